//! Where the values of a RON text are: a tree of byte ranges.
//!
//! Only the shape is read: brackets, names, commas, comments. What a scalar means is left to the reader of the tree.

use std::ops::Range;

/// Deepest nesting that is followed.
const DEEPEST: usize = 64;

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Node {
    /// Its bytes; those of a struct begin at its name.
    pub span: Range<usize>,
    pub kind: Kind,
}

/// What kind of value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind {
    /// A number, a text, a word.
    Scalar,
    /// `[..]` or `(..)` without names.
    List(Sequence),
    /// `(name: ..)`, or `{key: ..}`.
    Named(Sequence),
}

/// The entries between two brackets.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sequence {
    /// Just after the opening bracket.
    pub open: usize,
    /// The closing bracket.
    pub close: usize,
    pub entries: Vec<Entry>,
}

/// An entry with its place in the text.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    /// Name or key; empty in a list.
    pub name: Range<usize>,
    pub value: Node,
    /// Just after its comma.
    pub comma: Option<usize>,
}

impl Entry {
    /// Where name and value begin.
    pub fn start(&self) -> usize {
        if self.name.is_empty() { self.value.span.start } else { self.name.start }
    }
}

/// The text is not RON: byte and reason.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SpanFault {
    pub at: usize,
    pub reason: &'static str,
}

impl Node {
    /// The tree of a text.
    pub fn parse(text: &str) -> Result<Self, SpanFault> {
        let mut reader = Reader { text: text.as_bytes(), at: 0 };
        reader.attributes()?;
        let node = reader.value(0)?;
        reader.trivia()?;
        if reader.at < text.len() { reader.fault("something after the end") } else { Ok(node) }
    }

    /// The entries, if it has any kind of brackets.
    pub fn sequence(&self) -> Option<&Sequence> {
        match &self.kind {
            Kind::Scalar => None,
            Kind::List(sequence) | Kind::Named(sequence) => Some(sequence),
        }
    }

    /// The entry of this name (a text key with its quotes).
    pub fn entry(&self, text: &str, name: &str) -> Option<&Entry> {
        match &self.kind {
            Kind::Named(sequence) => sequence.entries.iter().find(|e| &text[e.name.clone()] == name),
            _ => None,
        }
    }

    /// The value of this name.
    pub fn get(&self, text: &str, name: &str) -> Option<&Node> {
        self.entry(text, name).map(|e| &e.value)
    }

    /// The value at this place of a list; a lone value inside `Some(..)` at 0.
    pub fn at(&self, index: usize) -> Option<&Node> {
        match &self.kind {
            Kind::List(sequence) => sequence.entries.get(index).map(|e| &e.value),
            _ => None,
        }
    }
}

