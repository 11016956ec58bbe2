//! `cycles.csv`: a row a second.
//!
//! Whole lines only are handed to the system, every few hundred or after a second of waiting, so that a run
//! that is killed leaves a file that can be read up to its last full line. An empty field is a value that was
//! not there. Quaternions are `x, y, z, w` from ICRS to star path; `rac` is radial, along, cross. Gyro and
//! magnetometer readings are in the axes of the Earth path; `rate_*_deg_s` is the rate found without an
//! attitude, star path axes. `faults` is what the scenario breaks, `reported_faults` what the sensor reports.

use crate::error::HostError;
use crate::judge::arcsec;
use crate::judge::expected::{mode_of, word};
use crate::judge::second::Axes;
use crate::output::PartialFile;
use crate::run::faults;
use crate::run::harness::Second;
use crate::run::status::{activity_word, fault_words, status_word};
use crate::world::scene::SensorState;
use fsw_core::telemetry::{EarthStatus, RateSource};
use std::fmt::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

/// Most lines kept back.
const LINES: u32 = 256;
/// Longest time for which lines are kept back.
const PATIENCE: Duration = Duration::from_secs(1);

/// The columns.
pub const HEADER: &str = "cycle,t_s,mode,expected_mode,sensor_state,lit_limb_deg,status,earth_status,\
stars,detections,limb_points,\
true_qx,true_qy,true_qz,true_qw,qx,qy,qz,qw,\
attitude_error_x_arcsec,attitude_error_y_arcsec,attitude_error_z_arcsec,\
attitude_sigma_x_arcsec,attitude_sigma_y_arcsec,attitude_sigma_z_arcsec,\
true_x_km,true_y_km,true_z_km,true_vx_km_s,true_vy_km_s,true_vz_km_s,\
x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s,\
sigma_x_km,sigma_y_km,sigma_z_km,sigma_vx_km_s,sigma_vy_km_s,sigma_vz_km_s,\
position_error_radial_km,position_error_along_km,position_error_cross_km,\
velocity_error_radial_m_s,velocity_error_along_m_s,velocity_error_cross_m_s,\
earth_error_x_deg,earth_error_y_deg,earth_sigma_deg,distance_error_km,distance_sigma_km,\
limb_inliers,limb_arc_deg,limb_rms_px,\
limb_height_km,limb_height_sigma_km,nis,nis_freedom,since_fix_s,settled,events,faults,\
rate_error_x_arcsec_s,rate_error_y_arcsec_s,rate_error_z_arcsec_s,\
gyro_x_deg_s,gyro_y_deg_s,gyro_z_deg_s,magnetometer_x_ut,magnetometer_y_ut,magnetometer_z_ut,\
true_rate_x_deg_s,true_rate_y_deg_s,true_rate_z_deg_s,rate_x_deg_s,rate_y_deg_s,rate_z_deg_s,\
rate_sigma_x_deg_s,rate_sigma_y_deg_s,rate_sigma_z_deg_s,rate_source,rate_either_sense,\
rate_error_percent,rate_axis_error_deg,\
filtered_error_x_arcsec,filtered_error_y_arcsec,filtered_error_z_arcsec,\
filtered_sigma_x_arcsec,filtered_sigma_y_arcsec,filtered_sigma_z_arcsec,activity,reported_faults";

/// A row under way: fields appended, each led by a comma but the first.
struct Row<'a> {
    text: &'a mut String,
    first: bool,
}

impl Row<'_> {
    fn put(&mut self, field: std::fmt::Arguments<'_>) {
        if !self.first {
            self.text.push(',');
        }
        self.first = false;
        // Writing to a String cannot fail.
        let _ = self.text.write_fmt(field);
    }

    fn word(&mut self, word: &str) {
        self.put(format_args!("{word}"));
    }

    fn number(&mut self, value: f64, digits: usize) {
        self.put(format_args!("{value:.digits$}"));
    }

    fn optional(&mut self, value: Option<f64>, digits: usize) {
        match value {
            Some(value) => self.number(value, digits),
            None => self.word(""),
        }
    }

    fn several<const N: usize>(&mut self, values: Option<[f64; N]>, digits: usize) {
        for index in 0..N {
            self.optional(values.map(|values| values[index]), digits);
        }
    }

    fn axes(&mut self, axes: Option<Axes>, scale: f64, digits: usize) {
        self.several(axes.map(|axes| axes.error.map(|error| error * scale)), digits);
    }
}

/// What came of looking for the Earth, in a word.
fn earth_word(status: EarthStatus) -> &'static str {
    use fsw_core::earth::FitError;
    match status {
        EarthStatus::NotLooked => "not-looked",
        EarthStatus::Dark => "dark",
        EarthStatus::Faint => "faint",
        EarthStatus::Found => "found",
        EarthStatus::Refused(FitError::TooFewPoints) => "too-few-points",
        EarthStatus::Refused(FitError::NoConsensus) => "no-consensus",
        EarthStatus::Refused(FitError::ShortArc) => "short-arc",
        EarthStatus::Refused(FitError::Degenerate) => "degenerate",
        EarthStatus::Refused(FitError::Uncertain) => "uncertain",
    }
}

/// A geometry's number in the thesis's table 8.1.
fn state_number(state: SensorState) -> u8 {
    state as u8
}

