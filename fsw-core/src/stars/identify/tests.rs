use super::*;
use crate::camera::{Camera, CameraParameters};
use crate::catalog::{Catalogue, sample};
use crate::oracle::Generator;
use crate::stars::artificial::{Picture, SKY, Spot, camera, camera_parameters, false_star};
use crate::stars::polygon::KEPT_POLYGONS;
use crate::stars::{MAX_MEASURED, MeasuredStar};
use std::collections::BTreeSet;
use std::vec::Vec as List;

/// As large as flight's.
type Search = Identifier<1024, 1536, 2048>;

/// All in one call.
fn search(measured: &[MeasuredStar], camera: &Camera) -> Progress {
    let catalogue = SKY.catalogue();
    let field = StarField::whole(measured, &catalogue, camera);
    Search::new().advance(&field, &IdentificationParameters::default(), u32::MAX)
}

/// What became of a number of pictures.
#[derive(Default, Debug)]
struct Tally {
    pictures: usize,
    identified: usize,
    /// Names given, and those of them that are not the star's.
    names: usize,
    wrong_names: usize,
    /// True stars in identified pictures that got no name.
    unnamed: usize,
    wrong_attitudes: usize,
    /// Squared errors of the attitudes' three angles in stated sigmas, summed.
    chi_square: f64,
}

impl Tally {
    fn count(&mut self, picture: &Picture, progress: &Progress) {
        self.pictures += 1;
        let Progress::Identified(confirmed, log10_false) = progress else { return };
        assert!(*log10_false <= -9.0);
        self.identified += 1;
        let star_of = |seen: u8| picture.spots[usize::from(seen)].star;
        self.names += confirmed.matches.len();
        self.wrong_names +=
            confirmed.matches.iter().filter(|found| star_of(found.measured) != Some(found.star)).count();
        let named: BTreeSet<u8> = confirmed.matches.iter().map(|found| found.measured).collect();
        assert_eq!(named.len(), confirmed.matches.len(), "a measured star has two names");
        let true_stars =
            (0..picture.spots.len().min(MAX_MEASURED) as u8).filter(|seen| star_of(*seen).is_some());
        self.unnamed += true_stars.filter(|seen| !named.contains(seen)).count();
        let error = picture.error_of(&confirmed.attitude);
        // A pixel is 2.6e-4 rad: twenty across and 0.7 degrees about the line of sight are beyond any noise
        // here.
        self.wrong_attitudes += usize::from(error.xy().norm() > 5e-3 || error.z.abs() > 12e-3);
        let in_sigmas = error.iter().zip(confirmed.sigma_rad).map(|(error, sigma)| error / f64::from(sigma));
        let chi_square = in_sigmas.map(|error| error * error).sum::<f64>();
        self.chi_square += chi_square;
    }
}

/// Tries pictures of the sky, each made by `change` from what the camera truly sees.
fn campaign(seed: u64, pictures: usize, change: impl Fn(Picture, &mut Generator) -> Picture) -> Tally {
    let (camera, mut generator, mut tally) = (camera(), Generator::new(seed), Tally::default());
    while tally.pictures < pictures {
        let look = generator.rotation();
        let picture = Picture::of(&SKY, &camera_parameters(), look);
        // Five are what 1e-9 takes; without them there is nothing to require.
        if picture.spots.len() >= 6 {
            let picture = change(picture, &mut generator);
            tally.count(&picture, &search(&picture.measured(&camera, 0.3), &camera));
        }
    }
    std::println!("{tally:?}");
    assert_eq!(tally.wrong_attitudes, 0, "{tally:?}");
    tally
}

#[test]
fn every_clean_sky_is_identified_and_every_name_is_right() {
    let tally = campaign(1, 500, |picture, generator| picture.noisy(generator, 0.3));
    assert_eq!((tally.identified, tally.wrong_names), (500, 0), "{tally:?}");
    assert!(tally.unnamed * 100 <= tally.names, "{tally:?}");
    // Three angles: 3 is what honest sigmas give.
    assert!((2.7..3.5).contains(&(tally.chi_square / 500.0)), "{tally:?}");
}

#[test]
fn noise_of_one_and_two_pixels_is_met_by_the_wider_tolerances() {
    for (seed, sigma_px, least) in [(2, 1.0, 198), (3, 2.0, 180)] {
        let tally = campaign(seed, 200, |picture, generator| picture.noisy(generator, sigma_px));
        assert!(tally.identified >= least, "{sigma_px} px: {tally:?}");
        assert!(tally.wrong_names * 1000 <= tally.names, "{sigma_px} px: {tally:?}");
    }
}

