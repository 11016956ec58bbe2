//! Turning without an attitude: the rate beside the identification, the Earth's rotation, streaks (thesis
//! figs. 3.16, 7.10, 7.11).
//!
//! Scenes are the world's ([`super::turning_sky`]); scan, marks and streaks are the flight code's.

use super::seeds::{OverSeeds, SEEDS, over_seeds};
use super::{Figure, Made, Row, SEED, Told, turning_sky};
use crate::error::HostError;
use crate::flight::{self, StarCalibration};
use crate::formats::camera_file::CameraFile;
use crate::formats::picture::Picture;
use crate::report::chart::{Axis, Chart, Series};
use crate::world::scene::{Scene, VisibleStar, WorldStar};
use fsw_core::camera::Camera;
use fsw_core::image::scan::{self, Detections, TILE_PIXELS};
use fsw_core::image::streaks::{Streak, follow, search};
use fsw_core::image::{DetectionMethod, DetectionParameters};
use fsw_core::rate::marks::{MAX_MARKS, Mark, match_by_separation};
use fsw_core::stars::MeasuredStar;
use fsw_core::telemetry::Outcome;
use fsw_hal::Detector;
use std::path::Path;

/// The figures.
pub const FIGURES: &[Figure] = &[
    Figure {
        name: "fig-3.16",
        title: "rate from image to image beside the identification",
        place: "\u{a7}3.1.5",
        thesis: &[],
        make: beside,
    },
    Figure {
        name: "fig-7.10",
        title: "the Earth's rotation seen by a camera at rest, from image to image",
        place: "\u{a7}7.2.1.3",
        thesis: &[
            Told {
                what: "rate of the Earth",
                value: 4.16e-3,
                unit: "deg/s",
                place: "\u{a7}7.2.1.3; the scan has 416 for its digits, and its own mean torn",
            },
            Told {
                what: "deviation of the rate, an interval of 5.18 s",
                value: 1.01e-3,
                unit: "deg/s",
                place: "\u{a7}7.2.1.3",
            },
            Told {
                what: "attitude of one image by it, pitch/yaw",
                value: 4.4,
                unit: "arcsec",
                place: "tab. 7.4",
            },
            Told {
                what: "attitude of one image by it, roll",
                value: 28.3,
                unit: "arcsec",
                place: "tab. 7.4",
            },
            Told {
                what: "all axes",
                value: 13.8,
                unit: "arcsec",
                place: "\u{a7}7.2.1.3, \u{a7}7.2.1.4; the scan has \u{201c}138\u{201d}",
            },
        ],
        make: earth_spin,
    },
    Figure {
        name: "fig-7.11",
        title: "streaks of 46 images laid over each other",
        place: "\u{a7}7.2.1.3",
        thesis: &[
            Told { what: "images", value: 46.0, unit: "", place: "\u{a7}7.2.1.3" },
            Told { what: "length of the streaks", value: 1.0, unit: "deg", place: "\u{a7}7.2.1.3" },
            Told { what: "streaks found down to V", value: 5.0, unit: "mag", place: "\u{a7}7.2.1.3" },
        ],
        make: streaks,
    },
];

/// Exposure, us.
const EXPOSURE_US: u32 = 400_000;
/// Rates of the beginning, deg/s, and its seconds.
const RATES_DEG_S: [f64; 3] = [0.1, 0.5, 2.0];
const BEGINNING_S: u32 = 8;

/// Seconds until the first rate that needed no attitude, and until the first attitude; none within the
/// flight.
fn firsts(seed: u64, rate_deg_s: f64, sky: &[WorldStar]) -> Result<[Option<u32>; 2], HostError> {
    let mut scene = turning_sky::scene(seed, rate_deg_s, sky)?;
    let mut firsts = [None; 2];
    turning_sky::fly(&mut scene, EXPOSURE_US, BEGINNING_S, |report, _| {
        let named = matches!(report.outcome, Some(Outcome::Identified | Outcome::Tracked));
        let seen = [report.rate.is_some(), report.attitude.is_some() && named];
        for (first, seen) in firsts.iter_mut().zip(seen) {
            if seen {
                first.get_or_insert(report.cycle + 1);
            }
        }
    })?;
    Ok(firsts)
}

