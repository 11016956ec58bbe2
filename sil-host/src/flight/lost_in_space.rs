//! Feeds the flight code's identification on the host, with room for large catalogues and, where the focal
//! length is known only roughly, one try for each of a ladder of focal lengths.
//!
//! In: centroids, brightest first, a camera, a catalogue. Out: [`Solution`] or the flight code's reason.
//! Nothing of the identification is done here: every try is [`Identifier::advance`], and the hypotheses of
//! all tries count in the false-identification probability.

use fsw_core::camera::{Camera, CameraParameters};
use fsw_core::catalog::Catalogue;
use fsw_core::stars::confirm::{Confirmed, confirm};
use fsw_core::stars::identify::{IdentificationParameters, Identifier, NotIdentified, Progress};
use fsw_core::stars::{MeasuredStar, StarField};

/// How hard a camera is tried: centroid sigma to assume (px) and catalogue pairs to look at.
pub(super) type Round = (f32, u32);

/// Relative distance of neighbouring focal lengths on the ladder.
pub(super) const FOCAL_STEP: f64 = 0.002;
/// Steps of the ladder to either side: covers 2.4 %.
const FOCAL_STEPS: i32 = 12;
/// Half a step and what the lens distorts.
const FOCAL_UNCERTAINTY: f32 = 0.001;
/// Rounds over the ladder. The first tries a base side or two of every focal length and wins on most
/// pictures; the fewer hypotheses were tried before, the less evidence is needed.
const ROUNDS: [Round; 5] =
    [(0.35, 20_000), (0.35, 300_000), (0.35, 6_000_000), (0.7, 6_000_000), (1.4, 6_000_000)];
/// Times the focal length is refined from the matched stars.
const REFINEMENTS: usize = 4;

/// How well the focal length of the camera is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FocalLength {
    /// Within 2 %: a ladder of tries.
    Within2Percent,
    /// The same of a picture that may be seen in a mirror: the ladder in the camera's sense, then in the
    /// other.
    Within2PercentEitherSense,
    /// Known to a thousandth, as for a camera file of a lens that was measured once.
    Rough,
}

/// An identified field.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The camera, its focal length refined.
    pub camera: Camera,
    /// The measured stars, as given.
    pub measured: Vec<MeasuredStar>,
    /// Names and attitude.
    pub confirmed: Confirmed,
    /// Common logarithm of the false-identification probability over all tries.
    pub log10_false: f32,
}

/// Room for 8,192 catalogue pairs a separation.
type HostIdentifier = Identifier<16_384, 16_384, 4_096>;

/// The host's workspace.
pub struct Solver {
    identifier: Box<HostIdentifier>,
}

impl Default for Solver {
    fn default() -> Self {
        Self { identifier: Box::new(Identifier::new()) }
    }
}

impl Solver {
    /// Number of polygons that the last search held ready as candidates.
    pub fn candidates(&self) -> usize {
        self.identifier.polygons().len()
    }

    /// Identifies stars of a calibrated camera, just as in flight; the parameters are the user's criterion.
    ///
    /// # Errors
    /// Why it was not identified.
    pub fn identify(
        &mut self,
        measured: &[MeasuredStar],
        camera: &Camera,
        catalogue: &Catalogue,
        parameters: &IdentificationParameters,
    ) -> Result<(Confirmed, f32), NotIdentified> {
        self.identifier.restart(0.0);
        let field = StarField::whole(measured, catalogue, camera);
        match self.identifier.advance(&field, parameters, u32::MAX) {
            Progress::Identified(confirmed, log10_false) => Ok((confirmed, log10_false)),
            Progress::NotIdentified(reason) => Err(reason),
            // There are fewer sides than the allowance.
            Progress::Searching => Err(NotIdentified::NoMatch),
        }
    }

