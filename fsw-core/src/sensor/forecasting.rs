//! The sensor's next change of state, looked for in the seconds that have time for it.
//!
//! In: orbit, attitude and rate. Out: when an outage begins or ends, how well that is known and how long it
//! lasts, for the spacecraft to plan by. Assumed is that the attitude goes on as it is: at rest in space
//! where it turns less than half as fast as the satellite goes about the body, else at rest against the local
//! vertical. An attitude that leaves that by [`HELD_RAD`] ends all that was foreseen. What it has left it
//! by goes on growing as it did since the look began ([`Basis::off_then_rad`]): that is a part of the error,
//! and nothing is told of a time at which the attitude is not held, nor before it was for [`PROVEN_S`]. So a
//! law of pointing that is neither of the two, as the fixed angle from the horizon that an eccentric orbit
//! asks for, gives no wrong times. A revolution takes 20 minutes to look through; then it begins again by
//! orbit and attitude of then, and sooner where they give times far better.
//!
//! What is foreseen is a notice: nothing on board rests on it, and it is no part of what is sealed.

use super::Sensor;
use super::record::Record;
use crate::frames::{EarthPath, Icrs, Lvlh, Rotation, StarPath};
use crate::modes::Mode;
use crate::orbit::OrbitState;
use crate::orbit::body::CentralBody;
use crate::orbit::constants::MICROSECONDS;
use crate::orbit::forces::Forces;
use crate::orbit::motion::Timing;
use crate::outages::{Change, Forecast, Outlook, PointingLaw, local_axes};
use crate::telemetry::NextState;
use crate::trigonometry::hypotenuse;
use fsw_ground::matrix::{cross, dot};
use nalgebra::Vector3;

/// How far an attitude may be from its law, rad: 1.1 deg.
const HELD_RAD: f32 = 0.02;
/// How long an attitude must have been held before anything is told by it, s.
const PROVEN_S: u32 = 60;
/// A look ahead begins anew where times would be known so many times better.
const FAR_BETTER: f32 = 3.0;
/// Time ahead for which that is asked, s.
const COMPARED_S: f32 = 3000.0;
/// Variance of whole seconds in place of times, s²: of what is foreseen, and of what comes.
const WHOLE_S2: f32 = 2.0 / 12.0;
/// Slowest pace of a lit limb that is believed, of that of the satellite.
const SLOWEST: f32 = 0.01;
/// Errors of the Sun's direction, of the mounting and of the attitude, rad: 0.008 deg.
const DIRECTION_RAD: f32 = 1.4e-4;

/// What a look ahead rests on.
#[derive(Clone, Copy, Debug)]
struct Basis {
    law: PointingLaw,
    begun_us: i64,
    timing: Timing,
    /// Rate at which the satellite goes about the body.
    circling_rad_s: f32,
    /// Sigma of how far across the orbit's plane it is.
    across_rad: f32,
}

impl Basis {
    /// How far the Earth path is from where the law has it, rad; more than [`HELD_RAD`] where it is not held.
    fn off_rad(&self, body: CentralBody, orbit: &OrbitState, path: &Rotation<Icrs, EarthPath>) -> f32 {
        let Some(expected) = self.law.earth_path(body, orbit) else { return f32::INFINITY };
        let angle_rad = path.angle_from(&expected);
        libm::sqrtf(dot(&angle_rad, &angle_rad))
    }

    /// How far the attitude will be from its law `ahead_s` after the begin, rad, where it goes on leaving it
    /// as it did until `now_us`, when it was `off_rad` off; `None` where it is not held then. Two sigmas are
    /// no leaving: of the attitude (`attitude_rad`) and of the orbit, which says where the local vertical is.
    fn off_then_rad(&self, (off_rad, attitude_rad): (f32, f32), now_us: i64, ahead_s: u32) -> Option<f32> {
        let held_s = seconds(self.begun_us, now_us);
        let along_rad = self.circling_rad_s * self.timing.sigma_s(0.0);
        let known_rad = hypotenuse(attitude_rad, hypotenuse(along_rad, self.across_rad));
        let left_rad = (off_rad - 2.0 * known_rad).max(0.0);
        let off_then_rad = off_rad.max(left_rad * (ahead_s as f32 / held_s.max(1) as f32));
        (off_then_rad < HELD_RAD).then_some(off_then_rad)
    }

