//! Case files: what stands in the room and how it is to be studied.
//!
//! ```
//! let case = etendue::case::Case::from_toml(
//!     "disk-over-patch",
//!     r#"
//!     [[source.disk]]
//!     center = [0.0, 0.0, 2.0]
//!     normal = [0.0, 0.0, -1.0]
//!     radius = 0.5
//!     exitance = 1.0
//!
//!     [[measure.point]]
//!     position = [0.0, 0.0, 0.0]
//!     normal = [0.0, 0.0, 1.0]
//!     "#,
//! )?;
//! assert_eq!(case.configuration.points().len(), 1);
//! # Ok::<(), etendue::case::CaseErrors>(())
//! ```
//!
//! [`select`] finds cases by file, folder or name; [`shipped`] lists those inside the program. [`schema`] holds every
//! key with its unit, default and meaning. All mistakes of a file come together, as [`CaseErrors`].

mod camera;
mod error;
mod folder;
#[cfg(feature = "cli")]
mod json_schema;
mod measure;
#[cfg(feature = "cli")]
mod named;
pub mod obj;
mod optics;
#[cfg_attr(not(feature = "studies"), path = "no_picture.rs")]
mod picture;
mod place;
mod read;
#[cfg(test)]
mod reference;
#[cfg_attr(not(feature = "studies"), path = "plain.rs")]
mod render;
pub mod schema;
mod select;
mod settings;
mod shapes;
mod shipped;
mod spelling;
mod study;
mod texture;
mod walk;

use std::path::Path;

use crate::configuration::Configuration;
use crate::eye::Camera;
use crate::light::LightSettings;

pub use error::{CaseError, CaseErrors, MeshFileFault, Mistake};
pub use folder::Reach;
#[cfg(feature = "cli")]
pub use json_schema::json_schema;
#[cfg(feature = "cli")]
pub(crate) use named::files_named;
pub use place::Place;
pub use render::Ink;
pub use select::{SelectError, Unmatched, select, select_reaching};
pub use shipped::{Shipped, shipped, shipped_caustics, shipped_direct, shipped_interreflections};
#[cfg(feature = "cli")]
pub(crate) use spelling::nearest;
pub use study::{Accepted, PROPERTIES, Replicates, SmallestBias, Study};

/// Whether a picture can be read, as light by an sRGB curve; if not, why.
#[cfg(any(fuzzing, test))]
pub(crate) fn check_picture(bytes: &[u8]) -> Result<(), String> {
    picture::read(bytes, crate::texture::Encoding::Srgb).map(drop)
}

/// A commented case file to start from.
#[cfg(feature = "cli")]
pub(crate) const TEMPLATE: &str = include_str!("../../assets/new-case.toml");

/// One case, valid by construction.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The file's path below the folder that was given, without `.toml`: `penumbra/eclipse`.
    pub name: String,
    /// What selects the case on a command line: the file's path as it was given, or the name of a shipped case.
    pub selector: String,
    /// How far the paths in its file were let reach, which a command that repeats its reading says again.
    pub reach: Reach,
    /// What people read.
    pub title: String,
    pub configuration: Configuration,
    pub study: Study,
    /// How light is followed from the sources.
    pub light: LightSettings,
    /// From where pictures show it, besides its receiver square on.
    pub camera: Option<Camera>,
}

impl Case {
    /// A case described in code. Its name stands in for a selector in messages and commands.
    pub fn new(name: &str, title: &str, configuration: Configuration, study: Study) -> Case {
        let light = LightSettings::default();
        Case {
            name: name.to_owned(),
            selector: name.to_owned(),
            reach: Reach::Inside,
            title: title.to_owned(),
            configuration,
            study,
            light,
            camera: None,
        }
    }

    /// Whether there are surfaces that emit and points that look at them. Else there are lamps alone, whose light
    /// [`crate::light`] follows, or nothing is measured but maps.
    pub fn measures_direct_light(&self) -> bool {
        !self.configuration.sources().is_empty() && !self.configuration.points().is_empty()
    }

    /// A case from text alone; it cannot name a mesh.
    pub fn from_toml(name: &str, text: &str) -> Result<Case, CaseErrors> {
        let file = read::CaseFile { path: name, selector: name, name, folder: &folder::Folder::Nowhere, below: name };
        read::read(&file, text.as_bytes())
    }

    /// A case whose file, and all that it names, lies in memory.
    #[cfg(any(fuzzing, test))]
    pub(crate) fn from_memory(
        bytes: &[u8],
        files: &'static [(&'static str, &'static [u8])],
    ) -> Result<Case, CaseErrors> {
        let folder = folder::Folder::Shipped(files);
        let file =
            read::CaseFile { path: "memory", selector: "memory", name: "memory", folder: &folder, below: "x.toml" };
        read::read(&file, bytes)
    }

    /// The shipped case of that name (`etendue list` has them); not a file, not a part of a name.
    pub fn shipped(name: &str) -> Result<Case, SelectError> {
        select::shipped_case(name)
    }

    /// A case file on disk, named by its stem. Meshes and pictures that it names lie in its folder or below.
    pub fn read(path: &Path) -> Result<Case, CaseErrors> {
        Case::read_reaching(path, Reach::Inside)
    }

    /// The same of a case whose paths may reach so far.
    pub fn read_reaching(path: &Path, reach: Reach) -> Result<Case, CaseErrors> {
        select::OnDisk::single(path).read(reach)
    }

    /// All `*.toml` in a folder and below it, sorted by name. If any file is faulty, all faulty files are told. Meshes and
    /// pictures that they name lie anywhere in that folder.
    pub fn read_folder(path: &Path) -> Result<Vec<Case>, Vec<CaseErrors>> {
        let files = select::OnDisk::folder(path).map_err(|error| vec![error])?;
        select::all_or_mistakes(files.iter().map(|file| file.read(Reach::Inside)))
    }
}
