use super::*;
use crate::calibration::centroid::{COLOUR, Lens, window_about};
use crate::flight::lost_in_space::{FocalLength, Solver};
use crate::flight::{self, REFERENCE_CALIBRATION};
use crate::formats::camera_file::CameraFile;
use crate::formats::picture::{check_request, copy_window};
use crate::harness::star_scene;
use crate::judge::{arcsec, attitude_error};
use crate::scenario::Scenario;
use crate::world::attitude::normalised;
use crate::world::detector::disturbances::Disturbances;
use crate::world::detector::fixed_pattern::PatternModel;
use crate::world::detector::imaging::ImagingModel;
use crate::world::detector::protons::Protons;
use crate::world::motion::Motion;
use crate::world::noise::{Noise, Stream};
use crate::world::scene::{Scene, SceneSettings, VisibleStar, WorldStar};
use crate::world::sky::stars::DetectorModel;
use fsw_core::catalog::Catalogue;
use fsw_core::image::DetectionMethod;
use fsw_core::image::bad_pixels::BadPixelDetector;
use fsw_core::image::calibration::Calibration;
use fsw_core::image::scan::read_stars;
use fsw_hal::{DetectorError, Window};
use std::path::Path;

/// The world's seed.
const SEED: u64 = 11;
const EXPOSURE_US: u32 = 400_000;

/// The reference camera, its detector with these defects and proton hits.
fn scene(defects: bool, quaternion: [f64; 4], stars: &[WorldStar]) -> Scene {
    let motion = Motion::turning(quaternion, [3.0e-4, 1.5e-4, -0.5e-4]);
    let mut settings = SceneSettings::new(CameraFile::reference(), motion, SEED);
    settings.detector = DetectorModel::reference();
    settings.imaging = ImagingModel::REFERENCE;
    let protons = Protons::Fixed(20);
    let none = Disturbances { protons, ..Disturbances::default() };
    settings.disturbances =
        if defects { Disturbances { hot_pixels: 2000, dead_low: 10, dead_high: 10, ..none } } else { none };
    Scene::new(settings, stars).unwrap()
}

fn whole(detector: &mut impl Detector<Error = DetectorError>) -> Vec<u16> {
    let window = detector.geometry().whole();
    let mut pixels = vec![0; window.area()];
    detector.read(window, &mut pixels).unwrap();
    pixels
}

/// What the command makes of five dark pictures of that detector.
fn surveyed() -> Survey {
    let mut dark = scene(true, [0.0, 0.0, 0.0, 1.0], &[]);
    let frames: Vec<Vec<u16>> = (100..105)
        .map(|cycle| {
            dark.expose_cycle(cycle, EXPOSURE_US).unwrap();
            whole(&mut dark)
        })
        .collect();
    survey::survey(&frames.iter().map(Vec::as_slice).collect::<Vec<_>>(), dark.geometry()).unwrap()
}

/// What came of several skies.
#[derive(Debug, Default)]
struct Outcome {
    stars: f64,
    found: f64,
    false_spots: u32,
    squares_px2: f64,
    worst_px: f64,
    identified: u32,
    squares_arcsec2: f64,
}

impl Outcome {
    /// Root mean square error of a star, px an axis.
    fn rms_px(&self) -> f64 {
        (self.squares_px2 / (2.0 * self.found)).sqrt()
    }

    fn print(&self, name: &str) {
        println!(
            "{name:8} {:.0} of {:.0} stars, {} false spots, rms {:.4} px, worst {:.3} px, {} identified, rms {:.2} arcsec",
            self.found,
            self.stars,
            self.false_spots,
            self.rms_px(),
            self.worst_px,
            self.identified,
            (self.squares_arcsec2 / f64::from(self.identified)).sqrt()
        );
    }

