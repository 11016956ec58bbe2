//! The `[optics]` of a scenario: what the lens does to stars and light.
//!
//! | key | default | says |
//! |---|---|---|
//! | `psf` | `"lens"` | star images traced through the lens, or `"gaussian"` |
//! | `psf_sigma_px` | 0.9 | width of the Gaussian; only with `"gaussian"` |
//! | `aperture_mm` | 10 | entrance pupil: the flux goes with its area; with `"lens"` also the images |
//! | `defocus_mm` | -0.06 | detector against the best focus, negative behind it; only with `"lens"` |
//! | `pixel_pitch_um` | 7.5 | side of a pixel; with the focal length in pixels it gives the lens its size |
//! | `star_colours` | true | light and image after B-V; else every star is white |
//! | `vignetting` | true | cosine of the field angle and the mounts |
//! | `corner_loss` | 0.15 | share that the mounts take in the corner |
//! | `shutter` | `"global"` | or `"rolling"` |
//! | `row_time_us` | 50 | from a row to the next; only with `"rolling"` |
//! | `mirror_transmission` | 0.09 | of the partial mirror towards the Earth path; the star path has the rest, and the grey filter is chosen so that the Earth is as bright |
//! | `star_path_transmission` | 1 | of a filter or shutter in the star path: 0 is closed |
//! | `earth_path_transmission` | 1 | the same in the Earth path, beside the grey filter |

use super::text::Text;
use crate::error::HostError;
use crate::formats::camera_file::CORNER_LOSS;
use crate::world::detector::imaging::ImagingModel;
use crate::world::detector::shutter::Shutter;
use crate::world::lens::psf::{LensModel, Psf, PsfModel};
use crate::world::lens::vignetting::VignettingModel;
use serde::Deserialize;
use toml::Spanned;

/// Row time where the file says nothing, µs.
const ROW_TIME_US: f64 = 50.0;

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawOptics {
    psf: Option<RawPsf>,
    psf_sigma_px: Option<Spanned<f64>>,
    aperture_mm: Option<Spanned<f64>>,
    defocus_mm: Option<Spanned<f64>>,
    pixel_pitch_um: Option<Spanned<f64>>,
    star_colours: Option<bool>,
    vignetting: Option<bool>,
    corner_loss: Option<Spanned<f64>>,
    shutter: Option<RawShutter>,
    row_time_us: Option<Spanned<f64>>,
    mirror_transmission: Option<Spanned<f64>>,
    star_path_transmission: Option<Spanned<f64>>,
    earth_path_transmission: Option<Spanned<f64>>,
}

#[derive(Deserialize, Default, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
enum RawPsf {
    #[default]
    Lens,
    Gaussian,
}

#[derive(Deserialize, Default, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
enum RawShutter {
    #[default]
    Global,
    Rolling,
}

/// Diameter of the entrance pupil for which the detector's flux is given, mm.
const FLUX_APERTURE_MM: f64 = 10.0;

fn aperture_mm(text: &Text<'_>, raw: &RawOptics) -> Result<f64, HostError> {
    text.number("optics.aperture_mm", raw.aperture_mm.as_ref(), FLUX_APERTURE_MM, (0.1, 1000.0))
}

/// Area of the entrance pupil over that for which the detector's flux is given.
pub(super) fn light(text: &Text<'_>, raw: &RawOptics) -> Result<f64, HostError> {
    let diameters = aperture_mm(text, raw)? / FLUX_APERTURE_MM;
    Ok(diameters * diameters)
}

/// Share that the partial mirror lets through, where it is another than that of the reference instrument.
pub(super) fn mirror(text: &Text<'_>, raw: &RawOptics) -> Result<Option<f64>, HostError> {
    let read = |value| text.number("optics.mirror_transmission", Some(value), 0.0, (0.01, 0.99));
    raw.mirror_transmission.as_ref().map(read).transpose()
}

/// Reads the table.
pub(super) fn read(text: &Text<'_>, raw: &RawOptics) -> Result<ImagingModel, HostError> {
    let number = |key: &str, value: &Option<Spanned<f64>>, default, range| {
        text.number(&format!("optics.{key}"), value.as_ref(), default, range)
    };
    let share = |key: &str, value: &Option<Spanned<f64>>, default| number(key, value, default, (0.0, 1.0));
    let (psf, shutter) = (raw.psf.unwrap_or_default(), raw.shutter.unwrap_or_default());
    let vignetting = raw.vignetting.unwrap_or(true);
    // A key that would say nothing is a mistake.
    let idle = [
        ("psf_sigma_px", &raw.psf_sigma_px, psf == RawPsf::Gaussian, "psf = \"gaussian\""),
        ("defocus_mm", &raw.defocus_mm, psf == RawPsf::Lens, "psf = \"lens\""),
        ("corner_loss", &raw.corner_loss, vignetting, "vignetting = true"),
        ("row_time_us", &raw.row_time_us, shutter == RawShutter::Rolling, "shutter = \"rolling\""),
    ];
    for (key, value, used, by) in idle {
        if let (Some(value), false) = (value, used) {
            let to_do = format!("remove it or set {by}");
            return Err(text.fault(
                value.span().start,
                &format!("optics.{key}"),
                "says nothing here",
                &to_do,
            ));
        }
    }
    let psf = match psf {
        RawPsf::Gaussian => {
            PsfModel::Gaussian { sigma_px: number("psf_sigma_px", &raw.psf_sigma_px, 0.9, Psf::SIGMA_PX)? }
        }
        RawPsf::Lens => PsfModel::Lens(LensModel {
            aperture_mm: aperture_mm(text, raw)?,
            defocus_mm: number("defocus_mm", &raw.defocus_mm, -0.06, (-5.0, 5.0))?,
        }),
    };
    let shutter = match shutter {
        RawShutter::Global => Shutter::Global,
        RawShutter::Rolling => {
            let range = (1e6 * ImagingModel::ROW_TIME_S.0, 1e6 * ImagingModel::ROW_TIME_S.1);
            let row_time_us = number("row_time_us", &raw.row_time_us, ROW_TIME_US, range)?;
            Shutter::Rolling { row_time_s: 1e-6 * row_time_us }
        }
    };
    Ok(ImagingModel {
        psf,
        pixel_pitch_um: number("pixel_pitch_um", &raw.pixel_pitch_um, 7.5, (0.1, 1000.0))?,
        star_colours: raw.star_colours.unwrap_or(true),
        vignetting: if vignetting {
            VignettingModel {
                cosine: true,
                corner_loss: share("corner_loss", &raw.corner_loss, CORNER_LOSS)?,
            }
        } else {
            VignettingModel::NONE
        },
        shutter,
        star_path_transmission: share("star_path_transmission", &raw.star_path_transmission, 1.0)?,
        earth_path_transmission: share("earth_path_transmission", &raw.earth_path_transmission, 1.0)?,
    })
}
