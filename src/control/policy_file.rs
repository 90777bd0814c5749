//! From bytes to an ONNX model and its contract, without trusting either.

use super::policy_error::PolicyError;
use crate::asset::policy_contract::{CONTRACT_KEY, PolicyContract};
use crate::asset::read_file::{self, ReadFault};
use prost::Message;
use std::path::Path;
use tract_onnx::pb::ModelProto;

/// Largest policy file, bytes. A network of 300-128-128-128-51 takes 0.3 MB.
pub const MAX_POLICY_BYTES: u64 = 64 << 20;

/// Reads the bytes of a policy file.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, PolicyError> {
    let file = path.display().to_string();
    read_file::read_bytes(path, MAX_POLICY_BYTES).map_err(|error| match error.fault {
        ReadFault::TooLarge { bytes, limit } => PolicyError::TooLarge { file, bytes, limit },
        fault => PolicyError::Read { file, reason: fault.to_string() },
    })
}

fn check_length(bytes: u64, file: &str) -> Result<(), PolicyError> {
    if bytes > MAX_POLICY_BYTES {
        return Err(PolicyError::TooLarge { file: file.to_owned(), bytes, limit: MAX_POLICY_BYTES });
    }
    Ok(())
}

/// The model in the bytes and its contract; `file` is for messages.
pub(crate) fn decode(bytes: &[u8], file: &str) -> Result<(ModelProto, PolicyContract), PolicyError> {
    check_length(bytes.len() as u64, file)?;
    check_fields(bytes).map_err(|fault| match fault {
        Fault::Foreign(at) => PolicyError::NotOnnx {
            file: file.to_owned(),
            reason: format!("byte {at} does not begin a field of an ONNX model"),
        },
        Fault::Cut { part, needs } => {
            PolicyError::Truncated { file: file.to_owned(), bytes: bytes.len() as u64, part, needs }
        }
    })?;
    let not_onnx = |reason: String| PolicyError::NotOnnx { file: file.to_owned(), reason };
    let model = ModelProto::decode(bytes).map_err(|e| not_onnx(e.to_string()))?;
    if model.graph.is_none() {
        return Err(not_onnx("it holds no graph".into()));
    }
    let text = model
        .metadata_props
        .iter()
        .find(|entry| entry.key == CONTRACT_KEY)
        .ok_or_else(|| PolicyError::NoContract { file: file.to_owned(), key: CONTRACT_KEY })?;
    let contract = PolicyContract::from_json(&text.value)
        .map_err(|error| PolicyError::Contract { file: file.to_owned(), error })?;
    Ok((model, contract))
}

/// What is wrong with the outermost fields.
enum Fault {
    /// No field of an ONNX model begins at this byte.
    Foreign(u64),
    /// The field that begins at byte `part` ends at byte `needs`, beyond the file.
    Cut { part: u64, needs: u64 },
}

/// Walks the outermost fields of the message. Protocol buffers have no magic number, and a decoder says the same of a
/// text, of a picture and of a model that was cut off: this walk tells them apart.
fn check_fields(bytes: &[u8]) -> Result<(), Fault> {
    if bytes.is_empty() {
        return Err(Fault::Foreign(0));
    }
    let total = bytes.len() as u64;
    let mut at = 0;
    while at < bytes.len() {
        let part = at as u64;
        let cut = |needs| Err(Fault::Cut { part, needs });
        let tag = match varint(bytes, &mut at) {
            Ok(tag) => tag,
            Err(true) => return cut(total + 1),
            Err(false) => return Err(Fault::Foreign(part)),
        };
        // Fields of ModelProto in onnx.proto: versions are numbers, the rest has a length. Beyond 15 there may be new
        // ones.
        let place = (tag >> 3, tag & 7);
        if !matches!(place, (1 | 5, 0) | (2 | 3 | 4 | 6 | 7 | 8 | 14, 2) | (16..=63, 0 | 1 | 2 | 5)) {
            return Err(Fault::Foreign(part));
        }
        let length = match tag & 7 {
            1 => 8,
            5 => 4,
            kind => match varint(bytes, &mut at) {
                Ok(number) => number * u64::from(kind == 2),
                Err(true) => return cut(total + 1),
                Err(false) => return Err(Fault::Foreign(part)),
            },
        };
        let end = (at as u64).saturating_add(length);
        if end > total {
            return cut(end);
        }
        at = end as usize;
    }
    Ok(())
}

/// A number of seven bits a byte, low bits first. `Err(true)`: the bytes end within it; `Err(false)`: it does not fit
/// 64 bits.
fn varint(bytes: &[u8], at: &mut usize) -> Result<u64, bool> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let byte = *bytes.get(*at).ok_or(true)?;
        *at += 1;
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Ok(value);
        }
    }
    Err(false)
}
