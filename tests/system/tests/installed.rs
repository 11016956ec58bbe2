//! The program under the name that `cargo install` gives it.

use std::path::PathBuf;
use std::process::{Command, Output};
use system_tests::{scratch, sil_host};

/// `cargo build -p sil-host` builds both.
fn sextant() -> PathBuf {
    sil_host().with_file_name(format!("sextant{}", std::env::consts::EXE_SUFFIX))
}

/// Calls it as from a shell, not under cargo.
fn call(arguments: &[&str]) -> Output {
    Command::new(sextant()).args(arguments).env_remove("CARGO").output().expect("the program starts")
}

#[test]
fn it_calls_itself_by_that_name() {
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    assert_eq!(text(call(&["--version"]).stdout), format!("sextant {}\n", env!("CARGO_PKG_VERSION")));
    let help = text(call(&["run", "--help"]).stdout);
    assert!(help.contains("Usage: sextant run ") && !help.contains("sil-host"), "{help}");
    let refused = text(call(&["solve", "no-such.png", "--fov-deg", "15"]).stderr);
    assert!(refused.starts_with("sextant: no-such.png: "), "{refused}");
    let refused = text(call(&["solve"]).stderr);
    assert!(
        refused.starts_with("sextant: ") && refused.ends_with("see `sextant solve --help`\n"),
        "{refused}"
    );
}

#[test]
fn bash_completes_its_commands_and_options() {
    let script = r#"
        eval "$("$0" completions bash)"
        complete -p sextant >/dev/null
        complete_after() {
            COMP_WORDS=(sextant "$@") COMP_CWORD=$# COMPREPLY=()
            _sextant sextant "${!#}" sextant
            echo "${COMPREPLY[@]}"
        }
        complete_after prop
        complete_after campaign acq
        complete_after propagate --dur
    "#;
    let output = Command::new("bash").args(["-euc", script]).arg(sextant()).output().expect("bash");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(text(&output.stdout), "propagate\nacquire\n--duration-s\n");
}

#[test]
fn its_manual_pages_are_ones_that_groff_reads() {
    let folder = scratch("man");
    assert!(call(&["man", folder.to_str().expect("a path")]).status.success());
    let pages: Vec<PathBuf> =
        std::fs::read_dir(&folder).expect("pages").map(|page| page.expect("an entry").path()).collect();
    assert!(pages.len() > 20, "{}", pages.len());
    for page in pages {
        let groff = Command::new("groff").args(["-man", "-Tutf8", "-ww"]).arg(&page).output();
        let Ok(output) = groff else { return println!("skipped: groff is not installed") };
        let warnings = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && warnings.is_empty(), "{}: {warnings}", page.display());
        assert!(!output.stdout.is_empty(), "{}", page.display());
    }
}
