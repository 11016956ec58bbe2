//! The link: what arrives, what is to be done, what is reported.
//!
//! A packet is checked in this order: length, APID, checksum, headers, tag and counter, sequence count,
//! version of the list, command and fields, and whether there is room for it. Of the first check that fails
//! its [`Refusal`] is reported. Counter and sequence count move with every packet that is authentic and newer
//! than the last, so that a refused one cannot be sent again either.
//!
//! One command is done in a second. Parts, the file of an area and what is sent down (the table, the log of
//! events, the spots) are the link's own affair and need none.
//!
//! | once | call |
//! |---|---|
//! | a packet | [`CommandLink::receive`] |
//! | a second | [`CommandLink::command`], the cycle with it, [`CommandLink::conclude`] |
//! | a second | [`CommandLink::log`] |
//! | a second, where there is memory of areas | [`CommandLink::check_area`] |
//! | a second | [`CommandLink::next_report`] until it gives none |

use super::area_check::AreaCheck;
use super::authentication::{Key, TAG_BYTES, TRAILER_BYTES};
use super::event_log::EventLog;
use super::packets::{self, MAX_DATA_BYTES, MAX_REPORT_BYTES, ReportHeaders, RequestId, TelecommandPacket};
use super::refusal::Refusal;
use super::spot_list;
use super::telecommand::{
    EVENTS_DOWN, MAX_PART_BYTES, PART_DOWN, REQUESTS, SPOTS_DOWN, TABLE, Telecommand, VERSION,
};
use super::upload::Upload;
use super::{Command, CommandOutcome, Downlink};
use crate::parameters::{MAX_TABLE_BYTES, Parameters};
use fsw_hal::{AreaStore, LocalTime};
use heapless::{Deque, Vec};
use serde::Serialize;

/// Reports that wait to be sent.
const MAX_REPORTS: usize = 16;
/// Places kept free among them: for the completion of the command of the second, of what is sent down and of
/// the check of an area.
const KEPT_FREE: usize = 3;
/// Service of the reports about requests.
const VERIFICATION: u8 = 1;
/// Sequence counts have 14 bits; the half of them that follows the last one is newer.
const SEQUENCE_MASK: u16 = 0x3FFF;
const NEWER: u16 = 0x1FFF;

/// A packet that was accepted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accepted<'a> {
    /// By which reports name it.
    pub request: RequestId,
    /// What it says.
    pub telecommand: Telecommand<'a>,
}

/// A packet that was refused; nothing changed but, for an authentic one, counter and sequence count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused {
    /// By which reports name it; `None` where the packet has less than four bytes.
    pub request: Option<RequestId>,
    /// Why.
    pub reason: Refusal,
}

/// What a report about a request says.
#[derive(Clone, Copy, Debug)]
enum Verdict {
    Accepted,
    NotAccepted(Refusal),
    Done,
    NotDone(Refusal),
}

impl Verdict {
    /// Its subservice, the place of its counter, and the reason.
    fn parts(self) -> (u8, usize, Option<Refusal>) {
        match self {
            Self::Accepted => (1, 0, None),
            Self::NotAccepted(reason) => (2, 1, Some(reason)),
            Self::Done => (7, 2, None),
            Self::NotDone(reason) => (8, 3, Some(reason)),
        }
    }
}

/// Kinds of reports: the four verdicts, the part of the table, that of the log and that of the spots.
const KINDS: usize = 7;
/// The counters of the last three.
const PART_COUNTER: usize = 4;
const EVENTS_COUNTER: usize = 5;
const SPOTS_COUNTER: usize = 6;

/// What a request is, once it was accepted.
#[derive(Clone, Copy, Debug)]
struct Request {
    id: RequestId,
    /// Whether its completion is to be reported.
    completion: bool,
}

