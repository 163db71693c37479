//! Media as glasses of CODE V: by names with their makers, by codes, or by indices of the file itself.

use crate::file::prescription::export::codev_shapes::nanometres;
use crate::file::prescription::export::zemax_glasses::{MATERIALS, medium_of};
use crate::file::prescription::export::zemax_writer::written;
use crate::file::prescription::glasses::glass_choice::MediumBehind;
use crate::file::prescription::import_report::Losses;
use crate::file::scene::material::{Material, OwnMedium};
use crate::optics::media::catalog;
use crate::optics::media::medium::Medium;

/// Wavelengths of a table between its ends, and how far these lie beyond those of the scene.
const ENTRIES: usize = 9;
const BEYOND: [f64; 2] = [0.8, 1.25];

/// Wavelengths on a line.
const ON_A_LINE: usize = 6;

/// The glasses of a prescription.
#[derive(Clone, Debug)]
pub(crate) struct CodevGlasses {
    wavelengths_um: Vec<f64>,
    /// Media whose indices stand in the file.
    tables: Vec<(Material, Medium)>,
}

impl CodevGlasses {
    /// The glasses of these media.
    pub(crate) fn of(media: &[MediumBehind], wavelengths_um: &[f64], losses: &mut Losses) -> Self {
        let mut glasses = Self {
            wavelengths_um: wavelengths_um.to_vec(),
            tables: Vec::new(),
        };
        let materials = media.iter().filter_map(|medium| medium.material.as_ref());
        for material in materials {
            let known = glasses.tables.iter().any(|(other, _)| other == material);
            let (None, Some(medium), false) = (word(material), medium_of(material), known) else {
                continue;
            };
            let dispersive = !matches!(material, Material::Own(OwnMedium { index: Some(_), .. }));
            if dispersive {
                let name = match material {
                    Material::Named(name) => name.clone(),
                    Material::Own(own) => own.to_string(),
                };
                losses.change(format!(
                    "The medium {name} is a table of indices of the file itself (PRV), about the wavelengths of the scene."
                ));
            }
            glasses.tables.push((material.clone(), medium));
        }
        glasses
    }

    /// The word of a medium in the row of a surface; none for air.
    pub(crate) fn word(&self, medium: &MediumBehind) -> Option<String> {
        let material = medium.material.as_ref()?;
        word(material).or_else(|| {
            let mut tables = self.tables.iter();
            let place = tables.position(|(other, _)| other == material)?;
            Some(format!("'M{}'", place + 1))
        })
    }

    /// The commands that define the media of the file itself.
    pub(crate) fn definitions(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for (number, (material, medium)) in (1..).zip(&self.tables) {
            let waves = match material {
                Material::Own(OwnMedium { index: Some(_), .. }) => {
                    self.wavelengths_um.iter().copied().take(1).collect()
                }
                _ => self.entries(medium),
            };
            let known = |um: &f64| Some((*um, medium.index(um * 1e-3).ok()?));
            let pairs: Vec<(f64, f64)> = waves.iter().filter_map(known).collect();
            let nm = pairs.iter().map(|(um, _)| written(nanometres(*um)));
            let indices = pairs.iter().map(|(_, index)| written(*index));
            lines.push("PRV".to_owned());
            lines.push(wrapped("PWL", nm.collect()));
            lines.push(wrapped(&format!("'M{number}'"), indices.collect()));
            lines.push("END".to_owned());
        }
        lines
    }

    /// The wavelengths of a table in µm, from long to short: those of the scene, and some about them.
    fn entries(&self, medium: &Medium) -> Vec<f64> {
        let shortest = self.wavelengths_um.iter().copied().fold(f64::MAX, f64::min);
        let longest = self.wavelengths_um.iter().copied().fold(0.0, f64::max);
        let [from, to] = [BEYOND[0] * shortest, BEYOND[1] * longest];
        let at = |i: usize| {
            let um = from * (to / from).powf(i as f64 / (ENTRIES - 1) as f64);
            (um * 1e6).round() / 1e6
        };
        let near = |um: f64| move |own: &f64| (um / own - 1.0).abs() < 1e-3;
        let about = (0..ENTRIES)
            .map(at)
            .filter(|um| !self.wavelengths_um.iter().any(near(*um)));
        let mut waves: Vec<f64> = about.chain(self.wavelengths_um.iter().copied()).collect();
        waves.retain(|um| medium.index(um * 1e-3).is_ok());
        waves.sort_by(|a, b| b.total_cmp(a));
        waves.dedup();
        waves
    }
}

/// A command over several lines.
fn wrapped(word: &str, values: Vec<String>) -> String {
    let lines = values.chunks(ON_A_LINE).map(|chunk| chunk.join(" "));
    let lines: Vec<String> = lines.collect();
    format!("{word} {}", lines.join(" &\n  "))
}

/// The name with its maker, or the code of a medium; none where the file needs its indices.
fn word(material: &Material) -> Option<String> {
    match material {
        Material::Named(name) => {
            let glass = catalog::glass(name).ok()?;
            if glass.catalogue == MATERIALS {
                return None;
            }
            let proper = glass.names.first()?;
            let plain: String = proper.chars().filter(|c| !" -_".contains(*c)).collect();
            let plain = plain.to_uppercase();
            let words = plain.chars().all(|c| c.is_ascii_alphanumeric());
            let found = catalog::glass(&format!("{}:{plain}", glass.catalogue)).ok()?;
            let same = words && std::ptr::eq(found, glass);
            same.then(|| format!("{plain}_{}", glass.catalogue))
        }
        Material::Own(OwnMedium {
            nd: Some(nd),
            vd: Some(vd),
            ..
        }) => {
            // Six digits of each part.
            let [index, abbe] = [(nd - 1.0) * 1e6, vd * 1e4].map(f64::round);
            let kept = |whole: f64, value: f64| (whole - value).abs() < 1e-6;
            let fits = (1.0..1e6).contains(&index) && (1.0..1e6).contains(&abbe);
            let exact = kept(index, (nd - 1.0) * 1e6) && kept(abbe, vd * 1e4);
            (fits && exact).then(|| format!("{index:06}.{abbe:06}"))
        }
        Material::Own(_) => None,
    }
}
