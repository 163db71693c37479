//! Apertures of a CODE V file's surfaces: circles, rectangles and ellipses that are open, blocked, holes or mere edges.

use crate::file::decode::fault::Fault;
use crate::file::prescription::codev::codev_commands::Command;
use crate::file::prescription::lens_text::LensText;
use crate::file::prescription::outline::RawEdge;
use crate::file::scene::aperture::Aperture;

/// Most apertures of a surface.
const MOST: usize = 100;

/// What an aperture does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Use {
    /// Light goes through its inside.
    #[default]
    Clear,
    /// Its inside is blocked, or a hole of the surface.
    Blocked,
    /// The end of the glass, which clips no rays.
    Edge,
}

/// One aperture, lengths in the unit of the file.
#[derive(Clone, Debug, Default, PartialEq)]
struct Edge {
    /// C, R or E.
    shape: char,
    role: Use,
    label: String,
    sizes: [Option<f64>; 2],
    centre: [f64; 2],
    rotation_deg: f64,
}

/// The apertures of a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Edges(Vec<Edge>);

/// What light may pass of a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct OpenPart {
    /// Radius of a centred circle in mm.
    pub semi_diameter_mm: Option<f64>,
    /// Another outline.
    pub outline: Option<Aperture>,
    /// What is blocked.
    pub blocked: Vec<Aperture>,
    /// Whether more than one aperture is to be open, of which this is the first.
    pub several: bool,
}

impl Edges {
    /// Reads a command; false where it is none of an aperture.
    ///
    /// # Errors
    /// A value that is missing or no number.
    pub(crate) fn read(&mut self, text: &LensText, command: &Command<'_>) -> Result<bool, Fault> {
        let (shape, place) = match command.key.as_str() {
            "CIR" => ('C', 0),
            "REX" => ('R', 0),
            "REY" => ('R', 1),
            "ELX" => ('E', 0),
            "ELY" => ('E', 1),
            "ADX" => (' ', 0),
            "ADY" => (' ', 1),
            "ARO" => (' ', 2),
            _ => return Ok(false),
        };
        let value = command.number(text, 0)?;
        let has = |word: &str| command.qualifiers.iter().any(|found| found == word);
        let role = match (has("OBS") || has("HOL"), has("EDG")) {
            (true, _) => Use::Blocked,
            (false, true) => Use::Edge,
            (false, false) => Use::Clear,
        };
        let label = command.qualifier('L').unwrap_or_default().to_owned();
        // Shifts and turns belong to any shape, and to the one that came last.
        let same = |edge: &&mut Edge| {
            edge.role == role && edge.label == label && (shape == ' ' || edge.shape == shape)
        };
        let found = self.0.iter_mut().rev().find(same);
        let edge = match found {
            Some(edge) => edge,
            None if shape == ' ' => {
                let expected = "CIR, REX, REY, ELX or ELY before it";
                return Err(text.fault(command.word, "a shift of no aperture", expected));
            }
            None => {
                if self.0.len() >= MOST {
                    let found = format!("more than {MOST} apertures of a surface");
                    return Err(text.fault(command.word, found, "fewer"));
                }
                self.0.push(Edge {
                    shape,
                    role,
                    label,
                    ..Edge::default()
                });
                match self.0.last_mut() {
                    Some(edge) => edge,
                    None => return Ok(true),
                }
            }
        };
        match (shape, place) {
            (' ', 2) => edge.rotation_deg = value,
            (' ', 1) => edge.centre[1] = value,
            (' ', _) => edge.centre[0] = value,
            (_, 1) => edge.sizes[1] = Some(value.abs()),
            _ => edge.sizes[0] = Some(value.abs()),
        }
        Ok(true)
    }

    /// What light may pass, for a unit of this many mm.
    pub(crate) fn open_part(&self, unit: f64) -> OpenPart {
        let mut open = OpenPart::default();
        for edge in &self.0 {
            let plain = edge.shape == 'C' && edge.centre == [0.0; 2];
            match edge.role {
                Use::Edge => {}
                Use::Blocked => open.blocked.extend(edge.aperture(unit)),
                Use::Clear if open.semi_diameter_mm.is_some() || open.outline.is_some() => {
                    open.several = true;
                }
                Use::Clear if plain => {
                    let radius = edge.sizes[0].map(|size| size * unit);
                    open.semi_diameter_mm = radius.filter(|radius| *radius > 1e-12);
                }
                Use::Clear => open.outline = edge.aperture(unit),
            }
        }
        open
    }
}

impl Edge {
    /// A half width that is not stated is the other one.
    fn aperture(&self, unit: f64) -> Option<Aperture> {
        let [x, y] = self.sizes;
        let sizes = [x.or(y)?, y.or(x)?];
        let outline = match self.shape {
            'R' => RawEdge::Rectangle(sizes),
            'E' => RawEdge::Ellipse(sizes),
            _ => RawEdge::Ring([0.0, sizes[0]]),
        };
        outline.aperture(self.centre, self.rotation_deg, unit)
    }
}
