//! `index.html`: the whole report on one page that stands alone. What was run and what came of it, the answer to the
//! commonest question, every verdict, every case with its drawing, formulas, charts and pictures, and a glossary.
//!
//! Words, tables and drawings are there without a script; charts are drawn by the page's own from embedded data when
//! their case is opened. Nothing is fetched: the page's policy forbids it.

mod data;
mod drawing;
mod flow;
mod formula;
mod glossary;
mod sampler;
mod verdicts;

use std::fmt::Write as _;

use super::folder::FILES;
use super::page::{STYLE, escaped, two_digits};
use super::record::{CaseRecord, ReportRecord, VerdictRecord};
use crate::oracle::Region;
use crate::statistics::Verdict;
use crate::trial::median;

use self::sampler::minus;
#[cfg(feature = "plots")]
pub(super) use self::sampler::shown;

pub(super) const FILE: &str = "index.html";

/// Nothing from elsewhere: no file, no font, no script, no request.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'";

/// Files beside the page that it may point to.
pub(super) struct Beside<'a> {
    /// Of each case: the stem of its plots, and which kinds there are.
    pub plots: &'a dyn Fn(usize) -> Vec<String>,
    /// Of each case.
    pub pictures: &'a [Pictures],
    /// Whether it loads itself again and again.
    pub watched: bool,
}

/// What a picture shows, and the picture as PNG.
pub(super) type Pictures = Vec<(String, Vec<u8>)>;

/// The page.
pub(super) fn page(record: &ReportRecord, beside: &Beside) -> String {
    let sampler = sampler::section(record, beside.pictures);
    let mut body = head(record, !sampler.is_empty());
    body += &failures(record);
    body += &faults(record);
    body += &chapters(record);
    body += &sampler;
    body += &verdicts::section(record);
    body += "<section id=\"cases\">\n<h2>Cases</h2>\n<p class=\"tools\"><button type=\"button\" data-all=\"open\">Open \
             all</button> <button type=\"button\" data-all=\"close\">Close all</button></p>\n";
    let mut chapter = "";
    let mut order: Vec<usize> = (0..record.cases.len()).collect();
    // Failing first, then in the order of the run.
    order.sort_by_key(|k| u8::from(worst(&record.cases[*k]) != Some(Verdict::Fail)));
    for k in order {
        let case = &record.cases[k];
        let of = if worst(case) == Some(Verdict::Fail) { "failed" } else { chapter_of(&case.name) };
        if of != chapter {
            let _ = writeln!(body, "<h3 class=\"chapter\">{}</h3>", escaped(of));
            chapter = of;
        }
        body += &section(record, k, beside);
    }
    body += "</section>\n";
    body += glossary::SECTION;
    let tables = FILES.iter().filter(|file| file.ends_with(".csv"));
    let tables: Vec<String> = tables.map(|file| format!("<a href=\"{file}\">{file}</a>")).collect();
    body += &format!(
        "<footer><p>etendue {} · seed {} · <code>{}</code> · tables: {}. Times are on a page of their own, <a href=\"timings.html\">timings.html</a>: they alone differ from \
         run to run.</p></footer>\n",
        escaped(&record.version),
        escaped(&record.seed),
        escaped(&record.command),
        tables.join(", "),
    );
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <title>etendue: {}</title>\n<style>{STYLE}{}</style>\n</head>\n<body{}>\n{body}\
         <script type=\"application/json\" id=\"data\">{}</script>\n<script>\n{}</script>\n</body>\n</html>\n",
        escaped(&summary(record)),
        include_str!("index.css"),
        if beside.watched { " data-watched" } else { "" },
        data::embedded(record),
        include_str!("index.js"),
    )
}

/// The folder that a case lies in.
fn chapter_of(name: &str) -> &str {
    name.split_once('/').map_or("cases", |(chapter, _)| chapter)
}

fn verdicts(record: &ReportRecord) -> impl Iterator<Item = (&CaseRecord, &VerdictRecord)> {
    record.cases.iter().flat_map(|case| case.verdicts.iter().map(move |judged| (case, judged)))
}

fn counts(record: &ReportRecord) -> [usize; 3] {
    [Verdict::Fail, Verdict::Undecided, Verdict::Pass]
        .map(|verdict| verdicts(record).filter(|(_, judged)| judged.verdict == verdict).count())
}

fn summary(record: &ReportRecord) -> String {
    let [failed, undecided, passed] = counts(record);
    format!("{passed} passed, {failed} failed, {undecided} undecided")
}

/// The worst verdict of a case: fail, then undecided.
fn worst(case: &CaseRecord) -> Option<Verdict> {
    case.verdicts.iter().map(|judged| judged.verdict).min_by_key(rank)
}

