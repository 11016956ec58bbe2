//! The world: truth, written apart from the flight code so that an error cannot cancel itself.
//!
//! All in f64 and `libm`; shared with the flight side are the HAL's types only. A frame is a pure function of (scene, seed,
//! cycle, x, y), see [`noise`].
//!
//! | module | takes | gives |
//! |---|---|---|
//! | [`noise`] | seed, cycle, x, y, stream | uniform, Gaussian and Poisson numbers |
//! | [`normal`] | a probability | the deviate of the normal distribution |
//! | [`vector`] | vectors | sums, products |
//! | [`attitude`] | quaternion, rate, time | quaternion, matrix |
//! | [`ephemeris`] | time | Sun, Moon, the Earth's motion, pole and rotation |
//! | [`orbit`] | elements or state, time | position and velocity |
//! | [`pointing`] | position, velocity, angles | frames of the two paths |
//! | [`earth`] | position, Sun, camera | light of the Earth on the detector |
//! | [`sun`] | Sun, Earth, optics | whether it blinds the detector |
//! | [`journey`] | orbit, pointing, mounting | the truth of a second |
//! | [`motion`] | turning or journey | attitude over time |
//! | [`optics`] | camera, direction in the sensor frame | pixel |
//! | [`sky`] | a year | the stars of the world |
//! | [`stars`] | visual magnitude, detector | electrons |
//! | [`spots`] | places and charges | mean electrons of a window |
//! | [`disturbances`] | counts, ranges, seed, cycle | false stars, hot pixels, protons |
//! | [`scene`] | all of these | raw frames through the detector trait, and the truth |
//! | [`fields`] | camera, star list, seed | lists of centroids with their truth |
//!
//! Left out in this form: star colours and parallax, vignetting, a PSF that varies over the field, pixel-to-pixel
//! response, the Moon's light, an Earth in the star path, stray light of a Sun outside the field, pointing errors. The
//! shutter is global: every pixel integrates over the same time.

pub mod attitude;
pub mod disturbances;
pub mod earth;
pub mod ephemeris;
pub mod fields;
pub mod journey;
pub mod moon;
pub mod motion;
pub mod noise;
pub mod normal;
pub mod optics;
pub mod orbit;
pub mod planets;
pub mod pointing;
pub mod satellites;
pub mod scene;
pub mod sky;
pub mod spots;
pub mod stars;
pub mod sun;
pub mod vector;
