//! The drawn Earth beside real pictures from the geostationary orbit: their figures should not distinguish
//! them.
//!
//! Both are laid on the same grid of scan angles, disc on disc. Land, sea and clouds of the world are
//! invented, so nothing is compared point by point: only how the brightness is spread, how it falls towards
//! the limb, and how it changes with distance.

use fsw_core::orbit::body::CentralBody;
use fsw_hal::Window;
use sil_host::formats::camera_file::CameraFile;
use sil_host::formats::picture::Picture;
use sil_host::world::earth::EarthModel;
use sil_host::world::earth::image::CellBuffer;
use sil_host::world::lens::optics::Optics;
use sil_host::world::motion::pointing::{Mount, Pointing};
use sil_host::world::motion::trajectory::{Look, Trajectory};
use sil_host::world::orbit::{TruthOrbit, state_of_elements};
use std::path::PathBuf;
use system_tests::data;

/// Points of the grid along a side, and how far it reaches in radii of the disc.
const SIDE: usize = 480;
const REACH: f64 = 1.05;
/// Half angle of the disc from the geostationary orbit, rad, east-west and north-south.
const DISC_RAD: [f64; 2] = [0.151_852_1, 0.151_350_7];
/// Brightest grey of a written picture.
const WHITE: f64 = 250.0;

/// Runs whose Earths are drawn; what is compared is their mean.
const SEEDS: [u64; 4] = [1, 2, 3, 4];
/// Allowed differences: of a quartile in parts of the 99th percentile, and of a ring in parts of the mean. A
/// real disc's own weather moves a ring by some 0.2 from one hour to another, as the pictures here show; four
/// invented ones have half of that left.
const QUARTILES: f64 = 0.2;
const RINGS: f64 = 0.35;
/// Allowed ratio of the structure function.
const STRUCTURE: f64 = 2.0;

/// Quartiles, rings and structure of a disc.
type Figures = ([f64; 3], [f64; 4], [f64; 5]);

/// Brightness on the grid, north up.
struct Disc(Vec<f64>);

impl Disc {
    /// From a function of the scan angles in radii of the disc, east and north.
    fn new(at: impl Fn(f64, f64) -> f64) -> Self {
        let angle = |k: usize| REACH * (2.0 * k as f64 / (SIDE - 1) as f64 - 1.0);
        Self((0..SIDE * SIDE).map(|k| at(angle(k % SIDE), -angle(k / SIDE))).collect())
    }

    /// A real picture whose disc has the `centre` and the half axes `radii`, px.
    fn real(file: &str, centre: [f64; 2], radii: [f64; 2]) -> Option<Self> {
        let picture = Picture::load(&data(file)?).unwrap();
        let width = fsw_hal::Detector::geometry(&picture).width_px as usize;
        let pixels: Vec<f64> = picture.pixels().iter().map(|p| f64::from(*p)).collect();
        Some(Self::new(|east, north| {
            bilinear(&pixels, width, [centre[0] + radii[0] * east, centre[1] - radii[1] * north])
        }))
    }

