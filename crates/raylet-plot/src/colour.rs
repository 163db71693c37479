//! Colours for values: which colour means which number, and the ticks of the colour bar.

use std::f64::consts::PI;

use crate::axis::{Axis, Direction, Tick};

/// The colour of values that are not numbers: a grey-green in none of the maps' bright parts.
pub(crate) const MISSING: [u8; 3] = [120, 160, 160];

/// Steps of the ramp from which many values take their colours: more than colours of 8 bits along it.
const RAMP: usize = 4096;

/// Colours of low and high values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourMap {
    /// Black over purple and orange to pale yellow: irradiance and other amounts.
    #[default]
    Inferno,
    /// Dark blue over green to yellow: heights and other quantities.
    Viridis,
    /// Black to white: photographs.
    Grey,
    /// A closed ring of hues over −π to π: phases; other values are wrapped into that range.
    Phase,
    /// Blue over white to red, white at zero and as far to either side: differences.
    Difference,
}

impl ColourMap {
    /// The colour at a place from 0 to 1.
    fn rgb(self, t: f64) -> [u8; 3] {
        match self {
            ColourMap::Inferno => colorous::INFERNO.eval_continuous(t).into_array(),
            ColourMap::Viridis => colorous::VIRIDIS.eval_continuous(t).into_array(),
            ColourMap::Grey => [(255.0 * t).round() as u8; 3],
            ColourMap::Phase => phase_rgb(t),
            ColourMap::Difference => colorous::RED_BLUE.eval_continuous(1.0 - t).into_array(),
        }
    }
}

/// A ring of hues that is lightest at phase 0 and darkest at ±π, in B. Ottosson's OKLab (2020).
fn phase_rgb(t: f64) -> [u8; 3] {
    // Lightness follows the cosine, so the sign of a real field shows in grey as well.
    let angle = 2.0 * PI * (t - 0.5);
    let lightness = 0.66 + 0.17 * angle.cos();
    let chroma = 0.12 - 0.01 * angle.cos().abs();
    let hue = angle + 2.5;
    let (a, b) = (chroma * hue.cos(), chroma * hue.sin());

    // From OKLab over cone responses to linear sRGB.
    let cube = |x: f64| x * x * x;
    let l = cube(lightness + 0.3963377774 * a + 0.2158037573 * b);
    let m = cube(lightness - 0.1055613458 * a - 0.0638541728 * b);
    let s = cube(lightness - 0.0894841775 * a - 1.2914855480 * b);
    let linear = [
        4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
        -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
        -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s,
    ];

    // The display's transfer curve.
    linear.map(|v| {
        let v = v.clamp(0.0, 1.0);
        let encoded = match v <= 0.0031308 {
            true => 12.92 * v,
            false => 1.055 * v.powf(1.0 / 2.4) - 0.055,
        };
        (255.0 * encoded).round() as u8
    })
}

/// A colour map laid over a range of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ColourScale {
    pub(crate) map: ColourMap,
    /// The values of the first and the last colour.
    pub(crate) range: [f64; 2],
    /// Whether colours are in proportion to the logarithm.
    pub(crate) log: bool,
}

impl ColourScale {
    /// A linear scale fit to finite values from `lo` to `hi`.
    ///
    /// Phases span −π to π, differences as far to both sides of zero, grey and amounts that come
    /// near zero (within a fifth of their range) start or end there.
    pub(crate) fn fitted(map: ColourMap, lo: f64, hi: f64) -> Self {
        let near = 0.2 * (hi - lo);
        let range = match map {
            ColourMap::Phase => [-PI, PI],
            ColourMap::Difference => {
                let most = lo.abs().max(hi.abs());
                let most = if most > 0.0 { most } else { 1.0 };
                [-most, most]
            }
            _ if lo == hi && lo == 0.0 => [0.0, 1.0],
            _ if lo == hi => [lo.min(0.0), hi.max(0.0)],
            _ if lo > 0.0 && lo <= near => [0.0, hi],
            _ if hi < 0.0 && -hi <= near => [lo, 0.0],
            _ => [lo, hi],
        };
        let log = false;
        ColourScale { map, range, log }
    }

