//! What can be wrong with a file of images.

use std::path::PathBuf;

use thiserror::Error;

/// Why images were refused.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ImageError {
    #[error("{}: {source}", path.display())]
    Unreadable { path: PathBuf, source: std::io::Error },
    #[error("{}: {what}; accepted: NPY arrays [image, row, column], PFM, OpenEXR", path.display())]
    Foreign { path: PathBuf, what: &'static str },
    #[error("{}: {what}", path.display())]
    Broken { path: PathBuf, what: String },
    #[error("{}: it holds {found}; the manifest says {width} x {height} pixels (columns x rows)", path.display())]
    Size { path: PathBuf, found: String, width: usize, height: usize },
    #[error("{}: {images} images by now; {most} of this size are held in memory", path.display())]
    TooMany { path: PathBuf, images: usize, most: usize },
    #[error("{}: {count} of {of} pixels of image {image} (counted from 0, over all files) are no finite numbers: {places}", path.display())]
    NotFinite { path: PathBuf, image: usize, count: usize, of: usize, places: String },
    #[error(
        "images {first} and {second}{files}, counted from 0, are equal to the last bit: they come from one seed and are one image. Every image needs a seed of its own"
    )]
    Identical { first: usize, second: usize, files: String },
}
