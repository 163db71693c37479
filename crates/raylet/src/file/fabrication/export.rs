//! An element as files that a foundry takes: the source, the format, and the report.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::file::arrays::array::BorrowedArray;
use crate::file::decode::fault::Fault;
use crate::file::fabrication::array_cells::{array_cells, mask_cells};
use crate::file::fabrication::cell_rows::Cells;
use crate::file::fabrication::element_cells::{element_cells, is_analytic};
use crate::file::fabrication::export_choices::{ExportChoices, Quantity, choice_fault};
use crate::file::fabrication::export_report::{
    ExportReport, report_drawing, report_levels, report_masks, report_values, short,
};
use crate::file::fabrication::gds::gds_writer::GdsFile;
use crate::file::fabrication::height_image::GreyScale;
use crate::file::fabrication::level_survey::survey;
use crate::file::fabrication::levels::{plan_levels, spread};
use crate::file::fabrication::made_values::MadeValues;
use crate::file::fabrication::masks::dxf_writer::DxfFile;
use crate::file::fabrication::masks::mask_file::write_masks;
use crate::file::fabrication::masks::mask_plan::MaskPlan;
use crate::file::fabrication::masks::outline::Outlines;
use crate::file::fabrication::oasis::oasis_writer::OasisFile;
use crate::file::fabrication::radial_fit::fit_radial;
use crate::file::fabrication::stl::ReliefGrid;
use crate::file::fabrication::value_files::{FEWEST_POINTS, write_csv, write_dat, write_npy};
use crate::file::model::scene_arrays::Arrays;
use crate::file::scene::scene_file::Scene;
use crate::file::storage::hidden::unwritable;
use crate::file::storage::own_file::{OwnFile, Replace};
use crate::optics::pixels::active_area::ActiveArea;

/// Where the cells come from.
#[derive(Clone, Copy, Debug)]
pub enum ExportSource<'a, 'l> {
    /// A scene (.toml), an array (.npy, .npz) or a mask file (.gds).
    File(&'a Path),
    /// An array [y, x] in memory.
    Array(BorrowedArray<'a>),
    /// A scene in memory, with its arrays.
    Scene(&'a Scene, &'a Arrays<'l>),
}

/// The formats, by the ends of their names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Gds,
    Oasis,
    Dxf,
    Stl,
    Png,
    Csv,
    Dat,
    Npy,
    Coefficients,
}

/// Names of files that can be written.
const EXTENSIONS: &str = "a name ending in .gds, .oas, .dxf, .stl, .png, .csv, .dat, .npy or .txt";

impl Format {
    fn of(path: &Path) -> Result<Self, Fault> {
        let extension = path.extension().and_then(|end| end.to_str()).unwrap_or("");
        match extension.to_ascii_lowercase().as_str() {
            "gds" => Ok(Self::Gds),
            "oas" => Ok(Self::Oasis),
            "dxf" => Ok(Self::Dxf),
            "stl" => Ok(Self::Stl),
            "png" => Ok(Self::Png),
            "csv" => Ok(Self::Csv),
            "dat" => Ok(Self::Dat),
            "npy" => Ok(Self::Npy),
            "txt" => Ok(Self::Coefficients),
            _ => {
                let found = format!("the extension `{extension}`");
                Err(Fault::of_file(path, found, EXTENSIONS))
            }
        }
    }
}

/// Writes the element of a source to a file, whose name decides on the format.
///
/// # Errors
/// A source that cannot be read, choices that do not fit, or a file that may not be replaced or cannot be written.
pub fn export_element(
    source: ExportSource<'_, '_>,
    target: &Path,
    choices: &ExportChoices,
) -> Result<ExportReport, Fault> {
    let format = Format::of(target)?;
    choices.check(target)?;
    // A place that cannot be written is refused before the work begins.
    let file = OwnFile::claim(target, Replace::any_if(choices.overwrite))?;
    let export = Export {
        file: &file,
        format,
        choices,
    };
    match source {
        ExportSource::File(path) if has_extension(path, "toml") => {
            let scene = Scene::open(path)?;
            let scene = match is_analytic(&scene, choices)? {
                true => scene.load()?,
                false => scene,
            };
            export.write(element_cells(&scene, &scene.arrays, choices)?)
        }
        ExportSource::File(path) if has_extension(path, "gds") => {
            export.write(mask_cells(path, choices)?)
        }
        ExportSource::File(path) => export.write(array_cells(path, None, choices)?),
        ExportSource::Array(array) => {
            export.write(array_cells(Path::new("array"), Some(array), choices)?)
        }
        ExportSource::Scene(scene, arrays) => export.write(element_cells(scene, arrays, choices)?),
    }
}

/// Whether the name of a file ends so.
pub(crate) fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension()
        .is_some_and(|end| end.eq_ignore_ascii_case(extension))
}

/// One export: what is written where.
struct Export<'a> {
    file: &'a OwnFile,
    format: Format,
    choices: &'a ExportChoices,
}

