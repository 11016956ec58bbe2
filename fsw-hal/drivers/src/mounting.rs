//! How a part sits on the spacecraft: the rotation from its axes to the body's.

/// Departure from a rotation that is still taken for rounding, of each product of two rows: 0.06 deg.
const TOLERANCE: f32 = 1e-3;

/// A rotation, by its matrix: body = matrix * part. A part that is turned over is a rotation as well; a
/// matrix that mirrors is not, and is refused: one of its axes has the wrong sense.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    rows: [[f32; 3]; 3],
}

fn dot([a, b, c]: [f32; 3], [x, y, z]: [f32; 3]) -> f32 {
    a * x + b * y + c * z
}

fn cross([a, b, c]: [f32; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

impl Mounting {
    /// The part's axes are the body's.
    pub const ALIGNED: Self = Self { rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] };

    /// From the rows of the matrix: the body's x, y and z in the part's axes. `None` where it is no rotation
    /// or not finite.
    pub fn new(rows: [[f32; 3]; 3]) -> Option<Self> {
        let [x, y, z] = rows;
        let [across_x, across_y, across_z] = cross(x, y);
        let off = [dot(x, x) - 1.0, dot(y, y) - 1.0, dot(x, y)];
        let off_z = [across_x - z[0], across_y - z[1], across_z - z[2]];
        let rotation = off.iter().chain(&off_z).all(|off| off.abs() <= TOLERANCE);
        rotation.then_some(Self { rows })
    }

    /// A vector of the part in the body's axes.
    pub fn to_body(&self, vector: [f32; 3]) -> [f32; 3] {
        self.rows.map(|row| dot(row, vector))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_part_turned_over_is_known_and_one_mirrored_is_refused() {
        let over = Mounting::new([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]).unwrap();
        assert_eq!(over.to_body([1.0, 2.0, 3.0]), [2.0, 1.0, -3.0]);
        assert_eq!(Mounting::new([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), None);
        assert_eq!(Mounting::new([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), None);
    }

    #[test]
    fn what_is_no_rotation_is_refused() {
        let aligned = Mounting::ALIGNED.rows;
        assert_eq!(Mounting::new(aligned), Some(Mounting::ALIGNED));
        for row in 0..3 {
            for column in 0..3 {
                for wrong in [f32::NAN, f32::INFINITY, -f32::INFINITY, 0.5, 2.0] {
                    let mut rows = aligned;
                    rows[row][column] = wrong;
                    assert_eq!(Mounting::new(rows), None, "{rows:?}");
                }
            }
        }
        assert_eq!(Mounting::new([[0.0; 3]; 3]), None);
    }

    proptest! {
        #[test]
        fn every_rotation_is_taken_and_keeps_lengths(
            q in prop::array::uniform4(-1.0..1.0f32).prop_filter("short", |q| dot4(*q) > 0.01),
            vector in prop::array::uniform3(-100.0..100.0f32),
        ) {
            let norm = dot4(q).sqrt();
            let [x, y, z, w] = q.map(|part| part / norm);
            let rows = [
                [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
                [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
                [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
            ];
            let turned = Mounting::new(rows).unwrap().to_body(vector);
            let (before, after) = (dot(vector, vector), dot(turned, turned));
            prop_assert!((before - after).abs() <= 1e-4 * before + 1e-6);
        }
    }

    fn dot4(q: [f32; 4]) -> f32 {
        q.iter().map(|part| part * part).sum()
    }
}
