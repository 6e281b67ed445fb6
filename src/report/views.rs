//! The pictures of receivers beside a report's page: written as PNG, found again by their names.

use std::path::{Path, PathBuf};

use super::ReportError;
use super::folder::{VIEW_ENDING, VIEWS, file_stems, write_whole};
use super::image::{self, Rgb, Tone, quantile};
use super::plot::Scale;
use super::record::CaseRecord;
use crate::intake::VIEW_BYTES;
use crate::trial::ReceiverViews;

/// Errors are shown up to what all but one in two hundred stay below.
const SHOWN: f64 = 0.995;

/// Writes the pictures of all cases of a report that have some.
pub(super) fn write(dir: &Path, cases: &[CaseRecord], views: &[ReceiverViews]) -> Result<Vec<PathBuf>, ReportError> {
    if views.is_empty() {
        return Ok(Vec::new());
    }
    let dir = dir.join(VIEWS);
    std::fs::create_dir_all(&dir).map_err(|source| ReportError::Folder { path: dir.clone(), source })?;
    let stems = file_stems(cases.iter().map(|case| case.name.as_str()));
    let mut written = Vec::new();
    for (case, stem) in cases.iter().zip(&stems) {
        let Some(of_case) = views.iter().find(|views| views.case == case.name) else { continue };
        let tone = Scale::Tone(Tone::of(of_case.exact.iter().flatten().copied()));
        let errors: Vec<(&str, Vec<Option<f64>>)> = of_case
            .estimates
            .iter()
            .map(|(strategy, values)| {
                let error = values.iter().zip(&of_case.exact).map(|(value, exact)| Some((*value)? - (*exact)?));
                (strategy.name(), error.collect())
            })
            .collect();
        let sizes = errors.iter().flat_map(|(_, error)| error).flatten().map(|error| error.abs());
        let signed = Scale::Signed { largest: quantile(sizes, SHOWN).filter(|error| *error > 0.0).unwrap_or(1.0) };
        let exact = [("exact".to_owned(), &of_case.exact, tone)];
        let estimates = of_case.estimates.iter().map(|(strategy, values)| (strategy.name().to_owned(), values, tone));
        let errors = errors.iter().map(|(name, error)| (format!("{name}-error"), error, signed));
        for (name, values, scale) in exact.into_iter().chain(estimates).chain(errors) {
            let file = format!("{stem}-{name}{VIEW_ENDING}");
            let colours: Vec<Rgb> = values.iter().map(|value| scale.colour(*value)).collect();
            let png = image::png(&colours, of_case.size, &[]);
            let png = png.map_err(|reason| ReportError::Plot { path: dir.join(&file), reason })?;
            written.push(write_whole(&dir, &file, &png)?);
        }
    }
    Ok(written)
}

/// The pictures of one case that a report's folder has, each with what it shows: exact, estimates, errors.
pub(super) fn of_case(dir: &Path, stem: &str, case: &CaseRecord) -> Vec<(String, Vec<u8>)> {
    // Something else may lie under such a name: a pipe would be waited for, a page would show it broken.
    let of = |name: &str| {
        let path = dir.join(VIEWS).join(format!("{stem}-{name}{VIEW_ENDING}"));
        let what = std::fs::metadata(&path).ok().filter(|what| what.is_file() && what.len() <= VIEW_BYTES);
        what.and_then(|_| std::fs::read(path).ok())
    };
    let png = |name: &str| of(name).filter(|bytes| bytes.starts_with(b"\x89PNG\r\n\x1a\n"));
    let exact = png("exact").map(|bytes| ("exact".to_owned(), bytes));
    // A guest may be called what a picture is.
    let own = || case.strategies.iter().filter(|made| made.known().is_some());
    let names = || own().map(|made| made.name.as_str());
    let shown = super::index::shown;
    let estimates = names().filter_map(|name| Some((shown(name), png(name)?)));
    let errors =
        names().filter_map(|name| Some((format!("error of {}", shown(name)), png(&format!("{name}-error"))?)));
    exact.into_iter().chain(estimates).chain(errors).collect()
}
