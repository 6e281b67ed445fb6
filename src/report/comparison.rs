//! What changed between two runs: for people, for a pull request, for programs.

use std::fmt::Write as _;

use serde::Serialize;

use super::page::two_digits;
use crate::statistics::Interval;
use crate::trial::{Comparison, Record, RecordedVerdict, VarianceChange, VerdictChange};

/// How a comparison is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComparisonFormat {
    /// For a terminal.
    Text,
    /// For a pull request.
    Markdown,
    /// For programs: one object.
    Json,
}

/// What changed, in words, tables or JSON.
///
/// - `names`: what the two runs are called, the one before first
/// - `all`: whether variances are listed that changed by no more than chance may
pub fn comparison_text(
    comparison: &Comparison,
    names: [&str; 2],
    records: [&Record; 2],
    format: ComparisonFormat,
    all: bool,
) -> String {
    match format {
        ComparisonFormat::Text => text(comparison, names, records, all),
        ComparisonFormat::Markdown => markdown(comparison, names, records, all),
        ComparisonFormat::Json => json(comparison, names, records),
    }
}

/// The changes of variance that are listed: those that got worse, those that got better, and those that a 95 % interval sets
/// apart, or all.
fn listed(comparison: &Comparison, all: bool) -> Vec<&VarianceChange> {
    let is_apart = |change: &&VarianceChange| all || !change.interval.contains(1.0);
    let mut listed: Vec<_> = comparison.variances.iter().filter(is_apart).collect();
    listed.sort_by_key(|change| (!change.is_worse(), !change.is_better()));
    listed
}

/// What a change of variance is called.
fn word(change: &VarianceChange) -> &'static str {
    match () {
        () if !change.is_same_case => "other case",
        () if change.is_worse() => "more",
        () if change.is_better() => "less",
        () if change.interval.contains(1.0) => "same",
        () => "may be chance",
    }
}

/// `2.3 times as much`, with digits that the interval bears.
fn times(change: &VarianceChange) -> [String; 2] {
    let Interval { low, high } = change.interval;
    // Enough digits to tell the ends of the interval apart from each other.
    let places = (1.0 - (high - low).max(1e-9).log10()).ceil().clamp(2.0, 6.0) as usize;
    match change.ratio {
        ratio if (0.01..100.0).contains(&ratio) => {
            [format!("{ratio:.places$}"), format!("{low:.places$} to {high:.places$}")]
        }
        ratio => [two_digits(ratio), format!("{} to {}", two_digits(low), two_digits(high))],
    }
}

/// The strategies of a change: one name, or two with an arrow.
fn strategies(change: &VarianceChange) -> String {
    if change.before == change.after {
        change.before.clone()
    } else {
        format!("{} → {}", change.before, change.after)
    }
}

fn of_change(change: &VerdictChange) -> String {
    let (before, after) = (&change.before.strategy, &change.after.strategy);
    if before == after { before.clone() } else { format!("{before} → {after}") }
}

/// ` 2.1 % (1.9 to 2.3)`, or nothing.
fn effect(verdict: &RecordedVerdict) -> String {
    let Some((effect, Interval { low, high })) = verdict.effect else { return String::new() };
    format!(" {:+.2} % ({:+.2} to {:+.2})", 100.0 * effect, 100.0 * low, 100.0 * high)
}

fn described(name: &str, record: &Record) -> String {
    if record.version.is_empty() {
        return format!("{name} (no manifest)");
    }
    format!("{name} (etendue {}, `{}`)", record.version, record.command)
}

/// The counts that come first.
fn summary(comparison: &Comparison) -> String {
    let worse = comparison.verdicts.iter().filter(|change| change.is_worse()).count();
    let better = comparison.verdicts.len() - worse;
    let same = comparison.compared - comparison.verdicts.len();
    let more = comparison.variances.iter().filter(|change| change.is_worse()).count();
    let less = comparison.variances.iter().filter(|change| change.is_better()).count();
    let plural = |n: usize| if n == 1 { "" } else { "s" };
    let (verdicts, variances) = (comparison.compared, comparison.variances.len());
    format!(
        "{verdicts} verdict{}: {worse} worse, {better} better, {same} the same; {variances} variance{}: {more} more, {less} less beyond doubt",
        plural(verdicts),
        plural(variances)
    )
}

