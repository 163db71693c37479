//! What elements are called: by their names, or by their places where they have none.

use crate::file::decode::decode_error::nearest;
use crate::file::decode::fault::{Fault, shortened};
use crate::file::scene::element::{Element, WITH_PIXELS};
use crate::file::scene::scene_file::Scene;

impl Scene {
    /// What the element of a number is called: its name, or its place, such as `element[0]`, if it has none.
    pub(crate) fn element_name(&self, number: usize) -> String {
        let name = self.element.get(number).and_then(Element::name);
        name.map_or_else(|| format!("element[{number}]"), str::to_owned)
    }

    /// The number of the element of this name.
    pub(crate) fn number_of(&self, name: &str) -> Option<usize> {
        (0..self.element.len()).find(|number| self.element_name(*number) == name)
    }

    /// The fault of a field that names an element which is not there.
    pub(crate) fn nameless(&self, path: &str, given: &str) -> Fault {
        let names: Vec<String> = (0..self.element.len())
            .map(|i| self.element_name(i))
            .collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let found = format!("\"{}\", which no element is called", shortened(given));
        let fault = self.fault(path, found, WITH_PIXELS);
        match nearest(given, &names) {
            Some(name) => fault.hint(format!("did you mean \"{name}\"?")),
            None => fault,
        }
    }
}
