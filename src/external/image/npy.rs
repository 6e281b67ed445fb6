//! NumPy arrays: [row, column], [image, row, column], either with a last axis of one or three channels.
//!
//! The header is the text of a Python dictionary (numpy.lib.format, versions 1 to 3). What `numpy.save` writes is read, and
//! nothing beyond it.

use std::io::Read;
use std::path::Path;

use super::error::ImageError;
use super::{Sink, grey};
use crate::intake::NPY_HEADER;

/// How one number is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Kind {
    bytes: usize,
    is_little: bool,
}

pub(super) fn read(path: &Path, reader: &mut dyn Read, length: u64, sink: &mut Sink) -> Result<(), ImageError> {
    let broken = |what: String| ImageError::Broken { path: path.to_owned(), what };
    let mut start = [0; 10];
    fill(path, reader, &mut start)?;
    let (header_length, before) = match start[6] {
        1 => (usize::from(u16::from_le_bytes([start[8], start[9]])), 10),
        2 | 3 => {
            let mut rest = [0; 2];
            fill(path, reader, &mut rest)?;
            (u32::from_le_bytes([start[8], start[9], rest[0], rest[1]]) as usize, 12)
        }
        version => return Err(broken(format!("NPY version {version}; 1 to 3 are known"))),
    };
    if header_length as u64 > NPY_HEADER {
        return Err(broken(format!("a header of {header_length} bytes; up to {NPY_HEADER} are accepted")));
    }
    let mut header = vec![0; header_length];
    fill(path, reader, &mut header)?;
    let header = std::str::from_utf8(&header).map_err(|_| broken("the header is no text".to_owned()))?;
    let (kind, shape) = parse(header).map_err(|what| broken(format!("in its header, {what}")))?;
    let shown = || format!("an array {shape:?}");
    let (images, channels) = layout(&shape, sink).ok_or_else(|| sink.size_error(path, shown()))?;
    if images == 0 {
        return Err(broken("there is no image in it".to_owned()));
    }
    sink.room_for(path, images)?;
    // Both factors are bounded by now.
    let due = (images * sink.n_pixels() * channels * kind.bytes) as u64;
    let there = length.saturating_sub((before + header_length) as u64);
    if there != due {
        let how = if there < due { "is cut off" } else { "goes on after its array" };
        return Err(broken(format!("the file {how}: {} needs {due} bytes, {there} are there", shown())));
    }
    sink.is_half |= kind.bytes == 2;
    let mut bytes = vec![0; sink.n_pixels() * channels * kind.bytes];
    for _ in 0..images {
        fill(path, reader, &mut bytes)?;
        let numbers = bytes.chunks_exact(kind.bytes).map(|bytes| kind.number(bytes));
        let image: Vec<f64> = match channels {
            3 => {
                let numbers: Vec<f64> = numbers.collect();
                numbers.as_chunks::<3>().0.iter().map(|rgb| grey(*rgb)).collect()
            }
            _ => numbers.collect(),
        };
        sink.push(path, &image)?;
    }
    Ok(())
}

fn fill(path: &Path, reader: &mut dyn Read, bytes: &mut [u8]) -> Result<(), ImageError> {
    reader.read_exact(bytes).map_err(|source| match source.kind() {
        std::io::ErrorKind::UnexpectedEof => {
            ImageError::Broken { path: path.to_owned(), what: "the file is cut off".to_owned() }
        }
        _ => ImageError::Unreadable { path: path.to_owned(), source },
    })
}

/// Images and channels of an array; `None` where it does not hold images of this size.
fn layout(shape: &[usize], sink: &Sink) -> Option<(usize, usize)> {
    let is_size = |rows: usize, columns: usize| (columns, rows) == (sink.width, sink.height);
    match *shape {
        [rows, columns] if is_size(rows, columns) => Some((1, 1)),
        [images, rows, columns] if is_size(rows, columns) => Some((images, 1)),
        [rows, columns, channels @ (1 | 3)] if is_size(rows, columns) => Some((1, channels)),
        [images, rows, columns, channels @ (1 | 3)] if is_size(rows, columns) => Some((images, channels)),
        _ => None,
    }
}

impl Kind {
    fn of(descr: &str) -> Option<Kind> {
        let (order, kind) = descr.split_at_checked(1)?;
        let is_little = match order {
            "<" => true,
            ">" => false,
            _ => return None,
        };
        let bytes = match kind {
            "f2" => 2,
            "f4" => 4,
            "f8" => 8,
            _ => return None,
        };
        Some(Kind { bytes, is_little })
    }

