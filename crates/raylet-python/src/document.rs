//! Documents of Python as trees that the library decodes.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString};
use raylet::file::decode::tree::{Entry, Value};

use crate::refusal::error;

/// How deep tables and lists may lie in each other; the package refuses fewer levels.
const MOST_LEVELS: usize = 100;

/// The entries of a dictionary of plain values, in its order.
///
/// # Errors
/// RayletError for values that lie too deep, TypeError for a value that is not plain.
pub(crate) fn entries(table: &Bound<'_, PyDict>) -> PyResult<Vec<Entry>> {
    entries_at(table, 0)
}

fn entries_at(table: &Bound<'_, PyDict>, level: usize) -> PyResult<Vec<Entry>> {
    let entry = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        Ok(Entry::new(
            key.extract::<String>()?,
            value_at(&value, level + 1)?,
        ))
    };
    table.iter().map(entry).collect()
}

fn value_at(value: &Bound<'_, PyAny>, level: usize) -> PyResult<Value> {
    if level > MOST_LEVELS {
        let message = format!("a value more than {MOST_LEVELS} lists or tables deep");
        return Err(error(value.py(), message));
    }
    // A truth value is a whole number too.
    if let Ok(truth) = value.cast::<PyBool>() {
        return Ok(Value::Truth(truth.is_true()));
    }
    if let Ok(number) = value.cast::<PyInt>() {
        return Ok(match number.extract::<i64>() {
            Ok(number) => Value::Integer(number),
            Err(_) => Value::LongInteger(number.str()?.extract()?),
        });
    }
    if let Ok(number) = value.cast::<PyFloat>() {
        return Ok(number.value().into());
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::Text(text.extract()?));
    }
    if let Ok(list) = value.cast::<PyList>() {
        let node = |value: Bound<'_, PyAny>| Ok(value_at(&value, level + 1)?.into());
        return Ok(Value::List(list.iter().map(node).collect::<PyResult<_>>()?));
    }
    if let Ok(table) = value.cast::<PyDict>() {
        return Ok(Value::Table(entries_at(table, level)?));
    }
    let found = value.get_type().name()?;
    let message = format!("{found}, expected a number, text, list or table");
    Err(PyTypeError::new_err(message))
}