#[test]
fn false_stars_of_any_brightness_neither_hide_the_true_nor_take_their_names() {
    for (seed, count, least) in [(4, 5, 200), (5, 20, 190)] {
        let tally = campaign(seed, 200, |picture, generator| {
            picture.noisy(generator, 0.3).with_false_stars(generator, count)
        });
        assert!(tally.identified >= least, "{count} false: {tally:?}");
        assert!(tally.wrong_names * 1000 <= tally.names, "{count} false: {tally:?}");
    }
}

#[test]
fn the_order_of_the_stars_does_not_decide() {
    let tally = campaign(6, 200, |picture, generator| picture.noisy(generator, 0.3).shuffled(generator));
    assert_eq!((tally.identified, tally.wrong_names), (200, 0), "{tally:?}");
}

#[test]
fn stars_three_sigma_off_spoil_no_name() {
    let tally = campaign(7, 200, |picture, generator| {
        let mut picture = picture.noisy(generator, 0.3);
        for spot in picture.spots.iter_mut().step_by(4) {
            let (sine, cosine) = generator.between(0.0, std::f64::consts::TAU).sin_cos();
            spot.centre_px[0] += 0.9 * cosine;
            spot.centre_px[1] += 0.9 * sine;
        }
        picture
    });
    assert_eq!((tally.identified, tally.wrong_names), (200, 0), "{tally:?}");
}

#[test]
fn stars_missing_from_the_picture_are_not_missed() {
    let tally = campaign(8, 200, |picture, generator| {
        let mut picture = picture.noisy(generator, 0.3);
        let mut place = 0;
        // Every other star goes while six remain.
        let mut left = picture.spots.len();
        picture.spots.retain(|_| {
            place += 1;
            let goes = place % 2 == 0 && left > 6;
            left -= usize::from(goes);
            !goes
        });
        picture
    });
    assert!(tally.identified >= 199 && tally.wrong_names == 0, "{tally:?}");
}

/// Everything of a result that could differ.
fn digest(progress: &Progress) -> std::string::String {
    std::format!("{progress:?}")
}

#[test]
fn a_search_resumed_with_small_allowances_ends_as_one_in_one_go() {
    let (camera, catalogue, mut generator) = (camera(), SKY.catalogue(), Generator::new(9));
    let parameters = IdentificationParameters::default();
    let mut most_calls = 0;
    for picture in 0..12 {
        let look = generator.rotation();
        let mut seen = Picture::of(&SKY, &camera_parameters(), look).noisy(&mut generator, 0.3);
        match picture % 3 {
            0 => seen = seen.with_false_stars(&mut generator, 10),
            1 => seen = seen.noisy(&mut generator, 1.5),
            _ => seen.spots.iter_mut().for_each(|spot| *spot = false_star(&mut generator)),
        }
        let measured = seen.measured(&camera, 0.3);
        let field = StarField::whole(&measured, &catalogue, &camera);
        let mut at_once = Search::new();
        let whole = at_once.advance(&field, &parameters, u32::MAX);
        assert!(!matches!(whole, Progress::Searching));
        for allowance in [1, 1000, 30_000] {
            let (mut resumed, mut calls) = (Search::new(), 0);
            let end = loop {
                calls += 1;
                // A corner a call at the least, and the end of each side.
                assert!(calls <= MAX_SIDES * (SEARCHED + 1), "no end");
                match resumed.advance(&field, &parameters, allowance) {
                    Progress::Searching => {}
                    end => break end,
                }
            };
            assert_eq!(digest(&end), digest(&whole), "allowance {allowance}");
            assert_eq!(std::format!("{:?}", resumed.polygons()), std::format!("{:?}", at_once.polygons()));
            assert_eq!(resumed.hypotheses(), at_once.hypotheses());
            most_calls = most_calls.max(calls);
        }
    }
    assert!(most_calls > 100, "{most_calls}");
}

#[test]
fn an_allowance_is_overdrawn_by_no_more_than_one_side() {
    let (camera, catalogue, mut generator) = (camera(), SKY.catalogue(), Generator::new(10));
    let look = generator.rotation();
    let mut noise = Picture::of(&SKY, &camera_parameters(), look);
    noise.spots.resize_with(30, || false_star(&mut generator));
    noise.spots.iter_mut().for_each(|spot| *spot = false_star(&mut generator));
    let measured = noise.measured(&camera, 0.3);
    let field = StarField::whole(&measured, &catalogue, &camera);
    let mut search = Search::new();
    // Without an allowance nothing is tried; with the least, one side a call.
    assert!(matches!(search.advance(&field, &Default::default(), 0), Progress::Searching));
    assert_eq!(search.hypotheses(), 0.0);
    let mut before = 0.0;
    for _ in 0..50 {
        assert!(matches!(search.advance(&field, &Default::default(), 1), Progress::Searching));
        let tried = search.hypotheses() - before;
        assert!(tried <= 1536.0, "{tried}");
        before = search.hypotheses();
    }
    assert!(before > 0.0);
}

