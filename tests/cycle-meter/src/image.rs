//! The flight image as the meter needs it: instructions by address, and the marks.
//!
//! In: the bytes of the ELF file, and the names of functions to be counted. Out: halfwords of its loaded
//! segments, the address ranges of the marks, and where those functions begin.
//! Instructions are read here and not from the emulator, which gives a wrong length for one that straddles a
//! page.

use crate::decode::Instruction;
use object::{Object, ObjectSegment, ObjectSymbol};
use std::ops::Range;

/// What a marked function announces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A cycle begins.
    CycleBegin,
    /// A cycle ends.
    CycleEnd,
    /// A stage begins.
    StageBegin,
    /// A stage ends.
    StageEnd,
    /// Work that is not the processor's begins.
    PauseBegin,
    /// It ends.
    PauseEnd,
}

/// The marks and the names of their functions.
const MARKS: [(Mark, &str); 6] = [
    (Mark::CycleBegin, "cycle_begin"),
    (Mark::CycleEnd, "cycle_end"),
    (Mark::StageBegin, "stage_begin"),
    (Mark::StageEnd, "stage_end"),
    (Mark::PauseBegin, "pause_begin"),
    (Mark::PauseEnd, "pause_end"),
];
/// The table whose entry number s is read by the marks of stage s.
const STAGE_TABLE: &str = "STAGE_MARKS";

/// The image.
#[derive(Debug)]
pub struct Image {
    segments: Vec<(u64, Vec<u8>)>,
    marks: Vec<(Mark, Range<u64>)>,
    stage_table: Range<u64>,
    /// Address of each copy of a counted function, and the function's number.
    counted: Vec<(u64, usize)>,
}

/// Whether a symbol is that of a function, `name` being the last parts of its path: each part stands behind
/// its length, and what may follow is the hash.
fn is_named(symbol: &str, name: &str) -> bool {
    let parts = name.split("::").map(|part| part.replace("{{", "_$u7b$$u7b$").replace("}}", "$u7d$$u7d$"));
    let path: String = parts.map(|part| format!("{}{part}", part.len())).collect();
    symbol.split_once(&path).is_some_and(|(_, rest)| rest == "E" || rest.starts_with("17h"))
}

/// Where every copy of the functions of these names begins, with the number of its name.
fn begins(file: &object::File, names: &[String]) -> Result<Vec<(u64, usize)>, String> {
    let mut begins = Vec::new();
    for (number, name) in names.iter().enumerate() {
        let named = |symbol: &object::Symbol| symbol.name().is_ok_and(|symbol| is_named(symbol, name));
        let copies = file.symbols().filter(|symbol| symbol.is_definition() && named(symbol));
        begins.extend(copies.map(|symbol| (symbol.address() & !1, number)));
        if begins.last().is_none_or(|(_, last)| *last != number) {
            return Err(format!("no function `{name}`"));
        }
    }
    Ok(begins)
}

impl Image {
    /// Reads an ELF file, in which the functions `counted` are to be found.
    ///
    /// # Errors
    /// One line that says what is wrong: no ELF file, a cycle's mark is missing, or a function to be counted.
    /// The other marks may be missing.
    pub fn parse(bytes: &[u8], counted: &[String]) -> Result<Self, String> {
        let file = object::File::parse(bytes).map_err(|error| error.to_string())?;
        let mut segments = Vec::new();
        for segment in file.segments() {
            segments.push((segment.address(), segment.data().map_err(|error| error.to_string())?.to_vec()));
        }
        let range_of = |name: &str| {
            let symbol = file.symbols().find(|symbol| symbol.name() == Ok(name) && symbol.is_definition());
            // Bit 0 of a function's address says Thumb.
            symbol
                .map(|symbol| (symbol.address() & !1, symbol.size().max(2)))
                .map(|(from, size)| from..from + size)
        };
        let marks: Vec<_> =
            MARKS.into_iter().filter_map(|(mark, name)| range_of(name).map(|range| (mark, range))).collect();
        for (needed, name) in &MARKS[..2] {
            if !marks.iter().any(|(mark, _)| mark == needed) {
                return Err(format!("no function `{name}`"));
            }
        }
        let table = file.symbols().find(|symbol| symbol.name() == Ok(STAGE_TABLE));
        let stage_table = table.map_or(0..0, |symbol| symbol.address()..symbol.address() + symbol.size());
        Ok(Self { segments, marks, stage_table, counted: begins(&file, counted)? })
    }

    /// The number of the counted function that begins at `address`.
    pub fn counted(&self, address: u64) -> Option<usize> {
        self.counted.iter().find(|(begin, _)| *begin == address).map(|(_, number)| *number)
    }

    /// The instruction at `address`; `None` outside the loaded segments.
    pub fn instruction(&self, address: u64) -> Option<Instruction> {
        let first = self.halfword(address)?;
        Some(Instruction::new(first, self.halfword(address + 2).unwrap_or(0)))
    }

    /// The mark whose function `address` lies in, and whether it is the function's entry.
    pub fn mark(&self, address: u64) -> Option<(Mark, bool)> {
        let found = self.marks.iter().find(|(_, range)| range.contains(&address));
        found.map(|(mark, range)| (*mark, range.start == address))
    }

    /// The stage whose table entry `address` is.
    pub fn stage(&self, address: u64) -> Option<u64> {
        self.stage_table.contains(&address).then(|| address - self.stage_table.start)
    }

    /// The little-endian halfword at `address`.
    fn halfword(&self, address: u64) -> Option<u16> {
        self.segments.iter().find_map(|(start, bytes)| {
            let offset = usize::try_from(address.checked_sub(*start)?).ok()?;
            bytes.get(offset..)?.first_chunk::<2>().map(|pair| u16::from_le_bytes(*pair))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_function_is_known_by_the_last_parts_of_its_path() {
        const HASH: &str = "17h0123456789abcdefE";
        let named = |path: &str, name: &str| is_named(&format!("_ZN{path}{HASH}"), name);
        let path = "8fsw_core5earth9consensus10inliers_of";
        assert!(named(path, "consensus::inliers_of") && named(path, "inliers_of"));
        assert!(!named(path, "arcs::inliers_of") && !named(path, "consensus") && !named(path, "of"));
        assert!(is_named("_ZN4room8functionE", "room::function"));
        assert!(named("4rays3Ray3new28_$u7b$$u7b$closure$u7d$$u7d$", "Ray::new::{{closure}}"));
        assert!(!named("4rays3Ray3new28_$u7b$$u7b$closure$u7d$$u7d$", "Ray::new"));
    }
}
