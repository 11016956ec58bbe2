//! What a scenario demands of a run: the `[limits]` of its file.
//!
//! Every limit is a figure of the judge's table ([`table`]) and a value. All are optional; a run without
//! limits is flown and shown, and fails only where a number is none.

use super::text::Text;
use crate::error::HostError;
use crate::judge::Limit;
use crate::judge::table;
use std::collections::BTreeMap;
use toml::Spanned;

/// Reads the `[limits]`.
pub(super) fn read(
    text: &Text<'_>,
    raw: &BTreeMap<Spanned<String>, Spanned<f64>>,
) -> Result<Vec<Limit>, HostError> {
    for key in raw.keys() {
        if table::figure(key.get_ref()).is_none() {
            let names = table::figures().map(|figure| figure.key).collect::<Vec<_>>().join(", ");
            let (at, key) = (key.span().start, format!("limits.{}", key.get_ref()));
            return Err(text.fault(at, &key, "unknown limit", &format!("use one of {names}")));
        }
    }
    // In the order of the table, whatever that of the file.
    let mut limits = Vec::new();
    for of in table::figures() {
        if let Some((key, value)) = raw.iter().find(|(key, _)| key.get_ref() == of.key) {
            let key = format!("limits.{}", key.get_ref());
            limits.push(Limit { of, value: text.number(&key, Some(value), 0.0, of.range)? });
        }
    }
    Ok(limits)
}
