//! Arguments of `gallery`.

use clap::Args;
use std::path::PathBuf;

/// Arguments of `gallery`.
#[derive(Debug, Args)]
pub struct GalleryArguments {
    /// Names of figures, as --list prints them; none: all
    #[arg(value_name = "FIGURE")]
    pub figures: Vec<String>,
    /// Make nothing; print names and titles
    #[arg(long)]
    pub list: bool,
    /// Folder for the pictures and gallery.md
    #[arg(long, value_name = "DIR", default_value = "gallery")]
    pub out: PathBuf,
}
