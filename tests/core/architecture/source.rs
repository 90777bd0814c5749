//! The crate's source as files that name each other.
//!
//! Just enough of the language: comments and literals are left out, `use` trees are opened, and paths that begin with
//! `crate`, `self`, `super` or a child module are followed through re-exports to the file that defines what is named.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Names of the modules from the root of the crate to a file.
pub type Module = Vec<String>;

/// A file names something in another one, or everything in it (`star`).
#[derive(PartialEq, Eq, PartialOrd, Ord, Clone, Debug)]
pub struct Import {
    pub from: Module,
    pub to: Module,
    pub line: usize,
    pub star: bool,
}

/// A path as it is written, made absolute; what it is called here, if a `use` brought it.
struct Named {
    line: usize,
    path: Vec<String>,
    own_name: Option<String>,
    /// It began with `crate`, `self` or `super`: it can only lead into this crate.
    anchored: bool,
}

struct Source {
    file: String,
    named: Vec<Named>,
    defined: BTreeSet<String>,
    /// Every word of its code: what a macro is told to define is among them.
    words: BTreeSet<String>,
}

/// The files of a crate, by module.
pub struct Crate(BTreeMap<Module, Source>);

impl Crate {
    /// All of a folder whose root is `lib.rs` or `main.rs`, except what begins with one of `except`: crates of their own.
    pub fn read(folder: &Path, root: &str, except: &[&str]) -> Self {
        let mut files = Vec::new();
        collect(folder, folder, &mut files);
        files.retain(|f| !except.iter().any(|e| f.starts_with(e)));
        let texts: Vec<String> = files.iter().map(|f| fs::read_to_string(folder.join(f)).unwrap()).collect();
        Self::new(files.iter().map(String::as_str).zip(texts.iter().map(String::as_str)), root)
    }

    /// From pairs of a path below the source folder and a text.
    pub fn new<'a>(texts: impl IntoIterator<Item = (&'a str, &'a str)>, root: &str) -> Self {
        let source = |(file, text): (&str, &str)| {
            let module = module_of(file, root);
            let source = Reader::read(file, text, &module);
            (module, source)
        };
        Self(texts.into_iter().map(source).collect())
    }

    pub fn files(&self) -> impl Iterator<Item = &str> {
        self.0.values().map(|s| s.file.as_str())
    }

    pub fn file(&self, module: &[String]) -> &str {
        &self.0[module].file
    }

    /// Every import of one file by another, once for each line, and every path that leads nowhere.
    pub fn imports(&self) -> (BTreeSet<Import>, Vec<String>) {
        let (mut imports, mut lost) = (BTreeSet::new(), Vec::new());
        for (from, source) in &self.0 {
            for named in source.named.iter().filter(|n| n.anchored || self.is_child(from, n)) {
                let star = named.path.last().is_some_and(|n| n == "*");
                let path = &named.path[..named.path.len() - usize::from(star)];
                match self.home(path, 0) {
                    Some(to) if to == *from => {}
                    Some(to) => _ = imports.insert(Import { from: from.clone(), to, line: named.line, star }),
                    None => lost.push(format!("{}:{}: {}", source.file, named.line, path.join("::"))),
                }
            }
        }
        (imports, lost)
    }

    /// Whether a path without an anchor begins with a child module of the file; otherwise it is another crate's.
    fn is_child(&self, module: &[String], named: &Named) -> bool {
        named.path.len() > module.len() && self.0.contains_key(&named.path[..=module.len()])
    }

    /// The module whose file defines what a path names.
    fn home(&self, path: &[String], depth: usize) -> Option<Module> {
        let length = (0..=path.len()).rev().find(|n| self.0.contains_key(&path[..*n]))?;
        let (module, source) = self.0.get_key_value(&path[..length])?;
        let Some(name) = path.get(length) else { return Some(module.clone()) };
        if source.defined.contains(name) || depth > 8 {
            return Some(module.clone());
        }
        let ways = source.named.iter().filter(|n| n.anchored || self.is_child(module, n));
        let by_name = ways.clone().filter(|n| n.own_name.as_ref() == Some(name));
        let by_star = ways.filter(|n| n.own_name.as_deref() == Some("*"));
        let targets = by_name.map(|n| (&n.path[..], length + 1));
        let targets = targets.chain(by_star.map(|n| (&n.path[..n.path.len() - 1], length)));
        for (target, rest) in targets {
            let target: Vec<String> = target.iter().chain(&path[rest..]).cloned().collect();
            if target != path
                && let Some(home) = self.home(&target, depth + 1)
            {
                return Some(home);
            }
        }
        source.words.contains(name).then(|| module.clone())
    }
}