/// Worst first.
fn rank(verdict: &Verdict) -> u8 {
    match verdict {
        Verdict::Fail => 0,
        Verdict::Undecided => 1,
        Verdict::Pass => 2,
    }
}

fn head(record: &ReportRecord, has_sampler: bool) -> String {
    let [failed, undecided, passed] = counts(record);
    let cases = record.cases.len();
    let word = match (failed, undecided) {
        (0, 0) if passed == 0 => "Nothing was judged.".to_owned(),
        (0, 0) => "Every verdict passed.".to_owned(),
        (0, _) => "No verdict failed; some are undecided.".to_owned(),
        (1, _) => "One verdict failed.".to_owned(),
        _ => format!("{failed} verdicts failed."),
    };
    let tile = |n: usize, name: &str| {
        let zero = if n == 0 { " none" } else { "" };
        format!("<li class=\"tile {name}{zero}\"><b>{n}</b> {name}</li>")
    };
    format!(
        "<header>\n<h1>{word}</h1>\n<p class=\"lead\">etendue {} measured Monte Carlo estimates of light from area sources in {cases} \
         case{} and held them against the exact values. <code>{}</code></p>\n<ul class=\"tiles\">{}{}{}</ul>\n\
         <nav aria-label=\"On this page\">{}<a href=\"#verdicts\">Verdicts</a> \
         <a href=\"#cases\">Cases</a> <a href=\"#glossary\">Glossary</a> <a href=\"timings.html\">Timings</a></nav>\n</header>\n",
        escaped(&record.version),
        if cases == 1 { "" } else { "s" },
        escaped(&record.command),
        tile(failed, "failed"),
        tile(undecided, "undecided"),
        tile(passed, "passed"),
        if has_sampler { "<a href=\"#sampler\">Which sampler?</a> " } else { "" },
    )
}

/// What failed, unmissable, each with its size and the command that repeats it.
fn failures(record: &ReportRecord) -> String {
    let failed: String = verdicts(record)
        .filter(|(_, judged)| judged.verdict == Verdict::Fail)
        .map(|(case, judged)| {
            format!(
                "<li><p><b>{}</b> of <b>{}</b> in <a href=\"#{}\">{}</a>: off by {}{}.</p>\n<p class=\"again\"><code>{}</code> \
                 <button type=\"button\" data-copy>Copy</button></p></li>\n",
                escaped(&judged.property),
                escaped(&sampler::shown(&judged.strategy)),
                anchor(case, record),
                escaped(&case.name),
                effect(judged),
                judged.evidence.map_or(String::new(), |x| format!(
                    "; evidence 10<sup>{}</sup>, where a correct one reaches 10<sup>6</sup> once in a million",
                    minus(format!("{x:.1}"))
                )),
                escaped(&judged.reproduce),
            )
        })
        .collect();
    if failed.is_empty() {
        return String::new();
    }
    format!("<section class=\"alarm\" role=\"alert\"><h2>What failed</h2>\n<ol>{failed}</ol></section>\n")
}

fn faults(record: &ReportRecord) -> String {
    if record.faults.is_empty() {
        return String::new();
    }
    let items: String = record.faults.iter().map(|fault| format!("<li>{}</li>", escaped(fault))).collect();
    format!(
        "<section class=\"missing\"><h2>What is missing from this report</h2>\n<p>The page shows what could be read.</p>\n\
         <ul>{items}</ul></section>\n"
    )
}

/// `+0.12 ± 0.42 %`.
fn effect(judged: &VerdictRecord) -> String {
    let Some([effect, low, high]) = judged.effect else { return "–".to_owned() };
    let sign = if effect < 0.0 { "−" } else { "+" };
    let size = two_digits((100.0 * effect).abs());
    let sign = if effect == 0.0 { "" } else { sign };
    if low == high {
        return format!("{sign}{size} %");
    }
    format!("{sign}{size} ± {} %", two_digits(50.0 * (high - low)))
}

/// `0.7 % / 10 %`.
fn seen_from(judged: &VerdictRecord) -> String {
    let percent = |x: Option<f64>| x.map_or("–".to_owned(), |x| format!("{} %", two_digits(100.0 * x)));
    match (judged.smallest_bias_mean, judged.smallest_bias_point) {
        (None, None) => "–".to_owned(),
        (mean, None) => percent(mean),
        (mean, point) => format!("{} / {}", percent(mean), percent(point)),
    }
}

