//! Judged images: every pixel and every region as tables, the verdicts as JSON and JUnit, maps of z and of the difference.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::ReportError;
use super::column::{Column, Table};
use super::folder::{claim_files, write_whole};
use super::page::escaped;
use crate::statistics::Verdict;
use crate::statistics::evidence::THRESHOLD_LOG10;
use crate::trial::{ImagesOutcome, JudgedProperty, Part, Pixel};

/// Files of a report on images.
const FILES: [&str; 6] = ["pixels.csv", "regions.csv", "verdict.json", "junit.xml", "z.png", "difference.png"];

/// Makes the folder and removes the files of an earlier report on images.
pub fn claim_images(dir: &Path) -> Result<(), ReportError> {
    claim_files(dir, &FILES)
}

/// Writes the whole report. Returns the files written.
pub fn write_images(dir: &Path, outcome: &ImagesOutcome) -> Result<Vec<PathBuf>, ReportError> {
    let mut tables: Vec<(&str, Vec<u8>)> = Vec::new();
    let mut content = Vec::new();
    let rows = outcome.pixels.iter().enumerate().map(|(p, pixel)| PixelRow { outcome, p, pixel });
    pixels().write(rows, &mut content)?;
    tables.push(("pixels.csv", std::mem::take(&mut content)));
    regions().write(outcome.parts.iter().map(|part| (outcome, part)), &mut content)?;
    tables.push(("regions.csv", content));
    tables.push(("verdict.json", json_of(outcome).into_bytes()));
    tables.push(("junit.xml", junit(&outcome.case, &outcome.name, &outcome.verdicts).into_bytes()));
    #[cfg(feature = "plots")]
    for (name, map) in [("z.png", z_map(outcome)), ("difference.png", difference_map(outcome))] {
        let bytes = super::plot::picture_of(&map.pixels, map.size);
        let bytes = bytes.map_err(|reason| ReportError::Plot { path: dir.join(name), reason })?;
        tables.push((name, bytes));
    }
    tables.iter().map(|(name, content)| write_whole(dir, name, content)).collect()
}

/// Writes files of an export, in their order.
pub fn write_files(dir: &Path, files: &[(String, Vec<u8>)]) -> Result<Vec<PathBuf>, ReportError> {
    claim_files(dir, &[])?;
    files.iter().map(|(name, content)| write_whole(dir, name, content)).collect()
}

pub(super) struct PixelRow<'a> {
    outcome: &'a ImagesOutcome,
    p: usize,
    pixel: &'a Pixel,
}

/// What stands for a region: one name, or `edge`.
fn region_name(pixel: &Pixel) -> &'static str {
    pixel.truth.region.map_or("edge", |region| region.name())
}

pub(super) fn column<R>(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    value: fn(&R) -> super::column::Field,
) -> Column<R> {
    Column { name, unit, meaning, value }
}

pub(super) fn pixels<'a>() -> Table<PixelRow<'a>> {
    Table {
        file: "pixels.csv",
        row: "one pixel of judged images (`verify`)",
        columns: vec![
            column("column", "", "counted from 0, from the left", |r| (r.p % r.outcome.width).into()),
            column("row", "", "counted from 0, from the top", |r| (r.p / r.outcome.width).into()),
            column("x_m", "m", "middle of its footprint", |r| r.outcome.places[r.p][0].into()),
            column("y_m", "m", "", |r| r.outcome.places[r.p][1].into()),
            column("z_m", "m", "", |r| r.outcome.places[r.p][2].into()),
            column(
                "region",
                "",
                "what all of the footprint sees; `edge` where a shadow's edge runs through it or within the ray epsilon",
                |r| region_name(r.pixel).into(),
            ),
            column("exact_irradiance_W_m2", "W/m²", "mean over the footprint", |r| r.pixel.truth.irradiance.into()),
            column("exact_bound_W_m2", "W/m²", "error of that mean", |r| r.pixel.truth.bound.into()),
            column("mean_irradiance_W_m2", "W/m²", "mean over the images", |r| r.pixel.mean.into()),
            column(
                "std_error_W_m2",
                "W/m²",
                "of the mean over the images, from the spread of the neighbourhood; 0 where nothing spreads",
                |r| r.pixel.std_error.into(),
            ),
            column("z", "", "deviation in standard errors; it decides nothing", |r| r.pixel.z().into()),
        ],
        more: &[],
        case: |r| &r.outcome.case,
    }
}

