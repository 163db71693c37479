//! The media of a prescription: glasses of the catalogue by their names, or by the numbers that the file states.

use std::collections::BTreeMap;

use crate::file::decode::fault::{Fault, shortened};
use crate::file::prescription::glasses::glass_file::GlassFiles;
use crate::file::prescription::import_report::Losses;
use crate::file::prescription::lens_text::LensText;
use crate::file::prescription::sequential::{Action, Behind, GlassRequest, Sequential};
use crate::file::scene::material::{Material, OwnMedium};
use crate::optics::media::catalog::{self, CatalogError};

/// Glasses of old catalogues whose makers publish the same formula under a new name.
const RENAMED: [(&str, &str); 1] = [("BK7", "SCHOTT:N-BK7")];

/// The list of single materials, which has no maker.
const MATERIALS: &str = "MATERIAL";

/// Most meanings of an ambiguous name that a message shows.
const SHOWN: usize = 5;

/// The medium behind a surface.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MediumBehind {
    /// The medium; none for air.
    pub material: Option<Material>,
    /// Its index at the wavelength.
    pub index: f64,
}

/// Where glasses come from besides the catalogue.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GlassSources<'a> {
    /// Glasses to take in place of those that the file names.
    pub replaced: &'a BTreeMap<String, String>,
    /// Catalogues of the user, which come before that of raylet.
    pub files: &'a GlassFiles,
}

/// The media behind all surfaces of a prescription at a wavelength in mm.
///
/// # Errors
/// A glass that is not known, or not at this wavelength, with its line.
pub(crate) fn media(
    lens: &Sequential,
    text: &LensText,
    wavelength: f64,
    sources: GlassSources<'_>,
    losses: &mut Losses,
) -> Result<Vec<MediumBehind>, Fault> {
    let mut before = MediumBehind {
        material: None,
        index: 1.0,
    };
    let mut list = Vec::new();
    for face in &lens.surface {
        let stays = matches!(face.action, Action::Turn(_)) || face.behind == Behind::Reflected;
        if !stays {
            before = match &face.behind {
                Behind::Glass(wanted) => {
                    let choice = Choice {
                        wanted,
                        catalogues: &lens.catalogues,
                        sources,
                    };
                    let material = choice.material(text, losses)?;
                    let index = index(&material, wavelength).map_err(|(found, expected)| {
                        text.fault_of_line(wanted.line, found, expected)
                    })?;
                    MediumBehind {
                        material: Some(material),
                        index,
                    }
                }
                _ => MediumBehind {
                    material: None,
                    index: 1.0,
                },
            };
        }
        list.push(before.clone());
    }
    Ok(list)
}

/// The index of a material at a wavelength in mm.
fn index(material: &Material, wavelength: f64) -> Result<f64, (String, String)> {
    let words = |error: String| (error, "a glass that is known at the wavelength".to_owned());
    let medium = match material {
        Material::Own(own) => own.medium()?,
        Material::Named(name) => catalog::medium(name).map_err(|error| words(error.to_string()))?,
    };
    medium
        .index(wavelength)
        .map_err(|error| words(error.to_string()))
}

/// What a glass is chosen by.
struct Choice<'a> {
    wanted: &'a GlassRequest,
    catalogues: &'a [String],
    sources: GlassSources<'a>,
}

