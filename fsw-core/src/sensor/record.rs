//! The record of a second: what each stage returned. The [`Report`] is made of it here, once, at the end of
//! the second; no stage reads what another one has put into the record but by its arguments.

use super::timekeeping::Time;
use crate::catalog::Catalogue;
use crate::command::CommandOutcome;
use crate::earth::{EarthFix, FitError, LimbPoint};
use crate::image::scan::Detections;
use crate::magnetism::Magnetism;
use crate::modes::{Mode, ModeInputs};
use crate::orbit::filter::Nis;
use crate::order::fill;
use crate::outages::SensorState;
use crate::stars::Match;
use crate::stars::MeasuredStar;
use crate::telemetry::{
    Activity, AttitudeReport, DetectorFault, EarthReport, EarthStatus, Event, Faults, FilteredAttitude,
    FixFault, ImageFault, LocalAttitude, MAX_EVENTS, MAX_STARS, MagnetometerReport, NextState, OrbitReport,
    Outcome, RateReport, ReadingFault, Report, ShutterFault, StarReport,
};
use fsw_hal::OpenPaths;
use heapless::Vec;
use nalgebra::Vector3;

/// What happened in a second, in the order of its stages.
#[derive(Debug, Default)]
pub(super) struct Events(pub(super) Vec<Event, MAX_EVENTS>);

impl Events {
    /// Adds an event; of more than [`MAX_EVENTS`] the first are kept.
    pub(super) fn note(&mut self, event: Event) {
        let _ = self.0.push(event);
    }
}

/// An attitude of a second, and what the filter makes of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solution {
    /// As it is reported; the Earth is looked for with it.
    pub(super) attitude: AttitudeReport,
    /// `None` where the attitude is the filter's own.
    pub(super) filtered: Option<FilteredAttitude>,
    /// Rate by the filter, where it is known, rad/s.
    pub(super) rate_rad_s: Option<[f32; 3]>,
    /// Best focal length over the parameter, where the image gave one.
    pub(super) focal_ratio: Option<f32>,
    /// Whether no image of this second supports it.
    pub(super) predicted: bool,
}

/// What the star stage of a second gave: filled by the one step that the mode and the image call for.
#[derive(Debug, Default)]
pub(super) struct StarRecord {
    pub(super) activity: Activity,
    pub(super) outcome: Option<Outcome>,
    /// Star-like spots, or streaks.
    pub(super) detections: u16,
    /// Tiles or windows too crowded to be searched whole.
    pub(super) crowded: u16,
    /// Whether the detector did not deliver all that was asked for.
    pub(super) incomplete: bool,
    /// Why the image is not believed by its stars: it is an old one, sold as new, or not where it is expected.
    pub(super) image_fault: Option<ImageFault>,
    pub(super) solution: Option<Solution>,
    /// Stars recognised, of those in the workspace, brightest first.
    pub(super) matches: Vec<Match, MAX_STARS>,
    /// A rate that needed no attitude.
    pub(super) rate: Option<RateReport>,
}

impl StarRecord {
    /// Counts what was detected in an image or its windows: `found`, the tiles too crowded to be searched
    /// whole, and whether any was not delivered.
    pub(super) fn count(&mut self, found: usize, detections: &Detections) {
        self.detections = found.min(u16::MAX.into()) as u16;
        self.crowded = detections.crowded_tiles().min(u16::MAX.into()) as u16;
        self.incomplete = detections.unread() > 0;
    }

    /// The attitude that this second's own image gave.
    pub(super) fn own_attitude(&self) -> Option<AttitudeReport> {
        let own = self.solution.filter(|solution| !solution.predicted && solution.attitude.age_s == 0);
        own.map(|solution| solution.attitude)
    }
}

/// What looking for the Earth came to.
#[derive(Debug, Default)]
pub(super) enum Looked {
    /// It was not looked for.
    #[default]
    Not,
    /// No limb in the field is lit.
    Dark,
    /// Too little of it is lit well.
    Faint,
    /// The Earth's centre, of limb points in the workspace.
    Found(EarthFix),
    /// None, and why.
    Refused(FitError),
}

