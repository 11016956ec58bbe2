//! The light of an image along a line.
//!
//! In: a detector whose image is exposed, a line. Out: its [`Profile`], and the part of it that is a
//! streak's.
//!
//! The image is sampled along the line, pixel by pixel, and up to `REACH` px across it; the sides are the
//! background. The light within `HALF_WIDTH` px of the line is its profile, of which the streak is the part
//! whose light stands best above half its own mean (the likeliest box in white noise); the drift of the light
//! across the line corrects the line.

use super::{scale, scaled};
use crate::image::scan::TILE_PIXELS;
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Window};
use fsw_pixels::radon::{BIN, SIDE};

/// So far across the line the image is sampled, px.
const REACH: i32 = 9;
/// Samples across the line.
const ACROSS: usize = 2 * REACH as usize + 1;
/// Light of the streak lies so far from the line at most, px ...
const HALF_WIDTH: i32 = 2;
/// ... and its drift is sought so far from it.
const DRIFT_WIDTH: i32 = 4;
/// The drift's noise over that of a pixel: the root of the sum of the squares of -4 to 4.
pub(super) const DRIFT_NOISE: f32 = 7.75;
/// So far the line of a piece may be off, px and px a px ...
const LINE_PX: f32 = 1.5;
const LINE_SLOPE: f32 = 0.04;
/// ... and more where the streak is shorter than the shortest line of a search, half a block: many lines of
/// its bins hold all of it. A bin, px, and a bin over that line.
const BIN_PX: f32 = BIN as f32;
const BIN_OF_LINE: f32 = 2.0 / SIDE as f32;
/// Columns sampled from one window.
pub const CHUNK: usize = 8;
/// Scaled counts of a unit in which profiles are kept.
const UNIT: f32 = 4.0;
/// What is off the detector.
const NONE: u16 = i16::MIN as u16;
/// Where profiles begin in the buffer; before it are the pixels.
const PROFILES: usize = TILE_PIXELS / 2;

/// A line on the detector.
#[derive(Clone, Copy)]
pub(super) struct Line {
    pub(super) origin: [f32; 2],
    pub(super) along: [f32; 2],
}

impl Line {
    /// The place `a` px along and `j` px across.
    pub(super) fn at(&self, a: f32, j: f32) -> [f32; 2] {
        let ([x, y], [ux, uy]) = (self.origin, self.along);
        [x + a * ux - j * uy, y + a * uy + j * ux]
    }

    /// The line shifted across and turned by small amounts.
    pub(super) fn moved(&self, across_px: f32, slope: f32) -> Self {
        let [ux, uy] = self.along;
        let per = 1.0 / libm::sqrtf(1.0 + slope * slope);
        Self { origin: self.at(0.0, across_px), along: [(ux - slope * uy) * per, (uy + slope * ux) * per] }
    }
}

/// A part of a profile: first column, the one after the last, mean light.
#[derive(Clone, Copy)]
pub(super) struct Part {
    pub(super) start: usize,
    pub(super) end: usize,
    pub(super) light: f32,
}

impl Part {
    pub(super) fn len(&self) -> usize {
        self.end.saturating_sub(self.start)
    }
}

/// Light and drift along a line, in the second half of the readout buffer.
pub(super) struct Profile<'a> {
    pub(super) light: &'a [u16],
    drift: &'a [u16],
    /// Noise of a pixel, scaled counts.
    pub(super) sigma: f32,
}

/// A kept value.
fn value(kept: u16) -> f32 {
    f32::from(kept as i16) * UNIT
}

/// A value to keep.
fn kept(value: f32) -> u16 {
    const MOST: f32 = i16::MAX as f32;
    ((value * (1.0 / UNIT)).clamp(-MOST, MOST) as i16) as u16
}

/// Bits of a pixel's fraction in a place, and those of them that are used between pixels.
const PLACE_BITS: u32 = 16;
const BETWEEN_BITS: u32 = 7;

/// The pixels of a window.
struct Pixels<'a> {
    raw: &'a [u16],
    window: Window,
    bits: u8,
    /// Scaled counts a raw count.
    scale: f32,
}

