//! Text: the embedded font, how wide its lines are, how its letters run, and how they are set in pixels.

use ab_glyph::{Font, FontRef, OutlineCurve, Point, ScaleFont, point};
use std::fmt::Write as _;
use std::sync::LazyLock;

use super::ink::{Align, At, Words};

const REGULAR: &[u8] = include_bytes!("../../../assets/fonts/DejaVuSans-subset.ttf");
const BOLD: &[u8] = include_bytes!("../../../assets/fonts/DejaVuSans-Bold-subset.ttf");

/// Units of the font to the em: its outlines and widths are whole numbers of them.
pub const UNITS_OF_EM: u16 = 2048;

/// Height of capitals and digits, em.
const CAPITALS: f64 = 0.729;

/// Steps between paper and ink along the edges of letters: few, so that pictures have few colours.
const SHADES: f32 = 10.0;

struct Fonts {
    regular: FontRef<'static>,
    bold: FontRef<'static>,
}

static FONTS: LazyLock<Fonts> = LazyLock::new(|| {
    let read = |bytes| {
        let font = FontRef::try_from_slice(bytes).expect("the embedded font is a font");
        assert_eq!(font.units_per_em(), Some(f32::from(UNITS_OF_EM)), "the embedded font's em");
        font
    };
    Fonts { regular: read(REGULAR), bold: read(BOLD) }
});

fn font(bold: bool) -> &'static FontRef<'static> {
    if bold { &FONTS.bold } else { &FONTS.regular }
}

/// ab_glyph counts a size from the lowest to the highest point of the font, we count in em.
fn height_of_em(font: &FontRef, em: f32) -> f32 {
    em * font.height_unscaled() / f32::from(UNITS_OF_EM)
}

/// Width of a text with letters `size` points to the em, points.
pub fn text_width(text: &str, size: f64, bold: bool) -> f64 {
    let font = font(bold);
    let scaled = font.as_scaled(height_of_em(font, 1.0));
    size * text.chars().map(|c| f64::from(scaled.h_advance(scaled.glyph_id(c)))).sum::<f64>()
}

/// Where a text begins on its base line, points, and its letters with how far along the line each stands, units of the
/// font. The base line lies so that capitals and digits are centred on the text's place.
pub fn set(words: &Words) -> (At, Vec<(char, i64)>) {
    let font = font(words.bold);
    let mut along = 0;
    let mut letters = Vec::with_capacity(words.text.len());
    for letter in words.text.chars() {
        let id = font.glyph_id(letter);
        if font.outline(id).is_some() {
            letters.push((letter, along));
        }
        along += font.h_advance_unscaled(id) as i64;
    }
    let length = words.size * along as f64 / f64::from(UNITS_OF_EM);
    let before = match words.align {
        Align::Start => 0.0,
        Align::Middle => 0.5 * length,
        Align::End => length,
    };
    let below = 0.5 * CAPITALS * words.size;
    let (x, y) = words.at;
    (if words.upwards { (x + below, y + before) } else { (x - before, y + below) }, letters)
}

/// The outline of a letter as the path of an SVG, units of the font, downwards from the base line; empty for a blank.
pub fn outline(letter: char, bold: bool) -> String {
    let font = font(bold);
    let Some(outline) = font.outline(font.glyph_id(letter)) else { return String::new() };
    let mut path = String::new();
    let mut last = None;
    for curve in outline.curves {
        let (OutlineCurve::Line(from, _) | OutlineCurve::Quad(from, ..) | OutlineCurve::Cubic(from, ..)) = curve;
        let mut from = whole(from);
        if last != Some(from) {
            path.push_str(if last.is_some() { "z" } else { "" });
            step(&mut path, 'M', (0, 0), &[from]);
        }
        match curve {
            OutlineCurve::Line(_, to) if whole(to) == from => {}
            OutlineCurve::Line(_, to) if whole(to).0 == from.0 => {
                write!(path, "v{}", whole(to).1 - from.1).expect("writing to memory succeeds");
                from = whole(to);
            }
            OutlineCurve::Line(_, to) if whole(to).1 == from.1 => {
                write!(path, "h{}", whole(to).0 - from.0).expect("writing to memory succeeds");
                from = whole(to);
            }
            OutlineCurve::Line(_, to) => from = step(&mut path, 'l', from, &[whole(to)]),
            OutlineCurve::Quad(_, by, to) => from = step(&mut path, 'q', from, &[whole(by), whole(to)]),
            OutlineCurve::Cubic(_, a, b, to) => from = step(&mut path, 'c', from, &[whole(a), whole(b), whole(to)]),
        }
        last = Some(from);
    }
    path + "z"
}

fn whole(at: Point) -> (i64, i64) {
    (at.x.round() as i64, -at.y.round() as i64)
}

