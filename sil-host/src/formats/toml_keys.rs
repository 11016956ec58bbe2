//! The keys of a TOML text and the lines in which they stand, for messages.

use toml::de::{DeTable, DeValue};

/// Line of a byte, from 1.
pub fn line_at(text: &str, at: usize) -> usize {
    text.get(..at).unwrap_or(text).matches('\n').count() + 1
}

/// Every key of a text with its line: tables, values, elements of arrays.
pub fn keys(text: &str) -> Vec<(String, usize)> {
    fn walk(value: &DeValue<'_>, path: &str, text: &str, into: &mut Vec<(String, usize)>) {
        let below = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
        match value {
            DeValue::Table(table) => {
                for (key, value) in table {
                    let name = below(key.get_ref());
                    into.push((name.clone(), line_at(text, key.span().start)));
                    walk(value.get_ref(), &name, text, into);
                }
            }
            DeValue::Array(values) => {
                for (index, value) in values.iter().enumerate() {
                    let name = below(&index.to_string());
                    into.push((name.clone(), line_at(text, value.span().start)));
                    walk(value.get_ref(), &name, text, into);
                }
            }
            _ => {}
        }
    }
    let mut keys = Vec::new();
    if let Ok(table) = DeTable::parse(text) {
        walk(&DeValue::Table(table.into_inner()), "", text, &mut keys);
    }
    keys
}

/// The key that stands in a line of a text; of several the one above the others.
pub fn key_at(text: &str, line: usize) -> Option<String> {
    let keys = keys(text).into_iter().filter(|(_, at)| *at == line);
    keys.map(|(name, _)| name).min_by_key(String::len)
}
