use super::*;
use crate::earth::test_world::parameters;
use nalgebra::Vector3;

fn limb_model(km_per_px: f32, sun_sine: f32, sun_facing: f32) -> LimbModel {
    let expected = ExpectedLimb {
        at_px: [600.0, 500.0],
        outward_px: [1.0, 0.0],
        normal: Vector3::x(),
        km_per_px,
        sun_sine,
        sun_facing,
        drawn_px: 0.0,
    };
    let mut parameters = parameters();
    parameters.limb.lommel_share = 0.5;
    LimbModel::new(&expected, 1.0, &parameters).unwrap()
}

#[test]
fn the_weights_are_a_gaussian_of_unit_sum_and_variance() {
    let [middle, sides @ ..] = WEIGHTS;
    let (mut sum, mut variance) = (middle, 0.0);
    for (index, weight) in sides.iter().enumerate() {
        sum += 2.0 * weight;
        variance += 2.0 * weight * ((index + 1) as f32 / 3.0).powi(2);
    }
    assert!((sum - 1.0).abs() < 1e-5 && (variance - 1.0).abs() < 0.02, "{sum} {variance}");
}

#[test]
fn the_share_is_that_of_a_finely_blurred_limb() {
    for (km_per_px, sine, facing) in
        [(14.0, 0.5, 0.3), (14.0, 0.1, 0.9), (1.0, 0.5, -0.3), (0.8, 0.2, 0.9), (3.0, 0.9, 0.1)]
    {
        let model = limb_model(km_per_px, sine, facing);
        let (scale, radius) = (8.0 / f64::from(km_per_px), 6378.137 / f64::from(km_per_px));
        let surface = scale * 2f64.ln();
        let clear = |place: f64| {
            if place < surface {
                return 0.5 * (place / scale).exp();
            }
            // Half Lambert's law, half Lommel and Seeliger's, with the exact turn of the normal, over those
            // at the limb.
            let turn = (1.0 - (place - surface) / radius).acos();
            let reflectance = |turn: f64| {
                let sunlight = turn.cos() * f64::from(sine) + turn.sin() * f64::from(facing);
                let view = turn.sin().hypot(0.1);
                sunlight * (1.0 / (sunlight + view) + 0.5)
            };
            (reflectance(turn) / reflectance(0.0)).clamp(0.3, 4.0)
        };
        let spread = (0.81f64 + 1.0 / 12.0 + 1.0 / 6.0).sqrt();
        let blurred = |place: f64| {
            (-800..=800)
                .map(|i| {
                    let offset = f64::from(i) * 0.01;
                    0.01 / (spread * std::f64::consts::TAU.sqrt())
                        * (-0.5 * (offset / spread).powi(2)).exp()
                        * clear(place + offset)
                })
                .sum::<f64>()
        };
        let count = model.end - model.begin;
        let bright = (model.begin..model.end).map(|place| blurred(place as f64)).sum::<f64>() / count as f64;
        let expected = blurred(0.0) / bright;
        std::println!("{km_per_px} km per px, sine {sine}: level {:.4}, fine {expected:.4}", model.level);
        assert!((f64::from(model.level) / expected - 1.0).abs() < 0.02);
    }
}

#[test]
fn a_rise_longer_than_a_strip_has_no_zone() {
    let expected = ExpectedLimb {
        at_px: [0.0; 2],
        outward_px: [1.0, 0.0],
        normal: Vector3::x(),
        km_per_px: 0.04,
        sun_sine: 0.5,
        sun_facing: 0.0,
        drawn_px: 0.0,
    };
    assert!(LimbModel::new(&expected, 1.0, &parameters()).is_none());
    let nowhere = ExpectedLimb { km_per_px: f32::NAN, ..expected };
    assert!(LimbModel::new(&nowhere, 1.0, &parameters()).is_none());
}

#[test]
fn the_quick_root_errs_by_five_millionths_of_it_at_most() {
    assert_eq!(fast_sqrt(0.0), 0.0);
    // Twelve numbers a percent, over 16 decades.
    for step in 0..44_000 {
        let square = 1e-12 * (f64::from(step) / 1200.0).exp();
        let exact = (square as f32 as f64).sqrt();
        assert!((f64::from(fast_sqrt(square as f32)) / exact - 1.0).abs() < 5e-6, "{square:e}");
    }
}
