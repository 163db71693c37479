//! Commands of a CODE V file on the whole lens: units, aperture, fields, wavelengths.

use crate::file::decode::fault::Fault;
use crate::file::prescription::codev::codev_commands::{Command, unquoted};
use crate::file::prescription::import_report::Losses;
use crate::file::prescription::lens_text::LensText;
use crate::file::prescription::sequential::{ApertureRule, FieldKind};

/// Most fields and wavelengths that a file may state.
const MOST: usize = 1000;

/// Wavelengths of a file in nm.
const SHORTEST: f64 = 10.0;
const LONGEST: f64 = 100_000.0;

/// What the commands say, lengths in the unit of the file.
#[derive(Clone, Debug)]
pub(crate) struct Header {
    /// The title.
    pub title: String,
    /// Millimetres in the unit of the file.
    pub unit: f64,
    /// Whether surfaces are given by radii; by curvatures otherwise.
    pub by_radii: bool,
    /// Whether the file says which.
    pub mode_stated: bool,
    /// What says how wide the light is.
    pub aperture: Option<ApertureRule>,
    /// What the numbers of a field are.
    pub field_kind: FieldKind,
    across: [Vec<f64>; 2],
    waves_nm: Vec<f64>,
    reference: Option<usize>,
}

impl Default for Header {
    fn default() -> Self {
        Self {
            title: String::new(),
            unit: 1.0,
            by_radii: false,
            mode_stated: false,
            aperture: None,
            field_kind: FieldKind::Angle,
            across: [Vec::new(), Vec::new()],
            waves_nm: Vec::new(),
            reference: None,
        }
    }
}

