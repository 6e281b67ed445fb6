//! How much readers take in of what others wrote: every limit in one place, each with its reason.
//!
//! Readers ask for these before they take memory, and refuse with an error that says where, what was said, and what is
//! accepted. `docs/reference/limits.md` is written from this table.

/// One limit, as the reference tells it.
#[cfg_attr(not(test), allow(dead_code))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limit {
    /// What is read.
    pub of: &'static str,
    pub what: &'static str,
    pub most: u64,
    pub is_bytes: bool,
    pub why: &'static str,
}

/// A limit that the fuzzer meets earlier: it looks for what readers do to few bytes, and not at how long an honest million
/// takes.
const fn sooner(most: u64, fuzzed: u64) -> u64 {
    if cfg!(fuzzing) { fuzzed } else { most }
}

macro_rules! limits {
    ($($of:literal { $($name:ident = $most:expr, $unit:ident, $what:literal, $why:literal;)* })*) => {
        $($(
            #[doc = concat!($what, ": ", $why)]
            pub const $name: u64 = $most;
        )*)*

        /// All of them, in the order of the reference.
        #[cfg(test)]
        pub(crate) const ALL: &[Limit] = &[
            $($(Limit { of: $of, what: $what, most: $name, is_bytes: limits!(@$unit), why: $why },)*)*
        ];
    };
    (@bytes) => { true };
    (@count) => { false };
}

