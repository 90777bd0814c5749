//! Learns one skill several times, each time without one of the things that the learner does, and draws the measured
//! survival of all of them.
//!
//! ```sh
//! cargo run --release --no-default-features --features cli --example what_helps -- forward_three_turn 10 what_helps.png
//! ```
//!
//! Arguments: the skill, million samples for each, the picture, and how many are learnt side by side (1 if not given), which
//! share the cores. Prints for each the mean of its last five measurements.

use bevy_athlete::cli::{find_skill, load_task};
use bevy_athlete::skill::SkillDefinition;
use bevy_athlete::storyboard::{Chart, Curve, charts_png};
use bevy_athlete::train::ppo::{TrainOptions, Trainer};
use std::error::Error;
use std::time::Instant;

/// What is left out, and how.
type Variant = (&'static str, fn(&mut SkillDefinition, &mut TrainOptions));

const VARIANTS: [Variant; 8] = [
    ("as it is", |_, _| ()),
    ("starts uniform", |_, options| options.uniform_share = 1.0),
    ("no starts at the beginning", |skill, _| skill.episode.begin_share = 0.0),
    ("last actor, no mean", |_, options| options.average = 1),
    ("turn and feet not watched", |skill, _| {
        (skill.limits.turn, skill.limits.free_foot, skill.limits.standing_foot) = (None, false, false);
    }),
    ("never pushed", |skill, _| skill.episode.push = None),
    ("always the same friction", |skill, _| {
        skill.episode.friction = skill.episode.friction.map(|(low, high)| (0.5 * (low + high), 0.5 * (low + high)));
    }),
    ("not smoothed", |_, options| options.smoothness = 0.0),
];

/// Measurements that a point of a curve is the mean of.
const MEAN_OF: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (name, millions, out) = match (arguments.next(), arguments.next(), arguments.next()) {
        (Some(name), Some(millions), Some(out)) => (name, millions.parse::<f64>()?, out),
        _ => return Err("give a skill, the million samples for each training, and the picture's path".into()),
    };
    let at_once = arguments.next().map_or(Ok(1), |n| n.parse::<usize>())?.clamp(1, VARIANTS.len());
    let threads = (TrainOptions::default().threads / at_once).max(1);
    let mut curves = Vec::new();
    for some in VARIANTS.chunks(at_once) {
        let learnt = std::thread::scope(|scope| {
            let name = &name;
            let run = |variant: &'static Variant| scope.spawn(move || learn(name, variant, millions, threads));
            let running: Vec<_> = some.iter().map(run).collect();
            running.into_iter().map(|training| training.join()).collect::<Vec<_>>()
        });
        for curve in learnt {
            curves.push(curve.map_err(|_| "a training panicked")??);
        }
    }
    let chart = Chart { title: name, x_label: "million samples".into(), low: 0.0, high: 1.0, curves };
    std::fs::write(&out, charts_png(&[chart], 900, 420)?).map_err(|e| format!("{out}: {e}"))?;
    Ok(())
}

/// Learns the skill once. Failures are texts, which may cross threads.
fn learn(name: &str, (variant, change): &Variant, millions: f64, threads: usize) -> Result<Curve, String> {
    let text = |e: Box<dyn Error>| e.to_string();
    let mut skill = SkillDefinition::load(find_skill(name).map_err(|e| text(e.into()))?).map_err(|e| e.to_string())?;
    let mut options = TrainOptions { threads, ..TrainOptions::default() };
    change(&mut skill, &mut options);
    let task = load_task(&skill, None).map_err(|e| text(e.into()))?;
    let mut trainer = Trainer::new(task, options).map_err(|e| e.to_string())?;
    let began = Instant::now();
    let mut measured = Vec::new();
    loop {
        let news = trainer.iterate();
        if news.samples as f64 >= 1e6 * millions {
            break;
        }
        if let Some((survival, _)) = news.evaluation {
            measured.push((news.samples as f64 / 1e6, survival));
        }
    }
    let mean = |points: &[(f64, f64)]| {
        let n = points.len().max(1) as f64;
        (points.last().map_or(0.0, |p| p.0), points.iter().map(|p| p.1).sum::<f64>() / n)
    };
    let points: Vec<_> = measured.windows(MEAN_OF).map(mean).collect();
    let (samples, survival) = points.last().copied().unwrap_or((0.0, 0.0));
    let minutes = began.elapsed().as_secs_f64() / 60.0;
    println!("{variant:<28} {samples:>6.1} million samples, {minutes:.1} min, survival {:>5.1} %", 100.0 * survival);
    Ok(Curve { name: (*variant).into(), points })
}
