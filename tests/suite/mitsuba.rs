//! The Mitsuba demonstration, as a test where somebody asks for it: it installs from PyPI and renders for a minute.

use std::process::Command;

#[test]
fn the_demonstration_gives_its_verdicts() {
    if std::env::var_os("ETENDUE_MITSUBA").is_none_or(|word| word != "1") {
        println!("SKIPPED: say ETENDUE_MITSUBA=1 to render with Mitsuba (from PyPI)");
        return;
    }
    let root = env!("CARGO_MANIFEST_DIR");
    let demo = Command::new(format!("{root}/examples/mitsuba/demo.sh"))
        .args(["--quick", &format!("{root}/target/mitsuba")])
        .env("ETENDUE", assert_cmd::cargo::cargo_bin("etendue"))
        .output()
        .expect("bash");
    let said = String::from_utf8_lossy(&demo.stdout).into_owned() + &String::from_utf8_lossy(&demo.stderr);
    println!("{said}");
    match demo.status.code() {
        Some(77) => println!("SKIPPED: {said}"),
        code => assert_eq!(code, Some(0), "{said}"),
    }
}
