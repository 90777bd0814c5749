//! Skinned meshes that follow the simulated links.

use crate::asset::bone_map::{BoneMap, BoneMapError};
use crate::engine::{AthleteBody, FileAsset, FileLoader, LinkPoses, LoadError};
use crate::model::{BoundBone, CharacterModel, LinkTransform, RestBone, bind_bones};
use bevy::app::AnimationSystems;
use bevy::math::{Affine3A, DMat4, DQuat, DVec3};
use bevy::prelude::*;
use bevy::transform::TransformSystems;
use std::sync::Arc;

/// A bone map, read from `*.bones.ron`.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct BoneMapAsset {
    /// The map.
    pub map: Arc<BoneMap>,
}

impl From<BoneMap> for BoneMapAsset {
    fn from(map: BoneMap) -> Self {
        Self { map: Arc::new(map) }
    }
}

impl FileAsset for BoneMapAsset {
    const ENDING: &'static str = "bones.ron";

    fn parse(file: &str, bytes: &[u8]) -> Result<Self, LoadError> {
        Ok(BoneMap::parse(file, bytes)?.into())
    }
}

/// Dresses an athlete: the bones of the scene that is its child follow its links.
///
/// Spawn the scene (of a glTF file, say) as a child of the athlete. The child's `Transform` is where the mesh stands in the
/// character's frame at rest: feet on the ground at the origin, facing -Z; a model that faces +Z is turned by half a turn
/// about Y. Once a bone of the map is found among the descendants, by [`Name`], all of them are bound: [`DressedIn`]
/// is added, or [`SkinRefused`] with the reason. From then on the `Transform`s of mapped bones are written in `PostUpdate`, after
/// animation; those of all other descendants are yours.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(Component)]
pub struct AthleteSkin {
    /// The bone map.
    pub map: Handle<BoneMapAsset>,
    /// Whether the plain shapes of links that a bone follows are hidden. Blades are always drawn.
    pub hide_shapes: bool,
}

impl AthleteSkin {
    /// A skin that hides the plain shapes under it.
    pub fn new(map: Handle<BoneMapAsset>) -> Self {
        Self { map, hide_shapes: true }
    }
}

/// The skin could not be bound; the athlete is simulated all the same. Remove this component to try again.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(opaque)]
#[reflect(Component)]
pub struct SkinRefused(pub BoneMapError);

/// An entity between the athlete and its bones, or a bone.
#[derive(Clone, Debug)]
struct SkinNode {
    entity: Entity,
    /// Index of its parent among the nodes; `None` for a child of the athlete.
    parent: Option<usize>,
    bone: Option<BoundBone>,
}

/// The bound bones of an athlete's skin.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(opaque)]
#[reflect(Component)]
pub struct DressedIn {
    /// Parents first.
    nodes: Vec<SkinNode>,
    /// Node to root link, by node.
    places: Vec<Affine3A>,
}

impl DressedIn {
    /// The bones that follow links: entity of the bone, and how it follows.
    pub fn bones(&self) -> impl Iterator<Item = (Entity, &BoundBone)> {
        self.nodes.iter().filter_map(|node| Some((node.entity, node.bone.as_ref()?)))
    }
}

/// Bone maps and the skins of athletes.
#[derive(Debug, Default)]
pub struct AthleteSkinPlugin;

impl Plugin for AthleteSkinPlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<BoneMapAsset>()
            .init_asset_loader::<FileLoader<BoneMapAsset>>()
            .register_type::<AthleteSkin>()
            .register_type::<DressedIn>()
            .register_type::<SkinRefused>()
            .add_systems(
                PostUpdate,
                (dress, pose_bones).chain().after(AnimationSystems).before(TransformSystems::Propagate),
            );
        #[cfg(feature = "render")]
        app.add_systems(PostUpdate, hide_shapes.after(pose_bones));
    }
}

/// Athletes that wait for their skin.
type Undressed = (Without<DressedIn>, Without<SkinRefused>);

/// Binds the bones of scenes that have arrived.
fn dress(
    mut commands: Commands,
    maps: Res<Assets<BoneMapAsset>>,
    athletes: Query<(Entity, &AthleteSkin, &AthleteBody, &Children), Undressed>,
    mut scene: Query<(&mut Transform, Option<&Name>, Option<&Children>), Without<AthleteBody>>,
) {
    for (athlete, skin, body, children) in &athletes {
        let Some(BoneMapAsset { map }) = maps.get(&skin.map) else { continue };
        let (nodes, skeleton) = descendants(children, &scene);
        let known = |bone: &RestBone| map.bones.iter().any(|(name, _)| *name == bone.name);
        if !skeleton.iter().any(known) {
            continue;
        }
        match bind_bones(map, body.model(), &skeleton) {
            Ok(bound) => {
                let nodes = needed(nodes, &bound);
                stand_on_root(&nodes, body.model(), &mut scene);
                let places = vec![Affine3A::IDENTITY; nodes.len()];
                commands.entity(athlete).insert(DressedIn { nodes, places });
            }
            Err(error) => {
                error!("the skin of athlete {athlete} is refused: {error}");
                commands.entity(athlete).insert(SkinRefused(error));
            }
        }
    }
}

