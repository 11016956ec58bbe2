//! What the optics do to light beside the projection: PSF, colours, vignetting, shutter, filters.
//!
//! Focus of the reference. The thesis wants images of about 3 x 5 px (§3.1.2, tab. 3.5) and a detector 0.1 mm
//! behind the focus (fig. 3.10). At f/2.25 the two exclude each other: 0.1 mm alone makes a disc of 44 µm,
//! 5.9 px. The reference takes the size: 0.06 mm behind the focus of least mean square radius, 85 % of the
//! light of a star lies in 3 x 5 px and the image is lopsided off the axis; at 0.1 mm it would be 52 %.

use super::shutter::Shutter;
use crate::formats::camera_file::CORNER_LOSS;
use crate::world::lens::optics::Optics;
use crate::world::lens::psf::{LensModel, Psf, PsfModel};
use crate::world::lens::vignetting::VignettingModel;
use std::sync::{Arc, Mutex, PoisonError};

/// How many PSF are kept.
const KEPT: usize = 4;

static LAST: Mutex<Vec<(ImagingModel, Optics, Arc<Psf>)>> = Mutex::new(Vec::new());

/// The optics of a scene beside the camera's projection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImagingModel {
    /// Images of stars.
    pub psf: PsfModel,
    /// Side of a pixel, µm: of the lens's image, and of protons.
    pub pixel_pitch_um: f64,
    /// Whether stars have colours; else all are of B-V = 0.
    pub star_colours: bool,
    /// Loss towards the edge.
    pub vignetting: VignettingModel,
    /// When rows collect light.
    pub shutter: Shutter,
    /// Share of the star path's light that filter or shutter let through.
    pub star_path_transmission: f64,
    /// The same of the Earth path, beside the grey filter.
    pub earth_path_transmission: f64,
}

impl ImagingModel {
    /// Longest row time, s: the frame is read within its second.
    pub const ROW_TIME_S: (f64, f64) = (0.0, 5e-4);

    /// Gaussian stars of 0.9 px without colours, no vignetting, a global shutter.
    pub const PLAIN: Self = Self {
        psf: PsfModel::Gaussian { sigma_px: 0.9 },
        pixel_pitch_um: 7.5,
        star_colours: false,
        vignetting: VignettingModel::NONE,
        shutter: Shutter::Global,
        star_path_transmission: 1.0,
        earth_path_transmission: 1.0,
    };

    /// The reference camera: stars through its lens, in their colours, vignetting with 15 % in the corner by
    /// the mounts, a global shutter.
    pub const REFERENCE: Self = Self {
        psf: PsfModel::Lens(LensModel { aperture_mm: 10.0, defocus_mm: -0.06 }),
        star_colours: true,
        vignetting: VignettingModel { cosine: true, corner_loss: CORNER_LOSS },
        ..Self::PLAIN
    };

    /// Whether all values make physical sense.
    pub fn is_sound(&self) -> bool {
        let psf = match self.psf {
            PsfModel::Gaussian { sigma_px } => (Psf::SIGMA_PX.0..=Psf::SIGMA_PX.1).contains(&sigma_px),
            PsfModel::Lens(lens) => {
                (0.1..=1000.0).contains(&lens.aperture_mm) && (-5.0..=5.0).contains(&lens.defocus_mm)
            }
        };
        let shutter = match self.shutter {
            Shutter::Global => true,
            Shutter::Rolling { row_time_s } => {
                (Self::ROW_TIME_S.0..=Self::ROW_TIME_S.1).contains(&row_time_s)
            }
        };
        let shares = [self.vignetting.corner_loss, self.star_path_transmission, self.earth_path_transmission];
        psf && shutter
            && (0.1..=1000.0).contains(&self.pixel_pitch_um)
            && shares.iter().all(|share| (0.0..=1.0).contains(share))
    }

    /// The PSF of a camera; `None` where the lens cannot be made for it. The last few are kept: the runs of a
    /// campaign ask for the same.
    pub fn psf(&self, optics: &Optics) -> Option<Arc<Psf>> {
        let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((.., psf)) = last.iter().find(|(model, seen, _)| model == self && seen == optics) {
            return Some(Arc::clone(psf));
        }
        let psf = Arc::new(match &self.psf {
            PsfModel::Gaussian { sigma_px } => Psf::gaussian(*sigma_px),
            PsfModel::Lens(lens) => Psf::of_lens(lens, &self.vignetting, self.pixel_pitch_um, optics)?,
        });
        if last.len() == KEPT {
            last.remove(0);
        }
        last.push((*self, *optics, Arc::clone(&psf)));
        Some(psf)
    }
}
