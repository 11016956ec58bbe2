//! Rates without an attitude: rendered skies turn, the sensor's own second gives the rate.

use fsw_core::sensor::{Command, Workspace};
use fsw_core::telemetry::{Outcome, RateReport, Report};
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Instant, LocalTime, Window};
use sil_host::flight;
use sil_host::formats::camera_file::CameraFile;
use sil_host::harness::star_scene;
use sil_host::scenario::Scenario;
use sil_host::world::attitude::{normalised, uniform};
use sil_host::world::detector::disturbances::Disturbances;
use sil_host::world::detector::imaging::ImagingModel;
use sil_host::world::detector::protons::Protons;
use sil_host::world::detector::shutter::Shutter;
use sil_host::world::motion::Motion;
use sil_host::world::noise::{Noise, Stream};
use sil_host::world::scene::{Scene, SceneSettings};
use sil_host::world::sky::stars::DetectorModel;
use std::path::Path;
use system_tests::amount;

/// Seconds flown of each turning; the first is the self-test.
const SECONDS: u32 = 8;
/// Turnings of each rate; the gate tries the first of them, held to the same limits.
const CASES: u64 = 6;
const GATE_CASES: u64 = 3;

/// A turning sky behind the reference lens, with hot pixels and 20 protons an image.
struct World {
    scene: Scene,
    rate_rad_s: [f64; 3],
    row_time_s: f64,
}

impl World {
    /// Attitude and axis are drawn by `case`.
    fn new(case: u64, rate_deg_s: f64, shutter: Shutter) -> Self {
        let noise = Noise::new(0x52_41_54_45, case, Stream::Attitude);
        let attitude = uniform(&noise, 0);
        let (z, around) = (2.0 * noise.uniform(1, 0) - 1.0, std::f64::consts::TAU * noise.uniform(1, 1));
        let across = (1.0 - z * z).sqrt();
        let axis = [across * around.cos(), across * around.sin(), z];
        let rate_rad_s = axis.map(|part| part * rate_deg_s.to_radians());
        let motion = Motion::turning(normalised(attitude).unwrap(), rate_rad_s);
        let mut settings = SceneSettings::new(CameraFile::reference(), motion, 100 + case);
        settings.imaging = ImagingModel { shutter, ..ImagingModel::REFERENCE };
        settings.detector = DetectorModel::reference();
        settings.disturbances =
            Disturbances { hot_pixels: 200, protons: Protons::Fixed(20), ..Disturbances::default() };
        let scene = Scene::new(settings, &star_scene::sky()).unwrap();
        Self { scene, rate_rad_s, row_time_s: shutter.row_time_s() }
    }

    /// The sensor's reports.
    fn fly(&mut self, seconds: u32) -> Vec<Report> {
        let catalogue = flight::open(catalog_gen::REFERENCE).unwrap();
        let mut workspace = Box::new(Workspace::new());
        let mut parameters = star_scene::parameters();
        parameters.imaging.row_time_ns = (self.row_time_s * 1e9).round() as u32;
        let mut sensor = flight::sensor(catalogue, None, parameters, &mut workspace).unwrap();
        let start_us = star_scene::epoch_us();
        (0..seconds)
            .map(|second| {
                let local = LocalTime::from_us(i64::from(second) * 1_000_000);
                let mut clock = Instant::new(local, start_us + local.as_us());
                let mut detector = Frame { scene: &mut self.scene, cycle: second.into(), pixels: Vec::new() };
                flight::second(&mut sensor, &mut detector, &mut clock, Command::Continue)
            })
            .collect()
    }
}

/// The world's detector, each image drawn whole and once: windows of it are the same, and many.
struct Frame<'a> {
    scene: &'a mut Scene,
    cycle: u64,
    pixels: Vec<u16>,
}

impl fsw_hal::ErrorType for Frame<'_> {
    type Error = DetectorError;
}

impl Detector for Frame<'_> {
    fn geometry(&self) -> DetectorGeometry {
        self.scene.geometry()
    }
    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        self.scene.expose_cycle(self.cycle, exposure_us)?;
        let whole = self.geometry().whole();
        self.pixels.resize(whole.area(), 0);
        self.scene.read(whole, &mut self.pixels)
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        self.scene.finish_exposure()
    }
    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        if !window.fits(&self.geometry()) {
            return Err(DetectorError::OutsideDetector);
        }
        let width = usize::from(self.geometry().width_px);
        let rows = self.pixels.chunks_exact(width).skip(window.y.into());
        for (row, to) in rows.zip(pixels.chunks_exact_mut(window.width.into())) {
            to.copy_from_slice(&row[usize::from(window.x)..][..to.len()]);
        }
        Ok(())
    }
}