/// One figure for each chapter.
fn chapters(record: &ReportRecord) -> String {
    let mut names: Vec<&str> = Vec::new();
    for case in &record.cases {
        let chapter = chapter_of(&case.name);
        if !names.contains(&chapter) {
            names.push(chapter);
        }
    }
    let tiles: String = names
        .iter()
        .filter_map(|chapter| {
            let cases: Vec<&CaseRecord> =
                record.cases.iter().filter(|case| chapter_of(&case.name) == *chapter).collect();
            let (figure, words) = figure_of(&cases)?;
            let n = cases.len();
            let plural = if n == 1 { "" } else { "s" };
            Some(format!(
                "<li><h3>{} <span class=\"note\">{n} case{plural}</span></h3><b>{figure}</b><p>{words}</p></li>",
                escaped(chapter)
            ))
        })
        .collect();
    if tiles.is_empty() { String::new() } else { format!("<ul class=\"figures\">{tiles}</ul>\n") }
}

/// What matters in a chapter: what strata are worth where strategies were measured, the books where light was followed, or
/// how near paths came where those were judged; whichever most of its cases have.
fn figure_of(cases: &[&CaseRecord]) -> Option<(String, String)> {
    let ratios: Vec<f64> = cases.iter().filter_map(|case| gain(case)).collect();
    let gaps: Vec<f64> = cases
        .iter()
        .filter_map(|case| case.ledger.iter().map(crate::trial::LightRow::largest_gap).reduce(f64::max))
        .collect();
    let judged = cases.iter().filter_map(|case| {
        let of_paths = case.verdicts.iter().filter(|judged| judged.property == "indirect");
        let effects = of_paths.filter_map(|judged| judged.effect);
        effects.map(|[effect, low, high]| [effect.abs(), 0.5 * (high - low)]).max_by(|a, b| a[0].total_cmp(&b[0]))
    });
    let paths: Vec<[f64; 2]> = judged.collect();
    let most = ratios.len().max(gaps.len()).max(paths.len());
    if paths.len() == most {
        let [effect, half] = *paths.iter().max_by(|a, b| a[0].total_cmp(&b[0]))?;
        return Some((
            format!("{} %", two_digits(100.0 * effect)),
            format!(
                "is the most that paths from the eye were off the exact value (± {} %)",
                two_digits(100.0 * half)
            ),
        ));
    }
    if ratios.len() == most {
        return Some((
            format!("{}×", two_digits(median(ratios)?)),
            "less variance by stratified points than by random ones, median of the cases, N = 64 or near".to_owned(),
        ));
    }
    let gap = gaps.into_iter().reduce(f64::max)?;
    let rounding = if gap < 1e-12 { ": rounding" } else { "" };
    Some((two_digits(gap), format!("of the power is unaccounted for, at most{rounding}")))
}

/// Variance of random points over that of stratified ones, in the penumbra where there is one.
fn gain(case: &CaseRecord) -> Option<f64> {
    let samples = case.shown_samples()?;
    let of = |name: &str| {
        let made = case.strategies.iter().find(|made| made.name == name)?;
        let rates = || made.rates.iter().filter(|rate| rate.quantity == "variance");
        let rate = rates().find(|r| r.region == Some(Region::Penumbra)).or_else(|| rates().next())?;
        rate.points.iter().find(|point| point.samples == samples).map(|point| point.value)
    };
    of("random").zip(of("stratified")).filter(|(_, least)| *least > 0.0).map(|(random, least)| random / least)
}

/// Where a case is on the page: its place, so that no name has to be an identifier.
fn anchor(case: &CaseRecord, record: &ReportRecord) -> String {
    let place = record.cases.iter().position(|one| std::ptr::eq(one, case)).unwrap_or(0);
    format!("case-{place}")
}

fn figure(chart: &str, title: &str, words: &str, files: &[String]) -> String {
    format!(
        "<figure class=\"fig\" data-chart=\"{chart}\"><h4>{title}</h4><figcaption>{words} {}</figcaption></figure>\n",
        files.join(" ")
    )
}

