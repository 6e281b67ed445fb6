//! From tables to a record: what is missing or broken is told, and what came before it is kept.

use std::collections::HashMap;

use serde::Deserialize;

use super::table::{Place, Row};
use super::{
    CaseRecord, CellRecord, FigureRecord, PathRecord, PointRecord, RateLine, RateRecord, ReportRecord, RingRecord,
    StrategyRecord, VerdictRecord,
};
use crate::configuration::{Arrangement, Role, Stroke};
use crate::geometry::DVec3;
use crate::intake::{REPORT_CASES, SERIES, STRATEGIES};
use crate::oracle::Region;
use crate::report::ReportError;
use crate::statistics::Verdict;
use crate::trial::{Correlation, LightRow, MapRow, Measured, RatePoint};

/// What `manifest.json` tells.
#[derive(Deserialize)]
pub(in crate::report) struct Manifest {
    pub etendue_version: String,
    pub seed: u64,
    pub command: String,
    pub cases: Vec<ManifestCase>,
}

#[derive(Deserialize)]
pub(in crate::report) struct ManifestCase {
    pub name: String,
    pub digest: String,
    #[serde(default)]
    pub title: String,
    /// Columns and rows of a grid; absent of other points.
    #[serde(default)]
    pub grid: Option<[usize; 2]>,
    #[serde(default)]
    pub line: bool,
}

const FILE: &str = "manifest.json";

/// `None` where there is no manifest.
pub(in crate::report) fn manifest(place: Place) -> Result<Option<Manifest>, ReportError> {
    let Some(mut opened) = place.open(FILE)? else { return Ok(None) };
    let mut text = String::new();
    let path = place.path(FILE);
    opened.read_to_string(&mut text).map_err(|source| ReportError::Unreadable { path: path.clone(), source })?;
    serde_json::from_str(&text).map(Some).map_err(|error| ReportError::NotOurs {
        path,
        line: error.line() as u64,
        reason: error.to_string(),
    })
}

/// Reads all of a report that can be read.
pub(in crate::report) fn read(place: Place) -> ReportRecord {
    let mut reader = Reader { record: ReportRecord::default(), by_name: HashMap::new() };
    reader.manifest(place);
    let tables: [(&str, &str, Take); 11] = [
        ("convergence.csv", "means, variances and profiles", Reader::convergence),
        ("means.csv", "biases over all points", Reader::means),
        ("rates.csv", "slopes", Reader::rate),
        ("curves.csv", "variance curves", Reader::curve),
        ("correlation.csv", "correlations", Reader::correlation),
        ("energy.csv", "ledgers", Reader::energy),
        ("caustic.csv", "caustics", Reader::caustic),
        ("texels.csv", "what maps are off by", Reader::texels),
        ("paths.csv", "eye paths", Reader::path),
        ("scene.csv", "drawings of the rooms", Reader::scene),
        ("verdicts.csv", "verdicts", Reader::verdict),
    ];
    for (file, what, take) in tables {
        match place.each(file, |row| take(&mut reader, row)) {
            Ok(true) => {}
            Ok(false) => reader.record.faults.push(format!("{file} is missing: no {what}.")),
            Err(error) => reader.record.faults.push(format!("{error}. What comes after it is left out.")),
        }
    }
    let mut record = reader.record;
    for case in &mut record.cases {
        let n = case.points.len();
        // Not the last cell of a table that ends too soon, nor one that begins too late: of no point there is nothing to show.
        let is_whole = |cell: &CellRecord| n > 0 && cell.points.len() == n;
        case.strategies.iter_mut().for_each(|strategy| strategy.cells.retain(is_whole));
        if let Arrangement::Grid { nu, nv } = case.arrangement
            && nu.checked_mul(nv) != Some(n)
        {
            case.arrangement = Arrangement::Scattered;
        }
    }
    record
}

type Take = fn(&mut Reader, &Row) -> Result<(), ReportError>;

struct Reader {
    record: ReportRecord,
    by_name: HashMap<String, usize>,
}

