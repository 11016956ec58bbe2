//! The XTCE description of telemetry and telecommands: valid by the standard's schema, and enough, without
//! any code of this project, to read a flight's frames and the command link's reports and to write its
//! telecommands.

mod decoder;
mod document;
mod encoder;

use decoder::{Decoder, Values};
use document::Element;
use encoder::Arguments;
use fsw_core::command::ground::{self, Envelope};
use fsw_core::command::telecommand::{ROWS, Telecommand};
use fsw_core::command::{
    CommandLink, CommandOutcome, Downlink, GroundOrbit, MAX_REPORT_BYTES, MAX_TELECOMMAND_BYTES,
    TimeCorrelation,
};
use fsw_core::image::Detection;
use fsw_core::orbit::OrbitState;
use fsw_core::parameters::{MAX_TABLE_BYTES, Parameters};
use fsw_core::telemetry::{self, Event};
use fsw_hal::{Area, LocalTime, OpenPaths};
use serde_json::Value;
use sil_host::commands::record::mission::MISSION;
use sil_host::commands::record::record_flight;
use sil_host::flight;
use sil_host::formats::camera_file::CameraFile;
use std::process::Command;
use system_tests::{json_lines, python, run, scratch};

const APID: u16 = 0x2A5;

fn description() -> (String, Element) {
    let output = run(&["telemetry", "--xtce"]);
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    let system = Element::read(&text);
    assert_eq!(system.name, "SpaceSystem");
    (text, system)
}

/// A decoded report's values under the description's names. An enumeration that holds something is an object
/// whose key begins with a capital letter.
fn flattened(path: &str, value: &Value, into: &mut Values) {
    let mut put = |path: &str, shown: String| into.entry(path.into()).or_default().push(shown);
    match value {
        Value::Null => {}
        Value::String(label) => put(path, label.clone()),
        Value::Array(values) => values.iter().for_each(|value| flattened(path, value, into)),
        Value::Object(fields) => {
            for (name, value) in fields {
                let longer = if path.is_empty() { name.clone() } else { format!("{path}-{name}") };
                if !name.starts_with(char::is_uppercase) {
                    flattened(&longer, value, into);
                    continue;
                }
                into.entry(path.into()).or_default().push(name.clone());
                match value {
                    Value::Array(held) => held
                        .iter()
                        .enumerate()
                        .for_each(|(number, held)| flattened(&format!("{longer}-{number}"), held, into)),
                    held => flattened(&longer, held, into),
                }
            }
        }
        other => put(path, other.to_string()),
    }
}

/// The values that a report has, without what the encoding adds.
fn of_report(values: Values) -> Values {
    let added = |name: &str| {
        let ends = [["-present", "-count"], ["-more-", "-bits-"]];
        name.starts_with("frame-")
            || name.starts_with("ccsds-")
            || ends[0].iter().any(|end| name.ends_with(end))
            || ends[1].iter().any(|part| name.contains(part))
    };
    values.into_iter().filter(|(name, _)| !added(name)).collect()
}

#[test]
fn a_flights_frames_are_read_by_the_description_alone_as_decode_reads_them() {
    let folder = scratch("xtce");
    record_flight(&MISSION, &folder).expect("the flight can be recorded");
    let path = folder.join("telemetry.bin");
    let stream = std::fs::read(&path).unwrap();
    let decoded = json_lines(&run(&["decode", path.to_str().unwrap(), "--json"]));
    let (_, system) = description();
    let mut decoder = Decoder::new(&system);
    let (mut rest, mut values_in_all) = (&stream[..], 0);
    for (number, report) in decoded.iter().enumerate() {
        let (frame, behind) = telemetry::split_first(rest).unwrap();
        let led = &rest[..rest.len() - behind.len()];
        rest = behind;
        let mut expected = Values::new();
        flattened("", report, &mut expected);
        let (kind, values) = decoder.decode("StreamFrame", led).unwrap();
        let values = of_report(values);
        assert_eq!((kind, &values), ("StreamFrame", &expected), "second {number}");
        values_in_all += values.values().map(Vec::len).sum::<usize>();
        // The same in a space packet, as a spacecraft may carry it.
        let mut packet =
            [APID, 0xC000 | number as u16, frame.len() as u16 - 1].map(u16::to_be_bytes).concat();
        packet.extend(frame);
        let (kind, values) = decoder.decode("SpacePacket", &packet).unwrap();
        assert_eq!((kind, of_report(values)), ("FramePacket", expected), "second {number}");
    }
    assert!(rest.is_empty());
    println!("{} frames, {values_in_all} values", decoded.len());
    // A turned bit is found by the checksum that the description gives: here of the counter, behind length,
    // version and cycle.
    let mut frame = stream[..2 + usize::from(u16::from_le_bytes([stream[0], stream[1]]))].to_vec();
    frame[4] ^= 1;
    assert!(decoder.decode("StreamFrame", &frame).unwrap_err().contains("checksum"));
    let _ = std::fs::remove_dir_all(&folder);
}

