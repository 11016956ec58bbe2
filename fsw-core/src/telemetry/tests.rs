use super::*;
use crate::checksum::crc32;
use crate::command::{Refusal, refusal};
use fsw_hal::DetectorError;
use proptest::prelude::*;

fn outcome() -> impl Strategy<Value = Outcome> {
    let reasons = [NotIdentified::TooFewStars, NotIdentified::NoSides, NotIdentified::NoMatch];
    prop_oneof![
        prop::sample::select(&[
            Outcome::SelfTestPassed,
            Outcome::Identified,
            Outcome::Searching,
            Outcome::TooFast,
            Outcome::Tracked,
            Outcome::Lost,
            Outcome::Blinded,
        ]),
        prop::sample::select(reasons.to_vec()).prop_map(Outcome::NotIdentified),
    ]
}

fn activity() -> impl Strategy<Value = Activity> {
    use Activity::{Propagation, SelfTest, StarSearch, StarTracking, StreakSearch, Waiting};
    prop::sample::select(&[Waiting, SelfTest, StarSearch, StreakSearch, StarTracking, Propagation])
}

prop_compose! {
    fn faults()(
        detector in prop::option::of(prop::sample::select(&[
            DetectorFault::Request, DetectorFault::Geometry, DetectorFault::Hardware,
        ])),
        image in prop::option::of(prop::sample::select(&[
            ImageFault::Repeated, ImageFault::OutOfOrder, ImageFault::Implausible, ImageFault::Unexpected,
        ])),
        clock in prop::option::of(prop::sample::select(&[
            ClockFault::NotSynchronised, ClockFault::Implausible, ClockFault::Hardware,
            ClockFault::CounterReset,
        ])),
        [rate_sensor, magnetometer] in prop::array::uniform2(prop::option::of(prop::sample::select(&[
            ReadingFault::Silent, ReadingFault::Stale, ReadingFault::NotFinite,
            ReadingFault::Saturated, ReadingFault::ShutOut,
        ]))),
        shutter in prop::option::of(prop::sample::select(&[ShutterFault::Stuck, ShutterFault::Hardware])),
        fix in prop::option::of(prop::sample::select(&[FixFault::Impossible, FixFault::Covariance])),
        crowded in any::<u16>(),
    ) -> Faults {
        Faults { detector, image, clock, rate_sensor, magnetometer, shutter, fix, crowded }
    }
}

/// Any number but NaN, which is unequal to itself.
fn real() -> impl Strategy<Value = f32> {
    any::<f32>().prop_map(|value| if value.is_nan() { 0.0 } else { value })
}

fn attitude() -> impl Strategy<Value = AttitudeReport> {
    (prop::array::uniform4(real()), prop::array::uniform3(real()), real(), any::<u16>()).prop_map(
        |(quaternion, sigma_rad, log10_false, age_s)| AttitudeReport {
            quaternion,
            sigma_rad,
            log10_false,
            age_s,
        },
    )
}

fn star() -> impl Strategy<Value = StarReport> {
    (any::<u32>(), prop::array::uniform2(real()), prop::array::uniform2(real()))
        .prop_map(|(hip, centre_px, residual_px)| StarReport { hip, centre_px, residual_px })
}

fn mode() -> impl Strategy<Value = Mode> {
    use Mode::{Acquisition, CommandedSafe, Eclipse, Safe, SelfTest, SunOutage, Tracking};
    prop::sample::select(&[SelfTest, Acquisition, Tracking, Eclipse, SunOutage, Safe, CommandedSafe])
}

fn earth() -> impl Strategy<Value = EarthReport> {
    let covariance = prop::array::uniform6(real());
    (prop::array::uniform3(real()), prop::array::uniform5(real()), covariance, any::<u16>()).prop_map(
        |(direction, [sigma_rad, distance_km, sigma_km, arc_deg, rms_px], covariance_km2, inliers)| {
            EarthReport {
                direction,
                sigma_rad,
                distance_km,
                sigma_km,
                covariance_km2,
                inliers,
                arc_deg,
                rms_px,
            }
        },
    )
}

