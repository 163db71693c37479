//! A prescription as the text of a Zemax file (.zmx).

use std::fmt::Write;

use crate::file::prescription::export::held_phase::Refusal;
use crate::file::prescription::export::lens_edges::{EdgeForm, LensEdge};
use crate::file::prescription::export::limiting_stop::rim_radius;
use crate::file::prescription::export::outgoing::Outgoing;
use crate::file::prescription::export::zemax_glasses::ZemaxGlasses;
use crate::file::prescription::export::zemax_types::{ZemaxType, zemax_type};
use crate::file::prescription::import_report::Losses;
use crate::file::prescription::sequential::{ApertureRule, Behind, Face, FieldKind, Sequential};

/// A surface of the file.
#[derive(Clone, Debug, Default)]
struct Row {
    stop: bool,
    kind: ZemaxType,
    comment: String,
    thickness_mm: f64,
    glass: Option<String>,
    radius_mm: Option<f64>,
    edge: Option<(LensEdge, bool)>,
}

/// Whether the format holds a surface.
///
/// # Errors
/// A curve or phase that it cannot hold, as what was found and what was expected.
pub(crate) fn zemax_holds(_: &Outgoing, face: &Face) -> Result<(), Refusal> {
    zemax_type(face).map(|_| ())
}

/// The text of a prescription.
///
/// # Errors
/// The number of a surface that the format cannot hold, with what was found and what was expected.
pub(crate) fn zemax_text(
    outgoing: &Outgoing,
    losses: &mut Losses,
) -> Result<String, (usize, Refusal)> {
    let lens = &outgoing.lens;
    let glasses = ZemaxGlasses::of(&outgoing.media);
    let mut rows: Vec<Row> = Vec::new();
    for (i, face) in lens.surface.iter().enumerate() {
        let kind = zemax_type(face).map_err(|refusal| (i, refusal))?;
        if let Some(last) = rows.last_mut() {
            last.thickness_mm += kind.offset_mm;
        }
        rows.extend(rows_of(outgoing, &glasses, i, face, kind, losses));
    }
    let mut text = String::new();
    // Text in memory takes all that is written.
    let _ = header(&mut text, lens, &glasses);
    for (number, row) in rows.iter().enumerate() {
        let _ = row.write(&mut text, number, number + 1 == rows.len());
    }
    Ok(text)
}

/// The rows of a surface: those of apertures that stand before it, and its own.
fn rows_of(
    outgoing: &Outgoing,
    glasses: &ZemaxGlasses,
    i: usize,
    face: &Face,
    kind: ZemaxType,
    losses: &mut Losses,
) -> Vec<Row> {
    let lens = &outgoing.lens;
    let last = i == lens.image();
    let glass = match face.behind {
        Behind::Reflected => Some("MIRROR 0 0 1.5 40 0 0 0 0 0 0".to_owned()),
        _ => glass_at(outgoing, glasses, i, losses),
    };
    let mut edges = edges(outgoing.path.get(i), face, losses);
    let own = Row {
        stop: i == lens.stop,
        comment: face.comment.clone(),
        thickness_mm: face.thickness_mm - kind.offset_mm,
        glass: glass.filter(|_| kind.word != "COORDBRK" && !last),
        radius_mm: match last {
            true => Some(outgoing.sensor_mm),
            false => rim_radius(face),
        },
        edge: edges.pop(),
        kind,
    };
    // The format has one aperture for each surface: others stand before it.
    let before = match edges.is_empty() {
        true => None,
        false => glass_at(outgoing, glasses, i.wrapping_sub(1), losses),
    };
    let aside = edges.into_iter().map(|edge| Row {
        kind: own.kind.bare(),
        glass: before.clone(),
        radius_mm: own.radius_mm,
        edge: Some(edge),
        ..Row::default()
    });
    let mut rows: Vec<Row> = aside.collect();
    rows.push(own);
    rows
}

/// The glass behind a surface.
fn glass_at(
    outgoing: &Outgoing,
    glasses: &ZemaxGlasses,
    i: usize,
    losses: &mut Losses,
) -> Option<String> {
    let waves = outgoing.lens.wavelength_um.len();
    glasses.record(outgoing.media.get(i)?, waves, losses)
}

impl ZemaxType {
    /// The conic of a surface, for an aperture that stands before it.
    fn bare(&self) -> Self {
        Self {
            word: "STANDARD",
            curvature: self.curvature,
            conic: self.conic,
            ..Self::default()
        }
    }
}

/// The edges of a surface, that of its own aperture last, each with whether it is blocked.
fn edges(path: Option<&String>, face: &Face, losses: &mut Losses) -> Vec<(LensEdge, bool)> {
    let mut fit = |edge: LensEdge| {
        let turned = edge.rotation_deg != 0.0;
        if edge.wider || turned {
            let path = path.map_or("", String::as_str);
            losses.change(format!(
                "{path}: an aperture of a form that the file cannot hold is the circle about it."
            ));
        }
        if turned { edge.circle() } else { edge }
    };
    let own = face.outline.as_ref().and_then(LensEdge::of).map(&mut fit);
    let blocked = face.blocked.iter().filter_map(LensEdge::of);
    let mut blocked: Vec<(LensEdge, bool)> = blocked.map(|edge| (fit(edge), true)).collect();

    // A disc in the middle of a round aperture is a ring of it.
    let round = own.is_none_or(|edge| edge.is_centred_circle());
    let place = blocked
        .iter()
        .position(|(edge, _)| edge.is_centred_circle());
    if let (true, Some(place), Some(outer)) = (round, place, rim_radius(face)) {
        let (inner, _) = blocked.remove(place);
        let ring = LensEdge {
            form: EdgeForm::Ring([inner.radius(), outer]),
            ..inner
        };
        blocked.push((ring, false));
        return blocked;
    }
    blocked.extend(own.map(|edge| (edge, false)));
    blocked
}

