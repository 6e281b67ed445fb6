//! A page as SVG that looks the same to every reader: letters are outlines, each drawn once and placed wherever it
//! stands. The words lie over them, unseen, so that they can be found, marked and copied.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::ink::{At, Ink, Page, Words};
use super::style::{Colour, Dash, FONT, INK, Marker};
use super::text;
use crate::report::page::escaped;

/// Units for each point of a page: coordinates are whole, and finer than any printer.
const UNITS: f64 = 8.0;

/// The page as SVG.
pub fn svg(page: &Page) -> String {
    let (width, height) = (units(page.width), units(page.height));
    let mut out = format!(
        "<svg width=\"{}\" height=\"{}\" viewBox=\"0 0 {width} {height}\" xmlns=\"http://www.w3.org/2000/svg\" role=\"img\">\n",
        page.width, page.height
    );
    let about = page.about.join(" ");
    writeln!(out, "<title>{}</title>\n<desc>{}</desc>", escaped(&page.title), escaped(&about)).expect(IN_MEMORY);
    letters(&mut out, page);
    writeln!(out, "<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>").expect(IN_MEMORY);
    writeln!(out, "<g stroke-linejoin=\"round\">").expect(IN_MEMORY);
    marks(&mut out, page.inks());
    writeln!(out, "</g>\n<g fill=\"{}\" font-family=\"{FONT}\" font-size=\"{}\">", hex(INK), text::UNITS_OF_EM)
        .expect(IN_MEMORY);
    page.texts().for_each(|words| set(&mut out, words));
    out + "</g>\n</svg>\n"
}

const IN_MEMORY: &str = "writing to memory succeeds";

fn units(points: f64) -> i64 {
    (points * UNITS).round() as i64
}

fn hex(Colour { 0: r, 1: g, 2: b }: Colour) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Every letter of the page, once.
fn letters(out: &mut String, page: &Page) {
    let used: BTreeSet<(bool, char)> =
        page.texts().flat_map(|words| words.text.chars().map(|c| (words.bold, c))).collect();
    out.push_str("<defs>\n");
    for (bold, letter) in used {
        let outline = text::outline(letter, bold);
        if !outline.is_empty() {
            writeln!(out, "<path id=\"{}\" d=\"{outline}\"/>", name(letter, bold)).expect(IN_MEMORY);
        }
    }
    out.push_str("</defs>\n");
}

/// The same letter has the same name in every plot, so that several fit into one page of HTML.
fn name(letter: char, bold: bool) -> String {
    format!("{}{:x}", if bold { 'b' } else { 'r' }, u32::from(letter))
}

fn set(out: &mut String, words: &Words) {
    let ((x, y), letters) = text::set(words);
    let turn = if words.upwards { "rotate(-90)" } else { "" };
    let scale = words.size * UNITS / f64::from(text::UNITS_OF_EM);
    write!(out, "<g transform=\"translate({} {}){turn}scale({:.5})\"", units(x), units(y), scale).expect(IN_MEMORY);
    if words.colour != INK {
        write!(out, " fill=\"{}\"", hex(words.colour)).expect(IN_MEMORY);
    }
    let weight = if words.bold { " font-weight=\"bold\"" } else { "" };
    write!(out, "><text fill=\"none\"{weight}>{}</text>", escaped(&words.text)).expect(IN_MEMORY);
    for (letter, along) in letters {
        write!(out, "<use href=\"#{}\"", name(letter, words.bold)).expect(IN_MEMORY);
        if along > 0 {
            write!(out, " x=\"{along}\"").expect(IN_MEMORY);
        }
        out.push_str("/>");
    }
    out.push_str("</g>\n");
}

/// Lines and markers of one colour that follow one another: their order among themselves cannot be seen, so that those
/// of one kind become one path.
#[derive(Default)]
struct Run {
    colour: Option<Colour>,
    lines: Vec<((i64, Dash), String)>,
    dots: String,
}

