//! The field: the human with feet of sixteen bones walks about over rough ground, on its round or where the player points. It was told how rough the ground
//! is, not where.

use crate::app::props::Props;
use crate::app::scenes::{DemoScene, scene_root};
use crate::app::stage::Stage;
use crate::app::thumb::{ThumbStick, over_ground, player_stick};
use crate::contact::{Geometry, HeightField, HeightFieldError, Solid, Surface, World};
use crate::engine::{
    Athlete, AthleteBody, AthleteController, AthleteHistory, AthleteInput, AthleteReset, AthleteSettings, AthleteWorld,
    CharacterAsset,
};
use crate::math::RandomStream;
use crate::model::foot_human;
use crate::ui::{AthletePanels, Panel};
use bevy::asset::RenderAssetUsages;
use bevy::math::DVec3;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use std::sync::Arc;

/// The roughest field, m up and down: half as much again as the walk was learnt on.
pub(crate) const ROUGHEST: f32 = 0.045;
/// What the walk was learnt on, m up and down.
const LEARNT: f32 = 0.03;
/// Nodes along a side, and their distance, m.
const NODES: usize = 97;
const SPACING: f64 = 0.3;
/// Around the middle it is level as far as this, m.
const LEVEL: f64 = 0.8;
/// Speed of a walk, and of one with the shift key, m/s.
const SPEEDS: (f32, f32) = (1.2, 1.8);
/// Speed of the round that it goes when nobody steers, m/s, and how fast that turns, rad/s.
const ROUND: (f32, f32) = (1.0, 0.2);

/// How rough the field is, and how rough it is to be, m up and down.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub(crate) struct Roughness {
    /// To be.
    pub wanted: f32,
    laid: Option<f32>,
}

impl Default for Roughness {
    fn default() -> Self {
        Self { wanted: 0.02, laid: None }
    }
}

/// Who walks.
#[derive(Component, Default)]
struct Walker {
    /// Somebody steers it.
    steered: bool,
}

/// The ground to be seen.
#[derive(Component)]
struct Ground;

pub(crate) struct FieldPlugin;

impl Plugin for FieldPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Roughness>()
            .add_systems(OnEnter(DemoScene::Field), enter)
            .add_systems(OnExit(DemoScene::Field), leave)
            .add_systems(Update, lay.run_if(in_state(DemoScene::Field)))
            .add_systems(FixedUpdate, go.run_if(in_state(DemoScene::Field)));
    }
}

fn enter(
    mut commands: Commands,
    stage: Res<Stage>,
    mut props: Props,
    assets: Res<AssetServer>,
    mut roughness: ResMut<Roughness>,
    mut characters: ResMut<Assets<CharacterAsset>>,
    panels: Option<ResMut<AthletePanels>>,
) {
    let root = scene_root(&mut commands, DemoScene::Field);
    props.hall(&mut commands, root, stage.options.low);
    *roughness = Roughness::default();
    panels.into_iter().for_each(|mut panels| panels.set_open(Panel::ContactPlate, true));
    commands.insert_resource(AthleteWorld(World::ground()));
    commands.spawn((
        Walker::default(),
        DespawnOnExit(DemoScene::Field),
        Athlete(characters.add(CharacterAsset { model: foot_human() })),
        AthleteController::skill(assets.load("skills/walking/walk/walk.skill.ron")),
        AthleteInput::default().at(0.0),
        AthleteSettings { restart_after: Some(1.5), ..default() },
        AthleteHistory::default(),
    ));
}

fn leave(panels: Option<ResMut<AthletePanels>>) {
    panels.into_iter().for_each(|mut panels| panels.set_open(Panel::ContactPlate, false));
}

/// Heights of the nodes, row by row along +X, m: up to twice `roughness`, level in the middle and at the border.
fn heights(roughness: f64) -> Vec<f64> {
    let mut random = RandomStream::new(2018, 13);
    let half = 0.5 * (NODES - 1) as f64 * SPACING;
    let mut height = |k: usize| {
        let (i, j) = (k % NODES, k / NODES);
        let drawn = random.range(0.0, 2.0 * roughness);
        let border = i == 0 || j == 0 || i == NODES - 1 || j == NODES - 1;
        let middle = (i as f64 * SPACING - half).hypot(j as f64 * SPACING - half) < LEVEL;
        if border || middle { 0.0 } else { drawn }
    };
    (0..NODES * NODES).map(&mut height).collect()
}

/// The corner of the field, m.
fn corner() -> DVec3 {
    let half = 0.5 * (NODES - 1) as f64 * SPACING;
    DVec3::new(-half, 0.0, -half)
}

/// The field as the athlete feels it.
fn world(heights: Vec<f64>) -> Result<World, HeightFieldError> {
    let field = HeightField::new(corner(), SPACING, NODES, NODES, heights)?;
    Ok(World { solids: vec![Solid::fixed(Geometry::HeightField(Arc::new(field)), Surface::GROUND)] })
}

