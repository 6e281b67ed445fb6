//! A page as pixels: plotters draws its lines and areas, [`text`](super::text) its words.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::ink::{At, Ink, Page, dashed};
use super::style::{Colour, Marker};
use super::text;

/// Pixels for each point of a page.
const SCALE: f64 = 2.0;
/// Areas are drawn on a grid so much finer and averaged: edges come out smooth.
const FINER: usize = 2;

/// The page as RGB, `[height][width][3]`, with its width and height.
pub fn drawn(page: &Page) -> Result<(Vec<u8>, (u32, u32)), String> {
    let size = ((page.width * SCALE) as u32, (page.height * SCALE) as u32);
    let finer = (size.0 * FINER as u32, size.1 * FINER as u32);
    let mut drawn = vec![0; 3 * finer.0 as usize * finer.1 as usize];
    draw(page, &BitMapBackend::with_buffer(&mut drawn, finer).into_drawing_area()).map_err(|e| e.to_string())?;
    let mut pixels = averaged(&drawn, size.0 as usize);
    text::set_texts(&mut pixels, size.0 as usize, SCALE, page.texts());
    Ok((pixels, size))
}

type Paper<'a> = DrawingArea<BitMapBackend<'a>, Shift>;
type Drawn<'a> = Result<(), DrawingAreaErrorKind<<BitMapBackend<'a> as DrawingBackend>::ErrorType>>;

/// Each pixel the mean of the finer ones in its place.
///
/// - `width`: of the coarse picture, pixels
fn averaged(drawn: &[u8], width: usize) -> Vec<u8> {
    const SHARE: u32 = (FINER * FINER) as u32;
    let row = 3 * width * FINER;
    let mut pixels = Vec::with_capacity(drawn.len() / SHARE as usize);
    for rows in drawn.chunks_exact(row * FINER) {
        for x in 0..width {
            for k in 0..3 {
                let places = (0..FINER * FINER).map(|i| (i / FINER) * row + 3 * (x * FINER + i % FINER) + k);
                let sum: u32 = places.map(|place| u32::from(rows[place])).sum();
                pixels.push(((sum + SHARE / 2) / SHARE) as u8);
            }
        }
    }
    pixels
}

const FINE: f64 = SCALE * FINER as f64;

fn device((x, y): At) -> (i32, i32) {
    ((x * FINE).round() as i32, (y * FINE).round() as i32)
}

/// The corners on the finer grid; what goes along the axes only lies on whole pixels, and is crisp.
fn devices(through: &[At]) -> Vec<(i32, i32)> {
    let is_upright = through.windows(2).all(|ends| ends[0].0 == ends[1].0 || ends[0].1 == ends[1].1);
    let whole = |v: f64| (v * SCALE).round() as i32 * FINER as i32;
    through.iter().map(|at| if is_upright { (whole(at.0), whole(at.1)) } else { device(*at) }).collect()
}

fn draw<'a>(page: &Page, paper: &Paper<'a>) -> Drawn<'a> {
    paper.fill(&WHITE)?;
    for ink in page.inks() {
        match ink {
            Ink::Line { through, colour, width, dash } => match dash.lengths() {
                None => line(paper, through, *colour, *width)?,
                Some(lengths) => {
                    dashed(through, lengths).iter().try_for_each(|piece| line(paper, piece, *colour, *width))?
                }
            },
            Ink::Area { outline, colour, opacity } => {
                paper.draw(&Polygon::new(devices(outline), colour.mix(*opacity).filled()))?;
            }
            Ink::Marker { at, marker: Marker::Circle, colour, size } => {
                paper.draw(&Circle::new(device(*at), (size * FINE).round() as i32, colour.filled()))?;
            }
            Ink::Marker { at, marker, colour, size } => {
                let outline: Vec<At> =
                    marker.outline().iter().map(|(x, y)| (at.0 + x * size, at.1 + y * size)).collect();
                paper.draw(&Polygon::new(devices(&outline), colour.filled()))?;
            }
            Ink::Raster { at, size, columns, colours } => {
                let ((left, top), (right, bottom)) = (device(*at), device((at.0 + size.0, at.1 + size.1)));
                let (width, height) = ((right - left).max(1) as usize, (bottom - top).max(1) as usize);
                let pixels = resampled(*columns, colours, [width, height]);
                if let Some(picture) =
                    BitMapElement::with_owned_buffer((left, top), (width as u32, height as u32), pixels)
                {
                    paper.draw(&picture)?;
                }
            }
            Ink::Text(_) => {}
        }
    }
    paper.present()
}

/// Piece by piece: where a line turns sharply, plotters' joints grow into spikes.
fn line<'a>(paper: &Paper<'a>, through: &[At], colour: Colour, width: f64) -> Drawn<'a> {
    let style = colour.stroke_width((width * FINE).round().max(1.0) as u32);
    let through = devices(through);
    let pieces = through.windows(2).filter(|ends| ends[0] != ends[1]);
    pieces.map(|ends| [ends[0], ends[1]]).try_for_each(|ends| paper.draw(&PathElement::new(ends, style)))
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
    use super::*;

    #[test]
    fn ink_covers_the_area_of_its_mark() {
        let mut page = Page::new(20.0, 20.0);
        page.marker((10.2, 9.7), Marker::Circle, Colour(0, 0, 0), 5.0);
        let (pixels, _) = drawn(&page).unwrap();
        let dark: f64 = pixels.iter().map(|value| 1.0 - f64::from(*value) / 255.0).sum::<f64>() / 3.0;
        // In pixels, of which two are a point.
        approx::assert_relative_eq!(dark, std::f64::consts::PI * 100.0, max_relative = 0.05);
        assert!(pixels.iter().any(|value| (1..255).contains(value)), "its edge is smooth");
    }

    #[test]
    fn upright_rectangles_are_crisp() {
        let mut page = Page::new(10.0, 10.0);
        page.rectangle((2.1, 6.07), (4.1, 8.03), Colour(0, 0, 0), 1.0);
        let (pixels, _) = drawn(&page).unwrap();
        assert!(pixels.iter().all(|value| *value == 0 || *value == 255));
    }

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
}
