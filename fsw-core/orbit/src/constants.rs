//! Constants that belong to no central body ([`super::body`]); km, s, rad.

/// Gravitational parameter of the Sun, km³/s² (DE440).
pub const MU_SUN_KM3_S2: f64 = 132_712_440_041.279_42;
/// Astronomical unit, km (IAU 2012).
pub const AU_KM: f64 = 149_597_870.7;
/// Speed of light, km/s.
pub const LIGHT_KM_S: f64 = 299_792.458;
/// Mass of the Moon as a share of the Earth's and the Moon's together (DE440).
pub const MOON_SHARE: f64 = 0.012_150_584;
/// Microseconds in a second.
pub const MICROSECONDS: f64 = 1e6;
/// Microseconds in a Julian century of 36,525 days.
pub const CENTURY_US: f64 = 36_525.0 * 86_400.0 * MICROSECONDS;
