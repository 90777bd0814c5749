//! Changes to a RON text that touch nothing but the values that change.

use crate::ui::editor::spans::{Entry, Kind, Node, Sequence, SpanFault};
use std::ops::Range;

/// A text and where its values are.
#[derive(Clone, Debug)]
pub(super) struct Patcher {
    text: String,
    root: Node,
}

impl Patcher {
    pub fn new(text: String) -> Result<Self, SpanFault> {
        let root = Node::parse(&text)?;
        Ok(Self { text, root })
    }

    pub fn text(&self) -> &str {
        &self.text
    }
    pub fn into_text(self) -> String {
        self.text
    }
    pub fn root(&self) -> &Node {
        &self.root
    }
    pub fn get<'a>(&'a self, node: &'a Node, name: &str) -> Option<&'a Node> {
        node.get(&self.text, name)
    }
    pub fn str(&self, node: &Node) -> &str {
        &self.text[node.span.clone()]
    }

    fn replace(&mut self, range: Range<usize>, with: &str) -> Result<(), SpanFault> {
        self.text.replace_range(range, with);
        self.root = Node::parse(&self.text)?;
        Ok(())
    }

    /// Writes a number over a scalar; one that already reads as this number keeps its spelling.
    pub fn set_number(&mut self, at: &Node, value: f64, decimals: i32) -> Result<(), SpanFault> {
        // `Some(x)` holds its number one deeper.
        let inner = at.at(0).filter(|_| self.str(at).starts_with("Some"));
        let at = inner.unwrap_or(at).span.clone();
        let text = number(value, decimals);
        if self.text[at.clone()].parse::<f64>().is_ok_and(|old| number(old, decimals) == text) {
            return Ok(());
        }
        self.replace(at, &text)
    }

    /// Writes a word over a scalar.
    pub fn set_word(&mut self, at: &Node, word: &str) -> Result<(), SpanFault> {
        if self.str(at) == word { Ok(()) } else { self.replace(at.span.clone(), word) }
    }

    /// Adds an entry at the end: on a line of its own where the last one is, else after it.
    pub fn add_entry(&mut self, to: &Node, entry: &str) -> Result<(), SpanFault> {
        let Some(sequence) = to.sequence() else {
            return Err(SpanFault { at: to.span.start, reason: "no brackets to add to" });
        };
        let Some(last) = sequence.entries.last() else {
            let open = sequence.open;
            return self.replace(open..open, entry);
        };
        let line = self.text[..last.start()].rfind('\n').map_or(0, |n| n + 1);
        let indent = &self.text[line..last.start()];
        let own_line = indent.bytes().all(|c| c == b' ' || c == b'\t');
        let gap = if own_line { format!("\n{indent}") } else { " ".to_owned() };
        match last.comma {
            Some(comma) => {
                let text = format!("{gap}{entry},");
                self.replace(comma..comma, &text)
            }
            None => {
                let end = last.value.span.end;
                let text = format!(",{gap}{entry}");
                self.replace(end..end, &text)
            }
        }
    }

    /// Takes an entry out, with the comments above it and its comma.
    pub fn remove(&mut self, sequence: &Sequence, index: usize) -> Result<(), SpanFault> {
        let chunk = self.chunk(sequence, index);
        self.replace(chunk, "")
    }

    /// Puts a copy of an entry, with the comments above it, after it.
    pub fn duplicate(&mut self, sequence: &Sequence, index: usize) -> Result<(), SpanFault> {
        let (text, chunk) = self.with_comma(sequence, index);
        // In a line, a blank goes between the two.
        let gap =
            if text.starts_with(char::is_whitespace) || self.text[..chunk.start].ends_with('\n') { "" } else { " " };
        let both = format!("{text}{gap}{text}");
        self.replace(chunk, &both)
    }

    /// Swaps an entry with the one after it, each with the comments above it.
    pub fn swap_with_next(&mut self, sequence: &Sequence, index: usize) -> Result<(), SpanFault> {
        let (first, a) = self.with_comma(sequence, index);
        let (second, b) = self.with_comma(sequence, index + 1);
        // What is before the first one in a line stays before whichever is first.
        let lead = |t: &str| t.len() - t.trim_start_matches([' ', '\t']).len();
        let (x, y) = (lead(&first), lead(&second));
        let inline = !first.contains('\n') && !second.contains('\n');
        let swapped = if inline {
            format!("{}{}{}{}", &first[..x], &second[y..], &second[..y], &first[x..])
        } else {
            format!("{second}{first}")
        };
        self.replace(a.start..b.end, &swapped)
    }

