//! A CODE V file (.seq) as a sequential prescription.

use std::ops::RangeInclusive;

use crate::file::decode::fault::{Fault, shortened};
use crate::file::prescription::codev::codev_commands::{Command, each_command};
use crate::file::prescription::codev::codev_glass::PrivateGlasses;
use crate::file::prescription::codev::codev_header::Header;
use crate::file::prescription::codev::codev_relations::{PickUp, at_position};
use crate::file::prescription::codev::codev_surface::{SurfaceData, Surroundings};
use crate::file::prescription::import_report::Losses;
use crate::file::prescription::lens_text::LensText;
use crate::file::prescription::sequential::{Action, ApertureRule, Face, FieldKind, Sequential};

/// Most surfaces, pick-ups and positions of a zoom of a file.
const MOST_SURFACES: usize = 5000;
const MOST_PICK_UPS: usize = 5000;
const MOST_POSITIONS: usize = 1000;

/// Commands that change nothing of the light: names, weights, limits of variables and their couplings, derivatives, colours of
/// plots, substrates of mirrors, settings of analyses.
const WITHOUT_EFFECT: [&str; 71] = [
    "LEN", "INI", "WTF", "WTW", "WTX", "WTY", "CWL", "CCY", "CCX", "THC", "GLC", "KC", "KXC",
    "KYC", "AC", "BC", "CC", "DC", "EC", "FC", "GC", "HC", "JC", "HCC", "SCC", "XDC", "YDC", "ZDC",
    "ADC", "BDC", "CDC", "CUC", "DER", "CLS", "CUM", "THM", "RDM", "LAB", "NOT", "COM", "IC", "CA",
    "POL", "WID", "DLF", "DLT", "DLR", "DLN", "DLA", "DLB", "DLS", "DLX", "DLY", "DLZ", "TOL",
    "CMP", "PFR", "MFL", "VIE", "LIS", "SAV", "DRA", "OUT", "GRC", "GSC", "CFL", "SPC", "PLC",
    "IDN", "MNT", "DUM",
];

/// Reads the prescription of a text at a position of its zoom, the first one by default. What is not known is left out if
/// `skip_unknown`.
///
/// # Errors
/// The first fault of the text, with its line.
pub(crate) fn read_codev(
    text: &LensText,
    skip_unknown: bool,
    configuration: Option<usize>,
    losses: &mut Losses,
) -> Result<Sequential, Fault> {
    let mut reading = Reading {
        text,
        skip_unknown,
        position: configuration.unwrap_or(1),
        positions: 1,
        header: Header::default(),
        glasses: PrivateGlasses::default(),
        // A new lens has an object and an image.
        surfaces: vec![SurfaceData::new(1), SurfaceData::new(1)],
        current: 0,
        stop: 1,
        pick_ups: Vec::new(),
        focused: None,
        losses,
    };
    if let Some(object) = reading.surfaces.first_mut() {
        object.thickness = f64::INFINITY;
    }
    each_command(text, |command| reading.read(command))?;
    reading.relate()?;
    reading.sequential()
}

/// A file as it is read.
struct Reading<'a> {
    text: &'a LensText,
    skip_unknown: bool,
    position: usize,
    positions: usize,
    header: Header,
    glasses: PrivateGlasses,
    surfaces: Vec<SurfaceData>,
    current: usize,
    stop: usize,
    pick_ups: Vec<PickUp>,
    /// The surface before the paraxial image, and the line that says so.
    focused: Option<(usize, usize)>,
    losses: &'a mut Losses,
}

