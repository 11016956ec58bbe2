//! The system tests in one program, so that they run side by side on every core and are linked once.
//!
//! `cargo test --release -p system-tests --test system FILE::` runs those of one file. Tests share nothing
//! but the program under test: each writes into a `scratch` folder of its own.

mod attitude_sets;
mod bad_input;
mod bodies;
mod book;
mod c_face;
mod calibrate;
mod cfs;
mod clock_faults;
mod detector_driver;
mod detector_faults;
mod dynamics;
mod earth_pictures;
mod earth_positions;
mod earth_real;
mod earth_vectors;
mod emulator;
mod extended_objects;
mod fast_turns;
mod flights;
mod foreseen_outages;
mod gallery;
mod identify_fields;
mod installed;
mod jobs;
mod lenses;
mod local_frame;
mod magnetometer;
mod misalignment;
mod orbits;
mod packages;
mod parameter_ranges;
mod rate_sensor;
mod rates;
mod scenarios;
mod sensor_cycles;
mod serve;
mod shutters;
mod sky_answers;
mod sky_pictures;
mod telecommands;
mod telemetry_layout;
mod two_fields;
mod uploads;
mod xtce;
