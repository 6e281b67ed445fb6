//! Plots of a report, as SVG and PNG: variance curves, bias, profiles and maps, correlation; caustics and
//! ledgers.
//!
//! A plot is first a [`Page`](ink::Page) of marks in points; plotters draws the same page as SVG and as pixels.

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
mod profile;
mod raster;
mod render;
mod style;
mod texels;
mod text;
mod variance;

use std::path::{Path, PathBuf};

use plotters::prelude::*;
use rayon::prelude::*;

use super::ReportError;
use super::folder::{PLOT_KINDS, file_stems, write_whole};
use super::image::Rgb;
use super::record::{CaseRecord, ReportRecord};
use crate::trial::{GrowthStudy, Lecture, ReceiverPicture};

pub(super) use picture::encoded as picture_of;
pub(super) use raster::Scale;

/// Pixels of a PNG, and units of an SVG, for each point of a page.
const PIXELS: f64 = 2.0;
const UNITS: f64 = 8.0;

/// Draws all plots of all cases, cases in parallel. Returns the files in the order of the cases.
pub(super) fn write_all(dir: &Path, report: &ReportRecord) -> Result<Vec<PathBuf>, ReportError> {
    std::fs::create_dir_all(dir).map_err(|source| ReportError::Folder { path: dir.to_owned(), source })?;
    let stems = file_stems(report.cases.iter().map(|c| c.name.as_str()));
    let written: Vec<Result<Vec<PathBuf>, ReportError>> =
        report.cases.par_iter().zip(&stems).map(|(case, stem)| write_case(dir, stem, case)).collect();
    let by_case: Result<Vec<Vec<PathBuf>>, ReportError> = written.into_iter().collect();
    Ok(by_case?.into_iter().flatten().collect())
}

fn write_case(dir: &Path, stem: &str, case: &CaseRecord) -> Result<Vec<PathBuf>, ReportError> {
    let draw: [fn(&CaseRecord) -> Option<ink::Page>; 8] = [
        variance::variance,
        bias::bias,
        profile::profile,
        map::map,
        correlation::correlation,
        caustic::caustic,
        energy::energy,
        texels::texels,
    ];
    let mut written = Vec::new();
    for (draw, kind) in draw.into_iter().zip(PLOT_KINDS) {
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

/// The page as SVG. Coordinates are whole eighths of a point: plotters counts in integers.
fn svg(page: &ink::Page) -> Result<Vec<u8>, String> {
    text::load_font();
    let mut text = String::new();
    let size = ((page.width * UNITS) as u32, (page.height * UNITS) as u32);
    page.draw(&SVGBackend::with_string(&mut text, size).into_drawing_area(), UNITS, ink::Medium::Svg)?;
    let finer = format!("width=\"{}\" height=\"{}\"", size.0, size.1);
    let shown = format!("width=\"{}\" height=\"{}\"", page.width, page.height);
    Ok(text.replacen(&finer, &shown, 1).into_bytes())
}

/// The page as PNG.
fn png(page: &ink::Page) -> Result<Vec<u8>, String> {
    let (pixels, size) = drawn(page)?;
    picture::encoded(&pixels, size)
}

/// The page as RGB, `[height][width][3]`, with its width and height.
fn drawn(page: &ink::Page) -> Result<(Vec<u8>, (u32, u32)), String> {
    let size = ((page.width * PIXELS) as u32, (page.height * PIXELS) as u32);
    let mut pixels = vec![0; 3 * (size.0 * size.1) as usize];
    page.draw(&BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area(), PIXELS, ink::Medium::Pixels)?;
    text::set_texts(&mut pixels, size.0 as usize, PIXELS, page.texts());
    Ok((pixels, size))
}

/// A page with pictures on it: pixels, width and height.
pub(super) type Drawn = (Vec<Rgb>, [usize; 2]);

fn drawn_picture(page: &ink::Page) -> Result<Drawn, String> {
    let (pixels, (width, height)) = drawn(page)?;
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
