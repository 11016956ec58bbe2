//! A star's image over the pixels, and the sums of a least-squares fit of it.
//!
//! In: the pixels about a star above its floor, where the star is thought to stand, the lens's [`Profile`]
//! there. Out: [`Sums`], from which `matched` of `fsw-core` takes the next step of the fit.

/// Points of a profile a pixel.
pub const POINTS_PER_PX: usize = 4;
/// How far from its place a profile knows of a star, px; at its last point nothing is known any more.
pub const PROFILE_REACH_PX: usize = 4;
/// Points of a profile along the field's radius.
pub const RADIAL_POINTS: usize = 2 * PROFILE_REACH_PX * POINTS_PER_PX + 1;
/// Points of a profile across it, one half: the other is its mirror image.
pub const TANGENTIAL_POINTS: usize = PROFILE_REACH_PX * POINTS_PER_PX + 1;
/// Half the side of the square whose pixels are asked, px: the profile's reach and the centre's distance from
/// the middle.
pub const HALF: usize = 4;
/// Its side.
pub const SIDE: usize = 2 * HALF + 1;

/// A point of a profile (i16), or both corrections at a phase (two i8).
pub type Entry = [u8; 2];
/// A row of a profile.
pub type ProfileRow = [Entry; RADIAL_POINTS];

/// A star's light over pixels that are sensitive throughout, at one distance from the optical centre: the
/// share of it that a pixel gets, by the pixel's place from the star. It is a quadratic B-spline.
///
/// [`TANGENTIAL_POINTS`] rows of [`RADIAL_POINTS`] i16, the spline's coefficients, along the field's radius
/// from the inside out, the first row on the radius itself, points [`POINTS_PER_PX`] a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Profile<'a> {
    /// What a point of 1 is worth.
    pub scale: f32,
    /// Points, row by row.
    pub rows: &'a [ProfileRow],
}

/// The point of a quadratic B-spline nearest to `at`, and how far `at` is from half a point before it and
/// from half a point after.
#[inline(always)]
fn nearest(at: f32) -> (usize, [f32; 2]) {
    let index = (at + 0.5) as usize;
    let past = at - index as f32;
    (index, [0.5 - past, 0.5 + past])
}

/// A quadratic B-spline with these coefficients about its nearest point, and its slope a point.
#[inline(always)]
fn spline(middle: f32, to_middle: f32, from_middle: f32, [before, after]: [f32; 2]) -> [f32; 2] {
    let (rise, fall) = (before * to_middle, after * from_middle);
    [middle + 0.5 * (after * fall - before * rise), rise + fall]
}

impl Profile<'_> {
    /// Share of a star's light in each pixel of a line, and its change along and across the field's radius, a
    /// pixel; zero beyond the reach. `first_px` is how far from the star the first pixel is along and across
    /// the radius, `step_px` how much farther each is than the one before.
    #[inline(always)]
    pub fn light_of_line(&self, first_px: [f32; 2], step_px: [f32; 2], lights: &mut [[f32; 3]]) {
        self.each_of_line(first_px, step_px, lights, |light, here| *light = here.unwrap_or([0.0; 3]));
    }

    /// [`Self::light_of_line`] of a star that moves: the mean over its places.
    #[inline(never)]
    fn light_of_way(&self, first_px: [f32; 2], step_px: [f32; 2], way: &Way, lights: &mut [[f32; 3]]) {
        let of_place = Self { scale: self.scale / f32::from(way.places), rows: self.rows };
        lights.fill([0.0; 3]);
        for place in 0..way.places {
            let steps = f32::from(place) - 0.5 * f32::from(way.places.saturating_sub(1));
            let [along, across] = first_px;
            let [step_along, step_across] = way.step_px;
            let first_px = [along - steps * step_along, across - steps * step_across];
            of_place.each_of_line(first_px, step_px, lights, |light, here| {
                let Some([f, along, across]) = here else { return };
                *light = [light[0] + f, light[1] + along, light[2] + across];
            });
        }
    }

    /// Puts the light of each pixel of a line, `None` beyond the reach.
    #[inline(always)]
    fn each_of_line(
        &self,
        first_px: [f32; 2],
        step_px: [f32; 2],
        lights: &mut [[f32; 3]],
        put: impl Fn(&mut [f32; 3], Option<[f32; 3]>),
    ) {
        const POINTS: f32 = POINTS_PER_PX as f32;
        let [mut along, mut across] = first_px.map(|px| px * POINTS);
        let [step_along, step_across] = step_px.map(|px| px * POINTS);
        along += PROFILE_REACH_PX as f32 * POINTS;
        for light in lights {
            put(light, self.light(along, across));
            (along, across) = (along + step_along, across + step_across);
        }
    }

    /// [`Self::light_of_line`] of one pixel, so many points from the first column and from the first row;
    /// `None` beyond the reach.
    #[inline(always)]
    fn light(&self, along: f32, across: f32) -> Option<[f32; 3]> {
        let side = if across < 0.0 { -1.0 } else { 1.0 };
        let (column, in_row) = nearest(along);
        let (row, in_column) = nearest(across * side);
        let first = column.wrapping_sub(1);
        // The row before the first is its mirror image.
        let above = if row == 0 { 1 } else { row - 1 };
        let (above, here, below) = (self.rows.get(above)?, self.rows.get(row)?, self.rows.get(row + 1)?);
        let of_row = |row: &ProfileRow| {
            let points = row.get(first..)?.first_chunk::<3>()?;
            let [a, b, c] = points.map(|point| i32::from(i16::from_le_bytes(point)));
            Some(spline(b as f32, (b - a) as f32, (c - b) as f32, in_row))
        };
        let [above, slope_above] = of_row(above)?;
        let [here, slope_here] = of_row(here)?;
        let [below, slope_below] = of_row(below)?;
        let [light, across] = spline(here, here - above, below - here, in_column);
        let [along, _] = spline(slope_here, slope_here - slope_above, slope_below - slope_here, in_column);
        let per_px = self.scale * POINTS_PER_PX as f32;
        Some([light * self.scale, along * per_px, across * side * per_px])
    }
}

