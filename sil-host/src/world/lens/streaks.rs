//! Images of moving points: lines, integrated along their way.
//!
//! In: the way of a point as a polyline, the electrons that each of its chords collects, the PSF, what of a
//! pixel is sensitive. Out: light added to the pixels of a window.
//!
//! A pixel whose centre lies `w` beside a way of length `l`, across from the place `s` along it, gets
//!
//! ```text
//! density(s) · Σ G_p(w) · (E_p(s) - E_p(s - l))
//! ```
//!
//! The parts `p` of the image are its Gaussians in slabs along the way; `G_p` is the light of a part, as a
//! pixel sees it, projected on the normal of the way, `E_p` the integral of its projection on the way. Away
//! from the ends `E` is 1 or 0 and the line is exact. Near an end the product of the two projections stands
//! for a part's image, which is exact for one Gaussian and a small pixel (`streaks_tests.rs` says what is
//! left). A faint line has one part.
//!
//! Projections stand in tables with steps of 1/8 px, linear in between: Gaussians in bins, convolved with the
//! trapezoids to which a pixel's square and its dead corner project. The variance that bins and interpolation
//! add is taken off the Gaussians. There are tables of the images at both ends and, on long lines, every
//! `TABLE_PX` between them, made when a window first needs them; from one to the next their light is blended.

use super::psf::{BLOBS_MAX, Blob, Psf};
use crate::world::detector::pixel::PixelResponse;
use crate::world::normal::QuickNormal;
use crate::world::sky::colour::BANDS;
use fsw_hal::Window;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Longest way between two tables, px.
const TABLE_PX: f64 = 48.0;
/// Slabs of the image of a line that is not faint.
const SLABS: usize = 8;
/// Light a pixel of way below which a line is faint: one table, one part. A pixel is then wrong by less than
/// 1 e-.
const FAINT_E_PX: f64 = 10.0;
/// Steps of a table, px.
const STEP_PX: f64 = 0.125;
/// Variance that the bins of Gaussian and pixel and the interpolation add to a profile: 1/12, 1/12 and 1/6 of
/// a step squared, px².
const STEP_VARIANCE_PX2: f64 = STEP_PX * STEP_PX / 3.0;
/// Least variance of a Gaussian in a table, px².
const LEAST_VARIANCE_PX2: f64 = 2.5e-3;
/// How far a pixel's sensitive part reaches beyond its centre of gravity, px, rounded up.
const PIXEL_REACH_PX: f64 = 1.0;

/// A place on a way.
#[derive(Debug, Clone, Copy)]
struct Knot {
    place: [f64; 2],
    /// From the start, px.
    at_px: f64,
    /// Light a pixel of way, e-.
    density: f64,
    /// Direction of the way past it, a unit vector.
    past: [f64; 2],
}

/// The way of a point while the shutter is open.
#[derive(Debug, Clone)]
struct Streak {
    knots: Vec<Knot>,
    length_px: f64,
    /// Its colour: electrons in each part of the band.
    electrons: [f64; BANDS],
    /// Of places at even distances from end to end; a faint one has one, of its middle.
    tables: Vec<OnceLock<Profile>>,
}

/// What is drawn as lines in an exposure.
#[derive(Debug, Clone)]
pub struct Streaks {
    psf: Arc<Psf>,
    response: PixelResponse,
    reach_px: f64,
    streaks: Vec<Streak>,
}

impl Streaks {
    /// None yet.
    pub fn new(psf: Arc<Psf>, response: PixelResponse) -> Self {
        let reach_px = ((psf.reach_px() + PIXEL_REACH_PX) / STEP_PX).ceil() * STEP_PX;
        Self { psf, response, reach_px, streaks: Vec::new() }
    }

    /// Adds the line through `points`; every chord collects `electrons`. Points that do not move make none.
    pub fn push(&mut self, mut points: Vec<[f64; 2]>, electrons: [f64; BANDS]) {
        points.dedup();
        if points.len() < 2 {
            return;
        }
        let knots = knots(&points, electrons.iter().sum());
        let length_px = knots.last().map_or(0.0, |knot| knot.at_px);
        let faint = knots.iter().all(|knot| knot.density < FAINT_E_PX);
        let tables = if faint { 1 } else { (length_px / TABLE_PX).ceil() as usize + 1 };
        let tables = (0..tables).map(|_| OnceLock::new()).collect();
        self.streaks.push(Streak { knots, length_px, electrons, tables });
    }

