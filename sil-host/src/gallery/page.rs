//! The page of the gallery, in Markdown.

use super::{Figure, Made, Row, SEED};
use crate::words::program;
use std::fmt::Write as _;

/// Names of a figure's picture files.
pub fn files<'a>(figure: &'a Figure, made: &'a Made) -> impl Iterator<Item = String> + 'a {
    (1..=made.pictures.len()).map(|number| match number {
        1 => format!("{}.svg", figure.name),
        _ => format!("{}-{number}.svg", figure.name),
    })
}

/// The page of these figures.
pub fn markdown(all: &[(&Figure, Made)]) -> String {
    let mut page = format!(
        "# Gallery of the thesis\n\nEach figure or table by the flight code and the world of this project, beside the thesis's numbers; \
         made by `{} gallery`. The thesis's text is a scan without the pictures: where a curve or a digit of it \
         cannot be read, none stands here. Everything random comes from seed {SEED}.\n",
        program()
    );
    all.iter().for_each(|(figure, made)| section(&mut page, figure, made));
    page
}

/// The section of one.
pub fn section(page: &mut String, figure: &Figure, made: &Made) {
    let _ = write!(page, "\n## {}: {}\n\n", figure.name, figure.title);
    for file in files(figure, made) {
        let _ = writeln!(page, "![{}]({file})", figure.title);
    }
    let _ = write!(page, "\n| | ours | thesis | where |\n|---|---|---|---|\n");
    for Row { what, ours, thesis } in &made.rows {
        let (words, place) = thesis.map_or(("\u{2013}".to_owned(), ""), |told| (told.words(), told.place));
        let _ = writeln!(page, "| {what} | {ours} | {words} | {place} |");
    }
    let _ = write!(
        page,
        "\n{}\n\nThesis {}; `{} gallery {}`.\n",
        made.verdict,
        figure.place,
        program(),
        figure.name
    );
}
