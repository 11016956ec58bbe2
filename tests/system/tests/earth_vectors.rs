//! Earth vectors of single pictures are as good as their covariances say, over rendered limbs with clouds and
//! an uneven horizon.
//!
//! Low orbits, arcs of 10 to 28 degrees, the orbit filter's own start included. Neighbouring seconds see the
//! same clouds: errors last for the half minute in which the limb moves on by the horizon's cells, so that
//! 900 s are worth some thirty pictures.

use crate::flights::{self, scenario};

const SECONDS: u32 = 900;
/// Seconds for which errors last.
const LASTING_S: f64 = 30.0;

#[test]
fn single_earth_vectors_are_as_good_as_they_say() {
    let (mut squares, mut found) = ([0.0; 3], 0.0);
    for name in ["leo-oblique", "sso-noon-midnight", "sso-dawn-dusk"] {
        let mut ratios = Vec::new();
        flights::fly(&scenario(name, SECONDS), |second| {
            // Without an orbit none is told that is known worse (`earth.plausible.told_deg`).
            let told_deg = second.report.earth.as_ref().map(|earth| earth.sigma_rad.to_degrees());
            assert!(second.report.orbit.is_some() || told_deg.is_none_or(|sigma_deg| sigma_deg <= 2.0));
            ratios.extend(second.judged.earth.as_ref().map(|earth| {
                let [first, second, _] = earth.direction_rad.deviates;
                [first, second, earth.distance_km / earth.sigma_km]
            }));
        });
        let count = ratios.len() as f64;
        for (k, what) in ["direction along x", "along y", "distance"].into_iter().enumerate() {
            let within = ratios.iter().filter(|ratio| ratio[k].abs() <= 3.0).count() as f64 / count;
            let square = ratios.iter().map(|ratio| ratio[k] * ratio[k]).sum::<f64>();
            squares[k] += square;
            println!(
                "{name}: {count} vectors, {what} within 3 sigma {within:.4}, mean square {:.2}",
                square / count
            );
            // Some twenty independent errors.
            assert!(within >= 0.95, "{name}: {what} {within}");
        }
        found += count;
    }
    // Two degrees of freedom of a direction, one of a distance. 95 %.
    let [x, y, distance] = squares.map(|sum| sum / found);
    for (square, freedom) in [(0.5 * (x + y), 2.0), (distance, 1.0)] {
        let band = 1.96 * (2.0 * LASTING_S / (found * freedom)).sqrt();
        println!("mean square {square:.2} of 1 +- {band:.2}");
        assert!((square - 1.0).abs() < band, "{square}");
    }
}
