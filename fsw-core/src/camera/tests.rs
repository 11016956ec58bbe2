use super::*;
use crate::oracle::{self, Generator, reference_camera, wide};
use proptest::prelude::*;

/// Strong but real distortion: 0.9 % at 12 deg off the line of sight, and tangential 2 px there.
const BROWN: Distortion = Distortion { k1: -0.2, k2: 0.05, k3: -0.01, p1: 1e-3, p2: -7e-4 };

fn camera(change: impl Fn(&mut CameraParameters)) -> Camera {
    let mut parameters = reference_camera();
    change(&mut parameters);
    Camera::new(parameters).unwrap()
}

/// The cameras under test: name, camera, greatest error allowed, px.
fn cameras() -> [(&'static str, Camera); 4] {
    [
        ("reference", camera(|_| ())),
        ("Brown", camera(|p| p.distortion = BROWN)),
        ("equiangular", camera(|p| p.projection = Projection::Equiangular)),
        (
            "equiangular, Brown, off centre",
            camera(|p| {
                p.projection = Projection::Equiangular;
                p.distortion = BROWN;
                p.optical_centre_px = [612.3, 540.9];
            }),
        ),
    ]
}

/// Every tenth pixel with its edges, and the optical centre and its surroundings.
fn pixels() -> impl Iterator<Item = [f32; 2]> {
    let grid = (0..=128).flat_map(|column| {
        (0..=103).map(move |row| [(column as f32 * 10.0).min(1279.0), (row as f32 * 10.0).min(1023.0)])
    });
    grid.chain([[639.5, 511.5], [639.5, 511.6], [639.501, 511.5], [-0.5, -0.5], [1279.5, 1023.5]])
}

fn apart([ax, ay]: [f64; 2], [bx, by]: [f32; 2]) -> f64 {
    (ax - f64::from(bx)).hypot(ay - f64::from(by))
}

#[test]
fn a_pixel_projects_back_onto_itself_over_the_whole_detector() {
    for (name, camera) in cameras() {
        let worst = pixels()
            .map(|at| {
                let [x, y] = camera.project(&camera.direction(at).unwrap()).unwrap();
                apart([x.into(), y.into()], at)
            })
            .fold(0.0, f64::max);
        std::println!("{name}: round trip {worst:.1e} px");
        assert!(worst < 1e-3, "{name}: {worst} px");
    }
}

#[test]
fn directions_and_positions_agree_with_an_f64_oracle() {
    for (name, camera) in cameras() {
        let (mut there, mut back) = (0.0f64, 0.0f64);
        for at in pixels() {
            let direction = camera.direction(at).unwrap();
            let position = oracle::project(camera.parameters(), &wide(direction.vector()));
            // What the direction misses: the oracle puts it elsewhere than on its pixel.
            back = back.max(apart(position, at));
            there = there.max(apart(position, camera.project(&direction).unwrap()));
        }
        std::println!("{name}: direction {back:.1e} px, project {there:.1e} px");
        assert!(there < 1e-3 && back < 1e-3, "{name}: {there} px, {back} px");
    }
}

#[test]
fn x_runs_right_y_down_and_z_along_the_line_of_sight() {
    let camera = camera(|_| ());
    let centre = camera.direction([639.5, 511.5]).unwrap();
    assert!((centre.vector() - Vector3::new(0.0, 0.0, 1.0)).norm() < 1e-7);
    let direction = camera.direction([639.5 + 300.0, 511.5 - 600.0]).unwrap();
    let expected = Vector3::new(0.1f32, -0.2, 1.0).normalize();
    assert!((direction.vector() - expected).norm() < 2e-7);
}

#[test]
fn an_equiangular_radius_is_the_angle() {
    let camera = camera(|p| p.projection = Projection::Equiangular);
    let direction = camera.direction([639.5 + 600.0, 511.5]).unwrap();
    assert!((f64::from(direction.vector().x) - 0.2f64.sin()).abs() < 1e-7);
}

#[test]
fn nothing_behind_the_camera_falls_on_the_detector() {
    let mut generator = Generator::new(1);
    for (name, camera) in cameras() {
        for _ in 0..1000 {
            let behind = generator.unit_in_cap(std::f64::consts::FRAC_PI_2).map(|x| -x as f32);
            let behind = Direction::new(behind).unwrap();
            assert_eq!(camera.project(&behind), None, "{name}: {:?}", behind.vector());
        }
        let opposite = Direction::new(Vector3::new(0.0, 0.0, -1.0)).unwrap();
        assert_eq!(camera.project(&opposite), None, "{name}");
    }
}

#[test]
fn positions_that_are_not_finite_have_no_direction() {
    for (_, camera) in cameras() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(camera.direction([bad, 100.0]).is_none());
            assert!(camera.direction([100.0, bad]).is_none());
        }
    }
}

