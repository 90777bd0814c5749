//! One skill, over and over if it repeats.

use crate::skill::SkillGraph;
use crate::skill::director::{BodyView, Choice, DirectorInput};
use glam::DVec3;

/// Plays the first skill of its graph, as fast as is wished and turning as is wished; a gait goes in the wished direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Single;

/// How fast a gait turns for each sine of the angle that is left to the wished direction, and at most, rad/s.
const TOWARDS: (f64, f64) = (2.0, 0.7);

impl Single {
    pub(super) fn next(&self, body: &BodyView, graph: &SkillGraph, input: &DirectorInput) -> Choice {
        let motion = &graph.skills()[body.skill].skill.motion;
        let speed = input.speed.unwrap_or(motion.mean_speed());
        Choice { enter: None, speed: Some(speed), turn: self.turn(body, graph, input, speed) }
    }
    /// The turn that is wished at a speed (m/s), rad/s, positive to the left.
    pub(super) fn turn(&self, body: &BodyView, graph: &SkillGraph, input: &DirectorInput, speed: f64) -> f64 {
        let gait = !graph.skills()[body.skill].skill.motion.levels().is_empty();
        if gait { input.turn + towards(body, input.direction, speed < SLOW) } else { input.turn }
    }
}

/// Who is slower than this (m/s), and faces the wished direction to within this sine, does not turn: steps on the spot would never end.
const SLOW: f64 = 0.3;
const FACES: f64 = 0.2;

/// The turn towards a direction (world, its level part counts), rad/s; zero for none.
fn towards(body: &BodyView, direction: DVec3, slow: bool) -> f64 {
    let level = |v: DVec3| DVec3::new(v.x, 0.0, v.z).normalize_or_zero();
    let faces = level(body.way);
    let wanted = level(direction);
    let (sine, cosine) = (faces.cross(wanted).y, faces.dot(wanted));
    if slow && cosine > 0.0 && sine.abs() < FACES {
        return 0.0;
    }
    // Half way round or more it turns as fast as it can, to one side.
    let sine = if cosine < 0.0 { 1f64.copysign(sine) } else { sine };
    (TOWARDS.0 * sine).clamp(-TOWARDS.1, TOWARDS.1)
}
