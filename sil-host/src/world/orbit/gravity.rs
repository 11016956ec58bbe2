//! The field of gravity of a body.
//!
//! In: position in axes that turn with it (ITRF), km. Out: acceleration there, km/s², and the potential,
//! km²/s². Spherical harmonics, fully normalised, by Cunningham's recursion (1970) as Montenbruck and Gill
//! give it (Satellite Orbits, 3.2.4), each step scaled by the norms so that no degree over- or underflows.
//! Models: of the Earth EGM2008 (`egm2008.txt`), to degree and order [`LARGEST`]; of Moon and Mars LP165P and
//! Mars50c (`lp165p.txt`, `mars50c.txt`), to [`LARGEST_OF_OTHERS`]. EGM2008's coefficients are free of tides;
//! the part of C20 that Sun and Moon raise for ever is added (IERS Conventions 2010, eq. 6.14). Tides that
//! come and go are left out.

use crate::world::attitude::{Vector, dot};
use fsw_core::orbit::body::CentralBody;
use std::sync::LazyLock;

/// The Earth's attraction, km³/s² (EGM2008).
pub const MU_EARTH: f64 = 398_600.441_5;
/// Radius of the model, km.
const RADIUS_KM: f64 = 6_378.136_3;
/// Highest degree and order in the table of the Earth.
pub const LARGEST: usize = 36;
/// Highest degree and order in the tables of the others.
pub const LARGEST_OF_OTHERS: usize = 12;
/// What the lasting tide adds to C20: 4.4228e-8 * -0.31460 * 0.30190.
const LASTING_TIDE_C20: f64 = -4.2006e-9;

static EGM2008: LazyLock<Vec<Coefficient>> = LazyLock::new(|| {
    let mut table = read(include_str!("egm2008.txt"));
    table[0].c += LASTING_TIDE_C20;
    table
});

static LP165P: LazyLock<Vec<Coefficient>> = LazyLock::new(|| read(include_str!("lp165p.txt")));
static MARS50C: LazyLock<Vec<Coefficient>> = LazyLock::new(|| read(include_str!("mars50c.txt")));

/// The attraction of a body, km³/s².
pub fn mu_km3_s2(body: CentralBody) -> f64 {
    match body {
        CentralBody::Earth => MU_EARTH,
        _ => body.facts().mu_km3_s2,
    }
}

/// Highest degree and order of the field of a body.
pub fn largest(body: CentralBody) -> usize {
    match body {
        CentralBody::Earth => LARGEST,
        _ => LARGEST_OF_OTHERS,
    }
}

/// One degree and order.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Coefficient {
    n: usize,
    m: usize,
    c: f64,
    s: f64,
}

/// Lines of degree, order, C, S; `#` begins a remark.
fn read(text: &str) -> Vec<Coefficient> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let rows = lines.filter_map(|line| {
        let mut fields = line.split_whitespace();
        let n = fields.next()?.parse().ok()?;
        let m = fields.next()?.parse().ok()?;
        Some(Coefficient { n, m, c: fields.next()?.parse().ok()?, s: fields.next()?.parse().ok()? })
    });
    rows.collect()
}

/// A coefficient with the factors of its share of the acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Term {
    coefficient: Coefficient,
    /// To order m + 1, m - 1 and m of the next degree.
    up: f64,
    down: f64,
    level: f64,
}

/// A field to some degree and order.
#[derive(Debug, Clone, PartialEq)]
pub struct Gravity {
    mu: f64,
    radius_km: f64,
    degree: usize,
    order: usize,
    terms: Vec<Term>,
    /// Factors of the recursion: at `index(n, m)` those of the last degree and of the one before.
    steps: Vec<(f64, f64)>,
}

fn index(n: usize, m: usize) -> usize {
    n * (n + 1) / 2 + m
}

impl Gravity {
    /// EGM2008 to `degree` and `order`, at most [`LARGEST`]; order no larger than degree.
    pub fn egm2008(degree: usize, order: usize) -> Self {
        Self::of((MU_EARTH, RADIUS_KM), &EGM2008, degree.min(LARGEST), order)
    }

    /// The field of a body to `degree` and `order`, at most [`largest`].
    pub fn about(body: CentralBody, degree: usize, order: usize) -> Self {
        let table = match body {
            CentralBody::Earth => return Self::egm2008(degree, order),
            CentralBody::Moon => &LP165P,
            CentralBody::Mars => &MARS50C,
        };
        Self::of((mu_km3_s2(body), body.facts().field_radius_km), table, degree.min(LARGEST_OF_OTHERS), order)
    }

    /// Another model: lines of degree, order, C, S, normalised, for the same radius.
    #[cfg(test)]
    pub fn of_table(mu: f64, table: &str, degree: usize) -> Self {
        Self::of((mu, RADIUS_KM), &read(table), degree, degree)
    }

