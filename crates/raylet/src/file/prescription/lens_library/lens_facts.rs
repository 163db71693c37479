//! What a list of lenses says of one: its maker, focal length, diameter.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::file::decode::fault::Fault;
use crate::file::prescription::import::OpenedLens;
use crate::file::prescription::lens_text::LensText;
use crate::file::prescription::sequential::{Action, Behind, Face};

/// Makers, and words that stand in their files.
const MAKERS: [(&str, &[&str]); 14] = [
    ("Thorlabs", &["thorlabs"]),
    ("Edmund Optics", &["edmund", "'eo '"]),
    ("Newport", &["newport"]),
    ("OptoSigma", &["optosigma", "sigma koki", "sigmakoki"]),
    ("Asphericon", &["asphericon"]),
    ("LightPath", &["lightpath"]),
    ("Qioptiq", &["qioptiq", "linos"]),
    ("Melles Griot", &["melles griot"]),
    ("CVI", &["cvi laser", "cvi melles"]),
    ("Ross Optical", &["ross optical"]),
    ("Comar", &["comar optics"]),
    ("Eksma", &["eksma"]),
    ("JML Optical", &["jml optical"]),
    ("Archer OpTx", &["archer optx"]),
];

/// The longest text in which a maker is sought, in bytes.
const LONGEST: usize = 100_000;

/// What a list says of a lens; lengths unfolded along its axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LensFacts {
    /// The title in the file, or else the name of the file without its end.
    pub name: String,
    /// The maker, where the file says so.
    pub maker: Option<String>,
    /// Focal length in mm; none where it has no power.
    pub focal_length_mm: Option<f64>,
    /// Diameter in mm: of the largest rim that the file fixes, or else that its program computed, or of the entrance pupil where
    /// that is larger.
    pub diameter_mm: f64,
    /// Focal length over the diameter of the entrance pupil.
    pub f_number: Option<f64>,
    /// Surfaces that bend light.
    pub surfaces: usize,
    /// The primary wavelength in µm, for which these numbers hold.
    pub wavelength_um: f64,
}

impl LensFacts {
    /// The facts of a lens file; glasses that are not known make them unknown.
    ///
    /// # Errors
    /// The first fault of the file.
    pub fn of(bytes: &[u8], path: &Path) -> Result<Self, Fault> {
        OpenedLens::seen(bytes, path, |text, opened| {
            Self::of_opened(text, opened, path)
        })
    }

    /// The facts of a lens that is read.
    fn of_opened(text: &LensText, opened: &OpenedLens, path: &Path) -> Self {
        let (lens, first) = (&opened.lens, &opened.first);
        let bends = |i: usize, face: &Face| {
            let media = [i.wrapping_sub(1), i].map(|at| opened.media.get(at));
            let crosses = match media {
                [Some(before), Some(behind)] => before.material != behind.material,
                _ => false,
            };
            let reflects = face.behind == Behind::Reflected;
            let ideal = matches!(face.action, Action::IdealLens(_));
            i < lens.image() && (crosses || reflects || ideal || !face.phase.is_empty())
        };
        let all = lens.surface.iter().enumerate().skip(1);
        let bending: Vec<&Face> = all
            .filter(|(i, face)| bends(*i, face))
            .map(|(_, face)| face)
            .collect();
        let finite =
            |value: f64| Some(value).filter(|value| value.is_finite() && value.abs() < 1e9);
        let focal_length_mm = finite(first.focal_length);
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let title = lens.title.trim();
        Self {
            name: match title.is_empty() {
                true => stem.into_owned(),
                false => title.to_owned(),
            },
            maker: maker(text),
            focal_length_mm,
            diameter_mm: diameter(&bending).unwrap_or(0.0).max(first.pupil_diameter),
            f_number: focal_length_mm.map(|length| length.abs() / first.pupil_diameter),
            surfaces: bending.len(),
            wavelength_um: opened.wavelength_um(),
        }
    }
}

/// The largest diameter of rims that are fixed, or else of any.
fn diameter(faces: &[&Face]) -> Option<f64> {
    let largest = |fixed: bool| {
        let sizes = faces.iter().filter_map(|face| face.semi_diameter);
        let sizes = sizes
            .filter(|(_, own)| *own || !fixed)
            .map(|(size, _)| 2.0 * size);
        sizes.reduce(f64::max)
    };
    largest(true).or_else(|| largest(false))
}

/// The maker whose words stand in a text.
fn maker(text: &LensText) -> Option<String> {
    let (mut whole, mut length) = (String::new(), 0);
    for (_, line) in text.lines() {
        length += line.len();
        if length > LONGEST {
            break;
        }
        whole.push_str(&line.to_lowercase());
        whole.push('\n');
    }
    let stands = |words: &[&str]| words.iter().any(|word| whole.contains(word));
    let found = MAKERS.iter().find(|(_, words)| stands(words));
    found.map(|(name, _)| (*name).to_owned())
}
