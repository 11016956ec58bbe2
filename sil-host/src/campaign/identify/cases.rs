//! The cases of the identification campaign: kinds of fields, how they are made, and what the peers reach on
//! them.
//!
//! In: a case, a seed, a number. Out: a field with its truth; it depends on these alone. Fields of one number
//! show the same sky with the same noise, scaled, in all cases of a seed, so that rows of the table compare
//! like with like.
//!
//! Fields are those of [`FieldGenerator`]: 15 deg square on 1024 x 1024 px (52.7 arcsec a pixel), all stars
//! to V = 6.

use crate::error::HostError;
use crate::formats::camera_file::{CameraFile, Distortion};
use crate::world::attitude;
use crate::world::fields::{Field, FieldGenerator, FieldSettings, FieldStar};
use crate::world::lens::optics::Optics;
use crate::world::noise::{Noise, Stream};
use crate::world::scene::WorldStar;
use fsw_core::stars::identify::IdentificationParameters;

/// Sides of the detector, px.
pub const SIDE_PX: u16 = 1024;
/// Width of the field, degrees.
pub const FIELD_DEG: f64 = 15.0;
/// Faintest magnitude.
pub const LIMIT_V: f64 = 6.0;
/// Centroid noise of the grid, px per axis.
pub const GRID_NOISE_PX: [f64; 4] = [0.3, 0.5, 1.0, 2.0];
/// False stars of the grid.
pub const GRID_FALSE: [u32; 5] = [0, 5, 10, 20, 40];
/// What is mixed in the random skies, one combination a sky.
const MIXED_NOISE_PX: [f64; 3] = [0.3, 0.5, 1.0];
const MIXED_FALSE: [u32; 3] = [0, 5, 10];
/// Noise whose separations are off by 240 arcsec at three sigmas: 240 / (3 sqrt 2) arcsec.
const NOISE_240_ARCSEC_PX: f64 = 1.073;
/// Distortion that moves the corners by 240 arcsec against the middle; the solver does not know it.
const UNTOLD_K1: f64 = 0.18;
/// Edge stars stand within this share of the side from the edge.
const EDGE_SHARE: f64 = 0.125;
/// Companions stand so far from their stars, px.
const COMPANION_PX: [f64; 2] = [1.5, 6.0];
/// Makes false stars fainter than every star.
const CLOUD_DIMMING: f64 = 1e-3;
/// Brighter than every star.
const PLANET_BRIGHTNESS: f64 = 30.0;

/// What is done to the fields of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// Nothing.
    None,
    /// Noise and false stars change from sky to sky.
    Mixed,
    /// So many of the brightest stars remain.
    Brightest(usize),
    /// Every second star, by lot, is missing.
    Half,
    /// Only stars near the edges remain.
    Edge,
    /// Every third star, by lot, has a companion that is in no catalogue.
    Companions,
    /// So many of the brightest stars remain, the false stars are fainter than they, and brightness is given:
    /// few stars before what clouds leave.
    BeforeClouds(usize),
    /// So many planets outshine all stars, and brightness is given.
    Planets(u32),
    /// The lens has a distortion that the solver does not know.
    UntoldLens,
    /// There are no stars at all.
    NoStars,
}

impl Change {
    fn gives_brightness(self) -> bool {
        matches!(self, Self::Planets(_) | Self::BeforeClouds(_))
    }
}

/// What the peers reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Peers {
    /// Measured: share of fields, %.
    Measured(f64),
    /// Not measured there; no more than this, which they reach with less noise or fewer false stars, %.
    AtMost(f64),
    /// Nothing is known.
    Unknown,
}

/// A kind of fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Its name, also in the file.
    pub name: String,
    /// Centroid noise, px per axis.
    pub noise_px: f64,
    /// False stars.
    pub false_stars: u32,
    /// What else is done.
    pub change: Change,
    /// The best of the peers.
    pub peers: Peers,
    /// The user's criterion: largest false-identification probability, and the centroid errors to assume.
    pub criterion: IdentificationParameters,
}

impl Case {
    fn new(name: &str, noise_px: f64, false_stars: u32, change: Change) -> Self {
        let criterion = IdentificationParameters::default();
        Self { name: name.to_string(), noise_px, false_stars, change, peers: Peers::Unknown, criterion }
    }

    /// With the criterion of a user who takes few stars for their stated probability: centroids as good as
    /// the sensor's, and one answer in ten may be wrong.
    fn for_few_stars(self) -> Self {
        let criterion = IdentificationParameters {
            centroid_sigma_px: [0.12, 0.35, 1.0],
            log10_false_limit: -1.0,
            ..self.criterion
        };
        Self { criterion, ..self }
    }

