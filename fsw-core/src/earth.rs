//! From the limb's pixels to the Earth's centre.

use serde::{Deserialize, Serialize};

/// Why no centre was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// Fewer limb points than make a fit.
    TooFewPoints,
    /// The points do not agree on one body.
    NoConsensus,
    /// The arc of the limb is too short.
    ShortArc,
    /// The points do not fix a centre, or fix an impossible one.
    Degenerate,
}

/// TEMPORARY
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EarthParameters {
    /// h
    pub limb_height_km: f32,
}
