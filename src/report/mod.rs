//! Reports: what a run found, as tables, plots and words. A report shows; it decides nothing.
//!
//! - [`claim`] finds an unwritable folder before the work starts;
//! - [`write`](fn@write) fills it: CSV tables, `manifest.json`, and plots (feature `plots`);
//! - [`write_calibration`] does the same for a calibration of the gate, [`write_growth`] for how cost grows;
//! - `write_pictures` and `write_lecture` write rendered pictures (feature `plots`);
//! - [`table`] tells the verdicts on a terminal; [`write_exact`] prints exact values, [`write_limits`] shadow limits;
//! - [`verdicts_json`], [`case_json_lines`] and `verdicts_junit` (feature `cli`) tell them to programs;
//! - [`read`] reads a report back; [`comparison_text`] tells what changed between two;
//! - [`write_images`] and [`images_table`] tell what came of images of other renderers; [`write_files`] writes a scene for one.
//!
//! The meaning of every column is in `reports/README.md`, which [`column_reference`] writes. Everything but
//! `timings.csv` and `timings.html` is the same from run to run, byte for byte.

mod calibration;
mod column;
mod comparison;
mod converge;
mod curves;
mod error;
mod exact;
#[cfg(feature = "plots")]
mod exr;
mod folder;
mod forecast;
mod growth;
#[cfg(feature = "plots")]
mod image;
mod images;
mod index;
#[cfg(feature = "cli")]
mod junit;
mod light;
mod limits;
mod machine;
mod manifest;
mod page;
mod paths;
#[cfg(feature = "plots")]
mod plot;
mod read;
mod record;
#[cfg(feature = "plots")]
mod render;
mod scene;
mod tables;
mod terminal;
mod timings;
#[cfg(feature = "plots")]
mod views;

#[cfg(test)]
mod made_up;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use crate::trial::{ReceiverViews, RunOutcome};

use self::record::{Place, ReportRecord};

pub use calibration::{calibration_reference, calibration_table, claim_calibration, write_calibration};
pub use comparison::{ComparisonFormat, comparison_text};
pub use converge::{convergence_table, write_convergence};
pub use error::ReportError;
pub use exact::{ExactCase, write_exact};
pub use folder::{claim, probe};
pub use forecast::{forecast_json, forecast_table};
pub use growth::{claim_growth, growth_table, write_growth};
pub use images::{claim_images, images_table, write_files, write_images};
#[cfg(feature = "cli")]
pub use junit::verdicts_junit;
pub use limits::{LimitsCase, write_limits};
pub use machine::{case_json_lines, summary_json_line, verdicts_json};
pub use read::read;
#[cfg(feature = "plots")]
pub use render::{
    CasePictures, WrittenPicture, claim_pictures, listed, pictures_table, write_lecture, write_pictures,
};
pub use terminal::{TableOptions, table};

/// How a report is written.
#[derive(Clone, Copy, Debug)]
pub struct ReportOptions<'a> {
    /// The random number generator and how its streams are keyed, for the manifest.
    pub generator: &'a str,
    /// Whether plots are drawn; without the feature `plots` none are.
    pub plots: bool,
    /// Pictures of receivers, of the cases that have some; without the feature `plots` none are written.
    pub views: &'a [ReceiverViews],
    /// Whether the report will be written anew while people look at it: then the page loads itself again and again.
    pub watched: bool,
}

