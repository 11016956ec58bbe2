//! Blocks of fields: what is tried at a time, and what came of it.
//!
//! In: a case and the numbers of its fields. Out: a [`Block`] of whole numbers that depend on the seed, the
//! case and the numbers of the fields alone, so that any order and any number of threads give the same table.

use super::cases::{Case, Maker};
use crate::commands::attitude::table::APART_PX;
use crate::commands::identify::{FieldInput, answer_with};
use crate::flight::lost_in_space::Solver;
use crate::judge::{arcsec, attitude_error};
use crate::world::fields::Field;
use fsw_core::camera::Camera;
use fsw_core::catalog::Catalogue;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Fields of a block.
pub const FIELDS: u64 = 250;
/// A line of sight further off than this shows another part of the sky.
const WRONG_SIGHT_ARCSEC: f64 = 900.0;
/// So does a roll. Three stars near each other, with 2 px noise, give the roll to half a degree.
const WRONG_ROLL_ARCSEC: f64 = 3.0 * 3600.0;

/// Which block.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Key {
    /// Seed of the campaign.
    pub seed: u64,
    /// Name of the case.
    pub case: String,
    /// Number of the first field.
    pub first: u64,
    /// Number of fields.
    pub fields: u64,
}

/// What came of some fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Outcome {
    /// Fields tried.
    pub tried: u64,
    /// Of these, identified.
    pub identified: u64,
    /// Of these, with an attitude that is not the true one.
    pub wrong: u64,
    /// Centroids named.
    pub names: u64,
    /// Of these, with a name whose star stands elsewhere.
    pub wrong_names: u64,
    /// Of these, beside the star of that name, within the image of a star: a companion, part of a blend.
    pub companions: u64,
    /// Sum of the stated false-identification probabilities, in parts per thousand million.
    pub stated_ppb: u64,
}

impl Outcome {
    /// Both together.
    pub fn and(&self, other: &Self) -> Self {
        Self {
            tried: self.tried + other.tried,
            identified: self.identified + other.identified,
            wrong: self.wrong + other.wrong,
            names: self.names + other.names,
            wrong_names: self.wrong_names + other.wrong_names,
            companions: self.companions + other.companions,
            stated_ppb: self.stated_ppb + other.stated_ppb,
        }
    }
}

/// A block and what came of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Block {
    /// Which.
    #[serde(flatten)]
    pub key: Key,
    /// What came of it.
    #[serde(flatten)]
    pub outcome: Outcome,
}

/// The blocks of these fields of a case.
pub fn of_case(case: &Case, seed: u64, fields: Range<u64>) -> impl Iterator<Item = Key> {
    let name = case.name.clone();
    let firsts = fields.clone().step_by(FIELDS as usize);
    firsts.map(move |first| Key { seed, case: name.clone(), first, fields: FIELDS.min(fields.end - first) })
}

/// Holds an answer against the truth.
fn judge(
    solver: &mut Solver,
    maker: &Maker<'_>,
    field: &Field,
    camera: &Camera,
    catalogue: &Catalogue,
) -> Outcome {
    let with_brightness = maker.with_brightness();
    let centroids = field.stars.iter().map(|star| match with_brightness {
        true => vec![star.pixel[0], star.pixel[1], star.brightness],
        false => star.pixel.to_vec(),
    });
    let input = FieldInput { id: field.id.into(), centroids: centroids.collect() };
    let found = answer_with(maker.criterion(), solver, &input, camera, catalogue);
    let mut outcome = Outcome { tried: 1, ..Outcome::default() };
    let Some(quaternion) = found.q else { return outcome };
    outcome.identified = 1;
    outcome.stated_ppb = (found.false_id_probability.unwrap_or(1.0) * 1e9) as u64;
    let [x, y, z] = attitude_error(quaternion, field.quaternion).map(|error| arcsec(error).abs());
    let no_star = field.stars.iter().all(|star| star.hip.is_none());
    outcome.wrong = (no_star || x.max(y) > WRONG_SIGHT_ARCSEC || z > WRONG_ROLL_ARCSEC).into();
    for (name, star) in found.hip.iter().zip(&field.stars) {
        let Some(name) = name else { continue };
        outcome.names += 1;
        if star.hip == Some(*name) {
            continue;
        }
        let place = maker.place(field, *name);
        let beside = place.is_some_and(|[x, y]| libm::hypot(star.pixel[0] - x, star.pixel[1] - y) < APART_PX);
        outcome.companions += u64::from(beside);
        outcome.wrong_names += u64::from(!beside);
    }
    outcome
}

/// Tries a block.
pub fn fly(
    key: Key,
    maker: &Maker<'_>,
    camera: &Camera,
    catalogue: &Catalogue,
    solver: &mut Solver,
) -> Block {
    let numbers = key.first..key.first + key.fields;
    let outcomes = numbers.map(|index| judge(solver, maker, &maker.field(index), camera, catalogue));
    let outcome = outcomes.fold(Outcome::default(), |sum, one| sum.and(&one));
    Block { key, outcome }
}

#[cfg(test)]
mod tests;
