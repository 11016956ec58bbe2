//! Files of catalogue, calibration and bad pixels sent up by telecommand: from the bytes of the packets to
//! the flight after the next start.

use fsw_core::catalog::Catalogue;
use fsw_core::checksum::crc32;
use fsw_core::command::ground::{self, Envelope};
use fsw_core::command::{
    CommandLink, Downlink, Key, MAX_PART_BYTES, MAX_REPORT_BYTES, MAX_TELECOMMAND_BYTES, Refusal, Telecommand,
};
use fsw_core::image::bad_pixels::BadPixelDetector;
use fsw_core::image::calibration::Calibration;
use fsw_core::image::defects::Defects;
use fsw_core::parameters::Parameters;
use fsw_core::sensor::{Command, Workspace};
use fsw_core::telemetry::Report;
use fsw_hal::{Area, Detector, DetectorError, DetectorGeometry, LocalTime, Window};
use sil_host::calibration::with_gain;
use sil_host::commands::record::mission::{Clip, Flight, MISSION};
use sil_host::commands::record::{Instrument, record_flight};
use sil_host::flight;
use sil_host::formats::defects_file;
use sil_host::formats::frames_file::Recording;
use sil_host::harness::areas::{ROOM_BYTES, RamAreas};
use std::collections::BTreeSet;
use system_tests::scratch;

const APID: u16 = 0x2A5;
const KEY: Key = Key::new([0x5E; 16]);
/// Seconds of the flight: the check of the catalogue takes 39 of them, the calibration's 8.
const SECONDS: usize = 60;
const FLIGHT: Flight =
    Flight { clips: &[Clip { scenario: "geo-eclipse", from_s: 0, seconds: SECONDS as u32 }], ..MISSION };
/// Seconds that are flown after a start to compare.
const AFTER_S: usize = 15;
/// Bytes of a part: whole words of any memory.
const PART_BYTES: usize = 192;
const AREAS: [Area; 3] = [Area::Catalogue, Area::Calibration, Area::BadPixels];

/// What a start of the flight code finds.
#[derive(Clone)]
struct Files {
    catalogue: Vec<u8>,
    calibration: Vec<u8>,
    bad_pixels: Vec<u8>,
}

impl Files {
    /// Those in the board's own image.
    fn own(size_px: [u16; 2]) -> Self {
        Self {
            catalogue: catalog_gen::REFERENCE.to_vec(),
            calibration: flight::REFERENCE_CALIBRATION.to_vec(),
            bad_pixels: defects_file::table(size_px, &[], &[]),
        }
    }

    /// Others: a catalogue without these stars, another gain, the hot pixels.
    fn newer(size_px: [u16; 2], without: &[u32]) -> Self {
        let mut stars = catalog_gen::source::stars();
        stars.retain(|star| !without.contains(&star.hip));
        Self {
            catalogue: catalog_gen::build(&stars, &catalog_gen::BuildParameters::reference()).unwrap(),
            calibration: with_gain(flight::REFERENCE_CALIBRATION, 1.02),
            bad_pixels: defects_file::table(size_px, &hot_pixels(), &[]),
        }
    }

    /// Those that serve, else the board's own.
    fn at_start(areas: &RamAreas, size_px: [u16; 2]) -> Self {
        let own = Self::own(size_px);
        let served = |area, own| areas.serving(area).map_or(own, <[u8]>::to_vec);
        Self {
            catalogue: served(Area::Catalogue, own.catalogue),
            calibration: served(Area::Calibration, own.calibration),
            bad_pixels: served(Area::BadPixels, own.bad_pixels),
        }
    }

    fn of(&self, area: Area) -> &[u8] {
        match area {
            Area::Catalogue => &self.catalogue,
            Area::Calibration => &self.calibration,
            Area::BadPixels => &self.bad_pixels,
        }
    }

    /// The table that names this calibration.
    fn parameters(&self, parameters: Parameters) -> Parameters {
        let mut parameters = parameters;
        parameters.imaging.calibration_crc = Calibration::open(&self.calibration).unwrap().crc();
        parameters
    }
}

