//! The image of a second: whether one is asked for, taken, and may be used, and when the second is.

use super::Sensor;
use super::timekeeping::Time;
use super::turning::{GREATEST_SCANNED_PX, short_divisor};
use crate::image::blinding::blinded;
use crate::image::fingerprint::Fingerprint;
use crate::modes::Mode;
use crate::plan;
use crate::telemetry::{DetectorFault, ImageFault};
use fsw_hal::{Clock, Detector, DetectorError, LocalTime, Stage, StageMeter};

/// So many probes may not be delivered.
const MOST_UNREAD: usize = 2;
/// Shortest exposure, as the parameters' own, us.
const SHORTEST_US: u32 = 100;

/// The image of a second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Image {
    /// None was asked for: safe mode, or a search that goes on with an image before.
    NotAsked,
    /// It can be read.
    Taken,
    /// It can be read, and the Sun blinds it.
    Blinded,
    /// Its instant is not one that this second can have; it is not read.
    Refused(ImageFault),
    /// The detector did not deliver it, or is not the one the parameters were made for.
    Failed(DetectorFault),
}

impl Image {
    /// Why its instant was refused.
    pub(super) fn fault(&self) -> Option<ImageFault> {
        match self {
            Self::Refused(fault) => Some(*fault),
            _ => None,
        }
    }
}

impl Sensor<'_> {
    /// Takes the image that the mode asks for and gives the times of the second with it.
    #[inline(never)]
    pub(super) fn take_image(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        clock: &mut impl Clock,
        meter: &mut impl StageMeter,
    ) -> (Image, Time) {
        meter.begin(Stage::Image);
        let asked = self.exposure_asked_us();
        self.exposure_us = asked.unwrap_or(self.exposure_us);
        let exposed = asked.map(|exposure_us| self.expose(detector, exposure_us));
        // After the exposure: no image can be later than the counter.
        let now = self.timekeeper.read_counter(clock);
        let (image, instant) = match exposed {
            None => (Image::NotAsked, None),
            Some(Err(fault)) => (Image::Failed(fault), None),
            Some(Ok(instant)) => match self.timekeeper.accept(instant, &now) {
                Ok(()) => match self.probe(detector) {
                    Image::Refused(fault) => (Image::Refused(fault), None),
                    image => (image, Some(instant)),
                },
                Err(fault) => (Image::Refused(fault), None),
            },
        };
        meter.end(Stage::Image);
        (image, self.timekeeper.times(clock, &now, instant))
    }

    /// The exposure that this second needs, us: where the sensor turns fast a shorter one than that of the
    /// parameters, as stars are to be no lines.
    fn exposure_asked_us(&self) -> Option<u32> {
        let divisor = match self.modes.mode() {
            Mode::CommandedSafe => return None,
            Mode::Acquisition | Mode::SunOutage if self.searching_since.is_some() => return None,
            Mode::Acquisition | Mode::SunOutage => self.turning.divisor(),
            Mode::Tracking | Mode::Eclipse => self.tracking_divisor(),
            Mode::SelfTest | Mode::Safe => 1,
        };
        Some((self.parameters.imaging.exposure_us / u32::from(divisor.max(1))).max(SHORTEST_US))
    }

    /// By what the exposure is divided where the filter's rate would draw stars out.
    fn tracking_divisor(&self) -> u8 {
        let drawn_px = self.motion.as_ref().map_or(0.0, |motion| self.drawn_px(motion));
        if drawn_px > GREATEST_SCANNED_PX { short_divisor(drawn_px) } else { 1 }
    }

    /// Exposes an image; the instant of its middle.
    fn expose(
        &self,
        detector: &mut impl Detector<Error = DetectorError>,
        exposure_us: u32,
    ) -> Result<LocalTime, DetectorFault> {
        let (geometry, camera) = (detector.geometry(), self.camera.parameters());
        if (geometry.width_px, geometry.height_px) != (camera.width_px, camera.height_px) {
            return Err(DetectorFault::Geometry);
        }
        detector.expose(exposure_us).map_err(DetectorFault::from)
    }

    /// Whether the Sun blinds the image: all probes stand at full scale. And whether it is one of the last
    /// ones again, whatever its instant. Up to [`MOST_UNREAD`] probes may fail.
    fn probe(&mut self, detector: &mut impl Detector<Error = DetectorError>) -> Image {
        let geometry = detector.geometry();
        let (mut blind, mut unread) = (0, 0);
        let mut fingerprint = Fingerprint::default();
        for (index, probe) in plan::probes(&geometry).iter().enumerate() {
            let Some(pixels) = self.workspace.shared.readout().buffer.get_mut(..probe.area()) else {
                return Image::Failed(DetectorFault::Request);
            };
            if let Err(error) = detector.read(*probe, pixels) {
                let fault = DetectorFault::from(error);
                if fault != DetectorFault::Hardware {
                    return Image::Failed(fault);
                }
                unread += 1;
                continue;
            }
            blind += usize::from(blinded(pixels, geometry.bits));
            fingerprint.take(index, pixels);
        }
        let former = self.fingerprints;
        let [_, last, undisturbed] = former;
        self.fingerprints = [last, fingerprint, undisturbed];
        if unread > MOST_UNREAD {
            return Image::Failed(DetectorFault::Hardware);
        }
        // Of saturated pixels only the dead ones differ, which are the same in every image.
        if blind + unread == plan::PROBES {
            return Image::Blinded;
        }
        if former.iter().any(|former| fingerprint.is_that_of(former)) {
            return Image::Refused(ImageFault::Repeated);
        }
        if !self.freshness.is_disturbed(fingerprint.noise()) {
            let [.., undisturbed] = &mut self.fingerprints;
            *undisturbed = fingerprint;
        }
        if !fingerprint.compares_with(&last) {
            self.freshness.suspect();
        }
        Image::Taken
    }
}
