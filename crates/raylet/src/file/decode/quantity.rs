//! What a value of a scene measures, by the end of its key, and the magnitude or length it keeps.
//!
//! Every key names its unit: `thickness_mm`, `pitch_um`, `tilt_deg`. So one table gives every number under a key,
//! however deep in lists, its largest magnitude, and no key can be forgotten. Fields with a tighter meaning have
//! their own range beside it, in `number.rs`.

use std::fmt;

use serde_json::Value;

/// The largest magnitude of a length in mm: a million kilometres.
pub(crate) const LENGTH: f64 = 1e12;

/// A kind of number with its largest magnitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quantity {
    /// What it is, in words.
    name: &'static str,
    /// Its unit, with a blank before it.
    unit: &'static str,
    /// The largest magnitude in this unit.
    pub(crate) largest: f64,
    /// The most bytes of a text that stands in its place.
    pub(crate) longest: usize,
}

/// Keys that name no unit because theirs is another in each place: coefficients of powers of a length, and what
/// means any number of the scene.
const OF_ANY_UNIT: [&str; 5] = ["aspheric", "coefficients", "scale", "lowest", "highest"];

/// Whole numbers without a meaning as a magnitude.
const OF_NO_MAGNITUDE: [&str; 1] = ["seed"];

/// Keys whose texts may be as long as the path of a file; others are names.
const LONG_TEXTS: [&str; 9] = [
    "title",
    "phase",
    "amplitude",
    "transmission",
    "samples",
    "height_um",
    "target",
    "picture",
    "mask",
];
const LONG: usize = 4096;
const NAME: usize = 200;

impl Quantity {
    /// The quantity of the numbers under a key.
    pub(crate) fn of_key(key: &str) -> Self {
        let longest = if LONG_TEXTS.contains(&key) {
            LONG
        } else {
            NAME
        };
        let quantity = |name, unit, largest| Self {
            name,
            unit,
            largest,
            longest,
        };
        match key.rsplit('_').next() {
            Some("mm") => quantity("a length", " mm", LENGTH),
            Some("um") => quantity("a length", " µm", 1e3 * LENGTH),
            Some("deg") => quantity("an angle", " degrees", 3600.0),
            Some("mb") => quantity("an amount of memory", " MB", 1e12),
            _ if OF_NO_MAGNITUDE.contains(&key) => quantity("a number", "", f64::INFINITY),
            _ if OF_ANY_UNIT.contains(&key) => quantity("a number", "", 1e100),
            _ => quantity("a number", "", 1e12),
        }
    }

    /// Whether a number is infinite, which only some fields take, or keeps the magnitude.
    pub(crate) fn admits(&self, value: f64) -> bool {
        !value.is_finite() || value.abs() <= self.largest
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            name,
            unit,
            largest,
            ..
        } = self;
        write!(f, "{name} of magnitude up to {largest:e}{unit}")
    }
}

/// Gives the numbers of a JSON Schema, by the keys of its properties, the bounds that they have not yet.
pub(crate) fn bound(schema: &mut Value) {
    if let Some(Value::Object(properties)) = schema.get_mut("properties") {
        for (key, property) in properties {
            bound_numbers(property, Quantity::of_key(key));
        }
    }
    inner(schema).for_each(bound);
}

/// The same for one property: a number, or lists of numbers.
fn bound_numbers(property: &mut Value, quantity: Quantity) {
    let is_number = |kind: &Value| kind == "number" || kind == "integer";
    let numeric = match &property["type"] {
        Value::Array(kinds) => kinds.iter().any(is_number),
        kind => is_number(kind),
    };
    if let Some(keys) = property
        .as_object_mut()
        .filter(|_| numeric && quantity.largest.is_finite())
    {
        let has = |keys: &serde_json::Map<String, Value>, words: [&str; 3]| {
            words.iter().any(|word| keys.contains_key(*word))
        };
        if !has(keys, ["maximum", "exclusiveMaximum", "const"]) {
            keys.insert(String::from("maximum"), quantity.largest.into());
        }
        if !has(keys, ["minimum", "exclusiveMinimum", "const"]) {
            keys.insert(String::from("minimum"), (-quantity.largest).into());
        }
    }
    for part in ["items", "anyOf", "prefixItems"] {
        match property.get_mut(part) {
            Some(Value::Array(list)) => {
                list.iter_mut().for_each(|one| bound_numbers(one, quantity))
            }
            Some(one) => bound_numbers(one, quantity),
            None => {}
        }
    }
}

/// Everything that a value holds.
fn inner(value: &mut Value) -> Box<dyn Iterator<Item = &mut Value> + '_> {
    match value {
        Value::Object(map) => Box::new(map.values_mut()),
        Value::Array(list) => Box::new(list.iter_mut()),
        _ => Box::new(std::iter::empty()),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use crate::file::decode::quantity::{Quantity, bound};

    #[test]
    fn units_at_the_end_of_keys_give_ranges() {
        for (key, most) in [
            ("thickness_mm", 1e12),
            ("pitch_um", 1e15),
            ("tilt_deg", 3600.0),
            ("conic", 1e12),
            ("aspheric", 1e100),
        ] {
            let quantity = Quantity::of_key(key);
            assert!(quantity.admits(most) && quantity.admits(-most), "{key}");
            assert!(!quantity.admits(1.001 * most), "{key}");
            assert!(
                quantity.admits(f64::INFINITY),
                "{key}: for the field to judge"
            );
        }
        assert!(Quantity::of_key("seed").admits(9.2e18));
        assert!(Quantity::of_key("name").longest < Quantity::of_key("phase").longest);
        let words = Quantity::of_key("radius_mm").to_string();
        assert_eq!(words, "a length of magnitude up to 1e12 mm");
    }

    #[test]
    fn schemas_have_the_same_ranges() {
        let number = json!({ "type": "number" });
        let share = json!({ "type": ["number", "null"], "minimum": 0, "exclusiveMaximum": 1 });
        let list = json!({ "type": "array", "items": number });
        let mut schema = json!({ "properties": { "x_mm": number, "share": share, "at_um": list } });
        bound(&mut schema);
        let properties = &schema["properties"];
        assert_eq!(
            properties["x_mm"],
            json!({ "type": "number", "minimum": -1e12, "maximum": 1e12 })
        );
        assert_eq!(properties["share"], share);
        assert_eq!(properties["at_um"]["items"]["maximum"], json!(1e15));
    }
}
