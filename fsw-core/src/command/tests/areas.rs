//! Files of the areas on their way up, packet by packet.

use super::*;
use crate::catalog::sample as catalogue;
use crate::command::area_check::SLICE_BYTES;
use crate::image::{calibration, defects};
use crate::oracle::Generator;
use fsw_hal::AreaError;

/// Bytes of an area's memory, and of a word of it.
const ROOM: usize = 40_000;
const WORD: usize = 8;

/// Memory that says what it was marked with; that of the calibration has no room where it is told so.
#[derive(Clone, Debug, Default)]
struct Memory {
    copies: [Vec<u8>; 3],
    marked: Vec<(Area, usize, u32)>,
    without_calibration: bool,
    fails: bool,
}

impl fsw_hal::ErrorType for Memory {
    type Error = AreaError;
}

impl AreaStore for Memory {
    fn room(&self, area: Area) -> usize {
        if area == Area::Calibration && self.without_calibration { 0 } else { ROOM }
    }

    fn write(&mut self, area: Area, offset: usize, part: &[u8]) -> Result<(), AreaError> {
        if self.fails {
            return Err(AreaError::Timeout);
        }
        if !offset.is_multiple_of(WORD) {
            return Err(AreaError::Alignment);
        }
        self.copies[area as usize].truncate(offset);
        assert_eq!(self.copies[area as usize].len(), offset, "a part does not follow the one before");
        self.copies[area as usize].extend_from_slice(part);
        Ok(())
    }

    fn written(&self, area: Area, length: usize) -> Result<&[u8], AreaError> {
        if self.fails { Err(AreaError::Bus) } else { Ok(&self.copies[area as usize][..length]) }
    }

    fn mark_whole(&mut self, area: Area, length: usize, crc: u32) -> Result<(), AreaError> {
        self.marked.push((area, length, crc));
        Ok(())
    }
}

/// The ground, the link and its memory.
struct Flight {
    link: CommandLink<Memory>,
    sequence: u16,
    parameters: Parameters,
}

impl Flight {
    fn new() -> Self {
        let mut parameters = parameters();
        parameters.camera.optical_centre_px = calibration::sample::CENTRE_PX;
        Self { link: CommandLink::with_areas(APID, None, 0, Memory::default()), sequence: 0, parameters }
    }

    /// Sends a command and gives the reason of its refusal.
    fn send(&mut self, telecommand: &Telecommand) -> Option<Refusal> {
        self.sequence += 1;
        refusal(&mut self.link, &packet(telecommand, self.sequence, None))
    }

    /// Lets a second go by; service, subservice and reason of its reports.
    fn second(&mut self) -> Vec<(u8, u8, u16)> {
        self.link.conclude(None);
        self.link.check_area(&self.parameters);
        let reason = |data: &[u8]| data.get(4..6).map_or(0, |code| u16::from_be_bytes([code[0], code[1]]));
        let told = reports(&mut self.link);
        told.iter().map(|report| (parts(report).0, reason(parts(report).1))).map(flat).collect()
    }

    /// Sends the parts of a file.
    fn parts(&mut self, area: Area, file: &[u8]) {
        for telecommand in ground::upload(Some(area), file, MAX_PART_BYTES) {
            if matches!(telecommand, Telecommand::Part { .. }) {
                assert_eq!(self.send(&telecommand), None);
                assert_eq!(self.second(), [(1, 1, 0), (1, 7, 0)]);
            }
        }
    }

    /// Sends a whole file up and loads it; the seconds of its check, and what it came to.
    fn load(&mut self, area: Area, file: &[u8]) -> (usize, Result<(), Refusal>) {
        self.parts(area, file);
        let load = Telecommand::Load { area: Some(area), length: file.len() as u32, crc: crc32(file) };
        assert_eq!(self.send(&load), None);
        self.checked()
    }

    fn checked(&mut self) -> (usize, Result<(), Refusal>) {
        let mut told = Vec::new();
        for seconds in 1..100 {
            told.extend(self.second());
            if let [(1, 1, 0), (1, verdict, reason)] = told[..] {
                let refused = refusal::ALL.iter().find(|known| known.code() == reason);
                assert_eq!(verdict, if refused.is_some() { 8 } else { 7 });
                return (seconds, refused.map_or(Ok(()), |reason| Err(*reason)));
            }
            assert!(told.len() < 2, "{told:?}");
        }
        panic!("the check has no end");
    }

    fn marked(&self) -> &[(Area, usize, u32)] {
        &self.link.store.marked
    }
}

fn flat(((service, subservice), reason): ((u8, u8), u16)) -> (u8, u8, u16) {
    (service, subservice, reason)
}

