//! Length of a strip that contains the whole rise of the limb.
//!
//! In: height that a pixel spans at the limb, sigma of the limb's height, how far the limb is drawn out. Out:
//! the strip's [`Reach`], or `None` where it exceeds the longest strip.

use super::EarthParameters;
use super::limb::{MAX_LENGTH, Reach};

/// Most strips across the limb in a second: 0.08 M cycles each, 2 of the 4 M that the Earth may take.
pub const MAX_LIMB_STRIPS: usize = 24;
/// Height of the limb's glow, scale heights: there it has fallen to 1 %.
const GLOW_SCALES: f32 = 4.5;
/// Depth of a strip inside the limb, scale heights: the end of the rise at 0.7, and 0.5 of bright side.
const BRIGHT_SCALES: f32 = 1.5;
/// Margin of a strip beyond the glow on either side, px: the blurred edge, and flat dark and bright ends.
pub const STRIP_MARGIN_PX: f32 = 9.0;

/// Height over which the limb's glow fades, km.
pub fn glow_km(parameters: &EarthParameters) -> f32 {
    GLOW_SCALES * parameters.limb.scale_height_km
}

/// How far a strip must reach from the expected limb, when its height there is known to `sigma_km` (3 sigma
/// are allowed for) and the exposure draws it out by `drawn_px`; `None` when the strip would be longer than
/// one can be.
pub fn limb_reach(
    km_per_px: f32,
    sigma_km: f32,
    drawn_px: f32,
    parameters: &EarthParameters,
) -> Option<Reach> {
    let margin_px = STRIP_MARGIN_PX + 0.5 * drawn_px;
    let reach_px = |km: f32| libm::ceilf(margin_px + (km + 3.0 * sigma_km) / km_per_px);
    let outward = reach_px(glow_km(parameters));
    let inward = reach_px(BRIGHT_SCALES * parameters.limb.scale_height_km);
    // Also refuses what is no number.
    let fits = outward + inward < MAX_LENGTH as f32;
    fits.then_some(Reach { outward_px: outward as u16, inward_px: inward as u16 })
}

#[cfg(test)]
mod tests;
