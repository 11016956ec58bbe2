use super::*;
use crate::catalog::{Catalogue, sample};
use crate::oracle::{self, Generator};
use crate::stars::artificial::{Picture, Spot, camera, camera_parameters, false_star};
use nalgebra::{Matrix3, Vector3};
use std::vec::Vec as List;

/// Stars at chosen places of the detector, and a catalogue of just these.
struct Scene {
    bytes: List<u8>,
    picture: Picture,
}

/// Stars placed at random, at least this far apart.
fn places(generator: &mut Generator, count: usize, apart_px: f64) -> List<[f64; 2]> {
    let mut places: List<[f64; 2]> = List::new();
    while places.len() < count {
        let new = [(); 2].map(|()| generator.between(5.0, 1018.0));
        if places.iter().all(|old| (old[0] - new[0]).hypot(old[1] - new[1]) >= apart_px) {
            places.push(new);
        }
    }
    places
}

impl Scene {
    /// `proximity` says which stars are flagged. The catalogue is brightest first in the order of the places.
    fn new(generator: &mut Generator, places: &[[f64; 2]], proximity: impl Fn(usize) -> bool) -> Self {
        let look = generator.rotation();
        let stars: List<_> = places
            .iter()
            .enumerate()
            .map(|(index, [x, y])| {
                let seen = Vector3::new((x - 511.5) / 3889.0, (y - 511.5) / 3889.0, 1.0).normalize();
                let star = sample::star(&(look.transpose() * seen), index as u32 + 1);
                sample::SampleStar { proximity: proximity(index), ..star }
            })
            .collect();
        let spot = |(index, at): (u16, &[f64; 2])| Spot { centre_px: *at, star: Some(index) };
        let spots = (0u16..).zip(places).map(spot).collect();
        Self { bytes: sample::bytes(&stars, 26, 0), picture: Picture { spots, look } }
    }

    /// `count` stars, none flagged.
    fn of(generator: &mut Generator, count: usize) -> Self {
        let places = places(generator, count, 20.0);
        Self::new(generator, &places, |_| false)
    }

    /// The picture confirmed with an attitude so far off the truth.
    fn confirm(
        &self,
        measured: &[MeasuredStar],
        angle_rad: Vector3<f64>,
        tolerance_px: f32,
    ) -> Option<Confirmed> {
        let (catalogue, camera) = (Catalogue::open(&self.bytes).unwrap(), camera());
        let hypothesis = self.picture.attitude_turned(&angle_rad);
        confirm(&hypothesis, &StarField::whole(measured, &catalogue, &camera), tolerance_px)
    }

    fn confirm_and_widen(
        &self,
        measured: &[MeasuredStar],
        tolerance_px: f32,
    ) -> Option<(Confirmed, Confirmed)> {
        let (catalogue, camera) = (Catalogue::open(&self.bytes).unwrap(), camera());
        let field = StarField::whole(measured, &catalogue, &camera);
        let narrow = confirm(&self.picture.attitude_turned(&Vector3::zeros()), &field, tolerance_px)?;
        let mut widened = narrow.clone();
        widen(&mut widened, &field, tolerance_px);
        Some((narrow, widened))
    }
}

fn wrong_names(confirmed: &Confirmed, picture: &Picture) -> usize {
    let star_of = |found: &&Match| picture.spots[usize::from(found.measured)].star;
    confirmed.matches.iter().filter(|found| star_of(found) != Some(found.star)).count()
}

fn named(confirmed: &Confirmed) -> List<u8> {
    confirmed.matches.iter().map(|found| found.measured).collect()
}

/// The error's angles in stated sigmas, squared and summed.
fn chi_square(confirmed: &Confirmed, picture: &Picture) -> f64 {
    let error = picture.error_of(&confirmed.attitude);
    error.iter().zip(confirmed.sigma_rad).map(|(error, sigma)| (error / f64::from(sigma)).powi(2)).sum()
}

