//! Scenes shared by the benchmark, the tests and the MuJoCo comparison: one definition of "the skater standing on both
//! blades" for all of them.
//!
//! | scene | what happens | steps are |
//! | --- | --- | --- |
//! | `skater_stand` | the skater on ice on both blades, four points each; trunk and arms sway by 0.15 rad at 1 Hz | whole steps |
//! | `skater_stand_cold` | the same; every 20 steps all joints are disturbed (by 0.001 rad and 0.02 rad/s) | whole steps |
//! | `foot_stand` | the foot human on ground on both feet, swaying | whole steps |
//! | `foot_stand_cold` | the same, disturbed | whole steps |
//! | `skater_air` | random poses in the air, servos on | forward dynamics without contact or integration |
//! | `skater_air_step` | the skater in flight, servos on, swaying | whole steps, contact search included |
//!
//! Joint limits and self-collision are off: the exported MuJoCo models have neither. The standing characters lean from
//! the ankles so that their weight is over the middle of their feet, as in `benches/mujoco/bench.py`, and go back to the
//! posture they started from after every period of the sway (after 120 steps where they are disturbed or in flight).

use crate::contact::{Surface, World};
use crate::math::{Quat, RandomStream, Real};
use crate::model::{CharacterModel, ContactKind, ContactPoint, JointKind, PointRole, SharedModel, foot_human, skater};
use crate::sim::{SimulationSettings, Simulator, step};
use glam::{DQuat, DVec3};
use std::sync::Arc;

/// Names of the scenes.
pub const SCENE_NAMES: [&str; 6] =
    ["skater_stand", "skater_stand_cold", "foot_stand", "foot_stand_cold", "skater_air", "skater_air_step"];
/// Steps between two changes of the targets, and between two disturbances of a cold scene.
pub const CHUNK: usize = 20;
/// Steps after which a disturbed or falling character goes back to where it started.
const RESET_STEPS: u64 = 120;
/// Lean of the standing skater from the ankles, which brings its weight over the middle of its blades, rad.
const SKATER_LEAN: f64 = 0.027;
/// The same of the foot human, rad: all 32 points of its feet that lie in the plane of the soles touch.
const FOOT_LEAN: f64 = 0.025;
/// How long a standing character comes to rest before the scene begins, s.
const SETTLE: f64 = 3.0;
/// Amplitude of the sway, rad.
pub const SWAY: f64 = 0.15;
/// Rate of the sway, 1/s.
pub const SWAY_RATE: f64 = 1.0;
/// Standard deviation of the disturbance of a joint in a cold scene, rad.
pub const COLD_ANGLE: f64 = 0.001;
/// Standard deviation of the disturbance of a joint's speed in a cold scene, rad/s.
pub const COLD_SPEED: f64 = 0.02;
/// Radius of the points added to a blade, whose lowest points lie on its edge, m.
const POINT_RADIUS: f64 = 0.002;
/// Links whose joints are below this height at rest, and their parents above it, are feet, m.
const ANKLE_HEIGHT: f64 = 0.2;

/// What a scene does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneKind {
    /// Stands and sways.
    Stand,
    /// Stands, sways and is disturbed.
    StandCold,
    /// Forward dynamics only, in random poses.
    Forward,
    /// Whole steps in flight.
    Flight,
}

/// A character in a world with something to do.
#[derive(Clone, Debug)]
pub struct Scene {
    /// One of [`SCENE_NAMES`].
    pub name: &'static str,
    /// The character, with the contact points of the scene.
    pub model: SharedModel,
    /// The world.
    pub world: World,
    /// Rate and switches.
    pub settings: SimulationSettings,
    /// What it does.
    pub kind: SceneKind,
    /// Friction coefficient of the world's floor.
    pub floor_friction: f64,
    /// Joints that sway: link and axis (child frame).
    sway: Vec<(usize, DVec3)>,
    /// Links below the ankles.
    feet: Vec<usize>,
    /// Lean from the ankles, rad.
    lean: f64,
}

