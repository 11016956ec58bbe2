//! The second, top to bottom: one call a room.
//!
//! [`Sensor::cycle`] is called once a second. Acquisition: expose, scan the whole detector, identify (over several
//! seconds if need be, on the stars of that one image), report. Tracking: predict, plan windows, expose, read them,
//! match, report. The sensor remembers the last two attitudes (for the rate), the measured stars of a search under way,
//! and nothing of the image.
//!
//! Memory: [`Workspace`] holds what is large, the readout buffer of 16 KiB and the chains of identification, and can be
//! placed in a static; [`Sensor`] itself is small, and the stack serves a few KiB of lists.

use crate::camera::Camera;
use crate::catalog::Catalogue;
use crate::frames::{Icrs, Rotation, StarPath};
use crate::image::DetectionParameters;
use crate::image::scan::{self, Detections, TILE_PIXELS};
use crate::modes::{Mode, Modes, Seen};
use crate::parameters::{ParameterError, Parameters, TrackingParameters};
use crate::plan;
use crate::stars::confirm::{Confirmed, confirm};
use crate::stars::identify::{Identifier, Progress};
use crate::stars::predict::field_stars;
use crate::stars::{Field, MAX_MEASURED, Measured};
use crate::telemetry::{AttitudeReport, EarthStatus, Event, Fault, Report, StarReport, Status};
use fsw_hal::{Clock, Detector, DetectorError, Stage, StageMeter, Window};
use heapless::Vec;
use nalgebra::Vector3;

/// Most stars of an onboard catalogue.
pub const MAX_CATALOGUE_STARS: usize = 3072;
/// Most directed catalogue pairs of one separation.
pub const MAX_BASE_SIDES: usize = 1536;
/// Most triangles over one base side.
pub const MAX_TRIANGLES: usize = 512;

/// Attitudes farther apart than this give no rate, s.
pub const MAX_RATE_BASE_S: u32 = 10;

/// The instruments, as the spacecraft lends them for a second.
#[derive(Debug)]
pub struct Instruments<'a, D, C, M> {
    /// The active-pixel detector behind both paths.
    pub detector: &'a mut D,
    /// Tells the instant of the second.
    pub clock: &'a mut C,
    /// Receives the marks of the stages; `&mut ()` where nothing is measured.
    pub meter: &'a mut M,
}

/// What the spacecraft wants of this second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Command {
    /// Go on.
    #[default]
    Continue,
    /// Forget the attitude and acquire anew.
    Reacquire,
}

/// Why a sensor could not be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorError {
    /// The parameters were refused.
    Parameters(ParameterError),
    /// The catalogue holds more stars than [`MAX_CATALOGUE_STARS`].
    CatalogueTooLarge,
}

// The parts of a second are not inlined into it, so that their lists do not lie on the stack together.

/// What a second's image taught.
struct Outcome {
    status: Status,
    confirmed: Option<(Confirmed, f32)>,
    detections: u16,
}

impl Outcome {
    fn nothing(status: Status, detections: usize) -> Self {
        Self { status, confirmed: None, detections: detections.min(usize::from(u16::MAX)) as u16 }
    }
}

/// An attitude found, and when.
#[derive(Clone, Copy)]
struct Known {
    attitude: Rotation<Icrs, StarPath>,
    /// Cycle in which its image was taken.
    cycle: u32,
}

/// What the sensor needs room for; all zero at first, so that a static of it costs no flash.
#[derive(Debug)]
pub struct Workspace {
    buffer: [u16; TILE_PIXELS],
    detections: Detections,
    measured: Vec<Measured, MAX_MEASURED>,
    identifier: Identifier<MAX_CATALOGUE_STARS, MAX_BASE_SIDES, MAX_TRIANGLES>,
}

impl Default for Workspace {
    fn default() -> Self {
        Self::new()
    }
}

impl Workspace {
    /// An empty workspace.
    pub const fn new() -> Self {
        Self {
            buffer: [0; TILE_PIXELS],
            detections: Detections::new(),
            measured: Vec::new(),
            identifier: Identifier::new(),
        }
    }

    /// Turns the brightest spots into measured directions.
    fn take_measured(&mut self, camera: &Camera) {
        self.measured.clear();
        let spots = self.detections.spots().iter();
        for star in spots.filter_map(|spot| Measured::from_detection(camera, spot)) {
            if self.measured.push(star).is_err() {
                break;
            }
        }
    }

    /// Reads the windows of the present image and finds their stars.
    fn read_windows(
        &mut self,
        detector: &mut impl Detector,
        windows: &[Window],
        parameters: &DetectionParameters,
    ) -> Result<(), DetectorError> {
        self.detections.clear();
        for window in windows {
            scan::read_stars(detector, *window, &mut self.buffer, parameters, &mut self.detections)?;
        }
        self.detections.sort();
        Ok(())
    }
}

