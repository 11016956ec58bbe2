use super::*;
use crate::harness::faults::FaultKind;
use crate::world::detector::protons::Protons;
use crate::world::motion::pointing::Law;
use crate::world::scene::SensorState;

fn default_text() -> &'static str {
    EMBEDDED[0].1
}

/// Message of the fault of the default scenario with `from` replaced by `to`.
fn refused(from: &str, to: &str) -> String {
    let text = default_text().replacen(from, to, 1);
    assert_ne!(text, default_text(), "{from} is not in the file");
    let message = Scenario::parse(Path::new("some.toml"), &text).expect_err(to).to_string();
    assert!(message.starts_with("sil-host: some.toml:") && !message.contains('\n'), "{message}");
    message
}

/// Line of the default scenario that begins with `start`.
fn line_of(start: &str) -> usize {
    1 + default_text().lines().position(|line| line.starts_with(start)).expect("a line")
}

#[test]
fn embedded_scenarios_are_sound_and_named_as_their_files() {
    for (name, text) in EMBEDDED {
        let scenario = Scenario::parse(&embedded_path(name), text).unwrap();
        assert_eq!(scenario.name, name);
        assert!(scenario.camera.mirrored && !scenario.description.is_empty());
        assert!(scenario.flight_parameters(None).check().is_ok());
        scenario.scene().unwrap();
    }
    assert_eq!(Scenario::default_embedded().name, "geo-eclipse");
    assert_eq!(Scenario::load(Path::new("geo-day")).unwrap().duration_s, 86_400);
}

#[test]
fn values_out_of_range_name_line_key_and_range() {
    let cases = [
        ("duration_s = 21600", "duration_s = 0", "scenario.duration_s"),
        ("seed = 1", "seed = -1", "scenario.seed"),
        ("exposure_ms = 400", "exposure_ms = 1500", "scenario.exposure_ms"),
        ("start = \"2026-09-23T18:00:00\"", "start = \"tomorrow\"", "scenario.start"),
        ("name = \"geo-eclipse\"", "name = \"../up\"", "scenario.name"),
        ("i_deg = 0.05", "i_deg = nan", "orbit.i_deg"),
        ("a_km = 42164.17", "a_km = 6000", "orbit.a_km"),
        ("off_nadir_deg = 0.0", "off_nadir_deg = 1e9", "pointing.off_nadir_deg"),
        ("star_path_deg = [0.0, 90.0, 0.0]", "star_path_deg = [0.0, 900.0, 0.0]", "mount.star_path_deg"),
        ("hot_pixels = 200", "hot_pixels = -200", "disturbances.hot_pixels"),
        ("mode_share = 0.99", "mode_share = 99", "limits.mode_share"),
        ("mode_share = 0.99", "mood_share = 0.99", "limits.mood_share"),
    ];
    for (from, to, key) in cases {
        let message = refused(from, to);
        let line = line_of(from);
        assert!(message.contains(&format!("some.toml:{line}: {key}: ")), "{message}");
        assert!(message.contains("; "), "{message}");
    }
}

/// The default scenario with these lines before its `[disturbances]`.
fn with_lines(lines: &str) -> Result<Scenario, HostError> {
    let text = default_text().replacen("[disturbances]", &format!("{lines}\n[disturbances]"), 1);
    Scenario::parse(Path::new("some.toml"), &text)
}

