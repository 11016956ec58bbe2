//! The deepest path through the calls.

use crate::image::{Function, Functions};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// How LLVM names a sequence of code that it has moved out of several functions.
const MOVED_OUT: &str = "OUTLINED_FUNCTION_";

/// A function on the deepest path.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Step {
    /// Its symbol.
    pub function: String,
    /// Its frame.
    pub frame_bytes: u32,
}

/// What the image needs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Depth {
    /// Deepest stack, bytes.
    pub stack_bytes: u32,
    /// The path to it, from the reset vector down.
    pub path: Vec<Step>,
    /// Functions that can be reached.
    pub functions: usize,
    /// Those with calls whose target the code does not name; such a call in a sequence of code that the
    /// compiler has moved out of several functions is theirs.
    pub unknown_calls: Vec<String>,
    /// Those with frames of a length that is computed.
    pub unknown_frames: Vec<String>,
    /// Those that call themselves, by themselves or through others.
    pub recursion: Vec<String>,
    /// Calls to what is no function of the image.
    pub unknown_targets: Vec<String>,
    /// Jumps through a register, taken to stay in their function.
    pub computed_jumps: u32,
}

impl Depth {
    /// Whether the figure is a bound.
    pub fn is_sound(&self) -> bool {
        [&self.unknown_calls, &self.unknown_frames, &self.recursion, &self.unknown_targets]
            .iter()
            .all(|faults| faults.is_empty())
    }
}

/// Bytes below a function's caller, and which call leads there.
#[derive(Clone, Copy, Debug)]
struct Below {
    bytes: u32,
    next: Option<u64>,
}

/// Walks the calls from the entry on, depth first.
pub fn deepest(functions: &Functions) -> Depth {
    let mut depth = Depth::default();
    let mut done: BTreeMap<u64, Below> = BTreeMap::new();
    // Functions whose calls are being followed: a call to one of them is recursion.
    let mut open: BTreeSet<u64> = BTreeSet::new();
    // Sequences moved out of functions, with unknown calls.
    let mut shared: BTreeSet<u64> = BTreeSet::new();
    // What is left to do: a function, and whether its callees are done.
    let mut work = vec![(functions.entry, false)];
    while let Some((address, callees_done)) = work.pop() {
        let Some(function) = functions.of.get(&address) else { continue };
        if callees_done {
            open.remove(&address);
            done.insert(address, below(function, &done));
            note(&mut depth, function);
            if function.unknown_calls > 0 || !function.calls.is_disjoint(&shared) {
                match function.name.starts_with(MOVED_OUT) {
                    true => drop(shared.insert(address)),
                    false => depth.unknown_calls.push(function.name.clone()),
                }
            }
            continue;
        }
        if done.contains_key(&address) {
            continue;
        }
        open.insert(address);
        work.push((address, true));
        for call in &function.calls {
            match functions.of.get(call) {
                None => depth.unknown_targets.push(format!("{} -> {call:#x}", function.name)),
                Some(callee) if open.contains(call) => depth.recursion.push(callee.name.clone()),
                Some(_) => work.push((*call, false)),
            }
        }
    }
    depth.functions = done.len();
    depth.stack_bytes = done.get(&functions.entry).map_or(0, |below| below.bytes);
    let mut next = Some(functions.entry);
    while let Some((function, below)) = next.and_then(|at| Some((functions.of.get(&at)?, done.get(&at)?))) {
        depth.path.push(Step { function: function.name.clone(), frame_bytes: function.frame_bytes });
        next = below.next;
    }
    depth
}

fn below(function: &Function, done: &BTreeMap<u64, Below>) -> Below {
    let deepest = function.calls.iter().filter_map(|call| Some((done.get(call)?.bytes, *call))).max();
    let (bytes, next) = deepest.map_or((0, None), |(bytes, call)| (bytes, Some(call)));
    Below { bytes: bytes + function.frame_bytes, next }
}

fn note(depth: &mut Depth, function: &Function) {
    if function.unknown_frames > 0 {
        depth.unknown_frames.push(function.name.clone());
    }
    depth.computed_jumps += function.computed_jumps;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Functions as (address, frame, calls); the first is the entry.
    fn image(of: &[(u64, u32, &[u64])]) -> Functions {
        let function = |(address, frame_bytes, calls): &(u64, u32, &[u64])| {
            let name = format!("f{address}");
            let calls = calls.iter().copied().collect();
            (*address, Function { name, frame_bytes: *frame_bytes, calls, ..Function::default() })
        };
        Functions { entry: of[0].0, of: of.iter().map(function).collect() }
    }

    #[test]
    fn the_deepest_path_counts_and_not_the_longest() {
        let depth =
            deepest(&image(&[(1, 8, &[2, 4]), (2, 8, &[3]), (3, 8, &[]), (4, 100, &[3]), (5, 999, &[])]));
        assert!(depth.is_sound(), "{depth:?}");
        assert_eq!((depth.stack_bytes, depth.functions), (116, 4));
        let path: Vec<&str> = depth.path.iter().map(|step| step.function.as_str()).collect();
        assert_eq!(path, ["f1", "f4", "f3"]);
    }

    #[test]
    fn a_function_called_on_two_floors_counts_where_it_is_deepest() {
        // 3 is a callee of 1 and of 2, which is a callee of 1 as well.
        let depth = deepest(&image(&[(1, 4, &[2, 3]), (2, 50, &[3]), (3, 10, &[])]));
        assert_eq!((depth.stack_bytes, depth.is_sound()), (64, true));
    }

    #[test]
    fn recursion_is_told_whether_straight_or_through_others() {
        assert_eq!(deepest(&image(&[(1, 4, &[1])])).recursion, ["f1"]);
        assert_eq!(deepest(&image(&[(1, 4, &[2]), (2, 4, &[3]), (3, 4, &[2])])).recursion, ["f2"]);
    }

    #[test]
    fn a_call_that_nobody_knows_is_told() {
        let mut functions = image(&[(1, 4, &[7])]);
        assert_eq!(deepest(&functions).unknown_targets, ["f1 -> 0x7"]);
        functions.of.get_mut(&1).unwrap().unknown_calls = 1;
        let depth = deepest(&functions);
        assert!(!depth.is_sound() && depth.unknown_calls == ["f1"]);
    }

    #[test]
    fn an_unknown_call_in_a_sequence_moved_out_is_that_of_its_callers() {
        let mut functions =
            image(&[(1, 4, &[2, 3, 5]), (2, 4, &[4]), (3, 4, &[4]), (4, 0, &[6]), (5, 4, &[]), (6, 0, &[])]);
        for address in [4, 6] {
            functions.of.get_mut(&address).unwrap().name = format!("{MOVED_OUT}{address}");
        }
        functions.of.get_mut(&6).unwrap().unknown_calls = 1;
        let mut unknown = deepest(&functions).unknown_calls;
        unknown.sort_unstable();
        assert_eq!(unknown, ["f2", "f3"]);
    }
}
