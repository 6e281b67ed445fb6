//! One set of axes on a page, and a legend beside it.

use super::axis::Axis;
use super::ink::{Align, At, Page};
use super::style::{Colour, Dash, GREY, GRID, INK, Marker, SMALL, TEXT, TITLE};
use super::text::text_width;

/// The page that most plots stand on, points.
pub const WIDTH: f64 = 900.0;
pub const HEIGHT: f64 = 600.0;

/// A page with its title and, below it, what is shown.
pub fn titled_page(title: &str, shown: &str) -> Page {
    let mut page = Page::new(WIDTH, HEIGHT);
    page.title = title.to_owned();
    page.about.push(format!("{shown}."));
    page.bold((24.0, 24.0), fitted(title, TITLE, true), TITLE, INK, Align::Start);
    page.text((24.0, 46.0), fitted(shown, TEXT, false), TEXT, GREY, Align::Start);
    page
}

/// What the marks mean, along the foot of the page, which grows where that takes a second line.
pub fn note(page: &mut Page, words: &str) {
    page.about.push(words.to_owned());
    let fits = |text: &str| text_width(text, SMALL, false) <= WIDTH - 48.0;
    let cut =
        if fits(words) { None } else { words.rmatch_indices(' ').map(|(at, _)| at).find(|at| fits(&words[..*at])) };
    let (first, second) = words.split_at(cut.unwrap_or(words.len()));
    page.text((24.0, page.height - 18.0), first, SMALL, GREY, Align::Start);
    if !second.is_empty() {
        page.height += 15.0;
        page.text((24.0, page.height - 18.0), fitted(second.trim_start(), SMALL, false), SMALL, GREY, Align::Start);
    }
}

/// The text, cut where it would leave the page.
fn fitted(text: &str, size: f64, bold: bool) -> String {
    let room = WIDTH - 48.0;
    if text_width(text, size, bold) <= room {
        return text.to_owned();
    }
    let fits = |kept: &String| text_width(kept, size, bold) + size <= room;
    let mut kept = String::new();
    for c in text.chars() {
        kept.push(c);
        if !fits(&kept) {
            kept.pop();
            break;
        }
    }
    kept + "…"
}

/// Axes on a rectangle of the page.
pub struct Panel {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
    pub x: Axis,
    pub y: Axis,
}

impl Panel {
    /// Where a pair of values lies on the page.
    pub fn at(&self, x: f64, y: f64) -> At {
        (
            self.left + (self.right - self.left) * self.x.share(x),
            self.bottom - (self.bottom - self.top) * self.y.share(y),
        )
    }

    /// Grid, frame, ticks and labels. Draw it before the data.
    pub fn draw(&self, page: &mut Page, x_name: &str, y_name: &str) {
        for (value, _) in &self.x.ticks {
            let (x, _) = self.at(*value, self.y.low());
            page.line(vec![(x, self.top), (x, self.bottom)], GRID, 0.8, Dash::Solid);
        }
        for (value, _) in &self.y.ticks {
            let (_, y) = self.at(self.x.low(), *value);
            page.line(vec![(self.left, y), (self.right, y)], GRID, 0.8, Dash::Solid);
        }
        self.draw_frame(page);
        let mut widest: f64 = 0.0;
        for (value, label) in &self.x.ticks {
            let (x, _) = self.at(*value, self.y.low());
            page.line(vec![(x, self.bottom), (x, self.bottom + 4.0)], INK, 1.0, Dash::Solid);
            page.text((x, self.bottom + 14.0), label.as_str(), SMALL, INK, Align::Middle);
        }
        for (value, label) in &self.y.ticks {
            let (_, y) = self.at(self.x.low(), *value);
            page.line(vec![(self.left - 4.0, y), (self.left, y)], INK, 1.0, Dash::Solid);
            page.text((self.left - 8.0, y), label.as_str(), SMALL, INK, Align::End);
            widest = widest.max(text_width(label, SMALL, false));
        }
        let middle = 0.5 * (self.left + self.right);
        page.text((middle, self.bottom + 34.0), self.x.named(x_name), TEXT, INK, Align::Middle);
        let aside = (self.left - 20.0 - widest).max(14.0);
        let (height, name) = (self.bottom - self.top, self.y.named(y_name));
        let middle = 0.5 * (self.top + self.bottom);
        // A name too long for the axis has its unit on a line of its own.
        match name.rfind(" (").filter(|_| text_width(&name, TEXT, false) > height) {
            Some(cut) => {
                let above = (aside - 16.0).max(12.0);
                page.upwards((above, middle), &name[..cut], TEXT, INK, Align::Middle);
                page.upwards((above + 16.0, middle), &name[cut + 1..], TEXT, INK, Align::Middle);
            }
            None => page.upwards((aside, middle), name, TEXT, INK, Align::Middle),
        }
    }