/// Hot pixels by row, then column: more than a detector has anywhere near, and none beside another.
fn hot_pixels() -> Vec<[u16; 2]> {
    (0..40).flat_map(|row| (0..50).map(move |column| [11 + 25 * column + row % 5, 9 + 25 * row])).collect()
}

/// The recorded detector with its hot pixels.
struct Hot<'r>(&'r mut Recording);

impl fsw_hal::ErrorType for Hot<'_> {
    type Error = DetectorError;
}

impl Detector for Hot<'_> {
    fn geometry(&self) -> DetectorGeometry {
        self.0.geometry()
    }

    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        self.0.start_exposure(exposure_us)
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        self.0.finish_exposure()
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        self.0.read(window, pixels)?;
        for [x, y] in hot_pixels() {
            let [right, down] = [x.wrapping_sub(window.x), y.wrapping_sub(window.y)];
            if right < window.width && down < window.height {
                let place = usize::from(down) * usize::from(window.width) + usize::from(right);
                pixels[place] = self.geometry().full_scale() * 3 / 4;
            }
        }
        Ok(())
    }
}

/// Flies the recording from its begin with these files; `between` is called after every second.
fn fly(
    recording: &mut Recording,
    (files, parameters): (&Files, Parameters),
    seconds: usize,
    mut between: impl FnMut(&Report, &Parameters),
) -> Vec<Report> {
    let mut workspace = Box::new(Workspace::new());
    let catalogue = Catalogue::open(&files.catalogue).unwrap();
    let calibration = Calibration::open(&files.calibration).unwrap();
    let parameters = files.parameters(parameters);
    let mut sensor = flight::sensor(catalogue, Some(calibration), parameters, &mut workspace).unwrap();
    let fly = |second| {
        let mut clock = recording.turn_to(second);
        let mut hot = Hot(recording);
        let mut detector =
            BadPixelDetector::new(&mut hot, Defects::open(&files.bad_pixels).unwrap()).unwrap();
        let report = flight::second(&mut sensor, &mut detector, &mut clock, Command::Continue);
        between(&report, sensor.parameters());
        report
    };
    (0..seconds).map(fly).collect()
}

/// The ground and the link, packet by packet.
struct Session<'a> {
    link: CommandLink<&'a mut RamAreas>,
    counter: u32,
    parameters: Parameters,
}

impl<'a> Session<'a> {
    fn new(areas: &'a mut RamAreas, parameters: Parameters) -> Self {
        Self { link: CommandLink::with_areas(APID, Some(KEY), 0, areas), counter: 0, parameters }
    }

    fn packet(&mut self, telecommand: &Telecommand) -> Vec<u8> {
        self.counter += 1;
        let authentication = Some((KEY, self.counter));
        let envelope = Envelope { apid: APID, sequence: (self.counter & 0x3FFF) as u16, authentication };
        ground::encode(telecommand, &envelope, &mut [0; MAX_TELECOMMAND_BYTES]).unwrap().to_vec()
    }

    /// Service, subservice and reason of the reports that wait.
    fn reports(&mut self) -> Vec<(u8, u8, u16)> {
        let mut buffer = [0; MAX_REPORT_BYTES];
        let mut told = Vec::new();
        let downlink = Downlink { parameters: &self.parameters, image: LocalTime::default(), spots: &[] };
        while let Some(report) = self.link.next_report(LocalTime::default(), &downlink, &mut buffer) {
            let reason = match report[8] {
                2 | 8 => u16::from_be_bytes([report[24], report[25]]),
                _ => 0,
            };
            told.push((report[7], report[8], reason));
        }
        told
    }

    /// Hands bytes to the link and gives its reports.
    fn receive(&mut self, packet: &[u8]) -> Vec<(u8, u8, u16)> {
        let _ = self.link.receive(packet);
        self.reports()
    }

    fn send(&mut self, telecommand: &Telecommand) -> Vec<(u8, u8, u16)> {
        let packet = self.packet(telecommand);
        self.receive(&packet)
    }

