//! The attitude's filter as the sensor holds it: one that is trusted, or one that was lost.
//!
//! What a lost one predicts is a hypothesis for the stars of later images and nothing that is told. An attitude
//! that it expects makes it trusted again.

use crate::attitude::filter::Filter;
use crate::frames::{Icrs, Rotation, StarPath};
use fsw_hal::LocalTime;

/// The filter, if there is one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    filter: Option<Filter>,
    lost: bool,
}

impl From<Filter> for Motion {
    fn from(filter: Filter) -> Self {
        Self { filter: Some(filter), lost: false }
    }
}

impl Motion {
    /// The filter that is trusted.
    pub(super) fn as_ref(&self) -> Option<&Filter> {
        self.filter.as_ref().filter(|_| !self.lost)
    }

    /// The same, to be updated.
    pub(super) fn as_mut(&mut self) -> Option<&mut Filter> {
        self.filter.as_mut().filter(|_| !self.lost)
    }

    /// The filter, trusted or lost.
    pub(super) fn any(&self) -> Option<&Filter> {
        self.filter.as_ref()
    }

    /// Sum of its words, and whether it is trusted.
    pub(super) fn word_sum(&self) -> u32 {
        self.filter.as_ref().map_or(0, Filter::word_sum).wrapping_add(u32::from(self.lost))
    }

    /// Whether it was lost in a turn that nobody saw: images contradicted it.
    pub(super) fn is_lost_in_turn(&self) -> bool {
        self.lost && self.filter.as_ref().is_some_and(|filter| !filter.is_steady())
    }

    /// Trusts it no longer.
    pub(super) fn lose(&mut self) {
        self.lost = true;
    }

    /// Trusts one that was lost again where it expects this attitude of an instant.
    pub(super) fn trust_again(
        &mut self,
        attitude: &Rotation<Icrs, StarPath>,
        sigma_rad: &[f32; 3],
        instant: LocalTime,
    ) {
        let filter = self.filter.as_ref().filter(|_| self.lost);
        if filter.is_some_and(|filter| filter.expects(attitude, sigma_rad, instant)) {
            self.lost = false;
        }
    }
}