    /// Adds the mean electrons of all lines to `electrons`, the pixels of `window` row by row.
    pub fn add_to(&self, window: Window, electrons: &mut [f64]) {
        for streak in &self.streaks {
            for number in 1..streak.knots.len() {
                let part = Part::new(streak, number, self.reach_px);
                for y in part.rows(window) {
                    let columns = part.columns(y, window);
                    let start = usize::from(y - window.y) * usize::from(window.width);
                    let from = start + usize::from(columns.start.saturating_sub(window.x));
                    for (x, pixel) in columns.zip(&mut electrons[from..]) {
                        if let Some((s, w, density)) = part.beside([f64::from(x), f64::from(y)]) {
                            *pixel += density * self.light(streak, s, w);
                        }
                    }
                }
            }
        }
    }

    /// Light at a pixel `w` px beside the place `s` of a line, were its density 1.
    #[inline]
    fn light(&self, streak: &Streak, s: f64, w: f64) -> f64 {
        let intervals = streak.tables.len() - 1;
        if intervals == 0 {
            return self.profile(streak, 0).light(s, w, streak.length_px);
        }
        let at = (s / streak.length_px).clamp(0.0, 1.0) * intervals as f64;
        let index = (at as usize).min(intervals - 1);
        let [near, far] =
            [index, index + 1].map(|table| self.profile(streak, table).light(s, w, streak.length_px));
        near + (at - index as f64) * (far - near)
    }

    #[inline]
    fn profile<'a>(&self, streak: &'a Streak, table: usize) -> &'a Profile {
        streak.tables[table].get_or_init(|| {
            let intervals = streak.tables.len() - 1;
            let (part, slabs) =
                if intervals == 0 { (0.5, 1) } else { (table as f64 / intervals as f64, SLABS) };
            let (place, along) = streak.at(part * streak.length_px);
            let blob = Blob { x_px: 0.0, y_px: 0.0, sigma_px: 1.0, electrons: 0.0 };
            let mut blobs = [blob; BLOBS_MAX];
            let count = self.psf.image(place[0], place[1], &streak.electrons, &mut blobs);
            Profile::new(&mut blobs[..count], place, along, self.response, self.reach_px, slabs)
        })
    }
}

/// Length of a way, px.
pub fn length_px(points: &[[f64; 2]]) -> f64 {
    points.windows(2).map(|ends| Direction::of(ends[0], ends[1]).length_px).sum()
}

/// From one place to another.
#[derive(Clone, Copy)]
struct Direction {
    along: [f64; 2],
    length_px: f64,
}

impl Direction {
    fn of(from: [f64; 2], to: [f64; 2]) -> Self {
        let way = [0, 1].map(|axis| to[axis] - from[axis]);
        let length_px = libm::hypot(way[0], way[1]);
        Self { along: way.map(|part| part / length_px.max(f64::MIN_POSITIVE)), length_px }
    }
}

/// The knots of a way, at least two places, whose chords collect `electrons` each.
fn knots(points: &[[f64; 2]], electrons: f64) -> Vec<Knot> {
    let last = points.len() - 1;
    let chord = |k: usize| Direction::of(points[k], points[k + 1]);
    let mut at_px = 0.0;
    let knot = |k: usize| {
        let (before, after) = (chord(k.max(1) - 1), chord(k.min(last - 1)));
        let past = Direction::of([0.0; 2], [0, 1].map(|axis| before.along[axis] + after.along[axis])).along;
        at_px += if k == 0 { 0.0 } else { before.length_px };
        let density = 2.0 * electrons / (before.length_px + after.length_px);
        Knot { place: points[k], at_px, density, past }
    };
    (0..=last).map(knot).collect()
}

impl Streak {
    /// The place `s` px from the start, and the direction there.
    fn at(&self, s: f64) -> ([f64; 2], [f64; 2]) {
        let next = self.knots.partition_point(|knot| knot.at_px < s).clamp(1, self.knots.len() - 1);
        let from = &self.knots[next - 1];
        let Direction { along, .. } = Direction::of(from.place, self.knots[next].place);
        ([0, 1].map(|axis| from.place[axis] + (s - from.at_px) * along[axis]), along)
    }
}

/// A chord and the pixels across from it. Where two chords meet, the line that halves their bend parts them;
/// pixels beyond the ends of the way are those of its first and last chord.
struct Part<'a> {
    from: &'a Knot,
    to: &'a Knot,
    way: Direction,
    first: bool,
    last: bool,
    /// How far the pixels go beyond the knots along the chord, and across it, px.
    beyond_px: [f64; 2],
    reach_px: f64,
}

