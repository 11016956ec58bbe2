//! The stars of the world: every star of the embedded source, moved to the year of the run.
//!
//! In: a Julian year. Out: directions (ICRS, from the Sun, without aberration), colours, and magnitudes to
//! V = 8.

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
