//! Random networks, contracts for them, and a forward pass that shares no code with the crate.
#![allow(dead_code, reason = "each test file uses its part")]

use bevy_athlete::asset::dense_layers::{Activation, DenseLayer, DenseLayers};
use bevy_athlete::asset::policy_contract::{
    ActionLayout, ActionMeaning, CONTRACT_VERSION, GoldenPair, Normaliser, ObservationBlock, PolicyContract,
    ReferenceFile,
};
use bevy_athlete::math::RandomStream;
use bevy_athlete::model::preset;

/// A network of these widths with normally distributed weights that keep the size of what passes through.
pub fn network(sizes: &[usize], activation: Activation, random: &mut RandomStream) -> DenseLayers {
    let layers = sizes.windows(2).map(|w| {
        let scale = 1.0 / (w[0] as f64).sqrt();
        let weights = (0..w[0] * w[1]).map(|_| (random.normal() * scale) as f32).collect();
        DenseLayer { weights, bias: (0..w[1]).map(|_| (random.normal() * 0.1) as f32).collect() }
    });
    DenseLayers { sizes: sizes.to_vec(), activation, layers: layers.collect() }
}

/// A contract for the skater that fits the network, with a random normaliser and the golden pair of [`forward`].
pub fn contract_for(layers: &DenseLayers, random: &mut RandomStream) -> PolicyContract {
    let (inputs, outputs) = (layers.sizes[0], layers.sizes[layers.sizes.len() - 1]);
    assert!(outputs.is_multiple_of(3));
    let skater = preset("skater").unwrap();
    let mut links: Vec<String> = skater.links.iter().skip(1).map(|l| l.name.clone()).collect();
    // More links than the skater has, where a test asks for a wide action.
    links.extend((links.len()..outputs / 3).map(|k| format!("extra_{k}")));
    links.truncate(outputs / 3);
    let block = |name: &str, size, meaning: &str| ObservationBlock { name: name.into(), size, meaning: meaning.into() };
    let mut observation = vec![block("phase", 1, "phase of the clip, 0 to 1")];
    if inputs > 1 {
        observation.push(block("links", inputs - 1, "positions (m) and velocities (m/s) of the links, root frame"));
    }
    let numbers = |f: &dyn Fn(f64) -> f64, random: &mut RandomStream| -> Vec<f32> {
        (0..inputs).map(|_| f(random.normal()) as f32).collect()
    };
    let normaliser =
        Normaliser { mean: numbers(&|x| 2.0 * x, random), scale: numbers(&|x| 0.5 + x.abs(), random), clip: 3.0 };
    let mut contract = PolicyContract {
        version: CONTRACT_VERSION,
        crate_version: "bevy_athlete test".into(),
        character: "skater".into(),
        character_fingerprint: None,
        skill: "stroking".into(),
        skill_settings: String::new(),
        control_rate: 30.0,
        simulation_rate: 600.0,
        observation,
        normaliser,
        action: ActionLayout { meaning: ActionMeaning::ReferenceOffset, scale: 0.3, links, gains: None },
        reference: ReferenceFile { file: "stroking.clip.ron".into(), fingerprint: None, cyclic: true },
        gains: None,
        golden: GoldenPair { observation: vec![0.0; inputs], action: vec![] },
    };
    contract.golden.observation = observations(&contract, 1, random);
    contract.golden.action = forward(layers, &contract.normaliser, &contract.golden.observation);
    contract
}

/// Raw observations around the normaliser's mean; one number in ten lies far outside.
pub fn observations(contract: &PolicyContract, rows: usize, random: &mut RandomStream) -> Vec<f32> {
    let Normaliser { mean, scale, .. } = &contract.normaliser;
    (0..rows * mean.len())
        .map(|k| {
            let (mean, scale) = (f64::from(mean[k % mean.len()]), f64::from(scale[k % mean.len()]));
            let far = if random.below(10) == 0 { 20.0 } else { 1.0 };
            (mean + far * random.normal() / scale) as f32
        })
        .collect()
}

/// The plain forward pass, in f64: clamp((raw - mean) scale), then layer after layer.
pub fn forward(layers: &DenseLayers, normaliser: &Normaliser, raw: &[f32]) -> Vec<f32> {
    let clip = f64::from(normaliser.clip);
    let mut values: Vec<f64> = (0..raw.len())
        .map(|k| (f64::from(raw[k]) - f64::from(normaliser.mean[k])) * f64::from(normaliser.scale[k]))
        .map(|v| v.clamp(-clip, clip))
        .collect();
    for (k, layer) in layers.layers.iter().enumerate() {
        let row = |r: usize| {
            let weights = &layer.weights[r * values.len()..(r + 1) * values.len()];
            f64::from(layer.bias[r]) + weights.iter().zip(&values).map(|(w, v)| f64::from(*w) * v).sum::<f64>()
        };
        let sums: Vec<f64> = (0..layer.bias.len()).map(row).collect();
        let activate = |v: f64| match layers.activation {
            Activation::Tanh => v.tanh(),
            Activation::Elu if v < 0.0 => v.exp() - 1.0,
            Activation::Elu => v,
            Activation::Relu => v.max(0.0),
        };
        values = if k + 1 == layers.layers.len() { sums } else { sums.into_iter().map(activate).collect() };
    }
    values.into_iter().map(|v| v as f32).collect()
}

/// Edits of a contract that its check has to refuse, with the field that the refusal has to name.
pub fn edited() -> Vec<(&'static str, fn(&mut PolicyContract))> {
    vec![
        ("version", |c| c.version = 0),
        ("character", |c| c.character.clear()),
        ("skill", |c| c.skill = "x".repeat(201)),
        ("skill_settings", |c| c.skill_settings = "{".into()),
        ("control_rate", |c| c.control_rate = 0.0),
        ("control_rate", |c| c.control_rate = f64::NAN),
        ("simulation_rate", |c| c.simulation_rate = 20.0),
        ("simulation_rate", |c| c.simulation_rate = 601.0),
        ("observation", |c| c.observation.clear()),
        ("observation", |c| c.observation[0].size = 0),
        ("observation", |c| c.observation[0].size = usize::MAX),
        ("observation", |c| c.observation[1].name = c.observation[0].name.clone()),
        ("normaliser.mean", |c| c.normaliser.mean.truncate(1)),
        ("normaliser.mean[2]", |c| c.normaliser.mean[2] = f32::INFINITY),
        ("normaliser.scale[1]", |c| c.normaliser.scale[1] = 0.0),
        ("normaliser.clip", |c| c.normaliser.clip = -1.0),
        ("action.scale", |c| c.action.scale = 0.0),
        ("action.links", |c| c.action.links.clear()),
        ("action.links", |c| c.action.links[0] = c.action.links[1].clone()),
        ("reference.file", |c| c.reference.file = "../../secret.ron".into()),
        ("reference.file", |c| c.reference.file.clear()),
        ("character_fingerprint", |c| c.character_fingerprint = Some("0X".into())),
        ("reference.fingerprint", |c| c.reference.fingerprint = Some(String::new())),
        ("gains", |c| c.gains = Some((600.0, -1.0))),
        ("golden.observation", |c| c.golden.observation.truncate(1)),
        ("golden.action[0]", |c| c.golden.action[0] = f32::NAN),
    ]
}

/// Layers whose weights and biases half precision holds exactly.
pub fn halved(mut layers: DenseLayers) -> DenseLayers {
    for layer in &mut layers.layers {
        for number in layer.weights.iter_mut().chain(&mut layer.bias) {
            *number = (*number * 512.0).round().clamp(-2047.0, 2047.0) / 512.0;
        }
    }
    layers
}
