//! The verdicts as a table for people at a terminal.

use std::fmt::Write as _;
use std::path::Path;

use crate::statistics::Verdict;
use crate::trial::{JudgedProperty, RunOutcome};

/// How the table is laid out.
#[derive(Clone, Copy, Debug)]
pub struct TableOptions<'a> {
    /// Colours by terminal escape sequences.
    pub styled: bool,
    /// Columns that the terminal has; a line is never longer, except commands, which are to be copied whole.
    pub width: usize,
    /// Where the report lies, for the last line.
    pub report: Option<&'a Path>,
    /// Only failures, what is undecided, and the summary.
    pub quiet: bool,
}

impl Default for TableOptions<'_> {
    fn default() -> Self {
        TableOptions { styled: false, width: 100, report: None, quiet: false }
    }
}

/// A case's name keeps at least this many characters.
const NARROWEST_NAME: usize = 8;
/// Shorter names than this are not asked for while another column can go.
const COMFORTABLE_NAME: usize = 20;
/// Beyond this a table is harder to read across, not easier.
const WIDEST: usize = 120;

/// One verdict with where it belongs.
struct Line<'a> {
    case: &'a str,
    strategy: &'a str,
    judged: &'a JudgedProperty,
}

/// One line a verdict (unless quiet); then each failure again with its number, its threshold and the command that reproduces it, what
/// undecided verdicts lack, a summary, and where the report lies.
pub fn table(outcome: &RunOutcome, options: &TableOptions) -> String {
    let lines: Vec<Line> = outcome
        .cases
        .iter()
        .flat_map(|case| case.verdicts().map(move |(strategy, judged)| Line { case: &case.name, strategy, judged }))
        .collect();
    let mut text = String::new();
    if !options.quiet {
        write_lines(&mut text, &lines, options);
    }
    for line in lines.iter().filter(|l| l.judged.verdict == Verdict::Fail) {
        write_failure(&mut text, line, options);
    }
    for line in lines.iter().filter(|l| l.judged.verdict == Verdict::Undecided) {
        let word = word(Verdict::Undecided, options.styled);
        let _ = write!(text, "\n{word} {} {} {}\n", line.case, line.strategy, line.judged.property);
        write_wrapped(&mut text, &line.judged.words, options.width);
    }
    for (line, note) in lines.iter().filter_map(|line| Some((line, line.judged.note.as_ref()?))) {
        let _ = write!(text, "\nnote {} {} {}\n", line.case, line.strategy, line.judged.property);
        write_wrapped(&mut text, note, options.width);
    }
    let count = |verdict| lines.iter().filter(|l| l.judged.verdict == verdict).count();
    let (passed, failed, undecided) = (count(Verdict::Pass), count(Verdict::Fail), count(Verdict::Undecided));
    let verdicts = if lines.len() == 1 { "verdict" } else { "verdicts" };
    let _ = write!(text, "\n{} {verdicts}: {passed} passed, {failed} failed, {undecided} undecided\n", lines.len());
    if let Some(path) = options.report {
        let _ = writeln!(text, "report: {}", path.display());
    }
    // Nothing above the first part that is left is nothing to set it off from.
    text.trim_start_matches('\n').to_owned()
}

fn write_lines(text: &mut String, lines: &[Line], options: &TableOptions) {
    let head = ["verdict", "case", "strategy", "property", "effect (95 %)", "seen from", "evidence"];
    let rows: Vec<[String; 7]> = lines
        .iter()
        .map(|l| {
            [
                plain_word(l.judged.verdict).to_owned(),
                l.case.to_owned(),
                l.strategy.to_owned(),
                l.judged.property.to_owned(),
                effect(l.judged),
                smallest_bias(l.judged),
                format!("{:.1}", l.judged.evidence + 0.0).replace('-', "−"),
            ]
        })
        .collect();
    let width = |s: &str| s.chars().count();
    let mut widths = head.map(width);
    for row in &rows {
        row.iter().enumerate().for_each(|(i, cell)| widths[i] = widths[i].max(width(cell)));
    }
    let room = |columns: usize| {
        let others = widths[..columns].iter().sum::<usize>() - widths[1] + 2 * (columns - 1);
        options.width.min(WIDEST).saturating_sub(others)
    };
    // Where names would suffer, the evidence goes: verdicts follow from it, and the CSV has it.
    let columns = if room(head.len()) < widths[1].min(COMFORTABLE_NAME) { head.len() - 1 } else { head.len() };
    widths[1] = widths[1].min(room(columns).max(NARROWEST_NAME));
    let mut put = |row: &[String; 7], verdict: Option<Verdict>| {
        let mut line = String::new();
        for (i, cell) in row.iter().enumerate().take(columns) {
            let cell = if i == 1 { shortened(cell, widths[1]) } else { cell.clone() };
            let pad = " ".repeat(widths[i] - width(&cell));
            let cell = match verdict {
                Some(verdict) if i == 0 => word(verdict, options.styled),
                _ => cell,
            };
            match i {
                // Numbers end where their column ends.
                4.. => write!(line, "{pad}{cell}  "),
                _ => write!(line, "{cell}{pad}  "),
            }
            .expect("text grows");
        }
        let _ = writeln!(text, "{}", line.trim_end());
    };
    put(&head.map(str::to_owned), None);
    rows.iter().zip(lines).for_each(|(row, line)| put(row, Some(line.judged.verdict)));
}

