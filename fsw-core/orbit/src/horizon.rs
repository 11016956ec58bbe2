//! Model of the horizon: how high the limb stands above the ellipsoid, and how that is known.
//!
//! Height above `earth.limb.height_km` at azimuth φ about nadir (φ = 0 along the flight, local vertical,
//! local horizontal axes), where the limb's place has the sine of latitude `s` and stands at the distance
//! `D`:
//!
//! `h = h0 + D e + c1 s + c2 (1/3 - s²) + Σ (a_k cos kφ + b_k sin kφ)`, k = 0 to 4.
//!
//! `h0` is the mean, `e` what the detection of edges adds as an angle, `c1` and `c2` the season and the
//! tropics; they are constants. The Fourier coefficients are a field over the ground of deviation σ and
//! length L: on a limb of radius ρ the wave k has the share `(1 + (k L / 2ρ)²)^-3/2` of its variance, twice
//! for k > 0, and lasts for `2 L / w`, where `w` is the speed of the limb over the turning Earth.
//!
//! The errors of edges, each shared by a patch of limb, are noise of the looks as far as the next look finds
//! others. Where the limb stays, as in GEO, the same come again for hours: the share that lasts is a part of
//! the coefficients, `2 σ² / n` of variance in each of `n` patches around the limb (the mean half of that),
//! and what a look's row holds of these is no noise of its own ([`LimbGeometry::left_of_edges`]).
//!
//! All of it is in sphere space, where the ellipsoid is a sphere (coordinates along the pole longer by
//! `a / b`), as the heights measured are: seen from a place that is off by 900 km an ellipsoid's limb is 7 km
//! from where the sphere's would be. What is moved in space moves in sphere space by [`LimbGeometry::moves`].
//!
//! Around one limb every term is a combination of the same nine waves, as is the change of height by a
//! displacement `dr` of the satellite, `-n · dr` with the limb's normal `n = cos θ (x cos φ + y sin φ) - z
//! sin θ`. So nine numbers hold all that a second's points say ([`super::look`]).

use super::body::CentralBody;
use super::factor::{EDGE, FIELD, HEIGHT, MISALIGNMENT, Row, STATES, SUMMER, TROPICS};
use super::noise::{decay, square};
use super::parameters::OrbitParameters;
use super::{OrbitState, lvlh};
use fsw_ground::matrix::{cross, dot, dot_slices, plus_scaled, scaled};
use fsw_ground::trigonometry::{hypotenuse, sine_cosine};
use nalgebra::{Matrix3, Vector3};

/// Number of the waves: 1, cos φ, sin φ, ... sin 4φ.
pub const WAVES: usize = 9;
/// Number of their angular frequencies.
const FREQUENCIES: usize = 5;
/// Their angular frequencies.
const ORDERS: [f32; FREQUENCIES] = [0.0, 1.0, 2.0, 3.0, 4.0];
/// Time for which the constants last, s: 30 days, a third of a season.
const CONSTANT_S: f64 = 30.0 * 86_400.0;

/// Azimuths at which the waves of a moved limb are summed: twice the waves, so that none is taken for
/// another.
const AZIMUTHS: usize = 18;
/// Cosine and sine of the angle between two of them, 20 deg.
const STEP: [f32; 2] = [0.939_692_6, 0.342_020_15];
/// Newton's steps to the moved limb; the third leaves less than a metre of 300 km.
const NEWTON_STEPS: usize = 3;
/// Greatest angle between the limbs, rad.
const MOST_RAD: f32 = 0.5;

/// Waves of the limb from another place about that from here.
#[derive(Clone, Copy, Debug)]
pub struct MovedLimb {
    /// Its height, km.
    pub height_km: [f32; WAVES],
    /// Derivatives of the height by the move, LVLH axes.
    pub gradient: [[f32; WAVES]; 3],
}

/// How a coefficient of the waves varies: a Gauss-Markov process.
#[derive(Clone, Copy, Debug)]
pub struct Variation {
    /// Its variance, km².
    pub variance_km2: f32,
    /// How long it lasts, s.
    pub lasts_s: f32,
}

impl Variation {
    /// Factor by which the coefficient decays over a span.
    pub fn decay(&self, dt: f64) -> f32 {
        decay(dt, self.lasts_s.into()) as f32
    }
}

/// How often an angular frequency stands among the waves: the mean once, any other as cosine and sine.
fn times(k: f32) -> f32 {
    if k > 0.0 { 2.0 } else { 1.0 }
}

/// What the frequencies have, by wave: cosine and sine of a frequency have the same.
pub fn of_waves<T: Copy>([a, b, c, d, e]: [T; FREQUENCIES]) -> [T; WAVES] {
    [a, b, b, c, c, d, d, e, e]
}

