//! The question that most readers come with: which sampler for soft shadows, and why? Answered from the run's own penumbras.

use std::fmt::Write as _;

use super::Pictures;
use crate::configuration::Role;
use crate::oracle::Region;
use crate::report::page::{escaped, two_digits};
use crate::report::record::{CaseRecord, RateRecord, ReportRecord, StrategyRecord};
use crate::sampling::Strategy;
use crate::statistics::Verdict;
use crate::trial::median;

/// What others are held against.
const BASE: &str = "random";
/// Less noise than this share of the base's is worth a recommendation.
const WORTH: f64 = 0.9;
/// Errors of neighbours that go together like this show as shapes, not as grain.
const TOGETHER: f64 = 0.5;

/// One strategy over all penumbras that it was run in.
pub struct Compared {
    pub name: String,
    pub cases: usize,
    /// Variance over the base's at the same N: median, least and largest of the cases.
    pub ratio: [f64; 3],
    /// N that has the base's variance at the shown N, by the fitted lines: median, least and largest; `None` where nothing falls.
    pub samples_for_same: Option<[f64; 3]>,
    pub slope: f64,
    pub expected_slope: f64,
    /// Of the errors of the nearest points: median, least and largest; `None` where it was not measured.
    pub neighbours: Option<[f64; 3]>,
    /// In all these cases.
    pub worst: Option<Verdict>,
}

/// All strategies in the penumbras that the base was measured in, quietest first, and the N of the comparison.
pub fn compared(record: &ReportRecord) -> Option<(u64, Vec<Compared>)> {
    let samples = record
        .cases
        .iter()
        .filter(|case| penumbra(case, BASE).is_some())
        .filter_map(CaseRecord::shown_samples)
        .min()?;
    let mut names: Vec<&str> = Vec::new();
    for strategy in record.cases.iter().flat_map(|case| &case.strategies) {
        if !names.contains(&strategy.name.as_str()) {
            names.push(&strategy.name);
        }
    }
    let mut all: Vec<Compared> = names.iter().filter_map(|name| over_cases(record, name, samples)).collect();
    all.sort_by(|a, b| a.ratio[0].total_cmp(&b.ratio[0]));
    (all.len() > 1).then_some((samples, all))
}

fn made<'a>(case: &'a CaseRecord, name: &str) -> Option<&'a StrategyRecord> {
    case.strategies.iter().find(|strategy| strategy.name == name)
}

/// The variance curve over the penumbra of a case.
fn penumbra<'a>(case: &'a CaseRecord, name: &str) -> Option<&'a RateRecord> {
    made(case, name)?.rates.iter().find(|r| r.quantity == "variance" && r.region == Some(Region::Penumbra))
}

fn over_cases(record: &ReportRecord, name: &str, samples: u64) -> Option<Compared> {
    let (mut ratios, mut same, mut slopes, mut expected, mut neighbours) = (vec![], vec![], vec![], vec![], vec![]);
    let mut worst: Option<Verdict> = None;
    for case in &record.cases {
        let (Some(own), Some(base)) = (penumbra(case, name), penumbra(case, BASE)) else { continue };
        let judged = case.verdicts.iter().filter(|judged| judged.strategy == name).map(|judged| judged.verdict);
        worst = judged.chain(worst).min_by_key(super::rank);
        let at = |rate: &RateRecord| rate.points.iter().find(|p| p.samples == samples).map(|p| p.value);
        let (Some(variance), Some(of_base)) = (at(own), at(base)) else { continue };
        if of_base <= 0.0 {
            continue;
        }
        ratios.push(variance / of_base);
        slopes.push(own.slope);
        expected.push(own.expected_slope);
        if let Some(line) = own.line.filter(|_| own.slope < 0.0) {
            same.push(((of_base.ln() - line.intercept) / own.slope).exp());
        }
        let correlations = made(case, name).map_or(&[][..], |made| &made.correlations);
        let apart = correlations.iter().filter(|c| c.samples == samples && c.separation > 0.0);
        if let Some(nearest) = apart.min_by(|a, b| a.separation.total_cmp(&b.separation)) {
            neighbours.push(nearest.correlation);
        }
    }
    Some(Compared {
        name: name.to_owned(),
        cases: ratios.len(),
        ratio: spread(ratios)?,
        samples_for_same: spread(same),
        slope: median(slopes)?,
        expected_slope: median(expected)?,
        neighbours: spread(neighbours),
        worst,
    })
}

/// Median, least and largest.
fn spread(values: Vec<f64>) -> Option<[f64; 3]> {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Some([median(values)?, least, largest])
}

