//! The stars of the world: every star of the embedded source, moved to the year of the run.
//!
//! In: a Julian year. Out: directions (ICRS, from the Earth, without aberration), colours, and magnitudes to
//! V = 8.
//!
//! | module | takes | gives |
//! |---|---|---|
//! | [`places`] | a star of the source, the Earth's place | its direction |
//! | [`cells`] | the stars' directions, a cone | the stars near it |
//! | [`stars`] | visual magnitude, detector | electrons, digital numbers |
//! | [`colour`] | B-V | electrons in the parts of the band |
//! | [`sun`] | Sun, Earth, optics | whether it blinds the detector, its image and stray light |
//! | [`planets`] | time | Mercury to Saturn |
//! | [`satellites`] | seed, attitude, time | others that cross the field |
//! | [`moon`] | Moon, Sun, a path | its disc and phase |
//! | [`bodies`] | all of these four | what shines beside stars and Earth |

pub mod bodies;
pub mod cells;
pub mod colour;
pub mod moon;
pub mod places;
pub mod planets;
pub mod satellites;
pub mod stars;
pub mod sun;

use super::scene::WorldStar;
use super::time::ephemeris::{AU_KM, sun_km};
use super::vector::times;

/// Every star as it stands in `year`.
pub fn in_year(year: f64) -> Vec<WorldStar> {
    let instant_us = ((year - 2000.0) * 365.25 * 86_400e6) as i64;
    let earth_au = times(-1.0 / AU_KM, sun_km(instant_us));
    let star = |star: &catalog_gen::SourceStar| WorldStar {
        hip: star.hip,
        direction: places::direction(star, year, earth_au),
        v: star.v,
        b_v: star.b_v,
    };
    catalog_gen::source::stars().iter().map(star).collect()
}
