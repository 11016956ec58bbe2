//! The flight code's working memory, and the bits of it that a flight turns over.
//!
//! In: the seed of a flight, its seconds. Out: [`Flip`]s that depend on these alone. Half of them are
//! anywhere in the memory, each bit as likely, as upsets are; most of that is the buffer of pixels, which is
//! written anew before it is read. The other half are in [`Sensor`] alone, a quarter of the memory, where
//! the attitude, the orbit and the parameters lie.

use fsw_core::sensor::{Sensor, Workspace};
use serde::{Deserialize, Serialize};
use sil_host::world::noise::{Noise, Stream};

/// Bytes of the state, the parameters among them.
pub const STATE_BYTES: usize = size_of::<Sensor>();
/// Bytes of the workspace.
pub const WORKSPACE_BYTES: usize = size_of::<Workspace>();

/// A part of the memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// [`Sensor`].
    State,
    /// [`Workspace`].
    Workspace,
}

/// A bit that is turned over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Flip {
    /// Before this second, from 1.
    pub second: u32,
    /// Where.
    pub part: Part,
    /// Byte of the part.
    pub byte: usize,
    /// Bit of the byte, the least 0.
    pub bit: u8,
}

/// The flips of a flight of so many seconds, in their order: one in each of `count` parts of it.
pub fn flips(flight_seed: u64, seconds: u32, count: u32) -> Vec<Flip> {
    let noise = Noise::new(flight_seed, 0, Stream::Upset);
    let flip = |index: u32| {
        let place = |slot, ends: usize| (noise.uniform(index, slot) * ends as f64) as usize;
        let late = (f64::from(index) + noise.uniform(index, 0)) / f64::from(count);
        let anywhere = place(2, STATE_BYTES + WORKSPACE_BYTES);
        let (part, byte) = if noise.uniform(index, 1) < 0.5 {
            (Part::State, place(3, STATE_BYTES))
        } else if anywhere < STATE_BYTES {
            (Part::State, anywhere)
        } else {
            (Part::Workspace, anywhere - STATE_BYTES)
        };
        let second = 1 + (late * f64::from(seconds.saturating_sub(1))) as u32;
        Flip { second, part, byte, bit: place(4, 8) as u8 }
    };
    (0..count).map(flip).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flips_are_those_of_the_seed_spread_over_flight_and_memory() {
        let all: Vec<Flip> = (0..500).flat_map(|seed| flips(seed, 160, 4)).collect();
        assert_eq!(all[..4], flips(0, 160, 4));
        assert!(all.iter().all(|flip| (1..160).contains(&flip.second) && flip.bit < 8));
        let in_state: Vec<&Flip> = all.iter().filter(|flip| flip.part == Part::State).collect();
        assert!(in_state.iter().all(|flip| flip.byte < STATE_BYTES));
        let outside = all.iter().filter(|flip| flip.part == Part::Workspace);
        assert!(outside.clone().all(|flip| flip.byte < WORKSPACE_BYTES));
        // 1,000 of the 2,000, and what of the others falls there; sigma 22.
        let share = STATE_BYTES as f64 / (STATE_BYTES + WORKSPACE_BYTES) as f64;
        let expected = 1000.0 * (1.0 + share);
        assert!((in_state.len() as f64 - expected).abs() < 90.0, "{} of {expected}", in_state.len());
        for quarter in all.chunks(4) {
            assert!(quarter.windows(2).all(|pair| pair[0].second <= pair[1].second));
            assert!(quarter[0].second <= 40 && quarter[3].second >= 120);
        }
    }
}
