//! The module's tests in Python, with the library that cargo built for this one: `pip install` has maturin
//! build it once more, in `tests/run long`.

use std::process::Command;
use system_tests::python;

#[test]
fn the_tests_in_python_pass() {
    let Some(python) = python() else { return };
    let test = std::env::current_exe().expect("a running test has a path");
    let built = test.with_file_name(format!(
        "{}sextant_python{}",
        std::env::consts::DLL_PREFIX,
        std::env::consts::DLL_SUFFIX
    ));
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("python");
    std::fs::create_dir_all(&folder).expect("a folder");
    // Python's own suffix, on every system but Windows.
    std::fs::copy(&built, folder.join("sextant.abi3.so")).expect("the library");
    let tests = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let status = Command::new(python)
        .args(["-m", "unittest", "discover", "-s"])
        .arg(tests)
        .env("PYTHONPATH", folder)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .status();
    assert!(status.expect("Python starts").success());
}
