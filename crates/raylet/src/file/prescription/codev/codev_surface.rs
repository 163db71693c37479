//! The commands of one surface of a CODE V file.

use crate::file::decode::fault::{Fault, shortened};
use crate::file::prescription::codev::codev_commands::{Command, unquoted};
use crate::file::prescription::codev::codev_edge::Edges;
use crate::file::prescription::codev::codev_glass::PrivateGlasses;
use crate::file::prescription::codev::codev_phase::RawPhase;
use crate::file::prescription::codev::codev_shape::{RawShape, Refusal, curvature};
use crate::file::prescription::codev::codev_tilt::Tilt;
use crate::file::prescription::import_report::Losses;
use crate::file::prescription::lens_text::LensText;
use crate::file::prescription::sequential::{Action, Behind, Face, Turn};

/// Objects that are further away, in the unit of the file, are infinitely far.
const DISTANT: f64 = 1e9;

/// What a file has of one surface, lengths in its unit.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceData {
    /// The line where it begins.
    pub line: usize,
    /// The distance to the next one.
    pub thickness: f64,
    /// Its shape.
    pub shape: RawShape,
    /// The word of what follows it, and its line.
    pub medium: (String, usize),
    /// Values that solves give, by the line and the value's command.
    pub solved: Vec<(usize, String)>,
    reflects: bool,
    label: String,
    edges: Edges,
    tilt: Tilt,
    phase: RawPhase,
}

/// What the reading of a surface needs of the rest of the file.
pub(crate) struct Surroundings<'a> {
    /// The text.
    pub text: &'a LensText,
    /// Glasses of the file itself.
    pub glasses: &'a PrivateGlasses,
    /// Millimetres in its unit.
    pub unit: f64,
    /// The reference wavelength in µm.
    pub reference_um: f64,
    /// Whether what has no counterpart is left out.
    pub skip_unknown: bool,
}

impl SurfaceData {
    /// A surface that begins at a line.
    pub(crate) fn new(line: usize) -> Self {
        Self {
            line,
            thickness: 0.0,
            shape: RawShape::default(),
            medium: (String::new(), line),
            solved: Vec::new(),
            reflects: false,
            label: String::new(),
            edges: Edges::default(),
            tilt: Tilt::default(),
            phase: RawPhase::default(),
        }
    }

    /// Reads the numbers of a command S, SO, SI or S3: radius or curvature, thickness, medium, and how it acts.
    ///
    /// # Errors
    /// Values that are no numbers.
    pub(crate) fn read_row(
        &mut self,
        text: &LensText,
        command: &Command<'_>,
        [by_radii, object]: [bool; 2],
    ) -> Result<(), Fault> {
        let mut words = command.values.iter();
        if let Some(word) = words.next() {
            let value = text.number(word)?;
            self.shape.curvature = if by_radii { curvature(value) } else { value };
        }
        if let Some(word) = words.next() {
            self.thickness = distance(text, word, object)?;
        }
        if let Some(word) = words.next() {
            self.medium = ((*word).to_owned(), command.line);
        }
        match words
            .next()
            .map(|word| word.to_ascii_uppercase())
            .as_deref()
        {
            None | Some("REFR") => {}
            Some("REFL") => self.reflects = true,
            Some(other) => {
                let found = shortened(other);
                return Err(text.fault_of_line(command.line, found, "REFR, REFL or nothing"));
            }
        }
        Ok(())
    }

    /// Reads a command; false where it is none of a surface.
    ///
    /// # Errors
    /// A value that is missing, no number, or of no meaning here.
    pub(crate) fn read(
        &mut self,
        text: &LensText,
        command: &Command<'_>,
        object: bool,
    ) -> Result<bool, Fault> {
        let key = command.key.as_str();
        if matches!(key, "THI" | "CUY" | "RDY" | "CUX" | "RDX") && self.solve(command) {
            return Ok(true);
        }
        match key {
            "THI" => {
                let word = command.values.first().copied().unwrap_or(command.word);
                self.thickness = distance(text, word, object)?;
            }
            "CUY" => self.shape.curvature = command.number(text, 0)?,
            "RDY" => self.shape.curvature = curvature(command.number(text, 0)?),
            "GLA" => {
                // Names such as F2 look like qualifiers.
                let last = command.qualifiers.last().cloned();
                let word = command.values.first().map(|word| (*word).to_owned());
                self.medium = (word.or(last).unwrap_or_default(), command.line);
            }
            "RMD" => {
                let word = command.values.first().map(|word| word.to_ascii_uppercase());
                self.reflects = match word.as_deref() {
                    Some("REFL") => true,
                    Some("REFR") => false,
                    _ => {
                        let found = "another way to act than REFL and REFR";
                        return Err(text.fault(command.word, found, "REFL or REFR"));
                    }
                };
            }
            "SLB" => {
                let words = command.values.join(" ");
                self.label = unquoted(&words).chars().take(40).collect();
            }
            _ => {
                return Ok(self.shape.read(text, command)?
                    || self.edges.read(text, command)?
                    || self.tilt.read(text, command)?
                    || self.phase.read(text, command)?);
            }
        }
        Ok(true)
    }

