//! Triangles to pixels: a depth buffer of several samples a pixel, shading by normal, outlines where solids meet.
//!
//! A depth buffer rather than sorted polygons, because limbs reach into each other at the joints and no order of whole
//! polygons is right there.

use super::camera::Camera;
use super::mesh::{Side, Solid, Vertex};
use glam::{DVec3, Vec3};
use tiny_skia::{Pixmap, PremultipliedColorU8};

/// Samples a pixel, along each side.
const SAMPLES: usize = 3;
/// A step in depth that gets a dark outline rather than a faint one, m.
const STEP: f32 = 0.03;

/// Samples of one cell.
pub(crate) struct Layer {
    width: usize,
    height: usize,
    depth: Vec<f32>,
    color: Vec<Vec3>,
    id: Vec<u16>,
}

impl Layer {
    /// An empty layer for a cell of this size, pixels.
    pub fn new(width: u32, height: u32) -> Self {
        let (width, height) = (width as usize * SAMPLES, height as usize * SAMPLES);
        let n = width * height;
        Self { width, height, depth: vec![f32::NEG_INFINITY; n], color: vec![Vec3::ZERO; n], id: vec![0; n] }
    }

    /// Draws a solid.
    pub fn solid(&mut self, camera: &Camera, solid: &Solid) {
        let base = hue(solid.side);
        for t in solid.vertices.chunks_exact(3) {
            self.triangle(camera, [t[0], t[1], t[2]], base, solid.id);
        }
    }

    fn triangle(&mut self, camera: &Camera, t: [Vertex; 3], base: Vec3, id: u16) {
        let corners = t.map(|v| {
            let (x, y, z) = camera.project(v.position);
            Vec3::new(x * SAMPLES as f32, y * SAMPLES as f32, z)
        });
        let colors = t.map(|v| shade(base, (camera.axes * v.normal).as_vec3(), v.normal.y as f32));
        self.fill(corners, |layer, i, weights| {
            let z = weights.dot(Vec3::new(corners[0].z, corners[1].z, corners[2].z));
            if z > layer.depth[i] {
                layer.depth[i] = z;
                layer.color[i] = colors[0] * weights.x + colors[1] * weights.y + colors[2] * weights.z;
                layer.id[i] = id;
            }
        });
    }

    /// Marks where a solid, pressed flat onto the ground from straight above, would be.
    pub fn shadow(&mut self, camera: &Camera, solid: &Solid) {
        for t in solid.vertices.chunks_exact(3) {
            let corners = [t[0], t[1], t[2]].map(|v| {
                let p = v.position;
                let (x, y, z) = camera.project(DVec3::new(p.x, camera.target.y, p.z));
                Vec3::new(x * SAMPLES as f32, y * SAMPLES as f32, z)
            });
            self.fill(corners, |layer, i, _| layer.id[i] = 1);
        }
    }