#[test]
fn optics_and_detector_are_on_by_default_and_can_be_switched_off() {
    let scenario = Scenario::default_embedded();
    assert_eq!((scenario.imaging, scenario.detector), (ImagingModel::REFERENCE, DetectorModel::reference()));
    assert_eq!(scenario.disturbances.protons, Protons::Fixed(20));
    let orbit = default_text().replacen("proton_hits = 20", "", 1);
    let orbit = Scenario::parse(Path::new("some.toml"), &orbit).unwrap();
    assert_eq!(orbit.disturbances.protons, Protons::Orbit);
    let plain = with_lines(
        "[optics]\npsf = \"gaussian\"\nstar_colours = false\nvignetting = false\n[detector]\npixel = \"full\"\n\
         prnu = 0.0\ndsnu = 0.0\ncolumn_offset_e = 0.0\nrow_noise_e = 0.0",
    )
    .unwrap();
    assert_eq!((plain.imaging, plain.detector), (ImagingModel::PLAIN, DetectorModel::default()));
    let rolling =
        with_lines("[optics]\nshutter = \"rolling\"\nrow_time_us = 40.0\nearth_path_transmission = 0.0")
            .unwrap();
    assert!((rolling.imaging.shutter.row_time_s() - 4e-5).abs() < 1e-18);
    assert_eq!(rolling.imaging.earth_path_transmission, 0.0);
}

#[test]
fn wrong_optics_and_detectors_name_line_and_key() {
    let cases = [
        ("[optics]\ncorner_loss = 2.0", "optics.corner_loss: 2 is out of range"),
        ("[optics]\npsf_sigma_px = 0.9", "optics.psf_sigma_px: says nothing here"),
        ("[optics]\nrow_time_us = 50.0", "optics.row_time_us: says nothing here"),
        ("[optics]\nshutter = \"slit\"", "slit"),
        ("[detector]\nread_noise_e = -1.0", "detector.read_noise_e: -1 is out of range"),
        ("[detector]\ngain = 1.0", "`gain`"),
    ];
    for (lines, words) in cases {
        let message = with_lines(lines).unwrap_err().to_string();
        let line = line_of("[disturbances]") + 1;
        assert!(message.contains(&format!("some.toml:{line}: ")) && message.contains(words), "{message}");
    }
    let message = refused("proton_hits = 20", "proton_hits = 20\nprotons = \"orbit\"");
    assert!(message.contains("disturbances.proton_hits: the orbit says"), "{message}");
    // A lens that the camera cannot have is found when the world is made.
    let fast = with_lines("[optics]\naperture_mm = 30.0").unwrap();
    assert!(fast.scene().unwrap_err().to_string().contains("the lens cannot be scaled"));
}

#[test]
fn unknown_and_missing_keys_are_named() {
    let message = refused("seed = 1", "seeds = 1");
    assert!(message.contains(&format!(":{}: ", line_of("seed"))) && message.contains("`seeds`"), "{message}");
    assert!(refused("[mount]", "[mouth]").contains("`mouth`"));
    assert!(refused("start = ", "# ").contains("`start`"));
    assert!(refused("a_km = 42164.17", "a_km = far").contains(&format!(":{}: ", line_of("a_km"))));
}

#[test]
fn impossible_orbits_name_the_line() {
    let message = refused("e = 0.0002", "e = 0.9");
    assert!(message.contains(&format!(":{}: orbit.e: perigee", line_of("e ="))), "{message}");
    let state = |v: &str| {
        let (from, to) = (default_text().find("a_km").unwrap(), default_text().find("[pointing]").unwrap());
        let state = format!("position_km = [7000.0, 0.0, 0.0]\nvelocity_km_s = {v}\n");
        let text = [&default_text()[..from], &state, &default_text()[to..]].concat();
        Scenario::parse(Path::new("some.toml"), &text)
    };
    assert!(state("[0.0, 7.6, 0.0]").is_ok());
    for (v, word) in [("[0.0, 11.0, 0.0]", "leaves the body"), ("[7.6, 0.0, 0.0]", "perigee")] {
        let message = state(v).unwrap_err().to_string();
        let line = line_of("a_km") + 1;
        assert!(message.contains(&format!(":{line}: orbit.velocity_km_s: ")), "{message}");
        assert!(message.contains(word), "{message}");
    }
    assert!(refused("a_km = 42164.17", "velocity_km_s = [0.0, 3.0, 0.0]").contains("exclude each other"));
}

#[test]
fn a_camera_that_is_not_there_names_the_line() {
    let message = refused("[disturbances]", "[camera]\nfile = \"no-such.toml\"\n[disturbances]");
    let line = line_of("[disturbances]") + 1;
    assert!(message.contains(&format!(":{line}: camera.file: no such file")), "{message}");
}

