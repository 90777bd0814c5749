//! Contract: the skater itself glides on one blade for 5 s, held up by nothing but its own joints.
//!
//! A knife edge is a tightrope: it takes no torque about its line, so whoever stands on it balances by turning one part of
//! the body against another. A rigid body over a blade (`blade.rs`) cannot show that the blade stays true while 57 degrees
//! of freedom work above it. There is no outside force, and without the feedback the same skater falls.
//!
//! The feedback moves the stance hip only. With x the distance of the centre of mass from the blade's line, H the angular
//! momentum about that line (positive towards x) and phi the hip's target, small motions follow
//!
//! ```text
//! x' = a H + e phi',    H' = m g x,    phi' = u
//! ```
//!
//! with `a` height over inertia for turning about the line as one piece, and `e` what the hip's turning does to x while H
//! stays. `u = -(k . (x, H, phi))` puts all three poles to one place (Ackermann 1972).

use crate::common::*;
use bevy_athlete::contact::{BladeEdge, Surface, World};
use bevy_athlete::math::{Quat, Vec3};
use bevy_athlete::model::{CharacterModel, skater};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use glam::{DQuat, DVec3};

const G: f64 = 9.81;
const SPEED: f64 = 3.0;
const SECONDS: f64 = 5.0;
/// Speed across the blade that is allowed while flat, m/s.
const SLIP: f64 = 1e-3;
/// Servo gains while balancing: stiff and well damped.
const GAINS: (f64, f64) = (2000.0, 200.0);
/// Where the feedback puts its poles, 1/s.
const POLE: f64 = 3.0;
/// The left blade.
const BLADE: usize = 0;
const STANCE_HIP: &str = "thigh_left";

fn link(model: &CharacterModel, name: &str) -> usize {
    model.link_index(name).unwrap()
}

/// On the left leg, knee bent, free leg behind, arms out, the foot level. `roll` and `flex` of the stance hip, degrees,
/// move the body over the blade.
fn posture(model: &CharacterModel, roll: f64, flex: f64) -> (DQuat, Vec<DQuat>) {
    let mut joints = pose(
        model,
        &[
            (STANCE_HIP, [flex, 0.0, roll]),
            ("shin_left", [-25.0, 0.0, 0.0]),
            ("thigh_right", [-15.0, 0.0, 8.0]),
            ("shin_right", [-35.0, 0.0, 0.0]),
            ("bicep_left", [0.0, 0.0, -50.0]),
            ("bicep_right", [0.0, 0.0, 50.0]),
        ],
    );
    let root = DQuat::from_rotation_x(-8.0_f64.to_radians());
    joints[link(model, "foot_left")] =
        (root * joints[link(model, STANCE_HIP)] * joints[link(model, "shin_left")]).inverse();
    (root, joints)
}

/// Toe and heel of the blade.
fn ends(sim: &mut Simulator<f64>) -> [DVec3; 2] {
    let blade = sim.model().blades[BLADE].clone();
    [blade.toe, blade.heel].map(|point| point_position(sim, point))
}

fn middle(sim: &mut Simulator<f64>) -> DVec3 {
    let [toe, heel] = ends(sim);
    (toe + heel) * 0.5
}

/// The skater in that posture with the middle of its blade at the origin, gliding towards -z, told to stay so.
fn stand(roll: f64, flex: f64) -> Simulator<f64> {
    let model = skater();
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
    let (root, joints) = posture(&model, roll, flex);
    sim.state.set_pose(0, DVec3::ZERO, root, &joints);
    sim.state_changed();
    let at = -middle(&mut sim);
    place(&mut sim, at, root, DVec3::NEG_Z * SPEED, DVec3::ZERO);
    for (command, rotation) in sim.commands.iter_mut().zip(&joints) {
        command.rotation = Quat::splat(*rotation);
        (command.kp, command.kd) = GAINS;
    }
    sim
}

