//! The objective: rays through four simple lenses.
//!
//! In: focal length, aperture and place of the detector; then a field angle, a wavelength, a point of the
//! pupil. Out: where the ray meets the detector, mm from the axis, x away from it in the plane of the field.
//!
//! The thesis uses "simple four-lens consumer optics" (§3.1.2, fig. 3.6) and prints no prescription, and the
//! published four-lens ones at hand (Laikin, Lens Design, 4th ed., pp. 63 and 75) either do not open to
//! f/2.25 or cover half the field. This one is therefore the world's own: an Ernostar - a triplet whose front
//! lens is split - with three lenses of N-LAK12 and one of SF4, its radii and air spaces fitted by least
//! squares to what the thesis shows: spherical aberration left in on purpose, so that the image is a ring
//! before the focus and a core with a halo behind it (figs. 3.4 and 3.9), lopsided off the axis. It is scaled
//! to the focal length asked for.
//!
//! Refraction is Snell's law in vector form at spheres (Welford, Aberrations of Optical Systems, ch. 4);
//! dispersion after Cauchy, `n = A + B / wavelength²` from the catalogue's `n_d` and `V_d`, right to 0.002 in
//! the band. Left out: coatings, ghosts, tolerances of manufacture. Vignetting by the mounts narrows the
//! pupil, see [`vignetting`].
//!
//! | module | takes | gives |
//! |---|---|---|
//! | [`optics`] | camera, direction in the sensor frame | pixel |
//! | [`psf`] | lens, place on the detector | the image of a star as a few Gaussians |
//! | [`spots`] | places and charges | mean electrons of a window |
//! | [`streaks`] | ways and charges | the same, of points that move |
//! | [`vignetting`] | place on the detector | what is left of the light |

pub mod optics;
pub mod psf;
pub mod spots;
pub mod streaks;
pub mod vignetting;

use super::vector::{plus, times};
use crate::world::attitude::{Vector, dot};

/// Wavelengths of the Fraunhofer lines F, d, C, µm.
const FRAUNHOFER_UM: [f64; 3] = [0.486_132_7, 0.587_561_8, 0.656_272_5];
/// Wavelength at which focal length and stop are taken, nm: the middle of the band.
const DESIGN_NM: f64 = 700.0;
/// A ray is right when it meets its point of the stop so nearly, in shares of the stop's radius.
const AIM: f64 = 1e-5;
/// Most attempts at aiming.
const AIM_ROUNDS_MAX: u32 = 25;
/// How far before the first vertex rays start, focal lengths.
const START: f64 = 0.5;

/// A glass: `n_d` and Abbe number `V_d`.
type Glass = (f64, f64);
const N_LAK12: Glass = (1.677_90, 55.20);
const SF4: Glass = (1.755_20, 27.58);

/// What a ray meets.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Surface {
    /// A sphere of this curvature, 1/mm, before a medium.
    Sphere { curvature: f64, behind: Option<Glass> },
    /// The aperture stop.
    Stop,
}

/// Radius (0: the stop), way to the next surface, glass between; mm at a focal length near 22.5 mm.
const PRESCRIPTION: [(f64, f64, Option<Glass>); 9] = [
    (12.95, 2.98, Some(N_LAK12)),
    (-635.0, 0.20, None),
    (9.38, 3.18, Some(N_LAK12)),
    (9.36, 0.40, None),
    (-39.96, 1.29, Some(SF4)),
    (7.815, 0.99, None),
    (0.0, 2.29, None),
    (21.43, 2.98, Some(N_LAK12)),
    (-14.76, 0.0, None),
];

/// Refractive index of what is `behind` a surface.
fn index(glass: Option<Glass>, wavelength_nm: f64) -> f64 {
    let Some((n_d, abbe)) = glass else { return 1.0 };
    let [f, d, c] = FRAUNHOFER_UM.map(|um| (um * um).recip());
    let um = 1e-3 * wavelength_nm;
    n_d + (n_d - 1.0) / abbe * ((um * um).recip() - d) / (f - c)
}

/// An objective before its detector; lengths in mm.
#[derive(Debug, Clone, PartialEq)]
pub struct Lens {
    surfaces: Vec<(Surface, f64)>,
    focal_length_mm: f64,
    stop_radius_mm: f64,
    /// Stop's radius over the entrance pupil's.
    pupil_scale: f64,
    detector_mm: f64,
}

