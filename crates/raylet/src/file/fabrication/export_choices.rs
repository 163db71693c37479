//! What a user chooses for the files of a foundry.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::file::decode::fault::{Address, Fault};

/// What the numbers of an array are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Phases in rad: the field is multiplied by exp(+iφ).
    #[default]
    Phase,
    /// Heights of a relief in µm.
    Height,
    /// Amplitudes of the field, from 0 to 1.
    Amplitude,
    /// Numbers of levels: 0, 1, 2, …
    Level,
}

impl Quantity {
    /// Its name with its unit.
    pub(crate) fn with_unit(self) -> &'static str {
        match self {
            Self::Phase => "phase in rad",
            Self::Height => "height in µm",
            Self::Amplitude => "amplitude",
            Self::Level => "level",
        }
    }

    /// The unit alone, with a space before it.
    pub(crate) fn unit(self) -> &'static str {
        match self {
            Self::Phase => " rad",
            Self::Height => " µm",
            Self::Amplitude => "",
            Self::Level => " levels",
        }
    }
}

/// How levels become layers of a mask file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Masks {
    /// A layer for each level from 1; level 0 is empty.
    #[default]
    Each,
    /// log₂ N masks: where mask k is drawn, 1/2ᵏ of the full depth is etched. The highest level is not etched.
    Binary,
    /// One layer, with the level as the data type: the dose of a grey-scale writer. Level 0 is empty.
    Dose,
}

/// The top of a relief.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Top {
    /// Flat cells with steep walls between them.
    #[default]
    Stairs,
    /// A continuous surface with vertices at the centres of the cells.
    Smooth,
}

/// Choices for an export. What is absent has a default, or comes from the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExportChoices {
    /// Name of the element of a scene; its only diffractive element without it.
    pub element: Option<String>,
    /// Number of the element's layer, from 0; its only one without it.
    pub layer: Option<usize>,
    /// Distance of neighbouring cells along x and y, in µm.
    pub pitch_um: Option<[f64; 2]>,
    /// What an array holds.
    pub quantity: Quantity,
    /// Mirrors the pattern in x: as it looks from the side from which the light comes.
    pub mirror: bool,
    /// Takes the whole grid of cells, also those outside of the aperture of the element.
    pub whole_grid: bool,
    /// Number of levels; those that the scene states, or on which the values are, without it.
    pub levels: Option<u32>,
    /// How levels become layers.
    pub masks: Masks,
    /// Number of the first layer of a mask file.
    pub gds_layer: u16,
    /// Number of the layer on which the outline of the aperture is drawn, if it is.
    pub aperture_layer: Option<u16>,
    /// How far in µm an etch moves each edge of a drawn shape outwards; shapes are drawn that much narrower.
    pub etch_bias_um: f64,
    /// Share of the area of a cell that is drawn; that of the scene's pixels without it.
    pub fill: Option<f64>,
    /// Database unit of a mask file in nm.
    pub database_unit_nm: f64,
    /// Number of cells [nx, ny] of a mask file that is read.
    pub size: Option<[usize; 2]>,
    /// Depth of a whole wave in µm, at which heights begin again.
    pub depth_um: Option<f64>,
    /// Wavelength in vacuum in µm.
    pub wavelength_um: Option<f64>,
    /// Index of the relief at this wavelength.
    pub index: Option<f64>,
    /// Index of the medium whose place it takes.
    pub ambient_index: Option<f64>,
    /// Turns phases into heights, for formats that hold either.
    pub as_height: bool,
    /// The top of a relief.
    pub top: Top,
    /// Thickness of the base of a relief in µm.
    pub base_um: f64,
    /// Width of the walls of a relief in µm; 1/64 of the pitch without it.
    pub wall_um: Option<f64>,
    /// Whether lengths of a relief are written in µm instead of mm.
    pub micrometres: bool,
    /// Bits of a grey level: 8 or 16.
    pub bits: u8,
    /// Number of coefficients of a rotational phase.
    pub terms: usize,
    /// Largest root mean square in rad of what coefficients leave.
    pub residual_rad: f64,
    /// Replaces files that raylet did not write.
    pub overwrite: bool,
}