/// The posture whose centre of mass is `aside` of the blade's line, and so far behind its middle that the friction does
/// not tip it.
fn above_the_blade(aside: f64) -> Simulator<f64> {
    let (mut roll, mut flex) = (0.0_f64, 20.0_f64);
    for _ in 0..40 {
        let mut sim = stand(roll, flex);
        let com = sim.center_of_mass().lane(0);
        roll += ((com.x - aside) / com.y).to_degrees();
        flex -= ((com.z - Surface::ICE.friction * com.y) / com.y).to_degrees();
    }
    stand(roll, flex)
}

/// The feedback, a test's helper: no part of the crate balances.
struct Balance {
    hip: usize,
    rest: DQuat,
    gains: [f64; 3],
    phi: f64,
}

impl Balance {
    fn new(sim: &mut Simulator<f64>) -> Self {
        let model = sim.model().clone();
        let hip = link(&model, STANCE_HIP);
        let weight = model.mass() * G;
        let height = sim.center_of_mass().lane(0).y;
        let a = height / (sim.total_inertia().zz + model.mass() * height * height);

        // The hip turns by 1 rad/s and the foot stays: what x and H do then, less the turning as one piece that brings
        // H back to zero.
        let mut moving = sim.clone();
        let thigh = moving.kinematics()[hip];
        let spin = thigh.rotation.lane(0) * DVec3::NEG_Z;
        let mut joints = vec![DVec3::ZERO; model.links.len()];
        joints[hip] = DVec3::NEG_Z;
        moving.state.set_velocity(0, spin.cross(thigh.origin.lane(0)), -spin, &joints);
        moving.state_changed();
        let (_, momentum) = Self::measure(&mut moving);
        let e = moving.total_momentum().linear.lane(0).x / model.mass() - a * momentum;

        // s^3 + (e k0 + k2) s^2 + m g (e k1 - a) s - m g a k2 = (s + POLE)^3
        let k2 = -POLE.powi(3) / (weight * a);
        let gains = [(3.0 * POLE - k2) / e, (3.0 * POLE * POLE / weight + a) / e, k2];
        println!("a {a:.5} 1/(kg m), e {e:.4} m, gains {gains:.3?}");
        Self { hip, rest: sim.commands[hip].rotation.lane(0), gains, phi: 0.0 }
    }

    /// Distance of the centre of mass from the blade's line and angular momentum about it, both positive to the right.
    fn measure(sim: &mut Simulator<f64>) -> (f64, f64) {
        let arm = sim.center_of_mass().lane(0) - middle(sim);
        let momentum = sim.total_momentum();
        let about_line = momentum.angular.lane(0) + arm.cross(momentum.linear.lane(0));
        (arm.x, -about_line.z)
    }

    fn drive(&mut self, sim: &mut Simulator<f64>) {
        let (x, momentum) = Self::measure(sim);
        let [k0, k1, k2] = self.gains;
        let rate = -(k0 * x + k1 * momentum + k2 * self.phi);
        self.phi += rate * sim.step_seconds();
        let command = &mut sim.commands[self.hip];
        command.rotation = Quat::splat(self.rest * DQuat::from_rotation_z(-self.phi));
        command.velocity = Vec3::splat(DVec3::NEG_Z * rate);
    }
}

/// What a glide came to.
#[derive(Debug)]
struct Glide {
    /// Time on the left blade alone, flat, s.
    flat: f64,
    /// Of that without load on the blade, s: a jerk of the hip can lift it by some micrometres.
    unloaded: f64,
    /// Largest speed of the blade's ends across it while flat and loaded, m/s.
    slip: f64,
    /// How far the blade's middle and the centre of mass went aside, m.
    blade_drift: f64,
    body_drift: f64,
    /// Largest lean of the blade, degrees.
    lean: f64,
    /// Speed at the end, m/s.
    speed: f64,
}