/// How a star's image moves in an exposure: places on a line, evenly apart, its own in their middle.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// Number of places, at least 1.
    pub places: u8,
    /// From a place to the next, along and across the field's radius, px.
    pub step_px: [f32; 2],
}

/// A star as the fit has it.
#[derive(Clone, Copy, Debug)]
pub struct Star {
    /// Its place from the middle pixel, px.
    pub at_px: [f32; 2],
    /// Unit vector of the field's radius.
    pub radius: [f32; 2],
    /// `β`, see [`Sums`].
    pub beta: f32,
}

/// What is summed over the pixels: value `s`, share of light `f`, `g = -∇f`, weight `q = 1 / (f + β)`. As
/// `q (f + β) = 1`, the sums with `q f` follow from these.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    /// Pixels, and `f`.
    pub even: [f32; 2],
    /// `s`, `q s` and `q s²`.
    pub seen: [f32; 3],
    /// `q`.
    pub weight: f32,
    /// `q g s`, `q g f` and `q g`, along and across the field's radius.
    pub pull: [[f32; 3]; 2],
    /// `q g gᵀ`: along, both, across.
    pub slope: [f32; 3],
    /// `q² g²`, along and across.
    pub noise: [f32; 2],
}

impl Sums {
    /// The sums over the pixels up to `half` from the middle, of a star at rest.
    #[inline(never)]
    pub fn of(pixels: &[[f32; SIDE]; SIDE], half: usize, star: &Star, profile: &Profile) -> Self {
        let light = |first, step, lights: &mut [_]| profile.light_of_line(first, step, lights);
        Self::by(pixels, half, star, light)
    }

    /// The same of a star that moves while it is exposed.
    #[inline(never)]
    pub fn of_moving(
        pixels: &[[f32; SIDE]; SIDE],
        half: usize,
        star: &Star,
        (profile, way): (&Profile, &Way),
    ) -> Self {
        let light = |first, step, lights: &mut [_]| profile.light_of_way(first, step, way, lights);
        Self::by(pixels, half, star, light)
    }

    /// The same with the light of each line as [`Profile::light_of_line`] gives it.
    #[inline(always)]
    fn by(
        pixels: &[[f32; SIDE]; SIDE],
        half: usize,
        star: &Star,
        light_of_line: impl Fn([f32; 2], [f32; 2], &mut [[f32; 3]]),
    ) -> Self {
        let ([x, y], [cos, sin]) = (star.at_px, star.radius);
        let mut sums = Self::default();
        let mut lights = [[0.0; 3]; SIDE];
        let lights = lights.get_mut(..2 * half + 1).unwrap_or(&mut []);
        let rows = pixels.iter().skip(HALF - half).take(2 * half + 1);
        for (dy, row) in (-(half as i32)..).zip(rows) {
            let from_y = dy as f32 - y;
            // First the light of the row, then its sums: together they need more numbers at hand than there
            // are registers.
            let from_x = -(half as f32) - x;
            let first_px = [from_x * cos + from_y * sin, from_y * cos - from_x * sin];
            light_of_line(first_px, [cos, -sin], lights);
            for (light, value) in lights.iter().zip(row.iter().skip(HALF - half)) {
                // Beyond the reach of the profile nothing is known.
                if light[0] != 0.0 {
                    sums.add(light, *value, star.beta);
                }
            }
        }
        sums
    }

    /// Adds a pixel with this share of the light and its change along and across the radius, value, and the
    /// star's `β`.
    #[inline(always)]
    fn add(&mut self, [f, along, across]: &[f32; 3], value: f32, beta: f32) {
        let q = 1.0 / (f + beta);
        let (u, v) = (-q * along, -q * across);
        let qs = q * value;
        self.even = [self.even[0] + 1.0, self.even[1] + f];
        self.seen = [self.seen[0] + value, self.seen[1] + qs, self.seen[2] + qs * value];
        self.weight += q;
        self.pull[0] = [self.pull[0][0] + u * value, self.pull[0][1] + u * f, self.pull[0][2] + u];
        self.pull[1] = [self.pull[1][0] + v * value, self.pull[1][1] + v * f, self.pull[1][2] + v];
        self.slope = [self.slope[0] - u * along, self.slope[1] - u * across, self.slope[2] - v * across];
        self.noise = [self.noise[0] + u * u, self.noise[1] + v * v];
    }
}
