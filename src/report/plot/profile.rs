//! Profiles: the exact irradiance along the measured points, what was measured there, and how noisy one estimate is.

use super::axis::Axis;
use super::bias::NORMAL_95;
use super::ink::{Align, Page};
use super::panel::{HEIGHT, Key, Panel, WIDTH, legend_rows, note, titled_page};
use super::style::{Colour, Dash, GREY, INK, SMALL, TEXT, look_of, shown_of};
use super::text::text_width;
use crate::configuration::Arrangement;
use crate::oracle::Region;
use crate::report::record::{CaseRecord, CellRecord, StrategyRecord};

/// `None` for a grid, which has a map instead, and where nothing was measured.
pub fn profile(case: &CaseRecord) -> Option<Page> {
    if is_map(case) {
        return None;
    }
    let samples = case.shown_samples()?;
    let shown_cells: Vec<(&StrategyRecord, &CellRecord)> =
        case.strategies.iter().filter_map(|s| Some((s, s.cells.iter().find(|c| c.samples == samples)?))).collect();
    let along = case.places();
    let line = case.arrangement == Arrangement::Line;
    let exact: Vec<f64> = case.points.iter().map(|point| point.exact).collect();

    let what = format!("{}: irradiance at N = {samples}, {} replicates", case.name, replicates(&shown_cells));
    let mut page = titled_page(&case.title, &what);
    // A line has some room at its ends: marks stand there.
    let (first, last) = (along[0], along[along.len() - 1]);
    let room = 0.012 * (last - first);
    let x = if line { Axis::linear(first - room, last + room, false, 8) } else { indices(along.len()) };
    let noise = |c: &CellRecord, i: usize| c.points[i].variance.sqrt();
    let reach = |c: &CellRecord, i: usize| c.points[i].bias.abs() + NORMAL_95 * c.points[i].bias_std_error;
    let (mut top, mut largest) = (exact.iter().copied().fold(0.0, f64::max), 0.0f64);
    for (_, cell) in &shown_cells {
        for (i, value) in exact.iter().enumerate() {
            top = top.max(value + noise(cell, i));
            largest = largest.max(reach(cell, i));
        }
    }
    let y = Axis::linear(0.0, if top > 0.0 { 1.08 * top } else { 1.0 }, false, 6);
    let largest = if largest > 0.0 { largest } else { 1e-3 * y.high() };
    let (left, right) = (104.0, WIDTH - 24.0);
    let upper = Panel { left, top: 88.0, right, bottom: 340.0, x: x.unlabelled(), y };
    let lower = Panel { left, top: 362.0, right, bottom: 484.0, x, y: Axis::linear(-largest, largest, true, 4) };

    shade_regions(&mut page, case, &along, &[&upper, &lower], line);
    upper.draw(&mut page, "", "irradiance (W/m²)");
    lower.draw(
        &mut page,
        if line { "distance along the line (m)" } else { "measurement point" },
        "mean − exact (W/m²)",
    );

    let key = Key::Line { colour: INK, width: 1.6, dash: Dash::Solid, marker: None };
    let mut legend = vec![(key, "exact".to_owned())];
    // The room of one point, when points stand side by side.
    let slot = (right - left) / along.len() as f64;
    let n = shown_cells.len().max(1);
    let apart = (0.8 * slot / n as f64).min(if line { 3.0 } else { 16.0 });
    if !line {
        for (place, value) in along.iter().zip(&exact) {
            let (x, y) = upper.at(*place, *value);
            let half = 0.5 * apart * (n as f64 + 0.4);
            page.line(vec![(x - half, y), (x + half, y)], INK, 1.6, Dash::Solid);
        }
    }
    for (k, (strategy, cell)) in shown_cells.iter().enumerate() {
        let look = look_of(strategy);
        let aside = apart * (k as f64 - 0.5 * (n as f64 - 1.0));
        // One estimate is never negative, though a standard deviation may reach below zero.
        let spread = |i: usize| (along[i], (exact[i] - noise(cell, i)).max(0.0), exact[i] + noise(cell, i));
        let spreads: Vec<_> = (0..exact.len()).map(spread).collect();
        if line {
            draw_band(&mut page, &upper, &spreads, look.colour, look.dash);
        } else {
            spreads.iter().for_each(|spread| upper.bar(&mut page, *spread, aside, 3.0, look.colour));
        }
        let every = if line { n * exact.len().div_ceil(16 * n) } else { 1 };
        let offset = every / n * k;
        for (i, point) in cell.points.iter().enumerate() {
            let half = NORMAL_95 * point.bias_std_error;
            lower.bar(&mut page, (along[i], point.bias - half, point.bias + half), aside, 0.0, look.colour);
            let (x, y) = lower.at(along[i], point.bias);
            page.marker((x + aside, y), look.marker, look.colour, if line { 2.0 } else { 3.0 });
            if i % every == offset % every {
                let (x, y) = upper.at(along[i], point.mean);
                page.marker((x + if line { 0.0 } else { aside }, y), look.marker, look.colour, 3.4);
            }
        }
        let key = match line {
            true => Key::Band { colour: look.colour, marker: look.marker, dash: look.dash },
            false => Key::Bar { colour: look.colour, marker: look.marker },
        };
        legend.push((key, shown_of(strategy).to_owned()));
    }
    lower.curve(&mut page, [(lower.x.low(), 0.0), (lower.x.high(), 0.0)], INK, 1.0, Dash::Solid);
    if line {
        upper.curve(&mut page, along.iter().copied().zip(exact.iter().copied()), INK, 1.4, Dash::Solid);
    }
    legend_rows(&mut page, (upper.left, HEIGHT - 56.0), upper.right - upper.left, &legend);
    let words = if line {
        "Above: marks are means (some shown), bands ±1 standard deviation of one estimate. Below: mean less exact, ±1.96 standard errors."
    } else {
        "Above: marks are means, bars ±1 standard deviation of one estimate. Below: ±1.96 standard errors of the mean."
    };
    note(&mut page, words);
    Some(page)
}

