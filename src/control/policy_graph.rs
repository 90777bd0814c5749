//! Checks that an ONNX graph is a plain feed-forward network, before any of it is run.
//!
//! A file may come from anywhere. So that nothing in it can make the inference library panic, allocate without bound or
//! read other files, only graphs of a small language pass: one input `observation`, one output `action`, both rows of
//! f32; the operators of [`OPERATORS`]; weights inside the file, finite, of f32 or of f16 that is cast to it; every name
//! defined once, before its use; shapes that fit. What passes is cleaned of everything that inference does not need.

use std::collections::HashMap;
use tract_onnx::pb::tensor_proto::DataType;
use tract_onnx::pb::{AttributeProto, GraphProto, ModelProto, NodeProto, TensorProto, ValueInfoProto};
use tract_onnx::pb::{attribute_proto::AttributeType, type_proto};

/// Operators that a policy may use.
pub const OPERATORS: [&str; 19] = [
    "Add",
    "Cast",
    "Clip",
    "Constant",
    "Div",
    "Elu",
    "Gemm",
    "Identity",
    "LeakyRelu",
    "MatMul",
    "Max",
    "Min",
    "Mul",
    "Relu",
    "Selu",
    "Sigmoid",
    "Softplus",
    "Sub",
    "Tanh",
];

/// Name of the graph's input.
pub(crate) const INPUT: &str = "observation";
/// Name of the graph's output.
pub(crate) const OUTPUT: &str = "action";
/// Oldest operator set; before it, Clip had its bounds elsewhere.
const OLDEST_OPSET: i64 = 11;
/// Most nodes in a graph.
const MAX_NODES: usize = 1000;
/// Most multiplications and other operations for one action, whatever the weights' size: a graph may use the same
/// weights again and again.
const MAX_WORK: usize = 1 << 24;

/// What is wrong with a graph.
#[derive(Debug)]
pub(crate) enum GraphFault {
    /// Something is not in the language, or does not fit.
    Place { place: String, reason: String },
    /// A weight is not finite.
    NotFinite { tensor: String, index: usize, value: f32 },
}

fn fault<T>(place: impl Into<String>, reason: impl Into<String>) -> Result<T, GraphFault> {
    Err(GraphFault::Place { place: place.into(), reason: reason.into() })
}

/// Shape of a value in the graph.
#[derive(Clone, Debug)]
enum Shape {
    /// One row of so many numbers for each observation.
    Rows(usize),
    /// A constant with these dimensions.
    Constant(Vec<usize>),
    /// A constant of f16: it has to be cast before its use.
    Half(Vec<usize>),
}

impl Shape {
    /// Numbers in it; of rows, in one row.
    fn count(&self) -> usize {
        match self {
            Self::Rows(width) => *width,
            Self::Constant(dims) | Self::Half(dims) => dims.iter().product(),
        }
    }
}

/// Numbers in an observation and in an action.
pub(crate) struct Widths {
    pub observation: usize,
    pub action: usize,
}

/// Checks the model and removes what inference does not need.
pub(crate) fn check_and_clean(model: &mut ModelProto) -> Result<Widths, GraphFault> {
    let opset = model.opset_import.iter().find(|o| o.domain.is_empty() || o.domain == "ai.onnx").map(|o| o.version);
    match opset {
        Some(version) if version >= OLDEST_OPSET => {}
        Some(version) => return fault("operator set", format!("is {version}; valid: {OLDEST_OPSET} or later")),
        None => return fault("operator set", format!("is not named; valid: {OLDEST_OPSET} or later")),
    }
    if !model.functions.is_empty() || !model.training_info.is_empty() {
        return fault("model", "has functions or training graphs; valid: one graph");
    }
    let Some(graph) = &mut model.graph else { return fault("model", "has no graph") };
    let widths = check_graph(graph)?;

    graph.value_info.clear();
    graph.quantization_annotation.clear();
    for (k, node) in graph.node.iter_mut().enumerate() {
        node.name = format!("node {k}");
    }
    model.metadata_props.clear();
    Ok(widths)
}