fn orbit() -> impl Strategy<Value = OrbitReport> {
    let vector = || prop::array::uniform3(-1e6..1e6f64);
    let sigmas = || prop::array::uniform3(real());
    let sigma = (sigmas(), sigmas(), prop::array::uniform15(real()));
    (vector(), vector(), sigma, prop::option::of(real()), any::<u32>(), any::<bool>()).prop_map(
        |(position_km, velocity_km_s, sigma, nis, since_fix_s, settled)| {
            let (sigma_position_km, sigma_velocity_km_s, correlations) = sigma;
            OrbitReport {
                position_km,
                velocity_km_s,
                sigma_position_km,
                sigma_velocity_km_s,
                correlations,
                sigma_hill_km: sigma_position_km,
                elements: settled.then(|| elements(position_km[0], sigma_velocity_km_s)),
                limb_height_km: sigma_position_km[0],
                limb_height_sigma_km: sigma_position_km[1],
                misalignment_rad: sigma_velocity_km_s,
                misalignment_sigma_rad: sigma_position_km,
                nis,
                nis_freedom: since_fix_s as u8,
                since_fix_s,
                settled,
            }
        },
    )
}

fn elements(semi_major_axis_km: f64, [eccentricity, inclination_rad, node_rad]: [f32; 3]) -> ElementsReport {
    let (perigee_rad, anomaly_rad) = (inclination_rad, node_rad);
    ElementsReport { semi_major_axis_km, eccentricity, inclination_rad, node_rad, perigee_rad, anomaly_rad }
}

prop_compose! {
    fn local()(
        quaternion in prop::array::uniform4(real()),
        nadir_rad in real(),
        yaw_rad in real(),
    ) -> LocalAttitude {
        LocalAttitude { quaternion, nadir_rad, yaw_rad }
    }
}

fn state() -> impl Strategy<Value = SensorState> {
    use SensorState::{Eclipse, Full, SunInEarthPath, SunInStarPath, SunInStarPathOverEarth};
    prop::sample::select(std::vec![Full, SunInEarthPath, Eclipse, SunInStarPath, SunInStarPathOverEarth])
}

fn next_state() -> impl Strategy<Value = NextState> {
    (state(), any::<u32>(), real(), prop::option::of(any::<u32>()))
        .prop_map(|(state, in_s, sigma_s, lasts_s)| NextState { state, in_s, sigma_s, lasts_s })
}

fn event() -> impl Strategy<Value = Event> {
    let plain = [
        Event::OrbitStarted,
        Event::OrbitConverged,
        Event::FixDownweighted,
        Event::OrbitRestarted,
        Event::OrbitForgotten,
        Event::ClockJump,
        Event::SunInPath,
        Event::ParametersRestored,
        Event::ParametersLost,
        Event::CatalogueDamaged,
        Event::CalibrationDamaged,
        Event::RateSensorShutOut,
        Event::MagnetometerShutOut,
        Event::TimeForgotten,
        Event::GroundForgotten,
        Event::ShuttersReleased,
        Event::Overran,
    ];
    prop_oneof![
        mode().prop_map(|mode| Event::Mode(mode, Guard::AttitudeLost)),
        prop::sample::select(plain.to_vec()),
    ]
}

fn command() -> impl Strategy<Value = Option<CommandOutcome>> {
    let refused = prop::sample::select(refusal::ALL).prop_map(CommandOutcome::Refused);
    prop::option::of(prop_oneof![Just(CommandOutcome::Done), refused])
}

fn earth_status() -> impl Strategy<Value = EarthStatus> {
    use EarthStatus::{Dark, Faint, Found, NotLooked, Refused};
    prop::sample::select(&[
        NotLooked,
        Dark,
        Faint,
        Found,
        Refused(FitError::ShortArc),
        Refused(FitError::TooFewPoints),
    ])
}

/// Times, the Earth with its limb points, the orbit, events.
type Whereabouts = (
    (i64, Option<i64>, ClockState),
    EarthStatus,
    Option<EarthReport>,
    Vec<[f32; 2], MAX_LIMB_POINTS>,
    (Option<OrbitReport>, (Option<LocalAttitude>, Option<NextState>, Option<MagnetometerReport>)),
    Vec<Event, MAX_EVENTS>,
);

