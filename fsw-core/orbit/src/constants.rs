//! Constants of the bodies; km, s, rad.

/// Gravitational parameter of the Earth, km³/s² (EGM96).
pub const MU_EARTH_KM3_S2: f64 = 398_600.441_8;
/// Gravitational parameter of the Moon, km³/s² (DE440).
pub const MU_MOON_KM3_S2: f64 = 4_902.800_118;
/// Gravitational parameter of the Sun, km³/s² (DE440).
pub const MU_SUN_KM3_S2: f64 = 132_712_440_041.279_42;
/// Second zonal harmonic of the Earth, not normalised: that of EGM2008 with the part that Sun and Moon
/// raise for ever (IERS Conventions 2010, eq. 6.14), as no other tide is modelled. Without that part, which
/// EGM96 and EGM2008 leave out, a low orbit is 10 m off after a day.
pub const J2: f64 = 1.082_635_67e-3;
/// Equatorial radius of the Earth, km (WGS84).
pub const EARTH_RADIUS_KM: f64 = 6_378.137;
/// Rotation of the Earth, rad/s (WGS84).
pub const EARTH_RATE_RAD_S: f64 = 7.292_115e-5;
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