    /// Identifies stars of a camera whose focal length is not calibrated.
    ///
    /// # Errors
    /// Why it was not identified.
    pub fn search(
        &mut self,
        centroids: &[([f32; 2], f32)],
        camera: &Camera,
        catalogue: &Catalogue,
        focal_length: FocalLength,
    ) -> Result<Solution, NotIdentified> {
        let mut hypotheses = 0.0;
        let mut reason = NotIdentified::TooFewStars;
        let steps = match focal_length {
            FocalLength::Within2Percent | FocalLength::Within2PercentEitherSense => FOCAL_STEPS,
            FocalLength::Rough => 0,
        };
        let mut cameras = ladder(camera, steps);
        if focal_length == FocalLength::Within2PercentEitherSense {
            let parameters = *camera.parameters();
            let other = Camera::new(CameraParameters { mirrored: !parameters.mirrored, ..parameters });
            cameras.extend(other.iter().flat_map(|other| ladder(other, steps)));
        }
        for round in ROUNDS {
            for camera in cameras.iter().cloned() {
                match self.attempt(centroids, camera, catalogue, round, &mut hypotheses) {
                    Err(NotIdentified::TooFewStars) => return Err(NotIdentified::TooFewStars),
                    Err(found) => reason = found,
                    identified => return identified,
                }
            }
        }
        Err(reason)
    }

    /// One try: identifies stars of a camera with as much effort as `round` says. `hypotheses` were tried
    /// on the same stars before; those of this try are added.
    ///
    /// # Errors
    /// Why they were not identified.
    pub(super) fn attempt(
        &mut self,
        centroids: &[([f32; 2], f32)],
        camera: Camera,
        catalogue: &Catalogue,
        (sigma, allowance): Round,
        hypotheses: &mut f32,
    ) -> Result<Solution, NotIdentified> {
        let parameters = IdentificationParameters {
            centroid_sigma_px: [sigma; 3],
            scale_uncertainty: FOCAL_UNCERTAINTY,
            ..IdentificationParameters::default()
        };
        let measured = measure(centroids, &camera);
        self.identifier.restart(*hypotheses);
        let field = StarField::whole(&measured, catalogue, &camera);
        let progress = self.identifier.advance(&field, &parameters, allowance);
        *hypotheses = self.identifier.hypotheses();
        match progress {
            Progress::Identified(confirmed, log10_false) => {
                let start = Solution { camera, measured, confirmed, log10_false };
                Ok(refine(start, centroids, catalogue))
            }
            Progress::NotIdentified(reason) => Err(reason),
            Progress::Searching => Err(NotIdentified::NoMatch),
        }
    }
}

/// Directions of centroids, given with their sigmas, px. Those outside what the camera can map are left out.
pub fn measure(centroids: &[([f32; 2], f32)], camera: &Camera) -> Vec<MeasuredStar> {
    centroids.iter().filter_map(|(centre, sigma)| MeasuredStar::new(camera, *centre, *sigma)).collect()
}

/// The cameras to try, from the given focal length outwards, so many steps to either side.
pub(super) fn ladder(camera: &Camera, steps: i32) -> Vec<Camera> {
    let mut offsets: Vec<i32> = (-steps..=steps).collect();
    offsets.sort_by_key(|offset| offset.abs());
    let given = f64::from(camera.parameters().focal_length_px);
    let focal_lengths = offsets.iter().map(|offset| given * (1.0 + FOCAL_STEP * f64::from(*offset)));
    focal_lengths.filter_map(|f| camera.with_focal_length(f as f32).ok()).collect()
}

/// Follows the focal length that the matched stars ask for, with a tolerance that shrinks with their
/// residuals.
fn refine(start: Solution, centroids: &[([f32; 2], f32)], catalogue: &Catalogue) -> Solution {
    let mut solution = start;
    for _ in 0..REFINEMENTS {
        let focal_length =
            solution.camera.parameters().focal_length_px * solution.confirmed.focal_ratio.ratio;
        let Ok(camera) = solution.camera.with_focal_length(focal_length) else { break };
        let measured = measure(centroids, &camera);
        let tolerance_px = (4.0 * solution.confirmed.rms_px).max(1.0);
        let field = StarField::whole(&measured, catalogue, &camera);
        let Some(confirmed) = confirm(&solution.confirmed.attitude, &field, tolerance_px) else { break };
        solution = Solution { camera, measured, confirmed, ..solution };
    }
    solution
}
