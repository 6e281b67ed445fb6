//! The ledger of a case as a flow: from what the sources give out to where it went, widths in proportion.

use std::fmt::Write as _;

use crate::report::page::{count, escaped, two_digits};
use crate::report::record::CaseRecord;

/// Units of the drawing.
const SIZE: [f64; 2] = [560.0, 230.0];

/// Empty where no light was followed.
pub fn flow(case: &CaseRecord) -> String {
    let Some(row) = case.ledger.last().filter(|row| row.source_power > 0.0) else { return String::new() };
    let (top, height) = (34.0, 168.0);
    let (from, to) = (96.0, 356.0);
    let parts = [
        ("deposited", "on the receiver and diffuse surfaces", row.deposited),
        ("absorbed", "by mirrors, occluders, sources, backs", row.absorbed),
        ("escaped", "met nothing any more", row.escaped),
        ("terminated", "at the limit of interactions", row.terminated),
    ];
    let whole = parts.iter().map(|part| part.2.max(0.0)).sum::<f64>().max(f64::MIN_POSITIVE);
    let gap = 10.0;
    let scale = (height - gap * (parts.len() - 1) as f64) / whole;
    let label = format!("Where {} W of light went", two_digits(row.source_power));
    let mut svg = format!(
        "<svg class=\"flow\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{label}\"><title>{label}</title>\n",
        SIZE[0], SIZE[1]
    );
    let thick = whole * scale;
    let begin = top + 0.5 * (height - thick);
    let _ = writeln!(
        svg,
        "<rect class=\"emitted\" x=\"{}\" y=\"{begin:.1}\" width=\"12\" height=\"{thick:.1}\"/>\
         <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">emitted</text><text class=\"note\" x=\"{}\" y=\"{:.1}\" \
         text-anchor=\"end\">{} W</text>",
        from - 12.0,
        from - 18.0,
        begin + 0.5 * thick - 3.0,
        from - 18.0,
        begin + 0.5 * thick + 13.0,
        two_digits(row.emitted),
    );
    let (mut left, mut right) = (begin, top);
    for (k, (name, where_to, watts)) in parts.into_iter().enumerate() {
        let part = watts.max(0.0) * scale;
        let middle = 0.5 * (from + to);
        if part > 0.0 {
            let _ = writeln!(
                svg,
                "<path class=\"part{k}\" d=\"M{from} {left:.2}C{middle} {left:.2} {middle} {right:.2} {to} {right:.2}V{0:.2}\
                 C{middle} {0:.2} {middle} {1:.2} {from} {1:.2}Z\"/>",
                right + part.max(0.6),
                left + part.max(0.6)
            );
        }
        let share = 100.0 * watts / whole;
        let share = if watts == 0.0 { "0".to_owned() } else { two_digits(share) };
        let y = right + 0.5 * part + 4.0;
        let _ = writeln!(
            svg,
            "<text x=\"{0}\" y=\"{y:.1}\">{name} {share} %<title>{1} W {where_to}</title></text>",
            to + 8.0,
            two_digits(watts)
        );
        left += part;
        // Words need room even where there is nothing to show.
        right += part.max(8.0) + gap;
    }
    svg += "</svg>\n";
    let known = row.exact_deposited.filter(|exact| *exact > 0.0).map_or(String::new(), |exact| {
        let off = 100.0 * (row.deposited / exact - 1.0);
        format!(" Deposited should be {} W in theory: {off:+.3} % off.", two_digits(exact)).replace('-', "−")
    });
    format!(
        "<figure class=\"fig\"><h4>Where each watt went</h4>{svg}<figcaption>{} rays left the sources. Books are off by {} of \
         the power, which is rounding below 10⁻¹².{known} <a href=\"energy.csv\">energy.csv</a></figcaption></figure>\n",
        count(row.rays),
        escaped(&two_digits(row.largest_gap())),
    )
}
