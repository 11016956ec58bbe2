//! Sines and cosines of sums of multiples of a few angles, without a sine for each.
//!
//! `exp(i k a)` of every multiple k from one sine and cosine by repeated products; the sum of angles is the
//! product of these. Error: below 1e-15 a term.

/// Real and imaginary part, cosine and sine.
pub(super) type Phase = (f64, f64);

fn times(a: Phase, b: Phase) -> Phase {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

/// `exp(i k a)` for k = 0 to N - 1.
pub(super) fn multiples<const N: usize>(angle_rad: f64) -> [Phase; N] {
    let (sine, cosine) = libm::sincos(angle_rad);
    let mut phases = [(1.0, 0.0); N];
    for k in 1..N {
        phases[k] = times(phases[k - 1], (cosine, sine));
    }
    phases
}

/// The phase of `Σ k a` over the angles, for multiples `k` below N in size.
pub(super) fn phase<const A: usize, const N: usize>(angles: &[[Phase; N]; A], k: &[i8; A]) -> Phase {
    let mut sum = (1.0, 0.0);
    for (phases, &k) in angles.iter().zip(k) {
        if k != 0 {
            let (cosine, sine) = phases[usize::from(k.unsigned_abs())];
            sum = times(sum, (cosine, if k < 0 { -sine } else { sine }));
        }
    }
    sum
}
