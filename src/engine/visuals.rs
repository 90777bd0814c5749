//! Meshes for the shapes of every link, placed from the interpolated poses.

use crate::engine::gizmos::{AthleteGizmos, draw_blades};
use crate::engine::look::Part;
use crate::engine::poses::to_transform;
use crate::engine::rounded_box::rounded_box;
use crate::engine::{AthleteBody, AthleteGhost, AthleteLook, LinkId, LinkPoses};
use crate::model::{CharacterModel, LinkTransform, Shape, SharedModel};
use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use bevy::transform::TransformSystems;
use std::sync::Arc;

/// Half extents below this are blades, m.
const BLADE_HALF_WIDTH: f64 = 0.006;
/// Roundness of a box's edges as a part of its smallest half extent.
const ROUNDNESS: f64 = 0.55;

/// Draws athletes: one child entity for each shape of each link.
///
/// Add it where there is a renderer with meshes and standard materials; it does nothing without.
#[derive(Debug, Default)]
pub struct AthleteRenderPlugin;

impl Plugin for AthleteRenderPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<AthleteLook>()
            .register_type::<AthleteGhost>()
            .register_type::<LinkVisual>()
            .register_type::<BladeVisual>()
            .register_type::<AthleteGizmos>()
            .add_systems(
                PostUpdate,
                draw_blades
                    .after(TransformSystems::Propagate)
                    .run_if(resource_exists::<bevy::gizmos::config::GizmoConfigStore>),
            )
            .init_resource::<VisualCache>()
            .add_systems(
                PostUpdate,
                (build_visuals, place_visuals)
                    .chain()
                    .before(TransformSystems::Propagate)
                    .run_if(resource_exists::<Assets<Mesh>>.and_then(resource_exists::<Assets<StandardMaterial>>)),
            );
    }
}

/// A drawn shape: a child of the athlete. Yours to hide or to give another material.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(Component)]
pub struct LinkVisual {
    /// The link.
    pub link: LinkId,
    /// Place of the mesh in the link's frame.
    pub local: Transform,
    /// Whether it belongs to the ghost of the reference.
    pub ghost: bool,
}

/// Marks a [`LinkVisual`] that is a blade: it stays when a skin hides the shapes of its link.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component, Default)]
pub struct BladeVisual;

/// One shape, ready to be drawn.
#[derive(Clone)]
struct ShapeVisual {
    link: usize,
    part: Part,
    mesh: Handle<Mesh>,
    local: Transform,
}

/// The materials of one look: left, right, middle, steel.
type LookMaterials = [Handle<StandardMaterial>; 4];

/// Meshes by model and materials by look, shared by all athletes that are alike.
#[derive(Resource, Default)]
struct VisualCache {
    models: Vec<(SharedModel, Vec<ShapeVisual>)>,
    looks: Vec<(AthleteLook, LookMaterials)>,
}

impl VisualCache {
    fn shapes(&mut self, model: &SharedModel, meshes: &mut Assets<Mesh>) -> &[ShapeVisual] {
        let found = self.models.iter().position(|(m, _)| Arc::ptr_eq(m, model));
        let index = found.unwrap_or_else(|| {
            self.models.push((model.clone(), shape_visuals(model, meshes)));
            self.models.len() - 1
        });
        &self.models[index].1
    }

    fn materials(&mut self, look: &AthleteLook, materials: &mut Assets<StandardMaterial>) -> LookMaterials {
        if let Some((_, found)) = self.looks.iter().find(|(l, _)| l == look) {
            return found.clone();
        }
        let parts = [Part::Left, Part::Right, Part::Middle, Part::Steel];
        let handles = parts.map(|part| materials.add(part.material(look)));
        self.looks.push((look.clone(), handles.clone()));
        handles
    }
}

/// All shapes of a model with their meshes.
fn shape_visuals(model: &CharacterModel, meshes: &mut Assets<Mesh>) -> Vec<ShapeVisual> {
    let mut visuals = Vec::new();
    for (link, description) in model.links.iter().enumerate() {
        for shape in &description.shapes {
            let (mesh, position, rotation) = shape_mesh(shape);
            let thin =
                matches!(shape, Shape::Box { half_extents, .. } if half_extents.min_element() < BLADE_HALF_WIDTH);
            let has_blade = model.blades.iter().any(|b| b.link == link);
            visuals.push(ShapeVisual {
                link,
                part: if thin && has_blade { Part::Steel } else { Part::of_link(&description.name) },
                mesh: meshes.add(mesh),
                local: to_transform(&LinkTransform { position, rotation }),
            });
        }
    }
    visuals
}

