use super::*;
use crate::harness::star_scene;

fn sky() -> Vec<WorldStar> {
    star_scene::sky().into_iter().filter(|star| star.v <= LIMIT_V).collect()
}

fn true_stars(field: &Field) -> Vec<FieldStar> {
    field.stars.iter().filter(|star| star.hip.is_some()).copied().collect()
}

fn all() -> Vec<Case> {
    grid().into_iter().chain(hard()).chain([skies(), no_stars()]).collect()
}

#[test]
fn cases_have_names_of_their_own() {
    let names: std::collections::HashSet<_> = all().into_iter().map(|case| case.name).collect();
    assert_eq!(names.len(), GRID_NOISE_PX.len() * GRID_FALSE.len() + hard().len() + 2);
}

#[test]
fn a_field_depends_on_case_seed_and_number_alone_and_all_cases_show_the_same_sky() {
    let sky = sky();
    let attitude = Maker::new(&skies(), 7, &sky).unwrap().field(5).quaternion;
    for case in all() {
        let maker = Maker::new(&case, 7, &sky).unwrap();
        let ahead = maker.field(5);
        maker.field(4);
        assert_eq!(maker.field(5), ahead, "{}", case.name);
        assert_eq!(ahead.quaternion, attitude, "{}", case.name);
        assert_ne!(Maker::new(&case, 8, &sky).unwrap().field(5), ahead, "{}", case.name);
    }
}

#[test]
fn the_hard_cases_are_what_their_names_say() {
    let sky = sky();
    let whole = Maker::new(&Case::new("whole", 0.3, 0, Change::None), 3, &sky).unwrap();
    let make = |change| Maker::new(&Case::new("x", 0.3, 4, change), 3, &sky).unwrap();
    let (few, half, edge) = (make(Change::Brightest(3)), make(Change::Half), make(Change::Edge));
    let (companions, planets, none) =
        (make(Change::Companions), make(Change::Planets(5)), make(Change::NoStars));
    let (mut missing, mut paired, mut stars) = (0, 0, 0);
    for index in 0..50 {
        let all = true_stars(&whole.field(index));
        stars += all.len();
        let brightest = true_stars(&few.field(index));
        assert!(brightest.len() <= 3);
        let faintest = brightest.iter().map(|star| star.brightness).fold(f64::INFINITY, f64::min);
        assert_eq!(all.iter().filter(|star| star.brightness >= faintest).count(), brightest.len());
        missing += all.len() - true_stars(&half.field(index)).len();
        for star in true_stars(&edge.field(index)) {
            let margin = star.pixel.into_iter().map(|place| place.min(1024.0 - place)).fold(1024.0, f64::min);
            assert!(margin <= 128.0, "{:?}", star.pixel);
        }
        paired += companions.field(index).stars.len() - all.len() - 4;
        let field = planets.field(index);
        assert_eq!(field.stars.iter().filter(|star| star.brightness == PLANET_BRIGHTNESS).count(), 5);
        assert!(field.stars.iter().all(|star| star.brightness <= PLANET_BRIGHTNESS));
        assert!(true_stars(&none.field(index)).is_empty());
    }
    // Binomial, 4 sigma.
    let share = |count: usize, p: f64| {
        let n = stars as f64;
        assert!((count as f64 - p * n).abs() < 4.0 * (p * (1.0 - p) * n).sqrt(), "{count} of {n}");
    };
    share(missing, 0.5);
    share(paired, 1.0 / 3.0);
}

#[test]
fn the_unknown_lens_moves_the_corners_by_240_arcsec() {
    let mut camera = camera().unwrap();
    let straight = Optics::new(&camera).unwrap();
    camera.distortion = Distortion { k1: UNTOLD_K1, ..Distortion::default() };
    let bent = Optics::new(&camera).unwrap();
    let side = libm::tan((FIELD_DEG / 2.0).to_radians());
    let corner = [side, side, 1.0];
    let ([x0, y0], [x1, y1]) = (straight.project(corner).unwrap(), bent.project(corner).unwrap());
    let arcsec = libm::atan(libm::hypot(x1 - x0, y1 - y0) / camera.focal_length_px).to_degrees() * 3600.0;
    assert!((arcsec - 240.0).abs() < 10.0, "{arcsec}");
}

#[test]
fn the_peers_figures_are_those_of_the_algorithms_of_record() {
    let of = |name: &str| grid().into_iter().find(|case| case.name == name).unwrap().peers;
    assert_eq!(of("0.3 px, 0 false"), Peers::Measured(100.0));
    assert_eq!(of("1 px, 0 false"), Peers::Measured(100.0));
    assert_eq!(of("2 px, 0 false"), Peers::Measured(94.5));
    assert_eq!(of("0.3 px, 20 false"), Peers::Measured(100.0));
    assert_eq!(of("0.3 px, 40 false"), Peers::Measured(98.0));
    // One peer bears the noise (but 99.5 % with 20 false stars), the other the false stars (but 84 % at 1
    // px).
    assert_eq!(of("1 px, 20 false"), Peers::AtMost(99.5));
    assert_eq!(of("0.5 px, 20 false"), Peers::AtMost(100.0));
    assert_eq!(of("2 px, 40 false"), Peers::AtMost(94.5));
}
