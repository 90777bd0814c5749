//! Contract: the networks compute what their formulas say, and the same bits whoever computes it.
//!
//! Outputs and gradients are checked against a plain double-precision network and its central differences, so an error common to
//! forward and backward shows. Sizes are chosen on both sides of the strips of 32 columns and the tiles of 8 rows.

use std::thread;

use bevy_athlete::math::RandomStream;
use bevy_athlete::train::nn::{Activation, Activations, Adam, Network, clip_norm};

/// The largest absolute and relative error that the docs of `Activation` promise.
const ACTIVATION_ERROR: f64 = if cfg!(any(target_feature = "fma", target_arch = "aarch64")) { 3e-7 } else { 4e-7 };

fn numbers(count: usize, random: &mut RandomStream) -> Vec<f32> {
    (0..count).map(|_| random.normal() as f32).collect()
}

/// The network in double precision, one row at a time, with exact activations.
fn reference(sizes: &[usize], activation: Activation, parameters: &[f64], input: &[f32]) -> Vec<f64> {
    let mut values: Vec<f64> = input.iter().map(|x| f64::from(*x)).collect();
    let mut at = 0;
    for layer in 0..sizes.len() - 1 {
        let (inputs, outputs) = (sizes[layer], sizes[layer + 1]);
        let (weights, bias) = parameters[at..].split_at(inputs * outputs);
        values = (0..outputs)
            .map(|o| {
                let sum: f64 = weights[o * inputs..][..inputs].iter().zip(&values).map(|(w, x)| w * x).sum();
                let sum = sum + bias[o];
                match activation {
                    _ if layer + 2 == sizes.len() => sum,
                    Activation::Tanh => sum.tanh(),
                    Activation::Elu => sum.max(sum.min(0.0).exp_m1()),
                }
            })
            .collect();
        at += (inputs + 1) * outputs;
    }
    values
}

/// A network whose biases are not zero either, a batch and a random derivative of the loss.
fn case(sizes: &[usize], activation: Activation, rows: usize) -> (Network, Vec<f32>, Vec<f32>) {
    let mut random = RandomStream::new(7, sizes.iter().sum::<usize>() as u64);
    let mut network = Network::new(sizes, activation, 1.0, &mut random);
    for value in network.parameters_mut() {
        *value += 0.1 * random.normal() as f32;
    }
    let input = numbers(rows * network.inputs(), &mut random);
    let d_output = numbers(rows * network.outputs(), &mut random);
    (network, input, d_output)
}

const SHAPES: [(&[usize], usize); 5] =
    [(&[3, 2], 1), (&[5, 40, 3], 9), (&[33, 32, 1], 8), (&[70, 17, 64, 51], 13), (&[1, 31, 33, 2], 20)];

#[test]
fn outputs_are_those_of_a_double_precision_network() {
    for activation in [Activation::Tanh, Activation::Elu] {
        let mut scratch = Activations::new();
        for (sizes, rows) in SHAPES {
            let (network, input, _) = case(sizes, activation, rows);
            let parameters: Vec<f64> = network.parameters().iter().map(|p| f64::from(*p)).collect();
            let output = network.forward(&mut scratch, &input, rows);
            assert_eq!(output.len(), rows * network.outputs());
            for (input, output) in input.chunks(network.inputs()).zip(output.chunks(network.outputs())) {
                for (exact, found) in reference(sizes, activation, &parameters, input).iter().zip(output) {
                    let error = (exact - f64::from(*found)).abs();
                    assert!(error < 1e-5 * (1.0 + exact.abs()), "{sizes:?} {activation:?}: {found}, exactly {exact}");
                }
            }
        }
    }
}

#[test]
fn gradients_are_central_differences_of_the_double_precision_network() {
    for activation in [Activation::Tanh, Activation::Elu] {
        for (sizes, rows) in SHAPES {
            let (network, input, d_output) = case(sizes, activation, rows);
            let mut scratch = Activations::new();
            network.forward(&mut scratch, &input, rows);
            // It adds to what is there.
            let mut gradient = vec![0.5; network.parameters().len()];
            network.backward(&mut scratch, &input, rows, &d_output, &mut gradient);

            let mut parameters: Vec<f64> = network.parameters().iter().map(|p| f64::from(*p)).collect();
            let loss = |parameters: &[f64]| -> f64 {
                let batch = input.chunks(network.inputs()).zip(d_output.chunks(network.outputs()));
                batch
                    .flat_map(|(input, d)| {
                        let output = reference(sizes, activation, parameters, input);
                        output.into_iter().zip(d).map(|(y, d)| y * f64::from(*d)).collect::<Vec<_>>()
                    })
                    .sum()
            };
            let step = 1e-5;
            let stride = 1 + parameters.len() / 400;
            let mut worst: f64 = 0.0;
            for at in (0..parameters.len()).step_by(stride) {
                let kept = parameters[at];
                parameters[at] = kept + step;
                let above = loss(&parameters);
                parameters[at] = kept - step;
                let below = loss(&parameters);
                parameters[at] = kept;
                let exact = (above - below) / (2.0 * step);
                let error = (f64::from(gradient[at]) - 0.5 - exact).abs() / (1.0 + exact.abs());
                worst = worst.max(error);
                assert!(
                    error < 2e-5,
                    "{sizes:?} {activation:?} parameter {at}: {}, exactly {exact}",
                    gradient[at] - 0.5
                );
            }
            println!("{sizes:?} {activation:?}: worst error of a gradient {worst:.1e}");
        }
    }
}

