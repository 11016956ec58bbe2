//! Measures the streak to which a piece of a line belongs.
//!
//! In: a detector whose image is exposed, a [`Piece`]. Out: the [`Streak`], its ends to a fraction of a
//! pixel, or nothing where the light is none of a streak.
//!
//! The light along the piece's line (`profile`) shows the streak's part and sets the line right. Where the
//! part reaches the end of what was sampled, twice as much is. Last, ends, light and blur are fitted
//! together: the profile is a box with smooth edges, and the best one maximises `(Σ l m)² / Σ m²` over its
//! shape `m`.
//!
//! Errors, `q` being the noise of a pixel's length over its light: an end is known along the streak to
//! `sqrt((EDGE_PX2 q² + FLOOR_PX2) (1 + SHORT_PX2 / L²) + WALK_PX2 q⁴ + FULL_PX2)`, L being its length. The
//! first term is the Cramer-Rao bound of an edge with a blur of 1.1 px, the second that of a faint one, which
//! noise alone displaces (Yao, Ann. Statist. 15, 1987), the last stands where pixels may be at full scale.

pub use super::profile::CHUNK;
use super::profile::{DRIFT_NOISE, Line, Part, Profile, sample};
use super::{FULL_SCALE, Piece, Streak, scaled};
use crate::image::scan::TILE_PIXELS;
use crate::trigonometry::sine_cosine;
use fsw_hal::{Detector, DetectorError, Window};

/// Columns of profiles that may be sampled in a second that has not scanned for stars.
pub const MAX_COLUMNS: usize = 7_000;
/// Columns to either side of the piece at first, and at most.
const FIRST_HALF: usize = 32;
const MAX_HALF: usize = 512;
/// Rounds of sampling: until the longest streak is whole, and some to set the line right.
const ROUNDS: usize = 7;
/// The line is right where the light at the streak's ends is no farther off than this, px.
const RIGHT_PX: f32 = 1.0;
/// A streak's box may end so near to the end of what was sampled, px.
const CLEAR: usize = 10;
/// Shortest streak, px.
const SHORTEST_PX: f32 = 4.0;
/// A streak rises so many sigmas above the noise, all its light together.
const LEAST_SIGMAS: f32 = 8.5;
/// Columns about an end in which it is fitted.
const EDGE: usize = 12;
/// Trials of the fit.
const TRIALS: usize = 100;
/// Half a ramp's length over its standard deviation: the root of 5.
const RAMP: f32 = 2.236;
/// Variance of an end, see the module: times q², times q⁴, and at least, px².
const EDGE_PX2: f32 = 4.5;
const WALK_PX2: f32 = 12.0;
const FLOOR_PX2: f32 = 0.006;
/// ... more of streaks shorter than 11 px ...
const SHORT_PX2: f32 = 120.0;
/// ... more of light above `FULL_LIGHT`: half of what the pixels show lies outside of half of the light ...
const FULL_PX2: f32 = 2.0;
/// ... and across the streak at least, its bend included, px².
const BEND_PX2: f32 = 0.04;
/// From this light on pixels behind a sharp lens stand at full scale, scaled counts.
const FULL_LIGHT: f32 = 1.4 * FULL_SCALE as f32;

/// A box with smooth edges: ends and blur, columns.
type Shape = [f32; 3];

/// A smooth step, 0 to 1, whose slope has unit standard deviation.
fn ramp(z: f32) -> f32 {
    let t = (z * (1.0 / RAMP)).clamp(-1.0, 1.0);
    0.5 + t * (0.75 - 0.25 * t * t)
}

/// `(Σ l m)² / Σ m²` of a shape over the columns about both ends of `part` and those between, and the light.
#[inline(never)]
fn merit(
    profile: &Profile,
    part: &Part,
    (light, count): (f32, f32),
    [start, end, blur]: Shape,
) -> (f32, f32) {
    let per = 1.0 / blur;
    let (mut both, mut square) = (light, count);
    let most = profile.most(part.light);
    for column in edges(profile, part) {
        let at = column as f32;
        let m = ramp((at - start) * per) * ramp((end - at) * per);
        if let Some(light) = profile.at(column, most) {
            both += m * light;
            square += m * m;
        }
    }
    if both <= 0.0 || square <= 0.0 {
        return (0.0, 0.0);
    }
    (both * both / square, both / square)
}

