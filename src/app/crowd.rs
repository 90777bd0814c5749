//! More skaters on the same ice, each stroking by its policy: what does a machine hold?

use crate::engine::{Athlete, CharacterAsset, SkillController};
use bevy::prelude::*;

/// Distance between neighbours, m.
const APART: f32 = 2.5;
/// What they perform.
const SKILL: &str = "skills/skating/stroking/stroking.skill.ron";

/// Adds `count` skaters in a square around `middle`, without the one that is there already.
pub(super) fn spawn_crowd(
    commands: &mut Commands,
    assets: &AssetServer,
    skater: &Handle<CharacterAsset>,
    middle: Vec3,
    count: u32,
) {
    let skill = assets.load(SKILL);
    let side = (count as f32).sqrt().ceil() as u32;
    for k in 0..count {
        let place = Vec2::new((k % side.max(1)) as f32, (k / side.max(1)) as f32) - Vec2::splat(side as f32 * 0.5);
        let place = middle + Vec3::new(place.x + 0.5, 0.0, place.y) * APART;
        commands.spawn((
            Athlete(skater.clone()),
            SkillController::new(skill.clone()),
            Transform::from_translation(place),
        ));
    }
}
