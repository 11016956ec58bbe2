//! The functions of an ELF image: their frames and whom they call.
//!
//! Data among the code (literals) is left out by the mapping symbols `$t` (Thumb) and `$d` (data) that the
//! compiler leaves (ELF for the Arm Architecture, 5.5.5).

use crate::decode::{Effect, effect, length};
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};
use std::collections::{BTreeMap, BTreeSet};

/// A function.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Function {
    /// Its name, demangled by nobody.
    pub name: String,
    /// Bytes by which it lowers the stack pointer.
    pub frame_bytes: u32,
    /// Addresses of the functions that it calls or jumps to.
    pub calls: BTreeSet<u64>,
    /// Calls whose target the code does not name.
    pub unknown_calls: u32,
    /// Frames of a length that is computed.
    pub unknown_frames: u32,
    /// Jumps within it through a register.
    pub computed_jumps: u32,
}

/// Functions by address; the first one is where the processor begins.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Functions {
    /// Where the processor begins.
    pub entry: u64,
    /// All of them.
    pub of: BTreeMap<u64, Function>,
}

/// Reads an ELF file.
///
/// # Errors
/// What is wrong with it.
pub fn functions(bytes: &[u8]) -> Result<Functions, String> {
    let file = object::File::parse(bytes).map_err(|error| error.to_string())?;
    // Bit 0 of a function's address says Thumb.
    let mut ranges = BTreeMap::new();
    let mut data: BTreeMap<u64, bool> = BTreeMap::new();
    let code: Vec<_> = file.sections().filter(|section| section.kind() == SectionKind::Text).collect();
    let is_code = |index| code.iter().any(|section| Some(section.index()) == index);
    // Other sections' mapping symbols count from 0 as well.
    for symbol in file.symbols().filter(|symbol| is_code(symbol.section_index())) {
        let name = symbol.name().unwrap_or_default();
        if name.starts_with("$d") || name.starts_with("$t") {
            data.insert(symbol.address() & !1, name.starts_with("$d"));
        } else if symbol.kind() == SymbolKind::Text && symbol.size() > 0 {
            ranges.insert(symbol.address() & !1, (symbol.size(), name.to_owned()));
        }
    }
    if data.is_empty() {
        return Err("no mapping symbols, code and data cannot be told apart".into());
    }
    let entry = file.entry() & !1;
    if !ranges.contains_key(&entry) {
        return Err("its entry is no function".into());
    }
    let mut of = BTreeMap::new();
    for section in code {
        let code = section.data().map_err(|error| error.to_string())?;
        let from = section.address();
        for (address, (size, name)) in ranges.range(from..from + code.len() as u64) {
            let is_data = |at: u64| data.range(..=at).next_back().is_some_and(|(_, is_data)| *is_data);
            let halfword = |at: u64| {
                let offset = usize::try_from(at - from).ok()?;
                code.get(offset..)?.first_chunk::<2>().map(|pair| u16::from_le_bytes(*pair))
            };
            of.insert(*address, function(name, *address..*address + *size, is_data, halfword));
        }
    }
    Ok(Functions { entry, of })
}

/// Walks through a function's code.
fn function(
    name: &str,
    range: std::ops::Range<u64>,
    is_data: impl Fn(u64) -> bool,
    halfword: impl Fn(u64) -> Option<u16>,
) -> Function {
    let mut function = Function { name: name.to_owned(), ..Function::default() };
    let mut at = range.start;
    while let Some(first) = halfword(at).filter(|_| range.contains(&at)) {
        if is_data(at) {
            at += 2;
            continue;
        }
        match effect(at, first, halfword(at + 2).unwrap_or(0)) {
            Effect::None => {}
            Effect::Lowers(bytes) => function.frame_bytes += bytes,
            Effect::LowersUnknown => function.unknown_frames += 1,
            Effect::ToUnknown => function.unknown_calls += 1,
            Effect::ComputedJump => function.computed_jumps += 1,
            // A jump to its own beginning would be told as recursion, to be safe.
            Effect::To(target) if range.contains(&target) && target != range.start => {}
            Effect::To(target) => {
                function.calls.insert(target);
            }
        }
        at += length(first);
    }
    function
}
