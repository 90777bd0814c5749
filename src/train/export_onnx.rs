//! Writing a trained network as a policy file. Features `train` and `policy`.
//!
//! The graph is Sub, Mul, Clip (the normaliser), then one Gemm for each layer with the activation between them:
//! operator set 17, which every ONNX runtime of the last years knows. The batch is a free dimension. Weights that f16 holds
//! exactly are written as f16, with a Cast to f32 behind: half the file for the same numbers.

use crate::asset::dense_layers::{Activation, DenseLayers, LayersError};
use crate::asset::policy_contract::{CONTRACT_KEY, ContractError, PolicyContract};
use crate::control::{Policy, PolicyError};
use prost::Message;
use std::path::{Path, PathBuf};
use tract_onnx::pb::attribute_proto::AttributeType;
use tract_onnx::pb::tensor_proto::DataType;
use tract_onnx::pb::tensor_shape_proto::{Dimension, dimension};
use tract_onnx::pb::{
    AttributeProto, GraphProto, ModelProto, NodeProto, OperatorSetIdProto, StringStringEntryProto, TensorProto,
    TensorShapeProto, TypeProto, ValueInfoProto, type_proto,
};

/// Version of the container format: that of operator set 17.
const IR_VERSION: i64 = 8;
/// Version of the operators.
const OPSET: i64 = 17;

