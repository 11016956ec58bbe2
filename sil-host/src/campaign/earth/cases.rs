//! The kinds of views that `campaign earth` draws, and how a run chooses one.
//!
//! In: case, seed, run. Out: a scenario of one second with the satellite somewhere about the Earth on some
//! day of the year, its camera looking at the disc or at a horizon, turned in any way about its line of
//! sight. Drawn anew until the Sun is in neither path, the phase is the case's and enough of the limb is lit.

use crate::error::HostError;
use crate::formats::camera_file::CameraFile;
use crate::harness::truth_of;
use crate::scenario::Scenario;
use crate::world::attitude::{Vector, apply, rotation};
use crate::world::detector::imaging::ImagingModel;
use crate::world::lens::optics::Optics;
use crate::world::motion::pointing::{Mount, Pointing};
use crate::world::motion::trajectory::{Trajectory, Truth};
use crate::world::noise::{Noise, Stream};
use crate::world::orbit::{MU_EARTH, TruthOrbit};
use crate::world::scene::Scene;
use crate::world::time::ephemeris;
use crate::world::vector::angle;
use std::f64::consts::TAU;
use std::path::Path;

const TEXT: &str = include_str!("../earth.toml");
/// Runs that share an Earth: its maps fill slowly.
const RUNS_AN_EARTH: u64 = 8;
/// Views drawn before it is given up.
const DRAWS: u32 = 2000;
/// A year, µs.
pub const YEAR_US: f64 = 365.25 * 86_400e6;
/// The Earth's radius, km, by which a horizon is aimed at.
const RADIUS_KM: f64 = 6378.0;
/// A disc is off the middle by up to this angle, deg: more would not fit the detector's lower side.
const OFF_DEG: f64 = 0.5;

/// A kind of view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// Name in the table and the file.
    pub name: &'static str,
    /// Height over the equator's radius, km.
    pub height_km: f64,
    /// Angle between Sun and satellite seen from the Earth, from and to, deg.
    pub phase_deg: [f64; 2],
    /// Whether the line of sight goes to the horizon, else to the centre.
    pub at_horizon: bool,
    /// Focal length, px, where it is not the reference camera's.
    pub focal_length_px: Option<f64>,
    /// Exposure, µs.
    pub exposure_us: u32,
    /// Lit limb on the detector, deg of azimuth about the centre.
    pub least_lit_deg: f64,
    /// What is asked of the direction, deg, 1 sigma an axis; none where the issue names none.
    pub goal_deg: Option<f64>,
}

/// Any phase.
const DAY: [f64; 2] = [0.0, 150.0];

const GEO: Case = Case {
    name: "",
    height_km: 35_786.0,
    phase_deg: DAY,
    at_horizon: false,
    focal_length_px: None,
    exposure_us: 400_000,
    least_lit_deg: 60.0,
    goal_deg: Some(0.02),
};

const HORIZON: Case =
    Case { at_horizon: true, exposure_us: 200_000, least_lit_deg: 20.0, goal_deg: None, ..GEO };

/// All kinds.
pub const CASES: [Case; 13] = [
    Case { name: "GEO, noon, phase 0-20", phase_deg: [0.0, 20.0], ..GEO },
    Case { name: "GEO, phase 20-60", phase_deg: [20.0, 60.0], ..GEO },
    Case { name: "GEO, phase 60-100", phase_deg: [60.0, 100.0], ..GEO },
    Case { name: "GEO, phase 100-130", phase_deg: [100.0, 130.0], ..GEO },
    Case { name: "GEO, phase 130-160", phase_deg: [130.0, 160.0], ..GEO },
    Case { name: "GTO, 30,000 km", height_km: 30_000.0, least_lit_deg: 20.0, ..HORIZON },
    Case { name: "GTO, 20,000 km", height_km: 20_000.0, ..HORIZON },
    Case { name: "GTO, 10,000 km", height_km: 10_000.0, ..HORIZON },
    Case { name: "GTO, 3,000 km", height_km: 3_000.0, ..HORIZON },
    Case { name: "LEO, 800 km", height_km: 800.0, ..HORIZON },
    Case { name: "LEO, 450 km", height_km: 450.0, ..HORIZON },
    Case { name: "LEO, 800 km, wide lens", ..wide(800.0) },
    Case { name: "LEO, 450 km, wide lens", ..wide(450.0) },
];

/// With a lens of a third of the reference's focal length, which takes in 60 deg and more of a low orbit's
/// limb; the light of a pixel is nine times as much.
const fn wide(height_km: f64) -> Case {
    Case {
        height_km,
        focal_length_px: Some(1000.0),
        exposure_us: 22_000,
        least_lit_deg: 60.0,
        goal_deg: Some(0.05),
        ..HORIZON
    }
}

