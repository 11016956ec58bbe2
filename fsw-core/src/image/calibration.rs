//! What is known of a lens and its pixels: star profiles and correction tables, version 2, little-endian, and
//! the door at which they are checked.
//!
//! | offset | type | content |
//! |---|---|---|
//! | 0 | `[u8; 4]` | magic `SXCC` |
//! | 4 | u16 | version |
//! | 6 | u16 | header length in bytes, 64 |
//! | 8 | u32 | CRC-32 (ISO-HDLC) of every byte from offset 12 on |
//! | 12 | u32 | total length in bytes |
//! | 16 | u16, u16 | columns and rows of the detector, px |
//! | 20 | f32, f32 | optical centre, px |
//! | 28 | u16 | number of profiles P |
//! | 30 | u16 | from a profile to the next, px of distance from the optical centre; the first is at 0 |
//! | 32 | u16, u16 | columns C and rows R of correction tables |
//! | 36 | u16 | from a table to the next, px |
//! | 38 | u16 | 1: the tables are those of one quadrant, 0: of the whole detector |
//! | 40 | i16, i16 | optical coordinates of the first table, px; 0, 0 where they are those of one quadrant |
//! | 44 | f32 | px that a correction of 1 is worth |
//! | 48 | f32 | electrons of a scaled count |
//! | 52 | f32 | what the corrections leave of a centroid's error without noise, px, 1 sigma an axis |
//! | 56 | u32 | CRC-32 of what it was made from |
//! | 60 | f32 | colour of the stars it was made with, B-V |
//! | 64 | P x [`PROFILE_BYTES`] | profiles, see [`Profile`] |
//! | | C R x [`TABLE_BYTES`] | tables row by row of the detector: 10 rows of 10 pairs (i8, i8), correction in x and y at every tenth of a pixel from its centre on; the next pixel begins with the first again |
//!
//! Corrections (thesis §3.1.2, tab. 3.6, where an eleventh phase repeats the first) are interpolated between
//! the four tables about a centroid, and between the four entries about its place within the pixel (the
//! thesis rounds that to a tenth). Of one quadrant the others are mirror images: coordinates, phase and
//! correction change their signs. That holds for the lens; where pixels are not symmetric (an L, fig. 3.7) it
//! does not, and the tables are those of the whole detector.

pub use crate::file::CRC_FROM;
use crate::file::{self, Refusal, u16_at, u32_at};
use fsw_pixels::profile::Entry;
pub use fsw_pixels::profile::{POINTS_PER_PX, PROFILE_REACH_PX, Profile, RADIAL_POINTS, TANGENTIAL_POINTS};

/// First bytes of every file.
pub const MAGIC: [u8; 4] = *b"SXCC";
/// The layout this code reads.
pub const VERSION: u16 = 2;
/// Length of the header in bytes.
pub const HEADER_BYTES: usize = 64;
/// Length of a profile's numbers before its points.
pub const PROFILE_HEADER_BYTES: usize = 8;
/// Length of a profile.
pub const PROFILE_BYTES: usize = PROFILE_HEADER_BYTES + 2 * RADIAL_POINTS * TANGENTIAL_POINTS;
/// Phases of a table along an axis; after the last comes the first, of the next pixel.
pub const PHASES: usize = 10;
/// Length of a table.
pub const TABLE_BYTES: usize = 2 * PHASES * PHASES;

/// So far the optical centre may have been refined since the lens was calibrated, px: "the shape of the PSF
/// does not vary when moving the optical center by one pixel" (thesis §3.1.2.2).
pub const CENTRE_PX: f32 = 1.5;

/// Why bytes were refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CalibrationError {
    /// Does not begin with the magic: no such file.
    NotACalibration,
    /// A layout this code does not read (the version found).
    Version(u16),
    /// Shorter or longer than its header says.
    Length,
    /// The checksum does not match: bytes were damaged.
    Checksum,
    /// Numbers contradict each other or make no sense.
    Structure,
}

impl From<Refusal> for CalibrationError {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Magic => Self::NotACalibration,
            Refusal::Version(found) => Self::Version(found),
            Refusal::Length => Self::Length,
            Refusal::Checksum => Self::Checksum,
            Refusal::Header => Self::Structure,
        }
    }
}

/// A checked calibration; borrows its bytes.
#[derive(Clone, Copy, Debug)]
pub struct Calibration<'a> {
    /// The bytes under the checksum, and it.
    protected: (&'a [u8], u32),
    source_crc: u32,
    size_px: [u16; 2],
    centre_px: [f32; 2],
    profiles: &'a [[u8; PROFILE_BYTES]],
    profiles_per_px: f32,
    tables: &'a [[u8; TABLE_BYTES]],
    columns: usize,
    rows: usize,
    tables_per_px: f32,
    mirrored: bool,
    first_px: [f32; 2],
    px_per_entry: f32,
    electrons_per_count: f32,
    residual_px: f32,
    colour: f32,
}

