//! Exact values as a table: what `etendue exact` prints.

use std::io::Write;

use super::ReportError;
use super::column::{Column, Field, MoreColumns, MoreDescribed, Table};
use super::tables::column;
use crate::configuration::MeasurementPoint;
use crate::oracle::optics::{Arriving, Bounded};
use crate::oracle::{Derivatives, Method, Parameter, Truth};
use crate::radiometry::Albedo;

/// A case whose exact values are known.
#[derive(Clone, Copy, Debug)]
pub struct ExactCase<'a> {
    pub name: &'a str,
    /// The receiver's at each point, or `None`.
    pub albedos: Option<&'a [Albedo]>,
    pub points: &'a [MeasurementPoint],
    /// One for each point.
    pub truths: &'a [Truth],
    /// What takes bends, one for each point.
    pub arriving: &'a [Arriving],
    /// One for each point, or none.
    pub derivatives: &'a [Derivatives],
}

pub(super) struct ExactRow<'a> {
    case: ExactCase<'a>,
    point: usize,
    at: &'a MeasurementPoint,
    truth: &'a Truth,
    arriving: &'a Arriving,
    derivatives: Option<&'a Derivatives>,
}

impl ExactRow<'_> {
    /// Straight from the sources: those with area, and where [`Arriving`] tells it the others; `None` where only the sum of
    /// all ways is known.
    fn direct(&self) -> Option<Bounded> {
        let [value, bound] = [self.truth.irradiance, self.truth.bound].map(|x| x.watts_per_square_metre());
        let only_total = self.arriving.total.is_some() && self.arriving.indirect.is_none();
        // The oracle's own value of sources with area is the better one.
        let told = self.arriving.direct.filter(|_| value == 0.0);
        if only_total { None } else { Some(told.unwrap_or(Bounded { value, bound })) }
    }

    /// Of all ways, as far as they are known.
    fn all(&self) -> Bounded {
        let parts = [self.direct(), self.arriving.caustic, self.arriving.indirect];
        let sum = |value: fn(&Bounded) -> f64| parts.iter().flatten().map(value).sum();
        let known = Bounded { value: sum(|part| part.value), bound: sum(|part| part.bound) };
        if self.direct().is_none() { self.arriving.total.unwrap_or(known) } else { known }
    }
}

fn told(part: Option<Bounded>) -> Option<Field> {
    part.map(|part| Field::Digits17(part.value))
}

/// Writes one row for each point of each case, numbers with 17 significant digits.
///
/// - `parameters`: those that the cases' derivatives are taken with respect to; each adds a column
///   `d_PARAMETER_UNIT`, and `derivative_side` comes last: `both`, or `one` where outlines touch
pub fn write_exact<'a>(
    out: impl Write,
    cases: impl IntoIterator<Item = ExactCase<'a>>,
    parameters: &[Parameter],
) -> Result<(), ReportError> {
    let rows = cases.into_iter().flat_map(|case| {
        assert_eq!(case.points.len(), case.truths.len(), "{}: one truth for each point", case.name);
        assert!(
            case.albedos.is_none_or(|albedos| albedos.len() == case.points.len()),
            "{}: one albedo for each point",
            case.name
        );
        assert_eq!(case.points.len(), case.arriving.len(), "{}: light by all ways for each point", case.name);
        let points = case.points.iter().zip(case.truths).enumerate();
        points.map(move |(point, (at, truth))| ExactRow {
            case,
            point,
            at,
            truth,
            arriving: &case.arriving[point],
            derivatives: case.derivatives.get(point),
        })
    });
    let mut more: Vec<MoreColumns<ExactRow<'a>>> = Vec::new();
    if !parameters.is_empty() {
        more.push(MoreColumns {
            names: parameters.iter().map(|p| format!("d_{p}_{}", p.unit_of_derivative())).collect(),
            values: |row| match row.derivatives.and_then(|d| d.values.as_ref()) {
                Some(values) => values.iter().map(|value| Field::Digits17(*value)).collect(),
                None => Vec::new(),
            },
        });
        more.push(MoreColumns {
            names: vec!["derivative_side".to_owned()],
            values: |row| row.derivatives.map(|d| Field::from(d.side.name())).into_iter().collect(),
        });
    }
    exact().write_with(rows, &more, out)
}

pub(super) fn exact<'a>() -> Table<ExactRow<'a>> {
    Table {
        file: "exact.csv",
        row: "the exact values at one measurement point (`etendue exact` prints this table on standard output)",
        case: |r| r.case.name,
        columns: vec![
            column!("case", "", "the case's name", |r| r.case.name),
            column!("point", "", "which measurement point, from 0, in the case's order", |r| r.point),
            column!("x_m", "m", "where the point is", |r| Field::Digits17(r.at.position().x)),
            column!("y_m", "m", "where the point is", |r| Field::Digits17(r.at.position().y)),
            column!("z_m", "m", "where the point is", |r| Field::Digits17(r.at.position().z)),
            column!("nx", "", "unit normal towards the receiving side", |r| Field::Digits17(r.at.normal().x)),
            column!("ny", "", "unit normal towards the receiving side", |r| Field::Digits17(r.at.normal().y)),
            column!("nz", "", "unit normal towards the receiving side", |r| Field::Digits17(r.at.normal().z)),
            column!("region", "", "`lit`, `penumbra`, `umbra`, `below_horizon` or `edge`", |r| r.truth.region.name()),
            column!("form_factor", "", "of the visible parts of all sources, seen directly", |r| Field::Digits17(
                r.truth.form_factor.ratio()
            )),
            column!(
                "direct_W_m2",
                "W/m²",
                "irradiance that comes straight from the sources; the strategies measure this alone; empty where only the sum is known",
                |r| told(r.direct())
            ),
            column!(
                "caustic_W_m2",
                "W/m²",
                "irradiance by way of mirrors and glass alone; empty where it is not known",
                |r| told(r.arriving.caustic)
            ),
            column!(
                "indirect_W_m2",
                "W/m²",
                "irradiance by way of diffuse surfaces; empty where it is not known",
                |r| told(r.arriving.indirect)
            ),
            column!(
                "irradiance_W_m2",
                "W/m²",
                "the sum of the three, as far as they are known; all light where only that is known",
                |r| Field::Digits17(r.all().value)
            ),
            column!(
                "radiosity_W_m2",
                "W/m²",
                "irradiance times the receiver's albedo at the point; empty without one",
                |r| r.case.albedos.map(|albedos| Field::Digits17(r.all().value * albedos[r.point].ratio()))
            ),
            column!("error_bound", "W/m²", "the irradiance is off by no more than this", |r| Field::Digits17(
                r.all().bound
            )),
            column!("method", "", "`closed-form` or `quadrature`", |r| {
                if r.arriving.by_quadrature { Method::Quadrature.name() } else { r.truth.method.name() }
            }),
        ],
        more: &[
            MoreDescribed {
                name: "d_PARAMETER_UNIT",
                unit: "W/m³, W/m² or 1",
                meaning: "with `--derivative PARAMETER,…`, one for each, in the order they were asked for: the irradiance's \
                          exact derivative with respect to that number of the case, UNIT being `W_m3` (a length), `W_m2` (a \
                          component of a unit normal) or `1` (an exitance); empty where there is no closed form, or outlines \
                          touch in a way that leaves it undecided",
            },
            MoreDescribed {
                name: "derivative_side",
                unit: "",
                meaning: "with `--derivative`: `both`, or `one` where outlines touch and moves the other way may have another \
                          derivative",
            },
        ],
    }
}
