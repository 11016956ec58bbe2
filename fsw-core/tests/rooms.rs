//! The rooms of `fsw-core`: a room uses those above it only, and its files form no circle.
//!
//! Read from the sources: every path that starts with `crate::`, `self::`, `super::` or a flight crate's name
//! outside of tests and comments. What the reader cannot see: a path of another kind, such as a type that a neighbour hands over
//! without its name.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What every room may use, bottom first.
const GROUND_FLOOR: [&str; 9] =
    ["checksum", "file", "word_sum", "matrix", "trigonometry", "frames", "order", "packet", "table"];
/// The rooms above it; each may use those before it.
const ROOMS: [&str; 17] = [
    "image",
    "camera",
    "catalog",
    "attitude",
    "rate",
    "stars",
    "earth",
    "orbit",
    "modes",
    "shutting",
    "magnetism",
    "parameters",
    "plan",
    "outages",
    "command",
    "telemetry",
    "sensor",
];
/// Those that use the ground floor alone.
const ALONE: [&str; 7] = ["image", "camera", "catalog", "attitude", "orbit", "modes", "magnetism"];

/// Crates of their own: the folder beside `src`, the name, and the path of its root as `fsw-core` gives it on.
const CRATES: [(&str, &str, &[&str]); 2] =
    [("ground", "fsw_ground", &[]), ("orbit", "fsw_orbit", &["orbit"])];

/// A module and the modules that its flight code names, each a path from the crate's root.
struct Module {
    path: Vec<String>,
    uses: BTreeSet<Vec<String>>,
}

fn room(path: &[String]) -> String {
    match path {
        [first, ..] => first.clone(),
        [] => String::new(),
    }
}

/// The lines that fly: no comments, and nothing that `#[cfg(test)]` stands before. Also gives the names of
/// test modules.
fn flight_code(text: &str) -> (String, Vec<String>) {
    let (mut code, mut tests) = (String::new(), Vec::new());
    let mut lines = text.lines().map(|line| line.split("//").next().unwrap_or(""));
    while let Some(line) = lines.next() {
        if line.trim() != "#[cfg(test)]" {
            code.push_str(line);
            code.push('\n');
            continue;
        }
        let Some(item) = lines.by_ref().find(|line| !line.trim_start().starts_with("#[")) else { break };
        if let Some(name) = item.trim_end_matches(';').split("mod ").nth(1) {
            tests.push(name.trim_end_matches(" {").to_owned());
        }
        let end = item.len() - item.trim_start().len();
        if !item.trim_end().ends_with(';') {
            // To the brace that closes it, which stands below its first letter.
            lines.by_ref().find(|line| line.starts_with(&format!("{}}}", " ".repeat(end))));
        }
    }
    (code, tests)
}

/// The paths in a tree such as `a::{b, c::d}`, up to where it ends.
fn paths(tree: &str, prefix: &[String], found: &mut BTreeSet<Vec<String>>) {
    let mut path = prefix.to_vec();
    let mut rest = tree;
    loop {
        let length =
            rest.find(|letter: char| !letter.is_alphanumeric() && letter != '_').unwrap_or(rest.len());
        let (name, after) = rest.split_at(length);
        match (name, after.strip_prefix("::")) {
            ("", _) if after.starts_with('{') => {
                let (mut depth, mut start) = (0, 1);
                for (at, letter) in after.char_indices() {
                    depth += i32::from(letter == '{') - i32::from(letter == '}');
                    if (letter == ',' && depth == 1) || depth == 0 {
                        paths(after[start..at].trim(), &path, found);
                        start = at + 1;
                    }
                    if depth == 0 {
                        return;
                    }
                }
                return;
            }
            ("self", _) if !path.is_empty() => {}
            ("super", _) => {
                path.pop();
            }
            ("", _) => {}
            _ => path.push(name.to_owned()),
        }
        match after.strip_prefix("::") {
            Some(deeper) if !name.is_empty() => rest = deeper,
            _ => break,
        }
    }
    found.insert(path);
}

fn owned(path: &[&str]) -> Vec<String> {
    path.iter().map(|&name| name.to_owned()).collect()
}

