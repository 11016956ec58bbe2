//! The world of a run as the page looks into it: frames drawn again, and where the optics point.
//!
//! A frame is a pure function of scenario, seed, faults, second, and what the second's report says of
//! exposure and shutters, so the frame of any second is drawn when it is asked for, and none is kept.

use crate::error::HostError;
use crate::harness::faults::{self, Fault, FaultKind, Faulty};
use crate::harness::{self, ThisSecond};
use crate::report::frames;
use crate::scenario::Scenario;
use crate::world::attitude::Vector;
use crate::world::lens::optics::Optics;
use crate::world::scene::Scene;
use fsw_core::telemetry::Report;
use fsw_hal::{Detector, DetectorGeometry, LocalTime, OpenPaths};
use image::codecs::png::CompressionType;

/// A scenario and its scene before the first exposure.
#[derive(Debug)]
pub struct World {
    scenario: Scenario,
    scene: Scene,
}

impl World {
    /// That of a scenario, whose scene is `scene`.
    pub fn new(scenario: Scenario, scene: Scene) -> Self {
        Self { scenario, scene }
    }

    /// Pixels of the detector.
    pub fn geometry(&self) -> DetectorGeometry {
        self.scene.geometry()
    }

    /// The optics of the star path.
    pub fn optics(&self) -> &Optics {
        self.scene.optics()
    }

    /// ICRS to Earth path at an instant, TT since J2000, us.
    pub fn earth_path(&self, instant_us: i64) -> Option<[Vector; 3]> {
        let trajectory = self.scene.settings().motion.trajectory()?;
        Some(trajectory.earth_path((instant_us - self.scenario.start_us) as f64 * 1e-6))
    }

    /// The limb at the centre and distance that a second's report gives: an SVG path in the detector's pixels.
    pub fn limb_path(&self, report: &Report) -> Option<String> {
        frames::limb_path(report, &self.scene.truth_at(report.cycle.into())?, &self.scene)
    }

    /// The frame of a second with what is broken in it, half its size and stretched, as a PNG: exposed as
    /// long and through the paths that the second's report says, without one as the scenario has it.
    ///
    /// # Errors
    /// Why there is none.
    pub fn frame(&self, faults: &[Fault], cycle: u32, report: Option<&Report>) -> Result<Vec<u8>, String> {
        let mut scene = self.scene.clone();
        scene.open(report.map_or(OpenPaths::Both, open_paths));
        let exposure_us = report.and_then(|report| report.exposure_us).unwrap_or(self.scenario.exposure_us);
        scene.delay(harness::late_us(faults, cycle) as f64 * 1e-6);
        scene.storm(faults::storm_hits(faults, cycle));
        let geometry = scene.geometry();
        let mut pixels = vec![0; geometry.whole().area()];
        // A readout that breaks off loses a window, not the image.
        let mut faults = faults.to_vec();
        for fault in &mut faults {
            if let FaultKind::DroppedWindow(share) = &mut fault.kind {
                *share = 0.0;
            }
        }
        let mut second = ThisSecond { scene: &mut scene, cycle: cycle.into(), instant: LocalTime::default() };
        let broken = (cycle, LocalTime::default());
        let mut detector = Faulty::new(&mut second, &faults, self.scenario.seed, broken);
        detector.expose(exposure_us).and_then(|_| detector.read(geometry.whole(), &mut pixels)).map_err(
            |error| match faults::words(&faults, cycle) {
                words if words.is_empty() => format!("no image: {error:?}"),
                words => format!("no image in this second: {words}"),
            },
        )?;
        let fast = CompressionType::Fast;
        frames::png(&pixels, usize::from(geometry.width_px), geometry.full_scale(), fast)
            .map_err(|error: HostError| error.to_string())
    }
}

/// The paths that were to be open in the second of a report.
fn open_paths(report: &Report) -> OpenPaths {
    match report {
        Report { star_path_shut: true, .. } => OpenPaths::Earth,
        Report { earth_path_shut: true, .. } => OpenPaths::Star,
        Report { earth_path_clear: true, .. } => OpenPaths::BothClear,
        _ => OpenPaths::Both,
    }
}
