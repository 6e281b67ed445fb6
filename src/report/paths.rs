//! The table of paths from the eye.

use super::column::{Column, Field, Table};
use super::tables::column;
use crate::trial::{CaseOutcome, RunOutcome};

/// What one estimator found at one place of one case.
pub(super) struct PathRow<'a> {
    case: &'a CaseOutcome,
    found: &'a crate::trial::PathRow,
}

pub(super) fn path_rows(outcome: &RunOutcome) -> impl Iterator<Item = PathRow<'_>> {
    outcome.cases.iter().flat_map(|case| {
        let paths = case.paths.iter();
        paths.flat_map(move |paths| paths.rows.iter().map(move |found| PathRow { case, found }))
    })
}

pub(super) fn paths<'a>() -> Table<PathRow<'a>> {
    Table {
        file: "paths.csv",
        row: "the irradiance that paths from the eye found at one point (or all over the receiver, beside what the map holds), by light that has come one way",
        case: |r| &r.case.name,
        columns: vec![
            column!("case", "", "the case's name", |r| r.case.name.as_str()),
            column!(
                "estimator",
                "",
                "`eye_paths` (sources are met by chance), `next_event` (every diffuse surface on the way sends shadow rays), or `light_map` (rays from the light, for comparison)",
                |r| r.found.estimator
            ),
            column!("point", "", "which measurement point, from 0; empty for the whole receiver", |r| r
                .found
                .point
                .map(|(point, _)| point)),
            column!("x_m", "m", "where the point is", |r| r.found.point.map(|(_, at)| at.x)),
            column!("y_m", "m", "where the point is", |r| r.found.point.map(|(_, at)| at.y)),
            column!("z_m", "m", "where the point is", |r| r.found.point.map(|(_, at)| at.z)),
            column!(
                "part",
                "",
                "which light: `total`, `caustic` (by mirrors and glass alone) or `indirect` (by way of a diffuse surface)",
                |r| r.found.part
            ),
            column!("paths", "", "paths from this place; of `light_map`, rays", |r| r.found.paths),
            column!(
                "reached_share",
                "",
                "share of the paths that came upon a source by chance and by such a way; nought where all sources are without extent",
                |r| r.found.reached_share
            ),
            column!("measured_irradiance_W_m2", "W/m²", "mean over the paths", |r| r.found.measured),
            column!("std_error_W_m2", "W/m²", "standard error of it", |r| r.found.std_error),
            column!("exact_irradiance_W_m2", "W/m²", "what is due; empty where it is not known", |r| r.found.exact),
            column!("exact_bound_W_m2", "W/m²", "the exact value is off by no more than this", |r| r.found.bound),
            column!("variance_W2_m4", "W²/m⁴", "of one path, estimated", |r| r.found.variance),
            column!(
                "largest_variance_W2_m4",
                "W²/m⁴",
                "what that is at most, by the exact side; the verdict leans on it",
                |r| r.found.largest_variance
            ),
            column!(
                "verdict",
                "",
                "`fail` where the evidence against this point alone reaches 10^6, `undecided` where a deviation of all of it would not have been seen, else `pass`; `not_judged` where nothing is known",
                |r| r.found.verdict.map_or("not_judged", |verdict| verdict.name())
            ),
        ],
        more: &[],
    }
}
