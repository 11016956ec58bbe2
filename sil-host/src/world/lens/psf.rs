//! The image of a star: a handful of narrow Gaussians that change over the field.
//!
//! In: a lens ([`Lens`]), a pixel pitch. Out: for a place on the detector and the electrons in each part of
//! the band, up to [`BLOBS_MAX`] Gaussians ([`Blob`]).
//!
//! For each of `NODES` field radii and the middle of each part of the band, rays through an even grid of the
//! pupil are traced; the pupil is narrowed in the plane of the field by what the mounts take. The pupil is
//! cut into [`BLOBS_MAX`] zones (a disc and three rings of sectors). A zone becomes a Gaussian at the mean of
//! its rays in the star's light, with their mean variance plus that of diffraction, `(0.42 wavelength ·
//! f-number)²`, and of charge that wanders between pixels, `DIFFUSION_PX`. First and second moments of the
//! rays are kept, the second up to their direction within a zone.
//!
//! The centre of gravity of a star of B-V = 0 is by definition where the distortion model puts the star: it
//! is taken off at every radius. Stars of other colours are displaced by what the lens makes of their
//! wavelengths (lateral colour). Between radii places and variances are interpolated. Left out: the shift of
//! the pattern by distortion (radii are those of the undistorted image).

use super::optics::Optics;
use super::vignetting::VignettingModel;
use crate::world::lens::Lens;
use crate::world::sky::colour::{self, BAND_NM, BANDS};

/// Most Gaussians a star is drawn of: the zones of the pupil.
pub const BLOBS_MAX: usize = 24;
/// Field radii traced.
const NODES: usize = 17;
/// Points along half the pupil's width.
const GRID: u32 = 14;
/// Squared outer radius and number of sectors of each ring of the pupil.
const RINGS: [(f64, usize); 4] = [(0.17, 1), (0.45, 6), (0.74, 8), (f64::INFINITY, 9)];
/// Charge diffusion, px: 2 µm of 7.5, usual for a CMOS pixel.
const DIFFUSION_PX: f64 = 0.25;
/// How far a Gaussian is drawn, in widths: 1e-5 of the light is cut off.
const REACH_SIGMAS: f64 = 4.6;

/// The lens of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensModel {
    /// Diameter of the entrance pupil, mm.
    pub aperture_mm: f64,
    /// Place of the detector against the best focus, mm; negative behind it, as in the thesis.
    pub defocus_mm: f64,
}

/// How a star is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PsfModel {
    /// A Gaussian, the same everywhere.
    Gaussian {
        /// Width, px.
        sigma_px: f64,
    },
    /// Traced through the lens.
    Lens(LensModel),
}

/// A Gaussian of light, relative to the star's place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blob {
    /// Column, px.
    pub x_px: f64,
    /// Row, px.
    pub y_px: f64,
    /// Width, px.
    pub sigma_px: f64,
    /// Electrons.
    pub electrons: f64,
}

/// Part of an image at a field radius: for each part of the band the mean place of its rays, and the mean of
/// half their squared distance from the star's place with diffraction and diffusion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Zone {
    radial_px: [f64; BANDS],
    tangential_px: [f64; BANDS],
    square_px2: [f64; BANDS],
}

impl Zone {
    /// Place and variance in light of these `weights`, which sum to 1.
    #[inline]
    fn seen(&self, weights: &[f64; BANDS]) -> (f64, f64, f64) {
        let mean = |values: &[f64; BANDS]| (0..BANDS).map(|band| weights[band] * values[band]).sum::<f64>();
        let (radial, tangential) = (mean(&self.radial_px), mean(&self.tangential_px));
        let variance = mean(&self.square_px2) - 0.5 * (radial * radial + tangential * tangential);
        (radial, tangential, variance)
    }
}

type Node = [Zone; BLOBS_MAX];

/// Point spread function of a camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Psf {
    centre_px: [f64; 2],
    nodes_per_px: f64,
    nodes: Vec<Node>,
    /// Share of a zone in the light.
    shares: [f64; BLOBS_MAX],
    narrowest_px: f64,
    rms_px: f64,
    reach_px: f64,
}

impl Psf {
    /// Range of widths of a Gaussian that can be drawn, px.
    pub const SIGMA_PX: (f64, f64) = (0.1, 6.0);

