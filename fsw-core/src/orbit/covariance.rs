//! The covariance of the orbit filter, in 3 x 3 blocks: position `r`, velocity `v`, limb height `h` (estimated),
//! misalignment `m` and the bias `b` of the fixes (considered).
//!
//! Units km, s, rad. Propagation is `Φ P Φᵀ + Q` with the blocks of [`Transition`] (14 block products instead of the 16 x 3
//! of full matrices); the update is that of Schmidt: with `W = P Hᵀ L⁻ᵀ` and `S = L Lᵀ` every block loses `W Wᵀ`, except
//! those of what is only considered with itself, which no measurement ever betters. Misalignment and bias are independent and
//! stay so. In f64 the loss of digits in the difference is
//! harmless: variances fall by 1e12 at most, and every run of the filter's campaigns ends with a
//! Cholesky factor of all states.

use super::dynamics::Transition;
use super::matrix::{applied, outer, product, products, scaled, symmetric, take_product, turned};
use super::noise::ProcessNoise;
use nalgebra::{Matrix3, Vector3};

/// Covariance of position, velocity, limb height, misalignment and bias.
#[derive(Clone, Copy, Debug)]
pub struct Covariance {
    /// Position, km².
    pub rr: Matrix3<f64>,
    /// Position (rows) with velocity, km²/s.
    pub rv: Matrix3<f64>,
    /// Velocity, km²/s².
    pub vv: Matrix3<f64>,
    /// Position with limb height, km².
    pub rh: Vector3<f64>,
    /// Velocity with limb height, km²/s.
    pub vh: Vector3<f64>,
    /// Limb height, km².
    pub hh: f64,
    /// Position with misalignment, km rad.
    pub rm: Matrix3<f64>,
    /// Velocity with misalignment, km rad/s.
    pub vm: Matrix3<f64>,
    /// Limb height with misalignment, km rad.
    pub hm: Vector3<f64>,
    /// Misalignment about each axis, rad².
    pub mm: f64,
    /// Position with bias, km².
    pub rb: Matrix3<f64>,
    /// Velocity with bias, km²/s.
    pub vb: Matrix3<f64>,
    /// Limb height with bias, km².
    pub hb: Vector3<f64>,
    /// Bias of the fixes, km².
    pub bb: Matrix3<f64>,
}

/// What a measured position depends on: `z = rr δr + rh δh + rm δm + rb δb + noise`.
#[derive(Clone, Copy, Debug)]
pub struct Sensitivity {
    /// To the position; symmetric.
    pub position: Matrix3<f64>,
    /// To the limb height.
    pub limb_height: Vector3<f64>,
    /// To the misalignment, km/rad.
    pub misalignment: Matrix3<f64>,
    /// To the bias; symmetric.
    pub bias: Matrix3<f64>,
}

/// A correction of the estimate, and how surprising the measurement was.
#[derive(Clone, Copy, Debug)]
pub struct Correction {
    /// Of the position, km.
    pub position_km: Vector3<f64>,
    /// Of the velocity, km/s.
    pub velocity_km_s: Vector3<f64>,
    /// Of the limb height, km.
    pub limb_height_km: f64,
    /// Normalised innovation squared, `νᵀ S⁻¹ ν`.
    pub nis: f64,
}

