//! Warnings about phases in other units than radians: degrees, or grey levels of a picture.

use ndarray::ArrayView2;

use crate::file::arrays::array::BorrowedArray;
use crate::file::model::scene_arrays::Arrays;
use crate::file::scene::element::Element;
use crate::file::scene::layer::Layer;
use crate::file::scene::scene_file::Scene;

/// Degrees reach at least this far, or else they would be few.
const DEGREES: f64 = 100.0;

/// Whole multiples of this are degrees rather than grey levels.
const EIGHTH: f64 = 45.0;

/// A picture of 8 bits has levels up to this.
const LEVELS: f64 = 255.0;

/// Rounded ends of a circle are this much beyond it at most.
const ROUNDED: f64 = 1e-3;

/// For each array of phases that is in degrees or grey levels, perhaps, where it stands (by the name of its element, or the path of
/// its field) and what there is to say.
pub fn phase_units(scene: &Scene, arrays: &Arrays) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for (i, element) in scene.element.iter().enumerate() {
        let Element::Doe(doe) = element else { continue };
        for (j, layer) in doe.layer.iter().enumerate() {
            let path = format!("element[{i}].layer[{j}].phase");
            if let (Layer::Pixels(pixels), Some(BorrowedArray::Real(phase))) =
                (layer, arrays.get(&path))
                && let Some(text) = other_unit(phase, pixels.phase_scale)
            {
                let place = match &doe.name {
                    Some(name) => format!("'{name}', layer[{j}].phase"),
                    None => path,
                };
                found.push((place, text));
            }
        }
    }
    found
}

/// What there is to say about one array. Phases in radians that run on without jumps of 2π may be as large, but then
/// neighbours differ by less than π.
fn other_unit(phase: ArrayView2<f64>, scale: f64) -> Option<String> {
    let (low, high) = phase
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(*value), high.max(*value))
        });
    let largest = high.max(-low);
    if scale != 1.0 || largest <= std::f64::consts::TAU || median_step(phase) < std::f64::consts::PI
    {
        return None;
    }
    let unit = |name: &str, scale: &str| {
        let [low, high] = [low, high].map(four_digits);
        format!(
            "values from {low} to {high}, between neighbours mostly more than π apart, look like {name}; phases are in \
             radians: phase_scale = {scale} would convert them"
        )
    };
    let eighths = phase.iter().all(|value| value % EIGHTH == 0.0);
    let whole = phase.iter().all(|value| value.fract() == 0.0);
    let circle = (low >= -ROUNDED && high <= 360.0 + ROUNDED)
        || (low >= -180.0 - ROUNDED && high <= 180.0 + ROUNDED);
    if whole && !eighths && low >= 0.0 && high <= LEVELS {
        return Some(unit("grey levels", "0.0245437 (2π/256)"));
    }
    (circle && (eighths || largest > DEGREES)).then(|| unit("degrees", "0.0174533 (π/180)"))
}

/// A number with four significant digits.
fn four_digits(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// The median of the distances of neighbours along x that differ: of two levels half of the neighbours are equal.
fn median_step(phase: ArrayView2<f64>) -> f64 {
    let mut steps: Vec<f64> = (phase.windows((1, 2)).into_iter())
        .map(|pair| pair.iter().fold(0.0, |step, value| value - step))
        .map(f64::abs)
        .filter(|step| *step > 0.0)
        .collect();
    if steps.is_empty() {
        return 0.0;
    }
    let middle = steps.len() / 2;
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use crate::file::model::phase_units::other_unit;

    /// Phases of a pseudo-random pattern, as shares of a circle.
    fn random() -> Array2<f64> {
        Array2::from_shape_fn((16, 16), |(j, i)| {
            (((16 * j + i) as f64) * 0.618_033_988_75).fract()
        })
    }

    #[test]
    fn degrees_and_grey_levels_are_told_from_radians() {
        let said = |phase: Array2<f64>| other_unit(phase.view(), 1.0).unwrap_or_default();
        assert!(said(random() * 360.0).contains("degrees"));
        assert!(said(random().mapv(|share| 360.0 * share - 180.0)).contains("degrees"));
        assert!(said(random().mapv(|share| (255.0 * share).round())).contains("grey levels"));
        let steps = |count: f64, step: f64| random().mapv(|share| (count * share).floor() * step);
        for (count, step) in [(2.0, 180.0), (4.0, 90.0), (8.0, 45.0), (2.0, 90.0)] {
            let text = said(steps(count, step));
            assert!(text.contains("look like degrees"), "{count}: {text}");
        }
        assert!(said(steps(2.0, 255.0)).contains("grey levels"));
        let broad =
            Array2::from_shape_fn((16, 16), |(_, i)| if i / 4 % 2 == 0 { 0.0 } else { 180.0 });
        assert!(said(broad).contains("look like degrees"));
        let text = said(random() * 123.456_789);
        assert!(text.contains(" to 123"), "{text}");
        let digits = |number: &str| number.chars().filter(char::is_ascii_digit).count();
        let number = text
            .split(" to ")
            .nth(1)
            .and_then(|rest| rest.split(',').next());
        assert!(number.is_some_and(|number| digits(number) <= 4), "{text}");
        assert_eq!(said(random() * std::f64::consts::TAU), "");
        // A lens whose phase runs on to 322 rad.
        let lens = Array2::from_shape_fn((128, 128), |(j, i)| {
            0.04 * ((i as f64 - 63.5).powi(2) + (j as f64 - 63.5).powi(2))
        });
        assert_eq!(said(lens), "");
        assert_eq!(other_unit((random() * 360.0).view(), 0.0174533), None);
    }
}
