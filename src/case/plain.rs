//! Mistakes without `annotate-snippets` (feature `studies`): the sentence, the place, the line underlined, and help.

use super::error::{CaseErrors, Mistake};

/// Lines that take more bytes are not drawn: one may be as long as the file, and have many mistakes.
const LONGEST: usize = 10_000;

/// More mistakes than this are counted, not shown.
const MOST_SHOWN: usize = 200;

/// How messages are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// Text alone.
    Plain,
    /// With terminal colours, where there are any: the slim build has none.
    Coloured,
}

impl CaseErrors {
    /// The mistakes of the file, one below the other: the first 200, and how many more there are.
    pub fn render(&self, _: Ink) -> String {
        let mut rendered: Vec<String> = self.mistakes.iter().take(MOST_SHOWN).map(|m| self.told(m)).collect();
        if let more @ 1.. = self.beyond(MOST_SHOWN) {
            rendered.push(format!("error: {more} more mistakes in the same file\n --> {}", self.path));
        }
        rendered.join("\n\n")
    }

    fn told(&self, mistake: &Mistake) -> String {
        let mut text = format!("error: {}\n --> {}", mistake.error, mistake.place);
        let span = mistake.span();
        let start = self.text[..span.start].rfind('\n').map_or(0, |at| at + 1);
        let line = self.text[start..].lines().next().unwrap_or_default();
        if !line.is_empty() && line.len() <= LONGEST {
            let within = |at: usize| self.text[start..at.min(start + line.len())].chars().count();
            let (from, to) = (within(span.start), within(span.end));
            let marks = "^".repeat((to - from).max(1));
            let (number, label) = (mistake.line().to_string(), mistake.error.label());
            let margin = " ".repeat(number.len());
            text += &format!("\n{margin} |\n{number} | {line}\n{margin} | {}{marks} {label}", " ".repeat(from));
        }
        for (span, words) in &mistake.also {
            let line = self.text[..span.start].matches('\n').count() + 1;
            text += &format!("\n  = line {line}: {words}");
        }
        for help in mistake.error.help() {
            text += &format!("\n  = help: {help}");
        }
        text
    }
}
