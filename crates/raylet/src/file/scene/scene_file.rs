//! The scene file: everything that a run needs, in one TOML text with array files beside it.

use std::collections::BTreeMap;
use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::file::arrays::array::BorrowedArray;
use crate::file::arrays::memory::{LEAST_LIMIT, MachineMemory};
use crate::file::decode::fault::Fault;
use crate::file::decode::from_tree::{decode, parse};
use crate::file::decode::number::{one_or_list_schema, wavelengths};
use crate::file::decode::origin::Origin;
use crate::file::decode::quantity::bound;
use crate::file::decode::tree::Node;
use crate::file::model::scene_arrays::Arrays;
use crate::file::scene::check::check_elements;
use crate::file::scene::design::Design;
use crate::file::scene::element::{Coordinates, Element, WITH_PIXELS};
use crate::file::scene::illumination::Illumination;
use crate::file::scene::layer::Layer;
use crate::file::scene::material::{Material, air};
use crate::file::scene::settings::{Hologram, Settings};

/// The version of the format that this program reads.
pub(crate) const VERSION: u32 = 1;

/// A scene of raylet: light, elements along an axis, a sensor, and how to compute it. Lengths are in
/// the units that the keys name; thicknesses lead from one element to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "raylet scene")]
pub struct Scene {
    /// Version of the format: 1.
    #[schemars(extend("const" = 1))]
    pub version: u32,
    /// Title in reports.
    #[serde(default)]
    pub title: String,
    /// Wavelength in vacuum in micrometres: one number or a list.
    #[serde(deserialize_with = "wavelengths")]
    #[schemars(schema_with = "one_or_list_schema")]
    pub wavelength_um: Vec<f64>,
    /// Medium outside the elements: a catalogue name or { index = … }.
    #[serde(default = "air")]
    pub ambient: Material,
    /// Seed of everything random.
    #[serde(default = "first_seed")]
    pub seed: u64,
    /// Where the light comes from.
    pub source: Illumination,
    /// The elements in the order light meets them; the last is the sensor.
    #[schemars(extend("minItems" = 1))]
    pub element: Vec<Element>,
    /// How the scene is computed.
    #[serde(default)]
    pub settings: Settings,
    /// A hologram to be computed for one of the elements.
    #[serde(default)]
    pub hologram: Option<Hologram>,
    /// A design by gradients through the real system.
    #[serde(default)]
    pub design: Option<Design>,
    /// The text the scene was read from.
    #[serde(skip)]
    pub origin: Origin,
    /// The arrays its layers name; empty until they are loaded.
    #[serde(skip)]
    pub arrays: Arrays<'static>,
}

/// The narrowest windows of beamlets, in wavelengths.
const NARROWEST: f64 = 0.25;

fn first_seed() -> u64 {
    1
}

impl Scene {
    /// Reads a scene file and every array it names.
    ///
    /// # Errors
    /// The first fault of the file, or of an array file, with its address.
    pub fn read(path: &Path) -> Result<Self, Fault> {
        Self::open(path)?.load()
    }

    /// Reads a scene file without its arrays, which may be still to come.
    ///
    /// # Errors
    /// The first fault of the file, with its address.
    pub fn open(path: &Path) -> Result<Self, Fault> {
        let origin = Origin::read(path)?;
        Self::from_tree(&parse(&origin)?, origin)
    }

    /// Reads the text of a scene without its arrays; faults name it as `path`, whose folder is that of its files.
    ///
    /// # Errors
    /// The first fault of the text, with its address.
    pub fn parse(text: &str, path: &Path) -> Result<Self, Fault> {
        let origin = Origin::new(text, path);
        Self::from_tree(&parse(&origin)?, origin)
    }

    /// Decodes a scene without its arrays. An error names its key, and its line in the text of `origin` if
    /// there is one.
    ///
    /// # Errors
    /// The first fault of the tree, with its address.
    pub fn from_tree(tree: &Node, origin: Origin) -> Result<Self, Fault> {
        let mut scene: Scene = decode(tree, &origin, i64::from(VERSION))?;
        scene.origin = origin;
        scene.check_source()?;
        check_elements(&scene.element, &scene.arrays, &scene.origin)?;
        scene.check_alone()?;
        scene.check_hologram()?;
        scene.check_memory()?;
        scene.check_width()?;
        Ok(scene)
    }

    /// A window much narrower than a wavelength has no directions: its spectrum is wider than all that propagate.
    fn check_width(&self) -> Result<(), Fault> {
        let longest = self.wavelength_um.iter().copied().fold(0.0, f64::max);
        let least = NARROWEST * longest;
        match self.settings.sigma_um.filter(|sigma| *sigma < least) {
            None => Ok(()),
            Some(sigma) => Err(self.fault(
                "settings.sigma_um",
                sigma.to_string(),
                format!("at least {least} µm: a quarter of the wavelength"),
            )),
        }
    }

