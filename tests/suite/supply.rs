//! What the house is built of: licences, doubles and origins of crates by `deny.toml`, without a network; no library of the
//! system; no `unsafe` of our own; the oldest compiler that is promised.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use toml::de::{DeTable, DeValue};

/// Crates that speak to a system by its C interface or build a library of their own (`links`, or a name in `-sys`), and why
/// nothing needs to be installed for them. A row that nothing uses fails the test.
const SYSTEM: &[(&str, &str)] = &[
    ("inotify-sys", "declarations alone; Linux, by notify"),
    ("js-sys", "declarations alone; the web, by plotters"),
    ("kqueue-sys", "declarations alone; BSD and macOS, by notify"),
    ("linux-raw-sys", "declarations alone; Linux, by rustix"),
    ("rayon-core", "links nothing: the key keeps two of them out of one program"),
    ("tikv-jemalloc-sys", "for who tunes rdst (cfg(tuning)): in the lock file, never in the build"),
    ("wasm-bindgen-shared", "links nothing: the key keeps two of them out of one program"),
    ("web-sys", "declarations alone; the web, by plotters"),
    ("windows-sys", "declarations alone; Windows"),
];

/// What stands in the lock file and in no build: for who tunes rdst, and conversions of nalgebra that nobody turns on.
const NEVER_BUILT: [&str; 5] =
    ["tikv-jemalloc-sys@0.5.4+5.3.0-patched", "glam@0.30.10", "glam@0.31.1", "glam@0.32.1", "glam@0.33.12"];

const CRATES_IO: &str = "registry+https://github.com/rust-lang/crates.io-index";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn text(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A value below the top of a TOML file, by its keys.
fn get<'t>(table: &'t DeTable<'t>, keys: &[&str]) -> &'t DeValue<'t> {
    let (first, rest) = keys.split_first().expect("a key");
    let value = table.get(*first).unwrap_or_else(|| panic!("there is no `{first}`")).get_ref();
    if rest.is_empty() { value } else { get(value.as_table().expect("a table"), rest) }
}

fn strings<'t>(value: &'t DeValue<'t>) -> Vec<&'t str> {
    value.as_array().expect("a list").iter().map(|item| item.get_ref().as_str().expect("a text")).collect()
}

/// A row of `Cargo.lock`.
#[derive(Clone, Debug)]
struct Locked {
    name: String,
    version: String,
    source: Option<String>,
    has_checksum: bool,
}

fn locked() -> Vec<Locked> {
    let text = text("Cargo.lock");
    let table = DeTable::parse(&text).expect("a lock file").into_inner();
    let rows = get(&table, &["package"]).as_array().expect("packages");
    let rows = rows.iter().map(|row| row.get_ref().as_table().expect("a package"));
    let said = |row: &DeTable, key: &str| row.get(key).map(|value| value.get_ref().as_str().unwrap().to_owned());
    rows.map(|row| Locked {
        name: said(row, "name").expect("a name"),
        version: said(row, "version").expect("a version"),
        source: said(row, "source"),
        has_checksum: row.contains_key("checksum"),
    })
    .collect()
}

/// What cargo knows of the crates.
struct Known {
    packages: Vec<serde_json::Value>,
    /// Whether those of other systems than this are among them: where all were fetched (`cargo fetch`, as `.ci/run` does).
    all: bool,
}

fn known() -> Known {
    let metadata = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO"));
        command.args(["metadata", "--format-version", "1", "--offline", "--locked", "--all-features"]).args(more);
        let output = command.current_dir(root()).output().expect("cargo runs");
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        let parsed = || serde_json::from_slice::<serde_json::Value>(&output.stdout).expect("JSON");
        if output.status.success() { Ok(parsed()) } else { Err(error) }
    };
    let packages = |found: serde_json::Value| found["packages"].as_array().expect("packages").clone();
    if let Ok(whole) = metadata(&[]) {
        return Known { packages: packages(whole), all: true };
    }
    let host = Command::new(env!("CARGO")).args(["-vV"]).output().expect("cargo runs");
    let host = String::from_utf8(host.stdout).expect("text");
    let host = host.lines().find_map(|line| line.strip_prefix("host: ")).expect("a host");
    let found = metadata(&["--filter-platform", host]).unwrap_or_else(|error| panic!("cargo metadata: {error}"));
    Known { packages: packages(found), all: false }
}

fn field<'p>(package: &'p serde_json::Value, key: &str) -> &'p str {
    package[key].as_str().unwrap_or_default()
}