/// Seconds in each state of an embedded scenario, every tenth second looked at.
fn seconds_in_states(name: &str) -> [u32; 5] {
    let scenario = Scenario::load(Path::new(name)).unwrap();
    let scene = scenario.scene().unwrap();
    let mut seconds = [0; 5];
    for cycle in (0..scenario.duration_s).step_by(10) {
        seconds[scene.truth_at(cycle.into()).unwrap().state as usize] += 10;
    }
    println!("{name}: {seconds:?}");
    seconds
}

#[test]
fn the_default_scenario_has_an_eclipse_and_the_sun_in_the_earth_path_on_either_side() {
    let [full, sun_earth, eclipse, sun_star, both] = seconds_in_states("geo-eclipse");
    // The Earth covers the Sun for 67 to 70 minutes at the equinox; the Sun needs 13 to 17 minutes from the
    // field's edge.
    assert!((3_900..4_300).contains(&eclipse) && (1_500..2_100).contains(&sun_earth));
    assert!(full > 15_000 && sun_star == 0 && both == 0);
}

#[test]
fn the_day_also_has_the_sun_in_the_star_path() {
    let [_, sun_earth, eclipse, sun_star, over_earth] = seconds_in_states("geo-day");
    assert!(sun_earth > 1_500 && eclipse > 3_900);
    // 24.1 degrees of field and the Sun's own half degree at 15 degrees an hour; two thirds of it over the
    // Earth's image.
    assert!((5_700..6_100).contains(&(sun_star + over_earth)) && over_earth > sun_star);
}

#[test]
fn low_orbits_have_light_and_dark_and_no_sun_where_none_is_meant() {
    let [full, sun_earth, eclipse, sun_star, both] = seconds_in_states("sso-noon-midnight");
    assert!(full > 5_000 && eclipse > 3_000 && sun_earth > 0 && sun_star == 0 && both == 0);
    let [full, sun_earth, eclipse, sun_star, both] = seconds_in_states("leo-oblique");
    assert!(full > 5_000 && eclipse > 3_000 && sun_earth == 0 && sun_star == 0 && both == 0);
}

#[test]
fn a_pointed_star_path_never_looks_at_the_earth() {
    for (name, _) in EMBEDDED {
        let scenario = Scenario::load(Path::new(name)).unwrap();
        if !matches!(scenario.pointing.law, Law::Nadir { .. } | Law::Horizon { .. }) {
            continue;
        }
        let scene = scenario.scene().unwrap();
        for cycle in (0..scenario.duration_s).step_by(60) {
            let truth = scene.truth_at(cycle.into()).unwrap();
            let distance_km = libm::sqrt(dot(truth.position_km, truth.position_km));
            let air_km = truth.ellipsoid.figure().equator_km + 100.0;
            let earth_deg = libm::asin(air_km / distance_km).to_degrees();
            let down = truth.position_km.map(|component| -component / distance_km);
            let star_path = crate::world::attitude::matrix(truth.quaternion)[2];
            let from_nadir_deg = libm::acos(dot(star_path, down)).to_degrees();
            // Half the diagonal of the field is 15.3 degrees.
            assert!(from_nadir_deg > earth_deg + 15.3, "{name}, {cycle}: {from_nadir_deg} of {earth_deg}");
        }
    }
    assert_eq!(SensorState::Eclipse as u8, 2);
}

