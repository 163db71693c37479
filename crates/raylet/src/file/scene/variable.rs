//! Numbers of a scene by their address, so that a design may change any of them.

use toml::Table;

use crate::file::decode::decode_error::nearest;
use crate::file::decode::fault::{Fault, shortened};
use crate::file::decode::path_step::{PathStep, path_steps};
use crate::file::decode::quantity::LENGTH;
use crate::file::decode::tree::{Entry, Node, Value, in_memory};
use crate::file::scene::scene_file::Scene;

/// A scene whose numbers can be changed many times. It is turned into a tree once; each change decodes a copy of the
/// tree, so numbers keep the same ranges as in a file.
#[derive(Clone, Debug)]
pub struct VariableScene {
    scene: Scene,
    tree: Node,
}

/// A number of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct VariableAddress {
    path: String,
    steps: Vec<PathStep>,
    /// Whether the design changes one over the number: a radius passes through infinity.
    inverse: bool,
}

impl VariableScene {
    /// A scene as it is at first.
    ///
    /// # Errors
    /// A number that TOML cannot hold.
    pub fn new(scene: &Scene) -> Result<Self, Fault> {
        Ok(Self {
            scene: scene.clone(),
            tree: tree(scene)?,
        })
    }

    /// The scene as it is at first.
    pub(crate) fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene with these values of what a design changes; its arrays are kept.
    ///
    /// # Errors
    /// A scene that is none with these parameters.
    pub(crate) fn with_parameters(
        &self,
        addresses: &[VariableAddress],
        values: &[f64],
    ) -> Result<Scene, Fault> {
        let mut tree = self.tree.clone();
        for (address, value) in addresses.iter().zip(values) {
            if let Some(number) = address.number_mut(&mut tree) {
                *number = address.written(*value).into();
            }
        }
        changed(&self.scene, &tree)
    }

    /// The fault of a path that leads to no number.
    fn unknown(&self, path: &str, at: &str) -> Fault {
        let expected = "the path of a number of this scene, such as element[1].thickness_mm";
        let found = format!("'{}'", shortened(path));
        let fault = self.scene.fault(at, found, expected);
        if path.contains("radius") {
            return fault.hint("a plane's curvature varies where it is written as radius_mm = inf");
        }
        if let Some((place, glass)) = self.named_medium(path) {
            return fault.hint(format!(
                "{place} is \"{glass}\" of the catalogue, whose index follows from its formula and is no number of the \
                 scene; with {place} = {{ index = 1.5 }} the path is {place}.index"
            ));
        }
        let mut known = Vec::new();
        collect(&self.tree, "", &mut known);
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        match nearest(path, &known) {
            Some(near) => fault.hint(format!("did you mean {near}?")),
            None => fault,
        }
    }
}

/// Keys of elements and surfaces that hold a medium.
const MEDIA: [&str; 2] = ["glass", "medium"];

impl VariableScene {
    /// The medium of the catalogue to which the path of an index leads: where it stands, and its name.
    fn named_medium(&self, path: &str) -> Option<(String, &str)> {
        let parent = path.strip_suffix(".index").unwrap_or(path);
        let inside = MEDIA.map(|key| format!("{parent}.{key}"));
        let places = std::iter::once(parent.to_owned()).chain(inside);
        let mut named = places.filter_map(|place| {
            let name = self.text_at(&place)?;
            Some((place, name))
        });
        named.find(|(place, _)| MEDIA.iter().any(|key| place.ends_with(key)))
    }

    /// The text at a path.
    fn text_at(&self, path: &str) -> Option<&str> {
        let steps: Option<Vec<PathStep>> = path_steps(path).collect();
        match &node_at(&self.tree, &steps?)?.value {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }
}

/// The node to which these steps lead.
fn node_at<'t>(tree: &'t Node, steps: &[PathStep]) -> Option<&'t Node> {
    let mut node = tree;
    for step in steps {
        node = match (step, &node.value) {
            (PathStep::Key(key), table) => table.get(key)?,
            (PathStep::Index(index), Value::List(list)) => list.get(*index)?,
            _ => return None,
        };
    }
    Some(node)
}

/// The paths of all numbers in a tree.
fn collect(node: &Node, path: &str, paths: &mut Vec<String>) {
    match &node.value {
        Value::Table(entries) => {
            for Entry { key, node, .. } in entries {
                let dot = if path.is_empty() { "" } else { "." };
                collect(node, &format!("{path}{dot}{key}"), paths);
            }
        }
        Value::List(list) => {
            for (i, node) in list.iter().enumerate() {
                collect(node, &format!("{path}[{i}]"), paths);
            }
        }
        Value::Integer(_) | Value::Float { .. } => paths.push(path.to_owned()),
        _ => {}
    }
}

