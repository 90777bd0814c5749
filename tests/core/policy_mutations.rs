//! Contract: whatever bytes a policy file holds, loading it ends in a policy or in a typed refusal, never in a panic.
//!
//! Six thousand damaged files: bytes changed, cut, doubled and inserted, and, because those seldom get past the outer
//! format, models decoded, changed in their graph and encoded again, which do reach the inference library. The
//! library's own panics would be caught on the way; a hook counts them here, so that the catch stays a second wall. It
//! has caught a product of two values that both depend on the observation, which gave actions of another length.

use crate::policy_support::{contract_for, network};
use bevy_athlete::asset::dense_layers::Activation;
use bevy_athlete::asset::policy_contract::PolicyContract;
use bevy_athlete::control::{OPERATORS, Policy, PolicyError};
use bevy_athlete::math::RandomStream;
use bevy_athlete::train::policy_bytes;
use prost::Message;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use tract_onnx::pb::attribute_proto::AttributeType;
use tract_onnx::pb::{AttributeProto, GraphProto, ModelProto};

/// Files tried.
const DAMAGED: usize = 6000;

/// Changes bytes: flips, cuts, doubles, inserts.
fn damage_bytes(bytes: &mut Vec<u8>, random: &mut RandomStream) {
    let length = bytes.len();
    match random.below(5) {
        0 => bytes.truncate(random.below(length)),
        1 => {
            let (from, to) = (random.below(length), random.below(length));
            let part = bytes[from.min(to)..from.max(to)].to_vec();
            let at = random.below(length);
            bytes.splice(at..at, part);
        }
        2 => {
            let (from, to) = (random.below(length), random.below(length));
            bytes.drain(from.min(to)..from.max(to));
        }
        _ => {
            // Near the beginning and the end the format's own bytes are dense; in the middle there are weights.
            for _ in 0..=random.below(8) {
                let at = if random.below(2) == 0 { random.below(length) } else { random.below(400.min(length)) };
                bytes[at] = random.bits() as u8;
            }
        }
    }
}

/// Changes one thing in the graph.
fn damage_graph(graph: &mut GraphProto, random: &mut RandomStream) {
    let names: Vec<String> = graph
        .initializer
        .iter()
        .map(|t| t.name.clone())
        .chain(graph.node.iter().flat_map(|n| n.output.clone()))
        .chain(["observation".into(), "action".into(), String::new()])
        .collect();
    let any = random.below(graph.node.len());
    let inputs = graph.node[any].input.len();
    let node = &mut graph.node[any];
    match random.below(10) {
        0 | 1 => node.op_type = OPERATORS[random.below(OPERATORS.len())].into(),
        2 if inputs > 0 => node.input[random.below(inputs)] = names[random.below(names.len())].clone(),
        2 | 3 => node.input.push(names[random.below(names.len())].clone()),
        4 => drop(node.input.pop()),
        5 => {
            let names = ["alpha", "beta", "gamma", "transA", "transB", "axis", "value"];
            let types = [AttributeType::Float, AttributeType::Int, AttributeType::Tensor, AttributeType::Floats];
            node.attribute.push(AttributeProto {
                name: names[random.below(names.len())].into(),
                r#type: types[random.below(types.len())] as i32,
                i: random.below(3) as i64,
                f: random.normal() as f32,
                t: (random.below(2) == 0).then(|| graph.initializer[0].clone()),
                ..Default::default()
            });
        }
        6 => drop(graph.node.remove(any)),
        7 => {
            let k = random.below(graph.initializer.len());
            let tensor = &mut graph.initializer[k];
            match random.below(4) {
                0 => tensor.dims.reverse(),
                1 => tensor.dims = vec![(tensor.raw_data.len() / 4) as i64],
                2 => tensor.dims.insert(0, 1),
                _ => tensor.dims = vec![random.bits() as i64, random.bits() as i64],
            }
        }
        8 => {
            let other = graph.node[random.below(graph.node.len())].clone();
            graph.node.insert(any, other);
        }
        _ => {
            let k = random.below(graph.initializer.len());
            let tensor = &mut graph.initializer[k];
            let value = [f32::MAX, f32::MIN, f32::MIN_POSITIVE / 2.0, f32::NAN, 0.0][random.below(5)];
            let at = 4 * random.below(tensor.raw_data.len() / 4);
            tensor.raw_data[at..at + 4].copy_from_slice(&value.to_le_bytes());
        }
    }
}

/// A word for how a file ended.
fn kind(result: &Result<Policy, PolicyError>) -> &'static str {
    match result {
        Ok(_) => "accepted",
        Err(PolicyError::NotOnnx { .. }) => "not ONNX",
        Err(PolicyError::Truncated { .. }) => "truncated",
        Err(PolicyError::NoContract { .. }) => "no contract",
        Err(PolicyError::Contract { .. }) => "contract",
        Err(PolicyError::Graph { .. }) => "graph",
        Err(PolicyError::NotFinite { .. }) => "not finite",
        Err(PolicyError::Size { .. }) => "size",
        Err(PolicyError::Golden { .. }) => "golden pair",
        Err(PolicyError::Network { .. }) => "network",
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn damaged_files_never_panic() {
    let mut random = RandomStream::new(20_190_105, 0);
    let files: Vec<(Vec<u8>, PolicyContract)> = [Activation::Tanh, Activation::Elu, Activation::Relu]
        .into_iter()
        .map(|activation| {
            let layers = network(&[6, 6, 6], activation, &mut random);
            let contract = contract_for(&layers, &mut random);
            (policy_bytes(&layers, &contract).unwrap(), contract)
        })
        .collect();

    let panics = Arc::new(AtomicUsize::new(0));
    let before = std::panic::take_hook();
    let (counter, here) = (panics.clone(), std::thread::current().id());
    std::panic::set_hook(Box::new(move |info| {
        // The hook is the program's: tests beside this one may fail meanwhile.
        if std::thread::current().id() == here {
            counter.fetch_add(1, Ordering::Relaxed);
        }
        eprintln!("{info}");
    }));
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    let mut strange = Vec::new();
    for k in 0..DAMAGED {
        let mut bytes = files[k % files.len()].0.clone();
        if random.below(3) == 0 {
            damage_bytes(&mut bytes, &mut random);
        } else {
            let mut model = ModelProto::decode(&*bytes).unwrap();
            for _ in 0..=random.below(6).saturating_sub(3) {
                let graph = model.graph.as_mut().unwrap();
                if !graph.node.is_empty() {
                    damage_graph(graph, &mut random);
                }
            }
            bytes = model.encode_to_vec();
        }
        let result = Policy::from_bytes(&bytes, "damaged.onnx");
        *kinds.entry(kind(&result)).or_default() += 1;
        match result {
            Ok(policy) => {
                let mut actions = Vec::new();
                policy.act(&[0.5; 6 * 70], 70, &mut actions).unwrap();
                assert_eq!(actions.len(), 6 * 70);
            }
            Err(error @ PolicyError::Network { .. }) => strange.push(error.to_string()),
            Err(_) => {}
        }
    }
    std::panic::set_hook(before);
    println!("{DAMAGED} damaged files: {kinds:?}");
    for error in strange.iter().take(10) {
        println!("refused by the inference library: {error}");
    }
    assert_eq!(panics.load(Ordering::Relaxed), 0, "panics on the way");
    assert!(kinds["golden pair"] + kinds["accepted"] > 300, "too few reach the inference library");
    assert!(["truncated", "graph", "contract", "not ONNX", "accepted"].iter().all(|k| kinds.contains_key(k)));
}
