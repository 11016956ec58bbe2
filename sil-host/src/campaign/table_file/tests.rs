use super::*;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use serde_json::json;

fn runs() -> Vec<Value> {
    vec![
        json!({"run": 0, "name": "a, \"b\"", "kept": true, "figures": {"x": 1, "y": [0.5, 2.0]}, "missed": []}),
        json!({"run": 1, "name": "c", "kept": false, "figures": {"x": 0.25}, "missed": ["one", "two"], "more": null}),
    ]
}

#[test]
fn csv_has_a_row_a_run_and_a_column_a_value() {
    let text = String::from_utf8(as_csv(&columns(&runs()), 2).unwrap()).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines,
        [
            "figures.x,figures.y.0,figures.y.1,kept,missed,name,run",
            "1,0.5,2.0,true,,\"a, \"\"b\"\"\",0",
            "0.25,,,false,one; two,c,1"
        ]
    );
}

#[test]
fn parquet_read_again_has_the_values_with_their_kinds() {
    let bytes = as_parquet(&columns(&runs()), 2).unwrap();
    let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
    let rows: Vec<Vec<(String, Field)>> = reader
        .get_row_iter(None)
        .unwrap()
        .map(|row| {
            row.unwrap().get_column_iter().map(|(name, field)| (name.clone(), field.clone())).collect()
        })
        .collect();
    let named = |name: &str, field: Field| (name.to_owned(), field);
    assert_eq!(
        rows[1],
        [
            named("figures.x", Field::Double(0.25)),
            named("figures.y.0", Field::Null),
            named("figures.y.1", Field::Null),
            named("kept", Field::Bool(false)),
            named("missed", Field::Str("one; two".into())),
            named("name", Field::Str("c".into())),
            named("run", Field::Long(1)),
        ]
    );
    assert_eq!(rows[0][0].1, Field::Double(1.0));
}

#[test]
fn only_csv_and_parquet_are_tables() {
    let file = std::env::temp_dir().join(format!("sextant-table-{}.parquet", std::process::id()));
    assert!(TableFile::new(&file).is_ok() && !file.exists());
    assert!(TableFile::new(&file.join("a.csv")).is_err(), "no such folder");
    let message = TableFile::new(Path::new("a.xlsx")).unwrap_err().to_string();
    assert!(message.contains("a.xlsx: neither .csv nor .parquet"), "{message}");
}