impl VariableAddress {
    /// The number at a path such as `element[1].surface[0].radius_mm`.
    ///
    /// # Errors
    /// A path that leads to no number, reported at the field `at` of the scene.
    pub fn new(scene: &VariableScene, path: &str, at: &str) -> Result<Self, Fault> {
        let refuse = || scene.unknown(path, at);
        let steps: Option<Vec<_>> = path_steps(path).collect();
        let steps = steps.ok_or_else(refuse)?;
        let inverse = matches!(steps.last(), Some(PathStep::Key(key)) if key.starts_with("radius"));
        let address = Self {
            path: path.to_owned(),
            steps,
            inverse,
        };
        address.number(&scene.tree).ok_or_else(refuse)?;
        Ok(address)
    }

    /// What the design calls it.
    pub(crate) fn name(&self) -> String {
        match self.inverse {
            true => format!("1/{}", self.path),
            false => self.path.clone(),
        }
    }

    /// The value that the design changes; zero where the scene has no such number.
    pub fn value(&self, scene: &VariableScene) -> f64 {
        let found = self.number(&scene.tree).unwrap_or(0.0);
        if self.inverse { 1.0 / found } else { found }
    }

    /// The bounds of the value that the design changes, from those of the number; none where no number keeps them
    /// or, for a radius, where they do not lie on one side of zero.
    pub(crate) fn bounds(&self, [lowest, highest]: [Option<f64>; 2]) -> Option<[f64; 2]> {
        let (free, ends) = (f64::INFINITY, [lowest, highest]);
        let bounds = match (self.inverse, ends) {
            (_, [None, None]) => [-free, free],
            (false, _) => [lowest.unwrap_or(-free), highest.unwrap_or(free)],
            (true, [Some(low), Some(high)]) if low * high > 0.0 => [1.0 / high, 1.0 / low],
            (true, _) => return None,
        };
        (bounds[0] <= bounds[1]).then_some(bounds)
    }

    /// The number as the scene has it; a radius beyond every length is that of a plane.
    fn written(&self, value: f64) -> f64 {
        if !self.inverse {
            return value;
        }
        let radius = 1.0 / value;
        match radius.abs() > LENGTH {
            true => f64::INFINITY.copysign(radius),
            false => radius,
        }
    }

    /// The number in a tree.
    fn number(&self, tree: &Node) -> Option<f64> {
        match node_at(tree, &self.steps)?.value {
            Value::Integer(number) => Some(number as f64),
            Value::Float { value, .. } => Some(value),
            _ => None,
        }
    }

    /// The number in a tree, to be changed.
    fn number_mut<'t>(&self, tree: &'t mut Node) -> Option<&'t mut Value> {
        let mut node = tree;
        for step in &self.steps {
            node = match (step, &mut node.value) {
                (PathStep::Key(key), table) => table.get_mut(key)?,
                (PathStep::Index(index), Value::List(list)) => list.get_mut(*index)?,
                _ => return None,
            };
        }
        let value = &mut node.value;
        matches!(value, Value::Integer(_) | Value::Float { .. }).then_some(value)
    }
}

/// The scene with some other settings, as the table `[settings]` of a scene file has them; its arrays are kept.
///
/// # Errors
/// A setting that is none, or has a value that it cannot have.
pub fn with_settings(scene: &Scene, settings: Vec<Entry>) -> Result<Scene, Fault> {
    let mut all = tree(scene)?;
    if let Some(Value::Table(own)) = all.value.get_mut("settings").map(|node| &mut node.value) {
        own.retain(|old| settings.iter().all(|new| new.key != old.key));
        own.extend(settings);
    }
    changed(scene, &all)
}

/// The scene of a changed tree, with the arrays and the text of the one it was.
fn changed(scene: &Scene, tree: &Node) -> Result<Scene, Fault> {
    let mut changed = Scene::from_tree(tree, scene.origin.clone())?;
    changed.arrays = scene.arrays.clone();
    Ok(changed)
}

