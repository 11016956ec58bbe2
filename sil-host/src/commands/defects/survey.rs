//! What is wrong with a detector, seen in several dark pictures.
//!
//! In: raw digital numbers of all pictures. Out: bad pixels by kind, offsets of columns, the noise.
//!
//! 1. Every picture's rows are brought to the same level, that of the middle picture: rows have an offset
//!    that is new in each readout, and the dark current follows the temperature.
//! 2. A pixel's level is its median over the pictures, so that a proton's hit in one does not count; its
//!    spread is the variance of all but the picture that is farthest from it. The noise is that of all
//!    pictures, in the median of the pixels.
//! 3. A column's offset is its level against the median of the columns around it, in whole numbers as the
//!    flight code takes it off; it counts where it exceeds what rounding may feign by [`SIGMAS`] of its own
//!    error.
//! 4. A pixel is hot or dead where its level, offsets taken off, is more than [`SIGMAS`] of the noise *of one
//!    picture* above or below the median of its neighbourhood of 5 x 5 px (of the scatter of levels, where
//!    that is larger): what is less is hidden in the noise in flight as well. It flickers where its spread
//!    exceeds the median of the spreads by more than [`SIGMAS`] sigmas of white noise do (chi-square by
//!    Wilson and Hilferty, 1931): telegraph noise.
//!
//! No noise is taken to be less than that of rounding. Of Gaussian noise this leaves, in a million pixels, no
//! false hot or dead one (levels are medians of several pictures) and 7, 3 and 2 that seem to flicker with 5,
//! 6 and 8 pictures (measured on five million). A pixel that is dead at the level of darkness is not seen:
//! that takes light.

use fsw_hal::DetectorGeometry;

/// What is farther out of line than this is a defect, sigmas.
pub const SIGMAS: f64 = 5.0;
/// Not more than one pixel in so many may be bad, else the pictures are not dark.
pub const BAD_SHARE: usize = 20;
/// A column whose offset exceeds this share of full scale is not offset but broken; its pixels are bad.
const OFFSET_SHARE: u16 = 8;
/// Levels that scatter so many times as much as a picture's noise are no darkness.
const PATTERN_MAX: f64 = 10.0;
/// Columns on either side against which an offset is seen, px.
const COLUMNS_AROUND: usize = 15;
/// Pixels on either side in a pixel's neighbourhood, px.
const AROUND: usize = 2;
/// What rounding to whole numbers can feign at most, DN, and its variance, DN².
const ROUNDING_DN: f64 = 0.5;
const ROUNDING_DN2: f64 = 1.0 / 12.0;

/// Kinds of bad pixels; of one that is of several the first counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Too bright.
    Hot,
    /// Too dark.
    Dead,
    /// Too noisy.
    Flickering,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    /// Bad pixels (column, row), sorted by row, then column.
    pub bad: Vec<([u16; 2], Kind)>,
    /// Columns with an offset and that offset, DN, from the left.
    pub offsets: Vec<(u16, i16)>,
    /// Noise of a pixel in one picture, DN.
    pub noise_dn: f64,
}