impl Lens {
    /// The prescription scaled to `focal_length_mm`, its pupil `aperture_mm` wide, the detector
    /// `behind_focus_mm` behind the place where the image of a white star on the axis has the least mean
    /// square radius. `None` where that is no lens: rays of the rim miss a surface.
    pub fn new(focal_length_mm: f64, aperture_mm: f64, behind_focus_mm: f64) -> Option<Self> {
        let whole = |(radius, way, behind): &(f64, f64, Option<Glass>), scale: f64| {
            let surface = if *radius == 0.0 {
                Surface::Stop
            } else {
                Surface::Sphere { curvature: (radius * scale).recip(), behind: *behind }
            };
            (surface, way * scale)
        };
        let drawn: Vec<_> = PRESCRIPTION.iter().map(|row| whole(row, 1.0)).collect();
        let scale = focal_length_mm / paraxial(&drawn).focal_length_mm;
        let surfaces: Vec<_> = PRESCRIPTION.iter().map(|row| whole(row, scale)).collect();
        let Paraxial { back_focus_mm, stop_height, .. } = paraxial(&surfaces);
        let mut lens = Self {
            surfaces,
            focal_length_mm,
            stop_radius_mm: 0.5 * aperture_mm * stop_height,
            pupil_scale: stop_height,
            detector_mm: back_focus_mm,
        };
        lens.detector_mm += lens.to_focus_mm()? + behind_focus_mm;
        Some(lens)
    }

    /// From the present plane to that of the least mean square radius on the axis, over pupil and band.
    fn to_focus_mm(&self) -> Option<f64> {
        let (mut across, mut slopes) = (0.0, 0.0);
        for wavelength_nm in [550.0, 700.0, 850.0] {
            // Rings of equal area.
            for ring in 0..20 {
                let (place, direction) =
                    self.ray(0.0, wavelength_nm, [((f64::from(ring) + 0.5) / 20.0).sqrt(), 0.0])?;
                let slope = direction[0] / direction[2];
                across += place[0] * slope;
                slopes += slope * slope;
            }
        }
        Some(-across / slopes)
    }

    /// Where the ray through `pupil` (the stop's radius is 1) of a star `field_rad` off the axis meets the
    /// detector, mm; `None` where it misses a surface.
    pub fn landing(&self, field_rad: f64, wavelength_nm: f64, pupil: [f64; 2]) -> Option<[f64; 2]> {
        self.ray(field_rad, wavelength_nm, pupil).map(|([x, y, _], _)| [x, y])
    }

    /// The same with the direction: the start is moved until the ray meets the stop at `pupil`.
    fn ray(&self, field_rad: f64, wavelength_nm: f64, pupil: [f64; 2]) -> Option<(Vector, Vector)> {
        let (sin, cos) = libm::sincos(field_rad);
        let direction = [sin, 0.0, cos];
        let goal = pupil.map(|p| p * self.stop_radius_mm);
        // In the plane through the first vertex.
        let mut entry = [0.0, goal[1] / self.pupil_scale];
        for _ in 0..AIM_ROUNDS_MAX {
            let start = plus([entry[0], entry[1], 0.0], -START * self.focal_length_mm, direction);
            let traced = self.trace(start, direction, wavelength_nm)?;
            let miss = [0, 1].map(|k| goal[k] - traced.stop[k]);
            if miss[0].abs().max(miss[1].abs()) <= AIM * self.stop_radius_mm {
                return Some((traced.place, traced.direction));
            }
            entry = [0, 1].map(|k| entry[k] + miss[k] / self.pupil_scale);
        }
        None
    }

    fn trace(&self, start: Vector, direction: Vector, wavelength_nm: f64) -> Option<Traced> {
        let (mut o, mut d) = (start, direction);
        let (mut before, mut stop) = (1.0, [0.0; 2]);
        for (surface, way) in &self.surfaces {
            o = plus(o, -o[2] / d[2], d);
            match *surface {
                Surface::Stop => stop = [o[0], o[1]],
                Surface::Sphere { curvature: c, behind } => {
                    // From the vertex plane on to the sphere.
                    let f = c * dot(o, o);
                    let g = d[2] - c * dot(o, d);
                    let root = g * g - c * f;
                    if root <= 0.0 {
                        return None;
                    }
                    o = plus(o, f / (g + root.sqrt()), d);
                    let normal = [-c * o[0], -c * o[1], 1.0 - c * o[2]];
                    let after = index(behind, wavelength_nm);
                    let (ratio, cos) = (before / after, dot(d, normal));
                    let square = 1.0 - ratio * ratio * (1.0 - cos * cos);
                    if square <= 0.0 {
                        return None;
                    }
                    d = plus(times(ratio, d), square.sqrt() - ratio * cos, normal);
                    before = after;
                }
            }
            o[2] -= way;
        }
        let place = plus(o, (self.detector_mm - o[2]) / d[2], d);
        Some(Traced { place, direction: d, stop })
    }
}

