//! Parameters of the orbit filter.

use super::body::CentralBody;
use super::forces::{Dynamics, Forces};
use fsw_ground::table::{choice, parameter_group};

/// What the filter takes of an image of the Earth; a scenario names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
pub enum Observation {
    /// The height of each limb point about the predicted limb, by the model of the horizon.
    LimbHeights,
    /// The Earth's centre: position by direction and distance, with its covariance (thesis §5.1).
    Position,
    /// Its direction alone (eq. 5.25): the two components across the line to the Earth.
    UnitVector,
    /// The position until the filter has settled, the direction afterwards.
    Combined,
}

choice! { Observation: LimbHeights, Position, UnitVector, Combined }

/// What becomes of the misalignment of star path and Earth path against the mounting of the parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Misalignment {
    /// It is not learned; the covariance allows for it (Schmidt).
    Considered,
    /// It is learned, and the Earth path turned by it. From the limb alone it cannot be told from a position
    /// (`sil-host navigate --observability`): for an orbit that the ground has given.
    Estimated,
}

choice! { Misalignment: Considered, Estimated }

parameter_group! {
    /// Propagation and filter of the orbit.
    pub struct OrbitParameters in "orbit" {
        /// What the satellite flies about.
        body: CentralBody = CentralBody::Earth, one of "Earth, Moon, Mars", "",
            "the mission's; ellipsoid and limb of another body go with it (`Parameters::about`)";
        /// What is taken of an image of the Earth.
        observation: Observation = Observation::LimbHeights,
            one of "LimbHeights, Position, UnitVector, Combined", "",
            "a centre bends with the errors of its limb, heights do not";
        /// Forces of the prediction.
        dynamics: Dynamics = Dynamics::Full, one of "Kepler, J2, Full", "",
            "field to degree 8, Sun, Moon, drag and the Sun's light";
        /// Coefficient of drag times the area across flight, over mass; the ground scales it by how dense the
        /// upper air is found to be. 0 about Moon and Mars, of whose air there is no model.
        drag_m2_kg: f32 = 0.022, 0.0..=10.0, "m2/kg", "100 kg, 1 m2, coefficient 2.2";
        /// Coefficient of radiation pressure times the area towards the Sun, over mass.
        radiation_m2_kg: f32 = 0.013, 0.0..=10.0, "m2/kg", "100 kg, 1 m2, coefficient 1.3";
        /// Sigma of the limb's mean height about `earth.limb.height_km`.
        height_sigma_km: f32 = 0.5, 0.0..=100.0, "km",
            "the mean of three orbits varies by it: rendered orbits";
        /// The same as an angle: the detection of edges may be off by a share of a pixel. It matters from
        /// afar; both are estimated.
        height_sigma_rad: f32 = 2.4e-5, 0.0..=0.01, "rad", "1 km in GEO: rendered orbits";
        /// Sigma of the limb's height by the sine of latitude: summer over winter.
        summer_sigma_km: f32 = 0.3, 0.0..=20.0, "km", "rendered orbits";
        /// Limb's height over the equator above that over the poles.
        tropics_km: f32 = 2.0, -20.0..=20.0, "km",
            "the tropopause stands at 17 km over the tropics, at 9 over the poles; rendered orbits";
        /// Its sigma.
        tropics_sigma_km: f32 = 0.5, 0.0..=20.0, "km", "rendered orbits";
        /// Deviation of the limb's height beside these, over hundreds to thousands of km.
        field_sigma_km: f32 = 1.7, 0.0..=20.0, "km", "rendered orbits";
        /// Length over which it changes.
        field_length_km: f32 = 1100.0, 100.0..=10_000.0, "km", "rendered orbits";
        /// Deviation of the height at which an edge is found: clouds.
        edge_sigma_km: f32 = 1.2, 0.0..=20.0, "km", "rendered orbits";
        /// The same as an angle. Both are joined as squares.
        edge_sigma_rad: f32 = 9e-5, 0.0..=0.01, "rad", "0.27 px of the reference camera: rendered orbits";
        /// Length of limb that shares it.
        edge_patch_km: f32 = 120.0, 1.0..=10_000.0, "km", "rendered orbits";
        /// The same as an angle. Both are joined as squares.
        edge_patch_rad: f32 = 0.0133, 0.0..=0.5, "rad", "5 deg of azimuth in GEO: rendered orbits";
        /// Longest time between two looks at the limb, where it does not move on sooner.
        edge_longest_s: f32 = 1800.0, 10.0..=86_400.0, "s", "an edge's error changes by 2 % in it";
        /// Time in which the light makes other errors of the edges where the limb stays.
        edge_light_s: f32 = 86_400.0, 2e3..=1e6, "s",
            "a day, after which the light comes again: likelier than 3e4 in rendered days in GEO";
        /// Longest time over which limb points are joined to one observation.
        look_s: f32 = 300.0, 1.0..=300.0, "s", "averages the attitude's noise, the orbit turns by 1 deg in GEO";
        /// What becomes of the misalignment of the paths.
        misalignment: Misalignment = Misalignment::Considered, one of "Considered, Estimated", "",
            "the limb alone does not show it: thesis 5.2.2";
        /// Its sigma about each axis of the Earth path.
        misalignment_sigma_rad: f32 = 5.1e-5, 0.0..=0.02, "rad",
            "10 arcsec of a theodolite, and `mount.boresight_sigma_px` in the reference camera, 3.4";
        /// White acceleration at the Earth's surface, per root hertz. It stands for the gravity of the
        /// degrees that `Full` leaves out, 9 and above. It falls with the twelfth power of the
        /// radius, as the pull of degree 10 does.
        gravity_noise_km_s15: f32 = 2.5e-7, 0.0..=1e-3, "km/s^1.5",
            "EGM2008 of degree 36 beside 8, 300 to 1,350 km: grows in a revolution to their rms error, 104 to 27 m";
        /// White acceleration over that by drag, per root hertz. It stands for the density of the upper air.
        drag_noise_s05: f32 = 30.0, 0.0..=1e3, "s^0.5", "density 35 % off for an hour";
        /// White acceleration everywhere, per root hertz.
        force_noise_km_s15: f32 = 4e-9, 0.0..=1e-3, "km/s^1.5",
            "a third of the Sun's light on 0.013 m2/kg, 2e-11 km/s2, that lasts for half a day";
        /// Gate of an observation: how far its normalised innovation squared may exceed what is expected, in
        /// its standard deviations. One beyond it contradicts the orbit and counts for less.
        gate_sigma: f32 = 8.0, 3.0..=100.0, "", "22.6 of three degrees of freedom, 43 of nine: 5 good ones in 100,000 are beyond, 2 in a million";
        /// Observations in a row that contradict the orbit after which the filter begins anew. Gross ones,
        /// of four times the gate's square; a lesser one counts for its share of that.
        patience: u16 = 4, 1..=600, "", "two minutes in LEO, two hours in GEO";
        /// The filter has settled when position and velocity are known to this share of their length.
        settled_share: f32 = 1e-3, 1e-6..=0.1, "", "42 km in GEO, 7 km in LEO";
    }
}

