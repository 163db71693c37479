//! The arrays of a scene, and what makes one whose file is missing.

use std::collections::BTreeMap;
use std::path::Path;

use crate::file::arrays::array::BorrowedArray;
use crate::file::decode::fault::Fault;
use crate::file::model::scene_arrays::Arrays;
use crate::file::scene::check::check_elements;
use crate::file::scene::scene_file::Scene;

/// Keys that name the file of an array.
const ARRAYS: [&str; 5] = ["samples", "phase", "amplitude", "transmission", "height_um"];

impl Scene {
    /// The scene with every array that its layers name.
    ///
    /// # Errors
    /// An array that is missing, malformed, not 2-D, of the wrong kind or shape, not finite, or too large
    /// for `memory_limit_mb`; or an array of heights that does not fit its surface.
    pub fn load(mut self) -> Result<Self, Fault> {
        self.arrays = self.load_with(&BTreeMap::new())?;
        Ok(self)
    }

    /// Every array that the scene's layers name: those that are `lent` (by the path of the field, such as
    /// `element[0].layer[0].phase`) from the memory of the caller, those that are loaded already, and the rest
    /// from their files. For [`crate::file::model::build::system_with`].
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn load_with<'a>(
        &self,
        lent: &BTreeMap<String, BorrowedArray<'a>>,
    ) -> Result<Arrays<'a>, Fault> {
        let limit = self.memory_limit();
        let arrays = Arrays::load(
            &self.source,
            &self.element,
            &self.origin,
            limit,
            lent,
            &self.arrays,
        );
        let arrays = arrays.map_err(|fault| with_maker(self, fault))?;
        // Surfaces of heights can only be checked now.
        check_elements(&self.element, &arrays, &self.origin)?;
        Ok(arrays)
    }
}

/// The same fault; where the file of an array is missing, with a hint at what makes it: the verb that fills it by the
/// scene's own tables, or else what a comment says behind the name of the file.
fn with_maker(scene: &Scene, fault: Fault) -> Fault {
    let Some(comment) = missing(scene, &fault) else {
        return fault;
    };
    let (file, number) = (scene.origin.file.display(), element(&fault.address.path));
    let fills = |name: &str| number.is_some() && scene.number_of(name) == number;

    // Tables of the scene come first: what they name is still to be found.
    let commissions = &scene.hologram;
    if commissions
        .as_ref()
        .is_some_and(|task| fills(&task.element))
    {
        return fault.hint(format!(
            "the phase is still to be computed: raylet hologram {file}"
        ));
    }
    let sought = scene.design.iter().flat_map(|design| &design.element);
    if sought.into_iter().any(|element| fills(&element.name)) {
        return fault.hint(format!("it is still to be found: raylet design {file}"));
    }
    match comment.is_empty() {
        true => fault,
        false => fault.hint(comment),
    }
}

/// The comment behind the name of an array's file, if a fault is at that name and the file is missing.
fn missing(scene: &Scene, fault: &Fault) -> Option<String> {
    let key = fault.address.path.rsplit('.').next().unwrap_or_default();
    let excerpt = fault.address.excerpt.as_ref()?;
    let mut rest = excerpt.text.chars().skip(excerpt.column.saturating_sub(1));
    let named: String = rest.by_ref().take(excerpt.width).collect();
    let file = scene
        .origin
        .beside(Path::new(named.trim_matches(['"', '\''])));
    if !ARRAYS.contains(&key) || file.exists() {
        return None;
    }
    let rest: String = rest.collect();
    let comment = rest.trim_start().strip_prefix('#').unwrap_or_default();
    Some(comment.trim().to_owned())
}

/// The number of the element in which a path lies.
fn element(path: &str) -> Option<usize> {
    path.strip_prefix("element[")?
        .split(']')
        .next()?
        .parse()
        .ok()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::file::scene::scene_file::Scene;

    const SCENE: &str = r#"
version = 1
wavelength_um = 0.5
source.kind = "plane"
[[element]]
kind = "doe"
name = "first"
thickness_mm = 1
aperture = { disc = { radius_mm = 0.1 } }
[[element.layer]]
kind = "pixels"
pitch_um = 2
size = [8, 8]
phase = "none.npy"
[[element]]
kind = "sensor"
pixels = [2, 2]
pitch_um = 1
"#;

    fn hint(text: &str) -> String {
        let scene = Scene::parse(text, Path::new("nowhere/scene.toml")).unwrap();
        scene.load().unwrap_err().hint.unwrap_or_default()
    }

    #[test]
    fn tables_of_the_scene_say_which_verb_makes_an_array() {
        assert_eq!(hint(SCENE), "");
        let design = "[[design.element]]\nname = 'first'\n\
            [[design.loss]]\nkind = 'spot'\nat_mm = [[0.0, 0.0]]\n";
        let found = hint(&format!("{SCENE}{design}"));
        assert_eq!(
            found,
            "it is still to be found: raylet design nowhere/scene.toml"
        );
        let task = "[hologram]\ntarget = 'x.png'\nelement = 'first'\nsize_mm = [0.1, 0.1]\n";
        let found = hint(&format!("{SCENE}{task}{design}"));
        assert!(
            found.ends_with("raylet hologram nowhere/scene.toml"),
            "{found}"
        );
    }

    #[test]
    fn a_comment_behind_the_name_says_what_makes_an_array() {
        let text = SCENE.replace("npy\"", "npy\" # raylet paper system2");
        assert_eq!(hint(&text), "raylet paper system2");
    }

    /// Scenes as they are before any of their arrays is made: alone in a folder.
    #[test]
    fn every_scene_of_the_repository_says_what_makes_its_arrays() {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        let mut seen = 0;
        for folder in ["", "paper", "real_size"] {
            for entry in std::fs::read_dir(scenes.join(folder)).unwrap() {
                let path = entry.unwrap().path();
                if path.extension().is_none_or(|ending| ending != "toml") {
                    continue;
                }
                let text = std::fs::read_to_string(&path).unwrap();
                let scene = Scene::parse(&text, Path::new("nowhere/scene.toml")).unwrap();
                if let Err(fault) = scene.load() {
                    assert!(fault.hint.is_some(), "{}: {fault}", path.display());
                    seen += 1;
                }
            }
        }
        assert!(seen >= 7, "{seen}");
    }
}