/// The field to be seen: the higher the lighter.
fn mesh(heights: &[f64], roughness: f64) -> Mesh {
    let place = |k: usize| {
        let (i, j) = (k % NODES, k / NODES);
        (corner() + DVec3::new(i as f64 * SPACING, heights[k], j as f64 * SPACING)).as_vec3().to_array()
    };
    let shade = |height: &f64| {
        let part = (height / (2.0 * roughness).max(1e-9)) as f32;
        // Linear light.
        [0.09 + 0.16 * part, 0.16 + 0.14 * part, 0.06 + 0.08 * part, 1.0]
    };
    let cell = |k: usize| (k % NODES != NODES - 1).then_some(k as u32);
    let row = NODES as u32;
    let cells = (0..NODES * (NODES - 1)).filter_map(cell);
    let indices = cells.flat_map(|k| [k, k + row, k + 1, k + 1, k + row, k + row + 1]).collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, (0..heights.len()).map(place).collect::<Vec<_>>())
        .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, heights.iter().map(shade).collect::<Vec<_>>())
        .with_inserted_indices(Indices::U32(indices))
        .with_computed_smooth_normals()
}

/// Lays the field as rough as it is to be, and puts the walker into its middle.
fn lay(
    mut commands: Commands,
    mut roughness: ResMut<Roughness>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    old: Query<Entity, With<Ground>>,
    walkers: Query<Entity, With<Walker>>,
) -> Result {
    if roughness.laid == Some(roughness.wanted) {
        return Ok(());
    }
    roughness.laid = Some(roughness.wanted);
    let heights = heights(f64::from(roughness.wanted));
    let material = StandardMaterial { perceptual_roughness: 0.95, reflectance: 0.05, ..default() };
    old.iter().for_each(|ground| commands.entity(ground).despawn());
    commands.spawn((
        Ground,
        DespawnOnExit(DemoScene::Field),
        Mesh3d(meshes.add(mesh(&heights, f64::from(roughness.wanted)))),
        MeshMaterial3d(materials.add(material)),
    ));
    commands.insert_resource(AthleteWorld(world(heights)?));
    walkers.iter().for_each(|walker| commands.trigger(AthleteReset::at(walker, Transform::default())));
    Ok(())
}

/// Arrow keys, the left stick or the one for thumbs; until the first touch it goes its round.
fn go(
    keys: Res<ButtonInput<KeyCode>>,
    gamepads: Query<&Gamepad>,
    thumb: Res<ThumbStick>,
    roughness: Res<Roughness>,
    cameras: Query<&GlobalTransform, With<Camera3d>>,
    mut walkers: Query<(&AthleteBody, &mut Walker, &mut AthleteInput)>,
) {
    let stick = player_stick(&keys, &gamepads, &thumb).clamp_length_max(1.0);
    let wished = over_ground(cameras.iter().next().unwrap_or(&GlobalTransform::IDENTITY), stick);
    let fastest = if keys.pressed(KeyCode::ShiftLeft) { SPEEDS.1 } else { SPEEDS.0 };
    for (body, mut walker, mut input) in &mut walkers {
        walker.steered |= stick != Vec2::ZERO;
        let (direction, speed) = if walker.steered {
            (wished, fastest * stick.length())
        } else {
            (Quat::from_rotation_y(ROUND.1 * body.time() as f32) * Vec3::NEG_Z, ROUND.0)
        };
        let told = f64::from(roughness.wanted.min(LEARNT));
        let wanted = AthleteInput::towards(direction).at(speed).with("roughness", told);
        if *input != wanted {
            *input = wanted;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Terrain;
    use crate::math::Vec3 as Lanes;

    /// What is seen is what is felt at the nodes, level in the middle and beyond the border.
    #[test]
    fn the_mesh_lies_where_the_ground_is_felt() {
        let roughness = 0.02;
        let heights = heights(roughness);
        let ground = world(heights.clone()).expect("a field");
        let mesh = mesh(&heights, roughness);
        let places = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|p| p.as_float3()).expect("places");
        assert_eq!(places.len(), NODES * NODES);
        let felt = |x: f64, z: f64| ground.height(Lanes::<f64>::splat(DVec3::new(x, 0.5, z))).height;
        for place in places.iter().step_by(31) {
            let height = felt(f64::from(place[0]), f64::from(place[2]));
            assert!((height - f64::from(place[1])).abs() < 1e-5, "{place:?}, felt {height}");
        }
        assert!(heights.iter().all(|h| (0.0..2.0 * roughness).contains(h)));
        assert!(heights.iter().copied().fold(0.0, f64::max) > 1.9 * roughness);
        for (x, z) in [(0.0, 0.0), (0.3, -0.3), (40.0, 3.0)] {
            assert_eq!(felt(x, z), 0.0);
        }
    }
}
