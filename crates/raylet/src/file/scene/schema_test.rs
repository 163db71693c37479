//! The JSON Schema of a scene file against good and bad scenes.

use serde_json::Value;

use crate::file::scene::scene_file::schema;
use crate::file::scene::scene_test::{SCENE, altered};
use crate::file::scene::surfaces_test;

/// Whether a value fits a schema, in the few words of JSON Schema that ours uses.
fn fits(schema: &Value, value: &Value, root: &Value) -> bool {
    if let Some(name) = schema["$ref"]
        .as_str()
        .and_then(|r| r.strip_prefix("#/$defs/"))
        && !fits(&root["$defs"][name], value, root)
    {
        return false;
    }
    let choices = |key: &str| {
        schema[key]
            .as_array()
            .map(|list| list.iter().filter(|s| fits(s, value, root)).count())
    };
    let right_type = |name: &str| match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        "boolean" => value.is_boolean(),
        _ => value.is_null(),
    };
    let types = match &schema["type"] {
        Value::String(name) => right_type(name),
        Value::Array(names) => names.iter().filter_map(Value::as_str).any(right_type),
        _ => true,
    };
    let object = value.as_object().is_none_or(|map| {
        let required = schema["required"].as_array().is_none_or(|keys| {
            keys.iter()
                .filter_map(Value::as_str)
                .all(|key| map.contains_key(key))
        });
        let known = map
            .iter()
            .all(|(key, inner)| match schema["properties"].get(key) {
                Some(property) => fits(property, inner, root),
                None => schema["additionalProperties"] != Value::Bool(false),
            });
        required && known
    });
    let items = value
        .as_array()
        .is_none_or(|list| match schema.get("items") {
            Some(item) => list.iter().all(|inner| fits(item, inner, root)),
            None => true,
        });
    let constant = schema.get("const").is_none_or(|only| only == value);
    let listed = schema["enum"]
        .as_array()
        .is_none_or(|list| list.contains(value));
    types
        && object
        && items
        && constant
        && listed
        && choices("oneOf").is_none_or(|count| count == 1)
        && choices("anyOf").is_none_or(|count| count > 0)
}

/// A TOML text as JSON, with infinities as large numbers.
fn json(text: &str) -> Value {
    let text = text.replace("-inf", "-1e300");
    let table: toml::Table = toml::from_str(&text).expect("TOML");
    serde_json::to_value(table).expect("JSON")
}

#[test]
fn schema_distinguishes_good_scenes_from_bad_ones() {
    let schema = schema();
    assert!(fits(&schema, &json(SCENE), &schema));
    for (from, to) in [
        ("seed =", "sead ="),
        ("radius_mm = 25.8", "raduis_mm = 25.8"),
        ("kind = \"lens\"", "kind = \"lense\""),
        ("kind = \"vortex\", charge", "kind = \"vortex\", charges"),
        ("disc =", "disk ="),
        ("pixels = [64, 32]\n", ""),
        ("method = \"beamlet\"", "method = \"beam\""),
        ("thickness_mm = 3.0", "thickness_mm = \"3 mm\""),
    ] {
        assert!(!fits(&schema, &json(&altered(from, to)), &schema), "{to}");
    }
}

#[test]
fn schema_knows_every_shape_and_aperture() {
    let schema = schema();
    assert!(fits(&schema, &json(surfaces_test::SCENE), &schema));
    for (from, to) in [
        ("kind = \"biconic\"", "kind = \"biconc\""),
        ("rotation_radius_mm", "rotation_mm"),
        ("straight_along = \"x\"", "straight_along = \"z\""),
        ("x = 2, height_um = 5", "x = 2"),
        ("sides = 6", "side = 6"),
        ("blocked = [{ disc", "blocked = [{ disk"),
        ("focal_length_mm = 80\n", ""),
    ] {
        let text = surfaces_test::SCENE;
        assert!(text.contains(from), "{from}");
        assert!(
            !fits(&schema, &json(&text.replacen(from, to, 1)), &schema),
            "{to}"
        );
    }
}

/// Every property of an object in the schema, with where it stands.
fn properties<'s>(schema: &'s Value, place: &str, into: &mut Vec<(String, &'s Value)>) {
    if let Some(map) = schema.as_object() {
        for (key, inner) in map {
            let place = format!("{place}/{key}");
            if let Some(list) = inner.as_object().filter(|_| key == "properties") {
                into.extend(list.iter().map(|(name, p)| (format!("{place}/{name}"), p)));
            }
            properties(inner, &place, into);
        }
    }
    for (i, inner) in schema.as_array().into_iter().flatten().enumerate() {
        properties(inner, &format!("{place}/{i}"), into);
    }
}

#[test]
fn schema_describes_every_key() {
    let schema = schema();
    let mut all = Vec::new();
    properties(&schema, "", &mut all);
    assert!(all.len() > 100, "{}", all.len());
    for (place, property) in all {
        let described = property["description"].is_string() || property["const"].is_string();
        assert!(described, "{place}");
    }
}
