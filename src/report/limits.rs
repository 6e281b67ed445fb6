//! Shadow limits as a table: what `etendue exact --limits` prints.

use std::io::Write;

use super::ReportError;
use super::column::{Column, Field, Table};
use super::tables::column;
use crate::oracle::limits::Limit;

/// A case whose limits are known.
#[derive(Clone, Copy, Debug)]
pub struct LimitsCase<'a> {
    pub name: &'a str,
    /// In order along its measured line.
    pub limits: &'a [Limit],
}

pub(super) struct LimitRow<'a> {
    case: &'a str,
    limit: &'a Limit,
}

/// Writes one row for each limit of each case, numbers with 17 significant digits.
pub fn write_limits<'a>(out: impl Write, cases: impl IntoIterator<Item = LimitsCase<'a>>) -> Result<(), ReportError> {
    let rows =
        cases.into_iter().flat_map(|case| case.limits.iter().map(move |limit| LimitRow { case: case.name, limit }));
    limits().write(rows, out)
}

pub(super) fn limits<'a>() -> Table<LimitRow<'a>> {
    Table {
        file: "limits.csv",
        row: "a place on a case's measured line where what is seen of the sources changes its kind \
              (`etendue exact --limits` prints this table on standard output)",
        case: |r| r.case,
        columns: vec![
            column!("case", "", "the case's name", |r| r.case),
            column!(
                "limit",
                "",
                "what happens there on the way along the line: `umbra_begins`, `umbra_ends`, the same of `penumbra` and of \
                 `antumbra` (where a closed ring of the source is seen around the occluder), `source_rises`, `source_sets`; \
                 a stretch shorter than 1/1024 of the line may be missed where the method is `bisection`",
                |r| r.limit.name()
            ),
            column!("distance_m", "m", "along the line from its first end", |r| Field::Digits17(r.limit.distance)),
            column!("x_m", "m", "where the limit is", |r| Field::Digits17(r.limit.position.x)),
            column!("y_m", "m", "where the limit is", |r| Field::Digits17(r.limit.position.y)),
            column!("z_m", "m", "where the limit is", |r| Field::Digits17(r.limit.position.z)),
            column!(
                "region_before",
                "",
                "`lit`, `penumbra`, `umbra` or `below_horizon`; an antumbra is penumbra",
                |r| r.limit.before.region().name()
            ),
            column!("region_after", "", "the same beyond the limit", |r| r.limit.after.region().name()),
            column!("bound_m", "m", "the distance is off by no more than this", |r| Field::Digits17(r.limit.bound)),
            column!("method", "", "`closed-form` or `bisection`", |r| r.limit.method.name()),
        ],
        more: &[],
    }
}
