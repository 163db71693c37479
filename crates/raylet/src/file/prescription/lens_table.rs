//! A table of surfaces (.csv) as a sequential prescription: a header row, then one row for each surface, lengths in mm.
//!
//! Columns: `radius` or `curvature`, `thickness`, `glass`, `semi_diameter`, `conic`, `a4`, `a6`, … `a20`, `stop`, `name`. Lines
//! that begin with `#` are remarks; those with a word and a colon state `wavelengths_um`, `fields_deg` and `object_mm`.

use std::collections::BTreeMap;

use crate::file::decode::fault::{Fault, shortened};
use crate::file::prescription::import_report::Losses;
use crate::file::prescription::lens_text::LensText;
use crate::file::prescription::sequential::{
    Action, ApertureRule, Behind, Curve, Face, FieldKind, GlassRequest, Sequential,
};

/// The columns that are read but for the coefficients, and most rows, columns and stated numbers.
const COLUMNS: [&str; 8] = [
    "radius",
    "curvature",
    "thickness",
    "glass",
    "semi_diameter",
    "conic",
    "stop",
    "name",
];
const MOST: usize = 5000;

/// The helium d line in µm.
const D_LINE: f64 = 0.587_561_8;

/// Reads the prescription of a table.
///
/// # Errors
/// The first fault of the text, with its line.
pub(crate) fn read_table(
    text: &LensText,
    _skip_unknown: bool,
    configuration: Option<usize>,
    losses: &mut Losses,
) -> Result<Sequential, Fault> {
    if let Some(number) = configuration.filter(|number| *number != 1) {
        let found = format!("a table, and configuration {number} requested");
        return Err(text.fault_of_file(found, "configuration 1, which a table has alone"));
    }
    let mut table = Table::default();
    for (line, row) in text.lines() {
        let row = row.trim();
        match row.strip_prefix('#') {
            Some(remark) => table.read_remark(text, remark)?,
            None if row.is_empty() => {}
            None if table.columns.is_empty() => table.read_header(text, row)?,
            None => table.read_row(text, line, row)?,
        }
    }
    table.sequential(text, losses)
}

/// What is read of a table.
#[derive(Debug, Default)]
struct Table {
    columns: Vec<String>,
    faces: Vec<Face>,
    stops: Vec<usize>,
    stated: BTreeMap<&'static str, Vec<f64>>,
}

impl Table {
    /// A remark, or numbers for the whole lens.
    fn read_remark(&mut self, text: &LensText, remark: &str) -> Result<(), Fault> {
        let Some((word, rest)) = remark.split_once(':') else {
            return Ok(());
        };
        let words = ["wavelengths_um", "fields_deg", "object_mm"];
        let Some(word) = words.into_iter().find(|known| *known == word.trim()) else {
            return Ok(());
        };
        let numbers = rest
            .split([',', ' '])
            .filter(|part| !part.is_empty())
            .take(MOST);
        let numbers: Result<Vec<f64>, Fault> =
            numbers.map(|part| text.number(part.trim())).collect();
        self.stated.insert(word, numbers?);
        Ok(())
    }

    fn read_header(&mut self, text: &LensText, row: &str) -> Result<(), Fault> {
        for cell in cells(row) {
            let column = cell.to_ascii_lowercase();
            let column = column.strip_suffix("_mm").unwrap_or(&column).to_owned();
            let known = COLUMNS.contains(&column.as_str()) || power(&column).is_some();
            if !known || self.columns.contains(&column) {
                let found = format!("the column {}", shortened(cell));
                let expected = format!("each of {}, a4, a6, … a20 once", COLUMNS.join(", "));
                return Err(text.fault(cell, found, expected));
            }
            self.columns.push(column);
        }
        let has = |name: &str| self.columns.iter().any(|column| column == name);
        match has("thickness") && (has("radius") || has("curvature")) {
            true => Ok(()),
            false => {
                let expected = "a header with thickness, and radius or curvature";
                Err(text.fault(row, shortened(row), expected))
            }
        }
    }

