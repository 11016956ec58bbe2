//! The sensor's next change of state, looked for in the seconds that have time for it.
//!
//! In: orbit, attitude and rate. Out: when an outage begins or ends, how well that is known and how long it
//! lasts, for the spacecraft to plan by. Assumed is that the attitude goes on as it is: at rest in space
//! where it turns less than half as fast as the satellite goes about the body, else at rest against the local
//! vertical. An attitude that leaves that by [`HELD_COSINE`] ends all that was foreseen. A revolution takes
//! 20 minutes to look through; then it begins again, and sooner where the orbit is known far better by then.
//!
//! What is foreseen is a notice: nothing on board rests on it, and it is no part of what is sealed.

use super::Sensor;
use crate::frames::{EarthPath, Lvlh, Rotation};
use crate::modes::Mode;
use crate::orbit::OrbitState;
use crate::orbit::constants::MICROSECONDS;
use crate::orbit::forces::Forces;
use crate::orbit::motion::Timing;
use crate::outages::{Change, Forecast, Outlook, PointingLaw, local_axes};
use crate::telemetry::NextState;
use fsw_ground::matrix::{cross, dot};

/// Cosine of 1.1 deg: how far an attitude may be from its law.
const HELD_COSINE: f32 = 0.9998;
/// A look ahead begins anew where times are known so many times better than at its begin.
const FAR_BETTER: f32 = 3.0;
/// Time to which looks are compared, s.
const COMPARED_S: f32 = 3000.0;
/// Variance of whole seconds in place of times, s²: of what is foreseen, and of what comes.
const WHOLE_S2: f32 = 2.0 / 12.0;
/// Errors of the Sun's direction, of the mounting and of the attitude, rad: 0.008 deg.
const DIRECTION_RAD: f32 = 1.4e-4;

/// A look ahead under way.
#[derive(Clone, Copy, Debug)]
struct Look {
    law: PointingLaw,
    outlook: Outlook,
    begun_us: i64,
    /// Of the orbit on which it rests.
    timing: Timing,
}

/// Changes, and when and by what orbit they were foreseen.
#[derive(Clone, Copy, Debug)]
struct Foreseen {
    changes: [Option<Change>; 2],
    begun_us: i64,
    timing: Timing,
}

impl Foreseen {
    fn by(Look { outlook, begun_us, timing, .. }: &Look) -> Self {
        Self { changes: outlook.found(), begun_us: *begun_us, timing: *timing }
    }

    /// What of it lies after an instant; `None` where nothing does.
    fn after(self, now_us: i64) -> Option<Self> {
        let changes = match self.changes {
            [Some(first), second] if first.time_us <= now_us => [second, None],
            changes => changes,
        };
        let [first, _] = changes;
        first.is_some_and(|first| first.time_us > now_us).then_some(Self { changes, ..self })
    }

    /// As it is told; `circling_rad_s` is the rate at which the satellite goes about the body.
    fn told(&self, now_us: i64, circling_rad_s: f32) -> Option<NextState> {
        let [first, second] = self.changes;
        let first = first?;
        let turning_s = DIRECTION_RAD / circling_rad_s;
        let orbit_s = self.timing.sigma_s(seconds(self.begun_us, first.time_us) as f32);
        Some(NextState {
            state: first.state,
            in_s: seconds(now_us, first.time_us),
            sigma_s: libm::sqrtf(orbit_s * orbit_s + turning_s * turning_s + WHOLE_S2),
            lasts_s: second.map(|second| seconds(first.time_us, second.time_us)),
        })
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
    under_way: Option<Look>,
    /// By the look before.
    foreseen: Option<Foreseen>,
}

impl Sensor<'_> {
    /// Goes on with the look ahead, and gives what is foreseen; nothing without orbit and the Earth path's
    /// attitude against local vertical and horizontal.
    #[inline(never)]
    pub(super) fn look_ahead(
        &mut self,
        mode: Mode,
        path: Option<&Rotation<Lvlh, EarthPath>>,
    ) -> Option<NextState> {
        let orbit = *self.orbit.state()?;
        let path = path?;
        let held = match &self.forecasting.under_way {
            Some(look) => self.is_held(&look.law, &orbit, path),
            None => false,
        };
        if !held {
            self.forecasting = Forecasting::default();
        }
        if matches!(mode, Mode::Tracking | Mode::Eclipse | Mode::SunOutage) && !self.orbit.is_busy() {
            self.go_on_ahead(&orbit, path);
        }
        let Forecasting { under_way, foreseen } = &self.forecasting;
        let before = foreseen.and_then(|foreseen| foreseen.after(orbit.time_us));
        let found = under_way.as_ref().and_then(|look| Foreseen::by(look).after(orbit.time_us));
        let whole = |foreseen: &Foreseen| foreseen.changes.iter().all(Option::is_some);
        let best = before.filter(whole).or(found).or(before);
        best?.told(orbit.time_us, libm::sqrt(circling_squared(&orbit)) as f32)
    }

