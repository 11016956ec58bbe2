//! Seeded flights over an arc of the limb that is lit for some minutes: is the filter as good as it says where
//! what it sees is short and its errors are long?

use super::world::{nees, radial_along_across, state_error};
use super::*;
use crate::constants::LIGHT_KM_S;
use crate::ephemeris::pole_axis;
use crate::forces::Dynamics;
use crate::horizon::{self, LimbGeometry, WAVES, of_waves, waves};

/// Radius of the limb's sphere, km.
const RADIUS_KM: f32 = 6383.0;
/// Points of a second.
const POINTS: usize = 24;

/// The limb of a true satellite, drawn from the filter's own model of it: constants as in
/// [`horizon::constants`], and waves.
struct TrueLimb {
    constants: [f64; 4],
    field: [f64; WAVES],
}

fn geometry(state: &OrbitState) -> LimbGeometry {
    LimbGeometry::of(CentralBody::Earth, state, &pole(state), RADIUS_KM).unwrap()
}

fn pole(state: &OrbitState) -> Vector3<f64> {
    pole_axis(CentralBody::Earth, state.time_us)
}

/// A vector in sphere space.
fn stretched(state: &OrbitState, vector: &Vector3<f64>) -> Vector3<f64> {
    let facts = CentralBody::Earth.facts();
    vector + pole(state) * ((facts.radius_km / facts.polar_km - 1.0) * pole(state).dot(vector))
}

impl TrueLimb {
    fn at_start(state: &OrbitState, parameters: &OrbitParameters, generator: &mut Generator) -> Self {
        let constants = horizon::constants(parameters)
            .map(|[mean, sigma]| f64::from(mean) + generator.gaussian() * f64::from(sigma));
        let field = of_waves(geometry(state).variations(parameters))
            .map(|wave| generator.gaussian() * f64::from(wave.variance_km2).sqrt());
        Self { constants, field }
    }

    fn live(&mut self, state: &OrbitState, parameters: &OrbitParameters, generator: &mut Generator) {
        for (wave, variation) in self.field.iter_mut().zip(of_waves(geometry(state).variations(parameters))) {
            let (decay, variance) = (f64::from(variation.decay(1.0)), f64::from(variation.variance_km2));
            *wave = decay * *wave + generator.gaussian() * (variance * (1.0 - decay * decay)).sqrt();
        }
    }

    /// Heights about the limb that `predicted` expects of an arc seen from `truth`, rad of azimuth.
    fn seen(
        &self,
        (truth, predicted): (&OrbitState, &OrbitState),
        [first_rad, last_rad]: [f64; 2],
        noise_km: f64,
        generator: &mut Generator,
    ) -> Vec<LimbHeight> {
        let (here, there) = (geometry(truth), geometry(predicted));
        let axes = here.axes.map(f64::from);
        let centre = -stretched(predicted, &predicted.position_km);
        let distance_km = centre.norm();
        let nadir = centre / distance_km;
        let cone = (f64::from(RADIUS_KM) / distance_km).asin();
        let velocity = axes * truth.velocity_km_s;
        let limb_km = f64::from(here.distance_km);
        (0..POINTS)
            .map(|k| {
                let azimuth = first_rad + (last_rad - first_rad) * k as f64 / (POINTS - 1) as f64;
                let (sine, cosine) = azimuth.sin_cos();
                let [h0, e, c1, c2] = self.constants;
                let (cone_sine, cone_cosine) = (f64::from(here.sine), f64::from(here.cosine));
                let normal = Vector3::new(cone_cosine * cosine, cone_cosine * sine, -cone_sine);
                let latitude = (axes * pole(truth)).dot(&normal);
                let field = waves(cosine as f32, sine as f32);
                let field: f64 = field.iter().zip(&self.field).map(|(w, a)| f64::from(*w) * a).sum();
                let height_km =
                    h0 + limb_km * e + c1 * latitude + c2 * (1.0 / 3.0 - latitude * latitude) + field;
                let lifted_km = limb_km * normal.dot(&velocity) / LIGHT_KM_S;
                let noise = noise_km * generator.gaussian();
                let angle = cone_sine.asin() + (height_km + lifted_km + noise) / limb_km;
                let ray =
                    axes.transpose() * Vector3::new(angle.sin() * cosine, angle.sin() * sine, angle.cos());
                let beyond = ray.dot(&nadir).acos() - cone;
                LimbHeight {
                    radial: (ray - nadir * ray.dot(&nadir)).normalize().map(|x| x as f32),
                    height_km: there.distance_km * beyond.sin() as f32,
                    sigma_km: 0.01,
                }
            })
            .collect()
    }
}