    fn read_row(&mut self, text: &LensText, line: usize, row: &str) -> Result<(), Fault> {
        let number = self.faces.len() + 1;
        let parts = cells(row);
        if parts.len() > self.columns.len() || number > MOST {
            let found = format!("{} cells in row {number}", parts.len());
            let expected = format!("at most {}, in at most {MOST} rows", self.columns.len());
            return Err(text.fault_of_line(line, found, expected));
        }
        let mut curve = Curve {
            aspheric: vec![0.0; 9],
            ..Curve::default()
        };
        let mut face = Face {
            action: Action::Border,
            clips: true,
            ..Face::turned([number, line], Default::default())
        };
        let mut stop = false;
        for (column, cell) in self.columns.iter().zip(parts) {
            match column.as_str() {
                "glass" => face.behind = behind(line, cell),
                "name" => {
                    face.comment = cell.chars().take(40).collect();
                    stop |= cell.to_ascii_lowercase().contains("stop");
                }
                "stop" => {
                    let no = ["", "0", "no", "false"];
                    stop |= !no.contains(&cell.to_ascii_lowercase().as_str());
                }
                "thickness" if !cell.is_empty() => face.thickness_mm = text.number(cell)?,
                "semi_diameter" if !cell.is_empty() => {
                    let size = text.number(cell)?;
                    face.semi_diameter = (size > 0.0).then_some((size, true));
                }
                column => read_shape(&mut curve, text, column, cell)?,
            }
        }
        while curve.aspheric.last() == Some(&0.0) {
            curve.aspheric.pop();
        }
        if stop {
            self.stops.push(number);
        }
        self.faces.push(Face { curve, ..face });
        Ok(())
    }

    fn sequential(self, text: &LensText, losses: &mut Losses) -> Result<Sequential, Fault> {
        let [stop] = self.stops[..] else {
            let found = format!("{} stops", self.stops.len());
            let expected = "one row with a mark in the column stop, or with stop in its name";
            return Err(text.fault_of_file(found, expected));
        };
        let stated = |word: &str| self.stated.get(word).filter(|numbers| !numbers.is_empty());
        let waves = stated("wavelengths_um").cloned().unwrap_or_else(|| {
            losses.change("The table states no wavelength (# wavelengths_um: …): it is the d line, 0.5875618 µm.");
            vec![D_LINE]
        });
        if let Some(wave) = waves.iter().find(|wave| !(0.01..=100.0).contains(*wave)) {
            let found = format!("a wavelength of {wave} µm");
            return Err(text.fault_of_file(found, "wavelengths from 0.01 to 100 µm"));
        }
        let distance =
            stated("object_mm").map_or(f64::INFINITY, |list| list.first().copied().unwrap_or(1.0));
        if distance <= 0.0 {
            let found = format!("an object {distance} mm before the first surface");
            return Err(text.fault_of_file(found, "a distance above zero"));
        }
        let plane = |number: usize| Face {
            action: Action::Border,
            ..Face::turned([number, 1], Default::default())
        };
        let object = Face {
            thickness_mm: distance,
            ..plane(0)
        };
        let image = plane(self.faces.len() + 1);
        Ok(Sequential {
            title: text.file_name(),
            surface: [vec![object], self.faces, vec![image]].concat(),
            stop,
            aperture: ApertureRule::StopSize,
            field_kind: FieldKind::Angle,
            field: match self.stated.get("fields_deg") {
                Some(list) if !list.is_empty() => list.iter().map(|y| [0.0, *y]).collect(),
                _ => vec![[0.0; 2]],
            },
            wavelength_um: waves,
            primary: 0,
            catalogues: Vec::new(),
            focused: None,
        })
    }
}

