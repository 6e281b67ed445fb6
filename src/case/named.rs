//! Which files a case file names, for who waits for them to change: as far as its text can be read.

use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use super::folder::{Reach, inside, read_file};
use super::schema;
use crate::intake::CASE_BYTES;

/// The meshes and pictures that a case file on disk names, whether they are there or not. None where it cannot be read, and none
/// that it may not name.
pub(crate) fn files_named(path: &Path, reach: Reach) -> Vec<PathBuf> {
    let bytes = read_file(path, CASE_BYTES).unwrap_or_default();
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut found = Vec::new();
    let text = String::from_utf8_lossy(&bytes);
    // What can be made out of a text with mistakes will do.
    let (document, _) = DeTable::parse_recoverable(&text);
    for value in document.get_ref().iter() {
        names(value.0.get_ref(), value.1.get_ref(), &mut found);
    }
    found.retain(|said| reach == Reach::Anywhere || inside("", said).is_ok());
    found.into_iter().map(|said| folder.join(said)).collect()
}

fn names(key: &str, value: &DeValue, found: &mut Vec<String>) {
    match value {
        DeValue::String(said) if [schema::FILE.name, schema::IMAGE.name].contains(&key) => {
            found.push(said.to_string())
        }
        DeValue::Array(items) => items.iter().for_each(|item| names(key, item.get_ref(), found)),
        DeValue::Table(table) => {
            table.iter().for_each(|(key, value)| names(key.get_ref(), value.get_ref(), found));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_and_pictures_are_found_beside_mistakes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("room.toml");
        let text = "title = \"file\"\n[[occluder.mesh]]\nfile = \"meshes/a.obj\"\n[[source.rectangle]]\nradius = ]\n\
                    exitance = { image = \"cross.png\", white = 2.0 }\n[[occluder.mesh]]\nfile = \"../b.obj\"\n";
        std::fs::write(&path, text).unwrap();
        let inside = ["meshes/a.obj", "cross.png"].map(|name| folder.path().join(name));
        assert_eq!(files_named(&path, Reach::Inside), inside);
        let all = files_named(&path, Reach::Anywhere);
        assert!(all.len() == 3 && all.contains(&folder.path().join("../b.obj")), "{all:?}");
        assert!(files_named(&folder.path().join("none.toml"), Reach::Inside).is_empty());
    }
}