/// The waves at an azimuth given by its cosine and sine.
pub fn waves(cosine: f32, sine: f32) -> [f32; WAVES] {
    let mut waves = [1.0; WAVES];
    let (mut c, mut s) = (1.0, 0.0);
    for (place, odd) in waves.iter_mut().skip(1).zip([true, false].iter().cycle()) {
        if *odd {
            (c, s) = (c * cosine - s * sine, s * cosine + c * sine);
        }
        *place = if *odd { c } else { s };
    }
    waves
}

/// By how much of it a length along the pole is longer in sphere space.
fn stretch(body: CentralBody) -> f64 {
    let facts = body.facts();
    facts.radius_km / facts.polar_km - 1.0
}

/// A vector in sphere space, along ICRS axes.
fn stretched(vector: &Vector3<f64>, stretch: f64, pole: &Vector3<f64>) -> Vector3<f64> {
    plus_scaled(vector, stretch * dot(pole, vector), pole)
}

/// Sine and cosine of the limb cone's half angle from a place in sphere space, and the limb's distance, km;
/// `None` inside the sphere.
fn limb(place_km: &Vector3<f64>, radius_km: f32) -> Option<[f64; 3]> {
    let radius_km = f64::from(radius_km);
    let sine = radius_km / libm::sqrt(dot(place_km, place_km));
    if sine > 0.9999 {
        return None;
    }
    let cosine = libm::sqrt(1.0 - sine * sine);
    Some([sine, cosine, radius_km * cosine / sine])
}

/// The limb's distance from a position about `body`, km; `None` as for [`LimbGeometry::of`].
pub fn limb_distance_km(
    body: CentralBody,
    position_km: &Vector3<f64>,
    pole: &Vector3<f64>,
    radius_km: f32,
) -> Option<f32> {
    limb(&stretched(position_km, stretch(body), pole), radius_km).map(|[.., distance_km]| distance_km as f32)
}

/// The limb as it is seen from a place: geometry of the horizon model.
#[derive(Clone, Copy, Debug)]
pub struct LimbGeometry {
    /// Radius of the sphere, km: that of the body's equator, and the limb's height.
    pub radius_km: f32,
    /// From ICRS to the local vertical, local horizontal axes of sphere space.
    pub axes: Matrix3<f32>,
    /// From a move along ICRS axes to that in sphere space along these.
    pub moves: Matrix3<f32>,
    /// Sine of the limb cone's half angle.
    pub sine: f32,
    /// Its cosine.
    pub cosine: f32,
    /// Distance of the limb, km.
    pub distance_km: f32,
    /// Speed of the limb over the ground, km/s.
    pub ground_km_s: f32,
}

impl LimbGeometry {
    /// From a state about `body`, whose limb is a sphere of `radius_km` in sphere space; `None` inside it,
    /// and where position and velocity span no plane.
    #[inline(never)]
    pub fn of(body: CentralBody, state: &OrbitState, pole: &Vector3<f64>, radius_km: f32) -> Option<Self> {
        let facts = body.facts();
        let OrbitState { position_km, velocity_km_s, .. } = state;
        let stretch = stretch(body);
        let place_km = stretched(position_km, stretch, pole);
        let axes =
            lvlh::lvlh(&place_km, &stretched(velocity_km_s, stretch, pole))?.map(|element| element as f32);
        let square_km2 = dot(position_km, position_km);
        let [sine, cosine, distance_km] = limb(&place_km, radius_km)?;
        // Of the point below the satellite: angular velocity r x v / r² less that of the body.
        let turn = scaled(&cross(position_km, velocity_km_s), 1.0 / square_km2);
        let turn = plus_scaled(&turn, -facts.rate_rad_s, pole);
        let pole = pole.map(|element| element as f32);
        Some(Self {
            radius_km,
            axes,
            moves: axes + axes * pole * (pole.transpose() * stretch as f32),
            sine: sine as f32,
            cosine: cosine as f32,
            distance_km: distance_km as f32,
            ground_km_s: (libm::sqrt(dot(&turn, &turn)) * facts.radius_km) as f32,
        })
    }

    /// Radius of the limb's circle, km.
    pub fn circle_km(&self) -> f32 {
        self.radius_km * self.cosine
    }