pub(super) fn regions<'a>() -> Table<(&'a ImagesOutcome, &'a Part)> {
    Table {
        file: "regions.csv",
        row: "one region of judged images (`verify`)",
        columns: vec![
            column("case", "", "name of the case", |(o, _)| o.case.as_str().into()),
            column("judged", "", "who made the images", |(o, _)| o.name.as_str().into()),
            column("region", "", "`all`, or what the pixels see", |(_, part)| part.name.into()),
            column("pixels", "", "how many there are", |(_, part)| part.n_pixels.into()),
            column("images", "", "how many there are", |(o, _)| o.n_images.into()),
            column("exact_irradiance_W_m2", "W/m²", "mean over these pixels", |(_, part)| part.exact.into()),
            column("exact_bound_W_m2", "W/m²", "mean error of their exact means", |(_, part)| {
                part.exact_bound.into()
            }),
            column("mean_irradiance_W_m2", "W/m²", "mean over pixels and images", |(_, part)| part.mean.into()),
            column("std_error_W_m2", "W/m²", "of that mean, if pixels are independent", |(_, part)| {
                part.std_error.into()
            }),
            column("chi_square", "", "mean of z² over the pixels that spread; about 1", |(_, part)| {
                part.chi_square.into()
            }),
            column("evidence", "", "log10 of the capital against the mean of these pixels", |(_, part)| {
                part.evidence.into()
            }),
        ],
        more: &[],
        case: |(o, _)| &o.case,
    }
}

pub(super) fn word(verdict: Option<Verdict>) -> &'static str {
    match verdict {
        Some(Verdict::Pass) => "pass",
        Some(Verdict::Fail) => "fail",
        Some(Verdict::Undecided) => "undecided",
        None => "none",
    }
}

/// What documents say of one verdict; numbers that are not finite are left out.
pub(super) fn verdict_json(judged: &JudgedProperty) -> serde_json::Value {
    json!({
        "property": judged.property,
        "verdict": word(Some(judged.verdict)),
        "evidence_log10": judged.evidence,
        "threshold_log10": THRESHOLD_LOG10,
        "effect": judged.effect,
        "effect_low": judged.effect_low,
        "effect_high": judged.effect_high,
        "smallest_bias_mean": judged.smallest_bias_mean,
        "smallest_bias_place": judged.smallest_bias_point,
        "words": judged.words,
        "note": judged.note,
        "reproduce": judged.reproduce,
    })
}

/// A document of plain values.
pub(super) fn document(value: &serde_json::Value) -> String {
    // It always has a text.
    serde_json::to_string_pretty(value).unwrap_or_default() + "\n"
}

fn json_of(outcome: &ImagesOutcome) -> String {
    let verdicts: Vec<_> = outcome.verdicts.iter().map(verdict_json).collect();
    let cause = outcome.cause.as_ref();
    let document = json!({
        "schema_version": 1,
        "case": outcome.case,
        "judged": outcome.name,
        "verdict": word(outcome.verdict()),
        "images": outcome.n_images,
        "width": outcome.width,
        "height": outcome.height,
        "samples_per_pixel": outcome.samples_per_pixel,
        "ray_epsilon_m": outcome.ray_epsilon,
        "exact_bound_over_std_error": { "mean": outcome.footprint_error[0], "worst_pixel": outcome.footprint_error[1] },
        "neighbour_correlation": outcome.neighbour_correlation,
        "image_correlation": outcome.image_correlation,
        "verdicts": verdicts,
        "cause": cause.map(|cause| json!({ "name": cause.name, "words": cause.words, "explained": cause.explained })),
        "notes": outcome.notes,
    });
    self::document(&document)
}

/// JUnit's form: a test case for each verdict.
pub(super) fn junit(case: &str, name: &str, verdicts: &[JudgedProperty]) -> String {
    let count = |verdict| verdicts.iter().filter(|judged| judged.verdict == verdict).count();
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"{}\">\n",
        escaped(case),
        verdicts.len(),
        count(Verdict::Fail),
        count(Verdict::Undecided)
    );
    for judged in verdicts {
        let (class, name, words) = (escaped(case), escaped(name), escaped(&judged.words));
        text += &format!("    <testcase classname=\"{class}\" name=\"{name}: {}\"", judged.property);
        text += &match judged.verdict {
            Verdict::Pass => "/>\n".to_owned(),
            Verdict::Fail => format!(">\n      <failure message=\"{words}\"/>\n    </testcase>\n"),
            Verdict::Undecided => format!(">\n      <skipped message=\"{words}\"/>\n    </testcase>\n"),
        };
    }
    text + "  </testsuite>\n</testsuites>\n"
}

/// What the terminal is told of one verdict.
pub(super) fn verdict_lines(judged: &JudgedProperty) -> String {
    let name = word(Some(judged.verdict)).to_uppercase();
    let note = judged.note.as_ref().map_or(String::new(), |note| format!("           {note}\n"));
    format!("{name:<9}  {}: {}\n{note}", judged.property, judged.words)
}

