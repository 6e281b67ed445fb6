//! What a map of texels is off by: bias that grows with the texels, noise that shrinks with them and with rays.

use super::axis::Axis;
use super::ink::Page;
use super::panel::{HEIGHT, Key, Panel, WIDTH, legend_rows, note, titled_page};
use super::render::grouped;
use super::style::{Dash, INK, look};
use crate::report::record::CaseRecord;
use crate::sampling::Strategy;
use crate::trial::MapRow;

/// Relative errors over the texels' size, log–log. `None` where they are not known.
pub fn texels(case: &CaseRecord) -> Option<Page> {
    let rows = &case.texels;
    let relative = |row: &MapRow, error: f64| error / row.irradiance;
    let noise = |row: &MapRow| relative(row, row.variance.sqrt());
    let due = |row: &MapRow| relative(row, row.predicted_variance.sqrt());
    let bias = |row: &MapRow| relative(row, row.exact_bias);
    let all = || rows.iter().flat_map(|row| [noise(row), due(row), bias(row)]).filter(|error| *error > 0.0);
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
    let sizes = || rows.iter().map(|row| row.size);
    let (small, large) = (sizes().fold(f64::INFINITY, f64::min), sizes().fold(0.0, f64::max));
    if high <= 0.0 || small >= large {
        return None;
    }
    let mut page = titled_page(
        &case.title,
        &format!("{}: error of the map of bent light, by the size of its texels", case.name),
    );
    let (left, right) = (104.0, WIDTH - 24.0);
    let x = Axis::log(small / 1.3, large * 1.3, 8);
    let panel = Panel { left, top: 76.0, right, bottom: 488.0, x, y: Axis::log(low / 2.0, high * 2.0, 8) };
    panel.draw(&mut page, "size of a texel (m)", "relative error (root mean square)");
    let mut budgets: Vec<u64> = rows.iter().map(|row| row.rays).collect();
    budgets.dedup();
    let mut legend = Vec::new();
    for (k, rays) in budgets.iter().enumerate() {
        let look = look(Strategy::ALL[k % Strategy::ALL.len()]);
        let of_budget = || rows.iter().filter(|row| row.rays == *rays);
        panel.curve(&mut page, of_budget().map(|row| (row.size, due(row))), look.colour, 1.4, look.dash);
        for row in of_budget().filter(|row| row.variance > 0.0) {
            page.marker(panel.at(row.size, noise(row)), look.marker, look.colour, 4.0);
        }
        let key = Key::Line { colour: look.colour, width: 1.4, dash: look.dash, marker: Some(look.marker) };
        legend.push((key, format!("noise, {} rays", grouped(*rays))));
    }
    let last = budgets.last()?;
    let biased = rows.iter().filter(|row| row.rays == *last && row.exact_bias > 0.0);
    panel.curve(&mut page, biased.map(|row| (row.size, bias(row))), INK, 1.8, Dash::Solid);
    legend.push((
        Key::Line { colour: INK, width: 1.8, dash: Dash::Solid, marker: None },
        "bias by the texels' size".to_owned(),
    ));
    legend_rows(&mut page, (left, HEIGHT - 56.0), right - left, &legend);
    let words =
        "Markers: measured. Lines: predicted; noise from counts of equal packets, bias from exact means over texels.";
    note(&mut page, words);
    Some(page)
}