/// A number that is finite.
fn f32_at(bytes: &[u8], offset: usize) -> Option<f32> {
    u32_at(bytes, offset).map(f32::from_bits).filter(|value| value.is_finite())
}

/// Two neighbours of a line of `count` points about `at`, and how far beyond the first, in shares of their
/// distance; beyond the ends a line goes straight on, for one step.
fn between(at: f32, count: usize) -> (usize, f32) {
    let last = count.saturating_sub(2);
    let index = (at.max(0.0) as usize).min(last);
    (index, (at - index as f32).clamp(-1.0, 2.0))
}

impl<'a> Calibration<'a> {
    /// Checks magic, version, length, checksum and structure, in this order.
    ///
    /// # Errors
    /// The first check that fails, see [`CalibrationError`].
    pub fn open(bytes: &'a [u8]) -> Result<Self, CalibrationError> {
        let protected = file::check(bytes, MAGIC, VERSION, HEADER_BYTES)?;
        Self::parse(bytes, protected).ok_or(CalibrationError::Structure)
    }

    fn parse(bytes: &'a [u8], protected: (&'a [u8], u32)) -> Option<Self> {
        let half = |offset| u16_at(bytes, offset);
        let [profile_count, columns, rows] = [28, 32, 34].map(|offset| half(offset).map(usize::from));
        let (profile_count, columns, rows) = (profile_count?, columns?, rows?);
        if profile_count == 0 || columns < 2 || rows < 2 {
            return None;
        }
        let (profiles, tables) =
            bytes.get(HEADER_BYTES..)?.split_at_checked(PROFILE_BYTES * profile_count)?;
        if tables.len() != TABLE_BYTES.checked_mul(columns * rows)? {
            return None;
        }
        let profiles = profiles.as_chunks::<PROFILE_BYTES>().0;
        if !profiles.iter().all(|profile| read_profile(profile).is_some()) {
            return None;
        }
        let per_px = |offset| half(offset).filter(|step| *step > 0).map(|step| 1.0 / f32::from(step));
        let within = |offset, low: f32, high: f32| f32_at(bytes, offset).filter(|v| *v >= low && *v <= high);
        Some(Self {
            protected,
            source_crc: u32_at(bytes, 56)?,
            size_px: [half(16)?, half(18)?],
            centre_px: [within(20, -65_536.0, 131_072.0)?, within(24, -65_536.0, 131_072.0)?],
            profiles,
            profiles_per_px: per_px(30)?,
            tables: tables.as_chunks::<TABLE_BYTES>().0,
            columns,
            rows,
            tables_per_px: per_px(36)?,
            mirrored: half(38)? == 1,
            first_px: [f32::from(half(40)? as i16), f32::from(half(42)? as i16)],
            px_per_entry: within(44, 0.0, 0.1)?,
            electrons_per_count: within(48, 1e-3, 1e6)?,
            residual_px: within(52, 1e-4, 1.0)?,
            colour: within(60, -1.0, 3.0)?,
        })
    }

    /// CRC-32 of the file, by which a parameter table names it.
    pub fn crc(&self) -> u32 {
        self.protected.1
    }

    /// The bytes under the checksum, and it.
    pub fn protected(&self) -> (&'a [u8], u32) {
        self.protected
    }

    /// CRC-32 of what it was made from.
    pub fn source_crc(&self) -> u32 {
        self.source_crc
    }

    /// Columns and rows of the detector it is for, px.
    pub fn size_px(&self) -> [u16; 2] {
        self.size_px
    }

    /// The optical centre it counts from, px.
    pub fn centre_px(&self) -> [f32; 2] {
        self.centre_px
    }

    /// Whether it is of a detector of this size, and of an optical centre within [`CENTRE_PX`] of this, px.
    pub fn is_of(&self, size_px: [u16; 2], [cx, cy]: [f32; 2]) -> bool {
        let [x, y] = self.centre_px;
        self.size_px == size_px && (x - cx).abs().max((y - cy).abs()) <= CENTRE_PX
    }

    /// Electrons of a scaled count.
    pub fn electrons_per_count(&self) -> f32 {
        self.electrons_per_count
    }

    /// What the corrections leave of a centroid's error without noise, px, 1 sigma an axis.
    pub fn residual_px(&self) -> f32 {
        self.residual_px
    }

    /// The profile of a star so far from the optical centre.
    pub fn profile(&self, radius_px: f32) -> Option<Profile<'a>> {
        self.nearest_profile(radius_px).map(|(profile, _)| profile)
    }

    /// The profile nearest to a distance from the optical centre, and how far it is displaced by colour, px a
    /// magnitude of B-V.
    fn nearest_profile(&self, radius_px: f32) -> Option<(Profile<'a>, f32)> {
        let nearest = (radius_px * self.profiles_per_px + 0.5) as usize;
        let last = self.profiles.len().saturating_sub(1);
        self.profiles.get(nearest.min(last)).and_then(read_profile)
    }

    /// How far a star of this B-V at `at_px` is displaced by its colour, px.
    pub fn colour_shift_px(&self, [x, y]: [f32; 2], b_v: f32) -> [f32; 2] {
        let [cx, cy] = self.centre_px;
        let (dx, dy) = (x - cx, y - cy);
        let radius_px = libm::sqrtf(dx * dx + dy * dy);
        let outwards_px =
            self.nearest_profile(radius_px).map_or(0.0, |(_, colour_px)| colour_px) * (b_v - self.colour);
        let per_radius = outwards_px / radius_px.max(1.0);
        [dx * per_radius, dy * per_radius]
    }

    /// What is to be added to a centroid at `at_px` on the detector, px (thesis §3.1.2).
    pub fn correction_px(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let [cx, cy] = self.centre_px;
        let (optical_x, optical_y) = (x - cx, y - cy);
        let turned = |at: f32| self.mirrored && at < 0.0;
        let along = |at: f32, pixel: f32, first: f32, count: usize| {
            let (at, pixel) = if turned(at) { (-at, -pixel) } else { (at, pixel) };
            let (table, part) = between((at - first) * self.tables_per_px, count);
            let phase = between((pixel - libm::floorf(pixel)) * PHASES as f32, PHASES + 1);
            (table, part, phase)
        };
        let [first_x, first_y] = self.first_px;
        let (column, right, phase_x) = along(optical_x, x, first_x, self.columns);
        let (row, below, phase_y) = along(optical_y, y, first_y, self.rows);
        let mut correction = [0.0; 2];
        let tables = [
            (0, 0, (1.0 - right) * (1.0 - below)),
            (1, 0, right * (1.0 - below)),
            (0, 1, (1.0 - right) * below),
            (1, 1, right * below),
        ];
        for (dx, dy, share) in tables {
            let Some(table) = self.tables.get((row + dy) * self.columns + column + dx) else { continue };
            let [here_x, here_y] = interpolated(table, phase_x, phase_y);
            correction = [correction[0] + share * here_x, correction[1] + share * here_y];
        }
        let [dx, dy] = correction.map(|entry| entry * self.px_per_entry);
        [if turned(optical_x) { -dx } else { dx }, if turned(optical_y) { -dy } else { dy }]
    }
}

