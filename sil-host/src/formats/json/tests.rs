use super::*;

/// What the lines of a file with these bytes are: number and text, or the fault.
fn lines(name: &str, bytes: &[u8]) -> Vec<Result<(usize, String), String>> {
    let path = std::env::temp_dir().join(format!("sextant-{}-{name}", std::process::id()));
    std::fs::write(&path, bytes).unwrap();
    let lines = Lines::open(&path, "give a line").unwrap();
    let lines = lines.map(|line| line.map_err(|fault| fault.to_string())).collect();
    std::fs::remove_file(&path).unwrap();
    lines
}

#[test]
fn a_line_that_is_no_text_is_a_fault_with_its_number_and_the_others_are_read() {
    let read = lines("no-text", b"one\n\n\xFF\xFE\nfour\r\n  \nsix");
    assert_eq!(read.len(), 4);
    assert_eq!(read[0], Ok((1, "one\n".into())));
    assert!(read[1].as_ref().unwrap_err().contains("no-text:3: no UTF-8 text; "), "{read:?}");
    assert_eq!(read[2], Ok((4, "four\r\n".into())));
    assert_eq!(read[3], Ok((6, "six".into())));
}

#[test]
fn a_file_without_lines_is_one_fault() {
    for (name, bytes) in [("empty", &b""[..]), ("blank", b"\n \t\r\n\n")] {
        let read = lines(name, bytes);
        assert_eq!(read.len(), 1);
        assert!(
            read[0].as_ref().unwrap_err().contains("the file is empty: it holds no line; give a line"),
            "{read:?}"
        );
    }
}
