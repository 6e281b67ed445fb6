//! The floors of the house, read from the source: every room looks strictly down, truth and measurement never see each
//! other, and each outside crate is spoken to in its own room only.
//!
//! Comments and tests are exempt: a test may call on whatever it needs to doubt the code.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Rooms with their floor and wing.
const ROOMS: &[(&str, u8, Wing)] = &[
    ("main", 12, Wing::Shared),
    ("cli", 11, Wing::Shared),
    ("fuzzing", 11, Wing::Shared),
    ("report", 10, Wing::Shared),
    ("calibration", 9, Wing::Shared),
    ("guest", 9, Wing::Shared),
    ("journal", 9, Wing::Shared),
    ("trial", 8, Wing::Shared),
    ("case", 7, Wing::Shared),
    ("eye", 6, Wing::Measurement),
    ("external", 5, Wing::Measurement),
    ("estimator", 5, Wing::Measurement),
    ("light", 5, Wing::Measurement),
    ("path", 5, Wing::Measurement),
    ("scene", 4, Wing::Measurement),
    ("sampling", 4, Wing::Measurement),
    ("oracle", 4, Wing::Truth),
    ("configuration", 3, Wing::Shared),
    ("radiometry", 2, Wing::Shared),
    ("texture", 2, Wing::Shared),
    ("geometry", 1, Wing::Shared),
    ("statistics", 1, Wing::Shared),
    ("errors", 0, Wing::Shared),
    ("intake", 0, Wing::Shared),
    ("number", 0, Wing::Shared),
    ("threads", 0, Wing::Shared),
];

#[derive(Clone, Copy, PartialEq, Eq)]
enum Wing {
    Shared,
    Measurement,
    Truth,
}

/// Looks to the side that are meant. A row that nothing uses fails the test.
const SIDEWAYS: &[(&str, &str, &str)] = &[
    ("scene", "sampling", "shadow rays lie in memory as the source points do that they lead to"),
    ("path", "light", "mirrors and glass send an eye path on as they do a packet from the light"),
];

/// Words of the source (crates, types) and the only places that may say them. A row that nothing uses fails the test.
const RESERVED: &[(&str, &[&str])] = &[
    // obvhs speaks f32; so does the font crate, of pixels, which no number of a report passes through; and so do files of pictures,
    // our own and those of other renderers, and who asks whether their numbers are shorter still.
    (
        "f32",
        &[
            "scene/hierarchy.rs",
            "scene/wide.rs",
            "report/exr.rs",
            "report/plot/text.rs",
            "external/image/",
            "trial/images/cause.rs",
        ],
    ),
    ("exr", &["external/image/", "report/"]),
    ("obvhs", &["scene/hierarchy.rs", "scene/wide.rs"]),
    ("rand", &["sampling/", "trial/"]),
    ("rayon", &["trial/", "journal/", "calibration/", "eye/", "light/", "path/", "threads/", "report/plot/", "cli/"]),
    ("pulp", &["number/eight.rs", "scene/hierarchy.rs", "scene/wide.rs"]),
    ("plotters", &["report/plot/"]),
    ("ab_glyph", &["report/plot/text.rs"]),
    ("csv", &["report/"]),
    ("quick_junit", &["report/junit.rs"]),
    ("toml", &["case/"]),
    ("clap", &["cli/"]),
    ("clap_complete", &["cli/"]),
    ("clap_mangen", &["cli/"]),
    ("notify", &["cli/watch.rs"]),
    ("signal_hook", &["cli/interrupt.rs"]),
    ("terminal_size", &["cli/progress.rs"]),
    ("statrs", &["statistics/"]),
    // How long a run goes on is shown while it does, and written nowhere.
    ("Instant", &["trial/", "journal/writer.rs", "cli/progress.rs"]),
    ("postcard", &["trial/onlooker.rs", "journal/frame.rs"]),
    ("crc32fast", &["journal/"]),
];

/// A source file: its path below `src`, and its text.
struct Source {
    path: String,
    text: String,
}

#[test]
fn every_room_looks_strictly_down() {
    let sources = sources();
    let (faults, used) = looks(&sources);
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    for (from, to, reason) in SIDEWAYS {
        assert!(used.contains(&(*from, *to)), "{from} no longer looks at {to} ({reason}): remove the row");
    }
}