#[test]
fn from_a_hypothesis_a_pixel_off_every_star_gets_its_own_name() {
    let mut generator = Generator::new(70);
    for _ in 0..200 {
        let scene = Scene::of(&mut generator, 30);
        let picture = scene.picture.clone().noisy(&mut generator, 0.2).shuffled(&mut generator);
        let angle = generator.unit() * (1.0 / 3889.0);
        let confirmed = scene.confirm(&picture.measured(&camera(), 0.2), angle, 1.5).unwrap();
        assert_eq!(
            (confirmed.matches.len(), confirmed.expected, wrong_names(&confirmed, &picture)),
            (30, 30, 0)
        );
        assert!(confirmed.matches.is_sorted_by_key(|found| found.star), "brightest first");
        assert!(confirmed.matches.iter().all(|found| u16::from(found.rank) == found.star));
        assert!(confirmed.log10_chance < -60.0, "{}", confirmed.log10_chance);
    }
}

#[test]
fn an_attitude_one_degree_off_is_refused() {
    let mut generator = Generator::new(71);
    let mut least = 0.0f32;
    for _ in 0..1000 {
        let scene = Scene::of(&mut generator, 30);
        let picture = scene.picture.clone().noisy(&mut generator, 0.3);
        let (sine, cosine) = generator.between(0.0, std::f64::consts::TAU).sin_cos();
        let angle = Vector3::new(sine, cosine, 0.0) * 1f64.to_radians();
        for tolerance_px in [1.5, 4.2, 8.5] {
            if let Some(found) = scene.confirm(&picture.measured(&camera(), 0.3), angle, tolerance_px) {
                least = least.min(found.log10_chance);
            }
        }
    }
    std::println!("most convincing of 3000 false attitudes: 10^{least}");
    assert!(least > -6.0, "{least}");
}

#[test]
fn false_attitudes_are_no_more_frequent_than_the_chance_they_state() {
    let mut generator = Generator::new(72);
    const TRIALS: usize = 20_000;
    // Wide radii and many stars, so that chance matches are common enough to count.
    for (stars, false_stars, tolerance_px) in [(30, 30, 8.5), (60, 4, 8.5), (12, 50, 16.0)] {
        let mut frequency = [0usize; 4];
        let mut scene = Scene::of(&mut generator, stars);
        for trial in 0..TRIALS {
            if trial % 100 == 0 {
                scene = Scene::of(&mut generator, stars);
            }
            let spots = (0..30 + false_stars).map(|_| false_star(&mut generator)).collect();
            let picture = Picture { spots, look: scene.picture.look };
            let measured = picture.measured(&camera(), 0.3);
            let Some(found) = scene.confirm(&measured, Vector3::zeros(), tolerance_px) else { continue };
            for (power, count) in (1..).zip(&mut frequency) {
                *count += usize::from(found.log10_chance <= -(power as f32));
            }
        }
        std::println!(
            "{stars}, {false_stars}, {tolerance_px} px: {frequency:?} of {TRIALS} at 1e-1, 1e-2, 1e-3, 1e-4"
        );
        for (power, count) in (1..).zip(frequency) {
            let stated = TRIALS as f64 * 10f64.powi(-power);
            // Three sigmas of a count.
            assert!(count as f64 <= stated + 3.0 * stated.sqrt(), "{count} below 1e-{power}");
        }
    }
}

#[test]
fn few_stars_beyond_the_two_of_a_false_hypothesis_fit_no_more_often_than_stated() {
    let mut generator = Generator::new(76);
    const TRIALS: usize = 20_000;
    // Two stars of the picture fit by construction, as a base side does, within the errors that a side may
    // have; the others stand anywhere. Wide radii, so that there is something to count.
    for (stars, measured, tolerance_px) in [(8, 4, 40.0), (8, 5, 40.0), (12, 6, 25.0), (12, 9, 25.0)] {
        let mut frequency = [0usize; 4];
        let mut scene = Scene::of(&mut generator, stars);
        for trial in 0..TRIALS {
            if trial % 20 == 0 {
                scene = Scene::of(&mut generator, stars);
            }
            let near = |spot: &Spot, generator: &mut Generator| {
                let [x, y] = spot.centre_px;
                let [dx, dy] = [(); 2].map(|()| 0.2 * f64::from(tolerance_px) * generator.gaussian());
                Spot { centre_px: [x + dx, y + dy], star: None }
            };
            let mut spots: List<Spot> =
                scene.picture.spots.iter().take(2).map(|spot| near(spot, &mut generator)).collect();
            spots.resize_with(measured, || false_star(&mut generator));
            let picture = Picture { spots, look: scene.picture.look };
            let measured = picture.measured(&camera(), 0.3);
            let Some(found) = scene.confirm(&measured, Vector3::zeros(), tolerance_px) else { continue };
            for (power, count) in (1..).zip(&mut frequency) {
                *count += usize::from(found.log10_chance <= -(power as f32));
            }
        }
        std::println!("{measured} of {stars}: {frequency:?} of {TRIALS} at 1e-1, 1e-2, 1e-3, 1e-4");
        for (power, count) in (1..).zip(frequency) {
            let stated = TRIALS as f64 * 10f64.powi(-power);
            assert!(count as f64 <= stated + 3.0 * stated.sqrt(), "{count} below 1e-{power}");
        }
    }
}

