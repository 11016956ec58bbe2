//! The central body: what the satellite flies about.
//!
//! [`CentralBody`] is the choice of the parameters (`orbit.body`) and of a scenario, [`BodyFacts`] the row
//! that belongs to it. Flight code and the host's world read the same rows; no fact of a body stands
//! elsewhere, but the Earth's where one table cannot hold them: its precession and nutation
//! ([`super::ephemeris`]), its air (`atmosphere`), and the world's own models of these, which are finer.
//!
//! Figures, poles and prime meridians: reports of the IAU Working Group on Cartographic Coordinates and
//! Rotational Elements (Archinal et al. 2011 and 2018, Celest. Mech. Dyn. Astr. 109, 101 and 130, 22). The
//! Moon's axes are those of the mean Earth; its field refers to the principal axes, 0.03 deg beside.

use fsw_ground::table::choice;

const RAD_PER_DEG: f64 = core::f64::consts::PI / 180.0;
/// A degree a day, rad/s.
const DEG_PER_DAY: f64 = RAD_PER_DEG / 86_400.0;

/// What a satellite flies about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CentralBody {
    /// The Earth.
    #[default]
    Earth,
    /// The Moon.
    Moon,
    /// Mars.
    Mars,
}

choice! { CentralBody: Earth, Moon, Mars }

/// What is known of a body.
#[derive(Debug)]
pub struct BodyFacts {
    /// Gravitational parameter, km³/s².
    pub mu_km3_s2: f64,
    /// Second zonal harmonic, not normalised.
    pub j2: f64,
    /// Radius to which that refers, km.
    pub field_radius_km: f64,
    /// Radius of the equator, km.
    pub radius_km: f64,
    /// Half axis to the pole, km.
    pub polar_km: f64,
    /// Rotation about the pole, rad/s.
    pub rate_rad_s: f64,
    /// Least and greatest distance from the centre that a state may have, km: the least is below any orbit
    /// and keeps divisions finite, at the greatest another body rules.
    pub bounds_km: [f64; 2],
    /// Least distance of an orbit's lowest point and greatest of its highest in the host's world, km.
    pub orbit_km: [f64; 2],
    /// Whether it has air that brakes a satellite, of which a model is on board.
    pub air: bool,
    /// Its axes; `None`: by precession, nutation and rotation angle of the Earth.
    pub axes: Option<BodyAxes>,
    /// Its ellipse about the Sun; `None`: that of the Earth-Moon barycentre.
    pub about_sun: Option<SolarOrbit>,
    /// How its limb stands, for the parameters; `None`: their defaults are the Earth's.
    pub limb: Option<BodyLimb>,
}

/// Pole and prime meridian in ICRS: right ascension, declination and the meridian's angle from the node of
/// the body's equator.
#[derive(Debug)]
pub struct BodyAxes {
    /// Right ascension of the pole at J2000.0 and its change a century, deg.
    pub right_ascension_deg: [f64; 2],
    /// Declination, likewise.
    pub declination_deg: [f64; 2],
    /// The prime meridian at J2000.0 and its change a day, deg.
    pub meridian_deg: [f64; 2],
    /// Terms of an argument `a + b d`, `d` in days: `a`, `b`, and the amplitudes of its sine in right
    /// ascension, of its cosine in declination, of its sine in the meridian, deg.
    pub terms: &'static [[f64; 5]],
}

/// An ellipse about the Sun, ecliptic and equinox of J2000: semi-major axis (au), eccentricity, inclination,
/// mean longitude, longitude of perihelion, longitude of the node (deg).
#[derive(Debug)]
pub struct SolarOrbit {
    /// At J2000.0.
    pub at_epoch: [f64; 6],
    /// Change a century.
    pub a_century: [f64; 6],
}

/// How a limb stands and how that is known: values of the parameters of the same names.
#[derive(Debug)]
pub struct BodyLimb {
    /// Height above the ellipsoid at which it is half bright, km.
    pub height_km: f32,
    /// Sigma of that height's mean, km.
    pub height_sigma_km: f32,
    /// Scatter of that height from one limb point to the next, km.
    pub scatter_km: f32,
    /// Height over which its brightness falls to 1/e, km.
    pub scale_height_km: f32,
    /// Share of the surface's brightness that follows the law of Lommel and Seeliger.
    pub lommel_share: f32,
    /// How far below the horizon the Sun still lights the air, deg.
    pub twilight_deg: f32,
    /// Deviation of the height over a length, km, and that length, km.
    pub field_km: [f32; 2],
    /// Deviation of an edge, km, and the length of limb that shares it, km.
    pub edge_km: [f32; 2],
    /// White acceleration at the surface for the degrees of gravity above 8, km/s^1.5.
    pub gravity_noise_km_s15: f32,
}

