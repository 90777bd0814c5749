//! State as bytes: little-endian numbers one after the other, of fixed widths on every machine.
//!
//! What a player or a body remembers is written by it and read back by one that was made from the same files; the
//! files themselves are not in the bytes. Every bit of a number is kept.

use glam::{DQuat, DVec3};

/// Why bytes are no state of what reads them.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StateError {
    /// The bytes end too early.
    #[error("the state ends at byte {at}, inside {what}")]
    End {
        /// Where.
        at: usize,
        /// What should be there.
        what: &'static str,
    },
    /// A value that cannot be.
    #[error("{what} is {found}; valid: {valid}")]
    Value {
        /// Which.
        what: &'static str,
        /// What is there.
        found: String,
        /// What would be valid.
        valid: String,
    },
}

impl StateError {
    /// A value that cannot be.
    pub fn value(what: &'static str, found: impl ToString, valid: impl ToString) -> Self {
        Self::Value { what, found: found.to_string(), valid: valid.to_string() }
    }
}

/// Collects state.
#[derive(Clone, Debug, Default)]
pub struct StateWriter {
    bytes: Vec<u8>,
}

impl StateWriter {
    /// An empty one with room for so many bytes.
    pub fn with_capacity(bytes: usize) -> Self {
        Self { bytes: Vec::with_capacity(bytes) }
    }
    /// The bytes.
    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }
    /// A small number.
    pub fn byte(&mut self, value: u8) {
        self.bytes.push(value);
    }
    /// A switch.
    pub fn switch(&mut self, value: bool) {
        self.byte(u8::from(value));
    }
    /// A whole number.
    pub fn whole(&mut self, value: u64) {
        self.bytes.extend_from_slice(&value.to_le_bytes());
    }
    /// A long whole number.
    pub fn long(&mut self, value: u128) {
        self.bytes.extend_from_slice(&value.to_le_bytes());
    }
    /// An index or a length.
    pub fn count(&mut self, value: usize) {
        self.whole(value as u64);
    }
    /// A number.
    pub fn number(&mut self, value: f64) {
        self.bytes.extend_from_slice(&value.to_le_bytes());
    }
    /// A vector.
    pub fn vector(&mut self, value: DVec3) {
        value.to_array().into_iter().for_each(|x| self.number(x));
    }
    /// A rotation.
    pub fn rotation(&mut self, value: DQuat) {
        value.to_array().into_iter().for_each(|x| self.number(x));
    }
    /// A text.
    pub fn text(&mut self, value: &str) {
        self.count(value.len());
        self.bytes.extend_from_slice(value.as_bytes());
    }
    /// Something or nothing.
    pub fn option<T>(&mut self, value: Option<T>, write: impl FnOnce(&mut Self, T)) {
        self.switch(value.is_some());
        if let Some(value) = value {
            write(self, value);
        }
    }
}

