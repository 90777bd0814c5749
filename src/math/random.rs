//! Seeded random streams: every consumer names its stream, so results do not depend on the order of threads.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// One reproducible stream of random numbers.
#[derive(Clone, Debug)]
pub struct RandomStream {
    generator: Pcg64Mcg,
    spare: Option<f64>,
}

impl RandomStream {
    /// The stream number `stream` of the seed: two different pairs give unrelated streams.
    pub fn new(seed: u64, stream: u64) -> Self {
        // Two rounds of SplitMix64 (Steele, Lea, Flood 2014) spread neighbouring numbers over the whole state.
        let mix = |z: u64| {
            let z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            z ^ (z >> 31)
        };
        let low = mix(seed ^ mix(stream));
        let high = mix(low ^ stream.rotate_left(32));
        let mut bytes = [0; 16];
        bytes[..8].copy_from_slice(&low.to_le_bytes());
        bytes[8..].copy_from_slice(&high.to_le_bytes());
        Self { generator: Pcg64Mcg::from_seed(bytes), spare: None }
    }

    /// A number evenly distributed in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.generator.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// A number evenly distributed in [low, high).
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// An integer evenly distributed in 0..count (count > 0).
    pub fn below(&mut self, count: usize) -> usize {
        ((self.uniform() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// A normally distributed number, mean 0, variance 1 (the polar method of Marsaglia and Bray 1964).
    pub fn normal(&mut self) -> f64 {
        if let Some(value) = self.spare.take() {
            return value;
        }
        loop {
            let (a, b) = (self.range(-1.0, 1.0), self.range(-1.0, 1.0));
            let s = a * a + b * b;
            if s > 0.0 && s < 1.0 {
                let scale = (-2.0 * s.ln() / s).sqrt();
                self.spare = Some(b * scale);
                return a * scale;
            }
        }
    }

    /// A uniformly distributed bit pattern.
    pub fn bits(&mut self) -> u64 {
        self.generator.next_u64()
    }
}
