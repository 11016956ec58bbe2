//! The attitude methods by the names of the command line, and what its help says of a line.

use crate::words::named;
use fsw_core::attitude::comparison::WahbaMethod;

/// What the help says of the lines.
pub const LINES: &str = "\
In, a set a line: {\"id\":..,\"b\":[[x,y,z],...],\"r\":[[x,y,z],...],\"sigma_rad\":[..]}, b unit vectors in the sensor frame, r in
ICRS, sigma_rad the error of each b per axis; optional for the method anisotropic: \"covariance_rad2\":[[xx,xy,yy],...], that of
the x and y of each b.
Out, a line a set and method: {\"id\",\"method\",\"status\":\"solved|refused\",\"reason\",\"q\",\"sigma_arcsec\",\"loss\",\"us\"}.
A set whose directions contradict each other is refused: twice the loss is a chi-square with two degrees of freedom a star less
three, and right sigmas would give so large a one once in a million sets.";

/// The methods and their names here.
pub const NAMES: [(WahbaMethod, &str); 8] = [
    (WahbaMethod::Svd, "svd"),
    (WahbaMethod::Davenport, "q"),
    (WahbaMethod::Quest, "quest"),
    (WahbaMethod::Foam, "foam"),
    (WahbaMethod::Esoq, "esoq"),
    (WahbaMethod::Esoq2, "esoq2"),
    (WahbaMethod::LeastSquares, "lsq"),
    (WahbaMethod::Anisotropic, "anisotropic"),
];

/// The method of a name.
///
/// # Errors
/// A list of the names there are.
pub fn method(name: &str) -> Result<WahbaMethod, String> {
    named(&NAMES, "methods", name.trim())
}

/// The name of a method.
pub fn name(method: WahbaMethod) -> &'static str {
    NAMES.iter().find(|(known, _)| *known == method).map_or("", |(_, name)| name)
}
