//! Why a policy file was refused, or could not act.

use crate::asset::policy_contract::ContractError;
use crate::asset::policy_fit::PolicyMisfit;

/// Why a policy was refused. Every message names the file, the place in it, what is there and what would be valid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PolicyError {
    /// The file is missing or cannot be read.
    #[error("{file}: cannot be read: {reason}")]
    Read {
        /// File name as given.
        file: String,
        /// The operating system's reason.
        reason: String,
    },
    /// The file is larger than any sensible policy.
    #[error("{file}: {bytes} bytes; valid: at most {limit} bytes")]
    TooLarge {
        /// File name as given.
        file: String,
        /// Size found, bytes.
        bytes: u64,
        /// Largest size, bytes.
        limit: u64,
    },
    /// The bytes are no ONNX model.
    #[error("{file}: not an ONNX model: {reason}")]
    NotOnnx {
        /// File name as given.
        file: String,
        /// Where and why.
        reason: String,
    },
    /// The file ends too early.
    #[error("{file}: ends too early: {bytes} bytes; the part that begins at byte {part} needs at least {needs}")]
    Truncated {
        /// File name as given.
        file: String,
        /// Size found, bytes.
        bytes: u64,
        /// Where the part begins that is cut off.
        part: u64,
        /// Bytes that the file would need for this part.
        needs: u64,
    },
    /// An ONNX model without a contract.
    #[error(
        "{file}: no contract in the model's metadata; valid: JSON under the key `{key}`, see docs/book/policies.md"
    )]
    NoContract {
        /// File name as given.
        file: String,
        /// The key.
        key: &'static str,
    },
    /// The contract is not one.
    #[error("{file}: {error}")]
    Contract {
        /// File name as given.
        file: String,
        /// Where and why.
        error: ContractError,
    },
    /// The graph is not a feed-forward network from observations to actions.
    #[error("{file}: {place}: {reason}")]
    Graph {
        /// File name as given.
        file: String,
        /// The node, tensor or value.
        place: String,
        /// What is wrong and what would be valid.
        reason: String,
    },
    /// A weight is not a finite number.
    #[error("{file}: tensor `{tensor}`: number {index} is {value}; valid: finite numbers")]
    NotFinite {
        /// File name as given.
        file: String,
        /// The tensor.
        tensor: String,
        /// Place in the tensor, from 0.
        index: usize,
        /// What it holds.
        value: f32,
    },
    /// The network takes or gives more or fewer numbers than the contract's layout says.
    #[error("{file}: the network's {end} has {network} numbers, the contract's layout {layout}; valid: as many")]
    Size {
        /// File name as given.
        file: String,
        /// `observation` or `action`.
        end: &'static str,
        /// Numbers in the network.
        network: usize,
        /// Numbers in the layout.
        layout: usize,
    },
    /// The network does not give the action that its trainer wrote down.
    #[error(
        "{file}: golden pair: action number {index} is {found}, expected {expected}: differs by {difference:e}; \
         valid: at most {tolerance:e}"
    )]
    Golden {
        /// File name as given.
        file: String,
        /// Which number of the action, from 0.
        index: usize,
        /// What the network gives.
        found: f32,
        /// What the trainer wrote down.
        expected: f32,
        /// Size of the difference.
        difference: f64,
        /// Largest allowed difference.
        tolerance: f64,
    },
    /// The inference library refused the network.
    #[error("{file}: the network cannot be run: {reason}")]
    Network {
        /// File name as given.
        file: String,
        /// The library's reason.
        reason: String,
    },
    /// The contract is not what would be played.
    #[error("{file}: a policy of `{skill}` by `{character}` that does not fit what is played: {misfit}")]
    Misfit {
        /// File name as given.
        file: String,
        /// The contract's skill.
        skill: String,
        /// The contract's character.
        character: String,
        /// The first field that differs.
        misfit: Box<PolicyMisfit>,
    },
    /// Observations of the wrong length were passed in.
    #[error("{file}: {found} numbers for {rows} observations of {size}; valid: {rows} x {size}")]
    Rows {
        /// File name as given.
        file: String,
        /// Numbers passed in.
        found: usize,
        /// Observations asked for.
        rows: usize,
        /// Numbers in an observation.
        size: usize,
    },
}
