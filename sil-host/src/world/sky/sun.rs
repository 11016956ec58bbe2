//! The Sun in front of a path, and its light on the detector.
//!
//! A path is blinded as soon as the Sun's disc touches the rectangle of the detector. The lens then focuses
//! it into an image, and light scattered at mirror, filter and lens veils the whole detector (thesis figs.
//! 8.2 to 8.4: even the attenuated Earth path shows nothing else). Veil: [`VEIL`] of what enters the
//! aperture, spread evenly, `E A / hν · QE · fill · VEIL / pixels`. With 500 W/m² in the band, a 10 mm
//! aperture and 1.3 million pixels that is 3.7e6 e-/s a pixel: full scale (40,000 e-) in 11 ms. What shorter
//! exposures or a shut path leave to be seen is drawn too ([`SunLight`]), each a share of the light that the
//! path lets through, with the shares of a lens of four simple elements as orders of magnitude:
//!
//! | part | share | shape |
//! |---|---|---|
//! | image | 1 | an even disc |
//! | halo | 5e-3 | `r0² / π (r² + r0²)²`, r0 = 20 px: scattering at rough surfaces |
//! | bloom | 1e-3 | along the columns of the image, falling by e in 60 px: charge that spills |
//! | ghost | 1e-5 | an even disc of 60 px, opposite the image through the optical centre: reflection at two surfaces |
//!
//! Outside the field of the star path the baffle scatters: 3000 e-/s a pixel next to the Sun, falling by e in
//! 4 deg of angle between pixel and Sun and nothing with the Sun more than 45 deg from the line of sight. The
//! logarithm is taken as linear over the detector, which is right to a tenth of itself within 12 deg. Behind
//! the grey filter of the Earth path that is nothing.

use crate::world::attitude::Vector;
use crate::world::earth::EarthModel;
use crate::world::lens::optics::Optics;
use crate::world::vector::{angle, cross, unit};
use fsw_hal::{DetectorGeometry, Window};
use std::f64::consts::PI;

/// Angular radius of the Sun at 1 au, rad (0.2666 deg).
pub const RADIUS_RAD: f64 = 4.653e-3;
/// Share of the light that enters the aperture and ends up evenly on the detector, whichever path the Sun is
/// in: the scattering is before the grey filter.
pub const VEIL: f64 = 1e-4;
/// Share of the path's light in the halo.
const HALO: f64 = 5e-3;
const HALO_PX: f64 = 20.0;
/// Share of the path's light that spills along columns.
const BLOOM: f64 = 1e-3;
const BLOOM_PX: f64 = 60.0;
/// Share of the path's light in the ghost.
const GHOST: f64 = 1e-5;
const GHOST_PX: f64 = 60.0;
/// Baffle's scattering in a direction next to the Sun, e-/s a pixel.
const STRAY_E_S: f64 = 3_000.0;
/// Angle in which it falls by e, rad (4 deg).
const STRAY_RAD: f64 = 0.0698;
/// Angle from the line of sight beyond which the baffle shuts the Sun out, rad (45 deg).
const BAFFLE_RAD: f64 = 0.785;

/// Whether the Sun's disc, centred on `direction` in the frame of the path `optics`, touches the detector's
/// field.
pub fn touches(optics: &Optics, direction: Vector) -> bool {
    edge_of_field(optics, direction).is_some_and(|apart| apart <= RADIUS_RAD)
}

/// Angle from `direction` to the nearest place of the field, rad; `None` where it is more than some degrees.
fn edge_of_field(optics: &Optics, direction: Vector) -> Option<f64> {
    // Half a degree more than the disc keeps directions away at which the distortion folds over.
    let margin_px = 2.0 * RADIUS_RAD * optics.focal_length_px();
    if direction[2] < optics.cone_cosine(margin_px) {
        return None;
    }
    let nearest = optics.project(direction).map(|pixel| optics.clamped(pixel));
    let edge = nearest.and_then(|pixel| optics.unproject(pixel))?;
    Some(angle(edge, direction))
}

/// Electrons a second in every pixel of a blinded detector.
pub fn veil_e_s(model: &EarthModel, geometry: &DetectorGeometry) -> f64 {
    VEIL * model.aperture_e_s() / geometry.whole().area() as f64
}

