//! Axes: places and labels of their ticks.
//!
//! Ticks are 1, 2 or 5 times a power of ten apart, as many as fit without their labels touching.

use crate::svg::text_width;

/// Letter size of tick labels in pixels.
pub(crate) const TICK_SIZE: f64 = 13.0;

/// Clear space between tick labels side by side, and above each other, in pixels.
const TICK_GAPS: [f64; 2] = [14.0, 17.0];

/// A marked value and what is written beside it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tick {
    pub(crate) value: f64,
    pub(crate) label: String,
}

/// Which way an axis runs, which decides how many labels fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Direction {
    /// Along the page: labels stand side by side.
    Across,
    /// Up the page: labels stand above each other.
    Up,
}

/// A unit of length to show millimetres in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LengthUnit {
    /// The unit's sign.
    pub(crate) sign: &'static str,
    /// How many of it make one millimetre.
    pub(crate) per_mm: f64,
}

impl LengthUnit {
    /// Millimetres.
    pub(crate) const MM: LengthUnit = LengthUnit {
        sign: "mm",
        per_mm: 1.0,
    };

    /// The unit in which a span in mm is a number with few digits.
    pub(crate) fn for_span(span_mm: f64) -> Self {
        let unit = |sign, per_mm| LengthUnit { sign, per_mm };
        // A hair below the border still counts as reaching it.
        match span_mm.abs() * (1.0 + 1e-9) {
            s if s >= 1e4 => unit("m", 1e-3),
            s if s >= 1.0 => LengthUnit::MM,
            s if s >= 1e-3 => unit("µm", 1e3),
            _ => unit("nm", 1e6),
        }
    }
}

/// A map from values to pixels with its ticks.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    range: [f64; 2],
    pixels: [f64; 2],
    log: bool,
    pub(crate) ticks: Vec<Tick>,
    /// Unlabelled marks of a logarithmic axis.
    pub(crate) minor: Vec<f64>,
    /// Labels are to be multiplied by ten to this power.
    exponent: i32,
}

impl Axis {
    /// An axis in proportion; labels show the value times `shown`.
    ///
    /// A range without extent is widened, one that runs backwards is kept.
    pub(crate) fn linear(
        range: [f64; 2],
        pixels: [f64; 2],
        direction: Direction,
        shown: f64,
    ) -> Self {
        let range = with_extent(range);
        let length = (pixels[1] - pixels[0]).abs();
        let mut axis = Axis {
            range,
            pixels,
            log: false,
            ticks: Vec::new(),
            minor: Vec::new(),
            exponent: 0,
        };

        // Take the most ticks whose labels stay apart.
        let ends = range.map(|v| v * shown);
        let (lo, hi) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        for most in (2..=9).rev() {
            let step = tick_step(hi - lo, most);
            let (exponent, labels) = label_values(&tick_values(lo, hi, step), step);
            axis.exponent = exponent;
            axis.ticks = labels;
            let room = length * step / (hi - lo);
            if axis.label_extent(direction) <= room {
                break;
            }
        }

        // On the shortest axes even two labels touch: then one has to do.
        let apart = |a: &Tick, b: &Tick| (b.value - a.value) / (hi - lo) * length;
        let least = axis.label_extent(direction) - TICK_GAPS[1] / 2.0;
        let mut pairs = axis.ticks.iter().zip(axis.ticks.iter().skip(1));
        if pairs.any(|(a, b)| apart(a, b) < least) {
            axis.ticks.truncate(1);
        }
        axis.ticks.iter_mut().for_each(|t| t.value /= shown);
        axis
    }

    /// An axis in proportion to the logarithm of positive values.
    pub(crate) fn logarithmic(range: [f64; 2], pixels: [f64; 2], direction: Direction) -> Self {
        let (lo, hi) = (range[0].min(range[1]), range[0].max(range[1]));

        // Less than two powers of ten in range: ticks in proportion say more.
        let (first, last) = (decade(lo).ceil() as i32, decade(hi).floor() as i32);
        if last - first < 1 {
            let plain = Axis::linear([lo, hi], pixels, direction, 1.0);
            return Axis { log: true, ..plain };
        }
        let mut axis = Axis {
            range: [lo, hi],
            pixels,
            log: true,
            ticks: Vec::new(),
            minor: Vec::new(),
            exponent: 0,
        };

        // Every power of ten, or every second, fifth, tenth ... where they would touch.
        let length = (pixels[1] - pixels[0]).abs();
        for stride in [1, 2, 5, 10, 20, 50, 100] {
            let powers = (first..=last).filter(|p| p.rem_euclid(stride) == 0);
            let tick = |p| Tick {
                value: 10f64.powi(p),
                label: power_of_ten(p),
            };
            axis.ticks = powers.map(tick).collect();
            let room = length * f64::from(stride) / (decade(hi) - decade(lo));
            if axis.label_extent(direction) <= room {
                break;
            }
        }
        if last - first <= 6 {
            let marks = (first - 1..=last).flat_map(|p| (2..10).map(move |m| (m, p)));
            let values = marks.map(|(m, p)| f64::from(m) * 10f64.powi(p));
            axis.minor = values.filter(|v| (lo..=hi).contains(v)).collect();
        }
        axis
    }

