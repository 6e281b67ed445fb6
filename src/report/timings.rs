//! `timings.html`: what the run's time bought, and where it went. With `timings.csv` all that differs from run to run.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::page::{
    Chart, Drawn, Entry, Series, bars, count, duration, escaped, head, page as whole, table, two_digits,
};
use crate::sampling::Strategy;
use crate::trial::{CaseOutcome, RunOutcome, StrategyOutcome, TimeTo, median};

pub(super) const FILE: &str = "timings.html";

/// Relative standard errors that times are told for.
const ERRORS: [(f64, &str); 3] = [(1e-3, "10⁻³"), (1e-4, "10⁻⁴"), (1e-5, "10⁻⁵")];
const SLOWEST: usize = 10;

/// The page of a run.
pub(super) fn page(outcome: &RunOutcome) -> String {
    let seconds: f64 = outcome.cases.iter().map(CaseOutcome::seconds).sum();
    let mut body = format!(
        "<p class=\"lead\"><code>{}</code></p>\n<p class=\"lead\">{} of processor time in {} {}. Times are those of this \
         machine while the run went on; the numbers are in <code>timings.csv</code>. These two files are all of a report that \
         differs from run to run.</p>\n",
        escaped(&outcome.command),
        duration(seconds),
        outcome.cases.len(),
        if outcome.cases.len() == 1 { "case" } else { "cases" },
    );
    let makers = makers(outcome);
    body += &efficiencies(outcome, &makers);
    body += &times_to(outcome, &makers);
    body += &stages(outcome);
    body += &slowest(outcome);
    body += &hierarchies(outcome);
    body += &costs(outcome, &makers);
    body += &others(outcome);
    whole("Timings", &body)
}

/// The names of all that made estimates: strategies in their order, then guests.
fn makers(outcome: &RunOutcome) -> Vec<&str> {
    let all = || outcome.cases.iter().flat_map(|case| &case.strategies);
    let own = Strategy::ALL.into_iter().filter(|s| all().any(|made| made.guest.is_none() && made.strategy == *s));
    let mut names: Vec<&str> = own.map(Strategy::name).collect();
    for guest in all().filter_map(|made| made.guest.as_deref()) {
        if !names.contains(&guest) {
            names.push(guest);
        }
    }
    names
}

fn made_by<'a>(case: &'a CaseOutcome, name: &str) -> Option<&'a StrategyOutcome> {
    case.strategies.iter().find(|made| made.name() == name)
}

/// Cases in which estimates were made.
fn measured(outcome: &RunOutcome) -> impl Iterator<Item = &CaseOutcome> {
    outcome.cases.iter().filter(|case| !case.strategies.is_empty())
}

/// One row a case, one column for each name; the entry that `better` prefers is marked where there are several.
fn by_case<T: Copy>(
    outcome: &RunOutcome,
    names: &[&str],
    value: impl Fn(&CaseOutcome, &StrategyOutcome) -> Option<T>,
    better: impl Fn(&T, &T) -> bool,
    show: impl Fn(&CaseOutcome, T) -> String,
) -> String {
    let mut heads = vec!["case".to_owned()];
    heads.extend(names.iter().map(|name| broken(name)));
    let rows: Vec<Vec<Entry>> = measured(outcome)
        .filter_map(|case| {
            let values: Vec<Option<T>> =
                names.iter().map(|name| made_by(case, name).and_then(|made| value(case, made))).collect();
            // Where no direct light varies there is nothing to compare.
            values.iter().any(Option::is_some).then_some(())?;
            let known = || values.iter().flatten();
            let best = |one: &T| known().any(|other| better(one, other)) && !known().any(|other| better(other, one));
            let mut row = vec![Entry::from(escaped(&case.name))];
            row.extend(values.iter().map(|value| match value {
                Some(value) => Entry { html: show(case, *value), best: best(value) },
                None => Entry::default(),
            }));
            Some(row)
        })
        .collect();
    table(&heads, &rows)
}

/// A name that may be broken at its hyphens, to keep columns narrow.
fn broken(name: &str) -> String {
    escaped(name).replace('-', "-<wbr>").replacen("-<wbr>", "-<br>", 1)
}

