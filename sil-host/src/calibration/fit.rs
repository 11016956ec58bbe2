//! A lens fitted to the stars of several pictures at once.
//!
//! In: a camera to start from; for every picture an attitude and its stars, each with its place (px) and its
//! direction (ICRS). Out: the camera, attitudes, standard deviations, residuals.
//!
//! Least squares of the residuals over their standard deviations, in the lens's parameters and three small
//! turns a picture, by Levenberg and Marquardt; derivatives by central differences. Which parameters: the
//! sets of [`LADDER`] are tried from the smallest on, and that with the least criterion of Schwarz (1978), `n
//! ln(χ² / n) + p ln n`, is taken, so that few stars do not make a distortion of their noise. Then it is done
//! once more without outliers: stars farther out than `OUTLIER_SIGMAS` robust deviations of the residuals
//! (from the median).
//!
//! Aberration is the same for all stars of a picture but for a stretch of v/c = 1e-4 along the Earth's
//! motion: pictures do not say when they were taken, so that the focal length carries that error.

use crate::formats::camera_file::CameraFile;
use crate::world::attitude::{Vector, apply, rotation};
use crate::world::lens::optics::Optics;
use crate::world::vector::product;
use nalgebra::{DMatrix, DVector};

/// Residuals farther out are no stars of the fit, in robust standard deviations.
const OUTLIER_SIGMAS: f64 = 4.0;
/// Error of a centroid beside its own sigma, px: what the detector's pixels and the catalogue's blends leave.
const FLOOR_PX: f64 = 0.05;
/// Most steps of a fit, and the relative change of χ² at which it ends.
const STEPS_MAX: usize = 60;
const CONVERGED: f64 = 1e-9;

/// A parameter of the lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Free {
    /// Focal length, px.
    FocalLength,
    /// Column of the optical centre, px.
    CentreX,
    /// Row of it, px.
    CentreY,
    /// Radial distortion of second order.
    K1,
    /// Of fourth order.
    K2,
    /// Tangential distortion, first.
    P1,
    /// Second.
    P2,
}

impl Free {
    /// Its key in a camera file.
    pub fn key(self) -> &'static str {
        match self {
            Self::FocalLength => "focal_length_px",
            Self::CentreX => "optical_centre_px[0]",
            Self::CentreY => "optical_centre_px[1]",
            Self::K1 => "k1",
            Self::K2 => "k2",
            Self::P1 => "p1",
            Self::P2 => "p2",
        }
    }

    /// Its value in a camera.
    pub fn of(self, camera: &CameraFile) -> f64 {
        *self.place(&mut camera.clone())
    }

    fn place(self, camera: &mut CameraFile) -> &mut f64 {
        match self {
            Self::FocalLength => &mut camera.focal_length_px,
            Self::CentreX => &mut camera.optical_centre_px[0],
            Self::CentreY => &mut camera.optical_centre_px[1],
            Self::K1 => &mut camera.distortion.k1,
            Self::K2 => &mut camera.distortion.k2,
            Self::P1 => &mut camera.distortion.p1,
            Self::P2 => &mut camera.distortion.p2,
        }
    }

    /// What moves a star in the corner by about a pixel.
    fn step(self, camera: &CameraFile) -> f64 {
        let f = camera.focal_length_px;
        let corner = 0.5 * f64::hypot(camera.width_px.into(), camera.height_px.into()) / f;
        match self {
            Self::FocalLength => 1.0 / corner,
            Self::CentreX | Self::CentreY => 1.0,
            Self::K1 => 1.0 / (f * corner.powi(3)),
            Self::K2 => 1.0 / (f * corner.powi(5)),
            Self::P1 | Self::P2 => 1.0 / (f * corner.powi(2)),
        }
    }
}

/// Sets of parameters, each with the one before in it.
pub const LADDER: [&[Free]; 5] = {
    use Free::{CentreX, CentreY, FocalLength, K1, K2, P1, P2};
    [
        &[FocalLength],
        &[FocalLength, K1],
        &[FocalLength, K1, CentreX, CentreY],
        &[FocalLength, K1, CentreX, CentreY, K2],
        &[FocalLength, K1, CentreX, CentreY, K2, P1, P2],
    ]
};

/// A star of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Hipparcos number.
    pub hip: u32,
    /// Direction, ICRS.
    pub direction: Vector,
    /// Measured place, px.
    pub at_px: [f64; 2],
    /// Its standard deviation per axis, px.
    pub sigma_px: f64,
}

/// A picture's stars and its attitude.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// ICRS to sensor.
    pub attitude: [Vector; 3],
    /// The stars.
    pub stars: Vec<Sighting>,
}

/// A fitted lens.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The camera.
    pub camera: CameraFile,
    /// The parameters that were fitted, with their standard deviations.
    pub free: Vec<(Free, f64)>,
    /// The pictures with their attitudes, outliers taken out.
    pub views: Vec<View>,
    /// Stars that were taken for outliers.
    pub outliers: usize,
}