/// Shaded, with edges in the strategy's own dash so that bands can be told apart without colour.
fn draw_band(page: &mut Page, panel: &Panel, edges: &[(f64, f64, f64)], colour: Colour, dash: Dash) {
    panel.band(page, edges, colour, 0.16);
    panel.curve(page, edges.iter().map(|e| (e.0, e.1)), colour, 0.9, dash);
    panel.curve(page, edges.iter().map(|e| (e.0, e.2)), colour, 0.9, dash);
}

/// Whether the points fill an area.
pub fn is_map(case: &CaseRecord) -> bool {
    matches!(case.arrangement, Arrangement::Grid { nu, nv } if nu > 1 && nv > 1)
}

/// `1000`, or `800–1000` where strategies differ.
pub fn replicates(cells: &[(&StrategyRecord, &CellRecord)]) -> String {
    let counts = || cells.iter().map(|(_, c)| c.replicates);
    match (counts().min(), counts().max()) {
        (Some(low), Some(high)) if low != high => format!("{low}–{high}"),
        (low, _) => low.unwrap_or(0).to_string(),
    }
}

/// An axis of points by number.
fn indices(n: usize) -> Axis {
    let mut axis = Axis::linear(-0.5, n as f64 - 0.5, false, n.clamp(1, 12));
    axis.ticks.retain(|(v, _)| *v == v.round() && *v >= 0.0 && *v <= (n - 1) as f64);
    for (value, label) in &mut axis.ticks {
        *label = format!("{value:.0}");
    }
    axis
}

fn shade(region: Region) -> (Colour, &'static str) {
    match region {
        Region::Lit => (Colour(0xff, 0xff, 0xff), "lit"),
        Region::Penumbra => (Colour(0xf3, 0xf3, 0xf3), "penumbra"),
        Region::Umbra => (Colour(0xe2, 0xe2, 0xe2), "umbra"),
        Region::BelowHorizon => (Colour(0xe6, 0xea, 0xf0), "below horizon"),
        Region::Edge => (Colour(0xf6, 0xee, 0xdd), "edge"),
    }
}

/// Shades each run of points in one region, and names it above the first panel. Regions meet halfway between points.
fn shade_regions(page: &mut Page, case: &CaseRecord, along: &[f64], panels: &[&Panel], line: bool) {
    let n = along.len();
    let mut start = 0;
    let mut free = f64::NEG_INFINITY;
    for i in 1..=n {
        if i < n && case.points[i].region == case.points[start].region {
            continue;
        }
        let (low, high) = (panels[0].x.low(), panels[0].x.high());
        let border = |a: usize, b: usize| if line { 0.5 * (along[a] + along[b]) } else { 0.5 * (a + b) as f64 };
        let from = if start == 0 { low } else { border(start - 1, start) };
        let to = if i == n { high } else { border(i - 1, i) };
        let (colour, name) = shade(case.points[start].region);
        for panel in panels {
            let (left, _) = panel.at(from, panel.y.low());
            let (right, _) = panel.at(to, panel.y.low());
            page.rectangle((left, panel.top), (right, panel.bottom), colour, 1.0);
        }
        let (left, _) = panels[0].at(from, panels[0].y.low());
        let (right, _) = panels[0].at(to, panels[0].y.low());
        let (middle, half) = (0.5 * (left + right), 0.5 * text_width(name, TEXT, false));
        if middle - half >= free.max(panels[0].left - 40.0) {
            page.text((middle, panels[0].top - 12.0), name, SMALL, GREY, Align::Middle);
            free = middle + half + 4.0;
        }
        start = i;
    }
}
