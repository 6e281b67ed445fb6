//! Pictures as files: from W/m² to what a screen shows (PNG), and as they are (EXR).

use super::exr;
use crate::eye::{Picture, Pixel};
use crate::light::First;
use crate::trial::ReceiverPicture;

/// An RGB colour, 8 bits each.
pub(super) type Rgb = [u8; 3];

/// Where a ray ends at nothing, and at what sends no light: no light, but colours to tell them from a shadow by.
const NOTHING: Rgb = [26, 26, 30];
const BLACK: Rgb = [40, 54, 78];
/// Beside a receiver.
const BESIDE: Rgb = [236, 236, 236];
/// Of the well-lit pixels, so many are shown without clipping.
const UNCLIPPED: f64 = 0.995;

/// How light becomes a level of grey: the sRGB curve (IEC 61966-2-1) of its share of a white, clipped above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// W/m² that are shown as white.
    pub white: f64,
}

impl Tone {
    /// With a white that all but half a percent of the lit values stay below.
    pub fn of(values: impl Iterator<Item = f64>) -> Tone {
        Tone { white: quantile(values.filter(|value| *value > 0.0), UNCLIPPED).unwrap_or(1.0) }
    }
    /// For a picture: sources may be brighter than its white.
    pub fn of_picture(picture: &Picture) -> Tone {
        let lit = |pixel: &Pixel| pixel.lit.map(|lit| lit.albedo * lit.irradiance());
        let surfaces: Vec<f64> = picture.pixels().iter().filter_map(lit).filter(|value| *value > 0.0).collect();
        if surfaces.is_empty() {
            Tone::of(picture.pixels().iter().map(|pixel| pixel.radiosity))
        } else {
            Tone::of(surfaces.into_iter())
        }
    }
    /// From 0 to 255.
    pub fn level(&self, value: f64) -> u8 {
        let share = (value / self.white).clamp(0.0, 1.0);
        let curved = if share <= 0.003_130_8 { 12.92 * share } else { 1.055 * libm::pow(share, 1.0 / 2.4) - 0.055 };
        (255.0 * curved).round() as u8
    }
    /// How it is told to whoever looks.
    pub fn words(&self) -> String {
        format!("sRGB curve of radiosity over {:.4} W/m2, clipped above", self.white)
    }
}

/// The value that a share of all lie below or at; `None` of none.
pub(super) fn quantile(values: impl Iterator<Item = f64>, share: f64) -> Option<f64> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some(values[(share * last as f64).round() as usize])
}

/// `[height][width]`.
pub(super) fn colours(picture: &Picture, tone: Tone) -> Vec<Rgb> {
    let colour = |pixel: &Pixel| match pixel.first {
        First::Black => BLACK,
        First::Nothing if pixel.lit.is_none() => NOTHING,
        _ => [tone.level(pixel.radiosity); 3],
    };
    picture.pixels().iter().map(colour).collect()
}

/// The same of a receiver square on: what is beside it is paper.
pub(super) fn colours_of_receiver(picture: &Picture, tone: Tone) -> Vec<Rgb> {
    let colour = |pixel: &Pixel| if pixel.lit.is_some() { [tone.level(pixel.radiosity); 3] } else { BESIDE };
    picture.pixels().iter().map(colour).collect()
}

/// A picture with words about it, as PNG.
///
/// - `pixels`: `[height][width]`; `texts`: keyword (Latin-1, below 80 letters) and text
pub(super) fn png(pixels: &[Rgb], [width, height]: [usize; 2], texts: &[(&str, String)]) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::Default);
    encoder.set_adaptive_filter(png::AdaptiveFilterType::Adaptive);
    for (keyword, text) in texts {
        encoder.add_itxt_chunk((*keyword).to_owned(), text.clone()).map_err(|e| e.to_string())?;
    }
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer.write_image_data(pixels.as_flattened()).map_err(|e| e.to_string())?;
    writer.finish().map_err(|e| e.to_string())?;
    Ok(bytes)
}

/// Whether bytes are a whole picture of a page, none of them changed since it was written; why not, in words.
pub(super) fn check(bytes: &[u8]) -> Result<(), String> {
    /// Far more than a view has.
    const PIXELS: u64 = 1 << 24;
    let wrong = |error: png::DecodingError| error.to_string().trim_end_matches('.').to_owned();
    let mut reader = png::Decoder::new(bytes).read_info().map_err(wrong)?;
    let (width, height) = (reader.info().width, reader.info().height);
    if u64::from(width) * u64::from(height) > PIXELS {
        return Err(format!("{width} × {height} pixels; at most {PIXELS} are accepted"));
    }
    let mut content = vec![0; reader.output_buffer_size()];
    reader.next_frame(&mut content).and_then(|_| reader.finish()).map_err(wrong)
}