#[test]
fn faults_are_read_and_their_mistakes_named() {
    let parse = |entry: &str| {
        let text = format!("{}\n[[faults]]\n{entry}\n", default_text());
        Scenario::parse(Path::new("some.toml"), &text)
    };
    let [fault] = parse("kind = \"late-frame\"\nfrom_s = 5\nuntil_s = 7\nshare = 0.5").unwrap().faults[..]
    else {
        panic!("one fault");
    };
    assert_eq!((fault.kind, fault.from_s, fault.until_s), (FaultKind::LateFrame(0.5), 5, 7));
    for (own, kind) in [
        ("kind = \"blinded\"", FaultKind::Blinded),
        ("kind = \"gyro-silent\"", FaultKind::GyroSilent),
        ("kind = \"magnetometer-silent\"", FaultKind::MagnetometerSilent),
        ("kind = \"magnetometer-offset\"\nfield_ut = 20.0", FaultKind::MagnetometerOffset(20.0)),
        ("kind = \"restart\"", FaultKind::Restart(1.0)),
        ("kind = \"restart\"\nshare = 0.1", FaultKind::Restart(0.1)),
        ("kind = \"proton-storm\"\nhits = 3000", FaultKind::ProtonStorm(3000)),
    ] {
        let scenario = parse(&format!("{own}\nfrom_s = 5\nuntil_s = 7")).unwrap();
        assert_eq!(scenario.faults[0].kind, kind);
    }
    let first = default_text().lines().count() + 3;
    let cases = [
        ("kind = \"rust\"\nfrom_s = 5\nuntil_s = 7", 0, "faults.kind: `rust` is no fault"),
        ("kind = \"time-out\"\nfrom_s = -5\nuntil_s = 7", 1, "faults.from_s: -5 is out of range"),
        (
            "kind = \"time-out\"\nfrom_s = 5\nuntil_s = 5",
            2,
            "faults.until_s: 5 is out of range; use 6 to 21600",
        ),
        ("kind = \"time-out\"\nfrom_s = 5\nuntil_s = 6\nshare = 1.5", 3, "faults.share: 1.5 is out of range"),
        ("kind = \"stuck-row\"\nfrom_s = 5\nuntil_s = 6", 0, "faults.row: a stuck-row needs one; add it"),
        (
            "kind = \"proton-storm\"\nfrom_s = 5\nuntil_s = 6",
            0,
            "faults.hits: a proton-storm needs one; add it",
        ),
        (
            "kind = \"blinded\"\nfrom_s = 5\nuntil_s = 6\nhits = 7",
            3,
            "faults.hits: a blinded has none; remove it",
        ),
        (
            "kind = \"time-out\"\nfrom_s = 5\nuntil_s = 6\nrow = 7",
            3,
            "faults.row: a time-out has none; remove it",
        ),
    ];
    for (entry, line, words) in cases {
        let message = parse(entry).unwrap_err().to_string();
        assert!(message.contains(&format!("some.toml:{}: {words}", first + line)), "{message}");
    }
}
/// The default scenario with `pointing` instead of its own: what comes of it.
fn with_pointing(pointing: &str) -> Result<Scenario, String> {
    let (from, to) = (default_text().find("[pointing]").unwrap(), default_text().find("[mount]").unwrap());
    let text = [&default_text()[..from], pointing, "\n", &default_text()[to..]].concat();
    Scenario::parse(Path::new("some.toml"), &text).map_err(|error| error.to_string())
}

#[test]
fn every_law_is_read_and_flown() {
    let slews =
        "[[pointing.slews]]\nstart_s = 10.0\nduration_s = 20.0\naxis = [0.0, 0.0, 2.0e-1]\nangle_deg = -30.0";
    let jitter = "[pointing.jitter]\nrandom_arcsec = [5.0, 5.0, 9.0]\n\
                  [[pointing.jitter.lines]]\nfrequency_hz = 7.0\namplitude_arcsec = [1.0, 2.0, 0.0]";
    let sky = "ra_deg = 83.8\ndec_deg = -5.4\nroll_deg = 3.0";
    for text in [
        format!("[pointing]\noff_nadir_deg = 5.0\n{slews}\n{jitter}"),
        format!("[pointing]\nlaw = \"inertial\"\n{sky}\n{slews}\n{jitter}"),
        format!("[pointing]\nlaw = \"spin\"\n{sky}\nrate_deg_s = [9.0, 12.0, 0.0]\n{jitter}"),
    ] {
        let scenario = with_pointing(&text).unwrap_or_else(|message| panic!("{text}: {message}"));
        let scene = scenario.clone().scene().unwrap();
        let Some(trajectory) = scene.settings().motion.trajectory() else {
            panic!("a scenario is a trajectory")
        };
        assert_eq!(trajectory.pointing.slews, scenario.pointing.slews);
        // The jitter is the seed's.
        let at = |seed| scenario.clone().with_seed(Some(seed)).scene().unwrap().truth_at(50).unwrap();
        assert_eq!(at(5), at(5));
        assert_ne!(at(5).quaternion, at(6).quaternion);
    }
    assert!(
        (with_pointing(&format!("[pointing]\n{slews}")).unwrap().pointing.slews[0].axis[2] - 1.0).abs()
            < 1e-15
    );
}

