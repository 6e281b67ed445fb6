//! Finding cases by file, folder or name.

use std::collections::{BTreeMap, HashSet};
use std::fmt;
use std::path::{Path, PathBuf};

use super::error::{CaseError, CaseErrors};
use super::folder::{Folder, Reach, ReadFault, read_file};
use super::read::{CaseFile, read, whole_file};
use super::shipped::{Shipped, shipped};
use super::spelling;
use super::{Case, Ink};
use crate::errors::errors;
use crate::intake::CASE_BYTES;

errors! {
    /// Why a selection gave no cases. On the command line `Nothing` is exit code 4, the others 2.
    #[derive(Debug)]
    #[non_exhaustive]
    pub enum SelectError {
        /// Files with mistakes, each with all of its own.
        #[error("{}", rendered(files, Ink::Plain))]
        Faulty { files: Vec<CaseErrors> },
        /// Selectors that are no file, no folder with a case in it, and no part of a shipped case's name.
        #[error("{}", unmatched.iter().map(Unmatched::to_string).collect::<Vec<_>>().join("\n"))]
        Nothing { unmatched: Vec<Unmatched> },
        /// Results are kept by name, so two different files cannot share one.
        #[error("two cases are called `{name}`: {first} and {second}; give the folder that holds both, or rename one")]
        SameName { name: String, first: String, second: String },
    }
}

impl SelectError {
    /// As `Display`, with colours if wanted.
    pub fn render(&self, ink: Ink) -> String {
        match self {
            SelectError::Faulty { files } => rendered(files, ink),
            other => other.to_string(),
        }
    }
}

fn rendered(files: &[CaseErrors], ink: Ink) -> String {
    files.iter().map(|file| file.render(ink)).collect::<Vec<_>>().join("\n\n")
}

/// A selector that names nothing, and shipped cases that may have been meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unmatched {
    pub selector: String,
    pub why: &'static str,
    pub nearest: Vec<&'static str>,
}

impl fmt::Display for Unmatched {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Unmatched { selector, why, nearest } = self;
        write!(f, "`{selector}` {why}")?;
        if nearest.is_empty() { Ok(()) } else { write!(f, "; nearest: {}", nearest.join(", ")) }
    }
}

impl std::error::Error for Unmatched {}

/// The cases that the selectors name, without repetition, in the order of the selectors; without a selector, all
/// shipped cases.
///
/// A selector is looked for as a file, then as a folder (all `*.toml` in it and below, sorted), then among the shipped
/// cases: as a full name, else as a pattern if it holds `*` or `?`, else as a part of a name. If any file is faulty, no
/// case is returned and every mistake of every file is.
pub fn select(selectors: &[String]) -> Result<Vec<Case>, SelectError> {
    select_reaching(selectors, Reach::Inside)
}

/// The same of cases whose paths may reach so far.
pub fn select_reaching(selectors: &[String], reach: Reach) -> Result<Vec<Case>, SelectError> {
    let mut found: Vec<Found> = Vec::new();
    let mut unmatched = Vec::new();
    let mut faulty = Vec::new();
    if selectors.is_empty() {
        found.extend(shipped().map(Found::Shipped));
    }
    for selector in selectors {
        let path = Path::new(selector);
        let why = if path.is_dir() {
            match OnDisk::folder(path) {
                Ok(files) if files.is_empty() => Some("is a folder without a case file (*.toml)"),
                Ok(files) => {
                    found.extend(files.into_iter().map(Found::OnDisk));
                    None
                }
                Err(error) => {
                    faulty.push(error);
                    None
                }
            }
        } else if path.exists() {
            found.push(Found::OnDisk(OnDisk::single(path)));
            None
        } else {
            let before = found.len();
            found.extend(shipped_by_name(selector).map(Found::Shipped));
            (found.len() == before).then_some("is no file, no folder, and no part of a shipped case's name")
        };
        if let Some(why) = why {
            unmatched.push(Unmatched { selector: selector.clone(), why, nearest: nearest_cases(selector) });
        }
    }
    if !unmatched.is_empty() {
        return Err(SelectError::Nothing { unmatched });
    }
    let mut seen = HashSet::new();
    found.retain(|found| seen.insert(found.identity()));
    let mut names = BTreeMap::new();
    for found in &found {
        if let Some(first) = names.insert(found.name().to_string(), found.shown()) {
            let (name, second) = (found.name().to_string(), found.shown());
            return Err(SelectError::SameName { name, first, second });
        }
    }
    match (all_or_mistakes(found.iter().map(|found| found.read(reach))), faulty) {
        (Ok(cases), faulty) if faulty.is_empty() => Ok(cases),
        (read, mut files) => {
            files.extend(read.err().unwrap_or_default());
            Err(SelectError::Faulty { files })
        }
    }
}

/// The shipped case of that very name.
pub(super) fn shipped_case(name: &str) -> Result<Case, SelectError> {
    let Some(found) = shipped().find(|case| case.name() == name) else {
        let why = "is no shipped case's whole name";
        let unmatched = Unmatched { selector: name.to_owned(), why, nearest: nearest_cases(name) };
        return Err(SelectError::Nothing { unmatched: vec![unmatched] });
    };
    found.read().map_err(|file| SelectError::Faulty { files: vec![file] })
}

/// All cases, or the mistakes of all faulty ones.
pub(super) fn all_or_mistakes(
    read: impl Iterator<Item = Result<Case, CaseErrors>>,
) -> Result<Vec<Case>, Vec<CaseErrors>> {
    let mut cases = Vec::new();
    let mut faulty = Vec::new();
    for result in read {
        match result {
            Ok(case) => cases.push(case),
            Err(errors) => faulty.push(errors),
        }
    }
    if faulty.is_empty() { Ok(cases) } else { Err(faulty) }
}