    fn of((mu, radius_km): (f64, f64), table: &[Coefficient], degree: usize, order: usize) -> Self {
        let kept = table.iter().filter(|row| row.n <= degree && row.m <= order);
        let terms = kept.map(|row| {
            let (n, m) = (row.n as f64, row.m as f64);
            let share = (2.0 * n + 1.0) / (2.0 * n + 3.0);
            // The norm of order 0 lacks the factor 2 of the others.
            let half = if row.m == 0 { 0.5 } else { 1.0 };
            let double = if row.m == 1 { 2.0 } else { 1.0 };
            Term {
                coefficient: *row,
                up: (half * share * (n + m + 1.0) * (n + m + 2.0)).sqrt(),
                down: (double * share * (n - m + 1.0) * (n - m + 2.0)).sqrt(),
                level: (share * (n + m + 1.0) * (n - m + 1.0)).sqrt(),
            }
        });
        let terms = terms.collect();
        let mut steps = vec![(0.0, 0.0); index(degree + 2, 0)];
        for whole_n in 1..=degree + 1 {
            for whole_m in 0..=whole_n {
                let (n, m) = (whole_n as f64, whole_m as f64);
                steps[index(whole_n, whole_m)] = if whole_m == whole_n {
                    let sectorial = if whole_n == 1 { 3.0 } else { (2.0 * n + 1.0) / (2.0 * n) };
                    (sectorial.sqrt(), 0.0)
                } else {
                    let across = (n - m) * (n + m);
                    let last = ((2.0 * n + 1.0) * (2.0 * n - 1.0) / across).sqrt();
                    let before = (2.0 * n + 1.0) * (n + m - 1.0) * (n - m - 1.0) / (across * (2.0 * n - 3.0));
                    (last, before.max(0.0).sqrt())
                };
            }
        }
        Self { mu, radius_km, degree, order, terms, steps }
    }

    /// The solid harmonics V and W to one degree beyond the field's.
    fn harmonics(&self, r: Vector) -> [[(f64, f64); LARGEST + 2]; LARGEST + 2] {
        let mut v = [[(0.0, 0.0); LARGEST + 2]; LARGEST + 2];
        let (radius_km, square) = (self.radius_km, dot(r, r));
        let [x, y, z] = r.map(|part| part * radius_km / square);
        let shrink = radius_km * radius_km / square;
        v[0][0] = (radius_km / square.sqrt(), 0.0);
        for m in 0..=self.order + 1 {
            if m > 0 {
                let (a, b) = v[m - 1][m - 1];
                let step = self.steps[index(m, m)].0;
                v[m][m] = (step * (x * a - y * b), step * (x * b + y * a));
            }
            for n in m + 1..=self.degree + 1 {
                let (last, before) = self.steps[index(n, m)];
                let (a, b) = v[n - 1][m];
                let (c, d) = if n > m + 1 { v[n - 2][m] } else { (0.0, 0.0) };
                v[n][m] = (last * z * a - before * shrink * c, last * z * b - before * shrink * d);
            }
        }
        v
    }

    /// Acceleration at `r`, km/s², in ITRF as `r` (km).
    pub fn acceleration(&self, r: Vector) -> Vector {
        let square = dot(r, r);
        let central = self.mu / (square * square.sqrt());
        if self.terms.is_empty() {
            return r.map(|part| -central * part);
        }
        let v = self.harmonics(r);
        let mut sum = [0.0; 3];
        for Term { coefficient: Coefficient { n, m, c, s }, up, down, level } in self.terms.iter().rev() {
            let (a, b) = v[n + 1][m + 1];
            if *m == 0 {
                sum[0] -= up * c * a;
                sum[1] -= up * c * b;
            } else {
                let (d, e) = v[n + 1][m - 1];
                sum[0] += 0.5 * (down * (c * d + s * e) - up * (c * a + s * b));
                sum[1] += 0.5 * (down * (s * d - c * e) + up * (s * a - c * b));
            }
            let (f, g) = v[n + 1][*m];
            sum[2] -= level * (c * f + s * g);
        }
        let scale = self.mu / (self.radius_km * self.radius_km);
        [0, 1, 2].map(|k| scale * sum[k] - central * r[k])
    }

    /// Potential at `r`, positive, km²/s².
    #[cfg(test)]
    pub fn potential(&self, r: Vector) -> f64 {
        let v = self.harmonics(r);
        let rest: f64 = self
            .terms
            .iter()
            .rev()
            .map(|term| {
                let Coefficient { n, m, c, s } = term.coefficient;
                c * v[n][m].0 + s * v[n][m].1
            })
            .sum();
        self.mu / self.radius_km * (v[0][0].0 + rest)
    }
}

#[cfg(test)]
mod tests;