/// The Sun's light in an exposure, without the even veil.
#[derive(Debug, Clone, PartialEq)]
pub enum SunLight {
    /// The Sun is in the field.
    Image {
        /// Middle of the image, px.
        centre_px: [f64; 2],
        /// Middle of the ghost, px.
        ghost_px: [f64; 2],
        /// Radius of the image, px.
        radius_px: f64,
        /// Light of the whole image, e-/s.
        light_e_s: f64,
    },
    /// The Sun is beside the field: stray light of the baffle.
    Stray {
        /// In the optical centre, e-/s a pixel.
        centre_e_s: f64,
        /// Optical centre, px.
        centre_px: [f64; 2],
        /// Growth of the logarithm a pixel along x and y.
        slope: [f64; 2],
    },
}

impl SunLight {
    /// Of a Sun in `direction` in the frame of the path `optics`, which lets the share `transmission` of
    /// `aperture_e_s` through; `None` where nothing of it arrives. Behind a `filter` the baffle's scattering
    /// counts for nothing.
    pub fn new(
        optics: &Optics,
        direction: Vector,
        aperture_e_s: f64,
        transmission: f64,
        filtered: bool,
    ) -> Option<Self> {
        let centre = optics.optical_centre_px();
        if let (true, Some(centre_px)) = (touches(optics, direction), optics.project(direction)) {
            return Some(Self::Image {
                centre_px,
                ghost_px: [0, 1].map(|k| 2.0 * centre[k] - centre_px[k]),
                radius_px: RADIUS_RAD * optics.focal_length_px(),
                light_e_s: aperture_e_s * transmission,
            });
        }
        let sight = [0.0, 0.0, 1.0];
        let apart = angle(sight, direction);
        if filtered || apart > BAFFLE_RAD {
            return None;
        }
        // From the line of sight towards the Sun.
        let [x, y, _] = unit(cross(cross(sight, direction), sight));
        let centre_e_s = STRAY_E_S * libm::exp(-apart / STRAY_RAD);
        let per_px = 1.0 / (STRAY_RAD * optics.focal_length_px());
        let [x, y] = optics.lens_axes([x, y]);
        Some(Self::Stray { centre_e_s, centre_px: centre, slope: [x * per_px, y * per_px] })
    }

    /// Adds the electrons of `time_s` to `electrons`, the pixels of `window` row by row.
    pub fn add_to(&self, window: Window, time_s: f64, electrons: &mut [f64]) {
        let lines = (window.y..).zip(electrons.chunks_exact_mut(usize::from(window.width).max(1)));
        match self {
            Self::Image { .. } => {
                for (y, line) in lines {
                    for (x, pixel) in (window.x..).zip(line) {
                        *pixel += time_s * self.image_e_s([f64::from(x), f64::from(y)]);
                    }
                }
            }
            Self::Stray { centre_e_s, centre_px, slope } => {
                for (y, line) in lines {
                    let row = time_s * centre_e_s * libm::exp((f64::from(y) - centre_px[1]) * slope[1]);
                    for (x, pixel) in (window.x..).zip(line) {
                        *pixel += row * libm::exp((f64::from(x) - centre_px[0]) * slope[0]);
                    }
                }
            }
        }
    }

