//! What the examples share: ice to be seen and to stand on, light, a camera that follows, and the keys for slow motion and a
//! new start.

use bevy::prelude::*;
use bevy_athlete::engine::*;

/// A rink, and a camera that looks at the athlete from so far away, m.
pub struct Rink {
    pub camera: Vec3,
}

#[derive(Resource)]
struct LooksFrom(Vec3);

impl Plugin for Rink {
    fn build(&self, app: &mut App) {
        app.insert_resource(ClearColor(Color::srgb(0.55, 0.68, 0.80)))
            .insert_resource(LooksFrom(self.camera))
            // What athletes stand on; what is seen of it comes below.
            .insert_resource(AthleteWorld::ice())
            .add_systems(Startup, rink)
            .add_systems(Update, (keys, follow));
    }
}

fn rink(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(200.0, 200.0))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.82, 0.91, 0.96),
            perceptual_roughness: 0.25,
            ..default()
        })),
    ));
    commands.spawn((
        DirectionalLight { shadow_maps_enabled: true, ..default() },
        Transform::from_xyz(-4.0, 9.0, 5.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((Camera3d::default(), Transform::default()));
}

/// Space is slow motion, R starts again.
fn keys(
    keys: Res<ButtonInput<KeyCode>>,
    mut commands: Commands,
    athletes: Query<Entity, With<Athlete>>,
    mut playback: ResMut<PlaybackSpeed>,
) {
    if keys.just_pressed(KeyCode::Space) {
        playback.speed = if playback.speed < 1.0 { 1.0 } else { 0.2 };
    }
    if keys.just_pressed(KeyCode::KeyR) {
        athletes.iter().for_each(|athlete| commands.trigger(AthleteReset::new(athlete)));
    }
}

fn follow(
    from: Res<LooksFrom>,
    athlete: Single<&Transform, With<Athlete>>,
    mut camera: Single<&mut Transform, (With<Camera>, Without<Athlete>)>,
) {
    let target = athlete.translation.with_y(0.85);
    **camera = Transform::from_translation(target + from.0).looking_at(target, Vec3::Y);
}
