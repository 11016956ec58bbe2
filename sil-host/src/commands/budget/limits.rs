//! The file of limits.

use crate::error::HostError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The file of limits, from the workspace's root.
const LIMITS_FILE: &str = "tests/obc-image/budget.toml";
/// The version of it that is read.
const LIMITS_VERSION: u32 = 1;

#[derive(Clone, Debug, Deserialize)]
pub(super) struct LimitsFile {
    pub(super) version: u32,
    pub(super) target: TargetLimits,
    pub(super) cycles: CycleLimits,
    pub(super) memory: MemoryLimits,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct TargetLimits {
    pub(super) core: String,
    pub(super) clock_hz: u64,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct CycleLimits {
    pub(super) acquisition: u64,
    pub(super) tracking: u64,
    pub(super) stars_of_tracking: u64,
    pub(super) earth_of_acquisition: u64,
    pub(super) earth_of_tracking: u64,
    pub(super) orbit: u64,
    pub(super) scan_per_pixel: u64,
}

/// Limits of memory, bytes.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct MemoryLimits {
    pub(super) flash_bytes: u64,
    pub(super) static_ram_bytes: u64,
    pub(super) stack_bytes: u64,
    pub(super) ram_bytes: u64,
}

/// The workspace's root: the nearest folder at or above this one that holds the file of limits.
pub(super) fn workspace() -> Result<PathBuf, HostError> {
    let here = std::env::current_dir().unwrap_or_default();
    let root = here.ancestors().find(|folder| folder.join(LIMITS_FILE).is_file());
    root.map(Path::to_path_buf).ok_or_else(|| {
        HostError::usage(format!("{LIMITS_FILE} is not here or above"), "run it inside the repository")
    })
}

pub(super) fn read(root: &Path) -> Result<LimitsFile, HostError> {
    let path = root.join(LIMITS_FILE);
    let text = std::fs::read_to_string(&path)
        .map_err(|error| HostError::system(&path, "read", &error, "restore it"))?;
    let limits: LimitsFile = toml::from_str(&text)
        .map_err(|error| HostError::input(&path, None, error.message().to_owned(), "correct it"))?;
    if limits.version == LIMITS_VERSION {
        Ok(limits)
    } else {
        let what = format!("version {} instead of {LIMITS_VERSION}", limits.version);
        Err(HostError::input(&path, None, what, "use the program of the same revision"))
    }
}
