//! Arc and mark of a streak in an image.
//!
//! In: a streak, px, with its standard deviations along and across, and the times of its rows. Out: its
//! [`Arc`], of which the rate is solved, and of that its [`Mark`], which the next image may show again; `None`
//! where the camera sees no direction there.

use super::arcs::Arc;
use super::marks::Mark;
use crate::camera::Camera;
use crate::image::streaks::Streak;
use nalgebra::Vector3;

/// Where the ends of a streak are seen, unit vectors.
fn ends_of(camera: &Camera, streak: &Streak) -> Option<[Vector3<f32>; 2]> {
    let [first, second] = streak.ends_px;
    Some([*camera.direction(first)?.vector(), *camera.direction(second)?.vector()])
}

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
    let ends = ends_of(camera, streak)?;
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

/// The mark of a whole streak's arc, whose middle was exposed `late_s` after the middle of the frame.
#[inline(never)]
pub fn mark_of(arc: &Arc, late_s: f32) -> Option<Mark> {
    let [first, second] = arc.ends;
    Some(Mark {
        // Not the middle of the pixels: equal times are equal angles.
        direction: (first + second).try_normalize(1e-3)?,
        // The displacement of one end against the other is twice as uncertain as their mean.
        sigma_rad: arc.sigma_rad.map(|sigma| 0.5 * sigma),
        late_s,
    })
}

/// Where the star of a streak was in the middle of the exposure: on its circle about the axis of the rate,
/// rad/s, not on the chord between the ends. In which sense it turned does not matter. `None` where the
/// camera sees no direction there, or without a rate.
#[inline(never)]
pub fn middle_of(camera: &Camera, streak: &Streak, rate_rad_s: &Vector3<f32>) -> Option<Vector3<f32>> {
    let [first, second] = ends_of(camera, streak)?;
    let (sum, axis) = (first + second, rate_rad_s.try_normalize(1e-9)?);
    let along = 0.5 * axis.dot(&sum);
    let across = (sum - axis * (2.0 * along)).try_normalize(1e-6)?;
    Some(axis * along + across * libm::sqrtf((1.0 - along * along).max(0.0)))
}

