//! A bone map laid on a character and a mesh's skeleton: which bone follows which link, and where on it.

use crate::asset::bone_map::{BoneMap, BoneMapError, rotation_of_degrees};
use crate::model::{CharacterModel, LinkTransform, ModelPose};
use glam::{DMat4, DVec3};

/// A bone of a skeleton at rest.
#[derive(Clone, Debug)]
pub struct RestBone {
    /// Its name; empty for one that has none.
    pub name: String,
    /// Bone axes to the character's frame (on the ground, Y up, facing -Z), m.
    pub to_character: DMat4,
}

/// A bone that follows a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundBone {
    /// Index in the skeleton.
    pub bone: usize,
    /// Index of the link.
    pub link: usize,
    /// The bone in the link's frame: its transform in the world is the link's times this.
    pub offset: LinkTransform,
    /// Its scale, kept from the rest pose.
    pub scale: DVec3,
}

/// Where the links are in the character's frame when it stands as the mesh does at rest, by link index.
pub fn rest_links(map: &BoneMap, model: &CharacterModel) -> Result<Vec<LinkTransform>, BoneMapError> {
    let mut pose = ModelPose::zero(model);
    pose.root_position = DVec3::new(0.0, model.rest_root_height(), 0.0);
    for (link, degrees) in &map.pose {
        pose.joints[link_of(map, model, "pose", link, link)?] = rotation_of_degrees(*degrees);
    }
    let mut links = Vec::new();
    pose.link_transforms(model, &mut links);
    Ok(links)
}

/// Finds the bones and links of a map, and the offsets that it leaves to the rest poses. In the order of the map.
pub fn bind_bones(
    map: &BoneMap,
    model: &CharacterModel,
    skeleton: &[RestBone],
) -> Result<Vec<BoundBone>, BoneMapError> {
    let file = || map.file.clone();
    if map.character != model.name {
        let (wanted, found) = (map.character.clone(), model.name.clone());
        return Err(BoneMapError::Character { file: file(), wanted, found });
    }
    let links = rest_links(map, model)?;
    map.bones
        .iter()
        .map(|(bone, entry)| {
            let link = link_of(map, model, "bone", bone, &entry.link)?;
            let mut named = skeleton.iter().enumerate().filter(|(_, b)| b.name == *bone);
            let Some((index, rest)) = named.next() else {
                let names: Vec<&str> =
                    skeleton.iter().map(|b| b.name.as_str()).filter(|name| !name.is_empty()).collect();
                return Err(BoneMapError::UnknownBone { file: file(), bone: bone.clone(), valid: names.join(", ") });
            };
            let others = named.count();
            if others > 0 {
                return Err(BoneMapError::AmbiguousBone { file: file(), bone: bone.clone(), count: others + 1 });
            }
            let flat = || BoneMapError::RestPose { file: file(), bone: bone.clone() };
            let determinant = rest.to_character.determinant();
            if !(determinant.is_finite() && determinant.abs() > 1e-18) {
                return Err(flat());
            }
            let (scale, rotation, position) = rest.to_character.to_scale_rotation_translation();
            let offset = match entry.offset {
                Some(given) => {
                    LinkTransform { position: given.translation, rotation: rotation_of_degrees(given.degrees) }
                }
                None => {
                    let back = links[link].rotation.inverse();
                    LinkTransform {
                        position: back * (position - links[link].position),
                        rotation: (back * rotation).normalize(),
                    }
                }
            };
            if !(offset.position.is_finite() && offset.rotation.is_finite() && scale.is_finite()) {
                return Err(flat());
            }
            Ok(BoundBone { bone: index, link, offset, scale })
        })
        .collect()
}

/// Index of a link that an entry names.
fn link_of(
    map: &BoneMap,
    model: &CharacterModel,
    part: &'static str,
    name: &str,
    link: &str,
) -> Result<usize, BoneMapError> {
    model.link_index(link).ok_or_else(|| {
        let names: Vec<&str> = model.links.iter().map(|l| l.name.as_str()).collect();
        BoneMapError::UnknownLink {
            file: map.file.clone(),
            part,
            name: name.into(),
            link: link.into(),
            valid: names.join(", "),
        }
    })
}
