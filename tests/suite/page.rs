//! The report's page: made again from its tables byte for byte, whatever is missing told, and used in a browser.
//!
//! The browser's part needs Chromium (`.ci/run` installs it) and says so where there is none; with
//! `ETENDUE_CHROMIUM=required` a missing one is a failure.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use assert_cmd::cargo::CommandCargoExt;
use serde_json::Value;

/// A name and a title that would be a script if they were not escaped.
const SCRIPT_NAME: &str = "<script>alert(1)<.toml";
const SCRIPT_CASE: &str = r#"
title = "</script><img src=x onerror=alert(2)> & \"quotes\""
[[source.disk]]
center = [0.0, 0.0, 2.0]
normal = [0.0, 0.0, -1.0]
radius = 0.5
exitance = 1.0
[[occluder.disk]]
center = [0.0, 0.0, 1.0]
normal = [0.0, 0.0, 1.0]
radius = 0.35
[receiver.rectangle]
center = [0.0, 0.0, 0.0]
edge_u = [4.0, 0.0, 0.0]
edge_v = [0.0, 4.0, 0.0]
[measure]
line = { from = [0.0, 0.0, 0.0], to = [1.5, 0.0, 0.0], points = 9 }
"#;

fn etendue() -> Command {
    Command::cargo_bin("etendue").expect("our binary")
}

/// A small report of every kind of case, made once.
fn report() -> &'static Path {
    static MADE: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, report) = MADE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let (case, report) = (folder.path().join(SCRIPT_NAME), folder.path().join("report"));
        fs::write(&case, SCRIPT_CASE).unwrap();
        let shipped =
            ["penumbra/three-regions", "caustic/paraboloid", "direct/disk-receiver", "interreflection/furnace"];
        let run = etendue()
            .arg("run")
            .args(shipped)
            .arg(&case)
            .args(["--quick", "--samples", "1,4,16", "--replicates", "40", "--quiet", "--out"])
            .arg(&report)
            .output()
            .unwrap();
        assert!(matches!(run.status.code(), Some(0 | 3)), "{}", String::from_utf8_lossy(&run.stderr));
        (folder, report)
    });
    report
}

/// A copy of the report to spoil.
fn copied() -> tempfile::TempDir {
    fn copy(from: &Path, to: &Path) {
        fs::create_dir_all(to).unwrap();
        for entry in fs::read_dir(from).unwrap() {
            let path = entry.unwrap().path();
            let target = to.join(path.file_name().unwrap());
            if path.is_dir() { copy(&path, &target) } else { fs::copy(&path, &target).map(drop).unwrap() }
        }
    }
    let folder = tempfile::tempdir().unwrap();
    copy(report(), folder.path());
    folder
}

/// Exit code and what was told of a report made anew.
fn rebuilt(dir: &Path) -> (Option<i32>, String) {
    let made = etendue().arg("report").arg(dir).output().unwrap();
    (made.status.code(), String::from_utf8(made.stderr).unwrap())
}

fn page(dir: &Path) -> String {
    fs::read_to_string(dir.join("index.html")).unwrap()
}

