//! Numbers of a scene file with the ranges they must keep, checked while they are read.
//!
//! The functions are named in `#[serde(deserialize_with = "…")]`, so a value out of range is refused at its
//! own address. When a number comes here it is finite already, except a radius, and keeps the magnitude of what its
//! key measures (`quantity.rs`); the ranges here are those that are tighter by meaning. What is divided by is at least
//! [`LEAST`], so that quotients stay finite too.

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Unexpected, Visitor};

/// The least magnitude, in the unit of the key, of a number that must not be zero.
pub(crate) const LEAST: f64 = 1e-12;

/// Something made of numbers, all of which must keep the same range.
pub(crate) trait Numbers {
    /// Every number in it.
    fn numbers(&self) -> Vec<f64>;
}

impl Numbers for f64 {
    fn numbers(&self) -> Vec<f64> {
        vec![*self]
    }
}

impl Numbers for usize {
    fn numbers(&self) -> Vec<f64> {
        vec![*self as f64]
    }
}

impl Numbers for u32 {
    fn numbers(&self) -> Vec<f64> {
        vec![f64::from(*self)]
    }
}

impl<T: Numbers> Numbers for Option<T> {
    fn numbers(&self) -> Vec<f64> {
        self.iter().flat_map(Numbers::numbers).collect()
    }
}

impl<T: Numbers, const N: usize> Numbers for [T; N] {
    fn numbers(&self) -> Vec<f64> {
        self.iter().flat_map(Numbers::numbers).collect()
    }
}

/// Reads numbers that must all be in a range, which the message describes in words.
fn within<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
    words: &str,
    keeps: impl Fn(f64) -> bool,
) -> Result<T, D::Error> {
    let value = T::deserialize(deserializer)?;
    match value.numbers().into_iter().find(|&number| !keeps(number)) {
        Some(number) => Err(D::Error::invalid_value(Unexpected::Float(number), &words)),
        None => Ok(value),
    }
}

/// Numbers above zero.
pub(crate) fn positive<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
) -> Result<T, D::Error> {
    within(deserializer, "a number above zero, at least 1e-12", |x| {
        x >= LEAST
    })
}

/// Numbers from zero up.
pub(crate) fn not_negative<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
) -> Result<T, D::Error> {
    within(deserializer, "zero or more", |x| x >= 0.0)
}

/// Counts from one to a thousand million: more than any run needs, and fewer than addresses.
pub(crate) fn count<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
) -> Result<T, D::Error> {
    within(deserializer, "a number above zero, up to 1000000000", |x| {
        (1.0..=1e9).contains(&x)
    })
}

/// Widths of patches and periods of gratings in micrometres: from a thousandth of an atom to a kilometre.
pub(crate) fn width<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
) -> Result<T, D::Error> {
    within(
        deserializer,
        "a number above zero, from 1e-6 to 1e9 micrometres",
        |x| (1e-6..=1e9).contains(&x),
    )
}

/// Wavelengths in vacuum in micrometres.
pub(crate) fn wavelength<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
) -> Result<T, D::Error> {
    within(deserializer, WAVELENGTH, is_wavelength)
}

/// What is expected of a wavelength. One in nanometres is the likely slip, and it falls out of this range.
const WAVELENGTH: &str = "a wavelength from 0.01 to 100 micrometres";

fn is_wavelength(value: f64) -> bool {
    (0.01..=100.0).contains(&value)
}

/// Factors from one up.
pub(crate) fn from_one<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
) -> Result<T, D::Error> {
    within(deserializer, "one or more, up to 1e6", |x| {
        (1.0..=1e6).contains(&x)
    })
}

/// Distances of windows in units of their width: farther apart they no longer cover what lies between.
pub(crate) fn step<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
) -> Result<T, D::Error> {
    within(
        deserializer,
        "a number above zero, from 0.01 up to 3",
        |x| (0.01..=3.0).contains(&x),
    )
}

/// Periods of windows in units of their width: a shorter one cuts the window itself.
pub(crate) fn period<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
) -> Result<T, D::Error> {
    within(deserializer, "from 2 to 100", |x| {
        (2.0..=100.0).contains(&x)
    })
}

/// Tolerances of Fourier sums.
pub(crate) fn tolerance<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
) -> Result<T, D::Error> {
    within(deserializer, "from 1e-13 to 0.1", |x| {
        (1e-13..=0.1).contains(&x)
    })
}

/// Numbers other than zero.
pub(crate) fn not_zero<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
) -> Result<T, D::Error> {
    within(
        deserializer,
        "a number other than zero, of magnitude at least 1e-12",
        |x| x.abs() >= LEAST,
    )
}

/// Refractive indices: from 1 to 10.
pub(crate) fn index<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
) -> Result<T, D::Error> {
    within(deserializer, "a refractive index from 1 to 10", |x| {
        (1.0..=10.0).contains(&x)
    })
}

/// Relative errors to aim at: rounding alone makes more than the least.
pub(crate) fn target<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
) -> Result<T, D::Error> {
    within(
        deserializer,
        "a number between 0 and 1, at least 1e-12",
        |x| (LEAST..1.0).contains(&x),
    )
}

/// Shares strictly between zero and one, whose squares are above zero too.
pub(crate) fn share<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
) -> Result<T, D::Error> {
    within(
        deserializer,
        "a number between 0 and 1, at least 1e-30",
        |x| (1e-30..1.0).contains(&x),
    )
}

