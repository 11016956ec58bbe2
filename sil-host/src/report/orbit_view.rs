//! The orbit, the Earth, its shadow and the Sun in one drawing.
//!
//! In: the truth, second by second. Out: inline SVG, seen from the orbit's normal, the Sun to the right.
//! Drawn is the first revolution: what happens in the later ones lies nearly where it lies in the first. The
//! shadow is a cylinder about the Sun's axis; with the Sun `beta` above the orbit plane it cuts that plane in
//! half an ellipse of the semi-axes `R` and `R / |sin beta|`. Drawings only: what is judged is not from here.

use super::scale::label;
use crate::world::attitude::{Vector, dot};
use crate::world::scene::{SensorState, Truth};
use crate::world::vector::{angle, cross, length, plus, unit};
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// A place is kept when the orbit has turned so far since the last one.
const TURN_RAD: f64 = 0.012;
/// Size of the drawing and its margin.
const SIZE: (f64, f64) = (520.0, 330.0);
const MARGIN: f64 = 26.0;

/// Places of the first revolution.
#[derive(Clone, Debug, Default)]
pub struct OrbitView {
    /// Axes of the drawing: towards the Sun in the orbit plane, across it, the normal; and the Sun above it.
    axes: Option<[Vector; 3]>,
    beta_rad: f64,
    /// Radius of the body's equator, km.
    equator_km: f64,
    /// In the orbit plane, km, and the state there.
    places: Vec<([f64; 2], SensorState)>,
    turned_rad: f64,
    last: Vector,
    /// Seconds without a lit limb, and with the Sun in a path.
    dark_s: u32,
    sun_s: u32,
    altitude_km: Option<(f64, f64)>,
}

impl OrbitView {
    /// Adds a second.
    pub fn add(&mut self, truth: &Truth) {
        match truth.state {
            SensorState::Full => {}
            SensorState::Eclipse => self.dark_s += 1,
            _ => self.sun_s += 1,
        }
        self.equator_km = truth.ellipsoid.figure().equator_km;
        let altitude = length(truth.position_km) - self.equator_km;
        let (low, high) = self.altitude_km.unwrap_or((altitude, altitude));
        self.altitude_km = Some((low.min(altitude), high.max(altitude)));
        if self.axes.is_none() {
            self.begin(truth);
        }
        let turned = if self.places.is_empty() { 0.0 } else { angle(self.last, truth.position_km) };
        let changed = self.places.last().is_none_or(|(_, state)| *state != truth.state);
        if self.turned_rad < TAU && (turned >= TURN_RAD || changed) {
            let [sunward, across, _] = self.axes.unwrap_or_default();
            let place = [dot(truth.position_km, sunward), dot(truth.position_km, across)];
            self.places.push((place, truth.state));
            self.turned_rad += turned;
            self.last = truth.position_km;
        }
    }

    fn begin(&mut self, truth: &Truth) {
        let normal = unit(cross(truth.position_km, truth.velocity_km_s));
        let sine = dot(truth.sun, normal);
        let in_plane = plus(truth.sun, -sine, normal);
        // With the Sun on the normal any direction will do.
        let sunward = unit(if length(in_plane) > 1e-3 { in_plane } else { truth.position_km });
        self.beta_rad = libm::asin(sine.clamp(-1.0, 1.0));
        self.axes = Some([sunward, cross(normal, sunward), normal]);
    }

    /// What it shows, in words: what, value.
    pub fn words(&self) -> Vec<(&'static str, String)> {
        let (low, high) = self.altitude_km.unwrap_or_default();
        vec![
            ("Altitude", format!("{low:.0} to {high:.0} km above the equator's radius")),
            ("Sun above the orbit plane", format!("{} deg", label(self.beta_rad.to_degrees()))),
            ("No lit limb in the field", format!("{} s", self.dark_s)),
            ("Sun in a path", format!("{} s", self.sun_s)),
        ]
    }

