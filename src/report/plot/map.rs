//! Maps: the exact irradiance over a grid of points, and how far each strategy's mean is from it.

use super::axis::Axis;
use super::ink::{Align, Page};
use super::panel::{HEIGHT, Panel, WIDTH, note, titled_page};
use super::profile::{is_map, replicates};
use super::style::{Dash, GREY, INK, SMALL, TEXT, shown_of};
use crate::configuration::Arrangement;
use crate::report::image::Rgb;
use crate::report::record::{CaseRecord, CellRecord, StrategyRecord};

/// Room around a map for the names of its axes and for its colour bar, points.
const LEFT: f64 = 62.0;
const RIGHT: f64 = 100.0;
const ABOVE: f64 = 24.0;
const BELOW: f64 = 58.0;

/// Shades of a colour scale: few enough that neighbours of one shade can be drawn as one.
const SHADES: usize = 80;

/// `None` where the points fill no area.
pub fn map(case: &CaseRecord) -> Option<Page> {
    let Arrangement::Grid { nu, nv } = case.arrangement else { return None };
    if !is_map(case) {
        return None;
    }
    let samples = case.shown_samples()?;
    let cells: Vec<(&StrategyRecord, &CellRecord)> =
        case.strategies.iter().filter_map(|s| Some((s, s.cells.iter().find(|c| c.samples == samples)?))).collect();
    let exact: Vec<f64> = case.points.iter().map(|point| point.exact).collect();
    let what = format!(
        "{}: exact irradiance, and the mean's relative deviation at N = {samples}, {} replicates",
        case.name,
        replicates(&cells)
    );
    let mut page = titled_page(&case.title, &what);
    let extent = extent(case, nu, nv);

    let top = exact.iter().copied().fold(0.0, f64::max);
    let deviations: Vec<Vec<Option<f64>>> = cells
        .iter()
        .map(|(_, cell)| {
            cell.points.iter().zip(&exact).map(|(m, e)| (*e > 0.0).then(|| 100.0 * m.bias / e)).collect()
        })
        .collect();
    let largest = deviations.iter().flatten().flatten().fold(0.0, |a: f64, d| a.max(d.abs()));
    if top == 0.0 && largest == 0.0 {
        return None;
    }
    let largest = if largest > 0.0 { largest } else { 1.0 };
    let shown_maps = 1 + cells.len();
    let columns = if shown_maps <= 3 { shown_maps } else { 2 };
    let rows = shown_maps.div_ceil(columns);
    let slot = ((WIDTH - 48.0) / columns as f64, (HEIGHT - 100.0) / rows.min(2) as f64);
    let size = extent.fitted((slot.0 - LEFT - RIGHT, slot.1 - ABOVE - BELOW));
    let step = ABOVE + size.1 + BELOW;
    page.height = 66.0 + step * rows as f64 + 34.0;
    for k in 0..shown_maps {
        let (column, row) = (k % columns, k / columns);
        let corner = (24.0 + slot.0 * column as f64, 66.0 + step * row as f64);
        let (heading, unit, values, scale): (_, _, Vec<Option<f64>>, _) = match k.checked_sub(1) {
            None => {
                let scale = ColourScale { low: 0.0, high: if top > 0.0 { top } else { 1.0 }, stops: &CIVIDIS };
                ("exact irradiance", "W/m²", exact.iter().copied().map(Some).collect(), scale)
            }
            Some(i) => {
                let scale = ColourScale { low: -largest, high: largest, stops: &BLUE_WHITE_ORANGE };
                (shown_of(cells[i].0), "%", deviations[i].clone(), scale)
            }
        };
        draw_map(&mut page, corner, size, &extent, (nu, nv), &values, &scale, (heading, unit));
    }
    let dark = exact.contains(&0.0);
    if dark {
        note(&mut page, "Grey: no light is due there.");
    } else {
        page.height -= 16.0;
    }
    Some(page)
}

/// What the map's edges mean: metres where the grid is a rectangle, else cells.
struct Extent {
    width: f64,
    height: f64,
    names: (&'static str, &'static str),
}

impl Extent {
    /// The largest map of this shape in some room; all of the room where that would be but a strip.
    fn fitted(&self, room: (f64, f64)) -> (f64, f64) {
        let fit = (room.0 / self.width).min(room.1 / self.height);
        let size = (fit * self.width, fit * self.height);
        if size.0 > 60.0 && size.1 > 60.0 { size } else { room }
    }
}