#[test]
fn a_pointing_that_cannot_be_names_line_and_key() {
    let spin = "[pointing]\nlaw = \"spin\"\nra_deg = 1.0\ndec_deg = 2.0\n";
    let slew = |start: &str, duration: &str, axis: &str, angle: &str| {
        format!(
            "[[pointing.slews]]\nstart_s = {start}\nduration_s = {duration}\naxis = {axis}\nangle_deg = {angle}\n"
        )
    };
    let good = slew("10.0", "30.0", "[1.0, 0.0, 0.0]", "20.0");
    let cases = [
        ("[pointing]\nlaw = \"moon\"".into(), 1, "pointing.law: unknown law \"moon\""),
        ("[pointing]\nlaw = \"inertial\"\nra_deg = 1.0".into(), 1, "pointing.dec_deg: is missing"),
        (
            "[pointing]\nlaw = \"inertial\"\nra_deg = 1.0\ndec_deg = 91.0".into(),
            3,
            "pointing.dec_deg: 91 is out",
        ),
        ("[pointing]\nra_deg = 1.0".into(), 1, "pointing.ra_deg: means nothing under the law \"nadir\""),
        (spin.into(), 1, "pointing.rate_deg_s: is missing"),
        (format!("{spin}rate_deg_s = [15.5, 0.0, 0.0]"), 4, "pointing.rate_deg_s: 15.5 is out of range"),
        (format!("{spin}rate_deg_s = [12.0, 12.0, 0.0]"), 4, "pointing.rate_deg_s: 16.971 deg/s in all"),
        (
            format!("{spin}rate_deg_s = [1.0, 0.0, 0.0]\ninertia = [1.0, 1.0, 2.5]"),
            5,
            "pointing.inertia: one moment",
        ),
        (
            format!("{spin}rate_deg_s = [1.0, 0.0, 0.0]\ninertia = [0.0, 1.0, 1.0]"),
            5,
            "pointing.inertia: 0 is out",
        ),
        (format!("{spin}rate_deg_s = [1.0, 0.0, 0.0]\n{good}"), 5, "pointing.slews: means nothing"),
        (slew("10.0", "-3.0", "[1.0, 0.0, 0.0]", "5.0"), 2, "pointing.slews.duration_s: -3 is out of range"),
        (slew("10.0", "3.0", "[0.0, 0.0, 0.0]", "5.0"), 3, "pointing.slews.axis: has no length"),
        (
            slew("10.0", "3.0", "[1.0, 0.0, 0.0]", "25.0"),
            2,
            "pointing.slews.duration_s: turns at up to 15.625",
        ),
        (
            format!("{good}{}", slew("39.0", "3.0", "[1.0, 0.0, 0.0]", "5.0")),
            6,
            "pointing.slews.start_s: begins before",
        ),
        (
            "[pointing.jitter]\ncorrelation_s = 0.0".into(),
            1,
            "pointing.jitter.correlation_s: 0 is out of range",
        ),
        (
            "[pointing.jitter]\nrandom_arcsec = [-1.0, 0.0, 0.0]".into(),
            1,
            "pointing.jitter.random_arcsec: -1 is out",
        ),
        (
            "[[pointing.jitter.lines]]\nfrequency_hz = 1e9\namplitude_arcsec = [1.0, 0.0, 0.0]".into(),
            1,
            "pointing.jitter.lines.frequency_hz: 1000000000 is out of range",
        ),
    ];
    for (text, below, words) in cases {
        let text: String = text;
        let message = with_pointing(&text).expect_err(&text);
        let line = line_of("[pointing]") + below;
        assert!(message.starts_with(&format!("sil-host: some.toml:{line}: {words}")), "{message}");
        assert!(message.contains("; ") && !message.contains('\n'), "{message}");
    }
}

