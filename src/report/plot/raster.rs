//! Pictures on a page: pixels with a scale beside them, and outlines on top.

use super::axis::Axis;
use super::ink::{Align, At, Page};
use super::style::{Colour, Dash, GREY, INK, SMALL, TEXT};
use crate::report::image::{Rgb, Tone};

/// What a value is shown as.
#[derive(Clone, Copy, Debug)]
pub enum Scale {
    /// From black to white.
    Tone(Tone),
    /// From minus to plus this, white in the middle.
    Signed { largest: f64 },
}

/// Nothing is known there.
const UNKNOWN: Rgb = [0xc8, 0xc8, 0xc8];
/// Less is blue, more is orange.
const STOPS: [Rgb; 5] = [[0, 76, 132], [104, 168, 210], [250, 250, 250], [236, 152, 92], [168, 66, 0]];

impl Scale {
    /// The ends of its bar.
    fn ends(&self) -> [f64; 2] {
        match self {
            Scale::Tone(tone) => [0.0, tone.white],
            Scale::Signed { largest } => [-largest, *largest],
        }
    }
    /// What a value is shown as; `None`: not known.
    pub fn colour(&self, value: Option<f64>) -> Rgb {
        let Some(value) = value else { return UNKNOWN };
        match self {
            Scale::Tone(tone) => [tone.level(value); 3],
            Scale::Signed { largest } => {
                let along = (0.5 + 0.5 * value / largest).clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
                let i = (along as usize).min(STOPS.len() - 2);
                let share = along - i as f64;
                std::array::from_fn(|k| {
                    let (a, b) = (f64::from(STOPS[i][k]), f64::from(STOPS[i + 1][k]));
                    (a + (b - a) * share).round() as u8
                })
            }
        }
    }
}

/// A place on the page for a picture.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

impl Frame {
    /// The largest of a shape (width over height) in some room, at its upper left.
    pub fn fitted((left, top): At, (width, height): (f64, f64), shape: f64) -> Frame {
        let width = width.min(height * shape);
        Frame { left, top, width, height: width / shape }
    }
    pub fn right(&self) -> f64 {
        self.left + self.width
    }
    pub fn bottom(&self) -> f64 {
        self.top + self.height
    }
    /// Draws a picture with a thin border.
    pub fn picture(&self, page: &mut Page, columns: usize, colours: Vec<Rgb>) {
        page.raster((self.left, self.top), (self.width, self.height), columns, colours);
        let (l, t, r, b) = (self.left, self.top, self.right(), self.bottom());
        page.line(vec![(l, t), (r, t), (r, b), (l, b), (l, t)], GREY, 0.5, Dash::Solid);
    }
    /// A heading over the picture, and a second line in small letters.
    pub fn heading(&self, page: &mut Page, heading: &str, below: &str) {
        let lines = if below.is_empty() { 12.0 } else { 27.0 };
        page.bold((self.left, self.top - lines), heading, TEXT, INK, Align::Start);
        page.text((self.left, self.top - 11.0), below, SMALL, GREY, Align::Start);
    }
    /// Metres along the lower and the left edge.
    pub fn metres(&self, page: &mut Page, [x, y]: [&Axis; 2], names: [&str; 2]) {
        for (value, label) in &x.ticks {
            let at = self.left + self.width * x.share(*value);
            page.line(vec![(at, self.bottom()), (at, self.bottom() + 4.0)], INK, 1.0, Dash::Solid);
            page.text((at, self.bottom() + 13.0), label.as_str(), SMALL, INK, Align::Middle);
        }
        for (value, label) in &y.ticks {
            let at = self.bottom() - self.height * y.share(*value);
            page.line(vec![(self.left - 4.0, at), (self.left, at)], INK, 1.0, Dash::Solid);
            page.text((self.left - 8.0, at), label.as_str(), SMALL, INK, Align::End);
        }
        let middle = (self.left + 0.5 * self.width, self.top + 0.5 * self.height);
        page.text((middle.0, self.bottom() + 30.0), x.named(names[0]), SMALL, INK, Align::Middle);
        page.upwards((self.left - 46.0, middle.1), y.named(names[1]), SMALL, INK, Align::Middle);
    }
    /// A bar to the right with its unit over it.
    pub fn bar(&self, page: &mut Page, scale: &Scale, unit: &str) {
        const LEVELS: usize = 128;
        let [low, high] = scale.ends();
        let colours = (0..LEVELS).map(|k| {
            let share = 1.0 - (k as f64 + 0.5) / LEVELS as f64;
            scale.colour(Some(low + (high - low) * share))
        });
        let bar = Frame { left: self.right() + 12.0, width: 12.0, ..*self };
        bar.picture(page, 1, colours.collect());
        let axis = Axis::linear(low, high, false, 5);
        for (value, label) in &axis.ticks {
            let at = bar.bottom() - bar.height * axis.share(*value);
            page.line(vec![(bar.right(), at), (bar.right() + 4.0, at)], INK, 1.0, Dash::Solid);
            page.text((bar.right() + 7.0, at), label.as_str(), SMALL, INK, Align::Start);
        }
        page.text((bar.left, self.top - 11.0), axis.unit(unit), SMALL, GREY, Align::Start);
    }
    /// Lines between cells of a grid over the picture that differ in kind, each in the colour that `between` names.
    pub fn outlines<K: PartialEq>(
        &self,
        page: &mut Page,
        [columns, rows]: [usize; 2],
        kind: impl Fn(usize, usize) -> K,
        between: impl Fn(&K, &K) -> Option<Colour>,
    ) {
        let (dx, dy) = (self.width / columns as f64, self.height / rows as f64);
        let at = |i: usize, j: usize| (self.left + dx * i as f64, self.top + dy * j as f64);
        for j in 0..rows {
            for i in 0..columns {
                let own = kind(i, j);
                if i + 1 < columns
                    && let Some(colour) = between(&own, &kind(i + 1, j))
                {
                    page.line(vec![at(i + 1, j), at(i + 1, j + 1)], colour, 1.2, Dash::Solid);
                }
                if j + 1 < rows
                    && let Some(colour) = between(&own, &kind(i, j + 1))
                {
                    page.line(vec![at(i, j + 1), at(i + 1, j + 1)], colour, 1.2, Dash::Solid);
                }
            }
        }
    }
}
