use super::*;
use crate::campaign::identify::blocks::{Block, Key, Outcome};

/// A file of this test, not there yet.
fn scratch(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("sextant-lines-{}-{name}.jsonl", std::process::id()));
    let _ = std::fs::remove_file(&path);
    path
}

fn block(first: u64) -> Block {
    let key = Key { seed: 1, case: "a case".to_string(), first, fields: 3 };
    Block { key, outcome: Outcome { tried: 3, identified: 2, names: first, ..Outcome::default() } }
}

#[test]
fn a_file_gives_back_what_was_added_but_for_a_line_that_was_cut_off() {
    let path = scratch("cut");
    let (file, held) = LinesFile::open::<Block>(Some(&path)).unwrap();
    assert!(held.is_empty());
    (0..3).for_each(|first| file.add(&block(first)).unwrap());
    drop(file);
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, &text[..text.len() - 5]).unwrap();
    let (file, held) = LinesFile::open::<Block>(Some(&path)).unwrap();
    assert_eq!(held.len(), 2);
    file.add(&block(2)).unwrap();
    drop(file);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
    let (_, held) = LinesFile::open::<Block>(Some(&path)).unwrap();
    assert_eq!(held, [0, 1, 2].map(block));
    std::fs::remove_file(&path).unwrap();
}

#[test]
fn a_file_of_something_else_is_refused_with_its_line_and_left_alone() {
    let path = scratch("other");
    for second in [&b"{\"id\":3}"[..], b"\xFF\xFE"] {
        let block = serde_json::to_vec(&block(0)).unwrap();
        let bytes = [&block[..], b"\n", second, b"\nhalf"].concat();
        std::fs::write(&path, &bytes).unwrap();
        let message = LinesFile::open::<Block>(Some(&path)).unwrap_err().to_string();
        assert!(message.contains(".jsonl:2: no line of such a campaign"), "{message}");
        assert!(!message.contains('\n'), "{message}");
        assert_eq!(std::fs::read(&path).unwrap(), bytes);
    }
    std::fs::remove_file(&path).unwrap();
}

#[test]
fn two_campaigns_at_a_time_on_one_file_are_refused() {
    let path = scratch("shared");
    let first = LinesFile::open::<Block>(Some(&path)).unwrap();
    let message = LinesFile::open::<Block>(Some(&path)).unwrap_err().to_string();
    assert!(message.contains("another run is writing into this file"), "{message}");
    drop(first);
    assert!(LinesFile::open::<Block>(Some(&path)).is_ok());
    std::fs::remove_file(&path).unwrap();
}
