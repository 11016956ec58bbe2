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
//! trustworthy only if the last two are 0.

use crate::{
    block::Work,
    count::{Counter, Cycle},
};

/// The report of a run.
pub fn json(counter: &Counter) -> String {
    let cycles = joined(counter.cycles().iter().map(cycle));
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

fn cycle(cycle: &Cycle) -> String {
    let stages =
        joined(cycle.stages.iter().map(|(number, stage)| {
            format!(r#""{number}":{{"calls":{},{}}}"#, stage.calls, work(stage.work))
        }));
    format!(r#"{{{},"stages":{{{stages}}}}}"#, work(cycle.work))
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
        assert_eq!(json(&Counter::new(2)), expected);
    }
}
