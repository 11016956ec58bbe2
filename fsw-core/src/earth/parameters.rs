//! Parameters of the Earth, its limb and limb points: a checked group for every step.

use super::{EarthFix, FitCriteria, Strips};
use fsw_ground::table::parameter_group;
use serde::{Deserialize, Serialize};

parameter_group! {
    /// An ellipsoid of revolution. Its axes are at most 20 % apart.
    pub struct Ellipsoid in "earth.ellipsoid" {
        /// Half axis on the equator.
        equatorial_km: f32 = 6378.137, 100.0..=100_000.0, "km", "World Geodetic System 1984";
        /// Half axis to the pole.
        polar_km: f32 = 6356.752, 80.0..=120_000.0, "km", "World Geodetic System 1984";
    }
}

parameter_group! {
    /// The air and the surface at the limb, and the lens through which they are seen.
    pub struct LimbParameters in "earth.limb" {
        /// Height above the ellipsoid at which the limb is half bright.
        height_km: f32 = 5.15, 0.0..=60.0, "km",
            "rendered limbs of seeds 1 to 10; 3 to 6 km, by wavelength and season (thesis 4.2)";
        /// Standard deviation of that height: season, wavelength, and that a limb narrower than a pixel seems
        /// 2 km higher than a wide one.
        height_sigma_km: f32 = 1.4, 0.0..=20.0, "km",
            "fitted to `campaign earth`, seeds 1 and 2; judged on others";
        /// Height over which the brightness above the surface falls to 1/e.
        scale_height_km: f32 = 8.0, 0.5..=50.0, "km", "thesis eq. 4.1; scale height of the air's density";
        /// Scatter of the limb's height from one limb point to the next.
        scatter_km: f32 = 0.6, 0.0..=10.0, "km",
            "fitted to `campaign earth`, seeds 1 and 2; judged on others";
        /// Difference of brightness between the limb and the bright side just inside that is not known, share
        /// of it: clouds.
        cloud_share: f32 = 0.1, 0.0..=1.0, "", "fitted to `campaign earth`, seeds 1 and 2; judged on others";
        /// Share by which the limb's own ground is nearer to the usual than the ground just inside, where it
        /// is brighter or darker.
        ground_share: f32 = 0.25, 0.0..=1.0, "",
            "0.21 to 0.33 in rendered flights of seeds 1 to 4 from 450 km, 798 km and GEO; judged on others";
        /// Share of the surface's brightness that follows the law of Lommel and Seeliger, the rest Lambert's.
        lommel_share: f32 = 0.5, 0.0..=1.0, "",
            "half way between the two laws: cloud tops follow the one, bare ground the other";
        /// Standard deviation of the point spread.
        psf_sigma_px: f32 = 0.9, 0.2..=5.0, "px", "thesis 3.1: spots of 3 px across";
    }
}

parameter_group! {
    /// Elevation of the Sun.
    pub struct LightParameters in "earth.light" {
        /// Elevation of the Sun above which a limb counts as lit: below it the mode is eclipse.
        lit_deg: f32 = 3.0, 0.0..=45.0, "deg",
            "a degree below `usable_deg`: where a limb can be measured it counts as lit";
        /// Least elevation of the Sun at a limb point. Lower, the slant of the light moves the place of half
        /// brightness. At the terminator every degree makes the arc longer.
        usable_deg: f32 = 4.0, 0.0..=45.0, "deg",
            "with 8 deg the Earth is never found from a dawn-dusk orbit";
        /// How far below the horizon the Sun still lights the air so that stars are not seen.
        twilight_deg: f32 = 6.0, 0.0..=18.0, "deg", "civil twilight: the brightest stars come out";
    }
}

parameter_group! {
    /// Limb points in strips across an expected limb.
    pub struct StripParameters in "earth.strips" {
        /// Least rise of brightness across the limb, share of full scale.
        contrast_share: f32 = 0.01, 0.005..=0.5, "",
            "10 counts of 10 bits, 45 sigma of a joined dark line (20 e- at 39 e- a count and rounding, \
             0.6; seven lines, 0.22); thesis 12 %, which misses a limb in low light";
        /// Brightest dark side of a limb point, share of full scale; in a search too.
        dark_share: f32 = 0.12, 0.01..=0.5, "", "thesis 3.2.1: 11 %";
        /// Brightness that counts as saturated, share of full scale.
        saturated_share: f32 = 0.95, 0.5..=1.0, "",
            "5 % clipped off the bright side move the limb by 5 % of a scale height, 0.4 km: less than \
             `scatter_km`";
        /// Least standard deviation of a limb point.
        floor_px: f32 = 0.05, 0.005..=2.0, "px",
            "vignetting, which is not taken off, moves a limb by up to 0.05 px (`limb/tests.rs`)";
        /// Farthest that an inlier may lie from the limb, besides four times its scatter.
        tolerance_px: f32 = 2.0, 0.2..=20.0, "px", "half of the thesis's 4 px: a strip joins nine lines";
        /// Least share of the strips read that must hold an inlier. Where they lie across the limb most do; a
        /// few that agree by chance give a centre that is wrong by many sigmas.
        inlier_share: f32 = 0.5, 0.2..=1.0, "", "thesis 3.2.1";
    }
}

