//! The Sun in front of a path: whether it blinds the detector, and how.
//!
//! A path is blinded as soon as the Sun's disc touches the rectangle of the detector, as if the baffle were perfect: no
//! stray light from outside. Inside, the lens focuses it into an image of some hundred pixels, and light scattered at
//! mirror, filter and lens veils the whole detector (thesis figs. 8.2 to 8.4: even the attenuated Earth path shows
//! nothing else). Veil: [`VEIL`] of what enters the aperture, spread evenly,
//! `E A / hν · QE · fill · VEIL / pixels`. With 500 W/m² in the band, a 10 mm aperture and 1.3 million pixels that is
//! 3.7e6 e-/s a pixel: full scale (40,000 e-) in 11 ms.

use super::attitude::Vector;
use super::earth::EarthModel;
use super::optics::Optics;
use super::vector::angle;
use fsw_hal::DetectorGeometry;

/// Angular radius of the Sun at 1 au, rad (0.2666 deg).
pub const RADIUS_RAD: f64 = 4.653e-3;
/// Share of the light that enters the aperture and ends up evenly on the detector, whichever path the Sun is in: the
/// scattering is before the grey filter.
pub const VEIL: f64 = 1e-4;

/// Whether the Sun's disc, centred on `direction` in the frame of the path `optics`, touches the detector's field.
pub fn touches(optics: &Optics, direction: Vector) -> bool {
    // Half a degree more than the disc keeps directions away at which the distortion folds over.
    let margin_px = 2.0 * RADIUS_RAD * optics.focal_length_px();
    if direction[2] < optics.cone_cosine(margin_px) {
        return false;
    }
    let nearest = optics.project(direction).map(|pixel| optics.clamped(pixel));
    let edge = nearest.and_then(|pixel| optics.unproject(pixel));
    edge.is_some_and(|edge| angle(edge, direction) <= RADIUS_RAD)
}

/// Electrons a second in every pixel of a blinded detector.
pub fn veil_e_s(model: &EarthModel, geometry: &DetectorGeometry) -> f64 {
    VEIL * model.aperture_e_s() / geometry.whole().area() as f64
}
