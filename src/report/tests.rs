//! Laws of a whole report: its tables, its manifest, its folder.

use std::collections::BTreeMap;
use std::fs;

use super::*;
use crate::geometry::DVec3;
use crate::oracle::Region;
use crate::oracle::limits::{Limit, LimitMethod, Phase};
use crate::statistics::Verdict;

const OPTIONS: ReportOptions =
    ReportOptions { generator: "8 lanes of xoshiro256++", plots: true, views: &[], watched: false };

/// Every file below a folder with its content.
fn contents(dir: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(contents(&path).into_iter().map(|(p, c)| (Path::new(path.file_name().unwrap()).join(p), c)));
        } else {
            found.insert(PathBuf::from(path.file_name().unwrap()), fs::read(&path).unwrap());
        }
    }
    found
}

fn rows(content: &[u8]) -> (Vec<String>, Vec<Vec<String>>) {
    let mut reader = csv::Reader::from_reader(content);
    let header = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let rows = reader.records().map(|r| r.unwrap().iter().map(str::to_owned).collect()).collect();
    (header, rows)
}

/// Columns as the contract lists them, and which of them may be empty.
const CONTRACT: [(&str, &str, &str); 14] = [
    (
        "convergence.csv",
        "case, strategy, point, x_m, y_m, z_m, region, samples, replicates, exact_irradiance_W_m2, \
         exact_bound_W_m2, mean_irradiance_W_m2, bias_W_m2, bias_std_error_W_m2, variance_W2_m4, variance_low, \
         variance_high, predicted_variance_W2_m4, mse_W2_m4",
        "predicted_variance_W2_m4",
    ),
    ("means.csv", "case, strategy, samples, replicates, exact_irradiance_W_m2, bias_W_m2, bias_std_error_W_m2", ""),
    ("rates.csv", "case, strategy, quantity, region, slope, slope_low, slope_high, expected_slope, verdict", ""),
    (
        "curves.csv",
        "case, strategy, quantity, region, samples, value_W2_m4, low_W2_m4, high_W2_m4, fitted_W2_m4, asymptotic_slope",
        "",
    ),
    ("correlation.csv", "case, strategy, samples, separation_m, correlation, low, high, predicted", "predicted"),
    (
        "energy.csv",
        "case, rays, source_power_W, emitted_W, deposited_W, deposited_std_error_W, absorbed_W, escaped_W, terminated_W, \
         residual_W, map_integral_W, exact_deposited_W, verdict",
        "deposited_std_error_W, exact_deposited_W",
    ),
    (
        "caustic.csv",
        "case, order, bin, position_m, measured_irradiance_W_m2, std_error_W_m2, exact_irradiance_W_m2, verdict",
        "position_m, std_error_W_m2",
    ),
    (
        "texels.csv",
        "case, rays, size_m, places, irradiance_W_m2, bias_W_m2, exact_bias_W_m2, variance_W2_m4, predicted_variance_W2_m4",
        "",
    ),
    (
        "paths.csv",
        "case, estimator, point, x_m, y_m, z_m, part, paths, reached_share, measured_irradiance_W_m2, std_error_W_m2, \
         exact_irradiance_W_m2, exact_bound_W_m2, variance_W2_m4, largest_variance_W2_m4, verdict",
        "point, x_m, y_m, z_m, reached_share, std_error_W_m2, exact_irradiance_W_m2, exact_bound_W_m2, variance_W2_m4, \
         largest_variance_W2_m4",
    ),
    (
        "scene.csv",
        "case, thing, role, shape, textured, stroke, form, vertex, x_m, y_m, z_m, normal_x, normal_y, normal_z, radius_m",
        "normal_x, normal_y, normal_z, radius_m",
    ),
    (
        "verdicts.csv",
        "case, strategy, property, verdict, evidence, threshold, effect, effect_low, effect_high, \
         smallest_bias_mean, smallest_bias_point, reproduce",
        "smallest_bias_mean, smallest_bias_point",
    ),
    ("timings.csv", "case, strategy, stage, rays, seconds, per_ray_ns, efficiency", "strategy, efficiency"),
    ("limits.csv", "case, limit, distance_m, x_m, y_m, z_m, region_before, region_after, bound_m, method", ""),
    (
        "exact.csv",
        "case, point, x_m, y_m, z_m, nx, ny, nz, region, form_factor, direct_W_m2, caustic_W_m2, indirect_W_m2, \
         irradiance_W_m2, radiosity_W_m2, error_bound, method",
        "direct_W_m2, caustic_W_m2, indirect_W_m2, radiosity_W_m2",
    ),
];
const WORDS: [&str; 18] = [
    "role",
    "shape",
    "textured",
    "form",
    "estimator",
    "part",
    "case",
    "strategy",
    "region",
    "quantity",
    "verdict",
    "property",
    "reproduce",
    "stage",
    "method",
    "limit",
    "region_before",
    "region_after",
];

