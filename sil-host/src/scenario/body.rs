//! The `[body]` of a scenario: what the satellite flies about.
//!
//! | key | says | default |
//! |---|---|---|
//! | `name` | `"earth"`, `"moon"` or `"mars"` | `"earth"` |
//!
//! World and flight code read the row of that name in `fsw_core::orbit::body`. What the body has not is
//! refused where a key asks for it ([`Asked`]): drag and a second body, the Earth's orientation, orbit files
//! and elements of the Earth, planets and satellites in its sky, a magnetometer.

use super::text::Text;
use crate::error::HostError;
use fsw_core::orbit::body::CentralBody;
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBody {
    name: Option<Spanned<String>>,
}

/// What a key asks for: its name, and its place in the text where it is given.
pub(super) type Asked = (&'static str, Option<usize>);

/// The body.
pub(super) fn read(text: &Text<'_>, raw: &RawBody) -> Result<CentralBody, HostError> {
    let Some(name) = &raw.name else { return Ok(CentralBody::Earth) };
    let known = CentralBody::ALL.map(CentralBody::name);
    CentralBody::of_name(name.get_ref()).ok_or_else(|| {
        let to_do = format!("give one of {}", known.join(", "));
        text.fault(name.span().start, "body.name", "unknown", &to_do)
    })
}

/// The place of a switch that is on.
pub(super) fn switched_on(switch: &Option<Spanned<bool>>) -> Option<usize> {
    switch.as_ref().filter(|on| *on.get_ref()).map(|on| on.span().start)
}

/// Refuses what only the Earth has.
pub(super) fn of_the_earth_alone(
    text: &Text<'_>,
    body: CentralBody,
    asked: &[Asked],
) -> Result<(), HostError> {
    if body == CentralBody::Earth {
        return Ok(());
    }
    match asked.iter().find_map(|(key, at)| at.map(|at| (key, at))) {
        None => Ok(()),
        Some((key, at)) => {
            let what = format!("there is none of it about the body {:?}", body.name());
            Err(text.fault(at, key, &what, "remove it"))
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::scenario::{EMBEDDED, Scenario};
    use fsw_core::orbit::body::CentralBody;
    use std::path::Path;

    fn parse(orbit: &str, tables: &str) -> Result<Scenario, String> {
        let head = "[scenario]\nname = \"x\"\nstart = \"2026-09-23T18:00:00\"\nduration_s = 60\n";
        let text = format!("{head}[orbit]\n{orbit}\n{tables}\n");
        Scenario::parse(Path::new("x.toml"), &text).map_err(|error| error.to_string())
    }

    #[test]
    fn a_body_reaches_world_and_flight_alike_and_the_earth_is_the_default() {
        for (name, body) in [("moon", CentralBody::Moon), ("mars", CentralBody::Mars)] {
            let scenario = parse("a_km = 5000.0", &format!("[body]\nname = \"{name}\"")).unwrap();
            assert!(scenario.forces.body == body && scenario.earth.body == body && !scenario.forces.drag);
            let parameters = scenario.flight_parameters(None);
            assert_eq!(parameters.orbit.body, body);
            parameters.check().unwrap();
            assert_eq!(parameters.earth.ellipsoid.equatorial_km, body.facts().radius_km as f32);
        }
        let scenario = Scenario::parse(Path::new("x.toml"), EMBEDDED[0].1).unwrap();
        assert_eq!((scenario.forces.body, scenario.earth.body), (CentralBody::Earth, CentralBody::Earth));
    }

    #[test]
    fn what_a_body_has_not_is_refused_with_line_and_key() {
        let mars = "[body]\nname = \"mars\"";
        for (key, tables) in [
            ("body.name", "[body]\nname = \"venus\"".to_owned()),
            ("forces.drag", format!("{mars}\n[forces]\ndrag = true")),
            ("forces.moon", format!("{mars}\n[forces]\nmoon = true")),
            ("forces.gravity_degree", format!("{mars}\n[forces]\ngravity_degree = 13")),
            ("sky.planets", format!("{mars}\n[sky]\nplanets = true")),
            ("sky.moon", format!("{mars}\n[sky]\nmoon = true")),
            ("sky.satellites_an_hour", format!("{mars}\n[sky]\nsatellites_an_hour = 1.0")),
            ("earth.season", format!("{mars}\n[earth]\nseason = true")),
            ("magnetometer", format!("{mars}\n[magnetometer]")),
        ] {
            let fault = parse("a_km = 5000.0", &tables).unwrap_err();
            assert!(fault.contains(key) && fault.contains("x.toml:"), "{key}: {fault}");
        }
        // An orbit that would clear the Moon and not Mars.
        let fault = parse("a_km = 2000.0", mars).unwrap_err();
        assert!(fault.contains("orbit.a_km"), "{fault}");
        assert!(parse("a_km = 2000.0", "[body]\nname = \"moon\"").is_ok());
    }
}