fn catalogue_file() -> Vec<u8> {
    catalogue::bytes(&catalogue::sky(&mut Generator::new(5), 600), 20, 1 << 28)
}

fn calibration_file() -> Vec<u8> {
    calibration::sample::gaussian(0.6)
}

fn defects_file() -> Vec<u8> {
    defects::sample::bytes([1280, 1024], &[[3, 4], [1279, 1023]], &[(7, -5)])
}

const AREAS: [Area; 3] = [Area::Catalogue, Area::Calibration, Area::BadPixels];

fn files() -> [(Area, Vec<u8>); 3] {
    let [a, b, c] = AREAS;
    [(a, catalogue_file()), (b, calibration_file()), (c, defects_file())]
}

#[test]
fn a_file_of_every_area_is_marked_whole_once_all_of_it_was_checked_a_slice_a_second() {
    let mut flight = Flight::new();
    let mut marked = Vec::new();
    for (area, file) in files() {
        let (seconds, outcome) = flight.load(area, &file);
        assert_eq!((seconds, outcome), (file.len().div_ceil(SLICE_BYTES) + 1, Ok(())), "{area:?}");
        marked.push((area, file.len(), crc32(&file)));
        assert_eq!(flight.marked(), marked);
        assert_eq!(flight.link.store.copies[area as usize], file);
    }
    assert!(files().iter().any(|(_, file)| file.len() > 2 * SLICE_BYTES));
}

#[test]
fn what_the_memory_does_not_hold_as_it_was_sent_is_refused_by_its_crc() {
    for (area, file) in files() {
        for place in [0, 3, file.len() / 2, file.len() - 1] {
            let mut flight = Flight::new();
            flight.parts(area, &file);
            flight.link.store.copies[area as usize][place] ^= 4;
            let load = Telecommand::Load { area: Some(area), length: file.len() as u32, crc: crc32(&file) };
            assert_eq!(flight.send(&load), None);
            assert_eq!(flight.checked().1, Err(Refusal::AreaChecksum), "{area:?} {place}");
            assert!(flight.marked().is_empty());
            // Nothing goes on where it was refused; sent anew it is taken.
            assert_eq!(flight.send(&load), Some(Refusal::Incomplete));
            assert_eq!(flight.load(area, &file).1, Ok(()));
        }
    }
}

#[test]
fn what_does_not_open_as_what_the_area_holds_is_refused_under_a_right_crc() {
    let mut flight = Flight::new();
    for (area, file) in files() {
        let damaged = |place: usize| {
            let mut damaged = file.clone();
            damaged[place] ^= 1;
            damaged
        };
        let mut counts = damaged(20);
        defects::sample::seal(&mut counts);
        // Magic, version, checksum within, a count under a right checksum, an end too early, too late.
        let wrong = [damaged(0), damaged(4), damaged(30), file[..file.len() - 8].to_vec(), {
            [&file[..], &[0; 8]].concat()
        }];
        for wrong in wrong.iter().chain((area == Area::BadPixels).then_some(&counts)) {
            assert_eq!(flight.load(area, wrong).1, Err(Refusal::AreaContent), "{area:?}");
        }
        for other in AREAS.into_iter().filter(|other| *other != area) {
            assert_eq!(flight.load(other, &file).1, Err(Refusal::AreaContent));
        }
    }
    assert!(flight.marked().is_empty());
}

#[test]
fn files_of_another_detector_or_optical_centre_are_refused() {
    let mut flight = Flight::new();
    let outside = defects::sample::bytes([1024, 1024], &[[3, 4]], &[]);
    assert_eq!(flight.load(Area::BadPixels, &outside).1, Err(Refusal::AreaDetector));
    flight.parameters.camera.optical_centre_px[1] += calibration::CENTRE_PX;
    assert_eq!(flight.load(Area::Calibration, &calibration_file()).1, Ok(()));
    flight.parameters.camera.optical_centre_px[1] += 0.01;
    assert_eq!(flight.load(Area::Calibration, &calibration_file()).1, Err(Refusal::AreaDetector));
    flight.parameters.camera.width_px -= 1;
    for (area, file) in [(Area::Calibration, calibration_file()), (Area::BadPixels, defects_file())] {
        assert_eq!(flight.load(area, &file).1, Err(Refusal::AreaDetector));
    }
    assert_eq!(flight.marked().len(), 1);
}

