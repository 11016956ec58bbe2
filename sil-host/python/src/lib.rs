//! The Python module `sextant`: what the commands `solve`, `identify`, `earth` and `propagate` answer, on
//! numpy arrays.
//!
//! Nothing is computed here. Arrays become the host's pictures, fields and states, its answers become arrays;
//! its refusals become `ValueError` with the same line, without the program's name and with Python's names
//! of the options.

mod arrays;
mod earth;
mod identify;
mod optics;
mod propagate;
mod solve;

use pyo3::prelude::*;

/// Attitude, stars, the Earth and orbits of the Sextant Earth and star sensor, on numpy arrays.
///
/// Pixels count x right (columns) and y down (rows), the centre of the first pixel is (0, 0). The sensor
/// frame is x along +x px, y along +y px, z out along the line of sight. A quaternion is [x, y, z, w], scalar
/// last, and maps ICRS to the sensor frame. Bad input is a ValueError of one line; a sky or an Earth that is
/// not found is an answer with a reason.
#[pymodule]
mod sextant {
    #[pymodule_export]
    use crate::earth::{Earth, earth};
    #[pymodule_export]
    use crate::identify::{Field, identify};
    #[pymodule_export]
    use crate::propagate::propagate;
    #[pymodule_export]
    use crate::solve::{Solution, solve};

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
