//! Other methods to measure the Earth, for comparison only; not flown.
//!
//! [`thesis`] is the thesis's own way to the centre, [`filters`] are its other filters across the limb,
//! [`scale`] checks the focal length on the ground.

pub mod filters;
pub mod scale;
pub mod thesis;
