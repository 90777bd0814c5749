//! Contract: a policy file computes what its trainer's network did, and says what its numbers mean. What does not fit is refused:
//! `policy_refusals.rs`.
//!
//! The reference is a forward pass in f64 written here, of a dozen lines and without a library: an exporter and a
//! reader that were wrong in the same way would agree with each other, and the golden pair inside the file would agree
//! too.

use crate::policy_support::{contract_for, forward, halved, network, observations};
use bevy_athlete::asset::dense_layers::Activation;
use bevy_athlete::asset::policy_contract::{ActionMeaning, PolicyContract};
use bevy_athlete::control::{Policy, PolicyError};
use bevy_athlete::math::RandomStream;
use bevy_athlete::train::{ImportError, layers_from_bytes, policy_bytes, save_policy};
use prost::Message;
use std::time::Instant;
use tract_onnx::pb::attribute_proto::AttributeType;
use tract_onnx::pb::{AttributeProto, ModelProto, NodeProto};

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
