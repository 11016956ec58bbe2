use super::*;
use crate::image::SPOT;
use crate::oracle::Generator;
use std::vec::Vec as List;

fn spot([x, y]: [f64; 2], brightness: i32) -> Detection {
    Detection {
        x_q16: (x * 65_536.0) as i32,
        y_q16: (y * 65_536.0) as i32,
        flux: brightness,
        core_flux: brightness,
        sigma_q16: 6000,
        ..SPOT
    }
}

fn image(places: impl IntoIterator<Item = ([f64; 2], i32)>) -> Detections {
    let mut detections = Detections::new();
    for (at, brightness) in places {
        detections.insert(spot(at, brightness));
    }
    detections.settle();
    detections
}

fn anywhere(generator: &mut Generator) -> [f64; 2] {
    [generator.between(5.0, 1275.0), generator.between(5.0, 1019.0)]
}

#[test]
fn a_few_faint_stars_that_moved_alike_come_before_eighty_bright_false_ones() {
    let mut generator = Generator::new(5);
    for _ in 0..200 {
        let stars: List<_> = (0..8).map(|_| anywhere(&mut generator)).collect();
        let moved = [generator.between(-31.0, 31.0), generator.between(-31.0, 31.0)];
        let mut repeated = Repeated::new();
        let mut seen = Detections::new();
        for second in [0.0, 1.0] {
            let at = |star: &[f64; 2]| [star[0] + second * moved[0], star[1] + second * moved[1]];
            let false_stars = (0..80).map(|_| (anywhere(&mut generator), 900));
            let all: List<_> = stars.iter().map(|star| (at(star), 100)).chain(false_stars).collect();
            seen = image(all);
            repeated.put_first(&mut seen);
        }
        let marked = seen.spots().iter().filter(|spot| spot.repeated);
        let (true_ones, false_ones): (List<&Detection>, List<_>) = marked.partition(|spot| spot.flux == 100);
        // A false star beside an old place, so far away as the stars moved: 8 of 200 images have one.
        assert!(
            true_ones.len() == 8 && false_ones.len() <= 2,
            "{} and {}",
            true_ones.len(),
            false_ones.len()
        );
        assert!(seen.spots().iter().take(8 + false_ones.len()).all(|spot| spot.repeated));
        assert!(seen.spots().is_sorted_by_key(|spot| spot.rank()));
    }
}

#[test]
fn what_is_new_in_each_image_keeps_its_order_by_brightness() {
    let mut generator = Generator::new(6);
    let mut repeated = Repeated::new();
    for _ in 0..200 {
        let mut seen = image((0..90).map(|k| (anywhere(&mut generator), 100 + k)));
        let brightness = |seen: &Detections| seen.spots().iter().map(|spot| spot.flux).collect::<List<_>>();
        let before = brightness(&seen);
        repeated.put_first(&mut seen);
        assert!(brightness(&seen) == before && !seen.spots().iter().any(|spot| spot.repeated));
    }
}

#[test]
fn stars_that_moved_farther_than_the_reach_are_new() {
    let stars = [[100.0, 100.0], [300.0, 200.0], [500.0, 900.0], [700.0, 400.0], [1100.0, 800.0]];
    for (shift, is_repeated) in [(0.0, true), (31.0, true), (33.0, false)] {
        let mut repeated = Repeated::new();
        let mut seen = Detections::new();
        for second in [0.0, 1.0] {
            seen = image(stars.map(|[x, y]| ([x + second * shift, y], 100)));
            repeated.put_first(&mut seen);
        }
        assert!(seen.spots().iter().all(|spot| spot.repeated == is_repeated), "{shift}");
    }
}

#[test]
fn a_star_keeps_its_number_as_long_as_it_is_seen_and_no_other_has_it() {
    let mut generator = Generator::new(8);
    let stars: List<_> = (0..8).map(|_| anywhere(&mut generator)).collect();
    let mut repeated = Repeated::new();
    let mut numbers = [0; 8];
    for second in 0..300 {
        // One image of a hundred does not show the first star.
        let hides = |k: usize| k == 0 && second % 100 == 99;
        let at = |k: usize| [stars[k][0] + f64::from(second % 2), stars[k][1]];
        let shown = (0..8).filter(|k| !hides(*k)).map(|k| (at(k), 100 + k as i32));
        // A false star within 2 px of a star may be taken for it.
        let beside = |[x, y]: &[f64; 2]| stars.iter().any(|star| (star[0] - x).hypot(star[1] - y) < 4.0);
        let false_stars: List<_> =
            (0..88).map(|_| anywhere(&mut generator)).filter(|at| !beside(at)).map(|at| (at, 900)).collect();
        let mut seen = image(shown.chain(false_stars));
        repeated.put_first(&mut seen);
        let mut all: List<_> = seen.spots().iter().map(|spot| spot.number).collect();
        all.sort_unstable();
        assert!(all.first() > Some(&0) && all.windows(2).all(|pair| pair[0] < pair[1]), "{all:?}");
        for (k, number) in numbers.iter_mut().enumerate() {
            let Some(star) = seen.spots().iter().find(|spot| spot.flux == 100 + k as i32) else {
                *number = 0;
                continue;
            };
            assert!(*number == 0 || star.number == *number, "star {k} in second {second}");
            *number = star.number;
        }
    }
}
