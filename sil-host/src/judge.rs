//! Holds the sensor's attitude against the truth.
//!
//! In: estimated and true quaternions, ICRS to sensor. Out: the error as a rotation vector in sensor axes, rad, and
//! what a run of them comes to. Written apart from the flight code, in f64.

use crate::world::attitude::compose;

/// A minute's limits: share of seconds with an attitude after the first, and of errors within three reported sigmas.
const LEAST_SHARE: f64 = 0.99;

/// Radians in arcseconds.
pub fn arcsec(rad: f64) -> f64 {
    rad.to_degrees() * 3600.0
}

/// Rotation vector, sensor axes, that turns the true attitude into the estimate.
pub fn attitude_error(estimate: [f32; 4], truth: [f64; 4]) -> [f64; 3] {
    let [tx, ty, tz, tw] = truth;
    let [x, y, z, w] = compose(estimate.map(f64::from), [-tx, -ty, -tz, tw]);
    let sign = if w < 0.0 { -2.0 } else { 2.0 };
    [sign * x, sign * y, sign * z]
}

/// Errors of a run, each with its reported sigma.
#[derive(Clone, Debug, Default)]
pub struct Errors {
    first: Option<u32>,
    count: u32,
    within: u32,
    square: [f64; 3],
    sigma_square: [f64; 3],
    bound_square: [f64; 3],
    largest: f64,
}

impl Errors {
    /// Adds a second's error, its reported sigma and the Cramer-Rao bound for the stars used.
    pub fn add(&mut self, second: u32, error_rad: [f64; 3], sigma_rad: [f64; 3], bound_rad: [f64; 3]) {
        self.first.get_or_insert(second);
        self.count += 1;
        for axis in 0..3 {
            self.square[axis] += error_rad[axis] * error_rad[axis];
            self.sigma_square[axis] += sigma_rad[axis] * sigma_rad[axis];
            self.bound_square[axis] += bound_rad[axis] * bound_rad[axis];
        }
        let worst = (0..3).map(|axis| (error_rad[axis] / sigma_rad[axis]).abs()).fold(0.0, f64::max);
        self.within += u32::from(worst <= 3.0);
        self.largest = self.largest.max(worst);
    }

    /// Prints the judgement of a run of `seconds`; whether it kept the limits.
    pub fn print(&self, seconds: u32) -> bool {
        let Some(first) = self.first else {
            println!("No attitude in {seconds} s: failed.");
            return false;
        };
        let share = f64::from(self.count) / f64::from(seconds - first);
        let within = f64::from(self.within) / f64::from(self.count);
        println!("first attitude after {} s, then in {:.1} % of the seconds", first + 1, 100.0 * share);
        let row = |name: &str, sums: [f64; 3]| {
            let [x, y, z] = sums.map(|sum| arcsec((sum / f64::from(self.count)).sqrt()));
            println!("{name:28} x {x:5.2}  y {y:5.2}  z {z:5.1}");
        };
        row("rms error, arcsec", self.square);
        row("reported sigma", self.sigma_square);
        row("Cramer-Rao bound", self.bound_square);
        println!("{:28} x {:5.2}  y {:5.2}  z {:5.1}", "thesis (5 stars, tab. 7.4)", 4.4, 4.4, 28.3);
        println!("within 3 sigma on all axes: {:.1} %, largest {:.1} sigma", 100.0 * within, self.largest);
        let kept = share >= LEAST_SHARE && within >= 0.95;
        println!("{}", if kept { "limits kept" } else { "limits NOT kept" });
        kept
    }
}
