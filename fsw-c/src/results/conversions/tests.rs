use super::*;
use fsw_core::telemetry::{
    ClockFault, DetectorFault, EarthReport, ElementsReport, Faults, FixFault, ImageFault, LocalAttitude,
    RateReport, RateSource, ReadingFault, ShutterFault,
};

#[test]
fn a_second_of_which_nothing_is_known_is_all_zero() {
    assert_eq!(CycleResult::from(&Report::default()), CycleResult::default());
}

#[test]
fn every_quantity_of_a_report_comes_through() {
    let orbit = OrbitReport {
        position_km: [7000.5, -1.25, 3.0],
        velocity_km_s: [0.5, 7.5, -0.125],
        sigma_position_km: [1.0, 2.0, 3.0],
        sigma_velocity_km_s: [0.1, 0.2, 0.3],
        correlations: [0.0; telemetry::MOTION_CORRELATIONS],
        sigma_hill_km: [0.5, 1.5, 0.25],
        elements: Some(ElementsReport {
            semi_major_axis_km: 7178.5,
            eccentricity: 0.01,
            inclination_rad: 1.5,
            node_rad: 2.5,
            perigee_rad: 3.5,
            anomaly_rad: 4.5,
        }),
        limb_height_km: 0.0,
        limb_height_sigma_km: 0.0,
        misalignment_rad: [1e-5, -2e-5, 3e-5],
        misalignment_sigma_rad: [4e-5, 5e-5, 6e-5],
        nis: None,
        nis_freedom: 0,
        since_fix_s: 9,
        settled: true,
    };
    let earth = EarthReport {
        direction: [0.0, 0.6, 0.8],
        sigma_rad: 1e-3,
        distance_km: 7000.0,
        sigma_km: 12.0,
        covariance_km2: [49.0, -1.0, 50.0, 2.0, -3.0, 144.0],
        inliers: 30,
        arc_deg: 60.0,
        rms_px: 0.2,
    };
    let (quaternion, sigma_rad) = ([0.5, -0.5, 0.5, 0.5], [1e-5, 2e-5, 3e-5]);
    let report = Report {
        cycle: 7,
        local_us: -5,
        instant_us: Some(800_000_000_000_000),
        clock: telemetry::ClockState::Holdover,
        mode: FlightMode::Eclipse,
        outcome: Some(telemetry::Outcome::Tracked),
        attitude: Some(AttitudeReport { quaternion, sigma_rad, log10_false: -20.0, age_s: 2 }),
        filtered: Some(FilteredAttitude { quaternion, sigma_rad }),
        rate_rad_s: Some([1e-3, 2e-3, 3e-3]),
        detections: 40,
        earth_status: telemetry::EarthStatus::Found,
        earth: Some(earth),
        orbit: Some(orbit),
        local: Some(LocalAttitude { quaternion, nadir_rad: 0.75, yaw_rad: -0.5 }),
        state: Some(outages::SensorState::Eclipse),
        next_state: Some(telemetry::NextState {
            state: outages::SensorState::SunInStarPath,
            in_s: 300,
            sigma_s: 1.5,
            lasts_s: Some(720),
        }),
        magnetometer: Some(telemetry::MagnetometerReport {
            field_ut: [10.0, -20.0, 30.0],
            zero_ut: [1.0, 2.0, 3.0],
            zero_sigma_ut: 0.25,
            used: true,
        }),
        command: Some(CommandOutcome::Done),
        exposure_us: Some(50_000),
        earth_path_shut: true,
        earth_path_clear: true,
        earth_path_stars: Some(7),
        ..Report::default()
    };
    let result = CycleResult::from(&report);
    let attitude = Attitude { known: true, quaternion, sigma_rad, age_s: 2 };
    let expected = CycleResult {
        cycle: 7,
        mode: Mode::Eclipse,
        outcome: Outcome::Tracked,
        earth_status: EarthStatus::Found,
        clock: ClockState::Holdover,
        faults: 0,
        local_us: -5,
        terrestrial_us: 800_000_000_000_000,
        detections: 40,
        stars: 0,
        attitude,
        filtered: Attitude { age_s: 0, ..attitude },
        rate: Rate { known: true, rad_s: [1e-3, 2e-3, 3e-3], ..Rate::default() },
        earth: Earth {
            direction: [0.0, 0.6, 0.8],
            sigma_rad: 1e-3,
            distance_km: 7000.0,
            sigma_km: 12.0,
            covariance_km2: [49.0, -1.0, 50.0, 2.0, -3.0, 144.0],
        },
        orbit: Orbit {
            known: true,
            settled: true,
            since_fix_s: 9,
            position_km: orbit.position_km,
            velocity_km_s: orbit.velocity_km_s,
            sigma_position_km: orbit.sigma_position_km,
            sigma_velocity_km_s: orbit.sigma_velocity_km_s,
            sigma_hill_km: orbit.sigma_hill_km,
            misalignment_rad: orbit.misalignment_rad,
            misalignment_sigma_rad: orbit.misalignment_sigma_rad,
            elements: Elements {
                known: true,
                semi_major_axis_km: 7178.5,
                eccentricity: 0.01,
                inclination_rad: 1.5,
                node_rad: 2.5,
                perigee_rad: 3.5,
                anomaly_rad: 4.5,
            },
        },
        local: Local { known: true, quaternion, nadir_rad: 0.75, yaw_rad: -0.5 },
        next_state: NextState {
            known: true,
            state: SensorState::SunInStarPath,
            in_s: 300,
            sigma_s: 1.5,
            lasts_s: 720,
        },
        magnetic_field: MagneticField {
            known: true,
            used: true,
            field_ut: [10.0, -20.0, 30.0],
            zero_ut: [1.0, 2.0, 3.0],
            zero_sigma_ut: 0.25,
        },
        command: CommandResult::Done,
        refusal: 0,
        exposure_us: 50_000,
        star_path_shut: false,
        earth_path_shut: true,
        earth_path_clear: true,
        earth_path_stars: 7,
        sensor_state_known: true,
        sensor_state: SensorState::Eclipse,
    };
    assert_eq!(result, expected);
}

