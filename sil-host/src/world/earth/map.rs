//! The Earth's face as maps, so that a pixel costs a look-up.
//!
//! In: a place in axes that turn with the Earth (any length), the footprint of a pixel in km. Out: albedo.
//!
//! A map is a square ([`super::octahedron`]). Level 0 has 4096 cells a side, 4 to 9 km wide; each further
//! level half as many. Between corners a level is bilinear, between levels that fit the footprint it is
//! blended. Every corner is the albedo of its place at its level, [`super::albedo`]. Tiles are filled when
//! first looked at; what is in them depends on the face only.

use super::albedo::Albedo;
use super::cell::AREA;
use super::octahedron::{folded, unfolded};
use std::sync::OnceLock;

/// Cells along a side of level 0.
const SIDE: usize = 4096;
/// Levels; the last has a single tile.
const LEVELS: usize = 7;
/// Mean width of a cell of level 0, km: (4 pi 6371²)^(1/2) / 4096.
const CELL_KM: f64 = 5.514;
/// Cells along a side of a tile.
const TILE: usize = 64;
const TILE_CORNERS: usize = TILE + 1;
/// Steps of the stored albedo a unit.
const STEPS: f32 = 65_535.0;

/// 1.5 · 2²³: a number added to it is rounded to a whole one, which stands in the lowest bits.
const ROUNDER: f32 = 12_582_912.0;

type Tile = [u16; TILE_CORNERS * TILE_CORNERS];

static EMPTY: Tile = [0; TILE_CORNERS * TILE_CORNERS];

/// Where on the maps places are: tile (level, row, column), first of the four corners in it, and the way from
/// there.
#[derive(Debug, Clone)]
struct Corners {
    tile: [u32; AREA],
    corner: [u32; AREA],
    x: [f32; AREA],
    y: [f32; AREA],
}

impl Corners {
    /// Finds (`u`, `v`), 0 to 1 across the map, on whole levels.
    #[inline(never)]
    fn find(&mut self, u: &[f32], v: &[f32], levels: &[f32]) {
        const SHIFT: u32 = TILE.trailing_zeros();
        const LAST: u32 = TILE as u32 - 1;
        let count = levels.len().min(u.len()).min(v.len()).min(AREA);
        for k in 0..count {
            let number = (levels[k] + ROUNDER).to_bits();
            // 2^-level, from its bits: cells a side.
            let side = SIDE as f32 * f32::from_bits(((0x4b40_007f - number) & 0xff) << 23);
            let (at_x, at_y) = (u[k] * side, v[k] * side);
            let (i, j) = (whole(at_x).min(side - 1.0), whole(at_y).min(side - 1.0));
            (self.x[k], self.y[k]) = (at_x - i, at_y - j);
            let (i, j) = ((i + ROUNDER).to_bits() & 0xffff, (j + ROUNDER).to_bits() & 0xffff);
            self.tile[k] = (number & 15) << 24 | (j >> SHIFT) << 12 | i >> SHIFT;
            // Times 65, the corners along a side of a tile.
            let row = j & LAST;
            self.corner[k] = (row << SHIFT) + row + (i & LAST);
        }
    }
}

/// Where on the square places are.
#[inline(never)]
fn unfold([x, y, z]: [&[f32]; 3], u: &mut [f32], v: &mut [f32]) {
    for ((((x, y), z), u), v) in x.iter().zip(y).zip(z).zip(u).zip(v) {
        [*u, *v] = unfolded([*x, *y, *z]);
    }
}

/// Room for [`AlbedoMap::read`].
#[derive(Debug, Clone)]
pub struct MapBuffer {
    at: Corners,
    u: [f32; AREA],
    v: [f32; AREA],
    /// Numbers of the places between two levels, the level above, how far they are on the way to it.
    blended: [u8; AREA],
    above: [f32; AREA],
    blend: [f32; AREA],
}