prop_compose! {
    /// The half of a report about the Earth and the orbit: one strategy takes no more than so many.
    fn whereabouts()(
        times in times(),
        earth_status in earth_status(),
        earth in prop::option::of(earth()),
        limb_px in prop::collection::vec(prop::array::uniform2(real()), 0..=MAX_LIMB_POINTS),
        orbit in prop::option::of(orbit()),
        local in (prop::option::of(local()), prop::option::of(next_state()), prop::option::of(magnetometer())),
        events in prop::collection::vec(event(), 0..=MAX_EVENTS),
    ) -> Whereabouts {
        let (limb_px, events) = (Vec::from_slice(&limb_px).unwrap(), Vec::from_slice(&events).unwrap());
        (times, earth_status, earth, limb_px, (orbit, local), events)
    }
}

prop_compose! {
    fn magnetometer()(
        [field_ut, zero_ut] in prop::array::uniform2(prop::array::uniform3(real())),
        zero_sigma_ut in real(),
        used in any::<bool>(),
    ) -> MagnetometerReport {
        MagnetometerReport { field_ut, zero_ut, zero_sigma_ut, used }
    }
}

prop_compose! {
    fn times()(
        local_us in any::<i64>(),
        instant_us in prop::option::of(any::<i64>()),
        clock in prop::sample::select(&[ClockState::Synchronised, ClockState::Holdover, ClockState::Unknown]),
    ) -> (i64, Option<i64>, ClockState) {
        (local_us, instant_us, clock)
    }
}

prop_compose! {
    fn rate()(
        rad_s in prop::array::uniform3(real()),
        sigma_rad_s in prop::array::uniform3(real()),
        source in prop::sample::select(&[RateSource::Streaks, RateSource::Images, RateSource::Both][..]),
        either_sense in any::<bool>(),
        stars in any::<u8>(),
    ) -> RateReport {
        RateReport { rad_s, sigma_rad_s, source, either_sense, stars }
    }
}

prop_compose! {
    fn report()(
        cycle in any::<u32>(),
        mode in mode(),
        whereabouts in whereabouts(),
        (activity, outcome, faults) in (activity(), prop::option::of(outcome()), faults()),
        attitude in prop::option::of(attitude()),
        filtered in prop::option::of(attitude()),
        rates in (prop::option::of(prop::array::uniform3(real())), prop::option::of(rate())),
        detections in any::<u16>(),
        focal_ratio in prop::option::of(real()),
        stars in prop::collection::vec(star(), 0..=MAX_STARS),
        (command, state) in (command(), prop::option::of(state())),
        (shut, earth_path_stars, exposure_us) in any::<([bool; 3], Option<u8>, Option<u32>)>(),
    ) -> Report {
        let stars = Vec::from_slice(&stars).unwrap();
        let filtered = filtered
            .map(|AttitudeReport { quaternion, sigma_rad, .. }| FilteredAttitude { quaternion, sigma_rad });
        let ((rate_rad_s, rate), [star_path_shut, earth_path_shut, earth_path_clear]) =
            (rates, shut);
        let ((local_us, instant_us, clock), earth_status, earth, limb_px, (orbit, ahead), events) = whereabouts;
        let (local, next_state, magnetometer) = ahead;
        Report {
            cycle, local_us, instant_us, clock, mode, activity, exposure_us, outcome, faults,
            star_path_shut, earth_path_shut, earth_path_clear, earth_path_stars, attitude, filtered,
            rate_rad_s, detections, focal_ratio, stars,
            earth_status, earth, limb_px, orbit, local, events, rate, command, state, next_state,
            magnetometer,
        }
    }
}

