//! The attitude filter: attitude and rate from successive images, and their prediction.
//!
//! In: attitudes with sigma and instant, or single stars where there are too few for an attitude; readings
//! of a rate sensor, if any. Out: attitude, rate and their sigmas at that instant or a later one. Star
//! path's frame, rad, rad/s.
//!
//! A multiplicative Kalman filter (Lefferts, Markley and Shuster 1982): the attitude is `exp(-[δ×]) A`; the
//! estimated error `δ` is applied to `A` after every update. The rate is `ω = reading + x₁`: without a rate
//! sensor the reading is 0 and `x₁` the rate, with one `-x₁` is its bias. The states are attitude and rate of
//! the thesis (eq. 3.19). Its angular acceleration as a third one (eq. 3.20) was tried: the rate's error, rms
//! of 50 flights, became 0.8 instead of 2.7 arcsec/s at 1 arcsec/s², and 0.71 instead of 0.41 at rest.
//!
//! Over `t` the sensor turns by `φ = ω t`, and `δ' = R δ + t J x₁` with `R = exp(-[φ×])` and `J` its mean over
//! the turn: exact for any rate. White noise drives `x₁`. Its density adapts to
//! the innovations: x2 per update while their mean square exceeds 1.5, x0.9 while it is below 1.2. So one
//! tuning covers rest, 10 deg/s, slews and wheel jitter, which a fixed one does not (thesis §3.1.4.2). An
//! innovation of NIS >= 40 is treated as a manoeuvre: the filter is reinitialised from the last two
//! attitudes. Attitudes are not gated here, because the identification of their stars has verified them.
//!
//! Errors of the same stars on the same pixels are correlated over tens of seconds. `CORRELATED_SHARE` of
//! an attitude's variance is not averaged down but added to the reported sigmas.

mod blocks;
mod update;

use crate::frames::{Icrs, Rotation, StarPath};
use crate::trigonometry::hypotenuse;
use crate::word_sum;
use blocks::{BlockCovariance, RotationStep, product};
use fsw_ground::table::parameter_group;
use fsw_hal::LocalTime;
use nalgebra::{Matrix3, Vector3};

/// Longest time between two attitudes that give a rate, s: the rotation between them must be below half a
/// turn.
pub const MAX_RATE_BASE_S: f32 = 10.0;
/// Shortest time between them, s: below, their noise dominates the rate.
const MIN_RATE_BASE_S: f32 = 0.05;
/// Longest time over which the state is propagated in one step, s: an hour.
const MAX_STEP_S: f32 = 3600.0;
/// Largest angle over which an attitude is propagated in one step, rad.
const MAX_ANGLE_RAD: f32 = 1.5;
/// Share of an attitude's variance that is correlated with the previous image: 0.13 to 0.4 in the flights
/// of all scenarios (autocorrelation of `cycles.csv`).
const CORRELATED_SHARE: f32 = 0.35;
/// Time constant of the mean square of the innovations, images.
const CONSISTENCY_IMAGES: f32 = 16.0;
/// Mean NIS per degree of freedom above (below) which the process noise is scaled, and the factor per
/// update: it grows within seconds after a manoeuvre and decays in a minute or two.
const NOISE_GROWTH: (f32, f32) = (1.5, 2.0);
const NOISE_DECAY: (f32, f32) = (1.2, 0.9);
/// Normalised innovation squared from which the filter is reinitialised: probability 1e-8 with 3 degrees of
/// freedom.
pub const RESTART_NIS: f32 = 40.0;
/// Time after the last contradiction for which a filter is not steady, s: a slew that begins or ends changes
/// the rate for seconds, and where images end with it its attitude cannot be carried on. Chosen.
const UNSTEADY_S: f32 = 10.0;
/// What turns faster tumbles or slews and does not keep its rate, rad/s: a quarter of a degree a second, four
/// times what the lowest orbit asks for.
const TUMBLING_RAD_S: f32 = 4.4e-3;
/// Initial process noise: sigma of the rate's change in a second, 1 arcsec/s.
const FIRST_PROCESS_NOISE_RAD: f32 = 4.8e-6;
/// Variances are kept in mrad², so that f32 has digits and range to spare.
const MRAD: f32 = 1e3;

/// Estimated rate.
#[derive(Clone, Copy, Debug)]
pub struct Rate {
    /// Of the star path against the stars, in its own frame, rad/s.
    pub rad_s: Vector3<f32>,
    /// Standard deviations, rad/s.
    pub sigma_rad_s: Vector3<f32>,
}

