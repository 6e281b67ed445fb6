//! Where each watt went, as one bar for each budget of rays.

use super::axis::superscript;
use super::ink::{Align, Page};
use super::panel::{Key, WIDTH, legend_rows, note, titled_page};
use super::render::grouped;
use super::style::{Dash, GREY, INK, PAPER, SMALL, TEXT, look};
use super::text::text_width;
use crate::report::record::CaseRecord;
use crate::sampling::Strategy;
use crate::trial::LightRow;

/// `None` where no light was followed.
pub fn energy(case: &CaseRecord) -> Option<Page> {
    let power = case.ledger.first()?.source_power;
    if power <= 0.0 {
        return None;
    }
    let mut page = titled_page(&case.title, &format!("{}: where the {power:.4} W of its sources went", case.name));
    let (left, right) = (120.0, WIDTH - 170.0);
    let (top, step, height) = (106.0, 66.0, 34.0);
    let colours = [0, 1, 2, 3].map(|k| look(Strategy::ALL[k]).colour);
    page.text((left - 12.0, top - 20.0), "rays", SMALL, GREY, Align::End);
    page.text((left, top - 20.0), "share of the power", SMALL, GREY, Align::Start);
    page.text((right + 12.0, top - 20.0), "gap", SMALL, GREY, Align::Start);
    for (k, row) in case.ledger.iter().enumerate() {
        let y = top + step * k as f64;
        page.text((left - 12.0, y + 0.5 * height), grouped(row.rays), TEXT, INK, Align::End);
        let mut from = left;
        // Where the next word under the bar may begin.
        let mut free = left;
        for ((part, colour), name) in parts(row).into_iter().zip(colours).zip(NAMES) {
            let to = from + (right - left) * part / row.emitted.max(f64::MIN_POSITIVE);
            page.rectangle((from, y), (to, y + height), colour, SHADE);
            if from > left && to > from {
                page.line(vec![(from, y), (from, y + height)], PAPER, 1.5, Dash::Solid);
            }
            let words = format!("{name} {:.2} %", 100.0 * part / row.emitted);
            let width = text_width(&words, SMALL, false);
            if to - from > width + 12.0 {
                page.text((0.5 * (from + to), y + 0.5 * height), words, SMALL, INK, Align::Middle);
            } else if part > 0.0 {
                let start = (0.5 * (from + to - width)).max(free).min(right - width);
                page.text((start, y + height + 11.0), words, SMALL, INK, Align::Start);
                free = start + width + 12.0;
            }
            from = to;
        }
        page.text((right + 12.0, y + 0.5 * height), shown_gap(row.largest_gap()), SMALL, GREY, Align::Start);
    }
    let bottom = top + step * case.ledger.len() as f64;
    let key = |k: usize| Key::Area { colour: colours[k], opacity: SHADE };
    let legend: Vec<_> = NAMES.iter().enumerate().map(|(k, name)| (key(k), (*name).to_owned())).collect();
    legend_rows(&mut page, (left, bottom + 8.0), right - left, &legend);
    let words = "Gap: the largest of emitted − all four, emitted − the sources' closed form, map − deposited; of the sources' power.";
    page.height = bottom + 56.0;
    note(&mut page, words);
    Some(page)
}

/// The four accounts, in the order of [`parts`].
const NAMES: [&str; 4] = ["deposited", "absorbed", "escaped", "terminated"];
/// Light enough for words on it.
const SHADE: f64 = 0.65;

/// `3·10⁻¹⁷`.
fn shown_gap(gap: f64) -> String {
    let text = format!("{gap:.0e}");
    match text.split_once('e') {
        Some((digits, exponent)) if gap != 0.0 => format!("{digits}·10{}", superscript(exponent)),
        _ => "0".to_owned(),
    }
}

fn parts(row: &LightRow) -> [f64; 4] {
    [row.deposited, row.absorbed, row.escaped, row.terminated]
}
