//! The pictures of receivers beside a report's page: written as PNG, found again by their names.

use std::io;
use std::path::{Path, PathBuf};

use super::ReportError;
use super::folder::{VIEW_ENDING, VIEWS, file_stems, write_whole};
use super::image::{self, Rgb, Tone, quantile};
use super::index::Pictures;
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

/// The pictures of one case that a report's folder has, each with what it shows: exact, estimates, errors. What lies under
/// such a name and is none is left out, and told.
pub(super) fn of_case(dir: &Path, stem: &str, case: &CaseRecord, faults: &mut Vec<ReportError>) -> Pictures {
    let mut png = |name: &str| {
        let path = dir.join(VIEWS).join(format!("{stem}-{name}{VIEW_ENDING}"));
        picture(&path).unwrap_or_else(|source| {
            faults.push(ReportError::Unreadable { path, source });
            None
        })
    };
    let shown = super::index::shown;
    // A guest may be called what a picture is.
    let names: Vec<&str> =
        case.strategies.iter().filter(|made| made.known().is_some()).map(|made| made.name.as_str()).collect();
    let mut pictures: Pictures = png("exact").map(|bytes| ("exact".to_owned(), bytes)).into_iter().collect();
    pictures.extend(names.iter().filter_map(|name| Some((shown(name), png(name)?))));
    let error = |name: &&str| Some((format!("error of {}", shown(name)), png(&format!("{name}-error"))?));
    pictures.extend(names.iter().filter_map(error));
    pictures
}

/// `None` where there is nothing under its name.
fn picture(path: &Path) -> io::Result<Option<Vec<u8>>> {
    let what = match std::fs::metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        what => what?,
    };
    // A pipe would be waited for, a page would show it broken.
    if !what.is_file() {
        return Err(io::Error::other("it is no file"));
    }
    if what.len() > VIEW_BYTES {
        return Err(io::Error::other(format!("it holds {} bytes; at most {VIEW_BYTES} are read", what.len())));
    }
    let bytes = std::fs::read(path)?;
    image::check(&bytes).map_err(io::Error::other)?;
    Ok(Some(bytes))
}
