//! Bias: how far the mean over the points is from the exact value, at each number of samples.

use super::axis::Axis;
use super::ink::Page;
use super::panel::{HEIGHT, Key, Panel, WIDTH, legend_rows, note, titled_page};
use super::style::{Dash, INK, look_of, shown_of};
use crate::report::record::{CaseRecord, CellRecord, StrategyRecord};

/// Half a 95 % interval in standard errors, for showing; verdicts use none.
pub use crate::statistics::interval::Z_95 as NORMAL_95;

/// `None` where nothing arrives and nothing is due.
pub fn bias(case: &CaseRecord) -> Option<Page> {
    let exact: f64 = case.points.iter().map(|point| point.exact).sum();
    let mean = exact / case.points.len().max(1) as f64;
    let (unit, name) = if mean > 0.0 {
        (mean / 100.0, "bias of the mean (% of the exact mean)")
    } else {
        (1.0, "bias of the mean (W/m²)")
    };
    let with_bias = |cell: &'_ CellRecord| Some((cell.samples, cell.mean_bias?));
    let cells = || case.strategies.iter().flat_map(|s| &s.cells).filter_map(with_bias);
    let reach = |[bias, error]: [f64; 2]| (bias.abs() + NORMAL_95 * error) / unit;
    let largest = cells().map(|(_, bias)| reach(bias)).fold(0.0, f64::max);
    let errors = cells().map(|(_, [_, error])| error / unit).filter(|e| *e > 0.0);
    let finest = errors.fold(f64::INFINITY, f64::min);
    if largest == 0.0 {
        return None;
    }
    let seen = |s: &StrategyRecord| {
        let judged = case.verdicts.iter().find(|v| v.property == "bias" && v.strategy == s.name)?;
        judged.smallest_bias_mean.filter(|b| mean > 0.0 && *b > 0.0).map(|b| 100.0 * b)
    };
    let largest = case.strategies.iter().filter_map(seen).fold(largest, f64::max);
    let counts: Vec<u64> =
        cells().map(|(samples, _)| samples).collect::<std::collections::BTreeSet<_>>().into_iter().collect();

    let shows = format!(
        "{}: bias of the mean over {} points, at each number of points on each source",
        case.name,
        case.points.len()
    );
    let mut page = titled_page(&case.title, &shows);
    let panel = Panel {
        left: 104.0,
        top: 72.0,
        right: WIDTH - 24.0,
        bottom: HEIGHT - 112.0,
        x: Axis::samples(&counts, (1.6, 1.6), WIDTH - 128.0),
        y: Axis::symmetric(1.15 * largest, finest),
    };
    panel.draw(&mut page, "samples N", name);
    panel.curve(&mut page, [(panel.x.low(), 0.0), (panel.x.high(), 0.0)], INK, 1.0, Dash::Solid);
    let mut legend = Vec::new();
    let middle = 0.5 * (case.strategies.len() as f64 - 1.0);
    for (i, strategy) in case.strategies.iter().enumerate() {
        let look = look_of(strategy);
        let aside = 11.0 * (i as f64 - middle);
        for (samples, [bias, std_error]) in strategy.cells.iter().filter_map(with_bias) {
            let (n, bias) = (samples as f64, bias / unit);
            let half = NORMAL_95 * std_error / unit;
            panel.bar(&mut page, (n, bias - half, bias + half), aside, 4.0, look.colour);
            let (x, y) = panel.at(n, bias);
            page.marker((x + aside, y), look.marker, look.colour, 3.8);
        }
        let mut text = shown_of(strategy).to_owned();
        if let Some(smallest) = seen(strategy) {
            for side in [-smallest, smallest] {
                let ends = [(panel.x.low(), side), (panel.x.high(), side)];
                panel.curve(&mut page, ends, look.colour, 0.8, look.dash);
            }
            text = format!("{text}: would catch ±{} %", two_digits(smallest));
        }
        legend.push((Key::Bar { colour: look.colour, marker: look.marker }, text));
    }
    legend_rows(&mut page, (panel.left, HEIGHT - 56.0), panel.right - panel.left, &legend);
    let words = "Bars: ±1.96 standard errors. Thin lines: the smallest bias that would have been caught at every N with \
                99 % probability.";
    note(&mut page, words);
    Some(page)
}

fn two_digits(x: f64) -> String {
    let decimals = (1.0 - x.log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{x:.decimals$}")
}