#[test]
fn outside_crates_are_spoken_to_in_their_own_rooms() {
    let sources = sources();
    let faults = reserved_words(&sources);
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    for (word, places) in RESERVED {
        for place in *places {
            let used = |source: &Source| source.path.starts_with(place) && says(&source.text, word);
            // Only what is used is worth a permission.
            assert!(sources.iter().any(used) || *place == "cli/", "{place} no longer says {word}: remove it");
        }
    }
}

#[test]
fn the_source_is_all_read() {
    let sources = sources();
    assert!(sources.len() > 50, "{} files", sources.len());
    let rooms = sources.iter().map(|source| room_of(&source.path)).filter(|room| *room != "lib");
    let rooms: BTreeSet<&str> = rooms.collect();
    let known: BTreeSet<&str> = ROOMS.iter().map(|(room, ..)| *room).collect();
    assert_eq!(rooms, known, "a new room gets its floor, an empty one leaves the list");
}

#[test]
fn a_breach_is_found_wherever_it_hides() {
    let breaches = [
        ("oracle/exact.rs", "use crate::sampling::Strategy;"),
        ("oracle/exact.rs", "fn f() { let x = crate::scene::Hierarchy::new(); }"),
        ("oracle/exact.rs", "use crate::{geometry::Shape, estimator::AreaEstimator};"),
        ("oracle/exact.rs", "use super::super::sampling::Strategy;"),
        ("oracle/mod.rs", "use super::sampling::Strategy;"),
        ("oracle/mod.rs", "use super::{geometry, sampling};"),
        ("oracle/deep/deeper.rs", "use super::super::super::sampling::Strategy;"),
        ("oracle/exact.rs", "use crate :: {\n    geometry::{\n        Disk, Shape,\n    },\n    scene,\n};"),
        ("estimator/area.rs", "use crate::oracle::Oracle;"),
        ("sampling/warp.rs", "use crate::estimator::Job;"),
        ("sampling/warp.rs", "use crate::scene::Blocker;"),
        ("statistics/slope.rs", "use crate::radiometry::Irradiance;"),
        ("statistics/slope.rs", "use crate::geometry::Disk;"),
        ("geometry/shape.rs", "use crate::statistics::PowerSums;"),
        ("configuration/mod.rs", "use crate::case::Case;"),
        ("case/read.rs", "pub(crate) use crate::trial::run as go;"),
        ("trial/run.rs", "use crate::report::write;"),
        ("report/mod.rs", "use crate::cli;"),
        ("oracle/exact.rs", "use etendue::sampling::Strategy;"),
        ("oracle/exact.rs", "use crate::attic::Box;"),
        ("oracle/exact.rs", "use crate::*;"),
        ("oracle/exact.rs", "#[cfg(test)]\nmod tests { fn f() { \"}\"; } }\nuse crate::sampling::Strategy;"),
        ("oracle/exact.rs", "const QUOTE: char = '\"'; use crate::sampling::Strategy; const OTHER: char = '\"';"),
    ];
    for (path, text) in breaches {
        let (faults, _) = looks(&[made_up(path, text)]);
        assert_eq!(faults.len(), 1, "{path}: {text}: {faults:?}");
    }
    let words =
        [("oracle/exact.rs", "use rand::Rng;"), ("geometry/mesh.rs", "let x: f32 = 1.0;"), ("oracle/a.rs", "1f32")];
    for (path, text) in words {
        assert_eq!(reserved_words(&[made_up(path, text)]).len(), 1, "{path}: {text}");
    }
}

#[test]
fn what_is_allowed_is_let_through() {
    let allowed = [
        ("oracle/exact.rs", "use crate::configuration::Configuration;\nuse crate::oracle::Truth;\nuse super::truth;"),
        (
            "oracle/exact.rs",
            "// use crate::sampling::Strategy;\n/// See [`crate::estimator`].\n/* crate::scene::X */",
        ),
        ("oracle/exact.rs", "const SAID: &str = \"crate::sampling\"; const RAW: &str = r#\"f32 \" crate::scene\"#;"),
        (
            "oracle/exact.rs",
            "#[cfg(test)]\nmod tests {\n    use super::*;\n    use crate::sampling::Strategy;\n    use rand::Rng;\n}",
        ),
        ("oracle/exact.rs", "fn f<'a>(x: &'a str) -> char { 'x' }\nfn operand_f32ish() { strand::x(); }"),
        ("scene/blocker.rs", "use crate::sampling::LANES;"),
        ("cli/commands.rs", "use crate::{case, oracle, report, trial};"),
        ("lib.rs", "pub mod oracle;"),
    ];
    for (path, text) in allowed {
        let source = [made_up(path, text)];
        assert_eq!(looks(&source).0, Vec::<String>::new(), "{path}: {text}");
        assert_eq!(reserved_words(&source), Vec::<String>::new(), "{path}: {text}");
    }
}