    /// The colours of values, three bytes each; values beyond the range take the colour of its end. Each value is
    /// divided by `divisor` first.
    pub(crate) fn colours<'a>(
        &self,
        values: impl Iterator<Item = &'a f64>,
        divisor: f64,
    ) -> Vec<u8> {
        let ramp = self.ramp(RAMP);
        let colour = |value: f64| {
            let step = |place: f64| (place * (RAMP - 1) as f64).round() as usize;
            let found = self
                .place(value / divisor)
                .and_then(|place| ramp.get(step(place)));
            *found.unwrap_or(&MISSING)
        };

        // Where few values fill a picture, neighbours are equal: only a value that differs is looked up.
        let mut last = (f64::NAN.to_bits(), MISSING);
        let mut bytes = Vec::with_capacity(3 * values.size_hint().0);
        for value in values {
            if value.to_bits() != last.0 {
                last = (value.to_bits(), colour(*value));
            }
            bytes.extend_from_slice(&last.1);
        }
        bytes
    }

    /// The place of a value in the map, from 0 to 1; nothing for what has no colour.
    fn place(&self, value: f64) -> Option<f64> {
        let [lo, hi] = self.range;
        let place = match (self.map, self.log) {
            _ if value.is_nan() => return None,
            (ColourMap::Phase, _) if value.is_infinite() => return None,
            (ColourMap::Phase, _) => ((value + PI) / (2.0 * PI)).rem_euclid(1.0),
            (_, _) if lo == hi => 0.5,
            (_, true) if value <= 0.0 => 0.0,
            (_, true) => (value.ln() - lo.ln()) / (hi.ln() - lo.ln()),
            (_, false) => (value - lo) / (hi - lo),
        };
        Some(place.clamp(0.0, 1.0))
    }

    /// The colours from the low to the high end of the scale.
    pub(crate) fn ramp(&self, steps: usize) -> Vec<[u8; 3]> {
        let last = steps.max(2) - 1;
        let place = |i: usize| i as f64 / last as f64;
        (0..steps).map(|i| self.map.rgb(place(i))).collect()
    }

    /// The axis beside the colour bar, from its bottom to its top pixel.
    pub(crate) fn axis(&self, pixels: [f64; 2]) -> Axis {
        let marks = [
            (-PI, "−π"),
            (-PI / 2.0, "−π/2"),
            (0.0, "0"),
            (PI / 2.0, "π/2"),
            (PI, "π"),
        ];
        let tick = |(value, label): (f64, &str)| Tick {
            value,
            label: label.to_owned(),
        };
        match (self.map, self.log) {
            (ColourMap::Phase, _) => Axis::linear(self.range, pixels, Direction::Up, 1.0)
                .with_ticks(marks.map(tick).into()),
            (_, true) => Axis::logarithmic(self.range, pixels, Direction::Up),
            (_, false) => Axis::linear(self.range, pixels, Direction::Up, 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use crate::colour::{ColourMap, ColourScale, MISSING, phase_rgb};

    impl ColourScale {
        /// The colour of one value.
        fn rgb(&self, value: f64) -> [u8; 3] {
            let colours = self.colours([value].iter(), 1.0);
            colours.try_into().unwrap()
        }
    }

    #[test]
    fn ends_and_middle_have_the_colours_of_the_map() {
        let grey = ColourScale::fitted(ColourMap::Grey, 0.0, 2.0);
        assert_eq!(
            [grey.rgb(0.0), grey.rgb(2.0), grey.rgb(1.0)],
            [[0; 3], [255; 3], [128; 3]]
        );
        assert_eq!([grey.rgb(-5.0), grey.rgb(5.0)], [[0; 3], [255; 3]]);
        assert_eq!(grey.rgb(f64::NAN), MISSING);
        // Inferno starts nearly black, differences are blue below and red above zero.
        let inferno = ColourScale::fitted(ColourMap::Inferno, 0.0, 1.0);
        assert!(inferno.rgb(0.0).iter().all(|c| *c < 8));
        let signed = ColourScale::fitted(ColourMap::Difference, -1.0, 3.0);
        let ([r, _, b], [s, _, c]) = (signed.rgb(-3.0), signed.rgb(3.0));
        assert!(b > r && s > c && signed.rgb(0.0).iter().all(|v| *v > 235));
    }

    #[test]
    fn phases_close_the_ring_without_a_step() {
        let scale = ColourScale::fitted(ColourMap::Phase, 0.0, 1.0);
        assert_eq!(scale.rgb(PI), scale.rgb(-PI));
        assert_eq!(scale.rgb(0.3), scale.rgb(0.3 + 2.0 * PI));
        // Neighbours on a ring of 512 differ by at most 5 of 255 levels in any channel.
        let ring: Vec<_> = (0..512).map(|i| phase_rgb(f64::from(i) / 512.0)).collect();
        for i in 0..512 {
            let (a, b) = (ring[i], ring[(i + 1) % 512]);
            assert!((0..3).all(|k| a[k].abs_diff(b[k]) <= 5), "{i} {a:?} {b:?}");
        }
        // Opposite phases are far apart.
        for i in 0..256 {
            let (a, b) = (ring[i], ring[i + 256]);
            let apart: u32 = (0..3).map(|k| u32::from(a[k].abs_diff(b[k]))).sum();
            assert!(apart > 100, "{i} {a:?} {b:?}");
        }
    }

    #[test]
    fn ranges_are_fit_to_what_is_shown() {
        let range = |map, lo, hi| ColourScale::fitted(map, lo, hi).range;
        assert_eq!(range(ColourMap::Inferno, 0.1, 1.0), [0.0, 1.0]);
        assert_eq!(range(ColourMap::Viridis, 100.0, 101.0), [100.0, 101.0]);
        assert_eq!(range(ColourMap::Difference, -0.5, 2.0), [-2.0, 2.0]);
        assert_eq!(range(ColourMap::Phase, 0.0, 1.0), [-PI, PI]);
    }

    #[test]
    fn logarithmic_scales_give_each_decade_the_same_share() {
        let scale = ColourScale {
            map: ColourMap::Grey,
            range: [1e-4, 1.0],
            log: true,
        };
        assert_eq!([scale.rgb(0.0), scale.rgb(1e-2)], [[0; 3], [128; 3]]);
        assert_eq!(scale.axis([100.0, 0.0]).ticks[0].label, "10⁻⁴");
    }
}
