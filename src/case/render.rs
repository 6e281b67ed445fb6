//! Mistakes as people know them from rustc: the sentence, the file's line with the text underlined, and help.

use std::ops::Range;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

use super::error::{CaseErrors, Mistake};

/// More lines than this are not underlined together: the first of them stands for all.
const MOST_LINES: usize = 6;

/// How messages are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// Text alone.
    Plain,
    /// With terminal colours.
    Coloured,
}

impl CaseErrors {
    /// All mistakes of the file, one below the other.
    pub fn render(&self, ink: Ink) -> String {
        let renderer = match ink {
            Ink::Plain => Renderer::plain(),
            Ink::Coloured => Renderer::styled(),
        };
        let rendered = self.mistakes.iter().map(|mistake| renderer.render(&[self.group(mistake)]));
        rendered.collect::<Vec<_>>().join("\n\n")
    }

    fn group<'a>(&'a self, mistake: &'a Mistake) -> Group<'a> {
        let title = Level::ERROR.primary_title(mistake.error.to_string());
        let span = self.shortened(mistake.span());
        let others: Vec<_> = mistake.also.iter().map(|(span, words)| (self.shortened(span.clone()), words)).collect();
        let spans = || others.iter().map(|(span, _)| span).chain([&span]);
        let first = spans().map(|span| span.start).min().unwrap_or(0);
        let last = spans().map(|span| span.end).max().unwrap_or(0);
        // Only the lines at hand go to the renderer: a file of many megabytes stays quick to complain about.
        let from = self.text[..first].rfind('\n').map_or(0, |at| at + 1);
        let to = self.text[last..].find('\n').map_or(self.text.len(), |at| last + at);
        let line = self.text[..from].matches('\n').count() + 1;
        let shift = |span: &Range<usize>| span.start - from..span.end - from;
        let snippet = Snippet::source(&self.text[from..to])
            .line_start(line)
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
