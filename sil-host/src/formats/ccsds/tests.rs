use super::*;
use crate::world::orbit::oem;
use crate::world::orbit::track::Frame;
use std::path::PathBuf;

const START_US: i64 = 843_458_400_000_000;

fn name() -> RunName {
    RunName {
        object: "a-run".into(),
        centre: fsw_core::orbit::body::CentralBody::Earth,
        comment: "made up",
        start_us: START_US,
        end_us: START_US + 100_000_000,
    }
}

fn scratch(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("sextant-ccsds-{}-{name}", std::process::id()))
}

/// Value of a key in the `segment`-th metadata.
fn value(text: &str, segment: usize, key: &str) -> String {
    let begins = format!("{key} = ");
    let line = text.lines().filter_map(|line| line.strip_prefix(&begins)).nth(segment);
    line.unwrap().to_owned()
}

#[test]
fn an_orbit_read_again_has_its_states_and_a_gap_divides_segments() {
    let path = scratch("orbit.oem");
    let mut file = MessageFile::create(&path, Message::Orbit, name()).unwrap();
    let place = |second: i64| [7000.125 + second as f64, -0.000_25, 1.0 / 3.0];
    let covariance: MotionCovariance =
        std::array::from_fn(|row| std::array::from_fn(|column| (10 * row + column) as f64));
    for second in [0, 1, 2, 30, 31] {
        let [x, y, z] = place(second);
        let state = [x, y, z, 0.0, 7.5, -1e-9];
        file.add(START_US + second * 1_000_000, &state, Some(&covariance)).unwrap();
    }
    file.finish().unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let segments = oem::read(&text).unwrap();
    assert_eq!((segments.len(), segments[0].frame), (2, Frame::Gcrf));
    for (segment, seconds) in segments.iter().zip([vec![0, 1, 2], vec![30, 31]]) {
        assert_eq!(segment.places.len(), seconds.len());
        for ((instant_us, found), second) in segment.places.iter().zip(seconds) {
            assert_eq!(*instant_us, START_US + second * 1_000_000);
            assert!(found.iter().zip(place(second)).all(|(one, other)| (one - other).abs() <= 5e-7));
        }
    }
    // Each segment says when it ends, and has one covariance: the gap between two is a minute.
    for (segment, last) in [(0, 2), (1, 31)] {
        assert_eq!(value(&text, segment, "STOP_TIME"), shown_text(START_US + last * 1_000_000));
    }
    let blocks: Vec<&str> = text.split("COVARIANCE_START\n").skip(1).collect();
    assert_eq!(blocks.len(), 2);
    let rows: Vec<Vec<f64>> = blocks[0]
        .lines()
        .skip(2)
        .take(MOTION)
        .map(|row| row.split(' ').map(|element| element.parse().unwrap()).collect())
        .collect();
    assert!(rows.iter().enumerate().all(|(row, elements)| *elements == covariance[row][..=row]));
    std::fs::remove_file(&path).unwrap();
}

#[test]
fn an_attitude_has_its_frames_and_a_killed_run_leaves_whole_lines() {
    let path = scratch("attitude.aem");
    let mut file = MessageFile::create(&path, Message::Attitude, name()).unwrap();
    file.add(START_US, &[0.5, -0.5, 0.5, 0.5], None).unwrap();
    file.flush().unwrap();
    file.add(START_US + 1_000_000, &[0.5, -0.5, 0.5, 0.5], None).unwrap();
    drop(file);
    assert!(!path.exists());
    let partial = path.with_extension("aem.partial");
    let text = std::fs::read_to_string(&partial).unwrap();
    for (key, expected) in [
        ("CCSDS_AEM_VERS", "1.0"),
        ("REF_FRAME_A", "ICRF"),
        ("REF_FRAME_B", "SENSOR_1"),
        ("ATTITUDE_DIR", "A2B"),
        ("TIME_SYSTEM", "TT"),
        ("QUATERNION_TYPE", "LAST"),
        ("STOP_TIME", &shown_text(name().end_us)),
    ] {
        assert_eq!(value(&text, 0, key), expected);
    }
    let last = text.lines().last().unwrap();
    assert_eq!(last, format!("{} 0.500000000 -0.500000000 0.500000000 0.500000000", shown_text(START_US)));
    std::fs::remove_file(&partial).unwrap();
}
