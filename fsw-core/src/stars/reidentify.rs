//! Identification with a former attitude as the hypothesis.
//!
//! In: an attitude that was known some seconds ago, carried to the image or not, and the measured stars. Out:
//! identified stars and a verified attitude, as a search without prior knowledge gives them
//! ([`identify`](super::identify)), or `None`.
//!
//! That search begins with the brightest spots. Where hits and false stars outnumber the stars it may take
//! many seconds, and finds nothing in the end. The former attitude says where the stars are but for what the
//! sensor has turned since, which moves them all alike: every pair of an expected and a measured star that
//! lie within [`REACH_PX`] proposes a displacement, the one on which most pairs agree is taken, and the
//! attitude that it gives is [confirmed](super::confirm) like any other, its chance times the number of
//! displacements that are no longer: that a chance match moves the stars by little is unlikely by itself.
//! Where the rate is known, fewer stars are so enough. A roll of 0.2 deg and more is out of reach.

use super::StarField;
use super::confirm::{Confirmed, confirm, widen};
use super::parameters::IdentificationParameters;
use super::predict::field_stars;
use crate::frames::{Icrs, Rotation, StarPath};
use crate::order::most_alike;
use heapless::Vec;

/// So far the stars may have moved along either axis, px: 1.2 deg for the reference camera, which a low
/// orbit's pitch of 0.06 deg/s takes 20 s for.
pub const REACH_PX: f32 = 64.0;
/// Displacements of the same turn differ by less along either axis, px: at the reach a turn moves stars in
/// the corners of 15 deg 3 px farther than in the middle.
const ALIKE_PX: f32 = 3.0;
/// Most displacements compared. Of 48 expected and 64 measured stars 40 pairs lie within reach by chance.
const MAX_DISPLACEMENTS: usize = 128;
/// The tolerance of the confirmation is that of this step of the search: centroids of images that shake.
const STEP: usize = 1;

/// The displacement, px, on which most pairs of an expected and a measured star agree: the mean of theirs.
fn common_displacement(displacements: &[[f32; 2]]) -> Option<[f32; 2]> {
    let alike = |one: [f32; 2], other: [f32; 2]| {
        (one[0] - other[0]).abs() < ALIKE_PX && (one[1] - other[1]).abs() < ALIKE_PX
    };
    let (best, count) = most_alike(displacements, alike)?;
    let of_best = displacements.iter().filter(|other| alike(best, **other));
    let [x, y] = of_best.fold([0.0, 0.0], |[x, y], [dx, dy]| [x + dx, y + dy]);
    Some([x / count as f32, y / count as f32])
}

/// The `former` attitude turned by what moves most of its stars onto measured ones, and how many
/// displacements that differ are no longer; `None` where there is no pair within reach. Not inlined: keeps
/// its lists off the stack of the confirmation.
#[inline(never)]
fn displaced(
    former: &Rotation<Icrs, StarPath>,
    field: &StarField,
) -> Option<(Rotation<Icrs, StarPath>, f32)> {
    let mut displacements: Vec<[f32; 2], MAX_DISPLACEMENTS> = Vec::new();
    for star in &field_stars(field.catalogue, field.camera, former)? {
        for seen in field.measured() {
            let ([x, y], [to_x, to_y]) = (star.centre_px, seen.centre_px);
            let [dx, dy] = [to_x - x, to_y - y];
            if dx.abs() < REACH_PX && dy.abs() < REACH_PX {
                // Of more than there is room for those of the brightest stars are compared.
                let _ = displacements.push([dx, dy]);
            }
        }
    }
    let [dx, dy] = common_displacement(&displacements)?;
    let [x, y] = field.camera.middle_px();
    let (before, after) = (field.camera.direction([x, y])?, field.camera.direction([x + dx, y + dy])?);
    let sides = 1.0 + dx.abs().max(dy.abs()) / ALIKE_PX;
    Some((former.turned(&after.vector().cross(before.vector())), sides * sides))
}

/// Identifies the stars of `field` near to the `former` attitude; the logarithm is that of the
/// false-identification probability over all displacements that are no longer than the one taken. `None`
/// where fewer than three stars match or it exceeds `log10_false_limit`.
#[inline(never)]
pub fn reidentify(
    former: &Rotation<Icrs, StarPath>,
    field: &StarField,
    parameters: &IdentificationParameters,
    log10_false_limit: f32,
) -> Option<(Confirmed, f32)> {
    let tolerance_px = parameters.tolerance_px(STEP);
    let (attitude, hypotheses) = displaced(former, field)?;
    let mut confirmed = confirm(&attitude, field, tolerance_px)?;
    let log10_false = (confirmed.log10_chance + libm::log10f(hypotheses)).min(0.0);
    if log10_false > log10_false_limit {
        return None;
    }
    widen(&mut confirmed, field, tolerance_px);
    Some((confirmed, log10_false))
}

#[cfg(test)]
mod tests;
