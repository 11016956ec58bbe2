//! Dark level and noise of an image and of its lines, from their darkest blocks.

use super::{FINE_SHIFT, for_each_line};
use crate::order::two_least;
use fsw_hal::{Detector, DetectorError};

/// Lines of a search from one that is read to the next.
const LINES: u16 = 4;
/// Pixels of a block.
const BLOCK: usize = 16;
/// Sum of a block of the brightest pixels there can be.
const BRIGHTEST_BLOCK: u32 = u16::MAX as u32 * BLOCK as u32;
/// Sigma of white noise over the sum of its steps in a block, in 256ths of a count of [`FINE_SHIFT`]:
/// sqrt(pi) / 2 of the mean step.
const SIGMA_OF_STEPS: u32 = 968;

/// Sum of the darkest block of a line and sigma of the noise in it, fine counts.
pub(super) fn darkest_block(pixels: &[u16]) -> (u32, i32) {
    let (mut least, mut found) = (BRIGHTEST_BLOCK, &[][..]);
    for block in pixels.chunks_exact(BLOCK) {
        let sum = block.iter().map(|raw| u32::from(*raw)).sum();
        if sum < least {
            (least, found) = (sum, block);
        }
    }
    let step = |pair: &[u16]| match pair {
        [one, other] => u32::from(one.abs_diff(*other)),
        _ => 0,
    };
    let steps: u32 = found.windows(2).map(step).sum();
    (least, ((steps * SIGMA_OF_STEPS) >> 8) as i32)
}

/// Mean of a block of this sum, fine counts.
pub(super) fn block_mean(sum: u32) -> i32 {
    ((sum >> BLOCK.ilog2()) << FINE_SHIFT) as i32
}

/// Level of the darkest sky of an image searched with this step, fine counts: the second smallest of the
/// lines' darkest blocks, so that one defective line does no harm.
pub(in crate::earth) fn sky_level(
    detector: &mut impl Detector<Error = DetectorError>,
    buffer: &mut [u16],
    step: u16,
) -> Result<i32, DetectorError> {
    let mut least = [BRIGHTEST_BLOCK; 2];
    for_each_line(detector, buffer, [step / 2, step.saturating_mul(LINES)], |_, _, _, pixels| {
        let (of_line, _) = darkest_block(pixels);
        least = two_least(least, of_line);
        Ok(())
    })?;
    let [_, sum] = least;
    Ok(block_mean(sum))
}
