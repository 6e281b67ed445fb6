//! Images of other renderers: stacks of pixels, read as if somebody had broken them on purpose.
//!
//! Every reader compares what a header claims with the size that is due before it makes room for it, so no file can ask for
//! more memory than the images that were ordered take.

mod error;
#[cfg(feature = "plots")]
mod exr;
mod npy;
mod pfm;

use std::collections::HashMap;
use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
#[cfg(any(fuzzing, test))]
use std::io;
use std::io::{BufRead, BufReader, Read, Seek};
use std::path::{Path, PathBuf};

pub use error::ImageError;
pub use pfm::pfm;

use crate::intake::{IMAGE_VALUES, IMAGES};

/// Images of one size, in the order of their files.
#[derive(Clone, Debug, PartialEq)]
pub struct Stack {
    pub width: usize,
    pub height: usize,
    /// `[image][row][column]`, in the units of the files.
    pub values: Vec<f64>,
    /// The variance of each pixel's value, as the file of a single image states it: `[row][column]`.
    pub variance: Option<Vec<f64>>,
    /// Whether any file keeps half-floats, whose rounding is up to 4.9e-4 of a value.
    pub is_half: bool,
}

impl Stack {
    /// Reads files of images, each of `width` × `height` pixels.
    ///
    /// Refused: what is cut off, foreign or of another size; NaN, infinite pixels; two equal images (but for black ones).
    pub fn read(paths: &[PathBuf], [width, height]: [usize; 2]) -> Result<Stack, ImageError> {
        let mut sink = Sink::new(width, height);
        for path in paths {
            read_file(path, &mut sink)?;
        }
        Stack::of(sink, paths)
    }

    /// The same of a file that lies in memory.
    #[cfg(any(fuzzing, test))]
    pub(crate) fn from_memory(bytes: &[u8], [width, height]: [usize; 2]) -> Result<Stack, ImageError> {
        let path = PathBuf::from("memory");
        let mut sink = Sink::new(width, height);
        read_open(&path, io::Cursor::new(bytes), bytes.len() as u64, &mut sink)?;
        Stack::of(sink, &[path])
    }

    fn of(sink: Sink, paths: &[PathBuf]) -> Result<Stack, ImageError> {
        let Sink { width, height, values, variances, is_half } = sink;
        let mut stack = Stack { width, height, values, variance: None, is_half };
        if stack.n_images() == 1 {
            stack.variance = variances.into_iter().next();
        }
        stack.refuse_twins(paths)?;
        Ok(stack)
    }

    /// Reads the variance of each pixel of a single image, of a file of its own.
    pub fn read_variance(path: &Path, [width, height]: [usize; 2]) -> Result<Vec<f64>, ImageError> {
        let mut sink = Sink::new(width, height);
        read_file(path, &mut sink)?;
        let n = sink.values.len() / (width * height);
        if n != 1 {
            let what = format!("{n} images of variances; one is accepted");
            return Err(ImageError::Broken { path: path.to_owned(), what });
        }
        let values = sink.values;
        if let Some(index) = values.iter().position(|variance| *variance < 0.0) {
            let what = format!("a variance is {} (column {}, row {})", values[index], index % width, index / width);
            return Err(ImageError::Broken { path: path.to_owned(), what });
        }
        Ok(values)
    }

    pub fn n_pixels(&self) -> usize {
        self.width * self.height
    }
    pub fn n_images(&self) -> usize {
        self.values.len() / self.n_pixels().max(1)
    }
    /// `[row][column]`.
    pub fn image(&self, k: usize) -> &[f64] {
        &self.values[k * self.n_pixels()..(k + 1) * self.n_pixels()]
    }

    /// Independent images are never equal, unless there is nothing to be seen on them.
    fn refuse_twins(&self, paths: &[PathBuf]) -> Result<(), ImageError> {
        let mut seen: HashMap<u64, Vec<usize>> = HashMap::new();
        for k in 0..self.n_images() {
            let image = self.image(k);
            if image.iter().all(|x| *x == 0.0) {
                continue;
            }
            let mut hasher = DefaultHasher::new();
            image.iter().for_each(|x| x.to_bits().hash(&mut hasher));
            let alike = seen.entry(hasher.finish()).or_default();
            if let Some(first) = alike.iter().find(|first| self.image(**first) == image) {
                let files = if paths.len() == self.n_images() {
                    format!(" ({} and {})", paths[*first].display(), paths[k].display())
                } else {
                    String::new()
                };
                return Err(ImageError::Identical { first: *first, second: k, files });
            }
            alike.push(k);
        }
        Ok(())
    }
}

/// What readers fill.
struct Sink {
    width: usize,
    height: usize,
    values: Vec<f64>,
    variances: Vec<Vec<f64>>,
    is_half: bool,
}

impl Sink {
    fn new(width: usize, height: usize) -> Sink {
        Sink { width, height, values: Vec::new(), variances: Vec::new(), is_half: false }
    }

    fn n_pixels(&self) -> usize {
        self.width * self.height
    }