parameter_group! {
    /// Limb points anywhere on the detector.
    pub struct SearchParameters in "earth.search" {
        /// Distance between the rows and columns that are read.
        step_px: u16 = 16, 4..=64, "px",
            "thesis 10; with 16 a search costs 40 % less and reaches as many points as the list holds";
        /// Least rise of brightness, share of full scale; in noise more.
        contrast_share: f32 = 0.02, 0.01..=0.5, "", "thesis 12 %, which misses a limb in low light";
        /// Brightest dark side above the darkest sky, share of full scale.
        dark_share: f32 = 0.06, 0.01..=0.5, "", "thesis 3.2.1: 6 %";
        /// Least length of the bright side.
        run_px: u16 = 12, 4..=64, "px",
            "three of the search's blocks of 4 px; a star is 3 to 5 px across (thesis 3.1)";
        /// Greatest length of the rise: a terminator is longer.
        rise_px: u16 = 64, 4..=250, "px",
            "from 400 km a scale height is 10 px of the reference camera: 42 px from 2 % to all of the \
             brightness; a terminator rises over more";
        /// Least standard deviation of a limb point: clouds move neighbours alike.
        floor_px: f32 = 1.5, 0.01..=5.0, "px",
            "searches of rendered Earths: normalised squares of the centre's error near 3";
        /// Farthest that an inlier may lie from the limb.
        tolerance_px: f32 = 4.0, 0.2..=20.0, "px", "thesis 3.2.1";
        /// Least share of inliers of the best hypothesis.
        inlier_share: f32 = 0.3, 0.2..=1.0, "",
            "thesis 3.2.1: 0.5; with faint limbs a terminator gives as many points as the limb";
    }
}

parameter_group! {
    /// Consensus and fit of the centre.
    pub struct FitParameters in "earth.fit" {
        /// Share of inliers at which a hypothesis is taken at once.
        enough_share: f32 = 0.95, 0.5..=1.0, "", "thesis 3.2.1";
        /// Fewest inliers.
        fewest_points: u16 = 6, 4..=40, "", "twice what fixes a centre";
        /// Shortest arc.
        least_arc_deg: f32 = 10.0, 1.0..=180.0, "deg",
            "from GEO (disc radius 459 px) its sagitta is 1.7 px: less than the 2 px that an inlier may be \
             off";
    }
}

parameter_group! {
    /// Height errors that neighbouring limb points share.
    pub struct HorizonParameters in "earth.horizon" {
        /// Standard deviation of the height: clouds and air masses.
        sigma_km: f32 = 1.8, 0.0..=20.0, "km",
            "fitted to `campaign earth` of the seeds 1 and 2, judged on others";
        /// Distance over which it is shared.
        cell_km: f32 = 400.0, 50.0..=10_000.0, "km",
            "fitted to `campaign earth` of the seeds 1 and 2, judged on others";
        /// Standard deviation of the place on the detector: clouds in a limb no wider than a pixel; in a
        /// wider one the less the wider it is.
        sigma_px: f32 = 0.48, 0.0..=5.0, "px",
            "fitted to `campaign earth` of the seeds 1 and 2, judged on others";
        /// Distance over which it is shared.
        cloud_cell_km: f32 = 300.0, 50.0..=10_000.0, "km",
            "fitted to `campaign earth` of the seeds 1 and 2, judged on others";
        /// Standard deviation of mean and first wave where the Sun is not known.
        sunless_px: f32 = 0.8, 0.0..=5.0, "px",
            "fitted to `campaign earth` solved without the Sun, seeds 1 and 2";
    }
}

