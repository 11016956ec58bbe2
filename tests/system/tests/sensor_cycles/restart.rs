//! A warm restart: the telemetry frame that was kept in flash before gives the orbit back.

use super::orbit::orbit_error_km;
use super::world::{World, fly, has, quietly};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use fsw_core::modes::Mode;
use fsw_core::sensor::Command;
use fsw_core::telemetry::{self, Event, MAX_FRAME_BYTES, Report};
use fsw_drivers::FlashStore;
use fsw_hal::StateStore;

const SLOT_BYTES: usize = 4096;
/// Seconds before the restart, and after it.
const BEFORE_S: u32 = 60;
const AFTER_S: u32 = 30;
/// Seconds that the restart takes.
const DOWN_S: u64 = 20;
const MAX_AGE_US: i64 = 100 * 60 * 1_000_000;

/// Flash that loses power after so many bytes.
struct Flash {
    bytes: Vec<u8>,
    power: usize,
}

impl Flash {
    fn change(&mut self, offset: u32, bytes: impl Iterator<Item = u8>) -> Result<(), NorFlashErrorKind> {
        for (at, byte) in (offset as usize..).zip(bytes) {
            self.power = self.power.checked_sub(1).ok_or(NorFlashErrorKind::Other)?;
            self.bytes[at] = byte;
        }
        Ok(())
    }
}

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 4096;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        self.change(from, (from..to).map(|_| 0xFF))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        self.change(offset, bytes.iter().copied())
    }
}

fn keep(store: &mut FlashStore<Flash>, report: &Report) -> bool {
    let mut buffer = [0; MAX_FRAME_BYTES];
    let frame = telemetry::encode(report, &mut buffer).unwrap();
    store.keep(frame, report.instant_us.unwrap()).is_ok()
}

/// The world after the restart: the counter and the sky went on.
fn after(world: &World) -> World {
    let mut after = World::clip("leo-oblique");
    after.second = world.second + DOWN_S;
    after.instant_us = world.instant_us + DOWN_S as i64 * 1_000_000;
    after
}

#[test]
fn an_orbit_outlives_a_restart_and_a_loss_of_power_while_it_was_kept() {
    let mut world = World::clip_with_orbit("leo-oblique");
    let reports = quietly(&mut world, BEFORE_S);
    let [.., kept, lost] = reports.as_slice() else { panic!("{} seconds", reports.len()) };
    let flash = Flash { bytes: vec![0; 2 * SLOT_BYTES], power: usize::MAX };
    let mut store = FlashStore::new(flash, 0, SLOT_BYTES).unwrap();
    assert!(keep(&mut store, kept));
    // Power goes in the middle of the next record.
    let mut flash = store.release();
    flash.power = SLOT_BYTES + 300;
    let mut store = FlashStore::new(flash, 0, SLOT_BYTES).unwrap();
    assert!(!keep(&mut store, lost));
    let mut flash = store.release();
    flash.power = usize::MAX;

    let mut store = FlashStore::new(flash, 0, SLOT_BYTES).unwrap();
    let mut restarted = after(&world);
    let mut buffer = [0; MAX_FRAME_BYTES];
    let record = store.kept(&mut buffer, restarted.instant_us, MAX_AGE_US).unwrap().expect("a record");
    let found = telemetry::decode(record).unwrap();
    assert_eq!(&found, kept);

    let began = restarted.second as usize;
    restarted.kept = Some(found);
    let reports = quietly(&mut restarted, AFTER_S);
    let truth = world.truth(world.second as usize - 2);
    let (_, sigma_before_km) = orbit_error_km(kept, &truth);
    let mut worst = 0.0f64;
    for (second, report) in (began..).zip(&reports) {
        let (error_km, sigma_km) = orbit_error_km(report, &restarted.truth(second));
        worst = worst.max(error_km / sigma_km);
        assert!(error_km < 5.0 * sigma_km, "second {}: {error_km} km of {sigma_km}", report.cycle);
        assert!(sigma_km < 3.0 * sigma_before_km, "second {}: {sigma_km} km", report.cycle);
    }
    println!("position off by {worst:.2} sigma at most; sigma before the restart {sigma_before_km:.2} km");

    // Without the record the images alone need minutes.
    let alone = quietly(&mut after(&world), AFTER_S);
    assert!(alone.iter().all(|report| report.orbit.is_none()));
}

#[test]
fn safe_that_was_commanded_outlives_a_restart_with_the_orbit_and_ends_by_a_command() {
    let mut world = World::clip_with_orbit("leo-oblique");
    let at = |wanted, command: Command<'static>| {
        move |second, _: &mut World| if second == wanted { command } else { Command::Continue }
    };
    let reports = fly(&mut world, BEFORE_S, at(BEFORE_S - 5, Command::Safe), |_, _| {});
    let kept = reports.last().unwrap();
    assert_eq!(kept.mode, Mode::CommandedSafe);

    let mut restarted = after(&world);
    restarted.kept = Some(kept.clone());
    let reports = fly(&mut restarted, AFTER_S, at(AFTER_S - 10, Command::Reacquire), |_, _| {});
    let (safe, on) = reports.split_at(AFTER_S as usize - 10);
    assert!(safe.iter().all(|report| report.mode == Mode::CommandedSafe && report.attitude.is_none()));
    assert!(safe.iter().all(|report| report.orbit.is_some()), "the orbit is propagated");
    assert_eq!(on.last().unwrap().mode, Mode::Tracking);
}

#[test]
fn an_orbit_of_before_is_told_when_the_time_is_known_and_forgotten_when_it_is_too_old() {
    let mut world = World::clip_with_orbit("leo-oblique");
    let kept = quietly(&mut world, BEFORE_S).pop().unwrap();
    for (down_s, goes_on) in [(3600, true), (7300, false), (-3600, false)] {
        let mut restarted = after(&world);
        restarted.kept = Some(kept.clone());
        restarted.instant_us = kept.instant_us.unwrap() + down_s * 1_000_000;
        // The sky is of no matter here.
        restarted.covered = true;
        let unknown = |second, world: &mut World| {
            world.clock_serves = second >= 5;
            Command::Continue
        };
        let reports = fly(&mut restarted, 20, unknown, |_, _| {});
        assert!(reports[..5].iter().all(|report| report.orbit.is_none() && report.instant_us.is_none()));
        let forgotten = reports.iter().filter(|report| has(report, Event::OrbitForgotten)).count();
        assert_eq!((reports[19].orbit.is_some(), forgotten), (goes_on, usize::from(!goes_on)), "{down_s} s");
    }
}