    /// Whether the criterion is that of flight, by which nothing may be wrong.
    pub fn as_in_flight(&self) -> bool {
        self.criterion == IdentificationParameters::default()
    }
}

/// Share of identified fields of an open solver, %, measured on one host with such fields, 500 a setting
/// (ALGORITHMS 2.1); none where it was not measured.
struct Peer {
    /// By the noise of the grid, without false stars.
    by_noise: [Option<f64>; 4],
    /// By the false stars of the grid, with 0.3 px noise.
    by_false: [Option<f64>; 5],
}

/// cedar-solve and tetra3rs.
const PEERS: [Peer; 2] = [
    Peer {
        by_noise: [Some(100.0), None, Some(100.0), Some(94.5)],
        by_false: [Some(100.0), None, None, Some(99.5), Some(98.0)],
    },
    Peer {
        by_noise: [Some(100.0), None, Some(84.0), Some(24.0)],
        by_false: [Some(100.0), None, None, Some(100.0), Some(98.0)],
    },
];

/// The best of the peers in a cell. Where none was measured: more noise or more false stars help nobody, so a
/// peer reaches no more than its least in a cell with less of either.
fn peers(noise: usize, false_stars: usize) -> Peers {
    let best = |shares: &[Option<f64>]| shares.iter().flatten().copied().reduce(f64::max);
    let measured = match (noise, false_stars) {
        (_, 0) => best(&PEERS.map(|peer| peer.by_noise[noise])),
        (0, _) => best(&PEERS.map(|peer| peer.by_false[false_stars])),
        _ => None,
    };
    let at_most = |peer: Peer| {
        let easier = peer.by_noise[..=noise].iter().chain(&peer.by_false[..=false_stars]).flatten();
        Some(easier.fold(100.0, |least: f64, share| least.min(*share)))
    };
    match measured {
        Some(share) => Peers::Measured(share),
        None => best(&PEERS.map(at_most)).map_or(Peers::Unknown, Peers::AtMost),
    }
}

/// The robustness grid, row by row.
pub fn grid() -> Vec<Case> {
    let rows = GRID_NOISE_PX.into_iter().enumerate();
    let cell = |(n, noise_px): (usize, f64)| {
        GRID_FALSE.into_iter().enumerate().map(move |(f, false_stars)| {
            let name = format!("{noise_px} px, {false_stars} false");
            Case { peers: peers(n, f), ..Case::new(&name, noise_px, false_stars, Change::None) }
        })
    };
    rows.flat_map(cell).collect()
}

/// The hard cases, one a row.
pub fn hard() -> Vec<Case> {
    vec![
        Case::new("3 stars, up to 10 % false", 0.1, 0, Change::Brightest(3)).for_few_stars(),
        Case::new("4 stars, up to 10 % false", 0.1, 0, Change::Brightest(4)).for_few_stars(),
        Case::new("4 brightest stars", 0.1, 0, Change::Brightest(4)),
        Case::new("5 brightest stars", 0.3, 0, Change::Brightest(5)),
        Case::new("7 stars before 45 of clouds", 0.3, 45, Change::BeforeClouds(7)),
        Case::new("240 arcsec", NOISE_240_ARCSEC_PX, 5, Change::None),
        Case::new("untold lens, 240 arcsec", 0.3, 5, Change::UntoldLens),
        Case::new("close pairs", 0.3, 0, Change::Companions),
        Case::new("edge stars", 0.3, 5, Change::Edge),
        Case::new("half of the stars missing", 0.3, 5, Change::Half),
        Case::new("5 planets", 0.3, 5, Change::Planets(5)),
    ]
}

/// The random skies.
pub fn skies() -> Case {
    Case::new("random skies", 0.0, 0, Change::Mixed)
}

/// Fields without any star; whatever is identified there is wrong.
pub fn no_stars() -> Case {
    Case::new("no stars", 0.3, 20, Change::NoStars)
}

/// The camera that the solver is given.
///
/// # Errors
/// Never for this field.
pub fn camera() -> Result<CameraFile, HostError> {
    CameraFile::from_fov(SIDE_PX, SIDE_PX, 10, FIELD_DEG)
}

/// Makes the fields of a case.
#[derive(Clone, Debug)]
pub struct Maker<'a> {
    change: Change,
    criterion: IdentificationParameters,
    seed: u64,
    sky: &'a [WorldStar],
    optics: Optics,
    /// One for every combination of noise and false stars.
    generators: Vec<FieldGenerator<'a>>,
}

