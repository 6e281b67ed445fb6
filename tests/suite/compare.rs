//! `etendue compare`: what two reports tell beside each other.

use std::fs;
use std::path::Path;

use assert_cmd::Command;

/// A report of two cells, in a folder of its own.
///
/// - `variance`: of one estimate by `random`, W²/m⁴; its 95 % interval reaches 4 % to either side
fn report(dir: &Path, verdict: &str, variance: f64, digest: &str) {
    fs::create_dir_all(dir).unwrap();
    let effect = if verdict == "fail" { "0.021,0.019,0.023" } else { "0.0001,-0.001,0.0012" };
    let verdicts = format!(
        "case,strategy,property,verdict,evidence,threshold,effect,effect_low,effect_high,smallest_bias_mean,smallest_bias_point,reproduce\n\
         room/<a|b>,random,bias,{verdict},0.1,6.0,{effect},0.01,0.1,etendue run room --seed 1\n\
         room/<a|b>,stratified,bias,pass,0.1,6.0,0.0001,-0.001,0.0012,0.01,0.1,etendue run room --seed 1\n"
    );
    let [low, high] = [0.96 * variance, 1.04 * variance];
    let convergence = format!(
        "case,strategy,point,samples,variance_W2_m4,variance_low,variance_high\n\
         room/<a|b>,random,0,16,{variance:?},{low:?},{high:?}\n\
         room/<a|b>,stratified,0,16,0.125,0.12,0.13\n\
         room/<a|b>,stratified,1,16,0.0,,\n"
    );
    let manifest = format!(
        "{{\"schema_version\":1,\"etendue_version\":\"0.1.0\",\"seed\":1,\"generator\":\"g\",\"command\":\"etendue run room\",\
         \"cases\":[{{\"name\":\"room/<a|b>\",\"title\":\"t\",\"digest\":\"{digest}\",\"points\":2,\"strategies\":[\"random\"]}}]}}"
    );
    fs::write(dir.join("verdicts.csv"), verdicts).unwrap();
    fs::write(dir.join("convergence.csv"), convergence).unwrap();
    fs::write(dir.join("manifest.json"), manifest).unwrap();
}

