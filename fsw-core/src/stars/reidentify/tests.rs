use super::*;
use crate::oracle::Generator;
use crate::stars::artificial::{Picture, SKY, camera, camera_parameters, false_star};
use nalgebra::Vector3;
use std::vec::Vec as List;

/// Errors of centres, px.
const SIGMA_PX: f32 = 0.1;

/// What is found of a picture near to an attitude that is off by a rotation vector, rad.
fn found(picture: &Picture, off_rad: &Vector3<f64>) -> Option<(Confirmed, f32)> {
    let (camera, catalogue) = (camera(), SKY.catalogue());
    let measured = picture.measured(&camera, SIGMA_PX);
    let field = StarField::whole(&measured, &catalogue, &camera);
    let parameters = IdentificationParameters::default();
    let limit = parameters.log10_false_limit;
    reidentify(&picture.attitude_turned(off_rad), &field, &parameters, limit)
}

/// A turn across the line of sight that moves stars by up to `most_px`, with a small roll.
fn turn(generator: &mut Generator, most_px: f64) -> Vector3<f64> {
    let most_rad = most_px / f64::from(camera_parameters().focal_length_px);
    Vector3::new(
        generator.between(-most_rad, most_rad),
        generator.between(-most_rad, most_rad),
        generator.between(-2e-3, 2e-3),
    )
}

#[test]
fn stars_are_found_again_among_many_more_false_ones() {
    let mut generator = Generator::new(71);
    let (mut tried, mut right) = (0, 0);
    for _ in 0..200 {
        let picture = Picture::of(&SKY, &camera_parameters(), generator.rotation());
        if picture.spots.len() < 8 {
            continue;
        }
        let picture = picture.noisy(&mut generator, 0.1).with_false_stars(&mut generator, 40);
        let off_rad = turn(&mut generator, 60.0);
        tried += 1;
        let Some((confirmed, log10_false)) = found(&picture, &off_rad) else { continue };
        assert!(log10_false <= IdentificationParameters::default().log10_false_limit);
        for found in &confirmed.matches {
            let seen = &picture.spots[usize::from(found.measured)];
            // A false star beside a true one may take its place.
            assert!(seen.star.is_none_or(|star| star == found.star));
        }
        assert!(picture.error_of(&confirmed.attitude).norm() < 2e-3);
        right += 1;
    }
    std::println!("found again: {right} of {tried}");
    assert!(tried > 150 && right * 100 >= tried * 95);
}

#[test]
fn nothing_is_found_where_there_are_no_stars_or_others() {
    let mut generator = Generator::new(72);
    for k in 0..300 {
        let mut picture = Picture::of(&SKY, &camera_parameters(), generator.rotation());
        if k % 2 == 0 {
            picture.spots = (0..60).map(|_| false_star(&mut generator)).collect::<List<_>>();
        }
        // Half a radian away other stars are in the field.
        let off_rad = if k % 2 == 0 { Vector3::zeros() } else { Vector3::new(0.5, 0.3, 0.0) };
        assert!(found(&picture, &off_rad).is_none());
    }
}

#[test]
fn by_chance_a_match_is_as_rare_as_it_is_said_to_be() {
    const LIMIT: f32 = -2.0;
    let mut generator = Generator::new(73);
    let parameters = IdentificationParameters::default();
    let (camera, catalogue) = (camera(), SKY.catalogue());
    let (trials, mut told) = (4000, 0);
    for _ in 0..trials {
        let mut picture = Picture::of(&SKY, &camera_parameters(), generator.rotation());
        picture.spots = (0..40).map(|_| false_star(&mut generator)).collect::<List<_>>();
        let measured = picture.measured(&camera, SIGMA_PX);
        let field = StarField::whole(&measured, &catalogue, &camera);
        let former = picture.attitude_turned(&Vector3::zeros());
        told += usize::from(reidentify(&former, &field, &parameters, LIMIT).is_some());
    }
    std::println!("{told} of {trials} by chance");
    // At most one in a hundred, and four standard deviations more.
    assert!(told <= 40 + 25);
}

#[test]
fn six_stars_are_enough_where_they_stand_as_predicted() {
    let mut generator = Generator::new(74);
    let mut right = [0; 2];
    for _ in 0..200 {
        let mut picture = Picture::of(&SKY, &camera_parameters(), generator.rotation());
        if picture.spots.len() < 6 {
            continue;
        }
        picture.spots.truncate(6);
        let picture = picture.noisy(&mut generator, 0.1).with_false_stars(&mut generator, 6);
        for (right, off_px) in right.iter_mut().zip([2.0, 60.0]) {
            let off_rad = Vector3::new(off_px / f64::from(camera_parameters().focal_length_px), 0.0, 0.0);
            let found = found(&picture, &off_rad);
            *right +=
                usize::from(found.is_some_and(|(found, _)| picture.error_of(&found.attitude).norm() < 2e-3));
        }
    }
    std::println!("found: {right:?} of 200");
    assert!(right[0] > right[1] && right[0] >= 150);
}

#[test]
fn without_a_turn_the_displacement_is_none_and_of_no_pairs_there_is_none() {
    assert_eq!(common_displacement(&[]), None);
    assert_eq!(common_displacement(&[[10.0, -20.0], [0.5, 0.0], [-0.5, 0.25]]), Some([0.0, 0.125]));
}