    /// Electrons a second at a pixel; 0 for stray light.
    fn image_e_s(&self, pixel: [f64; 2]) -> f64 {
        let Self::Image { centre_px, ghost_px, radius_px, light_e_s } = self else { return 0.0 };
        let square = |from: &[f64; 2]| (pixel[0] - from[0]).powi(2) + (pixel[1] - from[1]).powi(2);
        let (r2, radius) = (square(centre_px), *radius_px);
        // The share of the pixel that lies inside, as if the edge were straight.
        let disc = |r2: f64, radius: f64| (radius - r2.sqrt() + 0.5).clamp(0.0, 1.0) / (PI * radius * radius);
        let spread = r2 + HALO_PX * HALO_PX;
        let halo = HALO * HALO_PX * HALO_PX / (PI * spread * spread);
        let beside = (pixel[0] - centre_px[0]).abs() < radius;
        let along = (pixel[1] - centre_px[1]).abs() / BLOOM_PX;
        let bloom = if beside { BLOOM * libm::exp(-along) / (4.0 * BLOOM_PX * radius) } else { 0.0 };
        light_e_s * (disc(r2, radius) + halo + bloom + GHOST * disc(square(ghost_px), GHOST_PX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::camera_file::CameraFile;

    const APERTURE_E_S: f64 = 1e10;

    fn optics() -> Optics {
        Optics::new(&CameraFile::reference()).unwrap()
    }

    fn drawn(light: &SunLight, window: Window) -> Vec<f64> {
        let mut electrons = vec![0.0; window.area()];
        light.add_to(window, 2.0, &mut electrons);
        electrons
    }

    #[test]
    fn the_image_the_halo_the_bloom_and_the_ghost_hold_the_light_they_should() {
        let optics = optics();
        let direction = optics.unproject([500.0, 430.0]).unwrap();
        let light = SunLight::new(&optics, direction, APERTURE_E_S, 0.5, false).unwrap();
        let whole = Window { x: 0, y: 0, width: 1280, height: 1024 };
        let frame = drawn(&light, whole);
        let at = |x: usize, y: usize| frame[y * 1280 + x] / (2.0 * 0.5 * APERTURE_E_S);
        let sum = frame.iter().sum::<f64>() / (2.0 * 0.5 * APERTURE_E_S);
        // Of the halo r0² / (r0² + R²) lies beyond R: 0.2 % beyond the nearest edge.
        assert!((sum - 1.0 - HALO - BLOOM - GHOST).abs() < 0.003, "{sum}");
        // The image's radius is 14 px, the ghost stands opposite: (779, 593).
        assert!(at(513, 430) > 1e-3 && at(500, 445) < 1e-4);
        assert!(at(779, 593) - at(779, 660) > 0.9 * GHOST / (PI * 3600.0));
        // Bloom above and below, none aside.
        assert!(at(500, 530) > 2.0 * at(600, 430));
    }

    #[test]
    fn a_window_shows_what_the_whole_frame_shows() {
        let optics = optics();
        for direction in [optics.unproject([500.0, 430.0]).unwrap(), [0.3, 0.1, 0.9]] {
            let light = SunLight::new(&optics, unit(direction), APERTURE_E_S, 0.5, false).unwrap();
            let whole = drawn(&light, Window { x: 0, y: 0, width: 1280, height: 1024 });
            let window = Window { x: 480, y: 400, width: 60, height: 50 };
            for (index, value) in drawn(&light, window).iter().enumerate() {
                assert_eq!(*value, whole[(400 + index / 60) * 1280 + 480 + index % 60]);
            }
        }
    }

    #[test]
    fn stray_light_grows_towards_the_sun_and_ends_at_the_baffle() {
        let mut camera = CameraFile::reference();
        for mirrored in [false, true] {
            camera.mirrored = mirrored;
            let optics = Optics::new(&camera).unwrap();
            let sun = |deg: f64| {
                let (s, c) = libm::sincos(deg.to_radians());
                SunLight::new(&optics, [s, 0.0, c], APERTURE_E_S, 0.5, false)
            };
            // The field ends at 12.04 deg.
            let light = sun(13.0).unwrap();
            let row = drawn(&light, Window { x: 0, y: 512, width: 1280, height: 1 });
            let (near, far) = if mirrored { (row[0], row[1279]) } else { (row[1279], row[0]) };
            // 1 and 25 deg from the Sun: e^-0.25 and e^-6.2 of 3000 e-/s, over 2 s.
            assert!(
                (near / 6000.0 - 0.78).abs() < 0.05 && (far / 6000.0 - 0.0019).abs() < 5e-4,
                "{near} {far}"
            );
            assert!(sun(44.0).is_some() && sun(46.0).is_none() && sun(170.0).is_none());
            let (s, c) = libm::sincos(0.4);
            assert_eq!(SunLight::new(&optics, [s, 0.0, c], APERTURE_E_S, 1e-5, true), None);
        }
    }
}