parameter_group! {
    /// The errors of a rate sensor, an axis; there is none unless it is set.
    pub struct RateSensorNoise in "rate_sensor" {
        /// Standard deviation of the angle it loses in a second; at most a third of the gate.
        white_rad: f32 = 1e-5, 1e-8..=0.1, "rad", "fibre-optic gyro: 2 arcsec in a second";
        /// Standard deviation of the change of its bias in a second.
        walk_rad_s: f32 = 1e-7, 0.0..=1e-3, "rad/s", "fibre-optic gyro: 0.02 arcsec/s in a second";
        /// Standard deviation of its bias at first.
        bias_rad_s: f32 = 1e-4, 1e-8..=0.1, "rad/s", "fibre-optic gyro: 20 deg/h";
    }
}

/// State and covariance of the filter.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    attitude: Rotation<Icrs, StarPath>,
    /// Instant of the state.
    instant: LocalTime,
    /// Instant of the last attitude observed.
    updated_at: LocalTime,
    /// Instant of the last attitude or rate observed.
    rate_seen_at: LocalTime,
    /// Instant of the last image that contradicted the prediction.
    contradicted_at: Option<LocalTime>,
    /// The state after the attitude: the rate, or the negative bias of the rate sensor, rad/s.
    driven: Vector3<f32>,
    /// Of attitude and `driven`, mrad and s.
    covariance: BlockCovariance,
    /// Variance of the last attitude observed, mrad².
    variance: Vector3<f32>,
    /// Whether `driven` is initialised.
    has_rate: bool,
    /// Reading of the rate sensor, rad/s; 0 without one.
    reading: Vector3<f32>,
    sensor: Option<RateSensorNoise>,
    /// Spectral density of the noise that drives it, mrad² / s³.
    process_noise_psd: f32,
    /// Mean square of the normalised innovations, a degree of freedom.
    mean_nis: f32,
}

/// Numbers of attitude and rate, or negative bias, among the blocks of the covariance.
const ATTITUDE: usize = 0;
const RATE: usize = 1;

impl Filter {
    /// From a first attitude, with unknown rate.
    pub fn new(attitude: Rotation<Icrs, StarPath>, sigma_rad: [f32; 3], instant: LocalTime) -> Self {
        let mut filter = Self {
            attitude,
            instant,
            updated_at: instant,
            rate_seen_at: instant,
            contradicted_at: None,
            driven: Vector3::zeros(),
            covariance: BlockCovariance::default(),
            variance: squares(&Vector3::from(sigma_rad)),
            has_rate: false,
            reading: Vector3::zeros(),
            sensor: None,
            process_noise_psd: square(FIRST_PROCESS_NOISE_RAD),
            mean_nis: 1.0,
        };
        filter.covariance.set_block(ATTITUDE, ATTITUDE, Matrix3::from_diagonal(&filter.variance));
        filter
    }

    /// The same with a rate that is known from elsewhere; the first process noise is the greatest.
    pub fn with_rate(mut self, rate: &Rate) -> Self {
        self.driven += rate.rad_s;
        self.covariance.set_block(RATE, RATE, Matrix3::from_diagonal(&squares(&rate.sigma_rad_s)));
        self.has_rate = true;
        self.expect_change();
        self
    }

    /// The same with a rate sensor, whose readings come with every [`Filter::propagate`].
    pub fn with_rate_sensor(mut self, noise: RateSensorNoise) -> Self {
        (self.sensor, self.has_rate) = (Some(noise), true);
        self.driven = Vector3::zeros();
        self.covariance.set_block(ATTITUDE, RATE, Matrix3::zeros());
        self.covariance.set_block(RATE, RATE, Matrix3::from_diagonal_element(square(noise.bias_rad_s)));
        self.process_noise_psd = square(noise.walk_rad_s);
        self
    }

    /// Propagates the state to `instant` with the rate sensor's reading of the time before it, rad/s.
    /// Without a reading (`None`) its last one becomes the rate estimate, and the filter continues without
    /// rate sensor.
    pub fn propagate_gyro(
        &mut self,
        instant: LocalTime,
        noise: RateSensorNoise,
        reading_rad_s: Option<Vector3<f32>>,
    ) {
        match (reading_rad_s, self.sensor) {
            (Some(_), None) => *self = self.with_rate_sensor(noise),
            (None, Some(noise)) => {
                self.driven += core::mem::take(&mut self.reading);
                let white = Matrix3::from_diagonal_element(square(noise.white_rad));
                self.covariance.set_block(RATE, RATE, self.covariance.at(RATE, RATE) + white);
                (self.sensor, self.process_noise_psd) = (None, square(FIRST_PROCESS_NOISE_RAD));
            }
            _ => {}
        }
        if reading_rad_s.is_some() {
            self.propagate(instant, reading_rad_s);
        }
    }

