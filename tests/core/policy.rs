//! Contract: a policy file computes what its trainer's network did, says what its numbers mean, and is refused where
//! anything does not fit.
//!
//! The reference is a forward pass in f64 written here, of a dozen lines and without a library: an exporter and a
//! reader that were wrong in the same way would agree with each other, and the golden pair inside the file would agree
//! too. Refusals are tried one by one, because a file that loads and means something else moves a body by wrong numbers
//! without a word.

use crate::policy_support::{contract_for, edited, forward, network, observations};
use bevy_athlete::asset::dense_layers::{Activation, DenseLayers, LayersError};
use bevy_athlete::asset::policy_contract::{ActionMeaning, CONTRACT_KEY, ContractError, PolicyContract};
use bevy_athlete::control::{MAX_POLICY_BYTES, Policy, PolicyError};
use bevy_athlete::math::RandomStream;
use bevy_athlete::train::{ExportError, ImportError, layers_from_bytes, policy_bytes, save_policy};
use prost::Message;
use std::time::Instant;
use tract_onnx::pb::attribute_proto::AttributeType;
use tract_onnx::pb::{AttributeProto, ModelProto, NodeProto, tensor_proto::DataType};

const ACTIVATIONS: [Activation; 3] = [Activation::Tanh, Activation::Elu, Activation::Relu];

/// Largest difference of two rows, relative where numbers are beyond 1.
fn difference(a: &[f32], b: &[f32]) -> f64 {
    assert_eq!(a.len(), b.len());
    let apart = |(a, b): (&f32, &f32)| (f64::from(*a) - f64::from(*b)).abs() / f64::from(*b).abs().max(1.0);
    a.iter().zip(b).map(apart).fold(0.0, f64::max)
}

#[test]
fn the_file_computes_what_the_trainers_network_does() {
    let mut random = RandomStream::new(71, 0);
    let mut worst = 0.0f64;
    let shapes: [&[usize]; 5] =
        [&[300, 128, 128, 128, 51], &[7, 3], &[1, 1, 3], &[33, 64, 6], &[206, 256, 128, 64, 54]];
    for (k, sizes) in shapes.iter().cycle().take(15).enumerate() {
        let layers = network(sizes, ACTIVATIONS[k / 5], &mut random);
        let contract = contract_for(&layers, &mut random);
        let policy = Policy::from_bytes(&policy_bytes(&layers, &contract).unwrap(), "random").unwrap();
        let rows = 9;
        // Some of the numbers lie far outside the clip.
        let raw = observations(&contract, rows, &mut random);
        let mut actions = Vec::new();
        policy.act(&raw, rows, &mut actions).unwrap();
        let expected: Vec<f32> =
            raw.chunks(sizes[0]).flat_map(|row| forward(&layers, &contract.normaliser, row)).collect();
        worst = worst.max(difference(&actions, &expected));
    }
    println!("largest difference between the file and the plain forward pass: {worst:.1e} (allowed 1e-5)");
    assert!(worst < 1e-5);
}

#[test]
fn a_batch_equals_its_rows_one_by_one() {
    let mut random = RandomStream::new(72, 0);
    let layers = network(&[300, 128, 128, 128, 51], Activation::Tanh, &mut random);
    let contract = contract_for(&layers, &mut random);
    let policy = Policy::from_bytes(&policy_bytes(&layers, &contract).unwrap(), "batch").unwrap();
    let mut worst = 0.0f64;
    let mut same_bits = true;
    for rows in [64, 1, 7, 8, 3, 70, 50, 0] {
        let raw = observations(&contract, rows, &mut random);
        let (mut together, mut alone) = (vec![0.0; 5], Vec::new());
        policy.act(&raw, rows, &mut together).unwrap();
        assert_eq!(together.len(), rows * 51);
        for (observation, action) in raw.chunks(300).zip(together.chunks(51)) {
            policy.clone().act(observation, 1, &mut alone).unwrap();
            worst = worst.max(difference(action, &alone));
            same_bits &= action == alone;
        }
        // The same call gives the same bits.
        let mut again = Vec::new();
        policy.act(&raw, rows, &mut again).unwrap();
        assert_eq!(together, again);
    }
    println!("batch against single rows: {worst:.1e} (allowed 1e-6), same bits: {same_bits}");
    assert!(worst < 1e-6);
}

