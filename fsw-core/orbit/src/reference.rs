//! Truth for the orbit's tests, written apart from the flight code: the Earth's field to degree and order
//! 36 by Cunningham's recursion in the turning Earth, small steps, and the files of reference orbits.

use super::OrbitState;
use super::body::{CentralBody, EARTH, MOON};
use super::constants::MU_SUN_KM3_S2;
use super::ephemeris::Bodies;
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::path::PathBuf;
use std::string::String;
use std::sync::LazyLock;
use std::vec;
use std::vec::Vec;

/// TT, microseconds since J2000.0, of days since then on another scale that TT is `ahead_s` of.
pub fn time_us(days: f64, ahead_s: f64) -> i64 {
    ((days * 86_400.0 + ahead_s) * 1e6).round() as i64
}

/// A file of reference orbits; says so when there is none.
pub fn orbit_file(name: &str) -> Option<String> {
    let root = std::env::var_os("SEXTANT_DATA")
        .map(PathBuf::from)
        .unwrap_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"));
    let text = std::fs::read_to_string(root.join("orbits").join(name)).ok();
    if text.is_none() {
        std::println!("skipped: no data ({name})");
    }
    text
}

/// The numbers behind `"samples"` of a JSON file, seven a row: elapsed s, position km, velocity km/s.
pub fn samples(text: &str) -> Vec<[f64; 7]> {
    let rows = text.rsplit_once("\"samples\"").unwrap().1;
    let numbers: Vec<f64> =
        rows.split(['[', ']', ',', ':', '}', '{']).filter_map(|x| x.trim().parse().ok()).collect();
    numbers.chunks_exact(7).map(|row| row.try_into().unwrap()).collect()
}

/// Earth rotation angle of UT1 days since J2000.0 (IAU 2000).
pub fn earth_rotation(ut1_days: f64) -> f64 {
    std::f64::consts::TAU * (0.779_057_273_264 + 1.002_737_811_911_354_5 * ut1_days).rem_euclid(1.0)
}

/// From the Earth-fixed frame to ICRS: pole without nutation, no polar motion.
pub fn earth_fixed_to_icrs(time: i64, ut1_days: f64) -> Matrix3<f64> {
    let pole = Bodies::at(CentralBody::Earth, time).pole;
    let tilt = Rotation3::rotation_between(&Vector3::z(), &pole).unwrap();
    (tilt * Rotation3::from_axis_angle(&Vector3::z_axis(), earth_rotation(ut1_days))).into_inner()
}

/// EGM2008, normalised, as the world of the host has it: degree, order, C, S. To C of degree 2 and order 0
/// what Sun and Moon raise for ever is added (IERS Conventions 2010, eq. 6.14).
static FIELD: LazyLock<Vec<(usize, usize, f64, f64)>> = LazyLock::new(|| {
    let lines = include_str!("../../../sil-host/src/world/orbit/egm2008.txt").lines();
    let row = |line: &str| {
        let numbers: Vec<f64> = line.split_whitespace().map(|x| x.parse().unwrap()).collect();
        (numbers[0] as usize, numbers[1] as usize, numbers[2], numbers[3])
    };
    let mut rows: Vec<_> = lines.filter(|line| !line.starts_with('#')).map(row).collect();
    rows[0].2 -= 4.2006e-9;
    rows
});

/// Acceleration by the field up to `degree`, Earth-fixed (Montenbruck and Gill §3.2.4: Cunningham's V and W).
pub fn field_acceleration(r: &Vector3<f64>, degree: usize) -> Vector3<f64> {
    let size = degree + 2;
    let a = 6_378.136_3;
    let square = r.dot(r);
    let (x, y, z) = (a * r.x / square, a * r.y / square, a * r.z / square);
    let rho = a * a / square;
    let (mut v, mut w) = (vec![vec![0.0; size]; size], vec![vec![0.0; size]; size]);
    v[0][0] = a / square.sqrt();
    for m in 0..size {
        if m > 0 {
            let odd = (2 * m - 1) as f64;
            v[m][m] = odd * (x * v[m - 1][m - 1] - y * w[m - 1][m - 1]);
            w[m][m] = odd * (x * w[m - 1][m - 1] + y * v[m - 1][m - 1]);
        }
        for n in m + 1..size {
            let (one, two) = ((2 * n - 1) as f64 / (n - m) as f64, (n + m - 1) as f64 / (n - m) as f64);
            let back = if n >= m + 2 { (v[n - 2][m], w[n - 2][m]) } else { (0.0, 0.0) };
            v[n][m] = one * z * v[n - 1][m] - two * rho * back.0;
            w[n][m] = one * z * w[n - 1][m] - two * rho * back.1;
        }
    }
    let factorial = |n: usize| (1..=n).map(|x| x as f64).product::<f64>();
    let mut sum = Vector3::zeros();
    for (n, m, c, s) in
        [(0, 0, 1.0, 0.0)].into_iter().chain(FIELD.iter().copied()).filter(|term| term.0 <= degree)
    {
        let norm = ((2 * n + 1) as f64 * if m == 0 { 1.0 } else { 2.0 } * factorial(n - m)
            / factorial(n + m))
        .sqrt();
        let (c, s) = (c * norm, s * norm);
        let lower = (n - m + 1) as f64;
        if m == 0 {
            sum += Vector3::new(-c * v[n + 1][1], -c * w[n + 1][1], -lower * c * v[n + 1][0]);
        } else {
            let up = Vector3::new(
                -c * v[n + 1][m + 1] - s * w[n + 1][m + 1],
                -c * w[n + 1][m + 1] + s * v[n + 1][m + 1],
                0.0,
            ) * 0.5;
            let down = Vector3::new(
                c * v[n + 1][m - 1] + s * w[n + 1][m - 1],
                -c * w[n + 1][m - 1] + s * v[n + 1][m - 1],
                0.0,
            ) * (0.5 * lower * (lower + 1.0));
            let level = Vector3::new(0.0, 0.0, -lower * (c * v[n + 1][m] + s * w[n + 1][m]));
            sum += up + down + level;
        }
    }
    sum * (EARTH.mu_km3_s2 / (a * a))
}

