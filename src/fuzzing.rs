//! What others wrote, as bytes in memory, through the reader of its kind: for `fuzz/`, and for the inputs that are kept.
//!
//! A reader answers with a value or an error. That it answers at all, soon, and without a panic is all that is asked here.

use std::path::PathBuf;
use std::sync::LazyLock;

use crate::case::{self, Case, CaseErrors, Ink};
use crate::configuration::Configuration;
use crate::external::Manifest;
use crate::external::image::Stack;
use crate::{guest, journal, report};

/// Takes what may be anything.
pub type Reader = fn(&[u8]);

/// Every reader by the name of its target.
pub const READERS: [(&str, Reader); 12] = [
    ("case", case),
    ("obj", obj),
    ("png", png),
    ("pfm", image),
    ("npy", image),
    ("exr", image),
    ("manifest", manifest),
    ("estimates", estimates),
    ("points", points),
    ("report", report),
    ("plots", plots),
    ("units", units),
];

/// Files that a case of [`case`] may name.
static FILES: &[(&str, &[u8])] = &[
    ("m.obj", b"v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n"),
    ("broken.obj", b"v 0 0 1\nf 1 2 3\n"),
    ("p.png", include_bytes!("../cases/texture/cross.png")),
    ("broken.png", b"\x89PNG\r\n\x1a\n"),
];

/// A case file, its mistakes told in both inks.
pub fn case(bytes: &[u8]) {
    match Case::from_memory(bytes, FILES) {
        Ok(case) => drop(case.configuration.digest()),
        Err(found) => told(&found, bytes),
    }
}

fn told(found: &CaseErrors, bytes: &[u8]) {
    // Where there are many mistakes, drawing them takes longer than finding them.
    if found.mistakes().len() < 4 || is_chosen(bytes) {
        found.render(Ink::Plain);
        found.render(Ink::Coloured);
    }
    for mistake in found.mistakes() {
        assert!(mistake.line() >= 1 && mistake.column() >= 1, "{mistake}");
        found.underlined(mistake);
    }
}

/// A mesh.
pub fn obj(bytes: &[u8]) {
    if let Err(error) = case::obj::read(bytes) {
        drop(error.to_string());
    }
}

/// A picture as a texture.
pub fn png(bytes: &[u8]) {
    let _ = case::check_picture(bytes);
}

/// An image of another renderer, as one of each of these sizes.
pub fn image(bytes: &[u8]) {
    for size in [[1, 1], [2, 2], [3, 2], [64, 48]] {
        if let Err(error) = Stack::from_memory(bytes, size) {
            drop(error.to_string());
        }
    }
}

/// A manifest of such images.
pub fn manifest(bytes: &[u8]) {
    static ECLIPSE: LazyLock<Configuration> =
        LazyLock::new(|| Case::shipped("penumbra/eclipse").expect("it is shipped").configuration);
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = Manifest::parse(text, &ECLIPSE);
    }
}

/// Estimates of another program, of a case with three points.
pub fn estimates(bytes: &[u8]) {
    if let Err(error) = guest::estimates_from_memory(bytes, 3) {
        drop(error.to_string());
    }
}

/// Sets of points.
pub fn points(bytes: &[u8]) {
    if let Err(error) = guest::sets_from_memory(bytes) {
        drop(error.to_string());
    }
}

/// A report: its page, and what a comparison with itself says.
pub fn report(bytes: &[u8]) {
    report::try_page(&files(bytes));
}

/// A report: its plots.
pub fn plots(bytes: &[u8]) {
    report::try_plots(&files(bytes), is_chosen(bytes));
}

/// Whether what takes long is done for an input: of those of the fuzzer for one in thirty-two.
fn is_chosen(bytes: &[u8]) -> bool {
    !cfg!(fuzzing) || bytes.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte)) < 8
}

