//! A second looked at: what the page draws on the frame, the sky map and the globe.
//!
//! In: a second of the log. Out: an object for JSON. Directions are unit vectors, ICRS axes; places on the
//! detector px, x right and y down; places on the ground geocentric latitude and east longitude, degrees.

use super::log::{Logged, Place, Run};
use super::world::World;
use crate::world::attitude::{Vector, apply, dot, matrix};
use crate::world::body;
use crate::world::earth::Ellipsoid;
use crate::world::lens::optics::Optics;
use crate::world::scene::WorldStar;
use crate::world::sky;
use crate::world::time::civil_time;
use crate::world::vector::{length, minus, times, transposed, unit};
use catalog_gen::parameters::DEFAULT_EPOCH_YEAR;
use fsw_core::orbit::body::CentralBody;
use fsw_core::telemetry::Report;
use serde::Serialize;
use std::collections::HashMap;
use std::sync::LazyLock;

/// Faintest star of the sky map's background, V.
const FAINTEST_V: f64 = 4.2;
/// Every so many of the limb's 720 points is drawn.
const LIMB_EVERY: usize = 8;
/// Points along a side of the field.
const SIDE_POINTS: u32 = 6;
/// Sine of the Sun's elevation from which a limb point counts as lit, 3 deg.
const LIT_SINE: f64 = 0.052_336;

/// Every star of the world, by Hipparcos number; drawings need no proper motion.
static STARS: LazyLock<HashMap<u32, WorldStar>> =
    LazyLock::new(|| sky::in_year(DEFAULT_EPOCH_YEAR).into_iter().map(|star| (star.hip, star)).collect());

/// A second looked at.
#[derive(Debug, Serialize)]
pub struct Look {
    cycle: u32,
    utc: String,
    /// Width and height of the detector, px; none where the camera is not known.
    size_px: Option<[u16; 2]>,
    /// Why there is no frame; none where there is one.
    no_frame: Option<String>,
    /// Whether the sensor's report of the second is at hand: stars and limb points come from it.
    reported: bool,
    stars: Vec<StarSeen>,
    limb_px: Vec<[f64; 2]>,
    limb_path: Option<String>,
    /// Windows read: x, y, width, height; none where they were not kept.
    windows: Option<Vec<[u16; 4]>>,
    sky: SkyLook,
    globe: GlobeLook,
    rate_deg_s: Option<f64>,
    log10_false: Option<f64>,
    earth: Option<EarthSeen>,
}

/// A star that the sensor recognised.
#[derive(Debug, Serialize)]
struct StarSeen {
    hip: u32,
    at_px: [f64; 2],
    residual_px: f64,
    direction: Option<Vector>,
    v: Option<f64>,
}

/// The Earth as the sensor reports it.
#[derive(Debug, Serialize)]
struct EarthSeen {
    distance_km: f64,
    sigma_km: f64,
}

/// Directions.
#[derive(Debug, Serialize)]
struct SkyLook {
    boresight: Vector,
    /// Edge of the star path's field, and of the Earth path's; empty where the camera is not known.
    field: Vec<Vector>,
    earth_field: Vec<Vector>,
    sun: Vector,
    /// What pulls beside the Sun: of the Earth the Moon, of the Moon the Earth, of Mars nothing.
    neighbour: Option<Vector>,
    /// The Earth's centre and its limb.
    earth: Vector,
    limb: Vec<Vector>,
}

/// Places on the ground.
#[derive(Debug, Serialize)]
struct GlobeLook {
    below_deg: [f64; 2],
    altitude_km: f64,
    sun_deg: [f64; 2],
    /// Latitude, longitude, and what of the limb it is.
    limb: Vec<(f64, f64, LimbPart)>,
}

/// A point of the limb, and whether it is on the detector.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
enum LimbPart {
    /// Not on the detector, or the camera is not known.
    Outside,
    /// On the detector, and dark.
    Dark,
    /// On the detector, and lit.
    Lit,
}