impl Reader {
    fn manifest(&mut self, place: Place) {
        match manifest(place) {
            Ok(None) => self.record.faults.push("manifest.json is missing: no command, seed and titles.".to_owned()),
            Err(error) => self.record.faults.push(format!("{error}.")),
            Ok(Some(manifest)) => {
                self.record.version = manifest.etendue_version;
                self.record.seed = manifest.seed.to_string();
                self.record.command = manifest.command;
                for told in manifest.cases {
                    let Some(case) = self.case_named(&told.name) else {
                        let path = place.path(FILE).display().to_string();
                        self.record
                            .faults
                            .push(format!("{path}: more than {REPORT_CASES} cases. The others are left out."));
                        break;
                    };
                    case.digest = told.digest;
                    if !told.title.is_empty() {
                        case.title = told.title;
                    }
                    case.arrangement = match told.grid {
                        Some([nu, nv]) => Arrangement::Grid { nu, nv },
                        None if told.line => Arrangement::Line,
                        None => Arrangement::Scattered,
                    };
                }
            }
        }
    }

    /// `None` where there are too many already.
    fn case_named(&mut self, name: &str) -> Option<&mut CaseRecord> {
        let cases = &mut self.record.cases;
        if let Some(place) = self.by_name.get(name) {
            return Some(&mut cases[*place]);
        }
        if cases.len() as u64 >= REPORT_CASES {
            return None;
        }
        self.by_name.insert(name.to_owned(), cases.len());
        cases.push(CaseRecord::named(name));
        cases.last_mut()
    }

    fn case(&mut self, row: &Row) -> Result<&mut CaseRecord, ReportError> {
        self.case_named(row.text("case")?).ok_or_else(|| row.too_many("cases", REPORT_CASES))
    }

    fn strategy(&mut self, row: &Row) -> Result<&mut StrategyRecord, ReportError> {
        let name = row.text("strategy")?.to_owned();
        let made = &mut self.case(row)?.strategies;
        let found = made.iter().position(|strategy| strategy.name == name);
        if found.is_none() && made.len() as u64 >= STRATEGIES {
            return Err(row.too_many("strategies of a case", STRATEGIES));
        }
        let place = found.unwrap_or_else(|| {
            let (cells, rates, correlations) = (Vec::new(), Vec::new(), Vec::new());
            made.push(StrategyRecord { name, cells, rates, correlations });
            made.len() - 1
        });
        Ok(&mut made[place])
    }

    fn convergence(&mut self, row: &Row) -> Result<(), ReportError> {
        let (point, samples, replicates) = (row.count("point")?, row.count("samples")?, row.count("replicates")?);
        let record = PointRecord {
            position: position(row)?,
            region: region(row)?.ok_or_else(|| row.wrong("region", REGIONS))?,
            exact: due(row, "exact_irradiance_W_m2")?,
            bound: due(row, "exact_bound_W_m2")?,
        };
        let interval = row.with_interval(["variance_W2_m4", "variance_low", "variance_high"])?;
        let measured = Measured {
            mean: due(row, "mean_irradiance_W_m2")?,
            bias: due(row, "bias_W_m2")?,
            bias_std_error: due(row, "bias_std_error_W_m2")?,
            variance: due(row, "variance_W2_m4")?,
            variance_interval: interval.map(|(_, interval)| interval),
            predicted_variance: row.number("predicted_variance_W2_m4")?,
            mse: due(row, "mse_W2_m4")?,
        };
        let case = self.case(row)?;
        if point == case.points.len() as u64 {
            case.points.push(record);
        }
        let strategy = self.strategy(row)?;
        if strategy.cells.last().is_none_or(|cell| cell.samples != samples || point == 0) {
            if strategy.cells.len() as u64 >= SERIES {
                return Err(row.too_many("sample counts of a strategy", SERIES));
            }
            strategy.cells.push(CellRecord { samples, replicates, points: Vec::new(), mean_bias: None });
        }
        let cell = strategy.cells.last_mut().expect("one was pushed");
        if point != cell.points.len() as u64 {
            return Err(row.wrong("point", &format!("{} in this place", cell.points.len())));
        }
        cell.points.push(measured);
        Ok(())
    }

    fn means(&mut self, row: &Row) -> Result<(), ReportError> {
        let samples = row.count("samples")?;
        let bias = [due(row, "bias_W_m2")?, due(row, "bias_std_error_W_m2")?];
        let cells = &mut self.strategy(row)?.cells;
        if let Some(cell) = cells.iter_mut().find(|cell| cell.samples == samples) {
            cell.mean_bias = Some(bias);
        }
        Ok(())
    }

