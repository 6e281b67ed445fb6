//! Mistakes as people know them from rustc: the sentence, the file's line with the text underlined, and help.

use std::ops::Range;

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};

use super::error::{CaseErrors, Mistake};

/// More lines than this are not underlined together: the first of them stands for all.
const MOST_LINES: usize = 6;

/// Lines that take more bytes together are not drawn: one may be as long as the file, and have many mistakes.
const LONGEST: usize = 10_000;

/// More mistakes than this are counted, not shown.
const MOST_SHOWN: usize = 200;

/// A mark at the start of some files that is no text.
const BYTE_ORDER_MARK: &str = "\u{feff}";

/// How messages are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// Text alone.
    Plain,
    /// With terminal colours.
    Coloured,
}

impl CaseErrors {
    /// The mistakes of the file, one below the other: the first 200, and how many more there are.
    pub fn render(&self, ink: Ink) -> String {
        let renderer = match ink {
            Ink::Plain => Renderer::plain(),
            Ink::Coloured => Renderer::styled(),
        };
        let shown = self.mistakes.iter().take(MOST_SHOWN);
        let mut rendered: Vec<_> = shown.map(|mistake| renderer.render(&[self.group(mistake)])).collect();
        if let more @ 1.. = self.beyond(MOST_SHOWN) {
            let title = Level::ERROR.primary_title(format!("{more} more mistakes in the same file"));
            rendered.push(renderer.render(&[title.element(Origin::path(&*self.path))]));
        }
        rendered.join("\n\n")
    }

    fn group<'a>(&'a self, mistake: &'a Mistake) -> Group<'a> {
        let title = Level::ERROR.primary_title(mistake.error.to_string());
        if self.text.is_empty() {
            return title.element(Origin::path(&*self.path));
        }
        let span = self.shortened(mistake.span());
        let others: Vec<_> = mistake.also.iter().map(|(span, words)| (self.shortened(span.clone()), words)).collect();
        let spans = || others.iter().map(|(span, _)| span).chain([&span]);
        let first = spans().map(|span| span.start).min().unwrap_or(0);
        let last = spans().map(|span| span.end).max().unwrap_or(0);
        // Only the lines at hand go to the renderer: a file of many megabytes stays quick to complain about.
        let mark = if self.text.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len().min(first) } else { 0 };
        let from = self.text[..first].rfind('\n').map_or(mark, |at| at + 1);
        let to = self.text[last..].find('\n').map_or(self.text.len(), |at| last + at);
        if to - from > LONGEST {
            let at = Origin::path(&*self.path).line(mistake.line()).char_column(mistake.column());
            let help = mistake.error.help().into_iter().map(|line| Level::HELP.message(line));
            return title.element(at).elements(help);
        }
        let lines_between = self.text[from..span.start].matches('\n').count();
        let shift = |span: &Range<usize>| span.start - from..span.end - from;
        let snippet = Snippet::source(&self.text[from..to])
            .line_start(mistake.line() - lines_between)
            .path(&*self.path)
            .annotation(AnnotationKind::Primary.span(shift(&span)).label(mistake.error.label()))
            .annotations(
                others.iter().map(|(span, words)| AnnotationKind::Context.span(shift(span)).label(words.as_str())),
            );
        let help = mistake.error.help().into_iter().map(|line| Level::HELP.message(line));
        title.element(snippet).elements(help)
    }

    /// The span, or its first line if it runs over many.
    fn shortened(&self, span: Range<usize>) -> Range<usize> {
        let underlined = &self.text[span.clone()];
        match underlined.find('\n') {
            Some(end) if underlined.matches('\n').count() >= MOST_LINES => span.start..span.start + end,
            _ => span,
        }
    }
}
