//! The thesis's two other filters across the limb (§4.2, §7.2.2.1), for comparison with [`limb::crossing`]:
//! they find the limb by the shape of its rise, not by a share of the brightness behind it. Not flown.
//!
//! In: the pixels of a strip, as for the flight's crossing. Out: a limb point and its sigma, or nothing.
//! Both use the averaged line of [`limb`] from three scale heights outside a first guess, the outermost
//! place above half of the strip's range, to one and a half inside it. The thesis only names the filters;
//! the fitted models are this project's:
//!
//! | filter | fitted | the limb |
//! |---|---|---|
//! | [`exponential`] | `b exp(-h / H)` above an edge, `b` below, the edge moved until the squares are least | the edge, and `H ln 2` outward of it: half of `b` |
//! | [`polynomial`] | a polynomial of the fifth order | where it first passes half of the rise to its first maximum |
//!
//! The sigma is the residuals' root mean square over the slope there, with the floors of the flight's
//! crossing.

use crate::earth::EarthParameters;
use crate::earth::limb::{self, Lines, Strip, StripPoint};
use fsw_hal::DetectorGeometry;

/// Fitted range outside and inside the first guess, scale heights.
const OUTSIDE_SCALES: f32 = 3.0;
const INSIDE_SCALES: f32 = 1.5;
/// Least range, px.
const LEAST_PX: f32 = 6.0;
/// Steps of the edge in a px.
const STEPS: usize = 8;
/// Order of the polynomial.
const ORDER: usize = 5;

/// The part of a joined line about the limb.
struct LimbProfile {
    profile: [f32; limb::MAX_LENGTH],
    /// First place, and the one after the last.
    from: usize,
    to: usize,
    /// Places of a line.
    length: usize,
    /// First guess.
    guess: usize,
    dark: f32,
    /// Greatest brightness over it.
    bright: f32,
    /// Scale height, places.
    scale: f32,
}

impl LimbProfile {
    /// `None` where there is none, or it is too weak, saturated, or outer space bright.
    fn new(
        pixels: &[u16],
        strip: &Strip,
        geometry: &DetectorGeometry,
        parameters: &EarthParameters,
    ) -> Option<Self> {
        let lines = Lines::of(pixels, strip)?;
        let (length, mut line) = (lines.length, lines.averaged()?);
        line.extend(length)?;
        let full_scale = f32::from(geometry.full_scale());
        let dark = line.dark()?;
        let inner = line.end;
        let used = line.known().get(limb::END_MARGIN..inner)?;
        let most = used.iter().fold(dark, |most, value| if *value > most { *value } else { most });
        if dark > parameters.strips.dark_share * full_scale
            || most - dark < parameters.strips.contrast_share * full_scale
            || most > parameters.strips.saturated_share * full_scale
        {
            return None;
        }
        let half = 0.5 * (dark + most);
        let guess = limb::END_MARGIN + used.iter().position(|value| *value > half)?;
        let scale =
            parameters.limb.scale_height_km / (strip.expected().km_per_px * strip.normal_cosine()).max(1e-3);
        let reach = |scales: f32| libm::ceilf((scales * scale).max(LEAST_PX)) as usize;
        let from = guess.saturating_sub(reach(OUTSIDE_SCALES)).max(limb::END_MARGIN);
        let to = (guess + reach(INSIDE_SCALES)).min(inner);
        (to > from + 2 * ORDER).then_some(Self {
            profile: line.counts,
            from,
            to,
            length,
            guess,
            dark,
            bright: most - dark,
            scale,
        })
    }

    /// Places and values.
    fn values(&self) -> impl Iterator<Item = (f32, f32)> {
        let Self { from, to, .. } = *self;
        self.profile.iter().enumerate().take(to).skip(from).map(|(place, value)| (place as f32, *value))
    }

    fn point(
        &self,
        inward: f32,
        rms: f32,
        slope: f32,
        strip: &Strip,
        parameters: &EarthParameters,
    ) -> Option<StripPoint> {
        let inside = inward > self.from as f32 && inward < self.to as f32 && slope > 1e-3;
        let noise = rms / slope * strip.normal_cosine();
        let height = parameters.limb.scatter_km / strip.expected().km_per_px.max(1e-3);
        let floor = parameters.strips.floor_px;
        let sigma = libm::sqrtf(noise * noise + floor * floor + height * height);
        (inside && sigma < limb::GREATEST_SIGMA_PX.max(limb::GREATEST_SIGMA_SHARE * self.scale)).then(|| {
            StripPoint {
                point: strip.point(self.length, inward, sigma),
                dark: self.dark,
                bright: self.bright,
            }
        })
    }
}

/// Sum of squares about the best exponential whose edge is at a place, and its brightness over the dark.
fn misfit(rise: &LimbProfile, edge: f32) -> (f32, f32) {
    let shape = |place: f32| if place >= edge { 1.0 } else { libm::expf((place - edge) / rise.scale) };
    let (mut squares, mut products, mut shapes) = (0.0, 0.0, 0.0);
    for (place, value) in rise.values() {
        let (value, shape) = (value - rise.dark, shape(place));
        squares += value * value;
        products += value * shape;
        shapes += shape * shape;
    }
    let bright = products / f32::max(shapes, 1e-6);
    (squares - bright * products, bright)
}

