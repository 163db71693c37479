//! Several runs as a table of few digits, a line for each, that fits into 80 columns.

use std::fmt::Write;

use raylet::engine::error::run_warnings::{excess, misses};
use raylet::file::result::channel::Channel;
use raylet_plot::text_table::table;

/// Characters of the widest line of a table that is not split.
const WIDTH: usize = 80;

/// Behind an error above the target.
const MARK: &str = "*";

/// The part of a table in which a column stands where the table is split.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    /// What tells a run from the others: in both parts.
    Name,
    /// How the run went: in the first.
    Run,
    /// What is on the sensor: in the second.
    Light,
}

/// A column of the table.
struct Column {
    title: &'static str,
    unit: &'static str,
    part: Part,
    /// The entry of a run that aims at a target error; nothing where it has none.
    entry: fn(&Channel, f64) -> Option<String>,
}

const COLUMNS: [Column; 11] = [
    Column {
        title: "field",
        unit: "°",
        part: Part::Name,
        entry: |run, _| Some(listed(&run.place.angle_deg?)),
    },
    Column {
        title: "source",
        unit: "mm",
        part: Part::Name,
        entry: |run, _| Some(listed(&run.place.position_mm?)),
    },
    Column {
        title: "λ",
        unit: "µm",
        part: Part::Name,
        entry: |run, _| Some(run.wavelength_um.to_string()),
    },
    Column {
        title: "distance",
        unit: "mm",
        part: Part::Name,
        entry: |run, _| Some(run.place.distance_mm?.to_string()),
    },
    Column {
        title: "error",
        unit: "",
        part: Part::Run,
        entry: |run, target| {
            let mark = if misses(run.error?, target) { MARK } else { "" };
            Some(format!("{:.1e}{mark}", run.error?))
        },
    },
    Column {
        title: "light",
        unit: "%",
        part: Part::Run,
        entry: |run, _| Some(percent(run.light_share?)),
    },
    Column {
        title: "method",
        unit: "",
        part: Part::Run,
        entry: |run, _| Some(run.methods().join(", ")),
    },
    Column {
        title: "time",
        unit: "s",
        part: Part::Run,
        entry: |run, _| {
            let digits = if run.seconds < 100.0 { 2 } else { 0 };
            Some(format!("{:.digits$}", run.seconds))
        },
    },
    Column {
        title: "peak",
        unit: "",
        part: Part::Light,
        entry: |run, _| Some(format!("{:.2e}", run.metrics.peak)),
    },
    Column {
        title: "at x, y",
        unit: "mm",
        part: Part::Light,
        entry: |run, _| {
            let [x, y] = run.metrics.peak_mm?;
            Some(format!("{x:.4}, {y:.4}"))
        },
    },
    Column {
        title: "width x, y",
        unit: "µm",
        part: Part::Light,
        entry: |run, _| {
            let width = |um: Option<f64>| um.map_or(String::from("-"), |um| format!("{um:.2}"));
            let [x, y] = run.metrics.fwhm_um.map(width);
            Some(format!("{x}, {y}"))
        },
    },
];

/// Columns whose entry is said once where it is the same in all runs.
const SAID_ONCE: [&str; 5] = ["field", "source", "λ", "distance", "method"];

/// A column with its entries.
type Filled<'a> = (&'a Column, Vec<String>);

/// The table of two runs or more, under what is the same in all of them; in two parts where it is too wide for one.
pub(crate) fn run_lines(runs: &[Channel], target_error: f64) -> String {
    let filled = COLUMNS.iter().filter_map(|column| {
        let entries: Vec<_> = { runs.iter() }
            .map(|run| (column.entry)(run, target_error))
            .collect();
        let is_empty = column.part == Part::Name && entries.iter().all(Option::is_none);
        let entries = entries
            .into_iter()
            .map(|entry| entry.unwrap_or_else(|| String::from("-")));
        (!is_empty).then(|| (column, entries.collect::<Vec<_>>()))
    });
    let is_same = |(column, entries): &Filled| {
        SAID_ONCE.contains(&column.title)
            && entries.windows(2).all(|pair| pair.first() == pair.last())
    };
    let (same, varied): (Vec<Filled>, Vec<Filled>) = filled.partition(is_same);

    let mut text = String::new();
    if !same.is_empty() {
        let said = same.iter().map(|(column, entries)| {
            let entry = entries.first().map_or("", String::as_str);
            format!("{} {entry} {}", column.title, column.unit)
                .trim_end()
                .to_owned()
        });
        let _ = writeln!(text, "  all runs: {}", said.collect::<Vec<_>>().join("; "));
    }
    text += &within_width(&varied);
    if runs
        .iter()
        .any(|run| run.error.is_some_and(|error| misses(error, target_error)))
    {
        let _ = writeln!(text, "  {MARK} above the target error {target_error:.0e}");
    }
    text
}

/// One table if it is not too wide, else two.
fn within_width(columns: &[Filled]) -> String {
    let whole = table_of(columns, &|_| true);
    if whole.lines().all(|line| line.chars().count() <= WIDTH) {
        return whole;
    }
    table_of(columns, &|part| part != Part::Light) + &table_of(columns, &|part| part != Part::Run)
}