impl<'a> Part<'a> {
    fn new(streak: &'a Streak, number: usize, reach_px: f64) -> Self {
        let (from, to) = (&streak.knots[number - 1], &streak.knots[number]);
        let way = Direction::of(from.place, to.place);
        let (first, last) = (number == 1, number + 1 == streak.knots.len());
        // Half a bend makes the pixels on its outer side reach farther.
        let beyond = |knot: &Knot, end: bool| {
            let sine = knot.past[0] * way.along[1] - knot.past[1] * way.along[0];
            if end { reach_px } else { 2.0 * reach_px * sine.abs() + 1e-6 }
        };
        Self { from, to, way, first, last, beyond_px: [beyond(from, first), beyond(to, last)], reach_px }
    }

    /// The rows of a window that it may touch.
    fn rows(&self, window: Window) -> Range<u16> {
        let reach = |axis: usize| {
            let [one, other] = [self.from.place[axis], self.to.place[axis]];
            // Farther than the corner of what lies across.
            [one.min(other) - 1.5 * self.reach_px, one.max(other) + 1.5 * self.reach_px]
        };
        let columns = within(reach(0), window.x, window.width);
        if columns.is_empty() { 0..0 } else { within(reach(1), window.y, window.height) }
    }

    /// The columns of a window that it may touch in a row.
    fn columns(&self, y: u16, window: Window) -> Range<u16> {
        let [dx, dy] = self.way.along;
        let down = f64::from(y) - self.from.place[1];
        let along = span(dx, down * dy, -self.beyond_px[0], self.way.length_px + self.beyond_px[1]);
        let across = span(-dy, down * dx, -self.reach_px, self.reach_px);
        let left = self.from.place[0];
        within([left + along[0].max(across[0]), left + along[1].min(across[1])], window.x, window.width)
    }

    /// Where a pixel stands beside the way: how far from its start, how far across, and the density there;
    /// `None` if another chord has it.
    #[inline]
    fn beside(&self, pixel: [f64; 2]) -> Option<(f64, f64, f64)> {
        let ahead = |knot: &Knot| {
            let [x, y] = [0, 1].map(|axis| pixel[axis] - knot.place[axis]);
            x * knot.past[0] + y * knot.past[1] >= 0.0
        };
        if !(self.first || ahead(self.from)) || (!self.last && ahead(self.to)) {
            return None;
        }
        let [dx, dy] = self.way.along;
        let [x, y] = [0, 1].map(|axis| pixel[axis] - self.from.place[axis]);
        let (s, w) = (x * dx + y * dy, y * dx - x * dy);
        let part = (s / self.way.length_px).clamp(0.0, 1.0);
        Some((self.from.at_px + s, w, self.from.density + part * (self.to.density - self.from.density)))
    }
}

/// Where `slope · x + offset` lies between `least` and `most`.
fn span(slope: f64, offset: f64, least: f64, most: f64) -> [f64; 2] {
    if slope.abs() < 1e-9 {
        let inside = (least..=most).contains(&offset);
        return if inside { [f64::MIN, f64::MAX] } else { [f64::MAX, f64::MIN] };
    }
    let [one, other] = [(least - offset) / slope, (most - offset) / slope];
    [one.min(other), one.max(other)]
}

/// The pixels of a window's side between two places.
fn within([least, most]: [f64; 2], from: u16, length: u16) -> Range<u16> {
    let first = least.ceil().max(f64::from(from));
    let end = (most.floor() + 1.0).min(f64::from(from) + f64::from(length));
    if first < end { first as u16..end as u16 } else { 0..0 }
}

/// The image of a standing point along and across a direction.
#[derive(Debug, Clone)]
struct Profile {
    reach_px: f64,
    /// Light a pixel across.
    across: Table,
    /// Of each part light a pixel across, and the integral along, which ends at 1.
    parts: Vec<(Table, Table)>,
}

/// A function between -reach and reach: at each step the value, and the way to the next.
type Table = Vec<[f64; 2]>;

