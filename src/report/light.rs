//! The tables of light that was followed from its sources.

use super::column::{Column, Field, Table};
use super::tables::column;
use crate::trial::{CaseOutcome, CausticBin, LightRow, MapRow, RunOutcome};

/// The books of one budget of rays.
pub(super) struct EnergyRow<'a> {
    case: &'a CaseOutcome,
    books: &'a LightRow,
}

pub(super) fn energy_rows(outcome: &RunOutcome) -> impl Iterator<Item = EnergyRow<'_>> {
    outcome.cases.iter().flat_map(|case| {
        let light = case.light.iter();
        light.flat_map(move |light| light.rows.iter().map(move |books| EnergyRow { case, books }))
    })
}

pub(super) fn energy<'a>() -> Table<EnergyRow<'a>> {
    Table {
        file: "energy.csv",
        row: "where each watt went that left the sources of one case, with one budget of rays",
        case: |r| &r.case.name,
        columns: vec![
            column!("case", "", "the case's name", |r| r.case.name.as_str()),
            column!("rays", "", "rays that left the sources", |r| r.books.rays),
            column!("source_power_W", "W", "what the sources give out, in closed form", |r| r.books.source_power),
            column!("emitted_W", "W", "what the rays carried as they left", |r| r.books.emitted),
            column!("deposited_W", "W", "left on the receiver and on diffuse surfaces", |r| r.books.deposited),
            column!(
                "deposited_std_error_W",
                "W",
                "standard error of it, over independent groups of rays; empty below two",
                |r| r.books.deposited_std_error
            ),
            column!("absorbed_W", "W", "by mirrors, occluders, sources, and backs of diffuse surfaces", |r| r
                .books
                .absorbed),
            column!("escaped_W", "W", "met nothing any more", |r| r.books.escaped),
            column!("terminated_W", "W", "beyond the limit of interactions on one path", |r| r.books.terminated),
            column!("residual_W", "W", "emitted less deposited, absorbed, escaped and terminated", |r| r
                .books
                .residual),
            column!("map_integral_W", "W", "what the texels of all maps hold", |r| r.books.map_integral),
            column!(
                "exact_deposited_W",
                "W",
                "what should have been deposited, in closed form or by quadrature; empty where it is not known (see `caustic.csv` for parts that are)",
                |r| r.books.exact_deposited
            ),
            column!(
                "verdict",
                "",
                "`pass` where residual, emitted less source power, and map integral less deposited are below 1e-12 of the source power, else `fail`; whether the deposited share is right, too, says the verdict `energy` of the case",
                |r| r.books.verdict.name()
            ),
        ],
        more: &[],
    }
}

/// One ring of one case.
pub(super) struct CausticRow<'a> {
    case: &'a CaseOutcome,
    bin: &'a CausticBin,
}

pub(super) fn caustic_rows(outcome: &RunOutcome) -> impl Iterator<Item = CausticRow<'_>> {
    outcome.cases.iter().flat_map(|case| {
        let light = case.light.iter();
        light.flat_map(move |light| light.bins.iter().map(move |bin| CausticRow { case, bin }))
    })
}

pub(super) fn caustic<'a>() -> Table<CausticRow<'a>> {
    Table {
        file: "caustic.csv",
        row: "the mean irradiance over one ring around the axis (or over one tile of the receiver, or all of it), by light of one order, from the largest budget of rays",
        case: |r| &r.case.name,
        columns: vec![
            column!("case", "", "the case's name", |r| r.case.name.as_str()),
            column!("order", "", "interactions with mirrors and glass on the way", |r| r.bin.order),
            column!("bin", "", "which ring, from 0, outwards; which tile, from 0, along s, then t", |r| r.bin.bin),
            column!(
                "position_m",
                "m",
                "the middle of the ring's inner and outer radius; empty for a tile and for a whole receiver",
                |r| r.bin.radii.map(|[inner, outer]| 0.5 * (inner + outer))
            ),
            column!("measured_irradiance_W_m2", "W/m²", "flux that landed over the ring's area", |r| {
                r.bin.measured / r.bin.area
            }),
            column!("std_error_W_m2", "W/m²", "standard error of it, over independent groups of rays", |r| r
                .bin
                .std_error
                .map(|error| error / r.bin.area)),
            column!("exact_irradiance_W_m2", "W/m²", "the exact flux over the ring's area", |r| r.bin.exact
                / r.bin.area),
            column!(
                "verdict",
                "",
                "`fail` where the evidence against this ring alone reaches 10^6, `undecided` where a deviation of all of it would not have been seen, else `pass`",
                |r| r.bin.verdict.name()
            ),
        ],
        more: &[],
    }
}

/// Squares of texels of one size, of one case's map.
pub(super) struct TexelRow<'a> {
    case: &'a CaseOutcome,
    texels: &'a MapRow,
}

pub(super) fn texel_rows(outcome: &RunOutcome) -> impl Iterator<Item = TexelRow<'_>> {
    outcome.cases.iter().flat_map(|case| {
        let light = case.light.iter();
        light.flat_map(move |light| light.texels.iter().map(move |texels| TexelRow { case, texels }))
    })
}

pub(super) fn texels<'a>() -> Table<TexelRow<'a>> {
    Table {
        file: "texels.csv",
        row: "what the receiver's map of bent light is off by: squares of texels of one size, over many places, after one budget of rays",
        case: |r| &r.case.name,
        columns: vec![
            column!("case", "", "the case's name", |r| r.case.name.as_str()),
            column!("rays", "", "rays that left the sources", |r| r.texels.rays),
            column!("size_m", "m", "the root of a square's area", |r| r.texels.size),
            column!("places", "", "squares that were compared, away from caustics and edges of the light", |r| r
                .texels
                .places),
            column!("irradiance_W_m2", "W/m²", "exact, at the squares' middles, on average", |r| r
                .texels
                .irradiance),
            column!(
                "bias_W_m2",
                "W/m²",
                "what squares are off the exact irradiance in their middles: root mean square, less the predicted noise",
                |r| r.texels.bias
            ),
            column!("exact_bias_W_m2", "W/m²", "the same of the squares' exact means", |r| r.texels.exact_bias),
            column!("variance_W2_m4", "W²/m⁴", "what squares are off their own exact means: mean square", |r| r
                .texels
                .variance),
            column!("predicted_variance_W2_m4", "W²/m⁴", "the same as counts of equal packets have it", |r| r
                .texels
                .predicted_variance),
        ],
        more: &[],
    }
}
