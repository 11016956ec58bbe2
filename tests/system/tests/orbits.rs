//! `navigate` and `propagate`: the filter beside the bound of its measurements, the dynamics beside GMAT.
//!
//! Circles under a point mass, whose places are known exactly; directions with white noise of 0.1 deg, first
//! guesses wrong by 20 km and 20 m/s an axis. Beside the bound the filter is told that no force is unknown.

use serde_json::{Value, json};
use sil_host::world::noise::{Noise, Stream};
use std::f64::consts::TAU;
use std::ops::Range;
use std::path::Path;
use system_tests::{amount, data, json_lines, refused, run, scratch};

/// Earth (EGM96), Moon (LP165P), Mars (MRO110).
const EARTH: Body = Body { name: "earth", mu_km3_s2: 398_600.441_8 };
const MOON: Body = Body { name: "moon", mu_km3_s2: 4_902.801 };
const MARS: Body = Body { name: "mars", mu_km3_s2: 42_828.37 };
/// White noise of a direction, rad: 0.1 deg.
const NOISE_RAD: f64 = TAU / 3600.0;
/// White noise of a distance, km.
const RANGE_KM: f64 = 30.0;

type Vector = [f64; 3];

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn plus(a: Vector, factor: f64, b: Vector) -> Vector {
    [0, 1, 2].map(|axis| a[axis] + factor * b[axis])
}

fn vector(value: &Value) -> Option<Vector> {
    let numbers: Vec<f64> = value.as_array()?.iter().filter_map(Value::as_f64).collect();
    numbers.try_into().ok()
}

/// What is flown about, and its pull.
#[derive(Clone, Copy)]
struct Body {
    name: &'static str,
    mu_km3_s2: f64,
}

/// Measurements from a circle over the equator: after whole orbits x is up, y along, z across.
#[derive(Clone)]
struct Flight {
    about: Body,
    radius_km: f64,
    step_s: f64,
    /// In which nothing is seen.
    outage_s: Range<f64>,
    ranges: bool,
    /// By how much longer the first guess of the radius is, its velocity that of its own circle, the noise of
    /// forces that of flight; none: 20 km and 20 m/s an axis.
    farther_km: Option<f64>,
}

impl Flight {
    fn motion_rad_s(&self) -> f64 {
        (self.about.mu_km3_s2 / self.radius_km.powi(3)).sqrt()
    }

    /// Three orbits.
    fn times(&self) -> impl Iterator<Item = f64> + use<> {
        let steps = (3.0 * TAU / self.motion_rad_s() / self.step_s).round();
        let step_s = 3.0 * TAU / self.motion_rad_s() / steps;
        (1..=steps as u32).map(move |step| f64::from(step) * step_s)
    }

    /// Units up and along.
    fn axes(&self, t_s: f64) -> [Vector; 2] {
        let (sine, cosine) = (self.motion_rad_s() * t_s).sin_cos();
        [[cosine, sine, 0.0], [-sine, cosine, 0.0]]
    }

    fn first(&self, noise: impl Fn(u64, u32) -> f64) -> Value {
        let ([up, along], radius_km) = (self.axes(0.0), self.radius_km);
        let speed_km_s = |radius_km: f64| (self.about.mu_km3_s2 / radius_km).sqrt();
        let guessed_km = radius_km + self.farther_km.unwrap_or(0.0);
        let r = up.map(|axis| axis * guessed_km);
        let v = along.map(|axis| axis * speed_km_s(guessed_km));
        if let Some(farther_km) = self.farther_km {
            let slower_km_s = speed_km_s(radius_km) - speed_km_s(guessed_km);
            return json!({"t_s": 0.0, "r_km": r, "v_km_s": v, "body": self.about.name,
                          "sigma_r_km": farther_km, "sigma_v_km_s": slower_km_s});
        }
        let wrong = |of: u64| [0, 1, 2].map(|axis| noise(of, axis));
        let (r, v) = (plus(r, 20.0, wrong(0)), plus(v, 0.02, wrong(1)));
        json!({"t_s": 0.0, "r_km": r, "v_km_s": v, "body": self.about.name,
               "sigma_r_km": 20.0, "sigma_v_km_s": 0.02, "gravity_noise_km_s15": 0.0,
               "force_noise_km_s15": 0.0})
    }