    /// The drawing.
    pub fn draw(&self) -> String {
        let places = || self.places.iter().map(|(place, _)| *place);
        let reach = |axis: usize| {
            let (low, high) = (-1.15 * self.equator_km, 1.15 * self.equator_km);
            places().fold((low, high), |(low, high), place| (low.min(place[axis]), high.max(place[axis])))
        };
        let (x_km, y_km) = (reach(0), reach(1));
        // To the right the Sun's rays come in.
        let scale = ((SIZE.0 - 2.0 * MARGIN - 60.0) / (x_km.1 - x_km.0))
            .min((SIZE.1 - 2.0 * MARGIN) / (y_km.1 - y_km.0));
        let centre = [
            0.5 * (SIZE.0 - 60.0) - scale * 0.5 * (x_km.0 + x_km.1),
            0.5 * SIZE.1 + scale * 0.5 * (y_km.0 + y_km.1),
        ];
        let point = |[x, y]: [f64; 2]| [centre[0] + scale * x, centre[1] - scale * y];
        let mut svg = format!(
            "<svg class=\"orbit\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"Orbit, Earth, shadow and Sun\">",
            SIZE.0, SIZE.1
        );
        let (shadow, night) = (self.shadow(), self.night());
        let _ = write!(svg, "<path class=\"shadow\" d=\"{}Z\"/>", path(shadow.into_iter().map(point)));
        let [x, y] = centre;
        let _ = write!(
            svg,
            "<circle class=\"globe\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\"/><path class=\"night\" d=\"{}Z\"/>",
            scale * self.equator_km,
            path(night.into_iter().map(point))
        );
        for (class, piece) in self.pieces() {
            let _ = write!(
                svg,
                "<path class=\"way {class}-way\" d=\"{}\"/>",
                path(piece.iter().copied().map(point))
            );
        }
        self.flight(&mut svg, point);
        self.ends(&mut svg, point);
        rays(&mut svg);
        svg.push_str("</svg>");
        svg
    }

