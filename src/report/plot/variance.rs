//! Variance curves: how the noise of one estimate falls with the number of samples, beside the line fitted to it and
//! the slope that theory expects.

use super::axis::Axis;
use super::ink::{Align, Page};
use super::panel::{HEIGHT, Key, Panel, WIDTH, legend_column, more_than_three, titled_page};
use super::style::{Dash, GREY, GUIDE, INK, SMALL, TEXT, look_of, shown_of};
use crate::oracle::Region;
use crate::report::record::{CaseRecord, RateRecord, StrategyRecord};

/// The curves of one region.
struct Group<'a> {
    region: Option<Region>,
    rates: Vec<(&'a StrategyRecord, &'a RateRecord)>,
}

/// `None` where no variance was fitted: no light reaches any point.
pub fn variance(case: &CaseRecord) -> Option<Page> {
    let groups = groups(case);
    let drawn = || groups.iter().flat_map(|g| &g.rates).flat_map(|(_, rate)| positive(rate));
    let counts: Vec<u64> = drawn().map(|p| p.0).collect::<std::collections::BTreeSet<_>>().into_iter().collect();
    if groups.is_empty() || counts.is_empty() {
        return None;
    }
    let low = drawn().map(|p| p.2).fold(f64::INFINITY, f64::min);
    let high = drawn().map(|p| p.3).fold(0.0, f64::max);
    // Room for the guides above and below the data.
    let y = Axis::log(low / 6.0, high * 4.0, 12);

    let mut page = titled_page(
        &case.title,
        &format!("{}: variance of one estimate against the number of points on each source", case.name),
    );
    let n = groups.len() as f64;
    let (left, gap, right) = (92.0, 30.0, WIDTH - 24.0);
    let width = (right - left - gap * (n - 1.0)) / n;
    for (i, group) in groups.iter().enumerate() {
        let from = left + (width + gap) * i as f64;
        let x = Axis::samples(&counts, (1.35, 2.6), width);
        let y = if i == 0 { y.clone() } else { y.unlabelled() };
        let panel = Panel { left: from, top: 92.0, right: from + width, bottom: HEIGHT - 142.0, x, y };
        let name = if i == 0 { "variance (W²/m⁴)" } else { "" };
        panel.draw(&mut page, "samples N", name);
        page.bold((from, 76.0), heading(group.region), TEXT, INK, Align::Start);
        draw_group(&mut page, &panel, group);
    }
    let entries = groups.iter().map(|group| group.rates.len()).max().unwrap_or(0);
    page.height += more_than_three(entries);
    page.text((24.0, page.height - 18.0), NOTE, SMALL, GREY, Align::Start);
    Some(page)
}

const NOTE: &str =
    "Marks: mean over points, with 95 % band. Lines: fits, slopes with 95 % intervals. Thin grey: expected slopes.";

fn heading(region: Option<Region>) -> &'static str {
    match region {
        None => "all points that light reaches",
        Some(Region::Lit) => "lit",
        Some(Region::Penumbra) => "penumbra",
        Some(Region::Umbra) => "umbra",
        Some(Region::BelowHorizon) => "below the horizon",
        Some(Region::Edge) => "edge",
    }
}

/// By region; the summary over all points only where there is nothing finer.
fn groups(case: &CaseRecord) -> Vec<Group<'_>> {
    let mut groups: Vec<Group> = Vec::new();
    for strategy in &case.strategies {
        for rate in strategy.rates.iter().filter(|r| r.quantity == "variance") {
            if positive(rate).next().is_none() {
                continue;
            }
            match groups.iter_mut().find(|g| g.region == rate.region) {
                Some(group) => group.rates.push((strategy, rate)),
                None => groups.push(Group { region: rate.region, rates: vec![(strategy, rate)] }),
            }
        }
    }
    groups.sort_by_key(|g| g.region);
    if groups.len() > 1 {
        groups.retain(|g| g.region.is_some());
    }
    groups
}

