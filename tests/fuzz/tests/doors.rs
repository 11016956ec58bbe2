//! Mutilated files at every door, the same in every run.

use fsw_core::camera::Camera;
use fsw_core::catalog::Catalogue;
use fsw_core::command::ground::{self, Envelope};
use fsw_core::command::{GroundOrbit, MAX_PART_BYTES, MAX_TELECOMMAND_BYTES, Telecommand, TimeCorrelation};
use fsw_core::frames::Direction;
use fsw_core::modes::Mode;
use fsw_core::orbit::OrbitState;
use fsw_core::parameters::{MAX_TABLE_BYTES, Parameters};
use fsw_core::telemetry::{self, MAX_FRAME_BYTES, Report};
use fsw_hal::{Area, LocalTime, OpenPaths};
use fuzz::link;
use fuzz::seconds::{self, HEAD};
use sil_host::flight;
use sil_host::formats::defects_file;
use sil_host::world::noise::{Noise, Stream};
use spacepackets::crc::CRC_CCITT_FALSE;
use std::path::Path;
use system_tests::amount;

/// The world's noise, thrown one number after the other.
struct Dice {
    noise: Noise,
    thrown: u32,
}

impl Dice {
    fn below(&mut self, count: usize) -> usize {
        self.thrown += 1;
        self.noise.bits(self.thrown, 0) as usize % count.max(1)
    }

    /// A byte that is often an extreme one.
    fn byte(&mut self) -> u8 {
        let extremes = [0, 1, 0x7F, 0x80, 0xFF];
        if self.below(2) == 0 { extremes[self.below(extremes.len())] } else { self.below(256) as u8 }
    }

    /// One of the seeds with up to eight mutilations.
    fn mutilated(&mut self, seeds: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = seeds[self.below(seeds.len())].clone();
        for _ in 0..self.below(9) {
            let at = self.below(bytes.len());
            match self.below(6) {
                0 => bytes.truncate(at),
                1 => bytes.insert(at, self.byte()),
                2 => drop(bytes.drain(at..(at + self.below(16)).min(bytes.len()))),
                3 => {
                    let other = &seeds[self.below(seeds.len())];
                    let from = self.below(other.len());
                    let piece = &other[from..(from + self.below(64)).min(other.len())];
                    bytes.splice(at..at, piece.iter().copied());
                }
                _ if bytes.is_empty() => {}
                _ => bytes[at] = self.byte(),
            }
        }
        bytes
    }
}

/// A third of the `times` in the gate, all in the long tier, of which those are the first.
fn knock(door: impl Fn(&[u8]), seeds: &[Vec<u8>], times: usize) {
    let times = amount(times / 3, times);
    let mut dice = Dice { noise: Noise::new(0x5EED, 0, Stream::Shuffle), thrown: 0 };
    seeds.iter().for_each(|seed| door(seed));
    (0..times).for_each(|_| door(&dice.mutilated(seeds)));
}

/// All files of a folder of the repository that end so, a byte for their kind before each.
fn files(folder: &str, ending: &str, kind: &[u8]) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder);
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let paths = paths.iter().filter(|path| path.extension().is_some_and(|found| found == ending));
    let files: Vec<_> = paths.map(|path| [kind, &std::fs::read(path).unwrap()].concat()).collect();
    assert!(!files.is_empty());
    files
}

#[test]
fn packets() {
    let mut buffer = [0; MAX_FRAME_BYTES];
    let report =
        telemetry::encode_next(&Report { cycle: 7, mode: Mode::Tracking, ..Report::default() }, &mut buffer)
            .unwrap()
            .to_vec();
    let table = Parameters::for_camera(seconds::CAMERA).encode(&mut buffer).unwrap().to_vec();
    // The bodies alone, without length, version and checksum.
    let bodies = [&report[3..report.len() - 4], &table[1..table.len() - 4]].map(<[u8]>::to_vec);
    knock(fuzz::packets::try_bytes, &[&[report][..], &bodies[..]].concat(), 1_000_000);
}