fn check_graph(graph: &GraphProto) -> Result<Widths, GraphFault> {
    if graph.node.len() > MAX_NODES {
        return fault("graph", format!("has {} nodes; valid: at most {MAX_NODES}", graph.node.len()));
    }
    if !graph.sparse_initializer.is_empty() {
        return fault("graph", "has sparse tensors; valid: dense ones");
    }
    let (input, output) = match (&*graph.input, &*graph.output) {
        ([input], [output]) => (input, output),
        (inputs, outputs) => {
            let reason = format!("has {} inputs and {} outputs; valid: one of each", inputs.len(), outputs.len());
            return fault("graph", reason);
        }
    };
    for (value, name) in [(input, INPUT), (output, OUTPUT)] {
        if value.name != name {
            return fault("graph", format!("has an end named `{}`; valid: `{name}`", value.name));
        }
    }
    let observation = row_width(input)?;
    let mut values: HashMap<&str, Shape> = HashMap::new();
    values.insert(INPUT, Shape::Rows(observation));
    for tensor in &graph.initializer {
        let shape = check_tensor(tensor, &tensor.name)?;
        define(&mut values, &tensor.name, shape)?;
    }
    let mut work = 0usize;
    for node in &graph.node {
        let shape = node_shape(node, &values)?;
        let largest = node.input.iter().filter_map(|name| values.get(name.as_str())).map(Shape::count).max();
        work = work.saturating_add(largest.unwrap_or(0).max(shape.count()));
        if work > MAX_WORK {
            return fault("graph", format!("takes more than {MAX_WORK} operations an action; valid: at most as many"));
        }
        define(&mut values, &node.output[0], shape)?;
    }
    match values.get(OUTPUT) {
        Some(Shape::Rows(action)) => Ok(Widths { observation, action: *action }),
        Some(Shape::Constant(_) | Shape::Half(_)) => {
            fault(format!("output `{OUTPUT}`"), "does not depend on the observation")
        }
        None => fault(format!("output `{OUTPUT}`"), "is given by no node"),
    }
}

fn define<'a>(values: &mut HashMap<&'a str, Shape>, name: &'a str, shape: Shape) -> Result<(), GraphFault> {
    if name.is_empty() || values.insert(name, shape).is_some() {
        return fault(format!("value `{name}`"), "is blank or defined twice; valid: a name defined once");
    }
    Ok(())
}

/// Width of the input, which has to be f32 of shape \[batch, width\].
fn row_width(value: &ValueInfoProto) -> Result<usize, GraphFault> {
    use tract_onnx::pb::tensor_shape_proto::dimension::Value;
    let place = format!("input `{}`", value.name);
    let Some(type_proto::Value::TensorType(tensor)) = value.r#type.as_ref().and_then(|t| t.value.as_ref()) else {
        return fault(place, "has no tensor type; valid: f32 of shape [batch, numbers]");
    };
    if tensor.elem_type != DataType::Float as i32 {
        return fault(place, format!("has element type {}; valid: {} (f32)", tensor.elem_type, DataType::Float as i32));
    }
    let dims = tensor.shape.as_ref().map_or(&[][..], |s| &*s.dim);
    match dims {
        [_, last] => match last.value {
            Some(Value::DimValue(n)) if n >= 1 => usize::try_from(n).or_else(|_| fault(place, "is too wide")),
            _ => fault(place, "has no fixed width; valid: shape [batch, numbers] with numbers fixed"),
        },
        _ => fault(place, format!("has {} dimensions; valid: 2, [batch, numbers]", dims.len())),
    }
}

