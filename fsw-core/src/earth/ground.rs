//! Ground at the limb that is brighter or darker than usual, and the limb's height.
//!
//! In: limb points of strips, each with the brightness of the ground just inside. Out: these points, moved.
//!
//! An edge is where the air has a share of the brightness of the ground just inside ([`super::limb`]). That
//! ground stands before the limb, by 200 km from a low orbit and by 500 km from GEO: what clouds there are
//! is another thing there. Where it is brighter than usual, the limb's own ground is so by less in the mean;
//! then a share of too much light is asked for, and the edge is found too low. So a point moves outward by
//! the share `earth.limb.ground_share` of how much brighter it is, times the lever of the edge.
//!
//! Usual is the mean of all that was seen before, of six hours at most: no radiometric calibration is asked
//! for, but the lens's vignetting is taken off ([`Camera::light_share`]): what is dark by it, all along a
//! field's edge, would bend the limb. A mean that is wrong lifts all points alike, which the orbit's `h0` and
//! `e` take up.
//!
//! Without this belts of cloud, the ice and the open sea bend an orbit: they last as long as what the orbit
//! filter learns from.

use super::LimbPoint;
use super::parameters::LimbParameters;
use crate::camera::Camera;

/// Time over which the usual brightness is a mean, s: four revolutions in a low orbit; in GEO the Sun goes
/// by a quarter.
const LONGEST_S: f32 = 21_600.0;
/// Greatest part by which ground counts as brighter or darker: clouds are twice as bright as the mean.
const MOST: f32 = 1.0;

/// The ground just inside a limb point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ground {
    /// Its brightness over that of white ground under this Sun, counts; 0 where it was not measured. As the
    /// detector has it, until [`UsualGround::correct`] takes the lens's vignetting off.
    pub brightness: f32,
    /// How far outward the edge is found where the limb's own ground is twice as bright, were the edge
    /// straight, px.
    pub lever_px: f32,
}

/// Brightness that is usual.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UsualGround {
    /// The mean, counts; 0 where nothing was seen.
    brightness: f32,
    /// Its weight, s.
    seconds: f32,
}

impl UsualGround {
    /// Takes in the ground of a second's points, seen by `camera`, and moves them.
    #[inline(never)]
    pub fn correct(&mut self, points: &mut [LimbPoint], camera: &Camera, parameters: &LimbParameters) {
        for point in points.iter_mut() {
            point.ground.brightness /= camera.light_share(point.centre_px);
        }
        let (mut sum, mut count) = (0.0, 0.0);
        for brightness in points.iter().map(|point| point.ground.brightness).filter(|seen| *seen > 0.0) {
            (sum, count) = (sum + brightness, count + 1.0);
        }
        if count == 0.0 {
            return;
        }
        self.seconds = (self.seconds + 1.0).min(LONGEST_S);
        self.brightness += (sum / count - self.brightness) / self.seconds;
        for LimbPoint { centre_px, outward_px, ground, .. } in points {
            let brighter = (ground.brightness / self.brightness - 1.0).clamp(-MOST, MOST);
            let outward = parameters.ground_share * brighter * ground.lever_px;
            for (place, along) in centre_px.iter_mut().zip(outward_px) {
                *place += outward * *along;
            }
        }
    }

    /// One of a brightness, for tests.
    #[cfg(test)]
    pub(crate) fn sample(brightness: f32) -> Self {
        Self { brightness, seconds: 1.0 }
    }

    /// Sum of its words.
    pub fn word_sum(&self) -> u32 {
        fsw_ground::word_sum::of_singles(&[self.brightness, self.seconds])
    }
}

#[cfg(test)]
mod tests;