    /// Least and greatest density of the noise that drives the rate: 0.007 arcsec/s in a second, which covers
    /// the changing rate of nadir pointing in a low orbit of e = 0.001 over ten minutes without stars, and 40
    /// arcsec/s, more of a body that tumbles ([`free_body_change`]).
    fn process_noise_limits(&self) -> (f32, f32) {
        const LEAST_RAD: f32 = 3.4e-8;
        const GREATEST_RAD: f32 = 2e-4;
        let greatest_rad = GREATEST_RAD.max(free_body_change(&(self.reading + self.driven)));
        (square(LEAST_RAD), square(greatest_rad))
    }

    /// Sum of the words of attitude, rate and covariance. Another at the begin of a second than at the end of
    /// the last tells of an upset.
    pub fn word_sum(&self) -> u32 {
        let Self { attitude, instant, updated_at, rate_seen_at, driven, .. } = self;
        let Self { covariance, variance, reading, .. } = self;
        let scales = [self.process_noise_psd, self.mean_nis];
        let vectors = [driven, variance, reading].into_iter().map(|vector| vector.as_slice());
        let matrices = covariance.0.as_flattened().iter().chain([attitude.matrix()]);
        let singles = vectors.chain(matrices.map(|matrix| matrix.as_slice())).chain([&scales[..]]);
        let instants = [*instant, *updated_at, *rate_seen_at].into_iter().chain(self.contradicted_at);
        let longs = instants.map(|instant| word_sum::of_long(instant.as_us() as u64));
        let flags = 1 + u32::from(self.has_rate) + 2 * u32::from(self.sensor.is_some());
        singles.map(word_sum::of_singles).chain(longs).fold(flags, u32::wrapping_add)
    }

    /// Microseconds from the last measurement update to `instant`.
    pub fn age_us(&self, instant: LocalTime) -> i64 {
        instant.us_since(self.updated_at)
    }

    /// Notes that the image of an instant shows no star where the prediction has them.
    pub fn contradict(&mut self, instant: LocalTime) {
        self.contradicted_at = Some(instant);
    }

    /// Notes that the turn changes within the image that comes next: the process noise is the greatest until
    /// innovations say otherwise. Nothing with a rate sensor, which measures the turn.
    pub fn expect_change(&mut self) {
        if self.sensor.is_none() {
            (_, self.process_noise_psd) = self.process_noise_limits();
        }
    }

    /// Whether a rate sensor measures how it turns.
    pub fn has_rate_sensor(&self) -> bool {
        self.sensor.is_some()
    }

    /// Whether the turning can be carried on without images: a rate sensor measures it, or no image
    /// contradicted the prediction since some seconds before the last attitude.
    pub fn is_steady(&self) -> bool {
        let steady_s = |contradicted| seconds(self.updated_at.us_since(contradicted));
        self.sensor.is_some() || self.contradicted_at.is_none_or(|at| steady_s(at) >= UNSTEADY_S)
    }

    /// The rate, after two attitudes at most [`MAX_RATE_BASE_S`] apart, or with a rate sensor.
    pub fn rate(&self) -> Option<Rate> {
        let noise = self.sensor.map_or(0.0, |sensor| square(sensor.white_rad));
        let variance = self.covariance.at(RATE, RATE).diagonal().map(|variance| variance + noise);
        self.has_rate.then(|| Rate { rad_s: self.reading + self.driven, sigma_rad_s: self.sigma(&variance) })
    }

    /// Attitude and standard deviations, rad, at a later instant; `None` without a rate, for an earlier
    /// instant, beyond `MAX_STEP_S` and `MAX_ANGLE_RAD`.
    #[inline(never)]
    pub fn at(&self, instant: LocalTime) -> Option<(Rotation<Icrs, StarPath>, [f32; 3])> {
        let mut then = *self;
        then.propagate(instant, None).then(|| {
            let tumbled = Vector3::repeat(square(then.tumbled_rad(instant)));
            let variance = then.covariance.at(ATTITUDE, ATTITUDE).diagonal()
                + then.variance * CORRELATED_SHARE
                + tumbled;
            (then.attitude, then.sigma(&variance).into())
        })
    }

    /// By how much a body that tumbles has turned otherwise since its rate was last seen, one sigma an axis,
    /// rad: its rate changes in one sense for as long as the process noise, which is white, does not allow
    /// for. 0 with a rate sensor.
    fn tumbled_rad(&self, instant: LocalTime) -> f32 {
        let elapsed_s = seconds(instant.us_since(self.rate_seen_at));
        let tumbles = self.sensor.is_none() && self.driven.norm() > TUMBLING_RAD_S;
        if tumbles { 0.5 * free_body_change(&self.driven) * elapsed_s * elapsed_s } else { 0.0 }
    }