    /// Scans what the detector shows of a scene's sky, identifies it, and holds both against the truth.
    fn take(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        scene: &Scene,
        solver: &mut Solver,
        method: DetectionMethod,
    ) {
        let (mut buffer, mut detections) = (Box::new([0; TILE_PIXELS]), Detections::new());
        scan(detector, &mut buffer, method, &mut detections).unwrap();
        let spots: Vec<_> =
            detections.spots().iter().map(|spot| (spot.centre_px(), spot.sigma_px())).collect();
        let error_px =
            |(at, _): &([f32; 2], f32), x: f64, y: f64| [f64::from(at[0]) - x, f64::from(at[1]) - y];
        let near = |error: [f64; 2]| error[0].hypot(error[1]);
        for star in scene.visible_stars().iter().filter(|star| star.v <= 5.0) {
            let inside = |at: f64, side: f64| at > 8.0 && at < side - 9.0;
            let beside = |other: &&VisibleStar| near([other.x_px - star.x_px, other.y_px - star.y_px]) < 8.0;
            let crowded =
                scene.visible_stars().iter().filter(|other| other.v < 8.0).filter(beside).count() > 1;
            if crowded || !inside(star.x_px, 1280.0) || !inside(star.y_px, 1024.0) {
                continue;
            }
            self.stars += 1.0;
            let errors = spots.iter().map(|spot| error_px(spot, star.x_px, star.y_px));
            let nearest = errors.min_by(|a, b| near(*a).total_cmp(&near(*b)));
            if let Some(error) = nearest.filter(|error| near(*error) < 2.0) {
                self.found += 1.0;
                self.squares_px2 += near(error).powi(2);
                self.worst_px = self.worst_px.max(near(error));
            }
        }
        let is_star = |spot: &&([f32; 2], f32)| {
            scene.visible_stars().iter().any(|star| near(error_px(spot, star.x_px, star.y_px)) < 3.0)
        };
        self.false_spots += (spots.len() - spots.iter().filter(is_star).count()) as u32;
        let camera = flight::camera(&CameraFile::reference(), Path::new("reference.toml")).unwrap();
        let catalogue = Catalogue::open(catalog_gen::REFERENCE).unwrap();
        if let Ok(solution) = solver.search(&spots, &camera, &catalogue, FocalLength::Rough) {
            let [x, y, _] = attitude_error(solution.confirmed.attitude.quaternion(), scene.quaternion());
            self.identified += 1;
            self.squares_arcsec2 += arcsec(x.hypot(y)).powi(2);
        }
    }
}

#[test]
fn a_sky_with_two_thousand_hot_pixels_is_measured_as_on_a_detector_without() {
    let survey = surveyed();
    let size_px = [1280, 1024];
    let bad: Vec<_> = survey.bad.iter().map(|(at, _)| *at).collect();
    let bytes = table(size_px, &bad, &survey.offsets);
    let defects = Defects::open(&bytes).unwrap();
    // The survey: against the world's own lists.
    let stars = star_scene::sky();
    let truth = scene(true, [0.0, 0.0, 0.0, 1.0], &[]);
    let world = truth.settings().disturbances;
    let mut known: Vec<[u16; 2]> =
        world.hot_pixels(SEED, truth.geometry()).as_slice().iter().map(|hot| [hot.x, hot.y]).collect();
    known.extend(world.dead_pixels(SEED, truth.geometry()).iter().map(|(x, y, _)| [*x, *y]));
    let missed = known.iter().filter(|[x, y]| !defects.is_bad(*x, *y)).count();
    let invented = bad.iter().filter(|at| !known.contains(at)).count();
    let of = |kind| survey.bad.iter().filter(|(_, is)| *is == kind).count();
    println!(
        "{} hot, {} dead, {} flickering; {missed} of {} missed, {invented} invented; {} columns, noise {:.2} DN, {} bytes",
        of(Kind::Hot),
        of(Kind::Dead),
        of(Kind::Flickering),
        known.len(),
        survey.offsets.len(),
        survey.noise_dn,
        bytes.len()
    );
    assert_eq!((missed, survey.offsets.len()), (0, 0));
    assert!(invented <= 5, "{invented}");
    // The skies.
    let calibration = Calibration::open(REFERENCE_CALIBRATION).unwrap();
    let parameters = DetectionParameters::default();
    let method = DetectionMethod { parameters: &parameters, calibration: Some(&calibration), turn: None };
    let [mut clean, mut raw, mut mended] = [0; 3].map(|_| Outcome::default());
    let mut solver = Solver::default();
    let noise = Noise::new(SEED, 0, Stream::Attitude);
    const SKIES: u32 = 12;
    for sky in 0..SKIES {
        let quaternion = normalised([0, 1, 2, 3].map(|axis| noise.quick_gaussian(sky, axis))).unwrap();
        let expose = |defects| {
            let mut scene = scene(defects, quaternion, &stars);
            scene.expose_cycle(u64::from(sky), EXPOSURE_US).unwrap();
            let mut picture = Picture::from_pixels(scene.geometry(), whole(&mut scene)).unwrap();
            picture.expose(EXPOSURE_US).unwrap();
            (scene, picture)
        };
        let (scene, mut picture) = expose(false);
        clean.take(&mut picture, &scene, &mut solver, method);
        let (scene, mut picture) = expose(true);
        raw.take(&mut picture, &scene, &mut solver, method);
        mended.take(&mut BadPixelDetector::new(&mut picture, defects).unwrap(), &scene, &mut solver, method);
    }
    clean.print("clean");
    raw.print("raw");
    mended.print("mended");
    assert_eq!(mended.identified, SKIES);
    assert!(mended.squares_arcsec2 < 1.2 * clean.squares_arcsec2);
    // Without the table a hot pixel beside a star draws its centre along, and hides some.
    assert!(raw.rms_px() > 2.0 * mended.rms_px() && raw.found < mended.found);
    assert!(mended.found >= clean.found - 2.0 && mended.rms_px() < 1.1 * clean.rms_px());
    assert!(mended.false_spots <= clean.false_spots + 1);
}

