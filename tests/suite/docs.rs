//! The pages of `docs/` are worked through as a stranger would: every file saved, every command run, what is shown compared.
//!
//! On a page, in order, in one folder of its own:
//!
//! - a block below a line that ends in "as `NAME`:" is saved under that name, below "to `NAME`:" added to that file;
//! - a block of `sh` is run; it must succeed, or end as it says itself (`# exit code 1`);
//! - a block of `text` is what the commands before it printed; `…` stands for anything, alone in a line for any lines;
//! - any other must say why it is not run: `<!-- not run: … -->`.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A fenced block: the last line of text before it, what language it says it is in, its lines, and the line it begins at.
#[derive(Debug)]
struct Block<'a> {
    before: &'a str,
    language: &'a str,
    text: String,
    line: usize,
}

fn blocks(page: &str) -> Vec<Block<'_>> {
    let (mut found, mut before, mut lines) = (Vec::new(), "", page.lines().enumerate());
    while let Some((at, line)) = lines.next() {
        if let Some(language) = line.strip_prefix("```") {
            let inside = lines.by_ref().map(|(_, line)| line).take_while(|line| *line != "```");
            let text: String = inside.flat_map(|line| [line, "\n"]).collect();
            found.push(Block { before, language, text, line: at + 1 });
            before = "";
        } else if !line.trim().is_empty() {
            before = line;
        }
    }
    found
}

/// The name between the last two backticks of a line that ends in "…WORD `NAME`:".
fn named<'a>(line: &'a str, word: &str) -> Option<&'a str> {
    let (rest, name) = line.strip_suffix("`:")?.rsplit_once('`')?;
    rest.ends_with(&format!("{word} ")).then_some(name)
}

/// Whether a line is the one shown, `…` standing for anything.
fn is_line(shown: &str, line: &str) -> bool {
    let mut parts = shown.trim_end().split('…').peekable();
    let first = parts.next().unwrap_or("");
    let Some(mut rest) = line.trim_end().strip_prefix(first) else { return false };
    if parts.peek().is_none() {
        return rest.is_empty();
    }
    while let Some(part) = parts.next() {
        if parts.peek().is_none() {
            return rest.ends_with(part);
        }
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    true
}

/// Whether that was printed; else the first part of what is shown that was not.
fn compare(shown: &str, printed: &str) -> Result<(), String> {
    let printed: Vec<&str> = printed.trim_matches('\n').lines().collect();
    let shown: Vec<&str> = shown.trim_matches('\n').lines().collect();
    let chunks: Vec<&[&str]> = shown.split(|line| line.trim() == "…").collect();
    let mut at = 0;
    for (k, chunk) in chunks.iter().enumerate() {
        let last = printed.len().checked_sub(chunk.len()).ok_or_else(|| chunk.join("\n"))?;
        let anchored = if k == 0 { 0..=0 } else { at..=last };
        let anchored = if k + 1 == chunks.len() { last.max(*anchored.start())..=*anchored.end() } else { anchored };
        let fits = |from: &usize| {
            printed
                .get(*from..*from + chunk.len())
                .is_some_and(|lines| chunk.iter().zip(lines).all(|(shown, line)| is_line(shown, line)))
        };
        at = anchored.clone().find(fits).ok_or_else(|| chunk.join("\n"))? + chunk.len();
    }
    Ok(())
}

#[test]
fn what_is_shown_is_compared() {
    let printed = "a 1\nb\nfinished in 0.3 s\nd\n";
    for shown in [
        "a 1\nb\nfinished in 0.3 s\nd\n",
        "a 1\n…\nd\n",
        "…\nb\nfinished in … s\n…\n",
        "…\nd",
        "a …\n…",
        "a 1\nb\n…\nfinished …\nd",
    ] {
        assert_eq!(compare(shown, printed), Ok(()), "{shown}");
    }
    for shown in ["a 1\nb\n", "b\n…", "…\nb", "…\nd\n…\nb\n…", "a 2\n…", "a 1\n…\nfinished in … ms\n…", "…\ne\n…"]
    {
        assert!(compare(shown, printed).is_err(), "{shown}");
    }
}

fn markdown_below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder of the repository") {
        let path = entry.expect("it can be listed").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        // What builds, runs and other people's tools leave behind is not ours to read.
        if name.starts_with('.') || ["target", "latest", "convergence", "shared"].contains(&&*name) {
            continue;
        }
        if path.is_dir() {
            markdown_below(&path, found);
        } else if name.ends_with(".md") {
            found.push(path);
        }
    }
}