/// Looks at a second.
pub fn look(run: &Run, cycle: u32, second: &Logged) -> Look {
    let (report, place) = (second.report(), second.place);
    let world = run.world.as_ref().ok();
    let limb_path = report.as_ref().zip(world).and_then(|(report, world)| world.limb_path(report));
    Look {
        cycle,
        utc: civil_time::utc_text(place.instant_us),
        size_px: world.map(|world| [world.geometry().width_px, world.geometry().height_px]),
        no_frame: run.world.as_ref().err().cloned(),
        reported: report.is_some(),
        stars: report.as_ref().map_or_else(Vec::new, stars),
        limb_px: report.as_ref().map_or_else(Vec::new, |report| {
            report.limb_px.iter().map(|point| point.map(|px| rounded(px.into(), 1e1))).collect()
        }),
        limb_path,
        windows: second.windows.as_ref().map(|windows| {
            windows.iter().map(|window| [window.x, window.y, window.width, window.height]).collect()
        }),
        sky: sky_look(run.ground.body(), &place, world),
        globe: globe_look(run, &place, world),
        rate_deg_s: report.as_ref().and_then(|report| {
            let rate = report.rate_rad_s.or(report.rate.map(|rate| rate.rad_s))?;
            Some(length(rate.map(f64::from)).to_degrees())
        }),
        log10_false: report
            .as_ref()
            .and_then(|report| Some(f64::from(report.attitude?.log10_false)).filter(|log| *log < 0.0)),
        earth: report.as_ref().and_then(|report| report.earth).map(|earth| EarthSeen {
            distance_km: earth.distance_km.into(),
            sigma_km: earth.sigma_km.into(),
        }),
    }
}

/// The stars that the sky map has in its background: direction and V.
pub fn background() -> Vec<[f64; 4]> {
    let bright = STARS.values().filter(|star| star.v <= FAINTEST_V);
    let mut background: Vec<[f64; 4]> = bright
        .map(|star| {
            let [x, y, z] = short(star.direction);
            [x, y, z, rounded(star.v, 1e2)]
        })
        .collect();
    background.sort_by(|a, b| a[3].total_cmp(&b[3]));
    background
}

fn stars(report: &Report) -> Vec<StarSeen> {
    let seen = |star: &fsw_core::telemetry::StarReport| StarSeen {
        hip: star.hip,
        at_px: star.centre_px.map(|px| rounded(px.into(), 1e2)),
        residual_px: rounded(libm::hypotf(star.residual_px[0], star.residual_px[1]).into(), 1e3),
        direction: STARS.get(&star.hip).map(|star| short(star.direction)),
        v: STARS.get(&star.hip).map(|star| star.v),
    };
    report.stars.iter().map(seen).collect()
}

fn sky_look(about: CentralBody, place: &Place, world: Option<&World>) -> SkyLook {
    let star_path = matrix(place.quaternion);
    let field = |to_path: &[Vector; 3], optics: &Optics| {
        let to_icrs = transposed(to_path);
        edge(optics).into_iter().map(|direction| short(apply(&to_icrs, direction))).collect()
    };
    let earth_path = world.and_then(|world| world.earth_path(place.instant_us));
    let earth_field = world.zip(earth_path).map(|(world, path)| field(&path, &world.optics().earth_path()));
    let ellipsoid = ellipsoid(about, place);
    let limb = ellipsoid.limb().step_by(LIMB_EVERY);
    let neighbour = body::neighbour(about, place.instant_us);
    SkyLook {
        boresight: short(star_path[2]),
        field: world.map_or_else(Vec::new, |world| field(&star_path, world.optics())),
        earth_field: earth_field.unwrap_or_default(),
        sun: short(unit(body::sun_km(about, place.instant_us))),
        neighbour: neighbour.map(|(km, _)| short(unit(minus(km, place.position_km)))),
        earth: short(unit(times(-1.0, place.position_km))),
        limb: limb.map(|(_, point)| short(unit(minus(point, place.position_km)))).collect(),
    }
}