/// The scene of this name.
pub fn scene(name: &str) -> Option<Scene> {
    let name = *SCENE_NAMES.iter().find(|n| **n == name)?;
    let kind = match name {
        "skater_air" => SceneKind::Forward,
        "skater_air_step" => SceneKind::Flight,
        _ if name.ends_with("_cold") => SceneKind::StandCold,
        _ => SceneKind::Stand,
    };
    let (model, surface, lean) = if name.starts_with("foot") {
        (foot_human(), Surface::GROUND, FOOT_LEAN)
    } else {
        (Arc::new(with_blade_points(&skater())), Surface::ICE, SKATER_LEAN)
    };
    let settings = SimulationSettings { limits: None, self_collision: None, ..SimulationSettings::of(&model) };
    let (sway, feet) = (swaying_joints(&model), feet(&model));
    Some(Scene {
        name,
        model,
        world: World::plane(surface),
        settings,
        kind,
        floor_friction: surface.friction,
        sway,
        feet,
        lean,
    })
}

/// The character with two more points on the line of each blade, a third and two thirds of the way from heel to toe.
fn with_blade_points(model: &CharacterModel) -> CharacterModel {
    let mut model = model.clone();
    for blade in &model.blades {
        let [toe, heel] = [blade.toe, blade.heel].map(|i| model.contact_points[i].position);
        for (name, part) in [("third", 1.0 / 3.0), ("two_thirds", 2.0 / 3.0)] {
            model.contact_points.push(ContactPoint {
                name: format!("blade_{}_{name}", blade.name),
                link: blade.link,
                position: heel.lerp(toe, part) + DVec3::Y * POINT_RADIUS,
                radius: POINT_RADIUS,
                friction: 1.0,
                kind: ContactKind::Point,
                role: PointRole::Foot,
            });
        }
    }
    model
}

/// The first trunk joint, bending forwards, and the two shoulders, sideways.
fn swaying_joints(model: &CharacterModel) -> Vec<(usize, DVec3)> {
    let find = |words: &'static [&'static str]| {
        let fits = move |(_, link): &(usize, &crate::model::Link)| {
            link.joint == JointKind::Ball && words.iter().any(|w| link.name.contains(w))
        };
        model.links.iter().enumerate().filter(fits).map(|(i, _)| i)
    };
    let trunk = find(&["abdomen", "lower_back", "spine", "torso", "trunk", "chest"]).take(1).map(|i| (i, DVec3::X));
    let arms = find(&["bicep", "upper_arm", "humerus", "shoulder"]).take(2).map(|i| (i, DVec3::Z));
    trunk.chain(arms).collect()
}

/// The links right below the ankles.
fn feet(model: &CharacterModel) -> Vec<usize> {
    let (places, floor) = (model.rest_positions(), -model.rest_root_height());
    let low = |i: usize| places[i].y - floor < ANKLE_HEIGHT;
    (1..model.links.len()).filter(|&i| low(i) && model.links[i].parent.is_some_and(|p| !low(p))).collect()
}

impl Scene {
    /// The character for another simulator. MuJoCo takes the larger of two friction coefficients where this crate
    /// multiplies, so the ground's goes into the points' own. On ice the points keep theirs: with no knife edge there,
    /// ordinary friction is what holds a blade sideways.
    pub fn exported_model(&self) -> CharacterModel {
        let mut model = CharacterModel::clone(&self.model);
        if model.blades.is_empty() {
            for point in &mut model.contact_points {
                point.friction *= self.floor_friction;
            }
        }
        model
    }

    /// Steps after which the scene begins anew: a period of the sway, or less where the character does not stay upright.
    pub fn reset_steps(&self) -> u64 {
        match self.kind {
            SceneKind::Stand => (self.settings.rate / SWAY_RATE).round() as u64,
            _ => RESET_STEPS,
        }
    }

    /// Whether characters of this scene stand on something.
    pub fn stands(&self) -> bool {
        matches!(self.kind, SceneKind::Stand | SceneKind::StandCold)
    }

    fn aim<R: Real>(&self, sim: &mut Simulator<R>, time: f64) {
        for &foot in &self.feet {
            sim.commands[foot].rotation = Quat::splat(DQuat::from_rotation_x(self.lean));
        }
        let angle = SWAY * (2.0 * core::f64::consts::PI * SWAY_RATE * time).sin();
        for &(link, axis) in &self.sway {
            for lane in 0..R::LANES {
                // Lanes differ a little, as the members of a crowd do.
                let part = angle * (1.0 - 0.03 * lane as f64);
                sim.commands[link].rotation.set_lane(lane, DQuat::from_axis_angle(axis, part));
            }
        }
    }

