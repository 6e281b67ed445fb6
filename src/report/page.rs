//! Pages of HTML that stand alone: one file, no script, nothing fetched; light and dark, wide and narrow. Charts are SVG
//! drawn here, so that they take the page's colours; those of `plots/` are made for paper.

use std::fmt::Write as _;

/// Colours follow the reader's setting; a table too wide for the screen scrolls by itself, its first column stays.
pub(super) const STYLE: &str = "
:root { color-scheme: light dark; --paper: #ffffff; --ink: #1d232a; --grey: #5d6873; --rule: #d9dee3; --tint: #f3f6f8;
  --one: #0b6bb0; --two: #b8500b; --three: #0b7a5c; --best: #dff0e6; }
@media (prefers-color-scheme: dark) { :root { --paper: #14181c; --ink: #e4e8ec; --grey: #9aa5b0; --rule: #333c45; --tint: #1c2228;
  --one: #6cb6f0; --two: #f0a060; --three: #5fcfa8; --best: #1d4031; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 72rem; padding: 1.5rem 1rem 4rem; background: var(--paper); color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif; }
h1 { font-size: 1.6rem; line-height: 1.2; margin: 0 0 .4rem; }
h2 { font-size: 1.15rem; margin: 2.4rem 0 .3rem; }
p { margin: .3rem 0 .8rem; max-width: 46rem; }
.lead, figcaption, .note { color: var(--grey); }
code { font-family: ui-monospace, 'DejaVu Sans Mono', monospace; font-size: .92em; overflow-wrap: anywhere; }
.wide { overflow-x: auto; margin: .6rem 0 1rem; border-top: 1px solid var(--rule); border-bottom: 1px solid var(--rule); }
table { border-collapse: collapse; font-size: .87rem; font-variant-numeric: tabular-nums; min-width: 100%; }
th, td { padding: .22rem .6rem; text-align: right; white-space: nowrap; }
thead th { color: var(--grey); font-weight: 600; vertical-align: bottom; border-bottom: 1px solid var(--rule); line-height: 1.25; }
tbody tr:nth-child(even) { background: var(--tint); }
tbody th { font-weight: 500; }
th:first-child, td:first-child, .text { text-align: left; }
tr > :first-child { position: sticky; left: 0; background: var(--paper); max-width: 16rem; overflow: hidden; text-overflow: ellipsis; }
tbody tr:nth-child(even) > :first-child { background: var(--tint); }
td.best, tbody tr:nth-child(even) > td.best { background: var(--best); font-weight: 700; }
.unit { font-weight: 400; }
details { margin: .4rem 0; } summary { cursor: pointer; color: var(--one); }
.bars { display: grid; gap: .28rem; margin: .6rem 0 1rem; max-width: 52rem; }
.bar { display: grid; grid-template-columns: 15rem 1fr 8.5rem; gap: .8rem; align-items: center; font-size: .9rem; }
.bar .value { font-variant-numeric: tabular-nums; white-space: nowrap; }
.bar .name { overflow: hidden; text-overflow: ellipsis; }
.bar i { display: block; height: .85rem; min-width: 1px; background: var(--one); border-radius: 0 2px 2px 0; }
.charts { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(21rem, 100%), 1fr)); gap: 1.4rem 2rem; margin: .8rem 0; }
figure { margin: 0; } figcaption { font-size: .87rem; }
figure h3 { font-size: .98rem; margin: 0 0 .1rem; }
svg.chart { width: 100%; max-width: 34rem; height: auto; display: block; }
svg.chart text { font-size: 11.5px; fill: var(--ink); }
svg.chart .name { fill: var(--grey); }
svg.chart .grid { stroke: var(--rule); stroke-width: 1; }
svg.chart .axis { stroke: var(--grey); stroke-width: 1; fill: none; }
svg.chart .guide { stroke: var(--grey); stroke-width: 1; stroke-dasharray: 2 3; fill: none; }
svg.chart .guide-name { fill: var(--grey); }
svg.chart .one { stroke: var(--one); fill: var(--one); } svg.chart .two { stroke: var(--two); fill: var(--two); }
svg.chart .three { stroke: var(--three); fill: var(--three); }
svg.chart .line { fill: none; stroke-width: 1.6; } svg.chart .thin { fill: none; stroke-width: 1; opacity: .4; }
svg.chart .dashed { stroke-dasharray: 6 3; } svg.chart .dot { stroke: none; }
@media (max-width: 40rem) { body { padding: 1rem .75rem 3rem; } .bar { grid-template-columns: 1fr auto; gap: .1rem .6rem; }
  .bar .track { grid-column: 1 / -1; grid-row: 2; } tr > :first-child { max-width: 9.5rem; } }
@media print { body { max-width: none; } .wide { overflow: visible; } }
";

/// A whole page.
///
/// - `title`: as text; `body`: as HTML
pub(super) fn page(title: &str, body: &str) -> String {
    let title = escaped(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n\
         <body>\n<h1>{title}</h1>\n{body}</body>\n</html>\n"
    )
}

/// A text as HTML, in elements and in attributes. Control characters have no place there.
pub(super) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            c if c.is_control() => safe.push(' '),
            c => safe.push(c),
        }
    }
    safe
}

