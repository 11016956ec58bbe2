//! Words of others made fit for a message of one line.

/// `text` with every run of white space and control characters replaced by one blank, so that a message stays
/// a line whatever a library or a file name puts into it.
pub(crate) fn one_line(text: &str) -> String {
    text.split(|c: char| c.is_whitespace() || c.is_control())
        .filter(|word| !word.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

/// The one of `list` that has this name.
///
/// # Errors
/// A list of the names there are, as what `they` are.
pub(crate) fn named<T: Copy>(list: &[(T, &str)], they: &str, name: &str) -> Result<T, String> {
    let known = list.iter().find(|(_, known)| *known == name).map(|(one, _)| *one);
    known.ok_or_else(|| {
        let names: Vec<_> = list.iter().map(|(_, name)| *name).collect();
        format!("{they} are {}", names.join(", "))
    })
}

/// The system's words for an input/output fault, without the number it adds to them.
pub(crate) fn io_words(error: &std::io::Error) -> String {
    let text = error.to_string();
    let words = text.split(" (os error").next().unwrap_or(&text);
    one_line(words).to_lowercase()
}

/// The name under which the program is installed (`src/bin/sextant.rs`).
pub(crate) const INSTALLED: &str = "sextant";

/// The file name of the program as it was called.
fn called() -> Option<String> {
    let called = std::env::args_os().next().map(std::path::PathBuf::from)?;
    Some(one_line(&called.file_stem()?.to_string_lossy()))
}

/// The program's name, before its messages.
pub(crate) fn name() -> &'static str {
    if called().as_deref() == Some(INSTALLED) { INSTALLED } else { "sil-host" }
}

/// How this program was called, for hints that a user types: `cargo sil` under cargo, which puts no program
/// on the path, else the program's file name.
pub(crate) fn program() -> String {
    match std::env::var_os("CARGO") {
        Some(_) => "cargo sil".to_owned(),
        None => called().unwrap_or_else(|| name().to_owned()),
    }
}
