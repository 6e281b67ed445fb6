//! Where each watt went, as one bar for each budget of rays.

use super::ink::{Align, Page};
use super::panel::{Key, WIDTH, legend_rows, titled_page};
use super::style::{Dash, GREY, INK, SMALL, TEXT, look};
use crate::report::record::CaseRecord;
use crate::sampling::Strategy;
use crate::trial::LightRow;

/// `None` where no light was followed.
pub fn energy(case: &CaseRecord) -> Option<Page> {
    let power = case.ledger.first()?.source_power;
    if power <= 0.0 {
        return None;
    }
    let mut page = titled_page(
        &case.title,
        &format!("{}: where the {power:.4} W of its sources went, by rays that left them", case.name),
    );
    let (left, right) = (120.0, WIDTH - 170.0);
    let (top, step, height) = (88.0, 62.0, 34.0);
    let colours = [0, 1, 2, 3].map(|k| look(Strategy::ALL[k]).colour);
    for (k, row) in case.ledger.iter().enumerate() {
        let y = top + step * k as f64;
        page.text((left - 12.0, y + 0.5 * height), format!("{}", row.rays), TEXT, INK, Align::End);
        let mut from = left;
        for (part, colour) in parts(row).into_iter().zip(colours) {
            let to = from + (right - left) * part / row.emitted.max(f64::MIN_POSITIVE);
            page.rectangle((from, y), (to, y + height), colour, 0.75);
            if to - from > 44.0 {
                let share = format!("{:.2} %", 100.0 * part / row.emitted);
                page.text((0.5 * (from + to), y + 0.5 * height), share, SMALL, INK, Align::Middle);
            }
            from = to;
        }
        let gap = format!("gap {:.0e}", row.largest_gap());
        page.text((right + 12.0, y + 0.5 * height), gap, SMALL, GREY, Align::Start);
    }
    let bottom = top + step * case.ledger.len() as f64;
    let names = ["deposited", "absorbed", "escaped", "terminated"];
    let key = |k: usize| Key::Line { colour: colours[k], width: 9.0, dash: Dash::Solid, marker: None };
    let legend: Vec<_> = names.iter().enumerate().map(|(k, name)| (key(k), (*name).to_owned())).collect();
    legend_rows(&mut page, (left, bottom + 8.0), right - left, &legend);
    let note = "Gap: the largest of emitted − all four, emitted − the sources' closed form, map − deposited; of the sources' power.";
    page.height = bottom + 56.0;
    page.text((24.0, page.height - 18.0), note, SMALL, GREY, Align::Start);
    Some(page)
}

fn parts(row: &LightRow) -> [f64; 4] {
    [row.deposited, row.absorbed, row.escaped, row.terminated]
}
