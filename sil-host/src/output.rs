//! Files that are whole or marked as partial, folders that one run has to itself, and a standard output whose
//! loss is told.
//!
//! A file under way has [`PARTIAL`] behind its name until it is whole; then it takes the place of an older
//! one in one step. A run that is stopped leaves its partial files, which can be read up to their last whole
//! line or frame, and nothing of an older run beside them. A symbolic link is followed; a device, a pipe or
//! another special file is written as it goes.

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
pub fn print_line(words: Arguments<'_>) {
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
    HostError::system(path, "written", error, "check the folder and the space left, or name another place")
}

/// A file under way. What is [kept](Self::keep) goes to the system whole, with what follows it or at
/// [`flush`](Self::flush), so that a run that is killed leaves whole pieces.
#[derive(Debug)]
pub struct PartialFile {
    path: PathBuf,
    /// Where it stands until it is whole, and what it is named then; `None`: a special file, written as it
    /// goes.
    renamed: Option<[PathBuf; 2]>,
    file: File,
    kept: Vec<u8>,
    handed_over: u64,
}

impl PartialFile {
    /// Begins the file that is to be `path`.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn create(path: &Path) -> Result<Self, HostError> {
        let renamed = (!is_special(path)).then(|| followed(path)).map(|whole| [partial_name(&whole), whole]);
        let file = match &renamed {
            Some([partial, _]) => File::create(partial),
            None => File::options().write(true).open(path),
        };
        let file = file.map_err(|error| refused(path, &error))?;
        Ok(Self { path: path.to_path_buf(), renamed, file, kept: Vec::new(), handed_over: 0 })
    }

    /// Keeps a piece back until it is flushed.
    pub fn keep(&mut self, piece: &[u8]) {
        self.kept.extend_from_slice(piece);
    }

    /// Hands what is kept to the system.
    ///
    /// # Errors
    /// When it refuses.
    pub fn flush(&mut self) -> Result<(), HostError> {
        self.file.write_all(&self.kept).map_err(|error| refused(&self.path, &error))?;
        self.handed_over += self.kept.len() as u64;
        self.kept.clear();
        Ok(())
    }

    /// Hands bytes to the system, behind what is kept.
    ///
    /// # Errors
    /// When it refuses.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), HostError> {
        self.keep(bytes);
        self.flush()
    }

    /// Length of the file with what is kept.
    pub fn length(&self) -> u64 {
        self.handed_over + self.kept.len() as u64
    }

    /// Replaces bytes that are in the file or kept, from `place` on.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn overwrite(&mut self, place: u64, bytes: &[u8]) -> Result<(), HostError> {
        self.flush()?;
        let replaced = self.file.seek(SeekFrom::Start(place)).and_then(|_| self.file.write_all(bytes));
        let back = replaced.and_then(|()| self.file.seek(SeekFrom::End(0)));
        back.map(|_| ()).map_err(|error| refused(&self.path, &error))
    }

    /// Hands over what is kept and gives the file its name: it is whole.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn finish(mut self) -> Result<(), HostError> {
        self.flush()?;
        let Some([partial, whole]) = &self.renamed else { return Ok(()) };
        let named = self.file.sync_all().and_then(|()| std::fs::rename(partial, whole));
        named.map_err(|error| refused(&self.path, &error))
    }
}

impl Drop for PartialFile {
    /// Of a file of which nothing could be written nothing is left.
    fn drop(&mut self) {
        if let Some([partial, _]) = self.renamed.as_ref().filter(|_| self.handed_over == 0) {
            let _ = std::fs::remove_file(partial);
        }
    }
}

/// Whether a device, a pipe or a socket stands at a path.
fn is_special(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

/// The file that a path means: of a symbolic link where it leads to, also where nothing is there yet.
fn followed(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| match std::fs::read_link(path) {
        Ok(link) => path.parent().unwrap_or(Path::new("")).join(link),
        Err(_) => path.to_path_buf(),
    })
}

fn partial_name(path: &Path) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(PARTIAL);
    PathBuf::from(name)
}

/// Whether a file can be written at a path, before there is something to write. A special file is not opened:
/// the reader of a pipe would see its end.
///
/// # Errors
/// When the system refuses.
pub fn check(path: &Path) -> Result<(), HostError> {
    if is_special(path) { Ok(()) } else { PartialFile::create(path).map(|_| ()) }
}

/// Writes a file: it is there whole, or what stood there before is.
///
/// # Errors
/// When the system refuses.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), HostError> {
    let mut file = PartialFile::create(path)?;
    let partial = file.renamed.as_ref().map(|[partial, _]| partial.clone());
    let written = file.write(bytes).and_then(|()| file.finish());
    if let Some(partial) = partial.filter(|_| written.is_err()) {
        let _ = std::fs::remove_file(partial);
    }
    written
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
