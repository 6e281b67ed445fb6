//! What can be wrong with a case file.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use super::obj::ObjError;
use super::place::Place;
use super::schema::{self, Table};
use crate::configuration::ConfigurationError;
use crate::errors::errors;
use crate::eye::EyeError;
use crate::geometry::ShapeError;
use crate::radiometry::RadiometryError;
use crate::texture::TextureError;

errors! {
    /// One thing that is wrong with a case file.
    #[derive(Clone, Debug, PartialEq)]
    #[non_exhaustive]
    pub enum CaseError {
        /// In the words of the TOML parser.
        #[error("this is not TOML: {said}")]
        Syntax { said: String },
        #[error("{more} more places are not TOML; the first ones are listed")]
        MoreSyntax { more: usize },
        /// So many are not kept.
        #[error("{more} more mistakes in the same file, the last one here")]
        More { more: usize },
        #[error("the file cannot be read: {said}")]
        Unreadable { said: String },
        #[error("the file is larger than {} MiB, the most that is accepted: it would not fit into memory with all that it describes", limit >> 20)]
        TooLarge { limit: u64 },
        #[error("the file is not UTF-8 text")]
        NotText,
        #[error("{table} has no key `{said}`")]
        UnknownKey { table: String, said: String, accepted: Vec<&'static str>, nearest: Option<&'static str> },
        #[error("`{key}` is not supported by this version yet")]
        NotYet { key: String },
        #[error("{table} lacks the key `{key}`: {expected}")]
        MissingKey { table: String, key: &'static str, expected: String },
        #[error("`{key}` is {said}; {expected} is accepted")]
        WrongType { key: String, said: &'static str, expected: &'static str },
        #[error("`{key}` is \"{said}\"; accepted: {}", accepted.join(", "))]
        UnknownName { key: String, said: String, accepted: Vec<&'static str>, nearest: Option<&'static str> },
        #[error("`{key}` has {said} {what}; {expected} are accepted")]
        Length { key: String, what: &'static str, said: usize, expected: usize },
        #[error("`{key}` is {said}; every number is finite")]
        NotFinite { key: String, said: f64 },
        #[error("`{key}` is {said:e}; no number lies beyond ±{:e}", schema::MAX_MAGNITUDE)]
        TooFar { key: String, said: f64 },
        #[error("`{key}` is {said}; {accepted}")]
        Number { key: String, said: f64, accepted: &'static str },
        #[error("`{key}` is {said}; an integer from {least} to {most} is accepted")]
        Count { key: String, said: String, least: u64, most: u64 },
        #[error("`{key}` is empty; it names at least one")]
        Empty { key: String },
        #[error("`{key}` lists {said} twice")]
        Twice { key: String, said: String },
        #[error("{said} {what}; at most {limit} are accepted: more would take too much memory or time")]
        TooMany { what: &'static str, said: u128, limit: u64 },
        #[error("[{table}]: {error}")]
        Shape { table: &'static str, error: ShapeError },
        #[error("[{table}]: {error}")]
        Lamp { table: &'static str, error: RadiometryError },
        #[error("[{table}]: the area is {said:e} m²; {:e} to {:e} m² is accepted", schema::MIN_AREA, schema::MAX_MAGNITUDE * schema::MAX_MAGNITUDE)]
        Area { table: &'static str, said: f64 },
        #[error("`{file}` {fault}")]
        MeshFile { file: String, fault: MeshFileFault },
        #[error("the mesh `{file}` is broken: {error}")]
        Mesh { file: String, error: ObjError },
        #[error("`{key}`: {error}")]
        Texture { key: String, error: TextureError },
        #[error("`{key}` describes no texture; it has one of {}", accepted.join(", "))]
        NoTexture { key: String, accepted: Vec<&'static str> },
        #[error("`{key}` has both `{first}` and `{second}`; one is accepted")]
        TwoTextures { key: String, first: &'static str, second: &'static str },
        #[error("`{key}` is for {accepted}; this is a {shape}")]
        ForeignKey { key: String, accepted: &'static str, shape: &'static str },
        #[error("a texture lies on a rectangle, a disk, a triangle or a sphere; this polygon has {said} vertices")]
        NoMap { said: usize },
        #[error("`{file}` is no picture that can be read: {said}")]
        Picture { file: String, said: String },
        #[error("[receiver] has no shape; accepted: {}", accepted.join(", "))]
        NoReceiverShape { accepted: Vec<&'static str> },
        #[error("[receiver] has a second shape, `{said}`; one is accepted")]
        SecondReceiverShape { said: &'static str },
        #[error("`measure.{key}` needs a [receiver] to lie on")]
        NoReceiver { key: &'static str },
        #[error("`measure.line` runs from a point to itself; its ends differ")]
        LineWithoutLength,
        #[error("[camera]: {0}")]
        Camera(EyeError),
        #[error(transparent)]
        Configuration(ConfigurationError),
    }
}

errors! {
    /// What keeps a mesh file from being read.
    #[derive(Clone, Debug, PartialEq)]
    #[non_exhaustive]
    pub enum MeshFileFault {
        #[error("is an absolute path; a path relative to the case file is accepted")]
        Absolute,
        #[error("leaves the folder of the cases; a path inside it is accepted")]
        Outside,
        #[error("is a link, or lies behind one, that leads out of the folder of the cases; a file inside it is accepted")]
        LinkedOutside,
        #[error("cannot be read: {said}")]
        Unreadable { said: String },
        #[error("is larger than {} MiB, the most that is accepted: it would not fit into memory", limit >> 20)]
        TooLarge { limit: u64 },
        #[error("is too large beside the other files of this case; {} MiB are accepted of all of them", limit >> 20)]
        TooLargeTogether { limit: u64 },
        #[error("is no regular file")]
        NoFile,
    }
}

impl CaseError {
    pub(super) fn unknown_key(table: &Table, said: &str) -> CaseError {
        let accepted: Vec<_> = table.accepted().collect();
        let nearest = super::spelling::nearest(said, accepted.iter().copied());
        CaseError::UnknownKey { table: table.title(), said: said.into(), accepted, nearest }
    }

    /// The known name that may have been meant.
    pub fn nearest(&self) -> Option<&'static str> {
        match self {
            CaseError::UnknownKey { nearest, .. } | CaseError::UnknownName { nearest, .. } => *nearest,
            _ => None,
        }
    }

    /// What would help, one line each: the nearest name, then what is accepted where the error does not say so itself.
    pub fn help(&self) -> Vec<String> {
        let mut help = Vec::new();
        if let Some(nearest) = self.nearest() {
            help.push(format!("did you mean `{nearest}`?"));
        }
        match self {
            CaseError::UnknownKey { accepted, .. } if accepted.is_empty() => {}
            CaseError::UnknownKey { accepted, .. } => help.push(format!("accepted keys: {}", accepted.join(", "))),
            CaseError::MeshFile {
                fault: MeshFileFault::Absolute | MeshFileFault::Outside | MeshFileFault::LinkedOutside,
                ..
            } => help.push(
                "the folder of the cases is the one that was given, or of a single file its own; --allow-outside \
                 (`Reach::Anywhere` in code) lets a case name any file"
                    .into(),
            ),
            CaseError::NoReceiverShape { .. } => help.push("add [receiver.rectangle], for example".into()),
            _ => {}
        }
        help
    }

    /// A few words to stand beside the underlined text.
    pub(super) fn label(&self) -> &'static str {
        match self {
            CaseError::Syntax { .. } | CaseError::MoreSyntax { .. } | CaseError::NotText => "not TOML",
            CaseError::Unreadable { .. } | CaseError::TooLarge { .. } | CaseError::More { .. } => "",
            CaseError::UnknownKey { .. } => "unknown key",
            CaseError::NotYet { .. } => "not supported yet",
            CaseError::MissingKey { .. } => "in this table",
            CaseError::WrongType { .. } => "wrong type",
            CaseError::UnknownName { .. } => "unknown name",
            CaseError::NotFinite { .. } => "not finite",
            CaseError::Length { .. } => "wrong length",
            CaseError::TooFar { .. } | CaseError::Number { .. } | CaseError::Count { .. } => "out of range",
            CaseError::Empty { .. } => "empty",
            CaseError::Twice { .. } => "second time",
            CaseError::TooMany { .. } => "too many",
            CaseError::Shape { .. } | CaseError::Area { .. } => "impossible shape",
            CaseError::Lamp { .. } => "out of range",
            CaseError::MeshFile { .. } | CaseError::Mesh { .. } => "cannot be used",
            CaseError::Texture { .. } | CaseError::NoTexture { .. } => "no texture",
            CaseError::TwoTextures { .. } => "two textures",
            CaseError::ForeignKey { .. } => "not for this shape",
            CaseError::NoMap { .. } => "no map",
            CaseError::Picture { .. } => "cannot be used",
            CaseError::NoReceiverShape { .. } => "no shape",
            CaseError::SecondReceiverShape { .. } => "second shape",
            CaseError::NoReceiver { .. } => "no receiver",
            CaseError::LineWithoutLength => "no length",
            CaseError::Camera(EyeError::Inside { .. }) => "sees nothing from here",
            CaseError::Camera(_) => "no camera",
            CaseError::Configuration(error) => match error {
                ConfigurationError::NoSource => "no source",
                ConfigurationError::NothingToMeasure => "nothing to measure",
                ConfigurationError::PointOnSurface { .. } => "measured here",
                ConfigurationError::Albedo { .. }
                | ConfigurationError::Exitance { .. }
                | ConfigurationError::Reflectance { .. }
                | ConfigurationError::Ior { .. } => "out of range",
                ConfigurationError::GlassOverlap { .. } => "cuts into another",
                ConfigurationError::OutsideEnclosure { .. } => "out of the enclosure",
                ConfigurationError::CurvedBefore { .. } => "may hide a source",
                ConfigurationError::OffReceiver { .. } => "off the receiver",
                _ => "",
            },
        }
    }

    /// True where the mistake is that something is not there: after a syntax error that may only seem so.
    pub(super) fn is_absence(&self) -> bool {
        matches!(
            self,
            CaseError::MissingKey { .. }
                | CaseError::NoReceiverShape { .. }
                | CaseError::NoReceiver { .. }
                | CaseError::Empty { .. }
                | CaseError::Configuration(ConfigurationError::NoSource | ConfigurationError::NothingToMeasure)
        )
    }
}

/// One mistake, and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Mistake {
    pub error: CaseError,
    pub place: Place,
    /// Other text that has to do with it, with a few words.
    pub also: Vec<(Range<usize>, String)>,
}

impl Mistake {
    /// The file, as it was named.
    pub fn path(&self) -> &str {
        self.place.path()
    }
    /// Bytes of the file's text.
    pub fn span(&self) -> Range<usize> {
        self.place.span()
    }
    /// Counted from 1.
    pub fn line(&self) -> usize {
        self.place.line()
    }
    /// Counted from 1, in characters.
    pub fn column(&self) -> usize {
        self.place.column()
    }
}

impl fmt::Display for Mistake {
    /// One line: `eclipse.toml:14:10: [source.disk]: radius is -0.3; it is greater than zero (metres)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.error)
    }
}

/// All mistakes of one file, in the order of its text; at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseErrors {
    pub(super) path: Arc<str>,
    pub(super) text: Arc<str>,
    pub(super) mistakes: Vec<Mistake>,
}

impl CaseErrors {
    /// The file, as it was named.
    pub fn path(&self) -> &str {
        &self.path
    }
    /// In the order of the file's text.
    pub fn mistakes(&self) -> &[Mistake] {
        &self.mistakes
    }
    /// How many there are beyond the first so many.
    pub(super) fn beyond(&self, shown: usize) -> usize {
        let count = |mistake: &Mistake| if let CaseError::More { more } = mistake.error { more } else { 1 };
        self.mistakes.iter().skip(shown).map(count).sum()
    }
    /// The text that a mistake underlines.
    pub fn underlined(&self, mistake: &Mistake) -> &str {
        self.text.get(mistake.span()).unwrap_or_default()
    }
}

impl fmt::Display for CaseErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(super::Ink::Plain))
    }
}

impl std::error::Error for CaseErrors {}