/// A text without its fenced blocks and its code between backticks, in which brackets are no links.
fn prose(text: &str) -> String {
    let mut fenced = false;
    let lines = text.lines().filter(|line| {
        let is_fence = line.trim_start().starts_with("```");
        fenced ^= is_fence;
        !fenced && !is_fence
    });
    lines.map(|line| line.split('`').step_by(2).collect::<Vec<_>>().join("`")).collect::<Vec<_>>().join("\n")
}

/// What a heading is called in a link, as GitHub does it.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = text
        .lines()
        .filter_map(|line| line.trim_start_matches('#').strip_prefix(' ').filter(|_| line.starts_with('#')));
    let slug = |heading: &str| -> String {
        let kept =
            heading.to_lowercase().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect::<String>();
        kept.replace(' ', "-")
    };
    headings.map(slug).collect()
}

#[test]
fn every_link_of_every_page_leads_somewhere() {
    let mut pages = Vec::new();
    markdown_below(root(), &mut pages);
    let mut followed = 0;
    for page in &pages {
        let text = fs::read_to_string(page).unwrap_or_else(|error| panic!("{}: {error}", page.display()));
        for rest in prose(&text).split("](").skip(1) {
            let (target, _) =
                rest.split_once(')').unwrap_or_else(|| panic!("{}: a link is not closed", page.display()));
            if target.contains("://") || target.starts_with("mailto:") {
                continue;
            }
            let (file, anchor) = target.split_once('#').map_or((target, None), |(file, anchor)| (file, Some(anchor)));
            let to = if file.is_empty() { page.clone() } else { page.parent().expect("a folder").join(file) };
            assert!(to.exists(), "{} links to {target}, which does not exist", page.display());
            if let Some(anchor) = anchor {
                let there = anchors(&fs::read_to_string(&to).unwrap_or_default());
                assert!(there.contains(anchor), "{} links to {target}; its headings are {there:?}", page.display());
            }
            followed += 1;
        }
    }
    assert!(pages.len() > 15 && followed > 60, "{followed} links of {} pages were followed", pages.len());
}

#[test]
fn the_index_names_every_page() {
    let docs = root().join("docs");
    let index = fs::read_to_string(docs.join("README.md")).unwrap();
    let mut pages = Vec::new();
    markdown_below(&docs, &mut pages);
    for page in pages.iter().filter(|page| **page != docs.join("README.md")) {
        let name = page.strip_prefix(&docs).unwrap().to_string_lossy().replace('\\', "/");
        assert!(index.contains(&format!("({name})")), "docs/README.md does not name {name}");
    }
    assert!(fs::read_to_string(root().join("README.md")).unwrap().contains("(docs/README.md)"));
}

/// In each paragraph of `docs/mathematics.md` that says where its code is: files, and tests that stand in one of them.
#[test]
fn the_mathematics_names_code_and_witnesses_that_exist() {
    let text = fs::read_to_string(root().join("docs/mathematics.md")).unwrap();
    let (mut files, mut witnesses) = (0, 0);
    for paragraph in text.split("\n\n") {
        let code: Vec<&str> = paragraph.split('`').skip(1).step_by(2).collect();
        let (paths, names): (Vec<&str>, Vec<&str>) = code.into_iter().partition(|code| code.contains('/'));
        let read =
            |path: &&str| fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"));
        let sources: Vec<String> = paths.iter().map(read).collect();
        for name in &names {
            let is_word = |source: &String| {
                source.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|word| word == *name)
            };
            assert!(sources.iter().any(is_word), "{name} is in none of {paths:?}");
        }
        assert_eq!(paragraph.starts_with("Code: "), paths.len() > 1, "{paragraph}");
        assert!(!paragraph.starts_with("Code: ") || !names.is_empty(), "no witness: {paragraph}");
        (files, witnesses) = (files + paths.len(), witnesses + names.len());
    }
    assert!(files > 25 && witnesses > 15, "{files} files, {witnesses} witnesses");
}

#[cfg(all(feature = "cli", feature = "plots", unix))]
mod worked_through {
    use super::*;
    use std::process::Command;

    /// One page's folder, and where in it the last commands have left off.
    struct Desk {
        folder: tempfile::TempDir,
        at: PathBuf,
    }

