//! What the humans of the lab do: motions by the menu, pushes.

use super::LabHuman;
use super::settings::{FootLab, MOTIONS, Motion};
use crate::engine::{AthleteBody, AthleteController, AthleteForces, BalancePose, ControlFinished};
use crate::model::SharedModel;
use crate::ui::PushPlan;
use bevy::prelude::*;

/// Time for a quarter of a foot's circle, s.
const QUARTER: f32 = 0.75;
/// Where the menu's push acts, and for how long, s.
const PUSHED: (&str, f64) = ("chest", 0.4);
/// Who can jump, and how.
const JUMPER: (&str, &str) = ("foot_human", "skills/standing/in_place_jump/in_place_jump.skill.ron");

/// Whether a body has what a pose stands on; feet of two segments have no inside and no outside.
pub(super) fn can_take(pose: BalancePose, model: &SharedModel) -> bool {
    pose.stance(model).is_ok()
}

/// Tells those who can to do what was chosen.
pub(super) fn take_motion(
    time: Res<Time>,
    mut lab: ResMut<FootLab>,
    assets: Res<AssetServer>,
    mut humans: Query<(&mut LabHuman, &mut AthleteController, &AthleteBody)>,
) {
    let lab = lab.bypass_change_detection();
    lab.since += time.delta_secs();
    let Some((_, motion)) = lab.motion.and_then(|k| MOTIONS.get(k).copied()) else { return };
    for (mut human, mut controller, body) in &mut humans {
        let wanted = match motion {
            Motion::Pose(pose) => AthleteController::Balance(pose),
            Motion::Circle(foot) => {
                AthleteController::Balance(BalancePose::Circling { foot, quarter: (lab.since / QUARTER) as usize })
            }
            Motion::Jump if body.model().name == JUMPER.0 && lab.is_level() => {
                AthleteController::skill(assets.load(JUMPER.1))
            }
            Motion::Jump => AthleteController::Balance(BalancePose::Rest),
        };
        if human.told == wanted {
            continue;
        }
        let can = match &wanted {
            AthleteController::Balance(pose) => can_take(*pose, body.model()),
            _ => true,
        };
        if can {
            *controller = wanted.clone();
        }
        human.told = wanted;
    }
}

/// What was clicked on the contact plate goes on until another motion is chosen.
pub(super) fn leave_to_plate(mut lab: ResMut<FootLab>, mut humans: Query<(&mut LabHuman, &AthleteController)>) {
    for (mut human, controller) in &mut humans {
        if matches!(controller, AthleteController::Balance(BalancePose::Feet(_))) && human.told != *controller {
            human.told = controller.clone();
            lab.motion = None;
        }
    }
}

/// Who has jumped stands.
pub(super) fn end_jump(ended: On<ControlFinished>, mut lab: ResMut<FootLab>, humans: Query<&LabHuman>) {
    if humans.get(ended.entity).is_ok_and(|human| matches!(human.told, AthleteController::Skill { .. })) {
        lab.choose(0);
    }
}

/// The push of the menu, the same for all.
pub(super) fn push(mut lab: ResMut<FootLab>, mut humans: Query<(&AthleteBody, &mut AthleteForces), With<LabHuman>>) {
    let Some(azimuth) = lab.bypass_change_detection().push.take() else { return };
    let (link, seconds) = (PUSHED.0.to_owned(), PUSHED.1);
    let plan = PushPlan { link, azimuth, elevation: 0.0, force: f64::from(lab.force), seconds };
    for (body, mut forces) in &mut humans {
        forces.extend(plan.on(body));
    }
}
