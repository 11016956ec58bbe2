//! The solution as a FITS header: world coordinates of pixels by Greisen and Calabretta (2002).
//!
//! In: where a picture looks. Out: bytes of a header without data, blocks of 2880 bytes of cards of 80
//! (FITS 4.0, sections 3 and 8). The reference point is the line of sight at the optical centre; there
//! `(xi, eta) = CD (p - CRPIX)` are standard coordinates east and north: of a rectilinear lens gnomonic
//! (TAN), of an equiangular one zenithal equidistant (ARC). Distortion is not in these keywords; a comment
//! says how much that is. Pixel (1, 1) of FITS is the first pixel read, and row 1 the upper one.

use super::pointing::{Pointing, east_north, ra_dec_deg};
use crate::world::attitude::{apply, dot};
use fsw_core::camera::{Distortion, Projection};

const BLOCK_BYTES: usize = 2880;
const CARD_BYTES: usize = 80;
/// Longest text of a comment card, bytes.
const COMMENT_BYTES: usize = 70;

/// A projection onto the picture that is linear in standard coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldCoordinates {
    /// The lens's ideal projection.
    pub projection: Projection,
    /// Reference pixel, the first one (0, 0), px.
    pub reference_px: [f64; 2],
    /// Right ascension and declination there, degrees.
    pub reference_deg: [f64; 2],
    /// Degrees east and north for each pixel right and down.
    pub cd_deg_px: [[f64; 2]; 2],
}

impl WorldCoordinates {
    /// Those of a solved picture.
    pub fn new(pointing: &Pointing) -> Self {
        let parameters = pointing.camera.parameters();
        // The third row of the attitude is the line of sight.
        let [_, _, sight] = pointing.attitude;
        let per_px = f64::from(parameters.focal_length_px).recip().to_degrees();
        let right = if parameters.mirrored { -per_px } else { per_px };
        let row = |axis| {
            let [x, y, _] = apply(&pointing.attitude, axis);
            [x * right, y * per_px]
        };
        Self {
            projection: parameters.projection,
            reference_px: parameters.optical_centre_px.map(f64::from),
            reference_deg: ra_dec_deg(sight),
            cd_deg_px: east_north(sight).map(row),
        }
    }

    /// Where they put the direction that the camera shows at a pixel, px.
    fn image_px(&self, pointing: &Pointing, at_px: [f32; 2]) -> Option<[f64; 2]> {
        let (seen, [_, _, sight]) = (pointing.sky(at_px)?, pointing.attitude);
        let [east, north] = east_north(sight).map(|axis| dot(seen, axis));
        let (across, along) = (libm::hypot(east, north), dot(seen, sight));
        let radius_rad = match self.projection {
            Projection::Rectilinear => across / along,
            Projection::Equiangular => libm::atan2(across, along),
        };
        let scale = radius_rad.to_degrees() / across.max(f64::MIN_POSITIVE);
        let [[a, b], [c, d]] = self.cd_deg_px;
        let (xi, eta, determinant) = (scale * east, scale * north, a * d - b * c);
        let [x, y] = self.reference_px;
        Some([x + (d * xi - b * eta) / determinant, y + (a * eta - c * xi) / determinant])
    }

    /// How far from its true place distortion moves a corner of the picture at most, px.
    fn distortion_px(&self, pointing: &Pointing) -> f64 {
        let moved = |corner: [f32; 2]| {
            let [x, y] = self.image_px(pointing, corner)?;
            Some(libm::hypot(x - f64::from(corner[0]), y - f64::from(corner[1])))
        };
        pointing.camera.corners_px().into_iter().filter_map(moved).fold(0.0, f64::max)
    }
}

/// The header of a solved picture.
pub fn header(pointing: &Pointing) -> Vec<u8> {
    let coordinates = WorldCoordinates::new(pointing);
    let parameters = pointing.camera.parameters();
    let kind = match coordinates.projection {
        Projection::Rectilinear => "TAN",
        Projection::Equiangular => "ARC",
    };
    let [[cd11, cd12], [cd21, cd22]] = coordinates.cd_deg_px;
    let mut cards = vec![
        value("SIMPLE", "T", "a header without data"),
        value("BITPIX", "8", ""),
        value("NAXIS", "0", ""),
        value("WCSAXES", "2", ""),
        text("CTYPE1", &format!("RA---{kind}"), "right ascension"),
        text("CTYPE2", &format!("DEC--{kind}"), "declination"),
        text("CUNIT1", "deg", ""),
        text("CUNIT2", "deg", ""),
        value("CRPIX1", &fixed(coordinates.reference_px[0] + 1.0), "optical centre, px; first pixel 1"),
        value("CRPIX2", &fixed(coordinates.reference_px[1] + 1.0), "row 1 is the upper one"),
        value("CRVAL1", &fixed(coordinates.reference_deg[0]), "right ascension there, deg"),
        value("CRVAL2", &fixed(coordinates.reference_deg[1]), "declination there, deg"),
        value("CD1_1", &exponent(cd11), "deg east a px right"),
        value("CD1_2", &exponent(cd12), "deg east a px down"),
        value("CD2_1", &exponent(cd21), "deg north a px right"),
        value("CD2_2", &exponent(cd22), "deg north a px down"),
        text("RADESYS", "ICRS", ""),
        value("IMAGEW", &parameters.width_px.to_string(), "columns of the picture"),
        value("IMAGEH", &parameters.height_px.to_string(), "rows of the picture"),
        text("ROWORDER", "TOP-DOWN", "order of the rows"),
    ];
    if parameters.distortion != Distortion::default() {
        cards.push(comment("The camera's distortion is not in these keywords. They put a corner"));
        let moved_px = coordinates.distortion_px(pointing);
        cards.push(comment(&format!("of the picture up to {moved_px:.2} px from its place.")));
    }
    cards.push(format!("{:<CARD_BYTES$}", "END"));
    let mut bytes = cards.concat().into_bytes();
    bytes.resize(bytes.len().next_multiple_of(BLOCK_BYTES), b' ');
    bytes
}

fn fixed(value: f64) -> String {
    format!("{value:.12}")
}

fn exponent(value: f64) -> String {
    format!("{value:.12E}")
}

/// A card with a number or a logical value, which ends in column 30.
fn value(keyword: &str, value: &str, comment: &str) -> String {
    card(&format!("{keyword:<8}= {value:>20}"), comment)
}

/// A card with text of at least eight characters, which begins in column 11.
fn text(keyword: &str, text: &str, comment: &str) -> String {
    card(&format!("{keyword:<8}= {:<20}", format!("'{text:<8}'")), comment)
}

fn card(words: &str, comment: &str) -> String {
    let slash = if comment.is_empty() { "" } else { " / " };
    format!("{:<CARD_BYTES$.CARD_BYTES$}", format!("{words}{slash}{comment}"))
}

fn comment(words: &str) -> String {
    format!("COMMENT {words:<72.COMMENT_BYTES$}")
}

#[cfg(test)]
mod tests;