fn collect(folder: &Path, root: &Path, found: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, root, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let parts: Vec<_> = path.strip_prefix(root).unwrap().iter().map(|p| p.to_str().unwrap()).collect();
            found.push(parts.join("/"));
        }
    }
}

fn module_of(file: &str, root: &str) -> Module {
    let path = file.strip_suffix(".rs").unwrap();
    let path = path.strip_suffix("/mod").unwrap_or(path);
    if file == root { Vec::new() } else { path.split('/').map(str::to_owned).collect() }
}

#[derive(PartialEq, Debug)]
enum Token {
    Word(String),
    Path,
    Mark(char),
}

/// Goes through the tokens of one file.
struct Reader<'a> {
    tokens: &'a [(usize, Token)],
    at: usize,
    /// The module of the file and of the module in braces that the reader is in.
    place: Module,
    named: Vec<Named>,
}

impl Reader<'_> {
    fn read(file: &str, text: &str, module: &[String]) -> Source {
        let tokens = tokens(text);
        let mut reader = Reader { tokens: &tokens, at: 0, place: module.to_vec(), named: Vec::new() };
        let mut defined = BTreeSet::new();
        // Depth of braces, and the depths at which modules in braces begin.
        let (mut depth, mut inner) = (0, Vec::new());
        while let Some((_, token)) = tokens.get(reader.at) {
            let next = tokens.get(reader.at + 1).map(|(_, t)| t);
            match token {
                Token::Mark('{') => depth += 1,
                Token::Mark('}') => {
                    depth -= 1;
                    if inner.last() == Some(&depth) {
                        inner.pop();
                        reader.place.pop();
                    }
                }
                Token::Word(word) => match (word.as_str(), next) {
                    ("use", Some(Token::Word(_) | Token::Path)) => {
                        reader.at += 1;
                        reader.tree(&[]);
                        continue;
                    }
                    ("crate" | "self" | "super", Some(Token::Path)) => {
                        reader.path();
                        continue;
                    }
                    (
                        "fn" | "struct" | "enum" | "union" | "trait" | "type" | "const" | "static" | "mod",
                        Some(Token::Word(name)),
                    ) => {
                        defined.insert(name.clone());
                        if word == "mod" && matches!(tokens.get(reader.at + 2), Some((_, Token::Mark('{')))) {
                            inner.push(depth);
                            reader.place.push(name.clone());
                        }
                        reader.at += 1;
                    }
                    _ => {}
                },
                _ => {}
            }
            reader.at += 1;
        }
        let words = tokens.iter().filter_map(|(_, t)| if let Token::Word(w) = t { Some(w.clone()) } else { None });
        Source { file: file.to_owned(), named: reader.named, defined, words: words.collect() }
    }

    /// A path in code, which begins with an anchor.
    fn path(&mut self) {
        let (line, mut path) = (self.tokens[self.at].0, Vec::new());
        while let Some((_, Token::Word(word))) = self.tokens.get(self.at) {
            path.push(word.clone());
            self.at += 1;
            if !matches!(self.tokens.get(self.at), Some((_, Token::Path))) {
                break;
            }
            self.at += 1;
        }
        self.add(line, &path, None);
    }

    /// A tree of a `use`, up to what ends it.
    fn tree(&mut self, before: &[String]) {
        let mut path = before.to_vec();
        while let Some((line, token)) = self.tokens.get(self.at) {
            self.at += 1;
            match token {
                Token::Path => {}
                Token::Word(word) if word == "as" => {
                    if let Some((_, Token::Word(own))) = self.tokens.get(self.at) {
                        self.at += 1;
                        self.add(*line, &path, Some(own.clone()));
                    }
                    return;
                }
                Token::Mark('{') => {
                    while !matches!(self.tokens.get(self.at), Some((_, Token::Mark('}'))) | None) {
                        self.tree(&path);
                        if matches!(self.tokens.get(self.at), Some((_, Token::Mark(',')))) {
                            self.at += 1;
                        }
                    }
                    self.at += 1;
                    return;
                }
                Token::Word(word) => path.push(word.clone()),
                Token::Mark('*') => path.push("*".to_owned()),
                Token::Mark(_) => self.at -= 1,
            }
            let ends = !matches!(self.tokens.get(self.at), Some((_, Token::Path)))
                && !matches!(self.tokens.get(self.at), Some((_, Token::Word(w))) if w == "as")
                && !matches!(token, Token::Path);
            if ends {
                if path.len() > before.len() && path.last().is_some_and(|n| n == "self") {
                    path.pop();
                }
                self.add(*line, &path, path.last().cloned());
                return;
            }
        }
    }

    fn add(&mut self, line: usize, path: &[String], own_name: Option<String>) {
        let (mut absolute, mut anchored) = (self.place.clone(), false);
        for (k, word) in path.iter().enumerate() {
            match word.as_str() {
                "crate" if k == 0 => absolute.clear(),
                "self" if k == 0 => {}
                "super" => _ = absolute.pop(),
                _ => {
                    absolute.push(word.clone());
                    continue;
                }
            }
            anchored = true;
        }
        self.named.push(Named { line, path: absolute, own_name, anchored });
    }
}

