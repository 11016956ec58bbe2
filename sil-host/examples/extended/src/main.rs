//! The house is open: an effect of the world, a figure of the judge and a command of one's own, a few lines
//! each, in a package of its own.
//!
//! `cargo run --release -p extended -- ghost` flies a minute of the default scenario with a faint ghost light
//! on the detector; every command of `sil-host` is there beside it.

use clap::Parser;
use fsw_hal::Window;
use sil_host::cli::Command;
use sil_host::error::{EXIT_BAD_INPUT, HostError};
use sil_host::judge::table::{Figure, Side};
use sil_host::judge::{Judge, Limit, Verdict};
use sil_host::scenario::Scenario;
use sil_host::world::earth::image::CellBuffer;
use sil_host::world::scene::effects::{Effect, Stage};
use sil_host::{commands, harness};
use std::process::ExitCode;
use std::sync::Arc;

/// The effect: light that the lens mirrors into a square of the detector, electrons a pixel.
#[derive(Debug)]
struct Ghost(f64);

impl Effect for Ghost {
    fn add_to(&self, window: Window, electrons: &mut [f64], _: &mut CellBuffer) {
        for (row, y) in electrons.chunks_exact_mut(usize::from(window.width)).zip(window.y..) {
            let lit = row.iter_mut().zip(window.x..).filter(|(_, x)| (600..680).contains(x));
            lit.filter(|_| (400..480).contains(&y)).for_each(|(pixel, _)| *pixel += self.0);
        }
    }
}

/// The figure: seconds from the first attitude to the end.
static KNOWN_S: Figure = Figure {
    key: "known_s",
    words: "seconds since the first attitude",
    unit: "s",
    side: Side::AtLeast,
    range: (0.0, 1e6),
    of: |figures| Some(f64::from(figures.seconds - figures.first_attitude_s?)),
};

/// The command, beside those of the program.
#[derive(Parser)]
enum Mine {
    #[command(flatten)]
    Theirs(Command),
    /// Fly a minute with a ghost light
    Ghost,
}

fn ghost() -> Result<ExitCode, HostError> {
    let scenario = Scenario { duration_s: 60, ..Scenario::default_embedded() };
    let mut scene = scenario.scene()?;
    scene.add_effect(Stage::Stray, |_, moment| vec![Arc::new(Ghost(2000.0 * moment.time_s))]);
    let mut judge = Judge::new(scenario.duration_s, scenario.period_s());
    harness::fly(&scenario, &mut scene, |second| {
        judge.add(second.judged);
        Ok(())
    })?;
    let verdict = Verdict::new(&Limit { of: &KNOWN_S, value: 50.0 }, &judge.finish());
    println!("{}: {:?} s, kept: {}", KNOWN_S.words, verdict.reached, verdict.kept);
    Ok(ExitCode::from(u8::from(!verdict.kept)))
}

fn main() -> ExitCode {
    let status = match Mine::parse() {
        Mine::Theirs(command) => commands::obey(Some(&command)),
        Mine::Ghost => ghost(),
    };
    status.unwrap_or_else(|error| {
        eprintln!("{error}");
        ExitCode::from(EXIT_BAD_INPUT)
    })
}
