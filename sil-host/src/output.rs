//! Files that are whole or marked as partial, folders that one run has to itself, and a standard output whose
//! loss is told.
//!
//! A file under way has [`PARTIAL`] behind its name until it is whole; then it takes the place of an older
//! one in one step. A run that is stopped leaves its partial files, which can be read up to their last whole
//! line or frame, and nothing of an older run beside them.

use crate::error::HostError;
use std::ffi::OsString;
use std::fmt::Arguments;
use std::fs::{File, TryLockError};
use std::io::{ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// What a file's name ends with until the file is whole.
pub const PARTIAL: &str = ".partial";
/// File by which a folder is kept for one run; it goes with the run, and a dead run holds none.
const LOCK: &str = ".lock";

/// Why standard output was lost, the first time.
static STDOUT_LOST: OnceLock<String> = OnceLock::new();

/// A line on standard output.
pub fn say(words: Arguments<'_>) {
    print(words, "\n");
}

/// Text on standard output. A reader that closed the pipe has what it wanted; any other failure is told at
/// the end of the program ([`lost`]).
pub fn print(words: Arguments<'_>, end: &str) {
    let mut stdout = std::io::stdout().lock();
    let written = stdout.write_fmt(words).and_then(|()| stdout.write_all(end.as_bytes()));
    if let Err(error) = written.and_then(|()| stdout.flush())
        && error.kind() != ErrorKind::BrokenPipe
    {
        STDOUT_LOST.get_or_init(|| error.to_string());
    }
}

/// The fault of the standard output, if some of it was lost.
///
/// # Errors
/// When it was.
pub fn lost() -> Result<(), HostError> {
    STDOUT_LOST.get().map_or(Ok(()), |why| {
        Err(HostError::usage(format!("standard output cannot be written: {why}"), "give it another place"))
    })
}

fn refused(path: &Path, error: &std::io::Error) -> HostError {
    HostError::system(
        path,
        "written",
        error,
        "check the folder and the space left, or give another place by --out",
    )
}

/// A file under way.
#[derive(Debug)]
pub struct PartialFile {
    path: PathBuf,
    partial: PathBuf,
    file: File,
    length: u64,
}

impl PartialFile {
    /// Begins the file that is to be `path`.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn create(path: &Path) -> Result<Self, HostError> {
        let partial = partial_name(path);
        let file = File::create(&partial).map_err(|error| refused(path, &error))?;
        Ok(Self { path: path.to_path_buf(), partial, file, length: 0 })
    }

    /// Hands bytes to the system.
    ///
    /// # Errors
    /// When it refuses.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), HostError> {
        self.file.write_all(bytes).map_err(|error| refused(&self.path, &error))?;
        self.length += bytes.len() as u64;
        Ok(())
    }

    /// Bytes handed over so far.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Replaces bytes that were handed over before, from `place` on.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn overwrite(&mut self, place: u64, bytes: &[u8]) -> Result<(), HostError> {
        let replaced = self.file.seek(SeekFrom::Start(place)).and_then(|_| self.file.write_all(bytes));
        let back = replaced.and_then(|()| self.file.seek(SeekFrom::End(0)));
        back.map(|_| ()).map_err(|error| refused(&self.path, &error))
    }

    /// Gives the file its name: it is whole.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn finish(self) -> Result<(), HostError> {
        let named = self.file.sync_all().and_then(|()| std::fs::rename(&self.partial, &self.path));
        named.map_err(|error| refused(&self.path, &error))?;
        Ok(())
    }
}

impl Drop for PartialFile {
    /// Of a file of which nothing could be written nothing is left.
    fn drop(&mut self) {
        if self.length == 0 {
            let _ = std::fs::remove_file(&self.partial);
        }
    }
}

fn partial_name(path: &Path) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(PARTIAL);
    PathBuf::from(name)
}

/// Writes a file: it is there whole, or what stood there before is.
///
/// # Errors
/// When the system refuses.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), HostError> {
    let mut file = PartialFile::create(path)?;
    match file.write(bytes).and_then(|()| file.finish()) {
        Err(error) => {
            let _ = std::fs::remove_file(partial_name(path));
            Err(error)
        }
        written => written,
    }
}

/// A folder that no other run of this program writes into.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    _lock: File,
}

impl Folder {
    /// Makes the folder if there is none, keeps it for this run, and removes `results` that an earlier one
    /// left, whole or partial.
    ///
    /// # Errors
    /// When another run has it or the system refuses.
    pub fn claim(path: &Path, results: &[&str]) -> Result<Self, HostError> {
        let made =
            |error: std::io::Error| HostError::system(path, "made", &error, "give another folder by --out");
        std::fs::create_dir_all(path).map_err(made)?;
        let file = path.join(LOCK);
        let lock =
            File::options().create(true).append(true).open(&file).map_err(|error| refused(&file, &error))?;
        held(path, &lock, "folder")?;
        for result in results {
            let whole = path.join(result);
            for old in [partial_name(&whole), whole] {
                match std::fs::remove_file(&old) {
                    Err(error) if error.kind() != ErrorKind::NotFound => return Err(refused(&old, &error)),
                    _ => {}
                }
            }
        }
        Ok(Self { path: path.to_path_buf(), _lock: lock })
    }

    /// A file in it.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(self.path.join(LOCK));
    }
}

/// Keeps an open file for this run; `what` lies at `path`.
///
/// # Errors
/// When another run has it or the system refuses.
pub fn held(path: &Path, file: &File, what: &str) -> Result<(), HostError> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => {
            let why = format!("another run is writing into this {what}");
            Err(HostError::input(path, None, why, "wait for its end or give another one by --out"))
        }
        Err(TryLockError::Error(error)) => Err(refused(path, &error)),
    }
}

#[cfg(test)]
mod tests;