/// Shape of a tensor inside the file: f32 or f16, finite, as many numbers as its dimensions say.
fn check_tensor(tensor: &TensorProto, name: &str) -> Result<Shape, GraphFault> {
    let place = || format!("tensor `{name}`");
    let (single, half) = (DataType::Float as i32, DataType::Float16 as i32);
    if ![single, half].contains(&tensor.data_type) {
        let reason = format!("has type {}; valid: {single} (f32) or {half} (f16)", tensor.data_type);
        return fault(place(), reason);
    }
    if tensor.data_location.is_some_and(|l| l != 0) || !tensor.external_data.is_empty() || tensor.segment.is_some() {
        return fault(place(), "lies outside the file or in pieces; valid: inside the file, whole");
    }
    if tensor.dims.len() > 2 || tensor.dims.iter().any(|d| *d < 1) {
        return fault(place(), format!("has dimensions {:?}; valid: at most two, each at least 1", tensor.dims));
    }
    let count = tensor.dims.iter().try_fold(1i64, |n, d| n.checked_mul(*d)).unwrap_or(i64::MAX);
    let raw = &tensor.raw_data;
    let bytes = if tensor.data_type == half { 2 } else { 4 };
    let listed = &tensor.float_data;
    let found = if raw.is_empty() { listed.len() } else { raw.len() / bytes };
    if found as i64 != count || !raw.len().is_multiple_of(bytes) || (!raw.is_empty() && !listed.is_empty()) {
        return fault(place(), format!("holds {found} numbers; valid: {count}, as its dimensions say"));
    }
    if tensor.data_type == half && raw.is_empty() {
        return fault(place(), "of f16 is written as a list; valid: as raw data");
    }
    if let Some((index, value)) = tensor_values(tensor).enumerate().find(|(_, v)| !v.is_finite()) {
        return Err(GraphFault::NotFinite { tensor: name.to_owned(), index, value });
    }
    let dims = tensor.dims.iter().map(|d| *d as usize).collect();
    Ok(if tensor.data_type == half { Shape::Half(dims) } else { Shape::Constant(dims) })
}

