//! Affine policies: one matrix and an offset, y = W x + b, run by a plain loop.
//!
//! The same file format and contract as any other policy: a graph of one Gemm behind the normaliser. Sums are made in f64, in an order
//! of their own, so an action has the same bits on every machine and whatever its neighbours in the batch are.

use super::policy_graph::{OUTPUT, tensor_values};
use tract_onnx::pb::{GraphProto, ModelProto, TensorProto};

/// Sums that are made side by side.
const WIDTH: usize = 4;

/// The matrix and the offset.
pub(crate) struct AffineMap {
    inputs: usize,
    /// Outputs x inputs, row-major.
    weights: Vec<f32>,
    bias: Vec<f32>,
}

impl AffineMap {
    /// The map of a checked graph that is one Gemm and nothing else; weights may be cast from half precision.
    pub(crate) fn of(model: &ModelProto) -> Option<Self> {
        let graph = model.graph.as_ref()?;
        let gemm = graph.node.last()?;
        let casts = &graph.node[..graph.node.len() - 1];
        let plain = gemm.op_type == "Gemm"
            && gemm.output.first()? == OUTPUT
            && gemm.input.first()? == &graph.input.first()?.name;
        let factor = gemm.attribute.iter().any(|a| matches!(&*a.name, "alpha" | "beta") && a.f != 1.0);
        if !plain || factor || casts.iter().any(|node| node.op_type != "Cast") {
            return None;
        }
        let weights = constant(graph, gemm.input.get(1)?)?;
        let &[rows, columns] = &*weights.dims else { return None };
        let (rows, columns) = (usize::try_from(rows).ok()?, usize::try_from(columns).ok()?);
        let numbers: Vec<f32> = tensor_values(weights).collect();
        let transposed = gemm.attribute.iter().any(|a| a.name == "transB" && a.i == 1);
        let (inputs, outputs, weights) = if transposed {
            (columns, rows, numbers)
        } else {
            (rows, columns, (0..rows * columns).map(|k| numbers[k % rows * columns + k / rows]).collect())
        };
        let bias = match gemm.input.get(2).filter(|name| !name.is_empty()) {
            Some(name) => tensor_values(constant(graph, name)?).collect(),
            None => vec![0.0; outputs],
        };
        (bias.len() == outputs).then_some(Self { inputs, weights, bias })
    }

    /// One action for one row of what the map takes.
    pub(crate) fn apply(&self, row: &[f32], action: &mut [f32]) {
        for ((out, weights), bias) in action.iter_mut().zip(self.weights.chunks_exact(self.inputs)).zip(&self.bias) {
            let mut sums = [0.0_f64; WIDTH];
            let (whole, rest) = (row.chunks_exact(WIDTH), row.chunks_exact(WIDTH).remainder());
            let (weights, last) = (weights.chunks_exact(WIDTH), weights.chunks_exact(WIDTH).remainder());
            for (x, w) in whole.zip(weights) {
                for (sum, (x, w)) in sums.iter_mut().zip(x.iter().zip(w)) {
                    *sum += f64::from(*x) * f64::from(*w);
                }
            }
            for (sum, (x, w)) in sums.iter_mut().zip(rest.iter().zip(last)) {
                *sum += f64::from(*x) * f64::from(*w);
            }
            *out = ((sums[0] + sums[1]) + (sums[2] + sums[3]) + f64::from(*bias)) as f32;
        }
    }
}

/// The tensor behind a name, which may be cast.
fn constant<'a>(graph: &'a GraphProto, name: &str) -> Option<&'a TensorProto> {
    let cast = graph.node.iter().find(|node| node.op_type == "Cast" && node.output.first().is_some_and(|o| o == name));
    let name = cast.and_then(|node| node.input.first()).map_or(name, String::as_str);
    graph.initializer.iter().find(|tensor| tensor.name == name)
}