#[test]
fn the_candidates_stay_readable_best_first_and_the_best_is_the_solution() {
    let (camera, catalogue, mut generator) = (camera(), SKY.catalogue(), Generator::new(11));
    for _ in 0..50 {
        let look = generator.rotation();
        let picture = Picture::of(&SKY, &camera_parameters(), look).noisy(&mut generator, 0.3);
        let measured = picture.measured(&camera, 0.3);
        let field = StarField::whole(&measured, &catalogue, &camera);
        let mut search = Search::new();
        assert!(search.polygons().is_empty());
        if !matches!(search.advance(&field, &Default::default(), u32::MAX), Progress::Identified(..)) {
            continue;
        }
        let polygons = search.polygons();
        assert!((1..=KEPT_POLYGONS).contains(&polygons.len()));
        assert!(polygons.is_sorted_by(|one, other| {
            let (ours, theirs) = (one.corners.len(), other.corners.len());
            ours > theirs || (ours == theirs && one.mean_square_error <= other.mean_square_error)
        }));
        for (seen, name) in &polygons[0].corners {
            assert_eq!(picture.spots[usize::from(*seen)].star, Some(*name));
        }
        for polygon in polygons {
            assert!(polygon.corners.len() >= 3 && (0.0..=1.0).contains(&polygon.mean_square_error));
            let (seen, names): (BTreeSet<u8>, BTreeSet<u16>) = polygon.corners.iter().copied().unzip();
            assert_eq!((seen.len(), names.len()), (polygon.corners.len(), polygon.corners.len()));
        }
        search.restart(0.0);
        assert!(search.polygons().is_empty() && search.hypotheses() == 0.0);
    }
}

#[test]
fn hypotheses_tried_before_count_against_a_result() {
    let (camera, catalogue, mut generator) = (camera(), SKY.catalogue(), Generator::new(12));
    let look = generator.rotation();
    let picture = Picture::of(&SKY, &camera_parameters(), look).noisy(&mut generator, 0.3);
    let measured = picture.measured(&camera, 0.3);
    let field = StarField::whole(&measured, &catalogue, &camera);
    let mut search = Search::new();
    let mut log10_after = |before: f32| {
        search.restart(before);
        match search.advance(&field, &Default::default(), u32::MAX) {
            Progress::Identified(_, log10_false) => log10_false,
            other => panic!("{other:?}"),
        }
    };
    let (fresh, late) = (log10_after(0.0), log10_after(1e8));
    assert!(late > fresh + 3.0 && late < fresh + 8.0, "{fresh}, {late}");
}

#[test]
fn nothing_is_accepted_above_the_limit_of_false_identification() {
    let (camera, catalogue, mut generator) = (camera(), SKY.catalogue(), Generator::new(13));
    let strict = IdentificationParameters { log10_false_limit: -200.0, ..Default::default() };
    let look = generator.rotation();
    let picture = Picture::of(&SKY, &camera_parameters(), look).noisy(&mut generator, 0.3);
    let measured = picture.measured(&camera, 0.3);
    let field = StarField::whole(&measured, &catalogue, &camera);
    let mut search = Search::new();
    let end = search.advance(&field, &strict, u32::MAX);
    assert!(matches!(end, Progress::NotIdentified(NotIdentified::NoMatch)), "{end:?}");
    // The candidates tell the operator what was refused.
    assert!(search.polygons()[0].corners.len() >= 4);
    // The next image's stars are sought near the likeliest.
    assert!(picture.error_of(search.likeliest().unwrap()).norm() < 1e-3);
    // Asked again, it says the same.
    let again = search.advance(&field, &strict, u32::MAX);
    assert!(matches!(again, Progress::NotIdentified(NotIdentified::NoMatch)));
    search.restart(0.0);
    assert!(search.likeliest().is_none());
}

#[test]
fn fewer_than_three_stars_are_too_few() {
    let (camera, mut generator) = (camera(), Generator::new(14));
    let look = generator.rotation();
    let picture = Picture::of(&SKY, &camera_parameters(), look);
    let measured = picture.measured(&camera, 0.3);
    for count in 0..3 {
        let end = search(&measured[..count], &camera);
        assert!(matches!(end, Progress::NotIdentified(NotIdentified::TooFewStars)), "{end:?}");
    }
    let end = search(&measured[..3], &camera);
    assert!(!matches!(end, Progress::NotIdentified(NotIdentified::TooFewStars)), "{end:?}");
}

