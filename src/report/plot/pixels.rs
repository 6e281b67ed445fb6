//! A page as pixels, with edges as smooth as their share of a pixel makes them; [`text`](super::text) sets its words.

use super::ink::{At, Ink, Page, dashed};
use super::style::{Colour, Marker, PAPER};
use super::text;

/// Pixels for each point of a page.
const SCALE: f64 = 2.0;
/// Lines that are looked along in each row of pixels.
const LINES: i64 = 4;
/// Steps between paper and ink along edges: few, so that pictures have few colours.
const SHADES: usize = 8;
/// Shares of ink are whole numbers of this fraction, two to the power of minus this.
const BITS: i32 = 16;
const HALF: i32 = 1 << (BITS - 1);
/// Corners of a disc.
const CORNERS: usize = 24;

/// The page as RGB, `[height][width][3]`, with its width and height.
pub fn drawn(page: &Page) -> (Vec<u8>, (u32, u32)) {
    let (width, height) = ((page.width * SCALE) as usize, (page.height * SCALE) as usize);
    let mut paper = Paper { pixels: [PAPER.0, PAPER.1, PAPER.2].repeat(width * height), width, height };
    page.inks().iter().for_each(|ink| paper.draw(ink));
    text::set_texts(&mut paper.pixels, width, SCALE, page.texts());
    (paper.pixels, (width as u32, height as u32))
}

/// Corners of an area in pixels. Areas of one mark turn the same way round, so that they unite where they overlap.
type Outline = Vec<At>;

struct Paper {
    pixels: Vec<u8>,
    width: usize,
    height: usize,
}

impl Paper {
    fn draw(&mut self, ink: &Ink) {
        match ink {
            Ink::Line { through, colour, width, dash } => {
                let areas = match dash.lengths() {
                    None => stroke(through, *width),
                    Some(lengths) => {
                        dashed(through, lengths).iter().flat_map(|piece| stroke(piece, *width)).collect()
                    }
                };
                self.fill(&areas, *colour, 1.0);
            }
            Ink::Area { outline, colour, opacity } => {
                let mut area: Outline = outline.iter().map(scaled).collect();
                if is_upright(outline) {
                    // Edges of rectangles are crisp, and neighbours meet.
                    area.iter_mut().for_each(|(x, y)| (*x, *y) = (x.round(), y.round()));
                }
                self.fill(&[area], *colour, *opacity);
            }
            Ink::Marker { at, marker: Marker::Circle, colour, size } => {
                self.fill(&[disc(scaled(at), size * SCALE)], *colour, 1.0);
            }
            Ink::Marker { at, marker, colour, size } => {
                let corners = marker.outline().iter().map(|(x, y)| scaled(&(at.0 + x * size, at.1 + y * size)));
                self.fill(&[corners.collect()], *colour, 1.0);
            }
            Ink::Raster { at, size, columns, colours } => self.copy(*at, *size, *columns, colours),
            Ink::Text(_) => {}
        }
    }

    fn copy(&mut self, at: At, size: (f64, f64), columns: usize, colours: &[[u8; 3]]) {
        let ends = [at, (at.0 + size.0, at.1 + size.1)].map(|at| scaled(&at));
        let [left, top, right, bottom] =
            [ends[0].0, ends[0].1, ends[1].0, ends[1].1].map(|end| end.round().max(0.0) as usize);
        let (width, height) = (right.saturating_sub(left).max(1), bottom.saturating_sub(top).max(1));
        let picture = resampled(columns, colours, [width, height]);
        for (row, y) in picture.chunks_exact(3 * width).zip(top..self.height) {
            let first = 3 * (y * self.width + left.min(self.width));
            let shown = 3 * width.min(self.width - left.min(self.width));
            self.pixels[first..first + shown].copy_from_slice(&row[..shown]);
        }
    }

    /// Fills what lies inside any of the areas.
    fn fill(&mut self, areas: &[Outline], colour: Colour, opacity: f64) {
        // Where their edges cross the lines: the line, how far along it, and which way.
        let mut crossings: Vec<(i64, f64, i32)> = Vec::new();
        let last = self.height as i64 * LINES;
        for area in areas {
            for (from, to) in area.iter().zip(area.iter().cycle().skip(1)) {
                let ((top, bottom), way) = if from.1 < to.1 { ((from, to), 1) } else { ((to, from), -1) };
                let line = |y: f64| ((y * LINES as f64 - 0.5).ceil() as i64).clamp(0, last);
                let along = (bottom.0 - top.0) / (bottom.1 - top.1);
                for line in line(top.1)..line(bottom.1) {
                    let y = (line as f64 + 0.5) / LINES as f64;
                    crossings.push((line, top.0 + (y - top.1) * along, way));
                }
            }
        }
        crossings.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut shares = vec![0.0; self.width];
        let ink = |step: usize| (opacity * step as f64 / SHADES as f64 * f64::from(1 << BITS)).round() as i32;
        let inks: [i32; SHADES + 1] = std::array::from_fn(ink);
        for row in crossings.chunk_by(|a, b| a.0 / LINES == b.0 / LINES) {
            let mut reach = (self.width, 0);
            for line in row.chunk_by(|a, b| a.0 == b.0) {
                let mut winding = 0;
                for ends in line.windows(2) {
                    winding += ends[0].2;
                    if winding != 0 {
                        cover(&mut shares, (ends[0].1, ends[1].1), &mut reach);
                    }
                }
            }
            let y = (row[0].0 / LINES) as usize;
            let (from, to) = (reach.0.min(reach.1), reach.1);
            let pixels = self.pixels[3 * (y * self.width + from)..].chunks_exact_mut(3);
            for (share, pixel) in shares[from..to].iter_mut().zip(pixels) {
                let step = (share.min(1.0) * SHADES as f64 + 0.5) as usize;
                *share = 0.0;
                for (value, ink) in pixel.iter_mut().zip([colour.0, colour.1, colour.2]) {
                    let (under, over) = (i32::from(*value), i32::from(ink));
                    *value = (under + (((over - under) * inks[step] + HALF) >> BITS)) as u8;
                }
            }
        }
    }
}

