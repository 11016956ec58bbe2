//! What a sensor needs room for.

use crate::camera::Camera;
use crate::earth::LimbPoint;
use crate::earth::centre;
use crate::earth::search::Points;
use crate::image::DetectionMethod;
use crate::image::repeated::Repeated;
use crate::image::scan::{self, Detections, TILE_PIXELS};
use crate::order::fill;
use crate::plan;
use crate::stars::identify::Identifier;
use crate::stars::{MAX_MEASURED, MeasuredStar};
use fsw_hal::{Detector, DetectorError, Window};
use heapless::Vec;
use nalgebra::Vector3;

/// Chains of the base sides: up to so many stars of a catalogue have one each, and it costs no RAM beside the
/// readout.
pub const BASE_SIDE_CHAINS: usize = 4096;
/// Most directed catalogue pairs of one separation.
pub const MAX_BASE_SIDES: usize = 1536;
/// Most triangles over one base side.
pub const MAX_TRIANGLES: usize = 512;

/// The identifier with the capacities above.
type OnboardIdentifier = Identifier<BASE_SIDE_CHAINS, MAX_BASE_SIDES, MAX_TRIANGLES>;

/// What the reading of an image needs.
#[derive(Debug)]
pub(super) struct Readout {
    /// Pixels of the window that was read last.
    pub(super) buffer: [u16; TILE_PIXELS],
    /// Limb points of this image.
    pub(super) limb: Points,
    /// Their rays.
    pub(super) rays: centre::RayBuffer,
}

impl Readout {
    const fn new() -> Self {
        Self { buffer: [0; TILE_PIXELS], limb: Points::new(), rays: centre::RayBuffer::new() }
    }
}

/// Memory that reading an image and identifying its stars share: an image is read whole before its stars are
/// identified, and an identification that lasts for several seconds asks for no other image. The tag of the
/// first variant is 0 by `repr`, so that a static of it is all zero and costs no flash.
#[derive(Debug)]
#[repr(u8)]
#[expect(clippy::large_enum_variant, reason = "the point is to overlay the two, and there is no heap")]
pub(super) enum Shared {
    /// An image is read.
    Readout(Readout),
    /// Its stars are identified.
    Identification(OnboardIdentifier),
}

impl Shared {
    /// Room to read an image; an identification that was going on is dropped.
    #[inline(never)]
    pub(super) fn readout(&mut self) -> &mut Readout {
        // Two turns at most: the first leaves the variant that the second one finds.
        loop {
            match self {
                Self::Readout(readout) => return readout,
                Self::Identification(_) => *self = const { Self::Readout(Readout::new()) },
            }
        }
    }

    /// Begins an identification; what was read is overwritten.
    #[inline(never)]
    pub(super) fn begin_identification(&mut self) {
        *self = Self::Identification(Identifier::new());
    }

    /// The identification that is going on.
    pub(super) fn identifier(&mut self) -> Option<&mut OnboardIdentifier> {
        match self {
            Self::Identification(identifier) => Some(identifier),
            Self::Readout(_) => None,
        }
    }

    /// The limb points of this second's image.
    pub(super) fn limb_points(&self) -> &[LimbPoint] {
        match self {
            Self::Readout(readout) => &readout.limb,
            Self::Identification(_) => &[],
        }
    }
}

/// What the sensor needs room for; all zero at first, so that a static of it costs no flash.
#[derive(Debug)]
pub struct Workspace {
    pub(super) shared: Shared,
    pub(super) detections: Detections,
    /// Spots of the last scanned image.
    pub(super) repeated: Repeated,
    pub(super) measured: Vec<MeasuredStar, MAX_MEASURED>,
}

/// The brightest spots as measured directions, those of the middle of the frame where the rate, in the axes
/// of the camera's path, is known.
pub(super) fn measured(
    detections: &Detections,
    camera: &Camera,
    rate_rad_s: Option<&Vector3<f32>>,
    row_time_s: f32,
) -> impl Iterator<Item = MeasuredStar> {
    detections.spots().iter().filter_map(move |spot| {
        let star = MeasuredStar::from_detection(camera, spot)?;
        match rate_rad_s {
            Some(rate_rad_s) if row_time_s > 0.0 => star.at_mid_frame(camera, rate_rad_s, row_time_s),
            _ => Some(star),
        }
    })
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
            shared: Shared::Readout(Readout::new()),
            detections: Detections::new(),
            repeated: Repeated::new(),
            measured: Vec::new(),
        }
    }

    /// Turns the brightest spots into measured directions, those of the middle of the frame where the rate is
    /// known.
    pub(super) fn take_measured(
        &mut self,
        camera: &Camera,
        rate_rad_s: Option<&Vector3<f32>>,
        row_time_s: f32,
    ) {
        self.measured.clear();
        fill(&mut self.measured, measured(&self.detections, camera, rate_rad_s, row_time_s));
    }

    /// Reads the windows of the present image and finds their stars; how many of them can show none, too bright
    /// or not delivered.
    ///
    /// # Errors
    /// Of the detector, where more than half of them fail, or one for what was asked.
    pub(super) fn read_windows(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        windows: &[Window],
        method: &DetectionMethod,
    ) -> Result<usize, DetectorError> {
        self.detections.clear();
        let mut blank = 0;
        let buffer = &mut self.shared.readout().buffer;
        for window in windows {
            let is_blank = match scan::read_stars(detector, *window, buffer, *method, &mut self.detections) {
                Ok(is_washed) => is_washed,
                Err(error) => {
                    let searched_px = plan::searched_px(core::slice::from_ref(window));
                    self.detections.note_unread(error, searched_px as usize, windows.len() / 2)?;
                    true
                }
            };
            blank += usize::from(is_blank);
        }
        self.detections.settle();
        Ok(blank)
    }
}