/// The median; of an even number the mean of the middle two. The order of the values is lost.
fn median(values: &mut [f64]) -> f64 {
    let (middle, even) = (values.len() / 2, values.len().is_multiple_of(2));
    let (below, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let upper = *upper;
    if !even {
        return upper;
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (lower + upper) / 2.0
}

/// The mean without a [`BAD_SHARE`]th at either end. Finer than a median, which of whole numbers is a whole
/// number.
fn mean_of_most(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let end = values.len() / BAD_SHARE;
    let most = &values[end..values.len() - end];
    most.iter().sum::<f64>() / most.len() as f64
}

/// Ratio of a variance of `freedom` degrees of freedom to the true one at `sigmas` (Wilson and Hilferty).
fn chi_square_ratio(freedom: f64, sigmas: f64) -> f64 {
    let width = 2.0 / (9.0 * freedom);
    (1.0 - width + sigmas * width.sqrt()).powi(3)
}

/// What is to be added to each row of each picture, picture by picture, DN.
fn row_shifts(frames: &[&[u16]], width: usize) -> Vec<Vec<f64>> {
    let level =
        |row: &[u16]| mean_of_most(&mut row.iter().map(|value| f64::from(*value)).collect::<Vec<_>>());
    let levels: Vec<Vec<f64>> =
        frames.iter().map(|frame| frame.chunks_exact(width).map(level).collect()).collect();
    let rows = levels.first().map_or(0, Vec::len);
    let common: Vec<f64> =
        (0..rows).map(|y| median(&mut levels.iter().map(|frame| frame[y]).collect::<Vec<_>>())).collect();
    levels.iter().map(|frame| frame.iter().zip(&common).map(|(here, all)| all - here).collect()).collect()
}

/// The variance of some values, DN².
fn variance(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64
}

/// The median of variances of so many degrees of freedom as that of one which is exact.
fn typical(variances: &[f64], freedom: f64) -> f64 {
    (median(&mut variances.to_vec()) / chi_square_ratio(freedom, 0.0)).max(ROUNDING_DN2)
}

/// Of every pixel over the pictures.
struct Pixels {
    /// Median, DN.
    levels: Vec<f64>,
    /// Variances, DN².
    variances: Vec<f64>,
    /// The same without the picture that is farthest from the median.
    spreads: Vec<f64>,
}

fn pixels(frames: &[&[u16]], width: usize) -> Pixels {
    let shifts = row_shifts(frames, width);
    let count = frames.first().map_or(0, |frame| frame.len());
    let mut values = vec![0.0; frames.len()];
    let mut pixels = Pixels {
        levels: Vec::with_capacity(count),
        variances: Vec::with_capacity(count),
        spreads: Vec::with_capacity(count),
    };
    for index in 0..count {
        for ((value, frame), shifts) in values.iter_mut().zip(frames).zip(&shifts) {
            *value = f64::from(frame[index]) + shifts[index / width];
        }
        let level = median(&mut values);
        values.sort_unstable_by(|a, b| (a - level).abs().total_cmp(&(b - level).abs()));
        pixels.levels.push(level);
        pixels.variances.push(variance(&values));
        pixels.spreads.push(variance(&values[..values.len() - 1]));
    }
    pixels
}

/// Whole offsets of the columns, most of them 0.
fn column_offsets(levels: &[f64], width: usize, noise_dn: f64, full_scale: u16) -> Vec<i16> {
    let rows = levels.len() / width;
    let column =
        |x: usize| mean_of_most(&mut levels.iter().skip(x).step_by(width).copied().collect::<Vec<_>>());
    let columns: Vec<f64> = (0..width).map(column).collect();
    let error_dn = noise_dn / (rows as f64).sqrt();
    let largest = f64::from(full_scale / OFFSET_SHARE).min(f64::from(i16::MAX));
    // Against the columns around, on a straight line: at the edges they all lie on one side, and the level
    // may have a slope.
    let offset = |x: usize| {
        let around = x.saturating_sub(COLUMNS_AROUND)..(x + COLUMNS_AROUND + 1).min(width);
        let (low, high) = columns[around.clone()].split_at(around.len() / 2);
        let [left, right] = [low, high].map(|half| median(&mut half.to_vec()));
        let (middle, apart) = ((around.start + around.end - 1) as f64 / 2.0, around.len() as f64 / 2.0);
        let level = median(&mut columns[around].to_vec()) + (right - left) / apart * (x as f64 - middle);
        let offset = columns[x] - level;
        let counts = offset.abs() > SIGMAS * error_dn + ROUNDING_DN && offset.abs() <= largest;
        if counts { offset.round() as i16 } else { 0 }
    };
    (0..width).map(offset).collect()
}

/// How far every pixel is above the median of those around it, DN.
fn residuals(levels: &[f64], width: usize) -> Vec<f64> {
    let rows = levels.len() / width;
    let mut around = Vec::with_capacity((2 * AROUND + 1).pow(2));
    let residual = |index: usize| {
        let (x, y) = (index % width, index / width);
        around.clear();
        for row in y.saturating_sub(AROUND)..(y + AROUND + 1).min(rows) {
            let columns = x.saturating_sub(AROUND)..(x + AROUND + 1).min(width);
            around.extend(
                columns.map(|column| row * width + column).filter(|at| *at != index).map(|at| levels[at]),
            );
        }
        levels[index] - median(&mut around)
    };
    (0..levels.len()).map(residual).collect()
}

/// Half the distance within which 68 % of the values lie.
fn scatter(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    let mut at = |share: f64| {
        let index = (share * (values.len() - 1) as f64) as usize;
        *values.select_nth_unstable_by(index, f64::total_cmp).1
    };
    (at(0.841) - at(0.159)) / 2.0
}

/// Finds what is wrong with a detector; `frames` are at least five dark pictures of its size. `None` where so
/// much is out of line, or their levels scatter so much, that they are not dark.
pub fn survey(frames: &[&[u16]], geometry: DetectorGeometry) -> Option<Survey> {
    let width = usize::from(geometry.width_px);
    let Pixels { mut levels, variances, spreads } = pixels(frames, width);
    let freedom = frames.len().saturating_sub(1) as f64;
    let noise_dn = typical(&variances, freedom).sqrt();
    let largest_spread = typical(&spreads, freedom - 1.0) * chi_square_ratio(freedom - 1.0, SIGMAS);
    let offsets = column_offsets(&levels, width, noise_dn, geometry.full_scale());
    for row in levels.chunks_exact_mut(width) {
        row.iter_mut().zip(&offsets).for_each(|(level, offset)| *level -= f64::from(*offset));
    }
    let residuals = residuals(&levels, width);
    let pattern_dn = scatter(&residuals);
    if pattern_dn > PATTERN_MAX * noise_dn {
        return None;
    }
    let largest = SIGMAS * noise_dn.max(pattern_dn);
    let kind = |residual: f64, spread: f64| match residual {
        above if above > largest => Some(Kind::Hot),
        below if below < -largest => Some(Kind::Dead),
        _ => (spread > largest_spread).then_some(Kind::Flickering),
    };
    let bad: Vec<_> = residuals
        .iter()
        .zip(&spreads)
        .enumerate()
        .filter_map(|(index, (residual, spread))| {
            Some(([(index % width) as u16, (index / width) as u16], kind(*residual, *spread)?))
        })
        .collect();
    let offsets = (0..).zip(offsets).filter(|(_, offset)| *offset != 0).collect();
    let few = bad.len() <= (levels.len() / BAD_SHARE).min(usize::from(u16::MAX));
    few.then_some(Survey { bad, offsets, noise_dn })
}

#[cfg(test)]
mod tests;