struct Reader<'a> {
    text: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn fault<T>(&self, reason: &'static str) -> Result<T, SpanFault> {
        Err(SpanFault { at: self.at, reason })
    }

    fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    fn starts(&self, with: &[u8]) -> bool {
        self.text[self.at..].starts_with(with)
    }

    /// Skips blanks and comments; block comments nest.
    fn trivia(&mut self) -> Result<(), SpanFault> {
        loop {
            if self.peek().is_some_and(|c| c.is_ascii_whitespace()) {
                self.at += 1;
            } else if self.starts(b"//") {
                while self.peek().is_some_and(|c| c != b'\n') {
                    self.at += 1;
                }
            } else if self.starts(b"/*") {
                let mut depth = 0;
                loop {
                    if self.starts(b"/*") {
                        (depth, self.at) = (depth + 1, self.at + 2);
                    } else if self.starts(b"*/") {
                        (depth, self.at) = (depth - 1, self.at + 2);
                        if depth == 0 {
                            break;
                        }
                    } else if self.at < self.text.len() {
                        self.at += 1;
                    } else {
                        return self.fault("a comment without end");
                    }
                }
            } else {
                return Ok(());
            }
        }
    }

    /// `#![enable(..)]` lines.
    fn attributes(&mut self) -> Result<(), SpanFault> {
        self.trivia()?;
        while self.starts(b"#!") {
            while self.peek().is_some_and(|c| c != b']') {
                self.at += 1;
            }
            self.at = (self.at + 1).min(self.text.len());
            self.trivia()?;
        }
        Ok(())
    }

    fn value(&mut self, depth: usize) -> Result<Node, SpanFault> {
        self.trivia()?;
        if depth > DEEPEST {
            return self.fault("nested too deep");
        }
        let start = self.at;
        self.word();
        let after_word = self.at;
        if after_word > start {
            // A struct or `Some(..)` may have its name before the bracket.
            self.trivia()?;
            if self.peek() != Some(b'(') {
                self.at = after_word;
                // A raw text begins like a word.
                if self.peek() == Some(b'#') || self.peek() == Some(b'"') {
                    self.string()?;
                }
                return Ok(Node { span: start..self.at, kind: Kind::Scalar });
            }
        }
        let kind = match self.peek() {
            Some(b'(') => self.sequence(b')', depth)?,
            Some(b'[') => self.sequence(b']', depth)?,
            Some(b'{') => self.sequence(b'}', depth)?,
            Some(b'"') => {
                self.string()?;
                Kind::Scalar
            }
            Some(b'\'') => {
                self.at += 1;
                while self.peek().is_some_and(|c| c != b'\'') {
                    self.at += if self.peek() == Some(b'\\') { 2 } else { 1 };
                }
                self.at = (self.at + 1).min(self.text.len());
                Kind::Scalar
            }
            _ => return self.fault("no value"),
        };
        Ok(Node { span: start..self.at, kind })
    }

    /// A number or a name.
    fn word(&mut self) {
        let inner = |c: u8| c.is_ascii_alphanumeric() || matches!(c, b'_' | b'.' | b'+' | b'-');
        while self.peek().is_some_and(inner) {
            self.at += 1;
        }
    }

    /// A text, or a raw one from its `#` or `"` on.
    fn string(&mut self) -> Result<(), SpanFault> {
        let mut hashes = 0;
        while self.peek() == Some(b'#') {
            (hashes, self.at) = (hashes + 1, self.at + 1);
        }
        // An `r` stands before a raw text.
        let raw = hashes > 0 || self.at > 0 && self.text[self.at - 1] == b'r';
        self.at += 1;
        while let Some(c) = self.peek() {
            self.at += 1;
            match c {
                b'\\' if !raw => self.at += 1,
                b'"' => {
                    let end = &self.text[self.at.min(self.text.len())..];
                    if end.len() >= hashes && end[..hashes].iter().all(|c| *c == b'#') {
                        self.at += hashes;
                        return Ok(());
                    }
                }
                _ => {}
            }
        }
        self.at = self.text.len();
        self.fault("a text without end")
    }

    fn sequence(&mut self, close: u8, depth: usize) -> Result<Kind, SpanFault> {
        self.at += 1;
        let open = self.at;
        let mut entries: Vec<Entry> = Vec::new();
        loop {
            self.trivia()?;
            match self.peek() {
                None => return self.fault("a bracket without end"),
                Some(c) if c == close => break,
                _ => {}
            }
            let first = self.value(depth + 1)?;
            let end = self.at;
            self.trivia()?;
            let (name, value) = if self.peek() == Some(b':') {
                self.at += 1;
                let value = self.value(depth + 1)?;
                let end = self.at;
                self.trivia()?;
                if self.peek() != Some(b',') && self.peek() != Some(close) {
                    self.at = end;
                    return self.fault("no comma after a value");
                }
                (first.span, value)
            } else {
                (end..end, first)
            };
            let comma = (self.peek() == Some(b',')).then(|| self.at + 1);
            match (comma, self.peek()) {
                (Some(after), _) => self.at = after,
                (None, Some(c)) if c == close => {}
                _ => return self.fault("no comma after a value"),
            }
            entries.push(Entry { name, value, comma });
        }
        let sequence = Sequence { open, close: self.at, entries };
        self.at += 1;
        let named = close == b'}' || sequence.entries.iter().any(|e| !e.name.is_empty());
        Ok(if named { Kind::Named(sequence) } else { Kind::List(sequence) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_found_between_comments_names_and_texts() {
        let text = "#![enable(implicit_some)]\n// (a\n( /* x: ( */ a: 1, b: Some(-2.5e3), c: {\"k,(\": (1, 2 ,3)}, d: Blade(side: Left), e: r#\"\"(\"#,)";
        let root = Node::parse(text).unwrap();
        let of = |node: &Node| text[node.span.clone()].to_owned();
        assert_eq!(of(root.get(text, "a").unwrap()), "1");
        assert_eq!(of(root.get(text, "b").unwrap().at(0).unwrap()), "-2.5e3");
        let tuple = root.get(text, "c").unwrap().get(text, "\"k,(\"").unwrap();
        assert_eq!((0..3).map(|k| of(tuple.at(k).unwrap())).collect::<Vec<_>>(), ["1", "2", "3"]);
        assert_eq!(of(root.get(text, "d").unwrap()), "Blade(side: Left)");
        assert_eq!(of(root.get(text, "e").unwrap()), "r#\"\"(\"#");
    }

    #[test]
    fn what_is_no_ron_is_refused_and_never_panics() {
        let good = "(a: [1, 2], b: {\"x\": (y: 'c', z: \"\\\"\")}, /* n */ c: r\"t\")";
        assert!(Node::parse(good).is_ok());
        for end in 0..good.len() {
            assert!(Node::parse(&good[..end]).is_err(), "{}", &good[..end]);
        }
        for bad in ["(a: 1 b: 2)", "(a: )", "[1 2]", "(a: 1) x", "(a: 1]", &"(".repeat(5000)] {
            assert!(Node::parse(bad).is_err());
        }
    }
}
