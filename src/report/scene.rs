//! The table of what stands in the rooms, for their drawings.

use super::column::{Column, Field, Table};
use super::tables::column;
use crate::configuration::{Figure, Stroke};
use crate::geometry::DVec3;
use crate::trial::{CaseOutcome, RunOutcome};

/// One corner of a line, or one round figure.
pub(super) struct SceneRow<'a> {
    case: &'a CaseOutcome,
    thing: (usize, &'a Figure),
    stroke: (usize, &'a Stroke),
    vertex: usize,
}

impl SceneRow<'_> {
    fn at(&self) -> DVec3 {
        match self.stroke.1 {
            Stroke::Round { center, .. } => *center,
            Stroke::Closed(through) | Stroke::Open(through) | Stroke::Hull(through) => through[self.vertex],
        }
    }
    fn normal(&self) -> Option<DVec3> {
        if let Stroke::Round { normal, .. } = self.stroke.1 { *normal } else { None }
    }
    fn radius(&self) -> Option<f64> {
        if let Stroke::Round { radius, .. } = self.stroke.1 { Some(*radius) } else { None }
    }
    fn form(&self) -> &'static str {
        match self.stroke.1 {
            Stroke::Round { .. } => "round",
            Stroke::Closed(_) => "closed",
            Stroke::Open(_) => "open",
            Stroke::Hull(_) => "hull",
        }
    }
}

pub(super) fn scene_rows(outcome: &RunOutcome) -> impl Iterator<Item = SceneRow<'_>> {
    let vertices = |stroke: &Stroke| match stroke {
        Stroke::Round { .. } => 1,
        Stroke::Closed(through) | Stroke::Open(through) | Stroke::Hull(through) => through.len(),
    };
    let things =
        outcome.cases.iter().flat_map(|case| case.figures.iter().enumerate().map(move |thing| (case, thing)));
    let strokes =
        things.flat_map(|(case, thing)| thing.1.strokes.iter().enumerate().map(move |stroke| (case, thing, stroke)));
    strokes.flat_map(move |(case, thing, stroke)| {
        (0..vertices(stroke.1)).map(move |vertex| SceneRow { case, thing, stroke, vertex })
    })
}

pub(super) fn scene<'a>() -> Table<SceneRow<'a>> {
    Table {
        file: "scene.csv",
        row: "one corner of a line that a thing in the room is drawn by, or a circle or sphere of it",
        case: |r| &r.case.name,
        columns: vec![
            column!("case", "", "the case's name", |r| r.case.name.as_str()),
            column!("thing", "", "which thing of the room, from 0", |r| r.thing.0),
            column!("role", "", "`source`, `lamp`, `occluder`, `mirror`, `glass`, `diffuse` or `receiver`", |r| r
                .thing
                .1
                .role
                .name()),
            column!("shape", "", "as the case file names it", |r| r.thing.1.shape),
            column!("textured", "", "`yes` where what it sends out, or sends back, varies over it", |r| {
                if r.thing.1.is_textured { "yes" } else { "no" }
            }),
            column!("stroke", "", "which line of the thing, from 0", |r| r.stroke.0),
            column!(
                "form",
                "",
                "`round` (a circle about its normal; a sphere where that is empty), `closed` or `open` (a line through its \
                corners), `hull` (the outline of all corners together, of a mesh)",
                |r| r.form()
            ),
            column!("vertex", "", "which corner of the line, from 0", |r| r.vertex),
            column!("x_m", "m", "where the corner is; of a round figure, its centre", |r| r.at().x),
            column!("y_m", "m", "where the corner is", |r| r.at().y),
            column!("z_m", "m", "where the corner is", |r| r.at().z),
            column!("normal_x", "", "unit normal of a circle", |r| r.normal().map(|n| n.x)),
            column!("normal_y", "", "unit normal of a circle", |r| r.normal().map(|n| n.y)),
            column!("normal_z", "", "unit normal of a circle", |r| r.normal().map(|n| n.z)),
            column!("radius_m", "m", "of a round figure", |r| r.radius()),
        ],
        more: &[],
    }
}
