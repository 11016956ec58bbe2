//! The focal length checked in flight (ALGORITHMS part 3): by the Earth's apparent size where its distance is
//! known, and by the stars of the same frame.
//!
//! In: limb points and the distance by the orbit, or measured and predicted star positions. Out: a
//! [`Scale`], the relative error of the camera's focal length, with its sigma. [`Scale::apart`] compares
//! the two estimates.
//!
//! The distance `d` of the centre is fitted for the focal length `f` and for `f (1 + δ)`; with the slope
//! `D` between them the share is `(d_known - d) / D`, and its sigma that of the difference over `|D|`: the
//! horizon's common height, 1.4 km of 6378, leaves 2e-4 at the least. Stars have it ten times better: with
//! the sigma `s` of a centroid, `s / sqrt(Σ (r - r̄)²)` over their places `r`, 4e-5 for ten of 0.05 px. An
//! error that the Earth shows and the stars do not is therefore the limb's height or the orbit's; one that
//! both show is the lens's. Not flown: calibration is done on the ground.

use crate::camera::Camera;
use crate::earth::centre::{self, CentrePrior, RayBuffer};
use crate::earth::{Body, EarthParameters, FitCriteria, FitError, LimbPoint};

/// Step of the focal length, share.
const STEP: f32 = 2e-3;
/// Least relative change of the distance over that of the focal length: below, the focal length is not
/// observable.
const LEAST_SLOPE: f32 = 0.01;
/// Fewest stars.
const FEWEST_STARS: usize = 3;

/// Relative error of the focal length: true over the camera's, less one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The share.
    pub share: f32,
    /// Its standard deviation.
    pub sigma: f32,
}

/// Limb points with the arguments of their fit.
#[derive(Clone, Copy, Debug)]
pub struct LimbPoints<'a> {
    /// The points.
    pub points: &'a [LimbPoint],
    /// The camera.
    pub camera: &'a Camera,
    /// The body.
    pub body: &'a Body,
    /// Acceptance criteria of the fit.
    pub criteria: &'a FitCriteria,
    /// A priori centre.
    pub prior: Option<&'a CentrePrior>,
    /// Parameters of the Earth.
    pub parameters: &'a EarthParameters,
}

impl Scale {
    /// By the Earth, whose centre stands `known_km` away, known to `sigma_km`.
    ///
    /// # Errors
    /// As [`centre::centre`]; [`FitError::Degenerate`] where the distance does not depend on the focal
    /// length.
    pub fn by_the_earth(
        measured: &LimbPoints,
        [known_km, sigma_km]: [f32; 2],
        workspace: &mut RayBuffer,
    ) -> Result<Self, FitError> {
        let LimbPoints { points, camera, body, criteria, prior, parameters } = *measured;
        let mut longer = *camera.parameters();
        longer.focal_length_px *= 1.0 + STEP;
        let longer = Camera::new(longer).map_err(|_| FitError::Degenerate)?;
        let mut distance = |camera: &Camera| {
            let fix = centre::centre(points, camera, body, criteria, prior, parameters, workspace)?;
            Ok((fix.distance_km(), fix.sigmas().1))
        };
        let (distance_km, own_km) = distance(camera)?;
        let slope_km = (distance(&longer)?.0 - distance_km) / STEP;
        if libm::fabsf(slope_km).is_nan() || libm::fabsf(slope_km) < LEAST_SLOPE * distance_km {
            return Err(FitError::Degenerate);
        }
        let both_km = libm::sqrtf(own_km * own_km + sigma_km * sigma_km);
        Ok(Self { share: (known_km - distance_km) / slope_km, sigma: both_km / libm::fabsf(slope_km) })
    }

    /// By stars: places as predicted with the attitude of the same frame and as measured, px, and the sigma
    /// of a measured one. An attitude takes up a shift and a turn, but no stretch. `None` for fewer than
    /// three.
    pub fn by_stars(stars: &[([f32; 2], [f32; 2])], sigma_px: f32) -> Option<Self> {
        if stars.len() < FEWEST_STARS {
            return None;
        }
        let each = 1.0 / stars.len() as f32;
        let mut mean = [0.0; 4];
        let parts = |([px, py], [x, y]): ([f32; 2], [f32; 2])| [px, py, x - px, y - py];
        for star in stars {
            for (mean, part) in mean.iter_mut().zip(parts(*star)) {
                *mean += part * each;
            }
        }
        let [px, py, dx, dy] = mean;
        let (mut stretch, mut squares) = (0.0, 0.0);
        for star in stars {
            let [x, y, off_x, off_y] = parts(*star);
            stretch += (x - px) * (off_x - dx) + (y - py) * (off_y - dy);
            squares += (x - px) * (x - px) + (y - py) * (y - py);
        }
        (squares > 1.0).then(|| Self { share: stretch / squares, sigma: sigma_px / libm::sqrtf(squares) })
    }

    /// How far two are apart, in sigmas of their difference.
    pub fn apart(&self, other: &Self) -> f32 {
        let sigma = libm::sqrtf(self.sigma * self.sigma + other.sigma * other.sigma);
        (self.share - other.share) / sigma.max(1e-9)
    }
}

#[cfg(test)]
mod tests;
