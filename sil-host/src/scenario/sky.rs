//! The `[sky]` of a scenario: what shines beside stars and Earth. Every key may be left out. Planets, Moon
//! and satellites are drawn as from the Earth: about another body there are none.
//!
//! | key | says | range | default |
//! |---|---|---|---|
//! | `planets` | whether Mercury to Saturn are seen | | true |
//! | `moon` | whether the Moon is seen, in either path | | true |
//! | `sun_light` | whether the Sun has image, halo, bloom, ghost and stray light; in the field it veils the detector all the same | | true |
//! | `satellites_an_hour` | other satellites that cross the field, on average | 0 to 3600 | 10 |

use super::body::{of_the_earth_alone, switched_on};
use super::text::Text;
use crate::error::HostError;
use crate::world::sky::bodies::BodiesModel;
use crate::world::sky::satellites::CROSSINGS_AN_HOUR_MAX;
use fsw_core::orbit::body::CentralBody;
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSky {
    planets: Option<Spanned<bool>>,
    moon: Option<Spanned<bool>>,
    sun_light: Option<bool>,
    satellites_an_hour: Option<Spanned<f64>>,
}

/// Reads the `[sky]`.
pub(super) fn read(text: &Text<'_>, raw: &RawSky, body: CentralBody) -> Result<BodiesModel, HostError> {
    let satellites = raw.satellites_an_hour.as_ref().filter(|value| *value.get_ref() > 0.0);
    let asked = [
        ("sky.planets", switched_on(&raw.planets)),
        ("sky.moon", switched_on(&raw.moon)),
        ("sky.satellites_an_hour", satellites.map(|value| value.span().start)),
    ];
    of_the_earth_alone(text, body, &asked)?;
    let all = match body {
        CentralBody::Earth => BodiesModel::ALL,
        _ => BodiesModel { sun_light: true, ..BodiesModel::NONE },
    };
    let (key, value) = ("sky.satellites_an_hour", raw.satellites_an_hour.as_ref());
    Ok(BodiesModel {
        planets: raw.planets.as_ref().map_or(all.planets, |planets| *planets.get_ref()),
        moon: raw.moon.as_ref().map_or(all.moon, |moon| *moon.get_ref()),
        sun_light: raw.sun_light.unwrap_or(all.sun_light),
        satellites_an_hour: text.number(key, value, all.satellites_an_hour, (0.0, CROSSINGS_AN_HOUR_MAX))?,
    })
}