/// How a flight ended.
struct Outcome {
    /// Normalised error squared of position and velocity.
    nees: f64,
    /// Error of the position along the local vertical, and its sigma, km.
    radial_km: [f64; 2],
}

/// A quarter of an hour over the terminator, whose shade goes along the limb from one azimuth to another, deg;
/// the start is off by as much as it says, km and km/s. The forces are the filter's own.
fn fly(sigma_km: f64, sigma_km_s: f64, shade_deg: [f64; 2], seed: u64) -> Outcome {
    const SECONDS: i64 = 900;
    const BRIGHT_END_DEG: f64 = -13.5;
    let parameters = OrbitParameters {
        dynamics: Dynamics::J2,
        misalignment_sigma_rad: 0.0,
        gravity_noise_km_s15: 0.0,
        force_noise_km_s15: 1e-9,
        ..OrbitParameters::default()
    };
    let mut generator = Generator::new(seed);
    let mut truth = circular(7_176.0, 98.6);
    let mut start = truth;
    start.position_km += generator.gaussian_vector() * sigma_km;
    start.velocity_km_s += generator.gaussian_vector() * sigma_km_s;
    let mut filter = OrbitFilter::new();
    assert!(filter.initialise(start, sigma_km, sigma_km_s, &parameters));
    let mut limb = TrueLimb::at_start(&truth, &parameters, &mut generator);
    for second in 0..SECONDS {
        truth = parameters.forces().propagate(&truth, 1_000_000).unwrap();
        limb.live(&truth, &parameters, &mut generator);
        filter.advance(truth.time_us, &parameters).unwrap();
        let predicted = *filter.state().unwrap();
        let part = second as f64 / SECONDS as f64;
        let end_deg = shade_deg[0] + part * (shade_deg[1] - shade_deg[0]);
        let arc_rad = [BRIGHT_END_DEG, end_deg].map(f64::to_radians);
        // As many independent edges as there are patches in the time of a look.
        let geometry = geometry(&truth);
        let arc_km = (arc_rad[1] - arc_rad[0]) * f64::from(geometry.circle_km());
        let patches = 1.0 + arc_km / f64::from(geometry.patch_km(&parameters));
        let look_s = f64::from(geometry.between_looks_s(&parameters).min(parameters.look_s));
        let noise_km = (f64::from(geometry.edge_km2(&parameters)) * POINTS as f64 * look_s / patches).sqrt();
        let heights = limb.seen((&truth, &predicted), arc_rad, noise_km, &mut generator);
        filter.observe_limb(&heights, RADIUS_KM, &Matrix3::identity(), &Matrix3::zeros(), &parameters);
        filter.proceed(&parameters);
    }
    let axes = radial_along_across(&truth);
    let position_km2 = filter.factor().unwrap().block(POSITION, POSITION);
    let off_km = axes * state_error(&filter, &truth).fixed_rows::<3>(0);
    Outcome {
        nees: nees(&filter, &truth),
        radial_km: [off_km.x, (axes * position_km2 * axes.transpose())[(0, 0)].sqrt()],
    }
}

/// From an error that the straight geometry bears to one that is as long as after a first fix: the arc's bend,
/// which alone tells of the distance, is a hundredth of what it must be told from.
#[test]
fn errors_are_as_stated_over_a_short_arc_that_grows_shorter() {
    const RUNS: u64 = 48;
    for (sigma_km, sigma_km_s) in [(1.0, 1e-3), (60.0, 0.06)] {
        let outcomes: Vec<Outcome> =
            (0..RUNS).map(|seed| fly(sigma_km, sigma_km_s, [7.7, -3.2], seed)).collect();
        let mean = |of: fn(&Outcome) -> f64| outcomes.iter().map(of).sum::<f64>() / RUNS as f64;
        let nees = mean(|outcome| outcome.nees);
        let [error, sigma] = [mean(|o| o.radial_km[0].powi(2)), mean(|o| o.radial_km[1].powi(2))];
        std::println!(
            "{sigma_km} km at the start: NEES {nees:.2} of 6, radial {:.1} km, said {:.1}",
            error.sqrt(),
            sigma.sqrt()
        );
        // 99 % of a chi-square of 288 degrees.
        assert!((229.8 / 48.0..353.8 / 48.0).contains(&nees), "{sigma_km} km: NEES {nees}");
    }
}
