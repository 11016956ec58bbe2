//! The detector: what its pixels make of light, and what else leaves charge in them.

pub mod deposits;
pub mod disturbances;
pub mod fixed_pattern;
pub mod imaging;
pub mod pixel;
pub mod protons;
pub mod shutter;
