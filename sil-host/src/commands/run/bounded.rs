//! The judge of a flight, with the bounds of what its world allows beside the errors.
//!
//! In: the seconds of a flight. Out: the judge's figures. The attitude's bound is that of the stars used in a
//! second, sampled; the position's is that of all the limb seen until then
//! and of the state that the ground gave at the start.

use crate::bound::{self, position::PositionBound};
use crate::harness::Second;
use crate::judge::{Figures, Judge};
use crate::scenario::Scenario;
use crate::world::scene::{Scene, VisibleStar};

/// Seconds between two samples of the attitude's bound.
const BOUND_EVERY_S: u32 = 60;

/// Judges the seconds of a scenario.
pub struct BoundedJudge {
    judge: Judge,
    exposure_us: u32,
    position: PositionBound,
    position_km: Option<[f64; 3]>,
}

impl BoundedJudge {
    /// Before the first second.
    pub fn new(scenario: &Scenario) -> Self {
        let bound = PositionBound::new(&scenario.earth);
        Self {
            judge: Judge::new(scenario.duration_s, scenario.period_s()),
            exposure_us: scenario.exposure_us,
            position: match &scenario.orbit_filter.start {
                Some(start) => bound.knowing(start.position_sigma_km, start.velocity_sigma_m_s),
                None => bound,
            },
            position_km: None,
        }
    }

    /// Adds a second; gives whether its mode was right.
    pub fn add(&mut self, second: &Second<'_>) -> bool {
        if second.cycle.is_multiple_of(BOUND_EVERY_S)
            && let Some(bound_rad) = self.attitude_rad(second)
        {
            self.judge.add_bound(bound_rad);
        }
        self.position_km = self.position.add(second.truth, second.scene.optics());
        self.judge.add_position_bound(second.cycle, self.position_km);
        self.judge.add(second.judged)
    }

    /// The position's bound in the last second, radial, along, cross, km.
    pub fn position_bound_km(&self) -> Option<[f64; 3]> {
        self.position_km
    }

    /// What the run came to.
    pub fn finish(self) -> Figures {
        self.judge.finish()
    }

    /// The Cramer-Rao bound of a second's attitude for the stars that were used; only where it was found in
    /// that second's image.
    fn attitude_rad(&self, second: &Second<'_>) -> Option<[f64; 3]> {
        let scene: &Scene = second.scene;
        if scene.cycle() != Some(second.cycle.into()) || second.report.attitude?.age_s > 0 {
            return None;
        }
        let named = |seen: &&VisibleStar| second.report.stars.iter().any(|star| star.hip == seen.hip);
        let used: Vec<VisibleStar> = scene.visible_stars().iter().filter(named).copied().collect();
        bound::attitude_rad(scene, &used, self.exposure_us)
    }
}
