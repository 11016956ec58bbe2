//! `completions` and `man`: what a shell and a reader of manual pages want of the installed program.

use crate::cli::{CommandLine, CompletionsArguments, ManArguments};
use crate::error::HostError;
use crate::output;
use crate::words::INSTALLED;
use clap::CommandFactory;
use std::fs;
use std::io;
use std::path::Path;
use std::process::ExitCode;

fn command() -> clap::Command {
    CommandLine::command().name(INSTALLED).bin_name(INSTALLED)
}

/// Prints the completions of a shell.
///
/// # Errors
/// None.
pub fn completions(arguments: &CompletionsArguments) -> Result<ExitCode, HostError> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command(), INSTALLED, &mut script);
    output::print(format_args!("{}", String::from_utf8_lossy(&script)), "");
    Ok(ExitCode::SUCCESS)
}

/// Writes a manual page for the program and one for each of its commands into a folder.
///
/// # Errors
/// Where the folder cannot be written.
pub fn man(arguments: &ManArguments) -> Result<ExitCode, HostError> {
    let ManArguments { folder } = arguments;
    let made = fs::create_dir_all(folder).and_then(|()| clap_mangen::generate_to(command(), folder));
    let written = made.and_then(|()| lines_kept(folder));
    written.map_err(|error| HostError::system(folder, "written", &error, "name another folder"))?;
    Ok(ExitCode::SUCCESS)
}

/// Keeps the lines of the pages' sections EXTRA as they are: files and lines that a command reads, which a
/// formatter would make one paragraph.
fn lines_kept(folder: &Path) -> io::Result<()> {
    const HEADING: &str = ".SH EXTRA\n";
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let of_ours = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(INSTALLED));
        let Ok(page) = fs::read_to_string(&path) else { continue };
        let Some((above, extra)) = page.split_once(HEADING).filter(|_| of_ours) else { continue };
        let (extra, below) = extra.split_at(extra.find(".SH ").unwrap_or(extra.len()));
        fs::write(&path, format!("{above}{HEADING}.nf\n{extra}.fi\n{below}"))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap_complete::Shell;

    #[test]
    fn every_command_has_completions_and_a_page() {
        let names: Vec<_> = command().get_subcommands().map(|of| of.get_name().to_owned()).collect();
        assert!(names.len() > 15);
        for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut command(), INSTALLED, &mut script);
            let script = String::from_utf8(script).unwrap();
            assert!(names.iter().all(|name| script.contains(name.as_str())), "{shell}");
        }
        let folder = std::env::temp_dir().join(format!("sextant-man-{}", std::process::id()));
        man(&ManArguments { folder: folder.clone() }).unwrap();
        for name in &names {
            let page = fs::read_to_string(folder.join(format!("{INSTALLED}-{name}.1"))).unwrap();
            assert!(page.contains(".SH SYNOPSIS"), "{name}");
        }
        assert!(folder.join(format!("{INSTALLED}.1")).exists());
        let solve = fs::read_to_string(folder.join(format!("{INSTALLED}-solve.1"))).unwrap();
        let (_, extra) = solve.split_once(".SH EXTRA\n.nf\n").expect("lines that stay as they are");
        assert!(extra.split(".fi\n").next().unwrap().contains("\n[optics]\n"), "{extra}");
        fs::remove_dir_all(folder).unwrap();
        let file = std::env::current_exe().unwrap();
        assert!(man(&ManArguments { folder: file.join("below-a-file") }).is_err());
    }
}