impl Fit {
    /// Root mean square residual per axis, px.
    pub fn rms_px(&self) -> f64 {
        rms_px(&self.camera, &self.views)
    }
}

/// Measured less projected places, px, picture by picture; none for a star that the camera cannot see.
pub fn residuals(camera: &CameraFile, view: &View) -> Vec<Option<[f64; 2]>> {
    let Some(optics) = Optics::new(camera) else { return vec![None; view.stars.len()] };
    let of = |star: &Sighting| {
        let [x, y] = optics.project(apply(&view.attitude, star.direction))?;
        Some([star.at_px[0] - x, star.at_px[1] - y])
    };
    view.stars.iter().map(of).collect()
}

/// Root mean square residual per axis of several pictures, px.
pub fn rms_px(camera: &CameraFile, views: &[View]) -> f64 {
    let all: Vec<[f64; 2]> = views.iter().flat_map(|view| residuals(camera, view)).flatten().collect();
    let sum: f64 = all.iter().map(|[x, y]| x * x + y * y).sum();
    (sum / (2 * all.len()).max(1) as f64).sqrt()
}

/// The focal length alone fitted: what an uncalibrated lens is worth.
pub fn plain(camera: &CameraFile, views: &[View]) -> (CameraFile, Vec<View>) {
    let Problem { camera, views, .. } =
        Problem { free: LADDER[0], camera: camera.clone(), views: seen(camera, views) }.solved().0;
    (camera, views)
}

/// The attitude, ICRS to sensor, that fits the stars of a view with this camera.
pub fn attitude(camera: &CameraFile, view: &View) -> [Vector; 3] {
    let problem = Problem { free: &[], camera: camera.clone(), views: vec![view.clone()] };
    problem.solved().0.views.first().map_or(view.attitude, |view| view.attitude)
}

/// The lens of `views`, from `camera` on; `None` where the stars do not determine even its focal length.
pub fn fit(camera: &CameraFile, views: &[View]) -> Option<Fit> {
    let count = |views: &[View]| views.iter().map(|view| view.stars.len()).sum::<usize>();
    let rough = best(camera, &seen(camera, views))?;
    let kept = without_outliers(&rough.camera, &rough.views);
    let outliers = count(views) - count(&kept);
    best(camera, &kept).map(|fit| Fit { outliers, ..fit })
}

/// The stars in front of the camera. One behind it is named wrongly: it was measured on the detector.
fn seen(camera: &CameraFile, views: &[View]) -> Vec<View> {
    let seen = |view: &View| {
        let found = residuals(camera, view).into_iter().zip(&view.stars);
        let stars = found.filter_map(|(residual, star)| residual.map(|_| *star)).collect();
        View { attitude: view.attitude, stars }
    };
    views.iter().map(seen).collect()
}

/// The fit of all stars in the parameters that they support.
fn best(camera: &CameraFile, views: &[View]) -> Option<Fit> {
    let numbers = 2 * views.iter().map(|view| view.stars.len()).sum::<usize>();
    let mut best: Option<(f64, Fit)> = None;
    for free in LADDER {
        let unknowns = free.len() + 3 * views.len();
        if numbers <= unknowns {
            break;
        }
        let problem = Problem { free, camera: camera.clone(), views: views.to_vec() };
        let (Problem { camera, views, .. }, chi2, covariance) = problem.solved();
        let Some(covariance) = covariance else { break };
        let (n, p) = (numbers as f64, unknowns as f64);
        let criterion = n * (chi2 / n).ln() + p * n.ln();
        if best.as_ref().is_some_and(|(least, _)| *least <= criterion) {
            continue;
        }
        // The residuals themselves say how good the centroids were.
        let scale = chi2 / (n - p);
        let sigma = |k: usize| (scale * covariance[(k, k)]).sqrt();
        let free = free.iter().enumerate().map(|(k, free)| (*free, sigma(k))).collect();
        best = Some((criterion, Fit { camera, free, views, outliers: 0 }));
    }
    best.map(|(_, fit)| fit)
}

/// Takes out the stars whose residual is out of all proportion.
fn without_outliers(camera: &CameraFile, views: &[View]) -> Vec<View> {
    let lengths = |view: &View| -> Vec<f64> {
        let length = |residual: Option<[f64; 2]>| residual.map_or(f64::INFINITY, |[x, y]| x.hypot(y));
        residuals(camera, view).into_iter().map(length).collect()
    };
    let mut all: Vec<f64> = views.iter().flat_map(lengths).collect();
    all.sort_by(f64::total_cmp);
    let median = all.get(all.len() / 2).copied().unwrap_or(0.0);
    // The median length of a residual of two axes is 1.1774 standard deviations of one.
    let limit = OUTLIER_SIGMAS * median / 1.1774;
    let cleaned = |view: &View| {
        let kept = view.stars.iter().zip(lengths(view)).filter(|(_, length)| *length <= limit);
        View { attitude: view.attitude, stars: kept.map(|(star, _)| *star).collect() }
    };
    views.iter().map(cleaned).collect()
}