impl Default for ExportChoices {
    fn default() -> Self {
        Self {
            element: None,
            layer: None,
            pitch_um: None,
            quantity: Quantity::Phase,
            mirror: false,
            whole_grid: false,
            levels: None,
            masks: Masks::Each,
            gds_layer: 1,
            aperture_layer: None,
            etch_bias_um: 0.0,
            fill: None,
            database_unit_nm: 1.0,
            size: None,
            depth_um: None,
            wavelength_um: None,
            index: None,
            ambient_index: None,
            as_height: false,
            top: Top::Stairs,
            base_um: 10.0,
            wall_um: None,
            micrometres: false,
            bits: 16,
            terms: 8,
            residual_rad: 0.5,
            overwrite: false,
        }
    }
}

/// Most levels of a mask file.
pub const MOST_LEVELS: u32 = 32_767;

/// Most coefficients of a rotational phase.
pub const MOST_TERMS: usize = 20;

impl ExportChoices {
    /// Refuses numbers out of range.
    ///
    /// # Errors
    /// The first of them, at its name.
    pub(crate) fn check(&self, file: &Path) -> Result<(), Fault> {
        let refuse = |name: &str, found: String, expected: &str| {
            Err(choice_fault(file, name, found, expected))
        };
        let lengths = [
            ("database_unit_nm", Some(self.database_unit_nm)),
            ("depth_um", self.depth_um),
            ("wavelength_um", self.wavelength_um),
            ("index", self.index),
            ("ambient_index", self.ambient_index),
            ("base_um", Some(self.base_um)),
            ("wall_um", self.wall_um),
            ("residual_rad", Some(self.residual_rad)),
            ("pitch_um", self.pitch_um.map(|[x, _]| x)),
            ("pitch_um", self.pitch_um.map(|[_, y]| y)),
        ];
        for (name, value) in lengths {
            if let Some(value) = value.filter(|value| !(1e-6..=1e6).contains(value)) {
                return refuse(name, value.to_string(), "a number from 1e-6 to 1e6");
            }
        }
        if let Some(levels) = self.levels.filter(|n| !(2..=MOST_LEVELS).contains(n)) {
            return refuse("levels", levels.to_string(), "from 2 to 32767 levels");
        }
        if ![8, 16].contains(&self.bits) {
            return refuse("bits", self.bits.to_string(), "8 or 16");
        }
        if !(1..=MOST_TERMS).contains(&self.terms) {
            return refuse("terms", self.terms.to_string(), "from 1 to 20 coefficients");
        }
        if !(-1e3..=1e3).contains(&self.etch_bias_um) {
            let found = self.etch_bias_um.to_string();
            return refuse("etch_bias_um", found, "a number from -1000 to 1000");
        }
        if let Some(fill) = self.fill.filter(|fill| !(1e-6..=1.0).contains(fill)) {
            return refuse("fill", fill.to_string(), "a number from 1e-6 to 1");
        }
        if let Some([nx, ny]) = self.size.filter(|size| size.contains(&0)) {
            return refuse("size", format!("[{nx}, {ny}]"), "at least one cell");
        }
        Ok(())
    }
}

/// A choice without which something cannot be done.
///
/// # Errors
/// Its absence.
pub(crate) fn needed<T>(
    file: &Path,
    name: &str,
    value: Option<T>,
    purpose: &str,
) -> Result<T, Fault> {
    value.ok_or_else(|| choice_fault(file, name, "no value", format!("a value, for {purpose}")))
}

/// The fault of a choice for the export of a file.
pub(crate) fn choice_fault(
    file: &Path,
    name: &str,
    found: impl Into<String>,
    expected: impl Into<String>,
) -> Fault {
    let address = Address {
        file: file.to_path_buf(),
        path: name.to_owned(),
        excerpt: None,
    };
    Fault::at(address, found, expected)
}
