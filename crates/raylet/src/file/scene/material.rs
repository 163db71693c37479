//! A medium, as a scene file names it.

use std::fmt;

use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Unexpected, Visitor};
use serde::{Deserialize, Serialize};

use crate::file::decode::number::index;

/// A medium: the name of a glass in the catalogue, or a constant index { index = 1.5 }.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Material {
    /// A name of the catalogue, such as "N-BK7", "fused silica" or "air".
    Named(String),
    /// A medium without dispersion.
    Index(ConstantIndex),
}

/// A medium of the same refractive index at every wavelength.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstantIndex {
    /// Refractive index.
    #[serde(deserialize_with = "index")]
    #[schemars(range(min = 1, max = 10))]
    pub index: f64,
}

impl<'de> Deserialize<'de> for Material {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Choice;
        impl<'de> Visitor<'de> for Choice {
            type Value = Material;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "the name of a glass or {{ index = … }}")
            }
            fn visit_str<E: Error>(self, name: &str) -> Result<Material, E> {
                if name.trim().is_empty() {
                    return Err(E::invalid_value(Unexpected::Str(name), &self));
                }
                Ok(Material::Named(name.to_owned()))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Material, A::Error> {
                ConstantIndex::deserialize(MapAccessDeserializer::new(map)).map(Material::Index)
            }
        }
        deserializer.deserialize_any(Choice)
    }
}