#[test]
fn of_two_measured_stars_within_the_radius_neither_is_named() {
    let mut generator = Generator::new(73);
    for _ in 0..100 {
        let scene = Scene::of(&mut generator, 20);
        let mut picture = scene.picture.clone().noisy(&mut generator, 0.1);
        let twin = generator.bits() as u8 % 20;
        let (sine, cosine) = generator.between(0.0, std::f64::consts::TAU).sin_cos();
        let [x, y] = picture.spots[usize::from(twin)].centre_px;
        picture.spots.push(Spot { centre_px: [x + 0.8 * cosine, y + 0.8 * sine], star: None });
        let confirmed = scene.confirm(&picture.measured(&camera(), 0.1), Vector3::zeros(), 1.5).unwrap();
        let expected: List<u8> = (0..20).filter(|index| *index != twin).collect();
        assert_eq!(named(&confirmed), expected);
    }
}

#[test]
fn of_two_catalogue_stars_at_one_place_the_brighter_gives_the_name() {
    let mut generator = Generator::new(74);
    let mut places = places(&mut generator, 15, 20.0);
    places.push([places[4][0] + 0.3, places[4][1]]);
    let scene = Scene::new(&mut generator, &places, |_| false);
    let mut picture = scene.picture.clone();
    picture.spots.pop();
    let confirmed = scene.confirm(&picture.measured(&camera(), 0.1), Vector3::zeros(), 1.5).unwrap();
    assert_eq!((confirmed.expected, wrong_names(&confirmed, &picture)), (16, 0));
    assert_eq!(named(&confirmed), (0..15).collect::<List<u8>>());
}

#[test]
fn stars_with_a_close_neighbour_are_named_but_do_not_turn_the_attitude() {
    let mut generator = Generator::new(75);
    for _ in 0..50 {
        let places = places(&mut generator, 20, 20.0);
        let scene = Scene::new(&mut generator, &places, |index| index % 5 == 2);
        let mut picture = scene.picture.clone().noisy(&mut generator, 0.1);
        // The neighbour draws the centre aside, the same way everywhere.
        picture.spots.iter_mut().skip(2).step_by(5).for_each(|spot| spot.centre_px[0] += 1.0);
        let with = scene.confirm(&picture.measured(&camera(), 0.1), Vector3::zeros(), 2.0).unwrap();
        assert_eq!((with.matches.len(), wrong_names(&with, &picture)), (20, 0));
        let mut others = picture.clone();
        others.spots.retain(|spot| spot.star.is_some_and(|star| star % 5 != 2));
        let without = scene.confirm(&others.measured(&camera(), 0.1), Vector3::zeros(), 2.0).unwrap();
        assert_eq!(without.matches.len(), 16);
        assert_eq!(with.attitude.matrix(), without.attitude.matrix());
    }
}

#[test]
fn with_fewer_than_three_others_the_stars_with_a_close_neighbour_serve() {
    let mut generator = Generator::new(76);
    let places = places(&mut generator, 8, 60.0);
    for others in 0..=2 {
        let scene = Scene::new(&mut generator, &places, |index| index >= others);
        let picture = scene.picture.clone().noisy(&mut generator, 0.1);
        // Sigmas so large that no residual is doubted: all stars weigh the same, here and below.
        let confirmed = scene.confirm(&picture.measured(&camera(), 0.4), Vector3::zeros(), 1.5).unwrap();
        assert_eq!(confirmed.matches.len(), 8);
        let oracle = wahba_of(&picture, &scene, |_| true);
        assert!(oracle::small_turn(&oracle, &oracle::wide_matrix(confirmed.attitude.matrix())).norm() < 1e-6);
    }
}

