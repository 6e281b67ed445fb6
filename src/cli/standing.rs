//! Where a run stands, in words: as a bar that fits any width, and as a line for a log.

/// How far it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standing<'a> {
    pub done: u64,
    pub all: u64,
    /// What is counted: `cases`.
    pub what: &'a str,
    /// Of the whole, from 0 to 1; counts what is half done, too.
    pub share: f64,
    /// Traced so far, where rays are what takes the time.
    pub rays: Option<u64>,
    /// What is under way.
    pub doing: &'a str,
    pub seconds: f64,
    /// Whether that was all.
    pub ended: bool,
}

/// Before this share and these seconds nothing is said of how long the rest may take.
const TELLING_SHARE: f64 = 0.005;
const TELLING_SECONDS: f64 = 1.0;
/// The bar's own columns, brackets included: at least, and in a wide terminal.
const BARS: [usize; 3] = [10, 20, 32];
/// Shorter than this, a name says nothing.
const SHORTEST_NAME: usize = 8;

impl Standing<'_> {
    /// Seconds that the rest may take, if the rest is as the part before it.
    fn left(&self) -> Option<f64> {
        let known = self.share > TELLING_SHARE && self.seconds > TELLING_SECONDS;
        known.then(|| self.seconds * (1.0 - self.share) / self.share)
    }

    fn rate(&self) -> Option<f64> {
        self.rays.filter(|rays| *rays > 0 && self.seconds > 0.0).map(|rays| rays as f64 / self.seconds)
    }
}

/// One line of less than `columns` columns: what matters least is left out first, and the bar takes what is left over.
pub(super) fn bar(standing: &Standing, columns: usize) -> String {
    // A full line would wrap on some terminals.
    let room = columns.saturating_sub(1);
    let percent = format!("{:>3} %", (100.0 * standing.share.clamp(0.0, 1.0)).floor());
    let left = standing.left().map_or(String::new(), |seconds| format!("{} left", time(seconds)));
    let count = format!("{}/{}", standing.done, standing.all);
    let rate = standing.rate().map_or(String::new(), |rate| format!("{} rays/s", short(rate)));
    // In the order in which they matter; the bar comes third.
    let mut used = 0;
    let mut fits = |columns: usize| {
        let needed = if used == 0 { columns } else { columns + 2 };
        let fits = columns > 0 && used + needed <= room;
        used += if fits { needed } else { 0 };
        fits
    };
    let [has_percent, has_left, has_bar] = [percent.len(), left.len(), BARS[0]].map(&mut fits);
    let [has_count, has_rate] = [count.len(), rate.len()].map(&mut fits);
    let named = if has_rate || rate.is_empty() { room.saturating_sub(used + 2) } else { 0 };
    let doing = if named >= SHORTEST_NAME { cut(standing.doing, named) } else { String::new() };
    let spare = room - used - if doing.is_empty() { 0 } else { columns_of(&doing) + 2 };
    let wide = BARS.into_iter().rev().find(|wide| wide - BARS[0] <= spare).unwrap_or(BARS[0]);
    let drawn = drawn(standing.share, wide);
    let parts = [
        (has_bar, &drawn),
        (has_percent, &percent),
        (has_count, &count),
        (has_rate, &rate),
        (has_left, &left),
        (!doing.is_empty(), &doing),
    ];
    let parts: Vec<&str> = parts.iter().filter(|(has, _)| *has).map(|(_, part)| part.as_str()).collect();
    parts.join("  ")
}

/// `[====>   ]`: letters that every terminal knows, and knows the width of.
fn drawn(share: f64, columns: usize) -> String {
    let inside = columns - 2;
    let full = ((inside as f64 * share.clamp(0.0, 1.0)).floor() as usize).min(inside);
    let head = if full < inside { ">" } else { "" };
    format!("[{}{head}{}]", "=".repeat(full), " ".repeat(inside - full - head.len()))
}

/// `12/52 cases, 4.1e9 rays, 85 million rays/s, about 14 s left`
pub(super) fn plain(standing: &Standing) -> String {
    let mut parts = vec![format!("{}/{} {}", standing.done, standing.all, standing.what)];
    if let Some(rays) = standing.rays {
        parts.push(format!("{} rays", power_of_ten(rays as f64)));
    }
    if let Some(rate) = standing.rate() {
        parts.push(format!("{} rays/s", spelled(rate)));
    }
    match standing.left() {
        _ if standing.ended => parts.push(format!("in {}", time(standing.seconds))),
        Some(left) => parts.push(format!("about {} left", time(left))),
        None => {}
    }
    parts.join(", ")
}

/// `14 s`, `3 min`, `2 h 05 min`: as exact as it is known.
fn time(seconds: f64) -> String {
    let seconds = seconds.max(0.0).round();
    let minutes = (seconds / 60.0).round();
    match seconds {
        ..100.0 => format!("{seconds} s"),
        ..6000.0 => format!("{minutes} min"),
        ..360_000.0 => format!("{} h {:02} min", (minutes / 60.0).floor(), minutes % 60.0),
        _ => format!("{} days", (seconds / 86_400.0).round()),
    }
}

