//! The central body as light: its looks, and how many electrons they give. Its types are named after the
//! Earth.
//!
//! | module | takes | gives |
//! |---|---|---|
//! | [`ellipsoid`] | pole, position | what is hidden, how much limb is lit |
//! | [`lattice`] | a place in space | smooth random numbers |
//! | [`albedo`] | a place on the Earth | its albedo: sea, land, ice, clouds |
//! | [`octahedron`] | a place on the Earth | where on a map it is |
//! | [`map`] | place, footprint | the same from maps |
//! | [`horizon`] | a place on the Earth | how high the limb stands there |
//! | [`heights`] | the way between two places | what their heights have in common |
//! | [`limb`] | height of a line of sight | its brightness, blurred |
//! | [`photometry`] | albedo, Sun, view | brightness |
//! | [`looks`] | seed, model | the last three, shared |
//! | [`sight`] | pixel, time | where its line of sight passes |
//! | [`cell`] | values at its points | the same at its pixels |
//! | [`image`] | position, Sun, Earth path, rate | mean electrons of a window |
//!
//! Radiometry: a surface of albedo `A` with the Sun in the zenith has the radiance `A E / pi`; a pixel of
//! `cos³ / f²` sr collects `A E / pi · aperture cos³ / f² · mirror · filter · QE · fill / hν` electrons a
//! second: 1.16e4 for `A` = 0.3 and the thesis's camera on the axis. The fourth cosine, the aperture's
//! foreshortening, and the lens's vignetting are a factor over all light and not drawn here.

pub mod albedo;
pub mod cell;
pub mod ellipsoid;
pub mod heights;
pub mod horizon;
pub mod image;
pub mod lattice;
pub mod limb;
pub mod looks;
pub mod map;
pub mod octahedron;
pub mod photometry;
pub mod sight;

pub use ellipsoid::{Ellipsoid, Figure};

use fsw_core::orbit::body::CentralBody;
use std::f64::consts::PI;

/// Equatorial radius (WGS84), km.
pub const EQUATOR_KM: f64 = 6378.137;
/// Polar radius (WGS84), km.
pub const POLE_KM: f64 = 6_356.752_314_245;

/// The looks of the Earth, and the part of the optics that its light passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EarthModel {
    /// The body.
    pub body: CentralBody,
    /// Irradiance by the Sun at the body between 500 and 900 nm, W/m².
    pub irradiance_w_m2: f64,
    /// Diameter of the aperture, m.
    pub aperture_m: f64,
    /// Share the partial mirror lets through.
    pub mirror_transmission: f64,
    /// Share the grey filter lets through.
    pub filter_transmission: f64,
    /// Quantum efficiency of the detector.
    pub quantum_efficiency: f64,
    /// Share of a pixel that is sensitive.
    pub fill_factor: f64,
    /// Energy of a photon in the middle of the band (700 nm), J.
    pub photon_j: f64,
    /// Albedo about which the clouds vary.
    pub mean_albedo: f64,
    /// Contrast of clouds, land and sea, from 0 (the mean albedo everywhere) to 1 (0.05 to 0.85).
    pub cloud_contrast: f64,
    /// How bright a surface is, by how it is lit and seen.
    pub surface: photometry::Photometry,
    /// Where that is mixed: share of the brightness after Lommel and Seeliger, the rest is Lambert's.
    pub lommel_seeliger: f64,
    /// Share of the mean albedo at the limb, where haze hides clouds, land and sea.
    pub limb_haze: f64,
    /// Height over which the air loses a factor e of its density, km.
    pub scale_height_km: f64,
    /// Height over which clouds at the limb lose a factor e of their cover, km.
    pub cloud_top_km: f64,
    /// Vertical optical depth of dust that is mixed with the air; 0: the air is the Earth's, molecules and
    /// haze.
    pub dust_depth: f64,
    /// Brightness of thick air at the limb over that of the surface below.
    pub air_brightness: f64,
    /// What makes the limb stand higher here than there.
    pub horizon: horizon::Family,
    /// Standard deviation of the limb's height over thousands of km, km; half of it comes on top over
    /// hundreds. 0: nothing that a seed makes.
    pub height_variation_km: f64,
    /// Whether the limb stands higher over the tropics and the summer half.
    pub season: bool,
    /// Whether the night sky's layer at 90 km shines.
    pub airglow: bool,
    /// Height at which the atmosphere ends, km.
    pub atmosphere_top_km: f64,
    /// Depth of the Sun below the horizon at which the last light goes, degrees.
    pub twilight_deg: f64,
    /// Whether the satellite's own velocity shifts the Earth's image by v/c (5 arcsec in a low orbit), as in
    /// nature.
    pub aberration: bool,
}

