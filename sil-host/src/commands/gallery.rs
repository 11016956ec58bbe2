//! `sil-host gallery`: the thesis's figures and tables, ours over the thesis's numbers ([`crate::gallery`]).
//!
//! In: names of figures; none: all. Out, in a folder: an SVG file or more a figure, and `gallery.md` with
//! the pictures, a table of ours beside the thesis's, and where and why they differ. A line a figure on
//! stdout says where its picture lies.

use crate::cli::GalleryArguments;
use crate::error::HostError;
use crate::gallery::{Figure, Made, figures, page};
use crate::output::{self, Folder};
use crate::words::{nearest_first, program};
use std::process::ExitCode;

/// The page's file.
const PAGE: &str = "gallery.md";

/// The figures of these names, each once, in the order of the thesis; of none, all.
///
/// # Errors
/// A name that is none.
fn chosen(names: &[String]) -> Result<Vec<&'static Figure>, HostError> {
    if let Some(unknown) = names.iter().find(|name| figures().all(|figure| figure.name != **name)) {
        let near = nearest_first(unknown, figures().map(|figure| figure.name));
        let to_do = format!("{near}`{} gallery --list` has them all", program());
        return Err(HostError::usage(format!("there is no figure {unknown:?}"), to_do));
    }
    let asked = |figure: &&Figure| names.is_empty() || names.iter().any(|name| name == figure.name);
    Ok(figures().filter(asked).collect())
}

/// Runs the command.
///
/// # Errors
/// A name that is none, a folder that cannot be written, a figure that cannot be made.
pub fn run(arguments: &GalleryArguments) -> Result<ExitCode, HostError> {
    let chosen = chosen(&arguments.figures)?;
    if arguments.list {
        chosen.iter().for_each(|figure| print_line!("{:<16}{}", figure.name, figure.title));
        return Ok(ExitCode::SUCCESS);
    }
    let folder = Folder::claim(&arguments.out, &[])?;
    let mut all: Vec<(&Figure, Made)> = Vec::new();
    for figure in chosen {
        let made = (figure.make)(figure)?;
        for (name, picture) in page::files(figure, &made).zip(&made.pictures) {
            output::write_whole(&folder.file(&name), picture.as_bytes())?;
            print_line!("{:<16}{}", figure.name, folder.file(&name).display());
        }
        all.push((figure, made));
    }
    let path = folder.file(PAGE);
    // Figures made before stay on the page.
    let before = std::fs::read_to_string(&path).unwrap_or_default();
    output::write_whole(&path, page::markdown(&all, &before).as_bytes())?;
    eprintln!("sil-host: page in {}", path.display());
    Ok(ExitCode::SUCCESS)
}