    /// The world's Earth under a Sun that stands `hour_angle_deg` west of the satellite's meridian.
    fn drawn(seed: u64, hour_angle_deg: f64) -> Self {
        // 2026-08-21T12:00 UTC, the day of the year of the pictures; the Sun's right ascension is then 150.5
        // deg.
        const START_US: i64 = 840_585_669_184_000;
        let (r, v) =
            state_of_elements(CentralBody::Earth, [42_164.17, 0.0, 0.0, 0.0, 0.0, 150.5 + hour_angle_deg])
                .unwrap();
        let trajectory = Trajectory {
            orbit: TruthOrbit::new(START_US, r, v, 60).unwrap(),
            // x along flight, east; y south.
            pointing: Pointing::default(),
            mount: Mount { star_path_deg: [0.0, 90.0, 0.0] },
            earth: EarthModel::default(),
        };
        let camera = CameraFile::reference();
        let optics = Optics::new(&camera).unwrap();
        let truth = trajectory.truth(0.0, &optics);
        let look = Look { seed, psf_sigma_px: 0.9, exposure_s: 0.4, row_time_s: 0.0, transmission: 1.0 };
        let image = trajectory.earth_image(&truth, &optics, &look);
        let (width, height) = (1280, 1024);
        let mut electrons = vec![0.0; usize::from(width) * usize::from(height)];
        let mut cell_buffer = CellBuffer::EMPTY;
        image.add_to(Window { x: 0, y: 0, width, height }, &mut electrons, &mut cell_buffer);
        let path = optics.earth_path();
        Self::new(|east, north| {
            // Scan angles: about the north axis, then about the turned one.
            let (x, y) = (east * DISC_RAD[0], -north * DISC_RAD[1]);
            let pixel = path.project([x.sin() * y.cos(), y.sin(), x.cos() * y.cos()]).unwrap();
            bilinear(&electrons, usize::from(width), pixel)
        })
    }

    /// Brightness of the points nearer to the centre than `reach` radii and farther than `from`, on the lit
    /// side of `east` radii.
    fn within(&self, from: f64, reach: f64, east: f64) -> Vec<f64> {
        let at = Self::new(|x, y| if x < east { f64::NAN } else { x.hypot(y) });
        let inside = |(_, r): &(&f64, &f64)| (from..reach).contains(*r);
        self.0.iter().zip(&at.0).filter(inside).map(|(v, _)| *v).collect()
    }

    /// The 25th, 50th and 75th percentile over the 99th, within 0.85 radii.
    fn quartiles(&self, east: f64) -> [f64; 3] {
        let mut values = self.within(0.0, 0.85, east);
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[(share * (values.len() - 1) as f64) as usize];
        [0.25, 0.5, 0.75].map(|share| at(share) / at(0.99))
    }

    /// Mean brightness of four rings over that of all within 0.95 radii.
    fn rings(&self, east: f64) -> [f64; 4] {
        let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
        let all = mean(self.within(0.0, 0.95, east));
        [(0.0, 0.4), (0.4, 0.65), (0.65, 0.85), (0.85, 0.95)]
            .map(|(from, to)| mean(self.within(from, to, east)) / all)
    }

    /// Mean square of the difference of points 2, 4, 8, 16 and 32 apart, over twice the variance, within 0.75
    /// radii: the structure function. It tends to 1 where nothing is alike; a spectrum that falls with the
    /// power -p makes it rise with p - 1.
    fn structure(&self, east: f64) -> [f64; 5] {
        let at = Self::new(|x, y| if x < east { 2.0 } else { x.hypot(y) });
        let values = self.within(0.0, 0.75, east);
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
        [2, 4, 8, 16, 32].map(|lag| {
            let (mut sum, mut count) = (0.0, 0.0);
            for k in 0..SIDE * (SIDE - lag) {
                for other in [k + lag, k + lag * SIDE] {
                    if at.0[k] < 0.75 && at.0[other] < 0.75 {
                        sum += (self.0[k] - self.0[other]).powi(2);
                        count += 1.0;
                    }
                }
            }
            sum / count / (2.0 * variance)
        })
    }
}

fn bilinear(pixels: &[f64], width: usize, [x, y]: [f64; 2]) -> f64 {
    let (i, j) = (x.floor(), y.floor());
    let value = |dx: f64, dy: f64| {
        let (column, row) = (i + dx, j + dy);
        let inside = column >= 0.0 && row >= 0.0 && (column as usize) < width;
        if !inside {
            return 0.0;
        }
        pixels.get(row as usize * width + column as usize).copied().unwrap_or(0.0)
    };
    let (x, y) = (x - i, y - j);
    (1.0 - y) * ((1.0 - x) * value(0.0, 0.0) + x * value(1.0, 0.0))
        + y * ((1.0 - x) * value(0.0, 1.0) + x * value(1.0, 1.0))
}