/// Mesh, centre and rotation of a shape, link frame.
pub(crate) fn shape_mesh(shape: &Shape) -> (Mesh, DVec3, DQuat) {
    match *shape {
        Shape::Box { center, half_extents, rotation } => {
            let radius = half_extents.min_element() * ROUNDNESS;
            (rounded_box(half_extents.as_vec3(), radius as f32), center, rotation)
        }
        Shape::Capsule { a, b, radius } => {
            let axis = b - a;
            let length = axis.length();
            let rotation =
                if length > 1e-9 { DQuat::from_rotation_arc(DVec3::Y, axis / length) } else { DQuat::IDENTITY };
            let mesh = Mesh::from(Capsule3d::new(radius as f32, length as f32));
            (mesh, (a + b) * 0.5, rotation)
        }
        Shape::Sphere { center, radius } => (Mesh::from(Sphere::new(radius as f32)), center, DQuat::IDENTITY),
    }
}

/// Children for athletes whose body has just arrived.
fn build_visuals(
    mut commands: Commands,
    mut cache: ResMut<VisualCache>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    athletes: Query<(Entity, &AthleteBody, &AthleteLook, Option<&AthleteGhost>), Added<AthleteBody>>,
) {
    for (entity, body, look, ghost) in &athletes {
        let looks = cache.materials(look, &mut materials);
        let ghost = ghost.map(|g| materials.add(g.material()));
        for shape in cache.shapes(body.model(), &mut meshes) {
            let material = match shape.part {
                Part::Left => &looks[0],
                Part::Right => &looks[1],
                Part::Middle => &looks[2],
                Part::Steel => &looks[3],
            };
            let visual = LinkVisual { link: LinkId::at(shape.link), local: shape.local, ghost: false };
            let mut child = commands.spawn((
                ChildOf(entity),
                visual.clone(),
                Mesh3d(shape.mesh.clone()),
                MeshMaterial3d(material.clone()),
            ));
            if !look.shadows {
                child.insert(NotShadowCaster);
            }
            if shape.part == Part::Steel {
                child.insert(BladeVisual);
            }
            if let Some(material) = &ghost {
                commands.spawn((
                    ChildOf(entity),
                    LinkVisual { ghost: true, ..visual },
                    Mesh3d(shape.mesh.clone()),
                    MeshMaterial3d(material.clone()),
                    NotShadowCaster,
                    NotShadowReceiver,
                ));
            }
        }
    }
}

/// Moves every child to its link, relative to the athlete's transform (the root link's).
fn place_visuals(
    athletes: Query<(&AthleteBody, &LinkPoses, Option<&AthleteGhost>, &Children)>,
    mut visuals: Query<(&LinkVisual, &mut Transform, &mut Visibility)>,
    mut reference: Local<Vec<LinkTransform>>,
) {
    for (body, poses, ghost, children) in &athletes {
        let Some(root) = poses.interpolated.first() else { continue };
        let back = root.rotation.inverse();
        reference.clear();
        let mut offset = DVec3::ZERO;
        if let Some(ghost) = ghost {
            body.reference_links(poses.interpolated_time, &mut reference);
            offset = body.placement().heading * ghost.offset.as_dvec3();
        }
        for &child in children {
            let Ok((visual, mut transform, mut visibility)) = visuals.get_mut(child) else { continue };
            let links = if visual.ghost { &*reference } else { &poses.interpolated };
            let Some(link) = links.get(visual.link.index()) else {
                visibility.set_if_neq(Visibility::Hidden);
                continue;
            };
            let offset = if visual.ghost { offset } else { DVec3::ZERO };
            let relative = LinkTransform {
                position: back * (link.position + offset - root.position),
                rotation: (back * link.rotation).normalize(),
            };
            *transform = to_transform(&relative) * visual.local;
            if visual.ghost {
                visibility.set_if_neq(Visibility::Inherited);
            }
        }
    }
}