/// The report that needs most bytes: every list full, every number as long as it can be.
fn largest() -> Report {
    let star = StarReport { hip: u32::MAX, centre_px: [f32::MAX; 2], residual_px: [f32::MAX; 2] };
    let attitude = AttitudeReport {
        quaternion: [f32::MAX; 4],
        sigma_rad: [f32::MAX; 3],
        log10_false: f32::MIN,
        age_s: u16::MAX,
    };
    let earth = EarthReport {
        direction: [f32::MAX; 3],
        sigma_rad: f32::MAX,
        distance_km: f32::MAX,
        sigma_km: f32::MAX,
        covariance_km2: [f32::MAX; 6],
        inliers: u16::MAX,
        arc_deg: f32::MAX,
        rms_px: f32::MAX,
    };
    let orbit = OrbitReport {
        position_km: [f64::MAX; 3],
        velocity_km_s: [f64::MAX; 3],
        sigma_position_km: [f32::MAX; 3],
        sigma_velocity_km_s: [f32::MAX; 3],
        correlations: [f32::MAX; MOTION_CORRELATIONS],
        sigma_hill_km: [f32::MAX; 3],
        elements: Some(elements(f64::MAX, [f32::MAX; 3])),
        limb_height_km: f32::MAX,
        limb_height_sigma_km: f32::MAX,
        misalignment_rad: [f32::MAX; 3],
        misalignment_sigma_rad: [f32::MAX; 3],
        nis: Some(f32::MAX),
        nis_freedom: u8::MAX,
        since_fix_s: u32::MAX,
        settled: true,
    };
    Report {
        cycle: u32::MAX,
        local_us: i64::MIN,
        instant_us: Some(i64::MIN),
        clock: ClockState::Unknown,
        mode: Mode::Tracking,
        activity: Activity::Propagation,
        exposure_us: Some(u32::MAX),
        outcome: Some(Outcome::NotIdentified(NotIdentified::NoMatch)),
        faults: Faults {
            detector: Some(DetectorFault::Hardware),
            image: Some(ImageFault::Implausible),
            clock: Some(ClockFault::CounterReset),
            rate_sensor: Some(ReadingFault::Hardware),
            magnetometer: Some(ReadingFault::ShutOut),
            shutter: Some(ShutterFault::Hardware),
            fix: Some(FixFault::Covariance),
            crowded: u16::MAX,
        },
        star_path_shut: true,
        earth_path_shut: true,
        earth_path_clear: true,
        earth_path_stars: Some(u8::MAX),
        attitude: Some(attitude),
        filtered: Some(FilteredAttitude { quaternion: attitude.quaternion, sigma_rad: attitude.sigma_rad }),
        rate_rad_s: Some([f32::MAX; 3]),
        detections: u16::MAX,
        focal_ratio: Some(f32::MAX),
        stars: Vec::from_slice(&[star; MAX_STARS]).unwrap(),
        earth_status: EarthStatus::Refused(FitError::ShortArc),
        earth: Some(earth),
        limb_px: Vec::from_slice(&[[f32::MAX; 2]; MAX_LIMB_POINTS]).unwrap(),
        orbit: Some(orbit),
        local: Some(LocalAttitude { quaternion: [f32::MAX; 4], nadir_rad: f32::MAX, yaw_rad: f32::MAX }),
        events: Vec::from_slice(&[Event::Mode(Mode::Safe, Guard::Commanded); MAX_EVENTS]).unwrap(),
        rate: Some(RateReport {
            rad_s: [f32::MAX; 3],
            sigma_rad_s: [f32::MAX; 3],
            source: RateSource::Both,
            either_sense: true,
            stars: u8::MAX,
        }),
        command: Some(CommandOutcome::Refused(Refusal::ParametersLost)),
        state: Some(SensorState::Full),
        next_state: Some(NextState {
            state: SensorState::Full,
            in_s: u32::MAX,
            sigma_s: f32::MAX,
            lasts_s: Some(u32::MAX),
        }),
        magnetometer: Some(MagnetometerReport {
            field_ut: [f32::MAX; 3],
            zero_ut: [f32::MAX; 3],
            zero_sigma_ut: f32::MAX,
            used: true,
        }),
    }
}

/// A frame of these bytes with a right checksum.
fn sealed(content: &[u8]) -> std::vec::Vec<u8> {
    let crc = crc32(content).to_le_bytes();
    content.iter().chain(&crc).copied().collect()
}

#[test]
fn the_longest_frame_fits_the_buffer() {
    let mut buffer = [0; MAX_FRAME_BYTES];
    let report = largest();
    let frame = encode(&report, &mut buffer).unwrap();
    std::println!("longest frame: {} bytes", frame.len());
    assert_eq!(decode(frame), Ok(report));
}

#[test]
fn any_flipped_bit_of_a_frame_is_refused() {
    let mut buffer = [0; MAX_FRAME_BYTES];
    let length = encode(&largest(), &mut buffer).unwrap().len();
    for place in 0..length {
        for bit in 0..8 {
            let mut frame = buffer;
            frame[place] ^= 1 << bit;
            assert_eq!(decode(&frame[..length]), Err(PacketError::Checksum), "byte {place}, bit {bit}");
        }
    }
}