/// Where pictures for people go.
pub fn folder() -> PathBuf {
    std::env::var_os("SEXTANT_OUT").map_or_else(|| PathBuf::from(env!("CARGO_TARGET_TMPDIR")), PathBuf::from)
}

/// Both discs side by side, each with its 99.5th percentile white.
fn write_pair(name: &str, discs: [&Disc; 2]) {
    let mut picture = image::GrayImage::new(2 * SIDE as u32, SIDE as u32);
    for (disc, left) in discs.into_iter().zip([0, SIDE]) {
        let mut sorted = disc.within(0.0, 0.9, -2.0);
        sorted.sort_by(f64::total_cmp);
        let white = sorted[(0.995 * sorted.len() as f64) as usize];
        for (k, value) in disc.0.iter().enumerate() {
            let grey = (WHITE * value / white).clamp(0.0, 255.0) as u8;
            picture.put_pixel((left + k % SIDE) as u32, (k / SIDE) as u32, image::Luma([grey]));
        }
    }
    let path = folder().join(name);
    picture.save(&path).unwrap();
    println!("{}", path.display());
}

#[test]
fn a_drawn_disc_is_spread_and_structured_like_the_real_ones() {
    let real = [
        (
            "goes15-full",
            "earth/goestools/GOES15_FD_VS_20170821T2106Z.png",
            [234.13, 246.15],
            [235.25, 234.62],
            0.0,
        ),
        (
            "goes15-gibbous",
            "earth/goestools/GOES15_FD_VS_20170821T1806Z.png",
            [234.13, 246.15],
            [235.25, 234.62],
            -45.0,
        ),
        ("goes16-morning", "earth/pytroll/GOES16_ABI_C02_520.png", [259.5, 259.5], [255.97, 255.12], -88.0),
    ];
    for (name, file, centre, radii, hour_angle_deg) in real {
        let Some(picture) = Disc::real(file, centre, radii) else { return };
        // Half of the discs is dark in the others: there only what the Sun lights well is compared.
        let east = if hour_angle_deg == 0.0 { -2.0 } else { 0.2 };
        let discs = SEEDS.map(|seed| Disc::drawn(seed, hour_angle_deg));
        write_pair(&format!("earth-{name}.png"), [&picture, &discs[0]]);
        let figures = |disc: &Disc| (disc.quartiles(east), disc.rings(east), disc.structure(east));
        let (real_q, real_r, real_s) = figures(&picture);
        println!("{name:>14}  real: quartiles {real_q:.2?} rings {real_r:.2?} structure {real_s:.2?}");
        let all = discs.each_ref().map(figures);
        for (seed, (q, r, s)) in SEEDS.iter().zip(&all) {
            println!("{name:>14}     {seed}: quartiles {q:.2?} rings {r:.2?} structure {s:.2?}");
        }
        let mean = |of: &dyn Fn(&Figures) -> f64| all.iter().map(of).sum::<f64>() / SEEDS.len() as f64;
        for (k, real) in real_q.iter().enumerate() {
            let drawn = mean(&|f: &Figures| f.0[k]);
            assert!((drawn - real).abs() < QUARTILES, "{name}: quartile {k} {drawn:.2} for {real:.2}");
        }
        for (k, real) in real_r.iter().enumerate() {
            let drawn = mean(&|f: &Figures| f.1[k]);
            assert!((drawn - real).abs() < RINGS, "{name}: ring {k} {drawn:.2} for {real:.2}");
        }
        for (k, real) in real_s.iter().enumerate() {
            let drawn = mean(&|f: &Figures| f.2[k]);
            assert!(
                (drawn / real).ln().abs() < STRUCTURE.ln(),
                "{name}: structure {k} {drawn:.2} for {real:.2}"
            );
        }
    }
}
