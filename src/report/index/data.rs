//! What the page's script draws from, as JSON: rounded to what an eye can tell, the tables have the rest.

use serde_json::{Value, json};

use crate::configuration::Arrangement;
use crate::oracle::Region;
use crate::report::record::{CaseRecord, CellRecord, ReportRecord, StrategyRecord};
use crate::trial::Correlation;

/// Distances of each correlation.
const MOST_SEPARATIONS: usize = 40;
/// More points than these are not drawn one by one: every so many-th is.
const MOST_POINTS: usize = 2500;

/// All cases, ready to stand in a `<script>` element.
pub fn embedded(record: &ReportRecord) -> String {
    let cases: Vec<Value> = record.cases.iter().map(case).collect();
    // `</script>` and `<!--` would end the element.
    json!({ "cases": cases }).to_string().replace('<', "\\u003c")
}

fn case(case: &CaseRecord) -> Value {
    let every = case.points.len().div_ceil(MOST_POINTS).max(1);
    let samples = case.shown_samples();
    let (kind, grid) = match case.arrangement {
        Arrangement::Grid { nu, nv } if nu > 1 && nv > 1 && every == 1 => ("map", Some([nu, nv])),
        Arrangement::Line => ("line", None),
        _ => ("points", None),
    };
    let regions: String = case.points.iter().step_by(every).map(|point| letter(point.region)).collect();
    let strategies: Vec<Value> = case.strategies.iter().map(|made| strategy(case, made, samples, every)).collect();
    json!({
        "name": case.name,
        "kind": kind,
        "grid": grid,
        "samples": samples,
        // As they are: two places may not fall together.
        "along": case.places().into_iter().step_by(every).collect::<Vec<_>>(),
        "regions": regions,
        "exact": case.points.iter().step_by(every).map(|point| short(point.exact)).collect::<Vec<_>>(),
        "strategies": strategies,
        "rings": rings(case),
        "texels": case.texels.iter().map(|row| {
            let relative = |error: f64| short(error / row.irradiance);
            json!([row.rays, short(row.size), relative(row.variance.sqrt()), relative(row.predicted_variance.sqrt()),
                relative(row.exact_bias)])
        }).collect::<Vec<_>>(),
        "paths": case.paths.iter().filter_map(|path| {
            let (point, exact) = (path.point?, path.exact?);
            Some(json!([path.estimator, point, short(path.measured), short(path.std_error.unwrap_or(0.0)), short(exact)]))
        }).collect::<Vec<_>>(),
    })
}

fn strategy(case: &CaseRecord, made: &StrategyRecord, samples: Option<u64>, every: usize) -> Value {
    let mean = case.points.iter().map(|point| point.exact).sum::<f64>() / case.points.len().max(1) as f64;
    let shown = made.cells.iter().find(|cell| Some(cell.samples) == samples);
    let of = |pick: fn(&crate::trial::Measured) -> f64| -> Vec<Value> {
        shown.map_or(Vec::new(), |cell| cell.points.iter().step_by(every).map(|p| short(pick(p))).collect())
    };
    let biases = made.cells.iter().filter(|_| mean > 0.0);
    let biases = biases.filter_map(|cell| {
        let [bias, error] = cell.mean_bias?;
        Some(json!([cell.samples, short(bias / mean), short(error / mean)]))
    });
    let seen = case.verdicts.iter().find(|judged| judged.property == "bias" && judged.strategy == made.name);
    let curves = made.rates.iter().filter(|rate| rate.quantity == "variance").map(|rate| {
        let points: Vec<_> =
            rate.points.iter().map(|p| json!([p.samples, short(p.value), short(p.low), short(p.high)])).collect();
        json!({
            "region": rate.region.map_or("all", Region::name),
            "slope": short(rate.slope),
            "low": short(rate.slope_low),
            "high": short(rate.slope_high),
            "expected": short(rate.expected_slope),
            "asymptote": rate.asymptote(),
            "intercept": rate.line.map(|line| short(line.intercept)),
            "points": points,
        })
    });
    json!({
        "name": made.name,
        "replicates": shown.map(|cell: &CellRecord| cell.replicates),
        "bias": of(|p| p.bias),
        "error": of(|p| p.bias_std_error),
        "spread": of(|p| p.variance.max(0.0).sqrt()),
        "biases": biases.collect::<Vec<_>>(),
        "seen": seen.and_then(|judged| judged.smallest_bias_mean).map(short),
        "curves": curves.collect::<Vec<_>>(),
        "correlations": correlations(made),
    })
}

/// At most three sample counts, and so many distances.
fn correlations(made: &StrategyRecord) -> Vec<Value> {
    let curve = |samples: u64| {
        let mut of: Vec<&Correlation> = made.correlations.iter().filter(|c| c.samples == samples).collect();
        of.sort_by(|a, b| a.separation.total_cmp(&b.separation));
        let every = of.len().div_ceil(MOST_SEPARATIONS).max(1);
        let points: Vec<_> = of
            .into_iter()
            .step_by(every)
            .map(|c| {
                let predicted = c.predicted.map(short);
                json!([short(c.separation), short(c.correlation), short(c.low), short(c.high), predicted])
            })
            .collect();
        json!([samples, points])
    };
    made.shown_counts().into_iter().map(curve).collect()
}

fn rings(case: &CaseRecord) -> Vec<Value> {
    let rings = case.rings.iter().filter_map(|ring| {
        let position = short(ring.position?);
        Some(json!([
            ring.order,
            position,
            short(ring.measured),
            short(ring.std_error.unwrap_or(0.0)),
            short(ring.exact)
        ]))
    });
    rings.collect()
}

fn letter(region: Region) -> char {
    match region {
        Region::Lit => 'l',
        Region::Penumbra => 'p',
        Region::Umbra => 'u',
        Region::BelowHorizon => 'b',
        Region::Edge => 'e',
    }
}

/// To four digits.
fn short(x: f64) -> Value {
    format!("{x:.3e}").parse::<f64>().ok().filter(|x| x.is_finite()).map_or(Value::Null, |x| {
        // Whole numbers without their point take less room.
        if x == x.trunc() && x.abs() < 1e9 { json!(x as i64) } else { json!(x) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_four_digits() {
        assert_eq!(short(0.123_456_78).to_string(), "0.1235");
        assert_eq!(short(-123_456.0).to_string(), "-123500");
        assert_eq!(short(0.0).to_string(), "0");
        assert_eq!(short(f64::NAN), Value::Null);
    }
}
