//! Contract: a policy file is refused where anything does not fit.
//!
//! Refusals are tried one by one, because a file that loads and means something else moves a body by wrong numbers without a word. What
//! a file that fits computes: `policy.rs`.

use crate::policy_support::{contract_for, edited, halved, network};
use bevy_athlete::asset::dense_layers::{Activation, LayersError};
use bevy_athlete::asset::policy_contract::{CONTRACT_KEY, ContractError, PolicyContract};
use bevy_athlete::control::{MAX_POLICY_BYTES, Policy, PolicyError};
use bevy_athlete::math::RandomStream;
use bevy_athlete::train::{ExportError, policy_bytes, save_policy};
use prost::Message;
use tract_onnx::pb::{AttributeProto, ModelProto, NodeProto, tensor_proto::DataType};

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
