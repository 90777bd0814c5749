//! The BVH reader: words with line numbers, a stack of open joints, then the rows of numbers.

use super::{Axis, Bvh, BvhError, BvhJoint, BvhLimits, BvhWarning, Channel, FrameTimeUnit};
use glam::DVec3;

/// Longest joint name, bytes.
const LONGEST_NAME: usize = 256;
/// Largest magnitude of any number in a file.
const LARGEST_NUMBER: f64 = 1e9;

/// The words of the text with the lines they stand on.
struct Words<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    words: std::str::SplitWhitespace<'a>,
    line: usize,
    pushed_back: Option<(usize, &'a str)>,
}

impl<'a> Words<'a> {
    fn new(text: &'a str) -> Self {
        Self { lines: text.lines().enumerate(), words: "".split_whitespace(), line: 1, pushed_back: None }
    }
    /// The next word, on whatever line.
    fn next(&mut self) -> Option<(usize, &'a str)> {
        if let Some(word) = self.pushed_back.take() {
            return Some(word);
        }
        loop {
            if let Some(word) = self.words.next() {
                return Some((self.line, word));
            }
            let (index, text) = self.lines.next()?;
            self.line = index + 1;
            self.words = text.split_whitespace();
        }
    }
    /// The next word, or the error that the text ends.
    fn need(&mut self, expected: &'static str) -> Result<(usize, &'a str), BvhError> {
        self.next().ok_or(BvhError::UnexpectedEnd { expected })
    }
    /// The next word, which must be `keyword` in any case.
    fn keyword(&mut self, keyword: &'static str) -> Result<usize, BvhError> {
        let (line, found) = self.need(keyword)?;
        if found.eq_ignore_ascii_case(keyword) { Ok(line) } else { Err(unexpected(line, found, keyword)) }
    }
    /// The rest of the current line up to an opening brace, which stays unread.
    fn rest_of_line(&mut self) -> String {
        let mut name = String::new();
        for word in self.words.by_ref() {
            if word == "{" {
                self.pushed_back = Some((self.line, word));
                break;
            }
            // Enough to see that it is too long; the rest is passed over.
            if name.len() <= LONGEST_NAME {
                if !name.is_empty() {
                    name.push(' ');
                }
                name.push_str(word);
            }
        }
        name
    }
    fn number(&mut self, place: impl Fn() -> String) -> Result<f64, BvhError> {
        let (line, word) = self.need("a number")?;
        number(line, word, place)
    }
    fn vector(&mut self, place: impl Fn() -> String + Copy) -> Result<DVec3, BvhError> {
        Ok(DVec3::new(self.number(place)?, self.number(place)?, self.number(place)?))
    }
}

/// The start of a word, for messages.
fn shown(word: &str) -> String {
    word.chars().take(40).collect()
}

fn unexpected(line: usize, found: &str, expected: &'static str) -> BvhError {
    BvhError::UnexpectedToken { line, found: shown(found), expected }
}

fn number(line: usize, word: &str, place: impl Fn() -> String) -> Result<f64, BvhError> {
    match word.parse::<f64>() {
        Ok(value) if value.abs() < LARGEST_NUMBER => Ok(value),
        _ => Err(BvhError::BadNumber { line, place: place(), found: shown(word) }),
    }
}

fn channel(word: &str) -> Option<Channel> {
    let axis = match word.as_bytes().first()?.to_ascii_lowercase() {
        b'x' => Axis::X,
        b'y' => Axis::Y,
        b'z' => Axis::Z,
        _ => return None,
    };
    let rest = word.get(1..)?;
    if rest.eq_ignore_ascii_case("position") {
        Some(Channel::Position(axis))
    } else if rest.eq_ignore_ascii_case("rotation") {
        Some(Channel::Rotation(axis))
    } else {
        None
    }
}

/// A brace that waits for its end.
enum Open {
    Joint(usize),
    EndSite,
}

/// The hierarchy while it is being read.
struct Hierarchy {
    joints: Vec<BvhJoint>,
    /// Per joint, whether its OFFSET and its CHANNELS have been read.
    seen: Vec<(bool, bool)>,
    channel_count: usize,
    stack: Vec<Open>,
}

pub(super) fn parse(text: &str, limits: BvhLimits) -> Result<Bvh, BvhError> {
    if text.len() > limits.bytes {
        return Err(BvhError::TooLarge { what: "bytes", found: text.len(), limit: limits.bytes });
    }
    // A byte order mark is no word.
    let mut words = Words::new(text.trim_start_matches('\u{feff}'));
    words.keyword("HIERARCHY")?;
    words.keyword("ROOT")?;
    let hierarchy = read_hierarchy(&mut words, limits)?;
    read_motion(&mut words, hierarchy, limits)
}

