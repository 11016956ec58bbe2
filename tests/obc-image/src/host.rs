//! What the emulator's host lends the image: files, standard output, the command line and the way out.
//!
//! In: file names and the command line `IMAGE ARGUMENT...`, words separated by spaces (a name cannot hold
//! one). Out: bytes and an exit status. Everything goes through Arm semihosting calls, one breakpoint
//! instruction each; the time the host spends in them is no time of the target, so a read costs the image its
//! call and nothing else. All `unsafe` of semihosting is in this file.

use cortex_m_semihosting::{nr, syscall};

/// `SYS_EXIT_EXTENDED`: the exit that carries a status (Arm semihosting specification, 0x20).
const EXIT_EXTENDED: usize = 0x20;
/// `ADP_Stopped_ApplicationExit`, the only reason that lets the status through.
const APPLICATION_EXIT: usize = 0x20026;
/// Longest file name, bytes.
const NAME_BYTES: usize = 256;
/// Longest command line, bytes.
pub const COMMAND_LINE_BYTES: usize = 1024;

/// The host did not do what was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostError;

/// How a file is opened; the numbers are the semihosting modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// To read; it must exist.
    Read = nr::open::R_BINARY as isize,
    /// To write from its beginning; what was there is lost.
    Write = nr::open::W_TRUNC_BINARY as isize,
    /// To append; `:tt` opened so is standard error (semihosting extension SH_EXT_STDOUT_STDERR).
    Append = nr::open::W_APPEND_BINARY as isize,
}

/// An open file of the host. Never closed: the host closes all at exit.
#[derive(Debug)]
pub struct File {
    handle: usize,
}

impl File {
    /// Opens `name`; `:tt` for writing is standard output.
    ///
    /// # Errors
    /// [`HostError`] when the name is too long or the host refuses.
    #[inline(never)]
    pub fn open(name: &[u8], mode: Mode) -> Result<Self, HostError> {
        let mut terminated = [0u8; NAME_BYTES];
        // One byte stays zero: the host wants a C string.
        let room = terminated.get_mut(..NAME_BYTES - 1).ok_or(HostError)?;
        room.get_mut(..name.len()).ok_or(HostError)?.copy_from_slice(name);
        let block = [terminated.as_ptr() as usize, mode as usize, name.len()];
        // SAFETY: OPEN takes a C string, a mode and the string's length; `terminated` outlives the call.
        let handle = unsafe { syscall(nr::OPEN, &block) };
        if handle == usize::MAX { Err(HostError) } else { Ok(Self { handle }) }
    }

    /// Moves to `offset` bytes from the beginning.
    ///
    /// # Errors
    /// [`HostError`] when the host refuses.
    pub fn seek(&mut self, offset: usize) -> Result<(), HostError> {
        // SAFETY: SEEK takes a handle and an offset; the handle came from OPEN.
        done(unsafe { syscall(nr::SEEK, &[self.handle, offset]) })
    }

    /// Fills `bytes`; a file that ends before is an error.
    ///
    /// # Errors
    /// [`HostError`] when the file is too short or the host refuses.
    pub fn read(&mut self, bytes: &mut [u8]) -> Result<(), HostError> {
        // SAFETY: READ writes at most `len` bytes to the address; the slice is exclusively ours and that
        // long.
        done(unsafe { syscall(nr::READ, &[self.handle, bytes.as_mut_ptr() as usize, bytes.len()]) })
    }

    /// Fills `bytes` as far as the file reaches and gives the number of bytes.
    ///
    /// # Errors
    /// [`HostError`] when the host refuses.
    pub fn read_some(&mut self, bytes: &mut [u8]) -> Result<usize, HostError> {
        // SAFETY: as in `read`.
        let left = unsafe { syscall(nr::READ, &[self.handle, bytes.as_mut_ptr() as usize, bytes.len()]) };
        bytes.len().checked_sub(left).ok_or(HostError)
    }

    /// Fills `words` with little-endian `u16`; a file that ends before is an error.
    ///
    /// # Errors
    /// As [`File::read`].
    pub fn read_words(&mut self, words: &mut [u16]) -> Result<(), HostError> {
        // SAFETY: a u16 slice is twice as many bytes, initialised and of weaker alignment, and any bytes make
        // valid u16.
        let bytes = unsafe { core::slice::from_raw_parts_mut(words.as_mut_ptr().cast(), size_of_val(words)) };
        self.read(bytes)?;
        words.iter_mut().for_each(|word| *word = u16::from_le(*word));
        Ok(())
    }

    /// Writes all of `bytes`.
    ///
    /// # Errors
    /// [`HostError`] when the host takes less.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), HostError> {
        // SAFETY: WRITE reads `len` bytes at the address; the slice is that long and outlives the call.
        done(unsafe { syscall(nr::WRITE, &[self.handle, bytes.as_ptr() as usize, bytes.len()]) })
    }
}

/// SEEK answers 0 when done, READ and WRITE the number of bytes left over.
fn done(answer: usize) -> Result<(), HostError> {
    if answer == 0 { Ok(()) } else { Err(HostError) }
}

/// The words of the command line after the image's own name.
pub fn arguments(buffer: &mut [u8; COMMAND_LINE_BYTES]) -> impl Iterator<Item = &[u8]> {
    let mut block = [buffer.as_mut_ptr() as usize, COMMAND_LINE_BYTES];
    // SAFETY: GET_CMDLINE writes a C string of at most the given size to the address and its length into the
    // block, which is why the block's address is taken from a mutable place.
    let answer = unsafe { cortex_m_semihosting::syscall1(nr::GET_CMDLINE, block.as_mut_ptr() as usize) };
    let length = if answer == 0 { block[1] } else { 0 };
    let line = buffer.get(..length).unwrap_or(&[]);
    line.split(|byte| *byte == b' ').filter(|word| !word.is_empty()).skip(1)
}

/// Ends the emulation with `status`.
pub fn exit(status: u8) -> ! {
    loop {
        // SAFETY: takes a reason and a status; does not return under an emulator, and if it does it is asked
        // again.
        unsafe { syscall(EXIT_EXTENDED, &[APPLICATION_EXIT, usize::from(status)]) };
    }
}
