//! Telemetry read as a ground system in another language would: by the printed layout alone. And `decode`.

use fsw_core::telemetry;
use serde_json::{Map, Value, json};
use sil_host::commands::record::mission::MISSION;
use sil_host::commands::record::record_flight;
use sil_host::commands::telemetry::layout;
use system_tests::{json_lines, run, scratch};

/// Reads values by a layout; whatever is not as it says panics.
struct Reader<'a> {
    types: &'a Map<String, Value>,
    bytes: &'a [u8],
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (taken, rest) = self.bytes.split_first_chunk().expect("enough bytes");
        self.bytes = rest;
        *taken
    }

    fn whole(&mut self) -> u64 {
        let (mut value, mut shift) = (0, 0);
        loop {
            let [byte] = self.take();
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return value;
            }
            shift += 7;
        }
    }

    fn many(&mut self, count: u64, of: &Value) -> Value {
        (0..count).map(|_| self.value(of)).collect::<Vec<_>>().into()
    }

    fn value(&mut self, of: &Value) -> Value {
        let Some(name) = of.as_str() else {
            if let Some(of) = of.get("option") {
                return if self.take() == [0] { Value::Null } else { self.value(of) };
            }
            if let Some(of) = of.get("list") {
                let count = self.whole();
                return self.many(count, of);
            }
            return self.many(of["array"][1].as_u64().unwrap(), &of["array"][0]);
        };
        match name {
            "bool" => json!(self.take() == [1]),
            "u8" => json!(self.take::<1>()[0]),
            "u16" | "u32" => json!(self.whole()),
            "i64" => {
                let folded = self.whole();
                json!((folded >> 1) as i64 ^ -((folded & 1) as i64))
            }
            "f32" => json!(f32::from_le_bytes(self.take())),
            "f64" => json!(f64::from_le_bytes(self.take())),
            _ => self.compound(&self.types[name].clone()),
        }
    }

    fn compound(&mut self, described: &Value) -> Value {
        if let Some(fields) = described["fields"].as_array() {
            let value = |field: &Value| (field["name"].as_str().unwrap().into(), self.value(&field["type"]));
            return Value::Object(fields.iter().map(value).collect());
        }
        let variant = &described["variants"][self.whole() as usize];
        match &variant["types"].as_array().unwrap()[..] {
            [] => variant["name"].clone(),
            [one] => json!({ variant["name"].as_str().unwrap(): self.value(one) }),
            several => {
                let values: Vec<_> = several.iter().map(|of| self.value(of)).collect();
                json!({ variant["name"].as_str().unwrap(): values })
            }
        }
    }
}

#[test]
fn frames_are_read_by_the_printed_layout_alone_and_by_decode() {
    let folder = scratch("telemetry-layout");
    record_flight(&MISSION, &folder).expect("the flight can be recorded");
    let path = folder.join("telemetry.bin");
    let mut stream = std::fs::read(&path).unwrap();
    let layout = layout();
    let types = layout["types"].as_object().unwrap();
    let mut by_layout = Vec::new();
    let mut rest = &stream[..];
    while let Some((frame, behind)) = telemetry::split_first(rest) {
        assert_eq!(layout["version"], frame[0]);
        let mut reader = Reader { types, bytes: &frame[1..frame.len() - 4] };
        let report = reader.value(&layout["root"]);
        assert!(reader.bytes.is_empty(), "{} bytes left", reader.bytes.len());
        assert_eq!(report, serde_json::to_value(telemetry::decode(frame).unwrap()).unwrap());
        by_layout.push(report);
        rest = behind;
    }
    let some = |key: &str| by_layout.iter().filter(|report| !report[key].is_null()).count();
    assert!(some("attitude") > 100 && some("earth") > 10 && some("orbit") > 10, "a flight that tells much");

    let decoded = run(&["decode", path.to_str().unwrap(), "--json"]);
    assert!(decoded.status.success());
    // Shortest decimals: an f32 comes back as such.
    let lines = json_lines(&decoded);
    assert_eq!(lines.len(), by_layout.len());
    assert!(lines.iter().zip(&by_layout).all(|(line, report)| line["events"] == report["events"]));
    assert_eq!(lines[100]["orbit"]["position_km"], by_layout[100]["orbit"]["position_km"]);

    // A flipped bit costs its frame, and the status; a torn end is named behind what was read.
    stream[40] ^= 4;
    std::fs::write(&path, &stream).unwrap();
    let broken = run(&["decode", path.to_str().unwrap()]);
    let stderr = String::from_utf8_lossy(&broken.stderr).into_owned();
    assert_eq!((broken.status.code(), stderr.lines().count()), (Some(2), 1), "{stderr}");
    assert!(stderr.contains("byte 0: ") && stderr.contains("bytes are damaged and skipped"), "{stderr}");
    assert_eq!(String::from_utf8_lossy(&broken.stdout).lines().count(), by_layout.len() - 1);
    // So does a damaged length: the frames behind it are found again.
    stream[40] ^= 4;
    stream[1] ^= 0x40;
    std::fs::write(&path, &stream).unwrap();
    let lost = run(&["decode", path.to_str().unwrap()]);
    assert_eq!(String::from_utf8_lossy(&lost.stderr).lines().count(), 1);
    assert_eq!(String::from_utf8_lossy(&lost.stdout).lines().count(), by_layout.len() - 1);
    stream[1] ^= 0x40;
    stream.truncate(stream.len() - 5);
    std::fs::write(&path, &stream).unwrap();
    let torn = run(&["decode", path.to_str().unwrap()]);
    assert_eq!(torn.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&torn.stderr).contains("breaks off"));
    assert_eq!(String::from_utf8_lossy(&torn.stdout).lines().count(), by_layout.len() - 1);
    let _ = std::fs::remove_dir_all(&folder);
}
