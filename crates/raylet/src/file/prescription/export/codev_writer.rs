//! A prescription as the text of a CODE V file (.seq).

use std::f64::consts::TAU;

use crate::file::prescription::export::codev_glasses::CodevGlasses;
use crate::file::prescription::export::codev_shapes::{
    CodevShape, codev_curve, codev_phase, codev_turn, nanometres,
};
use crate::file::prescription::export::held_phase::{Refusal, Standing, joined, series};
use crate::file::prescription::export::lens_edges::{EdgeForm, LensEdge};
use crate::file::prescription::export::limiting_stop::rim_radius;
use crate::file::prescription::export::outgoing::Outgoing;
use crate::file::prescription::export::zemax_writer::written;
use crate::file::prescription::import_report::Losses;
use crate::file::prescription::sequential::{
    Action, ApertureRule, Behind, Face, FieldKind, Sequential,
};
use crate::optics::phase::placement::Placement;

/// The distance of an object that is infinitely far, in mm.
const DISTANT: &str = "1e13";

/// A surface of the file.
#[derive(Clone, Debug, Default)]
struct Row {
    shape: CodevShape,
    thickness_mm: f64,
    medium: Option<String>,
    commands: Vec<String>,
}

/// Whether the format holds a surface.
///
/// # Errors
/// A curve or phase that it cannot hold, as what was found and what was expected.
pub(crate) fn codev_holds(outgoing: &Outgoing, face: &Face) -> Result<(), Refusal> {
    shape(outgoing, face, &mut Losses::default()).map(|_| ())
}

/// The text of a prescription.
///
/// # Errors
/// The number of a surface that the format cannot hold, with what was found and what was expected.
pub(crate) fn codev_text(
    outgoing: &Outgoing,
    losses: &mut Losses,
) -> Result<String, (usize, Refusal)> {
    let lens = &outgoing.lens;
    let glasses = CodevGlasses::of(&outgoing.media, &lens.wavelength_um, losses);
    let mut rows: Vec<Row> = Vec::new();
    for (i, face) in lens.surface.iter().enumerate() {
        let shape = shape(outgoing, face, losses).map_err(|refusal| (i, refusal))?;
        let medium = outgoing.media.get(i);
        let medium = match face.behind {
            Behind::Reflected => Some("REFL".to_owned()),
            _ => medium.and_then(|medium| glasses.word(medium)),
        };
        if let Some(last) = rows.last_mut() {
            last.thickness_mm += shape.offset_mm;
        }
        let mut commands = Vec::new();
        if i == lens.stop {
            commands.push("STO".to_owned());
        }
        let label = plain(&face.comment);
        if !label.is_empty() {
            commands.push(format!("SLB '{label}'"));
        }
        edges(outgoing.path.get(i), face, &mut commands, losses);
        rows.push(Row {
            thickness_mm: face.thickness_mm - shape.offset_mm,
            medium: medium.filter(|_| i != lens.image()),
            shape,
            commands,
        });
    }
    let mut lines = header(lens);
    lines.extend(glasses.definitions());
    for (number, row) in rows.iter().enumerate() {
        row.write(&mut lines, number, number + 1 == rows.len());
    }
    lines.push("GO".to_owned());
    Ok(lines.join("\n") + "\n")
}

/// The commands of a surface's curve, phase or turn.
fn shape(outgoing: &Outgoing, face: &Face, losses: &mut Losses) -> Result<CodevShape, Refusal> {
    let i = face.number;
    let um = outgoing.lens.wavelength_um.first().copied().unwrap_or(0.55);
    let mut phase = face.phase.first().cloned();
    match face.action {
        Action::Turn(turn) => {
            return Ok(CodevShape {
                commands: codev_turn(turn),
                ..CodevShape::default()
            });
        }
        Action::IdealLens(focal_length) => {
            let index = outgoing.media.get(i).map_or(1.0, |medium| medium.index);
            let standing = Standing {
                first_um: um,
                index,
                reach_mm: rim_radius(face).unwrap_or(1.0),
            };
            let wavenumber = TAU * index / (um * 1e-3);
            let held = series(focal_length, wavenumber, Placement::NONE, standing)?;
            for remark in &held.remarks {
                losses.change(format!(
                    "{}: a paraxial lens is a diffractive phase at the first wavelength; {remark}.",
                    outgoing.path.get(i).map_or("", String::as_str)
                ));
            }
            phase = joined(&[held], standing.reach_mm);
        }
        Action::Border => {}
    }
    let mut shape = codev_curve(&face.curve)?;
    if let Some(layer) = &phase {
        shape.commands.extend(codev_phase(layer, um)?);
    }
    Ok(shape)
}

