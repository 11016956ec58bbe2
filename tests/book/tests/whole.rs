//! The book builds, and nothing in it points to what is not there.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Values of an attribute in a page.
fn values<'a>(page: &'a str, attribute: &str) -> Vec<&'a str> {
    let opening = format!(" {attribute}=\"");
    page.split(&opening).skip(1).filter_map(|rest| rest.split('"').next()).collect()
}

#[test]
fn every_page_is_built_and_every_link_inside_leads_somewhere() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("book");
    let chapters = book::build(&folder).expect("the book builds");
    assert!(chapters.len() >= 10, "{}", chapters.len());
    for (name, text) in &chapters {
        assert!(text.len() > 400 || text.contains("{{#include"), "{name} is empty");
    }
    let pages: BTreeSet<String> = fs::read_dir(&folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .filter(|name| name.ends_with(".html"))
        .collect();
    for name in &pages {
        let page = fs::read_to_string(folder.join(name)).expect("a page");
        for link in values(&page, "href").into_iter().chain(values(&page, "src")) {
            let outside = link.starts_with("https://") || link.starts_with('#') || link.starts_with("data:");
            let file = link.split('#').next().unwrap_or_default();
            assert!(outside || folder.join(file).exists(), "{name} links to {link}");
        }
        // A reader without a network sees all of it.
        assert!(!page.contains("<script src=\"http") && !page.contains("url(http"), "{name} needs a network");
        // What could not be included stands in the page as it was written.
        assert!(!page.contains("{{#include"), "{name} has a file left out");
    }
}
