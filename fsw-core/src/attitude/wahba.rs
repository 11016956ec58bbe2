//! Wahba's problem (thesis §3.1.4, eq. 3.4): the rotation `A` that minimises `½ Σ a |b - A r|²`, a file a method.

pub mod svd;

/// Why no attitude follows from a set of pairs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WahbaError {
    /// Fewer than two pairs.
    TooFew,
    /// All directions lie so close together that the rotation about them is undetermined.
    Degenerate,
    /// A direction or a sigma is not finite or not positive.
    NotFinite,
}
