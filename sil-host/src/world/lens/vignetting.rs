//! Vignetting: what is lost of all light on its way to the edge of the detector.
//!
//! `cos(field angle)` is the foreshortened aperture; the mounts take another `corner_loss (r / R)²`, R being
//! the distance of the farthest corner. (The other three cosines of the well-known fourth power belong to the
//! solid angle of a pixel and concern extended sources only.) The cosine is taken as a polynomial in `(r /
//! f)²`, error below 1e-4 within 20 degrees.

use super::optics::Optics;
use fsw_hal::Window;

/// What dims the image towards its edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VignettingModel {
    /// Whether the aperture is foreshortened.
    pub cosine: bool,
    /// Share that the mounts take in the farthest corner.
    pub corner_loss: f64,
}

impl VignettingModel {
    /// None at all.
    pub const NONE: Self = Self { cosine: false, corner_loss: 0.0 };

    /// Share that the mounts let through at a distance from the centre, in shares of the farthest corner's.
    pub fn mounts(&self, radius: f64) -> f64 {
        1.0 - self.corner_loss * radius * radius
    }
}

/// Vignetting of a camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Vignetting {
    none: bool,
    centre_px: [f64; 2],
    /// Squared distance of each column from the centre, px².
    columns_px2: Vec<f64>,
    /// Coefficients of `1, r², r⁴, r⁶` of the cosine.
    cosine: [f64; 4],
    /// Of `r²` of the mounts.
    mounts: f64,
}

impl Vignetting {
    /// For the camera of `optics`.
    pub fn new(model: &VignettingModel, optics: &Optics) -> Self {
        let per_f2 = optics.focal_length_px().powi(-2);
        let series = [1.0, -0.5, 0.375, -0.3125];
        let cosine = [0, 1, 2, 3].map(|k| series[k as usize] * per_f2.powi(k));
        let [centre_px, size_px] = [optics.centre_px(), optics.size_px()];
        Self {
            columns_px2: (0..size_px[0] as u32).map(|x| square(f64::from(x) - centre_px[0])).collect(),
            none: *model == VignettingModel::NONE,
            centre_px,
            cosine: if model.cosine { cosine } else { [1.0, 0.0, 0.0, 0.0] },
            mounts: model.corner_loss * optics.radius_px().powi(-2),
        }
    }

    /// Share of the light that is left at a pixel.
    #[inline]
    pub fn at(&self, x: f64, y: f64) -> f64 {
        self.at_square(square(x - self.centre_px[0]) + square(y - self.centre_px[1]))
    }

    /// Share of the light that is left at a distance whose square is `r2`, px².
    #[inline]
    fn at_square(&self, r2: f64) -> f64 {
        let [a, b, c, d] = self.cosine;
        (a + r2 * (b + r2 * (c + r2 * d))) * (1.0 - self.mounts * r2)
    }

    /// Dims `light`, the pixels of `window` row by row.
    pub fn dim(&self, window: Window, light: &mut [f64]) {
        if self.none {
            return;
        }
        for (y, line) in (window.y..).zip(light.chunks_exact_mut(usize::from(window.width))) {
            let row_px2 = square(f64::from(y) - self.centre_px[1]);
            for (pixel, column_px2) in line.iter_mut().zip(&self.columns_px2[usize::from(window.x)..]) {
                *pixel *= self.at_square(column_px2 + row_px2);
            }
        }
    }
}

fn square(x: f64) -> f64 {
    x * x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::camera_file::CameraFile;

    #[test]
    fn the_corner_is_dimmed_by_cosine_and_mounts() {
        let optics = Optics::new(&CameraFile::reference()).unwrap();
        let model = VignettingModel { cosine: true, corner_loss: 0.15 };
        let vignetting = Vignetting::new(&model, &optics);
        assert!((vignetting.at(639.5, 511.5) - 1.0).abs() < 1e-12);
        let tan = optics.radius_px() / 3000.0;
        let expected = libm::cos(libm::atan(tan)) * 0.85;
        assert!((vignetting.at(-0.5, -0.5) - expected).abs() < 1e-4);
        assert!((model.mounts(1.0) - 0.85).abs() < 1e-12);
        let mut light = [1.0; 4];
        let window = Window { x: 0, y: 0, width: 2, height: 2 };
        vignetting.dim(window, &mut light);
        assert_eq!(light[1], vignetting.at(1.0, 0.0));
        let mut same = [1.0; 4];
        Vignetting::new(&VignettingModel::NONE, &optics).dim(window, &mut same);
        assert_eq!(same, [1.0; 4]);
    }
}