/// A frame of the reference detector, dark but for a window.
struct Lit {
    window: Window,
    frame: Vec<u16>,
}

const GEOMETRY: DetectorGeometry = DetectorGeometry { width_px: 1280, height_px: 1024, bits: 10 };

impl fsw_hal::ErrorType for Lit {
    type Error = DetectorError;
}

impl Detector for Lit {
    fn geometry(&self) -> DetectorGeometry {
        GEOMETRY
    }

    fn start_exposure(&mut self, _: u32) -> Result<(), DetectorError> {
        Ok(())
    }

    fn finish_exposure(&mut self) -> Result<fsw_hal::LocalTime, DetectorError> {
        Ok(fsw_hal::LocalTime::default())
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        check_request(&GEOMETRY, window, pixels.len())?;
        copy_window(&self.frame, &GEOMETRY, window, pixels);
        Ok(())
    }
}

/// Bad pixels from a star's middle one, px.
const BESIDE: [(&str, [i32; 2]); 5] =
    [("middle", [0, 0]), ("beside", [1, 0]), ("above", [0, -1]), ("corner", [1, 1]), ("two off", [2, 0])];

#[test]
fn a_star_on_a_bad_pixel_keeps_its_place() {
    let scenario = Scenario::default_embedded();
    let detector = DetectorModel { pattern: PatternModel::NONE, ..scenario.detector };
    let lens = Lens::new(&scenario.camera, &scenario.imaging, &detector).unwrap();
    let calibration = Calibration::open(REFERENCE_CALIBRATION).unwrap();
    let parameters = DetectionParameters::default();
    let method = DetectionMethod { parameters: &parameters, calibration: Some(&calibration), turn: None };
    let dark_e = detector.dark_now_e_s() * 0.4;
    let (converter, places) = (detector.converter(10), Noise::new(1, 0, Stream::Attitude));
    const STARS: u32 = 300;
    let level = detector.pedestal_dn(10) as u16;
    let mut lit = Lit { window: window_about([40.0; 2]), frame: vec![level; GEOMETRY.whole().area()] };
    for v in [2.0, 3.5, 5.0] {
        for (name, [dx, dy]) in BESIDE {
            // Sum of squares and number found: sound, hot, dead, either mended.
            let mut tallies = [(0.0, 0.0); 4];
            for star in 0..STARS {
                let at = [0, 1].map(|k| 40.0 + 900.0 * places.uniform(star, k));
                let window = window_about(at);
                let mut electrons = vec![0.0; window.area()];
                let spot = lens.spot(at, detector.star_e_s(v) * 0.4, COLOUR);
                lens.draw(detector.response, &spot, window, &mut electrons);
                electrons.iter_mut().for_each(|charge| *charge += dark_e);
                let noise = |stream| Noise::new(1, u64::from(star), stream);
                for (row, line) in (0..).zip(electrons.chunks_exact_mut(usize::from(window.width))) {
                    noise(Stream::Photon).read_row(
                        (0, row),
                        line,
                        &noise(Stream::Read),
                        detector.read_noise_e,
                    );
                }
                lit.show(window, level, electrons.iter().map(|e| converter.digital_number(*e)));
                let bad = [(at[0].round() as i32 + dx) as u16, (at[1].round() as i32 + dy) as u16];
                let place = usize::from(bad[1]) * usize::from(GEOMETRY.width_px) + usize::from(bad[0]);
                let bytes = table([1280, 1024], &[bad], &[]);
                let sound = lit.frame[place];
                for (kind, value) in [sound, 1023.min(sound + 500), 0, 0].into_iter().enumerate() {
                    lit.frame[place] = value;
                    let mut mended;
                    let seen = if kind == 3 {
                        mended = BadPixelDetector::new(&mut lit, Defects::open(&bytes).unwrap()).unwrap();
                        nearest(&mut mended, window, method, at)
                    } else {
                        nearest(&mut lit, window, method, at)
                    };
                    if let Some(square) = seen {
                        tallies[kind] = (tallies[kind].0 + square, tallies[kind].1 + 1.0);
                    }
                }
            }
            let figures =
                tallies.map(|(sum, count)| ((sum / (2.0 * count)).sqrt(), count / f64::from(STARS)));
            println!(
                "V = {v}, {name:7}: rms px an axis and share found: sound, hot, dead, mended {figures:.3?}"
            );
            let [(sound, all), (_, hot), (_, dead), (mended, found)] = figures;
            assert!(mended < sound.hypot(0.21) && found > all - 0.03, "V = {v}, {name}");
            assert!(hot < found && dead <= found, "V = {v}, {name}");
        }
    }
}