/// The Earth.
pub static EARTH: BodyFacts = BodyFacts {
    // EGM96.
    mu_km3_s2: 398_600.441_8,
    // EGM2008 with the part that Sun and Moon raise for ever (IERS Conventions 2010, eq. 6.14), as no other
    // tide is modelled. Without that part, which EGM96 and EGM2008 leave out, a low orbit is 10 m off after a
    // day.
    j2: 1.082_635_67e-3,
    field_radius_km: 6_378.137,
    // WGS84, the pole to a metre.
    radius_km: 6_378.137,
    polar_km: 6_356.752,
    rate_rad_s: 7.292_115e-5,
    // 1.5 times the Moon's distance.
    bounds_km: [5_000.0, 600_000.0],
    orbit_km: [6_478.0, 500_000.0],
    air: true,
    axes: None,
    about_sun: None,
    limb: None,
};

/// The Moon.
pub static MOON: BodyFacts = BodyFacts {
    // DE440.
    mu_km3_s2: 4_902.800_118,
    // LP165P (Konopliv et al. 2001, Icarus 150, 1).
    j2: 2.032_366_226e-4,
    field_radius_km: 1_738.0,
    // A ball.
    radius_km: 1_737.4,
    polar_km: 1_737.4,
    rate_rad_s: 13.176_358_15 * DEG_PER_DAY,
    // 0.9 of its sphere of influence.
    bounds_km: [1_400.0, 60_000.0],
    // 10.8 km is the highest ground (LOLA).
    orbit_km: [1_750.0, 30_000.0],
    air: false,
    axes: Some(BodyAxes {
        right_ascension_deg: [269.9949, 0.0031],
        declination_deg: [66.5392, 0.0130],
        meridian_deg: [38.3213, 13.176_358_15],
        // E1 to E4; those left out come to 0.03 deg.
        terms: &[
            [125.045, -0.052_992_1, -3.8787, 1.5419, 3.5610],
            [250.089, -0.105_984_2, -0.1204, 0.0239, 0.1208],
            [260.008, 13.012_000_9, 0.0700, -0.0278, -0.0642],
            [176.625, 13.340_715_4, -0.0172, 0.0068, 0.0158],
        ],
    }),
    about_sun: None,
    limb: Some(BodyLimb {
        height_km: 0.0,
        height_sigma_km: 0.8,
        scatter_km: 0.4,
        scale_height_km: 0.5,
        lommel_share: 1.0,
        twilight_deg: 0.0,
        field_km: [2.0, 300.0],
        edge_km: [0.9, 33.0],
        gravity_noise_km_s15: 5e-7,
    }),
};

/// Mars.
pub static MARS: BodyFacts = BodyFacts {
    // DE440, without its moons.
    mu_km3_s2: 42_828.373_62,
    // Mars50c (Konopliv and Sjogren 1995, JPL Publication 95-5).
    j2: 1.958_616_127e-3,
    field_radius_km: 3_394.2,
    radius_km: 3_396.19,
    polar_km: 3_376.20,
    rate_rad_s: 350.891_982_26 * DEG_PER_DAY,
    // 0.9 of its sphere of influence.
    bounds_km: [2_700.0, 500_000.0],
    // 100 km above the equator.
    orbit_km: [3_496.0, 300_000.0],
    air: false,
    axes: Some(BodyAxes {
        // The report of 2009; that of 2015 has its slow terms beside these, 0.002 deg until 2050.
        right_ascension_deg: [317.681_43, -0.1061],
        declination_deg: [52.886_50, -0.0609],
        meridian_deg: [176.630, 350.891_982_26],
        terms: &[],
    }),
    // Standish, "Approximate Positions of the Planets", JPL, 1800 to 2050: within 0.02 deg.
    about_sun: Some(SolarOrbit {
        at_epoch: [1.523_710_34, 0.093_394_10, 1.849_691_42, -4.553_432_05, -23.943_629_59, 49.559_538_91],
        a_century: [1.847e-5, 7.882e-5, -0.008_131_31, 19_140.302_684_99, 0.444_410_88, -0.292_573_43],
    }),
    limb: Some(BodyLimb {
        // Of the haze below it.
        height_km: 35.0,
        height_sigma_km: 3.0,
        scatter_km: 1.6,
        scale_height_km: 11.0,
        lommel_share: 0.5,
        twilight_deg: 6.0,
        field_km: [4.5, 586.0],
        edge_km: [1.9, 64.0],
        gravity_noise_km_s15: 4e-7,
    }),
};

impl CentralBody {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Earth, Self::Moon, Self::Mars];

    /// Its row.
    pub const fn facts(self) -> &'static BodyFacts {
        match self {
            Self::Earth => &EARTH,
            Self::Moon => &MOON,
            Self::Mars => &MARS,
        }
    }

    /// Its name, as a scenario has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Earth => "earth",
            Self::Moon => "moon",
            Self::Mars => "mars",
        }
    }

    /// The body of this [name](Self::name).
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|body| body.name() == name)
    }
}

impl BodyFacts {
    /// Pull of the bulge over that of the mass, times the square of the distance, km².
    pub(crate) fn bulge_km2(&self) -> f64 {
        1.5 * self.j2 * self.field_radius_km * self.field_radius_km
    }
}

#[cfg(test)]
mod tests;