    /// Whether the attitude has been held for long enough.
    fn is_proven(&self, now_us: i64) -> bool {
        seconds(self.begun_us, now_us) >= PROVEN_S
    }

    /// Sigma of the time of what comes `ahead_s` after the begin at a pace, of an attitude that has left its
    /// law by `off_rad`.
    fn sigma_s(&self, ahead_s: f32, off_rad: f32, pace_rad_s: Option<f32>) -> f32 {
        let pace_rad_s = pace_rad_s.unwrap_or(self.circling_rad_s);
        let orbit_s = self.timing.sigma_s(ahead_s);
        let angle_rad = hypotenuse(hypotenuse(DIRECTION_RAD, off_rad), self.across_rad);
        let directions_s = angle_rad / pace_rad_s.max(SLOWEST * self.circling_rad_s);
        libm::sqrtf(orbit_s * orbit_s + directions_s * directions_s + WHOLE_S2)
    }
}

/// Changes, and by what they are foreseen.
#[derive(Clone, Copy, Debug)]
struct Foreseen {
    basis: Basis,
    changes: [Option<Change>; 2],
}

impl Foreseen {
    /// What of it lies after an instant; `None` where nothing does.
    fn after(self, now_us: i64) -> Option<Self> {
        let changes = match self.changes {
            [Some(first), second] if first.time_us <= now_us => [second, None],
            changes => changes,
        };
        let [first, _] = changes;
        first.is_some_and(|first| first.time_us > now_us).then_some(Self { changes, ..self })
    }
}

/// Whole seconds from one time to a later one.
fn seconds(from_us: i64, to_us: i64) -> u32 {
    let second = MICROSECONDS as i64;
    u32::try_from((to_us.saturating_sub(from_us) + second / 2) / second).unwrap_or(0)
}

/// What is foreseen, and the look ahead under way.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Forecasting {
    under_way: Option<(Basis, Outlook)>,
    /// By the look before.
    foreseen: Option<Foreseen>,
}

impl Forecasting {
    /// What is foreseen after an instant: by the look before, while the one under way has not found as much.
    fn best(&self, now_us: i64) -> Option<Foreseen> {
        let before = self.foreseen.and_then(|foreseen| foreseen.after(now_us));
        let under_way = self.under_way.filter(|(basis, _)| basis.is_proven(now_us));
        let found = under_way.and_then(|(basis, outlook)| {
            let changes = outlook.found();
            Foreseen { basis, changes }.after(now_us)
        });
        let whole = |foreseen: &Foreseen| foreseen.changes.iter().all(Option::is_some);
        before.filter(whole).or(found).or(before)
    }
}