fn section(record: &ReportRecord, k: usize, beside: &Beside) -> String {
    let case = &record.cases[k];
    let state = match worst(case) {
        Some(Verdict::Fail) => ("fail", "fail"),
        Some(Verdict::Undecided) => ("undecided", "undecided"),
        Some(Verdict::Pass) => ("pass", "pass"),
        None => ("none", "not judged"),
    };
    let open = if state.0 == "fail" { " open" } else { "" };
    let mut html = format!(
        "<details class=\"case\" id=\"case-{k}\" data-case=\"{k}\"{open}><summary><span class=\"mark {}\">{}</span> \
         <span class=\"title\">{}</span> <code>{}</code></summary>\n<div class=\"inside\">\n",
        state.0,
        state.1,
        escaped(&case.title),
        escaped(&case.name),
    );
    html += &drawing::drawing(case);
    html += &formula::formulas(case);
    html += &verdicts::of_case(case);
    html += &pictures(&beside.pictures[k]);
    html += "<div class=\"figs\">\n";
    let plots = (beside.plots)(k);
    let links = |kind: &str, table: &str| {
        let mut files = vec![format!("<a href=\"{table}\">{table}</a>")];
        let ending = format!("-{kind}.svg");
        files.extend(plots.iter().filter(|name| name.ends_with(&ending)).map(|name| {
            let name = escaped(name);
            format!("<a href=\"plots/{name}\">plot for paper</a>")
        }));
        files
    };
    let has_curves = case.strategies.iter().any(|made| made.rates.iter().any(|rate| !rate.points.is_empty()));
    if has_curves {
        html += &figure(
            "variance",
            "Variance of one estimate",
            "Marks: mean over the points, with 95 % band. Lines: fits, slopes with 95 %. Thin: the slopes that theory gives for large N.",
            &links("variance", "curves.csv"),
        );
    }
    if case.strategies.iter().any(|made| made.cells.iter().any(|cell| cell.mean_bias.is_some())) {
        html += &figure(
            "bias",
            "Bias of the mean over the points",
            "Bars: 95 %. Dashed: the smallest bias that would have been caught at every N, with 99 % probability.",
            &links("bias", "means.csv"),
        );
    }
    if !case.points.is_empty() && !case.strategies.is_empty() {
        html += &figure(
            "profile",
            "Irradiance",
            "Line: exact. Bands: ± one standard deviation of one estimate; below, the mean less the exact value with 95 % bars.",
            &links("profile", "convergence.csv"),
        );
    }
    if case.strategies.iter().any(|made| !made.correlations.is_empty()) {
        html += &figure(
            "correlation",
            "Correlation of two points’ errors",
            "By their distance; bands: 95 %. Dotted: predicted.",
            &links("correlation", "correlation.csv"),
        );
    }
    if case.rings.iter().any(|ring| ring.position.is_some()) {
        html += &figure(
            "caustic",
            "Caustic",
            "Steps: exact means over rings around the axis. Marks: measured, with 95 % bars.",
            &links("caustic", "caustic.csv"),
        );
    }
    html += &flow::flow(case);
    if !case.texels.is_empty() {
        html += &figure(
            "texels",
            "What the map is off by",
            "Marks: measured noise of texels. Lines: predicted noise and, dotted, the bias of their size.",
            &links("texels", "texels.csv"),
        );
    }
    if case.paths.iter().any(|path| path.point.is_some() && path.exact.is_some()) {
        html += &figure(
            "paths",
            "Paths from the eye",
            "Measured less exact at each point, relative, with 95 % bars.",
            &links("paths", "paths.csv"),
        );
    }
    html + "</div>\n</div>\n</details>\n"
}

/// Pictures of the receiver under a switch. The first is shown.
fn pictures(pictures: &[(String, Vec<u8>)]) -> String {
    if pictures.is_empty() {
        return String::new();
    }
    let mut html = String::from(
        "<figure class=\"pictures\"><h4>The receiver, rendered</h4>\n<div class=\"switch\" role=\"group\" aria-label=\"Which picture\">",
    );
    for (k, (name, _)) in pictures.iter().enumerate() {
        let _ = write!(
            html,
            "<button type=\"button\" aria-pressed=\"{}\" data-picture=\"{k}\">{}</button>",
            k == 0,
            escaped(name)
        );
    }
    html += "</div>\n<div class=\"frames\">";
    for (k, (name, png)) in pictures.iter().enumerate() {
        let hidden = if k == 0 { "" } else { " hidden" };
        let _ = write!(
            html,
            "<img alt=\"The receiver: {}\" data-picture=\"{k}\"{hidden} src=\"data:image/png;base64,{}\">",
            escaped(name),
            base64(png)
        );
    }
    html + "</div>\n<figcaption>Square on (a ball unrolled), 16 samples a pixel. Error: estimate less exact; orange is too bright, blue too dark. \
            Keys ← and → change the picture.</figcaption></figure>\n"
}

/// RFC 4648.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let all = chunk.iter().fold(0u32, |all, byte| (all << 8) | u32::from(*byte)) << (8 * (3 - chunk.len()));
        for k in 0..4 {
            let letter = LETTERS[(all >> (18 - 6 * k)) as usize & 63] as char;
            text.push(if k <= chunk.len() { letter } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// RFC 4648, section 10.
    #[test]
    fn bytes_are_told_as_the_standard_has_them() {
        let due =
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")];
        for (bytes, text) in due {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}
