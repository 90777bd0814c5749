//! A program performed once, from a disturbed start, and what became of it.

use crate::contact::{Surface, World};
use crate::control::PolicyError;
use crate::control::tracking::Heading;
use crate::math::RandomStream;
use crate::model::SharedModel;
use crate::sim::{SimulationSettings, Simulator, step};
use crate::skill::{Director, Disturbance, PELVIS, TrialOptions, forbidden_points};
use glam::DVec3;

/// How a performance went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProgramRun {
    /// Index of the last element that was begun.
    pub element: usize,
    /// The skater fell in it.
    pub fell: bool,
    /// Simulated time, s.
    pub seconds: f64,
}

/// Performs a program once; friction and start are drawn as `trial` says, from `seed` and the run's number. `look` is
/// called after every step.
pub fn run_program(
    director: &mut Director,
    model: &SharedModel,
    world: &World,
    trial: &TrialOptions,
    (seed, number): (u64, u64),
    mut look: impl FnMut(&mut Simulator<f64>, &Director),
) -> Result<ProgramRun, PolicyError> {
    let settings = SimulationSettings::of(model);
    let mut sim = Simulator::<f64>::new(model.clone(), settings);
    let mut random = RandomStream::new(seed, 0x7072_6f67_0000 + number);
    director.begin(&mut sim, Heading::ahead(), DVec3::ZERO);
    let disturbance = Disturbance {
        joint: trial.joint_noise,
        joint_velocity: trial.joint_velocity_noise,
        velocity: trial.velocity_noise,
    };
    disturbance.apply(&mut sim.state, 0, &mut random);
    if let Some((low, high)) = trial.friction {
        sim.friction_scale = random.range(low, high) / Surface::ICE.friction;
    }
    sim.state_changed();
    let forbidden = forbidden_points(model);
    let elements = director.as_program().map_or(&[][..], |program| program.elements());
    let most = elements.iter().map(|e| e.seconds + 30.0).sum::<f64>();
    loop {
        director.drive(&mut sim, world)?;
        step(&mut sim, world);
        director.after_step(&mut sim, world);
        look(&mut sim, director);
        let seconds = sim.state.time;
        let run =
            |fell| ProgramRun { element: director.as_program().map_or(0, |program| program.element()), fell, seconds };
        let down = forbidden.iter().any(|&p| sim.contact_force(p, 0) != DVec3::ZERO);
        if down || !sim.is_sane(0) || sim.state.root_position.lane(0).y < trial.pelvis.unwrap_or(PELVIS) {
            return Ok(run(true));
        }
        if director.is_finished() || seconds > most {
            return Ok(run(false));
        }
    }
}
