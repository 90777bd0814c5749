//! A program performed once, from a disturbed start, and what became of it.

use crate::contact::{Surface, World};
use crate::control::PolicyError;
use crate::control::tracking::Heading;
use crate::math::RandomStream;
use crate::model::SharedModel;
use crate::sim::{SimulationSettings, Simulator, step};
use crate::skill::{ProgramPlayer, TrialOptions, forbidden_points};
use glam::{DQuat, DVec3};

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
    player: &mut ProgramPlayer,
    model: &SharedModel,
    world: &World,
    trial: &TrialOptions,
    (seed, number): (u64, u64),
    mut look: impl FnMut(&mut Simulator<f64>, &ProgramPlayer),
) -> Result<ProgramRun, PolicyError> {
    let settings = SimulationSettings::of(model);
    let mut sim = Simulator::<f64>::new(model.clone(), settings);
    let mut random = RandomStream::new(seed, 0x7072_6f67_0000 + number);
    let mut ball = |size: f64| DVec3::from_array([0; 3].map(|_| random.range(-size, size))).clamp_length_max(size);
    player.begin(&mut sim, Heading::ahead(), DVec3::ZERO);
    for joint in sim.state.joints.iter_mut().skip(1) {
        let q = joint.rotation.lane(0) * DQuat::from_scaled_axis(ball(trial.joint_noise));
        joint.rotation.set_lane(0, q.normalize());
    }
    let linear = &mut sim.state.root_velocity.linear;
    linear.set_lane(0, linear.lane(0) + ball(trial.velocity_noise) * DVec3::new(1.0, 0.3, 1.0));
    if let Some((low, high)) = trial.friction {
        sim.friction_scale = random.range(low, high) / Surface::ICE.friction;
    }
    sim.state_changed();
    let forbidden = forbidden_points(model);
    let most = player.elements().iter().map(|e| e.seconds + 30.0).sum::<f64>();
    loop {
        player.drive(&mut sim)?;
        step(&mut sim, world);
        player.after_step(&sim);
        look(&mut sim, player);
        let seconds = sim.state.time;
        let run = |fell| ProgramRun { element: player.element(), fell, seconds };
        let down = forbidden.iter().any(|&p| sim.contact_force(p, 0) != DVec3::ZERO);
        if down || !sim.is_sane(0) || sim.state.root_position.lane(0).y < trial.pelvis {
            return Ok(run(true));
        }
        if player.is_finished() || seconds > most {
            return Ok(run(false));
        }
    }
}
