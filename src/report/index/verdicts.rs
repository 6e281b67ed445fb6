//! The tables of verdicts: one of all, to sort and filter, and a short one in each case.

use std::fmt::Write as _;

use super::{anchor, effect, rank, sampler, seen_from, verdicts, worst};
use crate::report::page::escaped;
use crate::report::record::{CaseRecord, ReportRecord, VerdictRecord};
use crate::statistics::Verdict;

const HEADS: [(&str, &str); 7] = [
    ("verdict", ""),
    ("case", ""),
    ("strategy", ""),
    ("property", ""),
    ("effect", "95 %"),
    ("seen from", "mean / worst point"),
    ("evidence", "log10; fails at 6"),
];

/// All verdicts, failing ones first.
pub fn section(record: &ReportRecord) -> String {
    let mut rows: Vec<(&CaseRecord, &VerdictRecord)> = verdicts(record).collect();
    if rows.is_empty() {
        return "<section id=\"verdicts\"><h2>Verdicts</h2>\n<p>None.</p></section>\n".to_owned();
    }
    rows.sort_by_key(|(_, judged)| rank(&judged.verdict));
    let mut html = String::from(
        "<section id=\"verdicts\">\n<h2>Verdicts</h2>\n<p>Each is about one property of one strategy in one case. <b>Pass</b>: no \
         evidence of a fault, and faults as small as <i>seen from</i> would have been caught with 99 % probability. <b>Fail</b>: \
         happens to a correct estimator once in a million. <b>Undecided</b>: too little was measured to say. <i>Bias</i>: the mean is exact; <i>variance</i>: errors are as large as \
         predicted; <i>covariance</i>: errors of different points go together as predicted; <i>energy</i>: every watt is booked; \
         <i>caustic</i>: rings get the flux that is due; <i>indirect</i>: so does light that was sent on. <i>Effect</i>: how far off, \
         relative; negative evidence is none. \
         <a href=\"verdicts.csv\">verdicts.csv</a></p>\n\
         <p class=\"tools\"><label>Find <input type=\"search\" id=\"find\" placeholder=\"case, strategy, property\"></label> \
         <label>Show <select id=\"only\"><option value=\"\">all verdicts</option><option value=\"fail\">failed</option>\
         <option value=\"undecided\">undecided</option><option value=\"pass\">passed</option></select></label> \
         <span id=\"found\" role=\"status\"></span></p>\n<div class=\"wide tall\" tabindex=\"0\" role=\"region\" \
         aria-label=\"Table of verdicts\"><table id=\"table\"><thead><tr>",
    );
    for (name, below) in HEADS {
        let below = if below.is_empty() { String::new() } else { format!("<br><span class=\"unit\">{below}</span>") };
        let _ = write!(html, "<th scope=\"col\"><button type=\"button\" data-sort>{name}</button>{below}</th>");
    }
    html += "</tr></thead><tbody>\n";
    for (case, judged) in rows {
        let _ = writeln!(
            html,
            "<tr data-verdict=\"{0}\"><td data-value=\"{1}\"><span class=\"mark {0}\">{0}</span></td>\
             <th scope=\"row\"><a href=\"#{2}\">{3}</a></th>{4}</tr>",
            judged.verdict.name(),
            rank(&judged.verdict),
            anchor(case, record),
            escaped(&case.name),
            cells(judged),
        );
    }
    html + "</tbody></table></div>\n</section>\n"
}

/// Of one case. Rings and points are told one by one in the tables.
pub fn of_case(case: &CaseRecord) -> String {
    if worst(case).is_none() {
        return "<p class=\"note\">Nothing was judged here.</p>\n".to_owned();
    }
    let mut html = String::from("<div class=\"wide\"><table><thead><tr>");
    for (name, below) in HEADS.iter().filter(|(name, _)| *name != "case") {
        let below = if below.is_empty() { String::new() } else { format!("<br><span class=\"unit\">{below}</span>") };
        let _ = write!(html, "<th scope=\"col\">{name}{below}</th>");
    }
    html += "</tr></thead><tbody>\n";
    for judged in &case.verdicts {
        let name = judged.verdict.name();
        let _ = writeln!(html, "<tr><td><span class=\"mark {name}\">{name}</span></td>{}</tr>", cells(judged));
    }
    html += "</tbody></table></div>\n";
    let again = case.verdicts.iter().find(|judged| judged.verdict == Verdict::Fail).or(case.verdicts.first());
    if let Some(judged) = again {
        let _ = writeln!(
            html,
            "<p class=\"again\"><code>{}</code> <button type=\"button\" data-copy>Copy</button></p>",
            escaped(&judged.reproduce)
        );
    }
    html
}

/// What both tables tell of a verdict, to the right of its case.
fn cells(judged: &VerdictRecord) -> String {
    let number = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:e}"));
    format!(
        "<td class=\"text\"><span class=\"s-{}\">{}</span></td><td class=\"text\">{}</td><td data-value=\"{}\">{}</td>\
         <td data-value=\"{}\">{}</td><td data-value=\"{}\">{}</td>",
        sampler::class(&judged.strategy),
        escaped(&sampler::shown(&judged.strategy)),
        escaped(&judged.property),
        number(judged.effect.map(|[effect, ..]| effect.abs())),
        effect(judged),
        number(judged.smallest_bias_mean),
        seen_from(judged),
        number(judged.evidence),
        judged.evidence.map_or("–".to_owned(), |x| sampler::minus(format!("{x:.1}"))),
    )
}
