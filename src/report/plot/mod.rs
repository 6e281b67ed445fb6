//! Plots of a report, as SVG and PNG: variance curves, bias, profiles and maps, correlation; caustics and
//! ledgers.
//!
//! A plot is first a [`Page`](ink::Page) of marks in points; the same page is drawn as SVG and, by plotters, as pixels.

mod axis;
mod bias;
mod caustic;
mod correlation;
mod energy;
mod growth;
mod ink;
mod lecture;
mod map;
mod panel;
mod picture;
mod pixels;
mod profile;
mod raster;
mod render;
mod style;
mod svg;
mod texels;
mod text;
mod variance;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::ReportError;
use super::folder::{PLOT_KINDS, file_stems, write_whole};
use super::image::Rgb;
use super::record::{CaseRecord, ReportRecord};
use crate::trial::{GrowthStudy, Lecture, ReceiverPicture};

pub(super) use picture::encoded as picture_of;
pub(super) use raster::Scale;

/// Draws all plots of all cases, cases in parallel. Returns the files in the order of the cases.
pub(super) fn write_all(dir: &Path, report: &ReportRecord) -> Result<Vec<PathBuf>, ReportError> {
    std::fs::create_dir_all(dir).map_err(|source| ReportError::Folder { path: dir.to_owned(), source })?;
    let stems = file_stems(report.cases.iter().map(|c| c.name.as_str()));
    let written: Vec<Result<Vec<PathBuf>, ReportError>> =
        report.cases.par_iter().zip(&stems).map(|(case, stem)| write_case(dir, stem, case)).collect();
    let by_case: Result<Vec<Vec<PathBuf>>, ReportError> = written.into_iter().collect();
    Ok(by_case?.into_iter().flatten().collect())
}

/// What is drawn of a case, in the order of [`PLOT_KINDS`].
const PLOTS: [fn(&CaseRecord) -> Option<ink::Page>; 8] = [
    variance::variance,
    bias::bias,
    profile::profile,
    map::map,
    correlation::correlation,
    caustic::caustic,
    energy::energy,
    texels::texels,
];

/// Draws all that is drawn of a case, and keeps nothing.
#[cfg(any(fuzzing, test))]
pub(super) fn try_all(case: &CaseRecord, pixels: bool) {
    for page in PLOTS.into_iter().filter_map(|draw| draw(case)) {
        svg::svg(&page);
        if pixels {
            let _ = drawn_picture(&page);
        }
    }
}

fn write_case(dir: &Path, stem: &str, case: &CaseRecord) -> Result<Vec<PathBuf>, ReportError> {
    let mut written = Vec::new();
    for (draw, kind) in PLOTS.into_iter().zip(PLOT_KINDS) {
        let Some(page) = draw(case) else { continue };
        for (format, bytes) in [("svg", svg(&page)), ("png", png(&page))] {
            let name = format!("{stem}-{kind}.{format}");
            let bytes = bytes.map_err(|reason| ReportError::Plot { path: dir.join(&name), reason })?;
            written.push(write_whole(dir, &name, &bytes)?);
        }
    }
    Ok(written)
}

/// How one cost grows, in each format; nothing where nothing was measured.
pub(super) fn growth_files(study: &GrowthStudy) -> Vec<(&'static str, Result<Vec<u8>, String>)> {
    let page = growth::growth(study);
    page.iter().flat_map(|page| [("svg", svg(page)), ("png", png(page))]).collect()
}

/// The page as SVG.
fn svg(page: &ink::Page) -> Result<Vec<u8>, String> {
    Ok(svg::svg(page).into_bytes())
}

/// The page as PNG.
fn png(page: &ink::Page) -> Result<Vec<u8>, String> {
    let (pixels, size) = pixels::drawn(page)?;
    picture::encoded(&pixels, size)
}

/// A page with pictures on it: pixels, width and height.
pub(super) type Drawn = (Vec<Rgb>, [usize; 2]);

fn drawn_picture(page: &ink::Page) -> Result<Drawn, String> {
    let (pixels, (width, height)) = pixels::drawn(page)?;
    Ok((pixels.as_chunks::<3>().0.to_vec(), [width as usize, height as usize]))
}

/// A rendered receiver beside its exact picture.
pub(super) fn page_of_receiver(receiver: &ReceiverPicture) -> Result<Drawn, String> {
    drawn_picture(&render::receiver(receiver))
}

/// The figures of the lecture: file name, what they show, the page.
pub(super) fn lecture_pages(lecture: &Lecture) -> Vec<(&'static str, &'static str, Result<Drawn, String>)> {
    let pages = lecture::pages(lecture).into_iter();
    pages.map(|(name, words, page)| (name, words, drawn_picture(&page))).collect()
}
