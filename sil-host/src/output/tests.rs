use super::*;

/// An empty folder of the test's own.
fn fresh(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("sextant-output-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let names =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

#[test]
fn a_file_has_its_name_only_when_it_is_whole() {
    let folder = fresh("whole");
    let path = folder.join("a.csv");
    std::fs::write(&path, "old").unwrap();
    let mut file = PartialFile::create(&path).unwrap();
    file.write(b"new").unwrap();
    assert_eq!(
        (names(&folder), std::fs::read(&path).unwrap()),
        (vec!["a.csv".into(), "a.csv.partial".into()], b"old".into())
    );
    file.finish().unwrap();
    assert_eq!((names(&folder), std::fs::read(&path).unwrap()), (vec!["a.csv".into()], b"new".into()));
    // Stopped: what was written is left, marked; nothing is left of nothing.
    let mut file = PartialFile::create(&path).unwrap();
    file.write(b"half").unwrap();
    drop(file);
    drop(PartialFile::create(&folder.join("b")).unwrap());
    assert_eq!(names(&folder), ["a.csv", "a.csv.partial"]);
    assert_eq!(std::fs::read(&path).unwrap(), b"new");
}

#[test]
fn bytes_handed_over_before_are_replaced_and_writing_goes_on_at_the_end() {
    let path = fresh("replaced").join("a");
    let mut file = PartialFile::create(&path).unwrap();
    file.keep(b"until ....");
    assert_eq!((file.length(), std::fs::read(path.with_extension("partial")).unwrap()), (10, Vec::new()));
    file.overwrite(6, b"noon").unwrap();
    file.write(b", rest").unwrap();
    assert_eq!(file.length(), 16);
    file.finish().unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), b"until noon, rest");
}

#[test]
fn a_file_that_cannot_be_written_leaves_nothing() {
    let folder = fresh("refused");
    let error = write_whole(&folder.join("none/a"), b"new").unwrap_err().to_string();
    assert!(error.contains("cannot be written") && !error.contains('\n'), "{error}");
    // A folder stands where the file is to be: renamed it cannot be.
    std::fs::create_dir(folder.join("a")).unwrap();
    assert!(write_whole(&folder.join("a"), b"new").is_err());
    assert_eq!(names(&folder), ["a"]);
}

#[test]
fn a_folder_belongs_to_one_run_and_begins_fresh() {
    let folder = fresh("claimed");
    for old in ["summary.json", "cycles.csv.partial", "notes.txt"] {
        std::fs::write(folder.join(old), "old").unwrap();
    }
    let claimed = Folder::claim(&folder, &["summary.json", "cycles.csv"]).unwrap();
    assert_eq!(names(&folder), [".lock", "notes.txt"]);
    let error = Folder::claim(&folder, &["summary.json"]).unwrap_err().to_string();
    assert!(error.contains("another run is writing into this folder"), "{error}");
    drop(claimed);
    assert_eq!(names(&folder), ["notes.txt"]);
    drop(Folder::claim(&folder, &[]).unwrap());
}

#[cfg(unix)]
#[test]
fn a_link_is_followed_and_stays_one() {
    let folder = fresh("linked");
    std::fs::create_dir(folder.join("there")).unwrap();
    std::os::unix::fs::symlink("there/a", folder.join("link")).unwrap();
    // First to a file that is not there yet, then over it.
    for words in ["one", "two"] {
        write_whole(&folder.join("link"), words.as_bytes()).unwrap();
        assert!(std::fs::symlink_metadata(folder.join("link")).unwrap().is_symlink());
        assert_eq!(std::fs::read(folder.join("there/a")).unwrap(), words.as_bytes());
    }
    assert_eq!(names(&folder), ["link", "there"]);
    assert_eq!(names(&folder.join("there")), ["a"]);
}

#[cfg(unix)]
#[test]
fn a_pipe_is_written_and_stays_one() {
    use std::os::unix::fs::FileTypeExt;
    let folder = fresh("pipe");
    let pipe = folder.join("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || std::fs::read(pipe).unwrap()
    });
    write_whole(&pipe, b"through").unwrap();
    assert_eq!(reader.join().unwrap(), b"through");
    assert!(std::fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo());
    assert_eq!(names(&folder), ["pipe"]);
}