fn files(dir: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for folder in ["", "plots", "images"] {
        for entry in fs::read_dir(dir.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.is_file() {
                found.push((path.strip_prefix(dir).unwrap().to_owned(), fs::read(&path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

#[test]
fn a_report_is_made_anew_from_its_tables_byte_for_byte() {
    let copy = copied();
    for (name, _) in files(copy.path()) {
        if name == Path::new("index.html") || name.starts_with("plots") {
            fs::remove_file(copy.path().join(name)).unwrap();
        }
    }
    assert_eq!(rebuilt(copy.path()), (Some(0), String::new()));
    let (again, first) = (files(copy.path()), files(report()));
    assert_eq!(
        again.iter().map(|(name, _)| name).collect::<Vec<_>>(),
        first.iter().map(|(name, _)| name).collect::<Vec<_>>()
    );
    for ((name, a), (_, b)) in again.iter().zip(&first) {
        assert!(a == b, "{} differs", name.display());
    }
    assert!(first.iter().any(|(name, _)| name.starts_with("plots")) && first.len() > 30);
}

#[test]
fn a_page_shows_what_is_there_and_lists_what_is_not() {
    let copy = copied();
    let write = |name: &str, text: &str| fs::write(copy.path().join(name), text).unwrap();
    fs::remove_file(copy.path().join("correlation.csv")).unwrap();
    fs::remove_file(copy.path().join("manifest.json")).unwrap();
    write("energy.csv", "name,age\nfoo,3\n");
    let rates = fs::read_to_string(copy.path().join("rates.csv")).unwrap();
    let whole: Vec<&str> = rates.lines().collect();
    write("rates.csv", &format!("{}\n{},random,vari", whole[..4].join("\n"), "penumbra/three-regions"));
    let curves = fs::read_to_string(copy.path().join("curves.csv")).unwrap();
    write("curves.csv", &curves.replacen(",variance,all,4,", ",variance,all,NaN,", 1));
    let verdicts = fs::read(copy.path().join("verdicts.csv")).unwrap();
    let (code, told) = rebuilt(copy.path());
    assert_eq!(code, Some(5), "{told}");
    let page = page(copy.path());
    let listed = page.split("What is missing").nth(1).and_then(|rest| rest.split("</section>").next()).unwrap();
    for due in [
        "correlation.csv is missing: no correlations.",
        "manifest.json is missing",
        "energy.csv, line 1: there is no column",
        "rates.csv, line 5: 3 fields where the header has 9: is the file whole?",
        "curves.csv, line ",
        "says `NaN`; a whole number is due",
    ] {
        assert!(listed.contains(due), "{due}: {listed}");
        assert!(told.contains(due), "{due}: {told}");
    }
    assert!(page.contains("penumbra/three-regions") && page.contains("data-chart=\"profile\""), "the rest is shown");
    assert_eq!(fs::read(copy.path().join("verdicts.csv")).unwrap(), verdicts, "tables are left alone");
}

/// Found by failing every call that opens a file: a picture that could not be read was left out without a word.
#[test]
fn a_picture_that_is_not_whole_is_told() {
    let copy = copied();
    let images = copy.path().join("images");
    let mut views: Vec<PathBuf> = fs::read_dir(&images).unwrap().map(|entry| entry.unwrap().path()).collect();
    views.sort();
    assert!(views.len() >= 5, "{views:?}");
    let whole = fs::read(&views[0]).unwrap();
    fs::write(&views[0], &whole[..whole.len() / 2]).unwrap();
    let mut flipped = fs::read(&views[1]).unwrap();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 1;
    fs::write(&views[1], flipped).unwrap();
    fs::write(&views[2], "a photograph").unwrap();
    fs::remove_file(&views[3]).unwrap();
    fs::create_dir(&views[3]).unwrap();
    // One that is not there at all is nobody's fault: pictures may be taken away.
    fs::remove_file(&views[4]).unwrap();
    let (code, told) = rebuilt(copy.path());
    assert_eq!(code, Some(5), "{told}");
    let name = |view: &PathBuf| view.file_name().unwrap().to_str().unwrap().to_owned();
    let page = page(copy.path());
    let listed = page.split("What is missing").nth(1).and_then(|rest| rest.split("</section>").next()).unwrap();
    for (k, view) in views.iter().enumerate() {
        assert_eq!(told.contains(&name(view)), k < 4, "{k}: {told}");
        assert_eq!(listed.contains(&name(view)), k < 4, "{k}: {listed}");
    }
    assert!(told.contains("it is no file") && !told.contains(".."), "{told}");
}

#[test]
fn a_folder_without_a_report_gets_no_page() {
    let folder = tempfile::tempdir().unwrap();
    for (dir, due) in
        [(folder.path().to_owned(), "any table with a case is missing"), (folder.path().join("x"), "no such folder")]
    {
        let (code, told) = rebuilt(&dir);
        assert!(code == Some(5) && told.starts_with("error: ") && told.contains(due), "{told}");
        assert!(!dir.join("index.html").exists());
    }
}

#[test]
fn numbers_out_of_place_do_not_cost_the_page() {
    let copy = copied();
    let spoil = |file: &str, from: &str, to: &str| {
        let text = fs::read_to_string(copy.path().join(file)).unwrap();
        let at = text.find('\n').unwrap() + 1;
        let (head, rest) = text.split_at(at);
        fs::write(copy.path().join(file), format!("{head}{}", rest.replacen(from, to, 1))).unwrap();
    };
    spoil("convergence.csv", ",random,1,", ",random,99999999999,");
    spoil("scene.csv", ",1,source,", ",77,source,");
    spoil("verdicts.csv", ",pass,", ",perhaps,");
    let (code, told) = rebuilt(copy.path());
    assert_eq!(code, Some(5));
    assert!(told.contains("`point` says `99999999999`; 1 in this place is due"), "{told}");
    assert!(told.contains("`verdict` says `perhaps`; pass, fail or undecided is due"), "{told}");
    assert!(page(copy.path()).ends_with("</html>\n"));
}

#[test]
fn names_from_case_files_are_text_everywhere() {
    let page = page(report());
    // The two scripts of ours, and the elements that hold them.
    assert_eq!(page.matches("<script").count(), 2, "data and program");
    assert_eq!(page.matches("</script").count(), 2);
    assert!(
        !page.contains("<img src=x") && page.contains("&lt;img src=x onerror=alert(2)&gt; &amp; &quot;quotes&quot;")
    );
    assert!(page.contains("&lt;script&gt;alert(1)&lt;"));
}

#[test]
fn a_page_stands_alone() {
    let page = page(report());
    for word in ["http:", "https:", "@import", "url(", "<link", "<iframe", "fetch(", "XMLHttpRequest"] {
        let mut found = page.match_indices(word).map(|(at, _)| &page[at.saturating_sub(30)..at + 40]);
        // SVG's name space is a name, and marks are clipped by elements of the page.
        assert!(found.all(|near| near.contains("www.w3.org/2000/svg") || near.contains("url(#")), "{word}");
    }
    assert!(page.contains("default-src 'none'"), "the browser is told to fetch nothing");
    assert!(page.len() < 5 << 20);
}

/// The browser, or why the test cannot be run.
fn chromium() -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    let found =
        names.into_iter().find(|name| Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success()));
    assert!(
        found.is_some() || std::env::var("ETENDUE_CHROMIUM").as_deref() != Ok("required"),
        "none of {names:?} is installed"
    );
    if found.is_none() {
        eprintln!("skipped: no Chromium");
    }
    found
}

/// The page used by a script in a window of some size: what came of it.
fn used(browser: &str, dir: &Path, size: &str, dark: bool) -> Value {
    let probe = include_str!("../data/page/probe.js");
    let page = page(dir);
    let first = "<script>window.probeErrors = [];\
                 addEventListener('error', (e) => probeErrors.push(String(e.message)));\
                 addEventListener('securitypolicyviolation', (e) => probeErrors.push('fetched ' + e.blockedURI));\
                 ['error', 'warn'].forEach((k) => { const was = console[k]; console[k] = (...a) => { probeErrors.push(a.join(' ')); was(...a); }; });\
                 </script>";
    let page = page.replacen("<title>", &format!("{first}<title>"), 1);
    let (body, end) = page.rsplit_once("</body>").unwrap();
    let path = dir.join(format!("probed-{size}-{dark}.html"));
    fs::write(&path, format!("{body}<script>{probe}</script></body>{end}")).unwrap();
    let profile = tempfile::tempdir().unwrap();
    let out = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            "--virtual-time-budget=20000",
            "--dump-dom",
        ])
        .arg(format!("--window-size={size}"))
        .arg(format!("--blink-settings=preferredColorScheme={}", u8::from(!dark)))
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{}", path.display()))
        .output()
        .unwrap();
    let dom = String::from_utf8_lossy(&out.stdout);
    let told = dom.rsplit_once("<pre id=\"told\">").and_then(|(_, rest)| rest.split_once("</pre>"));
    let (told, _) = told.unwrap_or_else(|| panic!("no answer: {}", String::from_utf8_lossy(&out.stderr)));
    let told = told.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    serde_json::from_str(&told).unwrap_or_else(|error| panic!("{error}: {told}"))
}

fn all_is_well(told: &Value, dir: &Path, dark: bool) {
    assert_eq!(told["errors"], Value::Array(Vec::new()), "console");
    let checks = told["checks"].as_object().unwrap();
    let wrong: Vec<_> = checks.iter().filter(|(_, found)| *found != "ok").collect();
    assert!(wrong.is_empty() && checks.len() > 25, "{wrong:#?} of {}", checks.len());
    for file in told["files"].as_array().unwrap() {
        assert!(dir.join(file.as_str().unwrap()).exists(), "{file} is linked and not there");
    }
    assert!(told["files"].as_array().unwrap().len() > 20);
    assert_eq!(told["scheme"], if dark { "dark" } else { "light" });
    assert!(
        told["rows"].as_u64() > Some(10) && told["charts"].as_u64() > Some(12) && told["texts"].as_u64() > Some(200)
    );
}

#[test]
fn a_reader_can_use_the_page_wide_and_narrow_light_and_dark() {
    let Some(browser) = chromium() else { return };
    let copy = copied();
    for (size, dark) in [("1280,1000", false), ("1280,1000", true), ("500,900", false), ("500,900", true)] {
        let told = used(browser, copy.path(), size, dark);
        all_is_well(&told, copy.path(), dark);
        assert_eq!(told["failing"], 0);
        // Of a real page; a loaded machine may take longer than the second that readers are promised.
        assert!(told["interactive_ms"].as_f64() < Some(10_000.0), "{}", told["interactive_ms"]);
    }
}

/// The answer's numbers, from the tables by another way: one penumbra, so that medians are its values.
#[test]
fn the_advice_is_what_the_tables_say() {
    let rows = |file: &str| -> Vec<std::collections::BTreeMap<String, String>> {
        csv::Reader::from_path(report().join(file)).unwrap().deserialize().map(Result::unwrap).collect()
    };
    let number = |row: &std::collections::BTreeMap<String, String>, column: &str| row[column].parse::<f64>().unwrap();
    let variance = |strategy: &str| {
        let curves = rows("curves.csv");
        let is_it = |row: &&std::collections::BTreeMap<String, String>| {
            row["strategy"] == strategy && row["region"] == "penumbra" && row["samples"] == "16"
        };
        let found: Vec<f64> = curves.iter().filter(is_it).map(|row| number(row, "value_W2_m4")).collect();
        assert_eq!(found.len(), 1, "one penumbra");
        found[0]
    };
    let page = page(report());
    let section = page.split("id=\"sampler\"").nth(1).and_then(|rest| rest.split("</section>").next()).unwrap();
    let told = section.split("times less variance").next().and_then(|text| text.rsplit("they have ").next()).unwrap();
    let told: f64 = told.trim().parse().unwrap();
    let due = variance("random") / variance("stratified");
    assert!((told / due - 1.0).abs() < 0.06 && due > 1.5, "{told} is told, {due} is due");
    let nearest = rows("correlation.csv")
        .into_iter()
        .filter(|row| {
            row["strategy"] == "correlated" && row["samples"] == "16" && row["case"].starts_with("<script>")
        })
        .min_by(|a, b| number(a, "separation_m").total_cmp(&number(b, "separation_m")))
        .map(|row| number(&row, "correlation"))
        .unwrap();
    assert!(section.contains(&format!("(correlation {nearest:.2} in the median")), "{nearest}: {section}");
    // Forty replicates are too few for a verdict, and the advice says so.
    assert!(section.contains("Some of its verdicts are undecided") && section.contains("mark undecided"));
}

#[test]
fn a_report_without_penumbras_has_no_advice_and_no_link_to_it() {
    let folder = tempfile::tempdir().unwrap();
    let run =
        etendue().args(["run", "caustic/paraboloid", "--quick", "--quiet", "--out"]).arg(folder.path()).output();
    assert_eq!(run.unwrap().status.code(), Some(0));
    let page = page(folder.path());
    assert!(!page.contains("#sampler\"") && !page.contains("id=\"sampler\""));
}

#[test]
fn what_failed_comes_first_with_the_command_that_repeats_it() {
    let copy = copied();
    let path = copy.path().join("verdicts.csv");
    let mut reader = csv::Reader::from_path(&path).unwrap();
    let header = reader.headers().unwrap().clone();
    let mut rows: Vec<Vec<String>> =
        reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect();
    let row =
        rows.iter_mut().find(|row| row[0].starts_with("<script>") && row[1] == "stratified" && row[2] == "bias");
    let row = row.unwrap();
    (row[3], row[4]) = ("fail".to_owned(), "8.25".to_owned());
    let again = row[11].clone();
    let mut writer = csv::Writer::from_path(&path).unwrap();
    writer.write_record(&header).unwrap();
    rows.iter().for_each(|row| writer.write_record(row).unwrap());
    writer.flush().unwrap();
    assert_eq!(rebuilt(copy.path()).0, Some(0));
    let page = page(copy.path());
    assert!(page.contains("<h1>One verdict failed.</h1>"));
    assert!(
        page.contains("<b>Not stratified</b>") && !page.contains("use <span class=\"s-stratified\">"),
        "no advice to use it"
    );
    let alarm = page.split("class=\"alarm\"").nth(1).unwrap();
    assert!(page.find("class=\"alarm\"") < page.find("id=\"sampler\""), "before all else");
    let escaped = again.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('\'', "&#39;");
    assert!(alarm.split("</section>").next().unwrap().contains(&escaped), "{escaped}");
    let Some(browser) = chromium() else { return };
    let told = used(browser, copy.path(), "1280,1000", false);
    all_is_well(&told, copy.path(), false);
    assert_eq!(told["failing"], 1);
    assert_eq!(told["alarms"][0], again);
}
