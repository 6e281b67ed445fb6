//! Pictures with a palette: plots have few colours, and a third of the bytes then says the same.

use std::collections::HashMap;

type Pixel = [u8; 3];

/// An RGB picture, `[height][width][3]`, as PNG with at most 256 colours.
///
/// Up to 256 colours all are kept. Of more, the most frequent are kept and the others (shades along the edges of marks)
/// become the nearest of them.
pub fn encoded(pixels: &[u8], (width, height): (u32, u32)) -> Result<Vec<u8>, String> {
    let (palette, indices) = with_palette(pixels);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette.concat());
    encoder.set_compression(png::Compression::Default);
    encoder.set_filter(png::FilterType::NoFilter);
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer.write_image_data(&indices).map_err(|e| e.to_string())?;
    writer.finish().map_err(|e| e.to_string())?;
    Ok(bytes)
}

/// The palette, most frequent colour first, and the index of each pixel.
fn with_palette(pixels: &[u8]) -> (Vec<Pixel>, Vec<u8>) {
    let (pixels, _) = pixels.as_chunks::<3>();
    let mut counts: HashMap<Pixel, usize> = HashMap::new();
    for run in pixels.chunk_by(|a, b| a == b) {
        *counts.entry(run[0]).or_default() += run.len();
    }
    let mut colours: Vec<(Pixel, usize)> = counts.into_iter().collect();
    colours.sort_by_key(|(colour, count)| (usize::MAX - count, *colour));
    let palette: Vec<Pixel> = colours.iter().take(256).map(|(colour, _)| *colour).collect();
    let index: HashMap<Pixel, u8> = colours
        .iter()
        .enumerate()
        .map(|(i, (colour, _))| (*colour, if i < palette.len() { i as u8 } else { nearest(&palette, *colour) }))
        .collect();
    let mut indices = Vec::with_capacity(pixels.len());
    for run in pixels.chunk_by(|a, b| a == b) {
        indices.resize(indices.len() + run.len(), index[&run[0]]);
    }
    (palette, indices)
}

fn nearest(palette: &[Pixel], colour: Pixel) -> u8 {
    let distance =
        |other: &Pixel| -> u32 { other.iter().zip(colour).map(|(a, b)| u32::from(a.abs_diff(b)).pow(2)).sum() };
    let (i, _) = palette.iter().enumerate().min_by_key(|(_, other)| distance(other)).expect("a picture has a colour");
    i as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_are_all_kept() {
        let pixels: Vec<u8> = (0..600u32).flat_map(|i| [(i % 200) as u8, 7, 9]).collect();
        let (palette, indices) = with_palette(&pixels);
        let (wanted, _) = pixels.as_chunks::<3>();
        assert_eq!(palette.len(), 200);
        assert!(indices.iter().zip(wanted).all(|(i, p)| palette[*i as usize] == *p));
    }

    #[test]
    fn rare_shades_become_the_nearest_frequent_one() {
        let frequent = (0..=255u8).flat_map(|i| [[i, 0, 0], [i, 0, 0]]);
        let rare = [[10u8, 3, 0], [200, 0, 5]];
        let pixels: Vec<u8> = frequent.chain(rare).flatten().collect();
        let (palette, indices) = with_palette(&pixels);
        let last: Vec<Pixel> = indices[indices.len() - 2..].iter().map(|i| palette[*i as usize]).collect();
        assert_eq!(last, [[10, 0, 0], [200, 0, 0]]);
    }

    #[test]
    fn a_picture_reads_back() {
        let pixels: Vec<u8> = (0..12u8).collect();
        let bytes = encoded(&pixels, (2, 2)).unwrap();
        let mut decoder = png::Decoder::new(bytes.as_slice());
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let mut read = vec![0; reader.output_buffer_size()];
        reader.next_frame(&mut read).unwrap();
        assert_eq!(read, pixels);
    }
}
