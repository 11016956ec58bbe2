//! The other side of the flight software's door: pictures, the synthetic world and the command line.
//!
//! | module | what it is |
//! |---|---|
//! | [`cli`] | the words of the command line |
//! | [`run`], [`render`], [`solve`], [`earth`], [`identify`], [`mod@attitude`], [`record`], [`budget`], [`defects`], [`parameters`] | what the commands do |
//! | [`scenario`] | scenario files (TOML), and those that come with the program |
//! | [`flight`] | cameras and catalogues for the flight code |
//! | [`lost_in_space`] | the flight code's identification with the host's memory |
//! | [`campaign`] | identification on many random skies, beside the peers |
//! | [`attitude_table`] | the methods of attitude compared over the sky |
//! | [`judge`], [`bound`] | estimate against truth, and against the physical limit |
//! | [`report`] | a run on one page |
//! | [`star_scene`] | the star path alone, for benchmarks and tests |
//! | [`picture`] | a picture file served as a detector |
//! | [`fits`] | reader of the first picture of a FITS file |
//! | [`camera_file`] | camera files (TOML) |
//! | [`frames_file`] | frames recorded for the emulated target, and their replay |
//! | [`world`] | truth, apart from the flight code: sky, optics, noise, frames |
//! | [`output`] | files that are whole or marked as partial |
//! | [`error`] | what a user reads when something is wrong |
//!
//! Pixels count x right and y down, the centre of the first pixel read is (0, 0). The sensor frame is x
//! along +x px, y along +y px, z out along the line of sight. A quaternion is `[x, y, z, w]`, scalar last,
//! and maps ICRS to sensor.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::print_stdout))]

/// A line on stdout.
macro_rules! say {
    ($($words:tt)*) => { $crate::output::say(format_args!($($words)*)) };
}

pub mod attitude;
pub mod attitude_table;
pub mod bound;
pub mod budget;
pub mod calibrate;
pub mod calibration;
pub mod camera_file;
pub mod campaign;
pub mod centroids;
pub mod cli;
pub mod defects;
pub mod earth;
pub mod error;
pub mod fits;
pub mod flight;
pub mod frames_file;
pub mod identify;
pub mod json;
pub mod judge;
pub mod lost_in_space;
pub mod output;
pub mod parameters;
pub mod picture;
pub mod record;
pub mod render;
pub mod report;
pub mod run;
pub mod scenario;
pub mod solve;
pub mod star_scene;
pub mod world;
