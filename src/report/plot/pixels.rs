//! A page as pixels: plotters draws its lines and areas, [`text`](super::text) its words.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::ink::{At, Ink, Page, dashed};
use super::style::{Colour, Marker};
use super::text;

/// Pixels for each point of a page.
const SCALE: f64 = 2.0;

/// The page as RGB, `[height][width][3]`, with its width and height.
pub fn drawn(page: &Page) -> Result<(Vec<u8>, (u32, u32)), String> {
    let size = ((page.width * SCALE) as u32, (page.height * SCALE) as u32);
    let mut pixels = vec![0; 3 * (size.0 * size.1) as usize];
    draw(page, &BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area()).map_err(|e| e.to_string())?;
    text::set_texts(&mut pixels, size.0 as usize, SCALE, page.texts());
    Ok((pixels, size))
}

type Paper<'a> = DrawingArea<BitMapBackend<'a>, Shift>;
type Drawn<'a> = Result<(), DrawingAreaErrorKind<<BitMapBackend<'a> as DrawingBackend>::ErrorType>>;

fn device((x, y): At) -> (i32, i32) {
    ((x * SCALE).round() as i32, (y * SCALE).round() as i32)
}

fn draw<'a>(page: &Page, paper: &Paper<'a>) -> Drawn<'a> {
    let devices = |points: &[At]| points.iter().map(|p| device(*p)).collect::<Vec<_>>();
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
                paper.draw(&Circle::new(device(*at), (size * SCALE).round() as i32, colour.filled()))?;
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
    let style = colour.stroke_width((width * SCALE).round().max(1.0) as u32);
    through
        .windows(2)
        .map(|ends| [device(ends[0]), device(ends[1])])
        .filter(|[from, to]| from != to)
        .try_for_each(|ends| paper.draw(&PathElement::new(ends, style)))
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