/// A number as short as reads back the same.
pub(crate) fn written(value: f64) -> String {
    let size = value.abs();
    match size == 0.0 || (1e-4..1e12).contains(&size) {
        true => format!("{}", value + 0.0),
        false => format!("{value:e}"),
    }
}

fn header(text: &mut String, lens: &Sequential, glasses: &ZemaxGlasses) -> std::fmt::Result {
    let pupil = match lens.aperture {
        ApertureRule::EntrancePupil(width) => width,
        _ => 1.0,
    };
    let title: String = lens.title.chars().filter(|c| !c.is_control()).collect();
    writeln!(text, "MODE SEQ")?;
    if !title.is_empty() {
        writeln!(text, "NAME {title}")?;
    }
    writeln!(text, "UNIT MM X W X CM MR CPMM")?;
    writeln!(text, "ENPD {}", written(pupil))?;
    if !glasses.catalogues.is_empty() {
        writeln!(text, "GCAT {}", glasses.catalogues.join(" "))?;
    }
    let kind = match lens.field_kind {
        FieldKind::ObjectHeight => 1,
        _ => 0,
    };
    let (fields, waves) = (lens.field.len(), lens.wavelength_um.len());
    writeln!(text, "FTYP {kind} 0 {fields} {waves} 0 0 0")?;
    for (word, axis) in [("XFLN", 0), ("YFLN", 1)] {
        let values = lens
            .field
            .iter()
            .map(|at| written(at.get(axis).copied().unwrap_or(0.0)));
        writeln!(text, "{word} {}", values.collect::<Vec<_>>().join(" "))?;
    }
    let zeros = vec!["0"; fields].join(" ");
    let ones = vec!["1"; fields].join(" ");
    writeln!(text, "FWGN {ones}")?;
    for word in ["VDXN", "VDYN", "VCXN", "VCYN", "VANN"] {
        writeln!(text, "{word} {zeros}")?;
    }
    for (number, wave) in (1..).zip(&lens.wavelength_um) {
        writeln!(text, "WAVM {number} {} 1", written(*wave))?;
    }
    writeln!(text, "PWAV {}", lens.primary + 1)
}

impl Row {
    fn write(&self, text: &mut String, number: usize, last: bool) -> std::fmt::Result {
        writeln!(text, "SURF {number}")?;
        if self.stop {
            writeln!(text, "  STOP")?;
        }
        writeln!(text, "  TYPE {}", self.kind.word)?;
        writeln!(text, "  CURV {} 0 0 0 0", written(self.kind.curvature))?;
        if !self.comment.is_empty() {
            let comment: String = self.comment.chars().filter(|c| !c.is_control()).collect();
            writeln!(text, "  COMM {comment}")?;
        }
        for (place, value) in &self.kind.parameter {
            writeln!(text, "  PARM {place} {}", written(*value))?;
        }
        for (place, value) in (1..).zip(&self.kind.extra) {
            writeln!(text, "  XDAT {place} {} 0 0 1 0 0", written(*value))?;
        }
        match self.thickness_mm.is_finite() {
            true if last => writeln!(text, "  DISZ 0")?,
            true => writeln!(text, "  DISZ {}", written(self.thickness_mm))?,
            false => writeln!(text, "  DISZ INFINITY")?,
        }
        if let Some(glass) = &self.glass {
            writeln!(text, "  GLAS {glass}")?;
        }
        if self.kind.conic != 0.0 {
            writeln!(text, "  CONI {}", written(self.kind.conic))?;
        }
        self.write_edge(text)
    }

    fn write_edge(&self, text: &mut String) -> std::fmt::Result {
        if let Some(radius) = self.radius_mm {
            writeln!(text, "  DIAM {} 1 0 0 1", written(radius))?;
        }
        let Some((edge, blocked)) = self.edge else {
            return match self.radius_mm {
                Some(radius) => writeln!(text, "  FLAP 0 {} 0", written(radius)),
                None => Ok(()),
            };
        };
        let (word, sizes) = match (edge.form, blocked) {
            (EdgeForm::Ring(sizes), false) => ("CLAP", sizes),
            (EdgeForm::Ring(sizes), true) => ("OBSC", sizes),
            (EdgeForm::Rectangle(sizes), false) => ("SQAP", sizes),
            (EdgeForm::Rectangle(sizes), true) => ("SQOB", sizes),
            (EdgeForm::Ellipse(sizes), false) => ("ELAP", sizes),
            (EdgeForm::Ellipse(sizes), true) => ("ELOB", sizes),
        };
        let [first, second] = sizes.map(written);
        writeln!(text, "  {word} {first} {second} 0")?;
        if edge.centre_mm != [0.0; 2] {
            let [x, y] = edge.centre_mm.map(written);
            writeln!(text, "  OBDC {x} {y}")?;
        }
        Ok(())
    }
}