impl Run {
    /// Goes on in a colour; what was drawn in another is written.
    fn go_on(&mut self, out: &mut String, colour: Option<Colour>) {
        if self.colour == colour {
            return;
        }
        let run = std::mem::replace(self, Run { colour, ..Run::default() });
        let Some(colour) = run.colour.map(hex) else { return };
        for ((width, dash), d) in run.lines {
            write!(out, "<path fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"").expect(IN_MEMORY);
            if let Some(lengths) = dash.lengths() {
                let lengths: Vec<String> = lengths.iter().map(|length| format!("{}", length * UNITS)).collect();
                write!(out, " stroke-dasharray=\"{}\"", lengths.join(" ")).expect(IN_MEMORY);
            }
            writeln!(out, " d=\"{d}\"/>").expect(IN_MEMORY);
        }
        if !run.dots.is_empty() {
            writeln!(out, "<path fill=\"{colour}\" d=\"{}\"/>", run.dots).expect(IN_MEMORY);
        }
    }

    fn line(&mut self, through: &[At], width: f64, dash: Dash) {
        let style = (units(width).max(1), dash);
        let known = self.lines.iter().position(|(known, _)| *known == style);
        let i = known.unwrap_or_else(|| {
            self.lines.push((style, String::new()));
            self.lines.len() - 1
        });
        path(&mut self.lines[i].1, through.iter().copied());
    }

    fn marker(&mut self, at: At, marker: Marker, size: f64) {
        if marker == Marker::Circle {
            let (x, y, r) = (units(at.0), units(at.1), units(size));
            write!(self.dots, "M{} {y}a{r} {r} 0 1 0 {} 0a{r} {r} 0 1 0 -{} 0z", x - r, 2 * r, 2 * r)
                .expect(IN_MEMORY);
        } else {
            path(&mut self.dots, marker.outline().iter().map(|(x, y)| (at.0 + x * size, at.1 + y * size)));
            self.dots.push('z');
        }
    }
}

/// From place to place; places that fall together count once.
fn path(d: &mut String, through: impl Iterator<Item = At>) {
    let mut last = None;
    for (x, y) in through.map(|(x, y)| (units(x), units(y))) {
        match last {
            None => write!(d, "M{x} {y}"),
            Some(last) if last == (x, y) => continue,
            Some((before, _)) if before == x => write!(d, "V{y}"),
            Some((_, before)) if before == y => write!(d, "H{x}"),
            Some(_) => write!(d, "L{x} {y}"),
        }
        .expect(IN_MEMORY);
        last = Some((x, y));
    }
}

fn marks(out: &mut String, inks: &[Ink]) {
    let mut run = Run::default();
    for ink in inks {
        match ink {
            Ink::Line { through, colour, width, dash } => {
                run.go_on(out, Some(*colour));
                run.line(through, *width, *dash);
            }
            Ink::Marker { at, marker, colour, size } => {
                run.go_on(out, Some(*colour));
                run.marker(*at, *marker, *size);
            }
            Ink::Area { outline, colour, opacity } => {
                run.go_on(out, None);
                write!(out, "<path fill=\"{}\"", hex(*colour)).expect(IN_MEMORY);
                if *opacity < 1.0 {
                    write!(out, " fill-opacity=\"{opacity}\"").expect(IN_MEMORY);
                }
                let mut d = String::new();
                path(&mut d, outline.iter().copied());
                writeln!(out, " d=\"{d}z\"/>").expect(IN_MEMORY);
            }
            Ink::Raster { at, size, columns, colours } => {
                run.go_on(out, None);
                raster(out, *at, *size, *columns, colours);
            }
            Ink::Text(_) => {}
        }
    }
    run.go_on(out, None);
}

/// Cells as areas, neighbours of a row together, all of one colour in one path. Not smoothed: seams would show.
fn raster(out: &mut String, at: At, size: (f64, f64), columns: usize, colours: &[[u8; 3]]) {
    let columns = columns.max(1);
    let rows = colours.len() / columns;
    let x = |i: usize| units(at.0 + size.0 * i as f64 / columns as f64);
    let y = |j: usize| units(at.1 + size.1 * j as f64 / rows as f64);
    let mut by_colour: BTreeMap<[u8; 3], String> = BTreeMap::new();
    for (j, row) in colours.chunks_exact(columns).enumerate() {
        let mut from = 0;
        for cells in row.chunk_by(|a, b| a == b) {
            let to = from + cells.len();
            let d = by_colour.entry(cells[0]).or_default();
            write!(d, "M{} {}H{}V{}H{}z", x(from), y(j), x(to), y(j + 1), x(from)).expect(IN_MEMORY);
            from = to;
        }
    }
    out.push_str("<g shape-rendering=\"crispEdges\">\n");
    for ([r, g, b], d) in by_colour {
        writeln!(out, "<path fill=\"{}\" d=\"{d}\"/>", hex(Colour(r, g, b))).expect(IN_MEMORY);
    }
    out.push_str("</g>\n");
}

#[cfg(test)]
mod tests {
    use super::super::ink::Align;
    use super::super::style::GREY;
    use super::*;

