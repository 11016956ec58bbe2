//! Which forces act on a satellite.
//!
//! [`Dynamics`] is the choice of the parameters, [`Forces`] what it comes to: degree and order of the
//! Earth's field, Sun and Moon, and for drag and the Sun's light the satellite's area over its mass.
//! [`super::dynamics`] applies them.

use super::body::CentralBody;
use super::gravity::MAX_DEGREE;
use fsw_ground::table::choice;

/// A choice of forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dynamics {
    /// The central body as a point.
    Kepler,
    /// Its field of the second degree, Sun and Moon (about the Moon: the Earth; about Mars: none).
    J2,
    /// The field to degree and order [`MAX_DEGREE`], Sun, Moon, drag and the Sun's light.
    Full,
}

choice! { Dynamics: Kepler, J2, Full }

impl Dynamics {
    /// The forces about the Earth on a satellite of these `Cd A / m` and `Cr A / m`, m²/kg.
    pub const fn forces(self, drag_m2_kg: f32, radiation_m2_kg: f32) -> Forces {
        match self {
            Self::Kepler => Forces::KEPLER,
            Self::J2 => Forces::J2,
            Self::Full => {
                Forces { degree: MAX_DEGREE, order: MAX_DEGREE, drag_m2_kg, radiation_m2_kg, ..Forces::J2 }
            }
        }
    }
}

/// The forces on a satellite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forces {
    /// What it flies about.
    pub body: CentralBody,
    /// Degree of the body's field, at most [`MAX_DEGREE`]; below 2 a point.
    pub degree: u8,
    /// Its order.
    pub order: u8,
    /// Whether the Sun pulls, and the Moon (on a satellite of the Moon: the Earth).
    pub sun_and_moon: bool,
    /// Coefficient of drag times area over mass, m²/kg; 0: no drag. About the Earth alone.
    pub drag_m2_kg: f32,
    /// Coefficient of radiation pressure times area over mass, m²/kg; 0: none.
    pub radiation_m2_kg: f32,
}

impl Forces {
    /// [`Dynamics::Kepler`] about the Earth.
    pub const KEPLER: Self = Self {
        body: CentralBody::Earth,
        degree: 0,
        order: 0,
        sun_and_moon: false,
        drag_m2_kg: 0.0,
        radiation_m2_kg: 0.0,
    };
    /// [`Dynamics::J2`] about the Earth.
    pub const J2: Self = Self { degree: 2, order: 2, sun_and_moon: true, ..Self::KEPLER };

    /// The same about another body.
    pub const fn about(self, body: CentralBody) -> Self {
        Self { body, ..self }
    }

    /// Factor of the bulge's pull, km².
    pub(super) fn bulge_km2(&self) -> f64 {
        if self.degree < 2 { 0.0 } else { self.body.facts().bulge_km2() }
    }
}
