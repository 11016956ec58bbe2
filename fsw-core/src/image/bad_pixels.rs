//! Replaces bad pixels and subtracts the offsets of columns (thesis §2.1).
//!
//! In: a [`Detector`] and its table of [`Defects`]. Out: a [`Detector`] whose windows are corrected as they
//! are read, so that stars, limb, streaks and self-test need not know.
//!
//! A bad pixel gets the mean of its two neighbours in the row, or the one of them that is good, as in the
//! thesis: "their individual values can be substituted by their predecessor, successor, or their mean value".
//! Where neither is good, those in the column serve, then those at twice the distance, and so on to
//! [`REACH_PX`]. A pixel with no good one on its four sides that near is left as it was read.
//!
//! What replaces a pixel depends on the detector's pixels alone, not on the window: a neighbour that lies
//! outside the window is read by itself, a window of one pixel. Taking what is inside would cost no such
//! reading, but a star at a window's edge would be measured otherwise than in another window. Only bad pixels
//! in the first and last column need it.
//!
//! What remains: a star of V = 3.5 whose middle pixel is bad is centred to 0.17 px an axis (rms; 0.017 on
//! sound pixels), 0.09 where the one beside is bad, 0.02 from the corner on; of V = 5 to 0.19, 0.11 and 0.06
//! (0.055). Its reported sigma does not know. Uncorrected, a hot pixel there costs the star (`sil-host`,
//! `defects_tests.rs`).
//!
//! An offset never takes a pixel off full scale, by which a saturated star and a blinded detector are known.
//!
//! Cost beside the reading (Cortex-M4 model, zero wait states): 100 cycles a row of the window, 700 a bad
//! pixel, 21 a pixel of a column with an offset. With 2,000 bad pixels on the reference detector that is
//! 4,000 for a star's window of 27 x 27 px and 2.4 million for all the tiles of a scan; offsets of all
//! columns would add 27.5 million to the scan, those of a few dozen hardly a million.

use super::defects::{Defects, DefectsError};
use fsw_hal::{Detector, DetectorGeometry, Window};

/// A neighbour so far away may still take a bad pixel's place, px.
pub const REACH_PX: u16 = 8;

/// A detector whose bad pixels are replaced and whose column offsets are subtracted.
#[derive(Debug)]
pub struct BadPixelDetector<'a, D> {
    detector: &'a mut D,
    defects: Defects<'a>,
    full_scale: u16,
}

/// Where a pixel takes its value from: one or two good ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Neighbours([u16; 2], Option<[u16; 2]>);

/// The two sides of a pixel, if they are on the detector and good.
fn good_of(defects: &Defects, sides: [Option<[u16; 2]>; 2]) -> Option<Neighbours> {
    let [width, height] = defects.size_px();
    let good = sides.map(|side| side.filter(|[x, y]| *x < width && *y < height && !defects.is_bad(*x, *y)));
    match good {
        [Some(one), other] | [other, Some(one)] => Some(Neighbours(one, other)),
        [None, None] => None,
    }
}

/// The nearest good pixels in row or column.
fn neighbours(defects: &Defects, x: u16, y: u16) -> Option<Neighbours> {
    (1..=REACH_PX).find_map(|step| {
        let in_row = [x.checked_sub(step), x.checked_add(step)].map(|x| Some([x?, y]));
        let in_column = [y.checked_sub(step), y.checked_add(step)].map(|y| Some([x, y?]));
        good_of(defects, in_row).or_else(|| good_of(defects, in_column))
    })
}

/// Whether a bad pixel can be replaced: a good one is within [`REACH_PX`] in its row or column.
pub fn is_replaceable(defects: &Defects, x: u16, y: u16) -> bool {
    neighbours(defects, x, y).is_some()
}

/// A pixel's value without its column's offset.
#[inline(always)]
fn without_offset(value: u16, offset: i16, full_scale: u16) -> u16 {
    let moved = (i32::from(value) - i32::from(offset)).clamp(0, i32::from(full_scale)) as u16;
    if value < full_scale { moved } else { value }
}

