//! Refusals of the library as Python exceptions.

use std::fmt::Display;

use pyo3::PyErr;
use pyo3::prelude::*;
use raylet::file::decode::fault::Fault;

pyo3::import_exception!(raylet._refusal, RayletError);

/// The exception of a fault.
pub(crate) fn fault(py: Python<'_>, fault: &Fault) -> PyErr {
    let hint = fault.hint.clone().unwrap_or_default();
    let parts = [&fault.address.path, &fault.found, &fault.expected, &hint];
    with_attributes(py, fault.to_string(), parts.map(String::as_str))
}

/// The exception of anything else that the library refuses.
pub(crate) fn error(py: Python<'_>, error: impl Display) -> PyErr {
    with_attributes(py, error.to_string(), [""; 4])
}

fn with_attributes(py: Python<'_>, message: String, parts: [&str; 4]) -> PyErr {
    let error = RayletError::new_err(message);
    let names = ["path", "found", "expected", "hint"];
    for (name, text) in names.into_iter().zip(parts) {
        if let Err(failure) = error.value(py).setattr(name, text) {
            return failure;
        }
    }
    error
}
