//! Hands the repository's `memory.x` to the linker, which looks for it by name (`link.x` includes it).

fn main() {
    let repository = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    println!("cargo:rustc-link-search={repository}");
    println!("cargo:rerun-if-changed={repository}/memory.x");
}