    /// The left and the lower edge.
    pub fn draw_frame(&self, page: &mut Page) {
        let corner = [(self.left, self.top), (self.left, self.bottom), (self.right, self.bottom)];
        page.line(corner.to_vec(), INK, 1.0, Dash::Solid);
    }

    /// A line through pairs of values.
    pub fn curve(
        &self,
        page: &mut Page,
        pairs: impl IntoIterator<Item = (f64, f64)>,
        colour: Colour,
        width: f64,
        dash: Dash,
    ) {
        page.line(pairs.into_iter().map(|(x, y)| self.at(x, y)).collect(), colour, width, dash);
    }

    /// The area between two curves over the same x.
    pub fn band(&self, page: &mut Page, edges: &[(f64, f64, f64)], colour: Colour, opacity: f64) {
        if edges.len() < 2 {
            return;
        }
        let upper = edges.iter().map(|(x, _, high)| self.at(*x, *high));
        let lower = edges.iter().rev().map(|(x, low, _)| self.at(*x, *low));
        page.area(upper.chain(lower).collect(), colour, opacity);
    }

    /// An interval with caps, moved aside by some points.
    pub fn bar(&self, page: &mut Page, (x, low, high): (f64, f64, f64), aside: f64, cap: f64, colour: Colour) {
        let ((x, bottom), (_, top)) = (self.at(x, low), self.at(x, high));
        let x = x + aside;
        page.line(vec![(x, bottom), (x, top)], colour, 1.3, Dash::Solid);
        if cap > 0.0 {
            for y in [bottom, top] {
                page.line(vec![(x - cap, y), (x + cap, y)], colour, 1.3, Dash::Solid);
            }
        }
    }
}

/// What a legend shows before the words.
#[derive(Clone, Copy, Debug)]
pub enum Key {
    Line {
        colour: Colour,
        width: f64,
        dash: Dash,
        marker: Option<Marker>,
    },
    Bar {
        colour: Colour,
        marker: Marker,
    },
    Area {
        colour: Colour,
        opacity: f64,
    },
    /// A marker on a band with edges.
    Band {
        colour: Colour,
        marker: Marker,
        dash: Dash,
    },
}

impl Key {
    /// With the gap before the words.
    fn width(&self) -> f64 {
        if let Key::Bar { .. } = self { 18.0 } else { 36.0 }
    }
}

/// Distance between entries, points.
const LEGEND_LINE: f64 = 19.0;

fn draw_entry(page: &mut Page, (x, y): At, key: Key, text: &str) {
    page.text((x + key.width(), y), text, SMALL, INK, Align::Start);
    let end = x + key.width() - 8.0;
    let middle = 0.5 * (x + end);
    match key {
        Key::Line { colour, width, dash, marker } => {
            page.line(vec![(x, y), (end, y)], colour, width, dash);
            if let Some(marker) = marker {
                page.marker((middle, y), marker, colour, 3.6);
            }
        }
        Key::Bar { colour, marker } => {
            page.line(vec![(middle, y - 7.0), (middle, y + 7.0)], colour, 1.3, Dash::Solid);
            page.marker((middle, y), marker, colour, 3.4);
        }
        Key::Area { colour, opacity } => page.rectangle((x, y - 5.0), (end, y + 5.0), colour, opacity),
        Key::Band { colour, marker, dash } => {
            page.rectangle((x, y - 6.0), (end, y + 6.0), colour, 0.16);
            for edge in [y - 6.0, y + 6.0] {
                page.line(vec![(x, edge), (end, edge)], colour, 0.9, dash);
            }
            page.marker((middle, y), marker, colour, 3.2);
        }
    }
}

/// How much higher a page must be for a column of so many entries.
pub fn more_than_three(entries: usize) -> f64 {
    LEGEND_LINE * entries.saturating_sub(3) as f64
}

/// Entries one below the other from a place on.
pub fn legend_column(page: &mut Page, (x, y): At, entries: &[(Key, String)]) {
    for (i, (key, text)) in entries.iter().enumerate() {
        draw_entry(page, (x, y + LEGEND_LINE * i as f64), *key, text);
    }
}

/// Entries side by side within a width, in as many rows as it takes; for which the page grows.
pub fn legend_rows(page: &mut Page, (left, top): At, width: f64, entries: &[(Key, String)]) {
    let (mut x, mut y) = (left, top);
    for (key, text) in entries {
        let long = key.width() + text_width(text, SMALL, false) + 22.0;
        if x > left && x + long > left + width {
            (x, y) = (left, y + LEGEND_LINE);
            page.height += if y > top + 1.5 * LEGEND_LINE { LEGEND_LINE } else { 8.0 };
        }
        draw_entry(page, (x, y), *key, text);
        x += long;
    }
}
