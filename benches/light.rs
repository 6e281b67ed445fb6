//! Seconds for a million rays from the light, on one thread.
//!
//! `cargo bench --bench light`: median of three runs of each shipped caustic case, as it stands and with both branches of
//! every split followed.

use std::time::Instant;

use etendue::case::shipped_caustics;
use etendue::light::{LightSettings, Split, trace};

const ROUNDS: usize = 3;

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    println!("{:<28} {:>6} {:>10} {:>8}", "case", "split", "rays", "seconds");
    for shipped in shipped_caustics() {
        let case = shipped.read().expect("a test reads it");
        for split in Split::ALL {
            let settings = LightSettings { rays: 1_000_000, split, ..case.light.clone() };
            let mut rays = 0;
            let mut rounds: Vec<f64> = (0..ROUNDS as u64)
                .map(|seed| {
                    let start = Instant::now();
                    let run = pool.install(|| trace(&case.configuration, &settings, seed));
                    rays = std::hint::black_box(run).ledger.rays;
                    start.elapsed().as_secs_f64()
                })
                .collect();
            rounds.sort_by(f64::total_cmp);
            println!("{:<28} {:>6} {rays:>10} {:>8.3}", case.name, split.name(), rounds[ROUNDS / 2]);
        }
    }
}