/// Two digits: `4.1e9`; whole below a thousand.
fn power_of_ten(number: f64) -> String {
    if number < 1000.0 { format!("{number}") } else { format!("{number:.1e}") }
}

/// `85 million`
fn spelled(number: f64) -> String {
    let steps = [(1e9, " thousand million"), (1e6, " million"), (1e3, " thousand"), (1.0, "")];
    scaled(number, &steps)
}

/// `85 M`
fn short(number: f64) -> String {
    scaled(number, &[(1e9, " G"), (1e6, " M"), (1e3, " k"), (1.0, "")])
}

fn scaled(number: f64, steps: &[(f64, &str)]) -> String {
    let (unit, name) = steps.iter().find(|(unit, _)| number >= 0.995 * unit).unwrap_or(&steps[steps.len() - 1]);
    let count = number / unit;
    let decimals = usize::from(count < 9.95);
    format!("{count:.decimals$}{name}")
}

/// Columns that a text takes, at most: what is no ASCII may take two.
pub(super) fn columns_of(text: &str) -> usize {
    text.chars().map(|letter| if letter.is_ascii() { 1 } else { 2 }).sum()
}

/// As much of a text as fits, its end told by dots.
fn cut(text: &str, columns: usize) -> String {
    if columns_of(text) <= columns {
        return text.to_owned();
    }
    let mut kept = String::new();
    for letter in text.chars() {
        if columns_of(&kept) + columns_of(letter.encode_utf8(&mut [0; 4])) + 2 > columns {
            break;
        }
        kept.push(letter);
    }
    kept + ".."
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF: Standing = Standing {
        done: 12,
        all: 52,
        what: "cases",
        share: 0.655,
        rays: Some(4_100_000_000),
        doing: "penumbra/eclipse, penumbra/half-plane",
        seconds: 48.2,
        ended: false,
    };

    #[test]
    fn a_bar_says_what_its_width_allows() {
        let due = [
            (
                200,
                "[===================>          ]   65 %  12/52  85 M rays/s  25 s left  penumbra/eclipse, penumbra/half-plane",
            ),
            (80, "[=====>  ]   65 %  12/52  85 M rays/s  25 s left  penumbra/eclipse, penumbra/.."),
            (60, "[=====>  ]   65 %  12/52  85 M rays/s  25 s left  penumbr.."),
            (50, "[=====>  ]   65 %  12/52  85 M rays/s  25 s left"),
            (40, "[=====>  ]   65 %  12/52  25 s left"),
            (30, "[=====>  ]   65 %  25 s left"),
            (20, " 65 %  25 s left"),
            (10, " 65 %"),
            (4, ""),
        ];
        for (columns, line) in due {
            assert_eq!(bar(&HALF, columns), line, "{columns}");
        }
    }

    #[test]
    fn no_bar_is_as_wide_as_its_terminal() {
        let names = [
            "",
            "a",
            "penumbra/eclipse",
            "影/日食, 半影/満ち欠け",
            "a-name-so-long-that-no-terminal-has-room-for-it",
        ];
        for columns in 0..=220 {
            for (k, share) in [0.0, 1e-3, 0.5, 0.999, 1.0, 2.0].into_iter().enumerate() {
                for doing in names {
                    let seconds = [0.0, 3.0, 400.0, 1e5, 1e9, 0.1][k];
                    let all = 10_u64.pow(k as u32);
                    for rays in [None, Some(0), Some(17), Some(u64::MAX)] {
                        let line = bar(&Standing { share, doing, seconds, all, rays, ..HALF }, columns);
                        assert!(columns_of(&line) < columns.max(1), "{columns}: `{line}`");
                        assert!(!line.contains(char::is_control), "{line:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_line_for_a_log_says_it_in_words() {
        assert_eq!(plain(&HALF), "12/52 cases, 4.1e9 rays, 85 million rays/s, about 25 s left");
        let begun = Standing { done: 0, share: 0.0, rays: Some(0), seconds: 0.3, ..HALF };
        assert_eq!(plain(&begun), "0/52 cases, 0 rays");
        let ended = Standing { done: 52, share: 1.0, ended: true, ..HALF };
        assert_eq!(plain(&ended), "52/52 cases, 4.1e9 rays, 85 million rays/s, in 48 s");
    }

    #[test]
    fn times_and_rates_have_the_digits_that_they_deserve() {
        let times = [
            (0.4, "0 s"),
            (99.4, "99 s"),
            (100.0, "2 min"),
            (5990.0, "100 min"),
            (7500.0, "2 h 05 min"),
            (4e5, "5 days"),
        ];
        for (seconds, said) in times {
            assert_eq!(time(seconds), said);
        }
        let rates = [(3.0, "3.0"), (999.0, "1.0 k"), (12_300.0, "12 k"), (8.51e7, "85 M"), (2e9, "2.0 G")];
        for (rate, said) in rates {
            assert_eq!(short(rate), said);
        }
    }
}