    /// The same axis with ticks of the caller's choice.
    pub(crate) fn with_ticks(self, ticks: Vec<Tick>) -> Self {
        Axis { ticks, ..self }
    }

    /// The pixel of a value; not finite where a logarithm does not exist.
    pub(crate) fn at(&self, value: f64) -> f64 {
        let [a, b] = self.range;
        let t = match self.log {
            true => (value.ln() - a.ln()) / (b.ln() - a.ln()),
            false => (value - a) / (b - a),
        };
        self.pixels[0] + t * (self.pixels[1] - self.pixels[0])
    }

    /// Width in pixels of the widest tick label.
    pub(crate) fn widest(&self) -> f64 {
        let widths = self.ticks.iter().map(|t| text_width(&t.label, TICK_SIZE));
        widths.fold(0.0, f64::max)
    }

    /// What a label and the space to the next one take along the axis.
    fn label_extent(&self, direction: Direction) -> f64 {
        match direction {
            Direction::Across => self.widest() + TICK_GAPS[0],
            Direction::Up => TICK_SIZE + TICK_GAPS[1],
        }
    }

    /// The axis label: name, then unit with the power of ten the tick labels leave out.
    pub(crate) fn label(&self, name: &str, unit: &str) -> String {
        let power = match self.exponent {
            0 => String::new(),
            e => format!("×10{}", superscript(e)),
        };
        match format!("{power} {unit}").trim() {
            "" => name.to_owned(),
            measure if name.is_empty() => measure.to_owned(),
            measure => format!("{name} ({measure})"),
        }
    }
}

/// A range that is finite and has an extent.
fn with_extent([a, b]: [f64; 2]) -> [f64; 2] {
    match (a.is_finite() && b.is_finite(), a == b) {
        (false, _) => [0.0, 1.0],
        (true, false) => [a, b],
        (true, true) if a == 0.0 => [-1.0, 1.0],
        (true, true) => [a - 0.5 * a.abs(), a + 0.5 * a.abs()],
    }
}

/// The base-10 logarithm with powers of ten themselves made exact.
fn decade(value: f64) -> f64 {
    let d = value.log10();
    if (d - d.round()).abs() < 1e-9 {
        d.round()
    } else {
        d
    }
}

/// The smallest step of 1, 2 or 5 times a power of ten that cuts `span` into at most `most` parts.
pub(crate) fn tick_step(span: f64, most: usize) -> f64 {
    let least = span / most.max(1) as f64;
    let power = 10f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|m| m * power);
    // Rounding must not push a span that divides evenly to the next step.
    let fits = |s: &&f64| **s >= least * (1.0 - 1e-9);
    steps.iter().find(fits).copied().unwrap_or(10.0 * power)
}

/// The multiples of `step` from `lo` to `hi`, ends included up to rounding.
pub(crate) fn tick_values(lo: f64, hi: f64, step: f64) -> Vec<f64> {
    let first = (lo / step - 1e-6).ceil();
    let last = (hi / step + 1e-6).floor();
    // More than a thousand ticks only come from steps below the resolution of the numbers.
    let count = (last - first + 1.0).clamp(0.0, 1000.0) as usize;
    (0..count).map(|i| (first + i as f64) * step).collect()
}

/// Ticks with labels, and the power of ten the labels leave out.
fn label_values(values: &[f64], step: f64) -> (i32, Vec<Tick>) {
    let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let outside = largest > 0.0 && !(1e-2..1e5).contains(&largest);
    let exponent = match outside {
        true => 3 * (decade(largest) / 3.0).floor() as i32,
        false => 0,
    };
    let factor = 10f64.powi(exponent);
    let decimals = (-decade(step / factor).floor()).clamp(0.0, 12.0) as usize;
    let tick = |&value: &f64| Tick {
        value,
        label: fixed(value / factor, decimals),
    };
    (exponent, values.iter().map(tick).collect())
}

/// A number with so many decimals, a true minus sign, and no negative zero.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|c| matches!(c, '0' | '.')) => digits.to_owned(),
        Some(digits) => format!("−{digits}"),
        None => text,
    }
}

/// A power of ten as it is read: 1, 10, then with raised digits.
pub(crate) fn power_of_ten(power: i32) -> String {
    match power {
        0 => "1".to_owned(),
        1 => "10".to_owned(),
        p => format!("10{}", superscript(p)),
    }
}