/// Text that may stand between quotes.
fn plain(text: &str) -> String {
    let words = text
        .chars()
        .filter(|c| !c.is_control() && !"'\"".contains(*c));
    words.take(40).collect()
}

/// The commands of a surface's apertures.
fn edges(path: Option<&String>, face: &Face, commands: &mut Vec<String>, losses: &mut Losses) {
    let own = face.outline.as_ref().and_then(LensEdge::of);
    match (own, face.semi_diameter) {
        (Some(edge), _) => edge_commands(edge, "", commands),
        (None, Some((radius, _))) => commands.push(format!("CIR {}", written(radius))),
        (None, None) => {}
    }
    if let Some(hole) = own.and_then(hole) {
        edge_commands(hole, " OBS L'hole'", commands);
    }
    let blocked = face.blocked.iter().filter_map(LensEdge::of);
    for (number, edge) in (1..).zip(blocked) {
        edge_commands(edge, &format!(" OBS L'b{number}'"), commands);
    }
    let mut all = own
        .into_iter()
        .chain(face.blocked.iter().filter_map(LensEdge::of));
    if all.any(|edge| edge.wider) {
        losses.change(format!(
            "{}: an aperture of a form that the file cannot hold is the circle about it.",
            path.map_or("", String::as_str)
        ));
    }
}

/// What is blocked in the middle of a ring.
fn hole(edge: LensEdge) -> Option<LensEdge> {
    match edge.form {
        EdgeForm::Ring([inner, _]) if inner > 0.0 => Some(LensEdge {
            form: EdgeForm::Ring([0.0, inner]),
            ..edge
        }),
        _ => None,
    }
}

/// The commands of one edge, whose use and label follow each word.
fn edge_commands(edge: LensEdge, role: &str, commands: &mut Vec<String>) {
    let mut say = |word: &str, value: f64| {
        commands.push(format!("{word}{role} {}", written(value)));
    };
    match edge.form {
        EdgeForm::Ring([_, radius]) => say("CIR", radius),
        EdgeForm::Rectangle([x, y]) => {
            say("REX", x);
            say("REY", y);
        }
        EdgeForm::Ellipse([x, y]) => {
            say("ELX", x);
            say("ELY", y);
        }
    }
    let [x, y] = edge.centre_mm;
    for (word, value) in [("ADX", x), ("ADY", y), ("ARO", edge.rotation_deg)] {
        if value != 0.0 {
            say(word, value);
        }
    }
}

fn header(lens: &Sequential) -> Vec<String> {
    let pupil = match lens.aperture {
        ApertureRule::EntrancePupil(width) => width,
        _ => 1.0,
    };
    let list = |axis: usize| {
        let values = lens.field.iter();
        let values = values.map(|at| written(at.get(axis).copied().unwrap_or(0.0)));
        values.collect::<Vec<_>>().join(" ")
    };
    let kind = match lens.field_kind {
        FieldKind::ObjectHeight => "OB",
        _ => "AN",
    };
    let waves = lens.wavelength_um.iter();
    let waves: Vec<String> = waves.map(|um| written(nanometres(*um))).collect();
    let mut lines = vec!["RDM; LEN".to_owned()];
    let title = plain(&lens.title);
    if !title.is_empty() {
        lines.push(format!("TITLE '{title}'"));
    }
    lines.extend([
        format!("EPD {}", written(pupil)),
        "DIM M".to_owned(),
        format!("WL {}", waves.join(" ")),
        format!("REF {}", lens.primary + 1),
        format!("X{kind} {}", list(0)),
        format!("Y{kind} {}", list(1)),
    ]);
    lines
}

impl Row {
    fn write(&self, lines: &mut Vec<String>, number: usize, last: bool) {
        let word = match (number, last) {
            (0, _) => "SO",
            (_, true) => "SI",
            _ => "S",
        };
        let distance = match self.thickness_mm.is_finite() {
            true if last => "0".to_owned(),
            true => written(self.thickness_mm),
            false => DISTANT.to_owned(),
        };
        let medium = self
            .medium
            .as_ref()
            .map_or(String::new(), |word| format!(" {word}"));
        let radius = written(self.shape.radius_mm);
        lines.push(format!("{word} {radius} {distance}{medium}"));
        let all = self.commands.iter().chain(&self.shape.commands);
        lines.extend(all.map(|command| format!("  {command}")));
    }
}