    /// By how many sigma, its own and the filter's together, an attitude of an instant is off what the filter
    /// predicts, about each axis; `None` where it predicts nothing.
    pub fn sigmas_off(
        &self,
        attitude: &Rotation<Icrs, StarPath>,
        sigma_rad: &[f32; 3],
        instant: LocalTime,
    ) -> Option<Vector3<f32>> {
        let (predicted, predicted_sigma_rad) = self.at(instant)?;
        let both = Vector3::from(predicted_sigma_rad).zip_map(&Vector3::from(*sigma_rad), hypotenuse);
        Some(attitude.angle_from(&predicted).component_div(&both))
    }

    /// Whether an attitude of an instant is within three sigma of what the filter predicts, about each axis.
    pub fn expects(
        &self,
        attitude: &Rotation<Icrs, StarPath>,
        sigma_rad: &[f32; 3],
        instant: LocalTime,
    ) -> bool {
        let off = self.sigmas_off(attitude, sigma_rad, instant);
        off.is_some_and(|off| off.iter().all(|sigmas| sigmas.abs() <= 3.0))
    }

    /// Propagates the state to `instant`, with a reading of the rate sensor, rad/s, or else the last one.
    /// `false`, and no change, where [`Filter::at`] gives `None`.
    #[inline(never)]
    pub fn propagate(&mut self, instant: LocalTime, reading_rad_s: Option<Vector3<f32>>) -> bool {
        let elapsed = seconds(instant.us_since(self.instant));
        let reading = reading_rad_s.unwrap_or(self.reading);
        let usable = self.has_rate && (0.0..=MAX_STEP_S).contains(&elapsed);
        let Some(turn) = self.rotation_step(&reading, elapsed).filter(|_| usable) else { return false };
        self.attitude = self.attitude.turned(&turn.angle);
        self.propagate_covariance(&turn, elapsed);
        (self.instant, self.reading) = (instant, reading);
        true
    }

    /// Rotation of the sensor in `elapsed` seconds.
    fn rotation_step(&self, reading: &Vector3<f32>, elapsed: f32) -> Option<RotationStep> {
        let angle = reading * elapsed + self.driven * elapsed;
        // False for NaN.
        let near = angle.dot(&angle) < MAX_ANGLE_RAD * MAX_ANGLE_RAD;
        near.then(|| RotationStep::by(angle))
    }

    /// Propagates the covariance: `Φ P Φᵀ + Q`, block by block, with `Φ = [[R, t J], [0, I]]`.
    fn propagate_covariance(&mut self, turn: &RotationStep, elapsed: f32) {
        // The upper row of Φ times a column of blocks.
        let passed = |upper: &Matrix3<f32>, lower: &Matrix3<f32>| {
            product(&turn.whole, upper) + product(&turn.mean, lower) * elapsed
        };
        let column =
            |column| passed(&self.covariance.at(ATTITUDE, column), &self.covariance.at(RATE, column));
        let [left, across] = [ATTITUDE, RATE].map(column);
        let attitude = passed(&left.transpose(), &across.transpose()).transpose();
        let noise = self.process_noise_psd * elapsed;
        let rate = self.covariance.at(RATE, RATE);
        for (row, column, propagated, noise) in [
            (ATTITUDE, ATTITUDE, attitude, self.process_noise_psd * elapsed * elapsed * elapsed / 3.0),
            (ATTITUDE, RATE, across, noise * elapsed / 2.0),
            (RATE, RATE, rate, noise),
        ] {
            self.covariance.set_block(row, column, propagated + Matrix3::from_diagonal_element(noise));
        }
        if let Some(sensor) = self.sensor {
            let lost = Matrix3::from_diagonal_element(square(sensor.white_rad) * elapsed);
            self.covariance.set_block(ATTITUDE, ATTITUDE, self.covariance.at(ATTITUDE, ATTITUDE) + lost);
        }
    }

    /// Standard deviations, rad, of variances, scaled by `mean_nis` where that exceeds 1.
    fn sigma(&self, variance: &Vector3<f32>) -> Vector3<f32> {
        let scale = self.mean_nis.max(1.0);
        variance.map(|variance| libm::sqrtf(variance * scale) * (1.0 / MRAD))
    }
}

/// By how much the rate of a free body changes in a second, one sigma, rad/s: Euler's equations with moments of
/// inertia that differ by a fifth.
pub(crate) fn free_body_change(rate_rad_s: &Vector3<f32>) -> f32 {
    0.2 * rate_rad_s.norm_squared()
}

/// Microseconds as seconds.
pub(crate) fn seconds(us: i64) -> f32 {
    us as f32 / 1e6
}

/// A standard deviation in rad as a variance in mrad².
fn square(sigma_rad: f32) -> f32 {
    (sigma_rad * MRAD) * (sigma_rad * MRAD)
}

fn squares(sigma_rad: &Vector3<f32>) -> Vector3<f32> {
    sigma_rad.map(square)
}

#[cfg(test)]
mod tests;