    /// The orbit in pieces of one look; each begins where the one before ends.
    fn pieces(&self) -> Vec<(&'static str, Vec<[f64; 2]>)> {
        let class = |state| match state {
            SensorState::Full => "full",
            SensorState::Eclipse => "dark",
            _ => "sun",
        };
        let mut pieces: Vec<(&'static str, Vec<[f64; 2]>)> = Vec::new();
        for (place, state) in &self.places {
            match pieces.last_mut() {
                Some((last, piece)) if *last == class(*state) => piece.push(*place),
                Some((_, piece)) => {
                    piece.push(*place);
                    pieces.push((class(*state), vec![*place]));
                }
                None => pieces.push((class(*state), vec![*place])),
            }
        }
        pieces
    }

    /// The direction of flight, on the way.
    fn flight(&self, svg: &mut String, point: impl Fn([f64; 2]) -> [f64; 2]) {
        let [Some(from), Some(to)] = [8, 10].map(|part| self.places.get(self.places.len() * part / 64))
        else {
            return;
        };
        let ([x, y], [u, v]) = (point(from.0), point(to.0));
        let heading = libm::atan2(v - y, u - x).to_degrees();
        let _ = write!(
            svg,
            "<path class=\"flight\" transform=\"translate({x:.1} {y:.1}) rotate({heading:.0})\" d=\"M-6 -6L3 0L-6 6\"/>"
        );
    }

    /// Start and end of what is drawn.
    fn ends(&self, svg: &mut String, point: impl Fn([f64; 2]) -> [f64; 2]) {
        let (Some((first, _)), Some((last, _))) = (self.places.first(), self.places.last()) else { return };
        let mut end = |class: &str, place: [f64; 2]| {
            // The word stands away from the Earth.
            let far = libm::hypot(place[0], place[1]);
            let ([x, y], out) = (point(place), place.map(|part| 20.0 * part / far));
            let _ = write!(
                svg,
                "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\"/>\
                 <text class=\"place\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{class}</text>",
                x + out[0],
                y - out[1] + 4.0
            );
        };
        end("start", *first);
        if self.turned_rad < 0.95 * TAU {
            end("end", *last);
        }
    }

    /// Where the orbit plane lies in the shadow, km.
    fn shadow(&self) -> Vec<[f64; 2]> {
        let long = self.equator_km / libm::sin(self.beta_rad).abs().max(1e-3);
        half_turn().map(|(sine, cosine)| [-long * cosine, self.equator_km * sine]).collect()
    }

    /// The night side of the globe as seen from the orbit's normal, km: from its rim back by the terminator.
    fn night(&self) -> Vec<[f64; 2]> {
        let tilt = libm::sin(self.beta_rad);
        let rim = half_turn().map(|(sine, cosine)| [-self.equator_km * cosine, self.equator_km * sine]);
        let terminator =
            half_turn().map(|(sine, cosine)| [-self.equator_km * tilt * cosine, -self.equator_km * sine]);
        rim.chain(terminator).collect()
    }
}

/// Sine and cosine from a quarter turn to its opposite.
fn half_turn() -> impl Iterator<Item = (f64, f64)> {
    (0..=48).map(|step| libm::sincos(TAU * (0.25 - f64::from(step) / 96.0)))
}

fn path(points: impl Iterator<Item = [f64; 2]>) -> String {
    points.enumerate().fold(String::new(), |mut path, (number, [x, y])| {
        let _ = write!(path, "{}{x:.1} {y:.1}", if number == 0 { 'M' } else { 'L' });
        path
    })
}

/// Arrows of the Sun's light.
fn rays(svg: &mut String) {
    let right = SIZE.0 - 10.0;
    for step in -1..=1 {
        let y = 0.5 * SIZE.1 + f64::from(step) * 34.0;
        let _ = write!(svg, "<path class=\"ray\" d=\"M{right} {y:.1}h-44m8 -5l-8 5l8 5\"/>");
    }
    let _ = write!(
        svg,
        "<text class=\"place\" x=\"{right}\" y=\"{:.1}\" text-anchor=\"end\">Sun</text>",
        0.5 * SIZE.1 - 46.0
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::harness::truth_of;
    use crate::scenario::Scenario;
    use crate::world::earth::EQUATOR_KM;

    #[test]
    fn a_revolution_is_drawn_once_and_in_the_states_it_was_flown_in() {
        let scenario = Scenario::default_embedded();
        let scene = scenario.scene().unwrap();
        let mut view = OrbitView::default();
        for cycle in (0..scenario.duration_s).step_by(10) {
            view.add(&truth_of(&scene, cycle).unwrap());
        }
        // A quarter of a geostationary revolution about the shadow, at the equinox.
        let looks: Vec<&str> = view.pieces().iter().map(|(class, _)| *class).collect();
        assert_eq!(looks, ["full", "sun", "dark", "sun", "full"]);
        assert!(view.beta_rad.to_degrees().abs() < 1.5, "{}", view.beta_rad);
        assert!(view.places.iter().all(|([x, _], _)| *x < 0.0));
        for ([x, y], _) in &view.places {
            assert!((x.hypot(*y) - 42_164.0).abs() < 100.0, "{x} {y}");
        }
        let svg = view.draw();
        assert!(svg.contains("dark-way") && svg.contains("sun-way") && svg.contains(">end<"));
    }

    #[test]
    fn the_shadow_is_as_long_as_the_sun_stands_low() {
        let low = OrbitView { beta_rad: 0.0, equator_km: EQUATOR_KM, ..OrbitView::default() };
        let farthest = |view: &OrbitView| view.shadow().iter().fold(0.0, |far: f64, [x, _]| far.min(*x));
        assert!(farthest(&low) < -1e6);
        let high = OrbitView { beta_rad: 0.5, ..low };
        assert!((farthest(&high) + EQUATOR_KM / 0.5f64.sin()).abs() < 1.0);
    }
}