/// What is to be done in the next second.
#[derive(Clone, Copy, Debug)]
enum Task {
    /// This command, which borrows nothing.
    Do(Command<'static>),
    /// Load the table that was uploaded.
    Load,
}

/// What is sent down in parts, and where the next one begins.
#[derive(Clone, Copy, Debug)]
enum Sending {
    /// The parameter table, from a byte on.
    Table(u16),
    /// The log of events, from the event of a number on.
    Events(u32),
    /// The spots, from the spot of a place on.
    Spots(u16),
}

/// The command link of a sensor; `S` is the memory of the areas, `()` where there is none.
#[derive(Clone, Debug)]
pub struct CommandLink<S = ()> {
    apid: u16,
    key: Option<Key>,
    counter: u32,
    sequence: Option<u16>,
    /// The table or file on its way up.
    pub(super) upload: Upload,
    /// The memory of the areas.
    pub(super) store: S,
    /// The file of an area that is checked, and for whom.
    check: Option<(Request, AreaCheck)>,
    /// What waits for its second.
    task: Option<(Request, Task)>,
    /// What is sent down, and for whom.
    sending: Option<(Request, Sending)>,
    events: EventLog,
    reports: Deque<(RequestId, Verdict), MAX_REPORTS>,
    /// Reports sent, all and of each kind.
    sent: u16,
    sent_of: [u16; KINDS],
}

impl CommandLink {
    /// The link for packets of this APID (its low 11 bits). With a key every packet must carry a tag, and a
    /// counter greater than `counter`: that of the last one, as it was stored; else 0.
    pub const fn new(apid: u16, key: Option<Key>, counter: u32) -> Self {
        Self::with_areas(apid, key, counter, ())
    }
}

impl<S: AreaStore> CommandLink<S> {
    /// The same, which takes files of areas up into `store`.
    pub const fn with_areas(apid: u16, key: Option<Key>, counter: u32, store: S) -> Self {
        Self {
            apid: apid & 0x07FF,
            key,
            counter,
            sequence: None,
            upload: Upload::new(),
            store,
            check: None,
            task: None,
            sending: None,
            events: EventLog::new(),
            reports: Deque::new(),
            sent: 0,
            sent_of: [0; KINDS],
        }
    }

    /// Counter of the last authentic packet. It is to be stored before its command is done: a link that is
    /// made with an older one takes packets again that it has had.
    pub fn counter(&self) -> u32 {
        self.counter
    }

