//! Licences and origins of all packages, judged by `.ci/deny.toml`; what ours hold when they are published.
//!
//! What flies and what is installed takes its `allow` alone; the tools of the book and of the C header have
//! its `exceptions`.

use serde_json::Value;
use spdx::{Expression, LicenseReq, Licensee, ParseMode};
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;
use system_tests::workspace;

/// What the image is linked of.
const FLIGHT: [&str; 7] =
    ["fsw-hal", "fsw-drivers", "fsw-core", "fsw-ground", "fsw-orbit", "fsw-pixels", "fsw-c"];
/// What `cargo install` builds.
const INSTALLED: [&str; 2] = ["catalog-gen", "sil-host"];

/// The licences that may be taken.
struct Rules {
    allow: Vec<Licensee>,
    exceptions: BTreeMap<String, Vec<Licensee>>,
}

fn words(value: &toml::Value) -> Vec<String> {
    let words = value.as_array().expect("a list").iter();
    words.map(|word| word.as_str().expect("words").to_owned()).collect()
}

fn licences(value: &toml::Value) -> Vec<Licensee> {
    words(value).iter().map(|name| Licensee::parse(name).expect("a licence of SPDX's list")).collect()
}

impl Rules {
    fn load() -> Self {
        let text = std::fs::read_to_string(workspace().join(".ci/deny.toml")).expect("the rules");
        let rules: toml::Value = toml::from_str(&text).expect("TOML");
        let exceptions = rules["licenses"]["exceptions"].as_array().expect("a list").iter();
        let named = |rule: &toml::Value| rule["crate"].as_str().expect("a name").to_owned();
        Self {
            allow: licences(&rules["licenses"]["allow"]),
            exceptions: exceptions.map(|rule| (named(rule), licences(&rule["allow"]))).collect(),
        }
    }

    /// Whether a licence can be taken by the list alone, or with the package's exception.
    fn permit(&self, expression: &str, excepted: Option<&str>) -> bool {
        let more = excepted.and_then(|name| self.exceptions.get(name)).map_or(&[][..], Vec::as_slice);
        // Old packages separate alternatives by a slash.
        let expression = Expression::parse_mode(expression, ParseMode::LAX);
        expression.is_ok_and(|expression| {
            let taken = |wanted: &LicenseReq| self.allow.iter().chain(more).any(|one| one.satisfies(wanted));
            expression.evaluate(taken)
        })
    }
}

fn cargo(arguments: &[&str]) -> String {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo).args(arguments).arg("--locked").current_dir(workspace()).output();
    let output = output.expect("cargo starts");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// Packages that some of this workspace are built of, name, version and licence, on one target or all.
fn built_of(packages: &[&str], edges: &str, target: &str) -> BTreeSet<[String; 3]> {
    let mut arguments = vec!["tree", "--prefix", "none", "--no-dedupe", "--format", "{p}|{l}"];
    arguments.extend(["--edges", edges, "--target", target]);
    arguments.extend(packages.iter().flat_map(|name| ["--package", name]));
    let lines = cargo(&arguments);
    let package = |line: &str| {
        let (package, licence) = line.split_once('|')?;
        let mut words = package.split_whitespace();
        Some([words.next()?.to_owned(), words.next()?.to_owned(), licence.to_owned()])
    };
    lines.lines().filter(|line| !line.is_empty()).map(|line| package(line).expect(line)).collect()
}

#[test]
fn every_package_is_of_crates_io_or_ours_and_under_an_allowed_licence() {
    let rules = Rules::load();
    let metadata = cargo(&["metadata", "--format-version", "1"]);
    let metadata: Value = serde_json::from_str(&metadata).expect("JSON");
    let packages = metadata["packages"].as_array().expect("a list");
    let mut excepted = BTreeSet::new();
    for package in packages {
        let [name, licence] = ["name", "license"].map(|key| package[key].as_str().unwrap_or_default());
        assert!(rules.permit(licence, Some(name)), "{name}: {licence:?} is not allowed");
        if !rules.permit(licence, None) {
            excepted.insert(name.to_owned());
        }
        let source = package["source"].as_str();
        assert!(
            source.is_none_or(|source| source.ends_with("/crates.io-index")),
            "{name} comes from {source:?}"
        );
    }
    let listed: BTreeSet<String> = rules.exceptions.into_keys().collect();
    assert_eq!(excepted, listed, "exceptions that are needed, and those that are listed");
    println!("{} packages, {} of them tools with an exception", packages.len(), excepted.len());
}