/// What the terminal is told.
pub fn images_table(outcome: &ImagesOutcome, report: Option<&Path>) -> String {
    let mut text = format!(
        "{}: {}, {} image{} of {} x {} pixels, {} samples a pixel\n\n",
        outcome.case,
        outcome.name,
        outcome.n_images,
        if outcome.n_images == 1 { "" } else { "s" },
        outcome.width,
        outcome.height,
        outcome.samples_per_pixel
    );
    text += &format!(
        "  {:<14} {:>7}  {:>12}  {:>12}  {:>9}  {:>7}\n",
        "region", "pixels", "exact W/m2", "mean W/m2", "z", "chi2/n"
    );
    for part in &outcome.parts {
        let z =
            (part.std_error > 0.0 && outcome.verdict().is_some()).then(|| (part.mean - part.exact) / part.std_error);
        let shown = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.2}"));
        text += &format!(
            "  {:<14} {:>7}  {:>12.6}  {:>12.6}  {:>9}  {:>7}\n",
            part.name,
            part.n_pixels,
            part.exact,
            part.mean,
            shown(z),
            shown(part.chi_square)
        );
    }
    // Along a shadow's edge neighbours do not tell how a pixel spreads: its z would only alarm.
    let told = outcome.pixels.iter().enumerate().filter(|(_, pixel)| pixel.truth.region.is_some());
    let by_z = told.filter_map(|(p, pixel)| Some((p, pixel, pixel.z()?)));
    if let Some((p, pixel, z)) = by_z.max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))
        && outcome.verdict().is_some()
    {
        let (column, row) = (p % outcome.width, p / outcome.width);
        text += &format!("  largest z of a pixel: {z:+.1} at column {column}, row {row}");
        let relative = pixel.mean / pixel.truth.irradiance - 1.0;
        text += &if relative.is_finite() { format!(" ({:+.2} %)\n", 100.0 * relative) } else { "\n".to_owned() };
    }
    text.push('\n');
    outcome.verdicts.iter().for_each(|judged| text += &verdict_lines(judged));
    for note in &outcome.notes {
        text += &format!("note       {note}\n");
    }
    if let Some(judged) = outcome.verdicts.iter().find(|judged| judged.verdict == Verdict::Fail) {
        text += &format!("again      {}\n", judged.reproduce);
    }
    if let Some(report) = report {
        text += &format!("report     {}\n", report.display());
    }
    text
}

/// A picture, `[height][width][3]`.
#[cfg(feature = "plots")]
struct Map {
    pixels: Vec<u8>,
    size: (u32, u32),
}

/// Narrower pictures are enlarged to so many pixels.
#[cfg(feature = "plots")]
const WIDEST: usize = 512;

#[cfg(feature = "plots")]
impl Map {
    /// From −1 (blue) over 0 (white) to 1 (red); grey where there is no number.
    fn of(outcome: &ImagesOutcome, value: &dyn Fn(&Pixel) -> Option<f64>) -> Map {
        let (width, height) = (outcome.width, outcome.height);
        let times = (WIDEST / width.max(height)).max(1);
        let colour = |pixel: &Pixel| match value(pixel) {
            None => [160, 160, 160],
            Some(x) => {
                let x = x.clamp(-1.0, 1.0);
                let toward = |end: [f64; 3]| end.map(|end| (255.0 + (end - 255.0) * x.abs()).round() as u8);
                // Steel blue and brick red, told apart by those who see few colours too.
                if x < 0.0 { toward([33.0, 80.0, 160.0]) } else { toward([178.0, 34.0, 34.0]) }
            }
        };
        let mut pixels = Vec::with_capacity(width * height * times * times * 3);
        for row in outcome.pixels.chunks_exact(width) {
            let line: Vec<u8> = row.iter().flat_map(|pixel| colour(pixel).repeat(times)).collect();
            (0..times).for_each(|_| pixels.extend_from_slice(&line));
        }
        Map { pixels, size: ((width * times) as u32, (height * times) as u32) }
    }
}

/// Deviations in standard errors, full colour at five.
#[cfg(feature = "plots")]
fn z_map(outcome: &ImagesOutcome) -> Map {
    Map::of(outcome, &|pixel| pixel.z().map(|z| z / 5.0))
}

/// Deviations, full colour at the largest.
#[cfg(feature = "plots")]
fn difference_map(outcome: &ImagesOutcome) -> Map {
    let off = |pixel: &Pixel| pixel.mean - pixel.truth.irradiance;
    let largest = outcome.pixels.iter().map(|pixel| off(pixel).abs()).fold(f64::MIN_POSITIVE, f64::max);
    Map::of(outcome, &|pixel| Some(off(pixel) / largest))
}
