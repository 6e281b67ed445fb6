//! Where something stands in a file: path, bytes, line and column.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// A stretch of a file's text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    pub(super) path: Arc<str>,
    pub(super) span: Range<usize>,
    pub(super) line: usize,
    pub(super) column: usize,
}

impl Place {
    /// The file, as it was named (`shipped:` before a case that is part of the program).
    pub fn path(&self) -> &str {
        &self.path
    }
    /// Bytes of the file's text.
    pub fn span(&self) -> Range<usize> {
        self.span.clone()
    }
    /// Counted from 1.
    pub fn line(&self) -> usize {
        self.line
    }
    /// Counted from 1, in characters.
    pub fn column(&self) -> usize {
        self.column
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.path, self.line, self.column)
    }
}

/// Finds places in one file.
pub(super) struct Places<'t> {
    path: Arc<str>,
    text: &'t str,
    line_starts: Vec<usize>,
    /// Characters before every so many bytes: a line may be as long as the file, and have thousands of mistakes.
    counted: Vec<usize>,
}

/// Bytes from one count of characters to the next.
const STRIDE: usize = 1 << 10;

impl<'t> Places<'t> {
    pub(super) fn new(path: &str, text: &'t str) -> Places<'t> {
        let line_starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        let mut so_far = 0;
        let counted = text.as_bytes().chunks(STRIDE).enumerate().map(|(k, chunk)| {
            let before = so_far;
            so_far += columns(text.as_bytes(), k * STRIDE..k * STRIDE + chunk.len());
            before
        });
        Places { path: path.into(), text, line_starts, counted: counted.collect() }
    }

    /// Characters before a byte of the text.
    fn columns_before(&self, byte: usize) -> usize {
        let k = (byte / STRIDE).min(self.counted.len().saturating_sub(1));
        self.counted.get(k).map_or(0, |before| before + columns(self.text.as_bytes(), k * STRIDE..byte))
    }

    /// The line of a byte, counted from 0.
    pub(super) fn line_of(&self, byte: usize) -> usize {
        self.line_starts.partition_point(|start| *start <= byte) - 1
    }

    pub(super) fn place(&self, span: Range<usize>) -> Place {
        let start = floor_boundary(self.text, span.start);
        let end = floor_boundary(self.text, span.end).max(start);
        let line = self.line_of(start);
        let column = self.columns_before(start) - self.columns_before(self.line_starts[line]) + 1;
        Place { path: self.path.clone(), span: start..end, line: line + 1, column }
    }
}

/// Characters that begin in a stretch of UTF-8 text, but for byte order marks.
fn columns(text: &[u8], stretch: Range<usize>) -> usize {
    let begin = text[stretch.clone()].iter().filter(|byte| **byte & 0xc0 != 0x80).count();
    let marks = stretch.filter(|at| text[*at] == 0xef && text[*at..].starts_with("\u{feff}".as_bytes()));
    begin - marks.count()
}

/// The nearest character boundary at or before a byte, within the text.
fn floor_boundary(text: &str, byte: usize) -> usize {
    (0..=byte.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_count_from_one_in_characters() {
        let places = Places::new("a.toml", "a = 1\nµ = 2\r\nc");
        let at = |span| {
            let place = places.place(span);
            (place.line(), place.column())
        };
        assert_eq!(at(0..1), (1, 1));
        assert_eq!(at(4..5), (1, 5));
        assert_eq!(at(9..10), (2, 3), "µ takes two bytes and one column");
        assert_eq!(at(14..15), (3, 1));
        assert_eq!(at(99..120), (3, 2), "beyond the end is the end");
        assert_eq!(places.place(7..8).span(), 6..8, "never inside a character");
        assert_eq!(places.place(0..1).to_string(), "a.toml:1:1");
    }

    #[test]
    fn columns_of_long_lines_are_those_that_one_counts() {
        let text = format!("\u{feff}{}\n{}", "aµ€".repeat(STRIDE), "é".repeat(3 * STRIDE));
        let places = Places::new("a.toml", &text);
        for at in (0..=text.len()).step_by(97).chain([STRIDE, 2 * STRIDE, text.len()]) {
            let place = places.place(at..at);
            let before = &text[..place.span().start];
            let line = before.rfind('\n').map_or(0, |at| at + 1);
            let column = before[line..].chars().filter(|c| *c != '\u{feff}').count() + 1;
            assert_eq!((place.line(), place.column()), (before.matches('\n').count() + 1, column), "byte {at}");
        }
    }
}