#[test]
fn what_flies_and_what_is_installed_needs_no_exception() {
    let rules = Rules::load();
    for packages in [&FLIGHT[..], &INSTALLED] {
        let built_of = built_of(packages, "normal", "all");
        for [name, version, licence] in &built_of {
            assert!(rules.permit(licence, None), "{name} {version}: {licence:?} is not allowed");
        }
        println!("{} of {packages:?}", built_of.len());
    }
}

#[test]
fn nothing_flies_in_two_versions() {
    let mut versions: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for [name, version, _] in built_of(&FLIGHT, "normal,no-proc-macro", "thumbv7em-none-eabihf") {
        versions.entry(name).or_default().push(version);
    }
    let twice: Vec<_> = versions.iter().filter(|(_, versions)| versions.len() > 1).collect();
    assert!(twice.is_empty(), "{twice:?}");
    println!("{} packages fly", versions.len());
}

#[test]
fn a_licence_that_reaches_further_is_refused() {
    let rules = Rules::load();
    for refused in ["GPL-3.0-only", "MIT AND LGPL-2.1-or-later", "", "MPL-2.0", "none of the list"] {
        assert!(!rules.permit(refused, Some("fsw-core")), "{refused}");
    }
    for allowed in ["MIT OR GPL-3.0-only", "MIT/Apache-2.0", "(MIT OR Apache-2.0) AND Unicode-3.0"] {
        assert!(rules.permit(allowed, None), "{allowed}");
    }
    assert!(rules.permit("MPL-2.0", Some("cbindgen")) && !rules.permit("GPL-2.0", Some("cbindgen")));
}

/// The crates that are published: those that do not say otherwise.
fn published() -> Vec<Value> {
    let metadata = cargo(&["metadata", "--format-version", "1", "--no-deps"]);
    let metadata: Value = serde_json::from_str(&metadata).expect("JSON");
    let packages = metadata["packages"].as_array().expect("a list").iter();
    packages.filter(|package| package["publish"].is_null()).cloned().collect()
}

#[test]
fn what_is_published_holds_both_licences_and_the_readme_and_says_what_it_is() {
    let published = published();
    let names: Vec<&str> =
        published.iter().map(|package| package["name"].as_str().expect("a name")).collect();
    assert_eq!(names.len(), 8, "{names:?}");
    for (name, package) in names.iter().zip(&published) {
        let listed = cargo(&["package", "--package", name, "--list", "--allow-dirty", "--offline"]);
        let files: BTreeSet<&str> = listed.lines().collect();
        let folder =
            std::path::Path::new(package["manifest_path"].as_str().expect("a path")).with_file_name("");
        for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
            assert!(files.contains(licence), "{name} goes without {licence}");
            // A link: one text for all.
            let text = |path: std::path::PathBuf| std::fs::read_to_string(path).expect("a text");
            assert_eq!(text(folder.join(licence)), text(workspace().join(licence)), "{name}");
        }
        assert!(files.contains("README.md"), "{name} goes without README.md");
        for key in ["description", "license", "rust_version"] {
            assert!(package[key].as_str().is_some_and(|words| !words.is_empty()), "{name}: {key}");
        }
        for key in ["keywords", "categories"] {
            assert!(package[key].as_array().is_some_and(|words| !words.is_empty()), "{name}: {key}");
        }
    }
}

/// The gate packs what is published; `tests/run long` builds it of its packages alone.
#[test]
fn what_is_published_is_what_the_gate_packs() {
    let script = std::fs::read_to_string(workspace().join("tests/run")).expect("the gate");
    let line = script.lines().find(|line| line.starts_with("published=(")).expect("a list");
    let words = line.trim_start_matches("published=(").trim_end_matches(')').split_whitespace();
    let packed: BTreeSet<String> = words.filter(|word| *word != "-p").map(str::to_owned).collect();
    let published =
        published().iter().map(|package| package["name"].as_str().expect("a name").to_owned()).collect();
    assert_eq!(packed, published);
}