/// A rate against the truth: its size off by a share, its axis by deg, the largest error over its sigma,
/// whether its sense is the right one.
struct Error {
    size: f64,
    axis_deg: f64,
    sigmas: f64,
    right_sense: bool,
}

fn length(vector: [f64; 3]) -> f64 {
    vector.iter().map(|part| part * part).sum::<f64>().sqrt()
}

fn cosine(one: [f64; 3], other: [f64; 3]) -> f64 {
    (0..3).map(|k| one[k] * other[k]).sum::<f64>() / length(one) / length(other)
}

fn error(rate: &RateReport, truth: [f64; 3]) -> Error {
    let found = rate.rad_s.map(f64::from);
    let cosine = cosine(found, truth);
    let sense = if rate.either_sense { cosine.signum() } else { 1.0 };
    let sigmas = (0..3)
        .map(|k| ((sense * found[k] - truth[k]) / f64::from(rate.sigma_rad_s[k])).abs())
        .fold(0.0, f64::max);
    Error {
        size: length(found) / length(truth) - 1.0,
        axis_deg: (sense * cosine).clamp(-1.0, 1.0).acos().to_degrees(),
        sigmas,
        right_sense: sense * cosine > 0.0,
    }
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// What a rate comes to over several turnings.
#[derive(Default)]
struct Tally {
    /// Seconds after the self-test, those with a rate, and those with one of known sense.
    seconds: u32,
    found: u32,
    sure: u32,
    /// Of those with a rate of its own sigma, how many lie within three, and how many beyond.
    within: u32,
    beyond: u32,
    wrong: u32,
    /// Errors of the rates of known sense: size in percent, axis in deg.
    sizes: Vec<f64>,
    axes: Vec<f64>,
    /// Images until a rate, and until one of known sense.
    first: Vec<f64>,
    first_sure: Vec<f64>,
}

fn fly(rate_deg_s: f64, shutter: Shutter, cases: std::ops::Range<u64>) -> Tally {
    let mut tally = Tally::default();
    for case in cases {
        let mut world = World::new(case, rate_deg_s, shutter);
        let mut firsts = [None; 2];
        let mut line = String::new();
        for report in &world.fly(SECONDS)[1..] {
            tally.seconds += 1;
            if report.attitude.is_some() {
                // The attitudes' own rate, from the second on.
                line += " attitude";
                if let Some(rad_s) = report.rate_rad_s {
                    let found = rad_s.map(f64::from);
                    tally.found += 1;
                    tally.sure += 1;
                    firsts[0].get_or_insert(report.cycle);
                    firsts[1].get_or_insert(report.cycle);
                    tally.sizes.push(100.0 * (length(found) / length(world.rate_rad_s) - 1.0).abs());
                    tally.axes.push(cosine(found, world.rate_rad_s).clamp(-1.0, 1.0).acos().to_degrees());
                }
                continue;
            }
            let Some(rate) = &report.rate else {
                line += " -";
                continue;
            };
            let error = error(rate, world.rate_rad_s);
            tally.found += 1;
            tally.within += u32::from(error.sigmas <= 3.0);
            tally.beyond += u32::from(error.sigmas > 3.0);
            tally.wrong += u32::from(!error.right_sense);
            firsts[0].get_or_insert(report.cycle);
            let sign = if rate.either_sense { "+-" } else { "" };
            line += &format!(
                " {:?}{sign} {} {:+.2} % {:.2} deg {:.1} sigma,",
                rate.source,
                rate.stars,
                100.0 * error.size,
                error.axis_deg,
                error.sigmas
            );
            if !rate.either_sense {
                tally.sure += 1;
                firsts[1].get_or_insert(report.cycle);
                tally.sizes.push(100.0 * error.size.abs());
                tally.axes.push(error.axis_deg);
            }
        }
        println!("{rate_deg_s} deg/s, case {case}:{line}");
        tally.first.push(firsts[0].map_or(f64::INFINITY, f64::from));
        tally.first_sure.push(firsts[1].map_or(f64::INFINITY, f64::from));
    }
    println!(
        "== {rate_deg_s} deg/s: rate in {} of {} s, sense known in {}; of these size off by {:.2} %, axis by {:.2} deg (medians); \
         within 3 sigma {}, wrong sense {}; first after {} images, of known sense {} (medians)",
        tally.found,
        tally.seconds,
        tally.sure,
        median(&mut tally.sizes),
        median(&mut tally.axes),
        tally.within,
        tally.wrong,
        median(&mut tally.first),
        median(&mut tally.first_sure)
    );
    tally
}

/// Rate, deg/s; least share of seconds with a rate; medians of size and axis, percent and deg, at most;
/// images until a rate of known sense, median, at most.
const DEMANDS: [(f64, f64, f64, f64, f64); 6] = [
    (0.5, 0.6, 1.0, 1.0, 4.0),
    (1.0, 0.6, 1.0, 1.0, 4.0),
    (2.0, 0.7, 0.7, 0.7, 4.0),
    (4.0, 0.6, 0.7, 0.7, 4.0),
    (8.0, 0.25, 1.5, 1.5, f64::INFINITY),
    (15.0, 0.05, f64::INFINITY, f64::INFINITY, f64::INFINITY),
];

/// A turning camera gives its rate with honest sigmas and never a wrong sense: a row of the demands.
fn holds(row: usize) {
    let (rate_deg_s, share, size_percent, axis_deg, images) = DEMANDS[row];
    let mut tally = fly(rate_deg_s, Shutter::Global, 0..amount(GATE_CASES, CASES));
    let found = f64::from(tally.found);
    assert!(found >= share * f64::from(tally.seconds));
    assert!(17 * tally.beyond <= 3 * tally.within && tally.wrong == 0);
    if size_percent.is_finite() {
        assert!(median(&mut tally.sizes) <= size_percent);
        assert!(median(&mut tally.axes) <= axis_deg);
    }
    assert!(median(&mut tally.first_sure) <= images);
}

#[test]
fn a_rate_of_half_a_degree_a_second_is_found() {
    holds(0);
}

#[test]
fn a_rate_of_1_degree_a_second_is_found() {
    holds(1);
}

#[test]
fn a_rate_of_2_degrees_a_second_is_found() {
    holds(2);
}

#[test]
fn a_rate_of_4_degrees_a_second_is_found() {
    holds(3);
}

#[test]
fn a_rate_of_8_degrees_a_second_is_found() {
    holds(4);
}

#[test]
fn a_rate_of_15_degrees_a_second_is_found_now_and_then_and_never_wrong() {
    holds(5);
}

#[test]
fn rows_that_begin_one_after_the_other_are_allowed_for() {
    // 0.4 s of rows beside 0.4 s of exposure: a streak along the rows' order would be off by its share of the
    // detector's height.
    let mut tally = fly(4.0, Shutter::Rolling { row_time_s: 4e-4 }, 0..3);
    assert!(tally.found >= 8 && tally.wrong == 0 && 4 * tally.beyond <= tally.within);
    assert!(median(&mut tally.sizes) < 1.5);
}

#[test]
fn a_camera_at_rest_and_one_that_sees_no_stars_give_no_rate() {
    for seed in 0..3 {
        let mut world = World::new(seed, 0.0, Shutter::Global);
        assert!(
            world
                .fly(4)
                .iter()
                .all(|report| report.rate.is_none() && report.outcome != Some(Outcome::TooFast))
        );
        let dark = Scene::new(world.scene.settings().clone(), &[]).unwrap();
        let mut world = World { scene: dark, ..world };
        let reports = world.fly(8);
        assert!(reports.iter().all(|report| report.rate.is_none() && report.attitude.is_none()), "{seed}");
    }
}

/// A twentieth of a degree a second is none of a turning that leaves streaks.
const AT_REST_RAD_S: f32 = 8.7e-4;

/// Limb and clouds are lines too, and the same in every image.
#[test]
fn an_earth_at_rest_gives_no_rate() {
    for scenario in ["geo-day", "geo-inertial", "molniya"] {
        let scene = Scenario::load(Path::new(scenario)).unwrap().scene().unwrap();
        // Without stars nothing but lines is left to look for.
        let scene = Scene::new(scene.settings().clone(), &[]).unwrap();
        let mut world = World { scene, rate_rad_s: [0.0; 3], row_time_s: 0.0 };
        let reports = world.fly(24);
        let lines = reports.iter().filter(|report| report.outcome == Some(Outcome::TooFast)).count();
        println!("{scenario}: taken for streaks in {lines} of {} seconds", reports.len());
        for report in &reports {
            assert!(report.attitude.is_none(), "{scenario}");
            // What stands in image after image may be found as rest.
            let turns =
                report.rate.is_some_and(|rate| rate.rad_s.iter().any(|part| part.abs() > AT_REST_RAD_S));
            assert!(!turns, "{scenario}: {:?}", report.rate);
        }
    }
}
