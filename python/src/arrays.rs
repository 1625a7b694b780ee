//! NumPy arrays, which own their memory, from rows.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use vibro_impact::State;

/// An array of one dimension.
pub type Array1<'py, T> = Bound<'py, PyArray1<T>>;
/// An array of two dimensions.
pub type Array2<'py, T> = Bound<'py, PyArray2<T>>;

/// An array with these rows.
pub fn table<'py, T: numpy::Element + Copy, const N: usize>(
    py: Python<'py>,
    rows: &[[T; N]],
) -> PyResult<Array2<'py, T>> {
    plane(py, rows.as_flattened(), rows.len(), N)
}

/// An array of `rows` times `columns`, filled row by row.
pub fn plane<'py, T: numpy::Element + Copy>(
    py: Python<'py>,
    numbers: &[T],
    rows: usize,
    columns: usize,
) -> PyResult<Array2<'py, T>> {
    let array = PyArray2::zeros(py, [rows, columns], false);
    array.try_readwrite()?.as_slice_mut()?.copy_from_slice(numbers);
    Ok(array)
}

/// An array with these numbers.
pub fn column<'py, T: numpy::Element + Copy>(py: Python<'py>, numbers: &[T]) -> Array1<'py, T> {
    PyArray1::from_slice(py, numbers)
}

/// Displacements (m) and velocities (m/s) of states, an array each.
pub fn states<'py>(py: Python<'py>, states: &[State]) -> PyResult<(Array2<'py, f64>, Array2<'py, f64>)> {
    let x: Vec<[f64; 3]> = states.iter().map(|s| s.x).collect();
    let v: Vec<[f64; 3]> = states.iter().map(|s| s.v).collect();
    Ok((table(py, &x)?, table(py, &v)?))
}

/// The numbers of an array. The Python modules pass contiguous arrays.
pub fn numbers(array: &PyReadonlyArray1<'_, f64>) -> PyResult<Vec<f64>> {
    Ok(array.as_slice()?.to_vec())
}

/// States from rows of x1, x2, x3 (m), v1, v2, v3 (m/s).
pub fn rows_of_states(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<State>> {
    Ok(array.as_slice()?.as_chunks::<6>().0.iter().map(state).collect())
}

/// A state from x1, x2, x3 (m), v1, v2, v3 (m/s).
pub fn state(&[x1, x2, x3, v1, v2, v3]: &[f64; 6]) -> State {
    State { x: [x1, x2, x3], v: [v1, v2, v3] }
}