/// A shadow that there are pictures of, exact and by each strategy side by side; the first with an umbra, if there is one.
fn beside(record: &ReportRecord, pictures: &[Pictures]) -> String {
    let has_shadow = |k: &usize| {
        let case = &record.cases[*k];
        penumbra(case, BASE).is_some() && case.figures.iter().any(|figure| figure.role == Role::Occluder)
    };
    let mut shadows: Vec<usize> = (0..record.cases.len()).filter(has_shadow).collect();
    shadows.sort_by_key(|k| !record.cases[*k].points.iter().any(|point| point.region == Region::Umbra));
    let shown = shadows.into_iter().map(|k| (k, &pictures[k])).find(|(_, pictures)| pictures.len() > 2);
    let Some((k, pictures)) = shown else { return String::new() };
    let figures: String = pictures
        .iter()
        .filter(|(name, _)| !name.starts_with("error"))
        .map(|(name, png)| {
            format!(
                "<figure><img alt=\"The receiver of {}: {}\" src=\"data:image/png;base64,{}\"><figcaption>{}</figcaption></figure>",
                escaped(&record.cases[k].name),
                escaped(name),
                super::base64(png),
                escaped(name),
            )
        })
        .collect();
    format!(
        "<p>Below: the receiver of <a href=\"#case-{k}\">{}</a>, exact and with 16 samples a pixel.</p>\n\
         <div class=\"beside\">{figures}</div>\n",
        escaped(&record.cases[k].name)
    )
}

/// What people read for a strategy.
pub fn shown(name: &str) -> String {
    if name == "correlated" { "shared points".to_owned() } else { name.to_owned() }
}

/// Why a strategy's noise falls as it does in a penumbra.
fn reason(name: &str) -> &'static str {
    match Strategy::from_name(name) {
        Some(Strategy::Stratified | Strategy::MultiJittered) => {
            "Each of its N points has a cell of the source for itself. Cells that a shadow’s edge does not cut are hardly noisy; \
             only some √N of the N cells are cut. So variance falls like N⁻³ᐟ² in a penumbra (and like N⁻² in the light, where \
             nothing is cut), while points thrown without such cells leave gaps and clumps and fall like N⁻¹."
        }
        Some(Strategy::Sobol) => {
            "Its points fill the source evenly at every N, so that each has about 1/N of it for itself; only those near a shadow’s \
             edge are uncertain."
        }
        Some(Strategy::UniformJitter) => {
            "A grid with one shift for all its points: it leaves no gaps, but the shift moves all of them together."
        }
        Some(Strategy::LatinHypercube) => {
            "It fills rows and columns evenly; that helps where light varies along one axis of the source at a time."
        }
        Some(Strategy::SolidAngle | Strategy::Cosine | Strategy::MisBalance | Strategy::MisPower) => {
            "It chooses directions rather than places on the source, so that no sample counts for much more than another; the \
             shadow’s edge stays, and with it the slope −1."
        }
        _ => "",
    }
}