/// The tables of the made-up outcome, `limits` and `exact` included.
fn tables_of(outcome: &RunOutcome) -> Vec<(&'static str, Vec<u8>)> {
    let mut files = csv_files(outcome).unwrap();
    let mut limits = Vec::new();
    let limit = Limit {
        distance: 0.2,
        position: DVec3::X * 0.2,
        before: Phase::Umbra,
        after: Phase::Penumbra,
        bound: 1e-15,
        method: LimitMethod::ClosedForm,
    };
    let cases =
        outcome.cases.iter().map(|case| LimitsCase { name: &case.name, limits: std::slice::from_ref(&limit) });
    write_limits(&mut limits, cases).unwrap();
    files.push(("limits.csv", limits));
    let mut exact = Vec::new();
    let nought = Some(crate::oracle::optics::Bounded::default());
    let none_bent = crate::oracle::optics::Arriving { caustic: nought, indirect: nought, ..Default::default() };
    let arriving: Vec<_> = outcome.cases.iter().map(|case| vec![none_bent; case.points.len()]).collect();
    let cases = outcome.cases.iter().enumerate().map(|(i, case)| ExactCase {
        name: &case.name,
        albedos: case.albedos.as_deref().filter(|_| i == 0),
        points: &case.points,
        truths: &case.truths,
        arriving: &arriving[i],
        derivatives: &[],
    });
    write_exact(&mut exact, cases, &[]).unwrap();
    files.push(("exact.csv", exact));
    files
}

#[test]
fn tables_have_the_columns_of_the_contract_and_parse() {
    let outcome = made_up::outcome();
    for ((file, content), (name, columns, may_be_empty)) in tables_of(&outcome).iter().zip(CONTRACT) {
        assert_eq!(*file, name);
        let (header, rows) = rows(content);
        assert_eq!(header, columns.split(", ").collect::<Vec<_>>(), "{file}");
        assert!(!rows.is_empty());
        for row in &rows {
            for (column, field) in header.iter().zip(row) {
                if field.is_empty() {
                    assert!(may_be_empty.split(", ").any(|c| c == column), "{file}: {column} is empty");
                } else if !WORDS.contains(&column.as_str()) {
                    let number: f64 = field.parse().unwrap_or_else(|e| panic!("{file}: {column}: {field}: {e}"));
                    assert!(number.is_finite(), "{file}: {column}: {field}");
                }
            }
        }
    }
}

#[test]
fn numbers_come_back_as_they_were_measured() {
    let outcome = made_up::outcome();
    let (_, content) = &csv_files(&outcome).unwrap()[0];
    let (header, rows) = rows(content);
    let column = |name: &str| header.iter().position(|h| h == name).unwrap();
    let mut rows = rows.iter();
    for case in &outcome.cases {
        for (strategy, cell) in case.strategies.iter().flat_map(|s| s.cells.iter().map(move |c| (s, c))) {
            for (i, measured) in cell.points.iter().enumerate() {
                let row = rows.next().expect("one row for each point of each cell");
                assert_eq!(row[column("case")], case.name);
                assert_eq!(row[column("strategy")], strategy.name());
                assert_eq!(row[column("point")], i.to_string());
                assert_eq!(row[column("region")], case.truths[i].region.name());
                assert_eq!(row[column("samples")], cell.samples.to_string());
                assert_eq!(row[column("replicates")], cell.replicates.to_string());
                let number = |name| row[column(name)].parse::<f64>().unwrap();
                assert_eq!(number("x_m"), case.points[i].position().x);
                assert_eq!(number("exact_irradiance_W_m2"), case.truths[i].irradiance.watts_per_square_metre());
                assert_eq!(number("mean_irradiance_W_m2"), measured.mean);
                assert_eq!(number("bias_W_m2"), measured.bias);
                assert_eq!(number("variance_high"), measured.variance_interval.unwrap().high);
                assert_eq!(number("mse_W2_m4"), measured.mse);
            }
        }
    }
    assert_eq!(rows.next(), None);
}

