use super::*;
use crate::oracle::Generator;
use nalgebra::{SMatrix, SVector};

#[test]
fn rows_hold_all_that_the_points_say() {
    let mut generator = Generator::new(81);
    let mut look = Look::new(0, 80.0, 6_378.0);
    let (mut information, mut right) =
        (SMatrix::<f64, WAVES, WAVES>::zeros(), SVector::<f64, WAVES>::zeros());
    for point in 0..200 {
        let azimuth = generator.between(-3.0, 3.0);
        let (sine, cosine) = azimuth.sin_cos();
        let (height, sigma) = (generator.gaussian(), generator.between(0.5, 2.0));
        look.add([cosine as f32, sine as f32], height as f32, sigma as f32, point as f32);
        let row = SVector::from(waves(cosine as f32, sine as f32).map(f64::from));
        information += row * row.transpose() / (sigma * sigma);
        right += row * (height / (sigma * sigma));
    }
    let (mut by_rows, mut right_by_rows) =
        (SMatrix::<f64, WAVES, WAVES>::zeros(), SVector::<f64, WAVES>::zeros());
    for (waves, height) in look.rows() {
        let row = SVector::<f64, WAVES>::from_iterator(waves.iter().map(|wave| f64::from(*wave)));
        by_rows += row * row.transpose();
        right_by_rows += row * f64::from(height);
    }
    assert!((by_rows - information).abs().max() < 1e-4 * information.abs().max());
    assert!((right_by_rows - right).abs().max() < 1e-3);
    assert_eq!(look.mean_s(), 99.5);
}

#[test]
fn waves_are_cosines_and_sines() {
    let azimuth = 0.7f32;
    let seen = waves(azimuth.cos(), azimuth.sin());
    for k in 0..=4u8 {
        let angle = f32::from(k) * azimuth;
        let at = usize::from(k);
        if k > 0 {
            assert!(
                (seen[2 * at - 1] - angle.cos()).abs() < 1e-6 && (seen[2 * at] - angle.sin()).abs() < 1e-6
            );
        } else {
            assert_eq!(seen[0], 1.0);
        }
    }
}