#[test]
fn without_a_separation_in_the_catalogues_range_there_are_no_sides() {
    let camera = camera();
    let star = |x: f32, y: f32| MeasuredStar::new(&camera, [x, y], 0.3).unwrap();
    // All within 8 px: too short to have a direction. Corners: farther apart than the catalogue's 10 deg.
    let close = [star(500.0, 500.0), star(505.0, 500.0), star(500.0, 506.0), star(504.0, 504.0)];
    let far = [star(0.0, 0.0), star(1023.0, 0.0), star(0.0, 1023.0), star(1023.0, 1023.0)];
    for measured in [close, far] {
        let end = search(&measured, &camera);
        assert!(matches!(end, Progress::NotIdentified(NotIdentified::NoSides)), "{end:?}");
    }
    let bytes = sample::bytes(&[], 17, 1 << 28);
    let empty = Catalogue::open(&bytes).unwrap();
    let measured = [star(100.0, 100.0), star(400.0, 100.0), star(400.0, 300.0)];
    let field = StarField::whole(&measured, &empty, &camera);
    let end = Search::new().advance(&field, &Default::default(), u32::MAX);
    assert!(matches!(end, Progress::NotIdentified(NotIdentified::NoSides)), "{end:?}");
}

#[test]
fn pure_noise_is_not_identified_and_the_reason_is_no_match() {
    let (camera, mut generator) = (camera(), Generator::new(15));
    for count in [3, 4, 5, 6, 8, 10, 12, 16, 20, 30, 64] {
        for _ in 0..3 {
            let spots = (0..count).map(|_| false_star(&mut generator)).collect();
            let picture = Picture { spots, look: generator.rotation() };
            let end = search(&picture.measured(&camera, 0.3), &camera);
            assert!(matches!(end, Progress::NotIdentified(NotIdentified::NoMatch)), "{count}: {end:?}");
        }
    }
}

#[test]
fn a_focal_length_wrong_by_5_percent_is_never_identified() {
    let mut generator = Generator::new(16);
    for factor in [0.95, 1.05] {
        let focal_length_px = camera_parameters().focal_length_px * factor;
        let wrong = Camera::new(CameraParameters { focal_length_px, ..camera_parameters() }).unwrap();
        for _ in 0..15 {
            let look = generator.rotation();
            let picture = Picture::of(&SKY, &camera_parameters(), look).noisy(&mut generator, 0.3);
            let end = search(&picture.measured(&wrong, 0.3), &wrong);
            assert!(matches!(end, Progress::NotIdentified(_)), "{factor}: {end:?}");
        }
    }
}

#[test]
fn a_mirrored_field_is_never_identified() {
    let (camera, mut generator) = (camera(), Generator::new(17));
    for _ in 0..30 {
        let look = generator.rotation();
        let mut picture = Picture::of(&SKY, &camera_parameters(), look).noisy(&mut generator, 0.3);
        picture.spots.iter_mut().for_each(|spot| spot.centre_px[0] = 1023.0 - spot.centre_px[0]);
        let end = search(&picture.measured(&camera, 0.3), &camera);
        assert!(matches!(end, Progress::NotIdentified(_)), "{end:?}");
    }
}

#[test]
fn stars_beyond_the_64_brightest_change_nothing() {
    let (camera, mut generator) = (camera(), Generator::new(18));
    for _ in 0..5 {
        let look = generator.rotation();
        let seen = Picture::of(&SKY, &camera_parameters(), look).noisy(&mut generator, 0.3);
        let mut crowded = seen.clone();
        crowded.spots.resize_with(150, || false_star(&mut generator));
        let measured = crowded.measured(&camera, 0.3);
        let (all, first) = (search(&measured, &camera), search(&measured[..MAX_MEASURED], &camera));
        assert_eq!(digest(&all), digest(&first));
        // True stars behind 64 false ones do not exist.
        let mut hidden: List<_> = (0..MAX_MEASURED).map(|_| false_star(&mut generator)).collect();
        hidden.extend(&seen.spots);
        let hidden = Picture { spots: hidden, look };
        let end = search(&hidden.measured(&camera, 0.3), &camera);
        assert!(matches!(end, Progress::NotIdentified(NotIdentified::NoMatch)), "{end:?}");
    }
}