/// Licences that an expression (SPDX, or with `/` for OR as older crates have it) cannot do without under a permission;
/// `None` where it is not allowed.
fn needed<'e>(expression: &'e str, allowed: &dyn Fn(&str) -> bool) -> Option<BTreeSet<&'e str>> {
    let expression = expression.trim();
    for (word, all) in [(" OR ", false), ("/", false), (" AND ", true)] {
        let parts = split_outside(expression, word);
        if parts.len() < 2 {
            continue;
        }
        let parts: Vec<Option<BTreeSet<&str>>> = parts.into_iter().map(|part| needed(part, allowed)).collect();
        return if all {
            parts.into_iter().try_fold(BTreeSet::new(), |sum, part| Some(&sum | &part?))
        } else {
            parts.into_iter().flatten().min_by_key(BTreeSet::len)
        };
    }
    match expression.strip_prefix('(').and_then(|inner| inner.strip_suffix(')')) {
        Some(inner) => needed(inner, allowed),
        None => allowed(expression).then(|| BTreeSet::from([expression])),
    }
}

/// Parts of a text between a word, where it does not stand in parentheses.
fn split_outside<'e>(text: &'e str, word: &str) -> Vec<&'e str> {
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    for (at, c) in text.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ => {}
        }
        if depth == 0 && at >= start && text[at..].starts_with(word) {
            parts.push(&text[start..at]);
            start = at + word.len();
        }
    }
    parts.push(&text[start..]);
    parts
}

#[test]
fn every_licence_is_permitted_and_every_permission_needed() {
    let rules = text("deny.toml");
    let rules = DeTable::parse(&rules).expect("deny.toml").into_inner();
    let allowed: Vec<&str> = strings(get(&rules, &["licenses", "allow"]));
    let known = known();
    let mut used = BTreeSet::new();
    for package in &known.packages {
        let (name, license) = (field(package, "name"), field(package, "license"));
        let needed = needed(license, &|one| allowed.contains(&one))
            .unwrap_or_else(|| panic!("{name} may be had under `{license}` alone; deny.toml allows {allowed:?}"));
        used.extend(needed.into_iter().map(str::to_owned));
    }
    assert!(known.packages.len() > 50, "{} crates", known.packages.len());
    for allowed in allowed {
        assert!(!known.all || used.contains(allowed), "deny.toml allows {allowed}, which no crate needs: remove it");
    }
}

#[test]
fn licence_expressions_are_read_as_they_are_meant() {
    let one = |one: &str| ["MIT", "Zlib", "Apache-2.0 WITH LLVM-exception"].contains(&one);
    let of = |expression: &'static str| needed(expression, &one).map(|set| set.into_iter().collect::<Vec<_>>());
    assert_eq!(of("MIT"), Some(vec!["MIT"]));
    assert_eq!(of("GPL-3.0-only"), None);
    assert_eq!(of("GPL-3.0-only OR MIT"), Some(vec!["MIT"]));
    assert_eq!(of("GPL-3.0-only/MIT"), Some(vec!["MIT"]));
    assert_eq!(of("MIT AND GPL-3.0-only"), None);
    assert_eq!(of("MIT AND Zlib"), Some(vec!["MIT", "Zlib"]));
    assert_eq!(of("(GPL-3.0-only OR MIT) AND Zlib"), Some(vec!["MIT", "Zlib"]));
    assert_eq!(of("(MIT OR GPL-3.0-only) AND (GPL-2.0-only OR ISC)"), None);
    assert_eq!(of("GPL-3.0-only AND MIT OR Zlib"), Some(vec!["Zlib"]));
    assert_eq!(of("Apache-2.0 WITH LLVM-exception"), Some(vec!["Apache-2.0 WITH LLVM-exception"]));
    assert_eq!(of("Apache-2.0"), None);
    assert_eq!(of(""), None);
}

#[test]
fn every_crate_comes_from_where_all_come_from_as_it_was() {
    for Locked { name, version, source, has_checksum } in locked() {
        let own = name == env!("CARGO_PKG_NAME");
        assert_eq!(source.as_deref(), (!own).then_some(CRATES_IO), "{name} {version}");
        assert_eq!(has_checksum, !own, "{name} {version}");
    }
    let rules = text("deny.toml");
    let rules = DeTable::parse(&rules).expect("deny.toml").into_inner();
    let registries = strings(get(&rules, &["sources", "allow-registry"]));
    assert_eq!(registries.iter().map(|at| format!("registry+{at}")).collect::<Vec<_>>(), [CRATES_IO]);
    assert!(strings(get(&rules, &["sources", "allow-git"])).is_empty());
    for what in ["unknown-registry", "unknown-git"] {
        assert_eq!(get(&rules, &["sources", what]).as_str(), Some("deny"), "{what}");
    }
}