impl Sensor<'_> {
    /// Goes on with the look ahead, and gives what is foreseen; nothing without orbit and attitude.
    #[inline(never)]
    pub(super) fn look_ahead(&mut self, record: &Record) -> Option<NextState> {
        let orbit = *self.orbit.state()?;
        let to_star_path = Rotation::<Lvlh, StarPath>::from_quaternion(record.local.as_ref()?.quaternion)?;
        let local = to_star_path.then(&self.mounting());
        let path = local_axes(&orbit)?.then(&local);
        let body = self.parameters.orbit.body;
        let off_rad = |basis: &Basis| basis.off_rad(body, &orbit, &path);
        let held = |basis: &Basis| off_rad(basis) < HELD_RAD;
        self.forecasting.under_way = self.forecasting.under_way.filter(|(basis, _)| held(basis));
        self.forecasting.foreseen = self.forecasting.foreseen.filter(|foreseen| held(&foreseen.basis));
        let busy = self.orbit.is_busy() || record.earth_path_stars.is_some();
        if matches!(record.mode, Mode::Tracking | Mode::Eclipse | Mode::SunOutage) && !busy {
            self.go_on_ahead(&orbit, &local, off_rad);
        }
        let Foreseen { basis, changes: [first, second] } = self.forecasting.best(orbit.time_us)?;
        let first = first?;
        let ahead_s = seconds(basis.begun_us, first.time_us);
        let sigma = Vector3::from(record.stars.solution.as_ref()?.attitude.sigma_rad);
        let attitude_rad = libm::sqrtf(dot(&sigma, &sigma));
        let off_then_rad = basis.off_then_rad((off_rad(&basis), attitude_rad), orbit.time_us, ahead_s)?;
        Some(NextState {
            state: first.state,
            in_s: seconds(orbit.time_us, first.time_us),
            sigma_s: basis.sigma_s(ahead_s as f32, off_then_rad, first.pace_rad_s),
            lasts_s: second.map(|second| seconds(first.time_us, second.time_us)),
        })
    }

    /// A step of the look ahead, or a new one where none is under way or it would be far better.
    fn go_on_ahead(
        &mut self,
        orbit: &OrbitState,
        local: &Rotation<Lvlh, EarthPath>,
        off_rad: impl Fn(&Basis) -> f32,
    ) {
        let Some(basis) = self.basis(orbit, local) else { return };
        let forecast = |law| Forecast {
            camera: &self.camera,
            star_to_earth: self.mounting(),
            pointing: law,
            earth: &self.parameters.earth,
            forces: Forces::J2.about(self.parameters.orbit.body),
        };
        let good = |than: &Basis| {
            let now_s = basis.sigma_s(COMPARED_S, 0.0, None);
            FAR_BETTER * now_s > than.sigma_s(COMPARED_S, off_rad(than), None)
        };
        let mut foreseen = self.forecasting.foreseen.filter(|foreseen| good(&foreseen.basis));
        let mut under_way = self.forecasting.under_way.filter(|(of, _)| good(of));
        if let Some((of, outlook)) = &mut under_way {
            let stepped = if outlook.is_over() { Ok(()) } else { outlook.step(&forecast(of.law)) };
            let done = outlook.is_over() && of.is_proven(orbit.time_us);
            if done {
                foreseen = Some(Foreseen { basis: *of, changes: outlook.found() });
            }
            under_way = under_way.filter(|_| stepped.is_ok() && !done);
        } else {
            under_way = Outlook::new(&forecast(basis.law), orbit).map(|outlook| (basis, outlook));
        }
        self.forecasting = Forecasting { under_way, foreseen };
    }

    /// What a look ahead rests on that begins now. It seems to be pointed at rest in space, or against the
    /// local vertical.
    fn basis(&self, orbit: &OrbitState, local: &Rotation<Lvlh, EarthPath>) -> Option<Basis> {
        let rate = self.motion.as_ref()?.rate()?.rad_s;
        let OrbitState { time_us, position_km, velocity_km_s } = orbit;
        let area = cross(position_km, velocity_km_s);
        // r x v / r².
        let circling = libm::sqrt(dot(&area, &area)) / dot(position_km, position_km);
        let circling_rad_s = circling as f32;
        let at_rest = dot(&rate, &rate) < 0.25 * circling_rad_s * circling_rad_s;
        let law = match at_rest {
            true => PointingLaw::Inertial(local_axes(orbit)?.then(local)),
            false => PointingLaw::Local(*local),
        };
        let covariance = self.orbit.motion_covariance()?;
        let timing = covariance.timing(self.parameters.orbit.body, orbit);
        let across_rad = covariance.across_rad(orbit);
        Some(Basis { law, begun_us: *time_us, timing, circling_rad_s, across_rad })
    }
}
