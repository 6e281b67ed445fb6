//! Where the files that a case names are read from: a folder on disk, the program itself, or nowhere.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use super::error::MeshFileFault;

/// How far the paths in case files may reach. Whoever reads cases of others keeps to the first: what such a file names may
/// be shown, in messages at least.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub enum Reach {
    /// Into the folder of the cases and below it: the folder that was given, or the one that a single file lies in. A link
    /// that leads out of it leads nowhere.
    #[default]
    Inside,
    /// To wherever the file system lets them.
    Anywhere,
}

impl Reach {
    /// What a command says to have it so, after a blank; nothing where that goes without saying.
    pub fn words(self) -> &'static str {
        match self {
            Reach::Inside => "",
            Reach::Anywhere => " --allow-outside",
        }
    }
}

/// The folder of the cases.
#[derive(Clone, Debug)]
pub(super) enum Folder {
    Disk {
        root: PathBuf,
        reach: Reach,
    },
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
        let unreadable = |said: &str| MeshFileFault::Unreadable { said: said.into() };
        match self {
            Folder::Disk { root, reach } => {
                let path = place(root, case, said, *reach)?;
                read_file(&path, limit).map_err(|fault| match fault {
                    ReadFault::Unreadable(said) => MeshFileFault::Unreadable { said },
                    ReadFault::TooLarge => MeshFileFault::TooLarge { limit },
                })
            }
            Folder::Shipped(files) => {
                let path = inside(case, said)?;
                match files.iter().find(|(name, _)| *name == path) {
                    Some((_, bytes)) => Ok(bytes.to_vec()),
                    None => Err(unreadable("no such file among the shipped cases")),
                }
            }
            Folder::Nowhere => inside(case, said).and(Err(unreadable("a case from text has no folder"))),
        }
    }
}

/// Where the file lies that a case file names, all links followed; it is a regular file.
///
/// - `root`: the folder of the cases; `case`: the case file's path below it
pub(super) fn place(root: &Path, case: &str, said: &str, reach: Reach) -> Result<PathBuf, MeshFileFault> {
    let unreadable = |error: std::io::Error| MeshFileFault::Unreadable { said: error.to_string() };
    let root = if root.as_os_str().is_empty() { Path::new(".") } else { root };
    let path = match reach {
        Reach::Inside => root.join(inside(case, said)?),
        Reach::Anywhere => root.join(case).parent().unwrap_or(root).join(said),
    };
    let path = path.canonicalize().map_err(unreadable)?;
    if reach == Reach::Inside && !path.starts_with(root.canonicalize().map_err(unreadable)?) {
        return Err(MeshFileFault::LinkedOutside);
    }
    // A pipe would be waited for, and a device never ends.
    if path.metadata().map_err(unreadable)?.is_file() { Ok(path) } else { Err(MeshFileFault::NoFile) }
}

/// The path below the folder that a case file's relative path means, by its text alone.
pub(super) fn inside(case: &str, said: &str) -> Result<String, MeshFileFault> {
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

    #[cfg(unix)]
    #[test]
    fn links_lead_no_further_than_paths() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |below: &str| folder.path().join(below);
        std::fs::create_dir_all(at("cases/deep")).unwrap();
        std::fs::create_dir(at("elsewhere")).unwrap();
        std::fs::write(at("elsewhere/a.obj"), b"out").unwrap();
        std::fs::write(at("cases/b.obj"), b"in").unwrap();
        symlink(at("elsewhere/a.obj"), at("cases/to-file.obj")).unwrap();
        symlink(at("elsewhere"), at("cases/to-folder")).unwrap();
        symlink("../b.obj", at("cases/deep/to-sound.obj")).unwrap();
        symlink(at("cases"), at("linked")).unwrap();
        symlink("/dev/zero", at("cases/endless.obj")).unwrap();
        for root in ["cases", "linked"] {
            let read = |reach, said| Folder::Disk { root: at(root), reach }.read("deep/x.toml", said, 9);
            let outside = ["../to-file.obj", "../to-folder/a.obj", "../endless.obj"];
            for said in outside {
                assert_eq!(read(Reach::Inside, said), Err(MeshFileFault::LinkedOutside), "{said}");
            }
            assert_eq!(read(Reach::Inside, "to-sound.obj"), Ok(b"in".to_vec()));
            assert_eq!(read(Reach::Inside, "."), Err(MeshFileFault::NoFile));
            assert_eq!(read(Reach::Inside, "../../elsewhere/a.obj"), Err(MeshFileFault::Outside));
            assert_eq!(read(Reach::Anywhere, "../to-file.obj"), Ok(b"out".to_vec()));
            assert_eq!(read(Reach::Anywhere, "../../elsewhere/a.obj"), Ok(b"out".to_vec()));
            let absolute = at("elsewhere/a.obj");
            assert_eq!(read(Reach::Anywhere, absolute.to_str().unwrap()), Ok(b"out".to_vec()));
            assert_eq!(read(Reach::Inside, absolute.to_str().unwrap()), Err(MeshFileFault::Absolute));
            assert_eq!(read(Reach::Anywhere, "../endless.obj"), Err(MeshFileFault::NoFile), "a device never ends");
        }
    }

    #[test]
    fn a_file_beyond_the_limit_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.obj"), b"12345").unwrap();
        let disk = Folder::Disk { root: folder.path().into(), reach: Reach::Inside };
        assert_eq!(disk.read("x.toml", "a.obj", 5), Ok(b"12345".to_vec()));
        assert_eq!(disk.read("x.toml", "a.obj", 4), Err(MeshFileFault::TooLarge { limit: 4 }));
        assert!(matches!(disk.read("x.toml", "b.obj", 4), Err(MeshFileFault::Unreadable { .. })));
    }
}