/// The limb in a strip by an exponential rise; as [`limb::crossing`].
pub fn exponential(
    pixels: &[u16],
    strip: &Strip,
    geometry: &DetectorGeometry,
    parameters: &EarthParameters,
) -> Option<StripPoint> {
    let rise = LimbProfile::new(pixels, strip, geometry, parameters)?;
    let step = 1.0 / STEPS as f32;
    let edge_at = |step_count: usize| rise.from as f32 + step * step_count as f32;
    let mut best: Option<(f32, usize)> = None;
    for number in 1..(rise.to - rise.from) * STEPS {
        let (squares, _) = misfit(&rise, edge_at(number));
        if best.is_none_or(|(least, _)| squares < least) {
            best = Some((squares, number));
        }
    }
    let (least, number) = best?;
    // The least of the parabola through three.
    let (before, _) = misfit(&rise, edge_at(number.checked_sub(1)?));
    let (after, _) = misfit(&rise, edge_at(number + 1));
    let bend = before - 2.0 * least + after;
    let aside = if bend > 0.0 { (0.5 * (before - after) / bend).clamp(-1.0, 1.0) } else { 0.0 };
    let edge = edge_at(number) + aside * step;
    let (squares, bright) = misfit(&rise, edge);
    let rms = libm::sqrtf(squares.max(0.0) / (rise.to - rise.from) as f32);
    let inward = edge - rise.scale * core::f32::consts::LN_2;
    rise.point(inward, rms, 0.5 * bright / rise.scale, strip, parameters)
}

/// A polynomial as a sum of those that are orthogonal over the places (Forsythe 1957): no matrix, no loss of
/// digits.
struct Polynomial {
    /// Middle and half length of the places.
    middle: f32,
    half: f32,
    /// Coefficients of the recurrence and of the sum.
    terms: [(f32, f32, f32); ORDER + 1],
}

impl Polynomial {
    /// Least squares through a rise.
    fn circle_through(rise: &LimbProfile) -> Self {
        let (from, to) = (rise.from as f32, rise.to as f32 - 1.0);
        let mut fit =
            Self { middle: 0.5 * (from + to), half: 0.5 * (to - from), terms: [(0.0, 0.0, 0.0); ORDER + 1] };
        let mut before = 1.0;
        for order in 0..=ORDER {
            let (mut norm, mut moment, mut product) = (0.0, 0.0, 0.0);
            for (place, value) in rise.values() {
                let at = (place - fit.middle) / fit.half;
                let base = fit.base(order, at);
                norm += base * base;
                moment += at * base * base;
                product += base * (value - rise.dark);
            }
            let norm = f32::max(norm, 1e-12);
            if let Some(term) = fit.terms.get_mut(order) {
                *term = (moment / norm, norm / before, product / norm);
            }
            before = norm;
        }
        fit
    }

    /// The orthogonal polynomial of an order, whose recurrence is known to the one before.
    fn base(&self, order: usize, at: f32) -> f32 {
        let (mut before, mut base) = (0.0, 1.0);
        for (k, (shift, weight, _)) in self.terms.iter().enumerate().take(order) {
            let weight = if k == 0 { 0.0 } else { *weight };
            (before, base) = (base, (at - shift) * base - weight * before);
        }
        base
    }

    fn value(&self, place: f32) -> f32 {
        let at = (place - self.middle) / self.half;
        self.terms.iter().enumerate().map(|(order, (.., share))| share * self.base(order, at)).sum()
    }
}

/// The limb in a strip by a polynomial of the fifth order; as [`limb::crossing`].
pub fn polynomial(
    pixels: &[u16],
    strip: &Strip,
    geometry: &DetectorGeometry,
    parameters: &EarthParameters,
) -> Option<StripPoint> {
    let rise = LimbProfile::new(pixels, strip, geometry, parameters)?;
    let fit = Polynomial::circle_through(&rise);
    // From the guess inwards to the first maximum, then outwards to half of it.
    let step = 1.0 / STEPS as f32;
    let mut place = rise.guess as f32;
    let mut most = fit.value(place);
    for _ in 0..(rise.to - rise.guess) * STEPS {
        let next = fit.value(place + step);
        if next <= most || place + step > rise.to as f32 - 1.0 {
            break;
        }
        (place, most) = (place + step, next);
    }
    let half = 0.5 * most;
    let mut inner = most;
    for _ in 0..(rise.to - rise.from) * STEPS {
        let outer = fit.value(place - step);
        if outer < half && inner > outer {
            let slope = (inner - outer) / step;
            let inward = place - (inner - half) / slope;
            let squares: f32 = rise
                .values()
                .map(|(place, value)| {
                    let left = value - rise.dark - fit.value(place);
                    left * left
                })
                .sum();
            let rms = libm::sqrtf(squares / (rise.to - rise.from) as f32);
            return rise.point(inward, rms, slope, strip, parameters);
        }
        (place, inner) = (place - step, outer);
        if place < rise.from as f32 {
            break;
        }
    }
    None
}

#[cfg(test)]
mod tests;
