//! Marks between which the stages of a second are measured.
//!
//! The sensor says when a stage begins and ends; what is done with it (a cycle counter, a trace pin, an outside meter
//! that watches two addresses, or nothing: `()`) is the platform's.

/// A stage of a second, in the order in which they are run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Stage {
    /// Acquisition: reading and searching the whole detector.
    Scan = 0,
    /// Acquisition: identification.
    Identify = 1,
    /// Tracking: predicted stars and their windows.
    Predict = 2,
    /// Tracking: reading and searching the windows.
    Windows = 3,
    /// Tracking: matching and attitude.
    Confirm = 4,
}

/// Receives the marks.
pub trait StageMeter {
    /// `stage` begins.
    fn begin(&mut self, stage: Stage);
    /// `stage` ends.
    fn end(&mut self, stage: Stage);
}

/// No measurement.
impl StageMeter for () {
    fn begin(&mut self, _: Stage) {}
    fn end(&mut self, _: Stage) {}
}