#[test]
fn a_tolerance_is_three_sigmas_of_the_difference_of_two_stars() {
    let parameters = IdentificationParameters::default();
    for (step, sigma_px) in [0.35f32, 1.0, 2.0].into_iter().enumerate() {
        let expected = 3.0 * (2.0 * sigma_px * sigma_px).sqrt();
        assert!((parameters.tolerance_px(step) - expected).abs() < 1e-5);
    }
    let camera = camera();
    let [a, b] = [[100.0, 200.0], [900.0, 700.0]].map(|at| MeasuredStar::new(&camera, at, 0.3).unwrap());
    let side = parameters.side(1, &a, &b, &camera);
    let chord = (a.direction.vector() - b.direction.vector()).norm();
    assert!((side.chord - chord).abs() < 1e-6);
    assert!((side.tolerance - (4.242_64 / 3889.0 + 2e-4 * chord)).abs() < 1e-8);
}

/// Holds every side of a polygon against the tolerance, in f64; gives the mean square of the errors in
/// tolerances.
fn mean_square_error(polygon: &Polygon, field: &StarField, sigma_px: f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (at, (one_seen, one_name)) in polygon.corners.iter().enumerate() {
        for (other_seen, other_name) in &polygon.corners[..at] {
            let direction = |seen: u8| field.measured()[usize::from(seen)].direction.vector().map(f64::from);
            let unit = |name: u16| field.catalogue.unit(name).unwrap().map(f64::from);
            let measured = (direction(*one_seen) - direction(*other_seen)).norm();
            let named = (unit(*one_name) - unit(*other_name)).norm();
            let tolerance = 3.0 * 2f64.sqrt() * sigma_px / 3889.0 + 2e-4 * measured;
            let error = (measured - named) / tolerance;
            assert!(error.abs() < 1.001, "a side is {error} tolerances off: {polygon:?}");
            sum += error * error;
            count += 1.0;
        }
    }
    sum / count
}

#[test]
fn all_separations_of_a_polygon_fit_and_its_error_is_their_mean_square() {
    let (camera, catalogue, mut generator) = (camera(), SKY.catalogue(), Generator::new(19));
    // One tolerance only, so that it is known which; chance builds many polygons.
    let parameters = IdentificationParameters { centroid_sigma_px: [1.5; 3], ..Default::default() };
    let mut larger = 0;
    for _ in 0..6 {
        let spots = (0..40).map(|_| false_star(&mut generator)).collect();
        let picture = Picture { spots, look: generator.rotation() };
        let measured = picture.measured(&camera, 0.3);
        let field = StarField::whole(&measured, &catalogue, &camera);
        let mut search = Search::new();
        search.advance(&field, &parameters, 1_000_000);
        assert!(!search.polygons().is_empty());
        for polygon in search.polygons() {
            let mean = mean_square_error(polygon, &field, 1.5);
            assert!((mean - f64::from(polygon.mean_square_error)).abs() < 1e-3, "{mean}: {polygon:?}");
            larger += usize::from(polygon.corners.len() > 3);
        }
    }
    assert!(larger > 10, "{larger}");
}

#[test]
fn where_catalogue_stars_stand_together_a_polygon_names_each_star_once() {
    let (camera, mut generator) = (camera(), Generator::new(20));
    let mut polygons = 0;
    for both_seen in [false, true] {
        let look = generator.rotation();
        let (mut stars, mut spots) = (List::new(), List::new());
        for hip in 0..16 {
            let ahead = generator.unit_in_cap(0.1);
            for twin in 0..2u32 {
                let direction = (ahead + generator.gaussian_vector() * 1e-4).normalize();
                let centre_px = crate::oracle::project(&camera_parameters(), &direction);
                if both_seen || twin == 0 {
                    spots.push(Spot { centre_px, star: Some(stars.len() as u16) });
                }
                stars.push(sample::star(&(look.transpose() * direction), 2 * hip + twin + 1));
            }
        }
        let bytes = sample::bytes(&stars, 17, 1 << 28);
        let catalogue = Catalogue::open(&bytes).unwrap();
        let picture = Picture { spots, look };
        let measured = picture.measured(&camera, 0.3);
        let field = StarField::whole(&measured, &catalogue, &camera);
        // Nothing is accepted, so that all sides are tried.
        let parameters = IdentificationParameters { log10_false_limit: -1e9, ..Default::default() };
        let mut search = Search::new();
        search.advance(&field, &parameters, 300_000);
        for polygon in search.polygons() {
            let (seen, names): (BTreeSet<u8>, BTreeSet<u16>) = polygon.corners.iter().copied().unzip();
            assert_eq!((seen.len(), names.len()), (polygon.corners.len(), polygon.corners.len()));
            polygons += 1;
        }
    }
    assert!(polygons > 8, "{polygons}");
}
