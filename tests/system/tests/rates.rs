//! Rates without an attitude: rendered skies turn, the sensor's own second tells how fast.

use catalog_gen::parameters::DEFAULT_EPOCH_YEAR;
use fsw_core::sensor::{Command, Instruments, Workspace};
use fsw_core::telemetry::{RateReport, Report, Status};
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Instant, Window};
use sil_host::camera_file::CameraFile;
use sil_host::world::attitude::{normalised, uniform};
use sil_host::world::disturbances::Disturbances;
use sil_host::world::imaging::ImagingModel;
use sil_host::world::motion::Motion;
use sil_host::world::noise::{Noise, Stream};
use sil_host::world::protons::Protons;
use sil_host::world::scene::{Scene, SceneSettings};
use sil_host::world::shutter::Shutter;
use sil_host::world::stars::DetectorModel;
use sil_host::{flight, star_scene};

/// Seconds flown of each turning; the first is the self-test.
const SECONDS: u32 = 9;
/// Turnings of each rate.
const CASES: u64 = 12;

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
        parameters.row_time_ns = (self.row_time_s * 1e9).round() as u32;
        let mut sensor = flight::sensor(catalogue, None, parameters, &mut workspace).unwrap();
        let start_us = ((DEFAULT_EPOCH_YEAR - 2000.0) * 365.25 * 86_400e6) as i64;
        (0..seconds)
            .map(|second| {
                let mut clock = Instant(start_us + i64::from(second) * 1_000_000);
                let mut detector = Frame { scene: &mut self.scene, cycle: second.into(), pixels: Vec::new() };
                let mut instruments =
                    Instruments { detector: &mut detector, clock: &mut clock, meter: &mut () };
                sensor.cycle(&mut instruments, Command::Continue)
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

impl Detector for Frame<'_> {
    fn geometry(&self) -> DetectorGeometry {
        self.scene.geometry()
    }
    fn expose(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        self.scene.expose_cycle(self.cycle, exposure_us)?;
        let whole = self.geometry().whole();
        self.pixels.resize(whole.area(), 0);
        self.scene.read(whole, &mut self.pixels)
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

/// A rate against the truth: its size off by a share, its axis by deg, the largest error over its sigma, whether its sense is
/// the right one.
struct Error {
    size: f64,
    axis_deg: f64,
    sigmas: f64,
    right_sense: bool,
}

fn length(vector: [f64; 3]) -> f64 {
    vector.iter().map(|part| part * part).sum::<f64>().sqrt()
}

fn error(rate: &RateReport, truth: [f64; 3]) -> Error {
    let found = rate.rad_s.map(f64::from);
    let cosine = (0..3).map(|k| found[k] * truth[k]).sum::<f64>() / length(found) / length(truth);
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

#[test]
fn explore() {
    let rates = std::env::var("RATES").unwrap_or("0.5,1,2,4,8,15".into());
    let cases: u64 = std::env::var("CASES").ok().and_then(|c| c.parse().ok()).unwrap_or(CASES);
    for rate_deg_s in rates.split(',').map(|rate| rate.parse::<f64>().unwrap()) {
        let (mut sizes, mut axes, mut within, mut firsts, mut said, mut all, mut wrong) =
            (vec![], vec![], 0, vec![], 0, 0, 0);
        for case in 0..cases {
            let mut world = World::new(case, rate_deg_s, Shutter::Global);
            let reports = world.fly(SECONDS);
            let mut first = None;
            let mut line = String::new();
            for report in &reports[1..] {
                if report.attitude.is_some() {
                    line += " attitude";
                    continue;
                }
                all += 1;
                line += &format!(" {:?}/{}", report.status, report.detections)
                    .replace("NotIdentified", "No")
                    .replace("TooFast", "Fast");
                let Some(rate) = &report.rate else { continue };
                said += 1;
                let error = error(rate, world.rate_rad_s);
                if !rate.either_sense {
                    first.get_or_insert(report.cycle);
                }
                line += &format!(
                    "[{:?}{} {} {:+.2}% {:.2}deg {:.1}s]",
                    rate.source,
                    if rate.either_sense { "+-" } else { "" },
                    rate.stars,
                    error.size * 100.0,
                    error.axis_deg,
                    error.sigmas
                );
                sizes.push(error.size.abs() * 100.0);
                axes.push(error.axis_deg);
                within += u32::from(error.sigmas <= 3.0);
                wrong += u32::from(!error.right_sense);
            }
            println!("{rate_deg_s} case {case}:{line}");
            firsts.push(first.map_or(99.0, f64::from));
        }
        println!(
            "== {rate_deg_s} deg/s: {said} of {all}, size {:.2} %, axis {:.3} deg, within 3 sigma {within}, wrong {wrong}, first {:.1}: {firsts:?}",
            median(&mut sizes),
            median(&mut axes),
            median(&mut firsts.clone())
        );
    }
}