/// Every look up or across, told as `file: room -> room`, and the sideways looks that were met.
fn looks(sources: &[Source]) -> (Vec<String>, BTreeSet<(&'static str, &'static str)>) {
    let mut faults = Vec::new();
    let mut used = BTreeSet::new();
    for source in sources.iter().filter(|source| source.path != "lib.rs") {
        let from = room_of(&source.path);
        for to in rooms_seen(source) {
            if to == from {
                continue;
            }
            if let Some((a, b, _)) = SIDEWAYS.iter().find(|(a, b, _)| *a == from && *b == to) {
                used.insert((*a, *b));
            } else if !may_see(from, &to) {
                faults.push(format!("{}: {from} may not see {to}", source.path));
            }
        }
    }
    (faults, used)
}

fn may_see(from: &str, to: &str) -> bool {
    let place = |room: &str| ROOMS.iter().find(|(name, ..)| *name == room);
    let (Some((_, upper, from_wing)), Some((_, lower, to_wing))) = (place(from), place(to)) else { return false };
    let walled = *from_wing != Wing::Shared && *to_wing != Wing::Shared && from_wing != to_wing;
    lower < upper && !walled
}

fn reserved_words(sources: &[Source]) -> Vec<String> {
    let mut faults = Vec::new();
    for source in sources {
        for (word, places) in RESERVED {
            if says(&source.text, word) && !places.iter().any(|place| source.path.starts_with(place)) {
                faults.push(format!("{}: says {word}, which belongs to {}", source.path, places.join(", ")));
            }
        }
    }
    faults
}

/// Whether a word stands in a text by itself. A number's type (`1f32`) does; crates are said as paths.
fn says(text: &str, word: &str) -> bool {
    let letter = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word).any(|(at, _)| {
        let before = text[..at].chars().next_back().is_some_and(|c| letter(c) && !c.is_ascii_digit());
        let rest = &text[at + word.len()..];
        let after = rest.chars().next().is_some_and(letter);
        let path =
            word.starts_with(|c: char| c.is_uppercase()) || word == "f32" || rest.trim_start().starts_with("::");
        !before && !after && path
    })
}

/// The first folder or file of a path: the room it belongs to.
fn room_of(path: &str) -> &str {
    path.split('/').next().map_or(path, |first| first.strip_suffix(".rs").unwrap_or(first))
}

/// The rooms that a file's paths lead to: `crate::room`, `etendue::room`, and `super` as often as leads to the crate.
fn rooms_seen(source: &Source) -> BTreeSet<String> {
    let tokens = tokens(&source.text);
    // Modules between the crate and this file.
    let parts = source.path.trim_end_matches(".rs").split('/').filter(|part| *part != "mod").count();
    let mut seen = BTreeSet::new();
    for at in 0..tokens.len() {
        let starts_path = at == 0 || tokens[at - 1] != "::";
        let mut next = match tokens[at].as_str() {
            "crate" | "etendue" if starts_path => at + 1,
            "super" if starts_path => {
                let mut supers = 1;
                while tokens.get(at + 2 * supers).is_some_and(|t| t == "super") {
                    supers += 1;
                }
                if supers < parts {
                    continue;
                }
                at + 2 * supers - 1
            }
            _ => continue,
        };
        if tokens.get(next).is_none_or(|token| token != "::") {
            continue;
        }
        next += 1;
        match tokens.get(next).map(String::as_str) {
            Some("{") => {
                // The heads of a group: what follows its brace or a comma at its own depth.
                let mut depth = 0;
                let mut head = false;
                for token in &tokens[next..] {
                    match token.as_str() {
                        "{" => {
                            depth += 1;
                            head = depth == 1;
                        }
                        "}" => {
                            depth -= 1;
                            if depth == 0 {
                                break;
                            }
                        }
                        "," => head = depth == 1,
                        name => {
                            if head {
                                seen.insert(name.to_owned());
                            }
                            head = false;
                        }
                    }
                }
            }
            Some(name) => {
                seen.insert(name.to_owned());
            }
            None => {}
        }
    }
    seen
}