#[test]
fn a_frame_of_another_version_is_refused_and_named() {
    let mut buffer = [0; MAX_FRAME_BYTES];
    let frame = encode(&largest(), &mut buffer).unwrap();
    for version in (0..=u8::MAX).filter(|version| *version != VERSION) {
        let mut content = frame[..frame.len() - 4].to_vec();
        content[0] = version;
        assert_eq!(decode(&sealed(&content)), Err(PacketError::Version(version)));
    }
}

#[test]
fn every_truncated_frame_is_refused() {
    let mut buffer = [0; MAX_FRAME_BYTES];
    let frame = encode(&largest(), &mut buffer).unwrap();
    for length in 0..frame.len() {
        assert_eq!(decode(&frame[..length]), Err(PacketError::Checksum), "{length} bytes");
    }
}

#[test]
fn a_sealed_frame_that_is_no_report_is_refused_by_its_content() {
    assert_eq!(decode(&sealed(&[VERSION])), Err(PacketError::Content));
    assert_eq!(decode(&sealed(&[VERSION, 1, 9, 9, 9])), Err(PacketError::Content));
    let mut buffer = [0; MAX_FRAME_BYTES];
    let frame = encode(&largest(), &mut buffer).unwrap();
    assert_eq!(decode(&sealed(&frame[..frame.len() - 5])), Err(PacketError::Content));
    // A list longer than it can be: 65 stars at the end of a report without any.
    let mut content = encode(&Report { stars: Vec::new(), ..largest() }, &mut buffer).unwrap().to_vec();
    content.truncate(content.len() - 4);
    *content.last_mut().unwrap() = MAX_STARS as u8 + 1;
    content.extend([0; 17 * (MAX_STARS + 1)]);
    assert_eq!(decode(&sealed(&content)), Err(PacketError::Content));
}

#[test]
fn a_buffer_that_is_too_short_is_refused() {
    let report = largest();
    let length = encode(&report, &mut [0; MAX_FRAME_BYTES]).unwrap().len();
    for short in 0..length {
        assert_eq!(encode(&report, &mut std::vec![0; short]), Err(PacketError::Buffer), "{short} bytes");
    }
    assert!(encode(&report, &mut std::vec![0; length]).is_ok());
}

#[test]
fn a_stream_gives_its_frames_in_order_and_ends_where_it_breaks_off() {
    let reports =
        [largest(), Report { stars: Vec::new(), ..largest() }, Report { attitude: None, ..largest() }];
    let mut stream = std::vec::Vec::new();
    for report in &reports {
        stream.extend_from_slice(encode_next(report, &mut [0; MAX_FRAME_BYTES + 2]).unwrap());
    }
    let mut rest = &stream[..];
    for report in &reports {
        let (frame, after) = split_first(rest).unwrap();
        assert_eq!(decode(frame).as_ref(), Ok(report));
        rest = after;
    }
    assert_eq!(split_first(rest), None);
    for length in 0..1000 {
        assert_eq!(split_first(&stream[..length]), None, "{length} bytes");
    }
}

#[test]
fn a_refused_request_is_our_fault_and_silence_the_hardware_s() {
    for ours in [DetectorError::OutsideDetector, DetectorError::BufferLength, DetectorError::Exposure] {
        assert_eq!(DetectorFault::from(ours), DetectorFault::Request);
    }
    for theirs in [DetectorError::NotExposed, DetectorError::Timeout, DetectorError::Bus] {
        assert_eq!(DetectorFault::from(theirs), DetectorFault::Hardware);
    }
}

proptest! {
    #[test]
    fn a_report_comes_back_from_its_frame(report in report()) {
        let mut buffer = [0; MAX_FRAME_BYTES];
        let frame = encode(&report, &mut buffer).unwrap();
        prop_assert_eq!(decode(frame), Ok(report));
    }

    #[test]
    fn no_bytes_panic(content in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = decode(&content);
        let mut versioned = std::vec![VERSION];
        versioned.extend(content);
        let _ = decode(&sealed(&versioned));
    }
}
