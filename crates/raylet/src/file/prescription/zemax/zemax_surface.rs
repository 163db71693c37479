//! The records of one surface of a Zemax file.

use std::path::PathBuf;

use crate::file::decode::fault::Fault;
use crate::file::prescription::import_report::Losses;
use crate::file::prescription::lens_text::{LensText, Record};
use crate::file::prescription::outline::RawEdge;
use crate::file::prescription::sequential::{Behind, Curve, Face, GlassRequest, Turn};
use crate::file::prescription::zemax::zemax_configuration::Operand;
use crate::file::prescription::zemax::zemax_edge::edge_record;
use crate::file::prescription::zemax::zemax_shape::{RawSurface, ReadSurface};

/// The highest number of a parameter, and of extra data.
const MOST_PARAMETERS: usize = 10_000;

/// Objects that are further away, in the unit of the file, are infinitely far in a configuration.
const DISTANT: f64 = 1e10;

/// A shift and turn that a surface has of its own.
#[derive(Clone, Copy, Debug)]
struct OwnTurn {
    line: usize,
    /// Whether it stands before the surface, the shift first, and can be read.
    before: bool,
    /// Shifts along x and y in the unit of the file, and turns about x, y and z in degrees.
    values: [f64; 5],
}

/// The records of a surface as they are read.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceRecords {
    /// Its number, from 0.
    pub number: usize,
    /// The line where it begins.
    pub line: usize,
    /// The line of its type.
    pub type_line: usize,
    /// Whether it is the aperture stop.
    pub stop: bool,
    comment: String,
    raw: RawSurface,
    thickness: f64,
    behind: Behind,
    semi_diameter: Option<(f64, bool)>,
    edges: Vec<(RawEdge, bool)>,
    edge_centre: [f64; 2],
    own_turn: Option<OwnTurn>,
}

impl SurfaceRecords {
    /// A surface that begins at a line.
    pub(crate) fn new(number: usize, line: usize) -> Self {
        Self {
            number,
            line,
            type_line: line,
            stop: false,
            comment: String::new(),
            raw: RawSurface {
                kind: "STANDARD".to_owned(),
                ..RawSurface::default()
            },
            thickness: 0.0,
            behind: Behind::Air,
            semi_diameter: None,
            edges: Vec::new(),
            edge_centre: [0.0; 2],
            own_turn: None,
        }
    }

    /// Reads a record; false where its word is none of a surface.
    ///
    /// # Errors
    /// A value that is missing, or no number.
    pub(crate) fn read(
        &mut self,
        text: &LensText,
        record: &Record<'_>,
        losses: &mut Losses,
    ) -> Result<bool, Fault> {
        match record.word {
            "TYPE" => {
                let kind = record.values.first().copied().unwrap_or("STANDARD");
                (self.raw.kind, self.type_line) = (kind.to_uppercase(), record.line);
            }
            "CURV" => self.raw.curvature = text.value(record, 0)?,
            "CONI" => self.raw.conic = text.value(record, 0)?,
            "DISZ" => self.thickness = thickness(text, record)?,
            "PARM" => {
                let number = text.count(record, 0, MOST_PARAMETERS)?;
                self.raw.parameter.insert(number, text.value(record, 1)?);
            }
            "XDAT" => {
                let number = text.count(record, 0, MOST_PARAMETERS)?;
                self.raw.extra.insert(number, text.value(record, 1)?);
            }
            "GLAS" => self.behind = medium(text, record)?,
            "STOP" => self.stop = true,
            "COMM" => self.comment = record.rest.chars().take(40).collect(),
            "DIAM" => {
                let size = text.value(record, 0)?.abs();
                let fixed = text.value_or(record, 1, 0.0)? != 0.0;
                self.semi_diameter = (size > 0.0).then_some((size, fixed));
            }
            "OBDC" => self.edge_centre = [text.value(record, 0)?, text.value(record, 1)?],
            "SCBD" => self.read_own_turn(text, record)?,
            "FLAP" => {}
            "GDAT" | "GARR" => return self.raw.grid.read(text, record),
            word => return self.read_edge(word, text, record, losses),
        }
        Ok(true)
    }