    /// A point source must lie before the first element, and its taper has one width.
    fn check_source(&self) -> Result<(), Fault> {
        let refuse = |(key, found, expected): (&str, String, &str)| {
            Err(self.fault(&format!("source.{key}"), found, expected))
        };
        self.source.fault().map_or(Ok(()), refuse)
    }

    /// A sensor stands behind something: an element, or the plane on which the light is given.
    fn check_alone(&self) -> Result<(), Fault> {
        match self.element.len() == 1 && self.source.plane().is_none() {
            false => Ok(()),
            true => {
                let expected = "at least one element before it";
                Err(self.fault("element[0].kind", "nothing but a sensor", expected))
            }
        }
    }

    /// A hologram needs its element, with a pixel layer to write into.
    fn check_hologram(&self) -> Result<(), Fault> {
        let Some(hologram) = &self.hologram else {
            return Ok(());
        };
        let named = self.number_of(&hologram.element);
        let found = match named.and_then(|number| self.element.get(number)) {
            Some(Element::Doe(doe)) if doe.coordinates == Coordinates::Surface => {
                "an element with coordinates = \"surface\", for which holograms are not designed"
                    .to_owned()
            }
            Some(Element::Doe(doe)) => {
                if doe.layer.iter().any(|l| matches!(l, Layer::Pixels(_))) {
                    return Ok(());
                }
                "an element without a layer of kind \"pixels\"".to_owned()
            }
            Some(_) => "an element that is not of kind \"doe\"".to_owned(),
            None => return Err(self.nameless("hologram.element", &hologram.element)),
        };
        Err(self.fault("hologram.element", found, WITH_PIXELS))
    }

    /// The field on the sensor must fit in memory, twice: while it is computed and while its pictures are made, as much
    /// is held beside it.
    fn check_memory(&self) -> Result<(), Fault> {
        for (i, element) in self.element.iter().enumerate() {
            let Element::Sensor(sensor) = element else {
                continue;
            };
            let [nx, ny] = sensor.pixels.map(|count| count as f64);
            let megabytes = 2.0 * nx * ny * self.wavelength_um.len() as f64 * 16e-6;
            // The machine's memory takes longer to read than small scenes: each of them has so much.
            if self.settings.memory_limit_mb.is_none() && megabytes * 1e6 <= LEAST_LIMIT as f64 {
                continue;
            }
            let limit = self.memory_limit() as f64 * 1e-6;
            if megabytes > limit {
                return Err(self.fault(
                    &format!("element[{i}].pixels"),
                    format!("a field that takes {megabytes:.3} MB with its pictures"),
                    format!("at most {limit} MB (settings.memory_limit_mb)"),
                ));
            }
        }
        Ok(())
    }

    /// The most memory that arrays may take, in bytes: as given, or half of what is free now.
    pub fn memory_limit(&self) -> u64 {
        match self.settings.memory_limit_mb {
            Some(megabytes) => (megabytes * 1e6) as u64,
            None => MachineMemory::now().usual_limit(),
        }
    }

    /// The scene with copies of arrays in the memory of a caller in place of files: of layers, and of pictures (such
    /// as `hologram.target`; [y, x] with y upwards). What it does not hold is still to be loaded.
    ///
    /// # Errors
    /// An array with a value that is not finite, or without any.
    pub fn holding(mut self, lent: &BTreeMap<String, BorrowedArray<'_>>) -> Result<Self, Fault> {
        for (path, look) in lent {
            let key = path.rsplit('.').next().unwrap_or(path);
            look.check(key)
                .map_err(|(found, expected)| self.fault(path, found, expected))?;
        }
        self.arrays.hold(lent);
        Ok(self)
    }

    /// The `channel`-th wavelength in mm.
    ///
    /// # Errors
    /// A channel that the scene has not.
    pub(crate) fn wavelength_mm(&self, channel: usize) -> Result<f64, Fault> {
        let found = self.wavelength_um.get(channel).map(|um| um * 1e-3);
        found.ok_or_else(|| {
            let count = self.wavelength_um.len();
            let expected = format!("one with the number {channel}, counted from 0");
            self.fault("wavelength_um", format!("{count} wavelengths"), expected)
        })
    }

    /// A fault of the field at a dotted path such as `element[2].surface[0].glass`, for findings of
    /// later stages.
    pub fn fault(
        &self,
        path: &str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Fault {
        self.origin.fault(path, found, expected)
    }

    /// The scene as TOML text, with every default written out and without comments.
    ///
    /// # Errors
    /// A number that TOML cannot hold, such as a seed above 2⁶³.
    pub fn to_toml(&self) -> Result<String, Fault> {
        toml::to_string(self).map_err(|error| {
            Fault::of_file(&self.origin.file, error.to_string(), "values TOML can hold")
        })
    }
}

/// The JSON Schema (2020-12) of a scene file, with a description of every key.
pub fn schema() -> serde_json::Value {
    let mut schema = schemars::schema_for!(Scene).to_value();
    bound(&mut schema);
    schema
}