/// The attitude of the named stars by Davenport's q.
fn wahba_of(picture: &Picture, scene: &Scene, used: impl Fn(usize) -> bool) -> Matrix3<f64> {
    let ray = |[x, y]: [f64; 2]| Vector3::new((x - 511.5) / 3889.0, (y - 511.5) / 3889.0, 1.0).normalize();
    let pairs: List<_> = picture
        .spots
        .iter()
        .filter_map(|spot| {
            let star = usize::from(spot.star.filter(|star| used(usize::from(*star)))?);
            let reference = scene.picture.look.transpose() * ray(scene.picture.spots[star].centre_px);
            Some((ray(spot.centre_px), reference, 1.0))
        })
        .collect();
    oracle::wahba(&pairs)
}

#[test]
fn attitude_and_residuals_are_those_of_an_f64_solution() {
    let mut generator = Generator::new(77);
    let (mut worst_px, mut worst_rms) = (0.0f64, 0.0f64);
    for _ in 0..200 {
        let scene = Scene::of(&mut generator, 25);
        let picture = scene.picture.clone().noisy(&mut generator, 0.3);
        let confirmed = scene.confirm(&picture.measured(&camera(), 1.0), Vector3::zeros(), 3.0).unwrap();
        assert_eq!(confirmed.matches.len(), 25);
        let solved = wahba_of(&picture, &scene, |_| true);
        let mut square = 0.0;
        for found in &confirmed.matches {
            let [seen, there] =
                [&picture, &scene.picture].map(|picture| picture.spots[usize::from(found.measured)]);
            let [x, y] = there.centre_px;
            let ray = Vector3::new((x - 511.5) / 3889.0, (y - 511.5) / 3889.0, 1.0).normalize();
            let at = oracle::project(&camera_parameters(), &(solved * scene.picture.look.transpose() * ray));
            for ((seen, at), found) in seen.centre_px.iter().zip(at).zip(found.residual_px) {
                let residual = seen - at;
                worst_px = worst_px.max((residual - f64::from(found)).abs());
                square += residual * residual;
            }
        }
        worst_rms = worst_rms.max((f64::from(confirmed.rms_px) - (square / 50.0).sqrt()).abs());
    }
    std::println!("residuals within {worst_px:.1e} px, rms within {worst_rms:.1e} px");
    assert!(worst_px < 5e-3 && worst_rms < 5e-4, "{worst_px} px, {worst_rms} px");
}

#[test]
fn the_focal_length_the_field_asks_for_is_returned() {
    let mut generator = Generator::new(78);
    let mut worst = 0.0f64;
    for _ in 0..100 {
        for ratio in [0.998, 0.9995, 1.0, 1.0002, 1.002] {
            let scene = Scene::of(&mut generator, 20);
            let mut picture = scene.picture.clone();
            for spot in &mut picture.spots {
                spot.centre_px = spot.centre_px.map(|x| 511.5 + (x - 511.5) * ratio);
            }
            let confirmed = scene.confirm(&picture.measured(&camera(), 0.3), Vector3::zeros(), 4.0).unwrap();
            assert_eq!(confirmed.matches.len(), 20);
            worst = worst.max((f64::from(confirmed.focal_ratio.ratio) - ratio).abs());
        }
    }
    std::println!("focal ratio within {worst:.1e}");
    assert!(worst < 1e-4, "{worst}");
}

/// Mean square error of attitudes in stated sigmas, when the centroids err by `ratio` of what they say.
fn stated_against_true(seed: u64, stars: usize, ratio: f64) -> f64 {
    let mut generator = Generator::new(seed);
    const TRIALS: usize = 400;
    let sum: f64 = (0..TRIALS)
        .map(|_| {
            let scene = Scene::of(&mut generator, stars);
            let picture = scene.picture.clone().noisy(&mut generator, 0.2 * ratio);
            let confirmed = scene.confirm(&picture.measured(&camera(), 0.2), Vector3::zeros(), 6.0).unwrap();
            chi_square(&confirmed, &picture)
        })
        .sum();
    sum / TRIALS as f64
}