    /// The simulation after standing still for `seconds`, leaning from the ankles as one piece.
    fn stand(&self, seconds: f64) -> Simulator<f64> {
        let mut sim = Simulator::<f64>::new(self.model.clone(), self.settings);
        let places = self.model.rest_positions();
        let pivot = self.feet.iter().map(|&i| places[i]).sum::<DVec3>() / self.feet.len().max(1) as f64;
        let mut joints = vec![DQuat::IDENTITY; self.model.links.len()];
        for &foot in &self.feet {
            joints[foot] = DQuat::from_rotation_x(self.lean);
        }
        // Turned back about the ankles, so that the feet lie flat, a hair below the floor.
        let turn = DQuat::from_rotation_x(-self.lean);
        let height = DVec3::Y * (self.model.rest_root_height() - 2e-4);
        sim.state.set_pose(0, height + pivot - turn * pivot, turn, &joints);
        sim.state_changed();
        self.aim(&mut sim, 0.0);
        for _ in 0..(seconds * self.settings.rate) as usize {
            step(&mut sim, &self.world);
        }
        sim
    }
}

/// A scene under way in every lane.
#[derive(Clone, Debug)]
pub struct SceneRun<R: Real> {
    scene: Scene,
    /// The simulator.
    pub sim: Simulator<R>,
    start: crate::dynamics::State<R>,
    steps: u64,
    random: RandomStream,
}

impl<R: Real> SceneRun<R> {
    /// The scene in its starting posture.
    pub fn new(scene: &Scene) -> Self {
        let mut sim = Simulator::<R>::new(scene.model.clone(), scene.settings);
        if scene.stands() {
            let settled = scene.stand(SETTLE);
            for lane in 0..R::LANES {
                sim.state.copy_lane(lane, &settled.state, 0);
            }
        } else {
            for lane in 0..R::LANES {
                sim.state.root_position.set_lane(lane, DVec3::Y * 3.0);
                let spin = DVec3::new(0.3, 2.0 + 0.1 * lane as f64, 0.2);
                sim.state.root_velocity.angular.set_lane(lane, spin);
            }
        }
        sim.state_changed();
        let start = sim.state.clone();
        Self { scene: scene.clone(), sim, start, steps: 0, random: RandomStream::new(1, 1) }
    }

    /// What has to happen before the next [`CHUNK`] steps and is no part of a step: targets, disturbances, resets.
    pub fn prepare(&mut self) {
        let period = self.scene.reset_steps();
        if self.steps.is_multiple_of(period) {
            self.sim.state.clone_from(&self.start);
        }
        let time = (self.steps % period) as f64 / self.scene.settings.rate;
        self.scene.aim(&mut self.sim, time);
        match self.scene.kind {
            SceneKind::StandCold => self.disturb(COLD_ANGLE, COLD_SPEED),
            SceneKind::Forward => {
                self.sim.state.clone_from(&self.start);
                self.disturb(0.5, 1.0);
            }
            _ => {}
        }
        self.sim.state_changed();
    }

    /// Turns every joint by a random angle and changes its speed (standard deviations in rad and rad/s).
    fn disturb(&mut self, angle: f64, speed: f64) {
        let random = &mut self.random;
        let mut draw = |size: f64| DVec3::new(random.normal(), random.normal(), random.normal()) * size;
        for joint in self.sim.state.joints.iter_mut().skip(1) {
            for lane in 0..R::LANES {
                let turn = DQuat::from_scaled_axis(draw(angle));
                joint.rotation.set_lane(lane, (joint.rotation.lane(lane) * turn).normalize());
                joint.velocity.set_lane(lane, joint.velocity.lane(lane) + draw(speed));
            }
        }
    }

    /// The part that is timed: [`CHUNK`] steps.
    pub fn advance(&mut self) {
        for _ in 0..CHUNK {
            match self.scene.kind {
                SceneKind::Forward => self.sim.forward_only(),
                _ => step(&mut self.sim, &self.scene.world),
            }
        }
        self.steps += CHUNK as u64;
    }

    /// Points that carried load in the last step, mean over the lanes.
    pub fn loaded_points(&self) -> f64 {
        if self.scene.kind == SceneKind::Forward {
            return 0.0;
        }
        (0..R::LANES).map(|lane| self.sim.loaded_points(lane) as f64).sum::<f64>() / R::LANES as f64
    }

    /// Points that took part in the contact solver's last step in any lane: near enough to touch within the step.
    pub fn solver_points(&self) -> f64 {
        match self.scene.kind {
            SceneKind::Forward => 0.0,
            _ => self.sim.contact.candidates().len() as f64,
        }
    }
}