fn read_hierarchy(words: &mut Words, limits: BvhLimits) -> Result<Hierarchy, BvhError> {
    let mut tree = Hierarchy { joints: Vec::new(), seen: Vec::new(), channel_count: 0, stack: Vec::new() };
    tree.open_joint(words, limits)?;
    loop {
        let (line, word) = words.need("the end of a joint, `}`")?;
        let place = match tree.stack.last() {
            Some(Open::Joint(index)) => Some(*index),
            Some(Open::EndSite) => None,
            // The root is closed.
            None if word.eq_ignore_ascii_case("MOTION") => return Ok(tree),
            None => return Err(unexpected(line, word, "MOTION (one ROOT to a file)")),
        };
        match (word.to_ascii_uppercase().as_str(), place) {
            ("JOINT", Some(_)) => tree.open_joint(words, limits)?,
            ("END", Some(_)) => {
                words.keyword("Site")?;
                words.rest_of_line();
                words.keyword("{")?;
                tree.stack.push(Open::EndSite);
            }
            ("OFFSET", Some(joint)) => tree.read_offset(words, line, joint)?,
            ("OFFSET", None) => {
                let offset = words.vector(|| "offset of an end site".into())?;
                // The joint around the end site; a stack never has two end sites in a row.
                if let Some(Open::Joint(parent)) = tree.stack.iter().rev().nth(1) {
                    tree.joints[*parent].end_sites.push(offset);
                }
            }
            ("CHANNELS", Some(joint)) => tree.read_channels(words, line, joint)?,
            ("}", _) => tree.close(line)?,
            (_, Some(_)) => return Err(unexpected(line, word, "JOINT, End Site, OFFSET, CHANNELS or `}`")),
            (_, None) => return Err(unexpected(line, word, "OFFSET or `}`")),
        }
    }
}

impl Hierarchy {
    fn open_joint(&mut self, words: &mut Words, limits: BvhLimits) -> Result<(), BvhError> {
        let name = words.rest_of_line();
        let line = words.line;
        let refuse = |problem: String| Err(BvhError::Joint { line, joint: shown(&name), problem });
        if name.is_empty() {
            return refuse("has no name; one is needed on the line of ROOT or JOINT".into());
        }
        if name.len() > LONGEST_NAME {
            return refuse(format!("has a name longer than {LONGEST_NAME} bytes"));
        }
        if self.joints.iter().any(|j| j.name == name) {
            return refuse("has the name of an earlier joint; names must be unique".into());
        }
        if self.joints.len() == limits.joints {
            return Err(BvhError::TooLarge { what: "joints", found: limits.joints + 1, limit: limits.joints });
        }
        words.keyword("{")?;
        let parent = self.stack.last().and_then(|open| match open {
            Open::Joint(index) => Some(*index),
            Open::EndSite => None,
        });
        self.stack.push(Open::Joint(self.joints.len()));
        self.seen.push((false, false));
        self.joints.push(BvhJoint {
            name,
            parent,
            offset: DVec3::ZERO,
            channels: Vec::new(),
            first_channel: 0,
            end_sites: Vec::new(),
        });
        Ok(())
    }

    fn error<T>(&self, line: usize, joint: usize, problem: impl Into<String>) -> Result<T, BvhError> {
        Err(BvhError::Joint { line, joint: shown(&self.joints[joint].name), problem: problem.into() })
    }

    fn read_offset(&mut self, words: &mut Words, line: usize, joint: usize) -> Result<(), BvhError> {
        if std::mem::replace(&mut self.seen[joint].0, true) {
            return self.error(line, joint, "has a second OFFSET");
        }
        let name = &self.joints[joint].name;
        let offset = words.vector(|| format!("offset of joint `{}`", shown(name)))?;
        self.joints[joint].offset = offset;
        Ok(())
    }

    fn read_channels(&mut self, words: &mut Words, line: usize, joint: usize) -> Result<(), BvhError> {
        if std::mem::replace(&mut self.seen[joint].1, true) {
            return self.error(line, joint, "has a second CHANNELS line");
        }
        let (line, word) = words.need("the number of channels")?;
        let count = match word.parse::<usize>() {
            Ok(count) if count <= 6 => count,
            _ => return self.error(line, joint, format!("has `{}` channels; valid is 0 to 6", shown(word))),
        };
        let mut channels = Vec::with_capacity(count);
        for _ in 0..count {
            let (line, word) = words.need("a channel name")?;
            let Some(channel) = channel(word) else {
                let problem = format!("has the channel `{}`; valid are Xposition, Xrotation and the like", shown(word));
                return self.error(line, joint, problem);
            };
            if channels.contains(&channel) {
                return self.error(line, joint, format!("has the channel `{}` twice", shown(word)));
            }
            channels.push(channel);
        }
        self.joints[joint].first_channel = self.channel_count;
        self.joints[joint].channels = channels;
        self.channel_count += count;
        Ok(())
    }

