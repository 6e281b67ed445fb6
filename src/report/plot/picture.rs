//! Pictures with a palette: plots have few colours, and a third of the bytes then says the same.

use std::collections::HashMap;

type Pixel = [u8; 3];

/// How far a colour may change (root of the sum of squares, of 255) where it covers many pixels, and where it covers
/// but a few.
const UNSEEN: u32 = 20;
const UNSEEN_FEW: u32 = 64;
/// So many are few: shades of edges, scattered over the picture.
const FEW: usize = 500;

/// An RGB picture, `[height][width][3]`, as PNG.
///
/// Up to 256 colours make a palette. Of more, the most frequent do, and the others (shades along the edges of marks)
/// become the nearest of them where nobody can see it; where one could, there is no palette.
pub fn encoded(pixels: &[u8], (width, height): (u32, u32)) -> Result<Vec<u8>, String> {
    let paletted = with_palette(pixels);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_depth(png::BitDepth::Eight);
    let data = match &paletted {
        Some((palette, indices)) => {
            encoder.set_color(png::ColorType::Indexed);
            encoder.set_palette(palette.concat());
            indices.as_slice()
        }
        None => {
            encoder.set_color(png::ColorType::Rgb);
            pixels
        }
    };
    encoder.set_compression(png::Compression::Default);
    encoder.set_filter(png::FilterType::NoFilter);
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer.write_image_data(data).map_err(|e| e.to_string())?;
    writer.finish().map_err(|e| e.to_string())?;
    Ok(bytes)
}

/// The palette, most frequent colour first, and the index of each pixel; `None` where colours would visibly change.
fn with_palette(pixels: &[u8]) -> Option<(Vec<Pixel>, Vec<u8>)> {
    let (pixels, _) = pixels.as_chunks::<3>();
    let mut counts: HashMap<Pixel, usize> = HashMap::new();
    for run in pixels.chunk_by(|a, b| a == b) {
        *counts.entry(run[0]).or_default() += run.len();
    }
    let mut colours: Vec<(Pixel, usize)> = counts.into_iter().collect();
    colours.sort_by_key(|(colour, count)| (usize::MAX - count, *colour));
    let palette: Vec<Pixel> = colours.iter().take(256).map(|(colour, _)| *colour).collect();
    let mut index = HashMap::new();
    for (i, (colour, count)) in colours.iter().enumerate() {
        let unseen = if *count > FEW { UNSEEN } else { UNSEEN_FEW };
        let nearest = if i < palette.len() { i } else { nearest(&palette, *colour, unseen)? };
        index.insert(*colour, nearest as u8);
    }
    let mut indices = Vec::with_capacity(pixels.len());
    for run in pixels.chunk_by(|a, b| a == b) {
        indices.resize(indices.len() + run.len(), index[&run[0]]);
    }
    Some((palette, indices))
}

/// The palette's colour that is closest, if it is close enough.
fn nearest(palette: &[Pixel], colour: Pixel, unseen: u32) -> Option<usize> {
    let distance = |p: &Pixel| -> u32 { p.iter().zip(colour).map(|(a, b)| u32::from(a.abs_diff(b)).pow(2)).sum() };
    let (i, closest) = palette.iter().map(distance).enumerate().min_by_key(|(_, d)| *d)?;
    (closest <= unseen * unseen).then_some(i)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_are_all_kept() {
        let pixels: Vec<u8> = (0..600u32).flat_map(|i| [(i % 200) as u8, 7, 9]).collect();
        let (palette, indices) = with_palette(&pixels).unwrap();
        let (wanted, _) = pixels.as_chunks::<3>();
        assert_eq!(palette.len(), 200);
        assert!(indices.iter().zip(wanted).all(|(i, p)| palette[*i as usize] == *p));
    }

    #[test]
    fn rare_shades_become_the_nearest_frequent_one() {
        let frequent = (0..=255u8).flat_map(|i| [[i, 0, 0], [i, 0, 0]]);
        let rare = [[10u8, 3, 0], [200, 0, 5]];
        let pixels: Vec<u8> = frequent.chain(rare).flatten().collect();
        let (palette, indices) = with_palette(&pixels).unwrap();
        let far = [0u8, 0, 0, 0, 0, 0].into_iter().chain(pixels.iter().copied()).chain([0, 200, 0]);
        assert!(with_palette(&far.collect::<Vec<_>>()).is_none(), "nobody may see a colour change");
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
