//! The cases that are part of the program, so that an installed `etendue` works anywhere.

use super::folder::Folder;
use super::read::{CaseFile, read};
use super::{Case, CaseErrors};

macro_rules! embedded {
    ($($path:literal,)*) => { &[$(($path, include_bytes!(concat!("../../cases/", $path)))),*] };
}

/// Every file below `cases/`, sorted by name; a test compares the list with the folder.
static FILES: &[(&str, &[u8])] = embedded![
    "caustic/ball-on-a-globe.toml",
    "caustic/ball-on-a-table.toml",
    "caustic/cup.toml",
    "caustic/glass-ball.toml",
    "caustic/mirror-ring.toml",
    "caustic/paraboloid.toml",
    "caustic/plane-mirror.toml",
    "caustic/plano-convex.toml",
    "caustic/slab.toml",
    "caustic/spherical-mirror.toml",
    "direct/diffuser-box.toml",
    "direct/disk-over-plane.toml",
    "direct/disk-receiver.toml",
    "direct/half-sunk-source.toml",
    "direct/l-shaped-source.toml",
    "direct/rectangle-over-plane.toml",
    "direct/sphere-receiver.toml",
    "direct/sphere-source.toml",
    "direct/tilted-source.toml",
    "direct/triangle-source.toml",
    "direct/turning-patch.toml",
    "direct/two-sources.toml",
    "penumbra/annular-eclipse.toml",
    "penumbra/contact-shadow.toml",
    "penumbra/disk-17-rings.obj",
    "penumbra/eclipse.toml",
    "penumbra/eclipse-at-sunset.toml",
    "penumbra/eclipse-closing.toml",
    "penumbra/eclipse-mesh.toml",
    "penumbra/half-plane.toml",
    "penumbra/l-shaped-occluder.toml",
    "penumbra/overlapping-occluders.toml",
    "penumbra/rectangle-behind-rectangle.toml",
    "penumbra/sphere-occluder.toml",
    "penumbra/spheres.toml",
    "penumbra/three-regions.toml",
    "penumbra/tilted-occluder.toml",
    "penumbra/two-shadows.toml",
    "texture/blended-panel.toml",
    "texture/checker-panel.toml",
    "texture/cross.png",
    "texture/globe.toml",
    "texture/picture-panel.toml",
    "texture/sectors.toml",
    "texture/slanted-triangle.toml",
    "texture/tiled-ball.toml",
];

/// A case that is part of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shipped {
    path: &'static str,
    text: &'static str,
}

impl Shipped {
    /// `penumbra/eclipse`.
    pub fn name(&self) -> &'static str {
        self.path.strip_suffix(".toml").unwrap_or(self.path)
    }
    /// The case file, comments included.
    pub fn text(&self) -> &'static str {
        self.text
    }
    /// The case, valid as all shipped ones are (a test reads them).
    pub fn read(&self) -> Result<Case, CaseErrors> {
        let shown = format!("shipped:{}", self.path);
        let folder = Folder::Shipped(FILES);
        let file =
            CaseFile { path: &shown, selector: self.name(), name: self.name(), folder: &folder, below: self.path };
        read(&file, self.text.as_bytes())
    }
}

/// The chapters whose light takes a bend: rays from the light measure them, and a run of the estimators does not.
const BENT: [&str; 1] = ["caustic/"];

/// The shipped cases that the estimators of direct light measure, sorted by name.
pub fn shipped_direct() -> impl Iterator<Item = Shipped> {
    shipped().filter(|case| !BENT.iter().any(|chapter| case.path.starts_with(chapter)))
}

/// The shipped cases whose light takes a bend ([`crate::light`]), sorted by name.
pub fn shipped_caustics() -> impl Iterator<Item = Shipped> {
    shipped().filter(|case| BENT.iter().any(|chapter| case.path.starts_with(chapter)))
}

/// All shipped cases, sorted by name.
pub fn shipped() -> impl Iterator<Item = Shipped> {
    FILES.iter().filter(|(path, _)| path.ends_with(".toml")).map(|(path, bytes)| Shipped {
        path,
        text: std::str::from_utf8(bytes).expect("the shipped cases are text; a test reads them"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn files_below(folder: &Path, found: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                files_below(&path, found);
            } else {
                let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
                let below = path.strip_prefix(root).unwrap();
                found.push(below.to_str().unwrap().replace('\\', "/"));
            }
        }
    }

    #[test]
    fn every_file_below_cases_is_part_of_the_program() {
        let mut found = Vec::new();
        files_below(&Path::new(env!("CARGO_MANIFEST_DIR")).join("cases"), &mut found);
        found.sort_by_key(|path| path.trim_end_matches(".toml").to_string());
        assert_eq!(FILES.iter().map(|(path, _)| *path).collect::<Vec<_>>(), found);
    }
}
