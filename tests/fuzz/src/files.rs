//! The files that people give to the host: pictures, scenarios, cameras, orbits. Each is read or refused in
//! one line.

use sil_host::formats::camera_file::CameraFile;
use sil_host::formats::picture::Picture;
use sil_host::scenario::Scenario;
use sil_host::world::orbit::{oem, sp3};
use std::path::Path;

/// An error is one line.
fn has_message(message: &impl std::fmt::Display) {
    let message = message.to_string();
    assert!(!message.is_empty() && !message.contains('\n'), "{message}");
}

/// Tries the bytes.
pub fn try_bytes(bytes: &[u8]) {
    let Some((kind, content)) = bytes.split_first() else { return };
    if kind % 5 == 0 {
        match Picture::decode(content) {
            Ok(picture) => assert!(!picture.pixels().is_empty()),
            Err(fault) => has_message(&fault),
        }
        return;
    }
    let Ok(text) = std::str::from_utf8(content) else { return };
    let path = Path::new("fuzz");
    match kind % 5 {
        1 => _ = Scenario::parse(path, text).map_err(|fault| has_message(&fault)),
        2 => _ = CameraFile::parse(path, text).map_err(|fault| has_message(&fault)),
        3 => _ = oem::read(text),
        _ => _ = sp3::read(text, None),
    }
}
