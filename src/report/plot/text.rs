//! Text: the embedded font, how wide its lines are, and how they are set in pixels.
//!
//! plotters sets text at whole pixels and leaves out the room before each letter, which shows; so pictures get their
//! texts from here, on top of what plotters has drawn.

use ab_glyph::{Font, FontRef, ScaleFont, point};
use plotters::style::{FontStyle, register_font};
use std::sync::LazyLock;

use super::ink::{Align, Words};
use super::style::FONT;

const REGULAR: &[u8] = include_bytes!("../../../assets/fonts/DejaVuSans-subset.ttf");
const BOLD: &[u8] = include_bytes!("../../../assets/fonts/DejaVuSans-Bold-subset.ttf");

/// Height of capitals and digits, em.
const CAPITALS: f64 = 0.729;

/// Steps between paper and ink along the edges of letters: few, so that pictures have few colours.
const SHADES: f32 = 10.0;

struct Fonts {
    regular: FontRef<'static>,
    bold: FontRef<'static>,
}

static FONTS: LazyLock<Fonts> = LazyLock::new(|| {
    let read = |bytes| FontRef::try_from_slice(bytes).expect("the embedded font is a font");
    for (style, bytes) in [(FontStyle::Normal, REGULAR), (FontStyle::Bold, BOLD)] {
        assert!(register_font(FONT, style, bytes).is_ok(), "plotters takes the embedded font");
    }
    Fonts { regular: read(REGULAR), bold: read(BOLD) }
});

/// Hands the embedded font to plotters, which lays out texts for SVG with it.
pub fn load_font() {
    LazyLock::force(&FONTS);
}

fn font(bold: bool) -> &'static FontRef<'static> {
    if bold { &FONTS.bold } else { &FONTS.regular }
}

/// ab_glyph counts a size from the lowest to the highest point of the font, we count in em.
fn height_of_em(font: &FontRef, em: f32) -> f32 {
    em * font.height_unscaled() / font.units_per_em().expect("the embedded font has an em")
}

/// Width of a text with letters `size` points to the em, points.
pub fn text_width(text: &str, size: f64, bold: bool) -> f64 {
    let font = font(bold);
    let scaled = font.as_scaled(height_of_em(font, 1.0));
    size * text.chars().map(|c| f64::from(scaled.h_advance(scaled.glyph_id(c)))).sum::<f64>()
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
    fn wider_texts_are_wider() {
        assert!(text_width("WW", 10.0, false) > text_width("ii", 10.0, false));
        approx::assert_abs_diff_eq!(text_width("0", 10.0, false), 6.36, epsilon = 0.01);
    }
}
