//! `sil-host centroids`: how well stars are centred, beside what is possible and what the thesis reached.
//!
//! In: a scenario's camera, optics and detector. Out: a table by magnitude. Stars of B-V = [`COLOUR`] stand
//! at random places of the detector, one at a time, with photon, dark, read and quantisation noise; pixels
//! are all alike (no fixed patterns, no banding), as in the bound. Each is centred twice by the flight code:
//! by the centre of intensity, and with the lens's calibration.
//!
//! Scatter: of the centroid about that of the same star without noise. Systematic: of the latter about the
//! true place. Both root mean square, px an axis. Bound: Cramer-Rao ([`crate::bound`]), root mean square over
//! the same places. Honesty: mean of (error / reported sigma)², 1 when sigmas are honest. Figures depend on
//! seed and scenario alone.

use crate::bound;
use crate::calibration::centroid::{COLOUR, Lens, find, window_about};
use crate::cli::CentroidsArguments;
use crate::error::HostError;
use crate::flight::{self, StarCalibration};
use crate::scenario::Scenario;
use crate::world::detector::fixed_pattern::PatternModel;
use crate::world::lens::optics::Optics;
use crate::world::noise::{Noise, Stream};
use crate::world::sky::stars::DetectorModel;
use fsw_core::image::calibration::Calibration;
use std::process::ExitCode;

/// Magnitudes of the table.
pub const MAGNITUDES: [f64; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
/// No star stands nearer to the detector's edge, px.
const MARGIN_PX: f64 = 20.0;
/// What the thesis reached, px.
pub const THESIS_PX: f64 = 0.1;
/// A centroid so far from its star is another's, px.
const FOUND_PX: f64 = 3.0;

/// Errors of one method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Root mean square scatter, px an axis.
    pub scatter_px: f64,
    /// Root mean square error without noise, px an axis.
    pub systematic_px: f64,
    /// Mean of (error / reported sigma)².
    pub normalised_square: f64,
    /// Share of the stars that were found with and without noise.
    pub found: f64,
}

/// A line of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Magnitude V.
    pub magnitude: f64,
    /// Cramer-Rao bound, px an axis.
    pub bound_px: f64,
    /// By the centre of intensity.
    pub before: Errors,
    /// With the calibration.
    pub after: Errors,
}

/// What is drawn.
pub struct Sky<'a> {
    /// The lens.
    pub lens: &'a Lens,
    /// The camera as it is, and as it is believed to be: centroids are wanted where the latter has the star.
    pub optics: [&'a Optics; 2],
    /// Its detector; patterns are left out.
    pub detector: DetectorModel,
    /// Bits of the converter.
    pub bits: u8,
    /// Columns and rows, px.
    pub size_px: [u16; 2],
    /// Exposure, s.
    pub exposure_s: f64,
    /// Stars a magnitude.
    pub stars: u32,
    /// Seed of places and noise.
    pub seed: u64,
}

/// Squares that become an [`Errors`].
#[derive(Default)]
struct Tally {
    scatter: f64,
    systematic: f64,
    normalised: f64,
    count: f64,
}

impl Tally {
    fn add(&mut self, truth: [f64; 2], quiet: [f64; 2], (seen, sigma): ([f64; 2], f64)) {
        for k in 0..2 {
            self.scatter += (seen[k] - quiet[k]).powi(2);
            self.systematic += (quiet[k] - truth[k]).powi(2);
            self.normalised += ((seen[k] - truth[k]) / sigma).powi(2);
            self.count += 1.0;
        }
    }

    fn errors(&self, stars: u32) -> Errors {
        let mean = |sum: f64| sum / self.count.max(1.0);
        Errors {
            scatter_px: mean(self.scatter).sqrt(),
            systematic_px: mean(self.systematic).sqrt(),
            normalised_square: mean(self.normalised),
            found: self.count / f64::from(2 * stars),
        }
    }
}

