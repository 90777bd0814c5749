//! How fast the networks learn: microseconds for a minibatch of 1,024 rows in four shards, on one and two threads, by each of the
//! vector instructions that the processor has.
//!
//! `cargo run --release --no-default-features --features train --example learner_speed`
//!
//! Look at `sum` on two threads: the cost of one step of actor and critic.

use std::thread;
use std::time::Instant;

use bevy_athlete::math::RandomStream;
use bevy_athlete::train::nn::{Activation, Activations, Adam, Network, known_instructions, use_instructions};

const ROWS: usize = 1024;
const SHARD: usize = 256;
const HIDDEN: usize = 128;
const INPUTS: usize = 300;

/// Multiply-adds count as two. Derivatives with respect to the input are not needed, so the first layer has two products, the others three.
fn operations(sizes: &[usize], rows: usize) -> f64 {
    let weights: Vec<usize> = sizes.windows(2).map(|pair| pair[0] * pair[1]).collect();
    2.0 * (3 * weights.iter().sum::<usize>() - weights[0]) as f64 * rows as f64
}

/// Seconds of the fastest of `repeats` calls.
fn fastest(repeats: usize, mut call: impl FnMut()) -> f64 {
    (0..repeats)
        .map(|_| {
            let start = Instant::now();
            call();
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

/// Seconds of a minibatch: shards dealt to the threads, gradients added in the order of the shards, Adam.
fn minibatch(name: &str, outputs: usize, activation: Activation, threads: usize) -> f64 {
    let sizes = [INPUTS, HIDDEN, HIDDEN, HIDDEN, outputs];
    let mut random = RandomStream::new(1, 0);
    let mut network = Network::new(&sizes, activation, 0.01, &mut random);
    let mut adam = Adam::new(network.parameters().len());
    let input: Vec<f32> = (0..ROWS * INPUTS).map(|_| random.normal() as f32).collect();
    let mut scratch = vec![Activations::new(); threads];
    let mut gradients = vec![vec![0.0; network.parameters().len()]; ROWS / SHARD];
    let mut sum = vec![0.0; network.parameters().len()];
    let (mut passes, mut steps) = (f64::INFINITY, f64::INFINITY);
    let total = fastest(400, || {
        let start = Instant::now();
        let network_now = &network;
        let work = |scratch: &mut Activations, gradients: &mut [Vec<f32>], input: &[f32]| {
            for (gradient, input) in gradients.iter_mut().zip(input.chunks(SHARD * INPUTS)) {
                gradient.fill(0.0);
                let d_output: Vec<f32> = network_now.forward(scratch, input, SHARD).iter().map(|y| y * 1e-3).collect();
                network_now.backward(scratch, input, SHARD, &d_output, gradient);
            }
        };
        let share = (ROWS / SHARD) / threads;
        let mut parts = scratch.iter_mut().zip(gradients.chunks_mut(share)).zip(input.chunks(share * SHARD * INPUTS));
        thread::scope(|scope| {
            let ((first, first_gradients), first_input) = parts.next().expect("one thread at least");
            for ((scratch, gradients), input) in parts {
                scope.spawn(move || work(scratch, gradients, input));
            }
            work(first, first_gradients, first_input);
        });
        passes = passes.min(start.elapsed().as_secs_f64());
        let start = Instant::now();
        sum.fill(0.0);
        for gradient in &gradients {
            sum.iter_mut().zip(gradient).for_each(|(sum, value)| *sum += value);
        }
        adam.step(network.parameters_mut(), &sum, 3e-4);
        steps = steps.min(start.elapsed().as_secs_f64());
    });
    println!(
        "{name:7} {threads} threads: {:6.0} us ({:3.0} GF/s in {:.0} us of passes, {:.0} us of sums and Adam)",
        total * 1e6,
        operations(&sizes, ROWS) / passes * 1e-9,
        passes * 1e6,
        steps * 1e6
    );
    total
}

fn main() {
    for instructions in known_instructions().into_iter().filter(|name| *name != "scalar") {
        println!("# {instructions}");
        use_instructions(Some(instructions)).expect("they are known");
        measure();
    }
}

/// Everything by the instructions in use.
fn measure() {
    for activation in [Activation::Tanh, Activation::Elu] {
        println!(
            "{activation:?}, {INPUTS}-{HIDDEN}-{HIDDEN}-{HIDDEN}-51 and -1, {ROWS} rows in shards of {SHARD}, fastest of 400"
        );
        for threads in [1, 2] {
            let both = minibatch("actor", 51, activation, threads) + minibatch("critic", 1, activation, threads);
            println!("sum     {threads} threads: {:6.0} us", both * 1e6);
        }
    }
    let mut random = RandomStream::new(1, 0);
    let network = Network::new(&[INPUTS, HIDDEN, HIDDEN, HIDDEN, 51], Activation::Tanh, 0.01, &mut random);
    let mut scratch = Activations::new();
    for rows in [1, 64, 128, 256] {
        let input: Vec<f32> = (0..rows * INPUTS).map(|_| random.normal() as f32).collect();
        let time = fastest(4000, || {
            network.forward(&mut scratch, &input, rows);
        });
        let weights: usize = network.sizes().windows(2).map(|pair| pair[0] * pair[1]).sum();
        println!("forward of {rows:3} rows: {:5.1} us ({:.0} GF/s)", time * 1e6, 2e-9 * (weights * rows) as f64 / time);
    }
    let mut network = network;
    let input = vec![0.5; INPUTS];
    let time = fastest(1000, || {
        network.parameters_mut()[0] += 1e-6;
        network.forward(&mut scratch, &input, 1);
    });
    println!("forward of   1 row after a change of parameters: {:5.1} us", time * 1e6);
}