/// What one run alone has, by case and strategy.
fn alone(keys: &[[String; 3]]) -> Vec<String> {
    let mut rows: Vec<(String, Vec<&str>)> = Vec::new();
    for [case, strategy, property] in keys {
        let name = format!("{case} {strategy}");
        match rows.last_mut() {
            Some((last, properties)) if *last == name => properties.push(property),
            _ => rows.push((name, vec![property])),
        }
    }
    rows.into_iter().map(|(name, properties)| format!("{name} ({})", properties.join(", "))).collect()
}

fn text(comparison: &Comparison, names: [&str; 2], records: [&Record; 2], all: bool) -> String {
    let mut text = String::new();
    for (when, k) in [("before", 0), ("after ", 1)] {
        let _ = writeln!(text, "{when}  {}", described(names[k], records[k]));
    }
    for change in &comparison.verdicts {
        let word = if change.is_worse() { "WORSE" } else { "BETTER" };
        let [before, after] = [change.before.verdict, change.after.verdict];
        let (case, property) = (&change.before.case, &change.before.property);
        let _ = writeln!(
            text,
            "\n{word}  {case} {} {property}: {before} → {after}{}",
            of_change(change),
            effect(&change.after)
        );
        if change.is_worse() && !change.after.reproduce.is_empty() {
            let _ = writeln!(text, "  {}", change.after.reproduce);
        }
    }
    let listed = listed(comparison, all);
    if !listed.is_empty() {
        let rows: Vec<[String; 6]> = listed
            .iter()
            .map(|change| {
                let [ratio, interval] = times(change);
                [
                    change.case.clone(),
                    strategies(change),
                    change.samples.to_string(),
                    ratio,
                    interval,
                    word(change).to_owned(),
                ]
            })
            .collect();
        let _ = writeln!(text, "\nVariance of one estimate, after over before, at the largest N of both:\n");
        let head = ["case", "strategy", "N", "ratio", "95 %", ""].map(str::to_owned);
        let widths: [usize; 6] =
            std::array::from_fn(|k| rows.iter().chain([&head]).map(|row| row[k].chars().count()).max().unwrap_or(0));
        for [case, strategy, n, ratio, interval, word] in [head].iter().chain(&rows) {
            let [a, b, c, d, e, _] = widths;
            let line = format!("{case:a$}  {strategy:b$}  {n:>c$}  {ratio:>d$}  {interval:>e$}  {word}");
            let _ = writeln!(text, "{}", line.trim_end());
        }
    }
    for (when, keys) in [("before", &comparison.only_before), ("after", &comparison.only_after)] {
        for row in alone(keys) {
            let _ = writeln!(text, "\nonly {when}: {row}");
        }
    }
    for case in &comparison.other_cases {
        let _ =
            writeln!(text, "\nnote: {case} is another case in each run: what changed there may not be the estimator");
    }
    let _ = writeln!(text, "\n{}", summary(comparison));
    text
}

/// A text in a cell of a Markdown table.
fn cell(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            '|' => "\\|".to_owned(),
            '<' => "&lt;".to_owned(),
            '&' => "&amp;".to_owned(),
            '`' | '*' | '_' | '[' | ']' => format!("\\{c}"),
            c if c.is_control() => " ".to_owned(),
            c => c.to_string(),
        })
        .collect()
}

fn markdown(comparison: &Comparison, names: [&str; 2], records: [&Record; 2], all: bool) -> String {
    let mut text = format!("**etendue**: {}\n\n", summary(comparison));
    if !comparison.verdicts.is_empty() {
        text.push_str(
            "| case | strategy | property | before | after | effect after (95 %) |\n|---|---|---|---|---|---|\n",
        );
        for change in &comparison.verdicts {
            let after = change.after.verdict.name();
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {} | {} |",
                cell(&change.before.case),
                cell(&of_change(change)),
                cell(&change.before.property),
                change.before.verdict,
                if change.is_worse() { format!("**{after}**") } else { after.to_owned() },
                effect(&change.after).trim()
            );
        }
        text.push('\n');
    }
    let listed = listed(comparison, all);
    if !listed.is_empty() {
        text.push_str("| case | strategy | N | variance, after / before | 95 % | |\n|---|---|--:|--:|--:|---|\n");
        for change in listed {
            let [ratio, interval] = times(change);
            let bold = if change.is_worse() { "**" } else { "" };
            let _ = writeln!(
                text,
                "| {} | {} | {} | {bold}{ratio}{bold} | {interval} | {} |",
                cell(&change.case),
                cell(&strategies(change)),
                change.samples,
                word(change)
            );
        }
        text.push('\n');
    }
    for (when, keys) in [("before", &comparison.only_before), ("after", &comparison.only_after)] {
        let rows = alone(keys);
        if !rows.is_empty() {
            let rows: Vec<String> = rows.iter().map(|row| cell(row)).collect();
            let _ = writeln!(text, "Only {when}: {}.\n", rows.join("; "));
        }
    }
    for case in &comparison.other_cases {
        let _ = writeln!(text, "{} is another case in each run.\n", cell(case));
    }
    for (when, k) in [("Before", 0), ("After", 1)] {
        let _ = writeln!(text, "{when}: {}  ", cell(&described(names[k], records[k])));
    }
    text
}