    /// A Gaussian of `sigma_px`, the same everywhere.
    pub fn gaussian(sigma_px: f64) -> Self {
        let sigma_px = sigma_px.clamp(Self::SIGMA_PX.0, Self::SIGMA_PX.1);
        Self {
            centre_px: [0.0; 2],
            nodes_per_px: 0.0,
            nodes: Vec::new(),
            shares: [0.0; BLOBS_MAX],
            narrowest_px: sigma_px,
            rms_px: sigma_px,
            reach_px: REACH_SIGMAS * sigma_px,
        }
    }

    /// That of a lens for the camera of `optics` with pixels of `pixel_pitch_um`; `None` where the lens
    /// cannot be made so, or its image is wider than can be drawn.
    pub fn of_lens(
        model: &LensModel,
        mounts: &VignettingModel,
        pixel_pitch_um: f64,
        optics: &Optics,
    ) -> Option<Self> {
        let pitch_mm = 1e-3 * pixel_pitch_um;
        let (focal_length_px, radius_px) = (optics.focal_length_px(), optics.radius_px());
        let lens = Lens::new(focal_length_px * pitch_mm, model.aperture_mm, -model.defocus_mm)?;
        let f_number = focal_length_px * pitch_mm / model.aperture_mm;
        let nodes = (0..NODES)
            .map(|index| {
                let radius = index as f64 / (NODES - 1) as f64;
                let field_rad = libm::atan(radius * radius_px / focal_length_px);
                node(&lens, field_rad, mounts.mounts(radius), pitch_mm, f_number)
            })
            .collect::<Option<Vec<_>>>()?;
        let counts = rays().fold([0.0; BLOBS_MAX], |mut counts, (u, v)| {
            counts[zone_of(u, v)] += 1.0;
            counts
        });
        let all: f64 = counts.iter().sum();
        let white = weights(&colour::shares(0.0));
        let seen = |node: &Node| node.map(|zone| zone.seen(&white));
        let images: Vec<_> = nodes.iter().map(seen).collect();
        let zones = || {
            images
                .iter()
                .flatten()
                .map(|(radial, tangential, variance)| (libm::hypot(*radial, *tangential), variance.sqrt()))
        };
        let narrowest_px = zones().map(|(_, sigma)| sigma).fold(f64::MAX, f64::min);
        let widest_px = zones().map(|(_, sigma)| sigma).fold(0.0, f64::max);
        // Stars of other colours reach a little farther.
        let reach_px = 0.5 + zones().map(|(way, sigma)| way + REACH_SIGMAS * sigma).fold(0.0, f64::max);
        let square = |image: &[(f64, f64, f64); BLOBS_MAX]| {
            let terms = image.iter().zip(&counts);
            terms
                .map(|((r, t, variance), count)| count / all * (0.5 * (r * r + t * t) + variance))
                .sum::<f64>()
        };
        let rms_px = (images.iter().map(square).sum::<f64>() / NODES as f64).sqrt();
        (reach_px.is_finite() && widest_px <= Self::SIGMA_PX.1).then_some(Self {
            centre_px: optics.centre_px(),
            nodes_per_px: (NODES - 1) as f64 / radius_px,
            nodes,
            shares: counts.map(|count| count / all),
            narrowest_px,
            reach_px,
            rms_px,
        })
    }

    /// Width of the Gaussian that is nearest to it on the mean, px: the root mean square radius an axis.
    pub fn rms_px(&self) -> f64 {
        self.rms_px
    }

    /// Longest way that a star may move between two images of it that shall look like a line, px.
    pub fn step_px(&self) -> f64 {
        if self.nodes.is_empty() { 0.5 * self.narrowest_px } else { 1.5 * self.narrowest_px }
    }

    /// How far from its place a star has light, px.
    pub fn reach_px(&self) -> f64 {
        self.reach_px
    }

    /// How far from its own pixel a Gaussian is drawn, px.
    pub fn blob_reach_px(sigma_px: f64) -> i64 {
        (REACH_SIGMAS * sigma_px) as i64 + 1
    }