/// Adds what a piece of a line covers of its pixels; `reach` grows to hold them.
fn cover(shares: &mut [f64], (from, to): (f64, f64), reach: &mut (usize, usize)) {
    let (from, to) = (from.max(0.0), to.min(shares.len() as f64));
    if from >= to {
        return;
    }
    let (first, end) = (from as usize, (to.ceil() as usize).min(shares.len()));
    *reach = (reach.0.min(first), reach.1.max(end));
    for (x, share) in shares.iter_mut().enumerate().take(end).skip(first) {
        *share += (to.min(x as f64 + 1.0) - from.max(x as f64)) / LINES as f64;
    }
}

fn scaled((x, y): &At) -> At {
    (x * SCALE, y * SCALE)
}

/// Whether a line goes along the axes only.
fn is_upright(through: &[At]) -> bool {
    through.windows(2).all(|ends| ends[0].0 == ends[1].0 || ends[0].1 == ends[1].1)
}

fn disc((x, y): At, radius: f64) -> Outline {
    let corner = |k: usize| std::f64::consts::TAU * k as f64 / CORNERS as f64;
    (0..CORNERS).map(|k| (x + radius * libm::sin(corner(k)), y + radius * libm::cos(corner(k)))).collect()
}

fn square((x, y): At, half: f64) -> Outline {
    vec![(x - half, y - half), (x - half, y + half), (x + half, y + half), (x + half, y - half)]
}

/// A line as areas: its straight pieces, and what fills its bends. Upright lines lie on whole pixels.
fn stroke(through: &[At], width: f64) -> Vec<Outline> {
    let is_upright = is_upright(through);
    let width = width * SCALE;
    let width = if is_upright { width.round().max(1.0) } else { width };
    let half = 0.5 * width;
    let middle = if width % 2.0 == 1.0 { 0.5 } else { 0.0 };
    let placed = |at: &At| {
        let (x, y) = scaled(at);
        if is_upright { ((x - middle).round() + middle, (y - middle).round() + middle) } else { (x, y) }
    };
    let places: Vec<At> = through.iter().map(placed).collect();
    let mut areas = Vec::with_capacity(2 * places.len());
    for ends in places.windows(2) {
        let ((ax, ay), (bx, by)) = (ends[0], ends[1]);
        let length = (bx - ax).hypot(by - ay);
        if length > 0.0 {
            let (u, v) = (half * (by - ay) / length, half * (bx - ax) / length);
            areas.push(vec![(ax - u, ay + v), (bx - u, by + v), (bx + u, by - v), (ax + u, ay - v)]);
        }
    }
    let bends = places.iter().skip(1).take(places.len().saturating_sub(2));
    areas.extend(bends.map(|at| if is_upright { square(*at, half) } else { disc(*at, half) }));
    areas
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

#[cfg(test)]
mod tests {
    use super::super::style::Dash;
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

    /// How dark the pixels of a small page are, in sum over a row each.
    fn darkness(page: &Page) -> Vec<f64> {
        let (pixels, (width, _)) = drawn(page);
        let dark = |row: &[u8]| row.iter().map(|value| 1.0 - f64::from(*value) / 255.0).sum::<f64>() / 3.0;
        pixels.chunks_exact(3 * width as usize).map(dark).collect()
    }

    const BLACK: Colour = Colour(0, 0, 0);

    #[test]
    fn ink_covers_the_area_of_its_mark() {
        let mut page = Page::new(20.0, 20.0);
        page.marker((10.2, 9.7), Marker::Circle, BLACK, 5.0);
        let disc: f64 = darkness(&page).iter().sum();
        approx::assert_relative_eq!(disc, std::f64::consts::PI * 100.0, max_relative = 0.02);

        // There and back over the same places is as dark as once: pieces and bends unite. Two pieces of 21.2 by 3 pixels
        // share a square in the bend, a quarter of a disc fills it, half a disc the end where the line turns.
        let mut page = Page::new(30.0, 20.0);
        let (from, bend, to) = ((5.0, 5.0), (12.5, 12.5), (20.0, 5.0));
        page.line(vec![from, bend, to, bend, from], BLACK, 1.5, Dash::Solid);
        let line: f64 = darkness(&page).iter().sum();
        let disc = std::f64::consts::PI * 1.5 * 1.5;
        approx::assert_relative_eq!(line, 2.0 * 450f64.sqrt() * 3.0 - 2.25 + 0.75 * disc, max_relative = 0.02);
    }

    #[test]
    fn upright_lines_and_rectangles_are_crisp() {
        let mut page = Page::new(10.0, 10.0);
        page.line(vec![(1.0, 3.13), (9.0, 3.13)], BLACK, 1.0, Dash::Solid);
        page.rectangle((2.0, 6.07), (4.0, 8.03), BLACK, 1.0);
        let rows = darkness(&page);
        let wanted = |y: usize| {
            if y == 5 || y == 6 {
                16.0
            } else if (12..16).contains(&y) {
                4.0
            } else {
                0.0
            }
        };
        assert_eq!(rows, (0..20).map(wanted).collect::<Vec<_>>());
    }
}