impl Pixels<'_> {
    /// A point counted from the window's first pixel, 2^-[`PLACE_BITS`] px.
    fn place(&self, [x, y]: [f32; 2]) -> [i32; 2] {
        const HALF_A_STEP: i32 = 1 << (PLACE_BITS - BETWEEN_BITS - 1);
        let fixed = |at: f32, first: u16| fixed(at - f32::from(first)) + HALF_A_STEP;
        [fixed(x, self.window.x), fixed(y, self.window.y)]
    }

    /// The image between pixels, scaled counts; `None` outside the window.
    #[inline(always)]
    fn between(&self, [x, y]: [i32; 2]) -> Option<f32> {
        let whole = |at: i32| usize::try_from(at >> PLACE_BITS).ok();
        let part = |at: i32| (at >> (PLACE_BITS - BETWEEN_BITS)) & ((1 << BETWEEN_BITS) - 1);
        let (column, row, width) = (whole(x)?, whole(y)?, usize::from(self.window.width));
        if column + 1 >= width {
            return None;
        }
        let (right, down) = (part(x), part(y));
        let two = |row: usize| {
            let [a, b] = self.raw.get(row * width + column..)?.first_chunk::<2>()?.map(i32::from);
            Some((a << BETWEEN_BITS) + (b - a) * right)
        };
        let (above, below) = (two(row)?, two(row + 1)?);
        // Of 16 bits and twice 7.
        let value = (above << BETWEEN_BITS) + (below - above) * down;
        Some(value as f32 * (self.scale / (1 << (2 * BETWEEN_BITS)) as f32))
    }

    /// Standard deviation of a pixel by the spread of the middle half of some.
    fn sigma(&self) -> f32 {
        let mut some = [0; 24];
        for (index, slot) in some.iter_mut().enumerate() {
            let at = index * self.raw.len() / 24;
            *slot = self.raw.get(at).map_or(0, |raw| scaled(*raw, self.bits));
        }
        crate::order::sort_numbers(&mut some);
        let [low, high] = [6, 18].map(|at: usize| some.get(at).copied().unwrap_or(0));
        (high - low) as f32 * 0.741
    }
}

/// Farther than any window reaches, px.
const FAR_PX: f32 = 16_000.0;

/// A number of pixels, 2^-[`PLACE_BITS`] px.
fn fixed(px: f32) -> i32 {
    (px.clamp(-FAR_PX, FAR_PX) * (1 << PLACE_BITS) as f32) as i32
}

/// The window that holds some columns of a line, within the detector.
fn window_of(line: &Line, first: f32, geometry: &DetectorGeometry) -> Option<Window> {
    let (last, reach) = (first + (CHUNK - 1) as f32, REACH as f32);
    let corners =
        [(first, -reach), (first, reach), (last, -reach), (last, reach)].map(|(a, j)| line.at(a, j));
    let span = |axis: fn(&[f32; 2]) -> f32, length: u16| {
        let (low, high) = corners
            .iter()
            .map(axis)
            .fold((f32::MAX, f32::MIN), |(low, high), at| (low.min(at), high.max(at)));
        let low = (libm::floorf(low) as i32).max(0);
        let high = ((libm::floorf(high) as i32).saturating_add(2)).min(i32::from(length));
        (high - low >= 2).then_some((low as u16, (high - low) as u16))
    };
    let (x, width) = span(|corner| corner[0], geometry.width_px)?;
    let (y, height) = span(|corner| corner[1], geometry.height_px)?;
    Some(Window { x, y, width, height })
}

/// The level of some values: the mean of those within three sigmas of the median of some, so that stars
/// beside the line do not lift it.
#[inline(never)]
fn level_of(values: &[f32], sigma: f32) -> f32 {
    let mut some = [0.0; 9];
    for (index, slot) in some.iter_mut().enumerate() {
        *slot = values.get(index * values.len() / 9).copied().unwrap_or(0.0);
    }
    crate::order::sort_numbers(&mut some);
    let (median, reach) = (some[4], 3.0 * sigma);
    let (sum, count) = values
        .iter()
        .filter(|value| (**value - median).abs() <= reach)
        .fold((0.0, 0.0f32), |(sum, count), value| (sum + (value - median), count + 1.0));
    median + sum / count.max(1.0)
}

/// What some columns of a line show.
struct Columns {
    /// The samples across the line, column by column.
    samples: [[f32; 2 * DRIFT_WIDTH as usize + 1]; CHUNK],
    /// A column counts where the line itself is on the detector with room for the light beside it.
    inside: [bool; CHUNK],
    /// The background beside them.
    level: f32,
    /// Noise of a pixel.
    sigma: f32,
}

