//! Marks on paper: a figure as a list of lines, areas, dots and words in points of a page, drawn by plotters as SVG or
//! as pixels. Both show the same marks, so that what is looked at in one is known of the other.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::style::{Colour, Dash, FONT, Marker};

/// A place on the page: points to the right, points downwards, from the upper left corner.
pub type At = (f64, f64);

/// Where a text stands relative to its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    Start,
    Middle,
    End,
}

/// What a page is drawn on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Medium {
    Svg,
    /// Without texts, which are set better by our own means.
    Pixels,
}

#[derive(Clone, Debug)]
enum Ink {
    Line { through: Vec<At>, colour: Colour, width: f64 },
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
    inks: Vec<Ink>,
}

impl Page {
    pub fn new(width: f64, height: f64) -> Page {
        Page { width, height, inks: Vec::new() }
    }

    pub fn line(&mut self, through: Vec<At>, colour: Colour, width: f64, dash: Dash) {
        match dash.lengths() {
            None => self.inks.push(Ink::Line { through, colour, width }),
            Some(lengths) => {
                let pieces = dashed(&through, lengths);
                self.inks.extend(pieces.into_iter().map(|through| Ink::Line { through, colour, width }));
            }
        }
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
    /// A picture, row by row from the top. Only where pixels are drawn: an SVG leaves it out.
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

    pub fn texts(&self) -> impl Iterator<Item = &Words> {
        self.inks.iter().filter_map(|ink| if let Ink::Text(words) = ink { Some(words) } else { None })
    }

    /// Draws the page with `scale` device units a point.
    pub fn draw<DB>(&self, area: &DrawingArea<DB, Shift>, scale: f64, medium: Medium) -> Result<(), String>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let device = |(x, y): At| ((x * scale).round() as i32, (y * scale).round() as i32);
        let devices = |points: &[At]| points.iter().map(|p| device(*p)).collect::<Vec<_>>();
        let stroke = |width: f64| (width * scale).round().max(1.0) as u32;
        area.fill(&WHITE).map_err(|e| e.to_string())?;
        for ink in &self.inks {
            match ink {
                Ink::Line { through, colour, width } => {
                    let style = colour.stroke_width(stroke(*width));
                    match medium {
                        Medium::Svg => area.draw(&PathElement::new(devices(through), style)),
                        // Piece by piece: where a line turns sharply, plotters' joints grow into spikes.
                        Medium::Pixels => devices(through)
                            .windows(2)
                            .filter(|ends| ends[0] != ends[1])
                            .try_for_each(|ends| area.draw(&PathElement::new(ends, style))),
                    }
                }
                Ink::Area { outline, colour, opacity } => {
                    area.draw(&Polygon::new(devices(outline), colour.mix(*opacity).filled()))
                }
                Ink::Marker { at, marker: Marker::Circle, colour, size } => {
                    area.draw(&Circle::new(device(*at), (size * scale).round() as i32, colour.filled()))
                }
                Ink::Marker { at, marker, colour, size } => {
                    let outline: Vec<At> =
                        marker.outline().iter().map(|(x, y)| (at.0 + x * size, at.1 + y * size)).collect();
                    area.draw(&Polygon::new(devices(&outline), colour.filled()))
                }
                Ink::Raster { .. } if medium == Medium::Svg => Ok(()),
                Ink::Raster { at, size, columns, colours } => {
                    let ((left, top), (right, bottom)) = (device(*at), device((at.0 + size.0, at.1 + size.1)));
                    let (width, height) = ((right - left).max(1) as usize, (bottom - top).max(1) as usize);
                    let pixels = resampled(*columns, colours, [width, height]);
                    match BitMapElement::with_owned_buffer((left, top), (width as u32, height as u32), pixels) {
                        Some(picture) => area.draw(&picture),
                        None => Ok(()),
                    }
                }
                Ink::Text(_) if medium == Medium::Pixels => Ok(()),
                Ink::Text(Words { at, text, size, bold, colour, align, upwards }) => {
                    let h = match align {
                        Align::Start => HPos::Left,
                        Align::Middle => HPos::Center,
                        Align::End => HPos::Right,
                    };
                    let style = if *bold { FontStyle::Bold } else { FontStyle::Normal };
                    let font = FontDesc::new(FontFamily::Name(FONT), size * scale * EM, style);
                    let font = if *upwards { font.transform(FontTransform::Rotate270) } else { font };
                    let style = TextStyle::from(font).color(colour).pos(Pos::new(h, VPos::Center));
                    area.draw(&Text::new(text.as_str(), device(*at), style))
                }
            }
            .map_err(|e| e.to_string())?;
        }
        area.present().map_err(|e| e.to_string())
    }
}

/// A picture of other pixels: each the mean of those that it covers, or a copy of the one that it lies in.
fn resampled(columns: usize, colours: &[[u8; 3]], [width, height]: [usize; 2]) -> Vec<u8> {
    let rows = colours.len() / columns.max(1);
    let span = |k: usize, n: usize, of: usize| {
        let first = (k * of / n).min(of.saturating_sub(1));
        first..((k + 1) * of / n).max(first + 1).min(of)
    };
    let mut pixels = Vec::with_capacity(3 * width * height);
    for y in 0..height {
        for x in 0..width {
            let mut sum = [0u32; 3];
            let mut n = 0;
            for j in span(y, height, rows) {
                for i in span(x, width, columns) {
                    sum.iter_mut().zip(colours[j * columns + i]).for_each(|(sum, value)| *sum += u32::from(value));
                    n += 1;
                }
            }
            pixels.extend(sum.map(|sum| ((sum + n / 2) / n.max(1)) as u8));
        }
    }
    pixels
}

/// plotters counts a font's size in line heights of this many em.
const EM: f64 = 1.24;

/// The pieces of a line that its dashes leave, each at least two places long.
fn dashed(through: &[At], lengths: &[f64]) -> Vec<Vec<At>> {
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
    fn a_picture_of_other_pixels_shows_the_same() {
        let colours = [[0, 10, 20], [100, 110, 120], [200, 210, 220], [50, 60, 70]];
        assert_eq!(resampled(2, &colours, [2, 2]), colours.as_flattened());
        let twice = resampled(2, &colours, [4, 4]);
        assert_eq!(
            (&twice[..3], &twice[3..6], &twice[6..9]),
            (&[0, 10, 20][..], &[0, 10, 20][..], &[100, 110, 120][..])
        );
        assert_eq!(resampled(2, &colours, [1, 1]), [88, 98, 108]);
    }

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