/// A length of time in two digits and a unit that suits it.
pub(super) fn duration(seconds: f64) -> String {
    const UNITS: [(f64, &str); 8] = [
        (1e-9, "ns"),
        (1e-6, "µs"),
        (1e-3, "ms"),
        (1.0, "s"),
        (60.0, "min"),
        (3600.0, "h"),
        (86_400.0, "d"),
        (31_557_600.0, "y"),
    ];
    if !seconds.is_finite() {
        return "–".to_owned();
    }
    if seconds <= 0.0 {
        return "0 s".to_owned();
    }
    // What rounds to 1000 ns is 1 µs.
    let rounded = rounded(seconds, 2);
    let (size, unit) = UNITS.into_iter().rev().find(|(size, _)| rounded >= *size * (1.0 - 1e-9)).unwrap_or(UNITS[0]);
    format!("{} {unit}", two_digits(seconds / size))
}

/// A number > 0 in two digits, or as many as it has before the point.
pub(super) fn two_digits(x: f64) -> String {
    if !x.is_finite() {
        return "–".to_owned();
    }
    if x == 0.0 {
        return "0".to_owned();
    }
    let rounded = rounded(x, 2);
    let places = (1 - rounded.abs().log10().floor() as i32).max(0) as usize;
    if rounded.abs() >= 1e5 || places > 5 {
        let exponent = rounded.abs().log10().floor() as i32;
        return format!("{:.1}·10{}", rounded / 10f64.powi(exponent), superscript(exponent));
    }
    if rounded.abs() >= 100.0 { format!("{x:.0}") } else { format!("{rounded:.places$}") }
}

/// To so many digits.
fn rounded(x: f64, digits: i32) -> f64 {
    let step = 10f64.powi(x.abs().log10().floor() as i32 + 1 - digits);
    (x / step).round() * step
}

/// `−3` as `⁻³`.
fn superscript(n: i32) -> String {
    const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised = |c: char| c.to_digit(10).map_or('⁻', |digit| RAISED[digit as usize]);
    n.to_string().chars().map(raised).collect()
}

/// A count with its thousands: `12 300`, narrow spaces between.
pub(super) fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (k, c) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(c);
    }
    text
}

/// A table within a frame that scrolls. Heads and cells are HTML.
///
/// - `rows`: the first cell of each names the row
pub(super) fn table(heads: &[String], rows: &[Vec<Entry>]) -> String {
    let mut html = String::from("<div class=\"wide\"><table>\n<thead><tr>");
    for head in heads {
        let _ = write!(html, "<th scope=\"col\">{head}</th>");
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for row in rows {
        html.push_str("<tr>");
        for (k, entry) in row.iter().enumerate() {
            let _ = match (k, entry.best) {
                (0, _) => write!(html, "<th scope=\"row\">{}</th>", entry.html),
                (_, true) => write!(html, "<td class=\"best\">{}</td>", entry.html),
                _ => write!(html, "<td>{}</td>", entry.html),
            };
        }
        html.push_str("</tr>\n");
    }
    html + "</tbody></table></div>\n"
}

/// One cell of a table.
#[derive(Clone, Debug, Default)]
pub(super) struct Entry {
    pub html: String,
    /// Marked as the best of its row.
    pub best: bool,
}

impl From<String> for Entry {
    fn from(html: String) -> Entry {
        Entry { html, best: false }
    }
}
impl From<&str> for Entry {
    fn from(html: &str) -> Entry {
        Entry::from(html.to_owned())
    }
}

/// A head with its unit below.
pub(super) fn head(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name}<br><span class=\"unit\">{unit}</span>") }
}