impl Columns {
    /// Those from `first` on; `None` where all are off the detector. No noise is less than `least`.
    #[inline(never)]
    fn of(pixels: &Pixels, line: &Line, first: f32, least: f32) -> Option<Self> {
        let mut sides: heapless::Vec<f32, { CHUNK / 2 * ACROSS }> = heapless::Vec::new();
        let mut columns =
            Self { samples: Default::default(), inside: [true; CHUNK], level: 0.0, sigma: pixels.sigma() };
        let [right, down] = line.along.map(fixed);
        let each = columns.samples.iter_mut().zip(&mut columns.inside).enumerate();
        for (column, (samples, inside)) in each {
            let [x, y] = pixels.place(line.at(first + column as f32, 0.0));
            let at = |j: i32| pixels.between([x - j * down, y + j * right]);
            for (sample, j) in samples.iter_mut().zip(-DRIFT_WIDTH..) {
                match at(j) {
                    Some(value) => *sample = value,
                    None => *inside = false,
                }
            }
            if *inside && column % 2 == 0 {
                for j in HALF_WIDTH + 2..=REACH {
                    for side in [at(j), at(-j)].into_iter().flatten() {
                        let _ = sides.push(side);
                    }
                }
            }
        }
        if !columns.inside.contains(&true) {
            return None;
        }
        columns.level = level_of(&sides, columns.sigma.max(least));
        Some(columns)
    }

    /// Keeps their light and drift.
    fn keep(&self, light: &mut [u16], drift: &mut [u16]) {
        let columns = light.iter_mut().zip(drift).zip(self.samples.iter().zip(self.inside));
        for ((light, drift), (samples, _)) in columns.filter(|(_, (_, inside))| *inside) {
            let (mut sum, mut moment) = (0.0, 0.0);
            for (value, j) in samples.iter().zip(-DRIFT_WIDTH..) {
                let rise = value - self.level;
                moment += rise * j as f32;
                if j.abs() <= HALF_WIDTH {
                    sum += rise;
                }
            }
            (*light, *drift) = (kept(sum), kept(moment));
        }
    }
}

/// Samples `2 half` columns of a line, those from -half on.
#[inline(never)]
pub(super) fn sample<'b>(
    detector: &mut impl Detector<Error = DetectorError>,
    buffer: &'b mut [u16; TILE_PIXELS],
    line: &Line,
    half: usize,
) -> Result<Profile<'b>, DetectorError> {
    let geometry = detector.geometry();
    let (pixels, profiles) = buffer.split_at_mut_checked(PROFILES).ok_or(DetectorError::BufferLength)?;
    let (light, drift) = profiles
        .get_mut(..4 * half)
        .and_then(|all| all.split_at_mut_checked(2 * half))
        .ok_or(DetectorError::BufferLength)?;
    // Never below the noise of quantisation.
    let least = 0.3 * scaled(1, geometry.bits).max(1) as f32;
    let scale = scale(geometry.bits);
    let (mut sigmas, mut chunks) = (0.0, 0.0);
    let mut first = -(half as f32);
    for (light, drift) in light.chunks_mut(CHUNK).zip(drift.chunks_mut(CHUNK)) {
        light.fill(NONE);
        if let Some(window) = window_of(line, first, &geometry) {
            let raw = pixels.get_mut(..window.area()).ok_or(DetectorError::BufferLength)?;
            detector.read(window, raw)?;
            let pixels = Pixels { raw, window, bits: geometry.bits, scale };
            if let Some(columns) = Columns::of(&pixels, line, first, least) {
                (sigmas, chunks) = (sigmas + columns.sigma, chunks + 1.0);
                columns.keep(light, drift);
            }
        }
        first += CHUNK as f32;
    }
    Ok(Profile { light, drift, sigma: if chunks > 0.0 { (sigmas / chunks).max(least) } else { least } })
}