/// A network 1 -> 1 -> 1 whose weights are one is the activation itself.
fn activation_values(activation: Activation, inputs: &[f32]) -> Vec<f32> {
    let mut network = Network::new(&[1, 1, 1], activation, 1.0, &mut RandomStream::new(1, 1));
    network.parameters_mut().copy_from_slice(&[1.0, 0.0, 1.0, 0.0]);
    network.forward(&mut Activations::new(), inputs, inputs.len()).to_vec()
}

#[test]
fn activations_keep_their_error_bounds() {
    let mut inputs: Vec<f32> = (0..400_000).map(|i| 1e-20 * 1.000_14f32.powi(i)).take_while(|x| *x < 12.0).collect();
    inputs.extend((0..1_200_000).map(|i| i as f32 * 1e-5));
    inputs.extend([0.0, 100.0, 1e30, f32::MAX, f32::INFINITY]);
    let negative: Vec<f32> = inputs.iter().map(|x| -x).collect();

    let tanh = activation_values(Activation::Tanh, &inputs);
    let mut worst: f64 = 0.0;
    for (x, y) in inputs.iter().zip(&tanh) {
        let error = (f64::from(*y) - f64::from(*x).tanh()).abs();
        assert!(error < ACTIVATION_ERROR && *y <= 1.0, "tanh {x} = {y}");
        assert!(error <= ACTIVATION_ERROR * f64::from(*y), "tanh {x} = {y}: relative error");
        worst = worst.max(error);
    }
    println!("tanh: {} points, worst error {worst:.3e}", inputs.len());
    for (y, mirrored) in tanh.iter().zip(activation_values(Activation::Tanh, &negative)) {
        assert_eq!(*y, -mirrored);
    }

    assert_eq!(activation_values(Activation::Elu, &inputs), inputs, "ELU is the identity above zero");
    let mut worst: f64 = 0.0;
    for (x, y) in negative.iter().zip(activation_values(Activation::Elu, &negative)) {
        let exact = f64::from(*x).exp_m1();
        let error = (f64::from(y) - exact).abs();
        worst = worst.max(error);
        assert!(error <= ACTIVATION_ERROR * exact.abs(), "ELU {x} = {y}, exactly {exact}");
    }
    println!("ELU: worst error {worst:.3e}");

    // A learner that has diverged must not look healthy.
    if cfg!(target_arch = "x86_64") {
        assert!(activation_values(Activation::Tanh, &[f32::NAN])[0].is_nan());
        assert!(activation_values(Activation::Elu, &[f32::NAN])[0].is_nan());
    }
}

#[test]
fn a_row_does_not_depend_on_its_batch() {
    let (network, input, _) = case(&[70, 64, 51], Activation::Tanh, 37);
    let mut scratch = Activations::new();
    let whole = network.forward(&mut scratch, &input, 37).to_vec();
    for row in [0, 7, 8, 36] {
        let alone = network.forward(&mut scratch, &input[row * 70..][..70], 1);
        assert_eq!(alone, &whole[row * 51..][..51]);
    }
}

#[test]
fn changed_parameters_reach_scratch_that_has_seen_the_old_ones() {
    let (mut network, input, d_output) = case(&[5, 40, 3], Activation::Elu, 9);
    let mut used = Activations::new();
    network.forward(&mut used, &input, 9);
    let copy = network.clone();
    network.parameters_mut().iter_mut().for_each(|p| *p *= 1.5);
    for network in [&network, &copy] {
        let mut fresh = Activations::new();
        assert_eq!(network.forward(&mut used, &input, 9), network.forward(&mut fresh, &input, 9));
        let mut gradients = [vec![0.0; network.parameters().len()], vec![0.0; network.parameters().len()]];
        for (scratch, gradient) in [&mut used, &mut fresh].into_iter().zip(&mut gradients) {
            network.backward(scratch, &input, 9, &d_output, gradient);
        }
        assert_eq!(gradients[0], gradients[1]);
    }
}