/// Where a pixel of the detector lies in a window's buffer.
fn place(window: Window, [x, y]: [u16; 2]) -> Option<usize> {
    let (right, down) = (x.checked_sub(window.x)?, y.checked_sub(window.y)?);
    let inside = right < window.width && down < window.height;
    inside.then_some(usize::from(down) * usize::from(window.width) + usize::from(right))
}

impl<'a, D: Detector> BadPixelDetector<'a, D> {
    /// `detector` without `defects`.
    ///
    /// # Errors
    /// [`DefectsError::OtherDetector`] where they are those of a detector of another size.
    pub fn new(detector: &'a mut D, defects: Defects<'a>) -> Result<Self, DefectsError> {
        let geometry = detector.geometry();
        if defects.size_px() != [geometry.width_px, geometry.height_px] {
            return Err(DefectsError::OtherDetector);
        }
        Ok(Self { detector, defects, full_scale: geometry.full_scale() })
    }

    fn subtract_offsets(&self, window: Window, pixels: &mut [u16]) {
        let (width, full_scale) = (usize::from(window.width).max(1), self.full_scale);
        for (x, offset) in self.defects.offsets_from(window.x) {
            // The first column beyond the window ends it.
            let Some(column) = place(Window { height: 1, ..window }, [x, window.y]) else { return };
            let below = pixels.get_mut(column..).unwrap_or_default().chunks_mut(width);
            for value in below.filter_map(<[u16]>::first_mut) {
                *value = without_offset(*value, offset, full_scale);
            }
        }
    }

    /// The value of a good pixel, its offset taken off: from the window, or read by itself.
    fn good_value(&mut self, at: [u16; 2], window: Window, pixels: &[u16]) -> Result<u16, D::Error> {
        if let Some(value) = place(window, at).and_then(|place| pixels.get(place)) {
            return Ok(*value);
        }
        let ([x, y], mut alone) = (at, [0]);
        self.detector.read(Window { x, y, width: 1, height: 1 }, &mut alone)?;
        let [value] = alone;
        let offset = self.defects.offsets_from(x).next().filter(|(column, _)| *column == x);
        Ok(offset.map_or(value, |(_, offset)| without_offset(value, offset, self.full_scale)))
    }

    fn replace(&mut self, at: [u16; 2], window: Window, pixels: &mut [u16]) -> Result<(), D::Error> {
        let [x, y] = at;
        let Some(Neighbours(one, other)) = neighbours(&self.defects, x, y) else { return Ok(()) };
        let first = self.good_value(one, window, pixels)?;
        let second = other.map_or(Ok(first), |other| self.good_value(other, window, pixels))?;
        if let Some(value) = place(window, at).and_then(|place| pixels.get_mut(place)) {
            *value = ((u32::from(first) + u32::from(second)).div_ceil(2)) as u16;
        }
        Ok(())
    }
}

impl<D: Detector> fsw_hal::ErrorType for BadPixelDetector<'_, D> {
    type Error = D::Error;
}

impl<D: Detector> Detector for BadPixelDetector<'_, D> {
    fn geometry(&self) -> DetectorGeometry {
        self.detector.geometry()
    }

    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), D::Error> {
        self.detector.start_exposure(exposure_us)
    }

    fn finish_exposure(&mut self) -> Result<fsw_hal::LocalTime, D::Error> {
        self.detector.finish_exposure()
    }

    /// Reads, takes offsets off, replaces bad pixels. Work is bounded by the window: its rows, its bad
    /// pixels, its columns.
    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), D::Error> {
        self.detector.read(window, pixels)?;
        if self.defects.are_apart(window) {
            return Ok(());
        }
        self.subtract_offsets(window, pixels);
        let mut bad = self.defects.within(window);
        bad.try_for_each(|at| self.replace(at, window, pixels))
    }
}

#[cfg(test)]
mod tests;