fn beside(_: &Figure) -> Result<Made, HostError> {
    let sky = turning_sky::sky();
    let (mut series, mut rows) = (Vec::new(), Vec::new());
    for rate_deg_s in RATES_DEG_S {
        let seeds =
            over_seeds(|seed| firsts(seed, rate_deg_s, &sky)).into_iter().collect::<Result<Vec<_>, _>>()?;
        let share = |what: usize, by: u32| {
            100.0 * seeds.iter().filter(|firsts| firsts[what].is_some_and(|first| first <= by)).count() as f64
                / seeds.len() as f64
        };
        let either = |by: u32| {
            let known = |firsts: &&[Option<u32>; 2]| firsts.iter().flatten().any(|first| *first <= by);
            100.0 * seeds.iter().filter(known).count() as f64 / seeds.len() as f64
        };
        let seconds = || 1..=BEGINNING_S;
        series.push(
            Series::ours(
                format!("ours, {rate_deg_s} deg/s: attitude"),
                seconds().map(|second| [second.into(), share(1, second)]).collect(),
            )
            .marked(),
        );
        series.push(
            Series::ours(
                format!("{rate_deg_s} deg/s: attitude or rate"),
                seconds().map(|second| [second.into(), either(second)]).collect(),
            )
            .marked(),
        );
        let first = |what: usize| {
            let known: Vec<f64> = seeds.iter().filter_map(|firsts| firsts[what].map(f64::from)).collect();
            match known.len() {
                0 => "never".to_owned(),
                count => format!("after {} in {count} of {SEEDS}", OverSeeds::of(known).words("s")),
            }
        };
        rows.push(Row::alone(
            format!("{rate_deg_s} deg/s: first rate; first attitude"),
            format!("{}; {}", first(0), first(1)),
        ));
    }
    let chart = Chart {
        title: "What is known after switching on, turning".into(),
        x: Axis::new("seconds since switched on, the self-test included"),
        y: Axis::new("share of the flights, %").between([0.0, 102.0]),
        series,
    };
    let verdict = "The thesis draws the two side by side: tracking numbers and rates from image to image while identification takes several. Here they \
        follow one another: at rest and when turning slowly identification is done in the second of the first image, so that no rate without it \
        is told; a search that takes longer takes no image meanwhile; from half a degree a second on the rate comes first, from streaks; the next image is exposed so shortly that stars are points, and \
        gives the attitude. No number of the thesis";
    Ok(Made::new(&[chart], rows, verdict))
}

/// The Earth's rotation, deg/s.
const EARTH_DEG_S: f64 = 360.0 / 86_164.1;
/// Seconds from image to image, near to the thesis's 5.18, and images of a series.
const INTERVAL_S: u32 = 5;
const IMAGES: u32 = 25;

/// The marks of the image in the scene, brightest first, as the flight code keeps them.
fn marks(scene: &mut Scene, method: &DetectionMethod<'_>, camera: &Camera) -> Result<Vec<Mark>, HostError> {
    let fault = |error| HostError::usage(format!("the scene failed ({error:?})"), "report this");
    let mut detections = Detections::new();
    scan::scan(scene, &mut [0; TILE_PIXELS], *method, &mut detections).map_err(fault)?;
    let stars = detections.spots().iter().filter_map(|spot| MeasuredStar::from_detection(camera, spot));
    let mark = |star: MeasuredStar| Mark {
        direction: *star.direction.vector(),
        sigma_rad: [star.sigma_px * camera.rad_per_px(); 2],
        late_s: 0.0,
    };
    Ok(stars.map(mark).take(MAX_MARKS).collect())
}

/// A rate's error along the sensor's axes, and its size, deg/s.
type Spin = ([f64; 3], f64);