#[test]
fn a_normaliser_deeper_in_the_graph_gives_the_same_bits() {
    // At the front of the graph it is taken out of it; behind an Identity it is not, nor with another mean in the contract.
    let mut random = RandomStream::new(73, 0);
    let layers = network(&[300, 128, 51], Activation::Elu, &mut random);
    let contract = contract_for(&layers, &mut random);
    let bytes = policy_bytes(&layers, &contract).unwrap();
    let mut model = ModelProto::decode(&*bytes).unwrap();
    let graph = model.graph.as_mut().unwrap();
    graph.node[0].input[0] = "same".into();
    let (input, output) = (vec!["observation".into()], vec!["same".into()]);
    graph.node.insert(0, NodeProto { op_type: "Identity".into(), input, output, ..Default::default() });
    let front = Policy::from_bytes(&bytes, "front").unwrap();
    let deep = Policy::from_bytes(&model.encode_to_vec(), "deep").unwrap();
    for rows in [1, 5, 64] {
        let raw = observations(&contract, rows, &mut random);
        let (mut a, mut b) = (Vec::new(), Vec::new());
        front.act(&raw, rows, &mut a).unwrap();
        deep.act(&raw, rows, &mut b).unwrap();
        assert_eq!(a, b, "{rows} rows");
    }
    // The graph is what counts: a contract that says something else changes nothing but the golden pair's fate.
    let mut other = contract.clone();
    other.normaliser.mean[0] += 0.5;
    let mut model = ModelProto::decode(&*bytes).unwrap();
    model.metadata_props[0].value = other.to_json().unwrap();
    let other = Policy::from_bytes(&model.encode_to_vec(), "other").unwrap();
    let raw = observations(&contract, 1, &mut random);
    let (mut a, mut b) = (Vec::new(), Vec::new());
    front.act(&raw, 1, &mut a).unwrap();
    other.act(&raw, 1, &mut b).unwrap();
    assert_eq!(a, b);
}

#[test]
fn a_broken_observation_stays_in_its_row() {
    let mut random = RandomStream::new(73, 0);
    let layers = network(&[12, 16, 6], Activation::Relu, &mut random);
    let contract = contract_for(&layers, &mut random);
    let policy = Policy::from_bytes(&policy_bytes(&layers, &contract).unwrap(), "broken").unwrap();
    let mut raw = observations(&contract, 5, &mut random);
    let (mut healthy, mut broken) = (Vec::new(), Vec::new());
    policy.act(&raw, 5, &mut healthy).unwrap();
    raw[12 + 4] = f32::NAN;
    raw[3 * 12] = f32::INFINITY;
    policy.act(&raw, 5, &mut broken).unwrap();
    for row in 0..5 {
        let range = row * 6..(row + 1) * 6;
        if row == 1 || row == 3 {
            assert!(broken[range].iter().all(|v| v.is_nan()), "row {row}");
        } else {
            assert_eq!(broken[range.clone()], healthy[range], "row {row}");
        }
    }
    let error = policy.act(&raw, 4, &mut broken).unwrap_err();
    assert!(matches!(error, PolicyError::Rows { found: 60, rows: 4, size: 12, .. }), "{error}");
}

