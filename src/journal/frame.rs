//! How a journal's file is written: a mark, then frames, each with its length and checksum.
//!
//! ```text
//! file  = "etendue units 1\n" frame*
//! frame = kind (1 byte) · length of the body (8 bytes) · CRC-32 of all that (kind, length, body) (4 bytes) · body
//! kind  = 1 head: JSON, first and once · 2 unit · 3 end: last and once
//! unit  = seconds (8 bytes) · length of the key (2 bytes) · key · payload
//! end   = number of units (8 bytes) · SHA-256 of all bytes of the file before this frame (32 bytes)
//! ```
//!
//! Numbers are little-endian. Keys and payloads are [`postcard`]'s: fixed by the types alone.

use std::io::{self, Read};

use crate::configuration::Sha256;
use crate::trial::{Kept, Unit};

/// What every file begins with. The number rises when a reader of older files would misread newer ones.
pub(super) const MARK: &[u8; 16] = b"etendue units 1\n";
/// Bytes of a frame before its body.
pub(super) const BEFORE: usize = 13;
/// Longest body, bytes: a map of a million texels is a tenth of it.
pub(super) const LONGEST: u64 = 1 << 30;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Head,
    Unit,
    End,
}

impl Kind {
    const ALL: [(Kind, u8); 3] = [(Kind::Head, 1), (Kind::Unit, 2), (Kind::End, 3)];

    fn byte(self) -> u8 {
        Kind::ALL.iter().find(|(kind, _)| *kind == self).map_or(0, |(_, byte)| *byte)
    }
    fn of(byte: u8) -> Option<Kind> {
        Kind::ALL.iter().find(|(_, known)| *known == byte).map(|(kind, _)| *kind)
    }
}

/// A frame, whole, as it is written.
pub(super) fn frame(kind: Kind, body: &[&[u8]]) -> Vec<u8> {
    let length: usize = body.iter().map(|part| part.len()).sum();
    let mut bytes = Vec::with_capacity(BEFORE + length);
    bytes.push(kind.byte());
    bytes.extend((length as u64).to_le_bytes());
    let mut checksum = crc32fast::Hasher::new();
    checksum.update(&bytes);
    body.iter().for_each(|part| checksum.update(part));
    bytes.extend(checksum.finalize().to_le_bytes());
    body.iter().for_each(|part| bytes.extend_from_slice(part));
    bytes
}

/// The frame of a unit.
pub(super) fn unit_frame(unit: &Unit, kept: &Kept) -> Vec<u8> {
    let key = key(unit);
    let length = (key.len() as u16).to_le_bytes();
    frame(Kind::Unit, &[&kept.seconds.to_le_bytes(), &length, &key, &kept.bytes])
}

/// The frame that ends a file.
pub(super) fn end_frame(units: u64, before: Sha256) -> Vec<u8> {
    frame(Kind::End, &[&units.to_le_bytes(), &before.finalize()])
}

fn key(unit: &Unit) -> Vec<u8> {
    postcard::to_allocvec(unit).expect("a key is a few numbers")
}

/// A unit's body, taken apart; `None` if it is none.
pub(super) fn unit_of(body: &[u8]) -> Option<(Unit, f64, &[u8])> {
    let (seconds, rest) = body.split_first_chunk::<8>()?;
    let (length, rest) = rest.split_first_chunk::<2>()?;
    let (key, payload) = rest.split_at_checked(usize::from(u16::from_le_bytes(*length)))?;
    let seconds = Some(f64::from_le_bytes(*seconds)).filter(|seconds| seconds.is_finite() && *seconds >= 0.0)?;
    Some((postcard::from_bytes(key).ok()?, seconds, payload))
}

/// An end's body: units, and the digest of what came before.
pub(super) fn end_of(body: &[u8]) -> Option<(u64, [u8; 32])> {
    let (units, digest) = body.split_first_chunk::<8>()?;
    Some((u64::from_le_bytes(*units), digest.try_into().ok()?))
}

/// Why a frame cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Broken {
    /// The file ends before it does.
    Short,
    /// Its bytes are others than were written.
    Altered,
}

/// One after the other, from a file that is `length` bytes long.
pub(super) struct Frames<R> {
    from: R,
    length: u64,
    /// Where the next frame begins.
    pub at: u64,
    /// Of all that was read.
    pub digest: Sha256,
}

impl<R: Read> Frames<R> {
    /// Reads the mark; `None` if there is another.
    pub fn begin(mut from: R, length: u64) -> io::Result<Option<Frames<R>>> {
        let mut mark = [0; MARK.len()];
        match from.read_exact(&mut mark) {
            Ok(()) if mark == *MARK => {}
            Ok(()) => return Ok(None),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
            Err(error) => return Err(error),
        }
        let mut digest = Sha256::new();
        digest.update(MARK);
        Ok(Some(Frames { from, length, at: MARK.len() as u64, digest }))
    }

    /// The next frame's kind, its body in `body`; `None` at the end of the file. The digest takes in all but an end.
    pub fn next(&mut self, body: &mut Vec<u8>) -> io::Result<Result<Option<Kind>, Broken>> {
        let left = self.length.saturating_sub(self.at);
        if left == 0 {
            return Ok(Ok(None));
        }
        if left < BEFORE as u64 {
            return Ok(Err(Broken::Short));
        }
        let mut before = [0; BEFORE];
        self.from.read_exact(&mut before)?;
        let [byte, rest @ ..] = before;
        let (length, checksum) = rest.split_at(8);
        let length = u64::from_le_bytes(length.try_into().expect("eight bytes"));
        let checksum = u32::from_le_bytes(checksum.try_into().expect("four bytes"));
        let Some(kind) = Kind::of(byte).filter(|_| length <= LONGEST) else { return Ok(Err(Broken::Altered)) };
        // No memory is taken for what is not there.
        if length > left - BEFORE as u64 {
            return Ok(Err(Broken::Short));
        }
        body.resize(length as usize, 0);
        self.from.read_exact(body)?;
        let mut found = crc32fast::Hasher::new();
        found.update(&before[..9]);
        found.update(body);
        if found.finalize() != checksum {
            return Ok(Err(Broken::Altered));
        }
        if kind != Kind::End {
            self.digest.update(&before);
            self.digest.update(body);
        }
        self.at += BEFORE as u64 + length;
        Ok(Ok(Some(kind)))
    }
}