limits! {
    "Case files" {
        CASE_BYTES = 4 << 20, bytes, "size of the file",
            "a parsed TOML value takes some hundred times the two bytes that it may be written with";
        CASE_DEPTH = 80, count, "arrays and tables within one another, and names in one dotted key",
            "the TOML parser's own: each level is a call within a call";
        CASE_MISTAKES = 10_000, count, "mistakes that are kept",
            "the others are counted; nobody reads so many";
        SURFACES = 1 << 14, count, "shapes and lamps of one case",
            "each point looks at each; a finer thing is a mesh";
        OPTICS = 1 << 10, count, "mirrors, pieces of glass and diffuse surfaces of one case",
            "each is compared with each";
        POINTS = sooner(1 << 20, 1 << 10), count, "measurement points of one case",
            "each is kept with its exact value and its sums for every strategy and sample count";
        POINTS_AND_SURFACES = 1 << 28, count, "pairs of a measurement point and a surface",
            "none may touch: a second's work";
        POINTS_AND_FACES = 1 << 36, count, "pairs of a measurement point and a triangle of a mesh, or an edge of a polygon",
            "the same: a minute's, if every point lies in the box around them";
        POINTS_BEHIND_OPTICS = sooner(1 << 22, 1 << 12), count, "measurement points, times curved optics, times sources",
            "none may hide a source: some seconds' work";
        POLYGON_VERTICES = sooner(10_000, 200), count, "vertices of one polygon",
            "each edge is compared with each other one";
        VERTICES = sooner(40_000, 400), count, "vertices of all polygons of one case",
            "the same, for all of them";
        STUDY_ENTRIES = 1_000, count, "entries of a list of a study",
            "each is measured, and compared with those before it";
    }
    "Files that a case names" {
        NAMED_BYTES = 512 << 20, bytes, "size of all of them",
            "a case can name one file many times";
        MESH_BYTES = 256 << 20, bytes, "size of a mesh (OBJ)",
            "it is held in memory with its vertices and faces, eight times its size at most";
        OBJ_STATEMENT = 1 << 20, bytes, "length of a line of OBJ, what continues it included",
            "a face of so many corners is no face";
        TRIANGLES = sooner(64_000_000, 1 << 12), count, "triangles of one case, after `subdivide`",
            "their tree takes some 100 bytes each";
        SUBDIVIDE = 8, count, "levels of `subdivide`",
            "each has four times as many triangles";
        PICTURE_BYTES = 64 << 20, bytes, "size of a picture (PNG)",
            "eight times the largest picture that fits the texels, uncompressed";
        TEXELS = sooner(1 << 20, 1 << 10), count, "texels of one texture",
            "each is a surface element of its own for the exact side";
        TEXELS_IN_ALL = sooner(1 << 22, 1 << 11), count, "texels of all textures of one case",
            "the same, for all of them";
    }
    "Images of other renderers" {
        IMAGE_VALUES = 1 << 25, count, "pixels of all images together",
            "256 MiB of numbers; the size of an image is the manifest's, and a header that says another is refused";
        IMAGES = 1 << 20, count, "images",
            "each is compared with all before it, by its digest";
        NPY_HEADER = 1 << 12, bytes, "header of an array (NPY)",
            "longer ones are no headers of plain arrays";
        PFM_WORD = 32, bytes, "a word of a PFM header",
            "no number needs more";
        EXR_HEADER = 1 << 22, bytes, "header of an OpenEXR file",
            "with all of its attributes, which are skipped";
        EXR_PARTS = 1 << 12, count, "parts of an OpenEXR file",
            "each is an image";
        EXR_CHANNELS = 64, count, "channels of a part",
            "they are held together until one to three are chosen";
        IMAGE_MANIFEST = 1 << 20, bytes, "manifest of an exported scene",
            "ours take two kilobytes";
    }
    "Estimates and points of others" {
        LINE = 4096, bytes, "length of a line",
            "what is longer comes in pieces, none of which is an answer";
        ESTIMATES = 20_000_000, count, "numbers of one judgement, or points of all sets",
            "320 MB at most";
        REPLICATES = 4_000_000, count, "replicates, or point sets",
            "each takes some 100 bytes beside its numbers";
        SAMPLE_COUNTS = 1_000, count, "sample counts (N)",
            "each is judged by itself";
    }
    "Reports read back" {
        TABLE_BYTES = 4 << 30, bytes, "size of a table",
            "a million points at a dozen sample counts; tables are read row by row";
        ROW_BYTES = 1 << 20, bytes, "length of a row",
            "a row is held as a whole";
        COLUMNS = 1_000, count, "columns of a table",
            "ours have some twenty";
        MANIFEST_BYTES = 64 << 20, bytes, "size of manifest.json",
            "it is held as a whole";
        VIEW_BYTES = 16 << 20, bytes, "size of a picture beside the page",
            "the page holds them all";
        REPORT_CASES = 10_000, count, "cases of a report",
            "each has a section on the page and a plot of each kind";
        STRATEGIES = 250, count, "strategies of a case",
            "each is a line in every chart";
        SERIES = 1_000, count, "sample counts, and slopes, of a strategy",
            "each is looked up by every row";
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;
    use std::path::PathBuf;

    use super::*;

    const HEAD: &str = "\
# Limits

What others wrote is read as if somebody had broken it on purpose: each reader knows how much it takes in, asks before it takes
memory, and refuses the rest with the place, what was said, and what is accepted. A limit that you meet with an honest file is
worth an issue.

*(This page is written from the table that the readers ask: `cargo test --lib write_the_limits -- --ignored`.)*

## Paths

A case file names meshes and pictures by paths relative to itself, and they stay in the folder of the cases: the folder that was
given (`etendue run rooms/`: anywhere below `rooms`), or of a file that was given by itself the one that it lies in. An absolute path,
one that leaves by `..`, and a link that leads out are refused, and so is what is no regular file. `--allow-outside`, on every command
that reads cases, lets them name any file (in code: `Case::read_reaching`, `case::select_reaching`). Case files themselves may lie
anywhere, links and pipes included: their paths are yours.

`etendue verify`, `judge`, `run --points` and `report` open the files and folders that you name, and none that those name.

## Numbers

Lengths, exitances and other numbers of a case are finite and of ordinary size: [Case files](case-files.md#limits) has the ranges.
";

    fn page() -> String {
        let mut page = HEAD.to_owned();
        let mut of = "";
        for limit in ALL {
            if limit.of != of {
                of = limit.of;
                let _ = writeln!(page, "\n## {of}\n\n| | at most | because |\n|---|---|---|");
            }
            let _ = writeln!(page, "| {} | {} | {} |", limit.what, most(limit), limit.why);
        }
        page
    }

    fn most(limit: &Limit) -> String {
        match limit.most {
            n if limit.is_bytes && n >= 1 << 30 => format!("{} GiB", n >> 30),
            n if limit.is_bytes && n >= 1 << 20 => format!("{} MiB", n >> 20),
            n if limit.is_bytes && n >= 1 << 10 => format!("{} KiB", n >> 10),
            n if limit.is_bytes => format!("{n} bytes"),
            n => grouped(n),
        }
    }

    /// `16,777,216`.
    fn grouped(n: u64) -> String {
        let digits = n.to_string();
        let mut text = String::new();
        for (k, digit) in digits.chars().enumerate() {
            if k > 0 && (digits.len() - k).is_multiple_of(3) {
                text.push(',');
            }
            text.push(digit);
        }
        text
    }

    fn path() -> PathBuf {
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("docs/reference/limits.md")
    }

    /// To write it anew: `cargo test --lib write_the_limits -- --ignored`.
    #[test]
    fn the_committed_limits_are_the_codes() {
        let committed = std::fs::read_to_string(path()).unwrap_or_default();
        assert_eq!(committed, page(), "write it anew with `cargo test --lib write_the_limits -- --ignored`");
    }

    #[test]
    #[ignore = "writes docs/reference/limits.md"]
    fn write_the_limits() {
        std::fs::write(path(), page()).unwrap();
    }

    #[test]
    fn whole_units_are_told_whole() {
        for limit in ALL.iter().filter(|limit| limit.is_bytes && limit.most >= 1 << 10) {
            assert!(limit.most.trailing_zeros() >= 10 * (limit.most.ilog2() / 10), "{}", limit.what);
        }
        assert_eq!((grouped(16_777_216), grouped(80)), ("16,777,216".to_owned(), "80".to_owned()));
    }
}