/// Samples, value and interval of what a logarithmic axis can show.
fn positive(rate: &RateRecord) -> impl Iterator<Item = (u64, f64, f64, f64)> {
    rate.points
        .iter()
        .filter(|p| p.value > 0.0)
        .map(|p| (p.samples, p.value, if p.low > 0.0 { p.low } else { p.value }, p.high))
}

fn draw_group(page: &mut Page, panel: &Panel, group: &Group) {
    draw_guides(page, panel, group);
    let mut legend = Vec::new();
    for (strategy, rate) in &group.rates {
        let look = look_of(strategy);
        let points: Vec<_> = positive(rate).collect();
        let band: Vec<_> = points.iter().map(|&(n, _, low, high)| (n as f64, low, high)).collect();
        panel.band(page, &band, look.colour, 0.22);
        let ends = [points[0].0 as f64, points[points.len() - 1].0 as f64];
        let fitted = |n: f64| rate.fitted(n).unwrap_or(f64::NAN);
        let inside = |v: f64| v.is_finite() && v >= panel.y.low() && v <= panel.y.high();
        if points.len() > 1 && ends.iter().all(|n| inside(fitted(*n))) {
            panel.curve(page, ends.map(|n| (n, fitted(n))), look.colour, 1.6, look.dash);
        }
        for &(n, value, ..) in &points {
            page.marker(panel.at(n as f64, value), look.marker, look.colour, 4.0);
        }
        let half = 0.5 * (rate.slope_high - rate.slope_low);
        let slope = format!("{:.3}", rate.slope).replace('-', "−");
        let text = format!("{}: slope {slope} ± {half:.3}", shown_of(strategy));
        legend
            .push((Key::Line { colour: look.colour, width: 1.6, dash: look.dash, marker: Some(look.marker) }, text));
    }
    legend_column(page, (panel.left, panel.bottom + 58.0), &legend);
}

/// Each expected slope once, beside the curves that it belongs to: the shallowest above all data, the others below.
fn draw_guides(page: &mut Page, panel: &Panel, group: &Group) {
    let mut slopes: Vec<f64> = group.rates.iter().filter_map(|(_, r)| r.asymptote()).collect();
    slopes.sort_by(|a, b| b.total_cmp(a));
    slopes.dedup();
    for (k, slope) in slopes.iter().enumerate() {
        let own = || group.rates.iter().filter(|(_, r)| r.asymptote() == Some(*slope)).flat_map(|(_, r)| positive(r));
        let last = own().map(|p| p.0).max().unwrap_or(1) as f64;
        let first = own().map(|p| p.0).min().unwrap_or(1) as f64;
        // Through the point that leaves all of the curve on one side.
        let offset = |p: (u64, f64, f64, f64)| p.1.ln() - slope * (p.0 as f64).ln();
        let level = if k == 0 {
            own().map(offset).fold(f64::NEG_INFINITY, f64::max) + 2.2f64.ln()
        } else {
            own().map(offset).fold(f64::INFINITY, f64::min) - 2.2f64.ln()
        };
        let guide = |n: f64| (level + slope * n.ln()).exp();
        // The line ends at the panel's edges.
        let end = last * 1.25;
        let (bottom, top) = (panel.y.low(), panel.y.high());
        let reaches = |v: f64| ((v.ln() - level) / slope).exp();
        let (from, to) = (first.max(reaches(top)), if guide(end) < bottom { reaches(bottom) } else { end });
        if from >= to {
            continue;
        }
        panel.curve(page, [(from, guide(from)), (to, guide(to))], GUIDE, 1.0, Dash::Solid);
        let (x, y) = panel.at(to, guide(to));
        page.text((x + 5.0, y), exponent(*slope), SMALL, GREY, Align::Start);
    }
}

/// A slope as people write it: `−1`, `−3/2`.
fn exponent(slope: f64) -> String {
    let halves = 2.0 * slope;
    let text = match slope {
        _ if slope == slope.round() => format!("{slope:.0}"),
        _ if halves == halves.round() => format!("{halves:.0}/2"),
        _ => format!("{slope}"),
    };
    text.replace('-', "−")
}