struct Traced {
    place: Vector,
    direction: Vector,
    stop: [f64; 2],
}

/// What thin rays see at the design wavelength.
struct Paraxial {
    focal_length_mm: f64,
    back_focus_mm: f64,
    /// Height at the stop of a ray that enters at height 1.
    stop_height: f64,
}

fn paraxial(surfaces: &[(Surface, f64)]) -> Paraxial {
    let (mut height, mut slope, mut before, mut stop_height) = (1.0, 0.0, 1.0, 1.0);
    let mut last = height;
    for (surface, way) in surfaces {
        match *surface {
            Surface::Stop => stop_height = height,
            Surface::Sphere { curvature, behind } => {
                let after = index(behind, DESIGN_NM);
                slope = (before * slope - height * curvature * (after - before)) / after;
                before = after;
            }
        }
        last = height;
        height += slope * way;
    }
    Paraxial { focal_length_mm: -slope.recip(), back_focus_mm: -last / slope, stop_height }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glass_has_the_index_of_the_catalogue_at_its_lines() {
        let [f, d, c] = FRAUNHOFER_UM.map(|um| index(Some(SF4), 1e3 * um));
        assert!((d - 1.755_20).abs() < 1e-12 && ((d - 1.0) / (f - c) - 27.58).abs() < 1e-9);
        // The catalogue's own formula, with Schott's six constants of SF4.
        let sellmeier = |nm: f64| {
            let square = 1e-6 * nm * nm;
            let terms = [
                (1.619_578_26, 0.012_550_210_4),
                (0.339_493_189, 0.054_455_982_2),
                (1.025_669_31, 117.652_222),
            ];
            (1.0 + terms.iter().map(|(b, c)| b * square / (square - c)).sum::<f64>()).sqrt()
        };
        for nm in [500.0, 567.0, 700.0, 833.0, 900.0] {
            assert!((index(Some(SF4), nm) - sellmeier(nm)).abs() < 2e-3, "{nm}");
        }
    }

    #[test]
    fn thin_rays_meet_at_the_focal_length() {
        let lens = Lens::new(22.5, 10.0, 0.0).unwrap();
        // A star a milliradian off the axis, through the middle of the stop.
        let [x, y] = lens.landing(1e-3, DESIGN_NM, [0.0, 0.0]).unwrap();
        assert!((x / 0.0225 - 1.0).abs() < 5e-3 && y.abs() < 1e-12, "{x} {y}");
    }

    #[test]
    fn rays_are_mirrored_with_their_points_of_the_pupil() {
        let lens = Lens::new(22.5, 10.0, 0.1).unwrap();
        for (field, u, v) in [(0.1, 0.3, 0.5), (0.26, -0.6, 0.7)] {
            let a = lens.landing(field, 600.0, [u, v]).unwrap();
            let b = lens.landing(field, 600.0, [u, -v]).unwrap();
            let c = lens.landing(-field, 600.0, [-u, v]).unwrap();
            assert!((a[0] - b[0]).abs() < 1e-9 && (a[1] + b[1]).abs() < 1e-9);
            assert!((a[0] + c[0]).abs() < 1e-9 && (a[1] - c[1]).abs() < 1e-9);
        }
    }

    #[test]
    fn spherical_aberration_is_undercorrected_as_in_the_thesis() {
        // Rim rays cross the axis before the middle ones: behind the focus they have crossed over.
        let lens = Lens::new(22.5, 10.0, 0.1).unwrap();
        let [rim, _] = lens.landing(0.0, 700.0, [1.0, 0.0]).unwrap();
        let [middle, _] = lens.landing(0.0, 700.0, [0.4, 0.0]).unwrap();
        assert!(rim < -0.015 && middle.abs() < 0.005, "{rim} {middle}");
    }

    #[test]
    fn what_cannot_be_a_lens_is_refused() {
        assert!(Lens::new(2.25, 10.0, 0.0).is_none());
    }
}