impl Reading<'_> {
    /// Reads a command; false at the end of the lens.
    fn read(&mut self, command: &Command<'_>) -> Result<bool, Fault> {
        if self.glasses.reading {
            self.glasses.read(self.text, command)?;
            return Ok(true);
        }
        if let Some(position) = command.qualifier('Z').filter(|at| *at != "A")
            && position != self.position.to_string()
        {
            return Ok(true);
        }
        match command.key.as_str() {
            "GO" => return Ok(false),
            "PRV" => self.glasses.reading = true,
            "ZOO" => self.read_zoom(command)?,
            "PIK" => self.read_pick_up(command)?,
            "PIM" => {
                let last = self.surfaces.len().saturating_sub(2);
                let span = self.span(command)?;
                self.focused = Some((span.map_or(last, |span| *span.end()), command.line));
            }
            "STO" => {
                let span = self.span(command)?;
                self.stop = span.map_or(self.current, |span| *span.start());
            }
            key if is_surface(key) => self.read_row(command)?,
            "TEM" | "PRE" => self.losses.leave_out(
                "Temperature and pressure: indices are those of the catalogue, lengths those of the file.",
            ),
            _ => return self.read_value(command),
        }
        Ok(true)
    }

    /// A command of the header or of surfaces, or one that is not used.
    fn read_value(&mut self, command: &Command<'_>) -> Result<bool, Fault> {
        if self.header.read(self.text, command, self.losses)? {
            return Ok(true);
        }
        let span = self.span(command)?.unwrap_or(self.current..=self.current);
        let mut known = false;
        for at in span {
            if let Some(surface) = self.surfaces.get_mut(at) {
                known = surface.read(self.text, command, at == 0)?;
            }
            if !known {
                break;
            }
        }
        let key = command.key.as_str();
        if known || WITHOUT_EFFECT.contains(&key) {
            return Ok(true);
        }
        if self.skip_unknown {
            let word = shortened(command.word);
            self.losses.warn(format!(
                "The command {word} is left out, which raylet does not know: the file may mean another lens."
            ));
            return Ok(true);
        }
        let found = format!("the unknown command {}", shortened(command.word));
        let fault = self
            .text
            .fault(command.word, found, "a command of a lens that raylet knows");
        Err(fault.hint("--skip-unknown leaves it out (in Python, skip_unknown=True)"))
    }

    /// S adds a surface before the image; SO, SI and S3 set the numbers of one that is there.
    fn read_row(&mut self, command: &Command<'_>) -> Result<(), Fault> {
        let image = self.surfaces.len().saturating_sub(1);
        self.current = match command.key.as_str() {
            "S" => {
                if image >= MOST_SURFACES {
                    let found = format!("more than {MOST_SURFACES} surfaces");
                    return Err(self.text.fault(command.word, found, "fewer"));
                }
                self.surfaces.insert(image, SurfaceData::new(command.line));
                image
            }
            key => self.place(command, key.get(1..).unwrap_or_default())?,
        };
        let numbers = [self.header.by_radii, self.current == 0];
        match self.surfaces.get_mut(self.current) {
            Some(surface) => {
                surface.line = command.line;
                surface.read_row(self.text, command, numbers)
            }
            None => Ok(()),
        }
    }

    fn read_zoom(&mut self, command: &Command<'_>) -> Result<(), Fault> {
        let first = command.values.first().copied().unwrap_or(command.word);
        if let Ok(count) = first.parse::<usize>() {
            if !(1..=MOST_POSITIONS).contains(&count) {
                let expected = format!("from 1 to {MOST_POSITIONS} positions of a zoom");
                return Err(self.text.fault(first, shortened(first), expected));
            }
            self.positions = count;
            return self.check_position();
        }
        let inner = at_position(self.text, command, self.position, self.positions)?;
        if inner.key == "ZOO" {
            return Err(self
                .text
                .fault(first, "ZOO within ZOO", "the command of a value"));
        }
        self.read(&inner).map(|_| ())
    }

    /// The position that is wanted is one of the zoom.
    fn check_position(&self) -> Result<(), Fault> {
        let (count, wanted) = (self.positions, self.position);
        match (1..=count).contains(&wanted) {
            true => Ok(()),
            false => {
                let found = format!("{count} configurations, and configuration {wanted} requested");
                let expected = format!("a configuration from 1 to {count}");
                Err(self.text.fault_of_file(found, expected))
            }
        }
    }

    fn read_pick_up(&mut self, command: &Command<'_>) -> Result<(), Fault> {
        if self.pick_ups.len() >= MOST_PICK_UPS {
            let found = format!("more than {MOST_PICK_UPS} pick-ups");
            return Err(self.text.fault(command.word, found, "fewer"));
        }
        self.pick_ups.push(PickUp::read(self.text, command)?);
        Ok(())
    }

    /// The surfaces that a command names; none where it names none.
    fn span(&self, command: &Command<'_>) -> Result<Option<RangeInclusive<usize>>, Fault> {
        let Some(name) = command.qualifier('S') else {
            return Ok(None);
        };
        let image = self.surfaces.len().saturating_sub(1);
        if name == "A" {
            return Ok(Some(0..=image));
        }
        let (from, to) = name.split_once("..").unwrap_or((name, name));
        let to = to.strip_prefix('S').unwrap_or(to);
        let (from, to) = (self.place(command, from)?, self.place(command, to)?);
        Ok(Some(from..=to))
    }

    /// The number of a surface that is named by what follows the S.
    fn place(&self, command: &Command<'_>, name: &str) -> Result<usize, Fault> {
        let image = self.surfaces.len().saturating_sub(1);
        let found = match name {
            "O" => Some(0),
            "I" => Some(image),
            "S" => Some(self.stop),
            number => number.parse::<usize>().ok(),
        };
        found.filter(|at| *at <= image).ok_or_else(|| {
            let found = format!("surface S{}", shortened(name));
            let expected = format!("a surface from S0 to S{image}");
            self.text.fault(command.word, found, expected)
        })
    }

    /// Gives surfaces the values that depend on others.
    fn relate(&mut self) -> Result<(), Fault> {
        self.check_position()?;
        for pick_up in std::mem::take(&mut self.pick_ups) {
            let command = Command::default();
            let names = pick_up.surfaces().map(|name| {
                let place = self.place(&command, name.get(1..).unwrap_or_default());
                place.map_err(|_| {
                    let found = format!("surface {}", shortened(name));
                    self.text
                        .fault_of_line(pick_up.line, found, "a surface of the lens")
                })
            });
            let [from, to] = names;
            let from = self.surfaces.get(from?);
            let value = from.and_then(|from| pick_up.value(from, self.position));
            let to = self.surfaces.get_mut(to?);
            let given = to
                .zip(value)
                .is_some_and(|(to, value)| pick_up.give(to, value));
            if !given {
                self.losses.solves += 1;
            }
        }
        self.check_solves()
    }

    /// A value that a solve gives is that which the file stores, unless that is zero.
    fn check_solves(&mut self) -> Result<(), Fault> {
        for surface in &self.surfaces {
            for (line, key) in &surface.solved {
                let stored = match key.as_str() {
                    "THI" => surface.thickness,
                    _ => surface.shape.curvature,
                };
                if stored == 0.0 && !self.skip_unknown {
                    let found = format!("a solve of {key} whose value the file does not store");
                    let fault = self
                        .text
                        .fault_of_line(*line, found, "a number in its place");
                    return Err(
                        fault.hint("--skip-unknown takes zero (in Python, skip_unknown=True)")
                    );
                }
                self.losses.solves += 1;
            }
        }
        Ok(())
    }

    /// The prescription in mm.
    fn sequential(mut self) -> Result<Sequential, Fault> {
        let image = self.surfaces.len().saturating_sub(1);
        if image < 2 {
            let expected = "at least one command S between the object (SO) and the image (SI)";
            return Err(self.text.fault_of_file("no surfaces of a lens", expected));
        }
        if !(1..image).contains(&self.stop) {
            let found = format!("the stop on surface {}", self.stop);
            return Err(self
                .text
                .fault_of_file(found, "STO between the object and the image"));
        }
        let Some(aperture) = self.header.aperture else {
            let expected = "one of the commands EPD, FNO, NA, NAO";
            return Err(self
                .text
                .fault_of_file("no aperture of the system", expected));
        };
        let (wavelength_um, primary) = self.header.wavelengths(self.text, self.losses)?;
        let reference_um = wavelength_um.get(primary).copied().unwrap_or(0.55);
        let (surface, stop, focused) = self.faces(reference_um)?;
        self.check_object(&surface)?;
        self.tell();
        Ok(Sequential {
            title: self.header.title.clone(),
            surface,
            stop,
            aperture: match aperture {
                ApertureRule::EntrancePupil(width) => {
                    ApertureRule::EntrancePupil(width * self.header.unit)
                }
                other => other,
            },
            field_kind: self.header.field_kind,
            field: self.header.fields(),
            wavelength_um,
            primary,
            catalogues: Vec::new(),
            focused,
        })
    }

    /// All faces, the number of the stop among them, and that of the one before a paraxial image.
    fn faces(&mut self, reference_um: f64) -> Result<(Vec<Face>, usize, Option<usize>), Fault> {
        let around = Surroundings {
            text: self.text,
            glasses: &self.glasses,
            unit: self.header.unit,
            reference_um,
            skip_unknown: self.skip_unknown,
        };
        let image = self.surfaces.len().saturating_sub(1);
        let (mut list, mut stop, mut focused): (Vec<Face>, _, _) = (Vec::new(), 0, None);
        for (number, surface) in self.surfaces.iter().enumerate() {
            let (mut faces, own) = surface.faces(number, &around, self.losses)?;
            if number == self.stop {
                stop = list.len() + own;
            }
            if number == image {
                // The thickness of the image is a defocus: it stands that far behind, before its own shift and tilt.
                faces.truncate(own + 1);
                if let Some(before) = list.last_mut() {
                    before.thickness_mm += surface.thickness * around.unit;
                }
                if let Some(face) = faces.last_mut() {
                    face.thickness_mm = 0.0;
                }
            }
            list.append(&mut faces);
            if let Some((_, line)) = self.focused.filter(|(at, _)| *at == number) {
                if surface.thickness == 0.0 && number > 0 && number < image {
                    focused = Some(list.len() - 1);
                } else {
                    self.losses.solves += 1;
                }
                self.losses.change(format!(
                    "Line {line}: the paraxial image (PIM) {}.",
                    match focused {
                        Some(_) => "is at the distance that raylet computes",
                        None => "stands where the file stores it",
                    }
                ));
            }
        }
        Ok((list, stop, focused))
    }

    /// The object lies before the first surface.
    fn check_object(&self, surface: &[Face]) -> Result<(), Fault> {
        match surface
            .iter()
            .find(|face| !matches!(face.action, Action::Turn(_)))
        {
            Some(object) if object.thickness_mm <= 0.0 => {
                let distance = object.thickness_mm;
                let found = format!("an object {distance} mm before the first surface");
                let expected =
                    "a distance above zero, of 1e9 or more for one that is infinitely far (SO)";
                Err(self.text.fault_of_line(object.line, found, expected))
            }
            _ => Ok(()),
        }
    }

    /// Sentences on what the file has as a whole.
    fn tell(&mut self) {
        if self.positions > 1 {
            self.losses.leave_out(format!(
                "The rest of the {} positions of the zoom: the scene has number {} (--configuration N takes another).",
                self.positions, self.position
            ));
        }
        if self.losses.solves > 0 {
            self.losses.change(format!(
                "Solves and pick-ups: the scene has the {} values that the file stores for them, as fixed numbers.",
                self.losses.solves
            ));
        }
        if !self.header.mode_stated {
            self.losses.change(
                "The file does not say whether it has radii or curvatures (RDM): its surfaces have curvatures, as CODE V takes them.",
            );
        }
        if self.header.field_kind == FieldKind::RealImageHeight {
            self.losses.warn(
                "Fields by real image heights are read as paraxial ones: distortion moves them on the sensor.",
            );
        }
        self.losses.change(
            "Wavelengths and indices are taken as they stand; raylet means wavelengths in vacuum.",
        );
    }
}

/// Whether a word is S, SO, SI or S with a number.
fn is_surface(key: &str) -> bool {
    let rest = key.strip_prefix('S');
    rest.is_some_and(|rest| {
        matches!(rest, "" | "O" | "I") || rest.bytes().all(|byte| byte.is_ascii_digit())
    })
}