impl Looked {
    fn status(&self) -> EarthStatus {
        match self {
            Self::Not => EarthStatus::NotLooked,
            Self::Dark => EarthStatus::Dark,
            Self::Faint => EarthStatus::Faint,
            Self::Found(_) => EarthStatus::Found,
            Self::Refused(refusal) => EarthStatus::Refused(*refusal),
        }
    }

    fn fix(&self) -> Option<&EarthFix> {
        match self {
            Self::Found(fix) => Some(fix),
            _ => None,
        }
    }
}

/// What the Earth stage of a second gave.
#[derive(Debug, Default)]
pub(super) struct EarthRecord {
    pub(super) looked: Looked,
    /// Whether no limb in the field is lit, by what was seen or by the orbit; `None` where neither tells.
    pub(super) dark: Option<bool>,
}

/// The Earth's magnetic field in a second, as it is read and as it should be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field {
    /// The reading, Earth path, uT.
    pub(super) reading_ut: Vector3<f32>,
    /// The field where the orbit has the satellite, ICRS axes, uT.
    pub(super) expected_ut: Vector3<f32>,
    /// Its standard deviation, an axis, uT.
    pub(super) sigma_ut: f32,
}

/// What the orbit filter made of a fix.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FixRecord {
    /// Normalised innovation squared, where the fix was compared with the orbit.
    pub(super) nis: Option<Nis>,
    /// Why it was refused.
    pub(super) fault: Option<FixFault>,
}

impl FixRecord {
    /// Adds what the second's own image came to.
    pub(super) fn add(&mut self, other: Self) {
        *self = Self { nis: other.nis.or(self.nis), fault: other.fault.or(self.fault) };
    }
}

fn earth_report(fix: &EarthFix) -> EarthReport {
    let distance_km = fix.distance_km();
    let (sigma_rad, sigma_km) = fix.sigmas();
    let of = &fix.covariance_km2;
    EarthReport {
        direction: (fix.centre_km * (1.0 / distance_km.max(1.0))).into(),
        sigma_rad,
        distance_km,
        sigma_km,
        covariance_km2: [of.m11, of.m21, of.m22, of.m31, of.m32, of.m33],
        inliers: fix.inliers.count_ones() as u16,
        arc_deg: fix.arc_rad.to_degrees(),
        rms_px: fix.rms_px,
    }
}

/// What the stages of a second gave.
#[derive(Debug)]
pub(super) struct Record {
    pub(super) cycle: u32,
    pub(super) mode: Mode,
    pub(super) time: Time,
    /// Exposure that the image was asked for with, us; `None` where none was.
    pub(super) exposure_us: Option<u32>,
    pub(super) detector_fault: Option<DetectorFault>,
    pub(super) image_fault: Option<ImageFault>,
    pub(super) rate_sensor_fault: Option<ReadingFault>,
    pub(super) magnetometer_fault: Option<ReadingFault>,
    pub(super) shutter_fault: Option<ShutterFault>,
    /// The paths that were to be open.
    pub(super) open: OpenPaths,
    /// How many stars were seen through the Earth path that do not contradict each other; `None` where none
    /// were looked for.
    pub(super) earth_path_stars: Option<u8>,
    pub(super) stars: StarRecord,
    pub(super) earth: EarthRecord,
    pub(super) fix: FixRecord,
    pub(super) orbit: Option<OrbitReport>,
    pub(super) local: Option<LocalAttitude>,
    pub(super) state: Option<SensorState>,
    pub(super) next_state: Option<NextState>,
    /// The magnetic field by magnetometer and orbit, and whether the attitude rests on it.
    pub(super) field: Option<Field>,
    pub(super) field_used: bool,
    pub(super) command: Option<CommandOutcome>,
    pub(super) events: Events,
}

