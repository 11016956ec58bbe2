//! All that light needs of the Earth and that does not change in a run: the face, the horizon, the limb's
//! profile.
//!
//! In: seed, model. Out: [`Looks`], shared. It is a pure function of both; the last few are kept, because
//! maps and tables fill slowly and every exposure asks for them.

use super::EarthModel;
use super::albedo::Albedo;
use super::horizon::Horizon;
use super::limb::Limb;
use super::map::AlbedoMap;
use std::sync::{Arc, Mutex, PoisonError};

/// How many are kept.
const KEPT: usize = 3;

/// The Earth of a seed.
#[derive(Debug)]
pub struct Looks {
    /// Its face.
    pub map: AlbedoMap,
    /// How high its limb stands.
    pub horizon: Horizon,
    /// The profile across its limb.
    pub limb: Limb,
}

static LAST: Mutex<Vec<(u64, EarthModel, Arc<Looks>)>> = Mutex::new(Vec::new());

impl Looks {
    /// The Earth of `seed` as `model` has it.
    pub fn of(seed: u64, model: &EarthModel) -> Arc<Self> {
        let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((.., looks)) = last.iter().find(|(s, m, _)| *s == seed && m == model) {
            return Arc::clone(looks);
        }
        let face = Albedo::new(seed, model.mean_albedo, model.cloud_contrast);
        let looks = Arc::new(Self {
            horizon: Horizon::new(model.horizon, seed, model.height_variation_km, model.season, &face),
            map: AlbedoMap::new(face),
            limb: Limb::new(model),
        });
        if last.len() == KEPT {
            last.remove(0);
        }
        last.push((seed, *model, Arc::clone(&looks)));
        looks
    }
}
