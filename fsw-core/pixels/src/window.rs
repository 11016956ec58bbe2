//! Size of a window and of the cells into which its background is divided; the scale of its pixels.
//!
//! Scaled counts: every pixel is brought to one scale, full scale = 2^14 = [`FULL_SCALE`], whatever the
//! converter's resolution, so thresholds mean the same for 8, 10 and 16 bits and a residual fits an `i16`.

/// Full scale of a pixel in scaled counts.
pub const FULL_SCALE: i32 = 1 << 14;
/// Resolution that is kept of a pixel: a scaled count is one of a converter of so many bits.
pub const KEPT_BITS: u8 = FULL_SCALE.ilog2() as u8;
/// Bits of the widest converter.
const MAX_BITS: u8 = 16;

/// Narrowest window, px.
pub const MIN_WIDTH: usize = 16;
/// Widest window, px.
pub const MAX_WIDTH: usize = 128;
/// Tallest window, px.
pub const MAX_HEIGHT: usize = 64;
/// Columns of a cell: a block.
pub const BLOCK: usize = 16;
/// Blocks of the widest window.
pub const BLOCKS: usize = MAX_WIDTH / BLOCK;
/// Rows of a cell: a band; the last band of a window has from half of them to half more.
pub const BAND: usize = 16;
/// Bands of the tallest window.
pub const BANDS: usize = MAX_HEIGHT / BAND;

/// A value for every cell of a window.
pub type Cells<T> = [[T; BLOCKS]; BANDS];

/// Number of bands of a window.
pub fn bands(height: usize) -> usize {
    ((height + BAND / 2) / BAND).clamp(1, BANDS)
}

/// Rows of a band of a window.
pub fn rows_of(band: usize, height: usize) -> core::ops::Range<usize> {
    let first = band * BAND;
    first.min(height)..if band + 1 < bands(height) { first + BAND } else { height }
}

/// The raw value from which on a pixel may have been at full scale: 0.95 of it. A twentieth is left to the
/// converter's last counts, to compression and to colours of which only some were full.
pub const fn saturation(bits: u8) -> u16 {
    let bits = if bits < 1 {
        1
    } else if bits > MAX_BITS {
        MAX_BITS
    } else {
        bits
    };
    let full_scale = ((1u32 << bits) - 1) as u16;
    full_scale - full_scale / 20
}
