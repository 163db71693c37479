//! Arrays and dictionaries that declare their Python types; type stubs are made of these.

use std::ops::Deref;

use num_complex::Complex64;
use numpy::ndarray::{Array, ArrayViewMut, Dimension};
use numpy::{Element, PyArray, PyReadonlyArray, PyReadwriteArray};
use pyo3::exceptions::PyValueError;
use pyo3::inspect::PyStaticExpr;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use pyo3::{type_hint_identifier, type_hint_subscript};

use crate::refusal::error;

/// A kind of number that NumPy knows.
pub(crate) trait Number: Element + Copy {
    /// Its name in Python.
    const HINT: PyStaticExpr;

    /// Whether it is neither infinite nor NaN.
    fn is_number(self) -> bool;
}

/// Declares a kind of number by its name in Python and its test for finite values.
macro_rules! number {
    ($kind:ty, $name:literal, $is_number:expr) => {
        impl Number for $kind {
            const HINT: PyStaticExpr = type_hint_identifier!("numpy", $name);
            fn is_number(self) -> bool {
                $is_number(self)
            }
        }
    };
}

number!(f64, "float64", f64::is_finite);
number!(Complex64, "complex128", Complex64::is_finite);
number!(i64, "int64", |_| true);
number!(u8, "uint8", |_| true);

const NDARRAY: PyStaticExpr = type_hint_identifier!("numpy.typing", "NDArray");
const ANY: PyStaticExpr = type_hint_identifier!("typing", "Any");
const STRING: PyStaticExpr = type_hint_identifier!("builtins", "str");

/// An array that Python lends to a call.
pub(crate) struct Given<'py, T: Element, D: Dimension>(PyReadonlyArray<'py, T, D>);

impl<'py, T: Element, D: Dimension> Deref for Given<'py, T, D> {
    type Target = PyReadonlyArray<'py, T, D>;
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl<'a, 'py, T: Number + 'a, D: Dimension + 'a> FromPyObject<'a, 'py> for Given<'py, T, D> {
    type Error = <PyReadonlyArray<'py, T, D> as FromPyObject<'a, 'py>>::Error;
    const INPUT_TYPE: PyStaticExpr = type_hint_subscript!(NDARRAY, T::HINT);
    fn extract(object: Borrowed<'a, 'py, PyAny>) -> Result<Self, Self::Error> {
        object.extract().map(Self)
    }
}

/// An array that Python lends to be written.
pub(crate) struct Filled<'py, T: Element, D: Dimension>(PyReadwriteArray<'py, T, D>);

impl<'py, T: Element, D: Dimension> Filled<'py, T, D> {
    /// Its memory, if it has this shape and its numbers stand in order.
    ///
    /// # Errors
    /// ValueError for another.
    pub(crate) fn as_shape(&mut self, shape: D) -> PyResult<ArrayViewMut<'_, T, D>> {
        let view = self.0.as_array_mut();
        match view.raw_dim() == shape && view.is_standard_layout() {
            true => Ok(view),
            false => {
                let (found, expected) = (view.raw_dim().into_pattern(), shape.into_pattern());
                let message =
                    format!("an array {found:?} to be written, expected {expected:?} in order");
                Err(PyValueError::new_err(message))
            }
        }
    }
}

impl<'a, 'py, T: Number + 'a, D: Dimension + 'a> FromPyObject<'a, 'py> for Filled<'py, T, D> {
    type Error = <PyReadwriteArray<'py, T, D> as FromPyObject<'a, 'py>>::Error;
    const INPUT_TYPE: PyStaticExpr = type_hint_subscript!(NDARRAY, T::HINT);
    fn extract(object: Borrowed<'a, 'py, PyAny>) -> Result<Self, Self::Error> {
        object.extract().map(Self)
    }
}

/// An array that was made here; its memory becomes NumPy's.
pub(crate) struct Made<'py, T, D>(Bound<'py, PyArray<T, D>>);

impl<'py, T: Number, D: Dimension> Made<'py, T, D> {
    /// An array of results: the one door through which they leave the library.
    ///
    /// # Errors
    /// RayletError for values that are not finite.
    pub(crate) fn new(py: Python<'py>, array: Array<T, D>) -> PyResult<Self> {
        match array.iter().all(|value| value.is_number()) {
            true => Ok(Self::with_gaps(py, array)),
            false => Err(not_finite(py)),
        }
    }

    /// An array in which NaN marks missing values.
    pub(crate) fn with_gaps(py: Python<'py>, array: Array<T, D>) -> Self {
        Self(PyArray::from_owned_array(py, array))
    }
}

/// The refusal of results that are no numbers.
fn not_finite(py: Python<'_>) -> PyErr {
    error(
        py,
        "a result that is not finite, expected sizes, distances and amplitudes that lie less far apart",
    )
}

/// Numbers of results.
///
/// # Errors
/// RayletError for one that is not finite.
pub(crate) fn finite<'a>(
    py: Python<'_>,
    values: impl IntoIterator<Item = &'a f64>,
) -> PyResult<()> {
    match { values }.into_iter().all(|value| value.is_finite()) {
        true => Ok(()),
        false => Err(not_finite(py)),
    }
}

impl<'py, T: Number, D: Dimension> IntoPyObject<'py> for Made<'py, T, D> {
    type Target = PyArray<T, D>;
    type Output = Bound<'py, Self::Target>;
    type Error = std::convert::Infallible;
    const OUTPUT_TYPE: PyStaticExpr = type_hint_subscript!(NDARRAY, T::HINT);
    fn into_pyobject(self, _: Python<'py>) -> Result<Self::Output, Self::Error> {
        Ok(self.0)
    }
}

/// What one of Python's containers is called, with what it holds.
macro_rules! container {
    ($(#[$words:meta])* $name:ident, $kind:ty, $hint:expr) => {
        $(#[$words])*
        pub(crate) struct $name<'py>(pub(crate) Bound<'py, $kind>);

        impl<'py> Deref for $name<'py> {
            type Target = Bound<'py, $kind>;
            fn deref(&self) -> &Self::Target {
                &self.0
            }
        }

        impl<'a, 'py> FromPyObject<'a, 'py> for $name<'py> {
            type Error = <Bound<'py, $kind> as FromPyObject<'a, 'py>>::Error;
            const INPUT_TYPE: PyStaticExpr = $hint;
            fn extract(object: Borrowed<'a, 'py, PyAny>) -> Result<Self, Self::Error> {
                object.extract().map(Self)
            }
        }

        impl<'py> IntoPyObject<'py> for $name<'py> {
            type Target = $kind;
            type Output = Bound<'py, $kind>;
            type Error = std::convert::Infallible;
            const OUTPUT_TYPE: PyStaticExpr = $hint;
            fn into_pyobject(self, _: Python<'py>) -> Result<Self::Output, Self::Error> {
                Ok(self.0)
            }
        }
    };
}

container!(
    /// Arrays by the path of the field that they replace.
    ByPath,
    PyDict,
    type_hint_subscript!(
        type_hint_identifier!("builtins", "dict"),
        STRING,
        type_hint_subscript!(NDARRAY, ANY)
    )
);

container!(
    /// Anything by name.
    Named,
    PyDict,
    type_hint_subscript!(type_hint_identifier!("builtins", "dict"), STRING, ANY)
);

container!(
    /// Arrays in order.
    Row,
    PyList,
    type_hint_subscript!(
        type_hint_identifier!("builtins", "list"),
        type_hint_subscript!(NDARRAY, ANY)
    )
);