impl Record {
    /// At the begin of a second, before which there were these events.
    pub(super) fn new(cycle: u32, mode: Mode, time: Time, events: Events) -> Self {
        Self {
            cycle,
            mode,
            time,
            exposure_us: None,
            detector_fault: None,
            image_fault: None,
            rate_sensor_fault: None,
            magnetometer_fault: None,
            shutter_fault: None,
            open: OpenPaths::Both,
            earth_path_stars: None,
            stars: StarRecord::default(),
            earth: EarthRecord::default(),
            fix: FixRecord::default(),
            orbit: None,
            local: None,
            state: None,
            next_state: None,
            field: None,
            field_used: false,
            command: None,
            events,
        }
    }

    /// What the guards of the modes judge by. `predicted`: the attitude propagated to the next second is
    /// within the gate.
    pub(super) fn mode_inputs(&self, predicted: bool) -> ModeInputs {
        ModeInputs {
            attitude: self.stars.solution.is_some_and(|solution| !solution.predicted),
            predicted,
            blinded: matches!(self.stars.outcome, Some(Outcome::Blinded | Outcome::StarPathShut)),
            dark: self.earth.dark,
            // Without an image that can be believed the self-test tested nothing, and no Sun has gone.
            fault: self.detector_fault.is_some()
                || (matches!(self.mode, Mode::SelfTest | Mode::Safe | Mode::SunOutage)
                    && self.image_fault.is_some()),
        }
    }

    /// The report: stars by what was `measured` and the `catalogue`, limb points from those of the image, the
    /// magnetometer as it is known.
    #[inline(never)]
    pub(super) fn report(
        &self,
        (measured, catalogue): (&[MeasuredStar], &Catalogue),
        limb: &[LimbPoint],
        magnetism: &Magnetism,
    ) -> Report {
        let Self { time, stars, earth: EarthRecord { looked: earth, .. }, .. } = self;
        let solution = stars.solution.as_ref();
        let mut report = Report {
            cycle: self.cycle,
            local_us: time.local.as_us(),
            instant_us: time.terrestrial_us,
            clock: time.state,
            mode: self.mode,
            activity: stars.activity,
            exposure_us: self.exposure_us,
            outcome: stars.outcome,
            faults: Faults {
                detector: self.detector_fault.or(stars.incomplete.then_some(DetectorFault::Hardware)),
                image: self.image_fault.or(stars.image_fault),
                clock: time.fault,
                rate_sensor: self.rate_sensor_fault,
                magnetometer: self.magnetometer_fault,
                shutter: self.shutter_fault,
                fix: self.fix.fault,
                crowded: stars.crowded,
            },
            star_path_shut: !self.open.star(),
            earth_path_shut: self.open == OpenPaths::Star,
            earth_path_clear: self.open.clear(),
            earth_path_stars: self.earth_path_stars,
            attitude: solution.map(|solution| solution.attitude),
            filtered: solution.and_then(|solution| solution.filtered),
            rate_rad_s: solution.and_then(|solution| solution.rate_rad_s),
            detections: stars.detections,
            focal_ratio: solution.and_then(|solution| solution.focal_ratio),
            stars: Vec::new(),
            earth_status: earth.status(),
            earth: earth.fix().map(earth_report),
            limb_px: Vec::new(),
            orbit: self.orbit,
            local: self.local,
            events: self.events.0.clone(),
            rate: stars.rate,
            command: self.command,
            state: self.state,
            next_state: self.next_state,
            magnetometer: self.field.map(|field| MagnetometerReport {
                field_ut: (field.reading_ut - magnetism.zero_ut()).into(),
                zero_ut: magnetism.zero_ut().into(),
                zero_sigma_ut: magnetism.zero_sigma_ut(),
                used: self.field_used,
            }),
        };
        let recognised = |found: &Match| {
            let (seen, star) = (measured.get(usize::from(found.measured))?, catalogue.star(found.star)?);
            Some(StarReport { hip: star.hip, centre_px: seen.centre_px, residual_px: found.residual_px })
        };
        fill(&mut report.stars, stars.matches.iter().filter_map(recognised));
        if let Some(fix) = earth.fix() {
            let inliers = limb.iter().enumerate().filter(|(index, _)| fix.is_inlier(*index));
            fill(&mut report.limb_px, inliers.map(|(_, point)| point.centre_px));
        }
        report
    }
}
