//! The certified sets of NIST: moments and least squares reach the digits that doubles allow.
//!
//! `tests/data/strd` holds data, certified values (15 digits) and, in `lre_reference.csv`, the digits that exact arithmetic
//! reaches once the data are rounded to `f64` (the ceiling) and that Householder QR in `f64` reaches.

use std::collections::HashMap;
use std::path::PathBuf;

use etendue::statistics::Summary;
use etendue::statistics::slope::{Fit, Noise, fit, fit_polynomial};

/// Digits a method may fall short of the ceiling: the last of fifteen digits is a coin's toss.
const SLACK: f64 = 0.3;

type Row = HashMap<String, String>;

fn rows(file: &str) -> Vec<Row> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/strd").join(file);
    let mut reader = csv::Reader::from_path(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    reader.deserialize().map(|row| row.unwrap()).collect()
}

fn column(rows: &[Row], name: &str) -> Vec<f64> {
    rows.iter().map(|row| row[name].parse().unwrap_or_else(|_| panic!("{name}: {}", row[name]))).collect()
}

/// Digits that agree, 15 at most; against a certified zero, the zeros after the point.
fn digits(found: f64, certified: f64) -> f64 {
    let scale = if certified == 0.0 { 1.0 } else { certified.abs() };
    (-((found - certified).abs() / scale).log10()).min(15.0)
}

fn reference(dataset: &str, method: &str, quantity: &str) -> f64 {
    let rows = rows("lre_reference.csv");
    let of = |row: &&Row| row["dataset"] == dataset && row["method"] == method && row["quantity"] == quantity;
    let row = rows.iter().find(of).unwrap_or_else(|| panic!("no reference for {dataset} {method} {quantity}"));
    row["digits"].parse().unwrap()
}

/// Collects what falls short, so that one failure shows all.
#[derive(Default)]
struct Ledger(Vec<String>);

impl Ledger {
    fn demand(&mut self, what: &str, reached: f64, least: f64) {
        println!("{what}: {reached:.1} digits (at least {least:.1})");
        if reached.is_nan() || reached < least {
            self.0.push(format!("{what}: {reached:.2} digits, {least:.2} demanded"));
        }
    }

    fn close(self) {
        assert!(self.0.is_empty(), "{}", self.0.join("\n"));
    }
}

#[test]
fn univariate_sets_reach_the_ceiling_of_doubles() {
    let mut ledger = Ledger::default();
    let sets = rows("univariate_certified.csv");
    assert_eq!(sets.len(), 9);
    for certified in &sets {
        let name = certified["dataset"].as_str();
        let value = |key: &str| certified[key].parse::<f64>().unwrap();
        let data = column(&rows(&format!("{name}.csv")), "y");
        assert_eq!(data.len() as f64, value("n"), "{name}");
        let summary = Summary::of(&data);
        let moments = summary.moments();
        ledger.demand(&format!("{name} mean"), digits(moments.mean().unwrap(), value("mean")), 14.5);
        for (quantity, found, key) in [
            ("sd", moments.std_deviation().unwrap(), "sd_n_minus_1"),
            ("lag1", summary.lag_1_autocorrelation().unwrap(), "lag1_autocorrelation"),
        ] {
            let least = reference(name, "f64-ceiling", quantity) - SLACK;
            ledger.demand(&format!("{name} {quantity}"), digits(found, value(key)), least);
        }
    }
    ledger.close();
}

fn certified_fit(name: &str, model: &Row) -> Fit {
    let data = rows(&format!("{name}.csv"));
    let y = column(&data, "y");
    let fitted = match (model["polynomial_degree"].as_str(), model["intercept"].as_str()) {
        ("linear", "yes") => {
            let ones = vec![1.0; y.len()];
            let predictors: Vec<Vec<f64>> = (1..=6).map(|k| column(&data, &format!("x{k}"))).collect();
            let columns: Vec<&[f64]> = std::iter::once(&ones).chain(&predictors).map(Vec::as_slice).collect();
            fit(&columns, &y, Noise::Equal)
        }
        (_, "no") => fit(&[&column(&data, "x")], &y, Noise::Equal),
        (degree, _) => fit_polynomial(&column(&data, "x"), &y, degree.parse().unwrap(), Noise::Equal),
    };
    fitted.unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn linear_sets_reach_the_ceiling_of_doubles() {
    let mut ledger = Ledger::default();
    let certified = rows("linear_certified_coefficients.csv");
    let models = rows("linear_certified_summary.csv");
    assert_eq!(models.len(), 11);
    for model in &models {
        let name = model["dataset"].as_str();
        let fitted = certified_fit(name, model);
        let of_set: Vec<&Row> = certified.iter().filter(|row| row["dataset"] == name).collect();
        assert_eq!(of_set.len(), fitted.coefficients.len(), "{name}");
        let worst = |found: &[f64], key: &str| {
            let each = found.iter().zip(&of_set).map(|(&found, row)| digits(found, row[key].parse().unwrap()));
            each.fold(f64::INFINITY, f64::min)
        };
        let residual = digits(fitted.residual_std_deviation().unwrap(), model["residual_sd"].parse().unwrap());
        for (quantity, reached) in [
            ("worst-coefficient", worst(&fitted.coefficients, "estimate")),
            ("worst-sd-of-coefficient", worst(fitted.std_errors.as_ref().unwrap(), "sd_of_estimate")),
            ("residual-sd", residual),
        ] {
            ledger.demand(&format!("{name} {quantity}"), reached, reference(name, "f64-ceiling", quantity) - SLACK);
        }
        let qr = reference(name, "householder-qr-f64", "worst-coefficient");
        ledger.demand(&format!("{name} against QR in f64"), worst(&fitted.coefficients, "estimate"), qr - 0.1);
    }
    ledger.close();
}
