//! Placeholder network: see branch nn.
use crate::math::RandomStream;
use serde::{Deserialize, Serialize};

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Activation { Tanh }

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Network { sizes: Vec<usize>, parameters: Vec<f32> }

#[derive(Default)]
pub struct Activations { layers: Vec<Vec<f32>>, transposed: Vec<f32>, delta: Vec<f32>, delta2: Vec<f32> }

/// c[m x n] (+)= a[m x k] b[k x n], all row-major.
fn product(a: &[f32], b: &[f32], c: &mut [f32], m: usize, k: usize, n: usize) {
    const W: usize = 16;
    const H: usize = 4;
    let mut r = 0;
    while r < m {
        let h = H.min(m - r);
        let mut col = 0;
        while col < n {
            let w = W.min(n - col);
            let mut acc = [[0.0_f32; W]; H];
            if h == H && w == W {
                for i in 0..k {
                    let brow: &[f32; W] = b[i * n + col..i * n + col + W].try_into().unwrap();
                    for y in 0..H {
                        let x = a[(r + y) * k + i];
                        for z in 0..W { acc[y][z] = x.mul_add(brow[z], acc[y][z]); }
                    }
                }
            } else {
                for i in 0..k { for y in 0..h { for z in 0..w { acc[y][z] += a[(r + y) * k + i] * b[i * n + col + z]; } } }
            }
            for y in 0..h { for z in 0..w { c[(r + y) * n + col + z] += acc[y][z]; } }
            col += W;
        }
        r += H;
    }
}
fn transpose(a: &[f32], rows: usize, cols: usize, out: &mut Vec<f32>) {
    out.clear(); out.resize(rows * cols, 0.0);
    for r in 0..rows { for c in 0..cols { out[c * rows + r] = a[r * cols + c]; } }
}
impl Network {
    pub fn new(sizes: &[usize], _a: Activation, last_gain: f32, random: &mut RandomStream) -> Self {
        let mut parameters = Vec::new();
        for l in 0..sizes.len() - 1 {
            let (i, o) = (sizes[l], sizes[l + 1]);
            let gain = if l + 2 == sizes.len() { last_gain } else { 1.0 };
            for _ in 0..i * o { parameters.push(gain * random.normal() as f32 / (i as f32).sqrt()); }
            for _ in 0..o { parameters.push(0.0); }
        }
        Self { sizes: sizes.to_vec(), parameters }
    }
    pub fn sizes(&self) -> &[usize] { &self.sizes }
    pub fn inputs(&self) -> usize { self.sizes[0] }
    pub fn outputs(&self) -> usize { self.sizes[self.sizes.len() - 1] }
    pub fn parameters(&self) -> &[f32] { &self.parameters }
    pub fn parameters_mut(&mut self) -> &mut [f32] { &mut self.parameters }
    fn at(&self, l: usize) -> usize { (0..l).map(|k| (self.sizes[k] + 1) * self.sizes[k + 1]).sum() }
    /// out x in
    pub fn weights(&self, l: usize) -> &[f32] { let a = self.at(l); &self.parameters[a..a + self.sizes[l] * self.sizes[l + 1]] }
    pub fn bias(&self, l: usize) -> &[f32] { let a = self.at(l) + self.sizes[l] * self.sizes[l + 1]; &self.parameters[a..a + self.sizes[l + 1]] }
    pub fn forward<'a>(&self, s: &'a mut Activations, input: &[f32], rows: usize) -> &'a [f32] {
        let n = self.sizes.len() - 1;
        s.layers.resize_with(n, Vec::new);
        for l in 0..n {
            let (i, o) = (self.sizes[l], self.sizes[l + 1]);
            transpose(self.weights(l), o, i, &mut s.transposed);
            let (before, rest) = s.layers.split_at_mut(l);
            let x = if l == 0 { input } else { &before[l - 1][..] };
            let y = &mut rest[0];
            y.clear();
            for _ in 0..rows { y.extend_from_slice(self.bias(l)); }
            product(x, &s.transposed, y, rows, i, o);
            if l + 1 < n { for v in y.iter_mut() { *v = tanh(*v); } }
        }
        &s.layers[n - 1]
    }
    /// After forward with the same input.
    pub fn backward(&self, s: &mut Activations, input: &[f32], rows: usize, d: &[f32], g: &mut [f32]) {
        let n = self.sizes.len() - 1;
        s.delta.clear(); s.delta.extend_from_slice(d);
        for l in (0..n).rev() {
            let (i, o) = (self.sizes[l], self.sizes[l + 1]);
            let at = self.at(l);
            let x = if l == 0 { input } else { &s.layers[l - 1][..] };
            transpose(&s.delta, rows, o, &mut s.transposed);
            product(&s.transposed, x, &mut g[at..at + i * o], o, rows, i);
            for r in 0..rows { for k in 0..o { g[at + i * o + k] += s.delta[r * o + k]; } }
            if l > 0 {
                s.delta2.clear(); s.delta2.resize(rows * i, 0.0);
                product(&s.delta, self.weights(l), &mut s.delta2, rows, o, i);
                for (d, y) in s.delta2.iter_mut().zip(&s.layers[l - 1]) { *d *= 1.0 - y * y; }
                std::mem::swap(&mut s.delta, &mut s.delta2);
            }
        }
    }
}
fn tanh(x: f32) -> f32 {
    let x = x.clamp(-7.9, 7.9);
    let x2 = x * x;
    let p = x * (135135.0 + x2 * (17325.0 + x2 * (378.0 + x2)));
    let q = 135135.0 + x2 * (62370.0 + x2 * (3150.0 + 28.0 * x2));
    (p / q).clamp(-1.0, 1.0)
}
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adam { m: Vec<f32>, v: Vec<f32>, t: i32 }
impl Adam {
    pub fn new(n: usize) -> Self { Self { m: vec![0.0; n], v: vec![0.0; n], t: 0 } }
    pub fn step(&mut self, p: &mut [f32], g: &[f32], rate: f32) {
        self.t += 1;
        let (c1, c2) = (1.0 - 0.9_f32.powi(self.t), 1.0 - 0.999_f32.powi(self.t));
        for (((p, g), m), v) in p.iter_mut().zip(g).zip(&mut self.m).zip(&mut self.v) {
            *m = 0.9 * *m + 0.1 * g;
            *v = 0.999 * *v + 0.001 * g * g;
            *p -= rate * (*m / c1) / ((*v / c2).sqrt() + 1e-5);
        }
    }
}
pub fn clip_norm(g: &mut [&mut [f32]], max: f32) -> f32 {
    let n = g.iter().flat_map(|g| g.iter()).map(|x| x * x).sum::<f32>().sqrt();
    if n > max { for g in g.iter_mut() { for x in g.iter_mut() { *x *= max / n; } } }
    n
}
