//! The world: truth, written apart from the flight code so that an error cannot cancel itself.
//!
//! All in f64 and `libm`; shared with the flight side are the HAL's types only. A frame is a pure function of
//! (scene, seed, cycle, x, y), see [`noise`].
//!
//! | module | takes | gives |
//! |---|---|---|
//! | [`noise`] | seed, cycle, x, y, stream | uniform, Gaussian and Poisson numbers |
//! | [`normal`] | a probability, or a deviate | the other one of the two |
//! | [`vector`] | vectors | sums, products |
//! | [`attitude`] | quaternion, rate, time | quaternion, matrix |
//! | [`civil_time`] | calendar dates on several clocks | TT |
//! | [`ephemeris`] | time | Sun, Moon, the Earth's motion, pole and rotation |
//! | [`earth_orientation`] | time, observed UT1 and pole | GCRF to ITRF |
//! | [`orbit`] | elements or state, time | position and velocity |
//! | [`moving_frame`] | rotations in a row | frame and rate, the one the derivative of the other |
//! | [`pointing`] | time, orbit, law, slews | frames of the two paths |
//! | [`tumble`] | attitude, rate, inertia, time | free turning of a body |
//! | [`slew`] | axis, angle, time | a smooth turn |
//! | [`jitter`] | deviation, frequencies, seed, time | pointing errors |
//! | [`earth`] | position, Sun, camera | light of the Earth on the detector |
//! | [`sun`] | Sun, Earth, optics | whether it blinds the detector, its image and stray light |
//! | [`planets`] | time | Mercury to Saturn |
//! | [`satellites`] | seed, attitude, time | others that cross the field |
//! | [`moon`] | Moon, Sun, a path | its disc and phase |
//! | [`bodies`] | all of these four | what shines beside stars and Earth |
//! | [`trajectory`] | orbit, pointing, mounting | the truth of a second |
//! | [`random_walk`] | seed, step | a walk of which any step can be asked alone |
//! | [`gyro`], [`magnetometer`] | truth, seed, cycle | readings through the sensors' traits |
//! | [`geomagnetism`] | place, time | the Earth's magnetic field |
//! | [`motion`] | turning or trajectory | attitude over time |
//! | [`optics`] | camera, direction in the sensor frame | pixel |
//! | [`sky`] | a year | the stars of the world |
//! | [`cells`] | the stars' directions, a cone | the stars near it |
//! | [`stars`] | visual magnitude, detector | electrons, digital numbers |
//! | [`colour`] | B-V | electrons in the parts of the band |
//! | [`lens`] | field angle, wavelength, point of the pupil | where the ray lands |
//! | [`psf`] | lens, place on the detector | the image of a star as a few Gaussians |
//! | [`pixel`] | a Gaussian | its share in the sensitive part of pixels |
//! | [`spots`] | places and charges | mean electrons of a window |
//! | [`streaks`] | ways and charges | the same, of points that move |
//! | [`vignetting`] | place on the detector | what is left of the light |
//! | [`shutter`] | attitude over time, row | where a star is when its row collects light |
//! | [`imaging`] | - | the settings of all of these |
//! | [`fixed_pattern`] | seed, pixel | gain, dark current, offsets |
//! | [`disturbances`] | counts, ranges, seed, cycle | false stars, hot and dead pixels |
//! | [`protons`] | position, seed, cycle | tracks of charge |
//! | [`scene`] | all of these | raw frames through the detector trait, and the truth |
//! | [`fields`] | camera, star list, seed | lists of centroids with their truth |
//!
//! Left out: the stars' parallax, ghosts and flare of the lens but the Sun's, lag, stray light of Earth and
//! Moon, maria, eclipses of the Sun by the Moon, satellites' shadows, charge that stars and Earth spill
//! beyond a full well.

pub mod attitude;
pub mod bodies;
pub mod cells;
pub mod civil_time;
pub mod colour;
pub mod disturbances;
pub mod earth;
pub mod earth_orientation;
pub mod ephemeris;
pub mod fields;
pub mod fixed_pattern;
pub mod geomagnetism;
pub mod gyro;
pub mod imaging;
pub mod jitter;
pub mod lens;
pub mod magnetometer;
pub mod moon;
pub mod motion;
pub mod moving_frame;
pub mod noise;
pub mod normal;
pub mod optics;
pub mod orbit;
pub mod pixel;
pub mod planets;
pub mod pointing;
pub mod protons;
pub mod psf;
pub mod random_walk;
pub mod satellites;
pub mod scene;
mod scene_settings;
pub mod shutter;
pub mod sky;
pub mod slew;
pub mod spots;
pub mod stars;
pub mod streaks;
pub mod sun;
pub mod trajectory;
pub mod tumble;
pub mod vector;
pub mod vignetting;

/// `value` to whole steps of `resolution`; as it is where there are none.
fn rounded(value: f64, resolution: f64) -> f64 {
    if resolution > 0.0 { libm::rint(value / resolution) * resolution } else { value }
}