    /// Whether the Earth path is where the law has it.
    fn is_held(&self, law: &PointingLaw, orbit: &OrbitState, path: &Rotation<Lvlh, EarthPath>) -> bool {
        let expected = law.earth_path(self.parameters.orbit.body, orbit);
        expected.zip(local_axes(orbit)).is_some_and(|(expected, axes)| {
            let off = expected.inverse().then(&axes.then(path));
            0.5 * (off.matrix().trace() - 1.0) > HELD_COSINE
        })
    }

    /// A step of the look ahead, or a new one where none is under way.
    fn go_on_ahead(&mut self, orbit: &OrbitState, path: &Rotation<Lvlh, EarthPath>) -> Option<()> {
        let body = self.parameters.orbit.body;
        let timing = self.orbit.motion_covariance()?.timing(body, orbit);
        let forecast = |pointing| Forecast {
            camera: &self.camera,
            star_to_earth: self.mounting(),
            pointing,
            earth: &self.parameters.earth,
            forces: Forces::J2.about(body),
        };
        let begun = |law| {
            let outlook = Outlook::new(&forecast(law), orbit)?;
            Some(Look { law, outlook, begun_us: orbit.time_us, timing })
        };
        let Some(mut look) = self.forecasting.under_way else {
            self.forecasting.under_way = begun(self.law_of(orbit, path)?);
            return None;
        };
        let better = |than: &Timing| FAR_BETTER * timing.sigma_s(COMPARED_S) < than.sigma_s(COMPARED_S);
        let stepped = look.outlook.step(&forecast(look.law)).is_ok();
        let over = look.outlook.is_over();
        let foreseen = if over { Some(Foreseen::by(&look)) } else { self.forecasting.foreseen };
        let again = over || better(&look.timing);
        let under_way = if again { begun(look.law) } else { stepped.then_some(look) };
        let foreseen = foreseen.filter(|foreseen| !better(&foreseen.timing));
        self.forecasting = Forecasting { under_way, foreseen };
        Some(())
    }

    /// The law by which it seems to be pointed: at rest in space, or against the local vertical.
    fn law_of(&self, orbit: &OrbitState, path: &Rotation<Lvlh, EarthPath>) -> Option<PointingLaw> {
        let rate = self.motion.as_ref()?.rate()?.rad_s;
        if f64::from(dot(&rate, &rate)) < 0.25 * circling_squared(orbit) {
            return Some(PointingLaw::Inertial(local_axes(orbit)?.then(path)));
        }
        Some(PointingLaw::Local(*path))
    }
}

/// Square of the rate at which the satellite goes about the body, (r x v / r²)², rad²/s².
fn circling_squared(OrbitState { position_km, velocity_km_s, .. }: &OrbitState) -> f64 {
    let area = cross(position_km, velocity_km_s);
    let square_km2 = dot(position_km, position_km);
    dot(&area, &area) / (square_km2 * square_km2)
}
