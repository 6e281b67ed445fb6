//! What the rings of a caustic got, beside what they should have got.

use super::axis::Axis;
use super::bias::NORMAL_95;
use super::ink::Page;
use super::panel::{HEIGHT, Key, Panel, WIDTH, legend_rows, note, titled_page};
use super::render::grouped;
use super::style::{Dash, GUIDE, INK, look};
use crate::report::record::{CaseRecord, RingRecord};
use crate::sampling::Strategy;

/// A ring with its radii and the irradiances over it.
struct Ring {
    radii: [f64; 2],
    exact: f64,
    measured: f64,
    std_error: f64,
}

/// The rings of one order, outwards. They follow each other from the axis on, so that their middles tell where they end.
fn rings_of(rings: &[RingRecord], order: usize) -> Vec<Ring> {
    let mut inner = 0.0;
    let of_order = rings.iter().filter(|ring| ring.order == order);
    of_order
        .filter_map(|ring| {
            let outer = 2.0 * ring.position? - inner;
            let std_error = ring.std_error.unwrap_or(0.0);
            let radii = [inner, outer];
            inner = outer;
            Some(Ring { radii, exact: ring.exact, measured: ring.measured, std_error })
        })
        .collect()
}

impl Ring {
    fn middle(&self) -> f64 {
        0.5 * (self.radii[0] + self.radii[1])
    }
}

/// Irradiance over the radius by order, and below it the deviations of the first order in standard errors. `None` where no
/// ring has an exact value.
pub fn caustic(case: &CaseRecord) -> Option<Page> {
    let mut orders: Vec<usize> =
        case.rings.iter().filter(|ring| ring.position.is_some()).map(|ring| ring.order).collect();
    orders.dedup();
    let rings = |order: usize| rings_of(&case.rings, order).into_iter();
    let all = || orders.iter().flat_map(|order| rings(*order));
    let farthest = all().map(|ring| ring.radii[1]).fold(0.0, f64::max);
    let high = all().map(|ring| ring.exact.max(ring.measured + NORMAL_95 * ring.std_error)).fold(0.0, f64::max);
    let first = *orders.first()?;
    if high <= 0.0 {
        return None;
    }
    // Several orders differ by factors of a hundred.
    let is_log = orders.len() > 1;
    let low = all().map(|ring| ring.exact).filter(|exact| *exact > 0.0).fold(high, f64::min);
    let y = if is_log { Axis::log(low / 2.0, high * 2.0, 8) } else { Axis::linear(0.0, 1.06 * high, false, 6) };
    let rays = case.ledger.last().map_or(0, |row| row.rays);
    let mut page = titled_page(
        &case.title,
        &format!("{}: mean irradiance over rings around the axis, {} rays", case.name, grouped(rays)),
    );
    let x = Axis::linear(0.0, farthest, false, 8);
    let (left, right) = (104.0, WIDTH - 24.0);
    let upper = Panel { left, top: 76.0, right, bottom: 348.0, x: x.unlabelled(), y };
    upper.draw(&mut page, "", "irradiance (W/m²)");
    let exact = Key::Line { colour: INK, width: 1.6, dash: Dash::Solid, marker: None };
    let mut legend = vec![(exact, "exact".to_owned())];
    for (k, order) in orders.iter().enumerate() {
        let look = look(Strategy::ALL[k % Strategy::ALL.len()]);
        let inside = |v: f64| v > upper.y.low() || !is_log;
        let steps: Vec<(f64, f64)> = rings(*order)
            .filter(|ring| inside(ring.exact))
            .flat_map(|ring| ring.radii.map(|radius| (radius, ring.exact)))
            .collect();
        upper.curve(&mut page, steps, INK, 1.4, Dash::Solid);
        for ring in rings(*order).filter(|ring| inside(ring.measured)) {
            let half = NORMAL_95 * ring.std_error;
            let (bottom, top) = (ring.measured - half, ring.measured + half);
            if inside(bottom) {
                upper.bar(&mut page, (ring.middle(), bottom, top), 0.0, 3.0, look.colour);
            } else {
                // It leaves the panel: no cap there.
                upper.bar(&mut page, (ring.middle(), upper.y.low(), top), 0.0, 0.0, look.colour);
                upper.bar(&mut page, (ring.middle(), top, top), 0.0, 3.0, look.colour);
            }
            page.marker(upper.at(ring.middle(), ring.measured), look.marker, look.colour, 3.4);
        }
        if rings(*order).all(|ring| !inside(ring.measured)) {
            // No ray came so far: there is no mark to tell of.
            continue;
        }
        let name = if *order == 1 { "1 interaction".to_owned() } else { format!("{order} interactions") };
        legend.push((Key::Bar { colour: look.colour, marker: look.marker }, name));
    }
    let pulls: Vec<(f64, f64)> = rings(first)
        .filter(|ring| ring.std_error > 0.0)
        .map(|ring| (ring.middle(), (ring.measured - ring.exact) / ring.std_error))
        .collect();
    let most = pulls.iter().map(|(_, pull)| pull.abs()).fold(3.0, f64::max);
    let lower = Panel { left, top: 372.0, right, bottom: 488.0, x, y: Axis::linear(-most, most, true, 4) };
    lower.draw(&mut page, "radius (m)", "deviation (standard errors)");
    for level in [-NORMAL_95, 0.0, NORMAL_95] {
        let colour = if level == 0.0 { INK } else { GUIDE };
        lower.curve(&mut page, [(0.0, level), (farthest, level)], colour, 1.0, Dash::Solid);
    }
    let look = look(Strategy::ALL[0]);
    for (radius, pull) in pulls {
        page.marker(lower.at(radius, pull), look.marker, look.colour, 3.4);
    }
    legend_rows(&mut page, (left, HEIGHT - 56.0), right - left, &legend);
    let below = if orders.len() > 1 { "the same less exact, first order" } else { "the same less exact" };
    let words = format!(
        "Steps: exact means over the rings. Marks: measured, bars ±1.96 standard errors. Below: {below}; grey lines at ±1.96."
    );
    note(&mut page, &words);
    Some(page)
}