/// Channels that every picture has: NaN where there is no such thing.
fn of_any(picture: &Picture) -> Vec<(&'static str, Vec<f64>)> {
    let all = |value: &dyn Fn(&Pixel) -> Option<f64>| -> Vec<f64> {
        picture.pixels().iter().map(|pixel| value(pixel).unwrap_or(f64::NAN)).collect()
    };
    vec![
        ("Y", all(&|pixel| Some(pixel.radiosity))),
        ("direct.Y", all(&|pixel| pixel.lit.map(|lit| lit.direct))),
        ("caustic.Y", all(&|pixel| pixel.lit.map(|lit| lit.caustic))),
        ("albedo", all(&|pixel| pixel.lit.map(|lit| lit.albedo))),
    ]
}

/// What the channels are, for the file's `units`.
const UNITS: &str = "Y: radiosity (pi x radiance), W/m2; direct.Y, caustic.Y: irradiance, W/m2; albedo: pure number; NaN: no \
                     scattering surface seen straight";
const UNITS_OF_RECEIVER: &str = "Y: radiosity, W/m2; direct.Y, caustic.Y, irradiance.Y: irradiance, W/m2; exact.Y: exact \
                                 irradiance, W/m2; error.Y: irradiance less exact, W/m2; standard_error.Y: of irradiance, \
                                 W/m2; z: error over standard error; albedo: pure number; NaN: none, or not known";

/// What a camera saw, as EXR.
pub(super) fn exr_of_picture(picture: &Picture, comments: &str) -> Result<Vec<u8>, String> {
    exr::written([picture.width(), picture.height()], of_any(picture), UNITS, comments)
}

/// A receiver with its exact values, as EXR.
pub(super) fn exr_of_receiver(receiver: &ReceiverPicture, comments: &str) -> Result<Vec<u8>, String> {
    let size @ [width, height] = receiver.view.pixels();
    let mut channels = of_any(&receiver.picture);
    let places = || (0..width * height).map(|k| (k % width, k / width));
    let all = |value: &dyn Fn(usize, usize) -> Option<f64>| -> Vec<f64> {
        places().map(|(x, y)| value(x, y).unwrap_or(f64::NAN)).collect()
    };
    let lit = |x: usize, y: usize| receiver.picture.pixel(x, y).lit;
    // Blocks of the stride hold the value of their middle.
    channels.push(("irradiance.Y", all(&|x, y| lit(x, y).map(|lit| lit.irradiance()))));
    channels.push(("exact.Y", all(&|x, y| receiver.due_around(x, y).map(|(_, due)| due.irradiance))));
    channels.push(("error.Y", all(&|x, y| receiver.error_around(x, y))));
    channels.push(("standard_error.Y", all(&|x, y| receiver.std_error[y * width + x])));
    channels.push(("z", all(&|x, y| receiver.z_around(x, y))));
    exr::written(size, channels, UNITS_OF_RECEIVER, comments)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_is_black_and_white_is_white() {
        let tone = Tone { white: 2.0 };
        assert_eq!([-1.0, 0.0, 2.0, 9.0].map(|value| tone.level(value)), [0, 0, 255, 255]);
        // By the curve of IEC 61966-2-1 the level 128 of 255 is linear 0.21586.
        assert_eq!(tone.level(2.0 * 0.215_861), 128);
        let levels: Vec<u8> = (0..=1000).map(|k| tone.level(0.002 * f64::from(k))).collect();
        assert!(levels.is_sorted());
    }

    #[test]
    fn the_white_leaves_out_what_is_rare() {
        let values = (1..=1000).map(f64::from).chain([0.0; 500]).chain([1e9]);
        assert_eq!(Tone::of(values).white, 996.0);
        assert_eq!(Tone::of(std::iter::empty()).white, 1.0);
    }

    #[test]
    fn a_png_reads_back_with_its_words() {
        let pixels: Vec<Rgb> = (0..12u8).map(|k| [k, 2 * k, 255 - k]).collect();
        let bytes = png(&pixels, [4, 3], &[("Tone", "as is, \u{b2}".into())]).unwrap();
        let mut reader = png::Decoder::new(bytes.as_slice()).read_info().unwrap();
        let mut read = vec![0; reader.output_buffer_size()];
        reader.next_frame(&mut read).unwrap();
        assert_eq!(read, pixels.as_flattened());
        let text = &reader.info().utf8_text[0];
        assert_eq!((text.keyword.as_str(), text.get_text().unwrap().as_str()), ("Tone", "as is, \u{b2}"));
    }
}
