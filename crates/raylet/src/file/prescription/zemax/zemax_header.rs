//! The records of a Zemax file that stand before its surfaces: units, aperture, fields, wavelengths.

use crate::file::decode::fault::Fault;
use crate::file::prescription::import_report::Losses;
use crate::file::prescription::lens_text::{LensText, Record};
use crate::file::prescription::sequential::{ApertureRule, FieldKind};
use crate::file::prescription::zemax::zemax_configuration::Operand;

/// Most fields and wavelengths that a file may state.
const MOST: usize = 1000;

/// Wavelengths of a file in µm.
const SHORTEST: f64 = 0.01;
const LONGEST: f64 = 100.0;

/// What the records say, lengths in the unit of the file.
#[derive(Clone, Debug)]
pub(crate) struct Header {
    /// The title.
    pub title: String,
    /// Millimetres in the unit of the file.
    pub unit: f64,
    /// What says how wide the light is.
    pub aperture: Option<ApertureRule>,
    /// What the numbers of a field are.
    pub field_kind: FieldKind,
    /// Catalogues of glasses.
    pub catalogues: Vec<String>,
    /// Number of the configuration whose values the surfaces have, and how many there are.
    pub configuration: [usize; 2],
    fields: usize,
    waves: usize,
    across: [Vec<f64>; 2],
    waves_um: Vec<f64>,
    primary: usize,
}

impl Default for Header {
    fn default() -> Self {
        Self {
            title: String::new(),
            unit: 1.0,
            aperture: None,
            field_kind: FieldKind::Angle,
            catalogues: Vec::new(),
            configuration: [1, 1],
            fields: 0,
            waves: 0,
            across: [Vec::new(), Vec::new()],
            waves_um: Vec::new(),
            primary: 1,
        }
    }
}