impl MapBuffer {
    /// Nothing on it.
    pub const EMPTY: Self = Self {
        at: Corners { tile: [0; AREA], corner: [0; AREA], x: [0.0; AREA], y: [0.0; AREA] },
        u: [0.0; AREA],
        v: [0.0; AREA],
        blended: [0; AREA],
        above: [0.0; AREA],
        blend: [0.0; AREA],
    };
}

/// All levels.
#[derive(Debug)]
pub struct AlbedoMap {
    face: Albedo,
    levels: [Vec<OnceLock<Box<Tile>>>; LEVELS],
}

impl AlbedoMap {
    /// Maps of `face`, still empty.
    pub fn new(face: Albedo) -> Self {
        let level = |level: usize| {
            let tiles = (SIDE >> level) / TILE;
            (0..tiles * tiles).map(|_| OnceLock::new()).collect()
        };
        Self { face, levels: [0, 1, 2, 3, 4, 5, 6].map(level) }
    }

    /// The face of which they are.
    pub fn face(&self) -> &Albedo {
        &self.face
    }

    /// The level that fits a footprint of `km`: its binary logarithm, linear between powers of two.
    #[inline]
    pub fn level_of(km: f32) -> f32 {
        const PER_CELL: f32 = (1.0 / CELL_KM) as f32;
        let bits = (km * PER_CELL).max(1.0).to_bits() - 0x3f80_0000;
        (bits as f32 * (1.0 / 8_388_608.0)).min((LEVELS - 1) as f32)
    }

    /// The albedo at places `[x, y, z]`, at most [`AREA`] of them: takes levels between 0 and the last, and
    /// gives albedos.
    pub fn read(&self, places: [&[f32]; 3], levels: &mut [f32], cell_buffer: &mut MapBuffer) {
        let MapBuffer { at, blended, above, u, v, blend } = cell_buffer;
        let count = levels.len().min(AREA);
        unfold(places, &mut u[..count], &mut v[..count]);
        let mut blending = 0;
        for (k, level) in levels.iter_mut().enumerate() {
            let low = whole(*level).min((LEVELS - 2) as f32);
            let part = (4.0 * (*level - low) - 1.5).clamp(0.0, 1.0);
            *level = low + if part < 1.0 { 0.0 } else { 1.0 };
            // Those between two levels are looked up once more.
            let k_blended = blending % AREA;
            (blended[k_blended], blend[k_blended], above[k_blended]) = (k as u8, part, low + 1.0);
            blending += usize::from(part > 0.0 && part < 1.0);
        }
        at.find(&u[..count], &v[..count], levels);
        self.look_up(at, levels);
        if blending == 0 {
            return;
        }
        for (k, from) in blended[..blending].iter().enumerate() {
            // Never before its turn: the list names places in their order.
            (u[k], v[k]) = (u[usize::from(*from) % AREA], v[usize::from(*from) % AREA]);
        }
        at.find(&u[..blending], &v[..blending], &above[..blending]);
        self.look_up(at, &mut above[..blending]);
        for ((k, above), part) in blended[..blending].iter().zip(&*above).zip(&*blend) {
            let albedo = &mut levels[usize::from(*k)];
            *albedo += part * (above - *albedo);
        }
    }

    /// The albedos at places that have been found.
    fn look_up(&self, at: &Corners, albedos: &mut [f32]) {
        let mut last = u32::MAX;
        let mut corners: &Tile = &EMPTY;
        let places = at.tile.iter().zip(&at.corner).zip(&at.x).zip(&at.y);
        for (albedo, (((tile, corner), x), y)) in albedos.iter_mut().zip(places) {
            if *tile != last {
                last = *tile;
                let [level, row, column] = [tile >> 24, tile >> 12 & 0xfff, tile & 0xfff];
                corners = self.tile(level as usize, column as usize, row as usize);
            }
            let first = *corner as usize;
            // One slice, one check.
            let Some(near) = corners.get(first..first + TILE_CORNERS + 2) else { continue };
            let value = |k: usize| f32::from(near[k]);
            let above = value(0) + x * (value(1) - value(0));
            let below = value(TILE_CORNERS) + x * (value(TILE_CORNERS + 1) - value(TILE_CORNERS));
            *albedo = (above + y * (below - above)) * (1.0 / STEPS);
        }
    }

