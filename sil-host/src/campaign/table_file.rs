//! All runs of a campaign as one table: CSV or Parquet, by the file's name.
//!
//! In: runs that can be written as JSON. Out: a row a run, in their order. A column has the path of its value
//! with dots (`figures.position_95_km`); a list of words is one column, separated by semicolons. Of Parquet
//! a column is BOOLEAN, INT64, DOUBLE or UTF-8 by what all its values are; missing values are null. In CSV
//! they are empty.

use crate::error::HostError;
use crate::output::{self, write_whole};
use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A table to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct TableFile {
    path: PathBuf,
    parquet: bool,
}

/// A column: its name, and a value or none for every run.
type Column = (String, Vec<Option<Value>>);

impl TableFile {
    /// The table that is to be `path`.
    ///
    /// # Errors
    /// When its name says neither CSV nor Parquet, or it cannot be written there: hours later would be too
    /// late to say so.
    pub fn new(path: &Path) -> Result<Self, HostError> {
        let parquet = match path.extension().and_then(|extension| extension.to_str()) {
            Some("csv") => false,
            Some("parquet") => true,
            _ => {
                let what = format!("--table {}: neither .csv nor .parquet", path.display());
                return Err(HostError::usage(what, "name it so"));
            }
        };
        output::check(path)?;
        Ok(Self { path: path.to_path_buf(), parquet })
    }

    /// Writes it, a row a run.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn write<R: Serialize>(&self, runs: &[R]) -> Result<(), HostError> {
        let columns = columns(runs);
        let bytes = if self.parquet {
            as_parquet(&columns, runs.len()).map_err(|error| error.to_string())
        } else {
            as_csv(&columns, runs.len()).map_err(|error| error.to_string())
        };
        let fault =
            |what| HostError::input(&self.path, None, format!("cannot be made: {what}"), "report this");
        write_whole(&self.path, &bytes.map_err(fault)?)
    }
}

/// The values of all runs, by column.
fn columns<R: Serialize>(runs: &[R]) -> Vec<Column> {
    let mut columns: BTreeMap<String, Vec<Option<Value>>> = BTreeMap::new();
    for (index, run) in runs.iter().enumerate() {
        let mut flat = Vec::new();
        flatten(serde_json::to_value(run).unwrap_or_default(), String::new(), &mut flat);
        for (name, value) in flat {
            columns.entry(name).or_insert_with(|| vec![None; runs.len()])[index] = Some(value);
        }
    }
    columns.into_iter().collect()
}

/// The values in a tree, each with its path.
fn flatten(value: Value, path: String, into: &mut Vec<(String, Value)>) {
    let below = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
    match value {
        Value::Null => {}
        Value::Object(fields) => {
            fields.into_iter().for_each(|(name, value)| flatten(value, below(&name), into));
        }
        Value::Array(values) if values.iter().all(Value::is_string) => {
            let words: Vec<&str> = values.iter().filter_map(Value::as_str).collect();
            into.push((path, Value::String(words.join("; "))));
        }
        Value::Array(values) => {
            let each = values.into_iter().enumerate();
            each.for_each(|(index, value)| flatten(value, below(&index.to_string()), into));
        }
        scalar => into.push((path, scalar)),
    }
}

/// A value as text, words without quotes.
fn words(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

fn as_csv(columns: &[Column], rows: usize) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(columns.iter().map(|(name, _)| name))?;
    for row in 0..rows {
        writer.write_record(
            columns.iter().map(|(_, values)| values[row].as_ref().map_or(String::new(), words)),
        )?;
    }
    writer.into_inner().map_err(|error| error.into_error().into())
}

/// What all values of a column are.
fn physical(values: &[Option<Value>]) -> Physical {
    let all = |is: fn(&Value) -> bool| values.iter().flatten().all(is);
    if all(Value::is_boolean) {
        Physical::BOOLEAN
    } else if all(Value::is_i64) {
        Physical::INT64
    } else if all(|value| value.is_f64() || value.is_i64()) {
        Physical::DOUBLE
    } else {
        Physical::BYTE_ARRAY
    }
}

fn as_parquet(columns: &[Column], rows: usize) -> Result<Vec<u8>, ParquetError> {
    let field = |(name, values): &Column| {
        let kind = physical(values);
        let field = Type::primitive_type_builder(name, kind).with_repetition(Repetition::OPTIONAL);
        let text = kind == Physical::BYTE_ARRAY;
        Ok(Arc::new(if text { field.with_converted_type(ConvertedType::UTF8) } else { field }.build()?))
    };
    let fields = columns.iter().map(field).collect::<Result<Vec<_>, ParquetError>>()?;
    let schema = Arc::new(Type::group_type_builder("runs").with_fields(fields).build()?);
    let mut bytes = Vec::new();
    let mut file = SerializedFileWriter::new(&mut bytes, schema, Arc::new(WriterProperties::default()))?;
    let mut group = file.next_row_group()?;
    let mut left = columns.iter();
    while let (Some(mut column), Some((_, values))) = (group.next_column()?, left.next()) {
        let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
        let there = values.iter().flatten();
        match column.untyped() {
            ColumnWriter::BoolColumnWriter(writer) => {
                writer.write_batch(&there.filter_map(Value::as_bool).collect::<Vec<_>>(), Some(&levels), None)
            }
            ColumnWriter::Int64ColumnWriter(writer) => {
                writer.write_batch(&there.filter_map(Value::as_i64).collect::<Vec<_>>(), Some(&levels), None)
            }
            ColumnWriter::DoubleColumnWriter(writer) => {
                writer.write_batch(&there.filter_map(Value::as_f64).collect::<Vec<_>>(), Some(&levels), None)
            }
            ColumnWriter::ByteArrayColumnWriter(writer) => {
                let texts: Vec<ByteArray> = there.map(|value| words(value).as_str().into()).collect();
                writer.write_batch(&texts, Some(&levels), None)
            }
            _ => Ok(rows),
        }?;
        column.close()?;
    }
    group.close()?;
    file.close()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests;
