//! Numbers at the edge: rooms of a micrometre and of a thousand kilometres, far from the origin, needles and slivers, faint and
//! glaring sources, one sample and 2³¹, a thousand occluders: right, or refused with the reason.
//!
//! A shipped case that is larger, brighter or elsewhere is the same text with other numbers. By powers of two nothing is
//! rounded: then no bit may differ.

mod counts;
mod crowds;
mod places;
mod scales;
mod slivers;

use std::fmt::Write;
use std::path::Path;

use etendue::Verdict;
use etendue::case::{Case, CaseErrors};
use etendue::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use etendue::geometry::{DVec3, Shape};
use etendue::oracle::{Oracle, Truth};
use etendue::radiometry::Exitance;
use etendue::report::{self, ReportOptions};
use etendue::trial::{self, RunOutcome, Settings};

/// Keys whose numbers are places, and other lengths; metres.
const PLACES: [&str; 8] = ["center", "vertices", "position", "from", "to", "vertex", "eye", "look_at"];
const LENGTHS: [&str; 9] =
    ["edge_u", "edge_v", "radius", "focal_length", "rim_radius", "curvature_radius", "thickness", "height", "width"];
/// Keys whose numbers are light, W/m².
const LIGHT: [&str; 4] = ["exitance", "irradiance", "white", "black"];

/// How a case differs from the shipped one.
#[derive(Clone, Copy, Debug)]
struct Change {
    /// Of all lengths.
    size: f64,
    /// Added to each coordinate of a place, after that, metres.
    shift: f64,
    /// Of all exitances and irradiances; a lamp's power grows with the area, too.
    light: f64,
}

const SAME: Change = Change { size: 1.0, shift: 0.0, light: 1.0 };

impl Change {
    fn of(self, key: &str, number: f64) -> f64 {
        match key {
            "power" => number * self.light * self.size * self.size,
            _ if LIGHT.contains(&key) => number * self.light,
            _ if PLACES.contains(&key) => number * self.size + self.shift,
            _ if LENGTHS.contains(&key) => number * self.size,
            _ => number,
        }
    }

    /// A case's text with its numbers changed, without its comments.
    fn text(self, text: &str) -> String {
        let (mut out, mut key) = (String::new(), String::new());
        for line in text.lines() {
            let mut rest = line.split('#').next().unwrap_or_default();
            while let Some(first) = rest.chars().next() {
                let of_word = |c: char| c.is_alphanumeric() || "_-.+".contains(c);
                let len = match rest.find(|c| !of_word(c)).unwrap_or(rest.len()) {
                    0 if first == '"' => rest[1..].find('"').map_or(rest.len(), |end| end + 2),
                    0 => first.len_utf8(),
                    len => len,
                };
                let (word, after) = rest.split_at(len);
                let is_key = of_word(first) && after.trim_start().starts_with('=');
                if is_key {
                    key = word.to_owned();
                }
                let number = word.replace('_', "").parse::<f64>().ok().filter(|_| !is_key);
                match number.map(|old| (old, self.of(&key, old))) {
                    Some((old, new)) if new != old => write!(out, "{new:e}").expect("a text grows"),
                    _ => out.push_str(word),
                }
                rest = after;
            }
            out.push('\n');
        }
        out
    }

    /// The shipped case, changed.
    fn case(self, name: &str) -> Result<Case, CaseErrors> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases").join(name).with_extension("toml");
        Case::from_toml(name, &self.text(&std::fs::read_to_string(path).expect(name)))
    }
}

fn shown(outcome: &RunOutcome) -> Vec<(String, Verdict, String)> {
    let verdicts = outcome.cases.iter().flat_map(|case| case.verdicts().map(move |found| (case, found)));
    let told = verdicts.map(|(case, (strategy, judged))| {
        (format!("{} {strategy} {}", case.name, judged.property), judged.verdict, judged.words.clone())
    });
    told.collect()
}

/// All verdicts pass, and every table holds numbers where it holds any.
fn assert_sound(what: &str, cases: &[Case], settings: &Settings) -> RunOutcome {
    let outcome = trial::run(cases, settings, &|_| {}).unwrap_or_else(|error| panic!("{what}: {error}"));
    let verdicts = shown(&outcome);
    assert!(!verdicts.is_empty(), "{what}");
    for (name, verdict, words) in verdicts {
        assert_eq!(verdict, Verdict::Pass, "{what}: {name}: {words}");
    }
    assert_tables(what, &outcome);
    outcome
}

fn assert_tables(what: &str, outcome: &RunOutcome) {
    let folder = tempfile::tempdir().expect("a folder");
    let options = ReportOptions { generator: "a test", plots: false, views: &[], watched: false };
    report::write(folder.path(), outcome, &options).unwrap_or_else(|error| panic!("{what}: {error}"));
    let mut fields = 0;
    for entry in std::fs::read_dir(folder.path()).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|extension| extension == "csv") {
            for line in std::fs::read_to_string(&path).expect("a table").lines() {
                for field in line.split(',') {
                    let number = field.parse::<f64>().unwrap_or(0.0);
                    assert!(number.is_finite(), "{what}: {}: {line}", path.display());
                    fields += 1;
                }
            }
        }
    }
    assert!(fields > 100, "{what}: {fields} fields");
}

fn room(sources: Vec<(Shape, f64)>, occluders: Vec<Shape>, points: Vec<MeasurementPoint>) -> Configuration {
    let sources = sources.into_iter().map(|(shape, m)| Source::new(shape, Exitance::new(m)).unwrap());
    Configuration::new(sources.collect(), occluders, None, points, Arrangement::Scattered).unwrap()
}

fn point(position: DVec3, normal: DVec3) -> MeasurementPoint {
    MeasurementPoint::new(position, normal).unwrap()
}

/// Of one source of exitance 1, at one point.
fn truth(source: Shape, occluders: Vec<Shape>, position: DVec3, normal: DVec3) -> Truth {
    let at = point(position, normal);
    Oracle::new(&room(vec![(source, 1.0)], occluders, vec![at])).at(&at)
}

fn bound(truth: &Truth) -> f64 {
    truth.bound.watts_per_square_metre()
}

fn irradiance(truth: &Truth) -> f64 {
    truth.irradiance.watts_per_square_metre()
}

/// Within its own bound, and to so many parts of itself, rounding of what is expected apart.
#[track_caller]
fn assert_near(what: &str, truth: &Truth, expected: f64, relative: f64) {
    let off = (irradiance(truth) - expected).abs();
    assert!(off <= bound(truth) + 4.0 * f64::EPSILON * expected, "{what}: {truth:?}, not {expected:e}: off {off:e}");
    assert!(off <= relative * expected, "{what}: {truth:?}, not {expected:e}: off {off:e}");
}

/// Form factor from an element to a disk parallel to it, facing it, off its axis.
///
/// F = ½ (1 − (h² + d² − R²)/√((h² + d² + R²)² − 4R²d²)), here without the difference of near-equal numbers.
fn to_parallel_disk(height: f64, beside: f64, radius: f64) -> f64 {
    let (h2, d2, r2) = (height * height, beside * beside, radius * radius);
    let sum = h2 + d2 + r2;
    let root = (sum * sum - 4.0 * r2 * d2).sqrt();
    // root² − (sum − 2R²)² = 4R²h².
    2.0 * r2 * h2 / (root * (root + sum - 2.0 * r2))
}
