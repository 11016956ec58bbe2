use super::*;

const GEOMETRY: DetectorGeometry = DetectorGeometry { width_px: 200, height_px: 100, bits: 10 };

/// A detector whose image is all its exposure's number.
#[derive(Default)]
struct Counting {
    exposures: u16,
}

impl fsw_hal::ErrorType for Counting {
    type Error = DetectorError;
}

impl Detector for Counting {
    fn geometry(&self) -> DetectorGeometry {
        GEOMETRY
    }

    fn start_exposure(&mut self, _: u32) -> Result<(), DetectorError> {
        self.exposures += 1;
        Ok(())
    }

    fn finish_exposure(&mut self) -> Result<fsw_hal::LocalTime, DetectorError> {
        Ok(fsw_hal::LocalTime::default())
    }

    fn read(&mut self, _: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        pixels.fill(100 * self.exposures);
        Ok(())
    }
}

fn always(kind: FaultKind) -> [Fault; 1] {
    [Fault { kind, from_s: 5, until_s: 8 }]
}

/// The whole image of a second, exposed before without faults and once more with them.
fn image(kind: FaultKind, cycle: u32, window: Window) -> Result<Vec<u16>, DetectorError> {
    let mut detector = Counting { exposures: 1 };
    let faults = always(kind);
    let mut faulty = Faulty::new(&mut detector, &faults, 3, (cycle, LocalTime::default()));
    faulty.expose(1)?;
    let mut pixels = vec![0; window.area()];
    faulty.read(window, &mut pixels).map(|()| pixels)
}

#[test]
fn a_fault_acts_in_its_seconds_only() {
    let whole = GEOMETRY.whole();
    for (cycle, acts) in [(4, false), (5, true), (7, true), (8, false)] {
        assert_eq!(image(FaultKind::TimeOut(1.0), cycle, whole).is_err(), acts);
        assert_eq!(image(FaultKind::DroppedWindow(1.0), cycle, whole).is_err(), acts);
        let late = image(FaultKind::LateFrame(1.0), cycle, whole).unwrap();
        assert!(late.iter().all(|pixel| *pixel == if acts { 100 } else { 200 }));
        let mut detector = Counting::default();
        let faults = always(FaultKind::WrongGeometry(1.0));
        let width = Faulty::new(&mut detector, &faults, 3, (cycle, LocalTime::default())).geometry().width_px;
        assert_eq!(width, if acts { 100 } else { 200 });
        assert_eq!(words(&faults, cycle), if acts { "wrong-geometry" } else { "" });
    }
}

#[test]
fn a_doubled_image_has_its_own_instant_and_a_late_frame_that_of_a_new_one() {
    let new = LocalTime::from_us(6_000_000);
    for (kind, instant) in
        [(FaultKind::LateFrame(1.0), new), (FaultKind::DoubledImage(1.0), LocalTime::default())]
    {
        let mut detector = Counting { exposures: 1 };
        let faults = always(kind);
        assert_eq!(Faulty::new(&mut detector, &faults, 3, (6, new)).expose(1), Ok(instant), "{kind:?}");
        assert_eq!(detector.exposures, 1);
    }
}

#[test]
fn an_image_that_was_blinded_is_blinded_whenever_it_is_handed_out() {
    let faults = [
        Fault { kind: FaultKind::Blinded, from_s: 5, until_s: 8 },
        Fault { kind: FaultKind::LateFrame(1.0), from_s: 8, until_s: 10 },
    ];
    for (cycle, is_blinded) in [(4, false), (5, true), (7, true), (8, true), (9, true), (10, false)] {
        let mut detector = Counting { exposures: 1 };
        let mut faulty = Faulty::new(&mut detector, &faults, 3, (cycle, LocalTime::default()));
        faulty.expose(1).unwrap();
        let mut pixels = vec![0; GEOMETRY.whole().area()];
        faulty.read(GEOMETRY.whole(), &mut pixels).unwrap();
        assert_eq!(pixels.iter().all(|pixel| *pixel == GEOMETRY.full_scale()), is_blinded, "{cycle}");
    }
}

#[test]
fn the_clock_is_off_silent_or_late_in_its_seconds_only() {
    let clock = Instant::new(LocalTime::from_us(7), 1_000_000_000);
    let read = |kind, cycle| faulty_clock(&always(kind), cycle, clock).terrestrial_us;
    assert_eq!(read(FaultKind::ClockStep(-600.0), 5), Some(400_000_000));
    assert_eq!(
        (read(FaultKind::ClockInvalid, 5), read(FaultKind::ClockInvalid, 8)),
        (None, Some(1_000_000_000))
    );
    let late = |cycle| lateness_s(&always(FaultKind::LateImage(0.2)), cycle);
    assert_eq!([late(4), late(5), late(8)], [0.0, 0.2, 0.0]);
}

