//! The world: truth, written apart from the flight code so that an error cannot cancel itself.
//!
//! All in f64; shared with the flight side are the HAL's types only. A frame is a pure function of (scene, seed,
//! cycle, x, y), see [`noise`].
//!
//! | module | takes | gives |
//! |---|---|---|
//! | [`noise`] | seed, cycle, x, y, stream | uniform, Gaussian and Poisson numbers |
//! | [`normal`] | a probability | the deviate of the normal distribution |
//! | [`attitude`] | quaternion, rate, time | quaternion, matrix |
//! | [`optics`] | camera, direction in the sensor frame | pixel |
//! | [`stars`] | visual magnitude, detector | electrons |
//! | [`spots`] | places and charges | mean electrons of a window |
//! | [`disturbances`] | counts, ranges, seed, cycle | false stars, hot pixels, protons |
//! | [`scene`] | all of these | raw frames through the detector trait, and the truth |
//! | [`fields`] | camera, star list, seed | lists of centroids with their truth |
//!
//! Left out in this form: annual and orbital aberration, star colours, vignetting, a PSF that varies over the field,
//! pixel-to-pixel response, the Earth. The shutter is global: every pixel integrates over the same time.

pub mod attitude;
pub mod disturbances;
pub mod fields;
pub mod noise;
pub mod normal;
pub mod optics;
pub mod scene;
pub mod spots;
pub mod stars;
