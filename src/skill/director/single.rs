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
        let gait = !motion.levels().is_empty();
        let turn = if gait { input.turn + towards(body, input.direction) } else { input.turn };
        Choice { enter: None, speed: Some(input.speed.unwrap_or(motion.mean_speed())), turn }
    }
}

/// The turn towards a direction (world, its level part counts), rad/s; zero for none.
fn towards(body: &BodyView, direction: DVec3) -> f64 {
    let level = |v: DVec3| DVec3::new(v.x, 0.0, v.z).normalize_or_zero();
    let faces = level(body.simulator.state.root_rotation.lane(0) * DVec3::NEG_Z);
    let wanted = level(direction);
    let (sine, cosine) = (faces.cross(wanted).y, faces.dot(wanted));
    // Half way round or more it turns as fast as it can, to one side.
    let sine = if cosine < 0.0 { 1f64.copysign(sine) } else { sine };
    (TOWARDS.0 * sine).clamp(-TOWARDS.1, TOWARDS.1)
}