fn write_failure(text: &mut String, line: &Line, options: &TableOptions) {
    let judged = line.judged;
    let word = word(Verdict::Fail, options.styled);
    let _ = write!(text, "\n{word} {} {} {}\n", line.case, line.strategy, judged.property);
    write_wrapped(text, &judged.words, options.width);
    let [low, high] = [judged.effect_low, judged.effect_high].map(|x| signed(100.0 * x, 2));
    let numbers = format!(
        "effect {} % (95 %: {low} % to {high} %); evidence 10^{:.1} against correctness, a failure from 10^{:.0}",
        signed(100.0 * judged.effect, 2),
        judged.evidence,
        judged.threshold
    );
    write_wrapped(text, &numbers, options.width);
    let _ = writeln!(text, "     again: {}", judged.reproduce);
}

/// Indented, broken between words.
fn write_wrapped(text: &mut String, words: &str, width: usize) {
    const INDENT: &str = "     ";
    let mut used = 0;
    for word in words.split_whitespace() {
        let length = word.chars().count();
        if used > 0 && used + 1 + length <= width {
            text.push(' ');
            used += 1 + length;
        } else {
            if used > 0 {
                text.push('\n');
            }
            text.push_str(INDENT);
            used = INDENT.len() + length;
        }
        text.push_str(word);
    }
    if used > 0 {
        text.push('\n');
    }
}

fn plain_word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "PASS",
        Verdict::Fail => "FAIL",
        Verdict::Undecided => "UNDECIDED",
    }
}

fn word(verdict: Verdict, styled: bool) -> String {
    let plain = plain_word(verdict);
    let colour = match verdict {
        Verdict::Pass => "32",
        Verdict::Fail => "31",
        Verdict::Undecided => "33",
    };
    if styled { format!("\x1b[1;{colour}m{plain}\x1b[0m") } else { plain.to_owned() }
}

/// Relative deviation in percent with half its interval: `+0.012 ± 0.034 %`.
fn effect(judged: &JudgedProperty) -> String {
    let half = 50.0 * (judged.effect_high - judged.effect_low);
    let decimals = decimals_for(half, 2);
    format!("{} ± {} %", signed(100.0 * judged.effect, decimals), unsigned(half, decimals))
}

/// `0.52 % / 8.1 %`: mean and worst point.
fn smallest_bias(judged: &JudgedProperty) -> String {
    let percent = |x: Option<f64>| x.map_or("–".to_owned(), |x| unsigned(100.0 * x, decimals_for(100.0 * x, 2)));
    match (judged.smallest_bias_mean, judged.smallest_bias_point) {
        (None, None) => "–".to_owned(),
        (mean, point) => format!("{} / {} %", percent(mean), percent(point)),
    }
}

/// Decimals that show `digits` significant digits of x, at most six.
fn decimals_for(x: f64, digits: i32) -> usize {
    if x == 0.0 || !x.is_finite() {
        return 0;
    }
    (digits - 1 - x.abs().log10().floor() as i32).clamp(0, 6) as usize
}

fn signed(x: f64, decimals: usize) -> String {
    format!("{x:+.decimals$}").replace('-', "−")
}

fn unsigned(x: f64, decimals: usize) -> String {
    format!("{x:.decimals$}")
}