    /// Visits the samples inside a triangle, with the weights of its corners.
    fn fill(&mut self, c: [Vec3; 3], mut visit: impl FnMut(&mut Self, usize, Vec3)) {
        let edge = |a: Vec3, b: Vec3, x: f32, y: f32| (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
        let area = edge(c[0], c[1], c[2].x, c[2].y);
        if area.abs() < 1e-6 || !area.is_finite() {
            return;
        }
        let range = |v: [f32; 3], size: usize| {
            let low = v.iter().copied().fold(f32::INFINITY, f32::min).floor().max(0.0) as usize;
            let high = v.iter().copied().fold(f32::NEG_INFINITY, f32::max).ceil().clamp(0.0, size as f32) as usize;
            low..high
        };
        for y in range(c.map(|p| p.y), self.height) {
            for x in range(c.map(|p| p.x), self.width) {
                let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
                let w = Vec3::new(edge(c[1], c[2], px, py), edge(c[2], c[0], px, py), edge(c[0], c[1], px, py)) / area;
                if w.min_element() >= 0.0 {
                    visit(self, y * self.width + x, w);
                }
            }
        }
    }

    /// Darkens the samples at the edge of a solid, on the side nearer to the viewer.
    pub fn outline(&mut self) {
        let factor = |i: usize| {
            let (x, y) = (i % self.width, i / self.width);
            let mut factor = 1.0f32;
            for (dx, dy) in [(-2, 0), (2, 0), (0, -2), (0, 2), (-1, -1), (1, 1), (1, -1), (-1, 1)] {
                let (Some(nx), Some(ny)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else { continue };
                if nx >= self.width || ny >= self.height {
                    continue;
                }
                let n = ny * self.width + nx;
                if self.id[n] != self.id[i] {
                    let gap = self.depth[i] - self.depth[n];
                    factor = factor.min(if gap > STEP { 0.42 } else { 0.74 });
                }
            }
            factor
        };
        let factors: Vec<f32> = (0..self.id.len()).map(|i| if self.id[i] == 0 { 1.0 } else { factor(i) }).collect();
        for (color, factor) in self.color.iter_mut().zip(factors) {
            *color *= factor;
        }
    }

    /// Lays the layer over a picture; `opacity` 1 hides what is below.
    pub fn over(&self, pixmap: &mut Pixmap, opacity: f32) {
        let width = pixmap.width() as usize;
        let pixels = pixmap.pixels_mut();
        for (i, pixel) in pixels.iter_mut().enumerate() {
            let (mut sum, mut covered) = (Vec3::ZERO, 0);
            for s in self.samples(i % width, i / width) {
                if self.id[s] != 0 {
                    sum += self.color[s];
                    covered += 1;
                }
            }
            if covered > 0 {
                let alpha = opacity * covered as f32 / (SAMPLES * SAMPLES) as f32;
                *pixel = mix(*pixel, sum / covered as f32, alpha);
            }
        }
    }

    /// Lays the layer over a picture as a shadow, blurred by `radius` pixels.
    pub fn over_as_shadow(&self, pixmap: &mut Pixmap, color: Vec3, opacity: f32, radius: usize) {
        let (width, height) = (pixmap.width() as usize, pixmap.height() as usize);
        let covered = |i| self.samples(i % width, i / width).filter(|&s| self.id[s] != 0).count();
        let mut mask: Vec<f32> = (0..width * height).map(|i| covered(i) as f32 / (SAMPLES * SAMPLES) as f32).collect();
        // Three box blurs are close to a Gaussian.
        for _ in 0..3 {
            mask = blur_rows(&mask, width, height, radius.max(1));
            mask = transpose(&mask, width, height);
            mask = blur_rows(&mask, height, width, (radius / 3).max(1));
            mask = transpose(&mask, height, width);
        }
        for (pixel, m) in pixmap.pixels_mut().iter_mut().zip(mask) {
            if m > 1e-3 {
                *pixel = mix(*pixel, color, (m * opacity).min(1.0));
            }
        }
    }

    fn samples(&self, x: usize, y: usize) -> impl Iterator<Item = usize> {
        let start = y * SAMPLES * self.width + x * SAMPLES;
        let width = self.width;
        (0..SAMPLES * SAMPLES).map(move |k| start + k / SAMPLES * width + k % SAMPLES)
    }
}

fn blur_rows(mask: &[f32], width: usize, height: usize, radius: usize) -> Vec<f32> {
    let mut out = vec![0.0; mask.len()];
    for y in 0..height {
        let row = &mask[y * width..(y + 1) * width];
        let at = |i: isize| if i < 0 || i >= width as isize { 0.0 } else { row[i as usize] };
        let mut sum: f32 = (0..radius.min(width)).map(|i| row[i]).sum();
        for x in 0..width {
            sum += at((x + radius) as isize) - at(x as isize - radius as isize - 1);
            out[y * width + x] = sum / (2 * radius + 1) as f32;
        }
    }
    out
}

fn transpose(mask: &[f32], width: usize, height: usize) -> Vec<f32> {
    (0..mask.len()).map(|i| mask[(i % height) * width + i / height]).collect()
}

fn mix(pixel: PremultipliedColorU8, color: Vec3, alpha: f32) -> PremultipliedColorU8 {
    let c = |old: u8, new: f32| (f32::from(old) * (1.0 - alpha) + 255.0 * new.clamp(0.0, 1.0) * alpha).round() as u8;
    let (r, g, b) = (c(pixel.red(), color.x), c(pixel.green(), color.y), c(pixel.blue(), color.z));
    PremultipliedColorU8::from_rgba(r, g, b, 255).unwrap_or(pixel)
}

/// The colour of a side, 0 to 1.
pub(crate) fn hue(side: Side) -> Vec3 {
    match side {
        Side::Left => Vec3::new(0.20, 0.52, 0.86),
        Side::Right => Vec3::new(0.93, 0.45, 0.25),
        Side::Middle => Vec3::new(0.80, 0.80, 0.83),
        Side::Steel => Vec3::new(0.40, 0.45, 0.52),
        Side::Scenery => Vec3::new(0.74, 0.71, 0.66),
        Side::Marked => Vec3::new(0.86, 0.10, 0.14),
    }
}

/// A key light from the upper left behind the viewer, sky from above, light from the ground below, and a faint rim.
fn shade(base: Vec3, view_normal: Vec3, world_up: f32) -> Vec3 {
    let key = Vec3::new(-0.45, 0.66, 0.6);
    let diffuse = ((view_normal.dot(key) + 0.25) / 1.25).max(0.0);
    let sky = Vec3::new(0.46, 0.48, 0.52).lerp(Vec3::new(0.30, 0.31, 0.36), 0.5 - 0.5 * world_up);
    let rim = (1.0 - view_normal.z.clamp(0.0, 1.0)).powi(3) * 0.10;
    let shine = (2.0 * view_normal.dot(key) * view_normal.z - key.z).max(0.0).powi(24) * 0.12;
    base * (sky + Vec3::splat(0.66 * diffuse)) + Vec3::splat(rim + shine)
}