/// All descendants, parents first, and their rest poses in the character's frame. What has no name cannot be a bone.
fn descendants(
    children: &Children,
    scene: &Query<(&mut Transform, Option<&Name>, Option<&Children>), Without<AthleteBody>>,
) -> (Vec<SkinNode>, Vec<RestBone>) {
    let (mut nodes, mut skeleton): (Vec<SkinNode>, Vec<RestBone>) = (Vec::new(), Vec::new());
    let mut waiting: Vec<(Entity, Option<usize>)> = children.iter().map(|child| (child, None)).rev().collect();
    while let Some((entity, parent)) = waiting.pop() {
        let Ok((transform, name, its_children)) = scene.get(entity) else { continue };
        let above = parent.map_or(DMat4::IDENTITY, |p: usize| skeleton[p].to_character);
        let own = DMat4::from_scale_rotation_translation(
            transform.scale.as_dvec3(),
            transform.rotation.as_dquat(),
            transform.translation.as_dvec3(),
        );
        let name = name.map(|n| n.as_str().to_owned()).unwrap_or_default();
        skeleton.push(RestBone { name, to_character: above * own });
        nodes.push(SkinNode { entity, parent, bone: None });
        let at = nodes.len() - 1;
        waiting.extend(its_children.into_iter().flat_map(|c| c.iter()).map(|child| (child, Some(at))).rev());
    }
    (nodes, skeleton)
}

/// The bound bones and what lies between them and the athlete.
fn needed(mut nodes: Vec<SkinNode>, bound: &[BoundBone]) -> Vec<SkinNode> {
    let mut wanted = vec![false; nodes.len()];
    for bone in bound {
        nodes[bone.bone].bone = Some(*bone);
        let mut node = Some(bone.bone);
        while let Some(at) = node.filter(|&at| !wanted[at]) {
            wanted[at] = true;
            node = nodes[at].parent;
        }
    }
    // Parents come first, so their new index is known.
    let mut index = vec![None; nodes.len()];
    let mut kept = Vec::new();
    for (at, node) in nodes.into_iter().enumerate().filter(|(at, _)| wanted[*at]) {
        index[at] = Some(kept.len());
        kept.push(SkinNode { parent: node.parent.and_then(|p| index[p]), ..node });
    }
    kept
}

/// Children of the athlete ride on its root link: at rest they are where they were in the character's frame.
fn stand_on_root(
    nodes: &[SkinNode],
    model: &CharacterModel,
    scene: &mut Query<(&mut Transform, Option<&Name>, Option<&Children>), Without<AthleteBody>>,
) {
    let down = Vec3::Y * model.rest_root_height() as f32;
    for node in nodes.iter().filter(|node| node.parent.is_none() && node.bone.is_none()) {
        if let Ok((mut transform, ..)) = scene.get_mut(node.entity) {
            transform.translation -= down;
        }
    }
}

/// Puts every mapped bone on its link.
fn pose_bones(
    mut commands: Commands,
    mut athletes: Query<(Entity, &mut DressedIn, &LinkPoses)>,
    mut transforms: Query<&mut Transform, Without<AthleteBody>>,
) {
    for (athlete, mut dress, poses) in &mut athletes {
        let Some(root) = poses.interpolated.first() else { continue };
        let back = root.rotation.inverse();
        let DressedIn { nodes, places } = &mut *dress;
        for (at, node) in nodes.iter().enumerate() {
            let above = node.parent.map_or(Affine3A::IDENTITY, |parent| places[parent]);
            let Ok(mut transform) = transforms.get_mut(node.entity) else {
                // The scene is gone; the next one is bound anew.
                commands.entity(athlete).remove::<DressedIn>();
                break;
            };
            let link = node.bone.and_then(|bone| Some((bone, poses.interpolated.get(bone.link)?)));
            let Some((bone, link)) = link else {
                places[at] = above * transform.compute_affine();
                continue;
            };
            let place = bone_place(&bone, link);
            let relative = Affine3A::from_scale_rotation_translation(
                bone.scale.as_vec3(),
                ((back * place.rotation).normalize()).as_quat(),
                (back * (place.position - root.position)).as_vec3(),
            );
            *transform = Transform::from_matrix(Mat4::from(above.inverse() * relative));
            places[at] = relative;
        }
    }
}

/// Where a bone is when its link is there.
fn bone_place(bone: &BoundBone, link: &LinkTransform) -> LinkTransform {
    let (position, rotation): (DVec3, DQuat) =
        (link.position + link.rotation * bone.offset.position, link.rotation * bone.offset.rotation);
    LinkTransform { position, rotation }
}

/// Hides the plain shapes of links that a bone follows.
#[cfg(feature = "render")]
fn hide_shapes(
    athletes: Query<(&AthleteSkin, &DressedIn, &Children)>,
    mut shapes: Query<(&crate::engine::LinkVisual, &mut Visibility), Without<crate::engine::BladeVisual>>,
) {
    for (_, dress, children) in athletes.iter().filter(|(skin, ..)| skin.hide_shapes) {
        for child in children.iter() {
            if let Ok((shape, mut visibility)) = shapes.get_mut(child)
                && !shape.ghost
                && dress.bones().any(|(_, bone)| bone.link == shape.link.index())
            {
                visibility.set_if_neq(Visibility::Hidden);
            }
        }
    }
}

/// The code of the guide compiles.
#[cfg(doctest)]
#[doc = include_str!("../../docs/book/dress.md")]
struct Guide;