    #[test]
    fn every_letter_is_drawn_once_and_every_word_can_be_found() {
        let mut page = Page::new(100.0, 50.0);
        page.title = "A < B & C".to_owned();
        page.text((10.0, 10.0), "noon & non", 10.0, INK, Align::Start);
        page.bold((10.0, 30.0), "no", 10.0, GREY, Align::Middle);
        let drawn = svg(&page);
        assert_eq!(drawn.matches("id=\"r6e\"").count(), 1, "n, once");
        assert_eq!(drawn.matches("href=\"#r6e\"").count(), 4);
        assert_eq!(drawn.matches("id=\"b6e\"").count(), 1, "and the bold one is another");
        assert!(drawn.contains(">noon &amp; non</text>") && drawn.contains("<title>A &lt; B &amp; C</title>"));
        assert_eq!(drawn.matches("fill=\"none\"").count(), 2, "words are not drawn a second time in a foreign font");
    }

    #[test]
    fn marks_of_one_colour_are_one_path_and_none_moves_past_another_colour() {
        let mut page = Page::new(100.0, 50.0);
        let bar = |x: f64| vec![(x, 10.0), (x, 20.0)];
        page.line(bar(10.0), INK, 1.0, Dash::Solid);
        page.marker((10.0, 15.0), Marker::Square, INK, 2.0);
        page.line(bar(20.0), INK, 1.0, Dash::Solid);
        page.line(bar(20.0), GREY, 1.0, Dash::Dotted);
        page.line(bar(30.0), INK, 1.0, Dash::Solid);
        let drawn = svg(&page);
        let strokes: Vec<&str> = drawn.lines().filter(|line| line.contains("stroke=")).collect();
        assert_eq!(strokes.len(), 3, "{drawn}");
        assert!(strokes[0].contains("d=\"M80 80V160M160 80V160\""), "{}", strokes[0]);
        assert!(strokes[1].contains("stroke-dasharray") && strokes[2].contains("d=\"M240 80V160\""));
    }

    #[test]
    fn cells_of_a_picture_cover_it_without_gaps() {
        let mut page = Page::new(100.0, 50.0);
        page.raster((1.0, 2.0), (8.0, 4.0), 2, vec![[1, 2, 3], [1, 2, 3], [9, 9, 9], [1, 2, 3]]);
        let drawn = svg(&page);
        assert!(drawn.contains("fill=\"#010203\" d=\"M8 16H72V32H8zM40 32H72V48H40z\""), "{drawn}");
        assert!(drawn.contains("fill=\"#090909\" d=\"M8 32H40V48H8z\""), "{drawn}");
    }
}