fn efficiencies(outcome: &RunOutcome, names: &[&str]) -> String {
    if measured(outcome).next().is_none() {
        return String::new();
    }
    // Against random, or where that is missing, against the first that is there.
    let base = |case: &CaseOutcome| {
        let random = made_by(case, Strategy::Random.name()).and_then(StrategyOutcome::efficiency);
        random.or_else(|| case.strategies.iter().find_map(StrategyOutcome::efficiency))
    };
    let table = by_case(
        outcome,
        names,
        |case, made| Some(made.efficiency()? / base(case)?),
        |a, b| a > b,
        |_, ratio| format!("{}×", two_digits(ratio)),
    );
    format!(
        "<h2>Efficiency</h2>\n<p>1 / (variance × time) at the largest N, relative to <code>random</code> in the same case (to the \
         first column filled where that was not run): at 3×, the same error takes a third of the time. The variance is the mean \
         over the points. The best of each case is marked.</p>\n{table}"
    )
}

fn times_to(outcome: &RunOutcome, names: &[&str]) -> String {
    if measured(outcome).next().is_none() {
        return String::new();
    }
    let mut html = String::from(
        "<h2>Time to an error</h2>\n<p>Processor time of one thread until the irradiance at a point is known to a relative standard \
         error, by repeating the estimate at the largest N and averaging: variance × time of one estimate / error², so that ten \
         times finer takes a hundred times longer. A larger N in place of repeats would be quicker where variance falls faster \
         than 1/N. Median over the points that a tenth or more of the light reaches; with ≤, one estimate is finer \
         already. The quickest of each case is marked.</p>\n",
    );
    for (k, (error, name)) in ERRORS.into_iter().enumerate() {
        let table = by_case(
            outcome,
            names,
            |case, made| made.time_to(&case.truths, error),
            |a: &TimeTo, b: &TimeTo| a.seconds < b.seconds,
            |_, time| format!("{}{}", if time.estimates < 1.0 { "≤ " } else { "" }, duration(time.seconds)),
        );
        let open = if k == 0 { " open" } else { "" };
        let _ = writeln!(html, "<details{open}><summary>to {name}</summary>\n{table}</details>");
    }
    html
}

/// What readers are told of a stage beside its name.
fn meaning(stage: &str) -> &'static str {
    match stage {
        "exact" => "exact values",
        "predict" => "predicted variances",
        "pilot" => "estimates that plan others",
        "measure" => "estimates",
        "judge" => "verdicts",
        "light" => "rays from the light",
        "eye_paths" => "paths from the points",
        "next_event" => "the same with shadow rays",
        "caustic_by_eye_paths" => "eye paths beside the map",
        "caustic_by_map" => "the map beside eye paths",
        "hierarchy_build" => "hierarchies over meshes",
        "hierarchy_rays" => "shadow rays through them",
        "brute_force_rays" => "the same without",
        "rays_with_cache" => "shadow rays by blocks, with the shadow cache",
        "rays_without_cache" => "the same without",
        "silhouette_search" => "a mesh's silhouette, from each point",
        "rays_past_silhouette" => "shadow rays by blocks, the silhouette being known",
        _ => "",
    }
}

fn by_stage<'a>(cases: impl Iterator<Item = &'a CaseOutcome>) -> Vec<(&'static str, f64)> {
    let mut sums: BTreeMap<&'static str, f64> = BTreeMap::new();
    for (stage, seconds) in cases.flat_map(CaseOutcome::stages) {
        *sums.entry(stage).or_default() += seconds;
    }
    let mut sums: Vec<_> = sums.into_iter().collect();
    sums.sort_by(|a, b| b.1.total_cmp(&a.1));
    sums
}

fn share(part: f64, whole: f64) -> String {
    let percent = 100.0 * part / whole.max(f64::MIN_POSITIVE);
    if percent < 0.95 { "&lt; 1 %".to_owned() } else { format!("{percent:.0} %") }
}

