//! The foot lab: the human with feet of sixteen bones beside the one with feet of two segments, balanced on a floor that tilts or on a ball. Motions,
//! ground, slope, lumps under a foot and pushes by the menu; segments and ankles on the contact plate; a pull by the pointer. Nothing but joint torques
//! and contact holds them up: they step where standing no longer helps, and fall when they are asked too much.
//!
//! | file | what it does |
//! | --- | --- |
//! | `settings` | what the lab is set to |
//! | `motions` | poses, circles, the jump, pushes |
//! | `ground` | the floor, the balls, the lumps |

mod ground;
mod motions;
mod settings;

use crate::app::props::Props;
use crate::app::scenes::{DemoScene, scene_root};
use crate::app::stage::Stage;
use crate::contact::World;
use crate::engine::{
    Athlete, AthleteBody, AthleteController, AthleteHistory, AthleteSettings, AthleteSystems, AthleteWorld,
    BalancePose, CharacterAsset,
};
use crate::model::{foot_human, two_segment_human};
use crate::ui::{AthletePanels, Panel};
use bevy::math::DVec2;
use bevy::prelude::*;
use ground::{ASIDE, BALL, Floor, LumpOf};

pub(crate) use settings::{FootLab, HIGHEST, LabGround, Lump, MOTIONS, STEEPEST, STRONGEST};

/// Half of the floor's sides, m.
const FLOOR: f32 = 1.6;

/// A human of the lab.
#[derive(Component)]
pub(crate) struct LabHuman {
    /// What it was told to do.
    told: AthleteController,
    /// Where a lump comes up under it: x and z, m.
    lump: Option<DVec2>,
}

/// The human that the panels show first.
#[derive(Component)]
struct First;

/// What lies on one ground only.
#[derive(Component)]
struct OnGround(LabGround);

pub(crate) struct FootLabPlugin;

impl Plugin for FootLabPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<FootLab>()
            .add_observer(motions::end_jump)
            .add_systems(OnEnter(DemoScene::FootLab), enter)
            .add_systems(OnExit(DemoScene::FootLab), close_plate)
            .add_systems(
                FixedUpdate,
                (motions::leave_to_plate, motions::take_motion, motions::push, ground::keep_places)
                    .chain()
                    .run_if(in_state(DemoScene::FootLab)),
            )
            .add_systems(
                FixedPostUpdate,
                ground::move_ground.in_set(AthleteSystems::ReadWorld).run_if(in_state(DemoScene::FootLab)),
            )
            .add_systems(
                Update,
                (change_ground, ground::place_ground, select_first).chain().run_if(in_state(DemoScene::FootLab)),
            );
    }
}

fn enter(
    mut commands: Commands,
    stage: Res<Stage>,
    mut lab: ResMut<FootLab>,
    mut props: Props,
    mut characters: ResMut<Assets<CharacterAsset>>,
    panels: Option<ResMut<AthletePanels>>,
) {
    *lab = FootLab::default();
    let root = scene_root(&mut commands, DemoScene::FootLab);
    props.hall(&mut commands, root, stage.options.low);
    let floor = props.block(Vec3::new(2.0 * FLOOR, 0.08, 2.0 * FLOOR), Color::srgb(0.78, 0.70, 0.58));
    let lies = OnGround(LabGround::Floor);
    commands.spawn((ChildOf(root), Floor, lies, floor, Transform::from_xyz(0.0, -0.04, 0.0)));
    for x in [-ASIDE, ASIDE] {
        let ball = props.ball(BALL, Color::srgb(0.55, 0.62, 0.72));
        let lies = OnGround(LabGround::Ball);
        commands.spawn((ChildOf(root), lies, ball, Visibility::Hidden, Transform::from_xyz(x, BALL, 0.0)));
    }
    commands.insert_resource(AthleteWorld(World::ground()));
    spawn_humans(&mut commands, &mut props, &mut characters, LabGround::Floor);
    panels.into_iter().for_each(|mut panels| panels.set_open(Panel::ContactPlate, true));
}

/// The plate shows the feet of five segments at first.
fn select_first(panels: Option<ResMut<AthletePanels>>, ready: Query<Entity, (With<First>, Added<AthleteBody>)>) {
    if let Some((mut panels, first)) = panels.zip(ready.iter().next()) {
        panels.selected = Some(first);
    }
}

fn close_plate(panels: Option<ResMut<AthletePanels>>) {
    panels.into_iter().for_each(|mut panels| panels.set_open(Panel::ContactPlate, false));
}

/// Both humans and their lumps; the first of them has feet of five segments.
fn spawn_humans(
    commands: &mut Commands,
    props: &mut Props,
    characters: &mut Assets<CharacterAsset>,
    ground: LabGround,
) {
    let top = if ground == LabGround::Ball { 2.0 * BALL } else { 0.0 };
    let names = ["feet of five segments", "feet of two"];
    for ((model, x), name) in [(foot_human(), -ASIDE), (two_segment_human(), ASIDE)].into_iter().zip(names) {
        let rest = AthleteController::Balance(BalancePose::Rest);
        let human = commands.spawn((
            LabHuman { told: rest.clone(), lump: None },
            Name::new(name),
            DespawnOnExit(DemoScene::FootLab),
            Athlete(characters.add(CharacterAsset { model })),
            rest,
            // Who has fallen gets up.
            AthleteSettings { restart_after: Some(1.5), ..default() },
            AthleteHistory::default(),
            Transform::from_xyz(x, top, 0.0),
        ));
        let human = human.id();
        if x < 0.0 {
            commands.entity(human).insert(First);
        }
        let lump = props.ball(1.0, Color::srgb(0.80, 0.42, 0.30));
        commands.spawn((DespawnOnExit(DemoScene::FootLab), LumpOf(human), lump, Visibility::Hidden));
    }
}

/// Shows the ground that was chosen, and begins anew on it.
fn change_ground(
    mut commands: Commands,
    mut lab: ResMut<FootLab>,
    mut shown: Local<LabGround>,
    humans: Query<Entity, Or<(With<LabHuman>, With<LumpOf>)>>,
    mut grounds: Query<(&OnGround, &mut Visibility)>,
    mut props: Props,
    mut characters: ResMut<Assets<CharacterAsset>>,
) {
    if *shown == lab.ground {
        return;
    }
    *shown = lab.ground;
    *lab = FootLab { ground: *shown, force: lab.force, ..FootLab::default() };
    for (on, mut visibility) in &mut grounds {
        *visibility = if on.0 == *shown { Visibility::Inherited } else { Visibility::Hidden };
    }
    humans.iter().for_each(|human| commands.entity(human).despawn());
    spawn_humans(&mut commands, &mut props, &mut characters, *shown);
}

#[cfg(test)]
mod tests {
    use super::motions::can_take;
    use super::settings::{MOTIONS, Motion};
    use crate::engine::BalancePose;
    use crate::model::{SharedModel, foot_human, two_segment_human};

    #[test]
    fn the_feet_of_five_segments_do_everything_and_those_of_two_what_needs_no_side() {
        let can = |model: &SharedModel| {
            MOTIONS.map(|(_, motion)| match motion {
                Motion::Pose(pose) => can_take(pose, model),
                Motion::Circle(foot) => (0..4).all(|quarter| can_take(BalancePose::Circling { foot, quarter }, model)),
                Motion::Jump => true,
            })
        };
        assert_eq!(can(&foot_human()), [true; 9]);
        assert_eq!(can(&two_segment_human()), [true, true, false, false, true, true, false, false, true]);
    }
}