    /// Sends all parts, each of which is accepted and done, and the load, which is accepted.
    fn upload(&mut self, area: Area, file: &[u8]) {
        for telecommand in ground::upload(Some(area), file, PART_BYTES) {
            let done = matches!(telecommand, Telecommand::Part { .. }).then_some((1, 7, 0));
            let expected: Vec<_> = [(1, 1, 0)].into_iter().chain(done).collect();
            assert_eq!(self.send(&telecommand), expected);
        }
    }

    /// A second of the link; its reports.
    fn second(&mut self) -> Vec<(u8, u8, u16)> {
        self.link.conclude(None);
        self.link.check_area(&self.parameters);
        self.reports()
    }

    /// Lets seconds go by until the check of a load ends; what it came to.
    fn checked(&mut self) -> (u8, u16) {
        let ended = (0..200).find_map(|_| self.second().first().copied());
        let (service, verdict, reason) = ended.expect("the check ends");
        assert_eq!(service, 1);
        (verdict, reason)
    }
}

/// Hipparcos numbers of all stars that were used, rising.
fn stars_of(reports: &[Report]) -> Vec<u32> {
    let stars: BTreeSet<u32> =
        reports.iter().flat_map(|report| report.stars.iter().map(|star| star.hip)).collect();
    stars.into_iter().collect()
}

fn size_px(geometry: DetectorGeometry) -> [u16; 2] {
    [geometry.width_px, geometry.height_px]
}

#[test]
fn files_that_go_up_in_flight_change_nothing_until_the_next_start_and_then_fly() {
    let folder = scratch("uploads");
    let (recorded, _) = record_flight(&FLIGHT, &folder).expect("it can be recorded");
    let Instrument { geometry, parameters, .. } = FLIGHT.instrument().unwrap();
    let size_px = size_px(geometry);
    let mut recording = Recording::load(&recorded.frames).unwrap();
    let _ = std::fs::remove_dir_all(&folder);
    let own = Files::own(size_px);
    let silent = fly(&mut recording, (&own, parameters), SECONDS, |_, _| {});
    // Every fourth of the stars that were used is no longer known.
    let without: Vec<u32> = stars_of(&silent).into_iter().step_by(4).collect();
    let newer = Files::newer(size_px, &without);

    let mut areas = RamAreas::default();
    let mut session = Session::new(&mut areas, parameters);
    let (mut files, mut told, mut packets) = (AREAS.into_iter(), Vec::new(), 0);
    let mut under_way = None;
    let reports = fly(&mut recording, (&own, parameters), SECONDS, |report, in_force| {
        session.parameters = *in_force;
        if under_way.is_none()
            && let Some(area) = files.next()
        {
            session.upload(area, newer.of(area));
            (under_way, packets) = (Some(report.cycle), session.counter);
        } else if let Some((service, verdict, reason)) = session.second().pop() {
            assert_eq!((service, verdict, reason), (1, 7, 0));
            told.push(report.cycle - under_way.take().expect("a file is checked"));
        }
    });
    assert_eq!(told.len(), 3, "{told:?}");
    println!("{packets} packets; seconds of the checks {told:?}");
    assert!(reports == silent, "the flight under way is another");

    areas.restart();
    for area in AREAS {
        assert_eq!(areas.serving(area), Some(newer.of(area)));
    }
    let started = Files::at_start(&areas, size_px);
    let reports = fly(&mut recording, (&started, parameters), AFTER_S, |_, _| {});
    let direct = fly(&mut recording, (&newer, parameters), AFTER_S, |_, _| {});
    assert!(reports == direct, "what went up is not what flies");
    // Each of the three is to be seen in the flight.
    for area in AREAS {
        let mut without = newer.clone();
        match area {
            Area::Catalogue => without.catalogue = own.catalogue.clone(),
            Area::Calibration => without.calibration = own.calibration.clone(),
            Area::BadPixels => without.bad_pixels = own.bad_pixels.clone(),
        }
        assert!(fly(&mut recording, (&without, parameters), AFTER_S, |_, _| {}) != reports, "{area:?}");
    }
    let stars = stars_of(&reports);
    assert!(stars.len() > 5 && stars.iter().all(|hip| !without.contains(hip)), "{stars:?}");
}