#[test]
fn parts_that_do_not_follow_or_do_not_fit_are_refused_and_those_before_stay() {
    let mut flight = Flight::new();
    let file = defects_file();
    let area = Some(Area::BadPixels);
    flight.parts(Area::BadPixels, &file[..400]);
    let part = |area, offset, bytes| Telecommand::Part { area, offset, bytes };
    for (wrong, reason) in [
        // A gap, one sent twice, of another area, of the table, of none, beyond all.
        (part(area, 408, &file[408..500]), Refusal::Part),
        (part(area, 200, &file[200..400]), Refusal::Part),
        (part(Some(Area::Catalogue), 400, &[1]), Refusal::Part),
        (part(None, 400, &[1]), Refusal::Part),
        (part(area, 400, &[]), Refusal::Part),
        (part(area, u32::MAX, &[1; 8]), Refusal::Part),
        (Telecommand::Load { area, length: 401, crc: 0 }, Refusal::Incomplete),
        (Telecommand::Load { area: Some(Area::Catalogue), length: 400, crc: 0 }, Refusal::Incomplete),
        (Telecommand::Load { area: None, length: 400, crc: 0 }, Refusal::Incomplete),
    ] {
        assert_eq!(flight.send(&wrong), Some(reason), "{wrong:?}");
    }
    assert_eq!(flight.send(&part(area, 400, &file[400..403])), None);
    flight.second();
    // The memory's words have eight bytes: what follows three of them is begun anew.
    assert_eq!(flight.send(&part(area, 403, &file[403..500])), Some(Refusal::Part));
    assert_eq!(flight.load(Area::BadPixels, &file).1, Ok(()));
    // To the last byte of its room, and one more.
    flight.parts(Area::Catalogue, &[0; ROOM]);
    assert_eq!(flight.send(&part(Some(Area::Catalogue), ROOM as u32, &[0])), Some(Refusal::Part));
}

#[test]
fn where_there_is_no_such_memory_parts_and_load_are_refused() {
    let load = |area| Telecommand::Load { area: Some(area), length: 0, crc: 0 };
    let part = |area| Telecommand::Part { area: Some(area), offset: 0, bytes: &[1] };
    for (sequence, area) in (1..).step_by(2).zip(AREAS) {
        let mut link = open_link();
        for (count, telecommand) in (sequence..).zip([part(area), load(area)]) {
            assert_eq!(refusal(&mut link, &packet(&telecommand, count, None)), Some(Refusal::Area));
        }
    }
    let mut flight = Flight::new();
    flight.link.store.without_calibration = true;
    assert_eq!(flight.send(&part(Area::Calibration)), Some(Refusal::Area));
    assert_eq!(flight.send(&part(Area::Catalogue)), None);
}

#[test]
fn a_memory_that_fails_is_told_and_the_file_begins_anew() {
    let (mut flight, file) = (Flight::new(), defects_file());
    let area = Some(Area::BadPixels);
    flight.parts(Area::BadPixels, &file[..400]);
    let next = Telecommand::Part { area, offset: 400, bytes: &file[400..600] };
    flight.link.store.fails = true;
    assert_eq!(flight.send(&next), Some(Refusal::Memory));
    flight.link.store.fails = false;
    assert_eq!(flight.send(&next), Some(Refusal::Part));
    flight.parts(Area::BadPixels, &file);
    assert_eq!(flight.send(&Telecommand::Load { area, length: file.len() as u32, crc: crc32(&file) }), None);
    flight.link.store.fails = true;
    assert_eq!(flight.checked().1, Err(Refusal::Memory));
    assert!(flight.marked().is_empty());
}

#[test]
fn while_a_file_is_checked_uploads_wait_and_every_other_command_goes_on() {
    let (mut flight, file) = (Flight::new(), catalogue_file());
    let area = Some(Area::Catalogue);
    flight.parts(Area::Catalogue, &file);
    let load = Telecommand::Load { area, length: file.len() as u32, crc: crc32(&file) };
    assert_eq!(flight.send(&load), None);
    for waits in [
        Telecommand::Part { area: None, offset: 0, bytes: &[1] },
        Telecommand::Part { area, offset: 0, bytes: &[1] },
        load,
    ] {
        flight.second();
        assert_eq!(flight.send(&waits), Some(Refusal::Busy));
    }
    assert_eq!(flight.send(&Telecommand::Safe), None);
    assert_eq!(flight.link.command(), Command::Safe);
    flight.link.conclude(Some(CommandOutcome::Done));
    let told: Vec<_> = (0..100).flat_map(|_| flight.second()).collect();
    assert_eq!(told, [(1, 1, 0), (1, 7, 0), (1, 7, 0)]);
    assert_eq!(flight.marked(), [(Area::Catalogue, file.len(), crc32(&file))]);
}
