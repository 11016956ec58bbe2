//! The book of Sextant (`sil-host/book`), built by mdBook's library.

use mdbook_driver::MDBook;
use mdbook_driver::errors::Result;
use std::path::Path;
use system_tests::workspace;

/// Builds the book into a folder and gives its chapters: name and text as they stand on the page, what they
/// include included.
///
/// # Errors
/// What mdBook says.
pub fn build(folder: &Path) -> Result<Vec<(String, String)>> {
    let mut book = MDBook::load(workspace().join("sil-host/book"))?;
    book.config.build.build_dir = folder.to_path_buf();
    book.build()?;
    let chapters = book.book.chapters();
    Ok(chapters.map(|chapter| (chapter.name.clone(), chapter.content.clone())).collect())
}