#[test]
fn exact_values_have_seventeen_digits_and_radiosity_only_with_an_albedo() {
    let outcome = made_up::outcome();
    let (_, content) = tables_of(&outcome).pop().unwrap();
    let (header, rows) = rows(&content);
    let column = |name: &str| header.iter().position(|h| h == name).unwrap();
    let first = outcome.cases[0].truths[0].irradiance.watts_per_square_metre();
    assert_eq!(rows[0][column("irradiance_W_m2")], format!("{first:.16e}"));
    assert_eq!(rows[0][column("radiosity_W_m2")], format!("{:.16e}", 0.5 * first));
    assert_eq!(rows[65][column("radiosity_W_m2")], "", "the second case has no albedo");
}

#[test]
fn what_has_no_meaning_is_empty_and_what_is_not_judged_says_so() {
    let mut outcome = made_up::outcome();
    outcome.cases.truncate(1);
    let strategy = &mut outcome.cases[0].strategies[0];
    strategy.rates[0].region = None;
    strategy.rates[0].verdict = None;
    strategy.rates[1].region = Some(Region::BelowHorizon);
    strategy.rates[1].verdict = Some(Verdict::Undecided);
    strategy.verdicts[0].smallest_bias_mean = None;
    strategy.timings[0].rays = 0;
    let text = |file: &str| {
        let files = csv_files(&outcome).unwrap();
        let (_, content) = files.iter().find(|(name, _)| *name == file).expect("written");
        String::from_utf8(content.clone()).unwrap()
    };
    let rates = text("rates.csv");
    assert!(rates.lines().nth(1).unwrap().starts_with("penumbra/eclipse,random,variance,all,"));
    assert!(rates.lines().nth(1).unwrap().ends_with(",not_judged"));
    assert!(rates.lines().nth(2).unwrap().starts_with("penumbra/eclipse,random,variance,below_horizon,"));
    assert!(rates.lines().nth(2).unwrap().ends_with(",undecided"));
    assert!(text("verdicts.csv").lines().nth(1).unwrap().contains(",,0.081,etendue run "));
    assert_eq!(text("timings.csv").lines().nth(2).unwrap(), "penumbra/eclipse,random,estimate,0,1.25,,31000000.0");
}

#[test]
fn a_number_that_is_none_stops_the_report_before_anything_is_written() {
    let mut outcome = made_up::outcome();
    outcome.cases[1].strategies[2].cells[3].points[7].mse = f64::NAN;
    let dir = tempfile::tempdir().unwrap();
    match write(dir.path(), &outcome, &OPTIONS) {
        Err(ReportError::NotFinite { table: "convergence.csv", column, case, value }) if column == "mse_W2_m4" => {
            assert_eq!(case, "direct/disk-grid");
            assert!(value.is_nan());
        }
        other => panic!("{other:?}"),
    }
    assert!(contents(dir.path()).is_empty());
}

#[test]
fn two_writes_give_the_same_bytes_and_name_every_file() {
    let outcome = made_up::outcome();
    let [first, second] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    claim(first.path()).unwrap();
    let named = write(first.path(), &outcome, &OPTIONS).unwrap();
    write(second.path(), &outcome, &OPTIONS).unwrap();
    let (a, b) = (contents(first.path()), contents(second.path()));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (name, content) in &a {
        assert!(content == &b[name], "{} differs", name.display());
    }
    let mut named: Vec<_> = named.iter().map(|p| p.strip_prefix(first.path()).unwrap().to_owned()).collect();
    named.sort();
    assert_eq!(named, a.keys().cloned().collect::<Vec<_>>(), "all files are named, none is left over");
    claim(first.path()).unwrap();
    assert!(contents(first.path()).is_empty(), "the next run's claim knows every file");
}

