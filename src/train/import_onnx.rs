//! Reading a policy file back as layers, to train it further. Features `train` and `policy`.

use crate::asset::dense_layers::{Activation, DenseLayer, DenseLayers, LayersError};
use crate::asset::policy_contract::PolicyContract;
use crate::control::{Policy, PolicyError, check_and_clean, decode, read_bytes, tensor_values};
use std::collections::HashMap;
use std::path::Path;
use tract_onnx::pb::{GraphProto, NodeProto};

/// Why a policy file cannot be trained further.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// The file is refused.
    #[error(transparent)]
    Policy(#[from] PolicyError),
    /// The network is no chain of dense layers with one activation between them.
    #[error(
        "{file}: node `{node}`: {reason}; valid for training: a normaliser, then Gemm layers with Tanh or Elu between them"
    )]
    Layers {
        /// The file.
        file: String,
        /// Where the chain breaks.
        node: String,
        /// How.
        reason: &'static str,
    },
    /// The layers do not fit each other.
    #[error("{file}: {error}")]
    Sizes {
        /// The file.
        file: String,
        /// What does not fit.
        error: LayersError,
    },
}

/// Layers and contract of a policy file. The file is checked like [`Policy::load`] does; its normaliser is the contract's.
pub fn load_layers(path: impl AsRef<Path>) -> Result<(DenseLayers, PolicyContract), ImportError> {
    let path = path.as_ref();
    layers_from_bytes(&read_bytes(path)?, &path.display().to_string())
}

/// Layers and contract of a policy file's bytes; `file` is for messages.
pub fn layers_from_bytes(bytes: &[u8], file: &str) -> Result<(DenseLayers, PolicyContract), ImportError> {
    Policy::from_bytes(bytes, file)?;
    let (mut model, contract) = decode(bytes, file)?;
    if check_and_clean(&mut model).is_err() {
        // Policy::from_bytes has passed it.
        return Err(PolicyError::NotOnnx { file: file.into(), reason: "its graph is refused".into() }.into());
    }
    let graph = model.graph.unwrap_or_default();
    let layers =
        chain(&graph).map_err(|(node, reason)| ImportError::Layers { file: file.into(), node: node.into(), reason })?;
    layers.check().map_err(|error| ImportError::Sizes { file: file.into(), error })?;
    Ok((layers, contract))
}

/// Follows the graph from its first layer to its end.
fn chain(graph: &GraphProto) -> Result<DenseLayers, (&str, &'static str)> {
    let tensors: HashMap<&str, _> = graph.initializer.iter().map(|t| (t.name.as_str(), t)).collect();
    // What a constant is after casts: the tensor behind it.
    let cast = |name: &str| graph.node.iter().find(|n| n.op_type == "Cast" && n.output[0] == name);
    let numbers = |name: &str| {
        let name = cast(name).map_or(name, |n| n.input[0].as_str());
        tensors.get(name).map(|t| (t.dims.clone(), tensor_values(t).collect::<Vec<f32>>()))
    };
    let first = graph.node.iter().find(|n| n.op_type == "Gemm").ok_or(("", "there is no Gemm"))?;
    let takers =
        |value: &str| -> Vec<&NodeProto> { graph.node.iter().filter(|n| n.input.iter().any(|i| i == value)).collect() };
    let mut layers = DenseLayers { sizes: Vec::new(), activation: Activation::Tanh, layers: Vec::new() };
    let mut activation = None;
    let mut node = first;
    loop {
        let here = node.output[0].as_str();
        let factor = |name: &str| node.attribute.iter().any(|a| a.name == name && a.f != 1.0);
        if factor("alpha") || factor("beta") {
            return Err((here, "has a factor"));
        }
        let (dims, mut weights) = numbers(&node.input[1]).ok_or((here, "its weights are computed"))?;
        let &[rows, columns] = &dims[..] else { return Err((here, "its weights are no matrix")) };
        let (mut outputs, mut inputs) = (rows as usize, columns as usize);
        if !node.attribute.iter().any(|a| a.name == "transB" && a.i == 1) {
            weights = (0..weights.len()).map(|k| weights[transposed(k, outputs, inputs)]).collect();
            (outputs, inputs) = (inputs, outputs);
        }
        let bias = match node.input.get(2).filter(|name| !name.is_empty()) {
            Some(name) => numbers(name).ok_or((here, "its bias is computed"))?.1,
            None => vec![0.0; outputs],
        };
        if layers.sizes.is_empty() {
            layers.sizes.push(inputs);
        }
        layers.sizes.push(outputs);
        layers.layers.push(DenseLayer { weights, bias });
        if here == "action" {
            layers.activation = activation.unwrap_or(Activation::Tanh);
            return Ok(layers);
        }
        let [next] = &takers(here)[..] else { return Err((here, "its output goes to several nodes or none")) };
        let kind = match next.op_type.as_str() {
            "Tanh" => Activation::Tanh,
            "Elu" if next.attribute.iter().all(|a| a.f == 1.0) => Activation::Elu,
            _ => return Err((&next.output[0], "is no Tanh or Elu")),
        };
        if activation.replace(kind).is_some_and(|before| before != kind) {
            return Err((&next.output[0], "is another activation than before"));
        }
        let value = next.output[0].as_str();
        node = match &takers(value)[..] {
            [layer] if layer.op_type == "Gemm" && layer.input[0] == value => layer,
            _ => return Err((value, "is followed by no Gemm")),
        };
    }
}

/// Place in a matrix of `rows` x `columns` of number `k` of its transpose.
fn transposed(k: usize, rows: usize, columns: usize) -> usize {
    let (column, row) = (k / rows, k % rows);
    row * columns + column
}