impl Export<'_> {
    /// Writes the file.
    fn write(&self, mut cells: Cells) -> Result<ExportReport, Fault> {
        self.complete(&mut cells);
        let mut report = ExportReport::default();
        let [nx, ny] = cells.size();
        let [dx, dy] = cells.pitch_um;
        let [width, height] = [nx as f64 * dx * 1e-3, ny as f64 * dy * 1e-3];
        report.line(
            "Cells",
            format!("{nx} x {ny} of {} x {} µm", short(dx), short(dy)),
        );
        report.line("Size", format!("{} x {} mm", short(width), short(height)));
        report.number("cells", nx as f64 * ny as f64);
        self.report_aperture(&cells, &mut report)?;
        match self.format {
            Format::Gds | Format::Oasis | Format::Dxf => self.masks(&mut cells, &mut report)?,
            Format::Stl => self.relief(&mut cells, &mut report)?,
            Format::Png => self.picture(&mut cells, &mut report)?,
            Format::Csv => {
                let made = self.values(&mut cells, &mut report)?;
                self.stream(|out| write_csv(out, &mut cells, &made))?;
            }
            Format::Dat => self.grid(&mut cells, &mut report)?,
            Format::Coefficients => self.coefficients(&mut cells, &mut report)?,
            Format::Npy => {
                let made = self.values(&mut cells, &mut report)?;
                self.stream(|out| write_npy(out, &mut cells, &made))?;
            }
        }
        report.lost.append(&mut cells.losses);
        Ok(report)
    }

    /// Adds to the cells what the choices say of them.
    fn complete(&self, cells: &mut Cells) {
        let choices = self.choices;
        cells.mirror = choices.mirror;
        let relief = &mut cells.relief;
        relief.wavelength_um = choices.wavelength_um.or(relief.wavelength_um);
        relief.stated_depth_um = choices.depth_um;
        if let Some(index) = choices.index {
            relief.step = Some(index - choices.ambient_index.unwrap_or(1.0));
        }
    }

    /// Reports how many cells the aperture closes.
    fn report_aperture(&self, cells: &Cells, report: &mut ExportReport) -> Result<(), Fault> {
        let Some(open) = &cells.open else {
            return Ok(());
        };
        let [nx, ny] = cells.size();
        let closed = open.closed([nx, ny]);
        report.number("closed_cells", closed as f64);
        if closed == nx as u64 * ny as u64 {
            let found = "an aperture in which no cell has its centre";
            let expected = "cells in the aperture, or the whole grid (--whole-grid)";
            return Err(Fault::of_file(&cells.file, found, expected));
        }
        if closed > 0 {
            let made = match self.format {
                Format::Gds | Format::Oasis | Format::Dxf => "on level 0",
                Format::Coefficients => "left out",
                _ => "at 0",
            };
            report.line(
                "Aperture",
                format!("{closed} cells with their centre outside are {made}"),
            );
        }
        Ok(())
    }

    /// The outlines that a mask file draws.
    fn outlines(&self, cells: &Cells, plan: &MaskPlan) -> Result<Outlines, Fault> {
        if self.choices.aperture_layer.is_none() {
            return Ok(Outlines::default());
        }
        let refuse = |found: &str| {
            let expected = "the aperture of an element of a scene, over a flat grid of cells";
            Err(choice_fault(&cells.file, "aperture_layer", found, expected))
        };
        match &cells.aperture {
            Some(aperture) => Outlines::new(&cells.file, aperture, plan.unit_nm),
            None => refuse("cells without such an aperture"),
        }
    }

    /// Writes the file by a function of a buffered stream.
    fn stream<T>(
        &self,
        write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<T>,
    ) -> Result<T, Fault> {
        let mut made = None;
        self.file.fill(|file| {
            let mut out = BufWriter::with_capacity(1 << 20, file);
            made = Some(write(&mut out)?);
            out.flush()
        })?;
        let nothing = || Fault::of_file(self.file.path(), "nothing", "a file that is written");
        made.ok_or_else(nothing)
    }

    /// A mask file.
    fn masks(&self, cells: &mut Cells, report: &mut ExportReport) -> Result<(), Fault> {
        let found = spread(cells)?;
        let levels = plan_levels(cells, &found, self.choices)?;
        let active = match self.choices.fill {
            Some(fill) => ActiveArea::of_fill(fill, cells.active.rest).unwrap_or(cells.active),
            None => cells.active,
        };
        let plan = MaskPlan::new(
            self.file.path(),
            cells.size(),
            (cells.pitch_um, active),
            levels.count,
            self.choices,
        )?;
        let outlines = self.outlines(cells, &plan)?;
        let survey = survey(cells, &levels)?;
        report_levels(report, cells, &levels, &survey);
        let drawn = (survey.tile, &outlines);
        let shapes = self.stream(|out| match self.format {
            Format::Oasis => {
                let mut file = OasisFile::new(out, plan.unit_nm)?;
                write_masks(&mut file, cells, &levels, &plan, drawn)
            }
            Format::Dxf => {
                let mut file = DxfFile::new(out, &plan)?;
                write_masks(&mut file, cells, &levels, &plan, drawn)
            }
            _ => {
                let mut file = GdsFile::new(out, plan.unit_nm)?;
                write_masks(&mut file, cells, &levels, &plan, drawn)
            }
        })?;
        report_masks(report, cells, &levels, &plan, &shapes);
        report_drawing(report, (&plan, active), &outlines);
        Ok(())
    }

    /// The values of a file that holds any of them.
    fn values(&self, cells: &mut Cells, report: &mut ExportReport) -> Result<MadeValues, Fault> {
        let made = MadeValues::plan(cells, self.choices, self.choices.as_height)?;
        let found = made.range(cells)?;
        report_values(report, cells, &made, &found);
        Ok(made)
    }

    /// A closed surface.
    fn relief(&self, cells: &mut Cells, report: &mut ExportReport) -> Result<(), Fault> {
        let made = MadeValues::plan(cells, self.choices, true)?;
        let found = made.range(cells)?;
        report_values(report, cells, &made, &found);
        let grid = ReliefGrid::plan(self.file.path(), cells, found.range, self.choices)?;
        let triangles = self.stream(|out| grid.write(out, cells, &made))?;
        let unit = if self.choices.micrometres {
            "µm"
        } else {
            "mm"
        };
        report.line("Triangles", format!("{triangles}, lengths in {unit}"));
        report.number("triangles", triangles as f64);
        if grid.stairs {
            report.line(
                "Walls",
                format!("{} µm wide, half in each cell", short(grid.wall_um)),
            );
        } else {
            let lost = "the outer half of the cells at the edge: the surface ends at their centres";
            report.lost.push(String::from(lost));
        }
        Ok(())
    }

    /// A picture, and what its grey levels mean beside it.
    fn picture(&self, cells: &mut Cells, report: &mut ExportReport) -> Result<(), Fault> {
        let mut name = self.file.path().as_os_str().to_owned();
        name.push(".toml");
        let beside = OwnFile::claim(Path::new(&name), Replace::any_if(self.choices.overwrite))?;
        let made = MadeValues::plan(cells, self.choices, self.choices.as_height)?;
        let found = made.range(cells)?;
        report_values(report, cells, &made, &found);
        let scale = GreyScale::new(cells, &made, found.range, self.choices.bits);
        let text = scale
            .text()
            .map_err(|error| unwritable(beside.path(), &error))?;
        self.stream(|out| scale.write(out, cells, &made))?;
        beside.write(text.as_bytes())?;
        let unit = made.quantity.unit();
        report.line(
            "Grey levels",
            format!(
                "{} bits, {}{unit} each, black is {}{unit}",
                scale.bits,
                short(scale.per_grey),
                short(scale.offset)
            ),
        );
        report.line(
            "Grey rounding",
            format!("rms {}{unit}", short(scale.rounding())),
        );
        report.line("Scale", format!("in {}", beside.path().display()));
        report.number("per_grey", scale.per_grey);
        report.number("offset", scale.offset);
        Ok(())
    }

    /// The coefficients of a rotational phase.
    fn coefficients(&self, cells: &mut Cells, report: &mut ExportReport) -> Result<(), Fault> {
        let fit = fit_radial(cells, self.choices)?;
        self.file.write(fit.text(&cells.name).as_bytes())?;
        let first = fit.coefficients.first().copied().unwrap_or(0.0);
        report.line(
            "Coefficients",
            format!(
                "{} over a radius of {} mm, A1 = {} rad",
                fit.coefficients.len(),
                short(fit.radius_mm),
                short(first)
            ),
        );
        report.line(
            "Residual",
            format!("rms {} rad over {} cells", short(fit.residual), fit.count),
        );
        report.number("residual_rad", fit.residual);
        report.number("radius_mm", fit.radius_mm);
        for (i, a) in (1..).zip(&fit.coefficients) {
            report.number(&format!("A{i}"), *a);
        }
        report.lost.push(format!(
            "the phase beyond {} mm, and a constant of {} rad",
            short(fit.radius_mm),
            short(fit.constant)
        ));
        Ok(())
    }

    /// A grid file of Zemax OpticStudio.
    fn grid(&self, cells: &mut Cells, report: &mut ExportReport) -> Result<(), Fault> {
        let [nx, ny] = cells.size();
        if nx.min(ny) < FEWEST_POINTS {
            let found = format!("{nx} x {ny} cells");
            let expected = "at least 5 x 5: OpticStudio takes no fewer";
            return Err(Fault::of_file(self.file.path(), found, expected));
        }
        let made = self.values(cells, report)?;
        let surface = match made.quantity {
            Quantity::Height => "Grid Sag, in mm",
            Quantity::Phase => "Grid Phase, in rad",
            Quantity::Amplitude | Quantity::Level => {
                let found = format!("values of a {}", made.quantity.with_unit());
                return Err(Fault::of_file(&cells.file, found, "phases or heights"));
            }
        };
        self.stream(|out| write_dat(out, cells, &made))?;
        report.line("Surface", surface);
        report.lost.push(String::from(
            "derivatives: they are zero, and OpticStudio takes differences",
        ));
        Ok(())
    }
}