fn shipped_by_name(selector: &str) -> impl Iterator<Item = Shipped> {
    let exact = shipped().any(|case| case.name() == selector);
    shipped().filter(move |case| match exact {
        true => case.name() == selector,
        false if selector.contains(['*', '?']) => matches(selector, case.name()),
        false => !selector.is_empty() && case.name().contains(selector),
    })
}

/// Whether a pattern fits a whole name: `*` stands for any text, `?` for one letter.
fn matches(pattern: &str, name: &str) -> bool {
    let (pattern, name): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    // fits[j]: the pattern so far fits the first j letters.
    let mut fits: Vec<bool> = (0..=name.len()).map(|j| j == 0).collect();
    for letter in pattern {
        let before = fits.clone();
        for j in 0..=name.len() {
            fits[j] = match letter {
                '*' => before[j] || (j > 0 && fits[j - 1]),
                '?' => j > 0 && before[j - 1],
                _ => j > 0 && before[j - 1] && name[j - 1] == letter,
            };
        }
    }
    fits[name.len()]
}

/// Up to three shipped names near to what was said, nearest first.
fn nearest_cases(said: &str) -> Vec<&'static str> {
    let said = said.strip_suffix(".toml").unwrap_or(said).to_lowercase();
    let slips = |name: &'static str| {
        let chapterless = name.rsplit('/').next().unwrap_or(name);
        spelling::distance(&said, name).min(spelling::distance(&said, chapterless))
    };
    let most = said.chars().count().div_ceil(3);
    let mut near: Vec<_> = shipped().map(|case| (slips(case.name()), case.name())).collect();
    near.retain(|(slips, _)| *slips <= most);
    near.sort();
    near.into_iter().take(3).map(|(_, name)| name).collect()
}

enum Found {
    OnDisk(OnDisk),
    Shipped(Shipped),
}

impl Found {
    fn name(&self) -> &str {
        match self {
            Found::OnDisk(file) => &file.name,
            Found::Shipped(case) => case.name(),
        }
    }
    /// As a message names it.
    fn shown(&self) -> String {
        match self {
            Found::OnDisk(file) => file.path.display().to_string(),
            Found::Shipped(case) => format!("the shipped {}", case.name()),
        }
    }
    /// The same for the same file, however it was named.
    fn identity(&self) -> (bool, PathBuf) {
        match self {
            Found::OnDisk(file) => (true, file.path.canonicalize().unwrap_or_else(|_| file.path.clone())),
            Found::Shipped(case) => (false, case.name().into()),
        }
    }
    fn read(&self, reach: Reach) -> Result<Case, CaseErrors> {
        match self {
            Found::OnDisk(file) => file.read(reach),
            Found::Shipped(case) => case.read(),
        }
    }
}

/// A case file on disk.
pub(super) struct OnDisk {
    path: PathBuf,
    name: String,
    /// The folder of the cases.
    root: PathBuf,
    /// The file's path below it, with `/`.
    below: String,
}

impl OnDisk {
    /// A file by itself: its own folder is the folder of the cases.
    pub(super) fn single(path: &Path) -> OnDisk {
        let text = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
        OnDisk {
            path: path.into(),
            name: text(path.file_stem()),
            root: path.parent().map(Path::to_path_buf).unwrap_or_default(),
            below: text(path.file_name()),
        }
    }

    /// Every file `*.toml` in a folder and below it, sorted by name. Links to folders are not followed.
    pub(super) fn folder(root: &Path) -> Result<Vec<OnDisk>, CaseErrors> {
        let mut found = Vec::new();
        let mut folders = vec![(root.to_path_buf(), String::new())];
        while let Some((folder, below)) = folders.pop() {
            let unreadable = |error: std::io::Error| {
                whole_file(&folder.display().to_string(), CaseError::Unreadable { said: error.to_string() })
            };
            for entry in std::fs::read_dir(&folder).map_err(unreadable)? {
                let entry = entry.map_err(unreadable)?;
                let below = format!("{below}{}", entry.file_name().to_string_lossy());
                if entry.file_type().map_err(unreadable)?.is_dir() {
                    folders.push((entry.path(), format!("{below}/")));
                } else if let Some(name) = below.strip_suffix(".toml") {
                    // A pipe would be waited for.
                    if entry.path().metadata().is_ok_and(|what| !what.is_file()) {
                        continue;
                    }
                    let name = name.to_string();
                    found.push(OnDisk { path: entry.path(), name, root: root.into(), below });
                }
            }
        }
        found.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(found)
    }

    pub(super) fn read(&self, reach: Reach) -> Result<Case, CaseErrors> {
        let shown = self.path.display().to_string();
        let limit = CASE_BYTES;
        let bytes = read_file(&self.path, limit).map_err(|fault| match fault {
            ReadFault::TooLarge => whole_file(&shown, CaseError::TooLarge { limit }),
            ReadFault::Unreadable(said) => whole_file(&shown, CaseError::Unreadable { said }),
        })?;
        let folder = Folder::Disk { root: self.root.clone(), reach };
        let file = CaseFile { path: &shown, selector: &shown, name: &self.name, folder: &folder, below: &self.below };
        Ok(Case { reach, ..read(&file, &bytes)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_fit_whole_names() {
        assert!(matches("penumbra/*", "penumbra/eclipse"));
        assert!(matches("*eclipse*", "penumbra/eclipse-mesh"));
        assert!(matches("*/e?lipse", "penumbra/eclipse"));
        assert!(!matches("eclipse", "penumbra/eclipse"));
        assert!(!matches("penumbra/?", "penumbra/eclipse"));
        assert!(matches("*", "") && matches("**", "a") && !matches("?", ""));
    }
}