/// The files of a report, one after the other, each after a line of its own: `=` and its name.
fn files(bytes: &[u8]) -> Vec<(&'static str, Vec<u8>)> {
    let mut files: Vec<(&'static str, Vec<u8>)> = Vec::new();
    for line in bytes.split_inclusive(|byte| *byte == b'\n') {
        let named = line.strip_prefix(b"=").and_then(|rest| std::str::from_utf8(rest).ok()).map(str::trim);
        match named.and_then(report::file_named) {
            Some(name) => files.push((name, Vec::new())),
            None => files.iter_mut().last().into_iter().for_each(|(_, content)| content.extend(line)),
        }
    }
    files
}

/// A file of units, as it stands; and the same bytes as bodies of frames whose checksums are right, so that what is behind them
/// is read, too. A byte before each body says how long it is, and of what kind.
pub fn units(bytes: &[u8]) {
    let _ = journal::try_bytes(bytes);
    let _ = journal::try_bodies(bytes);
}

/// Where inputs are kept that were found, or thought of: a folder for each target.
pub fn kept() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/fuzz")
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;

    /// What a kept input may take, of a few bytes; and a made one, of megabytes.
    const A_MOMENT: Duration = Duration::from_secs(1);
    const A_WHILE: Duration = Duration::from_secs(10);

    /// An answer, and soon: the quickest of three times counts, the machine may be busy.
    fn answers(reader: Reader, bytes: &[u8], within: Duration, name: &str) {
        let took = |_| {
            let begun = Instant::now();
            let caught = std::panic::catch_unwind(|| reader(bytes));
            assert!(caught.is_ok(), "{name}: the reader panics");
            begun.elapsed()
        };
        let quickest = (0..3).map(took).find(|took| *took < within);
        assert!(quickest.is_some(), "{name}: no answer within {within:?}");
    }

    #[test]
    fn every_kept_input_is_answered() {
        let mut fed = 0;
        for (target, reader) in READERS {
            // A report's page and its plots are made from the same files.
            let folders = if target == "plots" { vec!["report", "plots"] } else { vec![target] };
            let before = fed;
            for folder in folders {
                let Ok(entries) = std::fs::read_dir(kept().join(folder)) else { continue };
                for entry in entries {
                    let path = entry.unwrap().path();
                    answers(reader, &std::fs::read(&path).unwrap(), A_MOMENT, &path.display().to_string());
                    fed += 1;
                }
            }
            // A package has no `tests/`.
            assert!(fed > before || !kept().parent().is_some_and(std::path::Path::is_dir), "{target}: none is kept");
        }
    }

    /// Large inputs, told in few words.
    fn made() -> Vec<(&'static str, &'static str, Vec<u8>)> {
        const MANY: usize = 1_000_000;
        let list = |head: &str, item: &str, n: usize, tail: &str| [head, &item.repeat(n), tail].concat().into_bytes();
        let numbers: String = (1..500_000).map(|k| format!("{k},")).collect();
        let keys: String = (0..300_000).map(|k| format!("k{k}=1\n")).collect();
        let sets = "0 0\n\n".repeat(MANY);
        let cells: String = (1..50_000).map(|k| format!("0,0,{k},1\n")).collect();
        let columns: String = (0..MANY).map(|k| format!(",c{k}")).collect();
        let verdicts = "=verdicts.csv\ncase,strategy,property,verdict,evidence,threshold,effect,effect_low,effect_high,\
                        smallest_bias_mean,smallest_bias_point,reproduce\n";
        let cases: String = (0..50_000).map(|k| format!("{k},random,bias,pass,,,,,,,,\n")).collect();
        let strategies: String = (0..50_000).map(|k| format!("a,s{k},bias,pass,,,,,,,,\n")).collect();
        vec![
            ("case", "a million entries", list("[measure]\ngrid = [", "1,", MANY, "]\n")),
            ("case", "a million mistakes", list("[measure]\ngrid = [", "nan,", MANY, "]\n")),
            ("case", "a million wrong names", list("[study]\nstrategies = [", "\"\",", MANY, "]\n")),
            ("case", "half a million sample counts", format!("[study]\nsamples = [{numbers}]\n").into_bytes()),
            ("case", "a million empty shapes", list("source = {disk = [", "{},", MANY, "]}\n")),
            ("case", "many tables", list("", "[[source.disk]]\n", 200_000, "")),
            ("case", "many unknown keys", keys.into_bytes()),
            ("case", "nothing but signs", vec![b'='; 4 << 20]),
            ("case", "nothing but brackets", vec![b'['; 4 << 20]),
            ("case", "nothing but quotes", b"\"\n".repeat(2 << 20)),
            ("case", "nothing but lines", b"]\n".repeat(2 << 20)),
            ("case", "nothing but strange bytes", vec![0xff; 4 << 20]),
            ("case", "more than is read", vec![b'#'; (4 << 20) + 1]),
            ("obj", "a corner of slashes", list("v 0 0 0\nf ", "/", 10 * MANY, "\n")),
            ("obj", "a vertex of a million numbers", list("v ", "0 ", MANY, "\n")),
            ("obj", "a face of a million corners", list("v 0 0 0\nv 1 0 0\nv 0 1 0\nf ", "1 2 3 ", MANY, "\n")),
            ("obj", "a million continued lines", list("v 0 0 0", "\\\n", MANY, "")),
            ("obj", "a million faces", list("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "f 1 2 3\n", MANY, "")),
            ("npy", "a million images", {
                let header =
                    b"\x93NUMPY\x01\0\x42\0{'descr': '<f2', 'fortran_order': False, 'shape': (2000000, 1, 1)}";
                let mut bytes = [&header[..], &[b' '; 66]].concat();
                bytes.truncate(10 + 0x42);
                bytes.extend(vec![0; 4_000_000]);
                bytes
            }),
            ("estimates", "a million columns", list("point,replicate,samples,value", ",value", MANY, "\n0,0,1,1\n")),
            ("estimates", "many sample counts", cells.into_bytes()),
            ("points", "a million sets", sets.into_bytes()),
            ("report", "a million columns", format!("=verdicts.csv\ncase{columns}\n").into_bytes()),
            ("report", "a quote that is never closed", list(&format!("{verdicts}a,\""), "bias\n", MANY, "")),
            ("report", "many cases", format!("{verdicts}{cases}").into_bytes()),
            ("report", "many strategies", format!("{verdicts}{strategies}").into_bytes()),
        ]
    }

    #[test]
    fn large_inputs_are_answered() {
        for (target, name, bytes) in made() {
            let (_, reader) = READERS.iter().find(|(known, _)| *known == target).unwrap();
            answers(*reader, &bytes, A_WHILE, &format!("{target}: {name}"));
        }
    }
}
