//! The Sun's direction from the terminator, where no star gives the attitude (ALGORITHMS part 5, degraded
//! forms).
//!
//! In: the whole detector, the Earth's centre on it, and the angle at the Earth between Sun and camera, which
//! the orbit gives. Out: the azimuth of the Sun about the Earth's centre, with its sigma.
//!
//! Every sixteenth row is read in blocks of eight pixels, each without its brightest, a hot one or a star. A
//! block on the body is lit or dark. The Sun's azimuth is the one that the blocks contradict least: a lit one
//! by how far the Sun would be below the horizon there, three times as much as a dark one by how far above,
//! as the sea is dark under a low Sun and nothing bright without one. Of 32 azimuths the best is taken, then
//! the vertex of the parabola through it and its neighbours.
//!
//! The error is that of the terminator: clouds, twilight and dark seas move the place at which the ground is
//! as bright as the threshold by degrees of the Sun's elevation. Part of that is common to the whole
//! terminator: it cancels where both of its halves are in the field, as the elevation rises with the azimuth
//! on the one and falls on the other, and turns the Sun where one is. The rest lasts over thousands of
//! kilometres, and is not averaged.

use super::EarthParameters;
use super::search::{FINE_SHIFT, sky_level};
use super::view::{View, add_angles};
use crate::camera::Camera;
use crate::frames::{Direction, EarthPath};
use crate::trigonometry::sine_cosine;
use fsw_hal::{Detector, DetectorError, Window};

/// Azimuths tried.
const AZIMUTHS: usize = 32;
/// Cosine and sine of their distance, a 32nd of a turn.
const NEXT: [f32; 2] = [0.980_785_3, 0.195_090_32];
/// The same, rad.
const STEP_RAD: f32 = core::f32::consts::TAU / AZIMUTHS as f32;
/// Side of a block, px.
const BLOCK_PX: usize = 8;
/// Pixels of a block that count.
const COUNTED: u32 = BLOCK_PX as u32 - 1;
/// Blocks, lit and dark, without which there is no terminator.
const FEWEST_BLOCKS: f32 = 12.0;
/// Sine of the least elevation of the camera over a block's ground: nearer to the limb the air shines beyond
/// the terminator.
const LEAST_VIEW: f32 = 0.2;
/// A block is lit above this share of the brightest one: 2^-6, the sea under a Sun of 10 deg, clouds under
/// one of 1 deg; and at least this share of full scale, ten sigma of a block.
const LIT_SHIFT: u32 = 6;
const LEAST_LIT_SHARE: f32 = 0.003;
/// Sine of the Sun's elevation at which ground of medium brightness is as bright as the threshold.
const THRESHOLD_SINE: f32 = 0.05;
/// Weight of a lit block against that of a dark one.
const LIT_WEIGHT: f32 = 3.0;
/// Sine of the elevations that count as the terminator's.
const NEAR_SINE: f32 = 0.15;
/// Standard deviations of the Sun's elevation at the threshold, rad: common to the whole terminator, and of a
/// part of it. Set on flights of `any-earth-alone`, seeds 1 and 2.
const COMMON_RAD: f32 = 0.07;
const PART_RAD: f32 = 0.02;
/// Greatest mean contradiction, sine of an elevation: above, what is seen is no sphere under the Sun.
const GREATEST_MISFIT: f32 = 0.02;
/// Least contradiction, times that of the best azimuth, of those farther than an eighth of a turn from it.
const LEAST_CONTRAST: f32 = 2.0;

/// Where the Sun stands by the terminator.
#[derive(Clone, Copy, Debug)]
pub struct SunSeen {
    /// Its direction.
    pub direction: Direction<EarthPath>,
    /// Standard deviation of its azimuth about the Earth's centre, rad.
    pub sigma_rad: f32,
}

/// What the blocks say of an azimuth of the Sun.
#[derive(Clone, Copy, Default)]
struct Votes {
    contradiction: f32,
    /// Of the blocks at the terminator, how fast the Sun's elevation changes there with its azimuth: sum and
    /// sum of squares.
    slopes: f32,
    squares: f32,
    count: f32,
}

impl Votes {
    /// Adds a block with this upward normal in the view's axes, the Sun at an azimuth; `phase`: cosine and
    /// sine of the angle at the Earth between Sun and camera.
    fn add(&mut self, [along, first, second]: [f32; 3], weight: f32, phase: [f32; 2], azimuth: [f32; 2]) {
        let ([near, away], [cosine, sine]) = (phase, azimuth);
        let elevation_sine = away * (first * cosine + second * sine) - near * along;
        let excess = elevation_sine - THRESHOLD_SINE;
        self.contradiction += (weight * excess).max(0.0);
        if libm::fabsf(excess) < NEAR_SINE {
            let slope = away * (second * cosine - first * sine);
            (self.slopes, self.squares) = (self.slopes + slope, self.squares + slope * slope);
            self.count += 1.0;
        }
    }

    /// Standard deviation of the azimuth, rad, by least squares over the terminator; `None` where too little
    /// of one is in the field.
    fn sigma_rad(&self) -> Option<f32> {
        let common = COMMON_RAD * self.slopes / self.squares;
        let parts2 = PART_RAD * PART_RAD * self.count / self.squares;
        let seen = self.count >= FEWEST_BLOCKS && self.squares > 0.0;
        seen.then(|| libm::sqrtf(common * common + parts2))
    }
}

/// What the blocks say of every azimuth.
struct Ballot {
    azimuths: [Votes; AZIMUTHS],
    lit: f32,
    dark: f32,
}