    /// Notes a value that a solve gives; false where the command states it.
    fn solve(&mut self, command: &Command<'_>) -> bool {
        let first = command.values.first();
        let solve = first.is_some_and(|word| word.starts_with(|c: char| c.is_ascii_alphabetic()));
        if solve && self.solved.len() < 100 {
            self.solved.push((command.line, command.key.clone()));
        }
        solve
    }

    /// The surface in mm with the turns of the axis around it, as the faces of a prescription; its own is the one of the
    /// number returned.
    ///
    /// # Errors
    /// Numbers without a counterpart, with their lines.
    pub(crate) fn faces(
        &self,
        number: usize,
        around: &Surroundings<'_>,
        losses: &mut Losses,
    ) -> Result<(Vec<Face>, usize), Fault> {
        let (text, unit) = (around.text, around.unit);
        let behind = around.glasses.behind(text, self.medium.1, &self.medium.0)?;
        let [before, after] = self.tilt.turns(text, unit)?;
        let open = self.edges.open_part(unit);
        if open.several {
            losses.warn(format!(
                "Surface {number}: of several open apertures the first one is kept."
            ));
        }
        let face = Face {
            number,
            line: self.line,
            comment: self.label.clone(),
            action: Action::Border,
            thickness_mm: 0.0,
            curve: self.kept(number, self.shape.curve(unit), around, losses)?,
            phase: self.kept(
                number,
                self.phase.layers(unit, around.reference_um),
                around,
                losses,
            )?,
            grid: None,
            behind: if self.reflects {
                Behind::Reflected
            } else {
                behind
            },
            semi_diameter: open.semi_diameter_mm.map(|size| (size, true)),
            clips: true,
            outline: open.outline,
            blocked: open.blocked,
        };
        if self.phase.is_grating() && !face.phase.is_empty() {
            losses.change(format!(
                "Surface {number}: positive orders of its grating turn light towards the direction (GRX, GRY), as those of the same \
                 grating in OpticStudio."
            ));
        }
        let turned = |turn: Turn| Face::turned([number, self.line], turn);
        let mut list: Vec<Face> = before.map(turned).into_iter().collect();
        let own = list.len();
        list.push(face);
        list.extend(after.map(turned));
        if let Some(last) = list.last_mut() {
            last.thickness_mm = self.thickness * unit;
        }
        Ok((list, own))
    }

    /// What was read, or nothing in its place with a warning where that is wanted.
    fn kept<T: Default>(
        &self,
        number: usize,
        read: Result<T, Refusal>,
        around: &Surroundings<'_>,
        losses: &mut Losses,
    ) -> Result<T, Fault> {
        match read {
            Ok(read) => Ok(read),
            Err((found, _)) if around.skip_unknown => {
                losses.warn(format!(
                    "Surface {number} has a plane or nothing in place of what is not read: {found}. Light behind it goes another \
                     way."
                ));
                Ok(T::default())
            }
            Err((found, expected)) => {
                let found = format!("{found}, on surface {number}");
                let fault = around.text.fault_of_line(self.line, found, expected);
                Err(fault.hint(
                    "--skip-unknown leaves out what is not read (in Python, skip_unknown=True)",
                ))
            }
        }
    }
}

/// A distance of a file; that of the object may be infinite.
fn distance(text: &LensText, word: &str, object: bool) -> Result<f64, Fault> {
    let infinite = word.to_ascii_uppercase().starts_with("INF");
    let value = word.parse::<f64>().unwrap_or(0.0);
    match object && (infinite || value >= DISTANT) {
        true => Ok(f64::INFINITY),
        false => text.number(word),
    }
}
