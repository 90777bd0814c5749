//! A number of a course file: itself, or a formula over the course's parameters.
//!
//! ```text
//! formula = ["-"] product { ("+" | "-") product }
//! product = factor { "*" factor }
//! factor  = number | name
//! name    = letter { letter | digit | "_" }
//! ```
//!
//! There are no brackets and no division: what stands where in a course is a sum of products.

use serde::de::{Deserializer, Error, Visitor};
use serde::{Deserialize, Serialize, Serializer};
use std::fmt;

/// Longest formula, bytes.
const LONGEST: usize = 200;

/// A sum of products of numbers and parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    /// As it is written.
    text: String,
    products: Vec<Product>,
}

/// A number times the values of parameters.
#[derive(Clone, Debug, PartialEq)]
struct Product {
    factor: f64,
    names: Vec<String>,
}

/// Why a text is no formula.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "formula \"{text}\": {reason} at character {at}; valid: sums and products of numbers and parameters, such as \"distance + 0.2 * height\""
)]
pub struct FormulaError {
    /// The text.
    pub text: String,
    /// What is wrong.
    pub reason: &'static str,
    /// Where, from 1.
    pub at: usize,
}

impl Formula {
    /// Reads a formula.
    pub fn parse(text: &str) -> Result<Self, FormulaError> {
        let shown: String = text.chars().take(60).collect();
        let bad = |reason, at: usize| FormulaError { text: shown.clone(), reason, at: at + 1 };
        if text.len() > LONGEST {
            return Err(bad("more than 200 bytes", LONGEST));
        }
        if let Some(at) = text.bytes().position(|b| !b.is_ascii()) {
            return Err(bad("a letter outside a-z", at));
        }
        let bytes = text.as_bytes();
        let skip = |mut at: usize| {
            while bytes.get(at).is_some_and(u8::is_ascii_whitespace) {
                at += 1;
            }
            at
        };
        let mut at = skip(0);
        let (mut products, mut sign) = (Vec::new(), 1.0);
        if bytes.get(at) == Some(&b'-') {
            (sign, at) = (-1.0, skip(at + 1));
        }
        loop {
            let mut product = Product { factor: sign, names: Vec::new() };
            loop {
                let start = at;
                match bytes.get(at) {
                    Some(b) if b.is_ascii_digit() || *b == b'.' => {
                        while bytes.get(at).is_some_and(|b| b.is_ascii_digit() || *b == b'.') {
                            at += 1;
                        }
                        let number: f64 = text[start..at].parse().map_err(|_| bad("no number", start))?;
                        product.factor *= number;
                    }
                    Some(b) if b.is_ascii_alphabetic() => {
                        while bytes.get(at).is_some_and(|b| b.is_ascii_alphanumeric() || *b == b'_') {
                            at += 1;
                        }
                        product.names.push(text[start..at].to_owned());
                    }
                    Some(_) => return Err(bad("neither a number nor a name", at)),
                    None => return Err(bad("a number or a name is missing", at)),
                }
                at = skip(at);
                if bytes.get(at) != Some(&b'*') {
                    break;
                }
                at = skip(at + 1);
            }
            products.push(product);
            match bytes.get(at) {
                Some(b'+') => sign = 1.0,
                Some(b'-') => sign = -1.0,
                Some(_) => return Err(bad("no +, - or *", at)),
                None => return Ok(Self { text: text.to_owned(), products }),
            }
            at = skip(at + 1);
        }
    }

    /// As it is written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Names of the parameters in it.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.products.iter().flat_map(|p| &p.names).map(String::as_str)
    }
}

/// A number, or a formula for one.
#[derive(Clone, Debug, PartialEq)]
pub enum Quantity {
    /// The same in every course.
    Number(f64),
    /// Of the parameters.
    Formula(Formula),
}

impl Quantity {
    /// Zero.
    pub const ZERO: Self = Self::Number(0.0);

    /// Its value where `parameter` gives those of the parameters; NaN if it does not know one.
    pub fn value(&self, parameter: &impl Fn(&str) -> Option<f64>) -> f64 {
        match self {
            Self::Number(number) => *number,
            Self::Formula(formula) => {
                let product = |p: &Product| {
                    p.names.iter().fold(p.factor, |value, name| value * parameter(name).unwrap_or(f64::NAN))
                };
                formula.products.iter().map(product).sum()
            }
        }
    }

    /// The formula, if it is one.
    pub fn formula(&self) -> Option<&Formula> {
        match self {
            Self::Number(_) => None,
            Self::Formula(formula) => Some(formula),
        }
    }
}

impl From<f64> for Quantity {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl Serialize for Quantity {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Number(number) => to.serialize_f64(*number),
            Self::Formula(formula) => to.serialize_str(&formula.text),
        }
    }
}

impl<'de> Deserialize<'de> for Quantity {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Reader;
        impl Visitor<'_> for Reader {
            type Value = Quantity;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number or a formula in quotes")
            }
            fn visit_f64<E: Error>(self, number: f64) -> Result<Quantity, E> {
                Ok(Quantity::Number(number))
            }
            fn visit_i64<E: Error>(self, number: i64) -> Result<Quantity, E> {
                Ok(Quantity::Number(number as f64))
            }
            fn visit_u64<E: Error>(self, number: u64) -> Result<Quantity, E> {
                Ok(Quantity::Number(number as f64))
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<Quantity, E> {
                Formula::parse(text).map(Quantity::Formula).map_err(E::custom)
            }
        }
        from.deserialize_any(Reader)
    }
}