    /// Whether so many more images may come; else the error that says it.
    fn room_for(&self, path: &Path, images: usize) -> Result<(), ImageError> {
        let most = (IMAGE_VALUES as usize / self.n_pixels().max(1)).min(IMAGES as usize);
        let held = self.values.len() / self.n_pixels().max(1);
        if images > most.saturating_sub(held) {
            return Err(ImageError::TooMany { path: path.to_owned(), images: held.saturating_add(images), most });
        }
        Ok(())
    }

    /// Takes one image, `[row][column]`.
    fn push(&mut self, path: &Path, image: &[f64]) -> Result<(), ImageError> {
        self.room_for(path, 1)?;
        refuse_what_is_no_number(path, self.values.len() / self.n_pixels().max(1), image, self.width)?;
        self.values.extend_from_slice(image);
        Ok(())
    }

    /// Takes the variance of the image that came last.
    fn push_variance(&mut self, path: &Path, variance: Vec<f64>) -> Result<(), ImageError> {
        let k = (self.values.len() / self.n_pixels().max(1)).saturating_sub(1);
        refuse_what_is_no_number(path, k, &variance, self.width)?;
        if let Some(index) = variance.iter().position(|x| *x < 0.0) {
            let what = format!("a variance is {}", variance[index]);
            return Err(ImageError::Broken { path: path.to_owned(), what });
        }
        self.variances.push(variance);
        Ok(())
    }

    fn size_error(&self, path: &Path, found: impl Into<String>) -> ImageError {
        ImageError::Size { path: path.to_owned(), found: found.into(), width: self.width, height: self.height }
    }
}

fn refuse_what_is_no_number(path: &Path, image: usize, values: &[f64], width: usize) -> Result<(), ImageError> {
    let bad = || values.iter().enumerate().filter(|(_, x)| !x.is_finite());
    let count = bad().count();
    if count == 0 {
        return Ok(());
    }
    let place = |(i, x): (usize, &f64)| format!("column {}, row {}: {x}", i % width, i / width);
    let places: Vec<String> = bad().take(3).map(place).collect();
    let more = if count > 3 { "; …" } else { "" };
    let places = places.join("; ") + more;
    Err(ImageError::NotFinite { path: path.to_owned(), image, count, of: values.len(), places })
}

/// Luminance of the three primaries (ITU-R BT.709): of a neutral scene, any one of them.
fn grey(channels: [f64; 3]) -> f64 {
    0.2126 * channels[0] + 0.7152 * channels[1] + 0.0722 * channels[2]
}

fn read_file(path: &Path, sink: &mut Sink) -> Result<(), ImageError> {
    let unreadable = |source| ImageError::Unreadable { path: path.to_owned(), source };
    let file = File::open(path).map_err(unreadable)?;
    let meta = file.metadata().map_err(unreadable)?;
    if !meta.is_file() {
        return Err(ImageError::Foreign { path: path.to_owned(), what: "it is no file" });
    }
    read_open(path, BufReader::new(file), meta.len(), sink)
}

/// Reads images from the start of what is open.
///
/// - `path`: what it is called in errors; `length`: its bytes
fn read_open(path: &Path, mut reader: impl BufRead + Seek, length: u64, sink: &mut Sink) -> Result<(), ImageError> {
    let unreadable = |source| ImageError::Unreadable { path: path.to_owned(), source };
    let mut magic = Vec::new();
    reader.by_ref().take(8).read_to_end(&mut magic).map_err(unreadable)?;
    reader.rewind().map_err(unreadable)?;
    match magic.as_slice() {
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => npy::read(path, &mut reader, length, sink),
        [b'P', b'F' | b'f', ..] => pfm::read(path, &mut reader, length, sink),
        [0x76, 0x2f, 0x31, 0x01, ..] => read_exr(path, reader, sink),
        [] => Err(ImageError::Foreign { path: path.to_owned(), what: "it is empty" }),
        [0x89, b'P', b'N', b'G', ..] | [0xff, 0xd8, ..] | [b'B', b'M', ..] => Err(ImageError::Foreign {
            path: path.to_owned(),
            what: "a picture in whole numbers, clamped and curved for the eye, holds no radiance",
        }),
        _ => Err(ImageError::Foreign { path: path.to_owned(), what: "it begins as none of them does" }),
    }
}

#[cfg(feature = "plots")]
fn read_exr(path: &Path, reader: impl Read + Seek, sink: &mut Sink) -> Result<(), ImageError> {
    exr::read(path, reader, sink)
}
#[cfg(not(feature = "plots"))]
fn read_exr(path: &Path, _: impl Read + Seek, _: &mut Sink) -> Result<(), ImageError> {
    Err(ImageError::Foreign {
        path: path.to_owned(),
        what: "this build, without the feature `plots`, reads no OpenEXR",
    })
}

/// Whether a file is one of images, by how it begins.
pub fn is_image(path: &Path) -> bool {
    let mut magic = Vec::new();
    let read = File::open(path).and_then(|file| file.take(6).read_to_end(&mut magic));
    read.is_ok()
        && [
            &b"\x93NUMPY"[..],
            b"PF\n",
            b"Pf\n",
            b"PF\r",
            b"Pf\r",
            b"PF ",
            b"Pf ",
            b"\x76\x2f\x31\x01",
            b"\x89PNG",
            b"\xff\xd8\xff",
        ]
        .iter()
        .any(|known| magic.starts_with(known))
}

#[cfg(test)]
mod tests;