/// What is known in a fit, and what is to be found.
struct Problem<'a> {
    free: &'a [Free],
    camera: CameraFile,
    views: Vec<View>,
}

impl Problem<'_> {
    /// The problem with the unknowns moved by `step`: the lens's parameters in units of [`Free::step`], then
    /// a turn about each axis of each picture in pixels.
    fn moved(&self, step: &DVector<f64>) -> Self {
        let mut camera = self.camera.clone();
        for (k, free) in self.free.iter().enumerate() {
            *free.place(&mut camera) += step[k] * free.step(&self.camera);
        }
        let turned = |(index, view): (usize, &View)| View {
            attitude: self.turned(&view.attitude, |axis| step[self.free.len() + 3 * index + axis]),
            stars: view.stars.clone(),
        };
        Self { free: self.free, camera, views: self.views.iter().enumerate().map(turned).collect() }
    }

    fn turned(&self, attitude: &[Vector; 3], px: impl Fn(usize) -> f64) -> [Vector; 3] {
        let turn = |axis: usize| rotation(axis, px(axis) / self.camera.focal_length_px);
        product(&turn(2), &product(&turn(1), &product(&turn(0), attitude)))
    }

    /// Residuals of a picture over their standard deviations; infinite of a star that the camera cannot see.
    fn weighted(&self, camera: &CameraFile, view: &View) -> Vec<f64> {
        let scaled = |(residual, star): (Option<[f64; 2]>, &Sighting)| {
            let sigma = star.sigma_px.hypot(FLOOR_PX);
            residual.map_or([f64::INFINITY; 2], |residual| residual.map(|px| px / sigma))
        };
        residuals(camera, view).into_iter().zip(&view.stars).flat_map(scaled).collect()
    }

    /// Infinite where a star has left the field: no step that loses one is a gain.
    fn chi2(&self) -> f64 {
        self.views.iter().flat_map(|view| self.weighted(&self.camera, view)).map(|r| r * r).sum()
    }

    /// Normal matrix and right side.
    fn normal(&self) -> (DMatrix<f64>, DVector<f64>) {
        const DIFFERENCE: f64 = 1e-3;
        let lens = self.free.len();
        let size = lens + 3 * self.views.len();
        let (mut matrix, mut right) = (DMatrix::zeros(size, size), DVector::zeros(size));
        for (index, view) in self.views.iter().enumerate() {
            let here = self.weighted(&self.camera, view);
            let places: Vec<usize> = (0..lens).chain((0..3).map(|axis| lens + 3 * index + axis)).collect();
            let derivative = |place: &usize| -> Vec<f64> {
                let at = |sign: f64| {
                    if *place < lens {
                        let mut camera = self.camera.clone();
                        let free = self.free[*place];
                        *free.place(&mut camera) += sign * DIFFERENCE * free.step(&self.camera);
                        return self.weighted(&camera, view);
                    }
                    let axis = (*place - lens) % 3;
                    let px = |k: usize| if k == axis { sign * DIFFERENCE } else { 0.0 };
                    let attitude = self.turned(&view.attitude, px);
                    self.weighted(&self.camera, &View { attitude, stars: view.stars.clone() })
                };
                let pairs = at(1.0).into_iter().zip(at(-1.0));
                pairs.map(|(above, below)| (above - below) / (2.0 * DIFFERENCE)).collect()
            };
            let columns: Vec<Vec<f64>> = places.iter().map(derivative).collect();
            let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            for (a, i) in columns.iter().zip(&places) {
                for (b, j) in columns.iter().zip(&places) {
                    matrix[(*i, *j)] += product(a, b);
                }
                right[*i] -= product(a, &here);
            }
        }
        (matrix, right)
    }

    /// The solution, its χ², and the covariance of the unknowns; none where they are not determined.
    fn solved(self) -> (Self, f64, Option<DMatrix<f64>>) {
        let mut here = self;
        let mut chi2 = here.chi2();
        let mut damping = 1e-3;
        for _ in 0..STEPS_MAX {
            let (matrix, right) = here.normal();
            let mut damped = matrix.clone();
            for k in 0..damped.nrows() {
                damped[(k, k)] *= 1.0 + damping;
            }
            let Some(factors) = damped.cholesky() else { break };
            let next = here.moved(&factors.solve(&right));
            let found = next.chi2();
            // NaN is no improvement.
            if found < chi2 {
                let gain = (chi2 - found) / chi2.max(1e-300);
                (here, chi2, damping) = (next, found, damping * 0.1);
                if gain < CONVERGED {
                    break;
                }
            } else {
                damping *= 10.0;
                if damping > 1e6 {
                    break;
                }
            }
        }
        let covariance = here.normal().0.cholesky().map(|factors| {
            let mut covariance = factors.inverse();
            for (k, free) in here.free.iter().enumerate() {
                let step = free.step(&here.camera);
                covariance.row_mut(k).scale_mut(step);
                covariance.column_mut(k).scale_mut(step);
            }
            covariance
        });
        (here, chi2, covariance)
    }
}

#[cfg(test)]
mod tests;