fn glide(sim: &mut Simulator<f64>, mut balance: Option<Balance>) -> Glide {
    let world = World::ice();
    let h = sim.step_seconds();
    let start = sim.center_of_mass().lane(0).x;
    let mut glide =
        Glide { flat: 0.0, unloaded: 0.0, slip: 0.0, blade_drift: 0.0, body_drift: 0.0, lean: 0.0, speed: 0.0 };
    for _ in 0..(SECONDS / h) as usize {
        let before = ends(sim);
        if let Some(balance) = &mut balance {
            balance.drive(sim);
        }
        step(sim, &world);
        assert!(sim.external.is_empty() && sim.is_sane(0));
        let model = sim.model().clone();
        let (toe, heel) = (model.blades[BLADE].toe, model.blades[BLADE].heel);
        let others = (0..model.contact_points.len()).filter(|p| *p != toe && *p != heel);
        let alone = others.into_iter().all(|point| sim.contact_force(point, 0) == DVec3::ZERO);
        if !alone || sim.blade_edge(BLADE, 0) != BladeEdge::Flat {
            break;
        }
        glide.flat += h;
        if sim.loaded_points(0) == 0 {
            glide.unloaded += h;
        } else {
            let across = DVec3::Y.cross((before[0] - before[1]).with_y(0.0).normalize());
            for (before, after) in before.iter().zip(ends(sim)) {
                glide.slip = glide.slip.max(((after - *before).dot(across) / h).abs());
            }
        }
        glide.blade_drift = glide.blade_drift.max(middle(sim).x.abs());
        glide.lean = glide.lean.max(sim.blade_lean(BLADE, 0).map_or(0.0, |(lean, _)| lean.to_degrees().abs()));
    }
    glide.body_drift = (sim.center_of_mass().lane(0).x - start).abs();
    glide.speed = -sim.total_momentum().linear.lane(0).z / sim.model().mass();
    glide
}

#[test]
fn the_skater_glides_straight_on_one_blade() {
    let mut sim = above_the_blade(0.0);
    let balance = Balance::new(&mut sim);
    let g = glide(&mut sim, Some(balance));
    let expected = SPEED - Surface::ICE.friction * G * SECONDS;
    println!(
        "flat on one blade for {:.3} s ({:.4} s of it unloaded): slipped at most {:.5} mm/s (allowed 1); the blade drifted {:.4} mm and the centre of \
         mass {:.4} mm aside in all (allowed 1 mm/s); leaned {:.2} degrees at most; {:.4} m/s left (mu g t: {expected:.4}, \
         allowed 1 %)",
        g.flat,
        g.unloaded,
        g.slip * 1e3,
        g.blade_drift * 1e3,
        g.body_drift * 1e3,
        g.lean,
        g.speed
    );
    assert!(g.flat > SECONDS - 1e-6 && g.unloaded == 0.0, "{g:?}");
    assert!(g.slip < SLIP && g.blade_drift < 1e-3 && g.body_drift < 1e-3 * SECONDS, "{g:?}");
    assert!((g.speed / expected - 1.0).abs() < 0.01, "{g:?}");
}

/// It is the feedback that balances: from 4 mm aside it comes back; without it the skater falls, from the middle too.
#[test]
fn without_its_feedback_it_falls() {
    let mut sim = above_the_blade(0.004);
    let balance = Balance::new(&mut sim);
    let aside = glide(&mut sim, Some(balance));
    let end = Balance::measure(&mut sim).0;
    let held = glide(&mut above_the_blade(0.0), None);
    println!(
        "from 4 mm aside: flat for {:.3} s ({:.4} s of it unloaded), slipped at most {:.5} mm/s, leaned {:.2} degrees at most, {:.3} mm aside at the \
         end (allowed 0.5); without feedback: flat for {:.3} s",
        aside.flat,
        aside.unloaded,
        aside.slip * 1e3,
        aside.lean,
        end * 1e3,
        held.flat
    );
    assert!(aside.flat > SECONDS - 1e-6 && aside.unloaded < 0.01 && aside.slip < SLIP && end.abs() < 5e-4, "{aside:?}");
    assert!(held.flat < 2.0, "{held:?}");
}
