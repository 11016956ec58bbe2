//! The faults that the page has buttons for: each a fault of [`crate::harness::faults`] for some seconds.

use crate::harness::faults::{Fault, FaultKind};
use serde::Serialize;

/// What a button breaks, and for how long, s.
const BUTTONS: [(&str, FaultKind, u32); 13] = [
    ("Blinded", FaultKind::Blinded, 20),
    ("No image", FaultKind::TimeOut(1.0), 10),
    ("Stale image", FaultKind::LateFrame(1.0), 3),
    ("Repeated image", FaultKind::DoubledImage(1.0), 5),
    ("Late by 3 s", FaultKind::LateImage(3.0), 1),
    ("Lost windows", FaultKind::DroppedWindow(0.1), 20),
    ("Noise", FaultKind::NoiseBurst(30.0), 20),
    ("Bit flips", FaultKind::BitFlips(1e-4), 20),
    ("Stuck row", FaultKind::StuckRow(512), 30),
    ("Protons", FaultKind::ProtonStorm(3000), 30),
    ("Clock +2 s", FaultKind::ClockStep(2.0), 60),
    ("Clock lost", FaultKind::ClockInvalid, 60),
    ("Gyro silent", FaultKind::GyroSilent, 30),
];

/// A button.
#[derive(Debug, Serialize)]
pub struct Button {
    label: &'static str,
    kind: &'static str,
    seconds: u32,
}

/// All buttons, in their order.
pub fn buttons() -> Vec<Button> {
    BUTTONS.map(|(label, kind, seconds)| Button { label, kind: kind.word(), seconds }).into()
}

/// The fault of the button for this kind, from a second on.
pub fn from_second(word: &str, from_s: u32) -> Option<Fault> {
    let (_, kind, seconds) = BUTTONS.into_iter().find(|(_, kind, _)| kind.word() == word)?;
    Some(Fault { kind, from_s, until_s: from_s.saturating_add(seconds) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_button_is_a_kind_of_its_own() {
        let kinds: BTreeSet<&str> = buttons().iter().map(|button| button.kind).collect();
        assert_eq!(kinds.len(), BUTTONS.len());
        let blinded = from_second("blinded", 7).unwrap();
        assert_eq!((blinded.kind, blinded.from_s, blinded.until_s), (FaultKind::Blinded, 7, 27));
        assert_eq!(from_second("none such", 7), None);
    }
}
