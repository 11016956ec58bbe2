//! The attitude's filter as the sensor holds it: one that is trusted, or one that was lost.
//!
//! What a lost one predicts is a hypothesis for the stars of later images and nothing that is told. An attitude
//! that it expects makes it trusted again.

use crate::attitude::filter::Filter;

/// The filter, if there is one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    filter: Option<Filter<2>>,
    lost: bool,
}

impl From<Filter<2>> for Motion {
    fn from(filter: Filter<2>) -> Self {
        Self { filter: Some(filter), lost: false }
    }
}

impl Motion {
    /// The filter that is trusted.
    pub(super) fn as_ref(&self) -> Option<&Filter<2>> {
        self.filter.as_ref().filter(|_| !self.lost)
    }

    /// The same, to be updated.
    pub(super) fn as_mut(&mut self) -> Option<&mut Filter<2>> {
        self.filter.as_mut().filter(|_| !self.lost)
    }

    /// The filter, trusted or lost.
    pub(super) fn any(&self) -> Option<&Filter<2>> {
        self.filter.as_ref()
    }

    /// Sum of its words, and whether it is trusted.
    pub(super) fn word_sum(&self) -> u32 {
        self.filter.as_ref().map_or(0, Filter::word_sum).wrapping_add(u32::from(self.lost))
    }

    /// Trusts it no longer.
    pub(super) fn lose(&mut self) {
        self.lost = true;
    }

    /// The same filter, trusted.
    pub(super) fn trusted(&self) -> Self {
        Self { lost: false, ..*self }
    }
}
