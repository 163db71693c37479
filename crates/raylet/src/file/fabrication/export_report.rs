//! What an export reports: what was written, what was rounded, and what the file does not hold.

use std::collections::BTreeMap;
use std::fmt;

use crate::file::fabrication::cell_rows::Cells;
use crate::file::fabrication::export_choices::{Masks, Quantity};
use crate::file::fabrication::level_survey::Survey;
use crate::file::fabrication::levels::Levels;
use crate::file::fabrication::made_values::{MadeRange, MadeValues};
use crate::file::fabrication::masks::drawn_part::DrawnPart;
use crate::file::fabrication::masks::mask_file::Shapes;
use crate::file::fabrication::masks::mask_plan::MaskPlan;
use crate::file::fabrication::masks::outline::Outlines;
use crate::optics::pixels::active_area::{ActiveArea, Rest};

/// A short report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExportReport {
    /// What was written, each as a name and a value.
    pub lines: Vec<(String, String)>,
    /// What the file does not hold.
    pub lost: Vec<String>,
    /// The numbers of the report by their names, which say their units.
    pub numbers: BTreeMap<String, f64>,
}

impl ExportReport {
    /// Adds a line.
    pub(crate) fn line(&mut self, name: &str, value: impl Into<String>) {
        self.lines.push((name.to_owned(), value.into()));
    }

    /// Adds a number.
    pub(crate) fn number(&mut self, name: &str, value: f64) {
        self.numbers.insert(name.to_owned(), value);
    }
}

impl fmt::Display for ExportReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, value) in &self.lines {
            writeln!(f, "{name:<18}{value}")?;
        }
        if !self.lost.is_empty() {
            writeln!(f, "Not in the file:")?;
        }
        for sentence in &self.lost {
            writeln!(f, "  - {sentence}")?;
        }
        Ok(())
    }
}

