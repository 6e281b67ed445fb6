//! Correlation over distance: whether the errors of neighbouring points move together.

use super::axis::Axis;
use super::ink::{Align, Page};
use super::panel::{HEIGHT, Key, Panel, WIDTH, legend_column, note, titled_page};
use super::style::{Colour, Dash, INK, Look, Marker, TEXT, look_of, shown_of};
use crate::configuration::Arrangement;
use crate::report::record::{CaseRecord, StrategyRecord};
use crate::trial::Correlation;

/// `None` where no correlation was measured.
pub fn correlation(case: &CaseRecord) -> Option<Page> {
    let strategies: Vec<&StrategyRecord> = case.strategies.iter().filter(|s| !s.correlations.is_empty()).collect();
    let all = || strategies.iter().flat_map(|s| &s.correlations);
    let farthest = all().map(|c| c.separation).fold(0.0, f64::max);
    if strategies.is_empty() {
        return None;
    }
    let low = all().map(|c| c.low).fold(-0.2, f64::min).max(-1.0);
    let high = all().map(|c| 1.04 * c.high).fold(0.2, f64::max).min(1.0);
    let y = Axis::linear(low, high, true, 7);
    let shows = format!("{}: correlation between the errors of two points, by their distance", case.name);
    let mut page = titled_page(&case.title, &shows);
    let columns = strategies.len().min(MOST_COLUMNS);
    let n = columns as f64;
    let (left, gap, right) = (84.0, 26.0, WIDTH - 24.0);
    let width = (right - left - gap * (n - 1.0)) / n;
    page.height += ROW * (strategies.len().div_ceil(columns) - 1) as f64;
    for (i, strategy) in strategies.iter().enumerate() {
        let (row, column) = (i / columns, i % columns);
        let (from, top) = (left + (width + gap) * column as f64, 92.0 + ROW * row as f64);
        // Room at both ends, for marks; points at one and the same place have no other separation.
        let room = if farthest > 0.0 { 0.02 * farthest } else { 1.0 };
        let mut x = Axis::linear(-room, farthest + room, false, if n > 1.0 { 5 } else { 10 });
        x.ticks.retain(|(separation, _)| (0.0..=1.001 * farthest).contains(separation));
        let y = if column == 0 { y.clone() } else { y.unlabelled() };
        let panel = Panel { left: from, top, right: from + width, bottom: top + HEIGHT - 238.0, x, y };
        panel.draw(&mut page, "separation (m)", if column == 0 { "correlation coefficient" } else { "" });
        page.bold((from, top - 16.0), shown_of(strategy), TEXT, INK, Align::Start);
        panel.curve(&mut page, [(panel.x.low(), 0.0), (panel.x.high(), 0.0)], INK, 1.0, Dash::Solid);
        draw_strategy(&mut page, &panel, strategy, case.arrangement == Arrangement::Line);
    }
    page.height += 8.0;
    note(&mut page, "Bands and bars: 95 % intervals. Predicted: by the exact side.");
    Some(page)
}

/// Panels side by side, and the height of a row of them with its legends, points.
const MOST_COLUMNS: usize = 4;
const ROW: f64 = 530.0;
/// From one sample count to the next where they stand side by side, points.
const ASIDE: f64 = 3.0;

/// `is_line`: points lie on a line, so that errors are curves over the distance; elsewhere pairs of one distance lie in
/// different directions, and are marks.
fn draw_strategy(page: &mut Page, panel: &Panel, strategy: &StrategyRecord, is_line: bool) {
    let mut legend = Vec::new();
    let counts = strategy.shown_counts();
    let mut predicted = false;
    for (k, &samples) in counts.iter().enumerate() {
        let look = shade(look_of(strategy), k);
        let mut curve: Vec<&Correlation> = strategy.correlations.iter().filter(|c| c.samples == samples).collect();
        curve.sort_by(|a, b| a.separation.total_cmp(&b.separation));
        let is_curve = is_line && curve.len() > 1;
        if is_curve {
            let band: Vec<_> = curve.iter().map(|c| (c.separation, c.low, c.high)).collect();
            panel.band(page, &band, look.colour, 0.18);
            panel.curve(page, curve.iter().map(|c| (c.separation, c.correlation)), look.colour, 1.5, look.dash);
        }
        let every = if is_curve { curve.len().div_ceil(10).max(1) } else { 1 };
        let apart = if curve.len() > 1 { ASIDE } else { 5.0 * ASIDE };
        let aside = if is_curve { 0.0 } else { apart * (k as f64 - 0.5 * (counts.len() as f64 - 1.0)) };
        for c in curve.iter().skip(k * every / counts.len()).step_by(every) {
            if !is_curve {
                panel.bar(page, (c.separation, c.low, c.high), aside, 0.0, look.colour);
            }
            let (x, y) = panel.at(c.separation, c.correlation);
            page.marker((x + aside, y), look.marker, look.colour, if is_curve { 3.4 } else { 2.8 });
        }
        let expected: Vec<_> = curve.iter().filter_map(|c| Some((c.separation, c.predicted?))).collect();
        if is_curve && expected.len() > 1 {
            panel.curve(page, expected, INK, 1.0, Dash::Dotted);
            predicted = true;
        } else {
            for (separation, value) in expected {
                let (x, y) = panel.at(separation, value);
                page.line(vec![(x + aside - 2.4, y), (x + aside + 2.4, y)], INK, 1.0, Dash::Solid);
                predicted = true;
            }
        }
        let key = match is_curve {
            true => Key::Line { colour: look.colour, width: 1.5, dash: look.dash, marker: Some(look.marker) },
            false => Key::Bar { colour: look.colour, marker: look.marker },
        };
        legend.push((key, format!("N = {samples}")));
    }
    if predicted {
        let dash = if is_line { Dash::Dotted } else { Dash::Solid };
        let key = Key::Line { colour: INK, width: 1.0, dash, marker: None };
        legend.push((key, "predicted".to_owned()));
    }
    legend_column(page, (panel.left, panel.bottom + 58.0), &legend);
}

/// The strategy's colour, lighter to darker, each with its own marker and dash.
fn shade(look: Look, k: usize) -> Look {
    let mixed = |c: u8, with: u8, share: f64| (f64::from(c) * (1.0 - share) + f64::from(with) * share).round() as u8;
    let Colour { 0: r, 1: g, 2: b } = look.colour;
    let (with, share) = [(255, 0.45), (0, 0.0), (0, 0.45)][k % 3];
    let colour = Colour(mixed(r, with, share), mixed(g, with, share), mixed(b, with, share));
    let (marker, dash) =
        [(Marker::Circle, Dash::Solid), (Marker::Square, Dash::Dashed), (Marker::Diamond, Dash::Alternating)][k % 3];
    Look { colour, marker, dash }
}