/// Exit code, standard output and standard error.
fn compare(dir: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output =
        Command::cargo_bin("etendue").unwrap().current_dir(dir).arg("compare").args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

#[test]
fn a_report_beside_itself_is_no_regression() {
    let dir = tempfile::tempdir().unwrap();
    report(&dir.path().join("a"), "pass", 2.0, "x");
    let (code, said, errors) = compare(dir.path(), &["a", "a", "--all"]);
    assert_eq!((code, errors.as_str()), (0, ""), "{said}");
    assert!(said.contains("2 verdicts: 0 worse, 0 better, 2 the same; 2 variances: 0 more, 0 less"), "{said}");
    let line = said.lines().find(|line| line.contains("stratified")).unwrap();
    assert!(line.contains("1.00") && line.ends_with("same"), "{line}");
}

#[test]
fn regressions_leave_with_one_and_are_told_in_every_format() {
    let dir = tempfile::tempdir().unwrap();
    report(&dir.path().join("a"), "pass", 2.0, "x");
    report(&dir.path().join("worse"), "fail", 2.0, "x");
    report(&dir.path().join("noisier"), "pass", 3.0, "x");
    report(&dir.path().join("quieter"), "pass", 1.0, "x");
    let (code, said, _) = compare(dir.path(), &["a", "worse"]);
    assert_eq!(code, 1);
    assert!(said.contains("WORSE  room/<a|b> random bias: pass → fail +2.10 % (+1.90 to +2.30)"), "{said}");
    assert!(said.contains("\n  etendue run room --seed 1\n"), "{said}");
    let (code, said, _) = compare(dir.path(), &["a", "noisier"]);
    assert_eq!(code, 1);
    let line = said.lines().find(|line| line.contains("random")).unwrap();
    assert!(line.contains("1.50") && line.contains("1.42 to 1.59") && line.ends_with("more"), "{line}");
    assert!(!said.contains("stratified"), "what did not change is not listed: {said}");
    let (code, said, _) = compare(dir.path(), &["a", "quieter"]);
    assert!(code == 0 && said.contains("less"), "{said}");
    // Names are text in Markdown, and what got worse is bold.
    let (code, said, _) = compare(dir.path(), &["a", "noisier", "--format", "markdown"]);
    assert_eq!(code, 1);
    assert!(said.contains("| room/&lt;a\\|b> | random | 16 | **1.50** | 1.42 to 1.59 | more |"), "{said}");
    let (code, said, _) = compare(dir.path(), &["a", "worse", "--format", "json"]);
    assert_eq!(code, 1);
    let told: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(told["regression"], true);
    assert_eq!(told["verdicts_changed"][0]["effect"], 0.021);
    assert_eq!(told["variances"].as_array().unwrap().len(), 2);
}

#[test]
fn two_strategies_of_one_run_are_compared() {
    let dir = tempfile::tempdir().unwrap();
    report(&dir.path().join("a"), "pass", 2.0, "x");
    let (code, said, _) = compare(dir.path(), &["a", "a", "--strategy", "random,stratified"]);
    assert_eq!(code, 0);
    let line = said.lines().find(|line| line.contains("random → stratified")).unwrap();
    assert!(line.contains("0.0625") || line.contains("0.063"), "{line}");
    let (code, ..) = compare(dir.path(), &["a", "a", "--strategy", "random"]);
    assert_eq!(code, 2);
}

#[test]
fn other_cases_under_one_name_are_no_regression_of_the_estimator() {
    let dir = tempfile::tempdir().unwrap();
    report(&dir.path().join("a"), "pass", 2.0, "x");
    report(&dir.path().join("b"), "pass", 9.0, "y");
    let (code, said, _) = compare(dir.path(), &["a", "b"]);
    assert_eq!(code, 0);
    assert!(said.contains("other case") && said.contains("another case in each run"), "{said}");
}

#[test]
fn what_is_no_report_is_told_by_file_and_line() {
    let dir = tempfile::tempdir().unwrap();
    let (a, broken) = (dir.path().join("a"), dir.path().join("broken"));
    report(&a, "pass", 2.0, "x");
    let (code, _, errors) = compare(dir.path(), &["a", "nowhere"]);
    assert!(code == 5 && errors.contains("nowhere holds no report of etendue: there is no such folder"), "{errors}");
    for (file, from, to, said) in [
        (
            "verdicts.csv",
            "bias,pass",
            "bias,perhaps",
            "verdicts.csv, line 2: `verdict` says `perhaps`; pass, fail or undecided is due",
        ),
        ("verdicts.csv", "effect_low", "effect_lo", "verdicts.csv, line 1: there is no column `effect_low`"),
        ("verdicts.csv", "0.1,etendue run room", "0.1", "fields where the header has 12: is the file whole?"),
        (
            "convergence.csv",
            "random,0",
            "random,zero",
            "convergence.csv, line 2: `point` says `zero`; a whole number is due",
        ),
        (
            "convergence.csv",
            "2.0,1.92",
            "inf,1.92",
            "convergence.csv, line 2: `variance_W2_m4` says `inf`; a number is due",
        ),
        ("convergence.csv", "1.92,2.08", "2.08,1.92", "is not above the other end is due"),
        ("manifest.json", "\"seed\":1", "\"seed\":", "manifest.json, line 1"),
    ] {
        report(&broken, "pass", 2.0, "x");
        let path = broken.join(file);
        let text = fs::read_to_string(&path).unwrap();
        let with_fault = text.replacen(from, to, 1);
        assert_ne!(text, with_fault);
        fs::write(&path, with_fault).unwrap();
        let (code, out, errors) = compare(dir.path(), &["a", "broken"]);
        assert!(code == 5 && out.is_empty() && errors.contains(said), "{from} to {to}: {errors}");
    }
    report(&broken, "pass", 2.0, "x");
    fs::remove_file(broken.join("verdicts.csv")).unwrap();
    let (code, _, errors) = compare(dir.path(), &["broken", "a"]);
    assert!(code == 5 && errors.contains("verdicts.csv is missing"), "{errors}");
    let (code, _, errors) = compare(dir.path(), &["a", "a", "--strategy", "random,poisson"]);
    assert!(code == 4 && errors.contains("in common"), "{errors}");
}

#[test]
fn a_report_of_ours_is_read_back() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    let run = Command::cargo_bin("etendue")
        .unwrap()
        .args([
            "run",
            "penumbra/eclipse",
            "--quick",
            "--samples",
            "4,16",
            "--replicates",
            "200",
            "--no-plots",
            "--allow-undecided",
        ])
        .args(["--out", out.to_str().unwrap()])
        .output()
        .unwrap();
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    let (code, said, errors) = compare(dir.path(), &["run", "run", "--all"]);
    assert_eq!((code, errors.as_str()), (0, ""));
    assert!(said.contains("etendue run penumbra/eclipse"), "{said}");
    for strategy in ["random", "correlated", "stratified"] {
        let line = said.lines().find(|line| line.contains(strategy) && line.contains("16")).unwrap();
        assert!(line.contains("1.00") && line.ends_with("same"), "{line}");
    }
}