impl Profile<'_> {
    /// Noise of a pixel's length.
    pub(super) fn noise(&self) -> f32 {
        const WIDTH_ROOT: f32 = 2.236;
        const { assert!(HALF_WIDTH == 2) };
        self.sigma * WIDTH_ROOT
    }

    /// Whether a column is on the detector.
    pub(super) fn is_seen(&self, column: usize) -> bool {
        self.light.get(column).is_some_and(|kept| *kept != NONE)
    }

    /// Light of a column; `None` off the detector, and where it is more than `most`.
    pub(super) fn at(&self, column: usize, most: f32) -> Option<f32> {
        self.light
            .get(column)
            .filter(|kept| **kept != NONE)
            .map(|kept| value(*kept))
            .filter(|light| *light < most)
    }

    /// The light that may still be the streak's: more is a hit's, and says nothing of the streak.
    pub(super) fn most(&self, light: f32) -> f32 {
        2.0 * light + 3.0 * self.noise()
    }

    /// The stretch of the best signal to noise, of lengths 6, 12, 24 ...
    #[inline(never)]
    fn brightest(&self) -> Option<Part> {
        let mut best: Option<(f32, Part)> = None;
        let mut width = 6;
        while width <= self.light.len() {
            let per = 1.0 / width as f32;
            let light = |column| self.at(column, f32::MAX).unwrap_or(0.0);
            let mut sum = (0..width).fold(0.0, |sum, column| sum + light(column));
            for start in 0..=self.light.len() - width {
                let merit = sum * libm::sqrtf(per);
                if best.is_none_or(|(most, _)| merit > most) {
                    best = Some((merit, Part { start, end: start + width, light: sum * per }));
                }
                sum += light(start + width) - light(start);
            }
            width *= 2;
        }
        best.map(|(_, part)| part).filter(|part| part.light > 0.0)
    }

    /// The part in which the light exceeds half of `light` most clearly.
    #[inline(never)]
    fn likeliest(&self, light: f32) -> Option<Part> {
        let most = self.most(light);
        let (mut sum, mut start) = (0.0, 0);
        let mut best: Option<(f32, usize, usize)> = None;
        for column in 0..self.light.len() {
            if sum <= 0.0 || !self.is_seen(column) {
                (sum, start) = (0.0, column);
            }
            if !self.is_seen(column) {
                continue;
            }
            sum += self.at(column, most).map_or(0.0, |at| at - 0.5 * light);
            if best.is_none_or(|(greatest, ..)| sum > greatest) {
                best = Some((sum, start, column + 1));
            }
        }
        let (_, start, end) = best?;
        let (sum, count) = self.sum(start, end, most);
        (count > 0.0).then(|| Part { start, end, light: sum / count })
    }

    /// Light of the columns from `start` up to `end` where it is less than `most`, and their number.
    pub(super) fn sum(&self, start: usize, end: usize, most: f32) -> (f32, f32) {
        let lights = (start..end).filter_map(|column| self.at(column, most));
        lights.fold((0.0, 0.0), |(sum, count), light| (sum + light, count + 1.0))
    }

    /// The streak's part of the profile.
    #[inline(never)]
    pub(super) fn part(&self) -> Option<Part> {
        let mut part = self.brightest()?;
        for _ in 0..3 {
            part = self.likeliest(part.light).filter(|part| part.light > 0.0)?;
        }
        Some(part)
    }

    /// By how much the light lies across the line at its origin, column `half`, px, and how this changes
    /// along it.
    pub(super) fn drift(&self, part: &Part, half: usize) -> (f32, f32) {
        let most = self.most(part.light);
        let middle = 0.5 * (part.start + part.end - 1) as f32;
        let (mut count, mut sum, mut moment, mut square) = (0.0, 0.0, 0.0, 0.0);
        for column in part.start..part.end {
            if self.at(column, most).is_none() {
                continue;
            }
            let from_middle = column as f32 - middle;
            let drift = self.drift.get(column).map_or(0.0, |kept| value(*kept));
            count += 1.0;
            sum += drift;
            moment += drift * from_middle;
            square += from_middle * from_middle;
        }
        if count < 3.0 {
            return (0.0, 0.0);
        }
        // What is noise is not followed: each estimate is weighted against what the line may be off.
        let noise = DRIFT_NOISE * self.sigma / part.light;
        let weight = |sigma: f32, scatter: f32| sigma * sigma / (sigma * sigma + scatter);
        let across = weight(LINE_PX, noise * noise / count) * sum / (count * part.light);
        let short = (BIN_PX / part.len() as f32 - BIN_OF_LINE).max(0.0);
        let off = LINE_SLOPE + short;
        let slope = weight(off, noise * noise / square.max(1.0)) * moment / (square.max(1.0) * part.light);
        let (across, slope) = (across.clamp(-3.0, 3.0), slope.clamp(-0.4, 0.4));
        (across + slope * (half as f32 - middle), slope)
    }
}