/// The columns about the ends; `Part::start + EDGE` to `end - EDGE` are between.
fn edges(profile: &Profile, part: &Part) -> impl Iterator<Item = usize> {
    let (first, last) = (part.start.saturating_sub(EDGE), (part.end + EDGE).min(profile.light.len()));
    let (from, to) = between(part);
    (first..from).chain(to..last)
}

/// The columns that surely hold the streak.
fn between(part: &Part) -> (usize, usize) {
    if part.len() > 2 * EDGE { (part.start + EDGE, part.end - EDGE) } else { (part.end, part.end) }
}

/// The best shape and its light.
#[inline(never)]
fn fit(profile: &Profile, part: &Part) -> (Shape, f32) {
    let most = profile.most(part.light);
    let (from, to) = between(part);
    let inner = profile.sum(from, to, most);
    let mut shape = [part.start as f32 - 0.5, part.end as f32 - 0.5, 1.1];
    let mut best = merit(profile, part, inner, shape);
    let mut step = 1.0f32;
    let mut trials = 0;
    while step > 0.012 && trials < TRIALS {
        let mut moved = false;
        for axis in 0..3 {
            for sign in [step, -step] {
                let mut other = shape;
                if let Some(value) = other.get_mut(axis) {
                    *value += if axis == 2 { 0.5 * sign } else { sign };
                }
                let [start, end, blur] = other;
                trials += 1;
                if !(0.6..=3.5).contains(&blur) || end - start < 1.0 {
                    continue;
                }
                let other_merit = merit(profile, part, inner, other);
                if other_merit.0 > best.0 {
                    (shape, best, moved) = (other, other_merit, true);
                    break;
                }
            }
        }
        if !moved {
            step *= 0.5;
        }
    }
    (shape, best.1)
}

/// Measures the streak of a piece; `None` where there is none, or where `columns`, those that may still be
/// sampled (2,300 cycles of the Cortex-M4 model each), do not suffice.
///
/// # Errors
/// Of the detector, at the first window that fails.
#[inline(never)]
pub fn follow(
    detector: &mut impl Detector<Error = DetectorError>,
    buffer: &mut [u16; TILE_PIXELS],
    piece: &Piece,
    columns: &mut usize,
) -> Result<Option<Streak>, DetectorError> {
    let mut line = Line { origin: piece.at_px, along: piece.along };
    let mut half = FIRST_HALF;
    let (mut settled, mut grown) = (0, 0);
    for _ in 0..ROUNDS {
        if *columns < 2 * half {
            return Ok(None);
        }
        *columns -= 2 * half;
        let profile = sample(detector, buffer, &line, half)?;
        let Some(part) = profile.part() else { return Ok(None) };
        // Another's light farther along the line is not this piece's.
        if part.start > half + FIRST_HALF / 2 || part.end + FIRST_HALF / 2 < half {
            return Ok(None);
        }
        let open =
            |near: bool, column: Option<usize>| near && column.is_some_and(|column| profile.is_seen(column));
        let grows = half < MAX_HALF
            && (open(part.start < CLEAR, Some(0)) || open(part.end + CLEAR > 2 * half, Some(2 * half - 1)));
        let (across, slope) = profile.drift(&part, half);
        let off = across.abs() + 0.5 * slope.abs() * part.len() as f32;
        if settled + grown >= 2 && settled >= 1 && !grows && off < RIGHT_PX {
            return Ok(measured(&profile, &part, &line, half));
        }
        line = line.moved(across, slope);
        // What comes next is sampled about the middle of what was found.
        let middle = 0.5 * (part.start + part.end) as f32 - half as f32;
        line.origin = line.at(middle, 0.0);
        if grows {
            half *= 2;
            grown += 1;
        } else {
            settled += 1;
        }
    }
    Ok(None)
}

