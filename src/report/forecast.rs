//! Plans as a table for people at a terminal.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::trial::{Forecast, ShardCost};

/// One line a case and strategy: replicates, rays, time, and what would be seen.
///
/// - `shards`: what each should cost, where there are some
/// - `threads`: that the time in all is divided among
pub fn forecast_table(forecasts: &[Forecast], shards: Option<&[ShardCost]>, threads: usize) -> String {
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
    if let Some(shards) = shards {
        text.push_str(&shards_table(shards));
    }
    text
}

/// Units and seconds of each shard; of many, of the shortest and the longest.
fn shards_table(shards: &[ShardCost]) -> String {
    const SHOWN: usize = 40;
    let mut text = format!("\n{:>7}  {:>7}  {:>8}\n", "shard", "units", "CPU s");
    let mut line = |index: usize, cost: &ShardCost| {
        let _ = writeln!(text, "{index:>7}  {:>7}  {:>8.2}", cost.units, cost.seconds);
    };
    if shards.len() <= SHOWN {
        shards.iter().enumerate().for_each(|(index, cost)| line(index, cost));
    } else {
        let by_seconds = |a: &(usize, &ShardCost), b: &(usize, &ShardCost)| a.1.seconds.total_cmp(&b.1.seconds);
        let shortest = shards.iter().enumerate().min_by(by_seconds);
        let longest = shards.iter().enumerate().max_by(by_seconds);
        shortest.into_iter().chain(longest).for_each(|(index, cost)| line(index, cost));
    }
    let units: u64 = shards.iter().map(|cost| cost.units).sum();
    let seconds: f64 = shards.iter().map(|cost| cost.seconds).sum();
    let _ = writeln!(
        text,
        "{:>7}  {units:>7}  {seconds:>8.2}  in all, exact values, predictions, rays from the light and paths included",
        shards.len()
    );
    text
}

/// Plans for programs: one object.
pub fn forecast_json(forecasts: &[Forecast], shards: Option<&[ShardCost]>) -> String {
    let plan = |plan: &Forecast| {
        let cell = |(samples, replicates): &(u64, u64)| json!({ "samples": samples, "replicates": replicates });
        json!({
            "case": plan.case,
            "strategy": plan.strategy.name(),
            "cells": plan.cells.iter().map(cell).collect::<Vec<_>>(),
            "rays": plan.rays,
            "seconds": plan.seconds,
            "smallest_bias_mean": plan.smallest_bias_mean,
            "smallest_bias_point": plan.smallest_bias_point,
            "suffices": plan.suffices,
            "variances_predicted": plan.predicted,
        })
    };
    let mut told = json!({ "schema_version": 1, "plans": forecasts.iter().map(plan).collect::<Vec<_>>() });
    if let Some(shards) = shards {
        let of_shard = |cost: &ShardCost| json!({ "units": cost.units, "seconds": cost.seconds });
        told["shards"] = Value::Array(shards.iter().map(of_shard).collect());
    }
    format!("{told:#}\n")
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