impl Choice<'_> {
    fn material(&self, text: &LensText, losses: &mut Losses) -> Result<Material, Fault> {
        let name = self.wanted.name.as_str();
        if let Some(other) = self.replacement() {
            if let Some(own) = self.of_files(other, losses)? {
                return Ok(own);
            }
            let glass = catalog::glass(other).map_err(|error| {
                let expected = "a name of the glass catalogue in its place";
                text.fault_of_line(self.wanted.line, error.to_string(), expected)
            })?;
            losses.change(format!(
                "Glass {name}: {} in its place, as requested.",
                glass.name()
            ));
            return Ok(Material::Named(glass.name()));
        }
        if let Some(own) = &self.wanted.own {
            losses.change(format!(
                "Glass {}: its indices are those that the file itself has.",
                shortened(name)
            ));
            return Ok(Material::Own((**own).clone()));
        }
        if let Some(own) = self.of_files(name, losses)? {
            return Ok(own);
        }
        if name.is_empty() {
            return self.of_numbers(losses).ok_or_else(|| {
                let expected = "an index and an Abbe number as values 4 and 5";
                text.fault_of_line(self.wanted.line, "a model glass without numbers", expected)
            });
        }
        let named = self.of_catalogues(losses);
        let error = match named {
            Ok(name) => return Ok(Material::Named(name)),
            Err(error) => error,
        };
        let spare = self.of_numbers(losses).or_else(|| self.of_digits(losses));
        spare.ok_or_else(|| self.unknown(text, &error))
    }

    /// The glass of this name in the user's catalogues.
    fn of_files(&self, name: &str, losses: &mut Losses) -> Result<Option<Material>, Fault> {
        let found = self.sources.files.find(name)?;
        Ok(found.map(|found| {
            losses.change(format!("Glass {}: {}.", shortened(name), found.source));
            Material::Own(found.medium)
        }))
    }

    /// What is to stand in its place, by its name with or without its maker, in any capitals.
    fn replacement(&self) -> Option<&String> {
        let name = self.wanted.name.as_str();
        let maker = self.wanted.maker.as_deref();
        let whole = maker.map(|maker| format!("{name}_{maker}"));
        let meant = |key: &str| {
            [Some(name), whole.as_deref()]
                .into_iter()
                .flatten()
                .any(|known| known.eq_ignore_ascii_case(key))
        };
        let found = self.sources.replaced.iter().find(|(key, _)| meant(key));
        found.map(|(_, other)| other)
    }

    /// The glass of this name: of the file's catalogues in their order, or else of any.
    fn of_catalogues(&self, losses: &mut Losses) -> Result<String, CatalogError> {
        let name = self.wanted.name.as_str();
        let named: Vec<&String> = match &self.wanted.maker {
            Some(maker) => vec![maker],
            None => self.catalogues.iter().collect(),
        };
        for catalogue in &named {
            if let Ok(glass) = catalog::glass(&format!("{catalogue}:{name}")) {
                return Ok(glass.name());
            }
        }
        let renamed = RENAMED
            .iter()
            .find(|(old, _)| old.eq_ignore_ascii_case(name));
        if let Some((old, new)) = renamed {
            losses.change(format!(
                "Glass {old}: {new} in its place, for which its maker publishes the same formula."
            ));
            return Ok((*new).to_owned());
        }
        let glass = catalog::glass(name)?;
        if glass.catalogue == MATERIALS || named.is_empty() {
            return Ok(glass.name());
        }
        losses.warn(format!(
            "Glass {name} is {}: none of the catalogues that the file names ({}) has it here, and another maker's glass of the \
             same name may differ.",
            glass.name(),
            shortened(&named.into_iter().cloned().collect::<Vec<_>>().join(", "))
        ));
        Ok(glass.name())
    }

    /// A medium of the index and the Abbe number that the file states.
    fn of_numbers(&self, losses: &mut Losses) -> Option<Material> {
        let [nd, vd] = self.wanted.code?;
        if !(1.0..=10.0).contains(&nd) || !(vd == 0.0 || (1e-3..=1e6).contains(&vd)) {
            return None;
        }
        let name = match self.wanted.name.as_str() {
            "" => "Model glass".to_owned(),
            name => format!("Glass {name}, which the catalogue does not have"),
        };
        if vd == 0.0 {
            losses.change(format!("{name}: index {nd} at every wavelength."));
            return Some(Material::Own(OwnMedium {
                index: Some(nd),
                ..OwnMedium::default()
            }));
        }
        losses.change(format!(
            "{name}: nd = {nd} and vd = {vd}, as the file states. The index at other lines than d may be off by 1e-3."
        ));
        Some(Material::Own(OwnMedium {
            nd: Some(nd),
            vd: Some(vd),
            ..OwnMedium::default()
        }))
    }

    /// A code of six digits: 517642 has nd = 1.517 and vd = 64.2.
    fn of_digits(&self, losses: &mut Losses) -> Option<Material> {
        let name = self.wanted.name.as_str();
        if name.len() != 6 || !name.bytes().all(|byte| byte.is_ascii_digit()) {
            return None;
        }
        let (index, abbe) = name.split_at_checked(3)?;
        let [index, abbe] = [index, abbe].map(|digits| digits.parse::<f64>().unwrap_or(0.0));
        let (nd, vd) = (1.0 + index / 1000.0, abbe / 10.0);
        (vd > 0.0).then(|| {
            losses.change(format!(
                "Glass code {name}: nd = {nd} and vd = {vd}, three digits each. The index may be off by 1e-3."
            ));
            Material::Own(OwnMedium {
                nd: Some(nd),
                vd: Some(vd),
                ..OwnMedium::default()
            })
        })
    }

    fn unknown(&self, text: &LensText, error: &CatalogError) -> Fault {
        let name = shortened(&self.wanted.name);
        let (found, near) = match error {
            CatalogError::Ambiguous { meanings, .. } => (
                format!("the glass {name}, which several makers have"),
                meanings.clone(),
            ),
            CatalogError::Unknown { nearest, .. } => {
                (format!("the unknown glass {name}"), nearest.clone())
            }
            other => (other.to_string(), Vec::new()),
        };
        let near: Vec<String> = near.into_iter().take(SHOWN).collect();
        let expected =
            "a glass of the catalogue, or one whose index and Abbe number the file states";
        let fault = text.fault_of_line(self.wanted.line, found, expected);
        fault.hint(format!(
            "--glass {name}=NAME takes another (in Python, glasses={{\"{name}\": NAME}}); the nearest are {}",
            near.join(", ")
        ))
    }
}