/// Why a network was not written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The layers are no network.
    #[error(transparent)]
    Layers(#[from] LayersError),
    /// The contract cannot be used.
    #[error(transparent)]
    Contract(#[from] ContractError),
    /// The network takes or gives more or fewer numbers than the contract's layout says.
    #[error("network: its {end} has {network} numbers, the contract's layout {layout}; valid: as many")]
    Size {
        /// `observation` or `action`.
        end: &'static str,
        /// Numbers in the network.
        network: usize,
        /// Numbers in the layout.
        layout: usize,
    },
    /// The file, read back, is refused: its golden pair differs, for one.
    #[error("as written: {0}")]
    ReadBack(#[from] PolicyError),
    /// The file could not be written.
    #[error("{}: cannot be written: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
}

/// Writes a policy file, after reading it back from memory and checking it as any reader would, golden pair included.
/// An earlier file of the name is replaced at once or not at all.
pub fn save_policy(
    path: impl AsRef<Path>,
    layers: &DenseLayers,
    contract: &PolicyContract,
) -> Result<Policy, ExportError> {
    let path = path.as_ref();
    let bytes = policy_bytes(layers, contract)?;
    let policy = Policy::from_bytes(&bytes, &path.display().to_string())?;
    let mut beside = path.as_os_str().to_owned();
    beside.push(".part");
    std::fs::write(&beside, &bytes)
        .and_then(|()| std::fs::rename(&beside, path))
        .map_err(|e| ExportError::Write { path: path.to_path_buf(), reason: e.to_string() })?;
    Ok(policy)
}

/// The bytes of a policy file: the contract's normaliser, the layers, the contract. The golden pair is taken as it is,
/// so that it proves to a reader that the file computes what the trainer's own network did.
pub fn policy_bytes(layers: &DenseLayers, contract: &PolicyContract) -> Result<Vec<u8>, ExportError> {
    layers.check()?;
    let metadata = contract.to_json()?;
    for (end, network, layout) in [
        ("observation", layers.inputs(), contract.observation_size()),
        ("action", layers.outputs(), contract.action_size()),
    ] {
        if network != layout {
            return Err(ExportError::Size { end, network, layout });
        }
    }
    let model = ModelProto {
        ir_version: IR_VERSION,
        opset_import: vec![OperatorSetIdProto { domain: String::new(), version: OPSET }],
        producer_name: "bevy_athlete".into(),
        producer_version: env!("CARGO_PKG_VERSION").into(),
        graph: Some(graph(layers, contract)),
        metadata_props: vec![StringStringEntryProto { key: CONTRACT_KEY.into(), value: metadata }],
        ..ModelProto::default()
    };
    Ok(model.encode_to_vec())
}

fn graph(layers: &DenseLayers, contract: &PolicyContract) -> GraphProto {
    let normaliser = &contract.normaliser;
    let width = layers.inputs();
    let mut initializer = vec![
        tensor("mean", &[width], &normaliser.mean),
        tensor("scale", &[width], &normaliser.scale),
        tensor("low", &[], &[-normaliser.clip]),
        tensor("high", &[], &[normaliser.clip]),
    ];
    let mut nodes = vec![
        node("Sub", &["observation", "mean"], "centred"),
        node("Mul", &["centred", "scale"], "scaled"),
        node("Clip", &["scaled", "low", "high"], "normalised"),
    ];
    let activation = match layers.activation {
        Activation::Tanh => "Tanh",
        Activation::Elu => "Elu",
        Activation::Relu => "Relu",
    };
    let mut value = "normalised".to_owned();
    for (k, (layer, widths)) in layers.layers.iter().zip(layers.sizes.windows(2)).enumerate() {
        let (weights, bias) = (format!("weights_{k}"), format!("bias_{k}"));
        let dims = [widths[1], widths[0]];
        match as_half(&layer.weights) {
            Some(raw) => {
                let half = format!("half_{k}");
                initializer.push(raw_tensor(&half, &dims, DataType::Float16, raw));
                let mut cast = node("Cast", &[&half], &weights);
                cast.attribute.push(integer("to", DataType::Float as i64));
                nodes.push(cast);
            }
            None => initializer.push(tensor(&weights, &dims, &layer.weights)),
        }
        initializer.push(tensor(&bias, &[widths[1]], &layer.bias));
        let last = k + 1 == layers.layers.len();
        let sum = if last { "action".to_owned() } else { format!("sum_{k}") };
        let mut gemm = node("Gemm", &[&value, &weights, &bias], &sum);
        gemm.attribute.push(integer("transB", 1));
        nodes.push(gemm);
        if !last {
            value = format!("hidden_{k}");
            nodes.push(node(activation, &[&sum], &value));
        }
    }
    GraphProto {
        name: contract.skill.clone(),
        node: nodes,
        initializer,
        input: vec![rows("observation", width)],
        output: vec![rows("action", layers.outputs())],
        ..GraphProto::default()
    }
}

fn node(op: &str, inputs: &[&str], output: &str) -> NodeProto {
    NodeProto {
        op_type: op.into(),
        name: format!("make_{output}"),
        input: inputs.iter().map(|i| (*i).to_owned()).collect(),
        output: vec![output.to_owned()],
        ..NodeProto::default()
    }
}

fn integer(name: &str, value: i64) -> AttributeProto {
    AttributeProto { name: name.into(), r#type: AttributeType::Int as i32, i: value, ..AttributeProto::default() }
}

fn tensor(name: &str, dims: &[usize], values: &[f32]) -> TensorProto {
    raw_tensor(name, dims, DataType::Float, values.iter().flat_map(|v| v.to_le_bytes()).collect())
}

fn raw_tensor(name: &str, dims: &[usize], kind: DataType, raw_data: Vec<u8>) -> TensorProto {
    let dims = dims.iter().map(|d| *d as i64).collect();
    TensorProto { name: name.into(), dims, data_type: kind as i32, raw_data, ..TensorProto::default() }
}

/// The bytes of the numbers in half precision, where it holds every one of them exactly.
fn as_half(values: &[f32]) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(2 * values.len());
    for value in values {
        let half = half::f16::from_f32(*value);
        if half.to_f32().to_bits() != value.to_bits() {
            return None;
        }
        bytes.extend(half.to_le_bytes());
    }
    Some(bytes)
}

/// A value of f32 and shape \[batch, width\].
fn rows(name: &str, width: usize) -> ValueInfoProto {
    let dimension = |value| Dimension { value: Some(value), ..Dimension::default() };
    let dim = vec![
        dimension(dimension::Value::DimParam("batch".into())),
        dimension(dimension::Value::DimValue(width as i64)),
    ];
    let tensor = type_proto::Tensor { elem_type: DataType::Float as i32, shape: Some(TensorShapeProto { dim }) };
    let value = Some(type_proto::Value::TensorType(tensor));
    ValueInfoProto {
        name: name.into(),
        r#type: Some(TypeProto { value, ..TypeProto::default() }),
        ..Default::default()
    }
}
