//! A medium, as a scene file names it.

use std::fmt;

use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Unexpected, Visitor};
use serde::{Deserialize, Serialize};

use crate::file::decode::number::{index, positive};
use crate::optics::media::catalog;
use crate::optics::media::dispersion::{Dispersion, Formula};
use crate::optics::media::medium::Medium;

/// A medium: the name of a glass in the catalogue, or a table with a constant index, with a glass code, with the coefficients
/// of a formula, or with measured indices. Indices are relative to air.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Material {
    /// A name of the catalogue, such as "N-BK7", "fused silica" or "air".
    Named(String),
    /// A medium by its own numbers.
    Own(OwnMedium),
}

/// Air, by its name.
pub(crate) fn air() -> Material {
    Material::Named("air".to_owned())
}

/// A medium by its own numbers, in one of four ways: `index`; `nd` and `vd`; `sellmeier`; or `wavelengths_um` and `indices`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OwnMedium {
    /// Refractive index, the same at every wavelength.
    #[serde(
        default,
        deserialize_with = "index",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(range(min = 1, max = 10))]
    pub index: Option<f64>,
    /// Index at the d line, 0.5875618 µm. With `vd` the index is a + b/λ², from 0.4 to 0.8 µm: off by some 1e-4 to 1e-3 at the
    /// ends, as glasses of the same code differ.
    #[serde(
        default,
        deserialize_with = "index",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(range(min = 1, max = 10))]
    pub nd: Option<f64>,
    /// Abbe number (nd − 1)/(nF − nC).
    #[serde(
        default,
        deserialize_with = "positive",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(extend("minimum" = 1e-12))]
    pub vd: Option<f64>,
    /// Pairs [B, C] of n² = 1 + Σ B λ²/(λ² − C), λ in micrometres, C in µm².
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sellmeier: Option<Vec<[f64; 2]>>,
    /// Shortest and longest wavelength in micrometres for which `sellmeier` holds; from 0.3 to 2.5 without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range_um: Option<[f64; 2]>,
    /// Increasing wavelengths in micrometres, four or more, with the `indices` at them. Between them the index is
    /// the cubic in 1/λ through the nearest four.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wavelengths_um: Option<Vec<f64>>,
    /// The index at each of `wavelengths_um`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub indices: Option<Vec<f64>>,
}

/// The F, d and C lines in micrometres, and the range in which an index from a glass code is used.
const LINES: [f64; 3] = [0.486_132_7, 0.587_561_8, 0.656_272_5];
const CODE_RANGE: [f64; 2] = [0.4, 0.8];

/// The range of a formula without one of its own, in micrometres.
const FORMULA_RANGE: [f64; 2] = [0.3, 2.5];

/// What a name of a medium must be, in words.
pub(crate) const IN_CATALOGUE: &str = "a name of the glass catalogue";

/// The ways to state a medium, in words.
const WAYS: &str =
    "one of: index; nd and vd; sellmeier, with or without range_um; wavelengths_um and indices";

impl OwnMedium {
    /// The medium of these numbers.
    ///
    /// # Errors
    /// Keys that do not go together, or numbers that do not fit their form, as what was found and what was expected.
    pub(crate) fn medium(&self) -> Result<Medium, (String, String)> {
        let own = |dispersion| {
            Medium::new(self.to_string(), "the scene", dispersion)
                .map_err(|error| (error.to_string(), WAYS.to_owned()))
        };
        match self {
            Self {
                index: Some(index),
                nd: None,
                vd: None,
                sellmeier: None,
                range_um: None,
                wavelengths_um: None,
                indices: None,
            } => Ok(Medium::constant(*index)),
            Self {
                index: None,
                nd: Some(nd),
                vd: Some(vd),
                sellmeier: None,
                range_um: None,
                wavelengths_um: None,
                indices: None,
            } => own(of_code(*nd, *vd)),
            Self {
                index: None,
                nd: None,
                vd: None,
                sellmeier: Some(pairs),
                range_um,
                wavelengths_um: None,
                indices: None,
            } => own(Dispersion::Formula {
                formula: Formula::SellmeierSquared,
                coefficients: std::iter::once(0.0)
                    .chain(pairs.iter().flatten().copied())
                    .collect(),
                range_um: range_um.unwrap_or(FORMULA_RANGE),
            }),
            Self {
                index: None,
                nd: None,
                vd: None,
                sellmeier: None,
                range_um: None,
                wavelengths_um: Some(waves),
                indices: Some(indices),
            } => own(Dispersion::Table {
                wavelengths_um: waves.clone(),
                indices: indices.clone(),
            }),
            _ => Err((format!("a medium with {}", self.keys()), WAYS.to_owned())),
        }
    }