/// The Earth/star sensor in its first form: stars to attitude.
pub struct Sensor<'c> {
    catalogue: Catalogue<'c>,
    camera: Camera,
    parameters: Parameters,
    modes: Modes,
    cycle: u32,
    known: Option<Known>,
    rate_rad_s: Option<Vector3<f32>>,
    /// Cycle in which the image under search was taken.
    searching_since: Option<u32>,
    workspace: &'c mut Workspace,
}

impl<'c> Sensor<'c> {
    /// A sensor that knows nothing yet.
    ///
    /// # Errors
    /// Impossible parameters, or a catalogue beyond the workspace.
    pub fn new(
        catalogue: Catalogue<'c>,
        parameters: Parameters,
        workspace: &'c mut Workspace,
    ) -> Result<Self, SensorError> {
        let camera = parameters.check().map_err(SensorError::Parameters)?;
        if catalogue.star_count() > MAX_CATALOGUE_STARS {
            return Err(SensorError::CatalogueTooLarge);
        }
        Ok(Self {
            catalogue,
            camera,
            parameters,
            modes: Modes::default(),
            cycle: 0,
            known: None,
            rate_rad_s: None,
            searching_since: None,
            workspace,
        })
    }

    /// One second.
    pub fn cycle<D: Detector, C: Clock, M: StageMeter>(
        &mut self,
        instruments: &mut Instruments<D, C, M>,
        command: Command,
    ) -> Report {
        if command == Command::Reacquire {
            self.forget();
        }
        let mode = self.modes.mode();
        let instant_us = instruments.clock.instant_us();
        let (width, height) = (self.parameters.camera.width_px, self.parameters.camera.height_px);
        let geometry = instruments.detector.geometry();
        let outcome = if (geometry.width_px, geometry.height_px) != (width, height) {
            Outcome::nothing(Status::DetectorFault(Fault::Geometry), 0)
        } else {
            match mode {
                Mode::SelfTest => Outcome::nothing(Status::Proved, 0),
                Mode::Acquisition => self.acquire(instruments),
                Mode::Tracking | Mode::Eclipse => self.track(instruments),
                Mode::SunOutage | Mode::Safe => Outcome::nothing(Status::Waiting, 0),
            }
        };
        let mut report = self.learn(mode, outcome);
        report.instant_us = instant_us;
        let seen = Seen {
            attitude: report.attitude.is_some(),
            rate: self.rate_rad_s.is_some(),
            fault: matches!(report.status, Status::DetectorFault(_)),
            ..Seen::default()
        };
        if let Some(guard) = self.modes.next(&seen, &self.parameters.modes) {
            let _ = report.events.push(Event::Mode(self.modes.mode(), guard));
            if self.modes.mode() == Mode::Acquisition {
                self.forget();
            }
        }
        self.cycle = self.cycle.wrapping_add(1);
        report
    }

    /// Drops what was known of the attitude.
    fn forget(&mut self) {
        self.modes.enter(Mode::Acquisition);
        self.known = None;
        self.rate_rad_s = None;
        self.searching_since = None;
    }

    /// Lost in space: scan, then identify; a search that needs longer goes on with the same image.
    #[inline(never)]
    fn acquire(
        &mut self,
        instruments: &mut Instruments<impl Detector, impl Clock, impl StageMeter>,
    ) -> Outcome {
        let Workspace { buffer, detections, .. } = &mut *self.workspace;
        if self.searching_since.is_none() {
            instruments.meter.begin(Stage::Scan);
            let detector = &mut *instruments.detector;
            let scanned = detector
                .expose(self.parameters.exposure_us)
                .and_then(|()| scan::scan(detector, buffer, &self.parameters.detection, detections));
            instruments.meter.end(Stage::Scan);
            if let Err(error) = scanned {
                return Outcome::nothing(Status::DetectorFault(error.into()), 0);
            }
            self.workspace.take_measured(&self.camera);
            self.workspace.identifier.restart(0.0);
            self.searching_since = Some(self.cycle);
        }
        let Workspace { detections, measured, identifier, .. } = &mut *self.workspace;
        let found = detections.spots().len();
        let field = Field::whole(measured, &self.catalogue, &self.camera);
        instruments.meter.begin(Stage::Identify);
        let progress =
            identifier.advance(&field, &self.parameters.identification, self.parameters.pairs_per_cycle);
        instruments.meter.end(Stage::Identify);
        match progress {
            Progress::Searching => Outcome::nothing(Status::Searching, found),
            Progress::NotIdentified(reason) => {
                self.searching_since = None;
                Outcome::nothing(Status::NotIdentified(reason), found)
            }
            Progress::Identified(confirmed, log10_false) => Outcome {
                confirmed: Some((confirmed, log10_false)),
                ..Outcome::nothing(Status::Identified, found)
            },
        }
    }

