//! The gallery of the thesis: what the command writes, and that the book's page is what it writes.

use std::fs;
use std::path::Path;
use system_tests::{refused, run, scratch, workspace};

/// Figures that take seconds and hold no time of the machine.
const QUICK: [&str; 5] = ["fig-6.2", "fig-3.26", "fig-7.13", "fig-8.5", "fig-A.7"];

/// The section of a figure, without its pictures.
fn section<'a>(page: &'a str, figure: &str) -> Vec<&'a str> {
    let head = format!("## {figure}: ");
    let from = page.lines().skip_while(|line| !line.starts_with(&head));
    let mut of_it = from.enumerate().take_while(|(number, line)| *number == 0 || !line.starts_with("## "));
    let lines =
        of_it.by_ref().map(|(_, line)| line).filter(|line| !line.starts_with("![") && !line.is_empty());
    lines.collect()
}

#[test]
fn a_figure_is_a_picture_a_table_and_a_reason() {
    let folder = scratch("gallery");
    let out = folder.to_str().expect("a name");
    let arguments: Vec<&str> = ["gallery"].into_iter().chain(QUICK).chain(["--out", out]).collect();
    let output = run(&arguments);
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{words}");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let page = fs::read_to_string(folder.join("gallery.md")).expect("the page");
    let book = fs::read_to_string(workspace().join("sil-host/book/src/gallery.md")).expect("the book's page");
    for figure in QUICK {
        let picture = format!("{figure}.svg");
        assert!(said.lines().any(|line| line.starts_with(figure) && line.ends_with(&picture)), "{said}");
        assert!(page.contains(&format!("({picture})")), "{figure}");
        let svg = fs::read_to_string(folder.join(&picture)).expect("the picture");
        assert!(svg.starts_with("<svg xmlns=") && svg.trim_end().ends_with("</svg>"), "{figure}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{figure}");
        let ours = section(&page, figure);
        assert!(ours.iter().filter(|line| line.starts_with('|')).count() > 2, "{figure}: {ours:?}");
        assert_eq!(ours, section(&book, figure), "the book's page is another: make it again as it says");
    }
    // The thesis's numbers stand beside ours, and both are in the picture's legend.
    assert!(section(&page, "fig-8.5").iter().any(|line| line.contains("| 4215 s |")));
    let svg = fs::read_to_string(folder.join("fig-3.26.svg")).expect("the picture");
    assert!(svg.contains(">ours, GEO") && svg.contains("thesis"));
    let svg = fs::read_to_string(folder.join("fig-8.5.svg")).expect("the picture");
    assert!(
        svg.contains(">outages in GEO, star path in the plane of the orbit<") && svg.contains(">state 2 ")
    );
    assert!(svg.contains("fill=\"#1f5fa8\"") && !svg.contains("var(--"), "colours that every viewer reads");
    // A figure made again leaves the others on the page.
    assert!(run(&["gallery", "fig-A.7", "--out", out]).status.success());
    assert_eq!(fs::read_to_string(folder.join("gallery.md")).expect("the page"), page);
}

#[test]
fn the_list_names_what_the_book_shows() {
    let output = run(&["gallery", "--list"]);
    assert!(output.status.success());
    let list = String::from_utf8_lossy(&output.stdout).into_owned();
    let names: Vec<&str> = list.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.len() >= 25 && names.contains(&"tab-3.9"), "{names:?}");
    let book = fs::read_to_string(workspace().join("sil-host/book/src/gallery.md")).expect("the book's page");
    for name in names {
        assert!(!section(&book, name).is_empty(), "{name} is not in the book");
    }
}

#[test]
fn a_name_that_is_none_and_a_folder_that_is_a_file_are_refused_in_a_line() {
    refused(&["gallery", "fig-99"], &["fig-99", "--list"]);
    let file = scratch("gallery-file").join("taken");
    fs::write(&file, b"a file").expect("written");
    refused(&["gallery", "fig-8.6", "--out", file.to_str().expect("a name")], &["taken"]);
    assert!(Path::new(&file).is_file());
}