fn stages(outcome: &RunOutcome) -> String {
    let sums = by_stage(outcome.cases.iter());
    let whole: f64 = sums.iter().map(|(_, seconds)| seconds).sum();
    let entries: Vec<_> = sums
        .iter()
        .map(|(stage, seconds)| {
            let name = format!("<b>{}</b> <span class=\"note\">{}</span>", escaped(stage), meaning(stage));
            (name, *seconds, format!("{} · {}", duration(*seconds), share(*seconds, whole)))
        })
        .collect();
    format!("<h2>Where the time went</h2>\n<p>Stages, over all cases.</p>\n{}", bars(&entries))
}

fn slowest(outcome: &RunOutcome) -> String {
    let whole: f64 = outcome.cases.iter().map(CaseOutcome::seconds).sum();
    let mut cases: Vec<(&CaseOutcome, f64)> = outcome.cases.iter().map(|case| (case, case.seconds())).collect();
    cases.sort_by(|a, b| b.1.total_cmp(&a.1));
    let entries: Vec<_> = cases
        .iter()
        .take(SLOWEST)
        .map(|(case, seconds)| {
            let most = by_stage(std::iter::once(*case)).first().map_or("", |(stage, _)| *stage);
            let name = format!("<b>{}</b> <span class=\"note\">mostly {}</span>", escaped(&case.name), escaped(most));
            (name, *seconds, format!("{} · {}", duration(*seconds), share(*seconds, whole)))
        })
        .collect();
    let said = if cases.len() > SLOWEST { "The ten slowest cases" } else { "Cases, slowest first" };
    format!("<h2>{said}</h2>\n{}", bars(&entries))
}

