//! The `[sky]` of a scenario: what shines beside stars and Earth. Every key may be left out.
//!
//! | key | says | range | default |
//! |---|---|---|---|
//! | `planets` | whether Mercury to Saturn are seen | | true |
//! | `moon` | whether the Moon is seen, in either path | | true |
//! | `sun_light` | whether the Sun has image, halo, bloom, ghost and stray light; in the field it veils the detector all the same | | true |
//! | `satellites_an_hour` | other satellites that cross the field, on average | 0 to 3600 | 10 |

use super::text::Text;
use crate::error::HostError;
use crate::world::sky::bodies::BodiesModel;
use crate::world::sky::satellites::CROSSINGS_AN_HOUR_MAX;
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSky {
    planets: Option<bool>,
    moon: Option<bool>,
    sun_light: Option<bool>,
    satellites_an_hour: Option<Spanned<f64>>,
}

/// Reads the `[sky]`.
pub(super) fn read(text: &Text<'_>, raw: &RawSky) -> Result<BodiesModel, HostError> {
    let all = BodiesModel::ALL;
    let (key, value) = ("sky.satellites_an_hour", raw.satellites_an_hour.as_ref());
    Ok(BodiesModel {
        planets: raw.planets.unwrap_or(all.planets),
        moon: raw.moon.unwrap_or(all.moon),
        sun_light: raw.sun_light.unwrap_or(all.sun_light),
        satellites_an_hour: text.number(key, value, all.satellites_an_hour, (0.0, CROSSINGS_AN_HOUR_MAX))?,
    })
}