impl Sky<'_> {
    /// The line of one magnitude.
    pub fn line(&self, magnitude: f64, calibration: &Calibration) -> Line {
        let electrons = self.detector.star_e_s(magnitude) * self.exposure_s;
        let dark_e = self.detector.dark_now_e_s() * self.exposure_s;
        let gain = self.detector.gain_e_per_dn(self.bits);
        let read_e = self.detector.read_noise_e;
        let variance_e2 = dark_e + read_e * read_e + gain * gain / 12.0;
        let converter = self.detector.converter(self.bits);
        let places = Noise::new(self.seed, 0, Stream::Attitude);
        let (mut bound, mut before, mut after) = (0.0, Tally::default(), Tally::default());
        for star in 0..self.stars {
            let at = [0, 1].map(|k| {
                let room = f64::from(self.size_px[k]) - 2.0 * MARGIN_PX;
                MARGIN_PX + room * places.uniform(star, k as u32)
            });
            let [true_optics, believed] = self.optics;
            let Some(wanted) = true_optics.unproject(at).and_then(|sight| believed.project(sight)) else {
                continue;
            };
            let window = window_about(at);
            let image = |at: [f64; 2]| {
                let mut light = vec![0.0; window.area()];
                self.lens.draw(
                    self.detector.response,
                    &self.lens.spot(at, electrons, COLOUR),
                    window,
                    &mut light,
                );
                light
            };
            let [x, y] = bound::centroid_px(image, at, variance_e2);
            bound += x * x + y * y;
            let cycle = u64::from(star) + (magnitude * 1e6) as u64;
            let (photons, readout) =
                (Noise::new(self.seed, cycle, Stream::Photon), Noise::new(self.seed, cycle, Stream::Read));
            // The readout takes the dark current's mean off again, as the pedestal is set without it.
            let mut electrons: Vec<f64> = image(at).iter().map(|light| light + dark_e).collect();
            for (row, line) in (0..).zip(electrons.chunks_exact_mut(usize::from(window.width))) {
                photons.read_row((0, row), line, &readout, read_e);
            }
            let pixels: Vec<_> =
                electrons.iter().map(|electrons| converter.digital_number(*electrons)).collect();
            for (tally, calibration) in [(&mut before, None), (&mut after, Some(calibration))] {
                let quiet = self.lens.measured(at, COLOUR, calibration);
                let seen = find(window, self.bits, pixels.clone(), calibration, at);
                if let (Some(quiet), Some(seen)) = (quiet, seen)
                    && (0..2).all(|k| (seen.0[k] - at[k]).abs() < FOUND_PX)
                {
                    tally.add(wanted, quiet, seen);
                }
            }
        }
        let bound_px = (bound / f64::from(2 * self.stars)).sqrt();
        Line { magnitude, bound_px, before: before.errors(self.stars), after: after.errors(self.stars) }
    }
}

/// Prints the table.
///
/// # Errors
/// When the scenario cannot be read or its lens not be calibrated.
pub fn run(arguments: &CentroidsArguments) -> Result<ExitCode, HostError> {
    let scenario = Scenario::named(arguments.scenario.as_deref())?;
    let detector = DetectorModel { pattern: PatternModel::NONE, ..scenario.detector };
    let lens = Lens::new(&scenario.camera, &scenario.imaging, &detector)?;
    let made = scenario.calibration()?;
    let calibration = made.as_ref().and_then(StarCalibration::open).ok_or_else(|| {
        HostError::usage("this camera has no calibration", "give a camera whose optical centre lies on it")
    })?;
    let exposure_s =
        arguments.exposure_ms.map_or(f64::from(scenario.exposure_us) * 1e-6, |ms| 1e-3 * f64::from(ms));
    let camera = flight::calibrated_camera(&scenario.camera);
    let optics = [&scenario.camera, &camera].map(Optics::new);
    let [Some(true_optics), Some(believed)] = &optics else {
        return Err(HostError::usage("the world draws rectilinear cameras only", "give another camera"));
    };
    let sky = Sky {
        lens: &lens,
        optics: [true_optics, believed],
        detector,
        bits: scenario.camera.bits,
        size_px: [scenario.camera.width_px, scenario.camera.height_px],
        exposure_s,
        stars: arguments.stars,
        seed: arguments.seed,
    };
    print_line!(
        "Centroids, px an axis, {} stars a line, exposure {:.0} ms; thesis {THESIS_PX}",
        sky.stars,
        1e3 * exposure_s
    );
    print_line!("                   centre of intensity                     with the lens's calibration");
    print_line!("  V    bound   scatter  /bound  systematic  honesty   scatter  /bound  systematic  honesty");
    for magnitude in MAGNITUDES {
        let line = sky.line(magnitude, &calibration);
        let errors = |errors: &Errors| {
            format!(
                "{:.4}  {:6.2}      {:.4}   {:6.2}",
                errors.scatter_px,
                errors.scatter_px / line.bound_px,
                errors.systematic_px,
                errors.normalised_square
            )
        };
        print_line!(
            "{magnitude:3.0}   {:.4}    {}    {}",
            line.bound_px,
            errors(&line.before),
            errors(&line.after)
        );
    }
    Ok(ExitCode::SUCCESS)
}