/// A view as a run drew it.
#[derive(Debug)]
pub struct Drawn {
    /// The world.
    pub scene: Scene,
    /// What is true in it.
    pub truth: Truth,
    /// Its camera, for the flight code.
    pub camera: CameraFile,
    /// How the star path stands to the Earth path.
    pub mount: Mount,
    /// Angle between Sun and satellite seen from the Earth, deg.
    pub phase_deg: f64,
}

/// What all runs have in common.
///
/// # Errors
/// None but a fault of this program.
pub fn base() -> Result<Scenario, HostError> {
    Scenario::parse(Path::new("the satellite of the campaign"), TEXT)
}

/// The scenario of a draw.
fn scenario(base: &Scenario, case: &Case, seed: u64, run: u64, noise: &Noise, draw: u32) -> Scenario {
    let uniform = |slot| noise.uniform(draw, slot);
    let distance_km = RADIUS_KM + case.height_km;
    // A direction evenly over the sphere, a flight across it in any direction: a circle is as good as an
    // ellipse for one frame.
    let [z, right, turn] = [2.0 * uniform(0) - 1.0, TAU * uniform(1), TAU * uniform(2)];
    let to_place = |vector: Vector| {
        let along = apply(&rotation(0, -turn), vector);
        apply(&rotation(2, -right), apply(&rotation(1, libm::asin(z)), along))
    };
    let speed_km_s = (MU_EARTH / distance_km).sqrt();
    let off_deg = if case.at_horizon {
        // The limb within a quarter of the field's lower side.
        let half_field_deg = libm::atan(512.0 / case.focal_length_px.unwrap_or(3000.0)).to_degrees();
        libm::asin(RADIUS_KM / distance_km).to_degrees() + 0.5 * half_field_deg * (2.0 * uniform(3) - 1.0)
    } else {
        OFF_DEG * uniform(3)
    };
    let mut camera = base.camera.clone();
    let mut imaging = base.imaging;
    if let Some(focal_length_px) = case.focal_length_px {
        camera.focal_length_px = focal_length_px;
        // The reference's lens does not scale; one without its errors is enough for a limb.
        imaging.psf = ImagingModel::PLAIN.psf;
    }
    Scenario {
        seed: seed.wrapping_mul(1_000_003).wrapping_add(run),
        start_us: base.start_us + (YEAR_US * uniform(4)) as i64,
        exposure_us: case.exposure_us,
        position_km: to_place([distance_km, 0.0, 0.0]),
        velocity_km_s: to_place([0.0, speed_km_s, 0.0]),
        pointing: Pointing::nadir(off_deg, 360.0 * uniform(5)),
        camera,
        imaging,
        ..base.clone()
    }
}

/// The view of a run, exposed.
///
/// # Errors
/// When no draw gives one.
pub fn draw(base: &Scenario, number: usize, case: &Case, seed: u64, run: u64) -> Result<Drawn, HostError> {
    let noise = Noise::new(seed, run, Stream::Attitude).part(number as u64);
    for draw in 0..DRAWS {
        let scenario = scenario(base, case, seed, run, &noise, draw);
        let phase_deg = phase_deg(&scenario);
        let [from, to] = case.phase_deg;
        if !(from..to).contains(&phase_deg) {
            continue;
        }
        let truth = glimpse(&scenario)?;
        if truth.state.is_blinded() || truth.earth_in_star_path || truth.lit_limb_deg < case.least_lit_deg {
            continue;
        }
        let mut scene = scenario.scene_above(seed.wrapping_add(run / RUNS_AN_EARTH))?;
        let truth = truth_of(&scene, 0)?;
        scene.expose_cycle(0, scenario.exposure_us).map_err(|error| {
            HostError::usage(format!("run {run} is not exposed ({error:?})"), "report this")
        })?;
        return Ok(Drawn { scene, truth, camera: scenario.camera, mount: scenario.mount, phase_deg });
    }
    Err(HostError::usage(format!("run {run} finds no view of {}", case.name), "report this"))
}

/// What is true in a scenario's first second, without a world about it.
///
/// # Errors
/// No orbit, or a camera that cannot be drawn.
pub fn glimpse(scenario: &Scenario) -> Result<Truth, HostError> {
    let fault = |what: String| HostError::usage(what, "report this");
    let Scenario { start_us, position_km, velocity_km_s, duration_s, earth, mount, .. } = *scenario;
    let orbit = TruthOrbit::new(start_us, position_km, velocity_km_s, duration_s)
        .map_err(|error| fault(error.to_string()))?;
    let optics = Optics::new(&scenario.camera).ok_or_else(|| fault("the camera cannot be drawn".into()))?;
    Ok(Trajectory { orbit, pointing: scenario.pointing.clone(), mount, earth }.truth(0.0, &optics))
}

/// Angle between Sun and satellite seen from the Earth, deg.
fn phase_deg(scenario: &Scenario) -> f64 {
    angle(ephemeris::sun_km(scenario.start_us), scenario.position_km).to_degrees()
}
