//! Registers of the CMV4000 and their words on the bus.

/// `number_lines`, 2 bytes, and `start1`, 2 bytes.
const ROWS: u8 = 1;
/// `image_flipping`, and the exposure's mode.
const MODES: u8 = 40;
/// `exp_time`, 3 bytes.
const EXPOSURE: u8 = 42;
/// `number_frames`, 2 bytes, and `output_mode`.
const FRAMES: u8 = 70;
/// `fot_length`, row times.
pub(super) const FOT_LENGTH: u8 = 73;
/// `bit_mode`, and `adc_resolution`.
const BITS: u8 = 111;

/// Whether an address is left to the board's table.
pub(super) fn is_analogue(address: u8) -> bool {
    address < 128 && !matches!(address, 1..=4 | 40..=44 | 70..=72 | 111..=112)
}

/// Addresses and values of a window of rows, its first and their number, with one frame a request, 10 bits
/// and this output mode.
pub(super) fn of_frame(
    (first, count): (u16, u16),
    output_mode: u8,
) -> impl Iterator<Item = (u8, u8)> + use<> {
    let [[count_low, count_high], [first_low, first_high]] = [count.to_le_bytes(), first.to_le_bytes()];
    let rows = (ROWS..).zip([count_low, count_high, first_low, first_high]);
    let modes = (MODES..).zip([0, 0]);
    let frames = (FRAMES..).zip([1, 0, output_mode]);
    rows.chain(modes).chain(frames).chain((BITS..).zip([1, 0]))
}

/// Those of an exposure, 24 bits.
pub(super) fn of_exposure(units: u32) -> impl Iterator<Item = (u8, u8)> + use<> {
    (EXPOSURE..).zip(units.to_le_bytes()).take(3)
}

/// The word that writes a register: 1, 7 bits of address, 8 of value.
pub(super) fn write(address: u8, value: u8) -> [u8; 2] {
    [address | 0x80, value]
}

/// The word that reads it; the second byte is replaced by the value.
pub(super) fn read(address: u8) -> [u8; 2] {
    [address & 0x7F, 0]
}