#[test]
fn impossible_parameters_are_refused_by_their_name() {
    let refused = |change: &dyn Fn(&mut CameraParameters)| {
        let mut parameters = reference_camera();
        change(&mut parameters);
        Camera::new(parameters).map(|_| ()).unwrap_err()
    };
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let fields: [fn(&mut CameraParameters) -> &mut f32; 9] = [
            |p| &mut p.focal_length_px,
            |p| &mut p.optical_centre_px[0],
            |p| &mut p.optical_centre_px[1],
            |p| &mut p.distortion.k1,
            |p| &mut p.distortion.k2,
            |p| &mut p.distortion.k3,
            |p| &mut p.distortion.p1,
            |p| &mut p.distortion.p2,
            |p| &mut p.corner_loss,
        ];
        for field in fields {
            assert_eq!(refused(&|p| *field(p) = bad), CameraError::NotFinite);
        }
    }
    for focal_length in [0.0, -3000.0, 9.9, 1.1e6] {
        assert_eq!(refused(&|p| p.focal_length_px = focal_length), CameraError::FocalLength);
    }
    for loss in [-0.01, 0.91] {
        assert_eq!(refused(&|p| p.corner_loss = loss), CameraError::CornerLoss);
    }
    assert_eq!(refused(&|p| p.width_px = 31), CameraError::Detector);
    assert_eq!(refused(&|p| p.height_px = 0), CameraError::Detector);
    for off in [-1281.0, 2561.0] {
        assert_eq!(refused(&|p| p.optical_centre_px[0] = off), CameraError::OpticalCentre);
    }
    for off in [-1025.0, 2049.0] {
        assert_eq!(refused(&|p| p.optical_centre_px[1] = off), CameraError::OpticalCentre);
    }
}

#[test]
fn a_distortion_that_cannot_be_undone_is_refused() {
    let refused = |k1: f32, focal_length_px: f32| {
        let parameters = CameraParameters {
            focal_length_px,
            distortion: Distortion { k1, ..Distortion::default() },
            ..reference_camera()
        };
        Camera::new(parameters).map(|_| ()).err()
    };
    // Half of the field is folded over: two directions for a pixel, or none.
    assert_eq!(refused(-0.5, 800.0), Some(CameraError::Distortion));
    assert_eq!(refused(-20.0, 3000.0), Some(CameraError::Distortion));
    assert_eq!(refused(50.0, 3000.0), Some(CameraError::Distortion));
    // 10 % at the corner is what eight steps undo.
    assert_eq!(refused(-0.1, 820.0), None);
}

#[test]
fn a_camera_knows_its_detector() {
    let camera = camera(|_| ());
    assert_eq!(camera.middle_px(), [639.5, 511.5]);
    assert_eq!(camera.area_px(), 1280.0 * 1024.0);
    assert!((f64::from(camera.rad_per_px()) - 1.0 / 3000.0).abs() < 1e-10);
    assert!(camera.contains([0.0, 0.0], 0.0) && camera.contains([1279.0, 1023.0], 0.0));
    assert!(!camera.contains([1279.1, 5.0], 0.0) && !camera.contains([5.0, -0.1], 0.0));
    assert!(camera.contains([7.0, 7.0], 7.0) && !camera.contains([6.9, 7.0], 7.0));
    assert!(!camera.contains([f32::NAN, 5.0], 0.0));
}