/// Reads state.
#[derive(Clone, Debug)]
pub struct StateReader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> StateReader<'a> {
    /// Longest text that is read, bytes.
    pub const MAX_TEXT: usize = 4096;

    /// A reader at the start of the bytes.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }
    /// How many bytes are left.
    pub fn left(&self) -> usize {
        self.bytes.len() - self.at
    }
    /// The next so many bytes.
    pub fn take(&mut self, what: &'static str, count: usize) -> Result<&'a [u8], StateError> {
        let end = self.at.checked_add(count).filter(|end| *end <= self.bytes.len());
        let end = end.ok_or(StateError::End { at: self.bytes.len(), what })?;
        let taken = &self.bytes[self.at..end];
        self.at = end;
        Ok(taken)
    }
    fn array<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], StateError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(what, N)?);
        Ok(array)
    }
    /// A small number.
    pub fn byte(&mut self, what: &'static str) -> Result<u8, StateError> {
        Ok(self.array::<1>(what)?[0])
    }
    /// A switch.
    pub fn switch(&mut self, what: &'static str) -> Result<bool, StateError> {
        match self.byte(what)? {
            0 => Ok(false),
            1 => Ok(true),
            other => refuse(what, other, "0 or 1"),
        }
    }
    /// A whole number.
    pub fn whole(&mut self, what: &'static str) -> Result<u64, StateError> {
        Ok(u64::from_le_bytes(self.array(what)?))
    }
    /// A long whole number.
    pub fn long(&mut self, what: &'static str) -> Result<u128, StateError> {
        Ok(u128::from_le_bytes(self.array(what)?))
    }
    /// An index or a length that is below `limit`.
    pub fn below(&mut self, what: &'static str, limit: usize) -> Result<usize, StateError> {
        let value = self.whole(what)?;
        match usize::try_from(value) {
            Ok(value) if value < limit => Ok(value),
            _ => refuse(what, value, format!("below {limit}")),
        }
    }
    /// A length that has to be this one.
    pub fn exactly(&mut self, what: &'static str, wanted: usize) -> Result<(), StateError> {
        let value = self.whole(what)?;
        if value == wanted as u64 { Ok(()) } else { refuse(what, value, wanted) }
    }
    /// A number.
    pub fn number(&mut self, what: &'static str) -> Result<f64, StateError> {
        Ok(f64::from_le_bytes(self.array(what)?))
    }
    /// A vector.
    pub fn vector(&mut self, what: &'static str) -> Result<DVec3, StateError> {
        Ok(DVec3::new(self.number(what)?, self.number(what)?, self.number(what)?))
    }
    /// A rotation.
    pub fn rotation(&mut self, what: &'static str) -> Result<DQuat, StateError> {
        let (v, w) = (self.vector(what)?, self.number(what)?);
        Ok(DQuat::from_xyzw(v.x, v.y, v.z, w))
    }
    /// A text.
    pub fn text(&mut self, what: &'static str) -> Result<String, StateError> {
        let length = self.below(what, Self::MAX_TEXT + 1)?;
        match std::str::from_utf8(self.take(what, length)?) {
            Ok(text) => Ok(text.to_owned()),
            Err(_) => refuse(what, "bytes", "UTF-8"),
        }
    }
    /// Something or nothing.
    pub fn option<T>(
        &mut self,
        what: &'static str,
        read: impl FnOnce(&mut Self) -> Result<T, StateError>,
    ) -> Result<Option<T>, StateError> {
        if self.switch(what)? { read(self).map(Some) } else { Ok(None) }
    }
    /// Refuses bytes that are left over.
    pub fn end(&self) -> Result<(), StateError> {
        if self.left() == 0 { Ok(()) } else { refuse("the rest", format!("{} bytes", self.left()), "nothing") }
    }
}

fn refuse<T>(what: &'static str, found: impl ToString, valid: impl ToString) -> Result<T, StateError> {
    Err(StateError::value(what, found, valid))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read_and_short_bytes_are_refused() {
        let mut out = StateWriter::default();
        out.number(f64::NAN);
        out.vector(DVec3::new(-0.0, 1e-310, 3.0));
        out.option(Some("edge"), |out, text| out.text(text));
        out.option(None::<u64>, StateWriter::whole);
        out.long(u128::MAX);
        let bytes = out.finish();
        let mut from = StateReader::new(&bytes);
        assert_eq!(from.number("n").unwrap().to_bits(), f64::NAN.to_bits());
        let v = from.vector("v").unwrap();
        assert_eq!(v.to_array().map(f64::to_bits), [-0.0_f64, 1e-310, 3.0].map(f64::to_bits));
        assert_eq!(from.option("t", |f| f.text("t")).unwrap().as_deref(), Some("edge"));
        assert_eq!(from.option("w", |f| f.whole("w")).unwrap(), None);
        assert_eq!(from.long("l").unwrap(), u128::MAX);
        from.end().unwrap();
        for cut in 0..8 {
            assert!(matches!(StateReader::new(&bytes[..cut]).number("n"), Err(StateError::End { .. })));
        }
        assert!(matches!(StateReader::new(&[7]).switch("s"), Err(StateError::Value { .. })));
        assert!(matches!(StateReader::new(&[9, 0, 0, 0, 0, 0, 0, 0]).below("b", 9), Err(StateError::Value { .. })));
    }
}