/// The state `span_s` later under the field up to `degree`, Sun and Moon, in steps of at most `step_s`.
pub fn propagate(state: &OrbitState, span_s: f64, step_s: f64, degree: usize) -> OrbitState {
    let bodies = Bodies::at(CentralBody::Earth, state.time_us);
    let steps = (span_s / step_s).ceil().max(1.0);
    let h = span_s / steps;
    let (mut r, mut v) = (state.position_km, state.velocity_km_s);
    // TT less UT1 of 2023 and 2024.
    let mut days = (state.time_us as f64 / 1e6 - 69.2) / 86_400.0;
    let pull = |body: &Vector3<f64>, mu: f64, r: &Vector3<f64>| {
        mu * ((body - r) / (body - r).norm().powi(3) - body / body.norm().powi(3))
    };
    let to_icrs = earth_fixed_to_icrs(state.time_us, 0.0);
    let tilt = to_icrs * Rotation3::from_axis_angle(&Vector3::z_axis(), -earth_rotation(0.0)).into_inner();
    let slope = |days: f64, r: &Vector3<f64>| {
        let turn = tilt * Rotation3::from_axis_angle(&Vector3::z_axis(), earth_rotation(days)).into_inner();
        turn * field_acceleration(&(turn.transpose() * r), degree)
            + pull(&bodies.sun_km, MU_SUN_KM3_S2, r)
            + pull(&bodies.neighbour_km, MOON.mu_km3_s2, r)
    };
    for _ in 0..steps as usize {
        let middle = days + 0.5 * h / 86_400.0;
        let (r1, v1) = (v, slope(days, &r));
        let (r2, v2) = (v + v1 * (h / 2.0), slope(middle, &(r + r1 * (h / 2.0))));
        let (r3, v3) = (v + v2 * (h / 2.0), slope(middle, &(r + r2 * (h / 2.0))));
        let (r4, v4) = (v + v3 * h, slope(days + h / 86_400.0, &(r + r3 * h)));
        r += (r1 + (r2 + r3) * 2.0 + r4) * (h / 6.0);
        v += (v1 + (v2 + v3) * 2.0 + v4) * (h / 6.0);
        days += h / 86_400.0;
    }
    OrbitState { time_us: state.time_us + (span_s * 1e6).round() as i64, position_km: r, velocity_km_s: v }
}

/// Circular orbit of this radius and inclination, at the ascending node, at a time in 2024.
pub fn circular(radius_km: f64, inclination_deg: f64) -> OrbitState {
    let speed = (EARTH.mu_km3_s2 / radius_km).sqrt();
    let (sine, cosine) = inclination_deg.to_radians().sin_cos();
    OrbitState {
        time_us: 760_000_000_000_000,
        position_km: Vector3::new(radius_km, 0.0, 0.0),
        velocity_km_s: Vector3::new(0.0, cosine, sine) * speed,
    }
}

/// Seconds of one revolution.
pub fn period_s(radius_km: f64) -> f64 {
    std::f64::consts::TAU * (radius_km.powi(3) / EARTH.mu_km3_s2).sqrt()
}

/// Every position and velocity of the Jason-2 file, in ICRS.
pub fn jason2() -> Option<Vec<OrbitState>> {
    let text = orbit_file("jason2.sp3")?;
    let row = |line: &str| -> Vector3<f64> {
        let numbers: Vec<f64> = line[4..].split_whitespace().take(3).map(|x| x.parse().unwrap()).collect();
        Vector3::new(numbers[0], numbers[1], numbers[2])
    };
    let positions = text.lines().filter(|line| line.starts_with("PL27")).map(row);
    let velocities = text.lines().filter(|line| line.starts_with("VL27")).map(row);
    let states = positions.zip(velocities).enumerate().map(|(minute, (r, v))| {
        // 2008-08-30 21:00 TAI; TAI - UTC = 33 s, UT1 - UTC = -0.4643 s (IERS C04).
        let tai_days = 3_164.375 + minute as f64 / 1440.0;
        let time = time_us(tai_days, 32.184);
        let turn = earth_fixed_to_icrs(time, tai_days + (-33.0 - 0.4643) / 86_400.0);
        let spin = Vector3::new(0.0, 0.0, 7.292_115e-5);
        OrbitState { time_us: time, position_km: turn * r, velocity_km_s: turn * (v * 1e-3 + spin.cross(&r)) }
    });
    Some(states.collect())
}