/// Rates from image to image, deg/s, sensor axes, less the true one; and their sizes.
fn spin(seed: u64, sky: &[WorldStar]) -> Result<Vec<Spin>, HostError> {
    let mut scene = turning_sky::scene(seed, EARTH_DEG_S, sky)?;
    let calibration = turning_sky::calibration()?;
    let calibration = calibration.as_ref().and_then(StarCalibration::open);
    let parameters = DetectionParameters::default();
    let method = DetectionMethod { parameters: &parameters, calibration: calibration.as_ref(), turn: None };
    let file = flight::calibrated_camera(&CameraFile::reference());
    let camera = flight::camera(&file, Path::new("the reference camera"))?;
    let (mut before, mut rates): (Vec<Mark>, Vec<_>) = (Vec::new(), Vec::new());
    for image in 0..IMAGES {
        let exposed = scene.expose_cycle((image * INTERVAL_S).into(), EXPOSURE_US);
        exposed.map_err(|error| HostError::usage(format!("the scene failed ({error:?})"), "report this"))?;
        let now = marks(&mut scene, &method, &camera)?;
        if let Some(rate) = match_by_separation(&before, &now, INTERVAL_S as f32) {
            let rad_s = rate.rad_s.map(f64::from);
            let truth = scene.rate_rad_s();
            let error = [0, 1, 2].map(|axis| (rad_s[axis] - truth[axis]).to_degrees());
            rates.push((error, rad_s.norm().to_degrees()));
        }
        before = now;
    }
    Ok(rates)
}

fn earth_spin(figure: &Figure) -> Result<Made, HostError> {
    let sky = turning_sky::sky();
    let all = over_seeds(|seed| spin(seed, &sky)).into_iter().collect::<Result<Vec<_>, _>>()?;
    let per_seed = |of: &dyn Fn(&[Spin]) -> f64| {
        OverSeeds::of(all.iter().filter(|rates| !rates.is_empty()).map(|rates| of(rates)))
    };
    let mean_size = per_seed(&|rates| rates.iter().map(|(_, size)| size).sum::<f64>() / rates.len() as f64);
    let deviation = per_seed(&|rates| {
        let mean = rates.iter().map(|(_, size)| size).sum::<f64>() / rates.len() as f64;
        (rates.iter().map(|(_, size)| (size - mean).powi(2)).sum::<f64>() / rates.len() as f64).sqrt()
    });
    // A rate is the difference of two attitudes over the interval.
    let to_arcsec = 3600.0 * f64::from(INTERVAL_S) / std::f64::consts::SQRT_2;
    let axis = |axis: usize| {
        per_seed(&move |rates: &[Spin]| {
            to_arcsec
                * (rates.iter().map(|(error, _)| error[axis].powi(2)).sum::<f64>() / rates.len() as f64)
                    .sqrt()
        })
    };
    let (x, z) = (axis(0), axis(2));
    let found: usize = all.iter().map(Vec::len).sum();
    let rows = vec![
        figure.row(
            0,
            format!(
                "{:.3e} deg/s true; mean {:.3e} deg/s (95 %: {:.3e})",
                EARTH_DEG_S, mean_size.median, mean_size.edges[1]
            ),
        ),
        figure.row(
            1,
            format!(
                "{:.2e} deg/s (95 %: {:.2e}), an interval of {INTERVAL_S} s",
                deviation.median, deviation.edges[1]
            ),
        ),
        figure.row(2, x.words("arcsec")),
        figure.row(3, z.words("arcsec")),
        Row::alone("pairs of images with a rate", format!("{found} of {}", SEEDS * u64::from(IMAGES - 1))),
    ];
    let one = &all[0];
    let time = |index: usize| f64::from(INTERVAL_S) * (index as f64 + 1.0);
    let last = time(one.len().max(2) - 1);
    let level = |value: f64| vec![[time(0), value], [last, value]];
    let [told, sigma] = [figure.thesis[0].value, figure.thesis[1].value];
    let chart = Chart {
        title: "Rate of a camera that rests on the Earth, from image to image".into(),
        x: Axis::new("time, s"),
        y: Axis::new("size of the rate, deg/s"),
        series: vec![
            Series::ours(
                format!("ours, seed {SEED}"),
                one.iter().enumerate().map(|(index, (_, size))| [time(index), *size]).collect(),
            )
            .marked(),
            Series::thesis("thesis, rate of the Earth", level(told)),
            Series::thesis("thesis, 1 sigma about it", level(told - sigma)),
            Series::thesis("", level(told + sigma)),
        ],
    };
    let verdict = "The same figure by the flight code's matching of two images by their separations, without a catalogue. Ours scatters less: twelve stars instead of five, \
        a calibrated lens, no atmosphere between; the axis of the rotation lies across the line of sight. In flight a rate below 3 px an image is not told this way, because the \
        Sun's glare moves like that; here the matching is called by itself.";
    Ok(Made::new(&[chart], rows, verdict))
}

