//! Telemetry streams and parameter tables: what opens, closes and opens again is the same; the rest is
//! refused.

use fsw_core::packet;
use fsw_core::parameters::{MAX_TABLE_BYTES, Parameters};
use fsw_core::telemetry::{self, MAX_FRAME_BYTES, Report};

/// Any version will do.
const VERSION: u8 = 1;

/// Tries the bytes.
pub fn try_bytes(bytes: &[u8]) {
    let mut stream = bytes;
    while let Some((frame, rest)) = telemetry::split_first(stream) {
        assert!(rest.len() < stream.len());
        let _ = telemetry::decode(frame);
        stream = rest;
    }
    let packet = crate::sealed_packet(VERSION, bytes);
    if let Ok(report) = packet::decode::<Report>(VERSION, &packet) {
        let mut buffer = [0; MAX_FRAME_BYTES];
        let frame = telemetry::encode(&report, &mut buffer).expect("the buffer holds every frame").to_vec();
        let again = telemetry::decode(&frame).expect("what was closed opens");
        assert_eq!(telemetry::encode(&again, &mut buffer).map(<[u8]>::to_vec), Ok(frame));
    }
    if let Ok(table) = packet::decode::<Parameters>(VERSION, &packet) {
        let _ = table.check();
        let mut buffer = [0; MAX_TABLE_BYTES];
        let closed = table.encode(&mut buffer).expect("the buffer holds every table").to_vec();
        let again = Parameters::decode(&closed).expect("what was closed opens");
        assert_eq!(again.encode(&mut buffer).map(<[u8]>::to_vec), Ok(closed));
    }
}