#[test]
fn tables() {
    let mut seeds = files("sil-host/cameras", "corr", &[]);
    seeds.push(catalog_gen::REFERENCE.to_vec());
    knock(fuzz::tables::try_bytes, &seeds, 5000);
}

#[test]
fn pixels() {
    let steps: Vec<u8> = [100, 90, 2].into_iter().chain((0..4000u32).map(|k| (k * k / 97) as u8)).collect();
    let flat = [&[200, 40, 8][..], &[12; 999]].concat();
    knock(fuzz::pixels::try_bytes, &[steps, flat], 2000);
}

/// The pixels of a sky: the catalogue's stars in a field of 23 deg about a pole.
fn sky() -> Vec<u8> {
    let side = usize::from(seconds::SIDE_PX);
    let camera = Camera::new(seconds::CAMERA).unwrap();
    let mut pixels = vec![3.0f32; side * side];
    for (rank, star) in (1u16..).zip(Catalogue::open(catalog_gen::REFERENCE).unwrap().stars()) {
        let place = Direction::new(*star.direction().vector()).and_then(|there| camera.project(&there));
        let Some([x, y]) = place.filter(|place| camera.contains(*place, 0.0)) else { continue };
        // Of the n-th brightest star: three times as many are a magnitude fainter.
        let light = 4.0e3 * f32::from(rank).powf(-0.84);
        for (place, pixel) in pixels.iter_mut().enumerate() {
            let (dx, dy) = ((place % side) as f32 - x, (place / side) as f32 - y);
            *pixel += light * (-0.5 * (dx * dx + dy * dy)).exp();
        }
    }
    pixels.into_iter().map(|pixel| pixel.min(250.0) as u8).collect()
}

#[test]
fn seconds_of_the_sensor() {
    let pixels: Vec<u8> = [7].into_iter().chain((0..20_000u32).map(|k| (k * k / 1013) as u8)).collect();
    // Six images, each with a noise of its own.
    let sky = (0..6u32).fold(vec![5], |mut seconds, image| {
        let mut pixels = sky();
        for (place, pixel) in (1u32..).zip(&mut pixels) {
            *pixel += (place.wrapping_mul(2_654_435_761).wrapping_mul(place ^ image) >> 30) as u8;
        }
        seconds.extend([0; HEAD]);
        seconds.extend(pixels);
        seconds
    });
    // The self-test sees stars and names none.
    assert_eq!(seconds::try_bytes(&sky), 5);
    knock(|bytes| _ = seconds::try_bytes(bytes), &[pixels, sky.clone(), sky], 600);
}

/// A table of bad pixels of the detector that flies.
fn bad_pixels() -> Vec<u8> {
    defects_file::table([seconds::SIDE_PX; 2], &[[3, 4], [9, 4]], &[(7, -2)])
}