    /// Gives the surface the value of a configuration.
    ///
    /// # Errors
    /// A value that is no number, or one of a kind without a counterpart.
    pub(crate) fn configure(&mut self, text: &LensText, operand: &Operand) -> Result<(), Fault> {
        if operand.word == "GLSS" {
            self.behind = match operand.value.to_ascii_uppercase().as_str() {
                "MIRROR" => Behind::Reflected,
                "" | "AIR" => Behind::Air,
                _ => Behind::Glass(GlassRequest {
                    line: operand.line,
                    name: operand.value.clone(),
                    maker: None,
                    code: None,
                    own: None,
                }),
            };
            return Ok(());
        }
        let value = operand.number_of(text)?;
        match operand.word.as_str() {
            "CRVT" => self.raw.curvature = value,
            "CONN" => self.raw.conic = value,
            // Objects that are infinitely far have a large number here.
            "THIC" if self.number == 0 && value >= DISTANT => self.thickness = f64::INFINITY,
            "THIC" => self.thickness = value,
            "SDIA" => self.semi_diameter = (value > 0.0).then_some((value, true)),
            _ => return Err(operand.refused(text)),
        }
        Ok(())
    }

    fn read_edge(
        &mut self,
        word: &str,
        text: &LensText,
        record: &Record<'_>,
        losses: &mut Losses,
    ) -> Result<bool, Fault> {
        let sizes = match word {
            "CLAP" | "OBSC" | "SQAP" | "SQOB" | "ELAP" | "ELOB" => {
                [text.value(record, 0)?, text.value(record, 1)?]
            }
            _ => return Ok(false),
        };
        self.edges.extend(edge_record(word, sizes));
        if word.starts_with("EL") {
            losses.change(format!(
                "Surface {}: its elliptical aperture is a polygon of 360 corners.",
                self.number
            ));
        }
        Ok(true)
    }

    /// A shift and turn of one surface alone. Its values: which side, two flags, then shifts and tilts.
    fn read_own_turn(&mut self, text: &LensText, record: &Record<'_>) -> Result<(), Fault> {
        let mut values = [0.0; 8];
        for (place, value) in values.iter_mut().enumerate() {
            *value = text.value_or(record, place, 0.0)?;
        }
        let [side, order, other, turn @ ..] = values;
        if turn != [0.0; 5] {
            self.own_turn = Some(OwnTurn {
                line: record.line,
                before: [side, order, other] == [1.0, 0.0, 0.0] && self.own_turn.is_none(),
                values: turn,
            });
        }
        Ok(())
    }

    /// The surface in mm, and a turn of the axis before it where it has one of its own.
    ///
    /// # Errors
    /// A type or number without a counterpart, unless unknown types are to become planes.
    pub(crate) fn face(
        self,
        text: &LensText,
        unit: f64,
        skip_unknown: bool,
        losses: &mut Losses,
    ) -> Result<(Face, Option<Turn>), Fault> {
        let array = PathBuf::from(format!("{}_surface{}.npy", text.stem(), self.number));
        let read = match self.raw.read(unit, array) {
            Ok(read) => read,
            Err((found, _)) if skip_unknown => {
                losses.warn(format!(
                    "Surface {} is a plane in the scene: the file has {found}. Light behind it goes another way.",
                    self.number
                ));
                ReadSurface::plain(Curve::default())
            }
            Err((found, expected)) => {
                let found = format!("{found}, on surface {}", self.number);
                let fault = text.fault_of_line(self.type_line, found, expected);
                return Err(fault.hint(
                    "--skip-unknown makes such surfaces planes (in Python, skip_unknown=True)",
                ));
            }
        };
        if let Some(remark) = read.remark {
            losses.change(format!("Surface {}: {remark}.", self.number));
        }
        self.warn_of(&read, unit, losses);
        let turn = self.own_turn(text, unit)?;
        let centre = self.edge_centre;
        let edges = |wanted: bool| {
            let wanted = self
                .edges
                .iter()
                .filter(move |(_, blocked)| *blocked == wanted);
            wanted.filter_map(move |(edge, _)| edge.aperture(centre, 0.0, unit))
        };
        let (outline, blocked) = (edges(false).next(), edges(true).collect());
        let face = Face {
            number: self.number,
            line: self.line,
            comment: self.comment,
            action: read.action,
            thickness_mm: self.thickness * unit,
            curve: read.curve,
            phase: read.phase,
            grid: read.grid,
            behind: self.behind,
            semi_diameter: self.semi_diameter.map(|(size, fixed)| (size * unit, fixed)),
            clips: false,
            outline,
            blocked,
        };
        Ok((face, turn))
    }