    /// Writes the measurements of a seed.
    fn write(&self, path: &Path, seed: u64) {
        let noise = |of: u64, axis: u32| Noise::new(seed, of, Stream::Jitter).gaussian(axis, 0);
        let mut text = self.first(noise).to_string();
        for (of, t_s) in (2..).zip(self.times()) {
            let [up, along] = self.axes(t_s);
            let turned =
                plus(plus(up, NOISE_RAD * noise(of, 0), along), NOISE_RAD * noise(of, 1), [0.0, 0.0, 1.0]);
            let u = turned.map(|axis| axis / dot(turned, turned).sqrt());
            let seen = !self.outage_s.contains(&t_s);
            let range_km = self.ranges.then(|| self.radius_km + RANGE_KM * noise(of, 2));
            let line = json!({"t_s": t_s, "u": seen.then_some(u), "range_km": range_km,
                              "sigma_rad": NOISE_RAD, "sigma_range_km": RANGE_KM});
            text += &format!("\n{line}");
        }
        std::fs::write(path, text).unwrap();
    }

    /// What the filter answers.
    fn answers(&self, path: &Path, seed: u64, filter: &str) -> Vec<Value> {
        self.write(path, seed);
        let arguments =
            ["navigate", path.to_str().unwrap(), "--filter", filter, "--dynamics", "kepler", "--json"];
        let output = run(&arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let answers = json_lines(&output);
        assert_eq!(answers.len(), self.times().count());
        answers
    }

    /// Error at the end.
    fn error_km(&self, last: &Value) -> Vector {
        let [up, _] = self.axes(last["t_s"].as_f64().unwrap());
        plus(vector(&last["r_km"]).unwrap(), -self.radius_km, up)
    }
}

const GEO: Flight = Flight {
    about: EARTH,
    radius_km: 42_164.0,
    step_s: 30.0,
    outage_s: 0.0..0.0,
    ranges: false,
    farther_km: None,
};
const SSO: Flight = Flight { radius_km: 7_176.0, step_s: 4.0, ..GEO };
const LEO: Flight = Flight { radius_km: 6_828.0, step_s: 4.0, ..GEO };

/// Flies seeds; asserts that sigmas are at most 1.2 times the bound along each axis and, to 99 %, right.
fn assert_at_the_bound(name: &str, flight: &Flight, filter: &str) {
    let path = scratch(&format!("navigate-{name}")).join("measurements.jsonl");
    // Of a chi-square of 3 x 4 and 3 x 20 degrees the 0.5 and 99.5 % points, over its mean.
    let (seeds, band) = amount((4, 0.256..2.36), (20, 0.592..1.532));
    let (mut squares, mut normalised, mut innovations) = ([0.0; 3], 0.0, Vec::new());
    let (mut bound, mut sigma) = ([0.0; 3], [0.0; 3]);
    for seed in 0..seeds {
        let answers = flight.answers(&path, seed, filter);
        let last = answers.last().unwrap();
        let error = flight.error_km(last);
        [bound, sigma] = ["bound_r_km", "sigma_r_km"].map(|key| vector(&last[key]).unwrap());
        squares = plus(squares, 1.0 / seeds as f64, error.map(|error| error * error));
        normalised += (0..3).map(|axis| (error[axis] / sigma[axis]).powi(2)).sum::<f64>();
        let of = |key| answers.iter().filter_map(move |answer: &Value| answer[key].as_f64());
        innovations.push(of("nis").sum::<f64>() / of("nis_freedom").sum::<f64>());
    }
    normalised /= 3.0 * seeds as f64;
    let metres = |km: Vector| km.map(|km| (1e3 * km).round());
    println!(
        "{name}, {filter}: error {:?}, sigma {:?}, bound {:?} m radial, along, across; \
         (error / sigma)² {normalised:.2}, NIS {:.3}",
        metres(squares.map(f64::sqrt)),
        metres(sigma),
        metres(bound),
        innovations.iter().sum::<f64>() / innovations.len() as f64
    );
    for axis in 0..3 {
        assert!(sigma[axis] > 0.99 * bound[axis], "{name}: nothing is better known than the bound says");
        assert!(sigma[axis] < 1.2 * bound[axis], "{name}: {sigma:?} km of {bound:?}");
    }
    assert!(band.contains(&normalised), "{name}: {normalised}");
    // 8,000 and more degrees of freedom: 1 % is a sigma and more.
    assert!(innovations.iter().all(|nis| (0.95..1.05).contains(nis)), "{name}: {innovations:?}");
}

#[test]
fn the_filter_is_at_the_bound_of_its_measurements() {
    for (name, flight, dark_s) in
        [("GEO", GEO, 75.0 * 60.0), ("SSO", SSO, 35.0 * 60.0), ("LEO", LEO, 35.0 * 60.0)]
    {
        assert_at_the_bound(name, &flight, "unit");
        let begin_s = 1.5 * TAU / flight.motion_rad_s();
        let dark = Flight { outage_s: begin_s..begin_s + dark_s, ..flight.clone() };
        assert_at_the_bound(&format!("{name} with an outage"), &dark, "unit");
        let ranges = Flight { ranges: true, ..flight };
        assert_at_the_bound(&format!("{name} with distances"), &ranges, "position");
    }
}

#[test]
fn about_moon_and_mars_the_filter_is_at_the_bound_too() {
    for (about, radius_km) in [(MOON, 2_437.0), (MARS, 3_896.0)] {
        let flight = Flight { about, radius_km, step_s: 6.0, ranges: true, ..GEO };
        assert_at_the_bound(about.name, &flight, "position");
    }
}

#[test]
fn a_circle_about_moon_or_mars_closes_after_its_period() {
    for (about, radius_km) in [(EARTH, 7_000.0), (MOON, 2_437.0), (MARS, 3_896.0)] {
        let speed_km_s = (about.mu_km3_s2 / radius_km).sqrt();
        let state = json!({"t_s": 0.0, "r_km": [radius_km, 0.0, 0.0], "v_km_s": [0.0, 0.0, speed_km_s],
                           "body": about.name});
        let path = scratch(&format!("propagate-{}", about.name)).join("state.json");
        std::fs::write(&path, state.to_string()).unwrap();
        let period_s = (TAU * radius_km / speed_km_s).to_string();
        let apart_km = |dynamics: &str| {
            let steps = ["--duration-s", &period_s, "--step-s", "1000", "--dynamics", dynamics, "--json"];
            let output = run(&[&["propagate", path.to_str().unwrap()], &steps[..]].concat());
            assert!(output.status.success() && output.stderr.is_empty());
            let last = vector(&json_lines(&output).last().unwrap()["r_km"]).unwrap();
            let error = plus(last, -radius_km, [1.0, 0.0, 0.0]);
            dot(error, error).sqrt()
        };
        let (alone, all) = (apart_km("kepler"), apart_km("full"));
        println!("{}: {alone:.6} km off by its mass alone, {all:.1} km by its field", about.name);
        // The pull to its last digits here and there; the bulge of each delays a polar circle by kilometres.
        assert!(alone < 0.05 && (1.0..100.0).contains(&all), "{}: {alone} {all}", about.name);
    }
}

#[test]
fn a_first_radius_wrong_by_earth_radii_is_mended_or_told() {
    let path = scratch("navigate-wrong").join("measurements.jsonl");
    for (name, flight) in [("GEO", GEO), ("SSO", SSO), ("LEO", LEO)] {
        for radii in [1.0, 2.0, 5.0, 10.0, 20.0, 80.0] {
            let wrong = Flight { farther_km: Some(6378.0 * radii), ..flight.clone() };
            for seed in 0..amount(1, 20) {
                let answers = wrong.answers(&path, seed, "unit");
                let last = answers.last().unwrap();
                let Some(sigma) = vector(&last["sigma_r_km"]) else {
                    println!("{name}, {radii} radii: no orbit told");
                    assert_eq!(last["status"], "unknown");
                    continue;
                };
                let error = flight.error_km(last);
                let worst = (0..3).map(|axis| (error[axis] / sigma[axis]).abs()).fold(0.0, f64::max);
                println!("{name}, {radii} radii: {:.2} km off, {worst:.1} sigma", dot(error, error).sqrt());
                assert!(worst < 5.0, "{name}, {radii} radii: {error:?} of {sigma:?}");
            }
        }
    }
}

#[test]
fn what_directions_can_tell_is_what_the_thesis_says() {
    let path = scratch("navigate-observability").join("measurements.jsonl");
    for flight in [GEO, LEO] {
        Flight { step_s: 60.0, ..flight }.write(&path, 1);
        let observability = |dynamics: &str| {
            let file = path.to_str().unwrap();
            let output = run(&["navigate", file, "--observability", "--dynamics", dynamics, "--json"]);
            assert!(output.status.success() && output.stderr.is_empty());
            json_lines(&output)
        };
        let forms = observability("kepler");
        let ranks = |misalignment: bool| -> Vec<(&str, u64)> {
            let of = forms.iter().filter(|form| form["misalignment"] == misalignment);
            of.map(|form| (form["form"].as_str().unwrap(), form["rank"].as_u64().unwrap())).collect()
        };
        // §5.2.2: the orbit is observable; of a constant misalignment the angle across the track is, the one
        // along it is not; the third changes no direction.
        assert_eq!(ranks(false), [("unit", 6), ("position", 6), ("combined", 6)]);
        assert_eq!(ranks(true), [("unit", 7), ("position", 7), ("combined", 7)]);
        for form in forms.iter().filter(|form| form["misalignment"] == true) {
            assert_eq!(form["angles_observable"], json!([false, true, false]), "{form}");
        }
        // About the vertical nothing changes whatever the forces.
        assert!(observability("full").iter().all(|form| form["angles_observable"][0] != true));
    }
}

#[test]
fn lines_that_are_none_cost_a_line_each_and_the_others_are_answered() {
    let folder = scratch("navigate-bad");
    let path = folder.join("bad.jsonl");
    let file = path.to_str().unwrap();
    let refused = |text: &str, words: &[&str]| {
        std::fs::write(&path, text).unwrap();
        refused(&["navigate", file, "--json"], words)
    };
    let first = r#"{"t_s":0,"r_km":[7000,0,0],"v_km_s":[0,7.546,0],"sigma_r_km":1,"sigma_v_km_s":0.001}"#;
    refused("", &["bad.jsonl:", "empty"]);
    refused("{}", &["bad.jsonl:1:", "missing field"]);
    for (from, to) in [
        ("7000", "6000"),
        ("7000", "1e308"),
        ("7.546", "11.0"),
        ("7.546", "0"),
        (r#""sigma_r_km":1"#, r#""sigma_r_km":0"#),
        (r#""t_s":0"#, r#""t_s":1e12"#),
    ] {
        assert!(refused(&first.replace(from, to), &["bad.jsonl:1:"]).is_empty());
    }
    let seen = r#"{"t_s":10,"u":[1,0,0],"range_km":7000,"sigma_rad":0.01,"sigma_range_km":10}"#;
    for (from, to, word) in [
        ("[1,0,0]", "[1,1,0]", "unit vector"),
        ("[1,0,0]", "[1,0]", "length 2"),
        ("0.01", "0", "sigma_rad"),
        ("0.01", "-1", "sigma_rad"),
        ("7000", "-7000", "range_km"),
        (r#""t_s":10"#, r#""t_s":-10"#, "earlier"),
        ("}", "", "EOF"),
    ] {
        let answers =
            refused(&format!("{first}\n{}\n{seen}\n", seen.replace(from, to)), &["bad.jsonl:2:", word]);
        assert_eq!(answers.len(), 1);
        assert_eq!(answers[0]["t_s"], 10.0);
    }
    // Two directions are no arc.
    std::fs::write(&path, format!("{first}\n{seen}\n{seen}")).unwrap();
    system_tests::refused(&["navigate", file, "--observability"], &["bad.jsonl:", "fewer than three"]);
    // A gap of days is crossed, its sigmas grow.
    std::fs::write(&path, format!("{first}\n{}", r#"{"t_s":259200,"u":null}"#)).unwrap();
    let answers = json_lines(&run(&["navigate", file, "--json"]));
    assert_eq!(answers[0]["status"], "propagated");
    assert!(vector(&answers[0]["sigma_r_km"]).unwrap().iter().any(|sigma| *sigma > 100.0));
}

/// Worst distance from GMAT's hourly states of a file, m, in the hours up to each of these.
fn apart_m(name: &str, hours: &[usize]) -> Option<Vec<f64>> {
    let text = std::fs::read_to_string(data(&format!("orbits/{name}.json"))?).unwrap();
    let file: Value = serde_json::from_str(&text).unwrap();
    let samples: Vec<Vec<f64>> = file["samples"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| serde_json::from_value(row.clone()).unwrap())
        .collect();
    // 2023-05-16T20:00:00 UTC.
    let state = json!({"t_s": 737_539_269.184, "r_km": samples[0][1..4], "v_km_s": samples[0][4..7],
                       "mass_kg": 100, "drag_area_m2": 0, "srp_area_m2": 0, "cd": 2.2, "cr": 1.2});
    let path = scratch(&format!("propagate-{name}")).join("state.json");
    std::fs::write(&path, state.to_string()).unwrap();
    let steps = ["--duration-s", "86400", "--step-s", "3600", "--json"];
    let output = run(&[&["propagate", path.to_str().unwrap(), "--dynamics", "j2"], &steps[..]].concat());
    assert!(output.status.success() && output.stderr.is_empty());
    let answers = json_lines(&output);
    assert_eq!(answers.len(), 25);
    let apart = |hour: &usize| {
        let truth: Vector = samples[*hour][1..4].try_into().unwrap();
        let error = plus(vector(&answers[*hour]["r_km"]).unwrap(), -1.0, truth);
        1e3 * dot(error, error).sqrt()
    };
    let worst = |last: &usize| (0..=*last).map(|hour| apart(&hour)).fold(0.0, f64::max);
    Some(hours.iter().map(worst).collect())
}

/// With the same forces: the field to degree and order two, Sun and Moon.
#[test]
fn the_dynamics_that_fly_beside_gmat() {
    for name in ["leo_iss_j2", "geo_j2"] {
        let Some(apart_m) = apart_m(name, &[2, 24]) else { return };
        println!("{name}: {:.0} m after 2 hours, {:.0} m after a day", apart_m[0], apart_m[1]);
        assert!(apart_m[1] < 100.0);
    }
}

#[test]
fn an_orbit_that_leaves_the_bounds_is_told_and_what_is_no_state_refused() {
    let path = scratch("propagate-bad").join("state.json");
    let file = path.to_str().unwrap();
    let propagate = |text: &str, more: &[&str]| {
        std::fs::write(&path, text).unwrap();
        run(&[&["propagate", file, "--json"], more].concat())
    };
    let steps = ["--duration-s", "1000", "--step-s", "300"];
    let output = propagate(r#"{"t_s":0,"r_km":[7000,0,0],"v_km_s":[0,2,0]}"#, &steps);
    let answers = json_lines(&output);
    assert!(output.status.success() && answers.len() < 5);
    assert_eq!(answers.last().unwrap()["status"], "out_of_bounds");
    let pushed = r#"{"t_s":0,"r_km":[7000,0,0],"v_km_s":[0,7.5,0],"drag_area_m2":3,"mass_kg":90,"cd":2.2}"#;
    let output = propagate(pushed, &steps);
    assert!(output.status.success() && output.stderr.is_empty());
    let times: Vec<f64> = json_lines(&output).iter().map(|answer| answer["t_s"].as_f64().unwrap()).collect();
    assert_eq!(times, [0.0, 300.0, 600.0, 900.0, 1000.0]);
    for (text, more) in [
        ("", &steps[..]),
        (r#"{"t_s":0,"r_km":[7000,0,0],"v_km_s":[0,7.5,0],"drag_area_m2":3}"#, &steps),
        (r#"{"t_s":0,"r_km":[7000,0],"v_km_s":[0,7.5,0]}"#, &steps),
        (r#"{"t_s":0,"r_km":[7000,0,0],"v_km_s":[0,7.5,0],"body":"venus"}"#, &steps),
        (&pushed.replace("7.5", "0.8").replace("}", r#","body":"moon"}"#), &steps),
        (r#"{"t_s":0,"r_km":[700,0,0],"v_km_s":[0,7.5,0]}"#, &steps),
        (r#"{"t_s":0,"r_km":[7000,0,0],"v_km_s":[0,75,0]}"#, &steps),
        (r#"{"t_s":0,"r_km":[7000,0,0],"v_km_s":[0,7.5,0]}"#, &["--duration-s", "-1", "--step-s", "1"]),
        (r#"{"t_s":0,"r_km":[7000,0,0],"v_km_s":[0,7.5,0]}"#, &["--duration-s", "1e9", "--step-s", "1e-6"]),
        (r#"{"t_s":0,"r_km":[7000,0,0],"v_km_s":[0,7.5,0]}"#, &["--duration-s", "10", "--step-s", "nan"]),
    ] {
        std::fs::write(&path, text).unwrap();
        refused(&[&["propagate", file, "--json"], more].concat(), &[]);
    }
}
