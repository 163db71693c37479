//! NumPy arrays that are read in place.

use std::borrow::Cow;
use std::collections::BTreeMap;

use num_complex::Complex64;
use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{Element, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use raylet::file::arrays::array::BorrowedArray;

use crate::typed::ByPath;

/// One array that is lent, for as long as a call lasts.
pub(crate) enum Guard<'py> {
    Real(PyReadonlyArray2<'py, f64>),
    Complex(PyReadonlyArray2<'py, Complex64>),
}

impl Guard<'_> {
    pub(crate) fn borrowed(&self) -> BorrowedArray<'_> {
        match self {
            Guard::Real(array) => BorrowedArray::Real(array.as_array()),
            Guard::Complex(array) => BorrowedArray::Complex(array.as_array()),
        }
    }
}

/// Arrays by the path of the field that they replace.
pub(crate) struct Lent<'py>(Vec<(String, Guard<'py>)>);

impl<'py> Lent<'py> {
    /// Takes the arrays of a dictionary from paths to 2-D arrays of float64 or complex128.
    ///
    /// # Errors
    /// TypeError for anything else.
    pub(crate) fn new(arrays: &ByPath<'py>) -> PyResult<Self> {
        let one = |(path, array): (Bound<'py, PyAny>, Bound<'py, PyAny>)| {
            let path: String = path.extract()?;
            let guard = guard(&path, &array)?;
            Ok((path, guard))
        };
        Ok(Self(arrays.iter().map(one).collect::<PyResult<_>>()?))
    }

    pub(crate) fn borrowed_all(&self) -> BTreeMap<String, BorrowedArray<'_>> {
        self.0
            .iter()
            .map(|(path, guard)| (path.clone(), guard.borrowed()))
            .collect()
    }
}

/// One array that is lent.
///
/// # Errors
/// TypeError for anything but a 2-D array of float64 or complex128.
pub(crate) fn guard<'py>(name: &str, array: &Bound<'py, PyAny>) -> PyResult<Guard<'py>> {
    if let Ok(real) = array.extract::<PyReadonlyArray2<f64>>() {
        check_memory(name, &real)?;
        return Ok(Guard::Real(real));
    }
    let complex = array.extract::<PyReadonlyArray2<Complex64>>();
    let complex = complex.map_err(|_| {
        PyTypeError::new_err(format!(
            "{name}: expected a 2-D array of float64 or complex128"
        ))
    })?;
    check_memory(name, &complex)?;
    Ok(Guard::Complex(complex))
}

/// Refuses memory that cannot be read as it lies.
pub(crate) fn check_memory<T: Element, D: numpy::ndarray::Dimension>(
    name: &str,
    array: &numpy::PyReadonlyArray<'_, T, D>,
) -> PyResult<()> {
    let size = size_of::<T>() as isize;
    let aligned = (array.data() as usize).is_multiple_of(align_of::<T>());
    if !aligned || array.strides().iter().any(|stride| stride % size != 0) {
        return Err(PyTypeError::new_err(format!(
            "{name}: expected an aligned array"
        )));
    }
    Ok(())
}

/// Numbers in order: where they lie, if they lie so.
pub(crate) fn in_order(column: ArrayView1<'_, f64>) -> Cow<'_, [f64]> {
    match column.to_slice() {
        Some(numbers) => Cow::Borrowed(numbers),
        None => Cow::Owned(column.to_vec()),
    }
}

/// A column of numbers, one for each ray.
pub(crate) fn column<T: Element + Copy>(
    name: &str,
    array: &PyReadonlyArray1<'_, T>,
) -> PyResult<Vec<T>> {
    check_memory(name, array)?;
    let view: ArrayView1<T> = array.as_array();
    Ok(view.to_vec())
}

/// Rows of `N` numbers, one for each ray.
///
/// # Errors
/// ValueError for arrays of another width.
pub(crate) fn columns<T: Element + Copy, const N: usize>(
    name: &str,
    array: &PyReadonlyArray2<'_, T>,
) -> PyResult<Vec<[T; N]>> {
    check_memory(name, array)?;
    let view: ArrayView2<T> = array.as_array();
    if view.ncols() != N {
        let shape = view.shape();
        let message = format!("{name}: an array of shape {shape:?}, expected (rays, {N})");
        return Err(PyValueError::new_err(message));
    }
    // Rows that lie side by side are taken in one piece: millions come in little time.
    if let Some(numbers) = view.as_slice() {
        return Ok(numbers.as_chunks().0.to_vec());
    }
    #[expect(clippy::indexing_slicing, reason = "it has as many columns")]
    let row = |row: ArrayView1<T>| std::array::from_fn(|i| row[i]);
    Ok(view.rows().into_iter().map(row).collect())
}
