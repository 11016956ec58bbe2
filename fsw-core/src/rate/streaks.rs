//! Arc and mark of a streak in an image.
//!
//! In: a streak, px, with its standard deviations along and across, and the times of its rows. Out: its
//! [`Arc`], of which the rate is solved, and its [`Mark`], which the next image may show again; `None` where
//! the camera sees no direction there.

use super::arcs::Arc;
use super::marks::Mark;
use crate::camera::Camera;
use crate::image::streaks::Streak;
use nalgebra::Vector3;

/// The arc of a streak exposed for `exposure_s`, its rows `row_time_s` one after the other. `longest_px` is
/// how long a streak may be: a cut one shows less of its direction.
#[inline(never)]
pub fn arc_of(
    camera: &Camera,
    streak: &Streak,
    exposure_s: f32,
    row_time_s: f32,
    longest_px: f32,
) -> Option<Arc> {
    let [first, second] = streak.ends_px;
    let ends = [*camera.direction(first)?.vector(), *camera.direction(second)?.vector()];
    let stretch = if streak.cut { (longest_px / streak.length_px().max(1.0)).max(1.0) } else { 1.0 };
    let per = core::f32::consts::SQRT_2 * camera.rad_per_px();
    let rows_s = (second[1] - first[1]) * row_time_s;
    Some(Arc {
        ends,
        sigma_rad: [streak.sigma_along_px * per, streak.sigma_across_px * per * stretch],
        duration_s: [exposure_s + rows_s, exposure_s - rows_s],
        directed: false,
        whole: !streak.cut,
    })
}

/// The mark of a whole streak, whose middle was exposed `late_s` after the middle of the frame.
#[inline(never)]
pub fn mark_of(camera: &Camera, streak: &Streak, late_s: f32) -> Option<Mark> {
    let [first, second] =
        streak.ends_px.map(|end| camera.direction(end).map(|direction| *direction.vector()));
    let per = core::f32::consts::FRAC_1_SQRT_2 * camera.rad_per_px();
    Some(Mark {
        // Not the middle of the pixels: equal times are equal angles.
        direction: (first? + second?).try_normalize(1e-3)?,
        sigma_rad: [streak.sigma_along_px * per, streak.sigma_across_px * per],
        late_s,
    })
}

/// Where the star of a streak was in the middle of the exposure: on its circle about the axis of the rate, rad/s,
/// not on the chord between the ends. In which sense it turned does not matter. `None` where the camera sees no
/// direction there, or without a rate.
#[inline(never)]
pub fn middle_of(camera: &Camera, streak: &Streak, rate_rad_s: &Vector3<f32>) -> Option<Vector3<f32>> {
    let [first, second] =
        streak.ends_px.map(|end| camera.direction(end).map(|direction| *direction.vector()));
    let (sum, axis) = (first? + second?, rate_rad_s.try_normalize(1e-9)?);
    let along = 0.5 * axis.dot(&sum);
    let across = (sum - axis * (2.0 * along)).try_normalize(1e-6)?;
    Some(axis * along + across * libm::sqrtf((1.0 - along * along).max(0.0)))
}