/// Bars below each other: name and value as HTML, length relative to the longest.
pub(super) fn bars(entries: &[(String, f64, String)]) -> String {
    let longest = entries.iter().map(|entry| entry.1).fold(f64::MIN_POSITIVE, f64::max);
    let mut html = String::from("<div class=\"bars\">\n");
    for (name, length, value) in entries {
        let share = 100.0 * length / longest;
        let _ = writeln!(
            html,
            "<div class=\"bar\"><span class=\"name\">{name}</span><span class=\"track\"><i style=\"width:{share:.2}%\">\
             </i></span><span class=\"value\">{value}</span></div>"
        );
    }
    html + "</div>\n"
}

/// How a chart shows a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Drawn {
    /// Joined by a thin line, one of many.
    Thin,
    Dots,
    Line,
    Dashed,
    /// A law to compare with.
    Guide,
}

/// Pairs of values > 0.
#[derive(Clone, Debug)]
pub(super) struct Series {
    pub pairs: Vec<(f64, f64)>,
    pub drawn: Drawn,
    /// `one`, `two` or `three`.
    pub colour: &'static str,
    /// Written at its end; of thin lines, shown by pointing at them.
    pub name: String,
}

/// Times against what they grow with, both logarithmic.
#[derive(Clone, Debug)]
pub(super) struct Chart {
    pub x_name: String,
    pub y_name: String,
    /// Values with their labels.
    pub x_ticks: Vec<(f64, String)>,
    pub series: Vec<Series>,
}

impl Chart {
    /// As SVG; `None` where there is nothing to show.
    pub fn svg(&self) -> Option<String> {
        const SIZE: (f64, f64) = (380.0, 280.0);
        let [left, right, top, bottom] = [58.0, 14.0, 22.0, 40.0];
        // Guides may leave the frame, data do not.
        let shown = || self.series.iter().filter(|series| series.drawn != Drawn::Guide).flat_map(|s| &s.pairs);
        let all = || shown().filter(|(x, y)| x.is_finite() && y.is_finite() && *x > 0.0 && *y > 0.0);
        let ends = |of: fn(&(f64, f64)) -> f64| {
            all().map(of).fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)))
        };
        let ((x0, x1), (y0, y1)) = (ends(|pair| pair.0), ends(|pair| pair.1));
        if x1 <= 0.0 {
            return None;
        }
        let (x0, x1) = (x0 / 1.25, x1 * 1.25);
        let (y0, y1) = widened(y0, y1);
        let along = |v: f64, low: f64, high: f64| (v / low).ln() / (high / low).ln();
        let x_at = |x: f64| left + (SIZE.0 - left - right) * along(x, x0, x1);
        let y_at = |y: f64| SIZE.1 - bottom - (SIZE.1 - top - bottom) * along(y, y0, y1);
        let (floor, edge) = (SIZE.1 - bottom, SIZE.0 - right);
        let mut svg = format!(
            "<svg class=\"chart\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{} against {}\">\n",
            SIZE.0, SIZE.1, self.y_name, self.x_name
        );
        let mut decade = 10f64.powf((y0.log10() - 1e-9).ceil());
        let every = ((y1 / y0).log10() / 6.0).ceil().max(1.0) as i32;
        while decade <= y1 * (1.0 + 1e-9) {
            let y = y_at(decade);
            let _ = writeln!(svg, "<line class=\"grid\" x1=\"{left}\" y1=\"{y:.1}\" x2=\"{edge}\" y2=\"{y:.1}\"/>");
            if (decade.log10().round() as i32).rem_euclid(every) == 0 {
                let (x, y, label) = (left - 6.0, y + 4.0, duration(decade).replace(".0 ", " "));
                let _ = writeln!(svg, "<text x=\"{x}\" y=\"{y:.1}\" text-anchor=\"end\">{label}</text>");
            }
            decade *= 10.0;
        }
        for (value, label) in self.x_ticks.iter().filter(|(value, _)| (x0..=x1).contains(value)) {
            let (x, y) = (x_at(*value), floor + 16.0);
            let _ = writeln!(svg, "<line class=\"grid\" x1=\"{x:.1}\" y1=\"{top}\" x2=\"{x:.1}\" y2=\"{floor}\"/>");
            let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y}\" text-anchor=\"middle\">{label}</text>");
        }
        let _ = writeln!(svg, "<path class=\"axis\" d=\"M{left} {top}V{floor}H{edge}\"/>");
        let (middle, below) = (0.5 * (left + edge), SIZE.1 - 8.0);
        let _ = writeln!(
            svg,
            "<text class=\"name\" x=\"{middle}\" y=\"{below}\" text-anchor=\"middle\">{}</text>\n\
             <text class=\"name\" x=\"4\" y=\"12\">{}</text>",
            self.x_name, self.y_name
        );
        for series in &self.series {
            self.draw(&mut svg, series, [x0, x1, y0, y1], (&x_at, &y_at));
        }
        Some(svg + "</svg>\n")
    }

    fn draw(
        &self,
        svg: &mut String,
        series: &Series,
        [x0, x1, y0, y1]: [f64; 4],
        (x_at, y_at): (&dyn Fn(f64) -> f64, &dyn Fn(f64) -> f64),
    ) {
        let inside =
            |(x, y): &&(f64, f64)| (x0..=x1).contains(x) && (y0 * (1.0 - 1e-9)..=y1 * (1.0 + 1e-9)).contains(y);
        let places: Vec<(f64, f64)> = series.pairs.iter().filter(inside).map(|(x, y)| (x_at(*x), y_at(*y))).collect();
        let colour = series.colour;
        if series.drawn == Drawn::Dots {
            for (x, y) in &places {
                let _ = writeln!(svg, "<circle class=\"dot {colour}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.2\"/>");
            }
            return;
        }
        if places.len() < 2 {
            return;
        }
        let through: Vec<String> = places.iter().map(|(x, y)| format!("{x:.1} {y:.1}")).collect();
        let class = match series.drawn {
            Drawn::Thin => format!("thin {colour}"),
            Drawn::Guide => "guide".to_owned(),
            Drawn::Dashed => format!("line dashed {colour}"),
            _ => format!("line {colour}"),
        };
        let told = if series.drawn == Drawn::Thin && !series.name.is_empty() {
            format!("<title>{}</title>", series.name)
        } else {
            String::new()
        };
        let _ = writeln!(svg, "<path class=\"{class}\" fill=\"none\" d=\"M{}\">{told}</path>", through.join("L"));
        let (x, y) = places[places.len() - 1];
        if series.drawn == Drawn::Guide && !series.name.is_empty() {
            let _ = writeln!(
                svg,
                "<text class=\"guide-name\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                x - 4.0,
                (y - 7.0).max(32.0),
                series.name
            );
        }
    }
}

