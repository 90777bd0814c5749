//! The normaliser ahead of a network, taken out of its graph: one plain loop takes a tenth of the time of the three
//! operators in the inference library, which were a third of a whole decision.

use super::policy_graph::{INPUT, OUTPUT, tensor_values};
use crate::asset::policy_contract::Normaliser;
use tract_onnx::pb::tensor_proto::DataType;
use tract_onnx::pb::{GraphProto, ModelProto, NodeProto};

/// Takes Sub, Mul and Clip off the front of a checked graph, where they are the contract's normaliser and nothing else
/// uses what they make. The graph's input is the normalised observation then, and the result true.
pub(crate) fn take_normaliser(model: &mut ModelProto, normaliser: &Normaliser) -> bool {
    let Some(graph) = &mut model.graph else { return false };
    let Some(normalised) = output_of(graph, normaliser) else { return false };
    graph.node.drain(..3);
    let (nodes, initializers) = (&graph.node, &mut graph.initializer);
    initializers.retain(|tensor| nodes.iter().any(|node| node.input.contains(&tensor.name)));
    graph.input[0].name = normalised;
    true
}

/// Name of what the normaliser at the front of the graph makes; `None` if there is something else.
fn output_of(graph: &GraphProto, normaliser: &Normaliser) -> Option<String> {
    let [sub, mul, clip, ..] = &*graph.node else { return None };
    let (mean, centred) = operands(sub, "Sub")?;
    let (scale, scaled) = operands(mul, "Mul")?;
    let (bounds, normalised) = operands(clip, "Clip")?;
    let chain = sub.input[0] == INPUT && mul.input[0] == *centred && clip.input[0] == *scaled;
    let alone = |name: &str| graph.node.iter().flat_map(|n| &n.input).filter(|i| *i == name).count() == 1;
    let clip = normaliser.clip;
    let same = is(graph, mean.first()?, &normaliser.mean)
        && is(graph, scale.first()?, &normaliser.scale)
        && is(graph, bounds.first()?, &[-clip])
        && is(graph, bounds.get(1)?, &[clip]);
    let apart = [INPUT, centred, scaled].into_iter().all(alone) && normalised != OUTPUT;
    (chain && same && apart).then(|| normalised.clone())
}

/// Inputs but the first, and the output of a node of this kind.
fn operands<'a>(node: &'a NodeProto, kind: &str) -> Option<(&'a [String], &'a String)> {
    let plain = node.op_type == kind && node.attribute.is_empty();
    match (&*node.input, &*node.output) {
        ([_, rest @ ..], [output]) if plain => Some((rest, output)),
        _ => None,
    }
}

/// Whether a tensor of the file holds just these numbers.
fn is(graph: &GraphProto, name: &str, numbers: &[f32]) -> bool {
    let tensor = graph.initializer.iter().find(|t| t.name == name && t.data_type == DataType::Float as i32);
    tensor.is_some_and(|t| tensor_values(t).eq(numbers.iter().copied()))
}