/// Appends the row of a second.
pub fn append(second: &Second<'_>, text: &mut String) {
    let Second { report, truth, judged, .. } = *second;
    let mut row = Row { text, first: true };
    row.put(format_args!("{}", second.cycle));
    row.optional(report.instant_us.map(|us| us as f64 * 1e-6), 3);
    row.word(word(report.mode));
    row.word(word(mode_of(truth.state)));
    row.put(format_args!("{}", state_number(truth.state)));
    row.number(truth.lit_limb_deg, 1);
    row.word(status_word(report));
    row.word(earth_word(report.earth_status));
    for count in [judged.stars, judged.detections, judged.limb_points] {
        row.put(format_args!("{count}"));
    }
    row.several(Some(truth.quaternion), 9);
    row.several(report.attitude.map(|attitude| attitude.quaternion.map(f64::from)), 9);
    attitude(&mut row, judged.attitude_rad);
    row.several(Some(truth.position_km), 6);
    row.several(Some(truth.velocity_km_s), 9);
    row.several(report.orbit.map(|orbit| orbit.position_km), 6);
    row.several(report.orbit.map(|orbit| orbit.velocity_km_s), 9);
    row.several(judged.orbit.map(|orbit| orbit.position_km.sigma), 6);
    row.several(judged.orbit.map(|orbit| orbit.velocity_km_s.sigma), 9);
    row.axes(judged.orbit.map(|orbit| orbit.position_rac_km), 1.0, 6);
    row.axes(judged.orbit.map(|orbit| orbit.velocity_rac_km_s), 1e3, 5);
    let earth = judged.earth;
    row.several(earth.map(|earth| earth.across_rad.map(f64::to_degrees)), 6);
    row.optional(earth.map(|earth| earth.sigma_rad.to_degrees()), 6);
    row.several(earth.map(|earth| [earth.distance_km, earth.sigma_km]), 4);
    row.optional(report.earth.map(|earth| earth.inliers.into()), 0);
    row.several(report.earth.map(|earth| [earth.arc_deg.into(), earth.rms_px.into()]), 3);
    row.several(judged.orbit.map(|orbit| orbit.limb_height_km), 4);
    row.several(judged.orbit.and_then(|orbit| orbit.nis), 4);
    row.optional(judged.orbit.map(|orbit| orbit.since_fix_s.into()), 0);
    row.optional(judged.orbit.map(|orbit| f64::from(u8::from(orbit.settled))), 0);
    let events: Vec<String> = report.events.iter().map(super::events::words).collect();
    row.word(&events.join("; "));
    row.word(&faults::words(second.faults, second.cycle));
    row.several(judged.rate_rad_s.map(|rate| rate.map(arcsec)), 3);
    row.several(second.rate.map(|rate| rate.rad_s.map(|rad_s| f64::from(rad_s).to_degrees())), 4);
    row.several(second.field.map(|field| field.ut.map(f64::from)), 4);
    turning(&mut row, second);
    attitude(&mut row, judged.filtered_rad);
    row.word(activity_word(report.activity));
    row.word(&fault_words(report));
    text.push('\n');
}

/// The true rate, and the one found without an attitude.
fn turning(row: &mut Row<'_>, second: &Second<'_>) {
    let (rate, error) = (second.report.rate, second.judged.turning);
    row.several(Some(second.truth.rate_rad_s.map(f64::to_degrees)), 6);
    row.several(rate.map(|rate| rate.rad_s.map(|rad_s| f64::from(rad_s).to_degrees())), 6);
    row.several(rate.map(|rate| rate.sigma_rad_s.map(|sigma| f64::from(sigma).to_degrees())), 6);
    row.word(rate.map_or("", |rate| match rate.source {
        RateSource::Streaks => "streaks",
        RateSource::Images => "images",
        RateSource::Both => "streaks+images",
    }));
    row.optional(rate.map(|rate| f64::from(u8::from(rate.either_sense))), 0);
    row.several(error.map(|error| [100.0 * error.size, error.axis_deg]), 4);
}

fn attitude(row: &mut Row<'_>, attitude: Option<Axes>) {
    row.several(attitude.map(|attitude| attitude.error.map(arcsec)), 3);
    row.several(attitude.map(|attitude| attitude.sigma.map(arcsec)), 3);
}

/// The file under way.
#[derive(Debug)]
pub struct CyclesFile {
    file: PartialFile,
    text: String,
    lines: u32,
    written: Instant,
}

impl CyclesFile {
    /// Makes the file and writes its header.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn create(path: &Path) -> Result<Self, HostError> {
        let (file, text) = (PartialFile::create(path)?, format!("{HEADER}\n"));
        let mut cycles = Self { file, text, lines: 0, written: Instant::now() };
        cycles.flush()?;
        Ok(cycles)
    }

    /// Adds the row of a second; gives whether lines were handed to the system.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn add(&mut self, second: &Second<'_>) -> Result<bool, HostError> {
        append(second, &mut self.text);
        self.lines += 1;
        let due = self.lines >= LINES || self.written.elapsed() >= PATIENCE;
        if due {
            self.flush()?;
        }
        Ok(due)
    }

    fn flush(&mut self) -> Result<(), HostError> {
        self.file.write(self.text.as_bytes())?;
        self.text.clear();
        self.lines = 0;
        self.written = Instant::now();
        Ok(())
    }

    /// Hands over what is left and gives the file its name.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn finish(mut self) -> Result<(), HostError> {
        self.flush()?;
        self.file.finish()
    }
}