    impl Desk {
        /// A folder in which `etendue` is this program, the crate is this one, and nothing is fetched.
        fn new() -> Desk {
            let folder = tempfile::tempdir().unwrap();
            let at = folder.path().canonicalize().unwrap();
            fs::create_dir(at.join(".cargo")).unwrap();
            let patch = format!("[net]\noffline = true\n[patch.crates-io]\netendue.path = {:?}\n", root());
            fs::write(at.join(".cargo/config.toml"), patch).unwrap();
            Desk { folder, at }
        }

        fn save(&self, name: &str, text: &str, append: bool) {
            let path = self.at.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            let before = if append { fs::read_to_string(&path).unwrap() } else { String::new() };
            fs::write(path, before + text).unwrap();
        }

        /// What the commands print, on both outputs, and how they end.
        fn run(&mut self, commands: &str) -> (Option<i32>, String) {
            let binary = Path::new(env!("CARGO_BIN_EXE_etendue")).parent().unwrap();
            let path = format!("{}:{}", binary.display(), std::env::var("PATH").unwrap_or_default());
            let left_off = self.folder.path().join(".left-off");
            let script =
                format!("exec 2>&1\ntrap 'pwd >{:?}' EXIT\nset -e\n{commands}", left_off.display().to_string());
            let mut bash = Command::new("bash");
            bash.args(["-c", &script]).current_dir(&self.at).env("PATH", path);
            // Built once for all pages, and kept for the next `cargo test`.
            bash.env("CARGO_TARGET_DIR", Path::new(env!("CARGO_TARGET_TMPDIR")).join("docs"));
            bash.env("CARGO_TERM_COLOR", "never").env("RUST_BACKTRACE", "0").env("CARGO_PROFILE_DEV_DEBUG", "false");
            let output = bash.output().expect("bash");
            self.at = PathBuf::from(fs::read_to_string(left_off).unwrap().trim_end());
            (output.status.code(), String::from_utf8(output.stdout).unwrap())
        }
    }

    fn has_python() -> bool {
        Command::new("python3").arg("--version").output().is_ok()
    }

    fn work_through(name: &str) {
        let page =
            fs::read_to_string(root().join("docs").join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        if page.contains("python3") && !has_python() {
            return;
        }
        let (mut desk, mut printed, mut ran) = (Desk::new(), None, 0);
        for block in blocks(&page) {
            let Block { before, language, text, line } = &block;
            let place = format!("docs/{name}:{line}");
            if before.starts_with("<!-- not run: ") {
            } else if let Some(file) = named(before, "as") {
                desk.save(file, text, false);
            } else if let Some(file) = named(before, "to") {
                desk.save(file, text, true);
            } else if *language == "sh" {
                let (code, said) = desk.run(text);
                let expected = text.rsplit_once("# exit code ").map_or("0", |(_, code)| code.trim());
                assert_eq!(code.map(|code| code.to_string()).as_deref(), Some(expected), "{place}\n{text}\n{said}");
                printed = Some(said);
                ran += 1;
            } else if *language == "text" {
                let said = printed.take().unwrap_or_else(|| panic!("{place}: nothing was run before"));
                if let Err(missing) = compare(text, &said) {
                    panic!("{place} shows\n{missing}\nwhich was not printed where it stands; printed was\n{said}");
                }
            } else {
                panic!("{place}: a block of {language:?} that is neither saved nor run, below {before:?}");
            }
        }
        assert!(ran > 0, "docs/{name}: nothing was run");
    }

    macro_rules! pages {
        ($($test:ident: $page:literal,)*) => {
            $(#[test] fn $test() { work_through($page) })*

            #[test]
            fn every_page_that_shows_a_command_is_worked_through() {
                let mut pages = Vec::new();
                markdown_below(&root().join("docs"), &mut pages);
                let with_commands = pages.iter().filter(|page| fs::read_to_string(page).unwrap().contains("```sh"));
                let found: BTreeSet<PathBuf> = with_commands.cloned().collect();
                let known = [$($page),*].map(|page| root().join("docs").join(page));
                assert_eq!(found, known.into_iter().collect());
            }
        };
    }

    pages! {
        the_tutorial: "tutorial.md",
        how_to_run_the_suite: "how-to/run-the-suite.md",
        how_to_judge_in_cargo_test: "how-to/judge-in-cargo-test.md",
        how_to_judge_through_a_pipe: "how-to/judge-through-a-pipe.md",
        how_to_judge_images: "how-to/judge-images.md",
        how_to_write_a_case: "how-to/write-a-case.md",
        how_to_compare_two_runs: "how-to/compare-two-runs.md",
        how_to_run_in_continuous_integration: "how-to/continuous-integration.md",
        how_to_run_large_studies: "how-to/large-studies.md",
    }
}
