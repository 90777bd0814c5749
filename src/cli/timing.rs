//! Microseconds per character and step.

use crate::math::{F32x8, F32x8Fused, F64Fused, F64x4, F64x4Fused, Real};
use crate::scenes::{CHUNK, Scene, SceneRun};
use serde::Serialize;
use std::time::Instant;

/// Lane types that are timed. Those without `play` are the training configuration, which fuses multiply and add where
/// the build has the instruction; `play` never does and has the same bits everywhere.
pub const LANE_NAMES: [&str; 6] = ["f64", "f64 play", "4 x f64", "4 x f64 play", "8 x f32", "8 x f32 play"];

/// One figure of the benchmark.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BenchRow {
    /// Name of the scene.
    pub scene: String,
    /// `bevy_athlete`.
    pub engine: &'static str,
    /// One of [`LANE_NAMES`].
    pub lanes: &'static str,
    /// Contact points that carried load, mean.
    pub points: f64,
    /// Contact points in the solver, mean: those near enough to touch within the step.
    pub solver_points: f64,
    /// Least time over the batches, microseconds per character and step.
    pub us_min: f64,
    /// Median over the batches, microseconds per character and step.
    pub us_median: f64,
}

/// Times a scene in the lane type of this name (`None` for a name not in [`LANE_NAMES`]): `batches` batches of `steps`
/// steps, after two batches to warm up. Only the steps are timed, not what happens between them.
pub fn time_scene(scene: &Scene, lanes: &str, batches: usize, steps: usize) -> Option<BenchRow> {
    let name = *LANE_NAMES.iter().find(|n| **n == lanes)?;
    let run = match name {
        "f64" => time_in::<F64Fused>,
        "f64 play" => time_in::<f64>,
        "4 x f64" => time_in::<F64x4Fused>,
        "4 x f64 play" => time_in::<F64x4>,
        "8 x f32" => time_in::<F32x8Fused>,
        _ => time_in::<F32x8>,
    };
    let Figures { us_min, us_median, points, solver_points } = run(scene, batches.max(1), steps);
    let short = |value: f64, digits: f64| (value * digits).round() / digits;
    Some(BenchRow {
        scene: scene.name.to_owned(),
        engine: "bevy_athlete",
        lanes: name,
        points: short(points, 10.0),
        solver_points: short(solver_points, 10.0),
        us_min: short(us_min, 1e4),
        us_median: short(us_median, 1e4),
    })
}

/// Least and median microseconds per character and step, and mean numbers of points.
struct Figures {
    us_min: f64,
    us_median: f64,
    points: f64,
    solver_points: f64,
}

fn time_in<R: Real>(scene: &Scene, batches: usize, steps: usize) -> Figures {
    const WARM_UP: usize = 2;
    let chunks = (steps / CHUNK).max(1);
    let mut run = SceneRun::<R>::new(scene);
    let mut figures = Vec::with_capacity(batches);
    let (mut points, mut solver_points, mut looks) = (0.0, 0.0, 0.0);
    for batch in 0..batches + WARM_UP {
        let mut spent = 0.0;
        for _ in 0..chunks {
            run.prepare();
            let begin = Instant::now();
            run.advance();
            spent += begin.elapsed().as_secs_f64();
            points += run.loaded_points();
            solver_points += run.solver_points();
            looks += 1.0;
        }
        if batch >= WARM_UP {
            figures.push(spent * 1e6 / (chunks * CHUNK * R::LANES) as f64);
        }
    }
    figures.sort_by(f64::total_cmp);
    Figures {
        us_min: figures[0],
        us_median: figures[figures.len() / 2],
        points: points / looks,
        solver_points: solver_points / looks,
    }
}
