use super::*;
use crate::oracle::{Generator, rotation_of, skewness, turn, wide, wide_matrix};
use proptest::prelude::*;
use std::f64::consts::PI;

type Turn = Rotation<Icrs, StarPath>;

fn narrow(quaternion: [f64; 4]) -> [f32; 4] {
    quaternion.map(|x| x as f32)
}

/// Distance of two quaternions that may differ in sign.
fn distance(one: [f64; 4], other: [f32; 4]) -> f64 {
    let apart =
        |sign: f64| one.iter().zip(other).map(|(a, b)| (a - sign * f64::from(b)).abs()).fold(0.0, f64::max);
    apart(1.0).min(apart(-1.0))
}

/// Random quaternions, then such as turn by nearly 180 deg (w near zero, of either sign), then single axes.
fn quaternions() -> impl Iterator<Item = [f64; 4]> {
    let mut generator = Generator::new(1);
    let anywhere = (0..20_000).map(move |index| {
        let [x, y, z, w] = generator.quaternion();
        let w = match index % 4 {
            0 => w,
            1 => w * 1e-3,
            2 => w * 1e-7,
            _ => 0.0,
        };
        let norm = (x * x + y * y + z * z + w * w).sqrt();
        [x / norm, y / norm, z / norm, w / norm]
    });
    let axes = (0..4).map(|axis| std::array::from_fn(|index| if index == axis { 1.0 } else { 0.0 }));
    anywhere.chain(axes)
}

#[test]
fn a_quaternion_is_scalar_last_and_turns_the_frame_as_eq_2_4() {
    // A frame turned by +90 deg about z sees the old x axis along its -y axis.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let about_z = Turn::from_quaternion([0.0, 0.0, half, half]).unwrap();
    let by_hand = Matrix3::new(0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    assert!((about_z.matrix() - by_hand).abs().max() < 2e-7, "{}", about_z.matrix());
    // ... and one turned by +90 deg about x sees the old y axis along its -z axis.
    let about_x = Turn::from_quaternion([half, 0.0, 0.0, half]).unwrap();
    let y = Direction::new(Vector3::new(0.0, 1.0, 0.0)).unwrap();
    assert!((about_x.apply(&y).vector() - Vector3::new(0.0, 0.0, -1.0)).abs().max() < 2e-7);
}

#[test]
fn the_matrix_of_a_quaternion_is_eq_2_4_to_rounding() {
    let worst = quaternions()
        .map(|q| {
            let matrix = Turn::from_quaternion(narrow(q)).unwrap();
            (wide_matrix(matrix.matrix()) - rotation_of(q)).abs().max()
        })
        .fold(0.0, f64::max);
    std::println!("matrix of a quaternion: {worst:.2e}");
    assert!(worst < 1e-6, "{worst:e}");
}

#[test]
fn quaternion_and_matrix_give_each_other_back_even_at_180_deg() {
    let mut worst = 0.0f64;
    for q in quaternions() {
        let back = Turn::from_quaternion(narrow(q)).unwrap().quaternion();
        assert!(back[3] >= 0.0, "{back:?}");
        worst = worst.max(distance(q, back));
    }
    std::println!("quaternion round trip: {worst:.2e}");
    assert!(worst < 6e-7, "{worst:e}");
}

#[test]
fn a_quaternion_need_not_be_normalised() {
    let unit = Turn::from_quaternion([0.1, -0.2, 0.3, 0.4]).unwrap();
    let long = Turn::from_quaternion([100.0, -200.0, 300.0, 400.0]).unwrap();
    assert!((unit.matrix() - long.matrix()).abs().max() < 3e-7);
}

#[test]
fn values_without_a_direction_are_refused() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
        for place in 0..4 {
            let mut quaternion = [0.5f32; 4];
            quaternion[place] = bad;
            assert!(Turn::from_quaternion(quaternion).is_none(), "{quaternion:?}");
            if let Some(component) = quaternion.get(..3).filter(|_| place < 3) {
                assert!(Direction::<Icrs>::new(Vector3::from_column_slice(component)).is_none());
            }
        }
    }
    assert!(Turn::from_quaternion([0.0; 4]).is_none());
    assert!(Direction::<Icrs>::new(Vector3::zeros()).is_none());
    assert!(Direction::<Icrs>::new(Vector3::new(1e-7, 0.0, 0.0)).is_none());
}

#[test]
fn a_turned_rotation_is_rodrigues_formula() {
    let mut generator = Generator::new(2);
    let mut worst = [0.0f64; 2];
    for index in 0..20_000 {
        // Every size from a polishing step to half a turn.
        let angle = if index % 2 == 0 {
            10f64.powf(generator.between(-8.0, 0.28))
        } else {
            generator.between(1.9, PI)
        };
        let vector = (generator.unit() * angle).map(|x| x as f32);
        let before = Turn::from_quaternion(narrow(generator.quaternion())).unwrap();
        let expected = turn(&wide(&vector)) * wide_matrix(before.matrix());
        let error = (wide_matrix(before.turned(&vector).matrix()) - expected).abs().max();
        worst[index % 2] = worst[index % 2].max(error);
    }
    std::println!("turned: {:.2e} to 109 deg, {:.2e} to 180 deg", worst[0], worst[1]);
    assert!(worst[0] < 1e-6 && worst[1] < 5e-5, "{worst:?}");
}