impl Covariance {
    /// After `dt` seconds of this transition.
    pub fn propagated(&self, transition: &Transition, noise: &ProcessNoise, dt: f64) -> Self {
        let Transition { rr: a, rv: b, vr: c, vv: d } = transition;
        let vr = self.rv.transpose();
        // Rows of Φ P, then columns by Φᵀ (all blocks are symmetric).
        let (x_r, x_v) = (products((a, &self.rr), (b, &vr)), products((a, &self.rv), (b, &self.vv)));
        let (y_r, y_v) = (products((c, &self.rr), (d, &vr)), products((c, &self.rv), (d, &self.vv)));
        let white = |value: f64| Matrix3::from_diagonal_element(value);
        let position = |r: &Vector3<f64>, v: &Vector3<f64>| applied(a, r) + applied(b, v);
        let velocity = |r: &Vector3<f64>, v: &Vector3<f64>| applied(c, r) + applied(d, v);
        let (q, kept, height) = (noise.acceleration, noise.bias_kept, noise.height_kept);
        Self {
            rr: symmetric(&products((&x_r, a), (&x_v, b))) + white(q * dt * dt * dt / 3.0),
            rv: products((&x_r, c), (&x_v, d)) + white(q * dt * dt / 2.0),
            vv: symmetric(&products((&y_r, c), (&y_v, d))) + white(q * dt),
            rh: position(&self.rh, &self.vh) * height,
            vh: velocity(&self.rh, &self.vh) * height,
            hh: self.hh * (height * height) + noise.height_renewed,
            rm: products((a, &self.rm), (b, &self.vm)),
            vm: products((c, &self.rm), (d, &self.vm)),
            hm: self.hm * height,
            mm: self.mm,
            rb: scaled(&products((a, &self.rb), (b, &self.vb)), kept),
            vb: scaled(&products((c, &self.rb), (d, &self.vb)), kept),
            hb: self.hb * (height * kept),
            bb: scaled(&self.bb, kept * kept),
        }
    }

    /// Takes the innovation `innovation_km` in, whose noise has the covariance `noise_km2`, and gives what it corrects;
    /// `None`, and nothing is changed, when the innovation's covariance is not positive definite. Not inlined, and in place:
    /// the blocks are 2 KiB of stack.
    #[inline(never)]
    pub fn correct(
        &mut self,
        sensitivity: &Sensitivity,
        noise_km2: &Matrix3<f64>,
        innovation_km: &Vector3<f64>,
    ) -> Option<Correction> {
        let Sensitivity { position: t, limb_height, misalignment, bias: g } = sensitivity;
        let e = misalignment.transpose();
        // P Hᵀ, by rows of P.
        let r = product(&self.rr, t)
            + outer(&self.rh, limb_height)
            + product(&self.rm, &e)
            + product(&self.rb, g);
        let v = product(&self.rv.transpose(), t)
            + outer(&self.vh, limb_height)
            + product(&self.vm, &e)
            + product(&self.vb, g);
        let h = applied(t, &self.rh)
            + limb_height * self.hh
            + applied(misalignment, &self.hm)
            + applied(g, &self.hb);
        let m = product(&self.rm.transpose(), t) + outer(&self.hm, limb_height) + e * self.mm;
        let b = product(&self.rb.transpose(), t) + outer(&self.hb, limb_height) + product(&self.bb, g);
        let s = product(t, &r) + outer(limb_height, &h) + product(misalignment, &m) + product(g, &b);
        let s = symmetric(&(s + noise_km2));
        let factor = Cholesky::of(&s)?;
        // W = P Hᵀ L⁻ᵀ.
        let (wr, wv, wm) = (factor.whiten_rows(&r), factor.whiten_rows(&v), factor.whiten_rows(&m));
        let (wb, wh) = (factor.whiten_rows(&b), factor.whiten(&h));
        let y = factor.whiten(innovation_km);
        let (wvt, wmt, wbt) = (wv.transpose(), wm.transpose(), wb.transpose());
        take_product(&mut self.rr, &wr, &wr.transpose());
        take_product(&mut self.rv, &wr, &wvt);
        take_product(&mut self.vv, &wv, &wvt);
        self.rh -= applied(&wr, &wh);
        self.vh -= applied(&wv, &wh);
        self.hh -= wh.dot(&wh);
        take_product(&mut self.rm, &wr, &wmt);
        take_product(&mut self.vm, &wv, &wmt);
        self.hm -= applied(&wm, &wh);
        take_product(&mut self.rb, &wr, &wbt);
        take_product(&mut self.vb, &wv, &wbt);
        self.hb -= applied(&wb, &wh);
        Some(Correction {
            position_km: applied(&wr, &y),
            velocity_km_s: applied(&wv, &y),
            limb_height_km: wh.dot(&y),
            nis: y.dot(&y),
        })
    }

    /// Multiplies the variances of position and velocity and forgets every correlation of either.
    pub fn loosen(&mut self, factor: f64) {
        self.rr *= factor;
        self.vv *= factor;
        for block in [&mut self.rv, &mut self.rm, &mut self.vm, &mut self.rb, &mut self.vb] {
            *block = Matrix3::zeros();
        }
        self.rh = Vector3::zeros();
        self.vh = Vector3::zeros();
    }