fn arguments(values: &[(&str, &str)]) -> Arguments {
    values.iter().map(|(name, value)| ((*name).into(), (*value).into())).collect()
}

#[test]
fn telecommands_are_written_by_the_description_alone_to_the_byte() {
    let (_, system) = description();
    let orbit = GroundOrbit {
        state: OrbitState {
            time_us: -800_000_000_000_001,
            position_km: [42_164.0, -1.5, 0.0].into(),
            velocity_km_s: [0.0, 3.0746, 1e-9].into(),
        },
        position_sigma_km: 10.0,
        velocity_sigma_km_s: 0.01,
    };
    let time = TimeCorrelation { local: LocalTime::from_us(5_000_000), terrestrial_us: 800_000_000_000_000 };
    let all = [
        ("reacquire", Telecommand::Reacquire, vec![]),
        ("restart", Telecommand::Restart, vec![]),
        ("safe", Telecommand::Safe, vec![]),
        ("exposure", Telecommand::Exposure(50_000), vec![("exposure_us", "50000")]),
        (
            "orbit",
            Telecommand::Orbit(orbit),
            vec![
                ("time_us", "-800000000000001"),
                ("position_km-0", "42164"),
                ("position_km-1", "-1.5"),
                ("position_km-2", "0"),
                ("velocity_km_s-0", "0"),
                ("velocity_km_s-1", "3.0746"),
                ("velocity_km_s-2", "1e-9"),
                ("position_sigma_km", "10"),
                ("velocity_sigma_km_s", "0.01"),
            ],
        ),
        (
            "time",
            Telecommand::Time(time),
            vec![("local_us", "5000000"), ("terrestrial_us", "800000000000000")],
        ),
        ("shutter", Telecommand::Shutter(Some(OpenPaths::Star)), vec![("paths", "2")]),
        (
            "part",
            Telecommand::Part { area: Some(Area::Catalogue), offset: 100_000, bytes: &[1, 2, 255] },
            vec![("area", "1"), ("offset", "100000"), ("bytes", "0102ff"), ("packet_length", "15")],
        ),
        (
            "load",
            Telecommand::Load { area: None, length: 1234, crc: 0xDEAD_BEEF },
            vec![("area", "0"), ("length", "1234"), ("crc", "3735928559")],
        ),
        ("dump", Telecommand::Dump, vec![]),
        ("events", Telecommand::Events, vec![]),
        ("spots", Telecommand::Spots, vec![]),
    ];
    assert_eq!(all.len(), ROWS.len());
    for (sequence, (name, telecommand, given)) in (7u16..).zip(all) {
        let envelope = Envelope { apid: APID, sequence, authentication: None };
        let mut buffer = [0; MAX_TELECOMMAND_BYTES];
        let expected = ground::encode(&telecommand, &envelope, &mut buffer).unwrap();
        let count = sequence.to_string();
        // Acceptance and completion are to be reported with all four flags.
        let headers = [("apid", "677"), ("sequence_count", &count), ("acknowledge", "15"), ("source", "0")];
        let given = arguments(&[&headers[..], &given].concat());
        assert_eq!(encoder::encode(&system, name, &given), expected, "{name}");
    }
}

/// At column 100.5 and row 10.25.
const SPOT: Detection = Detection {
    x_q16: 0x64_8000,
    y_q16: 0x0A_4000,
    flux: 40,
    core_flux: 30,
    sigma_q16: 0x600,
    saturated: false,
    extended: false,
    drawn_px: 5,
    blended: false,
    repeated: true,
    number: 7,
    backdrop: 0,
};

