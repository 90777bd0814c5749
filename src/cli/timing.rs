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
    /// The least time of every chunk over the blocks, microseconds per character and step.
    pub us_min: f64,
    /// Median over the blocks, microseconds per character and step.
    pub us_median: f64,
}

/// Times a scene in the lane type of this name (`None` for a name not in [`LANE_NAMES`]): `blocks` times the same second.
/// Only the steps are timed, not what happens between them.
///
/// Every block does exactly the same work, and other programs on the machine seldom disturb the same chunk of it every
/// time: the figure is the sum of the least times of the chunks, so it covers the whole second and not its cheapest part.
pub fn time_scene(scene: &Scene, lanes: &str, blocks: usize) -> Option<BenchRow> {
    let name = *LANE_NAMES.iter().find(|n| **n == lanes)?;
    let run = match name {
        "f64" => time_in::<F64Fused>,
        "f64 play" => time_in::<f64>,
        "4 x f64" => time_in::<F64x4Fused>,
        "4 x f64 play" => time_in::<F64x4>,
        "8 x f32" => time_in::<F32x8Fused>,
        _ => time_in::<F32x8>,
    };
    let Figures { us_min, us_median, points, solver_points } = run(scene, blocks.max(1));
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

fn time_in<R: Real>(scene: &Scene, blocks: usize) -> Figures {
    let chunks = (scene.settings.rate as usize / CHUNK).max(1);
    let per_step = 1e6 / (chunks * CHUNK * R::LANES) as f64;
    let begin = SceneRun::<R>::new(scene);
    let mut least = vec![f64::INFINITY; chunks];
    let mut figures = Vec::with_capacity(blocks);
    let (mut points, mut solver_points) = (0.0, 0.0);
    for _ in 0..blocks {
        let mut run = begin.clone();
        let mut spent = 0.0;
        (points, solver_points) = (0.0, 0.0);
        for least in &mut least {
            run.prepare();
            let start = Instant::now();
            run.advance();
            let seconds = start.elapsed().as_secs_f64();
            *least = least.min(seconds);
            spent += seconds;
            points += run.loaded_points();
            solver_points += run.solver_points();
        }
        figures.push(spent * per_step);
    }
    figures.sort_by(f64::total_cmp);
    Figures {
        us_min: least.iter().sum::<f64>() * per_step,
        us_median: figures[figures.len() / 2],
        points: points / chunks as f64,
        solver_points: solver_points / chunks as f64,
    }
}