/// Writes the whole report into a folder, which is made if need be; [`claim`] it first so that no file of an earlier
/// run stays. Returns the files written: tables, plots by case, the manifest last.
///
/// - `outcome`: every case has one truth for each point, every cell one measurement for each point
pub fn write(dir: &Path, outcome: &RunOutcome, options: &ReportOptions) -> Result<Vec<PathBuf>, ReportError> {
    for case in &outcome.cases {
        let counts = |n: usize| assert_eq!(n, case.points.len(), "{}: one entry for each point", case.name);
        counts(case.truths.len());
        case.strategies.iter().flat_map(|s| &s.cells).for_each(|cell| counts(cell.points.len()));
    }
    std::fs::create_dir_all(dir).map_err(|source| ReportError::Folder { path: dir.to_owned(), source })?;
    let mut written = Vec::new();
    let mut files = csv_files(outcome)?;
    for (name, content) in &files {
        written.push(folder::write_whole(dir, name, content)?);
    }
    written.push(folder::write_whole(dir, timings::FILE, timings::page(outcome).as_bytes())?);
    files.push(("manifest.json", manifest::manifest(outcome, options.generator).into_bytes()));
    let mut record = record::read(Place::Memory(&files));
    let (name, content) = files.last().expect("the manifest was pushed");
    written.push(folder::write_whole(dir, name, content)?);
    drop(files);
    #[cfg(feature = "plots")]
    written.extend(views::write(dir, &record.cases, options.views)?);
    let shown = show(dir, &mut record, options.plots, options.watched)?;
    if let Some(fault) = shown.unread.into_iter().next() {
        return Err(fault);
    }
    written.extend(shown.written);
    Ok(written)
}

/// A report made anew from its tables: which files were written, and what was missing or could not be read, a sentence each.
#[derive(Clone, Debug)]
pub struct Rebuilt {
    pub written: Vec<PathBuf>,
    pub faults: Vec<String>,
}

/// Makes plots and page of a report from its tables alone. What is not there is told and left out.
pub fn rebuild(dir: &Path, plots: bool) -> Result<Rebuilt, ReportError> {
    if !dir.is_dir() {
        return Err(ReportError::NoReport { path: dir.to_owned(), missing: None });
    }
    let mut record = record::read(Place::Folder(dir));
    if record.cases.is_empty() {
        return Err(ReportError::NoReport {
            path: dir.to_owned(),
            missing: Some("any table with a case".to_owned()),
        });
    }
    if plots {
        folder::claim_plots(dir)?;
    }
    let shown = show(dir, &mut record, plots, false)?;
    Ok(Rebuilt { written: shown.written, faults: record.faults })
}

/// What was made of a report's tables.
struct Shown {
    written: Vec<PathBuf>,
    /// Pictures that are there and could not be read: the page stands without them, and says so.
    unread: Vec<ReportError>,
}

/// Plots and page, from what the tables tell.
fn show(dir: &Path, record: &mut ReportRecord, plots: bool, watched: bool) -> Result<Shown, ReportError> {
    let mut written: Vec<PathBuf> = Vec::new();
    #[cfg(feature = "plots")]
    if plots {
        written.extend(plot::write_all(&dir.join(folder::PLOTS), record)?);
    }
    #[cfg(not(feature = "plots"))]
    let _ = plots;
    let names: Vec<String> = written.iter().filter_map(|path| Some(path.file_name()?.to_str()?.to_owned())).collect();
    let stems = folder::file_stems(record.cases.iter().map(|case| case.name.as_str()));
    let of_case = |k: usize| {
        let kinds = folder::PLOT_KINDS.iter().map(|kind| format!("{}-{kind}.svg", stems[k]));
        kinds.filter(|name| names.contains(name)).collect()
    };
    let (pictures, unread) = pictures(dir, record, &stems);
    record.faults.extend(unread.iter().map(|fault| format!("{fault}.")));
    let beside = index::Beside { plots: &of_case, pictures: &pictures, watched };
    written.push(folder::write_whole(dir, index::FILE, index::page(record, &beside).as_bytes())?);
    Ok(Shown { written, unread })
}

/// Of each case: pictures by name, as PNG; and those that are there and could not be read.
#[cfg(feature = "plots")]
fn pictures(dir: &Path, record: &ReportRecord, stems: &[String]) -> (Vec<index::Pictures>, Vec<ReportError>) {
    let mut unread = Vec::new();
    let of_cases = record.cases.iter().zip(stems).map(|(case, stem)| views::of_case(dir, stem, case, &mut unread));
    (of_cases.collect(), unread)
}
#[cfg(not(feature = "plots"))]
fn pictures(_: &Path, record: &ReportRecord, _: &[String]) -> (Vec<index::Pictures>, Vec<ReportError>) {
    (vec![Vec::new(); record.cases.len()], Vec::new())
}

