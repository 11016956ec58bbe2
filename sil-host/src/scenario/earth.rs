//! The `[earth]` of a scenario: how the central body is drawn. Every key may be left out; `season` and
//! `airglow` are of the Earth alone, and the other defaults those of `EarthModel::of` the body.
//!
//! | key | says | range | default |
//! |---|---|---|---|
//! | `cloud_contrast` | contrast of clouds, land and sea; 0: the mean albedo everywhere | 0 to 1 | 1 |
//! | `surface` | law by which surfaces are bright, see `world::earth::photometry` | `mixed`, `minnaert` | `mixed` |
//! | `horizon` | what makes the limb stand higher here than there, see `world::earth::horizon` | `noise`, `temperature`, `cloud_tops` | `noise` |
//! | `height_variation_km` | standard deviation of the `noise` over thousands of km, half of it over hundreds; 0: nothing that a seed makes | 0 to 10 | 1.5 |
//! | `season` | whether the limb stands higher over the tropics and the summer half | | true |
//! | `airglow` | whether the night sky's layer at 90 km shines | | true |

use super::body::{of_the_earth_alone, switched_on};
use super::text::Text;
use crate::error::HostError;
use crate::world::earth::EarthModel;
use crate::world::earth::horizon::Family;
use crate::world::earth::photometry::Photometry;
use fsw_core::orbit::body::CentralBody;
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawEarth {
    cloud_contrast: Option<Spanned<f64>>,
    surface: Option<Spanned<String>>,
    horizon: Option<Spanned<String>>,
    height_variation_km: Option<Spanned<f64>>,
    season: Option<Spanned<bool>>,
    airglow: Option<Spanned<bool>>,
}

/// Reads the `[earth]`.
pub(super) fn read(text: &Text<'_>, raw: &RawEarth, body: CentralBody) -> Result<EarthModel, HostError> {
    let default = EarthModel::of(body);
    of_the_earth_alone(
        text,
        body,
        &[("earth.season", switched_on(&raw.season)), ("earth.airglow", switched_on(&raw.airglow))],
    )?;
    let number = |key: &str, value: &Option<Spanned<f64>>, default, range| {
        text.number(&format!("earth.{key}"), value.as_ref(), default, range)
    };
    let named = |key: &str, name: &Spanned<String>, known: &[&str]| {
        let to_do = format!("give one of {}", known.join(", "));
        text.fault(name.span().start, &format!("earth.{key}"), "unknown", &to_do)
    };
    let surface = raw.surface.as_ref().map_or(Ok(default.surface), |name| {
        let known = Photometry::ALL.map(Photometry::name);
        Photometry::named(name.get_ref()).ok_or_else(|| named("surface", name, &known))
    })?;
    let horizon = raw.horizon.as_ref().map_or(Ok(default.horizon), |name| {
        let known = Family::ALL.map(Family::name);
        Family::named(name.get_ref()).ok_or_else(|| named("horizon", name, &known))
    })?;
    Ok(EarthModel {
        surface,
        horizon,
        cloud_contrast: number("cloud_contrast", &raw.cloud_contrast, default.cloud_contrast, (0.0, 1.0))?,
        height_variation_km: number(
            "height_variation_km",
            &raw.height_variation_km,
            default.height_variation_km,
            (0.0, 10.0),
        )?,
        season: raw.season.as_ref().map_or(default.season, |season| *season.get_ref()),
        airglow: raw.airglow.as_ref().map_or(default.airglow, |airglow| *airglow.get_ref()),
        ..default
    })
}

#[cfg(test)]
mod tests {
    use crate::scenario::{EMBEDDED, Scenario};
    use crate::world::earth::horizon::Family;
    use crate::world::earth::photometry::Photometry;
    use std::path::Path;

    fn parse(table: &str) -> Result<Scenario, String> {
        let (_, text) = EMBEDDED[0];
        Scenario::parse(Path::new("x.toml"), &format!("{text}\n[earth]\n{table}\n"))
            .map_err(|e| e.to_string())
    }

    #[test]
    fn every_key_reaches_the_model_and_faults_name_line_and_key() {
        let all = "cloud_contrast = 0.5\nheight_variation_km = 0.0\nseason = false\nairglow = false\n\
            horizon = \"cloud_tops\"\nsurface = \"minnaert\"";
        let earth = parse(all).unwrap().earth;
        assert!(earth.cloud_contrast == 0.5 && earth.height_variation_km == 0.0);
        assert!(!earth.season && !earth.airglow && earth.horizon == Family::CloudTops);
        assert_eq!(earth.surface, Photometry::Minnaert);
        assert!(parse("horizon = \"flat\"").unwrap_err().contains("earth.horizon"));
        let fault = parse("height_variation_km = -1.0").unwrap_err();
        assert!(fault.contains("earth.height_variation_km") && fault.contains("x.toml:"), "{fault}");
        assert!(parse("moon = true").is_err());
    }
}