/// Gradients of four shards, each by the thread that `thread_of` names, added in the order of the shards.
fn sharded_gradient(
    network: &Network,
    input: &[f32],
    d_output: &[f32],
    threads: usize,
    thread_of: [usize; 4],
) -> Vec<f32> {
    const ROWS: usize = 32;
    let mut shards = vec![vec![0.0; network.parameters().len()]; 4];
    thread::scope(|scope| {
        let mut work: Vec<Vec<(usize, &mut Vec<f32>)>> = (0..threads).map(|_| Vec::new()).collect();
        for (shard, gradient) in shards.iter_mut().enumerate() {
            work[thread_of[shard]].push((shard, gradient));
        }
        for list in work {
            scope.spawn(move || {
                let mut scratch = Activations::new();
                for (shard, gradient) in list {
                    let input = &input[shard * ROWS * network.inputs()..][..ROWS * network.inputs()];
                    let d_output = &d_output[shard * ROWS * network.outputs()..][..ROWS * network.outputs()];
                    network.forward(&mut scratch, input, ROWS);
                    network.backward(&mut scratch, input, ROWS, d_output, gradient);
                }
            });
        }
    });
    let mut sum = vec![0.0; network.parameters().len()];
    for shard in &shards {
        sum.iter_mut().zip(shard).for_each(|(sum, value)| *sum += value);
    }
    sum
}

#[test]
fn the_assignment_of_shards_to_threads_changes_no_bit() {
    let (network, input, d_output) = case(&[70, 64, 64, 51], Activation::Tanh, 128);
    let one = sharded_gradient(&network, &input, &d_output, 1, [0; 4]);
    for (threads, thread_of) in [(2, [0, 0, 1, 1]), (2, [1, 0, 1, 0]), (3, [2, 0, 0, 1]), (4, [3, 1, 0, 2])] {
        assert_eq!(one, sharded_gradient(&network, &input, &d_output, threads, thread_of), "{thread_of:?}");
    }
}

#[test]
fn adam_follows_its_formula() {
    // The first step is rate * g / (|g| + epsilon), whatever the size of g.
    let gradient: Vec<f32> = (0..37).map(|i| (i as f32 - 18.0) * 10f32.powi(i % 9 - 4)).collect();
    let mut adam = Adam::new(37);
    let mut parameters = vec![1.0; 37];
    adam.step(&mut parameters, &gradient, 0.01);
    for (p, g) in parameters.iter().zip(&gradient) {
        let expected = 1.0 - 0.01 * f64::from(*g) / (f64::from(g.abs()) + 1e-5);
        assert!((f64::from(*p) - expected).abs() < 2e-7, "gradient {g}: {p}, expected {expected}");
    }

    // 500 steps on the quadratic sum k x_k^2 / 2 against the paper's algorithm in double precision.
    let mut adam = Adam::new(5);
    let mut x = [1.0f32, -2.0, 3.0, 0.5, -0.1];
    let (mut y, mut m, mut v) = (x.map(f64::from), [0.0f64; 5], [0.0f64; 5]);
    for t in 1..=500 {
        let gradient: Vec<f32> = x.iter().enumerate().map(|(k, x)| (k + 1) as f32 * x).collect();
        adam.step(&mut x, &gradient, 0.02);
        for k in 0..5 {
            let g = (k + 1) as f64 * y[k];
            m[k] = 0.9 * m[k] + 0.1 * g;
            v[k] = 0.999 * v[k] + 0.001 * g * g;
            let (m, v) = (m[k] / (1.0 - 0.9f64.powi(t)), v[k] / (1.0 - 0.999f64.powi(t)));
            y[k] -= 0.02 * m / (v.sqrt() + 1e-5);
        }
    }
    assert_eq!(adam.steps(), 500);
    for (x, y) in x.iter().zip(y) {
        assert!((f64::from(*x) - y).abs() < 1e-4, "{x}, in double precision {y}");
        assert!(x.abs() < 0.05, "the minimum is at zero, not {x}");
    }
}

#[test]
fn gradients_are_clipped_together() {
    let (mut a, mut b) = (vec![0.3f32; 100], vec![-0.4f32; 100]);
    assert!((clip_norm(&mut [&mut a, &mut b], 10.0) - 5.0).abs() < 1e-6);
    assert_eq!((a[0], b[99]), (0.3, -0.4), "below the limit nothing changes");
    assert!((clip_norm(&mut [&mut a, &mut b], 1.0) - 5.0).abs() < 1e-6);
    assert!((clip_norm(&mut [&mut a, &mut b], 1.0) - 1.0).abs() < 1e-6);
    a[3] = f32::NAN;
    let kept = b.clone();
    assert!(clip_norm(&mut [&mut a, &mut b], 0.1).is_nan());
    assert_eq!(b, kept);
}