#[test]
fn instruments_are_on_board_where_their_table_is() {
    let with = |tables: &str| {
        let text = default_text().replacen("[limits]", &format!("{tables}\n[limits]"), 1);
        Scenario::parse(Path::new("some.toml"), &text).map_err(|error| error.to_string())
    };
    let none = with("").unwrap();
    assert!(none.gyro.is_none() && none.magnetometer.is_none());
    let both = with("[gyro]\n[magnetometer]\nhard_iron_ut = [1.0, 2.0, 3.0]").unwrap();
    assert_eq!(both.gyro.map(|gyro| gyro.noise_deg_s), Some(0.22));
    assert!(both.flight_parameters(None).rate_sensor.is_none(), "too noisy to fly by");
    // A noise of 0.22 deg/s and steps of 0.07 in a second, less 20 % that are not believed; 5 px of 75
    // arcsec.
    let words = both.unused_gyro().expect("the thesis's gyro loses the stars");
    assert!(words.contains("it loses 0.18 deg") && words.contains("at most 0.03 deg"), "{words}");
    assert!(none.unused_gyro().is_none());
    let quiet = with("[gyro]\nnoise_deg_s = 0.0005\nresolution_deg_s = 0.0\nbias_deg_s = 0.01").unwrap();
    assert!(quiet.unused_gyro().is_none());
    // The flight code expects some noise of any.
    let none_at_all = with("[gyro]\nnoise_deg_s = 0.0\nresolution_deg_s = 0.0").unwrap();
    let words = none_at_all.unused_gyro().unwrap();
    assert!(words.contains("as rate_sensor.white_rad is outside its range: it loses 0.00 deg"), "{words}");
    let noise = quiet.flight_parameters(None).rate_sensor.unwrap();
    // 0.0005 deg/s, of which the data sheet tells four fifths.
    assert!((noise.white_rad - 6.981e-6).abs() < 1e-8, "{noise:?}");
    assert_eq!(both.magnetometer.map(|magnetometer| magnetometer.hard_iron_ut), Some([1.0, 2.0, 3.0]));
    let line = line_of("[limits]") + 1;
    for (tables, words) in [
        ("[gyro]\nnoise_deg_s = -1.0", "gyro.noise_deg_s: -1 is out of range"),
        ("[magnetometer]\nrange_ut = 0.0", "magnetometer.range_ut: 0 is out of range"),
    ] {
        let message = with(tables).unwrap_err();
        assert!(message.contains(&format!("some.toml:{line}: {words}")), "{message}");
    }
    assert!(with("[gyro]\ncolour = 1").unwrap_err().contains("`colour`"));
}

#[test]
fn what_shines_in_the_sky_can_be_switched_off() {
    let with = |table: &str| {
        let text = default_text().replacen("[limits]", &format!("[sky]\n{table}\n[limits]"), 1);
        Scenario::parse(Path::new("some.toml"), &text).map_err(|error| error.to_string())
    };
    assert_eq!(with("").unwrap().bodies, BodiesModel::ALL);
    let none = "planets = false\nmoon = false\nsun_light = false\nsatellites_an_hour = 0.0";
    assert_eq!(with(none).unwrap().bodies, BodiesModel::NONE);
    let line = line_of("[limits]") + 1;
    let message = with("satellites_an_hour = -1.0").unwrap_err();
    assert!(message.contains(&format!("some.toml:{line}: sky.satellites_an_hour: -1 is out")), "{message}");
}
