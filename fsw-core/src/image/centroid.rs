//! Is it a star, and where is its centre? (thesis §3.1.1, steps 2 and 3)
//!
//! In: conditioned pixels and the position of a local maximum. Out: a [`Detection`], or `None`.
//!
//! The region is square about the maximum, 5 x 5 to 13 x 13: it grows until the ring around it falls below a share of
//! the maximum, so sharp, blunt and saturated stars are all taken whole; what never falls off is an extended object
//! (Moon, Earth's rim, comet) and refused. The thesis's ratios are then taken between the maximum, the region, the
//! inner ring (half way) and the outer ring (edge); for the 5 x 5 region they are its 3 x 3 and 5 x 5 rings.
//!
//! Centre of intensity: `c = Σ (s - floor) x / Σ (s - floor)` over the region, floor = mean of the ring just outside.
//! Its variance from background noise is `sigma² Σ dx² / flux²`, to which the parameter `centroid_floor_millipx` adds
//! what photon noise and pixel phase leave.

use super::condition::Residuals;
use super::{Detection, DetectionParameters};

/// Half the region's side, smallest to largest.
pub const HALF_SIDES: [usize; 4] = [2, 3, 4, 6];
/// Pixels needed around a maximum: the largest region and the ring outside it.
pub const MARGIN: usize = 7;

/// Sum and number of the pixels on the square ring at distance `radius` from (x, y).
fn ring(window: &Residuals, x: usize, y: usize, radius: usize) -> (i32, i32) {
    let side = 2 * radius;
    let (left, top) = (x - radius, y - radius);
    let sum = (0..side).fold(0, |sum, step| {
        sum + window.at(left + step, top)
            + window.at(left + side, top + step)
            + window.at(left + side - step, top + side)
            + window.at(left, top + side - step)
    });
    (sum, 4 * side as i32)
}

/// Judges the local maximum at (x, y) of the window and centres it. The position returned counts from the window's
/// first pixel.
pub fn measure(
    window: &Residuals,
    x: usize,
    y: usize,
    parameters: &DetectionParameters,
) -> Option<Detection> {
    if x < MARGIN || y < MARGIN || x + MARGIN >= window.width() || y + MARGIN >= window.height() {
        return None;
    }
    let peak = window.at(x, y).max(1);
    let saturated = peak >= window.saturation;
    let share = |percent: u16| peak * i32::from(percent) / 100;
    // Noise of a ring's mean must not pass for a skirt.
    let skirt = share(parameters.skirt_share_percent).max(window.sigma);
    let half = HALF_SIDES.into_iter().find(|half| {
        let (sum, count) = ring(window, x, y, half + 1);
        sum <= skirt * count
    })?;

    let (floor_sum, floor_count) = ring(window, x, y, half + 1);
    let mean = |radius: usize| {
        let (sum, count) = ring(window, x, y, radius);
        sum / count - floor_sum / floor_count
    };
    let (inner, outer) = (mean(half / 2), mean(half));
    let maximum = peak - floor_sum / floor_count;
    let exceeds = |value: i32, percent: u16, other: i32| value * 100 > i32::from(percent) * other;
    if !exceeds(inner, parameters.inner_to_outer_percent, outer) {
        return None;
    }
    if inner * 100 < i32::from(parameters.inner_share_percent) * maximum {
        return None;
    }
    if !saturated && !exceeds(maximum, parameters.peak_to_inner_percent, inner) {
        return None;
    }

    // Sums in units of 1 / floor_count, so that the floor is exact.
    let (mut flux, mut moment_x, mut moment_y) = (0i64, 0i64, 0i64);
    let reach = half as i32;
    for dy in -reach..=reach {
        for dx in -reach..=reach {
            let value = window.at(x.wrapping_add_signed(dx as isize), y.wrapping_add_signed(dy as isize));
            let signal = i64::from(value * floor_count - floor_sum);
            flux += signal;
            moment_x += signal * i64::from(dx);
            moment_y += signal * i64::from(dy);
        }
    }
    let side = 2 * reach + 1;
    let area = i64::from(side * side);
    if flux <= 0
        || i64::from(maximum) * 100 * area * i64::from(floor_count)
            <= flux * i64::from(parameters.peak_to_region_percent)
    {
        return None;
    }
    let offset = |moment: i64| ((moment << 16) / flux) as i32;
    let (offset_x, offset_y) = (offset(moment_x), offset(moment_y));
    // A centre far from its maximum is two stars or an edge.
    let limit = reach << 15;
    if offset_x.abs() > limit || offset_y.abs() > limit {
        return None;
    }
    let counts = (flux / i64::from(floor_count)).max(1);
    // Σ dx² over the region = side · reach (reach + 1) side / 3.
    let spread = side * side * reach * (reach + 1) / 3;
    // Where neighbours go together the noise of a region is larger than its pixels' noise says.
    let noise = window.sum_sigma as f32 / 3.0 * libm::sqrtf(spread as f32) / counts as f32;
    let floor = f32::from(parameters.centroid_floor_millipx) * 1e-3;
    let core = i64::from(window.sum9(x, y) * floor_count - 9 * floor_sum) / i64::from(floor_count);
    Some(Detection {
        core_flux: if saturated { i32::MAX } else { core as i32 },
        x_q16: ((x as i32) << 16) + offset_x,
        y_q16: ((y as i32) << 16) + offset_y,
        flux: counts.min(i64::from(i32::MAX)) as i32,
        sigma_q16: (libm::sqrtf(noise * noise + floor * floor) * 65_536.0) as i32,
        saturated,
    })
}