    #[inline]
    fn tile(&self, level: usize, column: usize, row: usize) -> &Tile {
        let tiles = (SIDE >> level) / TILE;
        self.levels[level][row * tiles + column].get_or_init(|| self.fill(level, column, row))
    }

    #[cold]
    fn fill(&self, level: usize, column: usize, row: usize) -> Box<Tile> {
        let per_side = 1.0 / (SIDE >> level) as f64;
        let size_km = CELL_KM * (1 << level) as f64;
        let mut tile = Box::new([0; TILE_CORNERS * TILE_CORNERS]);
        for (index, corner) in tile.iter_mut().enumerate() {
            let u = (column * TILE + index % TILE_CORNERS) as f64 * per_side;
            let v = (row * TILE + index / TILE_CORNERS) as f64 * per_side;
            let albedo = self.face.at(folded(u, v), size_km);
            *corner = (albedo * f64::from(STEPS) + 0.5) as u16;
        }
        tile
    }
}

/// The whole part of a number from 0 to 4096; of a whole number it may be the one before.
#[inline]
fn whole(x: f32) -> f32 {
    ((x - 0.5) + ROUNDER) - ROUNDER
}

#[cfg(test)]
impl AlbedoMap {
    /// The albedo at one place.
    pub(super) fn at(&self, [x, y, z]: [f32; 3], level: f32) -> f32 {
        let (mut albedo, mut cell_buffer) = ([level], MapBuffer::EMPTY);
        self.read([&[x], &[y], &[z]], &mut albedo, &mut cell_buffer);
        albedo[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::attitude::{matrix, uniform};
    use crate::world::noise::{Noise, Stream};

    fn map() -> AlbedoMap {
        AlbedoMap::new(Albedo::new(4, 0.3, 1.0))
    }

    #[test]
    fn the_map_is_the_face_to_a_few_per_cent_and_coarser_levels_are_its_means() {
        let map = map();
        let noise = Noise::new(6, 0, Stream::Attitude);
        let mut sums = [0.0; LEVELS];
        let (mut squares, mut most) = (0.0, 0.0f64);
        let count = 300;
        for index in 0..count {
            let place = matrix(uniform(&noise, index))[2];
            let seen = place.map(|c| c as f32);
            let error = f64::from(map.at(seen, 0.0)) - map.face.at(place, CELL_KM);
            squares += error * error;
            most = most.max(error.abs());
            (0..LEVELS).for_each(|k| sums[k] += f64::from(map.at(seen, k as f32)) / f64::from(count));
        }
        let rms = (squares / f64::from(count)).sqrt();
        println!("bilinear rms {rms:.4}, most {most:.3}, means {sums:.3?}");
        assert!(rms < 0.02);
        assert!(sums.iter().all(|mean| (mean - sums[0]).abs() < 0.03));
    }

    #[test]
    fn no_seam_shows() {
        // Along the equator's fold and the cuts of the southern half, steps of 60 m.
        let map = map();
        for (from, step) in [([1.0, 0.3, -1e-4], [0.0, 0.0, 1e-5]), ([0.6, -1e-4, -0.7], [0.0, 1e-5, 0.0])] {
            for level in [0.0, 1.5, 3.0] {
                let place = |k: i32| [0, 1, 2].map(|c| (from[c] + step[c] * f64::from(k)) as f32);
                let seen = |k: i32| map.at(place(k), level);
                assert!((0..20).all(|k| (seen(k) - seen(k + 1)).abs() < 0.01));
            }
        }
    }

    #[test]
    fn levels_blend_without_a_step() {
        let map = map();
        let place = [0.3, -0.5, 0.7];
        let seen = |k: i32| map.at(place, AlbedoMap::level_of(1.0 + 0.01 * k as f32));
        assert!((0..40_000).all(|k| (seen(k) - seen(k + 1)).abs() < 0.005));
        assert_eq!(AlbedoMap::level_of(22.056), 2.0);
    }
}
