//! Numbers of a scene by their address, so that a design may change any of them.

use toml::{Table, Value};

use crate::file::decode::decode_error::nearest;
use crate::file::decode::fault::{Fault, shortened};
use crate::file::decode::quantity::LENGTH;
use crate::file::scene::scene_file::Scene;

/// A number of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Address {
    path: String,
    steps: Vec<Step>,
    /// Whether the design changes one over the number: a radius passes through infinity.
    inverse: bool,
}

/// The fault of a path that leads to no number.
fn unknown(scene: &Scene, path: &str, at: &str) -> Fault {
    let expected = "the path of a number of this scene, such as element[1].thickness_mm";
    let fault = scene.fault(at, format!("'{}'", shortened(path)), expected);
    if path.contains("radius") {
        return fault.hint("a plane's curvature varies where it is written as radius_mm = inf");
    }
    let mut known = Vec::new();
    if let Ok(table) = table(scene) {
        collect(&Value::Table(table), "", &mut known);
    }
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    match nearest(path, &known) {
        Some(near) => fault.hint(format!("did you mean {near}?")),
        None => fault,
    }
}

/// The paths of all numbers in a value.
fn collect(value: &Value, path: &str, paths: &mut Vec<String>) {
    match value {
        Value::Table(table) => {
            for (key, value) in table {
                let dot = if path.is_empty() { "" } else { "." };
                collect(value, &format!("{path}{dot}{key}"), paths);
            }
        }
        Value::Array(list) => {
            for (i, value) in list.iter().enumerate() {
                collect(value, &format!("{path}[{i}]"), paths);
            }
        }
        Value::Integer(_) | Value::Float(_) => paths.push(path.to_owned()),
        _ => {}
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Step {
    Key(String),
    Index(usize),
}

impl Address {
    /// The number at a path such as `element[1].surface[0].radius_mm`.
    ///
    /// # Errors
    /// A path that leads to no number, told at the field `at` of the scene.
    pub fn new(scene: &Scene, path: &str, at: &str) -> Result<Self, Fault> {
        let refuse = || unknown(scene, path, at);
        let steps = steps(path).ok_or_else(refuse)?;
        let inverse = matches!(steps.last(), Some(Step::Key(key)) if key.starts_with("radius"));
        let address = Self {
            path: path.to_owned(),
            steps,
            inverse,
        };
        let mut table = table(scene)?;
        address.number(&mut table).ok_or_else(refuse)?;
        Ok(address)
    }

    /// What the design calls it.
    pub fn name(&self) -> String {
        match self.inverse {
            true => format!("1/{}", self.path),
            false => self.path.clone(),
        }
    }

    /// The value that the design changes.
    ///
    /// # Errors
    /// As [`Address::new`].
    pub fn value(&self, scene: &Scene) -> Result<f64, Fault> {
        let mut table = table(scene)?;
        let found = self.number(&mut table).map_or(0.0, |value| match value {
            Value::Integer(number) => *number as f64,
            Value::Float(number) => *number,
            _ => 0.0,
        });
        Ok(if self.inverse { 1.0 / found } else { found })
    }

    /// The bounds of the value that the design changes, from those of the number; none where no number keeps them
    /// or, for a radius, where they do not lie on one side of zero.
    pub fn bounds(&self, [lowest, highest]: [Option<f64>; 2]) -> Option<[f64; 2]> {
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

    fn number<'t>(&self, table: &'t mut Table) -> Option<&'t mut Value> {
        let Some((Step::Key(first), rest)) = self.steps.split_first() else {
            return None;
        };
        let mut value = table.get_mut(first)?;
        for step in rest {
            value = match step {
                Step::Key(key) => value.as_table_mut()?.get_mut(key)?,
                Step::Index(index) => value.as_array_mut()?.get_mut(*index)?,
            };
        }
        (value.is_float() || value.is_integer()).then_some(value)
    }
}

/// The scene with these values of what a design changes; its arrays are kept.
///
/// # Errors
/// A scene that is none with these numbers.
pub fn with_numbers(scene: &Scene, addresses: &[Address], values: &[f64]) -> Result<Scene, Fault> {
    let mut table = table(scene)?;
    for (address, value) in addresses.iter().zip(values) {
        if let Some(number) = address.number(&mut table) {
            *number = Value::Float(address.written(*value));
        }
    }
    reread(scene, &table)
}

/// The scene with some other settings, as the table `[settings]` of a scene file has them; its arrays are kept.
///
/// # Errors
/// A setting that is none, or has a value that it cannot have.
pub fn with_settings(scene: &Scene, settings: &Table) -> Result<Scene, Fault> {
    let mut all = table(scene)?;
    let own = all.entry("settings").or_insert_with(|| Table::new().into());
    if let Value::Table(own) = own {
        own.extend(settings.clone());
    }
    reread(scene, &all)
}

/// The scene of a changed table, with the arrays of the one it was.
fn reread(scene: &Scene, table: &Table) -> Result<Scene, Fault> {
    let file = &scene.origin.file;
    let text = toml::to_string(table)
        .map_err(|error| Fault::of_file(file, error.to_string(), "values TOML can hold"))?;
    let mut changed = Scene::parse(&text, file)?;
    changed.arrays = scene.arrays.clone();
    Ok(changed)
}

fn table(scene: &Scene) -> Result<Table, Fault> {
    Table::try_from(scene).map_err(|error| {
        Fault::of_file(
            &scene.origin.file,
            error.to_string(),
            "values TOML can hold",
        )
    })
}

/// `a[1].b` as key, index, key; nothing when it is no path.
fn steps(path: &str) -> Option<Vec<Step>> {
    let mut steps = Vec::new();
    for part in path.split('.') {
        let (key, indices) = match part.find('[') {
            Some(at) => part.split_at(at),
            None => (part, ""),
        };
        if key.is_empty() {
            return None;
        }
        steps.push(Step::Key(key.to_owned()));
        let mut rest = indices;
        while !rest.is_empty() {
            let (index, after) = rest.strip_prefix('[')?.split_once(']')?;
            steps.push(Step::Index(index.parse().ok()?));
            rest = after;
        }
    }
    Some(steps)
}