impl Default for EarthModel {
    fn default() -> Self {
        Self {
            body: CentralBody::Earth,
            irradiance_w_m2: 500.0,
            aperture_m: 0.010,
            mirror_transmission: 0.09,
            filter_transmission: 1.0 / 4000.0,
            quantum_efficiency: 0.5,
            fill_factor: 0.7,
            photon_j: 2.84e-19,
            mean_albedo: 0.3,
            cloud_contrast: 1.0,
            surface: photometry::Photometry::Mixed,
            lommel_seeliger: 0.4,
            limb_haze: 0.7,
            scale_height_km: 8.0,
            cloud_top_km: 3.0,
            dust_depth: 0.0,
            air_brightness: 0.45,
            horizon: horizon::Family::Noise,
            height_variation_km: 1.5,
            season: true,
            airglow: true,
            atmosphere_top_km: 100.0,
            twilight_deg: 5.0,
            aberration: true,
        }
    }
}

impl EarthModel {
    /// The looks of a body. Albedo varies by the Earth's noise, whose contrast is less.
    ///
    /// Moon: no air; the ground's albedo 0.12 after Lommel and Seeliger, darkness where the whole disc of the
    /// Sun has set. Its terrain is noise of cells of 755 km and, half as much, of 180 and 90 km, together 2.0
    /// km: the deviation of LOLA's heights from 1737.4 km is about that (Smith et al. 2010, Geophys. Res.
    /// Lett. 37, L18204; -9.1 to 10.8 km).
    ///
    /// Mars: dust of a vertical optical depth of 0.5 (Lemmon et al. 2015, Icarus 251, 96: 0.3 to 1 but in
    /// storms), mixed with air of a scale height of 11 km, bright at the limb as haze. Along the limb it is
    /// thick to 34 km, half bright at 31 km; Viking's pictures show haze above 35 km (NASA SP-441, ch. 12)
    /// and Jaquin, Gierasch and Kahn (1986, Icarus 68, 442) find its top between 20 and 50 km by season and
    /// place: here noise of 4.0 km in cells of 1480 km and half as much in smaller ones.
    pub fn of(body: CentralBody) -> Self {
        let airless = Self {
            body,
            surface: photometry::Photometry::Mixed,
            season: false,
            airglow: false,
            cloud_top_km: 0.1,
            ..Self::default()
        };
        match body {
            CentralBody::Earth => Self::default(),
            CentralBody::Moon => Self {
                mean_albedo: 0.12,
                cloud_contrast: 0.1,
                lommel_seeliger: 1.0,
                limb_haze: 0.0,
                air_brightness: 0.0,
                height_variation_km: 1.8,
                atmosphere_top_km: 0.0,
                twilight_deg: 0.27,
                ..airless
            },
            CentralBody::Mars => Self {
                // At 1.52 au.
                irradiance_w_m2: 215.0,
                mean_albedo: 0.25,
                cloud_contrast: 0.25,
                scale_height_km: 11.0,
                dust_depth: 0.5,
                air_brightness: 0.8,
                height_variation_km: 4.0,
                atmosphere_top_km: 80.0,
                ..airless
            },
        }
    }

    /// The same behind another partial mirror, with a grey filter by which the Earth is as bright.
    pub fn behind(self, mirror_transmission: f64) -> Self {
        let filter_transmission = self.filter_transmission * self.mirror_transmission / mirror_transmission;
        Self { mirror_transmission, filter_transmission, ..self }
    }

    /// Electrons a second that all the light entering the aperture would free, were none lost before the
    /// detector.
    pub fn aperture_e_s(&self) -> f64 {
        let area_m2 = 0.25 * PI * self.aperture_m * self.aperture_m;
        self.irradiance_w_m2 * area_m2 / self.photon_j * self.quantum_efficiency * self.fill_factor
    }

    /// Electrons a second of a pixel that sees a white Lambert surface with the Sun in the zenith.
    pub fn white_e_s(&self, focal_length_px: f64) -> f64 {
        self.aperture_e_s() * self.mirror_transmission * self.filter_transmission
            / (PI * focal_length_px * focal_length_px)
    }

    /// Whether all values make physical sense.
    pub fn is_sound(&self) -> bool {
        let shares = [
            self.mirror_transmission,
            self.filter_transmission,
            self.quantum_efficiency,
            self.fill_factor,
            self.mean_albedo,
            self.cloud_contrast,
            self.lommel_seeliger,
            self.limb_haze,
            self.air_brightness,
        ];
        shares.iter().all(|share| (0.0..=1.0).contains(share))
            && (0.0..=1e6).contains(&self.irradiance_w_m2)
            && (1e-4..=10.0).contains(&self.aperture_m)
            && (1e-21..=1e-15).contains(&self.photon_j)
            && (1.0..=50.0).contains(&self.scale_height_km)
            && (0.1..=20.0).contains(&self.cloud_top_km)
            && (0.0..=10.0).contains(&self.dust_depth)
            && (0.0..=10.0).contains(&self.height_variation_km)
            && (0.0..=100.0).contains(&self.atmosphere_top_km)
            && (0.1..=30.0).contains(&self.twilight_deg)
    }
}
