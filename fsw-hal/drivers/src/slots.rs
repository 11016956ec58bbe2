//! Two slots of a flash that are written in turn, so that a loss of power leaves one of them.
//!
//! In: the sequence numbers that stand in the slots, each one more than that of the other, modulo 2^32. Out:
//! which slot is the newer, which is written next, and with which number.

/// The newer of two slots and what it holds, numbered by `sequence`; `None` where neither holds anything
/// whole.
pub(crate) fn newer<T>(slots: [Option<T>; 2], sequence: impl Fn(&T) -> u32) -> Option<(usize, T)> {
    let follows = |one: &T, other: &T| sequence(one).wrapping_sub(sequence(other)) as i32 > 0;
    match slots {
        [Some(first), Some(second)] if follows(&second, &first) => Some((1, second)),
        [Some(first), _] => Some((0, first)),
        [None, second] => second.map(|second| (1, second)),
    }
}

/// The slot that is written next, and its sequence number, where this one holds the newer.
pub(crate) fn next(newer: Option<(usize, u32)>) -> (usize, u32) {
    newer.map_or((0, 0), |(slot, sequence)| (1 - slot, sequence.wrapping_add(1)))
}

/// Whether `bytes` are a whole number of pieces of `size`.
pub(crate) fn divides(size: usize, bytes: usize) -> bool {
    bytes.checked_rem(size) == Some(0)
}