/// What plots and page are drawn from is what was measured, whatever the way through the tables.
#[test]
fn a_report_read_back_says_what_was_written() {
    let outcome = made_up::outcome();
    let mut files = csv_files(&outcome).unwrap();
    files.push(("manifest.json", manifest::manifest(&outcome, OPTIONS.generator).into_bytes()));
    let record = record::read(Place::Memory(&files));
    assert_eq!(record.faults, Vec::<String>::new());
    assert_eq!((record.command.as_str(), record.cases.len()), (outcome.command.as_str(), outcome.cases.len()));
    for (read, case) in record.cases.iter().zip(&outcome.cases) {
        assert_eq!((&read.name, &read.title, read.arrangement), (&case.name, &case.title, case.arrangement));
        assert_eq!(read.figures.len(), case.figures.len());
        for (read, figure) in read.figures.iter().zip(&case.figures) {
            assert_eq!((read.role, read.shape.as_str(), &read.strokes), (figure.role, figure.shape, &figure.strokes));
        }
        for ((read, point), truth) in read.points.iter().zip(&case.points).zip(&case.truths) {
            assert_eq!((read.position, read.region), (point.position(), truth.region));
            assert_eq!(read.exact, truth.irradiance.watts_per_square_metre());
        }
        for (read, made) in read.strategies.iter().zip(&case.strategies) {
            assert_eq!((read.name.as_str(), &read.correlations), (made.name(), &made.correlations));
            assert_eq!(read.cells.len(), made.cells.len());
            for (read, cell) in read.cells.iter().zip(&made.cells) {
                assert_eq!(
                    (read.samples, read.replicates, &read.points),
                    (cell.samples, cell.replicates, &cell.points)
                );
                assert_eq!(read.mean_bias, Some([cell.mean_bias, cell.mean_bias_std_error]));
            }
            for (read, rate) in read.rates.iter().zip(&made.rates) {
                assert_eq!((read.region, read.slope, &read.points), (rate.region, rate.slope, &rate.points));
                let line = read.line.unwrap();
                assert!((line.intercept - rate.intercept).abs() < 1e-12 && line.asymptote == rate.asymptote);
            }
        }
        let light = case.light.as_ref().unwrap();
        assert_eq!((&read.ledger, &read.texels), (&light.rows, &light.texels));
        assert_eq!(read.rings.len(), light.bins.len());
        assert_eq!(read.verdicts.len(), case.verdicts().count());
    }
}

#[cfg(feature = "plots")]
#[test]
fn plots_are_drawn_for_each_case_under_names_that_stay_in_their_folder() {
    let dir = tempfile::tempdir().unwrap();
    let report = dir.path().join("report");
    write(&report, &made_up::outcome(), &OPTIONS).unwrap();
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1, "nothing beside the report");
    let names: Vec<String> =
        contents(&report.join("plots")).into_keys().map(|p| p.to_str().unwrap().to_owned()).collect();
    for kind in ["variance", "bias", "profile", "correlation"] {
        for format in ["svg", "png"] {
            assert!(names.contains(&format!("penumbra-eclipse-{kind}.{format}")), "{names:?}");
            assert!(names.contains(&format!("three-points-{kind}.{format}")), "{names:?}");
        }
    }
    assert!(names.contains(&"direct-disk-grid-map.png".to_owned()));
    for (name, content) in contents(&report.join("plots")) {
        let text = String::from_utf8_lossy(&content);
        match name.extension().unwrap().to_str().unwrap() {
            "png" => assert!(content.starts_with(b"\x89PNG\r\n\x1a\n") && content.len() > 5000),
            _ => {
                assert!(text.starts_with("<svg width=\"900\" height=\"") && text.contains("viewBox=\"0 0 7200 "));
                assert!(text.trim_end().ends_with("</svg>") && !text.contains("NaN"));
            }
        }
    }
}

