//! A Zemax file (.zmx) as a sequential prescription.

use crate::file::decode::fault::Fault;
use crate::file::prescription::import_report::Losses;
use crate::file::prescription::lens_text::LensText;
use crate::file::prescription::sequential::{ApertureRule, Face, FieldKind, Sequential};
use crate::file::prescription::zemax::zemax_configuration::Operands;
use crate::file::prescription::zemax::zemax_header::Header;
use crate::file::prescription::zemax::zemax_surface::SurfaceRecords;

/// Most surfaces of a file.
const MOST_SURFACES: usize = 5000;

/// Records of a surface or a system that change nothing in a scene.
const WITHOUT_EFFECT: [&str; 49] = [
    "VERS", "NOTE", "AUTH", "PFIL", "LANG", "ENVD", "GFAC", "RAIM", "PUSH", "SDMA", "OMMA", "ROPD",
    "HYPR", "PICB", "FWGN", "FWGT", "WWGN", "WWGT", "POLS", "GLRS", "GSTD", "NSCD", "COFN", "HIDE",
    "MIRR", "SLAB", "POPS", "FIMP", "BLNK", "MOFF", "IWDP", "LUID", "EERA", "SSID", "STUD", "MEMA",
    "OEMA", "RCMF", "DBDT", "DMFS", "TCMM", "EDGE", "ISNA", "PUPD", "VDSZ", "VPAR", "VCUR", "VCON",
    "VXDA",
];

/// Records of solves and pick-ups.
const SOLVES: [&str; 6] = ["MAZH", "PZUP", "PPAR", "PKUP", "CHZH", "THIC"];

/// Reads the prescription of a text in a configuration, by default that whose values the surfaces have. Surfaces of unknown types
/// are planes if `skip_unknown`.
///
/// # Errors
/// The first fault of the text, with its line.
pub(crate) fn read_zemax(
    text: &LensText,
    skip_unknown: bool,
    configuration: Option<usize>,
    losses: &mut Losses,
) -> Result<Sequential, Fault> {
    let (mut header, mut operands, mut behind) = (Header::default(), Operands::default(), false);
    let mut surfaces: Vec<SurfaceRecords> = Vec::new();
    for record in text.records() {
        if record.word == "SURF" {
            let number = surfaces.len();
            if number >= MOST_SURFACES {
                let found = format!("more than {MOST_SURFACES} surfaces");
                return Err(text.fault(record.word, found, "fewer"));
            }
            surfaces.push(SurfaceRecords::new(number, record.line));
            continue;
        }
        if record.word == "MNUM" {
            behind = true;
        } else if behind && operands.read(text, &record)? {
            continue;
        }
        let known = match surfaces.last_mut() {
            Some(surface) => surface.read(text, &record, losses)?,
            None => false,
        };
        if !known && !header.read(text, &record, losses)? {
            sort_out(record.word, losses);
        }
    }
    if let Some(wanted) = configuration {
        configure(text, &operands, wanted, &mut header, &mut surfaces)?;
    }
    tell(&header, losses);
    assemble(text, &header, surfaces, skip_unknown, losses)
}

/// Gives the lens the values of a configuration.
fn configure(
    text: &LensText,
    operands: &Operands,
    wanted: usize,
    header: &mut Header,
    surfaces: &mut [SurfaceRecords],
) -> Result<(), Fault> {
    let [current, count] = header.configuration;
    if !(1..=count).contains(&wanted) {
        let found = format!("{count} configurations, and configuration {wanted} requested");
        let expected = format!("a configuration from 1 to {count}");
        return Err(text.fault_of_file(found, expected));
    }
    if wanted == current {
        return Ok(());
    }
    for operand in operands.of(wanted) {
        if header.configure(text, operand)? {
            continue;
        }
        if operand.word == "STPS" {
            let stop = operand.number_of(text)? as usize;
            for surface in surfaces.iter_mut() {
                surface.stop = surface.number == stop;
            }
            continue;
        }
        match surfaces.get_mut(operand.number) {
            Some(surface) => surface.configure(text, operand)?,
            None => return Err(operand.refused(text)),
        }
    }
    header.configuration = [wanted, count];
    Ok(())
}