#[test]
fn a_surface_is_dimmed_by_the_cosine_of_the_fourth_power_and_by_the_mounts() {
    let optical_centre_px = [600.0, 540.0];
    for projection in [Projection::Rectilinear, Projection::Equiangular] {
        let camera = camera(|p| {
            (p.projection, p.optical_centre_px, p.corner_loss) = (projection, optical_centre_px, 0.3);
        });
        // The farthest corner.
        let farthest = f64::hypot(1279.0 - 600.0, 540.0);
        for at in [optical_centre_px, [1279.0, 0.0], [0.0, 0.0], [300.0, 1000.0]] {
            let cosine = f64::from(camera.direction(at).unwrap().vector().z);
            let off = f64::hypot(f64::from(at[0]) - 600.0, f64::from(at[1]) - 540.0) / farthest;
            let expected = cosine.powi(4) * (1.0 - 0.3 * off * off);
            assert!((f64::from(camera.light_share(at)) - expected).abs() < 1e-3, "{projection:?}, {at:?}");
        }
    }
    // What no detector shows is not darker than the law allows anywhere.
    assert!(camera(|p| p.corner_loss = 0.9).light_share([1e5, 1e5]) > 0.0);
}

#[test]
fn a_refined_focal_length_passes_the_same_door() {
    let camera = camera(|p| p.distortion = BROWN);
    let refined = camera.with_focal_length(3010.0).unwrap();
    let expected = CameraParameters { focal_length_px: 3010.0, ..*camera.parameters() };
    assert_eq!(*refined.parameters(), expected);
    assert!(matches!(camera.with_focal_length(f32::NAN), Err(CameraError::NotFinite)));
}

proptest! {
    /// Whatever the door lets through: no direction is given that does not belong to its pixel.
    #[test]
    fn the_corners_of_any_accepted_camera_project_back(
        focal_length_px in 10.0f32..5000.0,
        k1 in -3.0f32..3.0,
        k2 in -3.0f32..3.0,
        p1 in -0.01f32..0.01,
        equiangular in any::<bool>(),
    ) {
        let projection = if equiangular { Projection::Equiangular } else { Projection::Rectilinear };
        let distortion = Distortion { k1, k2, p1, ..Distortion::default() };
        let parameters = CameraParameters { focal_length_px, projection, distortion, ..reference_camera() };
        if let Ok(camera) = Camera::new(parameters) {
            for corner in [[0.0, 0.0], [1279.0, 0.0], [0.0, 1023.0], [1279.0, 1023.0]] {
                let [x, y] = camera.project(&camera.direction(corner).unwrap()).unwrap();
                prop_assert!(apart([x.into(), y.into()], corner) < 0.5);
            }
        }
    }

    #[test]
    fn no_position_and_no_direction_panics(at in any::<[f32; 2]>(), v in any::<[f32; 3]>()) {
        for (_, camera) in cameras() {
            let _ = camera.direction(at);
            let _ = Direction::new(Vector3::from(v)).and_then(|direction| camera.project(&direction));
        }
    }
}

#[test]
fn a_mirror_turns_the_star_path_over_and_leaves_the_earth_path() {
    let (plain, mirrored) =
        (camera(|p| p.distortion = BROWN), camera(|p| (p.distortion, p.mirrored) = (BROWN, true)));
    for at in pixels() {
        let (before, after) = (plain.direction(at).unwrap(), mirrored.direction(at).unwrap());
        let [b, a] = [before, after].map(|direction| *direction.vector());
        assert_eq!([a.x, a.y, a.z], [-b.x, b.y, b.z]);
        assert_eq!(mirrored.earth_direction(at).unwrap().vector(), before.vector());
        let [x, y] = mirrored.project(&after).unwrap();
        assert!(apart([x.into(), y.into()], at) < 1e-3);
        assert_eq!(mirrored.project_earth(&mirrored.earth_direction(at).unwrap()), plain.project(&before));
    }
}
