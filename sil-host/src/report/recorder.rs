//! What the page needs of the seconds gone by; its size does not depend on their number.

use super::histogram::Deviates;
use super::moments::Moments;
use super::orbit_view::OrbitView;
use super::plot;
use super::trace::{Banded, Marks, Stretches, Trace};
use crate::harness::faults::Fault;
use crate::harness::{Second, events};
use crate::judge::arcsec;
use crate::judge::expected::expected_mode;
use crate::judge::quantities::QUANTITIES;
use crate::judge::second::{Axes, Judged};
use crate::world::attitude::{apply, matrix};
use crate::world::scene::{SensorState, Truth};
use crate::world::vector::length;
use fsw_core::modes::Mode;
use fsw_core::telemetry::{LocalAttitude, OrbitReport};

/// Most events listed; the others are counted.
const EVENTS_MAX: usize = 120;
/// Most restarts of the orbit marked.
const RESTARTS_MAX: usize = 200;

/// The last second whose orbit was known.
#[derive(Clone, Debug)]
pub(super) struct LastOrbit {
    pub(super) cycle: u32,
    pub(super) report: OrbitReport,
    pub(super) local: Option<LocalAttitude>,
    pub(super) truth: Truth,
}

/// Rows of the plot of modes, a mode each, in the order in which they are drawn.
pub const MODE_ROWS: [&str; 6] = ["tracking", "eclipse", "Sun outage", "acquisition", "self-test", "safe"];

/// The row of a mode.
fn row_of(mode: Mode) -> u8 {
    match mode {
        Mode::Tracking => 0,
        Mode::Eclipse => 1,
        Mode::SunOutage => 2,
        Mode::Acquisition => 3,
        Mode::SelfTest => 4,
        Mode::Safe | Mode::CommandedSafe => 5,
    }
}

/// Gathers what the page shows, second after second.
#[derive(Clone, Debug)]
pub struct Recorder {
    pub(super) stretches: Stretches,
    pub(super) geometry: Marks,
    pub(super) expected: Marks,
    pub(super) flown: Marks,
    pub(super) wrong: Marks,
    /// Arcsec, outside Sun states; the same filtered; and in Sun states.
    pub(super) attitude: [Banded; 3],
    pub(super) filtered: [Banded; 3],
    pub(super) sun_attitude: [Banded; 3],
    /// Arcsec/s; and without an attitude, deg/s.
    pub(super) rate: [Trace; 3],
    pub(super) turning: [Banded; 3],
    /// Radial, along, cross: km and m/s.
    pub(super) position: [Banded; 3],
    /// Bound of the position by the horizon, km.
    pub(super) position_bound: [Trace; 3],
    pub(super) velocity: [Banded; 3],
    /// Direction x and y, deg; distance, km.
    pub(super) earth: [Banded; 3],
    pub(super) limb_height: Banded,
    pub(super) stars: Trace,
    pub(super) limb_points: Trace,
    pub(super) lit_limb: Trace,
    pub(super) nis: Trace,
    /// Above the equator's radius, km.
    pub(super) altitude: Trace,
    /// Of the Sun from the middle of the Earth path and of the star path, deg.
    pub(super) sun_angles: [Trace; 2],
    pub(super) orbit: OrbitView,
    pub(super) last_orbit: Option<LastOrbit>,
    /// Error over sigma of each of the judge's quantities.
    pub(super) deviates: [Deviates; QUANTITIES.len()],
    pub(super) faults: Vec<Fault>,
    pub(super) restarts: Vec<(u32, String)>,
    pub(super) events: Vec<(u32, String)>,
    pub(super) events_left_out: u32,
    pub(super) moments: Moments,
}

impl Recorder {
    /// For a run of `seconds`.
    pub fn new(seconds: u32) -> Self {
        let stretches = Stretches::of(seconds);
        let marks = || Marks::new(stretches);
        let trace = || Trace::new(stretches);
        let banded = || Banded::new(stretches);
        let three = || [banded(), banded(), banded()];
        Self {
            stretches,
            geometry: marks(),
            expected: marks(),
            flown: marks(),
            wrong: marks(),
            attitude: three(),
            filtered: three(),
            sun_attitude: three(),
            rate: [trace(), trace(), trace()],
            turning: three(),
            position: three(),
            position_bound: [trace(), trace(), trace()],
            velocity: three(),
            earth: three(),
            limb_height: banded(),
            stars: trace(),
            limb_points: trace(),
            lit_limb: trace(),
            nis: trace(),
            altitude: trace(),
            sun_angles: [trace(), trace()],
            orbit: OrbitView::default(),
            last_orbit: None,
            deviates: Default::default(),
            faults: Vec::new(),
            restarts: Vec::new(),
            events: Vec::new(),
            events_left_out: 0,
            moments: Moments::default(),
        }
    }

