//! What it costs a run to keep its units: processor time with a checkpoint over processor time without.
//!
//! `cargo bench --bench checkpoint [name]`: the shipped cases whose name holds the given one (default: all), as `etendue run` takes
//! them, without writing a report; rounds with and without follow each other. Then what the checkpoint holds.

use std::ops::ControlFlow;

use etendue::case::{Case, Reach, shipped};
use etendue::journal::{CHECKPOINT, Checkpoint, Identity};
use etendue::trial::{Effort, Overrides, Progress, Settings, run_kept, run_while};

const ROUNDS: usize = 5;

fn main() {
    let wanted = std::env::args().skip(1).find(|word| !word.starts_with('-')).unwrap_or_default();
    let chosen = shipped().filter(|case| case.name().contains(&wanted));
    let cases: Vec<Case> = chosen.map(|case| case.read().expect("a test reads it")).collect();
    let settings = Settings { seed: 1, effort: Effort::Standard, overrides: Overrides::default() };
    let on = |_: Progress| ControlFlow::Continue(());
    let folder = tempfile::tempdir().expect("a folder");
    let mut bytes = 0;
    let mut with = || {
        let begun = now();
        let identity = Identity::new(&cases, &settings, &[], Reach::Inside, None);
        let checkpoint = Checkpoint::begin(folder.path(), &identity).expect("a checkpoint");
        run_kept(&cases, &settings, &checkpoint, &on).expect("a run");
        bytes = std::fs::metadata(folder.path().join(CHECKPOINT)).map_or(0, |file| file.len());
        checkpoint.remove(&[]).expect("it is ours");
        now() - begun
    };
    let without = || {
        let begun = now();
        run_while(&cases, &settings, &on).expect("a run");
        now() - begun
    };
    without();
    let mut ratios: Vec<f64> = (0..ROUNDS)
        .map(|round| {
            // Neither is always the first.
            let (with, without) = if round % 2 == 0 {
                let without = without();
                (with(), without)
            } else {
                (with(), without())
            };
            println!("with {with:.2} s, without {without:.2} s: {:.4}", with / without);
            with / without
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    let median = ratios[ROUNDS / 2];
    println!(
        "{} cases: {:+.2} % ({:+.2} to {:+.2} %), {bytes} bytes",
        cases.len(),
        share(median),
        share(ratios[0]),
        share(ratios[ROUNDS - 1])
    );
}

fn share(ratio: f64) -> f64 {
    100.0 * (ratio - 1.0)
}

/// Seconds that this process was on a core; by the clock where the system does not tell.
fn now() -> f64 {
    let told = std::fs::read_to_string("/proc/self/stat").ok();
    // Ticks of a hundredth, after the name in brackets: user and system are fields 14 and 15.
    let ticks = told.and_then(|text| {
        let fields: Vec<f64> =
            text.rsplit_once(')')?.1.split_whitespace().filter_map(|field| field.parse().ok()).collect();
        Some(fields.get(10)? + fields.get(11)?)
    });
    ticks.map_or_else(
        || std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0.0, |time| time.as_secs_f64()),
        |ticks| ticks / 100.0,
    )
}
