//! From the Hipparcos catalogue to the catalogue that flies: bytes in, bytes out, the same on every machine.
//!
//! | module | takes | gives |
//! |---|---|---|
//! | [`hip2`] | the text of `hip2.dat` | the compact star source (done once, kept in `data/`) |
//! | [`source`] | the compact star source | stars with their motion: 41,000, V <= 8, ICRS, epoch J1991.25 |
//! | [`parameters`] | a camera's field | limits of magnitude, density and separation, checked |
//! | [`blend`] | stars at the mission's epoch | blobs as a detector sees them |
//! | [`mod@build`] | stars, parameters | the onboard catalogue |
//! | [`mod@assemble`] | chosen stars | the bytes that `fsw_core::catalog` reads |
//! | [`coverage`], [`inspect`] | a catalogue | how many stars a field holds, and what the file contains |
//!
//! **Same bytes everywhere.** On the way to a byte there are only `+ - * / sqrt`, comparisons and the
//! functions of the `libm` crate; the mathematics of the host's own library differ in the last digit from one
//! system to the next.
//!
//! **Credit.** The star data come from the Hipparcos mission: ESA 1997, *The Hipparcos and Tycho Catalogues*,
//! ESA SP-1200, in the new reduction of F. van Leeuwen 2007, *Hipparcos, the New Reduction of the Raw Data*,
//! Astronomy & Astrophysics 474, 653 (catalogue I/311). Credit: ESA, licence CC BY 3.0 IGO. What was changed:
//! the stars to V 8.0 were selected, V was computed from Hp and B-V, values were rounded (see [`source`]),
//! and four entries that the new reduction lacks were added (see [`hip2`]).

#![forbid(unsafe_code)]

pub mod assemble;
pub mod blend;
pub mod build;
pub mod coverage;
pub mod grid;
pub mod hip2;
pub mod inspect;
pub mod parameters;
pub mod source;

pub use assemble::{CatalogueStar, TableParameters, assemble};
pub use build::{build, build_for_flight};
pub use parameters::{BuildError, BuildParameters, for_field};
pub use source::SourceStar;

/// The catalogue of the reference camera: [`build()`] of the embedded star source with
/// [`BuildParameters::reference`].
pub const REFERENCE: &[u8] = include_bytes!("../data/reference.cat");
