//! Values of cells as a grey picture (PNG), with what a grey level means in a text beside it.

use std::io::{self, Write};

use serde::{Deserialize, Serialize};

use crate::file::fabrication::cell_rows::Cells;
use crate::file::fabrication::made_values::MadeValues;

/// What the grey levels of a picture mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct GreyScale {
    /// What a value is, with its unit.
    pub quantity: String,
    /// The value of black.
    pub offset: f64,
    /// From one grey level to the next.
    pub per_grey: f64,
    /// Bits of a grey level.
    pub bits: u8,
    /// Number of cells [nx, ny].
    pub pixels: [usize; 2],
    /// Distance of neighbouring cells [x, y] in µm.
    pub pitch_um: [f64; 2],
    /// Number of equal levels, where values are on them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub levels: Option<u16>,
    /// Wavelength in vacuum in µm, if it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavelength_um: Option<f64>,
    /// Index of the relief less that of the medium whose place it takes, if it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub index_step: Option<f64>,
    /// Which side of the picture is which.
    pub orientation: String,
}

impl GreyScale {
    /// The scale from the smallest to the largest value; a whole number of grey levels for each level.
    pub(crate) fn new(cells: &Cells, made: &MadeValues, [low, high]: [f64; 2], bits: u8) -> Self {
        let most = greatest(bits);
        let (offset, per_grey) = match made.levels {
            Some(levels) => {
                let steps = f64::from(levels.count - 1);
                let each = (most / steps).floor().max(1.0);
                let values = (0..levels.count).map(|level| made.of(levels.value(level)));
                let [first, last] = values
                    .fold([f64::INFINITY, f64::NEG_INFINITY], |range, value| {
                        [range[0].min(value), range[1].max(value)]
                    });
                (first, (last - first) / steps / each)
            }
            None if high > low => (low, (high - low) / most),
            None => (low, 1.0),
        };
        let seen = match cells.mirror {
            true => "from which the light comes",
            false => "to which the light goes",
        };
        Self {
            quantity: made.quantity.with_unit().to_owned(),
            offset,
            per_grey,
            bits,
            pixels: cells.size(),
            pitch_um: cells.pitch_um,
            levels: made.levels.map(|levels| levels.count),
            wavelength_um: cells.relief.wavelength_um,
            index_step: cells.relief.step,
            orientation: format!("top row is +y; seen from the side {seen}"),
        }
    }

    /// The grey level of a value.
    fn grey(&self, value: f64) -> f64 {
        let grey = ((value - self.offset) / self.per_grey).round();
        grey.clamp(0.0, greatest(self.bits))
    }

    /// Root mean square of what grey levels change of equally likely values, in the unit of the values.
    pub(crate) fn rounding(&self) -> f64 {
        match self.levels {
            Some(_) => 0.0,
            None => self.per_grey / 12.0_f64.sqrt(),
        }
    }

    /// Writes the picture, from its top row.
    ///
    /// # Errors
    /// A row that cannot be read, or an error of the file system.
    pub(crate) fn write(
        &self,
        out: &mut impl Write,
        cells: &mut Cells,
        made: &MadeValues,
    ) -> io::Result<()> {
        let [nx, ny] = cells.size();
        let [width, height] = [nx, ny].map(u32::try_from);
        let (width, height) = (
            width.map_err(io::Error::other)?,
            height.map_err(io::Error::other)?,
        );
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(match self.bits {
            8 => png::BitDepth::Eight,
            _ => png::BitDepth::Sixteen,
        });
        encoder.set_compression(png::Compression::Fast);
        let mut writer = encoder.write_header()?;
        let mut stream = writer.stream_writer()?;
        let mut values = vec![0.0; nx];
        let mut bytes = Vec::new();
        for y in (0..ny).rev() {
            made.row(cells, y, &mut values)?;
            bytes.clear();
            for value in &values {
                let grey = self.grey(*value) as u16;
                match self.bits {
                    8 => bytes.push(grey as u8),
                    _ => bytes.extend(grey.to_be_bytes()),
                }
            }
            stream.write_all(&bytes)?;
        }
        stream.finish()?;
        Ok(writer.finish()?)
    }

    /// The text beside the picture.
    ///
    /// # Errors
    /// A number that a TOML text cannot hold.
    pub(crate) fn text(&self) -> io::Result<String> {
        let head = "# value = offset + per_grey × grey level\n";
        let text = toml::to_string(self).map_err(io::Error::other)?;
        Ok(format!("{head}{text}"))
    }
}

/// The greatest grey level.
fn greatest(bits: u8) -> f64 {
    match bits {
        8 => 255.0,
        _ => 65_535.0,
    }
}