    /// Takes the bytes of one packet.
    ///
    /// # Errors
    /// The first check that fails.
    pub fn receive<'a>(&mut self, bytes: &'a [u8]) -> Result<Accepted<'a>, Refused> {
        let request = RequestId::of(bytes);
        let checked = packets::read(bytes, self.apid).and_then(|packet| {
            let telecommand = self.read(&packet)?;
            Ok((packet.acknowledge, telecommand))
        });
        match (request, checked) {
            (Some(request), Ok(([acceptance, completion], telecommand))) => {
                if acceptance {
                    self.note(request, Verdict::Accepted);
                }
                self.take(Request { id: request, completion }, &telecommand);
                Ok(Accepted { request, telecommand })
            }
            (request, checked) => {
                let reason = checked.err().unwrap_or(Refusal::Length);
                if let Some(request) = request.filter(|_| reason != Refusal::Apid && self.room() > KEPT_FREE)
                {
                    self.note(request, Verdict::NotAccepted(reason));
                }
                Err(Refused { request, reason })
            }
        }
    }

    /// Checks what a packet says, all but its headers; an uploaded part is taken in.
    fn read<'a>(&mut self, packet: &TelecommandPacket<'a>) -> Result<Telecommand<'a>, Refusal> {
        let data = self.authenticate(packet)?;
        let newer = |last: u16| (1..=NEWER).contains(&(packet.sequence.wrapping_sub(last) & SEQUENCE_MASK));
        if !self.sequence.is_none_or(newer) {
            return Err(Refusal::Sequence);
        }
        self.sequence = Some(packet.sequence);
        let (version, fields) = data.split_first().ok_or(Refusal::Fields)?;
        if *version != VERSION {
            return Err(Refusal::Version);
        }
        let telecommand = Telecommand::decode(packet.number, fields)?;
        if self.task.is_some() || self.sending.is_some() || self.room() < KEPT_FREE + 2 {
            return Err(Refusal::Busy);
        }
        match telecommand {
            // What is checked must not change.
            Telecommand::Part { .. } | Telecommand::Load { .. } if self.check.is_some() => {
                return Err(Refusal::Busy);
            }
            Telecommand::Part { area, offset, bytes } => {
                self.upload.add((area, offset), bytes, &mut self.store)?;
            }
            Telecommand::Load { area, length, crc } => {
                self.upload.check(area, (length, crc), &self.store)?;
            }
            _ => {}
        }
        Ok(telecommand)
    }

    /// The data without counter and tag, where these are right or no key is set.
    fn authenticate<'a>(&mut self, packet: &TelecommandPacket<'a>) -> Result<&'a [u8], Refusal> {
        let Some(key) = &self.key else { return Ok(packet.data) };
        let (message, tag) = packet.content.split_last_chunk::<TAG_BYTES>().ok_or(Refusal::Tag)?;
        let data = packet.data.len().checked_sub(TRAILER_BYTES).and_then(|length| packet.data.get(..length));
        let (data, counter) = data.zip(message.last_chunk()).ok_or(Refusal::Tag)?;
        if !key.verifies(message, tag) {
            return Err(Refusal::Tag);
        }
        let counter = u32::from_be_bytes(*counter);
        if counter <= self.counter {
            return Err(Refusal::Counter);
        }
        self.counter = counter;
        Ok(data)
    }

    /// Lets an accepted command wait for its second, or does what the link does itself.
    fn take(&mut self, request: Request, telecommand: &Telecommand) {
        let task = match *telecommand {
            Telecommand::Reacquire => Task::Do(Command::Reacquire),
            Telecommand::Restart => Task::Do(Command::Restart),
            Telecommand::Safe => Task::Do(Command::Safe),
            Telecommand::Exposure(exposure_us) => Task::Do(Command::Exposure(exposure_us)),
            Telecommand::Orbit(orbit) => Task::Do(Command::Orbit(orbit)),
            Telecommand::Time(correlation) => Task::Do(Command::Time(correlation)),
            Telecommand::Shutter(paths) => Task::Do(Command::Shutter(paths)),
            Telecommand::Load { area: None, .. } => Task::Load,
            Telecommand::Load { area: Some(area), length, crc } => {
                self.check = Some((request, AreaCheck::new(area, length, crc)));
                // Nothing is written behind what is checked, nor is it checked again.
                self.upload.forget();
                return;
            }
            Telecommand::Part { .. } => return self.complete(request, CommandOutcome::Done),
            Telecommand::Dump => return self.send_down(request, Sending::Table(0)),
            Telecommand::Events => return self.send_down(request, Sending::Events(0)),
            Telecommand::Spots => return self.send_down(request, Sending::Spots(0)),
        };
        self.task = Some((request, task));
    }

    fn send_down(&mut self, request: Request, sending: Sending) {
        self.sending = Some((request, sending));
    }

    /// The command of the next second.
    pub fn command(&self) -> Command<'_> {
        match self.task {
            None => Command::Continue,
            Some((_, Task::Do(command))) => command,
            Some((_, Task::Load)) => Command::LoadParameters(self.upload.table()),
        }
    }

    /// Takes what came of the command in the second that was flown with it
    /// ([`Report::command`](crate::telemetry::Report::command)).
    pub fn conclude(&mut self, outcome: Option<CommandOutcome>) {
        if let Some(outcome) = outcome
            && let Some((request, _)) = self.task.take()
        {
            self.complete(request, outcome);
        }
    }

    /// Notes the events of a second for the log ([`Report::cycle`](crate::telemetry::Report::cycle),
    /// [`Report::events`](crate::telemetry::Report::events)).
    pub fn log(&mut self, cycle: u32, events: &[impl Serialize]) {
        self.events.note(cycle, events);
    }

    /// Goes on with the check of an area's file by a second's share; `parameters` are those in force, whose
    /// detector the file must be of.
    pub fn check_area(&mut self, parameters: &Parameters) {
        let outcome =
            self.check.as_mut().and_then(|(_, check)| check.step(&mut self.store, &parameters.camera));
        if let Some(outcome) = outcome
            && let Some((request, _)) = self.check.take()
        {
            self.complete(request, outcome);
        }
    }

    fn complete(&mut self, request: Request, outcome: CommandOutcome) {
        match outcome {
            CommandOutcome::Done if !request.completion => {}
            CommandOutcome::Done => self.note(request.id, Verdict::Done),
            CommandOutcome::Refused(reason) => self.note(request.id, Verdict::NotDone(reason)),
        }
    }

    /// Room for reports.
    fn room(&self) -> usize {
        MAX_REPORTS.saturating_sub(self.reports.len())
    }

    fn note(&mut self, request: RequestId, verdict: Verdict) {
        // There is room: nothing is accepted, and no refusal noted, without.
        let _ = self.reports.push_back((request, verdict));
    }

    /// Writes the next report, as of `now`, and gives the bytes used; `None` where none waits. `told` is what
    /// the ground may ask for.
    pub fn next_report<'a>(
        &mut self,
        now: LocalTime,
        told: &Downlink,
        buffer: &'a mut [u8; MAX_REPORT_BYTES],
    ) -> Option<&'a [u8]> {
        let mut data = Vec::<u8, MAX_DATA_BYTES>::new();
        let (number, counter) = match self.reports.pop_front() {
            Some((request, verdict)) => {
                let (subservice, counter, reason) = verdict.parts();
                data.extend_from_slice(&request.0).ok()?;
                if let Some(reason) = reason {
                    data.extend_from_slice(&reason.code().to_be_bytes()).ok()?;
                }
                ((VERIFICATION, subservice), counter)
            }
            None => {
                let (request, sending) = self.sending.take()?;
                let (next, kind) = match sending {
                    Sending::Table(offset) => {
                        let next = table_part(offset, told.parameters, &mut data)?.map(Sending::Table);
                        (next, ((TABLE, PART_DOWN), PART_COUNTER))
                    }
                    Sending::Events(from) => {
                        let next = self.events.write(from, &mut data)?.map(Sending::Events);
                        (next, ((REQUESTS, EVENTS_DOWN), EVENTS_COUNTER))
                    }
                    Sending::Spots(from) => {
                        let next = spot_list::write(told, from, &mut data)?.map(Sending::Spots);
                        (next, ((REQUESTS, SPOTS_DOWN), SPOTS_COUNTER))
                    }
                };
                match next {
                    None => self.complete(request, CommandOutcome::Done),
                    Some(next) => self.sending = Some((request, next)),
                }
                kind
            }
        };
        let count = self.sent_of.get_mut(counter)?;
        let sequence = self.sent & SEQUENCE_MASK;
        let headers = ReportHeaders { apid: self.apid, sequence, number, count: *count, now };
        *count = count.wrapping_add(1);
        self.sent = self.sent.wrapping_add(1);
        packets::write(&headers, &data, buffer)
    }
}

/// Writes a part of the table that is sent down: offset, length of the table, bytes. Where the next one
/// begins; no such place after the last one. `None` where there is nothing to send.
#[inline(never)]
fn table_part(
    offset: u16,
    parameters: &Parameters,
    data: &mut Vec<u8, MAX_DATA_BYTES>,
) -> Option<Option<u16>> {
    let mut buffer = [0; MAX_TABLE_BYTES];
    let table = parameters.encode(&mut buffer).ok()?;
    let rest = table.get(usize::from(offset)..)?;
    let part = rest.get(..rest.len().min(MAX_PART_BYTES))?;
    data.extend_from_slice(&offset.to_be_bytes()).ok()?;
    data.extend_from_slice(&u16::try_from(table.len()).ok()?.to_be_bytes()).ok()?;
    data.extend_from_slice(part).ok()?;
    let end = offset.checked_add(u16::try_from(part.len()).ok()?)?;
    Some((part.len() < rest.len()).then_some(end))
}
