//! Which program made a result: a version and a build.

use std::hash::{DefaultHasher, Hasher};
use std::sync::OnceLock;

/// Version, and a number made of the program's own bytes: results with the same words came of the same
/// program. Only the version where the program cannot be read.
pub fn words() -> &'static str {
    static WORDS: OnceLock<String> = OnceLock::new();
    WORDS.get_or_init(|| {
        let version = env!("CARGO_PKG_VERSION");
        let Ok(bytes) = std::env::current_exe().and_then(std::fs::read) else { return version.to_owned() };
        let mut hasher = DefaultHasher::new();
        hasher.write(&bytes);
        format!("{version} build {:08x}", hasher.finish() as u32)
    })
}