    /// Turns position and velocity.
    #[inline(never)]
    pub fn turn(&mut self, turn: &Matrix3<f64>) {
        for block in [&mut self.rr, &mut self.rv, &mut self.vv] {
            *block = turned(turn, block);
        }
        self.rr = symmetric(&self.rr);
        self.vv = symmetric(&self.vv);
        for block in [&mut self.rm, &mut self.vm, &mut self.rb, &mut self.vb] {
            *block = product(turn, block);
        }
        self.rh = applied(turn, &self.rh);
        self.vh = applied(turn, &self.vh);
    }

    /// Whether all variances are positive and finite.
    pub fn is_sound(&self) -> bool {
        let sound = |variance: f64| variance > 0.0 && variance < 1e30;
        [self.rr, self.vv].iter().all(|m| sound(m.m11) && sound(m.m22) && sound(m.m33))
            && self.hh >= 0.0
            && self.hh < 1e30
    }
}

/// Lower Cholesky factor of a 3 x 3 matrix, its diagonal inverted.
struct Cholesky {
    l21: f64,
    l31: f64,
    l32: f64,
    d1: f64,
    d2: f64,
    d3: f64,
}

impl Cholesky {
    #[inline(never)]
    fn of(m: &Matrix3<f64>) -> Option<Self> {
        /// A pivot smaller than this share of its diagonal element is rounding.
        const LEAST: f64 = 1e-12;
        let pivot =
            |value: f64, scale: f64| (value > LEAST * scale && value < 1e30).then(|| 1.0 / libm::sqrt(value));
        let d1 = pivot(m.m11, m.m11.max(1e-12))?;
        let (l21, l31) = (m.m21 * d1, m.m31 * d1);
        let d2 = pivot(m.m22 - l21 * l21, m.m22)?;
        let l32 = (m.m32 - l31 * l21) * d2;
        let d3 = pivot(m.m33 - l31 * l31 - l32 * l32, m.m33)?;
        Some(Self { l21, l31, l32, d1, d2, d3 })
    }

    /// `L⁻¹ v`.
    #[inline(never)]
    fn whiten(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let x = v.x * self.d1;
        let y = (v.y - self.l21 * x) * self.d2;
        Vector3::new(x, y, (v.z - self.l31 * x - self.l32 * y) * self.d3)
    }

    /// `M L⁻ᵀ`.
    #[inline(never)]
    fn whiten_rows(&self, m: &Matrix3<f64>) -> Matrix3<f64> {
        let row = |x: f64, y: f64, z: f64| self.whiten(&Vector3::new(x, y, z));
        let (first, second, third) =
            (row(m.m11, m.m12, m.m13), row(m.m21, m.m22, m.m23), row(m.m31, m.m32, m.m33));
        Matrix3::new(first.x, first.y, first.z, second.x, second.y, second.z, third.x, third.y, third.z)
    }
}

/// The inverse of a covariance; `None` when it is not positive definite.
pub fn inverse(m: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    // The columns of L⁻ᵀ are those of the identity whitened row by row.
    let factor = Cholesky::of(m)?.whiten_rows(&Matrix3::identity());
    Some(product(&factor, &factor.transpose()))
}

/// The same of single precision; in between it is double.
pub fn inverse_f32(m: &Matrix3<f32>) -> Option<Matrix3<f32>> {
    inverse(&m.map(f64::from)).map(|inverse| inverse.map(|element| element as f32))
}

/// Greatest trace that any covariance here can have: what is made of it stays finite.
const GREATEST_TRACE: f64 = 1e30;

/// Whether a covariance is positive definite. The factors look at one half of it only; in the other no element may be greater
/// than the trace, as none of a covariance is.
pub fn is_covariance(m: &Matrix3<f64>) -> bool {
    let trace = m.trace();
    trace < GREATEST_TRACE && m.iter().all(|x| libm::fabs(*x) <= trace) && Cholesky::of(m).is_some()
}

#[cfg(test)]
mod tests;