/// The modules of a directory; `root` is the path of its crate's root.
fn read(directory: &Path, root: &[String], path: &[String], tests: &[String], modules: &mut Vec<Module>) {
    let mut entries: Vec<_> =
        std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for file in entries.iter().filter(|file| file.extension().is_some_and(|ending| ending == "rs")) {
        let name = file.file_stem().unwrap().to_str().unwrap().to_owned();
        if name == "lib" || tests.contains(&name) {
            continue;
        }
        let module = [path, &[name]].concat();
        let (code, own_tests) = flight_code(&std::fs::read_to_string(file).unwrap());
        let mut uses = BTreeSet::new();
        let own = [("crate", root.to_vec()), ("super", path.to_vec()), ("self", module.clone())];
        let crates = CRATES.iter().map(|(_, name, root)| (*name, owned(root)));
        for (start, prefix) in own.into_iter().chain(crates) {
            let start = format!("{start}::");
            for (at, _) in code.match_indices(&start) {
                let before = &code[..at];
                let word =
                    before.ends_with(|letter: char| letter.is_alphanumeric() || "_:$".contains(letter));
                if !word && !before.ends_with("in ") {
                    paths(&code[at + start.len()..], &prefix, &mut uses);
                }
            }
        }
        let children = file.with_extension("");
        if children.is_dir() {
            read(&children, root, &module, &own_tests, modules);
        }
        modules.push(Module { path: module, uses });
    }
}

fn modules() -> Vec<Module> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut modules = Vec::new();
    let mut read_crate = |source: &Path, root: &[String]| {
        let (_, tests) = flight_code(&std::fs::read_to_string(source.join("lib.rs")).unwrap());
        read(source, root, root, &tests, &mut modules);
    };
    read_crate(&here.join("src"), &[]);
    for (folder, _, root) in CRATES {
        read_crate(&here.join(folder).join("src"), &owned(root));
    }
    modules
}

#[test]
fn a_room_uses_those_above_it_only() {
    let floor = |room: &str| {
        let rooms = GROUND_FLOOR.iter().chain(&ROOMS);
        rooms
            .into_iter()
            .position(|other| *other == room)
            .unwrap_or_else(|| panic!("{room} is no room of the table"))
    };
    let mut upward = Vec::new();
    for Module { path, uses } in modules() {
        let here = room(&path);
        for used in &uses {
            let there = room(used);
            let ground = GROUND_FLOOR.contains(&there.as_str());
            let allowed =
                here == there || floor(&there) < floor(&here) && (ground || !ALONE.contains(&here.as_str()));
            if !allowed {
                upward.push(format!("{} uses {}", path.join("::"), used.join("::")));
            }
        }
    }
    assert!(upward.is_empty(), "{} arrows upward:\n{}", upward.len(), upward.join("\n"));
}

/// Each file of a room stands for the files below it. The room's own file holds the words that all of them
/// share and is left out.
#[test]
fn the_files_of_a_room_form_no_circle() {
    let modules = modules();
    let file = |path: &[String]| path.get(..2).map(<[String]>::to_vec);
    let files: BTreeSet<_> = modules.iter().filter_map(|module| file(&module.path)).collect();
    let mut uses: BTreeMap<Vec<String>, BTreeSet<Vec<String>>> = BTreeMap::new();
    for module in &modules {
        let Some(here) = file(&module.path) else { continue };
        let others = module.uses.iter().filter_map(|used| file(used));
        let siblings = others.filter(|other| *other != here && other[0] == here[0] && files.contains(other));
        uses.entry(here.clone()).or_default().extend(siblings);
    }
    // Files that use none of those left are taken away until none goes; what stays hangs on a circle.
    while let Some(free) = uses.iter().find(|(_, used)| used.is_empty()).map(|(file, _)| file.clone()) {
        uses.remove(&free);
        uses.values_mut().for_each(|used| {
            used.remove(&free);
        });
    }
    let circles: Vec<_> = uses
        .iter()
        .map(|(file, used)| {
            let used: Vec<_> = used.iter().map(|other| other.join("::")).collect();
            format!("{} uses {}", file.join("::"), used.join(", "))
        })
        .collect();
    assert!(circles.is_empty(), "files that form circles, or use those that do:\n{}", circles.join("\n"));
}