    /// Fills `blobs` with the image of a star at (`x_px`, `y_px`) and gives their number.
    #[inline]
    pub fn image(
        &self,
        x_px: f64,
        y_px: f64,
        electrons: &[f64; BANDS],
        blobs: &mut [Blob; BLOBS_MAX],
    ) -> usize {
        if self.nodes.is_empty() {
            let electrons = electrons.iter().sum();
            blobs[0] = Blob { x_px, y_px, sigma_px: self.narrowest_px, electrons };
            return 1;
        }
        let (dx, dy) = (x_px - self.centre_px[0], y_px - self.centre_px[1]);
        let radius = (dx * dx + dy * dy).sqrt();
        let (cos, sin) = if radius > 0.0 { (dx / radius, dy / radius) } else { (1.0, 0.0) };
        let place = (radius * self.nodes_per_px).min((NODES - 1) as f64);
        let index = (place as usize).min(NODES - 2);
        let part = place - index as f64;
        let (inner, outer) = (&self.nodes[index], &self.nodes[index + 1]);
        let total: f64 = electrons.iter().sum();
        let weights = weights(electrons);
        for (zone, blob) in blobs.iter_mut().enumerate() {
            let (a, b) = (inner[zone].seen(&weights), outer[zone].seen(&weights));
            let between = |a: f64, b: f64| a + part * (b - a);
            let (radial, tangential) = (between(a.0, b.0), between(a.1, b.1));
            *blob = Blob {
                x_px: x_px + radial * cos - tangential * sin,
                y_px: y_px + radial * sin + tangential * cos,
                sigma_px: between(a.2, b.2).sqrt(),
                electrons: total * self.shares[zone],
            };
        }
        BLOBS_MAX
    }
}

/// Shares of the parts of the band in a star's light; even for a star without any.
#[inline]
fn weights(electrons: &[f64; BANDS]) -> [f64; BANDS] {
    let total: f64 = electrons.iter().sum();
    if total > 0.0 { electrons.map(|e| e / total) } else { [1.0 / BANDS as f64; BANDS] }
}

/// An even grid of the pupil.
fn rays() -> impl Iterator<Item = (f64, f64)> {
    let axis = |k: u32| (f64::from(k) + 0.5) / f64::from(GRID) - 1.0;
    let square = (0..2 * GRID).flat_map(move |i| (0..2 * GRID).map(move |j| (axis(i), axis(j))));
    square.filter(|(u, v)| u * u + v * v <= 1.0)
}

/// The images of the zones at a field angle, about the centre of gravity of a white star.
fn node(lens: &Lens, field_rad: f64, mounts: f64, pitch_mm: f64, f_number: f64) -> Option<Node> {
    let mut zones = [Zone::default(); BLOBS_MAX];
    let (mut counts, mut centre) = ([0.0; BLOBS_MAX], 0.0);
    let white = weights(&colour::shares(0.0));
    let mut landed = Vec::new();
    for (u, v) in rays() {
        let zone = zone_of(u, v);
        counts[zone] += 1.0;
        for band in 0..BANDS {
            let [x, y] = lens.landing(field_rad, BAND_NM[band], [u * mounts, v])?.map(|mm| mm / pitch_mm);
            centre += white[band] * x;
            landed.push((zone, band, [x, y]));
        }
    }
    centre /= counts.iter().sum::<f64>();
    for (zone, band, [x, y]) in landed {
        let (x, count) = (x - centre, counts[zone]);
        zones[zone].radial_px[band] += x / count;
        zones[zone].tangential_px[band] += y / count;
        zones[zone].square_px2[band] += 0.5 * (x * x + y * y) / count;
    }
    for (band, wavelength_nm) in BAND_NM.iter().enumerate() {
        let diffraction_px = 0.42e-6 * wavelength_nm * f_number / pitch_mm;
        let base = DIFFUSION_PX * DIFFUSION_PX + diffraction_px * diffraction_px;
        zones.iter_mut().for_each(|zone| zone.square_px2[band] += base);
    }
    Some(zones)
}

/// Number of the zone of a point of the pupil. Sectors are mirrored in the plane of the field.
fn zone_of(u: f64, v: f64) -> usize {
    let (r2, mut first) = (u * u + v * v, 0);
    for (outer, sectors) in RINGS {
        if r2 < outer {
            let turn = libm::atan2(v, u) / std::f64::consts::TAU;
            let place = (turn + 1.0) * sectors as f64 + 0.5;
            return first + place as usize % sectors;
        }
        first += sectors;
    }
    first - 1
}

#[cfg(test)]
mod tests;