    fn rate(&mut self, row: &Row) -> Result<(), ReportError> {
        let rate = RateRecord {
            quantity: row.text("quantity")?.to_owned(),
            region: region_or_all(row)?,
            slope: due(row, "slope")?,
            slope_low: due(row, "slope_low")?,
            slope_high: due(row, "slope_high")?,
            expected_slope: due(row, "expected_slope")?,
            line: None,
            points: Vec::new(),
        };
        let rates = &mut self.strategy(row)?.rates;
        if rates.len() as u64 >= SERIES {
            return Err(row.too_many("slopes of a strategy", SERIES));
        }
        rates.push(rate);
        Ok(())
    }

    fn curve(&mut self, row: &Row) -> Result<(), ReportError> {
        let (region, samples) = (region_or_all(row)?, row.count("samples")?);
        let point = RatePoint {
            samples,
            value: due(row, "value_W2_m4")?,
            low: due(row, "low_W2_m4")?,
            high: due(row, "high_W2_m4")?,
        };
        let (fitted, asymptote) = (due(row, "fitted_W2_m4")?, due(row, "asymptotic_slope")?);
        let rates = &mut self.strategy(row)?.rates;
        if let Some(rate) = rates.iter_mut().find(|rate| rate.region == region) {
            if rate.line.is_none() && fitted > 0.0 && samples > 0 {
                let intercept = fitted.ln() - rate.slope * (samples as f64).ln();
                rate.line = Some(RateLine { asymptote, intercept });
            }
            rate.points.push(point);
        }
        Ok(())
    }

    fn correlation(&mut self, row: &Row) -> Result<(), ReportError> {
        let correlation = Correlation {
            samples: row.count("samples")?,
            separation: due(row, "separation_m")?,
            correlation: due(row, "correlation")?,
            low: due(row, "low")?,
            high: due(row, "high")?,
            predicted: row.number("predicted")?,
        };
        self.strategy(row)?.correlations.push(correlation);
        Ok(())
    }

    fn energy(&mut self, row: &Row) -> Result<(), ReportError> {
        let books = LightRow {
            rays: row.count("rays")?,
            source_power: due(row, "source_power_W")?,
            emitted: due(row, "emitted_W")?,
            deposited: due(row, "deposited_W")?,
            deposited_std_error: row.number("deposited_std_error_W")?,
            absorbed: due(row, "absorbed_W")?,
            escaped: due(row, "escaped_W")?,
            terminated: due(row, "terminated_W")?,
            residual: due(row, "residual_W")?,
            map_integral: due(row, "map_integral_W")?,
            exact_deposited: row.number("exact_deposited_W")?,
            verdict: verdict(row)?,
        };
        self.case(row)?.ledger.push(books);
        Ok(())
    }

    fn caustic(&mut self, row: &Row) -> Result<(), ReportError> {
        let ring = RingRecord {
            // `all`: by any number of interactions.
            order: if row.text("order")? == "all" { 0 } else { row.count("order")? as usize },
            bin: row.count("bin")? as usize,
            position: row.number("position_m")?,
            measured: due(row, "measured_irradiance_W_m2")?,
            std_error: row.number("std_error_W_m2")?,
            exact: due(row, "exact_irradiance_W_m2")?,
            verdict: verdict(row)?,
        };
        self.case(row)?.rings.push(ring);
        Ok(())
    }

    fn texels(&mut self, row: &Row) -> Result<(), ReportError> {
        let texels = MapRow {
            rays: row.count("rays")?,
            size: due(row, "size_m")?,
            places: row.count("places")? as usize,
            irradiance: due(row, "irradiance_W_m2")?,
            bias: due(row, "bias_W_m2")?,
            exact_bias: due(row, "exact_bias_W_m2")?,
            variance: due(row, "variance_W2_m4")?,
            predicted_variance: due(row, "predicted_variance_W2_m4")?,
        };
        self.case(row)?.texels.push(texels);
        Ok(())
    }

    fn path(&mut self, row: &Row) -> Result<(), ReportError> {
        let path = PathRecord {
            estimator: row.text("estimator")?.to_owned(),
            point: if row.text("point")?.is_empty() { None } else { Some(row.count("point")?) },
            part: row.text("part")?.to_owned(),
            paths: row.count("paths")?,
            measured: due(row, "measured_irradiance_W_m2")?,
            std_error: row.number("std_error_W_m2")?,
            exact: row.number("exact_irradiance_W_m2")?,
            verdict: judged(row)?,
        };
        self.case(row)?.paths.push(path);
        Ok(())
    }