impl Profile {
    /// Of `blobs` about `centre`, in so many slabs.
    fn new(
        blobs: &mut [Blob],
        centre: [f64; 2],
        along: [f64; 2],
        response: PixelResponse,
        reach_px: f64,
        slabs: usize,
    ) -> Self {
        let across = [-along[1], along[0]];
        let half = (reach_px / STEP_PX) as usize;
        let ahead = |blob: &Blob| blob.x_px * along[0] + blob.y_px * along[1];
        blobs.sort_by(|one, other| ahead(one).total_cmp(&ahead(other)));
        let total: f64 = blobs.iter().map(|blob| blob.electrons).sum();
        let mut whole = vec![0.0; 2 * half + 1];
        let part = |slab: &[Blob]| {
            let beside = projected(slab, centre, across, response, half);
            whole.iter_mut().zip(&beside).for_each(|(whole, part)| *whole += part / total);
            let light = projected(slab, centre, along, response, half);
            let sums = light.iter().scan(0.0, |sum, light| {
                *sum += light;
                Some(*sum - 0.5 * light)
            });
            let sums: Vec<f64> = sums.collect();
            let all = sums.last().copied().unwrap_or(1.0);
            (steps(beside.iter().map(|light| light / total)), steps(sums.iter().map(|sum| sum / all)))
        };
        let parts = blobs.chunks(blobs.len().div_ceil(slabs)).map(part).collect();
        Self { reach_px, across: steps(whole.into_iter()), parts }
    }

    /// Light of a way of `length_px` and density 1 at a pixel beside it.
    #[inline]
    fn light(&self, s: f64, w: f64, length_px: f64) -> f64 {
        if s >= self.reach_px && s <= length_px - self.reach_px {
            return self.at(&self.across, w);
        }
        let of = |(across, sum): &(Table, Table)| {
            self.at(across, w) * (self.at(sum, s) - self.at(sum, s - length_px))
        };
        self.parts.iter().map(of).sum()
    }

    #[inline]
    fn at(&self, table: &Table, at_px: f64) -> f64 {
        let place = (at_px.clamp(-self.reach_px, self.reach_px) + self.reach_px) * (1.0 / STEP_PX);
        let index = place as usize;
        let [value, step] = table[index.min(table.len() - 1)];
        value + (place - index as f64) * step
    }
}

fn steps(values: impl Iterator<Item = f64>) -> Table {
    let values: Vec<f64> = values.collect();
    let next = values.iter().skip(1).chain(values.last());
    values.iter().zip(next).map(|(value, next)| [*value, next - value]).collect()
}

/// The light of `blobs` as pixels see it that lie in `direction` of `centre`: a pixel, at `half` steps on
/// either side.
fn projected(
    blobs: &[Blob],
    centre: [f64; 2],
    direction: [f64; 2],
    response: PixelResponse,
    half: usize,
) -> Vec<f64> {
    let normal = QuickNormal::table();
    let mut bins = vec![0.0; 2 * half + 1];
    for blob in blobs {
        let offset = [blob.x_px - centre[0], blob.y_px - centre[1]];
        let middle = offset[0] * direction[0] + offset[1] * direction[1];
        let variance = blob.sigma_px * blob.sigma_px - STEP_VARIANCE_PX2;
        let (sigma, share) = (variance.max(LEAST_VARIANCE_PX2).sqrt(), blob.electrons);
        let reach = Psf::blob_reach_px(sigma) as f64;
        let first = ((middle - reach) / STEP_PX + half as f64).max(0.0) as usize;
        let last = ((middle + reach) / STEP_PX + half as f64).max(0.0) as usize;
        let below = |edge: f64| share * normal.below(((edge - half as f64) * STEP_PX - middle) / sigma);
        let mut left = below(first as f64 - 0.5);
        for (index, bin) in bins.iter_mut().enumerate().take(last + 1).skip(first) {
            let right = below(index as f64 + 0.5);
            *bin += right - left;
            left = right;
        }
    }
    let reach = (PIXEL_REACH_PX / STEP_PX) as usize;
    let below = |step: f64| response.below(direction, (step - reach as f64) * STEP_PX);
    let kernel: Vec<f64> =
        (0..=2 * reach).map(|k| (below(k as f64 + 0.5) - below(k as f64 - 0.5)) / STEP_PX).collect();
    let mut padded = vec![0.0; reach];
    padded.extend(&bins);
    padded.extend(vec![0.0; reach]);
    let seen = |light: &[f64]| light.iter().zip(&kernel).map(|(light, share)| light * share).sum();
    padded.windows(kernel.len()).map(seen).collect()
}

#[cfg(test)]
mod tests;