impl OrbitParameters {
    /// The same about another body: how its limb stands and what it has of the forces. About the Earth nothing
    /// changes.
    pub fn about(self, body: CentralBody) -> Self {
        let facts = body.facts();
        let Some(limb) = &facts.limb else { return Self { body, ..self } };
        let ([field_sigma_km, field_length_km], [edge_sigma_km, edge_patch_km]) =
            (limb.field_km, limb.edge_km);
        Self {
            body,
            drag_m2_kg: if facts.air { self.drag_m2_kg } else { 0.0 },
            height_sigma_km: limb.height_sigma_km,
            summer_sigma_km: 0.0,
            tropics_km: 0.0,
            tropics_sigma_km: 0.0,
            field_sigma_km,
            field_length_km,
            edge_sigma_km,
            edge_patch_km,
            gravity_noise_km_s15: limb.gravity_noise_km_s15,
            ..self
        }
    }

    /// The forces of the prediction.
    pub fn forces(&self) -> Forces {
        self.dynamics.forces(self.drag_m2_kg, self.radiation_m2_kg).about(self.body)
    }

    /// The name of the first value that asks for what the body has not.
    pub fn first_not_of_body(&self) -> Option<&'static str> {
        (!self.body.facts().air && self.drag_m2_kg > 0.0).then_some("orbit.drag_m2_kg")
    }
}
