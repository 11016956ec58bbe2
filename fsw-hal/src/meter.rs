//! Marks between which the stages of a second are measured, and the second itself is watched.
//!
//! The sensor says when a stage begins and ends; what is done with it (a cycle counter, a trace pin, an
//! outside meter that watches two addresses, or nothing: `()`) is the platform's. A watchdog is served at
//! these marks: between two of them lies one stage, so that one that hangs is found out, and no second
//! without an end.

/// A stage of a second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Stage {
    /// Acquisition: reading and searching the whole detector for stars.
    Scan = 0,
    /// Acquisition: identification.
    Identify = 1,
    /// Predicted stars, what the Earth hides of them, and the windows about them.
    Predict = 2,
    /// Reading and searching the stars' windows.
    Windows = 3,
    /// Matching and attitude.
    Confirm = 4,
    /// Predicted limb, reading strips across it, and the limb points in them; of an Earth path without its
    /// filter the stars, predicted, read and matched.
    Limb = 5,
    /// The Earth's centre from limb points.
    Centre = 6,
    /// Propagation and filter of the orbit.
    Orbit = 7,
    /// Searching the whole detector for the limb, and reading strips across what was found.
    Search = 8,
    /// Acquisition: searching the whole detector for the lines that stars draw while the sensor turns.
    Streaks = 9,
    /// Exposing, and reading the probes by which an old image is known again.
    Image = 10,
}

/// Receives the marks.
pub trait StageMeter {
    /// `stage` begins.
    fn begin(&mut self, stage: Stage);
    /// `stage` ends.
    fn end(&mut self, stage: Stage);
    /// Whether the last second took longer than it may, by the platform's own timer; asked once as the next
    /// one begins, which tells it as an event.
    fn overran(&mut self) -> bool {
        false
    }
}

/// No measurement.
impl StageMeter for () {
    fn begin(&mut self, _: Stage) {}
    fn end(&mut self, _: Stage) {}
}
