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

/// Between what stands in a file and what should ([`kinds`]).
pub(crate) const IN_THE_PLACE_OF: &str = " in the place of ";

/// A parser's complaint of a value of another kind in the words of the file instead of the program's types;
/// any other as it is.
pub(crate) fn kinds(message: &str) -> String {
    // A list whose elements were taken for the values of keys.
    if message.starts_with("invalid length ") && message.contains(", expected struct ") {
        return format!("a list{IN_THE_PLACE_OF}a table of keys");
    }
    let found = message.strip_prefix("invalid type: ").and_then(|rest| rest.split_once(", expected "));
    let Some((found, expected)) = found else { return message.to_owned() };
    let found = match found {
        "map" => "a table",
        "sequence" => "a list",
        other => other,
    };
    let expected = match expected {
        "f64" | "f32" => "a number",
        "i64" | "i32" | "u64" | "u32" | "u16" | "u8" | "usize" => "a whole number",
        "a boolean" => "true or false",
        "a sequence" => "a list",
        "a map" => "a table",
        of if of.starts_with("struct ") => "a table of keys",
        other => other,
    };
    format!("{found}{IN_THE_PLACE_OF}{expected}")
}

/// The one of `names` that a misspelt one is most like, if at most a third of its letters are others.
pub(crate) fn nearest<'n>(name: &str, names: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    let distant = names.into_iter().map(|known| (distance(name, known), known));
    let (letters, known) = distant.min_by_key(|(letters, _)| *letters)?;
    (3 * letters <= known.chars().count()).then_some(known)
}

/// The [`nearest`] name as the begin of what is to be done; nothing where there is none.
pub(crate) fn nearest_first<'n>(name: &str, names: impl IntoIterator<Item = &'n str>) -> String {
    nearest(name, names).map_or(String::new(), |near| format!("the nearest name is {near}: "))
}

/// Letters to put in, take out or change to make one word of another (Levenshtein).
fn distance(one: &str, other: &str) -> usize {
    let other: Vec<char> = other.chars().collect();
    let mut row: Vec<usize> = (0..=other.len()).collect();
    for (index, letter) in one.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], index + 1);
        for (place, known) in other.iter().enumerate() {
            let changed = diagonal + usize::from(letter != *known);
            diagonal = row[place + 1];
            row[place + 1] = changed.min(diagonal + 1).min(row[place] + 1);
        }
    }
    row[other.len()]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_of_another_kind_is_told_without_types_of_the_program() {
        assert_eq!(kinds("invalid type: map, expected f64"), "a table in the place of a number");
        assert_eq!(
            kinds("invalid type: string \"98\", expected i64"),
            "string \"98\" in the place of a whole number"
        );
        assert_eq!(
            kinds("invalid type: sequence, expected struct Input"),
            "a list in the place of a table of keys"
        );
        assert_eq!(
            kinds("invalid length 1, expected struct Input with 5 elements"),
            "a list in the place of a table of keys"
        );
        let length = "invalid length 2, expected an array of length 3";
        assert_eq!(kinds(length), length);
        assert_eq!(kinds("missing field `id`"), "missing field `id`");
    }

    #[test]
    fn a_misspelt_name_is_told_from_another_one() {
        let names = ["geo-day", "geo-eclipse", "leo-oblique"];
        assert_eq!(nearest("geo-eclpise", names), Some("geo-eclipse"));
        assert_eq!(nearest("geoday", names), Some("geo-day"));
        assert_eq!(nearest("my-orbit", names), None);
        assert_eq!(nearest("a", []), None);
    }
}
