use crate::earth::LimbPoint;
use crate::earth::rays::{self, Rays};
use crate::earth::test_world::{GEO_KM, camera, geostationary, parameters};
use crate::oracle::{self, Generator};
use std::vec::Vec;

#[test]
fn the_closed_form_has_no_range_bias_on_a_short_arc() {
    let parameters = parameters();
    let world = geostationary(0.0, 1);
    let body = world.body(&parameters);
    let reference = oracle::reference_camera();
    let height = f64::from(parameters.limb.height_km);
    let mut generator = Generator::new(31);
    let [mx, my] = oracle::project(&reference, &world.centre.normalize());
    let (runs, noise) = (400, 0.3);
    let (mut with, mut without) = (0.0, 0.0);
    for _ in 0..runs {
        let points: Vec<LimbPoint> = (0..100)
            .map(|index| {
                let azimuth = 0.5 + (40f64.to_radians() / 100.0) * f64::from(index);
                let [x, y] = oracle::project(&reference, &world.limb(azimuth, height));
                let length = (x - mx).hypot(y - my);
                let normal = [(x - mx) / length, (y - my) / length];
                let off = noise * generator.gaussian();
                LimbPoint::new(
                    [(x + off * normal[0]) as f32, (y + off * normal[1]) as f32],
                    noise as f32,
                    normal.map(|part| part as f32),
                )
            })
            .collect();
        let mut rays = Rays::new();
        rays::fill(&mut rays, &points, &camera(), &body);
        let range =
            |rays: &Rays| f64::from(body.radius_km() / super::fit(rays, u128::MAX).unwrap().sine) - GEO_KM;
        with += range(&rays) / f64::from(runs);
        // Told of no noise, it takes none off.
        rays.iter_mut().for_each(|ray| ray.sigma_px = 1e-3);
        without += range(&rays) / f64::from(runs);
    }
    std::println!("40 deg of limb: bias {without:.0} km, without the noise's share {with:.0} km");
    assert!(with.abs() < 45.0 && without > 2.0 * with.abs(), "{with} {without}");
}
