//! Seconds for a million rays from the light, on one thread.
//!
//! `cargo bench --bench light [name]`: median of five runs of each shipped caustic case whose name holds the given one, as
//! it stands and with both branches of every split followed. Seconds that the thread was on a core, where the system tells
//! (Linux), so that what else runs on the machine counts little; else by the clock.

use std::time::Instant;

use etendue::case::shipped_caustics;
use etendue::light::{LightSettings, Split, trace};

const ROUNDS: usize = 5;

fn main() {
    let wanted = std::env::args().skip(1).find(|word| !word.starts_with('-')).unwrap_or_default();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    println!("{:<28} {:>6} {:>10} {:>8} {:>12}", "case", "split", "rays", "seconds", "rays/second");
    for shipped in shipped_caustics().filter(|case| case.name().contains(&wanted)) {
        let case = shipped.read().expect("a test reads it");
        for split in Split::ALL {
            let settings = LightSettings { rays: 1_000_000, split, ..case.light.clone() };
            let mut rays = 0;
            let mut round = |seed: u64| {
                let start = now();
                rays = std::hint::black_box(trace(&case.configuration, &settings, seed)).ledger.rays;
                now() - start
            };
            let mut rounds: Vec<f64> = pool.install(|| (0..ROUNDS as u64).map(&mut round).collect());
            rounds.sort_by(f64::total_cmp);
            let seconds = rounds[ROUNDS / 2];
            let rate = rays as f64 / seconds;
            println!("{:<28} {:>6} {rays:>10} {seconds:>8.3} {rate:>12.0}", case.name, split.name());
        }
    }
}

/// Seconds that this thread was on a core; by the clock where the system does not tell.
fn now() -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    thread_local!(static BEGUN: Instant = Instant::now());
    nanoseconds.map_or_else(|| BEGUN.with(|begun| begun.elapsed().as_secs_f64()), |ns| ns * 1e-9)
}