/// An integer in raised digits.
fn superscript(value: i32) -> String {
    let raised = |c| match c {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁴' as u32 + digit as u32 - '4' as u32).unwrap_or(digit),
    };
    value.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use crate::axis::{
        Axis, Direction, LengthUnit, TICK_GAPS, TICK_SIZE, fixed, power_of_ten, tick_step,
        tick_values,
    };
    use crate::svg::text_width;

    #[test]
    fn steps_are_one_two_or_five_times_a_power_of_ten() {
        for i in 0..2000 {
            let span = 1e-9 * 1.02f64.powi(i);
            let step = tick_step(span, 5);
            let mantissa = step / 10f64.powf(step.log10().floor() + 1e-12).round_ties();
            let near = [1.0, 2.0, 5.0, 10.0].map(|m| (mantissa / m - 1.0).abs());
            assert!(near.iter().any(|d| *d < 1e-9), "{span} {step}");
            // At most five parts, and the next finer step would give more.
            assert!(
                span / step <= 5.0 + 1e-6 && span / step > 1.9,
                "{span} {step}"
            );
        }
    }

    /// Stands in for rounding a power of ten that is inexact in binary.
    trait RoundTies {
        fn round_ties(self) -> f64;
    }

    impl RoundTies for f64 {
        fn round_ties(self) -> f64 {
            10f64.powf(self.log10().round())
        }
    }

    #[test]
    fn ticks_stay_in_range_and_reach_both_ends() {
        assert_eq!(tick_values(-1.0, 1.0, 0.5), [-1.0, -0.5, 0.0, 0.5, 1.0]);
        for i in 0..500 {
            let lo = -1.0 + 0.37 * f64::from(i);
            let hi = lo + 0.1 + 0.013 * f64::from(i);
            let step = tick_step(hi - lo, 6);
            let values = tick_values(lo, hi, step);
            assert!(values.len() >= 2 && values.len() <= 7);
            assert!(values[0] >= lo - 1e-5 * step && values[0] < lo + step);
            assert!(
                values
                    .last()
                    .is_some_and(|v| *v <= hi + 1e-5 * step && *v > hi - step)
            );
        }
    }

    #[test]
    fn labels_never_touch_and_always_differ() {
        for range in [
            [-3.0, 3.0],
            [0.0, 1e-7],
            [12345.0, 12346.0],
            [0.0, 8e6],
            [5.0, -5.0],
        ] {
            for width in [60.0, 120.0, 300.0, 900.0] {
                let axis = Axis::linear(range, [0.0, width], Direction::Across, 1.0);
                assert!(axis.ticks.len() >= 2 || width < 200.0, "{range:?} {width}");
                for pair in axis.ticks.windows(2) {
                    assert_ne!(pair[0].label, pair[1].label);
                    let half = |i: usize| text_width(&pair[i].label, TICK_SIZE) / 2.0;
                    let apart = (axis.at(pair[1].value) - axis.at(pair[0].value)).abs();
                    let clear = apart - half(0) - half(1);
                    assert!(clear > 0.0, "{range:?} {width}: {clear}");
                    // Where there are more than three they have the whole gap.
                    let wide = clear + 1e-9 >= TICK_GAPS[0];
                    assert!(wide || axis.ticks.len() <= 3, "{range:?} {width}");
                }
            }
        }
    }

    #[test]
    fn large_and_small_numbers_share_their_power_of_ten() {
        let axis = Axis::linear([0.0, 4e-6], [0.0, 300.0], Direction::Across, 1.0);
        assert_eq!(
            axis.label("irradiance", "W/mm²"),
            "irradiance (×10⁻⁶ W/mm²)"
        );
        assert_eq!(axis.ticks[1].label, "0.5");
        let plain = Axis::linear([-2.0, 2.0], [0.0, 100.0], Direction::Across, 1.0);
        assert_eq!(plain.label("x", "mm"), "x (mm)");
        assert_eq!(plain.ticks[0].label, "−2");
    }

    #[test]
    fn logarithms_mark_powers_of_ten() {
        let axis = Axis::logarithmic([1e-5, 1.0], [300.0, 0.0], Direction::Up);
        let labels: Vec<_> = axis.ticks.iter().map(|t| t.label.as_str()).collect();
        assert_eq!(labels, ["10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "1"]);
        assert!((axis.at(1e-2) - 120.0).abs() < 1e-9);
        assert_eq!(axis.minor.len(), 40);
        // A long axis skips some, a short range falls back to plain numbers.
        let long = Axis::logarithmic([1e-30, 1.0], [300.0, 0.0], Direction::Up);
        assert!(long.ticks.len() <= 12 && long.ticks.len() >= 3);
        let short = Axis::logarithmic([2.0, 6.0], [300.0, 0.0], Direction::Up);
        assert!(short.ticks.len() >= 4);
        assert!((short.at(12f64.sqrt()) - 150.0).abs() < 1e-9);
    }

    #[test]
    fn lengths_choose_a_unit_with_few_digits() {
        let sign = |span| LengthUnit::for_span(span).sign;
        assert_eq!(
            [sign(2e4), sign(6.0), sign(0.05), sign(5e-5)],
            ["m", "mm", "µm", "nm"]
        );
        let axis = Axis::linear([-0.05, 0.05], [0.0, 300.0], Direction::Across, 1e3);
        assert_eq!(axis.ticks[0].label, "−40");
        assert!((axis.ticks[0].value + 0.04).abs() < 1e-15);
    }

    #[test]
    fn numbers_read_well() {
        assert_eq!([fixed(-0.0001, 2), fixed(-1.5, 1)], ["0.00", "−1.5"]);
        assert_eq!([power_of_ten(0), power_of_ten(-12)], ["1", "10⁻¹²"]);
    }
}