/// The section; empty where no penumbra was measured with more than one strategy.
pub fn section(record: &ReportRecord, pictures: &[Pictures]) -> String {
    let Some((samples, all)) = compared(record) else { return String::new() };
    let most = all.iter().map(|one| one.cases).max().unwrap_or(0);
    let measured = all.len();
    let mut html = String::from("<section id=\"sampler\">\n<h2>Which sampler for soft shadows?</h2>\n");
    // Those that were measured in fewer cases had others to deal with.
    let fit = |one: &&Compared| one.worst != Some(Verdict::Fail) && one.cases == most;
    let mut sound = all.iter().filter(fit);
    match sound.next() {
        Some(best) if best.name != BASE && best.ratio[0] < WORTH => {
            let name = escaped(&shown(&best.name));
            let where_ = if most == 1 {
                "In the one penumbra".to_owned()
            } else {
                format!("In the median of the {most} penumbras")
            };
            let same = best.samples_for_same.map_or(String::new(), |[middle, least, largest]| {
                let range =
                    if most > 1 { format!(" ({} to {})", whole(least), whole(largest)) } else { String::new() };
                format!(": about {}{range} of them do what {samples} random ones do", whole(middle))
            });
            let _ = writeln!(
                html,
                "<p class=\"answer\"><b>Of the {measured} measured here, use <span class=\"s-{}\">{name}</span> points.</b> {where_} of \
                 this run they have {} times less variance than random points at N = {samples}{same}.</p>\n<p>{}</p>",
                class(&best.name),
                two_digits(1.0 / best.ratio[0]),
                reason(&best.name),
            );
            if best.worst == Some(Verdict::Undecided) {
                html +=
                    "<p><b>Some of its verdicts are undecided</b>: too little was measured to rule out a bias.</p>\n";
            }
        }
        Some(_) => {
            let _ = writeln!(
                html,
                "<p class=\"answer\"><b>None of the {measured} measured here does better than random points</b> in penumbras at \
                 N = {samples}.</p>"
            );
        }
        None => {
            html +=
                "<p class=\"answer\"><b>Every strategy has a failed verdict in a penumbra</b>: mend that first.</p>\n"
        }
    }
    for one in all.iter().filter(|one| one.worst == Some(Verdict::Fail)) {
        let name = escaped(&shown(&one.name));
        let _ = writeln!(html, "<p><b>Not {name}</b>: a verdict on it failed in a penumbra (below).</p>");
    }
    for (one, [together, ..]) in all.iter().filter_map(|one| Some((one, one.neighbours?))) {
        if together <= TOGETHER {
            continue;
        }
        let noise = match one.ratio[0] {
            ratio if ratio < WORTH => "less noisy than",
            ratio if ratio > 1.0 / WORTH => "noisier than",
            _ => "as noisy as",
        };
        let seen = if Strategy::from_name(&one.name).is_some_and(Strategy::shares_points) {
            ": the shadow’s edge breaks into ghost edges, one for each point on the source"
        } else {
            ""
        };
        let _ = writeln!(
            html,
            "<p><b>Beware of {}:</b> at a point they are {noise} random ones, but the nearest points err together (correlation \
             {together:.2} in the median; 0 for points that are fresh everywhere). The error is no grain that an eye or a filter \
             averages away{seen}.</p>",
            escaped(&shown(&one.name)),
        );
    }
    html += &beside(record, pictures);
    let _ = write!(
        html,
        "<div class=\"wide\"><table class=\"samplers\"><thead><tr><th scope=\"col\">strategy</th>\
         <th scope=\"col\">variance, random = 1<br><span class=\"unit\">N = {samples}; median (range)</span></th>\
         <th scope=\"col\">N as good as<br>{samples} random</th><th scope=\"col\">nearest errors<br>correlate</th>\
         <th scope=\"col\">slope<br><span class=\"unit\">measured / expected</span></th>\
         <th scope=\"col\">verdicts</th></tr></thead><tbody>"
    );
    for one in &all {
        let several = |words: String| {
            if one.cases > 1 { format!(" <span class=\"note\">({words})</span>") } else { String::new() }
        };
        let [ratio, least, largest] = one.ratio;
        let ratio_words = two_digits(ratio) + &several(format!("{}–{}", two_digits(least), two_digits(largest)));
        let same = match one.samples_for_same {
            _ if one.name == BASE => samples.to_string(),
            Some([middle, least, largest]) => {
                whole(middle) + &several(format!("{}–{}", whole(least), whole(largest)))
            }
            None => "–".to_owned(),
        };
        let neighbours = one.neighbours.map_or("–".to_owned(), |[middle, least, largest]| {
            correlation(middle) + &several(format!("{} to {}", correlation(least), correlation(largest)))
        });
        let name = one.worst.map_or("none", Verdict::name);
        let _ = write!(
            html,
            "<tr><th scope=\"row\"><span class=\"s-{}\">{}</span></th><td>{ratio_words}</td><td>{same}</td><td>{neighbours}</td>\
             <td>{} / {}</td><td><span class=\"mark {name}\">{name}</span></td></tr>",
            class(&one.name),
            escaped(&shown(&one.name)),
            minus(format!("{:.2}", one.slope)),
            minus(format!("{:.2}", one.expected_slope)),
        );
    }
    html += "</tbody></table></div>\n";
    html += "<div class=\"figs\"><figure class=\"fig\" data-chart=\"ratios\"><h4>Variance in penumbras, relative to random</h4>\
             <figcaption>Variance over that of random points with as many samples, median over the cases; bands: their range. Below 1 is better. \
             <a href=\"curves.csv\">curves.csv</a></figcaption></figure>\n";
    html + "</div>\n</section>\n"
}

/// A count of samples, one at least.
fn whole(n: f64) -> String {
    format!("{:.0}", n.max(1.0))
}

fn correlation(x: f64) -> String {
    minus(format!("{x:.2}")).replace("−0.00", "0.00")
}

pub fn minus(text: String) -> String {
    text.replace('-', "−")
}

/// A name that a style sheet can have, whatever a guest is called.
pub fn class(name: &str) -> &str {
    Strategy::from_name(name).map_or("guest", Strategy::name)
}