/// Words, `::`, and single marks.
fn tokens(text: &str) -> Vec<String> {
    let mut tokens = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let word = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        let len = match word {
            0 if rest.starts_with("::") => 2,
            0 => first.len_utf8(),
            word => word,
        };
        tokens.push(rest[..len].to_owned());
        rest = rest[len..].trim_start();
    }
    tokens
}

/// Every file below `src` but those that are tests, without comments, texts and `#[cfg(test)]` modules.
fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut paths = Vec::new();
    let mut folders = vec![root.clone()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("the source") {
            let path = entry.expect("an entry").path();
            match path.extension() {
                _ if path.is_dir() => folders.push(path),
                Some(extension) if extension == "rs" => paths.push(path),
                _ => {}
            }
        }
    }
    paths.sort();
    let read = |path: &PathBuf| std::fs::read_to_string(path).expect("text");
    let tests: BTreeSet<PathBuf> = paths.iter().flat_map(|path| test_files(path, &bare(&read(path)))).collect();
    let code = paths.iter().filter(|path| !tests.contains(*path));
    code.map(|path| {
        let below = path.strip_prefix(&root).expect("below src");
        made_up(&below.to_str().expect("a plain name").replace('\\', "/"), &read(path))
    })
    .collect()
}

fn made_up(path: &str, text: &str) -> Source {
    Source { path: path.to_owned(), text: without_tests(&bare(text)) }
}

const TEST: &str = "#[cfg(test)]";

/// Files that a file declares as `#[cfg(test)] mod name;`.
fn test_files(path: &Path, text: &str) -> Vec<PathBuf> {
    let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
    let folder = path.parent().expect("below src");
    let folder = if ["mod", "lib", "main"].contains(&stem) { folder.to_owned() } else { folder.join(stem) };
    let declared = text.split(TEST).skip(1).filter_map(|after| {
        let words = tokens(after.lines().find(|line| !line.trim().is_empty())?);
        let at = words.iter().position(|word| word == "mod")?;
        (words.get(at + 2)? == ";").then(|| words[at + 1].clone())
    });
    declared.flat_map(|name| [folder.join(format!("{name}.rs")), folder.join(name).join("mod.rs")]).collect()
}

/// A bare text without what `#[cfg(test)]` stands before: up to its `;`, or to the brace that closes it.
fn without_tests(text: &str) -> String {
    let mut parts = text.split(TEST);
    let mut kept = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let mut depth = 0;
        let end = part.char_indices().find(|(_, c)| match c {
            '{' => {
                depth += 1;
                false
            }
            '}' => {
                depth -= 1;
                depth == 0
            }
            ';' => depth == 0,
            _ => false,
        });
        kept.push_str(end.map_or("", |(at, c)| &part[at + c.len_utf8()..]));
    }
    kept
}

/// A source text without comments, and with nothing between its quotes.
fn bare(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let raw = rest.strip_prefix('r').map(|after| after.len() - after.trim_start_matches('#').len());
        let in_word = out.chars().next_back().is_some_and(|c| c.is_alphanumeric() && c != 'b');
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if let (Some(hashes), false) = (raw.filter(|n| rest[1 + n..].starts_with('"')), in_word) {
            let open = 2 + hashes;
            let close = format!("\"{}", "#".repeat(hashes));
            rest[open..].find(&close).map_or(rest.len(), |end| open + end + close.len())
        } else if first == '"' {
            let mut escaped = false;
            let end = rest.char_indices().skip(1).find(|(_, c)| {
                let closes = *c == '"' && !escaped;
                escaped = *c == '\\' && !escaped;
                closes
            });
            end.map_or(rest.len(), |(at, _)| at + 1)
        } else if first == '\'' {
            character(rest)
        } else {
            0
        };
        if skipped == 0 {
            out.push(first);
            rest = &rest[first.len_utf8()..];
        } else {
            out.push(' ');
            rest = &rest[skipped..];
        }
    }
    out
}

/// Bytes of the character literal at the start of a text; 0 where the mark begins a lifetime.
fn character(text: &str) -> usize {
    let mut letters = text.char_indices().skip(1);
    match letters.next() {
        Some((_, '\\')) => text[3..].find('\'').map_or(text.len(), |end| 3 + end + 1),
        Some(_) => letters.next().filter(|(_, c)| *c == '\'').map_or(0, |(at, _)| at + 1),
        None => 0,
    }
}
