use super::*;
use crate::earth::centre::{RayBuffer, centre};
use crate::earth::test_world::{World, camera, geostationary, low, parameters};
use crate::earth::{FitCriteria, LimbPoint};
use crate::oracle::{self, Generator, wide, wide_matrix};
use std::vec::Vec;

/// `x K₁(x)` by `K₁(x) = ∫ exp(-x cosh t) cosh t dt`, t from 0 (Abramowitz and Stegun 9.6.24).
fn matern(x: f64) -> f64 {
    if x < 1e-6 {
        return 1.0;
    }
    let step = 1e-3;
    (0..12_000)
        .map(|k| (f64::from(k) + 0.5) * step)
        .map(|t| x * (-x * t.cosh()).exp() * t.cosh() * step)
        .sum()
}

#[test]
fn the_waves_have_the_stated_correlation() {
    // K₁(1) = 0.601907 (Abramowitz and Stegun, table 9.8).
    assert!((matern(1.0) - 0.601_907).abs() < 1e-5);
    let world = low(800.0, 70.0, [40.0, 30.0], 1);
    let mut parameters = parameters();
    parameters.horizon.cell_km = 500.0;
    let body = world.body(&parameters);
    let range = world.centre.norm();
    let sine = (6378.0 / range) as f32;
    let cosine = libm::sqrtf(1.0 - sine * sine);
    let cone = Cone { axis: world.centre.normalize().map(|part| part as f32), sine, cosine };
    let [heights, _] = SharedHeights::new(&cone, &body, 1e-3, &parameters).fields;
    let total: f32 = (0..MODES).map(|wave| heights.share(wave)).sum();
    let radius_km = f64::from(body.radius_km() * cosine);
    for distance_km in [0.0, 250.0, 500.0, 1000.0, 2000.0] {
        let angle = distance_km / radius_km;
        let correlation: f64 =
            (0..MODES).map(|wave| f64::from(heights.share(wave) / total) * (angle * wave as f64).cos()).sum();
        let expected = matern(distance_km / 500.0);
        std::println!("{distance_km} km: {correlation:.3}, {expected:.3}");
        // The waves left out hold 4 % of the variance.
        assert!((correlation - expected).abs() < 0.04, "{distance_km} km");
    }
}

/// Limb points between two azimuths whose heights are drawn from the field: standard deviation and cell, km.
struct Scene {
    world: World,
    azimuths: Vec<f64>,
    /// Lower factor of the heights' covariance.
    factor: Vec<Vec<f64>>,
    noise_px: f64,
}

