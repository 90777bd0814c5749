//! The course: the runner on a hall's floor with numbered obstacles. It sees them and clears them, on its round or where the player points; the player
//! moves, raises, adds and removes them while it runs.
//!
//! | file | what it does |
//! | --- | --- |
//! | `site` | the pieces as data |
//! | `build` | the pointer, the keys, what is seen |
//! | `race` | eight runners side by side |

mod build;
mod race;
mod site;

use crate::app::props::Props;
use crate::app::scenes::{DemoScene, scene_root};
use crate::app::stage::Stage;
use crate::app::thumb::{ThumbStick, over_ground, player_stick};
use crate::contact::World;
use crate::engine::{
    Athlete, AthleteController, AthleteHistory, AthleteInput, AthleteSettings, AthleteSystems, AthleteWorld,
    CharacterAsset,
};
use crate::model::runner;
use bevy::prelude::*;
use build::CourseRoot;

pub(crate) use build::{build_keys, holds_no_piece, take_piece};
pub(crate) use race::Race;
pub(crate) use site::{DEPTHS, HEIGHTS, Piece, PieceKind, Site, WIDTHS};

/// Where the obstacles stand, m along -Z, and their heights, m.
const OBSTACLES: [(f32, f32); 3] = [(10.4, 0.30), (20.56, 0.35), (30.84, 0.75)];
/// Depth and width of an obstacle, m.
const SIZE: Vec2 = Vec2::new(0.35, 1.4);
/// Length of the way, m.
const WAY: f32 = 42.4;
/// Where it runs when nobody steers, m: to the right and along -Z, and at what speed, m/s.
const ROUND: [(f32, f32, f32); 7] = [
    (0.0, 40.0, 3.2),
    (-2.5, 43.0, 2.2),
    (-5.0, 40.0, 2.2),
    (-6.0, 20.0, 3.2),
    (-5.0, -3.0, 2.2),
    (-2.5, -6.0, 2.2),
    (0.0, -3.0, 2.2),
];
/// What clears obstacles, from the folder of the running skills.
const CLEARS: [&str; 7] = ["jump", "hop_down", "hurdle", "gap", "leap", "step_vault", "drop_roll"];
/// Distance at which a place counts as reached, m.
const REACHED: f32 = 1.5;
/// Fastest run that a player can ask for, m/s.
const FASTEST: f32 = 4.2;

/// A piece that is seen.
#[derive(Component)]
struct PieceOf {
    index: usize,
    kind: PieceKind,
}

/// The runner, and where it is on its round.
#[derive(Component, Default)]
pub(crate) struct Runner {
    next: usize,
    /// Somebody steers it.
    steered: bool,
}

pub(crate) struct CoursePlugin;

impl Plugin for CoursePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Site>()
            .init_resource::<Race>()
            .add_observer(race::fell)
            .add_observer(race::again)
            .add_systems(OnEnter(DemoScene::Course), enter)
            .add_systems(OnExit(DemoScene::Course), |mut site: ResMut<Site>| site.lay(Vec::new()))
            .add_systems(
                FixedUpdate,
                (change_runners, go, race::run, build::bring_back).chain().run_if(in_state(DemoScene::Course)),
            )
            .add_systems(Update, (build::drag_piece, build::lay_seen).chain().run_if(in_state(DemoScene::Course)))
            .add_systems(
                Update,
                build::draw_handles.run_if(in_state(DemoScene::Course).and_then(resource_exists::<GizmoConfigStore>)),
            )
            .add_systems(
                FixedPostUpdate,
                build::lay_world.in_set(AthleteSystems::ReadWorld).run_if(in_state(DemoScene::Course)),
            );
    }
}

/// What stands there at first.
pub(crate) fn first_pieces() -> Vec<Piece> {
    let piece = |(ahead, height)| Piece { height, depth: SIZE.x, width: SIZE.y, ..Piece::new(PieceKind::Box, ahead) };
    OBSTACLES.map(piece).to_vec()
}

fn enter(
    mut commands: Commands,
    stage: Res<Stage>,
    mut props: Props,
    (mut site, mut race): (ResMut<Site>, ResMut<Race>),
    assets: Res<AssetServer>,
    mut characters: ResMut<Assets<CharacterAsset>>,
) {
    let root = scene_root(&mut commands, DemoScene::Course);
    commands.entity(root).insert(CourseRoot);
    props.hall(&mut commands, root, stage.options.low);
    race.stop();
    race.on = stage.options.race;
    let runner = characters.add(CharacterAsset { model: runner() });
    begin(&mut commands, &assets, runner, &mut site, race.on);
    let lane = props.block(Vec3::new(SIZE.y + 4.0, 0.01, WAY + 4.0), Color::srgb(0.72, 0.36, 0.28));
    commands.spawn((ChildOf(root), lane, Transform::from_xyz(0.0, -0.004, -0.5 * WAY)));
    commands.insert_resource(AthleteWorld(site.world().unwrap_or_else(|_| World::ground())));
}