    fn close(&mut self, line: usize) -> Result<(), BvhError> {
        if let Some(Open::Joint(joint)) = self.stack.pop() {
            if !self.seen[joint].0 {
                return self.error(line, joint, "ends without an OFFSET line");
            }
            if !self.seen[joint].1 {
                return self.error(line, joint, "ends without a CHANNELS line");
            }
        }
        Ok(())
    }
}

/// `Frames: n`, `Frame Time: s`, then the rows. The colons may stand apart.
fn read_motion(words: &mut Words, tree: Hierarchy, limits: BvhLimits) -> Result<Bvh, BvhError> {
    label(words, &["frames"], "`Frames:`")?;
    let (line, word) = words.need("the number of frames")?;
    let frame_count = word.parse::<usize>().map_err(|_| unexpected(line, word, "the number of frames"))?;
    if frame_count == 0 {
        return Err(BvhError::NoFrames { line });
    }
    if frame_count > limits.frames {
        return Err(BvhError::TooLarge { what: "frames", found: frame_count, limit: limits.frames });
    }
    label(words, &["frame", "time"], "`Frame Time:`")?;
    let (line, word) = words.need("the frame time")?;
    let declared = number(line, word, || "frame time".into())?;
    let mut warnings = Vec::new();
    let (frame_time, unit) = frame_time(declared).ok_or(BvhError::FrameTime { line, found: declared })?;
    if let Some(taken) = unit {
        warnings.push(BvhWarning::FrameTime { declared, taken, seconds: frame_time });
    }

    // Rows may be wrapped; the first row of an unusual length is kept for the message. Headers miscount: what counts is
    // what the file holds.
    let (channels, needed) = (tree.channel_count, frame_count.saturating_mul(tree.channel_count));
    let mut values = Vec::new();
    let mut found = 0;
    let (mut row_line, mut row_length, mut odd_row) = (0, 0, None);
    while let Some((line, word)) = words.next() {
        if line != row_line {
            if row_length != channels && row_line != 0 {
                odd_row.get_or_insert(row_line);
            }
            (row_line, row_length) = (line, 0);
        }
        row_length += 1;
        found += 1;
        let value = number(line, word, || format!("frame {}", (found - 1) / channels.max(1)))?;
        values.push(value);
    }
    if found == 0 && needed > 0 {
        return Err(BvhError::UnexpectedEnd { expected: "the rows of the frames" });
    }
    if found % channels.max(1) != 0 || (channels == 0 && found > 0) {
        return Err(BvhError::ValueCount {
            line: odd_row.unwrap_or(words.line),
            frames: frame_count,
            channels,
            needed,
            found,
        });
    }
    let held = found.checked_div(channels).unwrap_or(frame_count);
    if held > limits.frames {
        return Err(BvhError::TooLarge { what: "frames", found: held, limit: limits.frames });
    }
    if held != frame_count {
        warnings.push(BvhWarning::FrameCount { declared: frame_count, found: held });
    }
    Ok(Bvh { joints: tree.joints, frame_time, channel_count: channels, frame_count: held, values, warnings })
}

/// Longest time between frames that is taken as it is, s.
const LONGEST_FRAME: f64 = 2.0;
/// Rates of cameras and capture systems, 1/s.
const RATES: [f64; 16] =
    [24.0, 25.0, 29.97, 30.0, 48.0, 50.0, 59.94, 60.0, 75.0, 90.0, 100.0, 119.88, 120.0, 144.0, 200.0, 240.0];

/// The time between frames that the number in a header means, s, and what it is if not seconds. A number above two is one of
/// the usual rates, or the milliseconds of a rate from 10 to 500 frames per second, or another rate.
fn frame_time(declared: f64) -> Option<(f64, Option<FrameTimeUnit>)> {
    if (1e-5..=LONGEST_FRAME).contains(&declared) {
        return Some((declared, None));
    }
    if RATES.iter().any(|rate| (declared - rate).abs() < 1e-3 * rate) {
        return Some((1.0 / declared, Some(FrameTimeUnit::Rate)));
    }
    if (2.0..=100.0).contains(&declared) {
        return Some((declared * 1e-3, Some(FrameTimeUnit::Milliseconds)));
    }
    (100.0..=1000.0).contains(&declared).then(|| (1.0 / declared, Some(FrameTimeUnit::Rate)))
}

/// The words of a header label; each may carry a colon or be followed by one.
fn label(words: &mut Words, parts: &[&str], expected: &'static str) -> Result<(), BvhError> {
    for part in parts {
        let (line, word) = words.need(expected)?;
        if !word.trim_end_matches(':').eq_ignore_ascii_case(part) {
            return Err(unexpected(line, word, expected));
        }
    }
    match words.next() {
        Some((_, ":")) | None => {}
        other => words.pushed_back = other,
    }
    Ok(())
}
