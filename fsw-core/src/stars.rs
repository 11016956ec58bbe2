//! From centroids to identified stars.
//!
//! [`identify`] proposes polygons of measured and catalogue stars (separations, triangles, sense of rotation, merging
//! along a side: thesis §3.1.3), [`confirm`] accepts or refuses a proposal by re-projecting the catalogue into the
//! image,
//! [`predict`] says which stars an attitude puts where.

pub mod agenda;
pub mod confirm;
pub mod identify;
pub mod polygon;
pub mod predict;
mod triangles;

use crate::attitude::VectorPair;
use crate::camera::Camera;
use crate::catalog::{Catalogue, Star};
use crate::frames::{Direction, StarPath};
use crate::image::Detection;

/// Most measured stars that take part in identification; of more, the brightest.
pub const MAX_MEASURED: usize = 64;

/// A measured star on its way to a name.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// Where it stands on the detector, px.
    pub centre_px: [f32; 2],
    /// Standard deviation of the centre per axis, px.
    pub sigma_px: f32,
    /// The direction it came from.
    pub direction: Direction<StarPath>,
}

impl Measured {
    /// A star at a pixel position; `None` when position or sigma are not finite, or the sigma is not positive.
    pub fn new(camera: &Camera, centre_px: [f32; 2], sigma_px: f32) -> Option<Self> {
        let direction = camera.direction(centre_px)?;
        let usable = sigma_px > 1e-4 && sigma_px < 1e3;
        if usable { Some(Self { centre_px, sigma_px, direction }) } else { None }
    }

    /// A star from its spot.
    pub fn from_detection(camera: &Camera, spot: &Detection) -> Option<Self> {
        Self::new(camera, spot.centre_px(), spot.sigma_px())
    }

    /// The pair that this star and its catalogue star make.
    pub fn paired_with(&self, star: &Star, camera: &Camera) -> VectorPair {
        VectorPair {
            measured: self.direction,
            reference: star.direction(),
            sigma_rad: self.sigma_px * camera.rad_per_px(),
        }
    }
}

/// Measured stars of one image and what they are held against.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    measured: &'a [Measured],
    /// The catalogue.
    pub catalogue: &'a Catalogue<'a>,
    /// The camera.
    pub camera: &'a Camera,
    /// Detector area in which stars were looked for, px: the whole detector, or the cores of the windows read.
    pub searched_px: f32,
}

impl<'a> Field<'a> {
    /// Stars found on the whole detector, brightest first where brightness is known; of more than [`MAX_MEASURED`] the
    /// first.
    pub fn whole(measured: &'a [Measured], catalogue: &'a Catalogue<'a>, camera: &'a Camera) -> Self {
        Self { measured, catalogue, camera, searched_px: camera.area_px() }
    }

    /// Stars found in windows of `searched_px` in all.
    pub fn windows(
        measured: &'a [Measured],
        catalogue: &'a Catalogue<'a>,
        camera: &'a Camera,
        searched_px: f32,
    ) -> Self {
        Self { measured, catalogue, camera, searched_px }
    }

    /// The measured stars, at most [`MAX_MEASURED`].
    pub fn measured(&self) -> &'a [Measured] {
        self.measured.get(..MAX_MEASURED).unwrap_or(self.measured)
    }
}