fn hierarchies(outcome: &RunOutcome) -> String {
    let rows: Vec<Vec<Entry>> = outcome
        .cases
        .iter()
        .flat_map(|case| case.hierarchies().into_iter().map(move |cost| (case, cost)))
        .map(|(case, cost)| {
            vec![
                Entry::from(escaped(&case.name)),
                count(cost.triangles).into(),
                duration(cost.build_seconds).into(),
                duration(cost.ray_seconds).into(),
                duration(cost.brute_force_seconds).into(),
                if cost.ray_seconds > 0.0 {
                    format!("{}×", two_digits(cost.brute_force_seconds / cost.ray_seconds)).into()
                } else {
                    Entry::default()
                },
                duration(cost.block_seconds[0]).into(),
                duration(cost.block_seconds[1]).into(),
            ]
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    let heads = [
        "case".to_owned(),
        "triangles".to_owned(),
        head("building it", "time"),
        head("through it", "time a ray"),
        head("every triangle", "time a ray"),
        "gain".to_owned(),
        head("by blocks, with cache", "time a ray"),
        head("without cache", "time a ray"),
    ];
    format!(
        "<h2>Hierarchy against brute force</h2>\n<p>The same shadow rays with and without a hierarchy over the mesh, one at a time; then by \
         blocks from points that share their points on the sources, with and without the cache of what blocked last. All gave the \
         same answers, ray by ray.</p>\n{}",
        table(&heads, &rows)
    )
}

fn costs(outcome: &RunOutcome, names: &[&str]) -> String {
    let made = || measured(outcome).flat_map(|case| case.strategies.iter().map(move |made| (case, made)));
    let mut series: Vec<Series> = made()
        .map(|(case, made)| {
            let grown = made.growth().map_or(String::new(), |p| format!(", N to the power of {p:.2}"));
            let name = format!("{}, {}{grown}", escaped(&case.name), escaped(made.name()));
            Series { pairs: made.costs(), drawn: Drawn::Thin, colour: "one", name }
        })
        .collect();
    let all = || series.iter().flat_map(|series| &series.pairs);
    let largest = all().map(|pair| pair.0).fold(0.0, f64::max);
    let at_largest = median(all().filter(|pair| pair.0 == largest).map(|pair| pair.1).collect());
    let mut ticks: Vec<f64> = all().map(|pair| pair.0).collect();
    ticks.sort_by(f64::total_cmp);
    ticks.dedup();
    let Some(middle) = at_largest else { return String::new() };
    let smallest = ticks.first().copied().unwrap_or(1.0);
    let law = |x: f64| (x, middle * x / largest);
    let steps = 64;
    let along = (0..=steps).map(|k| law(smallest * (largest / smallest).powf(f64::from(k) / f64::from(steps))));
    series.push(Series { pairs: along.collect(), drawn: Drawn::Guide, colour: "", name: "∝ N".to_owned() });
    let chart = Chart {
        x_name: "samples N".to_owned(),
        y_name: "processor time of one estimate".to_owned(),
        x_ticks: thinned(&ticks),
        series,
    };
    let rows: Vec<Vec<Entry>> = names
        .iter()
        .map(|name| {
            let of = |grown: fn(&StrategyOutcome) -> Option<f64>| {
                made().filter(|(_, made)| made.name() == *name).filter_map(|(_, m)| grown(m)).collect::<Vec<_>>()
            };
            let all = of(StrategyOutcome::growth);
            let mut row = vec![Entry::from(escaped(name)), Entry::from(all.len().to_string())];
            for values in [all, of(StrategyOutcome::last_growth)] {
                let low = values.iter().copied().fold(f64::INFINITY, f64::min);
                let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                row.push(median(values).map_or(Entry::default(), |m| format!("{m:.2}").into()));
                row.push(if low <= high { format!("{low:.2} … {high:.2}").into() } else { Entry::default() });
            }
            row
        })
        .collect();
    let heads = [
        "strategy".to_owned(),
        "cases".to_owned(),
        head("exponent", "all N, median"),
        head("", "range"),
        head("exponent", "last two N, median"),
        head("", "range"),
    ];
    let figure = chart.svg().map_or(String::new(), |svg| {
        format!(
            "<figure>{svg}<figcaption>One line a case and strategy; the dotted line grows in proportion to N.</figcaption></figure>"
        )
    });
    format!(
        "<h2>Cost against N</h2>\n<p>Processor time of one estimate at one point grows as a power of N: 1 is linear. Starting an \
         estimate costs something, too, which makes the power smaller where N is small.</p>\n{figure}\n{}",
        table(&heads, &rows)
    )
}

/// Labels of at most eight of the values.
fn thinned(values: &[f64]) -> Vec<(f64, String)> {
    let every = values.len().div_ceil(8).max(1);
    let label = |(k, value): (usize, &f64)| (*value, if k % every == 0 { format!("{value}") } else { String::new() });
    values.iter().enumerate().map(label).collect()
}

/// Cases in which no estimates were made are not in the tables.
fn others(outcome: &RunOutcome) -> String {
    let names: Vec<String> =
        outcome.cases.iter().filter(|case| case.strategies.is_empty()).map(|case| escaped(&case.name)).collect();
    if names.is_empty() {
        return String::new();
    }
    format!(
        "<p class=\"note\">Without estimates of direct light, and so in no table by strategy: {}.</p>\n",
        names.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::super::made_up;
    use super::*;

    /// Tags that are opened and not closed, or closed and not opened.
    fn unbalanced(html: &str) -> Vec<String> {
        let mut open: Vec<String> = Vec::new();
        let mut wrong = Vec::new();
        for tag in html.split('<').skip(1).filter_map(|rest| rest.split_once('>')).map(|(tag, _)| tag) {
            let name = tag.trim_start_matches('/').split([' ', '/']).next().unwrap_or("").to_owned();
            if tag.starts_with('!') || tag.ends_with('/') || ["meta", "br", "wbr"].contains(&name.as_str()) {
                continue;
            }
            if !tag.starts_with('/') {
                open.push(name);
            } else if open.pop().as_deref() != Some(&name) {
                wrong.push(name);
            }
        }
        wrong.extend(open);
        wrong
    }

    #[test]
    fn the_page_holds_every_case_and_every_strategy_and_escapes_names() {
        let mut outcome = made_up::outcome();
        let mut dark = outcome.cases[0].clone();
        dark.name = "caustic/<script>alert(1)</script> & \"more\"".to_owned();
        dark.strategies.clear();
        outcome.cases.push(dark);
        outcome.cases[1].strategies[0].guest = Some("guest <one>".to_owned());
        outcome.command = "etendue run '<x>&'".to_owned();
        let html = page(&outcome);
        for case in &outcome.cases {
            assert!(html.contains(&escaped(&case.name)), "{}", case.name);
        }
        for name in ["random", "correlated", "stratified", "guest &lt;one&gt;"] {
            assert!(html.contains(name), "{name}");
        }
        assert!(html.contains("etendue run &#39;&lt;x&gt;&amp;&#39;"));
        assert!(
            !html.contains("<script") && !html.contains("<one>") && !html.contains("NaN") && !html.contains("inf")
        );
        assert_eq!(unbalanced(&html), Vec::<String>::new());
        // Nothing is fetched.
        for word in ["http:", "https:", "src=", "href=", "url(", "@import"] {
            assert!(!html.contains(word), "{word}");
        }
    }

    #[test]
    fn efficiencies_stand_beside_those_of_random_and_the_best_is_marked() {
        let mut outcome = made_up::outcome();
        outcome.cases.truncate(1);
        for (made, efficiency) in outcome.cases[0].strategies.iter_mut().zip([2e6, 1e6, 6.2e6]) {
            made.timings[0].efficiency = Some(efficiency);
        }
        let html = efficiencies(&outcome, &makers(&outcome));
        assert!(html.contains("<td>1.0×</td><td>0.50×</td><td class=\"best\">3.1×</td>"), "{html}");
    }

    #[test]
    fn times_to_an_error_are_variance_times_time_over_its_square() {
        let mut outcome = made_up::outcome();
        outcome.cases.truncate(1);
        let case = &mut outcome.cases[0];
        let truths = case.truths.clone();
        let cell = case.strategies[0].cells.last_mut().unwrap();
        // A relative variance of 10⁻⁴ at every point, 2 µs an estimate: 100 repeats to 10⁻³.
        for (point, truth) in cell.points.iter_mut().zip(&truths) {
            point.variance = 1e-4 * truth.irradiance.watts_per_square_metre().powi(2);
        }
        cell.seconds = 2e-6 * cell.replicates as f64 * truths.len() as f64;
        let time = case.strategies[0].time_to(&truths, 1e-3).unwrap();
        assert!((time.seconds / 2e-4 - 1.0).abs() < 1e-12 && (time.estimates - 100.0).abs() < 1e-9, "{time:?}");
        let coarse = case.strategies[0].time_to(&truths, 0.1).unwrap();
        assert!((coarse.seconds / 2e-6 - 1.0).abs() < 1e-12 && coarse.estimates < 1.0, "{coarse:?}");
        let html = times_to(&outcome, &["random"]);
        assert!(
            html.contains("<td>200 µs</td>") && html.contains("<td>20 ms</td>") && html.contains("<td>2.0 s</td>")
        );
    }

    #[test]
    fn a_mesh_shows_what_its_hierarchy_gains() {
        let mut outcome = made_up::outcome();
        outcome.cases.truncate(1);
        let stage = |stage, rays, seconds| crate::trial::Timing { stage, rays, seconds, efficiency: None };
        outcome.cases[0].timings.extend([
            stage("hierarchy_build", 12_345, 2e-3),
            stage("hierarchy_rays", 100, 1e-5),
            stage("brute_force_rays", 100, 4.3e-3),
            stage("rays_with_cache", 1000, 6.1e-5),
            stage("rays_without_cache", 1000, 6.7e-5),
        ]);
        let html = hierarchies(&outcome);
        assert!(html.contains("12\u{202f}345") && html.contains("100 ns") && html.contains("43 µs"), "{html}");
        assert!(html.contains("430×") && html.contains("61 ns") && html.contains("67 ns"), "{html}");
    }

    #[test]
    #[ignore = "writes a page for people to look at, into the system's folder for passing files"]
    fn made_up_page_to_look_at() {
        let dir = std::env::temp_dir().join("etendue-pages");
        std::fs::create_dir_all(&dir).unwrap();
        std::fs::write(dir.join(FILE), page(&made_up::outcome())).unwrap();
    }
}