/// The numbers of a tensor of f32, or of f16 in raw data.
pub(crate) fn tensor_values(tensor: &TensorProto) -> impl Iterator<Item = f32> {
    let half = tensor.data_type == DataType::Float16 as i32;
    let raw = tensor.raw_data.chunks_exact(if half { 2 } else { 4 }).map(|b| match *b {
        [a, b] => half::f16::from_le_bytes([a, b]).to_f32(),
        [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
        _ => f32::NAN,
    });
    raw.chain(tensor.float_data.iter().copied())
}

/// Shape of a node's only output.
fn node_shape(node: &NodeProto, values: &HashMap<&str, Shape>) -> Result<Shape, GraphFault> {
    let place = || format!("node `{}` ({})", node.output.first().map_or("", |o| o), node.op_type);
    let op = node.op_type.as_str();
    if !OPERATORS.contains(&op) || !(node.domain.is_empty() || node.domain == "ai.onnx") {
        return fault(place(), format!("the operator is not one of a policy's; valid: {}", OPERATORS.join(", ")));
    }
    if node.output.len() != 1 {
        return fault(place(), format!("has {} outputs; valid: 1", node.output.len()));
    }
    if op == "Constant" {
        return constant_shape(node, place());
    }
    check_attributes(node, place())?;
    if op == "Cast" && !node.attribute.iter().any(|a| a.name == "to") {
        return fault(place(), "says no type; valid: the attribute `to` of 1 (f32)");
    }
    let (least, most) = match op {
        "Clip" => (1, 3),
        "Gemm" => (2, 3),
        "Add" | "Sub" | "Mul" | "Div" | "Min" | "Max" | "MatMul" => (2, 2),
        _ => (1, 1),
    };
    if !(least..=most).contains(&node.input.len()) {
        return fault(place(), format!("has {} inputs; valid: {least} to {most}", node.input.len()));
    }
    let mut shapes = Vec::with_capacity(3);
    for (k, name) in node.input.iter().enumerate() {
        match values.get(name.as_str()) {
            Some(shape) => shapes.push(Some(shape)),
            // An optional input left out.
            None if name.is_empty() && k >= least => shapes.push(None),
            None => return fault(place(), format!("takes `{name}`, which is not defined before it")),
        }
    }
    let unfit = || fault(place(), format!("operands of shape {shapes:?} do not fit"));
    match (op, &*shapes) {
        ("Clip", [Some(Shape::Rows(width)), bounds @ ..]) => {
            let single = |s: &Option<&Shape>| match s {
                Some(Shape::Constant(dims)) => dims.is_empty() || dims == &[1],
                Some(Shape::Rows(_) | Shape::Half(_)) => false,
                None => true,
            };
            if bounds.iter().all(single) { Ok(Shape::Rows(*width)) } else { unfit() }
        }
        ("MatMul", [Some(Shape::Rows(width)), Some(Shape::Constant(dims))]) => match **dims {
            [from, to] if from == *width => Ok(Shape::Rows(to)),
            _ => unfit(),
        },
        ("Gemm", [Some(Shape::Rows(width)), Some(Shape::Constant(dims)), bias @ ..]) => {
            let transposed = node.attribute.iter().any(|a| a.name == "transB" && a.i == 1);
            let to = match **dims {
                [from, to] if !transposed && from == *width => to,
                [to, from] if transposed && from == *width => to,
                _ => return unfit(),
            };
            let fits = |s: &Option<&Shape>| match s {
                Some(Shape::Constant(dims)) => fits_row(dims, to),
                Some(Shape::Rows(_) | Shape::Half(_)) => false,
                None => true,
            };
            if bias.iter().all(fits) { Ok(Shape::Rows(to)) } else { unfit() }
        }
        // Weights may be kept in half precision; nothing else changes its type.
        ("Cast", [Some(Shape::Half(dims))]) => Ok(Shape::Constant(dims.clone())),
        ("MatMul" | "Gemm" | "Clip" | "Cast", _) => unfit(),
        ("Identity", [Some(shape)]) => Ok((*shape).clone()),
        // Element by element from here on.
        (_, [Some(Shape::Rows(width))]) => Ok(Shape::Rows(*width)),
        (_, [Some(Shape::Rows(a)), Some(Shape::Rows(b))]) if a == b => Ok(Shape::Rows(*a)),
        (_, [Some(Shape::Rows(width)), Some(Shape::Constant(dims))])
        | (_, [Some(Shape::Constant(dims)), Some(Shape::Rows(width))])
            if fits_row(dims, *width) =>
        {
            Ok(Shape::Rows(*width))
        }
        _ => unfit(),
    }
}

/// Whether a constant can be added to every row without changing the rows' width.
fn fits_row(dims: &[usize], width: usize) -> bool {
    match *dims {
        [] => true,
        [last] | [1, last] => last == 1 || last == width,
        _ => false,
    }
}

fn constant_shape(node: &NodeProto, place: String) -> Result<Shape, GraphFault> {
    match (&*node.input, &*node.attribute) {
        ([], [AttributeProto { name, t: Some(tensor), r#type, ref_attr_name, .. }])
            if name == "value" && *r#type == AttributeType::Tensor as i32 && ref_attr_name.is_empty() =>
        {
            check_tensor(tensor, &node.output[0])
        }
        _ => fault(place, "holds something else than one tensor; valid: the attribute `value`"),
    }
}

/// Attributes that the operators may have: finite factors, whether weights are transposed, and f32 as the type of a cast.
fn check_attributes(node: &NodeProto, place: String) -> Result<(), GraphFault> {
    for attribute in &node.attribute {
        let AttributeProto { name, f, i, r#type, ref_attr_name, .. } = attribute;
        let number = *r#type == AttributeType::Float as i32 && f.is_finite();
        let flag = |most| *r#type == AttributeType::Int as i32 && (0..=most).contains(i);
        let good = match (node.op_type.as_str(), name.as_str()) {
            ("Gemm" | "Elu" | "LeakyRelu" | "Selu", "alpha") | ("Gemm", "beta") | ("Selu", "gamma") => number,
            ("Gemm", "transA") => flag(0),
            ("Gemm", "transB") | ("Cast", "saturate") => flag(1),
            ("Cast", "to") => *r#type == AttributeType::Int as i32 && *i == DataType::Float as i64,
            _ => false,
        };
        let twice = node.attribute.iter().filter(|a| a.name == *name).count() > 1;
        if !good || twice || !ref_attr_name.is_empty() {
            return fault(place, format!("attribute `{name}` is unknown, doubled or has a value that cannot be used"));
        }
    }
    Ok(())
}
