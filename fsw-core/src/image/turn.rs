//! How far the sensor's turning moves a star over the detector in an exposure.
//!
//! In: the turn, the focal length and the optical centre. Out: the motion at any place, px, as a pinhole has
//! it: distortion changes it by as much as it changes the image's scale.

/// A turn of the star path against the stars during an exposure.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    optical_centre_px: [f32; 2],
    focal_length_px: f32,
    /// About the detector's x and y and the line of sight, rad.
    about_rad: [f32; 3],
}

impl Turn {
    /// A small turn about the star path's axes, rad; where the path is `mirrored` its x runs along -x px.
    pub fn new(
        optical_centre_px: [f32; 2],
        focal_length_px: f32,
        mirrored: bool,
        turn_rad: [f32; 3],
    ) -> Self {
        let [x, y, z] = turn_rad;
        let about_rad = if mirrored { [x, -y, -z] } else { turn_rad };
        Self { optical_centre_px, focal_length_px, about_rad }
    }

    /// How far the image of a star at `at_px` moves, px.
    pub fn moved_px(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let ([centre_x, centre_y], [about_x, about_y, about_z]) = (self.optical_centre_px, self.about_rad);
        let (u, v) = ((x - centre_x) / self.focal_length_px, (y - centre_y) / self.focal_length_px);
        // A star's direction d moves by -turn x d.
        let forward = u * about_y - v * about_x;
        [v * about_z - about_y - u * forward, about_x - u * about_z - v * forward]
            .map(|rad| rad * self.focal_length_px)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::frames::Direction;
    use crate::oracle::reference_camera;
    use nalgebra::Vector3;

    #[test]
    fn a_star_moves_as_the_camera_projects_it() {
        let turn_rad = [3e-4, -5e-4, 8e-4];
        for mirrored in [false, true] {
            let mut parameters = reference_camera();
            (parameters.optical_centre_px, parameters.mirrored) = ([612.3, 540.9], mirrored);
            let camera = Camera::new(parameters).unwrap();
            let turn =
                Turn::new(parameters.optical_centre_px, parameters.focal_length_px, mirrored, turn_rad);
            for at in [[30.0, 40.0], [640.0, 500.0], [1250.0, 90.0], [200.0, 1000.0]] {
                let seen = *camera.direction(at).unwrap().vector();
                let [from, to] = [-0.5, 0.5].map(|share: f32| {
                    let turned = seen - (Vector3::from(turn_rad) * share).cross(&seen);
                    camera.project(&Direction::new(turned).unwrap()).unwrap()
                });
                let [x, y] = turn.moved_px(at);
                let off = libm::hypotf(x - (to[0] - from[0]), y - (to[1] - from[1]));
                assert!(off < 2e-3 && libm::hypotf(x, y) > 0.3, "{at:?}: {x} {y}, {from:?} to {to:?}");
            }
        }
    }
}
