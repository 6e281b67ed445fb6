//! The commands that speak with other renderers: `export`, and `verify` of images.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::commands::{fault, print, select, take};
use super::exit;
use super::guests::{VerifyOptions, case_words};
use super::options::Reaching;
use crate::case::Case;
use crate::external::image::{Stack, is_image};
use crate::external::recipe::{self, Inexpressible, Order};
use crate::external::{Manifest, ManifestError};
use crate::report;
use crate::statistics::Verdict;
use crate::trial::{ImageTerms, LEAST_TOLERANCE_OF_HALVES, as_judged, judge_images, quoted};

pub(super) const EXPORT_HELP: &str = "\
The folder gets scene.xml (and OBJ files), manifest.json, which says what the pixels are, and render.py, which renders
independent images into one array:

    pip install mitsuba numpy
    etendue export penumbra/eclipse --for mitsuba -o eclipse
    python eclipse/render.py 64
    etendue verify penumbra/eclipse eclipse/independent.npy

Any other renderer: `--for json` writes scene.json (shapes, receiver, height of the camera, points in numbers) and the manifest;
a script of yours builds the scene, and writes an array [image, row, column] of radiance.

A rectangle of even texels and one flat mirror are exported; with a mirror, light that has met it once belongs to the image
(`depth` 3), and images are judged if all of the receiver sees all of every source in it.

What is not expressed (other textures, lamps, curved mirrors, glass, receivers that are no rectangle, an occluder that touches the
receiver) is refused by name.

Exit codes: 0 written, 2 the command line or a case is wrong or cannot be expressed, 4 nothing selected, 5 an output could not be
written.";

/// Whose scene it is to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Renderer {
    /// Mitsuba 3, tried with 3.9.1
    Mitsuba,
    /// The case in numbers, for a script that builds the scene of another renderer
    Json,
}

/// Options of `export`.
#[derive(Args, Debug)]
pub struct ExportOptions {
    /// A case file or the name of a shipped case
    #[arg(value_name = "CASE")]
    case: String,
    /// The renderer
    #[arg(long = "for", value_name = "RENDERER")]
    renderer: Renderer,
    /// Folder that the scene is written to
    #[arg(long, short, value_name = "DIR")]
    out: PathBuf,
    /// Columns and rows of the images (default: 32 along the longer edge, square pixels)
    #[arg(long, value_name = "WxH", value_parser = pixels)]
    pixels: Option<[usize; 2]>,
    /// Samples a pixel
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u64).range(1..=1 << 30))]
    samples: u64,
    #[command(flatten)]
    reaching: Reaching,
}

/// Options of `verify` that speak of images.
#[derive(Args, Debug)]
pub struct ImageOptions {
    /// What the images are images of (default: manifest.json beside the first)
    #[arg(long, value_name = "FILE")]
    manifest: Option<PathBuf>,
    /// The variance of each pixel of a single image, as an image (PFM, NPY, OpenEXR), in the square of its units
    #[arg(long, value_name = "FILE")]
    pixel_variance: Option<PathBuf>,
    /// Metres by which the renderer may move the start of a shadow ray; pixels nearer to a shadow's edge are told apart
    #[arg(long, value_name = "METRES", value_parser = metres)]
    ray_epsilon: Option<f64>,
    /// Folder for the report
    #[arg(long, value_name = "DIR", default_value = "reports/verify")]
    pub(super) out: PathBuf,
}

fn pixels(text: &str) -> Result<[usize; 2], String> {
    let parsed =
        text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.trim().parse().ok()?, h.trim().parse().ok()?]));
    match parsed {
        Some([width, height]) if width > 0 && height > 0 => Ok([width, height]),
        _ => Err("columns and rows, such as 64x48".to_owned()),
    }
}

fn metres(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(length) if length > 0.0 && length.is_finite() => Ok(length),
        _ => Err("metres, greater than zero".to_owned()),
    }
}

pub fn export(options: &ExportOptions) -> u8 {
    export_to_end(options).unwrap_or_else(|code| code)
}

fn export_to_end(options: &ExportOptions) -> Result<u8, u8> {
    let mut cases = select(std::slice::from_ref(&options.case), &options.reaching)?;
    if cases.len() != 1 {
        return Err(fault(
            exit::USAGE,
            format!("`{}` names {} cases; one is exported at a time", options.case, cases.len()),
        ));
    }
    let case = cases.remove(0);
    if let Err(why) = as_judged(&case) {
        say!("note: images of {} cannot be judged: {why}", case.name);
    }
    let order = Order { pixels: options.pixels, samples_per_pixel: options.samples };
    let recipe = match options.renderer {
        Renderer::Mitsuba => recipe::mitsuba(&case.configuration, &case.name, &order),
        Renderer::Json => recipe::plain(&case.configuration, &case.name, &order),
    };
    let recipe = recipe.map_err(|found| {
        found.iter().for_each(|error: &Inexpressible| {
            fault(exit::USAGE, format!("{} cannot be exported: {error}", case.name));
        });
        exit::USAGE
    })?;
    let written = report::write_files(&options.out, &recipe.files).map_err(|error| fault(exit::OUTPUT, error))?;
    let names: String = written.iter().map(|path| format!("{}\n", path.display())).collect();
    print(&names)?;
    Ok(exit::PASSED)
}