/// The name of a file of a report.
#[cfg(any(fuzzing, test))]
pub(crate) fn file_named(name: &str) -> Option<&'static str> {
    folder::FILES.into_iter().find(|known| *known == name)
}

/// Makes the page of a report that lies in memory, compares it with itself, and keeps nothing.
#[cfg(any(fuzzing, test))]
pub(crate) fn try_page(files: &[(&'static str, Vec<u8>)]) {
    let record = record::read(Place::Memory(files));
    let pictures = vec![Vec::new(); record.cases.len()];
    let beside = index::Beside { plots: &|_| Vec::new(), pictures: &pictures, watched: false };
    index::page(&record, &beside);
    if let Ok(record) = read::read_from(Place::Memory(files)) {
        let comparison = crate::trial::compare(&record, &record, &None);
        for format in [ComparisonFormat::Text, ComparisonFormat::Markdown, ComparisonFormat::Json] {
            comparison_text(&comparison, ["before", "after"], [&record, &record], format, true);
        }
    }
}

/// Draws the plots of a report that lies in memory, and keeps nothing.
///
/// - `pixels`: as pictures, too
#[cfg(all(feature = "plots", any(fuzzing, test)))]
pub(crate) fn try_plots(files: &[(&'static str, Vec<u8>)], pixels: bool) {
    record::read(Place::Memory(files)).cases.iter().for_each(|case| plot::try_all(case, pixels));
}

/// The tables, in memory: nothing is written while any of them cannot be.
fn csv_files(outcome: &RunOutcome) -> Result<Vec<(&'static str, Vec<u8>)>, ReportError> {
    fn filled<R>(
        table: column::Table<R>,
        rows: impl Iterator<Item = R>,
    ) -> Result<(&'static str, Vec<u8>), ReportError> {
        let mut content = Vec::new();
        table.write(rows, &mut content)?;
        Ok((table.file, content))
    }
    Ok(vec![
        filled(tables::convergence(), tables::convergence_rows(outcome))?,
        filled(curves::means(), curves::mean_rows(outcome))?,
        filled(tables::rates(), tables::rate_rows(outcome))?,
        filled(curves::curves(), curves::curve_rows(outcome))?,
        filled(tables::correlation(), tables::correlation_rows(outcome))?,
        filled(light::energy(), light::energy_rows(outcome))?,
        filled(light::caustic(), light::caustic_rows(outcome))?,
        filled(light::texels(), light::texel_rows(outcome))?,
        filled(paths::paths(), paths::path_rows(outcome))?,
        filled(scene::scene(), scene::scene_rows(outcome))?,
        filled(tables::verdicts(), tables::verdict_rows(outcome))?,
        filled(tables::timings(), tables::timing_rows(outcome))?,
    ])
}

/// The meaning of every column of every table, as Markdown: the text of `reports/README.md`.
pub fn column_reference() -> String {
    let head = "\
# Reports

A run of `etendue` writes a folder like this one: tables (CSV), plots, and `manifest.json` (version, seed, generator,
the command, and a digest of each case). Everything but `timings.csv` and its page
`timings.html` is the same from run to run, byte for byte.

Tables are in long format, one observation a row: comma-separated, `.` as decimal mark, full round-trip digits. A field
is empty where a number has no meaning; none is ever NaN or infinite. *(This page is written by the code that writes
the tables.)*
";
    [
        head.to_owned(),
        tables::convergence().described(),
        curves::means().described(),
        tables::rates().described(),
        curves::curves().described(),
        tables::correlation().described(),
        light::energy().described(),
        light::caustic().described(),
        light::texels().described(),
        paths::paths().described(),
        scene::scene().described(),
        tables::verdicts().described(),
        tables::timings().described(),
        exact::exact().described(),
        limits::limits().described(),
        images::pixels().described(),
        images::regions().described(),
        converge::levels().described(),
        converge::points().described(),
        growth::growth().described(),
    ]
    .join("\n")
}