/// The streak of a part of a profile.
#[inline(never)]
fn measured(profile: &Profile, part: &Part, line: &Line, half: usize) -> Option<Streak> {
    let noise = profile.noise();
    let count = part.len() as f32;
    if part.light * libm::sqrtf(count) < LEAST_SIGMAS * noise {
        return None;
    }
    let beyond = |column: Option<usize>| column.is_none_or(|column| !profile.is_seen(column));
    let cut = beyond(part.start.checked_sub(EDGE / 2)) || beyond(Some(part.end + EDGE / 2));
    let (shape, light) = if cut {
        ([part.start as f32 - 0.5, part.end as f32 - 0.5, 1.0], part.light)
    } else {
        fit(profile, part)
    };
    let [start, end, _] = shape;
    if end - start < SHORTEST_PX || light <= 0.0 {
        return None;
    }
    let q2 = noise / light * noise / light;
    let full = if light > FULL_LIGHT { FULL_PX2 } else { 0.0 };
    // Of a short streak the blur is hardly told from the length.
    let short = 1.0 + SHORT_PX2 / ((end - start) * (end - start));
    let place = |column: f32| line.at(column - half as f32, 0.0);
    let across = 2.0 * DRIFT_NOISE * profile.sigma / (light * libm::sqrtf(count));
    Some(Streak {
        ends_px: [place(start), place(end)],
        sigma_along_px: libm::sqrtf(short * (EDGE_PX2 * q2 + FLOOR_PX2) + WALK_PX2 * q2 * q2 + full),
        sigma_across_px: libm::sqrtf(across * across + BEND_PX2),
        cut,
        light,
    })
}

/// The piece about a place whose direction is not known: the light within 10 px that rises from the noise,
/// its principal axis (thesis eq. 3.21 to 3.26).
///
/// # Errors
/// Of the detector.
#[inline(never)]
pub fn piece_at(
    detector: &mut impl Detector<Error = DetectorError>,
    buffer: &mut [u16; TILE_PIXELS],
    [x, y]: [u16; 2],
) -> Result<Option<Piece>, DetectorError> {
    const RADIUS: u16 = 10;
    let geometry = detector.geometry();
    let (left, top) = (x.saturating_sub(RADIUS), y.saturating_sub(RADIUS));
    const SIDE: u16 = 2 * RADIUS + 1;
    let window = Window { x: left, y: top, width: SIDE, height: SIDE };
    if !window.fits(&geometry) {
        return Ok(None);
    }
    let raw = buffer.get_mut(..window.area()).ok_or(DetectorError::BufferLength)?;
    detector.read(window, raw)?;
    let mut some = [0; 49];
    for (index, slot) in some.iter_mut().enumerate() {
        *slot = raw.get(index * 9).map_or(0, |raw| scaled(*raw, geometry.bits));
    }
    crate::order::sort_numbers(&mut some);
    let [low, level] = [12, 22].map(|at: usize| some.get(at).copied().unwrap_or(0));
    let floor = level + 5 * (level - low).max(scaled(1, geometry.bits));
    let radius = i32::from(RADIUS);
    let (mut sum, mut mx, mut my, mut xx, mut yy, mut xy) = (0.0f32, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (row, dy) in raw.chunks_exact(usize::from(SIDE)).zip(-radius..) {
        for (raw, dx) in row.iter().zip(-radius..) {
            let value = scaled(*raw, geometry.bits);
            if value <= floor || dx * dx + dy * dy > radius * radius {
                continue;
            }
            // The root: a bright core must not outweigh the arms.
            let light = libm::sqrtf((value - level) as f32);
            let (dx, dy) = (dx as f32, dy as f32);
            sum += light;
            (mx, my) = (mx + light * dx, my + light * dy);
            (xx, yy, xy) = (xx + light * dx * dx, yy + light * dy * dy, xy + light * dx * dy);
        }
    }
    if sum <= 0.0 {
        return Ok(None);
    }
    let per = 1.0 / sum;
    let (mx, my) = (mx * per, my * per);
    let (xx, yy, xy) = (xx * per - mx * mx, yy * per - my * my, xy * per - mx * my);
    let angle = 0.5 * libm::atan2f(2.0 * xy, xx - yy);
    let at_px = [f32::from(x) + mx, f32::from(y) + my];
    let (sine, cosine) = sine_cosine(angle);
    Ok(Some(Piece { at_px, along: [cosine, sine], strength: 0, background: 0 }))
}