fn extent(case: &CaseRecord, nu: usize, nv: usize) -> Extent {
    let at = |i: usize, j: usize| case.points[j * nu + i].position;
    if nu > 1 && nv > 1 {
        let (u, v) = (at(1, 0) - at(0, 0), at(0, 1) - at(0, 0));
        let (lu, lv) = (u.length(), v.length());
        let off = |i: usize, j: usize| (at(i, j) - (at(0, 0) + u * i as f64 + v * j as f64)).length();
        let even = (0..nv).all(|j| (0..nu).all(|i| off(i, j) <= 1e-9 * (lu * nu as f64 + lv * nv as f64)));
        if even && u.dot(v).abs() <= 1e-9 * lu * lv {
            let names = ("along u (m)", "along v (m)");
            return Extent { width: lu * nu as f64, height: lv * nv as f64, names };
        }
    }
    Extent { width: nu as f64, height: nv as f64, names: ("column (s)", "row (t)") }
}

#[allow(clippy::too_many_arguments)]
fn draw_map(
    page: &mut Page,
    corner: (f64, f64),
    size: (f64, f64),
    extent: &Extent,
    (nu, nv): (usize, usize),
    values: &[Option<f64>],
    scale: &ColourScale,
    (heading, unit): (&str, &str),
) {
    let (left, top) = (corner.0 + LEFT, corner.1 + ABOVE);
    let panel = Panel {
        left,
        top,
        right: left + size.0,
        bottom: top + size.1,
        x: Axis::linear(0.0, extent.width, false, 4),
        y: Axis::linear(0.0, extent.height, false, 4),
    };
    panel.draw(page, extent.names.0, extent.names.1);
    page.bold((left, corner.1 + 10.0), heading, TEXT, INK, Align::Start);
    let colour = |value: Option<f64>| value.map_or(NOTHING_DUE, |v| scale.colour(scale.shade(v)));
    // The first row of points lies below.
    let colours = (0..nv).rev().flat_map(|j| values[j * nu..(j + 1) * nu].iter().map(|value| colour(*value)));
    page.raster((left, top), size, nu, colours.collect());
    panel.draw_frame(page);
    let (bar, width) = (panel.right + 16.0, 14.0);
    let shades = (0..SHADES).rev().map(|shade| scale.colour(shade)).collect();
    page.raster((bar, top), (width, size.1), 1, shades);
    let axis = Axis::linear(scale.low, scale.high, false, 4);
    for (value, label) in &axis.ticks {
        let y = panel.bottom - size.1 * axis.share(*value);
        page.line(vec![(bar + width, y), (bar + width + 4.0, y)], INK, 1.0, Dash::Solid);
        page.text((bar + width + 7.0, y), label.as_str(), SMALL, INK, Align::Start);
    }
    page.text((bar, corner.1 + 10.0), axis.unit(unit), SMALL, GREY, Align::Start);
}

const NOTHING_DUE: Rgb = [0xc8; 3];

struct ColourScale {
    low: f64,
    high: f64,
    stops: &'static [(u8, u8, u8)],
}

impl ColourScale {
    fn shade(&self, value: f64) -> usize {
        let share = (value - self.low) / (self.high - self.low);
        (share * SHADES as f64).clamp(0.0, SHADES as f64 - 1.0) as usize
    }
    fn colour(&self, shade: usize) -> Rgb {
        let along = shade as f64 / (SHADES - 1) as f64 * (self.stops.len() - 1) as f64;
        let i = (along as usize).min(self.stops.len() - 2);
        let share = along - i as f64;
        let (a, b) = (self.stops[i], self.stops[i + 1]);
        let mixed = |a: u8, b: u8| (f64::from(a) + (f64::from(b) - f64::from(a)) * share).round() as u8;
        [mixed(a.0, b.0), mixed(a.1, b.1), mixed(a.2, b.2)]
    }
}

/// Nuñez, Anderton and Renslow (2018), nine stops of cividis.
const CIVIDIS: [(u8, u8, u8); 9] = [
    (0, 34, 78),
    (26, 56, 111),
    (67, 78, 108),
    (97, 101, 111),
    (125, 124, 120),
    (155, 148, 118),
    (188, 174, 108),
    (222, 201, 88),
    (254, 232, 56),
];

/// Diverging, its middle white: less than exact is blue, more is orange.
const BLUE_WHITE_ORANGE: [(u8, u8, u8); 5] =
    [(0, 76, 132), (104, 168, 210), (250, 250, 250), (236, 152, 92), (168, 66, 0)];
