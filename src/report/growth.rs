//! How cost grows, told: a table of what was timed, a page, plots, and a few lines for the terminal.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::ReportError;
use super::column::{Column, Field, Table};
use super::folder::{PLOT_FORMATS, PLOTS, claim_files, write_whole};
use super::page::{Chart, Drawn, Entry, Series, count, duration, escaped, head, page, table, two_digits};
use super::tables::column;
use crate::trial::{Affine, Fits, GrowthStudy, Law, Observation, PowerLaw};

const CSV: &str = "growth.csv";
const HTML: &str = "growth.html";

/// The plot's file, less its ending.
fn stem(study: &str) -> String {
    format!("growth-{study}")
}

/// Makes sure, before the work, that the report can be written, and removes an earlier one.
pub fn claim_growth(dir: &Path) -> Result<(), ReportError> {
    claim_files(dir, &[CSV, HTML])?;
    let plots: Vec<String> = GrowthStudy::NAMES
        .iter()
        .flat_map(|name| PLOT_FORMATS.map(|format| format!("{}.{format}", stem(name))))
        .collect();
    claim_files(&dir.join(PLOTS), &plots.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Writes `growth.csv`, `growth.html` and (with the feature `plots`) `plots/growth-*` into a folder that was claimed.
/// Returns the files written.
pub fn write_growth(dir: &Path, studies: &[GrowthStudy]) -> Result<Vec<PathBuf>, ReportError> {
    let mut csv = Vec::new();
    let rows = studies.iter().flat_map(|study| study.observations.iter().map(move |seen| (study, seen)));
    growth().write(rows, &mut csv)?;
    let mut written = vec![write_whole(dir, CSV, &csv)?, write_whole(dir, HTML, growth_page(studies).as_bytes())?];
    written.extend(write_plots(&dir.join(PLOTS), studies)?);
    Ok(written)
}

#[cfg(feature = "plots")]
fn write_plots(dir: &Path, studies: &[GrowthStudy]) -> Result<Vec<PathBuf>, ReportError> {
    let mut written = Vec::new();
    for study in studies {
        for (format, bytes) in super::plot::growth_files(study) {
            let name = format!("{}.{format}", stem(study.name));
            let bytes = bytes.map_err(|reason| ReportError::Plot { path: dir.join(&name), reason })?;
            written.push(write_whole(dir, &name, &bytes)?);
        }
    }
    Ok(written)
}

#[cfg(not(feature = "plots"))]
fn write_plots(_: &Path, _: &[GrowthStudy]) -> Result<Vec<PathBuf>, ReportError> {
    Ok(Vec::new())
}

type GrowthRow<'a> = (&'a GrowthStudy, &'a Observation);

pub(super) fn growth<'a>() -> Table<GrowthRow<'a>> {
    Table {
        file: CSV,
        row: "one room of `etendue growth`, timed on one thread; times are those of the machine at hand",
        case: |(study, _)| study.name,
        columns: vec![
            column!(
                "study",
                "",
                "what grows: `samples`, `occluders`, `mesh-build`, `mesh-rays`, `points`, `light-rays`",
                |r| r.0.name
            ),
            column!("quantity", "", "what x counts", |r| r.0.quantity),
            column!("x", "", "how many of them", |r| r.1.x),
            column!("timed", "", "what the seconds are of", |r| r.0.timed),
            column!("seconds", "s", "time of one thread, median of the repeats", |r| r.1.seconds),
            column!("seconds_low", "s", "the quickest repeat", |r| r.1.seconds_low),
            column!("seconds_high", "s", "the slowest repeat", |r| r.1.seconds_high),
            column!("unit", "", "what per_unit_ns is of", |r| r.0.unit),
            column!("per_unit_ns", "ns", "time for each of them", |r| r.1.per_unit_ns()),
            column!("repeats", "", "measurements of 20 ms or more each", |r| r.1.repeats),
        ],
        more: &[],
    }
}

/// `0.998 ± 0.002`.
pub(super) fn exponent(power: &PowerLaw) -> String {
    match power.std_error {
        Some(error) => format!("{:.3} ± {error:.3}", power.exponent).replace('-', "−"),
        None => format!("{:.3}", power.exponent).replace('-', "−"),
    }
}

/// `12 ns + 3.1 ns · x`.
pub(super) fn affine(fitted: &Affine) -> String {
    let sign = if fitted.start < 0.0 { "−" } else { "" };
    let x = match fitted.law {
        Law::Linear => "x",
        Law::Logarithmic => "ln x",
    };
    let joined = if fitted.step < 0.0 { "−" } else { "+" };
    format!("{sign}{} {joined} {} · {x}", duration(fitted.start.abs()), duration(fitted.step.abs()))
}

/// `1.4 %`.
pub(super) fn percent(share: f64) -> String {
    format!("{} %", two_digits(100.0 * share))
}

/// Which law is nearer, and how near.
pub(super) fn nearer(fits: &Fits) -> String {
    let (Some(power), Some(line)) = (fits.power, fits.affine) else {
        return "too few sizes for a law".to_owned();
    };
    let name = match line.law {
        Law::Linear => "the line",
        Law::Logarithmic => "the logarithm",
    };
    let (power_off, line_off) = (percent(power.off), percent(line.off));
    match fits.power_is_nearer() {
        Some(true) => format!("the power is nearer: off by {power_off}, {name} by {line_off}"),
        Some(false) => format!("{name} is nearer: off by {line_off}, the power by {power_off}"),
        None => format!("both are as near: the power off by {power_off}, {name} by {line_off}"),
    }
}

/// A sentence's beginning.
pub(super) fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// A few lines for the terminal.
pub fn growth_table(studies: &[GrowthStudy], report: &Path) -> String {
    let mut text =
        format!("{:<11} {:>9} {:>20}  {:>16}  {:<30}\n", "study", "from", "to", "exponent", "line or logarithm");
    for study in studies {
        let fits = study.fits();
        let side = |seen: Option<&Observation>| {
            seen.map_or("-".to_owned(), |seen| format!("{}: {}", seen.x, duration(seen.seconds)))
        };
        let _ = writeln!(
            text,
            "{:<11} {:>9} {:>20}  {:>16}  {}",
            study.name,
            side(study.observations.first()),
            side(study.observations.last()),
            fits.power.map_or("-".to_owned(), |power| exponent(&power)),
            fits.affine.map_or("-".to_owned(), |line| affine(&line)),
        );
    }
    text.push('\n');
    for study in studies {
        let _ = writeln!(text, "{}: {}", study.name, nearer(&study.fits()));
    }
    text + &format!("\nreport: {}\n", report.display())
}

/// Labels of a logarithmic axis: powers of ten where there are three or more between, else what was measured.
fn ticks(study: &GrowthStudy) -> Vec<(f64, String)> {
    let counts: Vec<u64> = study.observations.iter().map(|seen| seen.x).collect();
    let most = counts.iter().copied().max().unwrap_or(1);
    if most <= 100 {
        return counts.iter().map(|x| (*x as f64, x.to_string())).collect();
    }
    let label = |k: u32| {
        if k == 0 {
            "1".to_owned()
        } else {
            format!("10{}", ["", "", "²", "³", "⁴", "⁵", "⁶", "⁷"][k as usize])
        }
    };
    (0..8).map(|k| (10f64.powi(k as i32), label(k))).collect()
}

/// Values between the ends of a study, evenly spread on a logarithmic axis.
fn between(study: &GrowthStudy) -> Vec<f64> {
    let xs = || study.observations.iter().map(|seen| seen.x as f64);
    let (low, high) = (xs().fold(f64::INFINITY, f64::min), xs().fold(0.0, f64::max));
    if low >= high || low <= 0.0 {
        return Vec::new();
    }
    (0..=96).map(|k| low * (high / low).powf(f64::from(k) / 96.0)).collect()
}

/// What a law says between the ends of a study, where that is a time.
pub(super) fn along(study: &GrowthStudy, law: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    between(study).into_iter().map(|x| (x, law(x))).filter(|pair| pair.1 > 0.0).collect()
}

/// Through the last observation in proportion to x, where that is expected.
pub(super) fn proportion(study: &GrowthStudy) -> Option<impl Fn(f64) -> f64 + use<>> {
    let last = study.observations.last().filter(|_| study.law == Law::Linear)?;
    let each = last.seconds / last.x as f64;
    Some(move |x| each * x)
}

fn chart(study: &GrowthStudy, fits: &Fits) -> Chart {
    let mut series = Vec::new();
    if let Some(law) = proportion(study) {
        series.push(Series { pairs: along(study, law), drawn: Drawn::Guide, colour: "", name: "∝ x".to_owned() });
    }
    if let Some(line) = fits.affine {
        let pairs = along(study, |x| line.at(x));
        series.push(Series { pairs, drawn: Drawn::Dashed, colour: "three", name: String::new() });
    }
    if let Some(power) = fits.power {
        let pairs = along(study, |x| power.at(x));
        series.push(Series { pairs, drawn: Drawn::Line, colour: "one", name: String::new() });
    }
    let pairs = study.observations.iter().map(|seen| (seen.x as f64, seen.seconds)).collect();
    series.push(Series { pairs, drawn: Drawn::Dots, colour: "two", name: String::new() });
    Chart { x_name: study.quantity.to_owned(), y_name: study.timed.to_owned(), x_ticks: ticks(study), series }
}

fn growth_page(studies: &[GrowthStudy]) -> String {
    let mut body = String::from(
        "<p>How the cost of an answer grows with one number of its room. Each point is the median of repeats of 20 ms or more \
         on one thread; times are those of this machine, exponents hardly are. Two laws of two numbers each are fitted by least \
         squares of relative deviations: a power of x, and a start with a part in proportion to x (of triangles that a ray \
         passes: to its logarithm). How far each is off is the root mean square over the points. Where \
         starting costs something, the power is smaller than what it tends to, and the line says more.</p>\n",
    );
    let rows: Vec<Vec<Entry>> = studies
        .iter()
        .map(|study| {
            let fits = study.fits();
            let nearer = fits.power_is_nearer();
            let of = |fitted: Option<String>, best: bool| Entry { html: fitted.unwrap_or_default(), best };
            let per_unit = study.observations.last().map(|seen| duration(seen.per_unit_ns() * 1e-9));
            vec![
                Entry::from(study.name),
                format!("{} a {}", per_unit.unwrap_or_default(), study.unit).into(),
                of(fits.power.map(|power| exponent(&power)), nearer == Some(true)),
                of(fits.power.map(|power| percent(power.off)), false),
                of(fits.affine.map(|line| affine(&line)), nearer == Some(false)),
                of(fits.affine.map(|line| percent(line.off)), false),
            ]
        })
        .collect();
    let heads = [
        "study".to_owned(),
        head("at the largest", "time"),
        head("exponent", "± standard error"),
        head("power off by", "rms"),
        head("start and step", "of what is timed"),
        head("line off by", "rms"),
    ];
    body += &table(&heads, &rows);
    body.push_str("<p class=\"note\">The nearer law is marked.</p>\n<div class=\"charts\">\n");
    for study in studies {
        let fits = study.fits();
        let Some(svg) = chart(study, &fits).svg() else { continue };
        let law = fits.power.map_or(String::new(), |power| format!("Line: x to the power of {}. ", exponent(&power)));
        let line = fits.affine.map_or(String::new(), |line| format!("Dashed: {}. ", affine(&line)));
        let dotted = if study.law == Law::Linear { "Dotted: in proportion to x. " } else { "" };
        let nearer = capital(&nearer(&fits));
        let _ = writeln!(
            body,
            "<figure><h3>{}</h3>{svg}<figcaption>{law}{line}{dotted}{nearer}.</figcaption></figure>",
            escaped(study.title),
        );
    }
    body.push_str("</div>\n<h2>What was measured</h2>\n");
    for study in studies {
        let rows: Vec<Vec<Entry>> = study
            .observations
            .iter()
            .map(|seen| {
                vec![
                    count(seen.x).into(),
                    duration(seen.seconds).into(),
                    format!("{} … {}", duration(seen.seconds_low), duration(seen.seconds_high)).into(),
                    duration(seen.per_unit_ns() * 1e-9).into(),
                    seen.repeats.to_string().into(),
                ]
            })
            .collect();
        let heads = [
            escaped(study.quantity),
            head(&escaped(study.timed), "median"),
            head("", "quickest … slowest"),
            head("time", &format!("a {}", escaped(study.unit))),
            "repeats".to_owned(),
        ];
        let _ =
            writeln!(body, "<details><summary>{}</summary>\n{}</details>", escaped(study.name), table(&heads, &rows));
    }
    page("How cost grows", &body)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Studies that follow their laws to a few percent.
    pub(in crate::report) fn made_up() -> Vec<GrowthStudy> {
        let counts: [&[u64]; 6] = [
            &[4, 16, 64, 256, 1024, 4096, 16_384, 65_536],
            &[1, 2, 4, 8, 16, 32, 64],
            &[968, 10_082, 100_352, 999_698],
            &[968, 10_082, 100_352, 999_698],
            &[1, 4, 16, 64, 256, 1024, 4096],
            &[1000, 10_000, 100_000, 1_000_000],
        ];
        let studies = GrowthStudy::NAMES.into_iter().zip(counts).enumerate();
        studies
            .map(|(k, (name, counts))| {
                let (law, start, step) = match k {
                    1 => (Law::Linear, 4e-9, 7e-10),
                    3 => (Law::Logarithmic, -4e-8, 1.5e-8),
                    _ => (Law::Linear, 6e-8, 3e-9),
                };
                let observations = counts.iter().enumerate().map(|(i, x)| {
                    let along = if law == Law::Linear { *x as f64 } else { (*x as f64).ln() };
                    let seconds = (start + step * along) * [1.0, 1.03, 0.98][i % 3];
                    let (seconds_low, seconds_high) = (0.97 * seconds, 1.1 * seconds);
                    let units = if matches!(k, 1 | 3) { 1.0 } else { *x as f64 };
                    Observation { x: *x, seconds, seconds_low, seconds_high, units, repeats: 5 }
                });
                GrowthStudy {
                    name,
                    title: "Samples: a rectangle behind a disk, one point in the penumbra, strategy random",
                    quantity: "samples N",
                    timed: "one estimate",
                    unit: "sample",
                    law,
                    observations: observations.collect(),
                }
            })
            .collect()
    }

    #[test]
    fn the_table_holds_one_observation_a_row_and_every_number_is_one() {
        let studies = made_up();
        let dir = tempfile::tempdir().unwrap();
        claim_growth(dir.path()).unwrap();
        let written = write_growth(dir.path(), &studies).unwrap();
        let mut reader = csv::Reader::from_path(dir.path().join(CSV)).unwrap();
        let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
        let due = "study quantity x timed seconds seconds_low seconds_high unit per_unit_ns repeats";
        assert_eq!(header, due.split(' ').collect::<Vec<_>>());
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        let observations: Vec<_> = studies.iter().flat_map(|s| s.observations.iter().map(move |o| (s, o))).collect();
        assert_eq!(rows.len(), observations.len());
        for (row, (study, seen)) in rows.iter().zip(observations) {
            assert_eq!((&row[0], row[2].parse()), (study.name, Ok(seen.x)));
            assert_eq!(row[4].parse(), Ok(seen.seconds));
            let per_unit: f64 = row[8].parse().unwrap();
            assert!((per_unit * seen.units / (1e9 * seen.seconds) - 1.0).abs() < 1e-14);
        }
        // The next run's claim knows every file.
        assert!(written.iter().all(|path| path.is_file()));
        if cfg!(feature = "plots") {
            assert_eq!(written.len(), 2 + 2 * studies.len());
        }
        let foreign = dir.path().join("plots/holiday.png");
        std::fs::write(&foreign, "x").unwrap();
        claim_growth(dir.path()).unwrap();
        assert!(written.iter().all(|path| !path.exists()) && foreign.exists());
    }

    #[test]
    fn the_page_tells_each_law_and_shows_each_chart() {
        let mut studies = made_up();
        studies[0].title = "a <b> & c";
        let html = growth_page(&studies);
        assert!(html.contains("a &lt;b&gt; &amp; c") && !html.contains("<b>"));
        assert_eq!(html.matches("<svg").count(), studies.len());
        for study in &studies {
            assert!(html.contains(&exponent(&study.fits().power.unwrap())), "{}", study.name);
        }
        assert!(html.contains("The logarithm is nearer") && !html.contains("NaN"));
        for word in ["http:", "https:", "src=", "href=", "url(", "<script"] {
            assert!(!html.contains(word), "{word}");
        }
    }

    #[test]
    fn too_few_sizes_are_shown_without_a_law() {
        let mut studies = made_up();
        studies.iter_mut().for_each(|study| study.observations.truncate(1));
        assert!(growth_page(&studies).contains("Too few sizes for a law"));
        assert!(growth_table(&studies, Path::new("x")).contains("samples"));
        let dir = tempfile::tempdir().unwrap();
        claim_growth(dir.path()).unwrap();
        write_growth(dir.path(), &studies).unwrap();
    }

    #[test]
    #[ignore = "writes a report for people to look at, into the system's folder for passing files"]
    fn made_up_growth_to_look_at() {
        let dir = std::env::temp_dir().join("etendue-growth");
        claim_growth(&dir).unwrap();
        write_growth(&dir, &made_up()).unwrap();
        println!("{}", growth_table(&made_up(), &dir));
    }
}