#[derive(Serialize)]
struct Told<'a> {
    regression: bool,
    before: Run<'a>,
    after: Run<'a>,
    verdicts_compared: usize,
    verdicts_changed: Vec<ToldVerdict<'a>>,
    variances: Vec<ToldVariance<'a>>,
    only_before: Vec<Key<'a>>,
    only_after: Vec<Key<'a>>,
    other_cases: &'a [String],
}

#[derive(Serialize)]
struct Run<'a> {
    report: &'a str,
    etendue_version: &'a str,
    seed: &'a str,
    command: &'a str,
}

#[derive(Serialize)]
struct Key<'a> {
    case: &'a str,
    strategy: &'a str,
    property: &'a str,
}

#[derive(Serialize)]
struct ToldVerdict<'a> {
    case: &'a str,
    strategy_before: &'a str,
    strategy_after: &'a str,
    property: &'a str,
    before: &'static str,
    after: &'static str,
    worse: bool,
    effect: Option<f64>,
    effect_low: Option<f64>,
    effect_high: Option<f64>,
    reproduce: &'a str,
}

#[derive(Serialize)]
struct ToldVariance<'a> {
    case: &'a str,
    strategy_before: &'a str,
    strategy_after: &'a str,
    samples: u64,
    points: usize,
    ratio: f64,
    ratio_low: f64,
    ratio_high: f64,
    worse: bool,
    better: bool,
    same_case: bool,
}

fn json(comparison: &Comparison, names: [&str; 2], records: [&Record; 2]) -> String {
    let run = |k: usize| {
        let Record { version, seed, command, .. } = records[k];
        Run { report: names[k], etendue_version: version, seed, command }
    };
    fn keys(keys: &[[String; 3]]) -> Vec<Key<'_>> {
        keys.iter().map(|[case, strategy, property]| Key { case, strategy, property }).collect()
    }
    let told = Told {
        regression: comparison.regresses(),
        before: run(0),
        after: run(1),
        verdicts_compared: comparison.compared,
        verdicts_changed: comparison
            .verdicts
            .iter()
            .map(|change| ToldVerdict {
                case: &change.before.case,
                strategy_before: &change.before.strategy,
                strategy_after: &change.after.strategy,
                property: &change.before.property,
                before: change.before.verdict.name(),
                after: change.after.verdict.name(),
                worse: change.is_worse(),
                effect: change.after.effect.map(|(effect, _)| effect),
                effect_low: change.after.effect.map(|(_, interval)| interval.low),
                effect_high: change.after.effect.map(|(_, interval)| interval.high),
                reproduce: &change.after.reproduce,
            })
            .collect(),
        variances: comparison
            .variances
            .iter()
            .map(|change| ToldVariance {
                case: &change.case,
                strategy_before: &change.before,
                strategy_after: &change.after,
                samples: change.samples,
                points: change.points,
                ratio: change.ratio,
                ratio_low: change.interval.low,
                ratio_high: change.interval.high,
                worse: change.is_worse(),
                better: change.is_better(),
                same_case: change.is_same_case,
            })
            .collect(),
        only_before: keys(&comparison.only_before),
        only_after: keys(&comparison.only_after),
        other_cases: &comparison.other_cases,
    };
    let mut text = serde_json::to_string_pretty(&told).expect("texts and finite numbers serialise");
    text.push('\n');
    text
}