#[test]
fn the_stated_sigmas_cover_the_error_whatever_the_centroids_say_of_themselves() {
    // 3 is honest; more says too little error, less too much.
    for (seed, stars, ratio, low, high) in [
        (80, 30, 1.0, 2.5, 3.5),
        (81, 30, 3.0, 2.5, 3.7),
        (82, 30, 0.3, 0.5, 3.0),
        (83, 6, 1.0, 2.0, 4.0),
        (84, 6, 3.0, 2.5, 5.0),
        (85, 6, 0.3, 0.2, 3.0),
    ] {
        let mean = stated_against_true(seed, stars, ratio);
        std::println!("{stars} stars, errors {ratio} of those stated: chi square {mean:.2}");
        assert!((low..high).contains(&mean), "{stars} stars, {ratio}: {mean}");
    }
}

#[test]
fn residuals_larger_than_the_sigmas_widen_the_stated_sigmas_in_proportion() {
    let mut generator = Generator::new(86);
    let sigmas = |generator: &mut Generator, scene: &Scene, noise_px| {
        let picture = scene.picture.clone().noisy(generator, noise_px);
        let confirmed = scene.confirm(&picture.measured(&camera(), 0.2), Vector3::zeros(), 8.0).unwrap();
        f64::from(confirmed.sigma_rad[2])
    };
    let mut sum = 0.0;
    for _ in 0..100 {
        let scene = Scene::of(&mut generator, 40);
        sum += sigmas(&mut generator, &scene, 0.8) / sigmas(&mut generator, &scene, 0.2);
    }
    assert!((sum / 100.0 - 4.0).abs() < 0.3, "{}", sum / 100.0);
}

#[test]
fn fewer_than_three_stars_confirm_nothing() {
    let mut generator = Generator::new(87);
    let scene = Scene::of(&mut generator, 10);
    let measured = scene.picture.measured(&camera(), 0.1);
    for count in 0..3 {
        assert!(scene.confirm(&measured[..count], Vector3::zeros(), 1.5).is_none(), "{count}");
    }
    assert_eq!(scene.confirm(&measured[..3], Vector3::zeros(), 1.5).unwrap().matches.len(), 3);
}

#[test]
fn widening_recovers_the_stars_that_noise_put_outside_the_tolerance() {
    let mut generator = Generator::new(88);
    let (mut trials, mut narrow, mut wide, mut wrong, mut chi) = (0, 0, 0, 0, 0.0);
    for _ in 0..300 {
        let scene = Scene::of(&mut generator, 40);
        let picture = scene.picture.clone().noisy(&mut generator, 2.0);
        let Some((first, widened)) = scene.confirm_and_widen(&picture.measured(&camera(), 2.0), 1.5) else {
            continue;
        };
        trials += 1;
        narrow += first.matches.len();
        wide += widened.matches.len();
        wrong += wrong_names(&widened, &picture);
        chi += chi_square(&widened, &picture);
        assert_eq!(first.log10_chance, widened.log10_chance, "the evidence is that of the narrow match");
    }
    let share = wide as f64 / (40 * trials) as f64;
    std::println!(
        "{trials} trials: {narrow} stars, widened {wide} ({share:.3}), {wrong} wrong, chi square {:.2}",
        chi / f64::from(trials)
    );
    assert!(trials > 290 && share > 0.97 && wrong == 0, "{trials} {share} {wrong}");
}

#[test]
fn widening_takes_no_chance_matches_where_the_tolerance_was_right() {
    let mut generator = Generator::new(89);
    for _ in 0..300 {
        // Of 40 catalogue stars 20 are seen, between 40 false ones.
        let scene = Scene::of(&mut generator, 40);
        let mut picture = scene.picture.clone().noisy(&mut generator, 0.3);
        picture.spots.retain(|spot| spot.star.is_some_and(|star| star % 2 == 0));
        let picture = picture.with_false_stars(&mut generator, 40);
        let (narrow, widened) = scene.confirm_and_widen(&picture.measured(&camera(), 0.3), 1.5).unwrap();
        assert_eq!(named(&narrow), named(&widened));
    }
}