/// Adds a command with its places relative to one; returns the last.
fn step(path: &mut String, command: char, from: (i64, i64), places: &[(i64, i64)]) -> (i64, i64) {
    path.push(command);
    for (x, y) in places {
        for number in [x - from.0, y - from.1] {
            let gap = if number >= 0 && !path.ends_with(command) { " " } else { "" };
            write!(path, "{gap}{number}").expect("writing to memory succeeds");
        }
    }
    places[places.len() - 1]
}

/// Sets texts on an RGB picture, `[height][width][3]`, with `scale` pixels a point.
pub fn set_texts<'a>(pixels: &mut [u8], width: usize, scale: f64, texts: impl Iterator<Item = &'a Words>) {
    for words in texts {
        let font = font(words.bold);
        let em = words.size * scale;
        let height = height_of_em(font, em as f32);
        let scaled = font.as_scaled(height);
        let length = text_width(&words.text, em, words.bold);
        let mut along = match words.align {
            Align::Start => 0.0,
            Align::Middle => -0.5 * length,
            Align::End => -length,
        };
        let origin = (words.at.0 * scale, words.at.1 * scale);
        // The base line lies so that capitals and digits are centred on the place. Whole pixels keep it crisp.
        let below = 0.5 * CAPITALS * em;
        for c in words.text.chars() {
            let id = scaled.glyph_id(c);
            let across = if words.upwards { origin.0 + below } else { origin.1 + below }.round();
            let start = if words.upwards { along } else { origin.0 + along };
            // Along the line in u, downwards from the base line in v.
            let glyph = id.with_scale_and_position(height, point(start as f32, 0.0));
            if let Some(outline) = scaled.outline_glyph(glyph) {
                let bounds = outline.px_bounds();
                outline.draw(|x, y, share| {
                    let u = f64::from(bounds.min.x) + f64::from(x);
                    let v = f64::from(bounds.min.y) + f64::from(y);
                    let (x, y) = if words.upwards { (across + v, origin.1.round() - u) } else { (u, across + v) };
                    blend(pixels, width, (x, y), words.colour, share);
                });
            }
            along += f64::from(scaled.h_advance(id));
        }
    }
}

fn blend(pixels: &mut [u8], width: usize, (x, y): (f64, f64), colour: super::style::Colour, share: f32) {
    if x < 0.0 || y < 0.0 || x >= width as f64 {
        return;
    }
    let first = 3 * (y as usize * width + x as usize);
    let Some(pixel) = pixels.get_mut(first..first + 3) else { return };
    let share = (share.clamp(0.0, 1.0) * SHADES).round() / SHADES;
    for (under, over) in pixel.iter_mut().zip([colour.0, colour.1, colour.2]) {
        let mixed = f32::from(*under) + (f32::from(over) - f32::from(*under)) * share;
        *under = mixed.round() as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_font_has_every_letter_that_plots_use() {
        let used = "W²/m⁴ N 10⁻⁵⁶⁷⁸⁹⁰¹²³ ± − · – … ≤ ≥ ∞ √ ∑ ∫ α λ μ σ π Σ Δ ä é ß ° × ½ ₀₁₂₃ ’ “ ”";
        for bold in [false, true] {
            for c in used.chars().filter(|c| *c != ' ') {
                assert_ne!(font(bold).glyph_id(c).0, 0, "{c} is missing, bold: {bold}");
            }
        }
    }

    #[test]
    fn an_outline_is_the_letters_own() {
        // A stem of 9.8 % of an em that reaches from the base line to the height of capitals.
        assert_eq!(outline('I', false), "M201-1493h202v1493h-202v-1493z");
        assert_eq!(outline('O', false).matches('M').count(), 2, "outside and inside");
        assert_eq!(outline(' ', true), "");
    }

    #[test]
    fn letters_stand_where_the_text_is_aligned() {
        let mut words = Words {
            at: (100.0, 50.0),
            text: "I I".to_owned(),
            size: 20.48,
            bold: false,
            colour: crate::report::plot::style::INK,
            align: Align::Start,
            upwards: false,
        };
        let (start, letters) = set(&words);
        let width = text_width("I I", 20.48, false);
        approx::assert_abs_diff_eq!(start.0, 100.0);
        approx::assert_abs_diff_eq!(start.1, 50.0 + 0.5 * 0.729 * 20.48, epsilon = 1e-9);
        assert_eq!(letters, [('I', 0), ('I', 604 + 651)]);
        words.align = Align::End;
        approx::assert_abs_diff_eq!(set(&words).0.0, 100.0 - width, epsilon = 1e-4);
        words.upwards = true;
        approx::assert_abs_diff_eq!(set(&words).0.1, 50.0 + width, epsilon = 1e-4);
    }

    #[test]
    fn wider_texts_are_wider() {
        assert!(text_width("WW", 10.0, false) > text_width("ii", 10.0, false));
        approx::assert_abs_diff_eq!(text_width("0", 10.0, false), 6.36, epsilon = 0.01);
    }
}
