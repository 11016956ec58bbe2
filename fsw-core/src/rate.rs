//! Angular rate while no attitude is known (thesis §3.1.5: HARM and LARM).
//!
//! In: moving directions of an image ([`arcs::Arc`], [`marks::Mark`]), the seconds since the last image,
//! and the history of that image ([`sense::RateHistory`]). Out: the angular rate of the star path against
//! the stars, its own frame, rad/s, with its covariance.
//!
//! | file | does |
//! |---|---|
//! | [`arcs`] | the rate on which most arcs of an image agree, least squares |
//! | [`marks`] | stars and streaks of one image found again in the next |
//! | [`streaks`] | arc and mark of a streak in an image |
//! | [`sense`] | the sense of a rate by streaks, which one image leaves open and the next one decides |

pub mod arcs;
pub mod marks;
pub mod sense;
pub mod streaks;