/// The first pieces and who runs over them.
fn begin(
    commands: &mut Commands,
    assets: &AssetServer,
    character: Handle<CharacterAsset>,
    site: &mut Site,
    race: bool,
) {
    site.race_width = race.then_some(race::WIDTH);
    site.lay(first_pieces());
    spawn_runners(commands, assets, character, race);
}

/// One that goes its round, or the racers.
fn spawn_runners(commands: &mut Commands, assets: &AssetServer, character: Handle<CharacterAsset>, race: bool) {
    let settings = AthleteSettings { restart_after: (!race).then_some(1.5), ..default() };
    for lane in 0..if race { race::LANES } else { 1 } {
        let mut athlete = commands.spawn((
            Runner::default(),
            DespawnOnExit(DemoScene::Course),
            Athlete(character.clone()),
            AthleteController::course(
                assets.load("skills/running/run/run.skill.ron"),
                CLEARS.map(|name| assets.load(format!("skills/running/{name}/{name}.skill.ron"))),
            ),
            AthleteInput::default().at(0.0),
            settings.clone(),
            AthleteHistory::default(),
        ));
        if race {
            athlete.insert(race::racer(lane));
        }
    }
}

/// Racers in place of the one runner, or the other way round, where the menu says so.
fn change_runners(
    mut commands: Commands,
    mut race: ResMut<Race>,
    mut site: ResMut<Site>,
    assets: Res<AssetServer>,
    mut characters: ResMut<Assets<CharacterAsset>>,
    runners: Query<Entity, With<Runner>>,
    racers: Query<(), With<race::Racer>>,
) {
    if race.on != racers.is_empty() {
        return;
    }
    for runner in &runners {
        commands.entity(runner).despawn();
    }
    race.begin();
    let runner = characters.add(CharacterAsset { model: runner() });
    begin(&mut commands, &assets, runner, &mut site, race.on);
}

/// Arrow keys, the left stick or the one for thumbs; until the first touch it runs its round.
fn go(
    keys: Res<ButtonInput<KeyCode>>,
    gamepads: Query<&Gamepad>,
    thumb: Res<ThumbStick>,
    cameras: Query<&GlobalTransform, With<Camera3d>>,
    mut runners: Query<(&Transform, &mut Runner, &mut AthleteInput), Without<race::Racer>>,
) {
    let stick = player_stick(&keys, &gamepads, &thumb).clamp_length_max(1.0);
    let wished = over_ground(cameras.iter().next().unwrap_or(&GlobalTransform::IDENTITY), stick);
    for (place, mut runner, mut input) in &mut runners {
        runner.steered |= stick != Vec2::ZERO;
        let (direction, speed) = if runner.steered {
            (wished, FASTEST * stick.length())
        } else {
            let (x, z, speed) = ROUND[runner.next % ROUND.len()];
            let way = (Vec3::new(x, 0.0, -z) - place.translation).with_y(0.0);
            if way.length() < REACHED {
                runner.next = (runner.next + 1) % ROUND.len();
            }
            (way, speed)
        };
        let wanted = AthleteInput::towards(direction).at(speed);
        if *input != wanted {
            *input = wanted;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The round leads straight over every obstacle, with room to land, and comes near none on the way back.
    #[test]
    fn the_round_goes_over_every_obstacle_once() {
        let ends = |k: usize| (ROUND[(k + ROUND.len() - 1) % ROUND.len()], ROUND[k]);
        let ((x, from, _), (to_x, to, _)) = ends(0);
        assert!(x == 0.0 && to_x == 0.0, "straight ahead in the middle of the lane");
        for (at, _) in OBSTACLES {
            assert!(from + 8.0 < at && at + 6.0 < to, "the obstacle at {at}");
        }
        for k in 1..ROUND.len() {
            let ((x, z, _), (to_x, to_z, _)) = ends(k);
            for s in (0..=100).map(|k| k as f32 / 100.0) {
                let (x, z) = (x + (to_x - x) * s, z + (to_z - z) * s);
                for (at, _) in OBSTACLES {
                    let clear = (x.abs() - 0.5 * SIZE.y).max((z - at).abs() - 0.5 * SIZE.x);
                    assert!(clear > 1.0, "{x}, {z} is {clear} m from the obstacle at {at}");
                }
            }
        }
    }
}