impl Header {
    /// Reads a record; false where its word is none of these.
    ///
    /// # Errors
    /// A value that is missing, no number, or of no meaning here.
    pub(crate) fn read(
        &mut self,
        text: &LensText,
        record: &Record<'_>,
        losses: &mut Losses,
    ) -> Result<bool, Fault> {
        match record.word {
            "MODE" => check_mode(text, record)?,
            "NAME" => self.title = record.rest.chars().take(200).collect(),
            "UNIT" => self.unit = unit(text, record)?,
            "ENPD" | "FNUM" | "OBNA" | "FLOA" => {
                self.aperture = Some(aperture(text, record)?);
            }
            "FTYP" => self.read_field_kind(text, record, losses)?,
            "XFLN" | "XFLD" => self.across[0] = numbers(text, record)?,
            "YFLN" | "YFLD" => self.across[1] = numbers(text, record)?,
            "WAVL" | "WAVN" => self.waves_um = numbers(text, record)?,
            "WAVM" => {
                let number = text.count(record, 0, MOST)?.max(1);
                if self.waves_um.len() < number {
                    self.waves_um.resize(number, 0.0);
                }
                if let Some(wave) = self.waves_um.get_mut(number - 1) {
                    *wave = text.value(record, 1)?;
                }
            }
            "PWAV" => self.primary = text.count(record, 0, MOST)?,
            "GCAT" => {
                self.catalogues = record
                    .values
                    .iter()
                    .take(MOST)
                    .map(|&c| c.to_owned())
                    .collect();
            }
            "MNUM" => {
                let current = text.value_or(record, 1, 1.0)?;
                self.configuration = [current as usize, text.count(record, 0, 1_000_000)?];
            }
            "VDXN" | "VDYN" | "VCXN" | "VCYN" | "VANN" | "ZVDX" | "ZVDY" | "ZVCX" | "ZVCY"
            | "ZVAN" => {
                if numbers(text, record)?.iter().any(|value| *value != 0.0) {
                    losses.leave_out(
                        "Vignetting factors: the light of a field fills the stop, and rims of surfaces clip it. \
                         Fields off the axis may have more light, and larger spots, than in OpticStudio.",
                    );
                }
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Gives the lens the value of a configuration; false where it belongs to a surface.
    ///
    /// # Errors
    /// A value that is no number, or of a wavelength or field that is not there.
    pub(crate) fn configure(&mut self, text: &LensText, operand: &Operand) -> Result<bool, Fault> {
        let place = operand.number.wrapping_sub(1);
        let [x, y] = &mut self.across;
        let list = match operand.word.as_str() {
            "APER" => {
                let value = operand.number_of(text)?;
                self.aperture = self.aperture.map(|rule| match rule {
                    ApertureRule::EntrancePupil(_) => ApertureRule::EntrancePupil(value),
                    ApertureRule::ImageFNumber(_) => ApertureRule::ImageFNumber(value),
                    ApertureRule::WorkingFNumber(_) => ApertureRule::WorkingFNumber(value),
                    ApertureRule::ObjectSine(_) => ApertureRule::ObjectSine(value),
                    ApertureRule::StopSize => ApertureRule::StopSize,
                });
                return match value > 1e-9 {
                    true => Ok(true),
                    false => Err(operand.refused(text)),
                };
            }
            "PRWV" => {
                self.primary = operand.number_of(text)? as usize;
                return Ok(true);
            }
            "WAVE" => &mut self.waves_um,
            "XFIE" => x,
            "YFIE" => y,
            _ => return Ok(false),
        };
        if place < MOST && list.len() <= place {
            list.resize(place + 1, 0.0);
        }
        match list.get_mut(place) {
            Some(entry) => *entry = operand.number_of(text)?,
            None => return Err(operand.refused(text)),
        }
        Ok(true)
    }

    /// Values: the kind, a flag of telecentric objects, the numbers of fields and wavelengths.
    fn read_field_kind(
        &mut self,
        text: &LensText,
        record: &Record<'_>,
        losses: &mut Losses,
    ) -> Result<(), Fault> {
        self.field_kind = match text.count(record, 0, 100)? {
            0 => FieldKind::Angle,
            1 => FieldKind::ObjectHeight,
            2 => FieldKind::ImageHeight,
            3 => FieldKind::RealImageHeight,
            _ => {
                let expected = "0 (angle), 1 (object height), 2 or 3 (image height)";
                let word = record.values.first().copied().unwrap_or(record.word);
                return Err(text.fault(word, format!("fields of kind {word}"), expected));
            }
        };
        if text.value_or(record, 1, 0.0)? == 1.0 {
            losses.leave_out(
                "Telecentric object space: the stop limits the light, and chief rays go through its middle.",
            );
        }
        if record.values.len() > 3 {
            self.fields = text.count(record, 2, MOST)?;
            self.waves = text.count(record, 3, MOST)?;
        }
        Ok(())
    }

    /// The fields in the unit of the file, at least one.
    pub(crate) fn fields(&self) -> Vec<[f64; 2]> {
        let [x, y] = &self.across;
        let written = x.len().max(y.len());
        let count = match self.fields {
            0 => written,
            stated => stated.min(written),
        };
        let at = |list: &[f64], i: usize| list.get(i).copied().unwrap_or(0.0);
        let fields = (0..count.max(1)).map(|i| [at(x, i), at(y, i)]);
        fields.collect()
    }

    /// The wavelengths in µm, and the number of the primary one from 0.
    ///
    /// # Errors
    /// No wavelengths, one that is none, or a primary one that is not there.
    pub(crate) fn wavelengths(&self, text: &LensText) -> Result<(Vec<f64>, usize), Fault> {
        let mut waves = self.waves_um.clone();
        // Old files fill up the list with a wavelength that is not meant.
        if self.waves > 0 {
            waves.truncate(self.waves);
        }
        let expected = "records WAVM with wavelengths from 0.01 to 100 µm";
        if waves.is_empty() {
            return Err(text.fault_of_file("no wavelengths", expected));
        }
        if let Some(wave) = waves
            .iter()
            .find(|wave| !(SHORTEST..=LONGEST).contains(*wave))
        {
            return Err(text.fault_of_file(format!("a wavelength of {wave} µm"), expected));
        }
        match self.primary.checked_sub(1) {
            Some(primary) if primary < waves.len() => Ok((waves, primary)),
            _ => {
                let found = format!("wavelength {} of {} as primary", self.primary, waves.len());
                Err(text.fault_of_file(found, "PWAV with the number of a wavelength"))
            }
        }
    }
}

fn check_mode(text: &LensText, record: &Record<'_>) -> Result<(), Fault> {
    match record.values.first() {
        Some(mode) if !mode.eq_ignore_ascii_case("SEQ") => Err(text.fault(
            mode,
            format!("a file of mode {mode}"),
            "a sequential one, MODE SEQ",
        )),
        _ => Ok(()),
    }
}

/// Millimetres in the unit of a record.
fn unit(text: &LensText, record: &Record<'_>) -> Result<f64, Fault> {
    let word = record.values.first().copied().unwrap_or("MM");
    match word.to_uppercase().as_str() {
        "MM" => Ok(1.0),
        "CM" => Ok(10.0),
        "IN" | "INCH" => Ok(25.4),
        "M" | "METER" | "METERS" => Ok(1000.0),
        _ => Err(text.fault(word, format!("lengths in {word}"), "MM, CM, IN or METER")),
    }
}

fn numbers(text: &LensText, record: &Record<'_>) -> Result<Vec<f64>, Fault> {
    let words = record.values.iter().take(MOST);
    words.map(|word| text.number(word)).collect()
}

/// The aperture of a record, lengths in the unit of the file.
fn aperture(text: &LensText, record: &Record<'_>) -> Result<ApertureRule, Fault> {
    if record.word == "FLOA" {
        return Ok(ApertureRule::StopSize);
    }
    let (value, kind) = (text.value(record, 0)?, text.value_or(record, 1, 0.0)?);
    let rule = match (record.word, kind) {
        ("ENPD", _) => ApertureRule::EntrancePupil(value),
        ("FNUM", 0.0) => ApertureRule::ImageFNumber(value),
        ("FNUM", _) => ApertureRule::WorkingFNumber(value),
        (_, 0.0) => ApertureRule::ObjectSine(value),
        _ => ApertureRule::ObjectSine(value.to_radians().sin()),
    };
    let fits = match rule {
        ApertureRule::ObjectSine(sine) => sine > 1e-9 && sine < 1.0,
        _ => value > 1e-9,
    };
    match fits {
        true => Ok(rule),
        false => {
            let word = record.values.first().copied().unwrap_or(record.word);
            let expected = "an aperture above zero, and a numerical aperture below 1";
            Err(text.fault(word, format!("{} {value}", record.word), expected))
        }
    }
}