    /// The keys that it has.
    fn keys(&self) -> String {
        let all = [
            ("index", self.index.is_some()),
            ("nd", self.nd.is_some()),
            ("vd", self.vd.is_some()),
            ("sellmeier", self.sellmeier.is_some()),
            ("range_um", self.range_um.is_some()),
            ("wavelengths_um", self.wavelengths_um.is_some()),
            ("indices", self.indices.is_some()),
        ];
        let given: Vec<&str> = all.iter().filter(|key| key.1).map(|key| key.0).collect();
        if given.is_empty() {
            "no keys".to_owned()
        } else {
            given.join(", ")
        }
    }
}

/// n = a + b/λ² with the index at the d line and the Abbe number of a glass code.
fn of_code(nd: f64, vd: f64) -> Dispersion {
    let [f, d, c] = LINES.map(|line| line.powi(-2));
    let b = (nd - 1.0) / (vd * (f - c));
    Dispersion::Formula {
        formula: Formula::Cauchy,
        coefficients: vec![nd - b * d, b, -2.0],
        range_um: CODE_RANGE,
    }
}

impl fmt::Display for OwnMedium {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self {
                index: Some(index), ..
            } => write!(f, "n = {index}"),
            Self {
                nd: Some(nd),
                vd: Some(vd),
                ..
            } => write!(f, "nd = {nd}, vd = {vd}"),
            Self {
                sellmeier: Some(_), ..
            } => write!(f, "Sellmeier formula"),
            _ => write!(f, "table of indices"),
        }
    }
}

/// The error of a medium that is none, at the place where it is read.
fn refused<E: Error>(found: &str, expected: &str) -> E {
    E::invalid_value(Unexpected::Other(found), &expected)
}

impl<'de> Deserialize<'de> for Material {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Choice;
        impl<'de> Visitor<'de> for Choice {
            type Value = Material;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(
                    f,
                    "the name of a glass or {{ index = … }}, {{ nd = …, vd = … }}"
                )
            }
            fn visit_str<E: Error>(self, name: &str) -> Result<Material, E> {
                if name.trim().is_empty() {
                    return Err(E::invalid_value(Unexpected::Str(name), &self));
                }
                match catalog::medium(name) {
                    Ok(_) => Ok(Material::Named(name.to_owned())),
                    Err(error) => Err(refused(&error.to_string(), IN_CATALOGUE)),
                }
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Material, A::Error> {
                let own = OwnMedium::deserialize(MapAccessDeserializer::new(map))?;
                match own.medium() {
                    Ok(_) => Ok(Material::Own(own)),
                    Err((found, expected)) => Err(refused(&found, &expected)),
                }
            }
        }
        deserializer.deserialize_any(Choice)
    }
}

#[cfg(test)]
mod tests {
    use crate::file::scene::material::OwnMedium;
    use crate::optics::media::catalog;

    fn index(own: &OwnMedium, um: f64) -> f64 {
        own.medium().unwrap().index(um * 1e-3).unwrap()
    }

    /// N-BK7 by its glass code, by SCHOTT's coefficients, and by a table of its own indices.
    #[test]
    fn a_glass_by_its_own_numbers_is_that_of_the_catalogue() {
        let glass = catalog::medium("N-BK7").unwrap();
        let exact = |um: f64| glass.index(um * 1e-3).unwrap();
        let code = OwnMedium {
            nd: Some(1.5168),
            vd: Some(64.17),
            ..OwnMedium::default()
        };
        let formula = OwnMedium {
            sellmeier: Some(vec![
                [1.039_612_12, 0.006_000_698_67],
                [0.231_792_344, 0.020_017_914_4],
                [1.010_469_45, 103.560_653],
            ]),
            ..OwnMedium::default()
        };
        let waves = vec![0.4, 0.45, 0.5, 0.55, 0.6, 0.7];
        let table = OwnMedium {
            indices: Some(waves.iter().copied().map(exact).collect()),
            wavelengths_um: Some(waves),
            ..OwnMedium::default()
        };
        for um in [0.4861327, 0.5875618, 0.6562725] {
            assert!((index(&code, um) - exact(um)).abs() < 1e-4);
            assert!((index(&formula, um) - exact(um)).abs() < 1e-9);
            assert!((index(&table, um) - exact(um)).abs() < 1e-5);
        }
        assert!((index(&code, 0.4047) - exact(0.4047)).abs() < 1e-3);
        assert!(code.medium().unwrap().index(1.0e-3).is_err());
    }

    #[test]
    fn keys_that_do_not_go_together_are_refused() {
        let both = OwnMedium {
            nd: Some(1.5),
            index: Some(1.5),
            ..OwnMedium::default()
        };
        let (found, _) = both.medium().unwrap_err();
        assert_eq!(found, "a medium with index, nd");
        let (found, _) = OwnMedium::default().medium().unwrap_err();
        assert_eq!(found, "a medium with no keys");
        let short = OwnMedium {
            wavelengths_um: Some(vec![0.5, 0.6]),
            indices: Some(vec![1.5, 1.4]),
            ..OwnMedium::default()
        };
        assert!(short.medium().unwrap_err().0.contains("four or more"));
    }
}
