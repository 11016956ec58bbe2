//! The stars of the world: every star of the embedded source, moved to the year of the run.
//!
//! In: a Julian year. Out: directions (ICRS, from the Sun, without aberration), colours, and magnitudes to
//! V = 8.
//!
//! | module | takes | gives |
//! |---|---|---|
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
pub mod planets;
pub mod satellites;
pub mod stars;
pub mod sun;

use super::scene::WorldStar;

/// Every star as it stands in `year`.
pub fn in_year(year: f64) -> Vec<WorldStar> {
    let star = |star: &catalog_gen::SourceStar| WorldStar {
        hip: star.hip,
        direction: star.direction_at(year),
        v: star.v,
        b_v: star.b_v,
    };
    catalog_gen::source::stars().iter().map(star).collect()
}
