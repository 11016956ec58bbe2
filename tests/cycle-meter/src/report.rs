//! The meter's answer as one line of JSON.
//!
//! ```json
//! {"model":{"core":"cortex-m4f","refill_cycles":2},"start":{"instructions":60,"cycles":90,"waits":9},
//! "cycles":[{"instructions":9,"cycles":14,"waits":3,"stages":{"0":{"calls":1,"instructions":4,"cycles":6,
//! "waits":1}}}],"worst":{"cycle":0,"instructions":9,"cycles":14,"waits":3},
//! "image_instructions":80,"unfinished_cycles":0,"unknown_blocks":0}
//! ```
//!
//! `start` is what ran from reset to the first cycle. `worst` is null when no cycle ended. A report is
//! trustworthy only if the last two are 0. Where functions are counted each stage has their calls as well:
//!
//! ```json
//! "counted":{"room::function":{"calls":2,"instructions":8,"cycles":12,"waits":2,
//! "most":{"instructions":5,"cycles":7,"waits":1}}}
//! ```

use crate::{
    block::Work,
    calls::Calls,
    count::{Counter, Cycle},
};

/// The report of a run in which the functions of these names were counted.
pub fn json(counter: &Counter, counted: &[String]) -> String {
    let cycles = joined(counter.cycles().iter().map(|one| cycle(one, counted)));
    let worst = counter.worst().map_or("null".to_owned(), |index| {
        format!(r#"{{"cycle":{index},{}}}"#, work(counter.cycles()[index].work))
    });
    format!(
        r#"{{"model":{{"core":"cortex-m4f","refill_cycles":{}}},"start":{{{}}},"cycles":[{cycles}],"worst":{worst},"image_instructions":{},"unfinished_cycles":{},"unknown_blocks":{}}}"#,
        counter.refill_cycles(),
        work(counter.start()),
        counter.image_instructions(),
        counter.unfinished(),
        counter.unknown_blocks()
    ) + "\n"
}

fn cycle(cycle: &Cycle, names: &[String]) -> String {
    let stages = joined(cycle.stages.iter().map(|(number, stage)| {
        let counted = counted(cycle, *number, names);
        format!(r#""{number}":{{"calls":{},{}{counted}}}"#, stage.calls, work(stage.work))
    }));
    format!(r#"{{{},"stages":{{{stages}}}}}"#, work(cycle.work))
}

/// The counted functions of a stage; nothing where none are counted.
fn counted(cycle: &Cycle, number: u64, names: &[String]) -> String {
    let calls = names.iter().enumerate().filter_map(|(function, name)| {
        let Calls { calls, work: all, most } = cycle.calls.get(&(number, function))?;
        Some(format!(r#""{name}":{{"calls":{calls},{},"most":{{{}}}}}"#, work(*all), work(*most)))
    });
    if names.is_empty() { String::new() } else { format!(r#","counted":{{{}}}"#, joined(calls)) }
}

fn work(work: Work) -> String {
    format!(r#""instructions":{},"cycles":{},"waits":{}"#, work.instructions, work.cycles, work.waits)
}

fn joined(parts: impl Iterator<Item = String>) -> String {
    parts.collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_without_cycles_has_no_worst() {
        let expected = concat!(
            r#"{"model":{"core":"cortex-m4f","refill_cycles":2},"start":{"instructions":0,"cycles":0,"waits":0},"#,
            r#""cycles":[],"worst":null,"image_instructions":0,"unfinished_cycles":0,"unknown_blocks":0}"#,
            "\n"
        );
        assert_eq!(json(&Counter::new(2), &[]), expected);
    }
}