impl Ballot {
    /// Adds a block.
    fn add(&mut self, upward: [f32; 3], is_lit: bool, phase: [f32; 2]) {
        let (weight, count) = if is_lit { (-LIT_WEIGHT, &mut self.lit) } else { (1.0, &mut self.dark) };
        *count += 1.0;
        let mut azimuth = [1.0, 0.0];
        for votes in &mut self.azimuths {
            votes.add(upward, weight, phase, azimuth);
            azimuth = add_angles(azimuth, NEXT);
        }
    }

    /// Contradiction of an azimuth.
    fn at(&self, index: usize) -> f32 {
        self.azimuths.get(index % AZIMUTHS).map_or(f32::INFINITY, |votes| votes.contradiction)
    }

    /// The azimuth that is contradicted least, rad, and its standard deviation; `None` without a terminator,
    /// or where none stands out.
    fn best(&self) -> Option<(f32, f32)> {
        if self.lit < FEWEST_BLOCKS || self.dark < FEWEST_BLOCKS {
            return None;
        }
        let (mut best, mut least) = (0, f32::INFINITY);
        for index in 0..AZIMUTHS {
            if self.at(index) < least {
                (best, least) = (index, self.at(index));
            }
        }
        let far = AZIMUTHS / 8 + 1..AZIMUTHS - AZIMUTHS / 8;
        let rival = far.fold(f32::INFINITY, |rival, away| rival.min(self.at(best + away)));
        if least > GREATEST_MISFIT * (self.lit + self.dark) || rival < LEAST_CONTRAST * least {
            return None;
        }
        let (before, after) = (self.at(best + AZIMUTHS - 1), self.at(best + 1));
        let bend = before - 2.0 * least + after;
        let part = if bend > 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
        let sigma_rad = self.azimuths.get(best)?.sigma_rad()?;
        Some((STEP_RAD * (best as f32 + part.clamp(-0.5, 0.5)), sigma_rad))
    }
}

/// Calls `visit` with the place of every block of the detector and the sum of its pixels but the brightest.
fn for_each_block<D: Detector<Error = DetectorError>>(
    detector: &mut D,
    buffer: &mut [u16],
    step_px: u16,
    mut visit: impl FnMut([f32; 2], u32),
) -> Result<(), DetectorError> {
    let geometry = detector.geometry();
    let width = geometry.width_px;
    let pixels = buffer.get_mut(..usize::from(width)).ok_or(DetectorError::BufferLength)?;
    let step = usize::from(step_px).max(BLOCK_PX);
    for row in (step_px / 2..geometry.height_px).step_by(step) {
        detector.read(Window { x: 0, y: row, width, height: 1 }, pixels)?;
        for (index, block) in pixels.chunks_exact(BLOCK_PX).enumerate().step_by(step / BLOCK_PX) {
            let x = (index * BLOCK_PX) as f32 + 0.5 * (BLOCK_PX as f32 - 1.0);
            let brightest = block.iter().fold(0, |most, pixel| most.max(*pixel));
            let sum: u32 = block.iter().map(|pixel| u32::from(*pixel)).sum();
            visit([x, f32::from(row)], sum - u32::from(brightest));
        }
    }
    Ok(())
}

/// Upward normal of a block's ground in the view's axes; `None` where it shows none, or too slantwise.
fn upward(at_px: [f32; 2], camera: &Camera, view: &View) -> Option<[f32; 3]> {
    let upward = view.upward_where_met(&camera.earth_direction(at_px)?)?;
    let [along, ..] = upward;
    (-along >= LEAST_VIEW).then_some(upward)
}

/// The Sun's direction by the terminator on the detector. `view`: the Earth; `phase`: cosine of the
/// angle at the Earth between the directions to Sun and camera. `buffer` must hold the detector's longer
/// side. `None` where too little of a terminator is in the field, or what is seen is no sphere under the Sun.
///
/// # Errors
/// Of the detector; [`DetectorError::BufferLength`] for a short buffer.
#[inline(never)]
pub fn sun_seen(
    detector: &mut impl Detector<Error = DetectorError>,
    buffer: &mut [u16],
    (camera, view): (&Camera, &View),
    phase: f32,
    parameters: &EarthParameters,
) -> Result<Option<SunSeen>, DetectorError> {
    let least = LEAST_LIT_SHARE * f32::from(detector.geometry().full_scale());
    let step_px = parameters.search.step_px;
    let sky = sky_level(detector, buffer, step_px)?.max(0) as u32;
    let sky = (sky * COUNTED) >> FINE_SHIFT;
    let mut brightest = 0;
    for_each_block(detector, buffer, step_px, |_, sum| brightest = brightest.max(sum))?;
    let lit = sky + (brightest.saturating_sub(sky) >> LIT_SHIFT).max((least * COUNTED as f32) as u32);
    let phase = [phase, libm::sqrtf((1.0 - phase * phase).max(0.0))];
    let mut ballot = Ballot { azimuths: [Votes::default(); AZIMUTHS], lit: 0.0, dark: 0.0 };
    for_each_block(detector, buffer, step_px, |at_px, sum| {
        if let Some(upward) = upward(at_px, camera, view) {
            ballot.add(upward, sum > lit, phase);
        }
    })?;
    Ok(ballot.best().and_then(|(azimuth_rad, sigma_rad)| {
        let (sine, cosine) = sine_cosine(azimuth_rad);
        Some(SunSeen { direction: view.direction([cosine, sine], phase)?, sigma_rad })
    }))
}

#[cfg(test)]
mod tests;