/// Images laid over each other.
const LAID: u32 = 46;
/// Seconds from one to the next.
const STEP_S: u32 = 1;
/// Faintest star looked for, and the width of a class of magnitudes.
const FAINTEST_V: f64 = 6.0;
const CLASS_V: f64 = 0.5;
/// A streak is a star's whose middle lies so near, px.
const SAME_PX: f32 = 6.0;

/// A picture, its stars by the middle of their way, and the streaks found in it.
struct Drawn {
    stars: Vec<VisibleStar>,
    streaks: Vec<Streak>,
}

/// The flight code's streaks of a picture.
fn streaks_of(picture: &mut impl Detector<Error = fsw_hal::DetectorError>) -> Result<Vec<Streak>, HostError> {
    let fault = |error| HostError::usage(format!("the picture failed ({error:?})"), "report this");
    let (mut buffer, mut pieces, mut streaks) =
        ([0; TILE_PIXELS], search::Pieces::new(), Vec::<Streak>::new());
    search::search(picture, &mut buffer, &mut pieces).map_err(fault)?;
    let mut columns = usize::MAX / 2;
    for piece in &pieces {
        if streaks.iter().any(|streak| streak.holds(piece.at_px, SAME_PX)) {
            continue;
        }
        if let Some(streak) = follow::follow(picture, &mut buffer, piece, &mut columns).map_err(fault)? {
            streaks.push(streak);
        }
    }
    Ok(streaks)
}

/// Images laid over each other while the camera turns by the thesis's angle, means of them.
fn laid_over(seed: u64, sky: &[WorldStar], length_deg: f64) -> Result<Drawn, HostError> {
    let fault = |error: fsw_hal::DetectorError| {
        HostError::usage(format!("the scene failed ({error:?})"), "report this")
    };
    let mut scene = turning_sky::scene(seed, length_deg / f64::from(LAID * STEP_S), sky)?;
    let geometry = scene.geometry();
    let mut sums = vec![0u32; geometry.whole().area()];
    let mut pixels = vec![0u16; sums.len()];
    let mut stars = Vec::new();
    for image in 0..LAID {
        scene.expose_cycle((image * STEP_S).into(), EXPOSURE_US).map_err(fault)?;
        scene.read(geometry.whole(), &mut pixels).map_err(fault)?;
        sums.iter_mut().zip(&pixels).for_each(|(sum, pixel)| *sum += u32::from(*pixel));
        if image == LAID / 2 {
            stars = scene.visible_stars().to_vec();
        }
    }
    // The sum of ten bits, in sixteen, as the thesis's; hot pixels may fill it.
    let bits = 16;
    let summed = sums.iter().map(|sum| u16::try_from(*sum).unwrap_or(u16::MAX)).collect();
    let geometry = fsw_hal::DetectorGeometry { bits, ..geometry };
    let mut picture = Picture::from_pixels(geometry, summed)
        .ok_or_else(|| HostError::usage("the sum is no picture", "report this"))?;
    picture.expose(EXPOSURE_US).map_err(fault)?;
    Ok(Drawn { stars, streaks: streaks_of(&mut picture)? })
}

/// One image in which the stars move as far, at a rate.
fn one_image(seed: u64, sky: &[WorldStar], length_deg: f64) -> Result<Drawn, HostError> {
    let fault = |error: fsw_hal::DetectorError| {
        HostError::usage(format!("the scene failed ({error:?})"), "report this")
    };
    let mut scene = turning_sky::scene(seed, length_deg / (1e-6 * f64::from(EXPOSURE_US)), sky)?;
    scene.expose_cycle(0, EXPOSURE_US).map_err(fault)?;
    let stars = scene.visible_stars().to_vec();
    Ok(Drawn { stars, streaks: streaks_of(&mut scene)? })
}