/// Standard deviation of that middle an axis, px, where the streak's [`arc`](arc_of) is `off` sigmas longer
/// or shorter than the rate has it. Where that is much, one of its ends is not the star's, but noise's or
/// another's, and the middle is off by about as many of its own sigmas. Of 9,500 middles in flights at up to 5
/// deg/s those were 1.0 sigma off, rms, whose length was off by less than one, 2.6 at 3 to 4, 5.2 at 6 to 10.
pub fn middle_sigma_px(streak: &Streak, off: f32) -> f32 {
    let along_px = streak.sigma_along_px * libm::sqrtf((0.5 * (1.0 + off * off)).max(1.0));
    along_px.max(streak.sigma_across_px) * core::f32::consts::FRAC_1_SQRT_2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Direction;
    use crate::oracle::{Generator, reference_camera};
    use crate::rate::arcs::misfits;
    use crate::rate::marks::rotated;

    #[test]
    fn the_middle_of_a_streak_is_where_its_star_was_in_the_middle_of_the_exposure() {
        let camera = Camera::new(reference_camera()).unwrap();
        let mut generator = Generator::new(5);
        let mut chords = 0.0f32;
        for _ in 0..500 {
            // Up to 8 deg/s for 0.4 s, often about the line of sight.
            let axis = generator.unit() + Vector3::z() * generator.between(-2.0, 2.0);
            let rate = axis.normalize().map(|part| part as f32) * generator.between(0.01, 0.14) as f32;
            let at_px = [generator.between(100.0, 1180.0), generator.between(100.0, 900.0)];
            let star = *camera.direction(at_px.map(|at| at as f32)).unwrap().vector();
            let mark = Mark { direction: star, sigma_rad: [1e-4; 2], late_s: 0.0 };
            let ends = [-0.2, 0.2].map(|seconds| Direction::new(rotated(&mark, &rate, seconds)).unwrap());
            let [Some(from), Some(to)] = ends.map(|end| camera.project(&end)) else { continue };
            let (sigma_along_px, sigma_across_px) = (0.3, 0.2);
            for ends_px in [[from, to], [to, from]] {
                let streak = Streak { ends_px, sigma_along_px, sigma_across_px, cut: false, light: 100.0 };
                for rate in [rate, -rate] {
                    let middle = middle_of(&camera, &streak, &rate).unwrap();
                    assert!((middle - star).norm() < 3e-6, "{at_px:?}, {rate}");
                }
                let chord = mark_of(&arc_of(&camera, &streak, 0.4, 0.0, 0.0).unwrap(), 0.0).unwrap();
                chords = chords.max((chord.direction - star).norm());
            }
        }
        // The middle of the chord is off by up to a third of a pixel.
        assert!(chords > 5e-5, "{chords}");
    }

    #[test]
    fn the_sigma_of_a_middle_holds_an_end_that_is_not_the_stars() {
        const SIGMA_PX: f32 = 0.4;
        let camera = Camera::new(reference_camera()).unwrap();
        let rate = Vector3::new(0.01, -0.02, 0.004);
        let mut generator = Generator::new(6);
        // Of every range of lengths that misfit: number of middles, mean square over sigma, and over that of
        // an end.
        let mut ranges = [(3.0, 0, 0.0, 0.0), (6.0, 0, 0.0, 0.0), (f32::MAX, 0, 0.0, 0.0)];
        for _ in 0..4000 {
            let at_px = [generator.between(200.0, 1080.0), generator.between(200.0, 800.0)];
            let star = *camera.direction(at_px.map(|at| at as f32)).unwrap().vector();
            let mark = Mark { direction: star, sigma_rad: [1e-4; 2], late_s: 0.0 };
            let ends = [-0.2, 0.2].map(|seconds| Direction::new(rotated(&mark, &rate, seconds)).unwrap());
            let [from, to] = ends.map(|end| camera.project(&end).unwrap());
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            let along = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
            // One end in ten is another's.
            let ends_px = [from, to].map(|end| {
                let far = if generator.between(0.0, 1.0) < 0.1 { generator.between(-6.0, 6.0) } else { 0.0 };
                let off = far as f32 + SIGMA_PX * generator.gaussian() as f32;
                [end[0] + off * along[0], end[1] + off * along[1]]
            });
            let (sigma_along_px, sigma_across_px) = (SIGMA_PX, 0.2);
            let streak = Streak { ends_px, sigma_along_px, sigma_across_px, cut: false, light: 100.0 };
            let arc = arc_of(&camera, &streak, 0.4, 0.0, streak.length_px()).unwrap();
            let [off, _] = misfits(&arc, &rate).unwrap();
            let middle = Direction::new(middle_of(&camera, &streak, &rate).unwrap()).unwrap();
            let seen = camera.project(&middle).unwrap();
            let error = (seen[0] - at_px[0] as f32) * along[0] + (seen[1] - at_px[1] as f32) * along[1];
            let range = ranges.iter_mut().find(|(most, ..)| off.abs() < *most).unwrap();
            range.1 += 1;
            range.2 += (error / middle_sigma_px(&streak, off)).powi(2);
            range.3 += (error / middle_sigma_px(&streak, 0.0)).powi(2);
        }
        for (most, count, held, bare) in ranges {
            let [held, bare] = [held, bare].map(|sum| sum / count as f32);
            std::println!("up to {most} sigmas too long, {count}: {held:.2}; without it {bare:.2}");
            assert!(count > 150 && (0.5..2.2).contains(&held), "{most}: {count} {held}");
            assert!(most < 4.0 || bare > 5.0, "{bare}");
        }
    }
}