/// Of several versions all but the newest are named, each with its reason; what is named is there.
#[test]
fn every_double_is_named_with_its_reason() {
    let mut versions: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for row in locked() {
        versions.entry(row.name).or_default().push(row.version);
    }
    let number = |version: &String| -> Vec<u64> {
        version.split(['.', '+', '-']).map_while(|part| part.parse().ok()).collect()
    };
    let mut doubles = BTreeSet::new();
    for (name, mut versions) in versions {
        versions.sort_by_key(number);
        versions.pop();
        doubles.extend(versions.into_iter().map(|version| format!("{name}@{version}")));
    }
    let rules = text("deny.toml");
    let rules = DeTable::parse(&rules).expect("deny.toml").into_inner();
    assert_eq!(get(&rules, &["bans", "multiple-versions"]).as_str(), Some("deny"));
    let skipped = get(&rules, &["bans", "skip"]).as_array().expect("a list").iter();
    let named: BTreeSet<String> = skipped
        .map(|row| {
            let row = row.get_ref().as_table().expect("a table");
            let said = |key: &str| get(row, &[key]).as_str().expect("a text").to_owned();
            assert!(said("reason").len() > 5, "{} has no reason", said("crate"));
            said("crate")
        })
        .collect();
    let unbuilt: BTreeSet<String> = NEVER_BUILT.map(str::to_owned).into_iter().collect();
    doubles.retain(|double| !unbuilt.contains(double));
    let unnamed: Vec<_> = doubles.difference(&named).collect();
    let gone: Vec<_> = named.difference(&doubles).collect();
    assert!(unnamed.is_empty(), "older versions beside newer ones, not named in deny.toml: {unnamed:?}");
    assert!(gone.is_empty(), "no longer there: {gone:?}; remove them from deny.toml");
}

#[test]
fn nothing_of_the_system_is_needed() {
    let of_name = locked().into_iter().map(|row| row.name).filter(|name| name.ends_with("-sys"));
    let known = known();
    let linking = known.packages.iter().filter(|package| !package["links"].is_null());
    let found: BTreeSet<String> = of_name.chain(linking.map(|package| field(package, "name").to_owned())).collect();
    for name in &found {
        assert!(SYSTEM.iter().any(|(listed, _)| listed == name), "{name} needs a reason, or another crate");
    }
    for (name, reason) in SYSTEM {
        // Whether a key is there is told by the crate alone, which may not have been fetched.
        let is_told = known.all || name.ends_with("-sys");
        assert!(!is_told || found.contains(*name), "{name} is gone ({reason}): remove the row");
    }
    // What cargo would build here, tests and all.
    let tree = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--locked", "--all-features", "--prefix", "none", "--format", "{p}"])
        .current_dir(root())
        .output()
        .expect("cargo runs");
    assert!(tree.status.success(), "{}", String::from_utf8_lossy(&tree.stderr));
    let tree = String::from_utf8(tree.stdout).expect("text");
    let named = |line: &str| {
        let mut words = line.split_whitespace();
        Some(format!("{}@{}", words.next()?, words.next()?.trim_start_matches('v')))
    };
    let built: BTreeSet<String> = tree.lines().filter_map(named).collect();
    assert!(built.iter().any(|name| name.starts_with("glam@")) && built.len() > 50, "{built:?}");
    let locked: BTreeSet<String> = locked().into_iter().map(|row| format!("{}@{}", row.name, row.version)).collect();
    for name in NEVER_BUILT {
        assert!(locked.contains(name), "{name} is gone: remove it");
        assert!(!built.contains(name), "{name} is built");
    }
}

/// `forbid` cannot be taken back below: not by a room, not by a test.
#[test]
fn unsafe_is_forbidden_to_library_program_tests_and_examples() {
    let manifest = text("Cargo.toml");
    let manifest = DeTable::parse(&manifest).expect("Cargo.toml").into_inner();
    assert_eq!(get(&manifest, &["lints", "rust", "unsafe_code"]).as_str(), Some("forbid"));
    // Whoever reads the crate's root, and has no Cargo.toml at hand.
    assert!(text("src/lib.rs").contains("\n#![forbid(unsafe_code)]\n"));
}

/// The compiler that `Cargo.toml` promises is the one that the README names and `.ci/run` tries; no crate asks for a newer.
#[test]
fn the_oldest_compiler_is_said_alike_everywhere() {
    let promised = env!("CARGO_PKG_RUST_VERSION");
    assert!(text("README.md").contains(&format!("({promised} or newer)")), "the README does not name {promised}");
    assert!(text(".ci/run").contains("rust-version"), ".ci/run does not read it from Cargo.toml");
    let number = |version: &str| -> Vec<u64> { version.split('.').map_while(|part| part.parse().ok()).collect() };
    for package in known().packages {
        let asked = field(&package, "rust_version");
        assert!(
            number(asked) <= number(promised) || asked == format!("{promised}.0"),
            "{} {asked}",
            field(&package, "name")
        );
    }
}
