//! Contract: in free flight, with the servos at work and the joint limits on, a skater who tucks keeps its momentum.
//!
//! The centre of mass flies a parabola and the angular momentum about it stays what it was, at 1200 and at 300 steps per
//! second, with soft and with stiff servos, with and without self-collision. Both are read off where the links are seen from
//! step to step: the momentum that the simulation holds is written by the step itself and would say so whatever the body does.
//! A check of the spin alone would not do either: a plain semi-implicit step looks right by eye and still loses a third of a
//! turn. The spin-up is read off the turning of the pelvis.

use crate::common::*;
use crate::seen_momentum::Picture;
use bevy_athlete::contact::World;
use bevy_athlete::math::{Quat, Vec3};
use bevy_athlete::model::skater;
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use glam::{DQuat, DVec3};

/// Spin of the open pose, rad/s.
const SPIN: f64 = 8.0;
/// How far the centre of mass may be from its parabola, m.
const OFF_PATH: f64 = 1e-9;
/// Allowed change of the angular momentum that is seen, relative and times the rate: it comes from differences of poses, which are
/// off by a part of a step.
const OFF_SPIN: f64 = 10.0;

struct Outcome {
    /// Largest distance of the centre of mass from its parabola, m.
    off_path: f64,
    /// Largest change of the angular momentum that is seen, relative.
    off_spin: f64,
    /// Turning rate that the inertias give, `I^-1 L` about the vertical, last 0.3 s over start.
    by_inertia: f64,
    /// Turning rate of the pelvis, last 0.3 s over start.
    spin_ratio: f64,
    fingerprint: u64,
}

fn tuck(rate: f64, gains: Option<(f64, f64)>, self_collision: bool, omega: f64, closed: &[DQuat]) -> Outcome {
    let model = skater();
    let mut settings = SimulationSettings { rate, ..SimulationSettings::of(&model) };
    if !self_collision {
        settings.self_collision = None;
    }
    assert!(settings.limits.is_some());
    let mut sim = Simulator::<f64>::new(model.clone(), settings);
    if let Some((kp, kd)) = gains {
        for command in &mut sim.commands {
            (command.kp, command.kd) = (kp, kd);
        }
    }
    let open = open_pose(&model);
    sim.state.set_pose(0, DVec3::new(0.0, 10.0, 0.0), DQuat::IDENTITY, &open);
    sim.state_changed();
    // The centre of mass moves at (1, 3, -2) m/s, the body turns about the vertical through it.
    let arm = sim.center_of_mass().lane(0) - sim.state.root_position.lane(0);
    let spin = DVec3::Y * omega;
    let still = vec![DVec3::ZERO; model.links.len()];
    sim.state.set_velocity(0, DVec3::new(1.0, 3.0, -2.0) - spin.cross(arm), spin, &still);
    sim.state_changed();
    for (command, q) in sim.commands.iter_mut().zip(&open) {
        command.rotation = Quat::splat(*q);
        command.velocity = Vec3::zero();
    }

    let start = sim.total_momentum();
    let (v0, l0) = (start.linear.lane(0) / model.mass(), start.angular.lane(0));
    let gravity = sim.settings().gravity;
    let (mut off_path, mut off_spin) = (0.0_f64, 0.0_f64);
    let mut seen = Picture::of(&mut sim);
    let begin = seen.center;
    let world = World::empty();
    let steps = (1.5 * rate) as usize;
    let (mut turned, mut given, mut timed) = (0.0, 0.0, 0.0);
    for k in 0..steps {
        // Closes between 0.1 and 0.4 s.
        let s = ((k as f64 / rate - 0.1) / 0.3).clamp(0.0, 1.0);
        let s = s * s * (3.0 - 2.0 * s);
        for i in 1..model.links.len() {
            sim.commands[i].rotation = Quat::splat(open[i].slerp(closed[i], s));
        }
        let before = sim.state.root_rotation.lane(0);
        step(&mut sim, &world);
        let t = (k + 1) as f64 / rate;
        let now = Picture::of(&mut sim);
        // Of a semi-implicit step: gravity acts before the place moves on.
        let parabola = begin + v0 * t + 0.5 * gravity * t * (t + 1.0 / rate);
        off_path = off_path.max(now.center.distance(parabola));
        off_spin = off_spin.max((seen.momentum(&now, &model, 1.0 / rate).angular - l0).length() / l0.length());
        seen = now;
        if t > 1.0 {
            let q = sim.state.root_rotation.lane(0) * before.inverse();
            turned += 2.0 * q.y.atan2(q.w);
            given += sim.total_inertia().inverse().mul_vec(Vec3::splat(l0)).y / rate;
            timed += 1.0 / rate;
        }
    }
    Outcome {
        off_path,
        off_spin,
        by_inertia: given / timed / omega,
        spin_ratio: turned / timed / omega,
        fingerprint: sim.state.fingerprint(0),
    }
}

#[test]
fn a_tucking_skater_keeps_its_momentum() {
    let closed = closed_pose(&skater());
    for rate in [1200.0, 300.0] {
        for gains in [None, Some((2000.0, 60.0))] {
            for self_collision in [false, true] {
                let o = tuck(rate, gains, self_collision, SPIN, &closed);
                let off = (o.spin_ratio / o.by_inertia - 1.0).abs();
                println!(
                    "{rate} Hz, gains {gains:?}, self-collision {self_collision}: off the parabola {:.1e} m (allowed \
                     {OFF_PATH:.0e}), angular momentum {:.1e} (allowed {:.1e}); pelvis spins up x{:.3}, by the inertias x{:.3}, off by {:.2} % (allowed 4 %; the limbs still swing)",
                    o.off_path,
                    o.off_spin,
                    OFF_SPIN / rate,
                    o.spin_ratio,
                    o.by_inertia,
                    100.0 * off,
                );
                assert!(o.off_path < OFF_PATH && o.off_spin < OFF_SPIN / rate);
                assert!(o.by_inertia > 1.5, "the tuck closes");
                assert!(off < 0.04);
            }
        }
    }
}

/// Self-collision is a force of its own inside the body: it must not show in the momenta, and must act at all.
#[test]
fn legs_that_collide_in_flight_keep_the_momentum() {
    let closed = tangled_pose(&skater());
    for rate in [1200.0, 300.0] {
        let outcomes = [false, true].map(|on| tuck(rate, None, on, 1.0, &closed));
        let o = &outcomes[1];
        let allowed = OFF_SPIN / rate;
        println!(
            "{rate} Hz, legs crossed: off the parabola {:.1e} m, angular {:.1e} (allowed {allowed:.1e})",
            o.off_path, o.off_spin
        );
        assert!(o.off_path < OFF_PATH && o.off_spin < allowed);
        assert_ne!(outcomes[0].fingerprint, o.fingerprint, "the legs meet, so self-collision acts");
    }
}