#[test]
fn the_contract_survives_and_the_file_can_be_saved_and_shared() {
    let mut random = RandomStream::new(74, 0);
    let layers = network(&[206, 64, 51], Activation::Elu, &mut random);
    let mut contract = contract_for(&layers, &mut random);
    contract.gains = Some((2000.0, 60.5));
    contract.skill_settings = r#"{"jump": {"height": 0.4}, "note": "\"quoted\" ä"}"#.into();
    let folder = std::env::temp_dir().join(format!("athlete-policy-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("test.policy.onnx");
    save_policy(&path, &layers, &contract).unwrap();
    let policy = Policy::load(&path).unwrap();
    let names: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().file_name()).collect();
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(names, ["test.policy.onnx"], "nothing else is left behind");
    assert_eq!(*policy.contract(), contract);
    let settings: serde_json::Value = policy.contract().parse_skill_settings().unwrap();
    assert_eq!(settings["jump"]["height"], 0.4);
    assert_eq!(
        policy.fingerprint(),
        Policy::from_bytes(&policy_bytes(&layers, &contract).unwrap(), "x").unwrap().fingerprint()
    );
    fn shareable<T: Send + Sync + 'static>(_: &T) {}
    shareable(&policy);
    // The sentence in the file is the one that the type gives out.
    let json = contract.to_json().unwrap();
    assert!(json.contains(ActionMeaning::ReferenceOffset.sentence()));
    assert_eq!(PolicyContract::from_json(&json).unwrap(), contract);
}

/// Layers whose weights and biases half precision holds exactly.
fn halved(mut layers: DenseLayers) -> DenseLayers {
    for layer in &mut layers.layers {
        for number in layer.weights.iter_mut().chain(&mut layer.bias) {
            *number = (*number * 512.0).round().clamp(-2047.0, 2047.0) / 512.0;
        }
    }
    layers
}

#[test]
fn weights_of_half_precision_take_half_the_file() {
    let mut random = RandomStream::new(81, 0);
    let fine = network(&[300, 128, 128, 128, 51], Activation::Tanh, &mut random);
    let coarse = halved(fine.clone());
    let contract = contract_for(&coarse, &mut random);
    let bytes = policy_bytes(&coarse, &contract).unwrap();
    let policy = Policy::from_bytes(&bytes, "coarse").unwrap();
    let raw = observations(&contract, 9, &mut random);
    let mut actions = Vec::new();
    policy.act(&raw, 9, &mut actions).unwrap();
    let expected: Vec<f32> = raw.chunks(300).flat_map(|row| forward(&coarse, &contract.normaliser, row)).collect();
    assert!(difference(&actions, &expected) < 1e-5);
    let whole = policy_bytes(&fine, &contract_for(&fine, &mut random)).unwrap().len();
    println!("{} bytes, {whole} in single precision", bytes.len());
    assert!(bytes.len() < whole * 6 / 10);
}

#[test]
fn halves_that_are_not_cast_are_refused() {
    let mut random = RandomStream::new(82, 0);
    let layers = halved(network(&[10, 8, 6], Activation::Tanh, &mut random));
    let contract = contract_for(&layers, &mut random);
    let model = ModelProto::decode(&*policy_bytes(&layers, &contract).unwrap()).unwrap();
    let broken = |edit: &dyn Fn(&mut tract_onnx::pb::GraphProto)| {
        let mut model = model.clone();
        edit(model.graph.as_mut().unwrap());
        refusal(&model).to_string()
    };
    let cast = model.graph.as_ref().unwrap().node.iter().position(|n| n.op_type == "Cast").unwrap();
    let edits: [(&str, &dyn Fn(&mut tract_onnx::pb::GraphProto)); 6] = [
        ("attribute `to`", &|g| g.node[cast].attribute[0].i = 11),
        ("says no type", &|g| g.node[cast].attribute.clear()),
        ("do not fit", &|g| g.node[cast].input[0] = "bias_0".into()),
        ("do not fit", &|g| g.node[cast + 1].input[1] = "half_0".into()),
        ("half_0", &|g| g.initializer[4].raw_data[..2].copy_from_slice(&0x7c00u16.to_le_bytes())),
        ("holds 79 numbers", &|g| g.initializer[4].raw_data.truncate(79 * 2)),
    ];
    for (word, edit) in edits {
        let error = broken(edit);
        assert!(error.contains(word), "{word}: {error}");
    }
}

#[test]
fn layers_are_read_back_as_they_were_written() {
    let mut random = RandomStream::new(83, 0);
    for activation in [Activation::Tanh, Activation::Elu] {
        let fine = network(&[30, 16, 12, 6], activation, &mut random);
        for layers in [halved(fine.clone()), fine] {
            let contract = contract_for(&layers, &mut random);
            let mut model = ModelProto::decode(&*policy_bytes(&layers, &contract).unwrap()).unwrap();
            let read = layers_from_bytes(&model.encode_to_vec(), "own").unwrap();
            assert_eq!(read, (layers.clone(), contract.clone()));
            // Another exporter's: weights in x out.
            let graph = model.graph.as_mut().unwrap();
            if let Some(weights) = graph.initializer.iter_mut().find(|t| t.name == "weights_2") {
                weights.dims = vec![12, 6];
                let numbers = &layers.layers[2].weights;
                weights.raw_data = (0..72).flat_map(|k| numbers[k % 6 * 12 + k / 6].to_le_bytes()).collect();
                graph.node.last_mut().unwrap().attribute.clear();
                assert_eq!(layers_from_bytes(&model.encode_to_vec(), "other").unwrap().0, layers);
            }
        }
    }
    // A file that plays but has no such layers.
    let layers = network(&[10, 6], Activation::Relu, &mut random);
    let contract = contract_for(&layers, &mut random);
    let mut model = ModelProto::decode(&*policy_bytes(&layers, &contract).unwrap()).unwrap();
    let graph = model.graph.as_mut().unwrap();
    graph.node.last_mut().unwrap().output[0] = "before".into();
    let (input, output) = (vec!["before".into()], vec!["action".into()]);
    graph.node.push(NodeProto { op_type: "Identity".into(), input, output, ..Default::default() });
    let error = layers_from_bytes(&model.encode_to_vec(), "own").unwrap_err();
    assert!(matches!(&error, ImportError::Layers { node, .. } if node == "action"), "{error}");
}

/// A small policy whose parts are taken out and replaced.
fn small() -> (ModelProto, PolicyContract) {
    let mut random = RandomStream::new(75, 0);
    let layers = network(&[10, 8, 6], Activation::Tanh, &mut random);
    let contract = contract_for(&layers, &mut random);
    (ModelProto::decode(&*policy_bytes(&layers, &contract).unwrap()).unwrap(), contract)
}

fn refusal(model: &ModelProto) -> PolicyError {
    match Policy::from_bytes(&model.encode_to_vec(), "file.onnx") {
        Err(error) => {
            assert!(error.to_string().starts_with("file.onnx: "), "{error}");
            error
        }
        Ok(_) => panic!("it was accepted"),
    }
}

#[test]
fn files_that_are_no_policy_are_refused() {
    let load = |bytes: &[u8]| Policy::from_bytes(bytes, "file.onnx").unwrap_err();
    assert!(matches!(Policy::load("no/such/file.onnx"), Err(PolicyError::Read { .. })));
    for foreign in [
        &b""[..],
        b"hello, world",
        b"{\"json\": true}",
        b"(version: 1)",
        b"\x89PNG\r\n\x1a\n0000",
        b"PK\x03\x04zip",
        b"\x1f\x8b\x08\x00gzip",
        b"\0\0\0\0\0\0\0\0",
    ] {
        let error = load(foreign);
        assert!(matches!(error, PolicyError::NotOnnx { .. }), "{foreign:?}: {error}");
    }
    let error = load(&vec![0; MAX_POLICY_BYTES as usize + 1]);
    assert!(matches!(error, PolicyError::TooLarge { limit: MAX_POLICY_BYTES, .. }), "{error}");

    let (mut model, _) = small();
    let whole = model.encode_to_vec();
    let (mut cut, mut other) = (0, 0);
    for length in 1..whole.len() {
        match load(&whole[..length]) {
            PolicyError::Truncated { bytes, needs, .. } => {
                assert!(bytes == length as u64 && needs > bytes && needs <= whole.len() as u64);
                cut += 1;
            }
            // Cut between two parts: one of them is missing.
            PolicyError::NoContract { .. } | PolicyError::NotOnnx { .. } => other += 1,
            error => panic!("{length} bytes: {error}"),
        }
    }
    println!("of {} truncations {cut} were called that, {other} lacked a part", whole.len() - 1);
    assert!(other < 10);

    model.graph = None;
    assert!(matches!(refusal(&model), PolicyError::NotOnnx { .. }));
    let (mut model, _) = small();
    model.metadata_props[0].key = "other".into();
    assert!(matches!(refusal(&model), PolicyError::NoContract { key: CONTRACT_KEY, .. }));
    assert!(refusal(&model).to_string().contains(CONTRACT_KEY));
}

#[test]
fn contracts_that_do_not_fit_are_refused_with_their_place() {
    let (model, contract) = small();
    let with_text = |text: String| {
        let mut model = model.clone();
        model.metadata_props[0].value = text;
        refusal(&model)
    };
    let json = contract.to_json().unwrap();
    for (from, to, words) in [
        ("{\"version\"", "[\"version\"", "line 1"),
        ("\"cyclic\":true", "\"cyclic\":1", "expected a boolean"),
        ("\"cyclic\":true", "\"cyclic\":true,\"speed\":1", "unknown field `speed`"),
        ("\"skill\":", "\"skil\":", "unknown field `skil`"),
        ("offset o on", "torque", "unknown variant"),
        ("\"version\":1", "\"version\":2", "version is 2"),
    ] {
        assert!(json.contains(from), "{from}");
        let error = with_text(json.replacen(from, to, 1));
        assert!(matches!(error, PolicyError::Contract { .. }) && error.to_string().contains(words), "{error}");
    }
    // A later version is refused as such, whatever its fields are.
    let error = with_text("{\"version\": 9, \"new\": []}".into());
    assert!(error.to_string().contains("version is 9"), "{error}");

    for (name, edit) in edited() {
        let mut broken = contract.clone();
        edit(&mut broken);
        let ContractError::Value { field, .. } = broken.check().unwrap_err() else { panic!("{name}") };
        assert_eq!(field, name);
        assert!(matches!(broken.to_json(), Err(ContractError::Value { .. })));
        // A text can say what the writer above refuses to write; numbers that are no JSON end as syntax.
        let error = with_text(serde_json::to_string(&broken).unwrap());
        assert!(matches!(error, PolicyError::Contract { .. }), "{name}: {error}");
    }
}

#[test]
fn networks_that_do_not_fit_are_refused() {
    let (model, contract) = small();
    let broken = |edit: &dyn Fn(&mut ModelProto)| {
        let mut model = model.clone();
        edit(&mut model);
        refusal(&model)
    };
    let graph = |edit: &dyn Fn(&mut tract_onnx::pb::GraphProto)| broken(&|m| edit(m.graph.as_mut().unwrap()));

    // Sizes: the contract says one number more, or one link less.
    let mut longer = contract.clone();
    longer.observation[0].size += 1;
    longer.normaliser.mean.push(0.0);
    longer.normaliser.scale.push(1.0);
    longer.golden.observation.push(0.0);
    let error = broken(&|m| m.metadata_props[0].value = longer.to_json().unwrap());
    assert!(matches!(error, PolicyError::Size { end: "observation", network: 10, layout: 11, .. }), "{error}");
    let mut fewer = contract.clone();
    fewer.action.links.pop();
    fewer.golden.action.truncate(3);
    let error = broken(&|m| m.metadata_props[0].value = fewer.to_json().unwrap());
    assert!(matches!(error, PolicyError::Size { end: "action", network: 6, layout: 3, .. }), "{error}");

    // The golden pair.
    let mut other = contract.clone();
    other.golden.action[4] += 3e-5;
    match broken(&|m| m.metadata_props[0].value = other.to_json().unwrap()) {
        PolicyError::Golden { index: 4, difference, .. } => assert!((2e-5..4e-5).contains(&difference)),
        error => panic!("{error}"),
    }

    // Weights.
    let error = graph(&|g| g.initializer[4].raw_data[8..12].copy_from_slice(&f32::NAN.to_le_bytes()));
    assert!(matches!(&error, PolicyError::NotFinite { tensor, index: 2, .. } if tensor == "weights_0"), "{error}");
    let error = graph(&|g| {
        let constant = &mut g.initializer[5];
        constant.raw_data.clear();
        constant.float_data = vec![0.0; 8];
        constant.float_data[7] = f32::INFINITY;
    });
    assert!(matches!(&error, PolicyError::NotFinite { tensor, index: 7, .. } if tensor == "bias_0"), "{error}");

    // The graph: each edit, and a word of the refusal.
    let edits: [(&str, &dyn Fn(&mut tract_onnx::pb::GraphProto)); 17] = [
        ("holds 79 numbers", &|g| g.initializer[4].raw_data.truncate(79 * 4)),
        ("dimensions", &|g| g.initializer[4].dims = vec![i64::MAX, i64::MAX, 2]),
        ("holds 80 numbers", &|g| g.initializer[4].dims = vec![i64::MAX, i64::MAX]),
        ("has type 11", &|g| g.initializer[4].data_type = DataType::Double as i32),
        ("outside the file", &|g| g.initializer[4].data_location = Some(1)),
        ("do not fit", &|g| g.initializer[4].dims = vec![10, 8]),
        ("do not fit", &|g| g.initializer[0].dims = vec![10, 1]),
        ("named `input`", &|g| g.input[0].name = "input".into()),
        ("is given by no node", &|g| drop(g.node.pop())),
        ("2 inputs", &|g| g.input.push(g.input[0].clone())),
        ("has no tensor type", &|g| g.input[0].r#type = None),
        ("not one of a policy's", &|g| g.node[4].op_type = "Loop".into()),
        ("not defined before it", &|g| g.node.reverse()),
        ("defined twice", &|g| g.node.push(g.node[4].clone())),
        ("attribute `alpha`", &|g| {
            g.node[4].attribute.push(AttributeProto { name: "alpha".into(), ..Default::default() })
        }),
        ("at most 1000", &|g| g.node = vec![g.node[0].clone(); 1001]),
        ("operations an action", &|g| {
            // The same large weights, hundreds of times.
            let size = 500i64;
            let square = &mut g.initializer[4];
            square.dims = vec![size, size];
            square.raw_data = vec![0; (size * size * 4) as usize];
            g.input[0] = {
                let mut input = g.input[0].clone();
                let value = input.r#type.as_mut().unwrap().value.as_mut().unwrap();
                let tract_onnx::pb::type_proto::Value::TensorType(tensor) = value;
                tensor.shape.as_mut().unwrap().dim[1].value =
                    Some(tract_onnx::pb::tensor_shape_proto::dimension::Value::DimValue(size));
                input
            };
            let product = |k: usize| NodeProto {
                op_type: "MatMul".into(),
                input: vec![if k == 0 { "observation".into() } else { format!("v{k}") }, "weights_0".into()],
                output: vec![format!("v{}", k + 1)],
                ..Default::default()
            };
            g.node = (0..500).map(product).collect();
        }),
    ];
    for (word, edit) in edits {
        let error = graph(edit);
        assert!(matches!(error, PolicyError::Graph { .. }) && error.to_string().contains(word), "{word}: {error}");
    }
    let error = broken(&|m| m.opset_import[0].version = 7);
    assert!(error.to_string().contains("operator set"), "{error}");
    let error = broken(&|m| m.opset_import.clear());
    assert!(error.to_string().contains("operator set"), "{error}");
}

#[test]
fn graphs_of_other_exporters_are_read() {
    // Bounds as Constant nodes, products and sums apart, weights as in x out, x sigmoid(x) as an activation, a later
    // operator set.
    let mut random = RandomStream::new(80, 0);
    let layers = network(&[10, 6], Activation::Tanh, &mut random);
    let mut contract = contract_for(&layers, &mut random);
    let mut model = ModelProto::decode(&*policy_bytes(&layers, &contract).unwrap()).unwrap();
    model.opset_import[0].version = 20;
    let graph = model.graph.as_mut().unwrap();
    for bound in graph.initializer.drain(2..4).collect::<Vec<_>>() {
        let value = AttributeProto {
            name: "value".into(),
            r#type: AttributeType::Tensor as i32,
            t: Some(bound.clone()),
            ..Default::default()
        };
        let (op_type, output) = ("Constant".into(), vec![bound.name]);
        graph.node.insert(0, NodeProto { op_type, output, attribute: vec![value], ..Default::default() });
    }
    let weights = &mut graph.initializer[2];
    weights.dims = vec![10, 6];
    let original = &layers.layers[0].weights;
    weights.raw_data = (0..60).flat_map(|k| original[k % 6 * 10 + k / 6].to_le_bytes()).collect();
    graph.node.pop();
    for (op, inputs, output) in [
        ("MatMul", vec!["normalised", "weights_0"], "product"),
        ("Add", vec!["bias_0", "product"], "sum"),
        ("Sigmoid", vec!["sum"], "share"),
        ("Mul", vec!["sum", "share"], "weighted"),
        ("Identity", vec!["weighted"], "action"),
    ] {
        let input = inputs.into_iter().map(String::from).collect();
        graph.node.push(NodeProto { op_type: op.into(), input, output: vec![output.into()], ..Default::default() });
    }
    for action in &mut contract.golden.action {
        *action /= 1.0 + (-*action).exp();
    }
    model.metadata_props[0].value = contract.to_json().unwrap();
    let policy = Policy::from_bytes(&model.encode_to_vec(), "other.onnx").unwrap();
    assert_eq!(*policy.contract(), contract);
}

#[test]
fn the_exporter_refuses_what_a_reader_would() {
    let mut random = RandomStream::new(77, 0);
    let layers = network(&[10, 8, 6], Activation::Tanh, &mut random);
    let contract = contract_for(&layers, &mut random);
    let mut broken = layers.clone();
    broken.layers[1].weights[3] = f32::NAN;
    let error = policy_bytes(&broken, &contract).unwrap_err();
    assert!(matches!(error, ExportError::Layers(LayersError::NotFinite { layer: 1, index: 3, .. })), "{error}");
    broken = layers.clone();
    broken.layers[0].bias.pop();
    assert!(matches!(policy_bytes(&broken, &contract), Err(ExportError::Layers(LayersError::Count { layer: 0, .. }))));
    broken = layers.clone();
    broken.sizes.pop();
    assert!(matches!(policy_bytes(&broken, &contract), Err(ExportError::Layers(LayersError::Depth { .. }))));
    let wider = network(&[11, 6], Activation::Tanh, &mut random);
    let error = policy_bytes(&wider, &contract).unwrap_err();
    assert!(matches!(error, ExportError::Size { end: "observation", network: 11, layout: 10 }), "{error}");
    // A golden pair from another network: nothing is written.
    let path = std::env::temp_dir().join(format!("athlete-never-{}.onnx", std::process::id()));
    let other = network(&[10, 8, 6], Activation::Tanh, &mut random);
    let error = save_policy(&path, &other, &contract).unwrap_err();
    assert!(matches!(error, ExportError::ReadBack(PolicyError::Golden { .. })), "{error}");
    assert!(!path.exists());
}

#[test]
#[ignore = "a measurement: cargo test --release --no-default-features --features cli --test core policy::speed -- --ignored --nocapture"]
fn speed() {
    let mut random = RandomStream::new(78, 0);
    let layers = network(&[300, 128, 128, 128, 51], Activation::Tanh, &mut random);
    let contract = contract_for(&layers, &mut random);
    let bytes = policy_bytes(&layers, &contract).unwrap();
    let begin = Instant::now();
    let policy = Policy::from_bytes(&bytes, "speed").unwrap();
    println!("{} bytes loaded in {:.1} ms", bytes.len(), begin.elapsed().as_secs_f64() * 1e3);
    for rows in [1, 2, 8, 20, 64, 256] {
        let raw = observations(&contract, rows, &mut random);
        let mut actions = Vec::new();
        let microseconds = |_| {
            let begin = Instant::now();
            let calls = 2000 / rows + 1;
            for _ in 0..calls {
                policy.act(&raw, rows, &mut actions).unwrap();
            }
            begin.elapsed().as_secs_f64() * 1e6 / (calls * rows) as f64
        };
        let best = (0..20).map(microseconds).fold(f64::MAX, f64::min);
        println!("{rows} rows: {best:.2} us per row");
        assert!(rows > 1 || best < 20.0);
    }
}

/// Policies of every activation, and beside each what this crate makes of random observations, for
/// `scripts/check_onnx.py`.
#[test]
#[ignore = "writes samples to target/policy_samples"]
fn write_samples() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("target/policy_samples");
    std::fs::create_dir_all(&folder).unwrap();
    let mut random = RandomStream::new(79, 0);
    for (activation, sizes) in ACTIVATIONS.into_iter().zip([&[300, 128, 128, 128, 51][..], &[206, 64, 64, 51], &[7, 3]])
    {
        let layers = network(sizes, activation, &mut random);
        let contract = contract_for(&layers, &mut random);
        let name = format!("{activation:?}").to_lowercase();
        let policy = save_policy(folder.join(format!("{name}.onnx")), &layers, &contract).unwrap();
        let rows = 73;
        let raw = observations(&contract, rows, &mut random);
        let mut actions = Vec::new();
        policy.act(&raw, rows, &mut actions).unwrap();
        let sample = serde_json::json!({ "rows": rows, "observations": raw, "actions": actions });
        std::fs::write(folder.join(format!("{name}.json")), sample.to_string()).unwrap();
    }
}

/// One matrix and an offset need no network: the same file, the same contract, the same bits on every machine and in any company.
#[test]
fn affine_policies_go_out_and_come_back() {
    let mut random = RandomStream::new(78, 0);
    for sizes in [[240, 51], [7, 3], [4, 6]] {
        let layers = network(&sizes, Activation::Tanh, &mut random);
        let contract = contract_for(&layers, &mut random);
        let bytes = policy_bytes(&layers, &contract).unwrap();
        let policy = Policy::from_bytes(&bytes, "affine").unwrap();
        assert!(policy.is_affine());
        let (read, said) = layers_from_bytes(&bytes, "affine").unwrap();
        assert_eq!((&read.sizes, &read.layers, said), (&layers.sizes, &layers.layers, contract.clone()));

        let raw = observations(&contract, 9, &mut random);
        let (mut together, mut alone) = (Vec::new(), Vec::new());
        policy.act(&raw, 9, &mut together).unwrap();
        for (row, action) in raw.chunks(sizes[0]).zip(together.chunks(sizes[1])) {
            policy.act(row, 1, &mut alone).unwrap();
            assert_eq!(alone, action, "a row alone has the bits that it has among others");
            let worst = difference(action, &forward(&layers, &contract.normaliser, row));
            assert!(worst < 1e-6, "{worst:e}");
        }

        // Without transposition, and behind something else than the normaliser: what it computes stays.
        let mut model = ModelProto::decode(&*bytes).unwrap();
        let graph = model.graph.as_mut().unwrap();
        let weights = &mut graph.initializer[4];
        weights.dims.reverse();
        let original = &layers.layers[0].weights;
        weights.raw_data =
            (0..original.len()).flat_map(|k| original[k % sizes[1] * sizes[0] + k / sizes[1]].to_le_bytes()).collect();
        graph.node.last_mut().unwrap().attribute.clear();
        let plain = Policy::from_bytes(&model.encode_to_vec(), "affine").unwrap();
        plain.act(&raw, 9, &mut alone).unwrap();
        assert!(plain.is_affine() && alone == together);
        let graph = model.graph.as_mut().unwrap();
        graph.node[0].input[0] = "same".into();
        let (input, output) = (vec!["observation".into()], vec!["same".into()]);
        graph.node.insert(0, NodeProto { op_type: "Identity".into(), input, output, ..Default::default() });
        let deep = Policy::from_bytes(&model.encode_to_vec(), "affine").unwrap();
        deep.act(&raw, 9, &mut alone).unwrap();
        assert!(!deep.is_affine() && difference(&alone, &together) < 1e-5);
    }
    assert!(!Policy::from_bytes(&policy_bytes_of(&[7, 5, 3], &mut random), "deep").unwrap().is_affine());
}

fn policy_bytes_of(sizes: &[usize], random: &mut RandomStream) -> Vec<u8> {
    let layers = network(sizes, Activation::Tanh, random);
    let contract = contract_for(&layers, random);
    policy_bytes(&layers, &contract).unwrap()
}
