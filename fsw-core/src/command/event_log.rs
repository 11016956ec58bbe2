//! The log of events: the last [`MAX_LOGGED`], for a ground that has missed the frames of their seconds.
//!
//! In: the events of every second. Out: the data of the reports in which the log is sent down.
//!
//! | data of a report | |
//! |---|---|
//! | number of its first event, counted from the start of the link | u32 |
//! | events that the log holds from that one on | u16 |
//! | events, [`LOGGED_BYTES`] each, as many as there is room for | |
//!
//! An event is its second ([`Report::cycle`](crate::telemetry::Report::cycle), u32) and its three bytes as in
//! a frame: its code, and of [`Event::Mode`](crate::telemetry::Event::Mode) the codes of mode and guard
//! behind it, else zeros. All numbers are big-endian.
//!
//! RAM: 8 bytes an event.

use super::packets::{self, MAX_DATA_BYTES};
use heapless::{Deque, Vec};
use serde::Serialize;

/// Events that are kept.
pub const MAX_LOGGED: usize = 64;
/// Bytes of an event in a report: its second and itself.
pub const LOGGED_BYTES: usize = 4 + EVENT_BYTES;
/// Longest event in a frame.
const EVENT_BYTES: usize = 3;

/// An event and its second.
#[derive(Clone, Copy, Debug)]
struct Logged {
    cycle: u32,
    event: [u8; EVENT_BYTES],
}

impl Logged {
    /// As it is sent down.
    fn bytes(&self) -> [u8; LOGGED_BYTES] {
        let mut bytes = [0; LOGGED_BYTES];
        let parts = self.cycle.to_be_bytes().into_iter().chain(self.event);
        bytes.iter_mut().zip(parts).for_each(|(byte, part)| *byte = part);
        bytes
    }
}

/// The log.
#[derive(Clone, Debug)]
pub(super) struct EventLog {
    logged: Deque<Logged, MAX_LOGGED>,
    /// Events that are no longer kept.
    dropped: u32,
}

impl EventLog {
    /// An empty log.
    pub(super) const fn new() -> Self {
        Self { logged: Deque::new(), dropped: 0 }
    }

    /// Notes the events of a second; the oldest make room.
    pub(super) fn note(&mut self, cycle: u32, events: &[impl Serialize]) {
        for event in events {
            let logged = Logged { cycle, event: bytes_of(event) };
            if self.logged.is_full() && self.logged.pop_front().is_some() {
                self.dropped = self.dropped.wrapping_add(1);
            }
            // There is room now.
            let _ = self.logged.push_back(logged);
        }
    }

    /// Writes the events from number `from` on, the oldest where that is no longer kept: the number of the
    /// next one; no such number after the last one. `None` where there is no room for the data.
    pub(super) fn write(&self, from: u32, data: &mut Vec<u8, MAX_DATA_BYTES>) -> Option<Option<u32>> {
        let kept = self.logged.len();
        let passed = usize::try_from(from.saturating_sub(self.dropped)).unwrap_or(kept).min(kept);
        let (first, left) = (self.dropped.wrapping_add(passed as u32), kept - passed);
        data.extend_from_slice(&first.to_be_bytes()).ok()?;
        data.extend_from_slice(&(left as u16).to_be_bytes()).ok()?;
        let written = packets::append_whole(self.logged.iter().skip(passed).map(Logged::bytes), data);
        Some((written < left).then_some(first.wrapping_add(written as u32)))
    }
}

/// An event as it stands in a frame, zeros behind it.
fn bytes_of(event: &impl Serialize) -> [u8; EVENT_BYTES] {
    let mut bytes = [0; EVENT_BYTES];
    // No event is longer.
    let _ = postcard::to_slice(event, &mut bytes);
    bytes
}
