use super::*;
use crate::earth::test_world::{World, camera, direction, geostationary, low, narrow, parameters};
use crate::oracle::{self, Generator};
use std::vec::Vec as List;

fn view(world: &World) -> View {
    let parameters = parameters();
    View::new(&narrow(&world.centre), &world.body(&parameters)).unwrap()
}

/// The limb of the world on the detector, finely: position and sine of the Sun's elevation.
fn true_limb(world: &World) -> List<([f64; 2], f64)> {
    let height = f64::from(parameters().limb.height_km);
    let reference = oracle::reference_camera();
    (0..20_000)
        .map(|index| world.limb(f64::from(index) * std::f64::consts::TAU / 20_000.0, height))
        .filter(|ray| ray.z > 0.1)
        .map(|ray| (oracle::project(&reference, &ray), world.sun_sine(&ray, height).0))
        .collect()
}

fn scenes() -> [(&'static str, World); 6] {
    [
        ("geostationary, full", geostationary(20.0, 1)),
        ("geostationary, half", geostationary(90.0, 1)),
        ("geostationary, crescent", geostationary(140.0, 1)),
        ("450 km", low(450.0, 90.0, [40.0, 30.0], 1)),
        ("800 km", low(800.0, 200.0, [40.0, 30.0], 1)),
        ("600 km, corner", low(600.0, 40.0, [40.0, 30.0], 1)),
    ]
}

#[test]
fn expected_points_stand_on_the_lit_limb_to_a_hundredth_of_a_pixel_and_evenly() {
    for (name, world) in scenes() {
        let found = view(&world).limb(&camera(), 10.0, (24, 4), &parameters());
        let truth = true_limb(&world);
        assert_eq!(found.points.len(), 24, "{name}");
        let mut greatest = 0f64;
        for point in &found.points {
            let [x, y] = point.at_px.map(f64::from);
            let apart = |at: &[f64; 2]| (at[0] - x).hypot(at[1] - y);
            let nearest =
                (0..truth.len()).min_by(|i, j| apart(&truth[*i].0).total_cmp(&apart(&truth[*j].0))).unwrap();
            let (before, after) = (truth[nearest.max(1) - 1].0, truth[(nearest + 1).min(truth.len() - 1)].0);
            let length = (after[0] - before[0]).hypot(after[1] - before[1]);
            let normal = [(after[1] - before[1]) / length, (before[0] - after[0]) / length];
            let (at, sine) = truth[nearest];
            let off = (x - at[0]) * normal[0] + (y - at[1]) * normal[1];
            greatest = greatest.max(off.abs());
            let [nx, ny] = point.outward_px.map(f64::from);
            assert!((nx * normal[0] + ny * normal[1]).abs() > 1.0 - 1e-4, "{name}: normal");
            assert!((f64::from(point.sun_sine) - sine).abs() < 2e-3, "{name}: Sun");
            // Outward a pixel, the ray passes km_per_px higher.
            let ray = World::ray(x + 5.0 * nx, y + 5.0 * ny);
            let passes = |height: f64| world.sun_sine(&ray, height).1;
            let height = f64::from(parameters().limb.height_km) + 5.0 * f64::from(point.km_per_px);
            assert!(passes(height * 1.02 + 0.05) && !passes(height * 0.98 - 0.05), "{name}: km per px");
        }
        // Neighbours stand apart by about the same distance.
        let mut gaps: List<f32> = found
            .points
            .windows(2)
            .map(|pair| (pair[0].at_px[0] - pair[1].at_px[0]).hypot(pair[0].at_px[1] - pair[1].at_px[1]))
            .collect();
        gaps.sort_by(f32::total_cmp);
        std::println!(
            "{name}: {greatest:.1e} px off, arc {:.2}, lit {:.2} rad, gaps {:.0} to {:.0} px",
            found.lit_arcs.arc_rad,
            found.lit_arcs.lit_rad,
            gaps[0],
            gaps[gaps.len() - 1]
        );
        assert!(greatest < 0.01, "{name}: {greatest}");
        assert!(gaps[0] > 0.4 * gaps[gaps.len() / 2], "{name}: {gaps:?}");
    }
}

/// Height at which a ray passes the Earth, km.
fn passing_km(world: &World, ray: &nalgebra::Vector3<f64>) -> f64 {
    let (mut low, mut high) = (-200.0, 400.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if world.sun_sine(ray, middle).1 { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

#[test]
fn a_displaced_centre_lifts_the_limb_by_its_part_along_the_normal() {
    let mut generator = Generator::new(31);
    for (name, world) in scenes() {
        let found = view(&world).limb(&camera(), 10.0, (24, 4), &parameters());
        let mut greatest = 0f64;
        for point in &found.points {
            let ray = camera().earth_direction(point.at_px).unwrap().vector().map(f64::from);
            assert!((f64::from(point.normal.norm()) - 1.0).abs() < 1e-5);
            // Both ways, so that curvature falls out.
            let by = generator.unit() * 5.0;
            let at = |by: nalgebra::Vector3<f64>| {
                passing_km(&World { centre: world.centre + by, ..world.clone() }, &ray)
            };
            let lifted = 0.5 * (at(-by) - at(by));
            greatest = greatest.max((lifted - point.normal.map(f64::from).dot(&by)).abs());
        }
        // A five-hundredth of 5 km.
        assert!(greatest < 0.01, "{name}: {greatest} km of 5");
    }
}

#[test]
fn distortion_is_followed_to_a_hundredth_of_a_pixel() {
    let mut distorted = oracle::reference_camera();
    distorted.distortion = crate::camera::Distortion { k1: -0.2, k2: 0.05, k3: -0.01, p1: 1e-3, p2: -7e-4 };
    let camera = Camera::new(distorted).unwrap();
    let world = low(500.0, 60.0, [40.0, 30.0], 1);
    let found = view(&world).limb(&camera, 10.0, (48, 4), &parameters());
    let height = f64::from(parameters().limb.height_km);
    assert!(found.points.len() > 40);
    for point in &found.points {
        // Back through the camera, the ray touches the limb height: within a hundredth of a pixel, about 0.02
        // km.
        let seen = camera.earth_direction(point.at_px).unwrap().vector().map(f64::from);
        let [inner, outer] = [-0.02, 0.02].map(|km| world.sun_sine(&seen, height + km).1);
        assert!(!inner && outer);
        let [nx, ny] = point.outward_px;
        // Along the tangent the height does not change: 3 px off by less than curvature and 1 % of 3 px.
        let [x, y] = point.at_px;
        let aside = camera.earth_direction([x - 3.0 * ny, y + 3.0 * nx]).unwrap().vector().map(f64::from);
        assert!(!world.sun_sine(&aside, height - 0.06).1 && world.sun_sine(&aside, height + 0.06).1);
    }
}

#[test]
fn a_dark_or_absent_limb_gives_no_points_and_says_so() {
    let dark = low(500.0, 90.0, [-20.0, 120.0], 1);
    let found = view(&dark).limb(&camera(), 10.0, (24, 4), &parameters());
    assert!(found.points.is_empty() && found.lit_arcs.lit_rad == 0.0 && found.lit_arcs.arc_rad > 0.3);
    let mut beside = geostationary(0.0, 1);
    beside.centre = -beside.centre;
    let found = view(&beside).limb(&camera(), 10.0, (24, 4), &parameters());
    assert!(found.points.is_empty() && found.lit_arcs.arc_rad == 0.0);
    // The Earth fills the field.
    let mut filled = geostationary(0.0, 1);
    filled.centre *= 0.2;
    assert!(view(&filled).limb(&camera(), 10.0, (24, 4), &parameters()).points.is_empty());
}

#[test]
fn no_view_from_inside_the_earth_or_from_nowhere() {
    let body = geostationary(0.0, 1).body(&parameters());
    for bad in [
        Vector3::zeros(),
        Vector3::new(0.0, 0.0, 6300.0),
        Vector3::new(f32::NAN, 0.0, 1e4),
        Vector3::new(f32::INFINITY, 0.0, 1.0),
        Vector3::new(0.0, 0.0, 1e9),
    ] {
        assert!(View::new(&bad, &body).is_none(), "{bad}");
    }
}

#[test]
fn covered_and_lit_directions_agree_with_the_ray_cut_in_f64() {
    let mut generator = Generator::new(12);
    let parameters = parameters();
    let height = f64::from(parameters.limb.height_km);
    let twilight = f64::from(parameters.light.twilight_deg).to_radians().sin();
    for (name, world) in scenes() {
        let view = view(&world);
        let (mut covered, mut lit) = (0, 0);
        for _ in 0..5000 {
            let ray = generator.unit();
            let (sine, meets) = world.sun_sine(&ray, height);
            let ahead = ray.dot(&world.centre) > 0.0;
            // Not within a thousandth of a degree of the edge.
            let margin = 2e-5;
            let outer = view.mask(margin, &parameters).covers(&direction(&ray));
            assert!(outer || !(meets && ahead), "{name}");
            let within = view.mask(-margin, &parameters);
            let inner = within.covers(&direction(&ray));
            assert!(!inner || (meets && ahead), "{name}");
            if meets && ahead {
                covered += 1;
                if (sine + twilight).abs() > 2e-3 {
                    assert_eq!(within.is_lit(&direction(&ray)), sine > -twilight, "{name}");
                    lit += usize::from(sine > -twilight);
                }
            }
        }
        assert!(covered > 10 && lit <= covered, "{name}: {covered} {lit}");
    }
}

proptest::proptest! {
    #[test]
    fn whatever_the_position_expected_points_are_finite_and_in_the_field(
        x in -5e4f32..5e4, y in -5e4f32..5e4, z in -5e4f32..5e4, most in 0usize..60
    ) {
        let body = geostationary(40.0, 1).body(&parameters());
        if let Some(view) = View::new(&Vector3::new(x, y, z), &body) {
            let limb = view.limb(&camera(), 5.0, (most, 4), &parameters());
            proptest::prop_assert!(limb.points.len() <= most.min(MAX_LIMB_POINTS));
            for point in &limb.points {
                proptest::prop_assert!(camera().contains(point.at_px, 5.0));
                let [nx, ny] = point.outward_px;
                proptest::prop_assert!((nx * nx + ny * ny - 1.0).abs() < 1e-3 && point.km_per_px > 0.0);
            }
        }
    }
}
