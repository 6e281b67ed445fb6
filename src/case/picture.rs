//! Grey values from a PNG picture.

use crate::geometry::TexelGrid;
use crate::intake::TEXELS;
use crate::texture::Encoding;

/// A picture as light from 0 to 1, `[row][column]` from the lowest row upwards.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Picture {
    pub grid: TexelGrid,
    pub values: Vec<f64>,
}

/// Rec. 709 (ITU-R BT.709): luminance of the three primaries.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Reads a picture of 1 to 16 bits, grey or in colours; an opacity channel is left out.
///
/// - returns why not, in words
pub(super) fn read(bytes: &[u8], encoding: Encoding) -> Result<Picture, String> {
    let mut decoder = png::Decoder::new(bytes);
    // Palettes and single bits become bytes; 16 bits stay.
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(|error| error.to_string())?;
    let (width, height) = (reader.info().width, reader.info().height);
    if width == 0 || height == 0 {
        return Err(format!("it is {width} × {height} pixels large"));
    }
    if u64::from(width) * u64::from(height) > TEXELS {
        return Err(format!("{width} × {height} pixels; at most {TEXELS} are accepted"));
    }
    let grid = TexelGrid::new(width as usize, height as usize).map_err(|error| error.to_string())?;
    let mut content = vec![0; reader.output_buffer_size()];
    let frame = reader.next_frame(&mut content).map_err(|error| error.to_string())?;
    let channels = frame.color_type.samples();
    let numbers: Vec<f64> = match frame.bit_depth {
        png::BitDepth::Sixteen => content[..frame.buffer_size()]
            .as_chunks::<2>()
            .0
            .iter()
            .map(|pair| f64::from(u16::from_be_bytes(*pair)) / f64::from(u16::MAX))
            .collect(),
        _ => content[..frame.buffer_size()].iter().map(|byte| f64::from(*byte) / f64::from(u8::MAX)).collect(),
    };
    let light = |pixel: &[f64]| match pixel {
        [red, green, blue, ..] => {
            [red, green, blue].into_iter().zip(LUMINANCE).map(|(x, share)| share * encoding.decode(*x)).sum()
        }
        [grey, ..] => encoding.decode(*grey),
        [] => 0.0,
    };
    let rows = numbers.chunks_exact(channels * width as usize);
    let values: Vec<f64> = rows.rev().flat_map(|row| row.chunks_exact(channels).map(light)).collect();
    if values.len() != grid.n_texels() {
        return Err(format!("{} pixels where {} belong", values.len(), grid.n_texels()));
    }
    Ok(Picture { grid, values })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(width: u32, color: png::ColorType, depth: png::BitDepth, content: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let rows = content.len() as u32 * 8 / (width * color.samples() as u32 * depth as u32);
        let mut encoder = png::Encoder::new(&mut bytes, width, rows);
        encoder.set_color(color);
        encoder.set_depth(depth);
        encoder.write_header().unwrap().write_image_data(content).unwrap();
        bytes
    }

    #[test]
    fn rows_run_upwards_and_bytes_are_shares_of_white() {
        let bytes = written(2, png::ColorType::Grayscale, png::BitDepth::Eight, &[0, 51, 255, 102]);
        let picture = read(&bytes, Encoding::Linear).unwrap();
        assert_eq!(picture.values, [1.0, 0.4, 0.0, 0.2]);
        let decoded = read(&bytes, Encoding::Srgb).unwrap().values;
        assert_eq!(decoded, [1.0, Encoding::Srgb.decode(0.4), 0.0, Encoding::Srgb.decode(0.2)]);
    }

    #[test]
    fn sixteen_bits_and_colours_and_opacity_are_understood() {
        let fine = written(1, png::ColorType::Grayscale, png::BitDepth::Sixteen, &[0x80, 0x01]);
        assert_eq!(read(&fine, Encoding::Linear).unwrap().values, [f64::from(0x8001) / 65535.0]);
        let green = written(1, png::ColorType::Rgba, png::BitDepth::Eight, &[0, 255, 0, 7]);
        assert_eq!(read(&green, Encoding::Linear).unwrap().values, [0.7152]);
        let white = written(1, png::ColorType::Rgb, png::BitDepth::Eight, &[255, 255, 255]);
        approx::assert_abs_diff_eq!(read(&white, Encoding::Srgb).unwrap().values[0], 1.0, epsilon = 1e-15);
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        for bytes in [&b""[..], b"v 0 0 0", b"\x89PNG\r\n\x1a\n"] {
            assert!(read(bytes, Encoding::Linear).is_err());
        }
        let mut bytes = written(2, png::ColorType::Grayscale, png::BitDepth::Eight, &[0, 51, 255, 102]);
        bytes.truncate(bytes.len() - 20);
        assert!(read(&bytes, Encoding::Linear).is_err(), "cut off");
        // A width of nought, its check sum right.
        let mut empty = written(2, png::ColorType::Grayscale, png::BitDepth::Eight, &[0, 51]);
        empty[16..20].fill(0);
        assert!(read(&empty, Encoding::Linear).is_err());
    }
}
