//! Ice thrown up where an edge bites.

use crate::engine::{Athlete, AthleteBody, LinkPoses};
use crate::math::RandomStream;
use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::prelude::*;

/// Grains that are kept.
const GRAINS: usize = 220;
/// Force across the blade above which it throws ice, N.
const BITE: f32 = 260.0;
/// Speed below which it does not, m/s.
const SLOWEST: f32 = 0.8;
/// Athletes that throw ice.
const ATHLETES: usize = 6;

/// A grain of ice.
#[derive(Component)]
pub(super) struct Grain {
    velocity: Vec3,
    left: f32,
    life: f32,
}

/// The grain that is used next, and the randomness of them all.
#[derive(Resource)]
struct Spray {
    grains: Vec<Entity>,
    next: usize,
    random: RandomStream,
}

pub(super) struct SprayPlugin;

impl Plugin for SprayPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Startup, make).add_systems(Update, (throw, fly).chain());
    }
}

fn make(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    let mesh = meshes.add(Sphere::new(0.008).mesh().ico(1).unwrap_or_else(|_| Mesh::from(Sphere::new(0.008))));
    let material = materials.add(StandardMaterial { base_color: Color::WHITE, unlit: true, ..default() });
    let grains = (0..GRAINS).map(|_| {
        let grain = Grain { velocity: Vec3::ZERO, left: 0.0, life: 1.0 };
        let look = (Mesh3d(mesh.clone()), MeshMaterial3d(material.clone()), NotShadowCaster, NotShadowReceiver);
        commands.spawn((grain, look, Transform::default(), Visibility::Hidden)).id()
    });
    let grains = grains.collect();
    commands.insert_resource(Spray { grains, next: 0, random: RandomStream::new(7, 1) });
}

fn throw(
    time: Res<Time>,
    mut spray: ResMut<Spray>,
    athletes: Query<(&AthleteBody, &LinkPoses), With<Athlete>>,
    mut grains: Query<(&mut Grain, &mut Transform, &mut Visibility)>,
) {
    if time.delta_secs() <= 0.0 {
        return;
    }
    for (body, poses) in athletes.iter().take(ATHLETES) {
        let speed = body.root_velocity().with_y(0.0).as_vec3();
        if speed.length() < SLOWEST {
            continue;
        }
        for blade in &body.model().blades {
            let Some(pose) = poses.interpolated.get(blade.link) else { continue };
            for end in [blade.toe, blade.heel] {
                let force = body.simulator().contact_force(end, 0).as_vec3();
                // What pushes the skater round is what carves.
                let across = force.with_y(0.0);
                let excess = (across.length() - BITE) / BITE;
                if excess <= 0.0 {
                    continue;
                }
                let place = pose.position + pose.rotation * body.model().contact_points[end].position;
                let wanted = (excess.min(2.0) * 240.0 * time.delta_secs()) as f64;
                let count = wanted as usize + usize::from(spray.random.uniform() < wanted.fract());
                for _ in 0..count.min(12) {
                    let next = spray.next;
                    spray.next = (next + 1) % spray.grains.len();
                    let Ok((mut grain, mut transform, mut shown)) = grains.get_mut(spray.grains[next]) else {
                        continue;
                    };
                    let mut random = || spray.random.uniform() as f32;
                    let out = -across.normalize_or_zero() * (0.5 + 1.3 * random());
                    grain.velocity = out + speed * 0.35 * random() + Vec3::Y * (0.3 + 1.2 * random());
                    grain.life = 0.25 + 0.35 * random();
                    grain.left = grain.life;
                    transform.translation = place.as_vec3().with_y(0.01);
                    *shown = Visibility::Visible;
                }
            }
        }
    }
}

fn fly(time: Res<Time>, mut grains: Query<(&mut Grain, &mut Transform, &mut Visibility)>) {
    let dt = time.delta_secs();
    for (mut grain, mut transform, mut shown) in &mut grains {
        if grain.left <= 0.0 {
            continue;
        }
        grain.left -= dt;
        grain.velocity.y -= 9.81 * dt;
        transform.translation += grain.velocity * dt;
        transform.scale = Vec3::splat((grain.left / grain.life).clamp(0.05, 1.0));
        if grain.left <= 0.0 || transform.translation.y < 0.0 {
            grain.left = 0.0;
            *shown = Visibility::Hidden;
        }
    }
}
