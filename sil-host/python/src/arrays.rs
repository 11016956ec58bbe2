//! Arrays in and out.

use fsw_hal::DetectorGeometry;
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLike1, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sil_host::error::HostError;
use sil_host::formats::picture::{Picture, PictureFault};
use sil_host::formats::{SIDE_MAX_PX, SIDE_MIN_PX};

/// A row of numbers that a caller gives; whole numbers and lists serve as well.
pub(crate) type Numbers<'py> = PyArrayLike1<'py, f64, AllowTypeChange>;
/// A row of numbers that an answer holds.
pub(crate) type Row = Py<PyArray1<f64>>;
/// Rows of numbers that an answer holds.
pub(crate) type Rows = Py<PyArray2<f64>>;

/// A refusal.
pub(crate) fn refused(words: impl Into<String>) -> PyErr {
    PyValueError::new_err(words.into())
}

/// The host's refusal: its line, with `fov_deg` for `--fov-deg`.
pub(crate) fn fault(error: &HostError) -> PyErr {
    let line = error.to_string();
    let words = line.strip_prefix("sil-host: ").unwrap_or(&line).split(' ');
    let word =
        |word: &str| word.strip_prefix("--").map_or(word.to_owned(), |option| option.replace('-', "_"));
    refused(words.map(word).collect::<Vec<_>>().join(" "))
}

/// The picture of an array of rows, 8 or 16 bits.
///
/// # Errors
/// Another array, or a side of a length that is not read.
pub(crate) fn picture(image: &Bound<'_, PyAny>) -> PyResult<Picture> {
    let (rows, columns, bits, pixels) = if let Ok(image) = image.extract::<PyReadonlyArray2<'_, u8>>() {
        let image = image.as_array();
        (image.nrows(), image.ncols(), 8, image.iter().map(|value| u16::from(*value)).collect())
    } else if let Ok(image) = image.extract::<PyReadonlyArray2<'_, u16>>() {
        let image = image.as_array();
        (image.nrows(), image.ncols(), 16, image.iter().copied().collect())
    } else {
        return Err(refused("image: give an array (rows, columns) of uint8 or uint16"));
    };
    let of_size = || PictureFault::Size(columns as u64, rows as u64);
    let side = |length: usize| {
        let read = (SIDE_MIN_PX as usize..=SIDE_MAX_PX as usize).contains(&length);
        if read { Ok(length as u16) } else { Err(refused(format!("image: {}", of_size()))) }
    };
    let geometry = DetectorGeometry { width_px: side(columns)?, height_px: side(rows)?, bits };
    Picture::from_pixels(geometry, pixels).ok_or_else(|| refused(format!("image: {}", of_size())))
}

/// Three finite numbers.
///
/// # Errors
/// Another number of them, or one that is none.
pub(crate) fn three(name: &str, numbers: &Numbers<'_>) -> PyResult<[f64; 3]> {
    let numbers: Vec<f64> = numbers.as_array().iter().copied().collect();
    let three = <[f64; 3]>::try_from(numbers).ok();
    three
        .filter(|three| three.iter().all(|number| number.is_finite()))
        .ok_or_else(|| refused(format!("{name}: give three finite numbers")))
}

/// An answer's row.
pub(crate) fn row<T: Copy + Into<f64>>(py: Python<'_>, numbers: &[T]) -> Row {
    PyArray1::from_iter(py, numbers.iter().map(|number| (*number).into())).unbind()
}

/// An answer's row of whole numbers.
pub(crate) fn whole(py: Python<'_>, numbers: impl Iterator<Item = i64>) -> Py<PyArray1<i64>> {
    PyArray1::from_vec(py, numbers.collect()).unbind()
}

/// An answer's rows of `N`, none of them too.
pub(crate) fn rows<const N: usize, T: Copy + Into<f64>>(
    py: Python<'_>,
    of: impl Iterator<Item = [T; N]>,
) -> PyResult<Rows> {
    let flat: Vec<f64> = of.flat_map(|row| row.map(Into::into)).collect();
    let count = flat.len() / N;
    Ok(PyArray1::from_vec(py, flat).reshape([count, N])?.unbind())
}
