//! The committed header is what cbindgen makes of the sources.

use std::path::Path;

/// Sources with something for C in them, in the order of the header.
const SOURCES: [&str; 9] =
    ["status", "doors", "instruments", "results", "memory", "calls", "areas", "link", "resuming"];

/// The header of the sources, without the sections that only Rust reads.
fn header() -> String {
    let crate_folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(crate_folder.join("cbindgen.toml")).expect("a configuration");
    let builder = SOURCES.iter().fold(cbindgen::Builder::new().with_config(config), |builder, name| {
        builder.with_src(crate_folder.join(format!("src/{name}.rs")))
    });
    let mut text = Vec::new();
    builder.generate().expect("the sources can be read").write(&mut text);
    let text = String::from_utf8(text).expect("UTF-8");
    let (mut kept, mut rust_only) = (Vec::new(), false);
    for line in text.lines().map(str::trim_end) {
        if line == " * # Safety" {
            // With the empty line above it.
            kept.pop();
            rust_only = true;
        } else if line == " */" {
            rust_only = false;
        }
        if !rust_only {
            kept.push(line);
        }
    }
    kept.join("\n") + "\n"
}

#[test]
fn the_committed_header_is_that_of_the_sources() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/sextant.h");
    let made = header();
    if std::env::var_os("SEXTANT_BLESS").is_some() {
        std::fs::write(&path, &made).expect("the header can be written");
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        committed == made,
        "{} is not made of these sources; make it anew: SEXTANT_BLESS=1 cargo test -p fsw-c --test header",
        path.display()
    );
}