fn globe_look(run: &Run, place: &Place, world: Option<&World>) -> GlobeLook {
    let about = run.ground.body();
    let sun = unit(body::sun_km(about, place.instant_us));
    let seen =
        world.and_then(|world| Some((world.optics().earth_path(), world.earth_path(place.instant_us)?)));
    let part = |normal: Vector, point: Vector| {
        let to_limb = minus(point, place.position_km);
        let pixel = seen.as_ref().and_then(|(optics, path)| {
            optics.project(apply(path, to_limb)).filter(|pixel| optics.on_detector(*pixel))
        });
        match pixel {
            None => LimbPart::Outside,
            Some(_) if dot(normal, sun) > LIT_SINE => LimbPart::Lit,
            Some(_) => LimbPart::Dark,
        }
    };
    let ellipsoid = ellipsoid(about, place);
    let limb = ellipsoid.limb().step_by(LIMB_EVERY).map(|(normal, point)| {
        let [latitude, longitude] = run.ground.place_deg(point, place.instant_us);
        (rounded(latitude, 1e2), rounded(longitude, 1e2), part(normal, point))
    });
    GlobeLook {
        below_deg: run.ground.place_deg(place.position_km, place.instant_us),
        altitude_km: rounded(length(place.position_km) - ellipsoid.figure().equator_km, 1e1),
        sun_deg: run.ground.place_deg(sun, place.instant_us),
        limb: limb.collect(),
    }
}

fn ellipsoid(about: CentralBody, place: &Place) -> Ellipsoid {
    Ellipsoid::new(about, &body::icrs_to_equator(about, place.instant_us), place.position_km)
}

/// Directions of the detector's edge, around it, in the axes of the path.
fn edge(optics: &Optics) -> Vec<Vector> {
    let [width, height] = optics.size_px();
    let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
    let mut edge = Vec::new();
    for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        for step in 0..SIDE_POINTS {
            let part = f64::from(step) / f64::from(SIDE_POINTS);
            let pixel = [0, 1].map(|k| from[k] + part * (to[k] - from[k]) - 0.5);
            edge.extend(optics.unproject(pixel));
        }
    }
    edge
}

/// A direction with as many digits as a drawing shows.
fn short(direction: Vector) -> Vector {
    direction.map(|component| rounded(component, 1e5))
}

/// A value in so many parts of one.
fn rounded(value: f64, parts: f64) -> f64 {
    libm::round(value * parts) / parts
}

#[cfg(test)]
mod tests {
    use super::super::log::{Log, Title};
    use super::*;
    use crate::harness::truth_of;
    use crate::scenario::Scenario;
    use crate::world::earth::EQUATOR_KM;
    use std::path::Path;

    #[test]
    fn a_high_satellite_sees_the_whole_limb_a_low_one_an_arc_and_as_much_is_lit_as_in_truth() {
        for (name, sees_all) in [("geo-eclipse", true), ("leo-oblique", false)] {
            let scenario = Scenario::load(Path::new(name)).unwrap();
            let scene = scenario.scene().unwrap();
            let truth = truth_of(&scene, 0).unwrap();
            let place = Place {
                instant_us: truth.instant_us,
                quaternion: truth.quaternion,
                position_km: truth.position_km,
            };
            let second = Logged { row: "[]".into(), place, frame: None, windows: None };
            let run = Run::new(Title::of(1, &scenario), Ok(World::new(scenario, scene)), Log::default());
            let Look { sky, globe, reported, .. } = look(&run, 0, &second);
            let limb = |part: LimbPart| globe.limb.iter().filter(|point| point.2 == part).count();
            assert_eq!(limb(LimbPart::Outside) == 0, sees_all, "{name}");
            // A point stands for 4 deg of the limb.
            let lit_deg = 4.0 * limb(LimbPart::Lit) as f64;
            assert!((lit_deg - truth.lit_limb_deg).abs() <= 8.0, "{name}: {lit_deg} {}", truth.lit_limb_deg);
            // The field lies about the boresight, half its diagonal away at most.
            assert!(sky.field.len() == 24 && !reported);
            assert!(sky.field.iter().all(|edge| (0.1..0.4).contains(&dot(*edge, sky.boresight).acos())));
            let half_disc = (EQUATOR_KM / length(truth.position_km)).asin();
            assert!(sky.limb.iter().all(|edge| (dot(*edge, sky.earth).acos() - half_disc).abs() < 0.01));
        }
    }
}
