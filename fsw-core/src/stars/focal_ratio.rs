//! The focal length that an image's matched stars ask for.
//!
//! In: where stars were measured and where they are projected. Out: the ratio of measured to projected
//! distances from their means, least squares, with its sigma. An attitude takes up a shift and a turn, but no
//! stretch.

/// The focal length that suits an image's stars best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FocalRatio {
    /// Over that of the camera.
    pub ratio: f32,
    /// Its standard deviation by what the stars are off once it is taken; infinite for fewer than three.
    pub sigma: f32,
}

/// Ratio of the measured to the projected distances from their means, of `count` matched stars whose measured
/// and projected `positions` are given, px, as often as they are asked for.
#[inline(never)]
pub(super) fn focal_ratio<P>(count: usize, positions: impl Fn() -> P) -> FocalRatio
where
    P: Iterator<Item = ([f32; 2], [f32; 2])>,
{
    let count = (count as f32).max(1.0);
    let ([sx, sy], [px, py]) =
        positions().fold(([0.0f32; 2], [0.0f32; 2]), |([sx, sy], [px, py]), (seen, projected)| {
            ([sx + seen[0], sy + seen[1]], [px + projected[0], py + projected[1]])
        });
    // Of the distances projected, and of what they are off.
    let (off, square, off_square) = positions().fold((0.0f32, 0.0f32, 0.0f32), |sums, (seen, projected)| {
        let (vx, vy) = (projected[0] - px / count, projected[1] - py / count);
        let (dx, dy) = (seen[0] - sx / count - vx, seen[1] - sy / count - vy);
        (sums.0 + dx * vx + dy * vy, sums.1 + vx * vx + vy * vy, sums.2 + dx * dx + dy * dy)
    });
    // Two residuals a star, less two of the mean, the roll and the ratio.
    let freedom = 2.0 * count - 4.0;
    if square <= 1.0 || freedom < 2.0 {
        return FocalRatio { ratio: 1.0, sigma: f32::INFINITY };
    }
    let left = (off_square - off * off / square).max(0.0) / freedom;
    FocalRatio { ratio: 1.0 + off / square, sigma: libm::sqrtf(left / square) }
}