/// A number with few digits.
pub(crate) fn short(value: f64) -> String {
    let text = match value.abs() {
        0.0 => return String::from("0"),
        size if (1e-4..1e7).contains(&size) => {
            let digits = (5 - size.log10().floor() as i32).max(0);
            format!("{value:.*}", digits as usize)
        }
        _ => return format!("{value:.3e}"),
    };
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// Reports the values of a file.
pub(crate) fn report_values(
    report: &mut ExportReport,
    cells: &Cells,
    made: &MadeValues,
    found: &MadeRange,
) {
    let [low, high] = found.range;
    let unit = made.quantity.unit();
    report.line(
        "Values",
        format!(
            "{} from {} to {}{unit}",
            made.quantity.with_unit(),
            short(low),
            short(high)
        ),
    );
    report.number("smallest", low);
    report.number("largest", high);
    if let Some(levels) = made.levels {
        let unit = cells.quantity.unit();
        report.line(
            "Levels",
            format!("{} of {}{unit} each", levels.count, short(levels.step)),
        );
        report.line("Rounding", format!("rms {}{unit}", short(found.rounding)));
        report.number("levels", f64::from(levels.count));
        report.number("rounding_rms", found.rounding);
    }
    if cells.quantity == Quantity::Phase && made.quantity == Quantity::Height {
        let depth = cells.relief.depth_um().unwrap_or(0.0);
        report.line(
            "Relief",
            format!(
                "a whole wave is {} µm deep; whole waves are left out",
                short(depth)
            ),
        );
        report.number("depth_um", depth);
    }
    if found.jumps {
        report.lost.push(String::from(
            "whole turns: neighbours differ by more than π, and what is interpolated between them is wrong there",
        ));
    }
}

/// Reports levels, rounding and the smallest feature.
pub(crate) fn report_levels(
    report: &mut ExportReport,
    cells: &Cells,
    levels: &Levels,
    survey: &Survey,
) {
    let used = survey.counts.iter().filter(|count| **count > 0).count();
    let unit = cells.quantity.unit();
    report.line(
        "Levels",
        format!(
            "{} of {}{unit} each, {used} of them used",
            levels.count,
            short(levels.step)
        ),
    );
    let [rms, largest] = survey.off;
    report.line(
        "Rounding",
        format!("rms {}{unit}, largest {}{unit}", short(rms), short(largest)),
    );
    report.number("levels", f64::from(levels.count));
    report.number("rounding_rms", rms);
    report.number("rounding_largest", largest);

    // Runs at the edge of the element have no end there.
    let [dx, dy] = cells.pitch_um;
    let widths = survey.feature.into_iter().zip([dx, dy]);
    let widths = widths.map(|(count, pitch)| count.map(|count| count as f64 * pitch));
    let names: Vec<String> = (["x", "y"].iter().zip(widths.clone()))
        .filter_map(|(axis, width)| width.map(|width| format!("{} µm along {axis}", short(width))))
        .collect();
    let text = match names.is_empty() {
        true => String::from("none between two others"),
        false => names.join(", "),
    };
    report.line("Smallest feature", text);
    if let Some(width) = widths.flatten().reduce(f64::min) {
        report.number("smallest_feature_um", width);
    }
}

/// Reports layers and shapes of a mask file.
pub(crate) fn report_masks(
    report: &mut ExportReport,
    cells: &Cells,
    levels: &Levels,
    plan: &MaskPlan,
    shapes: &Shapes,
) {
    let layers: Vec<String> = (shapes.rectangles.iter().take(8))
        .map(|(layer, count)| format!("{}/{}: {count}", layer.layer, layer.data_type))
        .collect();
    let more = if shapes.rectangles.len() > layers.len() {
        ", …"
    } else {
        ""
    };
    let count = shapes.count();
    report.line(
        "Rectangles",
        format!("{count} ({}{more})", layers.join(", ")),
    );
    report.number("rectangles", count as f64);
    report.number("layers", shapes.rectangles.len() as f64);
    let [columns, rows] = shapes.repeats;
    if shapes.repeats != [1, 1] {
        report.line("Repeated", format!("{columns} x {rows} times"));
    }
    report.number("repeats", columns as f64 * rows as f64);
    report.line(
        "Structure",
        format!("{}, database unit {} nm", shapes.name, plan.unit_nm),
    );

    // What the masks are for.
    let depth = match cells.quantity {
        Quantity::Height => Some(levels.step * f64::from(levels.count)),
        _ => cells.relief.depth_um(),
    };
    let step = depth.map(|depth| format!("{} nm", short(1e3 * depth / f64::from(levels.count))));
    let step = step.unwrap_or_else(|| String::from("one step"));
    report.line(
        "Meaning",
        match plan.masks {
            Masks::Each => format!(
                "layer {} + L − 1: level L, {step} a level",
                plan.first_layer
            ),
            Masks::Binary => format!(
                "layer {} + k − 1: etched by 1/2ᵏ of {} steps of {step}; the highest level stays",
                plan.first_layer, levels.count
            ),
            Masks::Dose => format!("layer {}, data type L: level L", plan.first_layer),
        },
    );
    let [x, y] = plan.corner;
    let [width, height] = plan.place(plan.size);
    if x * 2 + width != 0 || y * 2 + height != 0 {
        let lost = "half a database unit: the centre lies that far from the origin";
        report.lost.push(String::from(lost));
    }
}

/// Reports what else a mask file draws: gaps, the bias of an etch, the outline of the aperture.
pub(crate) fn report_drawing(
    report: &mut ExportReport,
    (plan, active): (&MaskPlan, ActiveArea),
    outlines: &Outlines,
) {
    let um = |units: i64| short(units as f64 * plan.unit_nm * 1e-3);
    let [dx, dy] = plan.pitch;
    match plan.part {
        DrawnPart::Whole => {}
        DrawnPart::Apart([x, y]) => report.line(
            "Cells drawn",
            format!(
                "{} x {} µm each, level 0 around",
                um(dx - 2 * x),
                um(dy - 2 * y)
            ),
        ),
        DrawnPart::Shrunk(margin) => report.line(
            "Etch bias",
            format!("{} µm: shapes are narrower by it at each edge", um(margin)),
        ),
        DrawnPart::Grown(margin) => report.line(
            "Etch bias",
            format!("-{} µm: shapes are wider by it at each edge", um(margin)),
        ),
    }
    if !active.is_whole() && plan.part == DrawnPart::Whole {
        report.lost.push(String::from(
            "the gaps between pixels, which are narrower than a database unit",
        ));
    } else if !active.is_whole() && active.rest == Rest::Dark {
        report.lost.push(String::from(
            "that the gaps between pixels are dark: they are on level 0",
        ));
    }
    let Some(layer) = plan.aperture_layer else {
        return;
    };
    let corners: usize = outlines.polygons.iter().map(|one| one.corners.len()).sum();
    report.line(
        "Outline",
        format!(
            "{} polygons of {corners} corners on layer {layer}, within {} nm of the aperture",
            outlines.polygons.len(),
            short((outlines.off + 0.5) * plan.unit_nm)
        ),
    );
    report.number("outlines", outlines.polygons.len() as f64);
    report.number("outline_error_nm", (outlines.off + 0.5) * plan.unit_nm);
}

#[cfg(test)]
mod tests {
    use crate::file::fabrication::export_report::{ExportReport, short};

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.3335, "0.3335"),
            (-1234.5678, "-1234.57"),
            (6_000_000.0, "6000000"),
            (1e-9, "1.000e-9"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn a_report_has_lines_and_losses() {
        let mut report = ExportReport::default();
        report.line("Cells", "4 x 5");
        report.lost.push(String::from("the amplitude"));
        let text = "Cells             4 x 5\nNot in the file:\n  - the amplitude\n";
        assert_eq!(report.to_string(), text);
    }
}
