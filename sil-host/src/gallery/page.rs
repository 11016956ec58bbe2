//! The page of the gallery, in Markdown.

use super::{Figure, Made, Row, SEED, figures};
use crate::words::program;
use std::fmt::Write as _;

/// Names of a figure's picture files.
pub fn files<'a>(figure: &'a Figure, made: &'a Made) -> impl Iterator<Item = String> + 'a {
    (1..=made.pictures.len()).map(|number| match number {
        1 => format!("{}.svg", figure.name),
        _ => format!("{}-{number}.svg", figure.name),
    })
}

/// What a figure's section begins with.
fn heading(figure: &Figure) -> String {
    format!("\n## {}: ", figure.name)
}

/// The section of a figure on a page written before.
fn kept<'p>(page: &'p str, figure: &Figure) -> Option<&'p str> {
    let begin = page.find(&heading(figure))?;
    let next = page[begin + 1..].find("\n## ");
    Some(&page[begin..next.map_or(page.len(), |next| begin + 1 + next)])
}

/// The page of these figures, and of the others that are on a page written `before`; in the order of the
/// thesis.
pub fn markdown(all: &[(&Figure, Made)], before: &str) -> String {
    let mut page = format!(
        "# Gallery of the thesis\n\nEach figure or table by the flight code and the world of this project, beside the thesis's numbers; \
         made by `{} gallery`. The thesis's text is a scan without the pictures: where a curve or a digit of it \
         cannot be read, none stands here. Everything random comes from seed {SEED}.\n",
        program()
    );
    for figure in figures() {
        match all.iter().find(|(made, _)| made.name == figure.name) {
            Some((figure, made)) => section(&mut page, figure, made),
            None => page += kept(before, figure).unwrap_or_default(),
        }
    }
    page
}

/// The section of one.
pub fn section(page: &mut String, figure: &Figure, made: &Made) {
    let _ = write!(page, "{}{}\n\n", heading(figure), figure.title);
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
