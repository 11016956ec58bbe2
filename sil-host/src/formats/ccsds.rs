//! Orbit and Attitude Ephemeris Messages of the CCSDS as key-value text, written while a run goes on.
//!
//! In: states with their instants. Out: an OEM (CCSDS 502.0-B-2, sec. 5) or an AEM (504.0-B-1, sec. 4) in
//! ICRF axes about the Earth's centre and TT. Where time jumps (back, or ahead by more than [`GAP_US`]) a
//! segment ends and another one begins, so that nothing is interpolated over the jump. `STOP_TIME` is the
//! run's planned end until its segment ends, then the last instant: a run that is killed leaves a message
//! that can be read up to its last whole line. `CREATION_DATE` is the run's start, for the same run gives the
//! same bytes.

use crate::error::HostError;
use crate::output::PartialFile;
use crate::world::time::civil_time::{shown_text, utc_text};
use fsw_core::orbit::body::CentralBody;
use std::path::Path;

/// Longest time between two states of a segment, µs.
pub const GAP_US: i64 = 10_000_000;
/// Time between two covariances, µs.
const COVARIANCE_EVERY_US: i64 = 60_000_000;
/// States of position and velocity.
pub const MOTION: usize = 6;

/// Lower triangle, row by row, of a covariance of position and velocity: km², km²/s, km²/s².
pub type MotionCovariance = [[f64; MOTION]; MOTION];

/// Which message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Message {
    /// Position and velocity.
    Orbit,
    /// The quaternion from ICRF to the star path, scalar last.
    Attitude,
}

/// A run, as the messages name it.
#[derive(Clone, Debug)]
pub struct RunName {
    /// The scenario.
    pub object: String,
    /// The body about which the states are.
    pub centre: CentralBody,
    /// What is written: the truth, or what the flight code made of it.
    pub comment: &'static str,
    /// First instant, TT, µs since J2000.0.
    pub start_us: i64,
    /// Planned end.
    pub end_us: i64,
}

/// A message under way.
#[derive(Debug)]
pub struct MessageFile {
    file: PartialFile,
    message: Message,
    name: RunName,
    /// Place of the present segment's `STOP_TIME` in the file, and its last instant.
    segment: Option<(u64, i64)>,
    covariances: String,
    covariance_us: Option<i64>,
}

impl MessageFile {
    /// Begins a message.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn create(path: &Path, message: Message, name: RunName) -> Result<Self, HostError> {
        let version = match message {
            Message::Orbit => "CCSDS_OEM_VERS = 2.0",
            Message::Attitude => "CCSDS_AEM_VERS = 1.0",
        };
        // Of all times in the message this one is UTC.
        let start = utc_text(name.start_us);
        let head = format!(
            "{version}\nCOMMENT {}\nCOMMENT CREATION_DATE is the run's start: the same run gives the same bytes\n\
             CREATION_DATE = {start}\nORIGINATOR = SEXTANT\n",
            name.comment
        );
        let mut file = PartialFile::create(path)?;
        file.write(head.as_bytes())?;
        Ok(Self { file, message, name, segment: None, covariances: String::new(), covariance_us: None })
    }

    /// Adds a state: position (km) and velocity (km/s), or a quaternion; of an orbit with its covariance,
    /// which is written once a minute.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn add(
        &mut self,
        instant_us: i64,
        state: &[f64],
        covariance: Option<&MotionCovariance>,
    ) -> Result<(), HostError> {
        let goes_on = |(_, last_us): (u64, i64)| instant_us > last_us && instant_us - last_us <= GAP_US;
        if !self.segment.is_some_and(goes_on) {
            self.end_segment()?;
            self.begin_segment(instant_us);
        }
        let mut line = shown_text(instant_us);
        for (index, value) in state.iter().enumerate() {
            // A millimetre, a micrometre a second; a thousandth of an arcsecond.
            let digits = if self.message == Message::Orbit && index < 3 { 6 } else { 9 };
            line += &format!(" {value:.digits$}");
        }
        self.keep(&line);
        self.keep("\n");
        if let Some((_, last_us)) = &mut self.segment {
            *last_us = instant_us;
        }
        let due = self.covariance_us.is_none_or(|last_us| instant_us - last_us >= COVARIANCE_EVERY_US);
        if let Some(covariance) = covariance.filter(|_| due) {
            self.covariance_us = Some(instant_us);
            self.covariances += &format!("EPOCH = {}\nCOV_REF_FRAME = ICRF\n", shown_text(instant_us));
            for (row, elements) in covariance.iter().enumerate() {
                let row: Vec<String> =
                    elements[..=row].iter().map(|element| format!("{element:.9e}")).collect();
                self.covariances += &format!("{}\n", row.join(" "));
            }
        }
        Ok(())
    }

    /// Metadata, up to the first line of data.
    fn begin_segment(&mut self, first_us: i64) {
        let frames = match self.message {
            Message::Orbit => "REF_FRAME = ICRF\n",
            Message::Attitude => "REF_FRAME_A = ICRF\nREF_FRAME_B = SENSOR_1\nATTITUDE_DIR = A2B\n",
        };
        let head = format!(
            "\nMETA_START\nOBJECT_NAME = {}\nOBJECT_ID = UNKNOWN\nCENTER_NAME = {}\n{frames}TIME_SYSTEM = TT\n\
             START_TIME = {}\nSTOP_TIME = ",
            self.name.object,
            self.name.centre.name().to_uppercase(),
            shown_text(first_us)
        );
        self.keep(&head);
        self.segment = Some((self.file.length(), first_us));
        self.keep(&shown_text(self.name.end_us.max(first_us)));
        self.keep(match self.message {
            Message::Orbit => "\nMETA_STOP\n",
            Message::Attitude => {
                "\nATTITUDE_TYPE = QUATERNION\nQUATERNION_TYPE = LAST\nMETA_STOP\n\
                 COMMENT SENSOR_1 is the star path: x along the columns, y along the rows, z along the line of sight\n\
                 DATA_START\n"
            }
        });
    }

    /// The covariances behind the data, and the true `STOP_TIME`.
    fn end_segment(&mut self) -> Result<(), HostError> {
        let Some((place, last_us)) = self.segment.take() else { return Ok(()) };
        if self.message == Message::Attitude {
            self.keep("DATA_STOP\n");
        }
        if !self.covariances.is_empty() {
            let block = format!("COVARIANCE_START\n{}COVARIANCE_STOP\n", self.covariances);
            self.keep(&block);
            self.covariances.clear();
        }
        self.covariance_us = None;
        self.file.overwrite(place, shown_text(last_us).as_bytes())
    }

    fn keep(&mut self, text: &str) {
        self.file.keep(text.as_bytes());
    }

    /// Hands whole lines over to the system.
    ///
    /// # Errors
    /// When it refuses.
    pub fn flush(&mut self) -> Result<(), HostError> {
        self.file.flush()
    }

    /// Ends the message and gives the file its name.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn finish(mut self) -> Result<(), HostError> {
        self.end_segment()?;
        self.file.finish()
    }
}

#[cfg(test)]
mod tests;