#[test]
fn what_is_refused_serves_at_no_start() {
    let Instrument { geometry, parameters, .. } = FLIGHT.instrument().unwrap();
    let files = Files::newer(size_px(geometry), &[]);
    let mut areas = RamAreas::default();
    let mut session = Session::new(&mut areas, parameters);
    let refused = |code: Refusal| vec![(1, 2, code.code())];
    let not_done = |code: Refusal| (8, code.code());
    for area in AREAS {
        let file = files.of(area);
        let (area, length, crc) = (Some(area), file.len() as u32, crc32(file));
        // A gap, and a file that is not whole.
        let part = |from: usize| Telecommand::Part {
            area,
            offset: from as u32,
            bytes: &file[from..file.len().min(from + PART_BYTES)],
        };
        session.send(&part(0));
        assert_eq!(session.send(&part(2 * PART_BYTES)), refused(Refusal::Part));
        assert_eq!(session.send(&Telecommand::Load { area, length, crc }), refused(Refusal::Incomplete));
        // Another CRC than that of the bytes in memory.
        for part in ground::upload(area, file, PART_BYTES) {
            if matches!(part, Telecommand::Part { .. }) {
                session.send(&part);
            }
        }
        session.send(&Telecommand::Load { area, length, crc: crc ^ 1 });
        // Until it ends the memory is busy, for the other areas too.
        for other in AREAS {
            let begin = Telecommand::Part { area: Some(other), offset: 0, bytes: &file[..8] };
            assert_eq!(session.send(&begin), refused(Refusal::Busy));
        }
        assert_eq!(session.checked(), not_done(Refusal::AreaChecksum));
    }
    // Damaged before it was sent, under the CRC of the damaged bytes: in the head, the middle, the end.
    for area in AREAS {
        for place in [1, files.of(area).len() / 2, files.of(area).len() - 1] {
            let mut damaged = files.of(area).to_vec();
            damaged[place] ^= 0x10;
            session.upload(area, &damaged);
            assert_eq!(session.checked(), not_done(Refusal::AreaContent), "{area:?} {place}");
        }
    }
    // Of another detector.
    session.upload(Area::BadPixels, &defects_file::table([640, 480], &[[1, 1]], &[]));
    assert_eq!(session.checked(), not_done(Refusal::AreaDetector));
    // Longer than the room.
    let long = vec![7; ROOM_BYTES];
    for part in ground::upload(Some(Area::Catalogue), &long, MAX_PART_BYTES) {
        if matches!(part, Telecommand::Part { .. }) {
            assert_eq!(session.send(&part), [(1, 1, 0), (1, 7, 0)]);
        }
    }
    let beyond = Telecommand::Part { area: Some(Area::Catalogue), offset: ROOM_BYTES as u32, bytes: &[7] };
    assert_eq!(session.send(&beyond), refused(Refusal::Part));
    // A packet that was sent before, and one with another key.
    let first = Telecommand::Part { area: Some(Area::Catalogue), offset: 0, bytes: &files.catalogue[..8] };
    let packet = session.packet(&first);
    assert_eq!(session.receive(&packet), [(1, 1, 0), (1, 7, 0)]);
    assert_eq!(session.receive(&packet), refused(Refusal::Counter));
    let envelope = Envelope {
        apid: APID,
        sequence: ((session.counter + 1) & 0x3FFF) as u16,
        authentication: Some((Key::new([0; 16]), session.counter + 1)),
    };
    let mut buffer = [0; MAX_TELECOMMAND_BYTES];
    let foreign = ground::encode(&first, &envelope, &mut buffer).unwrap();
    assert_eq!(session.receive(foreign), refused(Refusal::Tag));
    // A good one at last, which power leaves before it is marked.
    session.upload(Area::Calibration, &files.calibration);
    assert!(session.second().is_empty());

    areas.restart();
    assert_eq!(AREAS.map(|area| areas.serving(area)), [None, None, None]);
    // After all that the next one is taken.
    let mut session = Session::new(&mut areas, parameters);
    session.upload(Area::Catalogue, &files.catalogue);
    assert_eq!(session.checked(), (7, 0));
    areas.restart();
    assert_eq!(areas.serving(Area::Catalogue), Some(&files.catalogue[..]));
}
