//! Portable float maps: `PF` (three channels) or `Pf` (one), width and height, a scale whose sign tells the byte order, then
//! 32-bit rows from the lowest upwards. Numbers are times the scale's size.

use std::io::BufRead;
use std::path::Path;

use super::error::ImageError;
use super::{Sink, grey};
use crate::intake::PFM_WORD;

/// A grey picture as a file of this kind, little-endian.
///
/// - `values`: as many as pixels, row by row from the lowest upwards; rounded to 32 bits
pub fn pfm([width, height]: [usize; 2], values: &[f64]) -> Vec<u8> {
    let mut bytes = format!("Pf\n{width} {height}\n-1.0\n").into_bytes();
    bytes.extend(values.iter().flat_map(|value| (*value as f32).to_le_bytes()));
    bytes
}

pub(super) fn read(path: &Path, reader: &mut dyn BufRead, length: u64, sink: &mut Sink) -> Result<(), ImageError> {
    let broken = |what: String| ImageError::Broken { path: path.to_owned(), what };
    let mut used = 0;
    let mut word = |what: &str| -> Result<String, ImageError> {
        let mut word = String::new();
        loop {
            let mut byte = [0];
            reader.read_exact(&mut byte).map_err(|_| broken(format!("the header is cut off before its {what}")))?;
            used += 1;
            match byte[0] {
                b' ' | b'\t' | b'\r' | b'\n' if word.is_empty() => {}
                b' ' | b'\t' | b'\r' | b'\n' => return Ok(word),
                c if c.is_ascii_graphic() && (word.len() as u64) < PFM_WORD => word.push(char::from(c)),
                _ => return Err(broken(format!("its {what} is no word of a PFM header"))),
            }
        }
    };
    let channels = if word("kind")? == "PF" { 3 } else { 1 };
    let (columns, rows, scale) = (word("width")?, word("height")?, word("scale")?);
    let found = format!("{columns} x {rows} pixels");
    if (columns.parse(), rows.parse()) != (Ok(sink.width), Ok(sink.height)) {
        return Err(sink.size_error(path, found));
    }
    let scale: f64 = scale
        .parse()
        .ok()
        .filter(|scale: &f64| scale.is_finite() && *scale != 0.0)
        .ok_or_else(|| broken(format!("its scale is {scale}; a number other than 0 is accepted")))?;
    sink.room_for(path, 1)?;
    let row_bytes = sink.width * channels * 4;
    let due = (row_bytes * sink.height) as u64;
    let there = length.saturating_sub(used);
    if there != due {
        let how = if there < due { "is cut off" } else { "goes on after its pixels" };
        return Err(broken(format!("the file {how}: {found} need {due} bytes, {there} are there")));
    }
    let mut image = vec![0.0; sink.n_pixels()];
    let mut bytes = vec![0; row_bytes];
    for row in image.chunks_exact_mut(sink.width).rev() {
        reader.read_exact(&mut bytes).map_err(|source| ImageError::Unreadable { path: path.to_owned(), source })?;
        let number = |four: &[u8; 4]| {
            let kept = if scale < 0.0 { f32::from_le_bytes(*four) } else { f32::from_be_bytes(*four) };
            f64::from(kept) * scale.abs()
        };
        let numbers: Vec<f64> = bytes.as_chunks::<4>().0.iter().map(number).collect();
        for (pixel, channels) in row.iter_mut().zip(numbers.chunks_exact(channels)) {
            *pixel = if let [r, g, b] = *channels { grey([r, g, b]) } else { channels[0] };
        }
    }
    sink.push(path, &image)
}
