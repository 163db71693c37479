//! `raylet export SOURCE -o FILE`: an element as files that foundries and other programs take, or a scene as a lens file.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use raylet::file::fabrication::export::{ExportSource, export_element};
use raylet::file::fabrication::export_choices::{ExportChoices, Masks, Quantity, Top};
use raylet::file::prescription::export::lens_export::{
    LensExportChoices, export_lens_of, is_lens_file,
};

use crate::failure::Failure;
use crate::say::say;

/// Writes a diffractive element for a foundry or another program, or a scene as a lens file of OpticStudio or CODE V, and reports
/// what was changed and left out.
#[derive(Args)]
pub(crate) struct Export {
    /// A scene (.toml), an array of phases, heights, amplitudes or levels (.npy, .npz), or a mask file (.gds). For a lens file
    /// a scene, or another lens file.
    source: PathBuf,
    /// The file to be written; its end decides on the format: .gds, .oas, .dxf, .stl, .png, .csv, .dat, .txt (coefficients) or
    /// .npy for an element, .zmx or .seq for a lens file.
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    cells: CellOptions,
    #[command(flatten)]
    masks: MaskOptions,
    #[command(flatten)]
    relief: ReliefOptions,
    #[command(flatten)]
    other: OtherOptions,
    /// Leaves out of a lens file what it cannot hold, with a warning.
    #[arg(long)]
    skip_unknown: bool,
    /// Replaces a file that raylet did not write, or that was changed since.
    #[arg(long)]
    overwrite: bool,
}

/// What the cells are.
#[derive(Args)]
struct CellOptions {
    /// Name of the element of a scene; its only diffractive element by default.
    #[arg(long, value_name = "NAME")]
    element: Option<String>,
    /// Number of the element's layer, from 0; its only one by default.
    #[arg(long, value_name = "N")]
    layer: Option<usize>,
    /// Distance of neighbouring cells in µm, one number or X,Y: of an array, a mask file or an analytic phase.
    #[arg(long, value_name = "P", value_parser = pair)]
    pitch_um: Option<[f64; 2]>,
    /// What an array holds.
    #[arg(long, value_name = "WHAT", default_value = "phase")]
    quantity: QuantityName,
    /// Mirrors the pattern in x: as it looks from the side from which the light comes.
    #[arg(long)]
    mirror: bool,
    /// Takes all cells; by default those with their centre outside of the element's aperture are on level 0.
    #[arg(long)]
    whole_grid: bool,
}

/// Levels and masks.
#[derive(Args)]
struct MaskOptions {
    /// Number of levels; by default those of the scene's design or kinoform, or else those on which the values are.
    #[arg(long, value_name = "N")]
    levels: Option<u32>,
    /// A layer for each level, binary etch masks, or one layer with the level as the data type.
    #[arg(
        long,
        value_name = "HOW",
        default_value = "each",
        conflicts_with = "dose"
    )]
    masks: MasksName,
    /// The same as --masks dose.
    #[arg(long)]
    dose: bool,
    /// Number of the first layer of a mask file.
    #[arg(long, value_name = "N", default_value_t = 1)]
    gds_layer: u16,
    /// Draws the outline of the element's aperture on this layer, and on data type 1 what is blocked in it.
    #[arg(long, value_name = "N")]
    aperture_layer: Option<u16>,
    /// How far in µm an etch moves each edge of a drawn shape outwards; shapes are drawn that much narrower.
    #[arg(
        long,
        value_name = "B",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    etch_bias_um: f64,
    /// Share of the area of a cell that is drawn; by default that of the scene's pixels.
    #[arg(long, value_name = "F")]
    fill: Option<f64>,
    /// Database unit of a mask file in nm.
    #[arg(long, value_name = "U", default_value_t = 1.0)]
    database_unit_nm: f64,
    /// Number of cells X,Y of a mask file that is read; by default those from its first to its last shape.
    #[arg(long, value_name = "X,Y", value_parser = counts)]
    size: Option<[usize; 2]>,
}

/// The relief that makes a phase.
#[derive(Args)]
struct ReliefOptions {
    /// Index of the relief; phases become heights φ λ / (2π (n − n₀)).
    #[arg(long, value_name = "N")]
    index: Option<f64>,
    /// Index n₀ of the medium whose place it takes; 1 by default.
    #[arg(long, value_name = "N0", requires = "index")]
    ambient_index: Option<f64>,
    /// Wavelength in vacuum in µm; the first of a scene by default.
    #[arg(long, value_name = "L")]
    wavelength_um: Option<f64>,
    /// Depth of a whole wave in µm, in place of index and wavelength.
    #[arg(long, value_name = "D", conflicts_with = "index")]
    depth_um: Option<f64>,
    /// Writes heights in place of phases, where a format holds either.
    #[arg(long)]
    as_height: bool,
}

