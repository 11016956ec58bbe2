use super::*;
use crate::commands::solve::pointing::unit_vector;
use crate::flight;
use crate::formats::camera_file::{self, CameraFile};
use crate::world::attitude::{matrix, uniform};
use crate::world::noise::{Noise, Stream};
use std::path::Path;

fn pointing(camera: &CameraFile, index: u32) -> Pointing {
    let quaternion = uniform(&Noise::new(1, 0, Stream::Attitude), index);
    Pointing { camera: flight::camera(camera, Path::new("test")).unwrap(), attitude: matrix(quaternion) }
}

fn reference() -> CameraFile {
    CameraFile::reference()
}

#[test]
fn pixels_of_undistorted_lenses_are_where_the_keywords_put_them() {
    let mirrored = CameraFile { mirrored: true, optical_centre_px: [600.0, 530.0], ..reference() };
    let equiangular = CameraFile { projection: camera_file::Projection::Equiangular, ..reference() };
    for camera in [reference(), mirrored, equiangular] {
        for index in 0..50 {
            let pointing = pointing(&camera, index);
            let coordinates = WorldCoordinates::new(&pointing);
            for at in [[0.0, 0.0], [1279.0, 1023.0], [100.0, 900.0], [639.5, 511.5]] {
                let [x, y] = coordinates.image_px(&pointing, at).unwrap();
                let off = libm::hypot(x - f64::from(at[0]), y - f64::from(at[1]));
                // The flight camera's own rounding.
                assert!(off < 2e-3, "{at:?}: {off} px");
            }
        }
    }
}

#[test]
fn the_reference_point_is_the_line_of_sight_and_the_matrix_is_in_degrees() {
    let pointing = pointing(&reference(), 3);
    let coordinates = WorldCoordinates::new(&pointing);
    let seen = unit_vector(coordinates.reference_deg);
    assert!(dot(seen, pointing.attitude[2]) > 1.0 - 1e-15);
    let [[a, b], [c, d]] = coordinates.cd_deg_px;
    let per_px = (1.0 / 3000f64).to_degrees();
    assert!(((a * d - b * c).abs().sqrt() / per_px - 1.0).abs() < 1e-12);
    // Right ascension grows to the left where north is up, x right, y down: a positive determinant.
    assert!(a * d - b * c > 0.0);
}

#[test]
fn a_header_is_made_of_cards_and_blocks_and_tells_of_distortion() {
    let mut camera = reference();
    for distorted in [false, true] {
        let bytes = header(&pointing(&camera, 7));
        assert_eq!(bytes.len() % 2880, 0);
        let cards: Vec<&str> =
            bytes.chunks_exact(80).map(|card| std::str::from_utf8(card).unwrap().trim_end()).collect();
        assert!(bytes.is_ascii() && cards[0].starts_with("SIMPLE  =                    T"));
        assert!(
            cards.contains(&"END") && cards.contains(&"CTYPE1  = 'RA---TAN'           / right ascension")
        );
        let comments: Vec<&&str> = cards.iter().filter(|card| card.starts_with("COMMENT")).collect();
        assert_eq!(comments.len(), if distorted { 2 } else { 0 }, "{comments:?}");
        // k1 r³ f = 6.1 px in the corner at r = 0.273, and what that adds to r.
        assert!(!distorted || comments[1].contains("up to 6.2"), "{comments:?}");
        camera.distortion.k1 = -0.1;
    }
}