/// Words and marks with their lines (from 1), without comments, strings, characters and lifetimes.
fn tokens(text: &str) -> Vec<(usize, Token)> {
    let c: Vec<char> = text.chars().collect();
    let is = |at: usize, word: &str| word.chars().enumerate().all(|(k, w)| c.get(at + k) == Some(&w));
    let in_word = |at: usize| c.get(at).is_some_and(|c| c.is_alphanumeric() || *c == '_');
    let (mut found, mut line, mut at) = (Vec::new(), 1, 0);
    while at < c.len() {
        let begin = at;
        if is(at, "//") {
            at += c[at..].iter().position(|c| *c == '\n').unwrap_or(c.len() - at);
        } else if is(at, "/*") {
            at = end_of_comment(&c, at);
        } else if in_word(at) {
            at += (at..).take_while(|k| in_word(*k)).count();
            let word: String = c[begin..at].iter().collect();
            let raw = matches!(word.as_str(), "r" | "br" | "cr");
            let hashes = (at..).take_while(|k| is(*k, "#")).count();
            if raw && is(at + hashes, "\"") {
                let end = format!("\"{}", "#".repeat(hashes));
                at += hashes + 1;
                at += (at..c.len()).take_while(|k| !is(*k, &end)).count() + end.len();
            } else if !(matches!(word.as_str(), "b" | "c") && (is(at, "\"") || is(at, "'"))) {
                found.push((line, Token::Word(word)));
            }
        } else if c[at] == '"' || (c[at] == '\'' && (is(at + 1, "\\") || is(at + 2, "'"))) {
            at += 1;
            while at < c.len() && c[at] != c[begin] {
                at += if c[at] == '\\' { 2 } else { 1 };
            }
            at += 1;
        } else if c[at] == '\'' {
            at += 1 + (at + 1..).take_while(|k| in_word(*k)).count();
        } else if is(at, "::") {
            found.push((line, Token::Path));
            at += 2;
        } else {
            if !c[at].is_whitespace() {
                found.push((line, Token::Mark(c[at])));
            }
            at += 1;
        }
        line += c[begin..at.min(c.len())].iter().filter(|c| **c == '\n').count();
    }
    found
}

/// Where a comment ends that begins at `at`; such comments nest.
fn end_of_comment(c: &[char], mut at: usize) -> usize {
    let mut depth = 0;
    while at < c.len() {
        match (c[at], c.get(at + 1)) {
            ('/', Some('*')) => (depth, at) = (depth + 1, at + 2),
            ('*', Some('/')) => (depth, at) = (depth - 1, at + 2),
            _ => at += 1,
        }
        if depth == 0 {
            break;
        }
    }
    at
}