#[test]
fn a_share_is_the_share_of_seconds_and_of_windows() {
    let late = |cycle: &u32| {
        let faults = [Fault { kind: FaultKind::LateFrame(0.3), from_s: 0, until_s: u32::MAX }];
        let mut detector = Counting { exposures: 1 };
        Faulty::new(&mut detector, &faults, 9, (*cycle, LocalTime::default())).expose(1).unwrap();
        detector.exposures == 1
    };
    // 10,000 draws: a standard deviation of 46; five of them fail a right generator once in two million.
    let count = (0..10_000).filter(late).count();
    assert!((2_770..3_230).contains(&count), "{count}");
    let faults = [Fault { kind: FaultKind::DroppedWindow(0.3), from_s: 0, until_s: 1 }];
    let mut detector = Counting::default();
    let mut faulty = Faulty::new(&mut detector, &faults, 9, (0, LocalTime::default()));
    let mut dropped = |place: u32| {
        let window = Window { x: (place % 200) as u16, y: (place / 200) as u16, width: 1, height: 1 };
        let first = faulty.read(window, &mut [0]).is_err();
        assert_eq!(faulty.read(window, &mut [0]).is_err(), first);
        first
    };
    let count = (0..20_000).filter(|place| dropped(*place)).count();
    assert!((5_675..6_325).contains(&count), "{count}");
}

#[test]
fn pixels_are_spoiled_alike_in_any_window() {
    for kind in [FaultKind::StuckRow(40), FaultKind::BitFlips(0.02), FaultKind::NoiseBurst(30.0)] {
        let whole = image(kind, 6, GEOMETRY.whole()).unwrap();
        let window = Window { x: 31, y: 33, width: 50, height: 20 };
        for (index, pixel) in image(kind, 6, window).unwrap().iter().enumerate() {
            let (x, y) = (31 + index % 50, 33 + index / 50);
            assert_eq!(*pixel, whole[y * 200 + x], "{kind:?} {x} {y}");
        }
    }
}

#[test]
fn stuck_rows_flipped_bits_and_noise_are_as_strong_as_set() {
    let whole = |kind| image(kind, 6, GEOMETRY.whole()).unwrap();
    let stuck = whole(FaultKind::StuckRow(40));
    assert!(stuck.iter().enumerate().all(|(k, pixel)| *pixel == if k / 200 == 40 { 1023 } else { 200 }));
    let flipped = whole(FaultKind::BitFlips(0.02));
    let changed: Vec<u16> = flipped.iter().map(|pixel| pixel ^ 200).filter(|bits| *bits != 0).collect();
    // 20,000 pixels: 400 with a standard deviation of 20.
    assert!(
        (300..500).contains(&changed.len())
            && changed.iter().all(|bits| bits.count_ones() == 1 && *bits < 1024)
    );
    let noisy = whole(FaultKind::NoiseBurst(30.0));
    let variance = noisy.iter().map(|pixel| (f64::from(*pixel) - 200.0).powi(2)).sum::<f64>() / 20_000.0;
    // Rounding adds 1/12; the estimate's standard deviation is 1 %.
    assert!((variance / 900.1 - 1.0).abs() < 0.05, "{variance}");
}

#[test]
fn a_blinded_detector_reads_full_scale_everywhere() {
    assert!(image(FaultKind::Blinded, 6, GEOMETRY.whole()).unwrap().iter().all(|pixel| *pixel == 1023));
}

#[test]
fn restarts_are_commanded_in_their_seconds_as_often_as_asked() {
    let faults = [Fault { kind: FaultKind::Restart(0.1), from_s: 100, until_s: 2100 }];
    let commanded = |cycle: &u32| command(&faults, 1, *cycle) == Command::Restart;
    // Of 2,000 seconds one in ten, three standard deviations of 13.4.
    assert!((160..=240).contains(&(0..3000).filter(commanded).count()));
    assert!((0..100).chain(2100..3000).all(|cycle| !commanded(&cycle)));
}

#[test]
fn storms_add_up_and_a_gyro_is_silent_or_off_in_its_seconds_only() {
    let storm = |hits, from_s| Fault { kind: FaultKind::ProtonStorm(hits), from_s, until_s: 8 };
    let gyro = |kind, from_s| Fault { kind, from_s, until_s: from_s + 1 };
    let faults =
        [storm(300, 5), storm(40, 7), gyro(FaultKind::GyroSilent, 6), gyro(FaultKind::GyroOffset(90.0), 7)];
    assert_eq!([4, 5, 7, 8].map(|cycle| storm_hits(&faults, cycle)), [0, 300, 340, 0]);
    let reading = AngularRate { instant: LocalTime::from_us(7), rad_s: [0.5, 0.0, -0.5] };
    let seen = [5, 6, 7, 8].map(|cycle| faulty_rate(&faults, cycle, Some(reading)).map(|rate| rate.rad_s));
    let off = reading.rad_s.map(|axis| axis + std::f32::consts::FRAC_PI_2);
    assert_eq!(seen, [Some(reading.rad_s), None, Some(off), Some(reading.rad_s)]);
    assert_eq!(faulty_rate(&faults, 7, None), None);
}

#[test]
fn a_magnetometer_is_silent_or_off_in_its_seconds_only() {
    let fault = |kind, from_s| Fault { kind, from_s, until_s: from_s + 1 };
    let faults = [fault(FaultKind::MagnetometerSilent, 6), fault(FaultKind::MagnetometerOffset(20.0), 7)];
    let reading = MagneticField { instant: LocalTime::from_us(7), ut: [10.0, 0.0, -30.0] };
    let seen = [5, 6, 7, 8].map(|cycle| faulty_field(&faults, cycle, Some(reading)).map(|field| field.ut));
    assert_eq!(seen, [Some(reading.ut), None, Some([30.0, 20.0, -10.0]), Some(reading.ut)]);
}