/// The table of the columns of some parts, with units under the titles.
fn table_of(columns: &[Filled], belongs: &dyn Fn(Part) -> bool) -> String {
    let chosen: Vec<&Filled> = columns
        .iter()
        .filter(|(column, _)| belongs(column.part))
        .collect();
    let head: Vec<&str> = chosen.iter().map(|(column, _)| column.title).collect();
    let mut rows = vec![
        chosen
            .iter()
            .map(|(column, _)| column.unit.to_owned())
            .collect(),
    ];
    let runs = chosen.first().map_or(0, |(_, entries)| entries.len());
    rows.extend((0..runs).map(|run| {
        let row = chosen
            .iter()
            .filter_map(|(_, entries)| entries.get(run).cloned());
        row.collect::<Vec<String>>()
    }));
    let numbers = chosen
        .iter()
        .enumerate()
        .filter(|(_, (column, _))| column.part != Part::Name && !column.unit.is_empty());
    table(
        &head,
        &rows,
        &numbers.map(|(place, _)| place).collect::<Vec<_>>(),
    )
}

/// Numbers with commas.
fn listed(numbers: &[f64]) -> String {
    let texts: Vec<String> = numbers.iter().map(f64::to_string).collect();
    texts.join(", ")
}

/// A share of the light in per cent. More than all of it is an error of the method, and no share.
fn percent(share: f64) -> String {
    match excess(share, 1.0) {
        Some(_) => String::from("> 100"),
        None => format!("{:.2}", 100.0 * share.min(1.0)),
    }
}

#[cfg(test)]
mod tests {
    use raylet::file::result::channel::{Channel, Place};
    use raylet::file::result::light_metrics::Metrics;
    use raylet::file::result::reference_step::StepEntry;

    use crate::run_lines::{WIDTH, run_lines};

    /// A run with entries as long as usual ones get.
    fn run(place: Place, wavelength_um: f64, method: &str) -> Channel {
        let step = StepEntry {
            from: String::from("doe"),
            to: String::from("sensor"),
            method: method.to_owned(),
            why: String::new(),
            neglects: String::new(),
            samples: [0; 2],
            power: [None; 3],
            work: 0.0,
            unresolved_pixels: 0,
            seconds: 0.0,
        };
        Channel {
            place,
            wavelength_um,
            hops: Vec::new(),
            steps: vec![step],
            error: Some(2.5e-3),
            target_reached: Some(false),
            light_share: Some(0.98765),
            metrics: Metrics {
                power: 1.0,
                peak: 123456.0,
                peak_mm: Some([-12.34567, -0.00012]),
                centroid_mm: None,
                fwhm_um: [Some(123.456), None],
                encircled_um: None,
            },
            seconds: 1234.567,
            warnings: Vec::new(),
        }
    }

    fn at(position_mm: [f64; 3], distance: f64) -> Place {
        Place {
            angle_deg: None,
            position_mm: Some(position_mm),
            distance_mm: Some(distance),
        }
    }

    #[test]
    fn a_wide_table_is_split_and_no_line_is_wider_than_a_page() {
        let runs = [
            run(at([-0.25, 12.5, -1000.0], 48.35), 0.6328, "local_bands"),
            run(at([-0.25, 12.5, -1000.0], 48.6), 1.064, "local_bands, free"),
        ];
        let text = run_lines(&runs, 1e-3);
        assert!(
            text.lines().all(|line| line.chars().count() <= WIDTH),
            "{text}"
        );
        assert_eq!(
            text,
            concat!(
                "  all runs: source -0.25, 12.5, -1000 mm\n",
                "  λ       distance  error    light  method             time\n",
                "  µm      mm                     %                        s\n",
                "  0.6328  48.35     2.5e-3*  98.77  local_bands        1235\n",
                "  1.064   48.6      2.5e-3*  98.77  local_bands, free  1235\n",
                "  λ       distance  peak              at x, y  width x, y\n",
                "  µm      mm                               mm          µm\n",
                "  0.6328  48.35     1.23e5  -12.3457, -0.0001   123.46, -\n",
                "  1.064   48.6      1.23e5  -12.3457, -0.0001   123.46, -\n",
                "  * above the target error 1e-3\n",
            )
        );
        // With places that vary, too.
        let far = run(at([-0.75, 12.5, -1000.0], 48.35), 0.55, "plane");
        let text = run_lines(&[runs[0].clone(), far], 1e-3);
        assert!(
            text.lines().all(|line| line.chars().count() <= WIDTH),
            "{text}"
        );
        assert!(text.contains("all runs: distance 48.35 mm\n"), "{text}");
    }

    #[test]
    fn a_usual_table_is_one() {
        let place = |x: f64| Place {
            angle_deg: Some([x, 0.0]),
            ..Place::default()
        };
        let runs = [0.0, 10.0].map(|x| run(place(x), 0.55, "local_bands"));
        let text = run_lines(&runs, 1e-2);
        assert_eq!(text.lines().count(), 5, "{text}");
        assert!(
            text.starts_with("  all runs: λ 0.55 µm; method local_bands\n"),
            "{text}"
        );
        assert!(
            text.lines().all(|line| line.chars().count() <= WIDTH),
            "{text}"
        );
    }
}
