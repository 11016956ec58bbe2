//! The world: truth, written apart from the flight code so that an error cannot cancel itself.
//!
//! All in f64 and `libm`; shared with the flight side are the HAL's types and the facts of the bodies. A
//! frame is a pure function of (scene, seed, cycle, x, y), see [`noise`].
//!
//! | room | what is in it |
//! |---|---|
//! | [`noise`], [`normal`], [`random_walk`], [`vector`], [`attitude`] | the ground floor: counter-based random numbers, vectors, rotations |
//! | [`time`] | calendars and clocks, Sun, Moon, the Earth's axes |
//! | [`body`] | Earth, Moon and Mars: Sun and neighbour from there, motion, axes |
//! | [`orbit`] | position and velocity, by forces or from a file |
//! | [`motion`] | attitude over time: laws of pointing, slews, jitter, tumbling; the truth of a second |
//! | [`sky`] | stars, planets, Moon, Sun, satellites |
//! | [`lens`] | what the objective does to light |
//! | [`detector`] | what the pixels make of it, and what else leaves charge in them |
//! | [`earth`] | light of the central body on the detector |
//! | [`instruments`] | gyro and magnetometer |
//! | [`scene`] | all of these: raw frames through the detector trait, and the truth |
//! | [`fields`] | lists of centroids with their truth, without a picture |
//!
//! Left out: ghosts and flare of the lens but the Sun's, lag, stray light of Earth and
//! Moon, maria, eclipses of the Sun by the Moon, satellites' shadows, charge that stars and Earth spill
//! beyond a full well.

pub mod attitude;
pub mod body;
pub mod detector;
pub mod earth;
pub mod fields;
pub mod instruments;
pub mod lens;
pub mod motion;
pub mod noise;
pub mod normal;
pub mod orbit;
pub mod random_walk;
pub mod scene;
pub mod sky;
pub mod time;
pub mod vector;