#[test]
fn the_command_links_reports_are_read_by_the_description_alone() {
    let (_, system) = description();
    let mut decoder = Decoder::new(&system);
    let mut link = CommandLink::new(APID, None, 0);
    let camera = flight::camera_parameters(&CameraFile::reference());
    let parameters = Parameters::for_camera(camera);
    let send = |link: &mut CommandLink, sequence: u16, telecommand: Telecommand| {
        let envelope = Envelope { apid: APID, sequence, authentication: None };
        let mut buffer = [0; MAX_TELECOMMAND_BYTES];
        let packet = ground::encode(&telecommand, &envelope, &mut buffer).unwrap().to_vec();
        let _ = link.receive(&packet);
    };
    let told = Downlink { parameters: &parameters, image: LocalTime::from_us(12_000_000), spots: &[SPOT] };
    let now = LocalTime::from_us(12_500_000);
    let mut next = |link: &mut CommandLink| {
        let mut buffer = [0; MAX_REPORT_BYTES];
        let packet = link.next_report(now, &told, &mut buffer)?.to_vec();
        let (kind, values) = decoder.decode("SpacePacket", &packet).unwrap();
        assert_eq!((&values["report-seconds"][0][..], &values["report-fraction"][0][..]), ("12", "0.5"));
        assert_eq!(values["ccsds-apid"], ["677"]);
        Some((kind, values))
    };
    send(&mut link, 7, Telecommand::Safe);
    let (kind, values) = next(&mut link).unwrap();
    assert_eq!((kind, &values["request-sequence_count"][0][..]), ("Accepted", "7"));
    send(&mut link, 8, Telecommand::Restart);
    let (kind, values) = next(&mut link).unwrap();
    assert_eq!((kind, &values["request-reason"][0][..]), ("NotAccepted", "Busy"));
    link.conclude(Some(CommandOutcome::Done));
    assert_eq!(next(&mut link).unwrap().0, "Completed");
    send(&mut link, 9, Telecommand::Exposure(1));
    assert_eq!(next(&mut link).unwrap().0, "Accepted");
    link.conclude(Some(CommandOutcome::Refused(fsw_core::command::refusal::Refusal::Exposure)));
    let (kind, values) = next(&mut link).unwrap();
    assert_eq!((kind, &values["request-reason"][0][..]), ("NotCompleted", "Exposure"));
    // The table comes down in parts, and is the one in force.
    send(&mut link, 10, Telecommand::Dump);
    let mut table = String::new();
    while let Some((kind, values)) = next(&mut link) {
        if kind == "TablePart" {
            assert_eq!(values["table-offset"], [(table.len() / 2).to_string()]);
            table += &values["table-bytes"][0];
        }
    }
    let mut buffer = [0; MAX_TABLE_BYTES];
    let expected: String =
        parameters.encode(&mut buffer).unwrap().iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(table, expected);
    // The log of events.
    link.log(77, &[Event::ClockJump]);
    send(&mut link, 11, Telecommand::Events);
    assert_eq!(next(&mut link).unwrap().0, "Accepted");
    let (kind, values) = next(&mut link).unwrap();
    assert_eq!(
        (kind, &values["events-first"][0][..], &values["events-left"][0][..]),
        ("EventsPart", "0", "1")
    );
    assert_eq!(values["events-bytes"], ["0000004d060000"]);
    // The spots of an image.
    send(&mut link, 12, Telecommand::Spots);
    assert_eq!(next(&mut link).unwrap().0, "Completed");
    assert_eq!(next(&mut link).unwrap().0, "Accepted");
    let (kind, values) = next(&mut link).unwrap();
    assert_eq!((kind, &values["spots-image"][0][..]), ("SpotsPart", "12000000"));
    assert_eq!(values["spots-left"], ["1"]);
    assert_eq!(values["spots-bytes"], ["00648000000a40000000001e06000708"]);
}

#[test]
fn the_document_is_valid_by_the_standards_schema() {
    let Some(python) = python() else { return };
    let path = scratch("xtce-schema").join("sextant.xml");
    std::fs::write(&path, description().0).unwrap();
    // The schema comes with the package.
    let program = "import sys; from space_packet_parser.xtce.validation import validate_xtce; \
                   print(validate_xtce(sys.argv[1], level='schema', allow_schema_download=False).valid)";
    let output = Command::new(python).args(["-c", program]).arg(&path).output().unwrap();
    let words = [output.stdout, output.stderr].map(|words| String::from_utf8_lossy(&words).into_owned());
    assert!(output.status.success() && words[0].trim_end().ends_with("True"), "{words:?}");
}