impl Lit {
    /// Shows a window's pixels, and darkness where the last window was.
    fn show(&mut self, window: Window, level: u16, pixels: impl Iterator<Item = u16>) {
        let places = |window: Window| {
            let row = move |y: u16| {
                usize::from(window.y + y) * usize::from(GEOMETRY.width_px) + usize::from(window.x)
            };
            (0..window.height).flat_map(move |y| (0..window.width).map(move |x| row(y) + usize::from(x)))
        };
        places(self.window).for_each(|place| self.frame[place] = level);
        places(window).zip(pixels).for_each(|(place, value)| self.frame[place] = value);
        self.window = window;
    }
}

/// Square of the distance from a place to the nearest spot within 3 px.
fn nearest(
    detector: &mut impl Detector<Error = DetectorError>,
    window: Window,
    method: DetectionMethod,
    at: [f64; 2],
) -> Option<f64> {
    let (mut detections, mut buffer) = (Detections::new(), [0; TILE_PIXELS]);
    read_stars(detector, window, &mut buffer, method, &mut detections).unwrap();
    let square = |[x, y]: [f32; 2]| (f64::from(x) - at[0]).powi(2) + (f64::from(y) - at[1]).powi(2);
    let squares = detections.spots().iter().map(|spot| square(spot.centre_px()));
    squares.min_by(f64::total_cmp).filter(|square| *square < 9.0)
}

/// A file of this test in the system's folder for such.
fn scratch(name: &str, bytes: &[u8]) -> PathBuf {
    let path = std::env::temp_dir().join(format!("sextant-defects-{}-{name}", std::process::id()));
    std::fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn pictures_that_do_not_go_together_are_too_few_or_not_dark_are_refused() {
    // The pictures of a set differ in a pixel each.
    let png = |side: u32, level: u8, number: u32| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let mut stripes = image::GrayImage::from_fn(side, side, |x, y| {
            image::Luma([if (x / 3 + y / 3) % 3 == 0 { level } else { 9 }])
        });
        stripes.get_pixel_mut(7 * number, 5).0[0] += 1;
        stripes.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        bytes.into_inner()
    };
    let set = |name: &str, level| {
        [1, 2, 3, 4, 5].map(|number| scratch(&format!("{number}-{name}"), &png(64, level, number)))
    };
    let (dark, bright) = (set("dark.png", 9), set("bright.png", 200));
    let large = scratch("large.png", &png(65, 9, 1));
    let out = scratch("out", b"");
    let message = |images: &[PathBuf]| {
        let images = images.to_vec();
        run(&DefectsArguments { images, out: out.clone(), json: false }).map(|_| ()).unwrap_err().to_string()
    };
    let mixed = [dark[0].clone(), large.clone()];
    assert!(message(&mixed).contains("large.png: the picture has 65 x 65 px of 8 bits"));
    assert!(message(&dark[..4]).contains("4 dark pictures"));
    assert!(message(&bright).contains("more than darkness"));
    let copies = [&dark[..4], &dark[1..2]].concat();
    assert!(message(&copies).contains("equal to") && message(&copies).contains("2-dark.png"));
    assert_eq!(std::fs::read(&out).unwrap(), b"", "nothing was written");
    let arguments = DefectsArguments { images: dark.to_vec(), out: out.clone(), json: true };
    assert!(run(&arguments).is_ok());
    assert_eq!(std::fs::read(&out).unwrap(), table([64, 64], &[], &[]));
    for path in dark.iter().chain(&bright).chain([&large, &out]) {
        let _ = std::fs::remove_file(path);
    }
}

#[test]
fn darks_of_a_worn_detector_hold_no_star_like_spots_and_skies_do() {
    let spots = |stars: &[WorldStar]| {
        let mut scene = scene(true, [0.0, 0.0, 0.0, 1.0], stars);
        let mut pictures: Vec<Picture> = (0..PICTURES_MIN as u64)
            .map(|cycle| {
                scene.expose_cycle(cycle, EXPOSURE_US).unwrap();
                let pixels = whole(&mut scene);
                Picture::from_pixels(scene.geometry(), pixels).unwrap()
            })
            .collect();
        super::star_like_spots(&vec![PathBuf::new(); PICTURES_MIN], &mut pictures).unwrap()
    };
    let [darks, skies] = [spots(&[]), spots(&star_scene::sky())];
    println!("{darks} star-like spots in a dark, {skies} in a sky");
    assert!(darks <= SPOTS_MAX / 4 && skies >= 2 * SPOTS_MAX);
}