impl<'a> Maker<'a> {
    /// For the fields of `case` under `sky`.
    ///
    /// # Errors
    /// Never for these cameras.
    pub fn new(case: &Case, seed: u64, sky: &'a [WorldStar]) -> Result<Self, HostError> {
        let mut camera = camera()?;
        if case.change == Change::UntoldLens {
            camera.distortion = Distortion { k1: UNTOLD_K1, ..Distortion::default() };
        }
        let settings = |noise_px, false_stars| FieldSettings {
            camera: camera.clone(),
            limit_v: if case.change == Change::NoStars { f64::NEG_INFINITY } else { LIMIT_V },
            noise_px,
            false_stars,
            brightness: case.change.gives_brightness(),
            seed,
        };
        let combinations: Vec<_> = match case.change {
            Change::Mixed => {
                MIXED_NOISE_PX.into_iter().flat_map(|n| MIXED_FALSE.map(|f| settings(n, f))).collect()
            }
            _ => vec![settings(case.noise_px, case.false_stars)],
        };
        let refuse = || HostError::usage("the camera of the campaign is not rectilinear", "report this");
        let generators = combinations.into_iter().map(|settings| FieldGenerator::new(settings, sky));
        let generators = generators.collect::<Option<_>>().ok_or_else(refuse)?;
        let optics = Optics::new(&camera).ok_or_else(refuse)?;
        Ok(Self { change: case.change, criterion: case.criterion, seed, sky, optics, generators })
    }

    /// Whether the centroids carry their brightness.
    pub fn with_brightness(&self) -> bool {
        self.change.gives_brightness()
    }

    /// The user's criterion.
    pub fn criterion(&self) -> &IdentificationParameters {
        &self.criterion
    }

    /// Where the star `hip` truly is imaged in a field, px.
    pub fn place(&self, field: &Field, hip: u32) -> Option<[f64; 2]> {
        let star = self.sky.iter().find(|star| star.hip == hip)?;
        self.optics.project(attitude::apply(&attitude::matrix(field.quaternion), star.direction))
    }

    /// Field number `index`.
    pub fn field(&self, index: u64) -> Field {
        let generator = &self.generators[(index % self.generators.len() as u64) as usize];
        let mut field = generator.field(index);
        let lot = Noise::new(self.seed, index, Stream::FalseStar).part(1);
        change(self.change, &mut field.stars, &lot);
        field
    }
}

/// Keeps so many of the true stars.
fn keep_brightest(count: usize, stars: &mut Vec<FieldStar>) {
    let mut brightness: Vec<f64> =
        stars.iter().filter(|star| star.hip.is_some()).map(|star| star.brightness).collect();
    brightness.sort_by(|a, b| b.total_cmp(a));
    if let Some(limit) = brightness.get(count) {
        stars.retain(|star| star.hip.is_none() || star.brightness > *limit);
    }
}

/// Changes the stars of a field.
fn change(change: Change, stars: &mut Vec<FieldStar>, lot: &Noise) {
    let chosen =
        |star: &FieldStar, one_in: f64| star.hip.is_some_and(|hip| lot.uniform(hip, 0) * one_in < 1.0);
    match change {
        Change::None | Change::Mixed | Change::UntoldLens | Change::NoStars => {}
        Change::Brightest(count) => keep_brightest(count, stars),
        Change::BeforeClouds(count) => {
            keep_brightest(count, stars);
            let clouds = stars.iter_mut().filter(|star| star.hip.is_none());
            clouds.for_each(|cloud| cloud.brightness *= CLOUD_DIMMING);
        }
        Change::Half => stars.retain(|star| !chosen(star, 2.0)),
        Change::Edge => {
            let side = f64::from(SIDE_PX);
            let outside = |place: f64| !(EDGE_SHARE * side..(1.0 - EDGE_SHARE) * side).contains(&place);
            stars.retain(|star| star.hip.is_none() || star.pixel.into_iter().any(outside));
        }
        Change::Companions => {
            let companion = |star: &FieldStar| {
                let hip = star.hip?;
                let [nearest, farthest] = COMPANION_PX;
                let apart = nearest + (farthest - nearest) * lot.uniform(hip, 1);
                let (sine, cosine) = libm::sincos(std::f64::consts::TAU * lot.uniform(hip, 2));
                let pixel = [star.pixel[0] + apart * cosine, star.pixel[1] + apart * sine];
                Some(FieldStar { pixel, brightness: star.brightness, hip: None })
            };
            let companions: Vec<_> =
                stars.iter().filter(|star| chosen(star, 3.0)).filter_map(companion).collect();
            stars.extend(companions);
        }
        Change::Planets(count) => {
            let planet = |index| FieldStar {
                pixel: [1, 2].map(|axis| f64::from(SIDE_PX) * lot.uniform(index, axis) - 0.5),
                brightness: PLANET_BRIGHTNESS,
                hip: None,
            };
            stars.extend((0..count).map(planet));
        }
    }
}

#[cfg(test)]
mod tests;
