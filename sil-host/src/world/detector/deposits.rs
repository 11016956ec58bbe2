//! Electrons that are added to single pixels.

use fsw_hal::Window;

/// Electrons added to one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deposit {
    /// Column, px.
    pub x: u16,
    /// Row, px.
    pub y: u16,
    /// Charge, e-.
    pub electrons: f64,
}

/// Deposits sorted by row, so that a window finds its own quickly.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Deposits {
    deposits: Vec<Deposit>,
}

impl Deposits {
    /// Sorts stably: deposits in one pixel always add up in the same order.
    pub fn new(mut deposits: Vec<Deposit>) -> Self {
        deposits.sort_by_key(|d| d.y);
        Self { deposits }
    }

    /// The deposits, row by row.
    pub fn as_slice(&self) -> &[Deposit] {
        &self.deposits
    }

    /// Adds `factor` times the deposits that lie in `window` to its pixels.
    pub fn add_to(&self, window: Window, factor: f64, electrons: &mut [f64]) {
        let first = self.deposits.partition_point(|d| d.y < window.y);
        for d in self.deposits[first..].iter().take_while(|d| d.y - window.y < window.height) {
            if d.x >= window.x && d.x - window.x < window.width {
                let place =
                    usize::from(d.y - window.y) * usize::from(window.width) + usize::from(d.x - window.x);
                electrons[place] += factor * d.electrons;
            }
        }
    }
}
