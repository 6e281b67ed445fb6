//! The files of `etendue render`.

use std::path::{Path, PathBuf};

use super::ReportError;
use super::folder::{claim_files, file_stems, write_whole};
use super::image::{self, Rgb, Tone};
use super::plot;
use crate::eye::Picture;
use crate::statistics::Verdict;
use crate::trial::{Judged, Lecture, PictureSettings, ReceiverPicture};

/// The pictures of one case.
#[derive(Clone, Debug)]
pub struct CasePictures {
    pub name: String,
    /// The case's digest and what made the pictures, for the files.
    pub digest: String,
    pub command: String,
    pub settings: PictureSettings,
    pub camera: Option<Picture>,
    pub receiver: Option<ReceiverPicture>,
}

/// A picture that was written, and what people should know of it.
#[derive(Clone, Debug)]
pub struct WrittenPicture {
    pub path: PathBuf,
    pub words: String,
}

/// Makes sure that pictures can be written to a folder, before the work.
pub fn claim_pictures(dir: &Path) -> Result<(), ReportError> {
    claim_files(dir, &[])
}

/// Writes the pictures of all cases: as PNG, as EXR, and beside exact values.
pub fn write_pictures(dir: &Path, cases: &[CasePictures]) -> Result<Vec<WrittenPicture>, ReportError> {
    let mut written = Vec::new();
    let stems = file_stems(cases.iter().map(|case| case.name.as_str()));
    for (case, stem) in cases.iter().zip(stems) {
        let shading = format!(
            "{} points, {} on each source for each pixel, seed {}",
            case.settings.strategy, case.settings.samples, case.settings.seed
        );
        let comments = format!("{}; digest {}; {shading}; {}", ascii(&case.name), case.digest, ascii(&case.command));
        let texts = |tone: Tone| {
            vec![
                ("Title", case.name.clone()),
                ("Tone mapping", tone.words()),
                ("Comment", comments.clone()),
                ("Software", concat!("etendue ", env!("CARGO_PKG_VERSION")).to_owned()),
            ]
        };
        let mut write = |name: String, bytes: Result<Vec<u8>, String>, words: String| {
            let bytes = bytes.map_err(|reason| ReportError::Plot { path: dir.join(&name), reason })?;
            written.push(WrittenPicture { path: write_whole(dir, &name, &bytes)?, words });
            Ok::<(), ReportError>(())
        };
        let linear = || "linear, 32 bits, channels named, units in its attributes".to_owned();
        if let Some(picture) = &case.camera {
            let (tone, size) = (Tone::of_picture(picture), [picture.width(), picture.height()]);
            let png = image::png(&image::colours(picture, tone), size, &texts(tone));
            write(format!("{stem}.png"), png, format!("by the camera; {}", tone.words()))?;
            write(format!("{stem}.exr"), image::exr_of_picture(picture, &comments), linear())?;
        }
        if let Some(receiver) = &case.receiver {
            let (tone, size) = (Tone::of_picture(&receiver.picture), receiver.view.pixels());
            let png = image::png(&image::colours_of_receiver(&receiver.picture, tone), size, &texts(tone));
            write(format!("{stem}-receiver.png"), png, format!("the receiver square on; {}", tone.words()))?;
            write(format!("{stem}-receiver.exr"), image::exr_of_receiver(receiver, &comments), linear())?;
            let (pixels, size) = plot::page_of_receiver(receiver)
                .map_err(|reason| ReportError::Plot { path: dir.join(&stem), reason })?;
            let words = match receiver.judged {
                Judged::By(_) => "beside the exact picture, the signed error and z",
                Judged::Not(_) => "with its scale",
            };
            let png = image::png(&pixels, size, &texts(tone)[..1]);
            write(format!("{stem}-receiver-exact.png"), png, words.to_owned())?;
        }
    }
    Ok(written)
}

/// Attributes of EXR files hold Latin-1.
fn ascii(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii() && !c.is_control() { c } else { '?' }).collect()
}

/// Writes the figures of the lecture.
pub fn write_lecture(dir: &Path, lecture: &Lecture) -> Result<Vec<WrittenPicture>, ReportError> {
    let mut written = Vec::new();
    for (name, words, page) in plot::lecture_pages(lecture) {
        let path = dir.join(name);
        let (pixels, size): (Vec<Rgb>, _) =
            page.map_err(|reason| ReportError::Plot { path: path.clone(), reason })?;
        let bytes = image::png(&pixels, size, &[("Title", words.to_owned())])
            .map_err(|reason| ReportError::Plot { path, reason })?;
        written.push(WrittenPicture { path: write_whole(dir, name, &bytes)?, words: words.to_owned() });
    }
    Ok(written)
}

/// What came of the pictures, for a terminal.
pub fn pictures_table(cases: &[CasePictures], written: &[WrittenPicture]) -> String {
    let mut text = String::new();
    for case in cases {
        text += &match case.receiver.as_ref().map(|receiver| &receiver.judged) {
            Some(Judged::By(judged)) => {
                let verdict = match judged.verdict {
                    Verdict::Pass => "PASS",
                    Verdict::Fail => "FAIL",
                    Verdict::Undecided => "UNDECIDED",
                };
                let again = if judged.verdict == Verdict::Pass {
                    String::new()
                } else {
                    format!("\n           again: {}", judged.reproduce)
                };
                format!("{verdict:<9}  {}  {}: {}{again}\n", case.name, judged.property, judged.words)
            }
            Some(Judged::Not(why)) => format!("not judged {}  {why}\n", case.name),
            None => format!("not judged {}  it has no receiver\n", case.name),
        };
    }
    text += &listed(written);
    text
}

/// The files, one a line.
pub fn listed(written: &[WrittenPicture]) -> String {
    let names: Vec<String> = written.iter().map(|picture| picture.path.display().to_string()).collect();
    let widest = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
    names.iter().zip(written).map(|(name, picture)| format!("{name:<widest$}  {}\n", picture.words)).collect()
}
