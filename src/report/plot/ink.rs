//! Marks on paper: a figure as a list of lines, areas, dots and words in points of a page, drawn as SVG or as pixels.
//! Both show the same marks, so that what is looked at in one is known of the other.

use super::style::{Colour, Dash, Marker};

/// A place on the page: points to the right, points downwards, from the upper left corner.
pub type At = (f64, f64);

/// Where a text stands relative to its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    Start,
    Middle,
    End,
}

/// One mark. Words lie above all others, whenever they are set.
#[derive(Clone, Debug)]
pub enum Ink {
    Line { through: Vec<At>, colour: Colour, width: f64, dash: Dash },
    Area { outline: Vec<At>, colour: Colour, opacity: f64 },
    Marker { at: At, marker: Marker, colour: Colour, size: f64 },
    Text(Words),
    Raster { at: At, size: (f64, f64), columns: usize, colours: Vec<[u8; 3]> },
}

/// A line of text. `at` is the middle of its height; `upwards` turns it by a quarter to the left.
#[derive(Clone, Debug)]
pub struct Words {
    pub at: At,
    pub text: String,
    pub size: f64,
    pub bold: bool,
    pub colour: Colour,
    pub align: Align,
    pub upwards: bool,
}

/// A page and what has been drawn on it so far.
#[derive(Clone, Debug)]
pub struct Page {
    pub width: f64,
    pub height: f64,
    /// What the page shows, for those who hear it read: its name, and sentences about it.
    pub title: String,
    pub about: Vec<String>,
    inks: Vec<Ink>,
}

impl Page {
    pub fn new(width: f64, height: f64) -> Page {
        Page { width, height, title: String::new(), about: Vec::new(), inks: Vec::new() }
    }

    pub fn line(&mut self, through: Vec<At>, colour: Colour, width: f64, dash: Dash) {
        self.inks.push(Ink::Line { through, colour, width, dash });
    }
    pub fn area(&mut self, outline: Vec<At>, colour: Colour, opacity: f64) {
        self.inks.push(Ink::Area { outline, colour, opacity });
    }
    pub fn rectangle(&mut self, (left, top): At, (right, bottom): At, colour: Colour, opacity: f64) {
        self.area(vec![(left, top), (right, top), (right, bottom), (left, bottom)], colour, opacity);
    }
    pub fn marker(&mut self, at: At, marker: Marker, colour: Colour, size: f64) {
        self.inks.push(Ink::Marker { at, marker, colour, size });
    }
    /// A picture, row by row from the top.
    ///
    /// - `colours`: `[rows][columns]`
    pub fn raster(&mut self, at: At, size: (f64, f64), columns: usize, colours: Vec<[u8; 3]>) {
        self.inks.push(Ink::Raster { at, size, columns, colours });
    }
    pub fn text(&mut self, at: At, text: impl Into<String>, size: f64, colour: Colour, align: Align) {
        self.push_text(at, text.into(), size, false, colour, align, false);
    }
    pub fn bold(&mut self, at: At, text: impl Into<String>, size: f64, colour: Colour, align: Align) {
        self.push_text(at, text.into(), size, true, colour, align, false);
    }
    pub fn upwards(&mut self, at: At, text: impl Into<String>, size: f64, colour: Colour, align: Align) {
        self.push_text(at, text.into(), size, false, colour, align, true);
    }
    #[allow(clippy::too_many_arguments)]
    fn push_text(
        &mut self,
        at: At,
        text: String,
        size: f64,
        bold: bool,
        colour: Colour,
        align: Align,
        upwards: bool,
    ) {
        // Control characters have no shape, and an SVG may not hold them.
        let text = text.chars().filter(|c| !c.is_control()).collect();
        self.inks.push(Ink::Text(Words { at, text, size, bold, colour, align, upwards }));
    }

    /// All marks, in the order in which they were set.
    pub fn inks(&self) -> &[Ink] {
        &self.inks
    }
    pub fn texts(&self) -> impl Iterator<Item = &Words> {
        self.inks.iter().filter_map(|ink| if let Ink::Text(words) = ink { Some(words) } else { None })
    }
}

/// The pieces of a line that its dashes leave, each at least two places long.
pub fn dashed(through: &[At], lengths: &[f64]) -> Vec<Vec<At>> {
    let mut pieces = Vec::new();
    let mut turn = 0;
    let mut left = lengths[0];
    let mut piece: Vec<At> = through.first().copied().into_iter().collect();
    for pair in through.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let whole = (b.0 - a.0).hypot(b.1 - a.1);
        let mut gone = 0.0;
        while whole - gone > left {
            gone += left;
            let at = (a.0 + (b.0 - a.0) * gone / whole, a.1 + (b.1 - a.1) * gone / whole);
            if turn % 2 == 0 {
                piece.push(at);
                pieces.push(std::mem::take(&mut piece));
            } else {
                piece = vec![at];
            }
            turn += 1;
            left = lengths[turn % lengths.len()];
        }
        left -= whole - gone;
        if turn % 2 == 0 {
            piece.push(b);
        }
    }
    if piece.len() > 1 {
        pieces.push(piece);
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_leave_the_stated_share_of_a_line() {
        let through = [(0.0, 0.0), (10.0, 0.0), (10.0, 17.0)];
        let pieces = dashed(&through, &[4.0, 2.0]);
        let length = |p: &Vec<At>| p.windows(2).map(|w| (w[1].0 - w[0].0).hypot(w[1].1 - w[0].1)).sum::<f64>();
        let drawn: f64 = pieces.iter().map(length).sum();
        // 27 = 4 full periods of 6 and a rest of 3, all of it dash.
        approx::assert_abs_diff_eq!(drawn, 4.0 * 4.0 + 3.0, epsilon = 1e-12);
        assert_eq!(pieces.len(), 5);
    }
}
