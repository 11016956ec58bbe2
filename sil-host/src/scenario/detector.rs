//! The `[detector]` and the `[disturbances]` of a scenario.
//!
//! | key of `[detector]` | default | says |
//! |---|---|---|
//! | `temperature_c` | 20 | sets the dark current, which doubles every 7 K |
//! | `dark_e_s` | 800 | dark current of a pixel at 20 °C, e-/s |
//! | `read_noise_e` | 20 | standard deviation of the readout, e- |
//! | `pixel` | `"l-shape"` | sensitive part of a pixel: an L of 70 %, or `"full"` |
//! | `prnu` | 0.01 | standard deviation of the pixels' gains |
//! | `dsnu` | 0.1 | standard deviation of their dark currents, share of the mean |
//! | `column_offset_e` | 4 | standard deviation of the columns' offsets, e- |
//! | `row_noise_e` | 3 | standard deviation of the rows' offsets, new in each second, e- |
//!
//! | key of `[disturbances]` | default | says |
//! |---|---|---|
//! | `false_stars` | 0 | in every exposure |
//! | `hot_pixels` | 0 | pixels with 4e3 to 1e5 e-/s |
//! | `dead_low`, `dead_high` | 10, 10 | pixels that always read 0, or full scale |
//! | `surveyed_percent` | 0 | of the hot and dead pixels so many stand in the table by which they are corrected on board |
//! | `protons` | `"orbit"` | hits by the place in the orbit; `"fixed"`: `proton_hits` in every exposure |
//! | `proton_hits` | 0 | makes `protons` fixed |
//!
//! 0 switches off whatever has a size or number.

use super::text::Text;
use crate::error::HostError;
use crate::world::detector::disturbances::Disturbances;
use crate::world::detector::fixed_pattern::PatternModel;
use crate::world::detector::pixel::PixelResponse;
use crate::world::detector::protons::Protons;
use crate::world::sky::stars::DetectorModel;
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawDetector {
    temperature_c: Option<Spanned<f64>>,
    dark_e_s: Option<Spanned<f64>>,
    read_noise_e: Option<Spanned<f64>>,
    pixel: Option<RawPixel>,
    prnu: Option<Spanned<f64>>,
    dsnu: Option<Spanned<f64>>,
    column_offset_e: Option<Spanned<f64>>,
    row_noise_e: Option<Spanned<f64>>,
}

#[derive(Deserialize, Clone, Copy)]
enum RawPixel {
    #[serde(rename = "full")]
    Full,
    #[serde(rename = "l-shape")]
    LShape,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawDisturbances {
    false_stars: Option<Spanned<i64>>,
    hot_pixels: Option<Spanned<i64>>,
    dead_low: Option<Spanned<i64>>,
    dead_high: Option<Spanned<i64>>,
    surveyed_percent: Option<Spanned<f64>>,
    protons: Option<RawProtons>,
    proton_hits: Option<Spanned<i64>>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
enum RawProtons {
    Fixed,
    Orbit,
}

/// Reads the `[detector]`.
pub(super) fn read(text: &Text<'_>, raw: &RawDetector) -> Result<DetectorModel, HostError> {
    let number = |key: &str, value: &Option<Spanned<f64>>, default, range| {
        text.number(&format!("detector.{key}"), value.as_ref(), default, range)
    };
    let default = DetectorModel::reference();
    let PatternModel { prnu, dsnu, column_offset_e, row_noise_e } = default.pattern;
    Ok(DetectorModel {
        temperature_c: number("temperature_c", &raw.temperature_c, default.temperature_c, (-100.0, 100.0))?,
        dark_e_s: number("dark_e_s", &raw.dark_e_s, default.dark_e_s, (0.0, 1e6))?,
        read_noise_e: number("read_noise_e", &raw.read_noise_e, default.read_noise_e, (0.0, 1e4))?,
        response: raw.pixel.map_or(default.response, |pixel| match pixel {
            RawPixel::Full => PixelResponse::Full,
            RawPixel::LShape => PixelResponse::LShape,
        }),
        pattern: PatternModel {
            prnu: number("prnu", &raw.prnu, prnu, (0.0, 0.3))?,
            dsnu: number("dsnu", &raw.dsnu, dsnu, (0.0, 0.3))?,
            column_offset_e: number("column_offset_e", &raw.column_offset_e, column_offset_e, (0.0, 1e4))?,
            row_noise_e: number("row_noise_e", &raw.row_noise_e, row_noise_e, (0.0, 1e4))?,
        },
        ..default
    })
}

/// Reads the `[disturbances]`.
pub(super) fn disturbances(text: &Text<'_>, raw: &RawDisturbances) -> Result<Disturbances, HostError> {
    let count = |key: &str, value: &Option<Spanned<i64>>, default, most| {
        let key = format!("disturbances.{key}");
        text.whole(&key, value.as_ref(), default, (0, most)).map(|count| count as u32)
    };
    let hits = count("proton_hits", &raw.proton_hits, 0, 5_000)?;
    let protons = match (raw.protons, &raw.proton_hits) {
        (Some(RawProtons::Orbit), Some(value)) => {
            let (key, to_do) = ("disturbances.proton_hits", "remove it or set protons = \"fixed\"");
            return Err(text.fault(value.span().start, key, "the orbit says how many there are", to_do));
        }
        (Some(RawProtons::Fixed), _) | (None, Some(_)) => Protons::Fixed(hits),
        (Some(RawProtons::Orbit) | None, None) => Protons::Orbit,
    };
    Ok(Disturbances {
        false_stars: count("false_stars", &raw.false_stars, 0, 200)?,
        hot_pixels: count("hot_pixels", &raw.hot_pixels, 0, 20_000)?,
        dead_low: count("dead_low", &raw.dead_low, 10, 10_000)?,
        dead_high: count("dead_high", &raw.dead_high, 10, 10_000)?,
        protons,
        surveyed: 0.01
            * text.number(
                "disturbances.surveyed_percent",
                raw.surveyed_percent.as_ref(),
                0.0,
                (0.0, 100.0),
            )?,
        ..Disturbances::default()
    })
}
