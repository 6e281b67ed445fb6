//! Plans as a table for people at a terminal.

use std::fmt::Write as _;

use crate::trial::Forecast;

/// One line a case and strategy: replicates, rays, time, and what would be seen.
///
/// - `threads`: that the time in all is divided among
pub fn forecast_table(forecasts: &[Forecast], threads: usize) -> String {
    let widest = forecasts.iter().map(|plan| plan.case.len()).max().unwrap_or(0).max(4);
    let named = forecasts.iter().map(|plan| plan.strategy.name().len()).max().unwrap_or(0).max(8);
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{:widest$}  {:named$}  {:>9}  {:>8}  {:>19}  variance",
        "case", "strategy", "rays", "CPU s", "seen from (%)"
    );
    for plan in forecasts {
        let percent = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{:.2}", 100.0 * x));
        let seen = format!("{} / {}", percent(plan.smallest_bias_mean), percent(plan.smallest_bias_point));
        let short = if plan.suffices { "" } else { ", too little to decide" };
        let _ = writeln!(
            text,
            "{:widest$}  {:named$}  {:>9}  {:>8.2}  {seen:>19}  {}{short}",
            plan.case,
            plan.strategy.name(),
            count(plan.rays),
            plan.seconds,
            if plan.predicted { "predicted" } else { "of a pilot" },
        );
    }
    let (rays, seconds) = forecasts.iter().fold((0, 0.0), |(r, s), plan| (r + plan.rays, s + plan.seconds));
    let _ = writeln!(
        text,
        "\n{} shadow rays, {seconds:.1} s of processor time to estimate (stages `pilot` and `measure` of timings.csv): about {:.0} s on \
         {threads} threads. Not counted: exact values and predictions, verdicts, rays from the light and paths",
        count(rays),
        (seconds / threads as f64).ceil()
    );
    text
}

/// A number in three digits and its thousands.
fn count(n: u64) -> String {
    let n = n as f64;
    match n {
        n if n >= 1e9 => format!("{:.2} G", n / 1e9),
        n if n >= 1e6 => format!("{:.1} M", n / 1e6),
        n if n >= 1e3 => format!("{:.1} k", n / 1e3),
        n => format!("{n}"),
    }
}
