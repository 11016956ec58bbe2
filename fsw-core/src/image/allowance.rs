//! How much work a crowded picture may cost.
//!
//! In: what each step of a search is about to cost. Out: whether it may be done. Levels and bounds cost the
//! same whatever the pixels show; what depends on them is paid from here, in cycles of the Cortex-M4 model,
//! at prices that hold for the dearest of each step. So many steps, and no more, can be done:
//!
//! `tiles x (TILE_FIXED_CYCLES + TILE_CYCLES) + RESERVE_CYCLES`, see [`bound_cycles`]: 76.6 million for the
//! 192 tiles of the reference detector, whose converter has 10 bits (more than 12 cost one more pass over the
//! pixels).
//!
//! Every tile has an income of its own, [`TILE_CYCLES`], that nothing seen elsewhere can use up: whatever a
//! cloud field has cost, the brightest spots of the tiles below it are still measured. What a tile leaves
//! goes into savings, of which each tile may take a quarter ([`LOAN_DIVISOR`]): dense tiles get much, and no
//! one all. Within a tile the brightest is looked at first (`peaks`), so what is left out are its faintest
//! spots; only where more boxes pass the coarse look than a sixth of the allowance pays for, those below are.
//!
//! No clock is read: the same pixels get the same work everywhere.

/// A block's row looked at for peaks.
pub const LOOK_CYCLES: u32 = 1_200;
/// A maximum of its row compared with the rows around it.
pub const ROW_MAXIMUM_CYCLES: u32 = 1_000;
/// A glance at a candidate, which tells a single pixel that shines.
pub const GLANCE_CYCLES: u32 = 2_000;
/// A candidate judged, centred and kept.
pub const CANDIDATE_CYCLES: u32 = 32_000;
/// What is no star at first sight, or drawn out, and therefore looked at once more.
pub const SECOND_LOOK_CYCLES: u32 = 22_000;
/// Of what a tile may spend its boxes (`coarse`) have one part in so many: the others are for the candidates
/// found.
pub const BOXES_DIVISOR: u32 = 6;
/// The window about a candidate conditioned.
pub const WINDOW_READING_CYCLES: u32 = 40_000;
/// The same among noisy cells, 80 x 64 px: one of 128 x 64 px was measured at 210,000.
pub const TEXTURED_READING_CYCLES: u32 = 135_000;
/// A star's image fitted.
pub const FIT_CYCLES: u32 = 60_000;
/// Income of a tile: a star at the least; fitted, where it does not stand in texture.
pub const TILE_CYCLES: u32 = 238_000;
/// All that a single window has: a star, fitted, at the least.
pub const WINDOW_CYCLES: u32 = 160_000;
/// Savings with which a scan begins.
pub const RESERVE_CYCLES: u32 = 4_000_000;
/// A tile may take the savings divided by this.
pub const LOAN_DIVISOR: u32 = 4;
/// What a tile of the largest size costs whatever it shows: measured 105,000, and 34,000 where all of it is
/// texture.
pub const TILE_FIXED_CYCLES: u32 = 140_000;

/// The most that a scan in so many tiles can cost, cycles, the reading of the pixels not counted.
pub const fn bound_cycles(tiles: u32) -> u64 {
    tiles as u64 * (TILE_FIXED_CYCLES + TILE_CYCLES) as u64 + RESERVE_CYCLES as u64
}

/// The most that so many windows outside a scan can cost, of the widest gate (62 x 62 px), cycles.
pub const fn windows_bound_cycles(windows: u32) -> u64 {
    windows as u64 * (TEXTURED_READING_CYCLES + WINDOW_CYCLES) as u64
}

/// What may still be spent on a window, cycles.
#[derive(Debug)]
pub struct Allowance(u32);

impl Allowance {
    /// That of a window outside any scan.
    pub const fn of_a_window() -> Self {
        Self(WINDOW_CYCLES)
    }

    /// No limit that a test could reach.
    #[cfg(test)]
    pub const fn plenty() -> Self {
        Self(u32::MAX)
    }

    /// Takes the price of a step; where it is not there anymore nothing is taken and the step must be left.
    pub fn spend(&mut self, cycles: u32) -> bool {
        let left = self.0.checked_sub(cycles);
        self.0 = left.unwrap_or(self.0);
        left.is_some()
    }

    /// What may be spent on the boxes of a tile, cycles.
    pub fn for_boxes(&self) -> u32 {
        self.0 / BOXES_DIVISOR
    }

    /// Gives back the price of a step that was not needed.
    pub fn give_back(&mut self, cycles: u32) {
        self.0 = self.0.saturating_add(cycles);
    }
}

/// What the tiles of a scan have left over for those to come.
#[derive(Debug)]
pub struct Savings(u32);

impl Savings {
    /// Those at the beginning of a scan.
    pub const fn new() -> Self {
        Self(RESERVE_CYCLES)
    }

    /// The next tile's allowance: its income and its share of the savings.
    pub fn next_tile(&mut self) -> Allowance {
        let loan = self.0 / LOAN_DIVISOR;
        self.0 -= loan;
        Allowance(TILE_CYCLES.saturating_add(loan))
    }

    /// Puts back what a tile has left.
    pub fn put_back(&mut self, left: Allowance) {
        self.0 = self.0.saturating_add(left.0);
    }
}

#[cfg(test)]
mod tests;
