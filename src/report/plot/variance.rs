//! Variance curves: how the noise of one estimate falls with the number of samples, beside the line fitted to it and
//! the slope that theory expects.

use super::axis::Axis;
use super::ink::{Align, At, Page};
use super::panel::{HEIGHT, Key, Panel, WIDTH, legend_column, more_than_three, note, titled_page};
use super::style::{Dash, GREY, GUIDE, INK, SMALL, TEXT, look_of, shown_of};
use super::text::text_width;
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
    // Room for the guides above and below the data.
    let guided = || groups.iter().flat_map(guides).flat_map(|guide| guide.ends.map(|(_, variance)| variance));
    let low = drawn().map(|p| p.2).chain(guided()).fold(f64::INFINITY, f64::min);
    let high = drawn().map(|p| p.3).chain(guided()).fold(0.0, f64::max);
    let y = Axis::log(low / 2.0, high * 2.0, 12);

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
    note(&mut page, NOTE);
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

/// An expected slope as a straight piece beside the curves that it belongs to.
struct Guide {
    slope: f64,
    /// Samples and variance.
    ends: [(f64, f64); 2],
}

/// From the curves to their guide, as a factor.
const APART: f64 = 2.2;

/// Each expected slope once, over the later half of its curves, where they come nearest to it: the shallowest above them,
/// the others below.
fn guides(group: &Group) -> Vec<Guide> {
    let mut slopes: Vec<f64> = group.rates.iter().filter_map(|(_, r)| r.asymptote()).collect();
    slopes.sort_by(|a, b| b.total_cmp(a));
    slopes.dedup();
    let guide = |(k, slope): (usize, f64)| {
        let own = || group.rates.iter().filter(|(_, r)| r.asymptote() == Some(slope)).flat_map(|(_, r)| positive(r));
        let last = own().map(|p| p.0).max().unwrap_or(1) as f64;
        let first = own().map(|p| p.0).min().unwrap_or(1) as f64;
        let (from, to) = ((first * last).sqrt(), 1.25 * last);
        // Through the point that leaves all of the curve there on one side.
        let offsets = own().filter(|p| p.0 as f64 >= from).map(|p| p.1.ln() - slope * (p.0 as f64).ln());
        let level = if k == 0 {
            offsets.fold(f64::NEG_INFINITY, f64::max) + APART.ln()
        } else {
            offsets.fold(f64::INFINITY, f64::min) - APART.ln()
        };
        Guide { slope, ends: [from, to].map(|n| (n, (level + slope * n.ln()).exp())) }
    };
    slopes.into_iter().enumerate().map(guide).collect()
}

/// Draws the guides, and their slopes where no mark and no other slope stands.
fn draw_guides(page: &mut Page, panel: &Panel, group: &Group) {
    let mut taken: Vec<At> = Vec::new();
    for (_, rate) in &group.rates {
        let marks: Vec<At> = positive(rate).map(|(n, value, ..)| panel.at(n as f64, value)).collect();
        let fitted = |(n, ..): (u64, f64, f64, f64)| rate.fitted(n as f64).unwrap_or(f64::NAN);
        let fit: Vec<At> = positive(rate).map(|p| panel.at(p.0 as f64, fitted(p))).collect();
        taken.extend(along(&marks).chain(along(&fit)));
    }
    let guides = guides(group);
    for guide in &guides {
        taken.extend(along(&guide.ends.map(|(n, value)| panel.at(n, value))));
    }
    for guide in &guides {
        panel.curve(page, guide.ends, GUIDE, 1.0, Dash::Solid);
        let words = exponent(guide.slope);
        let (width, height) = (text_width(&words, SMALL, false), SMALL);
        let [(left, upper), (right, lower)] = guide.ends.map(|(n, value)| panel.at(n, value));
        let half = 0.5 * width;
        let share = |t: f64| (left + t * (right - left), upper + t * (lower - upper));
        // Behind its end; else over or under it, from its end backwards.
        let behind = std::iter::once((right + 5.0 + half, lower));
        let beside = (0..8).flat_map(|k| {
            let (x, y) = share(1.0 - f64::from(k) / 8.0);
            [(x + half, y - height), (x - half, y + height), (x - half - 4.0, y + 2.0), (x + half + 4.0, y - 2.0)]
        });
        let clear = |(x, y): &At| {
            let near = |(a, b): &&At| (a - x).abs() < half + 3.0 && (b - y).abs() < 0.5 * height + 3.0;
            let inside = x - half > panel.left
                && x + half <= panel.right
                && y + height < panel.bottom
                && y - height > panel.top;
            inside && !taken.iter().any(|place| near(&place))
        };
        let Some((x, y)) = behind.chain(beside).find(clear) else { continue };
        page.text((x, y), words, SMALL, GREY, Align::Middle);
        taken.extend([(x - half, y), (x, y), (x + half, y)]);
    }
}

/// Places on a line, close enough together that no word slips between them.
fn along(through: &[At]) -> impl Iterator<Item = At> {
    through.windows(2).flat_map(|ends| {
        let (a, b) = (ends[0], ends[1]);
        let steps = ((b.0 - a.0).hypot(b.1 - a.1) / 4.0).ceil().max(1.0) as u32;
        (0..=steps).map(move |k| {
            let share = f64::from(k) / f64::from(steps);
            (a.0 + share * (b.0 - a.0), a.1 + share * (b.1 - a.1))
        })
    })
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
