//! Words of others made fit for a message of one line.

/// `text` with every run of white space and control characters replaced by one blank, so that a message stays
/// a line whatever a library or a file name puts into it.
pub(crate) fn one_line(text: &str) -> String {
    text.split(|c: char| c.is_whitespace() || c.is_control())
        .filter(|word| !word.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

/// The system's words for an input/output fault, without the number it adds to them.
pub(crate) fn io_words(error: &std::io::Error) -> String {
    let text = error.to_string();
    let words = text.split(" (os error").next().unwrap_or(&text);
    one_line(words).to_lowercase()
}