parameter_group! {
    /// Limits of a centre, most of them of one without an orbit as its prior.
    pub struct PlausibleParameters in "earth.plausible" {
        /// Greatest standard deviation of the direction.
        sigma_deg: f32 = 10.0, 0.001..=10.0, "deg",
            "half of the reference field's shorter side, 19.4 deg: known worse, a centre is no more than an \
             Earth in the field";
        /// Greatest standard deviation of a direction that is told, with an orbit too; a first orbit is begun
        /// with worse ones, which it holds against each other.
        told_deg: f32 = 2.0, 0.001..=10.0, "deg",
            "clouds and low sunlight bend a short arc by more than its heights do: of 1,282 centres known worse \
             from low orbits one in 40 was off by more than 3 sigma, up to 9.6 (low-motion, seed 51); with an \
             orbit up to 7.7, of those known better up to 3.7 (sso-dawn-dusk, seed 8301)";
        /// Fewest points of a centre that is told without an orbit, of 24 strips.
        told_points: u16 = 20, 3..=24, "",
            "of 3,602 centres with so many eight were off by more than 3 sigma, 4.7 at worst; of 78 with fewer \
             eleven, up to 8.5 (the same)";
        /// Greatest standard deviation of the distance, share of it.
        range_share: f32 = 0.5, 0.001..=1.0, "",
            "in GEO 3.3 Earth radii; the orbit filter converges from up to three (`Observation::UnitVector`)";
        /// Farthest that the body can be: a lit cloud in the night side is a small crescent.
        distance_km: f32 = 100_000.0, 10_000.0..=1e9, "km",
            "twice the geostationary radius; a lit cloud in the night side was taken for a crescent at \
             549,000 km";
    }
}

impl PlausibleParameters {
    /// Whether a centre is told; `alone`: that no orbit supports.
    pub fn is_told(&self, fix: &EarthFix, alone: bool) -> bool {
        let enough = !alone || fix.inliers.count_ones() >= self.told_points.into();
        enough && fix.sigmas().0 <= self.told_deg.to_radians()
    }
}

/// Parameters of the Earth, its limb and limb points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EarthParameters {
    /// The body.
    pub ellipsoid: Ellipsoid,
    /// Its limb.
    pub limb: LimbParameters,
    /// Its light.
    pub light: LightParameters,
    /// Strips.
    pub strips: StripParameters,
    /// The search.
    pub search: SearchParameters,
    /// Consensus and fit.
    pub fit: FitParameters,
    /// Shared heights.
    pub horizon: HorizonParameters,
    /// Plausibility.
    pub plausible: PlausibleParameters,
}

/// Tolerance in units of [`LimbParameters::scatter_km`]: one good point in 16,000 is lost.
const TOLERATED_SCATTERS: f32 = 4.0;
/// Least and greatest polar over equatorial half axis.
const AXES_SHARE: [f32; 2] = [0.8, 1.2];

impl EarthParameters {
    /// The name of the first value that is outside its range or not finite.
    pub fn first_out_of_range(&self) -> Option<&'static str> {
        let Ellipsoid { equatorial_km, polar_km } = self.ellipsoid;
        let [least, greatest] = AXES_SHARE.map(|share| share * equatorial_km);
        let groups = [
            self.ellipsoid.first_out_of_range(),
            (!(least..=greatest).contains(&polar_km)).then_some("earth.ellipsoid.polar_km"),
            self.limb.first_out_of_range(),
            self.light.first_out_of_range(),
            self.strips.first_out_of_range(),
            self.search.first_out_of_range(),
            self.fit.first_out_of_range(),
            self.horizon.first_out_of_range(),
            self.plausible.first_out_of_range(),
        ];
        groups.into_iter().flatten().next()
    }

    /// Criteria of a search that found this many points.
    pub fn search_criteria(&self, points: usize) -> FitCriteria {
        let min_inliers = self.fewest(self.search.inlier_share, points);
        FitCriteria { tolerance_px: self.search.tolerance_px, min_inliers, standalone: true }
    }

    /// Criteria of these strips; `alone`: without an orbit as prior. The tolerance includes four times the
    /// limb's scatter.
    pub fn strip_criteria(&self, strips: &Strips, alone: bool) -> FitCriteria {
        let min_inliers = self.fewest(self.strips.inlier_share, strips.read);
        let tolerance_px = self.strips.tolerance_px;
        let scatter_px = TOLERATED_SCATTERS * self.limb.scatter_km / strips.km_per_px.max(1e-3);
        let tolerance_px = libm::sqrtf(tolerance_px * tolerance_px + scatter_px * scatter_px);
        FitCriteria { tolerance_px, min_inliers, standalone: alone }
    }

    /// Reduction of the shift by clouds for a limb wider than a pixel: `sqrt(1 + (scale height in px)²)`.
    pub fn clouds_reduction(&self, km_per_px: f32) -> f32 {
        let wide = self.limb.scale_height_km / km_per_px.max(1e-3);
        libm::sqrtf(1.0 + wide * wide)
    }

    fn fewest(&self, share: f32, count: usize) -> usize {
        let inliers = libm::ceilf(share * count as f32) as usize;
        inliers.max(self.fit.fewest_points.into()).max(3)
    }
}