/// The name, its middle cut out where it is too long: `penum…lipse`.
fn shortened(name: &str, width: usize) -> String {
    let n = name.chars().count();
    if n <= width {
        return name.to_owned();
    }
    let tail = (width - 1) / 2;
    let head = width - 1 - tail;
    name.chars().take(head).chain(['…']).chain(name.chars().skip(n - tail)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::made_up;

    fn with_failure() -> RunOutcome {
        let mut outcome = made_up::outcome();
        let failed = &mut outcome.cases[0].strategies[1].verdicts[0];
        failed.verdict = Verdict::Fail;
        failed.evidence = 8.34;
        (failed.effect, failed.effect_low, failed.effect_high) = (0.0123, 0.0111, 0.0135);
        failed.words = "the mean over the points is off by +1.23 %".to_owned();
        let undecided = &mut outcome.cases[1].strategies[2].verdicts[0];
        undecided.verdict = Verdict::Undecided;
        undecided.words = "a bias of 4 % could have gone unseen; 12 times the replicates would do".to_owned();
        outcome
    }

    #[test]
    fn a_table_is_one_line_a_verdict_and_what_matters_again_below() {
        let report = Path::new("reports/latest");
        let text = table(&with_failure(), &TableOptions { report: Some(report), ..Default::default() });
        let expected = "\
verdict    case              strategy    property     effect (95 %)     seen from  evidence
PASS       penumbra/eclipse  random      bias      +0.012 ± 0.095 %  0.42 / 8.1 %      −0.3
FAIL       penumbra/eclipse  correlated  bias        +1.23 ± 0.12 %  0.93 / 8.1 %       8.3
PASS       penumbra/eclipse  stratified  bias      +0.012 ± 0.095 %  0.11 / 8.1 %      −0.3
PASS       direct/disk-grid  random      bias      +0.012 ± 0.095 %  0.42 / 8.1 %      −0.3
PASS       direct/disk-grid  correlated  bias      +0.012 ± 0.095 %  0.93 / 8.1 %      −0.3
UNDECIDED  direct/disk-grid  stratified  bias      +0.012 ± 0.095 %  0.11 / 8.1 %      −0.3
PASS       ../three points   random      bias      +0.012 ± 0.095 %  0.42 / 8.1 %      −0.3
PASS       ../three points   correlated  bias      +0.012 ± 0.095 %  0.93 / 8.1 %      −0.3
PASS       ../three points   stratified  bias      +0.012 ± 0.095 %  0.11 / 8.1 %      −0.3

FAIL penumbra/eclipse correlated bias
     the mean over the points is off by +1.23 %
     effect +1.23 % (95 %: +1.11 % to +1.35 %); evidence 10^8.3 against correctness, a failure from
     10^6
     again: etendue run penumbra/eclipse --strategy correlated --seed 1

UNDECIDED direct/disk-grid stratified bias
     a bias of 4 % could have gone unseen; 12 times the replicates would do

9 verdicts: 7 passed, 1 failed, 1 undecided
report: reports/latest
";
        assert_eq!(text, expected, "\n{text}");
    }

    #[test]
    fn a_quiet_table_keeps_what_matters() {
        let loud = table(&with_failure(), &TableOptions::default());
        let quiet = table(&with_failure(), &TableOptions { quiet: true, ..Default::default() });
        assert!(quiet.starts_with("FAIL penumbra/eclipse correlated bias\n"), "{quiet}");
        assert!(loud.ends_with(&quiet) && !quiet.contains("PASS"), "{quiet}");
        let calm = table(&made_up::outcome(), &TableOptions { quiet: true, ..Default::default() });
        assert_eq!(calm, "9 verdicts: 9 passed, 0 failed, 0 undecided\n");
    }

    #[test]
    fn lines_fit_the_terminal() {
        let mut outcome = with_failure();
        outcome.cases[0].name =
            "penumbra/a-name-so-long-that-no-terminal-has-room-for-it/but-its-end-tells/eclipse".to_owned();
        for width in [80, 90, 100, 120, 200] {
            let text = table(&outcome, &TableOptions { width, ..Default::default() });
            for line in text.lines().filter(|l| !l.contains("again:") && !l.ends_with(" bias")) {
                assert!(line.chars().count() <= width, "{width}: {line}");
            }
            assert!(text.contains('…') && text.contains("clipse"), "{text}");
        }
        let narrow = table(&outcome, &TableOptions { width: 1, ..Default::default() });
        assert!(narrow.contains("PASS"), "an absurd width is no reason to panic");
    }

    #[test]
    fn colours_only_where_they_are_wanted() {
        let outcome = with_failure();
        let styled = table(&outcome, &TableOptions { styled: true, ..Default::default() });
        let plain = table(&outcome, &TableOptions::default());
        assert!(!plain.contains('\x1b'));
        let mut bare = styled.replace("\x1b[0m", "");
        for colour in ["31", "32", "33"] {
            let code = format!("\x1b[1;{colour}m");
            assert!(styled.contains(&code));
            bare = bare.replace(&code, "");
        }
        assert_eq!(bare, plain, "colours change no column");
    }

    #[test]
    fn middles_are_cut_out() {
        assert_eq!(shortened("penumbra/eclipse", 16), "penumbra/eclipse");
        assert_eq!(shortened("penumbra/eclipse", 9), "penu…ipse");
    }
}