/// Whether these are files of images. A mixture is left to the reader of images, which says what is foreign.
pub(super) fn are_images(options: &VerifyOptions) -> bool {
    options.images.manifest.is_some()
        || options.images.pixel_variance.is_some()
        || options.files.iter().any(|file| is_image(file))
}

pub(super) fn verify(options: &VerifyOptions, case: &Case) -> Result<u8, u8> {
    let VerifyOptions { files, images, terms, .. } = options;
    let beside = || files[0].parent().map_or_else(PathBuf::new, PathBuf::from).join("manifest.json");
    let path = images.manifest.clone().unwrap_or_else(beside);
    let straight = as_judged(case)
        .map_err(|error| fault(exit::USAGE, format!("images of {} cannot be judged: {error}", case.name)))?;
    let manifest = Manifest::read(&path, &case.configuration).map_err(|error| {
        let hint = match &error {
            ManifestError::Unreadable { .. } if images.manifest.is_none() => {
                " (images need the manifest that was exported with their scene: --manifest FILE)"
            }
            _ => "",
        };
        fault(exit::USAGE, format!("{error}{hint}"))
    })?;
    let size = [manifest.pixels.width, manifest.pixels.height];
    let mut stack = Stack::read(files, size).map_err(|error| fault(exit::OUTPUT, error))?;
    if let Some(path) = &images.pixel_variance {
        if stack.n_images() != 1 {
            return Err(fault(
                exit::USAGE,
                format!("{} images; --pixel-variance is for a single one", stack.n_images()),
            ));
        }
        stack.variance = Some(Stack::read_variance(path, size).map_err(|error| fault(exit::OUTPUT, error))?);
    }
    let tolerance = case.study.tolerance;
    if stack.is_half && tolerance < LEAST_TOLERANCE_OF_HALVES {
        return Err(fault(
            exit::OUTPUT,
            format!(
                "{}: half-floats round by up to 4.9e-4 of a value, and {tolerance} is all that may be off. Write 32 bits, or say --tolerance {LEAST_TOLERANCE_OF_HALVES}",
                files[0].display()
            ),
        ));
    }
    let stem = files[0].file_stem().map_or(String::new(), |stem| stem.to_string_lossy().into_owned());
    let name = terms.name.clone().unwrap_or(format!("{}:{stem}", manifest.renderer));
    let words = |path: &PathBuf| quoted(&path.to_string_lossy());
    let mut reproduce = format!("etendue verify {}", case_words(case));
    // A thousand files are known by their folder.
    files.iter().take(4).for_each(|file| reproduce += &format!(" {}", words(file)));
    reproduce += if files.len() > 4 { " …" } else { "" };
    reproduce += &format!(" --manifest {}", words(&path));
    reproduce +=
        &images.pixel_variance.as_ref().map_or(String::new(), |path| format!(" --pixel-variance {}", words(path)));
    reproduce += &images.ray_epsilon.map_or(String::new(), |epsilon| format!(" --ray-epsilon {epsilon}"));
    reproduce += &terms.smallest_bias.map_or(String::new(), |b| format!(" --smallest-bias {},{}", b.mean, b.point));
    reproduce += &terms.words();
    let judged = ImageTerms {
        name: &name,
        reproduce,
        irradiance_of_value: manifest.irradiance_of_radiance(),
        rho: manifest.rho,
        samples_per_pixel: manifest.samples_per_pixel,
        first_sample_at_centre: manifest.first_sample_at_centre,
        tolerance,
        ray_epsilon: images.ray_epsilon,
        smallest_bias: terms.smallest_bias.unwrap_or(case.study.smallest_bias),
    };
    let _lock = take(&images.out)?;
    report::claim_images(&images.out).map_err(|error| fault(exit::OUTPUT, error))?;
    let outcome = judge_images(&straight, &manifest.pixels, &stack, &judged);
    report::write_images(&images.out, &outcome).map_err(|error| fault(exit::OUTPUT, error))?;
    print(&report::images_table(&outcome, Some(&images.out)))?;
    Ok(match outcome.verdict() {
        Some(Verdict::Fail) => exit::FAILED,
        Some(Verdict::Undecided) | None if !terms.allow_undecided => exit::UNDECIDED,
        _ => exit::PASSED,
    })
}
