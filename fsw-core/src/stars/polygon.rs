//! Polygons of measured and catalogue stars that agree in all their separations (thesis §3.1.3, steps 4 and
//! 5).

use crate::order::insert_last;
use heapless::Vec;

/// Most stars of a polygon.
pub const MAX_POLYGON: usize = 12;
/// Polygons kept for inspection.
pub const KEPT_POLYGONS: usize = 8;

/// Measured and catalogue stars that agree in all their separations.
#[derive(Clone, Debug)]
pub struct Polygon {
    /// Pairs of (measured index, catalogue index).
    pub corners: Vec<(u8, u16), MAX_POLYGON>,
    /// Mean square error of its sides, squared tolerances.
    pub mean_square_error: f32,
}

impl Polygon {
    /// Whether all corners of `other` are corners of this one.
    fn contains(&self, other: &Polygon) -> bool {
        other.corners.iter().all(|corner| self.corners.contains(corner))
    }

    /// The thesis's criterion: more corners, then less error.
    fn better_than(&self, other: &Polygon) -> bool {
        let (ours, theirs) = (self.corners.len(), other.corners.len());
        ours > theirs || (ours == theirs && self.mean_square_error < other.mean_square_error)
    }
}

/// The best polygons of a search, best first.
#[derive(Clone, Debug)]
pub(super) struct Candidates {
    kept: Vec<Polygon, KEPT_POLYGONS>,
}

impl Candidates {
    pub const fn new() -> Self {
        Self { kept: Vec::new() }
    }

    pub fn polygons(&self) -> &[Polygon] {
        &self.kept
    }

    /// Keeps a polygon of three or more corners, unless it is part of a kept one or eight better ones are
    /// kept.
    pub fn keep(&mut self, polygon: Polygon) {
        if polygon.corners.len() < 3 || self.kept.iter().any(|kept| kept.contains(&polygon)) {
            return;
        }
        self.kept.retain(|kept| !polygon.contains(kept));
        if self.kept.is_full() && self.kept.last().is_some_and(|worst| polygon.better_than(worst)) {
            self.kept.pop();
        }
        if self.kept.push(polygon).is_ok() {
            insert_last(&mut self.kept, Polygon::better_than);
        }
    }
}

#[cfg(test)]
mod tests;