#[test]
fn without_an_attitude_the_rate_is_that_of_the_streaks() {
    let rate = RateReport {
        rad_s: [0.1, 0.2, 0.3],
        sigma_rad_s: [0.01, 0.02, 0.03],
        source: RateSource::Streaks,
        either_sense: true,
        stars: 5,
    };
    let result = CycleResult::from(&Report { rate: Some(rate), ..Report::default() });
    let RateReport { rad_s, sigma_rad_s, .. } = rate;
    assert_eq!(result.rate, Rate { known: true, either_sense: true, rad_s, sigma_rad_s });
}

#[test]
fn every_fault_has_its_bit() {
    let of = |faults: Faults| CycleResult::from(&Report { faults, ..Report::default() }).faults;
    let none = Faults::default();
    assert_eq!(of(Faults { detector: Some(DetectorFault::Hardware), ..none }), FAULT_DETECTOR);
    assert_eq!(of(Faults { image: Some(ImageFault::Repeated), ..none }), FAULT_IMAGE);
    assert_eq!(of(Faults { clock: Some(ClockFault::Hardware), ..none }), FAULT_CLOCK);
    assert_eq!(of(Faults { rate_sensor: Some(ReadingFault::Silent), ..none }), FAULT_RATE_SENSOR);
    assert_eq!(of(Faults { fix: Some(FixFault::Covariance), ..none }), FAULT_FIX);
    assert_eq!(of(Faults { shutter: Some(ShutterFault::Stuck), ..none }), FAULT_SHUTTER);
    assert_eq!(of(Faults { magnetometer: Some(ReadingFault::Stale), ..none }), FAULT_MAGNETOMETER);
}