    /// Adds a second; `mode_right` is the judge's word on its mode.
    pub fn add(&mut self, second: &Second<'_>, mode_right: bool) {
        let Second { cycle, report, truth, judged, .. } = *second;
        let at = self.stretches.index(cycle);
        self.expected.add(at, row_of(expected_mode(judged)));
        self.flown.add(at, row_of(report.mode));
        if !mode_right {
            self.wrong.add(at, row_of(report.mode));
        }
        self.add_geometry(at, truth);
        self.add_attitude(at, judged);
        self.add_orbit(at, judged);
        if let Some(orbit) = report.orbit {
            self.last_orbit = Some(LastOrbit { cycle, report: orbit, local: report.local, truth: *truth });
        }
        for (quantity, deviates) in QUANTITIES.iter().zip(&mut self.deviates) {
            if let Some(axes) = (quantity.of)(judged) {
                deviates.add(&axes, quantity.axes);
            }
        }
        self.stars.add(at, judged.stars.into());
        self.limb_points.add(at, judged.limb_points.into());
        self.add_events(second);
        self.moments.look(second, cycle + 1 == self.stretches.seconds);
    }

    /// Adds the bound of a second's position, radial, along, cross, km, where there is one.
    pub fn add_bound(&mut self, cycle: u32, bound_km: Option<[f64; 3]>) {
        let at = self.stretches.index(cycle);
        for (trace, bound) in self.position_bound.iter_mut().zip(bound_km.into_iter().flatten()) {
            trace.add(at, bound);
        }
    }

    fn add_geometry(&mut self, at: usize, truth: &Truth) {
        match truth.state {
            SensorState::Full => {}
            SensorState::Eclipse => self.geometry.add(at, plot::DARK),
            _ => self.geometry.add(at, plot::SUN),
        }
        self.lit_limb.add(at, truth.lit_limb_deg);
        self.altitude.add(at, length(truth.position_km) - truth.ellipsoid.figure().equator_km);
        let star_path = matrix(truth.quaternion);
        for (trace, path) in self.sun_angles.iter_mut().zip([&truth.earth_path, &star_path]) {
            let [x, y, z] = apply(path, truth.sun);
            trace.add(at, libm::atan2(libm::hypot(x, y), z).to_degrees());
        }
        self.orbit.add(truth);
    }

    fn add_attitude(&mut self, at: usize, judged: &Judged) {
        let attitude = if judged.sun() { &mut self.sun_attitude } else { &mut self.attitude };
        add_axes(attitude, at, judged.attitude_rad.as_ref(), arcsec(1.0));
        add_axes(&mut self.filtered, at, judged.filtered_rad.filter(|_| !judged.sun()).as_ref(), arcsec(1.0));
        let turning = judged.turning.map(|turning| turning.rad_s);
        add_axes(&mut self.turning, at, turning.as_ref(), 1f64.to_degrees());
        if let Some(rate) = judged.rate_rad_s {
            for (trace, error) in self.rate.iter_mut().zip(rate) {
                trace.add(at, arcsec(error));
            }
        }
    }

    fn add_orbit(&mut self, at: usize, judged: &Judged) {
        if let Some(earth) = &judged.earth {
            let Axes { error, sigma } = earth.direction_rad.axes;
            for axis in 0..2 {
                self.earth[axis].add(at, error[axis].to_degrees(), sigma[axis].to_degrees());
            }
            self.earth[2].add(at, earth.distance_km, earth.sigma_km);
        }
        if let Some(orbit) = &judged.orbit {
            add_axes(&mut self.position, at, Some(&orbit.position_km.axes), 1.0);
            add_axes(&mut self.velocity, at, Some(&orbit.velocity_km_s.axes), 1e3);
            let [height, sigma] = orbit.limb_height_km;
            self.limb_height.add(at, height, sigma);
            if let Some([square, freedom]) = orbit.nis {
                self.nis.add(at, square / freedom.max(1.0));
            }
        }
    }

    fn add_events(&mut self, second: &Second<'_>) {
        let cycle = second.cycle;
        for fault in second.faults.iter().filter(|fault| fault.from_s == cycle) {
            self.faults.push(*fault);
            let words = format!("fault injected for {} s: {}", fault.until_s - cycle, fault.kind.word());
            self.note(cycle, words);
        }
        for event in &second.report.events {
            if events::is_restart(event) && self.restarts.len() < RESTARTS_MAX {
                self.restarts.push((cycle, events::words(event)));
            }
            self.note(cycle, events::words(event));
        }
    }

    fn note(&mut self, cycle: u32, words: String) {
        if self.events.len() < EVENTS_MAX {
            self.events.push((cycle, words));
        } else {
            self.events_left_out += 1;
        }
    }
}

/// Adds the axes of a second in units of `1 / scale`, where there are any.
fn add_axes(to: &mut [Banded; 3], at: usize, axes: Option<&Axes>, scale: f64) {
    let Some(axes) = axes else { return };
    for (axis, banded) in to.iter_mut().enumerate() {
        banded.add(at, scale * axes.error[axis], scale * axes.sigma[axis]);
    }
}