    /// The text of an entry's chunk, with a comma, and its bytes.
    fn with_comma(&self, sequence: &Sequence, index: usize) -> (String, Range<usize>) {
        let chunk = self.chunk(sequence, index);
        let mut text = self.text[chunk.clone()].to_owned();
        let entry = &sequence.entries[index];
        if entry.comma.is_none() {
            text.insert(entry.value.span.end - chunk.start, ',');
        }
        (text, chunk)
    }

    /// An entry with all that belongs to it: comments above, the comma, the rest of its last line.
    fn chunk(&self, sequence: &Sequence, index: usize) -> Range<usize> {
        let after = |entry: &Entry| entry.comma.unwrap_or(entry.value.span.end);
        let start = if index == 0 { sequence.open } else { after(&sequence.entries[index - 1]) };
        let end = after(&sequence.entries[index]);
        self.past_line(start).min(sequence.entries[index].start())..self.past_line(end).min(sequence.close)
    }

    /// Just after the line end, if nothing but blanks and a comment is before it.
    fn past_line(&self, from: usize) -> usize {
        let rest = &self.text[from..];
        let line = rest.find('\n').map_or(rest, |end| &rest[..end]);
        let blank = line.trim_start();
        if line.len() < rest.len() && (blank.is_empty() || blank.starts_with("//")) {
            from + line.len() + 1
        } else {
            from
        }
    }

    /// The text without the entries of these names.
    pub fn without(&self, sequences: &[(&Sequence, &[&str])]) -> (String, Vec<String>) {
        let mut cuts: Vec<(Range<usize>, String)> = Vec::new();
        for (sequence, known) in sequences {
            for (k, entry) in sequence.entries.iter().enumerate() {
                let name = &self.text[entry.name.clone()];
                if !name.is_empty() && !known.contains(&name) {
                    cuts.push((self.chunk(sequence, k), name.to_owned()));
                }
            }
        }
        cuts.sort_by_key(|(range, _)| range.start);
        let mut text = self.text.clone();
        for (range, _) in cuts.iter().rev() {
            text.replace_range(range.clone(), "");
        }
        (text, cuts.into_iter().map(|(_, name)| name).collect())
    }
}

impl Node {
    /// The entries of a list.
    pub fn list(&self) -> Option<&Sequence> {
        match &self.kind {
            Kind::List(sequence) => Some(sequence),
            // An empty pair of brackets could be either.
            _ => None,
        }
    }
}

/// A number with at most so many decimals.
pub(super) fn number(value: f64, decimals: i32) -> String {
    let unit = 10_f64.powi(decimals);
    // Adding zero turns -0 into 0.
    format!("{}", (value * unit).round() / unit + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(text: &str) -> Patcher {
        Patcher::new(text.to_owned()).unwrap()
    }

    #[test]
    fn lists_in_a_line_are_duplicated_removed_and_swapped() {
        let changed = |text: &str, change: fn(&mut Patcher, &Sequence)| {
            let mut patcher = list(text);
            let sequence = patcher.root().sequence().unwrap().clone();
            change(&mut patcher, &sequence);
            patcher.into_text()
        };
        assert_eq!(changed("[1, 2, 3]", |p, s| p.duplicate(s, 0).unwrap()), "[1, 1, 2, 3]");
        assert_eq!(changed("[1, 2, 3]", |p, s| p.duplicate(s, 2).unwrap()), "[1, 2, 3, 3,]");
        assert_eq!(changed("[1, 2, 3]", |p, s| p.remove(s, 1).unwrap()), "[1, 3]");
        assert_eq!(changed("[1, 2, 3]", |p, s| p.swap_with_next(s, 0).unwrap()), "[2, 1, 3]");
        assert_eq!(changed("[1, 2]", |p, s| p.swap_with_next(s, 0).unwrap()), "[2, 1,]");
    }

    #[test]
    fn entries_in_lines_take_their_comments_with_them() {
        let text = "[\n    // one\n    (1), // first\n    // two\n    (2)\n]";
        let mut patcher = list(text);
        let sequence = patcher.root().sequence().unwrap().clone();
        patcher.swap_with_next(&sequence, 0).unwrap();
        assert_eq!(patcher.text(), "[\n    // two\n    (2),\n    // one\n    (1), // first\n]");
        let sequence = patcher.root().sequence().unwrap().clone();
        patcher.remove(&sequence, 1).unwrap();
        assert_eq!(patcher.text(), "[\n    // two\n    (2),\n]");
    }

    #[test]
    fn a_number_that_stays_keeps_its_spelling() {
        let mut patcher = list("(a: 1.50, b: Some(2.0))");
        let a = patcher.get(patcher.root(), "a").unwrap().clone();
        patcher.set_number(&a, 1.5, 2).unwrap();
        let b = patcher.get(patcher.root(), "b").unwrap().clone();
        patcher.set_number(&b, 2.25, 2).unwrap();
        assert_eq!(patcher.text(), "(a: 1.50, b: Some(2.25))");
    }
}
