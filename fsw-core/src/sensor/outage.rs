//! The Sun in a path: a blinded detector, an outage that lasts, and the shutters against it.

use super::Sensor;
use super::exposing::Image;
use super::propagation::Ephemeris;
use super::record::StarRecord;
use super::timekeeping::SECOND_US;
use crate::frames::{Icrs, Rotation, StarPath};
use crate::modes::Mode;
use crate::outages::{SensorState, fields_met, state_by_sun};
use crate::shutting::{EarthFilter, SunPlace};
use fsw_hal::{LocalTime, OpenPaths};

/// Angular radius of the Sun, rad: 0.267 deg.
const SUN_RADIUS_RAD: f32 = 4.66e-3;

impl Sensor<'_> {
    /// In a Sun outage the filter's state is propagated every second: no step is longer, whatever the outage
    /// lasts.
    pub(super) fn propagate_in_outage(&mut self, mode: Mode) {
        if let (Mode::SunOutage, Some(motion)) = (mode, self.motion.as_mut()) {
            motion.propagate(self.now, None);
        }
    }

    /// Whether the Sun's disc touches the field of a path, by the predicted attitude.
    #[inline(never)]
    pub(super) fn sun_is_in_path(&self, ephemeris: &Ephemeris) -> bool {
        self.sun_in_paths(ephemeris, self.now, 0.0).is_some_and(|(star, earth)| star || earth)
    }

    /// The sensor's state in a second with this image; `dark`: whether no limb in the field is lit, where
    /// that is known. An image through both paths that is not blinded has no Sun in it, wherever attitude and
    /// orbit have it; in any other it is where these say.
    #[inline(never)]
    pub(super) fn state(
        &self,
        ephemeris: &Ephemeris,
        (image, open): (Image, OpenPaths),
        dark: Option<bool>,
    ) -> Option<SensorState> {
        let by_light = dark.map(|dark| SensorState::by_light(!dark));
        if image == Image::Taken && open.both() {
            return by_light;
        }
        let touched = self.sun_in_paths(ephemeris, self.now, 0.0)?;
        if touched == (false, false) {
            return by_light;
        }
        let (attitude, _) = self.motion.as_ref()?.at(self.now)?;
        let view = self.known_view(ephemeris, &attitude);
        state_by_sun(&self.camera, &attitude.apply(&ephemeris.sun), touched, view.as_ref())
    }

    /// Whether the Sun's disc comes within `margin_rad` of the field of star path and Earth path, by the
    /// attitude carried on to `instant`, and is not hidden whole by the Earth; `None` without an attitude.
    fn sun_in_paths(
        &self,
        ephemeris: &Ephemeris,
        instant: LocalTime,
        margin_rad: f32,
    ) -> Option<(bool, bool)> {
        let (attitude, _) = self.motion.as_ref()?.at(instant)?;
        let in_star_path = attitude.apply(&ephemeris.sun);
        let in_earth_path = self.mounting().apply(&in_star_path);
        let radius_rad = SUN_RADIUS_RAD + margin_rad;
        let hidden = || self.earth_hides_sun(ephemeris, &attitude, margin_rad);
        Some(fields_met(&self.camera, (&in_star_path, &in_earth_path), radius_rad, hidden))
    }

    /// Whether the Earth hides the Sun's disc, at this attitude of the star path, and whatever is within
    /// `margin_rad` of it.
    fn earth_hides_sun(
        &self,
        ephemeris: &Ephemeris,
        attitude: &Rotation<Icrs, StarPath>,
        margin_rad: f32,
    ) -> bool {
        let sun = self.mounting().apply(&attitude.apply(&ephemeris.sun));
        let view = self.known_view(ephemeris, attitude);
        view.is_some_and(|view| view.hides_disc(&sun, SUN_RADIUS_RAD + margin_rad))
    }

    /// Whether no light of the Earth can come into the Earth path at `instant`: the Sun is deeper below its
    /// limb than twilight reaches. Where the whole Sun is hidden no ground in sight is lit: the plane that
    /// touches lit ground has Sun and satellite on its upper side, and nothing of the Earth between them.
    #[inline(never)]
    fn earth_gives_no_light(&self, ephemeris: &Ephemeris, instant: LocalTime) -> bool {
        let twilight_rad = self.parameters.earth.light.twilight_deg.to_radians();
        let attitude = self.motion.as_ref().and_then(|motion| motion.at(instant));
        attitude.is_some_and(|(attitude, _)| self.earth_hides_sun(ephemeris, &attitude, twilight_rad))
    }

    /// Decides which paths are open in the next second; nothing is new of a second without an image.
    #[inline(never)]
    pub(super) fn shut_against_sun(
        &mut self,
        image: Image,
        ephemeris: Option<&Ephemeris>,
        stars: &StarRecord,
    ) {
        let Some(parameters) = self.parameters.shutter else { return };
        let blinded = match image {
            Image::Taken => false,
            Image::Blinded => true,
            Image::NotAsked | Image::Refused(_) | Image::Failed(_) => return,
        };
        let next = self.now.plus_us(SECOND_US);
        let places =
            ephemeris.and_then(|ephemeris| self.sun_in_paths(ephemeris, next, parameters.margin_rad));
        let is_adaptive = parameters.filter == EarthFilter::Adaptive;
        let dark =
            is_adaptive && ephemeris.is_some_and(|ephemeris| self.earth_gives_no_light(ephemeris, next));
        let sun = places.map(|place| SunPlace {
            free: match place {
                (true, false) => OpenPaths::Earth,
                (false, true) => OpenPaths::Star,
                (false, false) if dark => OpenPaths::BothClear,
                (false, false) | (true, true) => OpenPaths::Both,
            },
            measured: stars.own_attitude().is_some(),
        });
        self.shutting.next(self.now, blinded, sun, &parameters);
    }
}