/// The case when nothing is due anywhere, and nothing arrives.
fn in_the_dark(mut case: crate::trial::CaseOutcome) -> crate::trial::CaseOutcome {
    case.name = "dark".to_owned();
    case.light = None;
    for truth in &mut case.truths {
        truth.irradiance = crate::radiometry::Irradiance::new(0.0);
        truth.region = Region::Umbra;
    }
    for strategy in &mut case.strategies {
        strategy.rates.clear();
        strategy.correlations.clear();
        for cell in &mut strategy.cells {
            (cell.mean_bias, cell.mean_bias_std_error) = (0.0, 0.0);
            for p in &mut cell.points {
                (p.mean, p.bias, p.bias_std_error, p.variance, p.mse) = (0.0, 0.0, 0.0, 0.0, 0.0);
                (p.variance_interval, p.predicted_variance) = (None, None);
            }
        }
    }
    case
}

#[cfg(feature = "plots")]
#[test]
fn a_case_without_light_is_reported_without_plots_that_would_be_empty() {
    let mut outcome = made_up::outcome();
    outcome.cases = vec![in_the_dark(outcome.cases[0].clone())];
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), &outcome, &OPTIONS).unwrap();
    let plots = contents(&dir.path().join("plots"));
    assert_eq!(plots.len(), 2, "the profile alone: {:?}", plots.keys());
    assert!(plots.values().all(|content| !String::from_utf8_lossy(content).contains("NaN")));
}

#[test]
fn the_manifest_says_where_the_numbers_come_from() {
    let outcome = made_up::outcome();
    let text = manifest::manifest(&outcome, OPTIONS.generator);
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(value["schema_version"], 1);
    assert_eq!(value["etendue_version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(value["seed"], 1);
    assert_eq!(value["generator"], OPTIONS.generator);
    assert_eq!(value["command"], outcome.command.as_str());
    assert_eq!(value["cases"][0]["name"], "penumbra/eclipse");
    assert_eq!(value["cases"][0]["digest"], outcome.cases[0].digest.to_string());
    let keys = [
        "schema_version",
        "etendue_version",
        "seed",
        "generator",
        "command",
        "machine_features_that_change_bits",
        "cases",
    ];
    let places: Vec<_> = keys.iter().map(|k| text.find(&format!("\n  \"{k}\":")).unwrap()).collect();
    assert!(places.is_sorted(), "keys keep their order");
}

/// To write it anew: `cargo test --lib write_the_column_reference -- --ignored`.
#[test]
fn the_committed_column_reference_is_the_codes() {
    let committed = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/README.md"));
    assert_eq!(
        committed.unwrap_or_default(),
        column_reference(),
        "write it anew with `cargo test --lib write_the_column_reference -- --ignored`"
    );
}

#[test]
#[ignore = "writes reports/README.md"]
fn write_the_column_reference() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("reports");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("README.md"), column_reference()).unwrap();
}

#[test]
#[ignore = "writes plots for people to look at, into the system's folder for passing files"]
fn made_up_plots_to_look_at() {
    let dir = std::env::temp_dir().join("etendue-plots");
    claim(&dir).unwrap();
    let mut outcome = made_up::outcome();
    let mut plain = outcome.cases[0].clone();
    plain.name = "plain".to_owned();
    plain.strategies.truncate(1);
    plain.strategies[0].rates.truncate(1);
    plain.strategies[0].cells.drain(..3);
    outcome.cases.push(plain);
    outcome.cases.push(in_the_dark(outcome.cases[0].clone()));
    write(&dir, &outcome, &OPTIONS).unwrap();
}

#[test]
#[ignore = "takes the time of a report on eighteen cases"]
fn time_of_a_report() {
    let mut outcome = made_up::outcome();
    let cases = outcome.cases.clone();
    outcome.cases = (0..18)
        .map(|i| {
            let mut case = cases[[0, 0, 0, 0, 2, 1][i % 6]].clone();
            case.name = format!("case/{i}");
            case
        })
        .collect();
    let dir = tempfile::tempdir().unwrap();
    let start = std::time::Instant::now();
    write(dir.path(), &outcome, &ReportOptions { plots: false, ..OPTIONS }).unwrap();
    println!("tables: {:?}", start.elapsed());
    let start = std::time::Instant::now();
    write(dir.path(), &outcome, &OPTIONS).unwrap();
    println!("with plots: {:?}", start.elapsed());
    let bytes: usize = contents(dir.path()).values().map(Vec::len).sum();
    println!("{bytes} bytes");
}