    /// - `bytes`: as many as the kind has
    fn number(self, bytes: &[u8]) -> f64 {
        let mut whole = [0; 8];
        for (i, byte) in bytes.iter().enumerate() {
            whole[if self.is_little { i } else { self.bytes - 1 - i }] = *byte;
        }
        let bits = u64::from_le_bytes(whole);
        match self.bytes {
            2 => half(bits as u16),
            4 => f64::from(f32::from_bits(bits as u32)),
            _ => f64::from_bits(bits),
        }
    }
}

/// IEEE 754 binary16.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    sign * match exponent {
        0 => fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction / 1024.0) * 2f64.powi(exponent - 15),
    }
}

/// The kind and the shape, of `{'descr': '<f4', 'fortran_order': False, 'shape': (16, 32, 32), }`.
fn parse(header: &str) -> Result<(Kind, Vec<usize>), String> {
    let inside = header.trim().strip_prefix('{').and_then(|rest| rest.strip_suffix('}'));
    let mut rest = inside.ok_or("there is no dictionary")?.trim_start();
    let (mut kind, mut shape, mut is_fortran) = (None, None, None);
    while !rest.is_empty() {
        let (key, after) = quoted(rest).ok_or("a key is missing")?;
        rest = after.trim_start().strip_prefix(':').ok_or("a colon is missing")?.trim_start();
        match key {
            "descr" => {
                let (descr, after) = quoted(rest).ok_or("`descr` is no plain type (an array of records?)")?;
                let known = Kind::of(descr);
                kind = Some(known.ok_or(format!("`descr` is '{descr}'; accepted: f2, f4, f8, with < or >"))?);
                rest = after;
            }
            "fortran_order" => {
                let (value, after) = [("False", false), ("True", true)]
                    .into_iter()
                    .find_map(|(word, value)| Some((value, rest.strip_prefix(word)?)))
                    .ok_or("`fortran_order` is neither True nor False")?;
                is_fortran = Some(value);
                rest = after;
            }
            "shape" => {
                let (inside, after) = rest
                    .strip_prefix('(')
                    .and_then(|rest| rest.split_once(')'))
                    .ok_or("`shape` has no parentheses")?;
                let axes = inside.split(',').map(str::trim).filter(|axis| !axis.is_empty());
                let axes: Result<Vec<usize>, _> = axes.map(str::parse).collect();
                shape = Some(axes.map_err(|_| format!("`shape` is ({inside}); accepted: whole numbers"))?);
                rest = after;
            }
            other => return Err(format!("`{other}` is not known")),
        }
        rest = rest.trim_start();
        rest = rest.strip_prefix(',').unwrap_or(rest).trim_start();
    }
    match (kind, shape, is_fortran) {
        (Some(kind), Some(shape), Some(false)) => Ok((kind, shape)),
        (_, _, Some(true)) => {
            Err("`fortran_order` is True; accepted: rows one after the other (numpy.ascontiguousarray)".to_owned())
        }
        _ => Err("`descr`, `fortran_order` or `shape` is missing".to_owned()),
    }
}

/// What stands between quotes, and what follows.
fn quoted(text: &str) -> Option<(&str, &str)> {
    let mark = text.chars().next().filter(|c| "'\"".contains(*c))?;
    text[1..].split_once(mark)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_what_they_stand_for() {
        for (bits, value) in
            [(0x3c00, 1.0), (0xc000, -2.0), (0x7bff, 65504.0), (0x0001, 2f64.powi(-24)), (0x3555, 0.333_251_953_125)]
        {
            assert_eq!(half(bits), value);
        }
        assert!(half(0x7c00).is_infinite() && half(0x7e00).is_nan());
    }

    #[test]
    fn a_header_is_read_strictly() {
        let read = |text: &str| parse(text).map(|(kind, shape)| (kind.bytes, kind.is_little, shape));
        assert_eq!(
            read("{'descr': '<f4', 'fortran_order': False, 'shape': (3, 2, 2), }  \n"),
            Ok((4, true, vec![3, 2, 2]))
        );
        assert_eq!(read("{\"shape\":(7,),\"fortran_order\":False,\"descr\":\">f8\"}"), Ok((8, false, vec![7])));
        for (text, said) in [
            ("", "no dictionary"),
            ("{'descr': '<i4', 'fortran_order': False, 'shape': (1,)}", "'<i4'"),
            ("{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (1,)}", "plain type"),
            ("{'descr': '<f4', 'fortran_order': True, 'shape': (1,)}", "True"),
            ("{'descr': '<f4', 'fortran_order': False, 'shape': (-1,)}", "(-1,)"),
            ("{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999,)}", "9999"),
            ("{'descr': '<f4', 'fortran_order': False}", "missing"),
            ("{'descr': 'é', 'fortran_order': False}", "'é'"),
            ("{'evil': 1}", "evil"),
            ("{descr: 1}", "key"),
        ] {
            assert!(read(text).unwrap_err().contains(said), "{text}: {:?}", read(text));
        }
    }
}