    /// Warns where the surface is wider than its Zernike terms are in OpticStudio, and where its grid has gaps.
    fn warn_of(&self, read: &ReadSurface, unit: f64, losses: &mut Losses) {
        let number = self.number;
        let within = |end: f64| {
            let size = self.semi_diameter.map(|(size, _)| size * unit);
            size.is_some_and(|size| size <= end * (1.0 + 1e-9))
        };
        if let Some(end) = read.ends_mm.filter(|end| !within(*end)) {
            losses.warn(format!(
                "Surface {number}: its Zernike terms go on beyond {end} mm from the axis, where OpticStudio leaves them out."
            ));
        }
        if read.gaps > 0 {
            losses.warn(format!(
                "Surface {number}: points of its grid are without data ({}), and zero in the scene.",
                read.gaps
            ));
        }
    }

    /// The turn before the surface; turns of another kind have no counterpart.
    fn own_turn(&self, text: &LensText, unit: f64) -> Result<Option<Turn>, Fault> {
        let Some(own) = self.own_turn else {
            return Ok(None);
        };
        let [dx, dy, tx, ty, tz] = own.values;
        if own.before {
            return Ok(Some(Turn {
                decenter_mm: [dx * unit, dy * unit],
                tilt_deg: [tx, ty, tz],
                ..Turn::default()
            }));
        }
        let found = format!("a shift or tilt of surface {} of its own", self.number);
        let expected = "surfaces of type COORDBRK before and behind it";
        Err(text.fault_of_line(own.line, found, expected))
    }
}

fn thickness(text: &LensText, record: &Record<'_>) -> Result<f64, Fault> {
    match record.values.first() {
        Some(word) if word.eq_ignore_ascii_case("INFINITY") => Ok(f64::INFINITY),
        _ => text.value(record, 0),
    }
}

/// Values: the name, a kind of solve, a number of another surface, index at the d line, Abbe number.
fn medium(text: &LensText, record: &Record<'_>) -> Result<Behind, Fault> {
    let Some(name) = record.values.first() else {
        return Err(text.fault(record.word, "GLAS without a name", "the name of a glass"));
    };
    if name.eq_ignore_ascii_case("MIRROR") {
        return Ok(Behind::Reflected);
    }
    let blank = name.eq_ignore_ascii_case("___BLANK");
    let code = match record.values.len() {
        0..=4 => None,
        _ => Some([text.value(record, 3)?, text.value(record, 4)?]),
    };
    // Beside a name, these stand where the program had no numbers.
    let nothing = |[nd, vd]: [f64; 2]| nd == 0.0 || [nd, vd] == [1.5, 40.0];
    Ok(Behind::Glass(GlassRequest {
        line: record.line,
        name: if blank {
            String::new()
        } else {
            (*name).to_owned()
        },
        maker: None,
        code: code.filter(|code| blank || !nothing(*code)),
        own: None,
    }))
}