/// Reads a cell of a surface's shape; nothing in it, or another column, changes nothing.
fn read_shape(curve: &mut Curve, text: &LensText, column: &str, cell: &str) -> Result<(), Fault> {
    match column {
        _ if cell.is_empty() => {}
        "radius" if cell.to_ascii_lowercase().starts_with("inf") => {}
        "radius" => {
            let radius = text.number(cell)?;
            curve.curvature = if radius == 0.0 { 0.0 } else { 1.0 / radius };
        }
        "curvature" => curve.curvature = text.number(cell)?,
        "conic" => curve.conic = text.number(cell)?,
        other => {
            let place = power(other).and_then(|power| curve.aspheric.get_mut(power / 2 - 2));
            if let Some(place) = place {
                *place = text.number(cell)?;
            }
        }
    }
    Ok(())
}

/// The cells of a row, between commas or, where there are none, semicolons.
fn cells(row: &str) -> Vec<&str> {
    let between = if row.contains(',') { ',' } else { ';' };
    let cells = row.split(between).take(MOST);
    cells
        .map(|cell| cell.trim().trim_matches('"').trim())
        .collect()
}

/// The power of a column of coefficients: 4 for a4.
fn power(column: &str) -> Option<usize> {
    let power = column.strip_prefix('a')?.parse::<usize>().ok()?;
    (power.is_multiple_of(2) && (4..=20).contains(&power)).then_some(power)
}

/// What follows a surface.
fn behind(line: usize, cell: &str) -> Behind {
    match cell.to_ascii_lowercase().as_str() {
        "" | "air" => Behind::Air,
        "mirror" => Behind::Reflected,
        _ => Behind::Glass(GlassRequest {
            line,
            name: cell.to_owned(),
            maker: None,
            code: None,
            own: None,
        }),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::file::prescription::import::{ImportChoices, ImportedLens, import_bytes};

    const LENS: &str = "# a lens of one medium\n# wavelengths_um: 0.5, 0.6\n# fields_deg: 0 5\n\
                        name, radius_mm, thickness_mm, glass, semi_diameter, conic, a4\n\
                        stop, , 5, , 4,\nfront, 50, 3, N-BK7, 6, -0.5, 1e-6\nback, -50, 40, , 6\n";

    fn read(text: &str, name: &str) -> Result<ImportedLens, String> {
        let lens = import_bytes(text.as_bytes(), Path::new(name), &ImportChoices::default());
        lens.map_err(|fault| fault.to_string())
    }

    /// The same lens as a table and as a file of CODE V.
    #[test]
    fn a_table_is_the_lens_of_its_numbers() {
        let same = "RDM\nEPD 8\nWL 500 600\nREF 1\nYAN 0 5\nS 0 5\nSTO\nCIR 4\nS 50 3 NBK7_SCHOTT\nCIR 6\nASP; K -0.5; A 1e-6\n\
                    S -50 40\nCIR 6\nSI 0 0\n";
        let [ours, theirs] = [read(LENS, "a.csv"), read(same, "a.seq")].map(Result::unwrap);
        assert_eq!(
            ours.report.number("focal length (mm)"),
            theirs.report.number("focal length (mm)")
        );
        let shapes = |lens: &ImportedLens| {
            let text = lens.scene.to_toml().unwrap();
            let lines = text
                .lines()
                .filter(|line| !line.starts_with("name") && !line.starts_with("title"));
            lines.map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(shapes(&ours), shapes(&theirs));
    }

    #[test]
    fn faults_name_the_line() {
        for (from, to, start) in [
            ("glass", "colour", "a.csv:4:32: found the column colour"),
            ("-50, 40", "-50, x", "a.csv:7:12: found x"),
            ("stop, ,", "front, ,", "a.csv: found 0 stops"),
            ("0.5, 0.6", "500", "a.csv: found a wavelength of 500 µm"),
            (
                "N-BK7",
                "N-BK77",
                "a.csv:6:1: found the unknown glass N-BK77",
            ),
            (
                ", , 4,",
                ", , ,",
                "a.csv: found an aperture given by the stop",
            ),
            (
                "40, , 6",
                "40, , 6, 1, 2, 3",
                "a.csv:7:1: found 8 cells in row 3",
            ),
        ] {
            let message = read(&LENS.replacen(from, to, 1), "a.csv").unwrap_err();
            assert!(message.starts_with(start), "{message}");
        }
    }
}