    /// The attitude expected in this second.
    fn predict(&self) -> Option<Rotation<Icrs, StarPath>> {
        let (known, rate) = (self.known?, self.rate_rad_s?);
        Some(known.attitude.turned(&(rate * self.cycle.wrapping_sub(known.cycle) as f32)))
    }

    /// Follows known stars in windows about their predicted places.
    #[inline(never)]
    fn track(
        &mut self,
        instruments: &mut Instruments<impl Detector, impl Clock, impl StageMeter>,
    ) -> Outcome {
        let TrackingParameters { gate_px, fewest_stars, .. } = self.parameters.tracking;
        instruments.meter.begin(Stage::Predict);
        let prediction = self.predict().and_then(|attitude| {
            let predicted = field_stars(&self.catalogue, &self.camera, &attitude)?;
            Some((attitude, plan::star_windows(&predicted, &instruments.detector.geometry(), gate_px)))
        });
        instruments.meter.end(Stage::Predict);
        let Some((attitude, windows)) = prediction else { return Outcome::nothing(Status::Lost, 0) };

        instruments.meter.begin(Stage::Windows);
        let detector = &mut *instruments.detector;
        let read = detector
            .expose(self.parameters.exposure_us)
            .and_then(|()| self.workspace.read_windows(detector, &windows, &self.parameters.detection));
        instruments.meter.end(Stage::Windows);
        if let Err(error) = read {
            return Outcome::nothing(Status::DetectorFault(error.into()), 0);
        }

        self.workspace.take_measured(&self.camera);
        let measured = &self.workspace.measured;
        let field = Field::windows(measured, &self.catalogue, &self.camera, plan::searched_px(&windows));
        instruments.meter.begin(Stage::Confirm);
        // Matching begins with twice the tolerance: with the whole gate.
        let confirmed = confirm(&attitude, &field, f32::from(gate_px) * 0.5);
        instruments.meter.end(Stage::Confirm);
        match confirmed {
            Some(confirmed) if confirmed.matches.len() >= usize::from(fewest_stars) => {
                let log10_false = confirmed.log10_chance;
                let confirmed = Some((confirmed, log10_false));
                Outcome { confirmed, ..Outcome::nothing(Status::Tracked, measured.len()) }
            }
            _ => Outcome::nothing(Status::Lost, measured.len()),
        }
    }

    /// Takes over what the second's image taught, and reports it.
    #[inline(never)]
    fn learn(&mut self, mode: Mode, outcome: Outcome) -> Report {
        let image_cycle = self.searching_since.take_if(|_| outcome.confirmed.is_some()).unwrap_or(self.cycle);
        let mut report = Report {
            cycle: self.cycle,
            instant_us: 0,
            mode,
            status: outcome.status,
            attitude: None,
            rate_rad_s: None,
            detections: outcome.detections,
            focal_ratio: 1.0,
            stars: Vec::new(),
            earth_status: EarthStatus::NotLooked,
            earth: None,
            limb_px: Vec::new(),
            orbit: None,
            events: Vec::new(),
        };
        let Some((confirmed, log10_false)) = outcome.confirmed else { return report };
        let now = Known { attitude: confirmed.attitude, cycle: image_cycle };
        self.rate_rad_s = self.known.and_then(|before| rate_between(&before, &now));
        self.known = Some(now);
        report.attitude = Some(AttitudeReport {
            quaternion: now.attitude.quaternion(),
            sigma_rad: confirmed.sigma_rad,
            log10_false,
            age_s: self.cycle.wrapping_sub(image_cycle).min(u16::MAX.into()) as u16,
        });
        report.rate_rad_s = self.rate_rad_s.map(|rate| [rate.x, rate.y, rate.z]);
        report.focal_ratio = confirmed.focal_ratio;
        for found in &confirmed.matches {
            let seen = self.workspace.measured.get(usize::from(found.measured));
            if let (Some(seen), Some(star)) = (seen, self.catalogue.star(found.star)) {
                let recognised =
                    StarReport { hip: star.hip, centre_px: seen.centre_px, residual_px: found.residual_px };
                // The report holds as many stars as confirmation matches.
                let _ = report.stars.push(recognised);
            }
        }
        report
    }
}

/// Mean rate between two attitudes in the star path's frame, rad/s; `None` when they are too far apart in time for the
/// rotation between them to be the short way round.
fn rate_between(before: &Known, now: &Known) -> Option<Vector3<f32>> {
    let elapsed = now.cycle.wrapping_sub(before.cycle);
    if !(1..=MAX_RATE_BASE_S).contains(&elapsed) {
        return None;
    }
    Some(now.attitude.angle_from(&before.attitude) * (1.0 / elapsed as f32))
}