#[test]
fn angle_from_undoes_turned() {
    let mut generator = Generator::new(3);
    let mut worst = 0.0f64;
    for _ in 0..20_000 {
        let vector = (generator.unit() * 10f64.powf(generator.between(-8.0, 0.28))).map(|x| x as f32);
        let before = Turn::from_quaternion(narrow(generator.quaternion())).unwrap();
        let back = before.turned(&vector).angle_from(&before);
        worst = worst.max(wide(&(back - vector)).norm());
    }
    std::println!("angle_from(turned): {worst:.2e} rad");
    assert!(worst < 2e-6, "{worst:e} rad");
}

#[test]
fn angle_from_is_right_up_to_180_deg() {
    let mut generator = Generator::new(4);
    for index in 0..5000 {
        let angle = if index % 2 == 0 { generator.between(0.0, PI) } else { PI - 1e-4 };
        let between = turn(&(generator.unit() * angle));
        let before = Turn::from_quaternion(narrow(generator.quaternion())).unwrap();
        let after = Turn::from_orthogonal((between * wide_matrix(before.matrix())).map(|x| x as f32));
        let found = turn(&wide(&after.angle_from(&before))) * wide_matrix(before.matrix());
        let error = (found - wide_matrix(after.matrix())).abs().max();
        assert!(error < 2e-6, "{angle} rad: {error:e}");
    }
}

#[test]
fn a_thousand_turns_leave_a_rotation_orthogonal() {
    let mut generator = Generator::new(5);
    let mut attitude = Turn::from_quaternion([0.0, 0.0, 0.0, 1.0]).unwrap();
    for _ in 0..1000 {
        attitude = attitude.turned(&generator.gaussian_vector().map(|x| 0.1 * x as f32));
    }
    let skew = skewness(attitude.matrix());
    std::println!("|A A' - I| after 1000 turns: {skew:.2e}");
    assert!(skew < 1e-5, "{skew:e}");
    assert!((wide_matrix(attitude.matrix()).determinant() - 1.0).abs() < 1e-5);
}

#[test]
fn a_turn_that_is_not_finite_leaves_the_rotation_as_it_was() {
    let attitude = Turn::from_quaternion([0.1, 0.2, 0.3, 0.9]).unwrap();
    for bad in [f32::NAN, f32::INFINITY, f32::MAX] {
        assert_eq!(attitude.turned(&Vector3::new(0.0, bad, 0.0)).matrix(), attitude.matrix());
    }
}

#[test]
fn a_chord_is_twice_the_sine_of_half_the_angle() {
    let mut generator = Generator::new(6);
    for _ in 0..20_000 {
        let angle = 10f64.powf(generator.between(-5.0, 0.49));
        let (one, axis) = (generator.unit(), generator.unit());
        let axis = one.cross(&axis).normalize();
        let other = turn(&(axis * angle)) * one;
        let [one, other] = [one, other].map(|v| Direction::<Icrs>::new(v.map(|x| x as f32)).unwrap());
        let error = (f64::from(one.chord(&other)) - 2.0 * (angle / 2.0).sin()).abs();
        assert!(error < 5e-7, "{angle} rad: {error:e}");
    }
}

#[test]
fn a_fixed_point_direction_has_unit_length_to_rounding() {
    let mut generator = Generator::new(7);
    for _ in 0..5000 {
        let unit = generator.unit();
        let fixed = unit.map(|x| (x * f64::from(1u32 << 30)).round() as i32);
        let direction = Direction::<Icrs>::from_q30([fixed.x, fixed.y, fixed.z]);
        assert!((wide(direction.vector()) - unit).norm() < 1e-7);
    }
}

proptest! {
    #[test]
    fn a_direction_has_unit_length(x in any::<f32>(), y in any::<f32>(), z in any::<f32>()) {
        if let Some(direction) = Direction::<Icrs>::new(Vector3::new(x, y, z)) {
            prop_assert!((wide(direction.vector()).norm() - 1.0).abs() < 3e-7);
        }
    }

    #[test]
    fn any_quaternion_gives_a_rotation_or_nothing(q in any::<[f32; 4]>()) {
        if let Some(rotation) = Turn::from_quaternion(q) {
            prop_assert!(skewness(rotation.matrix()) < 2e-6);
        }
    }

    #[test]
    fn a_rotation_and_its_inverse_cancel(
        q in prop::array::uniform4(-1.0f32..1.0),
        v in prop::array::uniform3(-1.0f32..1.0),
    ) {
        let (Some(turn), Some(star)) = (Turn::from_quaternion(q), Direction::new(Vector3::from(v))) else {
            return Ok(());
        };
        let back = turn.inverse().apply(&turn.apply(&star));
        prop_assert!(back.chord(&star) < 2e-6);
        let nothing = turn.then(&turn.inverse());
        prop_assert!((nothing.matrix() - Matrix3::identity()).abs().max() < 2e-6);
    }
}