impl Scene {
    fn new(world: World, [middle, arc]: [f64; 2], count: usize, sigma_km: f64, cell_km: f64) -> Self {
        let range = world.centre.norm();
        let radius_km = 6378.0 * (1.0 - (6378.0 / range).powi(2)).sqrt();
        let azimuths: Vec<f64> =
            (0..count).map(|k| middle + arc * ((k as f64 + 0.5) / count as f64 - 0.5)).collect();
        let covariance = |i: usize, j: usize| {
            let apart = (azimuths[i] - azimuths[j]).abs();
            let around = apart.min(std::f64::consts::TAU - apart);
            let own = if i == j { 1e-6 } else { 0.0 };
            sigma_km * sigma_km * (matern(around * radius_km / cell_km) + own)
        };
        // Cholesky's.
        let mut factor = std::vec![std::vec![0.0; count]; count];
        for i in 0..count {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
                let left = covariance(i, j) - known;
                factor[i][j] = if i == j { left.sqrt() } else { left / factor[j][j] };
            }
        }
        Self { world, azimuths, factor, noise_px: 0.4 }
    }

    fn points(&self, generator: &mut Generator) -> Vec<LimbPoint> {
        let camera = oracle::reference_camera();
        let mean_km = f64::from(parameters().limb.height_km);
        let chances: Vec<f64> = self.azimuths.iter().map(|_| generator.gaussian()).collect();
        let heights = self.factor.iter().map(|row| row.iter().zip(&chances).map(|(f, g)| f * g).sum::<f64>());
        let heights: Vec<f64> = heights.collect();
        let point = |(azimuth, height): (&f64, &f64)| {
            let at = |azimuth, height| oracle::project(&camera, &self.world.limb(azimuth, height));
            let [x, y] = at(*azimuth, mean_km + height);
            let [x0, y0] = at(azimuth - 1e-3, mean_km);
            let [x1, y1] = at(azimuth + 1e-3, mean_km);
            let length = (x1 - x0).hypot(y1 - y0);
            let mut normal = [(y1 - y0) / length, (x0 - x1) / length];
            let [ox, oy] = at(*azimuth, mean_km + 50.0);
            if (ox - x) * normal[0] + (oy - y) * normal[1] < 0.0 {
                normal = normal.map(|part| -part);
            }
            let noise = self.noise_px * generator.gaussian();
            LimbPoint::new(
                [(x + noise * normal[0]) as f32, (y + noise * normal[1]) as f32],
                self.noise_px as f32,
                normal.map(|part| part as f32),
            )
        };
        self.azimuths.iter().zip(&heights).map(point).collect()
    }

    /// Mean normalised square of the centre's error with the whole covariance, and with that of the points
    /// alone.
    fn nees(&self, sigma_km: f64, cell_km: f64, runs: usize) -> [f64; 2] {
        let mut parameters = parameters();
        (parameters.horizon.sigma_km, parameters.horizon.cell_km) = (sigma_km as f32, cell_km as f32);
        (parameters.plausible.sigma_deg, parameters.plausible.range_share) = (1e3, 1e3);
        let body = self.world.body(&parameters);
        let criteria = FitCriteria { tolerance_px: 30.0, min_inliers: 6, standalone: true };
        let mut generator = Generator::new(77);
        let mut sums = [0.0; 2];
        for _ in 0..runs {
            let list = self.points(&mut generator);
            let fix =
                centre(&list, &camera(), &body, &criteria, None, &parameters, &mut RayBuffer::new()).unwrap();
            let error = wide(&fix.centre_km) - self.world.centre;
            for (sum, covariance) in sums.iter_mut().zip([fix.covariance_km2, fix.noise_km2]) {
                *sum += error.dot(&(wide_matrix(&covariance).try_inverse().unwrap() * error)) / runs as f64;
            }
        }
        sums
    }
}

/// Azimuth, about the centre, of the line of sight.
fn ahead(world: &World) -> f64 {
    let axis = world.centre.normalize();
    let first = (Vector3::x() - axis * axis.x).normalize();
    axis.cross(&first).z.atan2(first.z)
}

#[test]
fn a_centre_is_as_good_as_its_covariance_where_neighbours_share_their_height() {
    let runs = 300;
    let (low_orbit, high_orbit) = (low(800.0, 70.0, [40.0, 30.0], 1), geostationary(0.0, 1));
    let middle = ahead(&low_orbit);
    for (name, world, arc, count, sigma_km, cell_km) in [
        ("800 km, 25 deg", low_orbit.clone(), [middle, 0.44], 24, 1.4, 200.0),
        ("800 km, 25 deg, long cells", low_orbit, [middle, 0.44], 24, 2.0, 600.0),
        ("geostationary, half", high_orbit.clone(), [2.0, 3.1], 24, 4.0, 1500.0),
        ("geostationary, 40 deg", high_orbit, [2.0, 0.7], 24, 4.0, 1500.0),
    ] {
        let scene = Scene::new(world, arc, count, sigma_km, cell_km);
        let [whole, points_alone] = scene.nees(sigma_km, cell_km, runs);
        std::println!("{name}: NEES {whole:.2}, with the points' own errors alone {points_alone:.1}");
        // 99.9 % of the mean of so many chi-squares of three degrees of freedom; the waves left out, Tukey's
        // weights and the enlargement by residuals that are part of the shared heights may take and give a
        // sixth.
        let band = 3.3 * (6.0 / runs as f64).sqrt() + 0.5;
        assert!((whole - 3.0).abs() < band, "{name}: {whole}");
        assert!(points_alone > whole);
    }
}