/// Beginnings of a catalogue and of a calibration: their checks refuse them.
fn beginnings() -> [(Area, &'static [u8]); 2] {
    [(Area::Catalogue, catalog_gen::REFERENCE), (Area::Calibration, flight::REFERENCE_CALIBRATION)]
        .map(|(area, file)| (area, &file[..2 * MAX_PART_BYTES]))
}

/// A flight of all commands, each in a packet of its own, led by its length.
fn telecommands(flags: u8) -> Vec<u8> {
    let parameters = Parameters::for_camera(seconds::CAMERA);
    let mut buffer = [0; MAX_TABLE_BYTES];
    let table = parameters.encode(&mut buffer).unwrap();
    let state = OrbitState {
        time_us: link::BEGIN_US,
        position_km: [42164.0, 0.0, 0.0].into(),
        velocity_km_s: [0.0, 3.0746, 0.0].into(),
    };
    let orbit = GroundOrbit { state, position_sigma_km: 10.0, velocity_sigma_km_s: 0.01 };
    let time = TimeCorrelation { local: LocalTime::from_us(1_000_000), terrestrial_us: link::BEGIN_US };
    let file = bad_pixels();
    let loaded = ground::upload(None, table, MAX_PART_BYTES);
    let filed = ground::upload(Some(Area::BadPixels), &file, MAX_PART_BYTES);
    // While a file is checked the next part would be refused: a command between them lets a second go by.
    let begun =
        beginnings().into_iter().zip([Some(OpenPaths::Star), None]).flat_map(|((area, file), paths)| {
            let upload = ground::upload(Some(area), file, MAX_PART_BYTES);
            [Telecommand::Shutter(paths)].into_iter().chain(upload)
        });
    let rest = [
        Telecommand::Time(time),
        Telecommand::Orbit(orbit),
        Telecommand::Exposure(50_000),
        Telecommand::Exposure(1),
        Telecommand::Safe,
        Telecommand::Reacquire,
        Telecommand::Dump,
        Telecommand::Restart,
    ];
    (1..).zip(loaded.chain(filed).chain(begun).chain(rest)).fold(
        vec![flags],
        |mut bytes, (count, telecommand)| {
            let authentication = (flags & 1 == 1).then_some((link::KEY, count));
            let envelope = Envelope { apid: link::APID, sequence: count as u16, authentication };
            let mut buffer = [0; MAX_TELECOMMAND_BYTES];
            let packet = ground::encode(&telecommand, &envelope, &mut buffer).unwrap();
            bytes.push(packet.len() as u8);
            bytes.extend_from_slice(packet);
            bytes
        },
    )
}

/// Writes the checksum of every packet again, so that more of them get past it.
fn sealed(bytes: &[u8]) -> Vec<u8> {
    let Some((flags, mut rest)) = bytes.split_first() else { return Vec::new() };
    let mut sealed = vec![*flags];
    while let Some((length, after)) = rest.split_first() {
        let (packet, after) = after.split_at(usize::from(*length).min(after.len()));
        rest = after;
        sealed.push(packet.len() as u8);
        match packet.split_last_chunk::<2>() {
            Some((content, _)) => {
                sealed.extend_from_slice(content);
                sealed.extend(CRC_CCITT_FALSE.checksum(content).to_be_bytes());
            }
            None => sealed.extend_from_slice(packet),
        }
    }
    sealed
}

/// Flights of all commands, with and without a key and a clock.
fn command_flights() -> Vec<Vec<u8>> {
    (0..4).map(telecommands).collect()
}

#[test]
fn the_command_link() {
    let seeds = command_flights();
    let table = Parameters::for_camera(seconds::CAMERA).encode(&mut [0; MAX_TABLE_BYTES]).unwrap().len();
    let parts = [table, bad_pixels().len()].map(|bytes| bytes.div_ceil(MAX_PART_BYTES));
    // Two parts and a load of each beginning, the other loads, and ten commands of one packet.
    let all = parts.iter().sum::<usize>() + 6 + 2 + 10;
    assert!(seeds.iter().all(|seed| link::try_bytes(seed) == all));
    knock(|bytes| _ = link::try_bytes(bytes), &seeds, 1000);
}

#[test]
fn the_command_link_behind_its_checksum() {
    knock(|bytes| _ = link::try_bytes(&sealed(bytes)), &command_flights(), 1000);
}

#[test]
fn files_of_people() {
    let seeds =
        [files("sil-host/src/scenarios", "toml", &[1]), files("sil-host/cameras", "toml", &[2])].concat();
    let fits: Vec<u8> = ["SIMPLE  = T", "BITPIX  = 16", "NAXIS   = 2", "NAXIS1  = 40", "NAXIS2  = 36", "END"]
        .iter()
        .flat_map(|card| format!("{card:80}").into_bytes())
        .collect();
    let picture = [&[0][..], &fits, &vec![b' '; 2880 - fits.len()], &vec![9; 2880]].concat();
    knock(fuzz::files::try_bytes, &[seeds, vec![picture]].concat(), 30_000);
}
