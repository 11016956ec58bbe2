//! Times of the CMV4000, all by its input clock: integers, 64 bits.
//!
//! With `n` outputs a row takes `129 * 16 / n` clocks, the frame overhead `129 (fot_length + 2 * 16 / n)`,
//! and an exposure `129 (0.43 fot_length + exp_time)`.

/// Clocks of a row read over 16 outputs, and of a unit of the exposure.
const ROW_CLOCKS: u64 = 129;
/// The share of the frame overhead that still exposes, in hundredths.
const OVERHEAD_EXPOSED: u64 = 43;
/// Largest `exp_time`, 24 bits: 216 s at 10 MHz.
pub const EXPOSURE_MAX: u32 = 0xFF_FFFF;

/// LVDS outputs in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outputs {
    /// All.
    Sixteen,
    /// Every second.
    Eight,
    /// Every fourth.
    Four,
    /// Every eighth.
    Two,
}

impl Outputs {
    /// Value of `output_mode`.
    pub(super) fn mode(self) -> u8 {
        match self {
            Self::Sixteen => 0,
            Self::Eight => 1,
            Self::Four => 2,
            Self::Two => 3,
        }
    }

    /// Row times of 16 outputs that a row takes.
    fn share(self) -> u64 {
        1 << self.mode()
    }
}

/// What the times depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Timing {
    pub(super) clock_hz: u32,
    pub(super) outputs: Outputs,
    pub(super) rows: u16,
    pub(super) fot_length: u8,
}

impl Timing {
    fn us(&self, clocks: u64) -> u64 {
        clocks * 1_000_000 / u64::from(self.clock_hz).max(1)
    }

    /// `exp_time` for an exposure, to the nearest; `None` where the detector cannot do it.
    pub(super) fn exposure_units(&self, exposure_us: u32) -> Option<u32> {
        let hundredths = u64::from(exposure_us) * u64::from(self.clock_hz) / (10_000 * ROW_CLOCKS);
        let rest = hundredths.checked_sub(OVERHEAD_EXPOSED * u64::from(self.fot_length))?;
        let units = (rest + 50) / 100;
        u32::try_from(units).ok().filter(|units| (1..=EXPOSURE_MAX).contains(units))
    }

    /// The exposure that an `exp_time` makes, us.
    pub(super) fn exposure_us(&self, units: u32) -> u64 {
        let hundredths = OVERHEAD_EXPOSED * u64::from(self.fot_length) + 100 * u64::from(units);
        self.us(ROW_CLOCKS * hundredths) / 100
    }

    /// From the end of the exposure to the last pixel, us.
    pub(super) fn readout_us(&self) -> u64 {
        let share = self.outputs.share();
        let rows = u64::from(self.fot_length) + 2 * share + u64::from(self.rows) * share;
        self.us(ROW_CLOCKS * rows)
    }
}
