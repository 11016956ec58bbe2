//! Covariance of 3 x 3 blocks, and a rotation with its mean, for the filter's propagation.

use nalgebra::{Matrix3, Vector3};

/// Symmetric, of two by two blocks.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BlockCovariance(pub(super) [[Matrix3<f32>; 2]; 2]);

impl BlockCovariance {
    /// A block; there is none outside.
    pub(super) fn at(&self, row: usize, column: usize) -> Matrix3<f32> {
        self.0.get(row).and_then(|blocks| blocks.get(column)).copied().unwrap_or_default()
    }

    /// Sets a block and its transpose; a diagonal block is symmetrised against rounding.
    pub(super) fn set_block(&mut self, row: usize, column: usize, block: Matrix3<f32>) {
        let across = block.transpose();
        let (block, across) = if row == column { ((block + across) * 0.5, across) } else { (block, across) };
        for (row, column, block) in [(column, row, across), (row, column, block)] {
            if let Some(place) = self.0.get_mut(row).and_then(|blocks| blocks.get_mut(column)) {
                *place = block;
            }
        }
    }
}

/// Matrix product; not inlined, to save flash.
#[inline(never)]
pub(super) fn product(a: &Matrix3<f32>, b: &Matrix3<f32>) -> Matrix3<f32> {
    a * b
}

/// A rotation vector, its matrix and the mean of the matrix over the rotation.
pub(super) struct RotationStep {
    pub(super) angle: Vector3<f32>,
    pub(super) whole: Matrix3<f32>,
    pub(super) mean: Matrix3<f32>,
}

impl RotationStep {
    /// By `angle`, rad, of at most [`super::MAX_ANGLE_RAD`]: to f32's rounding, by the series of `sin φ / φ`
    /// and its like.
    pub(super) fn by(angle: Vector3<f32>) -> Self {
        let square = angle.dot(&angle);
        let sine = 1.0
            - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5040.0 - square / 362_880.0)));
        let cosine = 0.5
            - square
                * (1.0 / 24.0 - square * (1.0 / 720.0 - square * (1.0 / 40_320.0 - square / 3_628_800.0)));
        let third = 1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5040.0 - square / 362_880.0));
        let cross = angle.cross_matrix();
        let twice = cross * cross;
        Self {
            angle,
            whole: Matrix3::identity() - cross * sine + twice * cosine,
            mean: Matrix3::identity() - cross * cosine + twice * third,
        }
    }
}