/// Of each class of magnitudes the stars, and those on which a streak was found.
fn by_magnitude(drawn: &[Drawn]) -> Vec<[f64; 3]> {
    let classes = (FAINTEST_V / CLASS_V) as usize;
    let mut table = vec![[0.0; 3]; classes];
    for (class, row) in table.iter_mut().enumerate() {
        row[0] = CLASS_V * (class as f64 + 0.5);
    }
    for Drawn { stars, streaks } in drawn {
        for star in stars.iter().filter(|star| (0.0..FAINTEST_V).contains(&star.v)) {
            let row = &mut table[(star.v / CLASS_V) as usize];
            row[1] += 1.0;
            let at = [star.x_px as f32, star.y_px as f32];
            row[2] += f64::from(u8::from(streaks.iter().any(|streak| streak.holds(at, SAME_PX))));
        }
    }
    table
}

fn streaks(figure: &Figure) -> Result<Made, HostError> {
    let sky = turning_sky::sky();
    let length_deg = figure.thesis[1].value;
    let laid =
        over_seeds(|seed| laid_over(seed, &sky, length_deg)).into_iter().collect::<Result<Vec<_>, _>>()?;
    let one =
        over_seeds(|seed| one_image(seed, &sky, length_deg)).into_iter().collect::<Result<Vec<_>, _>>()?;
    let curve = |table: &[[f64; 3]]| -> Vec<[f64; 2]> {
        table.iter().filter(|row| row[1] > 0.0).map(|[v, all, found]| [*v, 100.0 * found / all]).collect()
    };
    let half = |table: &[[f64; 3]]| {
        let faintest = table.iter().rev().find(|[_, all, found]| *all > 0.0 && found / all >= 0.5);
        faintest.map_or("none".into(), |row| format!("V = {:.1}", row[0] + 0.5 * CLASS_V))
    };
    let other = |drawn: &[Drawn]| {
        let of = |Drawn { stars, streaks }: &Drawn| {
            let on = |streak: &&Streak| {
                !stars.iter().any(|star| streak.holds([star.x_px as f32, star.y_px as f32], SAME_PX))
            };
            streaks.iter().filter(on).count() as f64
        };
        OverSeeds::of(drawn.iter().map(of))
    };
    let (laid_table, one_table) = (by_magnitude(&laid), by_magnitude(&one));
    let lengths = OverSeeds::of(laid.iter().map(|drawn| {
        let mut lengths: Vec<f64> = drawn
            .streaks
            .iter()
            .filter(|streak| !streak.cut)
            .map(|streak| f64::from(streak.length_px()))
            .collect();
        lengths.sort_by(f64::total_cmp);
        lengths
            .get(lengths.len() / 2)
            .map_or(f64::NAN, |px| libm::atan(px / CameraFile::reference().focal_length_px).to_degrees())
    }));
    let rows = vec![
        figure.row(0, LAID.to_string()),
        figure.row(1, lengths.words("deg")),
        figure.row(
            2,
            format!(
                "half of the stars of {}; in one image of 2.5 deg/s {}",
                half(&laid_table),
                half(&one_table)
            ),
        ),
        Row::alone(
            "streaks that are no star's, an image; in one image",
            format!("{}; {}", other(&laid).words(""), other(&one).words("")),
        ),
    ];
    let chart = Chart {
        title: "Streaks of 1 deg found by magnitude, 20 seeds".into(),
        x: Axis::new("magnitude V, classes of half a magnitude"),
        y: Axis::new("share of the stars on which a streak was found, %").between([0.0, 102.0]),
        series: vec![
            Series::ours("ours, 46 images laid over each other", curve(&laid_table)).marked(),
            Series::ours("ours, one image of 0.4 s at 2.5 deg/s", curve(&one_table)).marked(),
            Series::thesis("thesis, down to V = 5", vec![[5.0, 0.0], [5.0, 100.0]]),
        ],
    };
    let verdict = "Half of the stars are found down to half a magnitude less than the thesis names, and none of another thing. The sum of 46 images goes hardly deeper than one image of a streak as long, though it holds \
        46 times the light: dark current and the pixels' pattern add up with it, and the search keeps the 48 strongest pieces; which of these it is has not been taken apart. The search is the flight code's (lines of 64 px by a Radon \
        transform), which replaces the thesis's 11 x 11 sums";
    Ok(Made::new(&[chart], rows, verdict))
}