/// Options of single formats.
#[derive(Args)]
struct OtherOptions {
    /// Top of a relief (.stl): flat cells with steep walls, or a smooth surface.
    #[arg(long, value_name = "TOP", default_value = "stairs")]
    top: TopName,
    /// Thickness of the base of a relief in µm.
    #[arg(long, value_name = "B", default_value_t = 10.0)]
    base_um: f64,
    /// Width of the walls of a relief in µm; 1/64 of the pitch by default.
    #[arg(long, value_name = "W")]
    wall_um: Option<f64>,
    /// Writes a relief in µm instead of mm.
    #[arg(long)]
    micrometres: bool,
    /// Bits of a grey level of a picture: 8 or 16.
    #[arg(long, value_name = "B", default_value_t = 16)]
    bits: u8,
    /// Number of coefficients of a rotational phase.
    #[arg(long, value_name = "N", default_value_t = 8)]
    terms: usize,
    /// Largest root mean square in rad of what coefficients leave of a phase.
    #[arg(long, value_name = "R", default_value_t = 0.5)]
    residual_rad: f64,
}

/// [`Quantity`] on the command line.
#[derive(Clone, Copy, ValueEnum)]
enum QuantityName {
    /// Phases in rad.
    Phase,
    /// Heights in µm.
    Height,
    /// Amplitudes from 0 to 1.
    Amplitude,
    /// Numbers of levels.
    Level,
}

/// [`Masks`] on the command line.
#[derive(Clone, Copy, ValueEnum)]
enum MasksName {
    /// A layer for each level from 1.
    Each,
    /// log₂ N masks; mask k etches 1/2ᵏ of the full depth.
    Binary,
    /// One layer, with the level as the data type.
    Dose,
}

/// [`Top`] on the command line.
#[derive(Clone, Copy, ValueEnum)]
enum TopName {
    /// Flat cells with steep walls.
    Stairs,
    /// A smooth surface.
    Smooth,
}

impl Export {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        if is_lens_file(&self.out) {
            return self.lens();
        }
        if self.skip_unknown {
            return Err(Failure::new(
                "--skip-unknown is for lens files (.zmx, .seq)",
            ));
        }
        let report = export_element(ExportSource::File(&self.source), &self.out, &self.choices())?;
        say(&format!("{report}Written to {}\n", self.out.display()))
    }

    /// Writes a lens file.
    fn lens(&self) -> Result<(), Failure> {
        let own = ExportChoices {
            overwrite: self.overwrite,
            ..ExportChoices::default()
        };
        if self.choices() != own {
            let out = self.out.display();
            return Err(Failure::new(format!(
                "{out} is a lens file: found an option of elements, expected --skip-unknown and --overwrite alone"
            )));
        }
        let choices = LensExportChoices {
            skip_unknown: self.skip_unknown,
            overwrite: self.overwrite,
        };
        let report = export_lens_of(&self.source, &self.out, choices)?;
        say(&format!("{report}Written to {}\n", self.out.display()))
    }

    fn choices(&self) -> ExportChoices {
        let (cells, masks, relief, other) = (&self.cells, &self.masks, &self.relief, &self.other);
        ExportChoices {
            element: cells.element.clone(),
            layer: cells.layer,
            pitch_um: cells.pitch_um,
            quantity: match cells.quantity {
                QuantityName::Phase => Quantity::Phase,
                QuantityName::Height => Quantity::Height,
                QuantityName::Amplitude => Quantity::Amplitude,
                QuantityName::Level => Quantity::Level,
            },
            mirror: cells.mirror,
            whole_grid: cells.whole_grid,
            levels: masks.levels,
            masks: match masks.masks {
                _ if masks.dose => Masks::Dose,
                MasksName::Each => Masks::Each,
                MasksName::Binary => Masks::Binary,
                MasksName::Dose => Masks::Dose,
            },
            gds_layer: masks.gds_layer,
            aperture_layer: masks.aperture_layer,
            etch_bias_um: masks.etch_bias_um,
            fill: masks.fill,
            database_unit_nm: masks.database_unit_nm,
            size: masks.size,
            depth_um: relief.depth_um,
            wavelength_um: relief.wavelength_um,
            index: relief.index,
            ambient_index: relief.ambient_index,
            as_height: relief.as_height,
            top: match other.top {
                TopName::Stairs => Top::Stairs,
                TopName::Smooth => Top::Smooth,
            },
            base_um: other.base_um,
            wall_um: other.wall_um,
            micrometres: other.micrometres,
            bits: other.bits,
            terms: other.terms,
            residual_rad: other.residual_rad,
            overwrite: self.overwrite,
        }
    }
}

/// One number for both axes, or two.
fn pair(text: &str) -> Result<[f64; 2], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([both]) => Ok([*both; 2]),
        Ok([x, y]) => Ok([*x, *y]),
        _ => Err(String::from("expected a number, or two as X,Y")),
    }
}

/// Two whole numbers.
fn counts(text: &str) -> Result<[usize; 2], String> {
    let numbers: Result<Vec<usize>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([x, y]) => Ok([*x, *y]),
        _ => Err(String::from("expected two whole numbers, X,Y")),
    }
}
