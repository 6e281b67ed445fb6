//! Where the files that a case names are read from: a folder on disk, the program itself, or nowhere.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use super::error::MeshFileFault;

/// The folder of the cases. Case files name other files inside it, never outside.
#[derive(Clone, Debug)]
pub(super) enum Folder {
    Disk(PathBuf),
    /// Paths below `cases/`, with content.
    Shipped(&'static [(&'static str, &'static [u8])]),
    /// A case from text alone.
    Nowhere,
}

/// Why a whole file could not be had.
pub(super) enum ReadFault {
    Unreadable(String),
    TooLarge,
}

impl Folder {
    /// The content of a file that a case file names.
    ///
    /// - `case`: the case file's path below the folder, with `/`
    /// - `said`: the path that it names, relative to itself
    pub(super) fn read(&self, case: &str, said: &str, limit: u64) -> Result<Vec<u8>, MeshFileFault> {
        let path = inside(case, said)?;
        let unreadable = |said: &str| MeshFileFault::Unreadable { said: said.into() };
        match self {
            Folder::Disk(root) => read_file(&root.join(path), limit).map_err(|fault| match fault {
                ReadFault::Unreadable(said) => MeshFileFault::Unreadable { said },
                ReadFault::TooLarge => MeshFileFault::TooLarge { limit },
            }),
            Folder::Shipped(files) => match files.iter().find(|(name, _)| *name == path) {
                Some((_, bytes)) => Ok(bytes.to_vec()),
                None => Err(unreadable("no such file among the shipped cases")),
            },
            Folder::Nowhere => Err(unreadable("a case from text has no folder")),
        }
    }
}

/// The path below the folder that a case file's relative path means. Only the text is looked at: links are followed.
fn inside(case: &str, said: &str) -> Result<String, MeshFileFault> {
    let drive = said.as_bytes().get(1) == Some(&b':');
    if Path::new(said).is_absolute() || said.starts_with(['/', '\\']) || drive {
        return Err(MeshFileFault::Absolute);
    }
    let mut parts: Vec<&str> = case.split('/').collect();
    parts.pop();
    for part in said.split('/') {
        match part {
            "" | "." => {}
            ".." if parts.pop().is_some() => {}
            // Elsewhere a backslash separates folders, and a step upwards could hide behind it.
            _ if part == ".." || part.split('\\').any(|p| p == "..") => return Err(MeshFileFault::Outside),
            _ => parts.push(part),
        }
    }
    Ok(parts.join("/"))
}

/// The content of a file on disk, never more than `limit` bytes of it.
pub(super) fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, ReadFault> {
    let unreadable = |error: std::io::Error| ReadFault::Unreadable(error.to_string());
    let file = File::open(path).map_err(unreadable)?;
    if file.metadata().map_err(unreadable)?.len() > limit {
        return Err(ReadFault::TooLarge);
    }
    let mut bytes = Vec::new();
    file.take(limit + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > limit { Err(ReadFault::TooLarge) } else { Ok(bytes) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_inside_the_folder() {
        let inside = |said| inside("penumbra/deep/eclipse.toml", said).ok();
        assert_eq!(inside("a.obj").as_deref(), Some("penumbra/deep/a.obj"));
        assert_eq!(inside("./b/../a.obj").as_deref(), Some("penumbra/deep/a.obj"));
        assert_eq!(inside("../../meshes/a.obj").as_deref(), Some("meshes/a.obj"));
        for outside in ["../../../a.obj", "/etc/passwd", "\\\\host\\a", "C:\\a.obj", "..\\..\\..\\a.obj"] {
            assert_eq!(inside(outside), None, "{outside}");
        }
    }

    #[test]
    fn a_file_beyond_the_limit_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.obj"), b"12345").unwrap();
        let disk = Folder::Disk(folder.path().into());
        assert_eq!(disk.read("x.toml", "a.obj", 5), Ok(b"12345".to_vec()));
        assert_eq!(disk.read("x.toml", "a.obj", 4), Err(MeshFileFault::TooLarge { limit: 4 }));
        assert!(matches!(disk.read("x.toml", "b.obj", 4), Err(MeshFileFault::Unreadable { .. })));
    }
}
