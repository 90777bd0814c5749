//! Serde for parameters: f32 as its bit pattern, so that a text format brings back the very same numbers.

use serde::{Deserialize, Deserializer, Serializer};

/// For `#[serde(serialize_with)]`.
pub(super) fn serialize<S: Serializer>(values: &[f32], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(values.iter().map(|value| value.to_bits()))
}

/// For `#[serde(deserialize_with)]`.
pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f32>, D::Error> {
    Ok(Vec::<u32>::deserialize(deserializer)?.into_iter().map(f32::from_bits).collect())
}