    /// Rows of one stroke follow each other.
    fn scene(&mut self, row: &Row) -> Result<(), ReportError> {
        let (thing, stroke, vertex) = (row.count("thing")?, row.count("stroke")?, row.count("vertex")?);
        let role = Role::ALL.into_iter().find(|role| row.text("role").is_ok_and(|said| said == role.name()));
        let role = role.ok_or_else(|| row.wrong("role", "source, occluder or another part of a room"))?;
        let (shape, form, at) = (row.text("shape")?.to_owned(), row.text("form")?.to_owned(), position(row)?);
        let normal = match (row.number("normal_x")?, row.number("normal_y")?, row.number("normal_z")?) {
            (Some(x), Some(y), Some(z)) => Some(DVec3::new(x, y, z)),
            _ => None,
        };
        let (radius, is_textured) = (row.number("radius_m")?, row.text("textured")? == "yes");
        let figures = &mut self.case(row)?.figures;
        if thing == figures.len() as u64 {
            figures.push(FigureRecord { role, shape, is_textured, strokes: Vec::new() });
        }
        let n_figures = figures.len();
        let figure = figures.last_mut().filter(|_| thing + 1 == n_figures as u64);
        let figure = figure.ok_or_else(|| row.wrong("thing", "the last one or the next"))?;
        if vertex == 0 {
            let fresh = match form.as_str() {
                "round" => {
                    let radius = radius.ok_or_else(|| row.wrong("radius_m", "a radius"))?;
                    Stroke::Round { center: at, normal, radius }
                }
                "closed" => Stroke::Closed(Vec::new()),
                "open" => Stroke::Open(Vec::new()),
                "hull" => Stroke::Hull(Vec::new()),
                _ => return Err(row.wrong("form", "round, closed, open or hull")),
            };
            figure.strokes.push(fresh);
        }
        if stroke + 1 != figure.strokes.len() as u64 {
            return Err(row.wrong("stroke", "the last one or the next"));
        }
        if let Some(Stroke::Closed(through) | Stroke::Open(through) | Stroke::Hull(through)) =
            figure.strokes.last_mut()
        {
            through.push(at);
        }
        Ok(())
    }

    fn verdict(&mut self, row: &Row) -> Result<(), ReportError> {
        let effect = match (row.number("effect")?, row.number("effect_low")?, row.number("effect_high")?) {
            (Some(x), Some(low), Some(high)) => Some([x, low, high]),
            _ => None,
        };
        let judged = VerdictRecord {
            strategy: row.text("strategy")?.to_owned(),
            property: row.text("property")?.to_owned(),
            verdict: verdict(row)?,
            evidence: row.number("evidence")?,
            threshold: row.number("threshold")?,
            effect,
            smallest_bias_mean: row.number("smallest_bias_mean")?,
            smallest_bias_point: row.number("smallest_bias_point")?,
            reproduce: row.text("reproduce")?.to_owned(),
        };
        self.case(row)?.verdicts.push(judged);
        Ok(())
    }
}

/// A number that no row may lack.
fn due(row: &Row, column: &str) -> Result<f64, ReportError> {
    row.number(column)?.ok_or_else(|| row.wrong(column, "a number"))
}

fn position(row: &Row) -> Result<DVec3, ReportError> {
    Ok(DVec3::new(due(row, "x_m")?, due(row, "y_m")?, due(row, "z_m")?))
}

const REGIONS: &str = "lit, penumbra, umbra, below_horizon or edge";

fn region(row: &Row) -> Result<Option<Region>, ReportError> {
    Ok(Region::from_name(row.text("region")?))
}

fn region_or_all(row: &Row) -> Result<Option<Region>, ReportError> {
    match (row.text("region")?, region(row)?) {
        ("all", _) => Ok(None),
        (_, Some(region)) => Ok(Some(region)),
        _ => Err(row.wrong("region", &format!("all, {REGIONS}"))),
    }
}

fn verdict(row: &Row) -> Result<Verdict, ReportError> {
    Verdict::from_name(row.text("verdict")?).ok_or_else(|| row.wrong("verdict", "pass, fail or undecided"))
}

/// `None` where nothing was judged.
fn judged(row: &Row) -> Result<Option<Verdict>, ReportError> {
    if row.text("verdict")? == "not_judged" { Ok(None) } else { verdict(row).map(Some) }
}
