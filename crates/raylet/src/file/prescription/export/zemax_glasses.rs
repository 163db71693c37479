//! Media as glasses of OpticStudio: by their names, or by numbers.

use crate::file::prescription::glasses::glass_choice::MediumBehind;
use crate::file::prescription::import_report::Losses;
use crate::file::scene::material::{Material, OwnMedium};
use crate::optics::media::catalog::{self, Glass};
use crate::optics::media::medium::Medium;

/// The F, d and C lines in mm.
pub(crate) const LINES_MM: [f64; 3] = [0.486_132_7e-3, 0.587_561_8e-3, 0.656_272_5e-3];

/// The list of single materials, which has no maker, and the catalogue of OpticStudio that has most of them.
pub(crate) const MATERIALS: &str = "MATERIAL";
const MISCELLANEOUS: &str = "MISC";

/// A name that files of OpticStudio and its readers share, where the catalogue has several in capitals.
const COMMON: &str = "SILICA";

/// The glasses of a prescription.
#[derive(Clone, Debug, Default)]
pub(crate) struct ZemaxGlasses {
    /// Catalogues in which names are sought, in this order.
    pub catalogues: Vec<String>,
}

/// The medium of a material; none for one that is unknown, which a scene cannot have.
pub(crate) fn medium_of(material: &Material) -> Option<Medium> {
    match material {
        Material::Named(name) => catalog::medium(name).ok(),
        Material::Own(own) => own.medium().ok(),
    }
}

/// Index at the d line and Abbe number; none where a line is out of range, or without dispersion.
pub(crate) fn code(medium: &Medium) -> Option<[f64; 2]> {
    let [f, d, c] = LINES_MM.map(|line| medium.index(line).ok());
    let (f, d, c) = (f?, d?, c?);
    let abbe = (d - 1.0) / (f - c);
    abbe.is_finite().then_some([d, abbe])
}

impl ZemaxGlasses {
    /// The catalogues that hold the glasses of these media.
    pub(crate) fn of(media: &[MediumBehind]) -> Self {
        let mut catalogues: Vec<String> = Vec::new();
        for medium in media {
            let Some(Material::Named(name)) = &medium.material else {
                continue;
            };
            let Ok(glass) = catalog::glass(name) else {
                continue;
            };
            let wanted = match glass.catalogue {
                MATERIALS => MISCELLANEOUS,
                maker => maker,
            };
            if !catalogues.iter().any(|known| known == wanted) {
                catalogues.push(wanted.to_owned());
            }
        }
        Self { catalogues }
    }

    /// The values of the record GLAS of a medium; none for air.
    pub(crate) fn record(
        &self,
        medium: &MediumBehind,
        wavelengths: usize,
        losses: &mut Losses,
    ) -> Option<String> {
        let material = medium.material.as_ref()?;
        let named = match material {
            Material::Named(name) => catalog::glass(name).ok(),
            Material::Own(_) => None,
        };
        let found = medium_of(material)?;
        if let Some(name) = named.and_then(|glass| self.file_name(glass)) {
            let [nd, vd] = code(&found).unwrap_or([0.0; 2]);
            return Some(format!("{name} 0 0 {nd} {vd} 0 0 0 0 0 0"));
        }
        let [nd, vd] = self.numbers(material, &found, medium.index, wavelengths, losses);
        Some(format!("___BLANK 1 0 {nd} {vd} 0 0 0 0 0 0"))
    }

    /// The name by which a reader finds this glass; none where it would find another.
    fn file_name(&self, glass: &'static Glass) -> Option<String> {
        let word = |name: &&str| name.replace(' ', "_");
        let found = |name: &String| {
            let whole = self
                .catalogues
                .iter()
                .map(|maker| format!("{maker}:{name}"));
            let mut all = whole.chain([name.clone()]);
            let first = all.find_map(|name| catalog::glass(&name).ok());
            first.is_some_and(|first| std::ptr::eq(first, glass))
        };
        // Files of OpticStudio have capitals.
        let capitals = |name: &&&str| name.chars().all(|c| !c.is_lowercase() && c != ' ');
        let preferred = glass.names.iter().filter(capitals);
        let common = glass
            .names
            .iter()
            .any(|name| name.eq_ignore_ascii_case(COMMON));
        let first = common.then(|| COMMON.to_owned());
        let mut names = first
            .into_iter()
            .chain(preferred.chain(&glass.names).map(word));
        names.find(found)
    }

    /// Index and Abbe number of a medium without a name; an Abbe number of zero stands for no dispersion.
    fn numbers(
        &self,
        material: &Material,
        medium: &Medium,
        index: f64,
        wavelengths: usize,
        losses: &mut Losses,
    ) -> [f64; 2] {
        match material {
            Material::Own(OwnMedium {
                index: Some(index), ..
            }) => return [*index, 0.0],
            Material::Own(OwnMedium {
                nd: Some(nd),
                vd: Some(vd),
                ..
            }) => return [*nd, *vd],
            _ => {}
        }
        let name = match material {
            Material::Named(name) => name.clone(),
            Material::Own(own) => own.to_string(),
        };
        match code(medium).filter(|_| wavelengths > 1) {
            Some(code) => {
                losses.change(format!(
                    "The medium {name} has its index at the d line and its Abbe number: other wavelengths may be off by 1e-3."
                ));
                code
            }
            None => {
                losses.change(format!(
                    "The medium {name} has its index at the first wavelength, {index}, at every wavelength."
                ));
                [index, 0.0]
            }
        }
    }
}