/// Notes a record that is not read.
fn sort_out(word: &str, losses: &mut Losses) {
    match word {
        "COAT" => losses.leave_out(
            "Coatings: every surface has an ideal antireflection coating (settings.coating), and mirrors reflect all light.",
        ),
        "TOL" => losses.leave_out("Tolerances."),
        "SPID" | "USAP" | "USOB" | "UDAD" => losses.warn(format!(
            "An aperture of kind {word} is left out: more light may come through."
        )),
        "EFFL" | "CONF" => losses.ignore(word),
        word if SOLVES.contains(&word) => losses.solves += 1,
        word if WITHOUT_EFFECT.contains(&word) => {}
        word => losses.ignore(word),
    }
}

/// Sentences on what the file has as a whole.
fn tell(header: &Header, losses: &mut Losses) {
    let [current, count] = header.configuration;
    if count > 1 {
        losses.leave_out(format!(
            "Configurations: the file has {count}, and the scene has number {current} (--configuration N takes another)."
        ));
    }
    if losses.solves > 0 {
        losses.change(format!(
            "Solves and pick-ups: the scene has the {} values that the file computed by them, as fixed numbers.",
            losses.solves
        ));
    }
    if header.field_kind == FieldKind::RealImageHeight {
        losses.warn(
            "Fields by real image heights are read as paraxial ones: distortion moves them on the sensor.",
        );
    }
    losses.change(
        "Wavelengths are taken as they stand: OpticStudio means those in air, raylet those in vacuum (0.03 % longer).",
    );
    if !losses.unused.is_empty() {
        let words = losses.unused.iter();
        let words: Vec<String> = words.map(|(word, n)| format!("{word} ({n})")).collect();
        losses.leave_out(format!(
            "Records that raylet does not know, most of them of merit functions: {}.",
            words.join(", ")
        ));
    }
}

/// The prescription in mm.
fn assemble(
    text: &LensText,
    header: &Header,
    records: Vec<SurfaceRecords>,
    skip_unknown: bool,
    losses: &mut Losses,
) -> Result<Sequential, Fault> {
    if records.len() < 3 {
        let found = format!("{} surfaces (records SURF)", records.len());
        let expected = "at least three: the object, a surface and the image";
        return Err(text.fault_of_file(found, expected));
    }
    let stop_record = records.iter().position(|surface| surface.stop);
    let (mut surface, mut stop) = (Vec::new(), None);
    for records in records {
        let (number, line) = (records.number, records.line);
        let (face, turn) = records.face(text, header.unit, skip_unknown, losses)?;
        // A turn of one surface alone stands before it, on a line of its own.
        surface.extend(turn.map(|turn| Face::turned([number, line], turn)));
        if stop_record == Some(number) {
            stop = Some(surface.len());
        }
        surface.push(face);
    }
    check_distances(text, &surface)?;
    let last = surface.len() - 1;
    let stop = match stop {
        Some(stop) if (1..last).contains(&stop) => stop,
        Some(_) => return Err(text.fault_of_file("the stop at the object or image", STOP)),
        None => return Err(text.fault_of_file("no stop", STOP)),
    };
    let Some(aperture) = header.aperture else {
        let expected = "one of the records ENPD, FNUM, OBNA, FLOA";
        return Err(text.fault_of_file("no aperture of the system", expected));
    };
    let length = match header.field_kind {
        FieldKind::Angle => 1.0,
        _ => header.unit,
    };
    let (wavelength_um, primary) = header.wavelengths(text)?;
    Ok(Sequential {
        title: header.title.clone(),
        surface,
        stop,
        aperture: match aperture {
            ApertureRule::EntrancePupil(width) => ApertureRule::EntrancePupil(width * header.unit),
            other => other,
        },
        field_kind: header.field_kind,
        field: header
            .fields()
            .iter()
            .map(|at| at.map(|a| a * length))
            .collect(),
        wavelength_um,
        primary,
        catalogues: header.catalogues.clone(),
        focused: None,
    })
}

const STOP: &str = "a record STOP on a surface between the object and the image";

/// Only the object may be infinitely far, and it lies before the first surface.
fn check_distances(text: &LensText, surface: &[Face]) -> Result<(), Fault> {
    for (number, face) in surface.iter().enumerate() {
        let thickness = face.thickness_mm;
        if number > 0 && thickness.is_infinite() && number + 1 < surface.len() {
            let found = format!("an infinite thickness behind surface {}", face.number);
            return Err(text.fault_of_line(face.line, found, "a finite one (DISZ)"));
        }
    }
    match surface.first() {
        Some(object) if object.thickness_mm <= 0.0 => Err(text.fault_of_line(
            object.line,
            format!(
                "an object {} mm before the first surface",
                object.thickness_mm
            ),
            "a distance above zero, or INFINITY (DISZ)",
        )),
        _ => Ok(()),
    }
}
