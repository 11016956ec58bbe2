//! The `[mount]` of a scenario: how the star path stands to the Earth path.

use super::ANGLE_DEG;
use super::text::Text;
use crate::error::HostError;
use crate::world::motion::pointing::Mount;
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawMount {
    star_path_deg: Option<Spanned<[f64; 3]>>,
    /// Whether the star path is seen in a mirror; where the file says nothing, as the camera has it.
    pub(super) mirrored: Option<bool>,
}

/// The mounting.
pub(super) fn read(text: &Text<'_>, raw: &RawMount) -> Result<Mount, HostError> {
    let star_path_deg = match &raw.star_path_deg {
        Some(angles) => text.array("mount.star_path_deg", angles, ANGLE_DEG)?,
        None => [0.0, 90.0, 0.0],
    };
    Ok(Mount { star_path_deg })
}