    /// The limb seen after a move of the satellite by `moved_km` (sphere space, LVLH), about that from here:
    /// waves of its height, and of the derivatives of that by the move. At each azimuth the ray is sought
    /// (Newton's method) that passes the centre of a sphere at its radius.
    #[inline(never)]
    pub fn moved(&self, moved_km: &Vector3<f32>) -> MovedLimb {
        let radius_km = self.radius_km;
        let place = moved_km - Vector3::new(0.0, 0.0, radius_km / self.sine);
        let mut limb = MovedLimb { height_km: [0.0; WAVES], gradient: [[0.0; WAVES]; 3] };
        let (mut cosine, mut sine) = (1.0, 0.0);
        for _ in 0..AZIMUTHS {
            // Angle beyond the limb from here.
            let mut beyond = 0.0;
            let mut normal = Vector3::zeros();
            let mut scale = 1.0;
            for _ in 0..NEWTON_STEPS {
                let (s, c) = sine_cosine(beyond);
                let (across, along) = (self.sine * c + self.cosine * s, self.cosine * c - self.sine * s);
                let ray = Vector3::new(across * cosine, across * sine, along);
                let distance_km = -place.dot(&ray);
                let off = place + ray * distance_km;
                let length = libm::sqrtf(off.dot(&off)).max(1.0);
                normal = off * (1.0 / length);
                scale = self.distance_km / distance_km.max(1.0);
                beyond = (beyond + (radius_km - length) / distance_km.max(1.0)).clamp(-MOST_RAD, MOST_RAD);
            }
            let height_km = self.distance_km * sine_cosine(beyond).0;
            let values = [height_km, -normal.x * scale, -normal.y * scale, -normal.z * scale];
            let [along_x, along_y, along_z] = &mut limb.gradient;
            let places = [&mut limb.height_km, along_x, along_y, along_z];
            for (sums, value) in places.into_iter().zip(values) {
                for (k, (sum, wave)) in sums.iter_mut().zip(waves(cosine, sine)).enumerate() {
                    // Fourier's sums: the mean, and twice that of every other wave.
                    *sum += value * wave * (if k == 0 { 1.0 } else { 2.0 }) * (1.0 / AZIMUTHS as f32);
                }
            }
            let [c, s] = STEP;
            (cosine, sine) = (cosine * c - sine * s, sine * c + cosine * s);
        }
        limb
    }

    /// Sensitivity of a combination of waves: to position (at `limb`) and velocity (`lag_s` after the points
    /// were seen), constants and field, and to a rotation of the Earth path (`path`: from ICRS to it).
    #[inline(never)]
    pub fn sensitivity(
        &self,
        combination: &[f32],
        limb: &MovedLimb,
        (pole, path): (&Vector3<f32>, &Matrix3<f32>),
        lag_s: f32,
    ) -> Row {
        let mut row = [0.0; STATES];
        let mut wave = combination.iter().copied();
        let mut next = || wave.next().unwrap_or(0.0);
        let [w0, wx, wy, wxx, wxy] = [next(), next(), next(), next(), next()];
        let move_by = Vector3::from(limb.gradient.each_ref().map(|waves| dot_slices(waves, combination)));
        let move_by = self.moves.tr_mul(&move_by);
        // z x n = cos θ (y cos φ - x sin φ).
        let turn_by = path * self.axes.tr_mul(&Vector3::new(-wy, wx, 0.0)) * self.distance_km;
        // Latitude: s = s0 + sx cos φ + sy sin φ.
        let pole = self.axes * pole;
        let [s0, sx, sy] = [-self.sine * pole.z, self.cosine * pole.x, self.cosine * pole.y];
        let squared = (s0 * s0 + 0.5 * (sx * sx + sy * sy)) * w0
            + 2.0 * s0 * (sx * wx + sy * wy)
            + 0.5 * (sx * sx - sy * sy) * wxx
            + sx * sy * wxy;
        let motion = move_by.iter().copied().chain(move_by.iter().map(|element| -lag_s * element));
        let constants = [w0, self.distance_km * w0, s0 * w0 + sx * wx + sy * wy, w0 / 3.0 - squared];
        let all = motion.chain(constants).chain(combination.iter().copied()).chain(turn_by.iter().copied());
        for (place, element) in row.iter_mut().zip(all) {
            *place = element;
        }
        row
    }

    /// How the waves' coefficients vary, by frequency (see [`of_waves`]): the field, and what lasts of the
    /// edges' errors, which many patches share evenly among the waves.
    pub fn variations(&self, parameters: &OrbitParameters) -> [Variation; FREQUENCIES] {
        let ratio = parameters.field_length_km / (2.0 * self.circle_km().max(1.0));
        let share = |k: f32| {
            let falling = 1.0 + (k * ratio) * (k * ratio);
            times(k) / (falling * libm::sqrtf(falling))
        };
        let all = ORDERS.map(share).iter().sum::<f32>();
        let unit = parameters.field_sigma_km * parameters.field_sigma_km / all;
        let field_rate = 1.0 / self.field_lasts_s(parameters);
        let (edge_km2, edge_rate) = (self.lasting_edge_km2(parameters), self.edge_rate(parameters));
        ORDERS.map(|k| {
            let (field, edge) = (share(k) * unit, times(k) * edge_km2);
            let variance_km2 = field + edge;
            let rate = field * field_rate + edge * edge_rate;
            Variation { variance_km2, lasts_s: variance_km2 / rate.max(1e-20) }
        })
    }