/// An axis of at least two decades, with a little room at both ends.
fn widened(low: f64, high: f64) -> (f64, f64) {
    let (low, high) = (low / 1.6, high * 1.6);
    let short = (100.0 / (high / low)).max(1.0).sqrt();
    (low / short, high * short)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_a_name_is_taken_for_html() {
        assert_eq!(escaped("a<b> & \"c\" 'd'\u{1}\n"), "a&lt;b&gt; &amp; &quot;c&quot; &#39;d&#39;  ");
    }

    #[test]
    fn times_are_said_as_people_say_them() {
        for (seconds, said) in [
            (3.14e-9, "3.1 ns"),
            (9.996e-7, "1.0 µs"),
            (2.5e-4, "250 µs"),
            (0.0123, "12 ms"),
            (1.0, "1.0 s"),
            (59.9, "1.0 min"),
            (7300.0, "2.0 h"),
            (2.0e5, "2.3 d"),
            (1e9, "32 y"),
            (0.0, "0 s"),
            (f64::INFINITY, "–"),
        ] {
            assert_eq!(duration(seconds), said, "{seconds}");
        }
    }

    #[test]
    fn numbers_keep_two_digits() {
        for (x, said) in [
            (3.12, "3.1"),
            (0.0314, "0.031"),
            (31.4, "31"),
            (314.0, "314"),
            (0.999, "1.0"),
            (1.0, "1.0"),
            (1234.0, "1234"),
            (3.2e7, "3.2·10⁷"),
            (3.2e-8, "3.2·10⁻⁸"),
            (f64::NAN, "–"),
        ] {
            assert_eq!(two_digits(x), said);
        }
        assert_eq!(count(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(count(12), "12");
    }

    #[test]
    fn a_chart_of_nothing_is_none() {
        let empty = Chart { x_name: "N".into(), y_name: "s".into(), x_ticks: vec![], series: vec![] };
        assert!(empty.svg().is_none());
        let pairs = vec![(1.0, 0.0), (f64::NAN, 1.0)];
        let dots = Series { pairs, drawn: Drawn::Dots, colour: "one", name: String::new() };
        assert!(Chart { series: vec![dots], ..empty }.svg().is_none());
    }
}