/// Both corrections of a table between the four entries about a phase.
fn interpolated(table: &[u8; TABLE_BYTES], (x, right): (usize, f32), (y, below): (usize, f32)) -> [f32; 2] {
    let entries = table.as_chunks::<2>().0;
    let entry = |x: usize, y: usize| {
        entries.get(y * PHASES + x).map_or([0.0; 2], |entry: &Entry| entry.map(|byte| f32::from(byte as i8)))
    };
    let after = |phase: usize| if phase + 1 < PHASES { phase + 1 } else { 0 };
    let (a, b) = (entry(x, y), entry(after(x), y));
    let (c, d) = (entry(x, after(y)), entry(after(x), after(y)));
    let mix = |a: f32, b: f32, c: f32, d: f32| {
        let (above, under) = (a + right * (b - a), c + right * (d - c));
        above + below * (under - above)
    };
    [mix(a[0], b[0], c[0], d[0]), mix(a[1], b[1], c[1], d[1])]
}

/// A profile: f32, what a point of 1 is worth; f32, how far a star is displaced outwards for each magnitude
/// that its B-V exceeds the header's, px (lateral colour); then the points. Gives it and that displacement.
fn read_profile(bytes: &[u8; PROFILE_BYTES]) -> Option<(Profile<'_>, f32)> {
    let scale = f32_at(bytes, 0).filter(|scale| *scale > 0.0 && *scale < 1.0)?;
    let points = bytes.get(PROFILE_HEADER_BYTES..)?.as_chunks::<2>().0;
    let colour_px = f32_at(bytes, 4).filter(|px| px.abs() <= 1.0)?;
    Some((Profile { scale, rows: points.as_chunks::<RADIAL_POINTS>().0 }, colour_px))
}

#[cfg(test)]
pub(crate) mod sample;
#[cfg(test)]
mod tests;