/// Shares above zero, up to the whole.
pub(crate) fn whole_or_part<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
) -> Result<T, D::Error> {
    within(deserializer, "a number above 0, from 1e-12 up to 1", |x| {
        (LEAST..=1.0).contains(&x)
    })
}

/// Orders of tapers: beyond, the sides are as good as hard edges.
pub(crate) fn taper_order<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u32, D::Error> {
    within(deserializer, "a whole number from 1 to 50", |x| {
        (1.0..=50.0).contains(&x)
    })
}

/// Angles in degrees within a right angle to both sides.
pub(crate) fn acute<'de, D: Deserializer<'de>, T: Deserialize<'de> + Numbers>(
    deserializer: D,
) -> Result<T, D::Error> {
    within(deserializer, "degrees between -90 and 90", |x| {
        x.abs() < 90.0
    })
}

/// A list with at least one item.
pub(crate) fn not_empty<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<Vec<T>, D::Error> {
    let list = Vec::deserialize(deserializer)?;
    if list.is_empty() {
        return Err(D::Error::invalid_length(0, &"at least one"));
    }
    Ok(list)
}

/// A radius of curvature: infinite or finite, never zero or NaN.
pub(crate) fn radius<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    struct Radius;
    impl Visitor<'_> for Radius {
        type Value = f64;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(
                f,
                "a radius other than zero, of magnitude at least 1e-12, or inf for a plane"
            )
        }
        fn visit_f64<E: Error>(self, value: f64) -> Result<f64, E> {
            if value.is_nan() || value.abs() < LEAST {
                return Err(E::invalid_value(Unexpected::Float(value), &self));
            }
            Ok(value)
        }
        fn visit_i64<E: Error>(self, value: i64) -> Result<f64, E> {
            self.visit_f64(value as f64)
        }
    }
    deserializer.deserialize_any(Radius).map(Some)
}

/// A single value, or a list whose length is checked by the caller.
struct OneOrList;

/// What was given, and whether as a list.
type Given = (Vec<f64>, bool);

impl<'de> Visitor<'de> for OneOrList {
    type Value = Given;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a number or a list of numbers")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Given, E> {
        if !value.is_finite() {
            return Err(E::invalid_value(
                Unexpected::Float(value),
                &"a finite number",
            ));
        }
        Ok((vec![value], false))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Given, E> {
        Ok((vec![value as f64], false))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Given, A::Error> {
        let mut list = Vec::new();
        while let Some(value) = items.next_element()? {
            list.push(value);
        }
        Ok((list, true))
    }
}

/// A pitch or radius above zero along x and y, given as a pair or as one number for both.
pub(crate) fn pitch<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 2], D::Error> {
    // Up to a metre: samples further apart than any light reaches would be dark without a reported reason.
    let words = "a length above zero, from 1e-6 to 1e6 micrometres";
    one_or_pair(deserializer, words)
}

/// Two widths of a taper, given as a pair or as one number for both.
pub(crate) fn widths<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 2], D::Error> {
    one_or_pair(deserializer, "a number above zero, from 1e-6 to 1e6")
}

/// The same, where they may be missing.
pub(crate) fn some_widths<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<[f64; 2]>, D::Error> {
    widths(deserializer).map(Some)
}

/// A number or a pair from 1e-6 to 1e6, which the message describes in words.
fn one_or_pair<'de, D: Deserializer<'de>>(
    deserializer: D,
    words: &str,
) -> Result<[f64; 2], D::Error> {
    let (list, listed) = deserializer.deserialize_any(OneOrList)?;
    let pair = match *list.as_slice() {
        [both] if !listed => [both, both],
        [x, y] => [x, y],
        _ => {
            return Err(D::Error::invalid_length(
                list.len(),
                &"one number, or two for x and y",
            ));
        }
    };
    let fits = |one: f64| (1e-6..=1e6).contains(&one);
    match pair.into_iter().find(|&one| !fits(one)) {
        Some(one) => Err(D::Error::invalid_value(Unexpected::Float(one), &words)),
        None => Ok(pair),
    }
}

/// One or several wavelengths in µm.
pub(crate) fn wavelengths<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<f64>, D::Error> {
    let (list, _) = deserializer.deserialize_any(OneOrList)?;
    if list.is_empty() {
        return Err(D::Error::invalid_length(0, &"at least one wavelength"));
    }
    match list.iter().find(|&&value| !is_wavelength(value)) {
        Some(&value) => Err(D::Error::invalid_value(
            Unexpected::Float(value),
            &WAVELENGTH,
        )),
        None => Ok(list),
    }
}

/// The schema of a wavelength or a list of them.
pub(crate) fn one_or_list_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({
        "anyOf": [
            { "type": "number", "minimum": 0.01, "maximum": 100 },
            {
                "type": "array",
                "items": { "type": "number", "minimum": 0.01, "maximum": 100 },
                "minItems": 1
            }
        ]
    })
}

/// The schema of a pitch or a pair of them.
pub(crate) fn one_or_pair_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({
        "anyOf": [
            { "type": "number", "minimum": 1e-6, "maximum": 1e6 },
            {
                "type": "array",
                "items": { "type": "number", "minimum": 1e-6, "maximum": 1e6 },
                "minItems": 2,
                "maxItems": 2
            }
        ]
    })
}