/// The tree of a scene.
fn tree(scene: &Scene) -> Result<Node, Fault> {
    let table = Table::try_from(scene).map_err(|error| {
        Fault::of_file(
            &scene.origin.file,
            error.to_string(),
            "values TOML can hold",
        )
    })?;
    Ok(in_memory(table).into())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::file::decode::origin::Origin;
    use crate::file::decode::tree::{Entry, Value};
    use crate::file::scene::scene_file::Scene;
    use crate::file::scene::scene_test::SCENE;
    use crate::file::scene::variable::{VariableAddress, VariableScene, collect, with_settings};

    fn scene() -> VariableScene {
        let scene = Scene::parse(SCENE, Path::new("demo.toml")).unwrap();
        VariableScene::new(&scene).unwrap()
    }

    #[test]
    fn numbers_change_as_they_do_in_a_text() {
        let scene = scene();
        let mut paths = Vec::new();
        collect(&scene.tree, "", &mut paths);
        let mut accepted = 0;
        for path in &paths {
            let address = [VariableAddress::new(&scene, path, "element").unwrap()];
            let value = address[0].value(&scene) * (1.0 + f64::EPSILON);
            let Ok(changed) = scene.with_parameters(&address, &[value]) else {
                continue;
            };
            let text = changed.to_toml().unwrap();
            let mut read = Scene::parse(&text, Path::new("demo.toml")).unwrap();
            read.origin = changed.origin.clone();
            assert_eq!(read, changed, "{path}");
            let written = address[0].value(&VariableScene::new(&changed).unwrap());
            let (found, expected) = (written, address[0].written(value));
            let expected = if address[0].inverse {
                1.0 / expected
            } else {
                expected
            };
            assert_eq!(found.to_bits(), expected.to_bits(), "{path}");
            accepted += 1;
        }
        assert!(accepted > 10, "{accepted} of {} numbers", paths.len());
    }

    #[test]
    fn faults_of_a_changed_number_are_reported_at_its_key() {
        let scene = scene();
        let path = "element[0].thickness_mm";
        let address = [VariableAddress::new(&scene, path, "element").unwrap()];
        for (value, found, expected) in [
            (
                -1.5,
                "-1.5",
                "zero or more: no mirror has turned the light back",
            ),
            (
                1e13,
                "10000000000000.0",
                "a length of magnitude up to 1e12 mm",
            ),
            (f64::NAN, "nan", "a finite number"),
        ] {
            let fault = scene.with_parameters(&address, &[value]).unwrap_err();
            assert_eq!(
                (fault.found.as_str(), fault.expected.as_str()),
                (found, expected)
            );
            assert_eq!(fault.address.path, path);
            assert_eq!(fault.address.file, Path::new("demo.toml"));
            let line = fault.address.excerpt.map(|excerpt| excerpt.text);
            assert!(line.is_some_and(|line| line.starts_with("thickness_mm")));
        }
        let fault = VariableAddress::new(&scene, "element[0].thicknes_mm", "element").unwrap_err();
        assert_eq!(
            fault.hint.as_deref(),
            Some("did you mean element[0].thickness_mm?")
        );
    }

    /// The index of a glass of the catalogue is no number of the scene, whichever way its path is written.
    #[test]
    fn the_index_of_a_catalogue_glass_is_explained() {
        let text = "version = 1\nwavelength_um = 0.5\nsource = { kind = 'plane' }\n\
            [[element]]\nkind = 'lens'\nthickness_mm = 9\n\
            surface = [{ radius_mm = 5, thickness_mm = 1, glass = 'N-BK7', semi_aperture_mm = 1 }, \
            { semi_aperture_mm = 1 }]\n\
            [[element]]\nkind = 'sensor'\npixels = [8, 8]\npitch_um = 10\n";
        let scene =
            Scene::parse(text, Path::new("lens.toml")).unwrap_or_else(|fault| panic!("{fault}"));
        let scene = VariableScene::new(&scene).unwrap();
        for path in ["glass.index", "index", "glass"] {
            let path = format!("element[0].surface[0].{path}");
            let fault = VariableAddress::new(&scene, &path, "element").unwrap_err();
            let hint = fault.hint.unwrap_or_default();
            assert!(
                hint.contains("N-BK7") && hint.contains("surface[0].glass.index"),
                "{path}: {hint}"
            );
        }
    }

    #[test]
    fn settings_replace_those_of_the_scene() {
        let scene = Scene {
            origin: Origin::default(),
            ..scene().scene().clone()
        };
        let target = || vec![Entry::new("target_error", Value::from(1e-2))];
        let changed = with_settings(&scene, target()).unwrap();
        assert_eq!(changed.settings.target_error, 1e-2);
        assert_eq!(changed.element, scene.element);
        let method = vec![Entry::new("method", Value::Text(String::from("beam")))];
        let fault = with_settings(&scene, method).unwrap_err();
        let message = fault.to_string();
        assert!(
            message.starts_with("input: settings.method: found \"beam\", expected one of"),
            "{message}"
        );
    }
}