impl Header {
    /// Reads a command; false where it is none of these.
    ///
    /// # Errors
    /// A value that is missing, no number, or of no meaning here.
    pub(crate) fn read(
        &mut self,
        text: &LensText,
        command: &Command<'_>,
        losses: &mut Losses,
    ) -> Result<bool, Fault> {
        match command.key.as_str() {
            "RDM" => (self.by_radii, self.mode_stated) = (command.agrees(), true),
            "TIT" => {
                let whole = command.values.join(" ");
                self.title = unquoted(&whole).chars().take(200).collect();
            }
            "DIM" => self.unit = unit(text, command)?,
            "EPD" | "FNO" | "NAO" | "NA" => self.aperture = Some(aperture(text, command)?),
            "WL" => set(&mut self.waves_nm, text, command, 'W')?,
            "REF" => {
                let number = command.number(text, 0)?;
                let whole = number.fract() == 0.0 && (1.0..=MOST as f64).contains(&number);
                if !whole {
                    let expected = "the number of a wavelength";
                    return Err(text.fault(command.word, format!("REF {number}"), expected));
                }
                self.reference = Some(number as usize);
            }
            "XAN" | "YAN" | "XOB" | "YOB" | "XIM" | "YIM" | "XRI" | "YRI" => {
                self.read_field(text, command)?;
            }
            "VUX" | "VLX" | "VUY" | "VLY" => {
                let values = command.numbers(text)?;
                if values.iter().any(|value| *value != 0.0) {
                    losses.leave_out(
                        "Vignetting factors: the light of a field fills the stop, and rims of surfaces clip it. Fields off the \
                         axis may have more light, and larger spots, than in CODE V.",
                    );
                }
            }
            "TEL" if command.agrees() => losses.leave_out(
                "Telecentric object space: the stop limits the light, and chief rays go through its middle.",
            ),
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn read_field(&mut self, text: &LensText, command: &Command<'_>) -> Result<(), Fault> {
        let (axis, kind) = command.key.split_at_checked(1).unwrap_or_default();
        self.field_kind = match kind {
            "AN" => FieldKind::Angle,
            "OB" => FieldKind::ObjectHeight,
            "IM" => FieldKind::ImageHeight,
            _ => FieldKind::RealImageHeight,
        };
        let [x, y] = &mut self.across;
        set(if axis == "X" { x } else { y }, text, command, 'F')
    }

    /// The fields in mm or degrees, at least one.
    pub(crate) fn fields(&self) -> Vec<[f64; 2]> {
        let length = match self.field_kind {
            FieldKind::Angle => 1.0,
            _ => self.unit,
        };
        let [x, y] = &self.across;
        let at = |list: &[f64], i: usize| length * list.get(i).copied().unwrap_or(0.0);
        let count = x.len().max(y.len()).max(1);
        (0..count).map(|i| [at(x, i), at(y, i)]).collect()
    }

    /// The wavelengths in µm, and the number of the reference one from 0.
    ///
    /// # Errors
    /// No wavelengths, one that is none, or a reference one that is not there.
    pub(crate) fn wavelengths(
        &self,
        text: &LensText,
        losses: &mut Losses,
    ) -> Result<(Vec<f64>, usize), Fault> {
        let count = self.waves_nm.len();
        let expected = "WL with wavelengths from 10 to 100000 nm";
        let within = |wave: &&f64| !(SHORTEST..=LONGEST).contains(*wave);
        if let Some(wave) = self.waves_nm.iter().find(within) {
            return Err(text.fault_of_file(format!("a wavelength of {wave} nm"), expected));
        }
        if count == 0 {
            return Err(text.fault_of_file("no wavelengths", expected));
        }
        let reference = match self.reference {
            Some(number) if number <= count => number - 1,
            Some(number) => {
                let found = format!("wavelength {number} of {count} as reference");
                return Err(text.fault_of_file(found, "REF with the number of a wavelength"));
            }
            None => (count - 1) / 2,
        };
        if self.reference.is_none() && count > 1 {
            losses.change(format!(
                "The file states no reference wavelength (REF): it is the middle one, number {}.",
                reference + 1
            ));
        }
        Ok((self.waves_nm.iter().map(|nm| nm / 1e3).collect(), reference))
    }
}

/// Sets a whole list, or the one entry that a qualifier names.
fn set(
    list: &mut Vec<f64>,
    text: &LensText,
    command: &Command<'_>,
    letter: char,
) -> Result<(), Fault> {
    let expected = format!("at most {MOST} of them");
    let number = command.qualifier(letter).filter(|number| *number != "A");
    let Some(number) = number else {
        if command.values.len() > MOST {
            let found = format!("{} values of {}", command.values.len(), command.word);
            return Err(text.fault(command.word, found, expected));
        }
        *list = command.numbers(text)?;
        return Ok(());
    };
    let place = number.parse::<usize>().ok();
    let Some(place) = place.filter(|place| (1..=MOST).contains(place)) else {
        let found = format!("{} with number {number}", command.word);
        return Err(text.fault(command.word, found, expected));
    };
    if list.len() < place {
        list.resize(place, 0.0);
    }
    if let Some(entry) = list.get_mut(place - 1) {
        *entry = command.number(text, 0)?;
    }
    Ok(())
}

/// Millimetres in the unit of a command.
fn unit(text: &LensText, command: &Command<'_>) -> Result<f64, Fault> {
    let word = command.values.first().copied().unwrap_or("M");
    match unquoted(word).to_ascii_uppercase().chars().next() {
        Some('M') => Ok(1.0),
        Some('C') => Ok(10.0),
        Some('I') => Ok(25.4),
        _ => {
            let expected = "M (millimetres), C (centimetres) or I (inches)";
            Err(text.fault(word, format!("lengths in {word}"), expected))
        }
    }
}

/// The aperture of a command, lengths in the unit of the file.
fn aperture(text: &LensText, command: &Command<'_>) -> Result<ApertureRule, Fault> {
    let value = command.number(text, 0)?;
    let rule = match command.key.as_str() {
        "EPD" => ApertureRule::EntrancePupil(value),
        "FNO" => ApertureRule::WorkingFNumber(value),
        "NAO" => ApertureRule::ObjectSine(value),
        // The paraxial ray has the slope of the real one.
        _ => ApertureRule::WorkingFNumber(0.5 / value.asin().tan()),
    };
    let fits = match rule {
        ApertureRule::ObjectSine(sine) => sine > 1e-9 && sine < 1.0,
        ApertureRule::WorkingFNumber(number) => number > 1e-9 && value > 1e-9,
        _ => value > 1e-9,
    };
    match fits {
        true => Ok(rule),
        false => {
            let word = command.values.first().copied().unwrap_or(command.word);
            let expected = "an aperture above zero, and a numerical aperture below 1";
            Err(text.fault(word, format!("{} {value}", command.word), expected))
        }
    }
}