    /// Variance that what lasts of the edges' errors gives the mean height, km²; twice that the other waves.
    fn lasting_edge_km2(&self, parameters: &OrbitParameters) -> f32 {
        let patches = core::f32::consts::TAU * self.circle_km().max(1.0) / self.patch_km(parameters);
        self.lasting_share(parameters) * self.edge_km2(parameters) / patches
    }

    /// Variance that is left of a look's row of unit variance without what lasts of the edges' errors: that
    /// is in the waves.
    pub fn left_of_edges(&self, combination: &[f32], parameters: &OrbitParameters) -> f32 {
        let mean = combination.first().copied().unwrap_or(0.0);
        let square = 2.0 * dot_slices(combination, combination) - mean * mean;
        let lasting = square * self.lasting_edge_km2(parameters);
        1.0 - lasting.min(self.lasting_share(parameters))
    }

    /// How much of the edges' errors lasts until the next look.
    fn lasting_share(&self, parameters: &OrbitParameters) -> f32 {
        let left = 1.0 - self.between_looks_s(parameters) * self.edge_rate(parameters);
        if left > 0.0 { left } else { 0.0 }
    }

    /// At what rate the edges' errors become others: by the limb that moves over a patch, and by the light.
    fn edge_rate(&self, parameters: &OrbitParameters) -> f32 {
        self.ground_km_s.max(1e-3) / self.patch_km(parameters) + 1.0 / parameters.edge_light_s
    }

    /// How long the field lasts, s.
    pub fn field_lasts_s(&self, parameters: &OrbitParameters) -> f32 {
        2.0 * parameters.field_length_km / self.ground_km_s.max(1e-6)
    }

    /// Time between looks, s: until the limb has moved over two patches of an edge's error.
    pub fn between_looks_s(&self, parameters: &OrbitParameters) -> f32 {
        let passing_s = 2.0 * self.patch_km(parameters) / self.ground_km_s.max(1e-3);
        passing_s.min(parameters.edge_longest_s)
    }

    /// Length of limb that shares the error of an edge, km.
    pub fn patch_km(&self, parameters: &OrbitParameters) -> f32 {
        hypotenuse(parameters.edge_patch_km, parameters.edge_patch_rad * self.distance_km)
    }

    /// Variance of an edge, km².
    pub fn edge_km2(&self, parameters: &OrbitParameters) -> f32 {
        let seen_km = parameters.edge_sigma_rad * self.distance_km;
        parameters.edge_sigma_km * parameters.edge_sigma_km + seen_km * seen_km
    }
}

/// Factor by which the constants decay over a span.
pub fn constants_decay(dt: f64) -> f32 {
    decay(dt, CONSTANT_S) as f32
}

/// Prior of the constants: mean and sigma of the states from [`HEIGHT`] on.
pub fn constants(parameters: &OrbitParameters) -> [[f32; 2]; FIELD - HEIGHT] {
    [
        [0.0, parameters.height_sigma_km],
        [0.0, parameters.height_sigma_rad],
        [0.0, parameters.summer_sigma_km],
        [parameters.tropics_km, parameters.tropics_sigma_km],
    ]
}

/// Prior of every state but position and velocity: means, and sigmas.
pub fn prior(geometry: &LimbGeometry, parameters: &OrbitParameters) -> (Row, Row) {
    let (mut means, mut sigmas) = ([0.0; STATES], [0.0; STATES]);
    for ((mean, sigma), given) in means.iter_mut().zip(&mut sigmas).skip(HEIGHT).zip(constants(parameters)) {
        [*mean, *sigma] = given;
    }
    for (sigma, variation) in sigmas.iter_mut().skip(FIELD).zip(of_waves(geometry.variations(parameters))) {
        *sigma = libm::sqrtf(variation.variance_km2);
    }
    for sigma in sigmas.iter_mut().skip(MISALIGNMENT) {
        *sigma = square(parameters.misalignment_sigma_rad).max(0.0) as f32;
        *sigma = libm::sqrtf(*sigma);
    }
    (means, sigmas)
}

const _: () =
    assert!(EDGE == HEIGHT + 1 && SUMMER == EDGE + 1 && TROPICS == SUMMER + 1 && FIELD == TROPICS + 1);

#[cfg(test)]
mod tests;