#[test]
fn an_outlier_within_the_tolerance_hardly_turns_the_attitude() {
    let mut generator = Generator::new(79);
    for _ in 0..50 {
        let scene = Scene::of(&mut generator, 25);
        let mut picture = scene.picture.clone().noisy(&mut generator, 0.02);
        let clean = scene.confirm(&picture.measured(&camera(), 0.02), Vector3::zeros(), 3.0).unwrap();
        // A proton in the image of the third star.
        picture.spots[2].centre_px[0] += 1.5;
        let hit = scene.confirm(&picture.measured(&camera(), 0.02), Vector3::zeros(), 3.0).unwrap();
        let turn = hit.attitude.angle_from(&clean.attitude) * 3889.0;
        // 1.5 px in one of 25 stars would turn it by 0.06 px.
        assert!(libm::hypotf(turn.x, turn.y) < 0.02, "{turn:?}");
        assert!(hit.sigma_rad[0] < 2.5 * clean.sigma_rad[0], "{:?} {:?}", hit.sigma_rad, clean.sigma_rad);
    }
}

#[test]
fn a_bright_star_at_the_border_does_not_draw_the_roll_along() {
    let mut generator = Generator::new(90);
    let mut worst = 0.0f64;
    for _ in 0..100 {
        // It fixes three quarters of the roll, so that its residual is a quarter of its error.
        let mut places = places(&mut generator, 14, 20.0);
        places.iter_mut().for_each(|place| *place = place.map(|x| 511.5 + 0.5 * (x - 511.5)));
        places.insert(0, [980.0, 980.0]);
        let scene = Scene::new(&mut generator, &places, |_| false);
        let mut picture = scene.picture.clone().noisy(&mut generator, 0.1);
        picture.spots[0].centre_px = [980.0 + 0.57, 980.0 - 0.57];
        let mut measured = picture.measured(&camera(), 0.2);
        measured[0].sigma_px = 0.1;
        let confirmed = scene.confirm(&measured, Vector3::zeros(), 3.0).unwrap();
        let roll = scene.picture.error_of(&confirmed.attitude).z;
        worst = worst.max(roll.abs() / f64::from(confirmed.sigma_rad[2]));
    }
    // Off by eight sigma across; with residuals as they stand the roll was 8.2 sigma off.
    std::println!("roll {worst:.2} sigma off at worst");
    assert!(worst < 4.0, "{worst}");
}

#[test]
fn the_columns_find_what_a_look_at_every_star_finds() {
    let mut generator = Generator::new(78);
    let camera = camera();
    let bytes = sample::bytes(&[], 26, 0);
    let catalogue = Catalogue::open(&bytes).unwrap();
    let [width, height] = [camera.parameters().width_px, camera.parameters().height_px].map(f64::from);
    for radius_px in [0.3, 3.0, 40.0, 400.0] {
        let mut found = 0;
        for _ in 0..40 {
            let mut place =
                |margin: f64| [width, height].map(|side| generator.between(-margin, side + margin) as f32);
            let stars: List<MeasuredStar> =
                (0..MAX_MEASURED).map(|_| MeasuredStar::new(&camera, place(0.0), 0.1).unwrap()).collect();
            let columns = ColumnIndex::new(&StarField::whole(&stars, &catalogue, &camera), radius_px);
            for star in &stars {
                let [x, y] = place(1.5 * f64::from(radius_px));
                let [near_x, near_y] = star.centre_px;
                for at in [[x, y], [near_x + 0.7 * radius_px, near_y], [near_x - radius_px, near_y]] {
                    let offsets = (0u8..)
                        .zip(&stars)
                        .map(|(index, star)| (index, [star.centre_px[0] - at[0], star.centre_px[1] - at[1]]));
                    let near: List<_> =
                        offsets.filter(|(_, [dx, dy])| dx * dx + dy * dy < radius_px * radius_px).collect();
                    let only = if let [only] = near[..] { Some(only) } else { None };
                    assert_eq!(columns.only_star_near(at, radius_px), only);
                    found += usize::from(only.is_some());
                }
            }
        }
        assert!(found > 100 || radius_px > 100.0, "{found} at {radius_px}");
    }
}
