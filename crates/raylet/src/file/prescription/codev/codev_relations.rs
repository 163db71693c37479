//! Values of a CODE V file that others give: pick-ups, and positions of a zoom.

use crate::file::decode::fault::{Fault, shortened};
use crate::file::prescription::codev::codev_commands::{Command, key};
use crate::file::prescription::codev::codev_shape::curvature;
use crate::file::prescription::codev::codev_surface::SurfaceData;
use crate::file::prescription::lens_text::LensText;

/// A value that is another one, times a factor.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PickUp {
    /// The line of the file.
    pub line: usize,
    /// What is given: the command of the value, its surface as it is written, and its position.
    to: Item,
    /// What it is taken from.
    from: Item,
    factor: f64,
    offset: f64,
}

/// A value of a surface.
#[derive(Clone, Debug, Default, PartialEq)]
struct Item {
    key: String,
    surface: String,
    position: Option<String>,
}

impl PickUp {
    /// Reads a command PIK: what is given, what it is taken from, a factor and an offset.
    ///
    /// # Errors
    /// Two values that are not named, or numbers that are none.
    pub(crate) fn read(text: &LensText, command: &Command<'_>) -> Result<Self, Fault> {
        let mut items: Vec<Item> = Vec::new();
        let mut numbers = Vec::new();
        for word in &command.values {
            let upper = word.to_ascii_uppercase();
            let numbered = upper
                .chars()
                .nth(1)
                .is_some_and(|c| c.is_ascii_digit() || "OIS".contains(c));
            let named = items.len();
            match (upper.chars().next(), items.last_mut()) {
                (Some('S'), Some(item)) if upper.len() < 8 && numbered => item.surface = upper,
                (Some('Z'), Some(item)) if numbered => {
                    item.position = upper.get(1..).map(str::to_owned);
                }
                (Some(c), _) if c.is_ascii_alphabetic() && named < 2 => items.push(Item {
                    key: key(word),
                    ..Item::default()
                }),
                _ => numbers.push(text.number(word)?),
            }
        }
        let expected = "PIK with two values and their surfaces, such as PIK RDY S4 RDY S2";
        match <[Item; 2]>::try_from(items) {
            Ok([to, from]) if !to.surface.is_empty() && !from.surface.is_empty() => Ok(Self {
                line: command.line,
                to,
                from,
                factor: numbers.first().copied().unwrap_or(1.0),
                offset: numbers.get(1).copied().unwrap_or(0.0),
            }),
            _ => Err(text.fault(command.word, "an unknown pick-up", expected)),
        }
    }

    /// The surfaces that give and take, as they are written.
    pub(crate) fn surfaces(&self) -> [&str; 2] {
        [&self.from.surface, &self.to.surface]
    }

    /// The value to be taken at a position of the zoom; none where it belongs to another position or is no plain number.
    pub(crate) fn value(&self, from: &SurfaceData, position: usize) -> Option<f64> {
        let here = position.to_string();
        let meant = |item: &Item| item.position.as_ref().is_none_or(|at| *at == here);
        if !meant(&self.to) || !meant(&self.from) {
            return None;
        }
        let value = match self.from.key.as_str() {
            "CUY" => from.shape.curvature,
            "RDY" => curvature(from.shape.curvature),
            "THI" => from.thickness,
            "K" => from.shape.conic,
            _ => return None,
        };
        let value = self.factor * value + self.offset;
        value.is_finite().then_some(value)
    }

    /// Gives a surface the value; false where it cannot have it.
    pub(crate) fn give(&self, to: &mut SurfaceData, value: f64) -> bool {
        match self.to.key.as_str() {
            "CUY" => to.shape.curvature = value,
            "RDY" => to.shape.curvature = curvature(value),
            "THI" => to.thickness = value,
            "K" => to.shape.conic = value,
            _ => return false,
        }
        true
    }
}

/// The command that a command ZOO means at a position, from 1, of `count`: a value's command with the value of that position.
///
/// # Errors
/// Values that are not as many as there are positions.
pub(crate) fn at_position<'t>(
    text: &LensText,
    command: &Command<'t>,
    position: usize,
    count: usize,
) -> Result<Command<'t>, Fault> {
    let expected =
        format!("ZOO with the command of a value and {count} values, such as ZOO THI S5 1 2");
    let refuse = |found: String| text.fault(command.word, found, expected.clone());
    let Some((word, rest)) = command.values.split_first() else {
        return Err(refuse("ZOO without a value".to_owned()));
    };
    let inner = command.inner(word, rest);
    let values = inner.values.len();
    let value = match values {
        1 => inner.values.first(),
        _ if values == count => inner.values.get(position.wrapping_sub(1)),
        _ => None,
    };
    match value {
        Some(value) => Ok(Command {
            values: vec![*value],
            ..inner
        }),
        None => Err(refuse(format!("{values} values of {}", shortened(word)))),
    }
}