#[test]
fn stored_networks_and_moments_come_back_to_the_bit() {
    let (mut network, input, d_output) = case(&[5, 40, 3], Activation::Elu, 9);
    let mut adam = Adam::new(network.parameters().len());
    let mut scratch = Activations::new();
    for _ in 0..3 {
        let mut gradient = vec![0.0; network.parameters().len()];
        network.forward(&mut scratch, &input, 9);
        network.backward(&mut scratch, &input, 9, &d_output, &mut gradient);
        adam.step(network.parameters_mut(), &gradient, 1e-3);
    }
    let json: (Network, Adam) = serde_json::from_str(&serde_json::to_string(&(&network, &adam)).unwrap()).unwrap();
    assert_eq!((&json.0, &json.1), (&network, &adam));
    let ron: (Network, Adam) = ron::from_str(&ron::to_string(&(&network, &adam)).unwrap()).unwrap();
    assert_eq!((&ron.0, &ron.1), (&network, &adam));
    assert_eq!(json.0.forward(&mut Activations::new(), &input, 9), network.forward(&mut scratch, &input, 9));

    let huge = format!(r#"{{"sizes":[{0},{0}],"activation":"Tanh","parameters":[]}}"#, usize::MAX);
    for (text, reason) in [
        (r#"{"sizes":[2,1],"activation":"Tanh","parameters":[0,0]}"#, "holds 2 parameters, 3 would be valid"),
        (r#"{"sizes":[2],"activation":"Tanh","parameters":[]}"#, "at least an input and an output size"),
        (r#"{"sizes":[2,0],"activation":"Tanh","parameters":[]}"#, "all of them positive"),
        (&huge, "network sizes"),
    ] {
        let error = serde_json::from_str::<Network>(text).unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    }
}

#[test]
fn first_weights_are_orthogonal_with_their_gain() {
    let network = Network::new(&[40, 24, 60, 3], Activation::Tanh, 0.01, &mut RandomStream::new(3, 0));
    for (layer, gain) in [(0, 2.0), (1, 2.0), (2, 1e-4)] {
        let (inputs, outputs) = (network.sizes()[layer], network.sizes()[layer + 1]);
        let w = |o: usize, i: usize| f64::from(network.weights(layer)[o * inputs + i]);
        let count = inputs.min(outputs);
        for a in 0..count {
            for b in 0..count {
                let product: f64 = if outputs <= inputs {
                    (0..inputs).map(|i| w(a, i) * w(b, i)).sum()
                } else {
                    (0..outputs).map(|o| w(o, a) * w(o, b)).sum()
                };
                let expected = if a == b { gain } else { 0.0 };
                assert!((product - expected).abs() < 1e-6, "layer {layer}: {a} {b}: {product}");
            }
        }
        assert!(network.bias(layer).iter().all(|b| *b == 0.0));
    }
}

/// Mean squared error after so many steps of Adam on the whole batch.
fn fit(activation: Activation, input: &[f32], target: &[f32], steps: usize) -> f32 {
    let rows = target.len();
    let mut network = Network::new(&[input.len() / rows, 32, 32, 1], activation, 1.0, &mut RandomStream::new(11, 0));
    let mut adam = Adam::new(network.parameters().len());
    let mut scratch = Activations::new();
    let mut gradient = vec![0.0; network.parameters().len()];
    let mut error = f32::INFINITY;
    for _ in 0..steps {
        let output = network.forward(&mut scratch, input, rows);
        let difference: Vec<f32> = output.iter().zip(target).map(|(y, t)| y - t).collect();
        error = difference.iter().map(|d| d * d).sum::<f32>() / rows as f32;
        let d_output: Vec<f32> = difference.iter().map(|d| 2.0 * d / rows as f32).collect();
        gradient.fill(0.0);
        network.backward(&mut scratch, input, rows, &d_output, &mut gradient);
        adam.step(network.parameters_mut(), &gradient, 3e-3);
    }
    error
}

#[test]
fn it_learns_exclusive_or_and_a_sine() {
    let sine_input: Vec<f32> = (0..200).map(|i| (i as f32 - 100.0) * 0.03).collect();
    let sine: Vec<f32> = sine_input.iter().map(|x| (2.0 * x).sin()).collect();
    for activation in [Activation::Tanh, Activation::Elu] {
        let or = fit(activation, &[0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0], &[0.0, 1.0, 1.0, 0.0], 300);
        assert!(or < 1e-4, "{activation:?}: exclusive or {or}");
        let wave = fit(activation, &sine_input, &sine, 2000);
        println!("{activation:?}: exclusive or {or:.1e}, sine {wave:.1e}");
        assert!(wave < 1e-3, "{activation:?}: sine {wave}");
    }
}
