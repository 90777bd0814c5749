//! BVH motion onto a character, as a [`JointMap`] says.

use super::{CharacterModel, some_names};
use crate::asset::bvh::{Bvh, BvhTransform};
use crate::asset::clip::{ClipError, MotionClip, Pose};
use crate::asset::joint_map::{Fit, JointMap, LinkMap, MapError, RootAnchor};
use crate::asset::turn::{slerp, unit};
use glam::{DQuat, DVec3};

/// Why a BVH file could not be put onto a character.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// The map is invalid.
    #[error(transparent)]
    Map(#[from] MapError),
    /// The resulting clip is invalid.
    #[error(transparent)]
    Clip(#[from] ClipError),
    /// Joints of the file are not in the map.
    #[error(
        "{} of the file not in joint map `{map}`: {}; map them or list them under `ignored` (docs/book/motions.md, \"BVH and joint maps\")",
        if joints.len() == 1 { "1 joint is".into() } else { format!("{} joints are", joints.len()) },
        joints.join(", ")
    )]
    UnmappedJoints {
        /// All of them.
        joints: Vec<String>,
        /// The map.
        map: String,
    },
    /// A joint of the map is not in the file.
    #[error("joint map `{map}` names joint `{joint}`, but the file has only: {found}")]
    MissingJoint {
        /// The map.
        map: String,
        /// The joint.
        joint: String,
        /// Joints of the file.
        found: String,
    },
    /// Joints summed into one link are no chain.
    #[error("joint map `{map}`, link `{link}`: joint `{joint}` does not lie below the joint listed before it")]
    Chain {
        /// The map.
        map: String,
        /// The link.
        link: String,
        /// The joint.
        joint: String,
    },
    /// A link of the map is not in the character.
    #[error("joint map `{map}` names link `{link}`, but character `{character}` has only: {links}")]
    UnknownLink {
        /// The map.
        map: String,
        /// The link.
        link: String,
        /// The character.
        character: String,
        /// Its links.
        links: String,
    },
    /// Two entries lead to one link, or the root entry to another link than the root.
    #[error("joint map `{map}`, entry `{entry}`: link `{link}` of the character {problem}")]
    LinkUse {
        /// The map.
        map: String,
        /// The entry.
        entry: String,
        /// The link.
        link: String,
        /// What is wrong.
        problem: &'static str,
    },
    /// A leg has no length to fit by.
    #[error("joint map `{map}`: the legs of the {of} are {found} m long; a fit needs 0.000001 to 1000000 m")]
    LegLength {
        /// The map.
        map: String,
        /// Source or character.
        of: &'static str,
        /// Found, m.
        found: f64,
    },
}

/// A link that follows a source joint.
struct Follower {
    joint: usize,
    /// Link axes to the source joint's axes.
    axes: DQuat,
    share: f64,
}

/// Puts the motion of a BVH file onto a character.
///
/// The clip has the file's frame rate and place, in our axes and metres, with the joints that the map names, in the
/// order of the character's links. It is named after the map; the name is free to be changed.
pub fn import_bvh(bvh: &Bvh, map: &JointMap, model: &CharacterModel) -> Result<MotionClip, ImportError> {
    map.validate()?;
    let source = Importer { bvh, map, model };
    let followers = source.followers()?;
    let scale = map.unit * source.fit()?;
    let anchor = source.anchor()?;

    let driven: Vec<usize> = (1..model.links.len()).filter(|&l| followers[l].is_some()).collect();
    let world = map.world_rotation();
    let mut rotations = vec![DQuat::IDENTITY; model.links.len()];
    let mut poses = Vec::with_capacity(bvh.frame_count());
    for frame in 0..bvh.frame_count() {
        let joints = bvh.world_transforms(frame);
        for (link, follower) in followers.iter().enumerate() {
            let parent = model.links[link].parent.map_or(DQuat::IDENTITY, |p| rotations[p]);
            rotations[link] = match follower {
                None => parent,
                Some(f) => {
                    let goal = unit(world * joints[f.joint].rotation * f.axes);
                    if f.share < 1.0 { slerp(parent, goal, f.share) } else { goal }
                }
            };
        }
        let mut root_position = world * anchor.source(&joints) * scale;
        root_position *= DVec3::new(map.stride, 1.0, map.stride);
        root_position += DVec3::Y * map.lift - rotations[0] * anchor.in_root;
        poses.push(Pose {
            root_position,
            root_rotation: rotations[0],
            joints: driven
                .iter()
                .map(|&l| {
                    let parent = model.links[l].parent.map_or(DQuat::IDENTITY, |p| rotations[p]);
                    unit(parent.conjugate() * rotations[l])
                })
                .collect(),
        });
    }

    let joints = driven.iter().map(|&l| model.links[l].name.clone()).collect();
    let mut clip = MotionClip { name: map.name.clone(), frame_rate: 1.0 / bvh.frame_time(), joints, poses };
    clip.validate()?;
    if !map.soles.is_empty() {
        let mut soles = Vec::new();
        for sole in &map.soles {
            soles.push(model.links[source.link(sole)?].name.as_str());
        }
        clip = clip.grounded_at(model, &soles, map.sole_fraction)?.0;
    }
    Ok(clip)
}

/// Metres on the character for one unit of the file, as [`import_bvh`] has them before `stride`.
pub fn import_scale(bvh: &Bvh, map: &JointMap, model: &CharacterModel) -> Result<f64, ImportError> {
    map.validate()?;
    Ok(map.unit * Importer { bvh, map, model }.fit()?)
}

/// The point of the source that the root follows, and where it lies in the root link.
struct Anchor {
    joints: (usize, usize),
    in_root: DVec3,
}

impl Anchor {
    /// The point in the source world, file units.
    fn source(&self, joints: &[BvhTransform]) -> DVec3 {
        (joints[self.joints.0].position + joints[self.joints.1].position) * 0.5
    }
}

struct Importer<'a> {
    bvh: &'a Bvh,
    map: &'a JointMap,
    model: &'a CharacterModel,
}

impl Importer<'_> {
    fn joint(&self, name: &str) -> Result<usize, ImportError> {
        self.bvh.joint_index(name).ok_or_else(|| {
            let found: Vec<&str> = self.bvh.joints().iter().map(|j| j.name.as_str()).collect();
            ImportError::MissingJoint { map: self.map.name.clone(), joint: name.into(), found: some_names(&found) }
        })
    }

    /// The character's link for an entry, by its name or the first alias that fits.
    fn entry_link(&self, entry: &LinkMap) -> Option<usize> {
        std::iter::once(&entry.link).chain(&entry.aliases).find_map(|name| self.model.link_index(name))
    }

    /// The character's link by its name in the map.
    fn link(&self, name: &str) -> Result<usize, ImportError> {
        self.map.entry(name).and_then(|entry| self.entry_link(entry)).ok_or_else(|| {
            let links: Vec<&str> = self.model.links.iter().map(|l| l.name.as_str()).collect();
            ImportError::UnknownLink {
                map: self.map.name.clone(),
                link: name.into(),
                character: self.model.name.clone(),
                links: links.join(", "),
            }
        })
    }

    /// For each link of the character, what it follows.
    fn followers(&self) -> Result<Vec<Option<Follower>>, ImportError> {
        let unmapped = self.bvh.joints().iter().filter(|joint| !self.map.knows(&joint.name));
        let joints: Vec<String> = unmapped.map(|joint| joint.name.clone()).collect();
        if !joints.is_empty() {
            return Err(ImportError::UnmappedJoints { joints, map: self.map.name.clone() });
        }
        let mut followers: Vec<Option<Follower>> = self.model.links.iter().map(|_| None).collect();
        for (index, entry) in self.map.entries().enumerate() {
            let joint = self.chain_end(entry)?;
            if entry.optional && self.entry_link(entry).is_none() {
                continue;
            }
            let link = self.link(&entry.link)?;
            let misuse = |problem| ImportError::LinkUse {
                map: self.map.name.clone(),
                entry: entry.link.clone(),
                link: self.model.links[link].name.clone(),
                problem,
            };
            if index == 0 && link != 0 {
                return Err(misuse("is not its root"));
            }
            if followers[link].is_some() {
                return Err(misuse("is driven by an earlier entry"));
            }
            followers[link] = Some(Follower { joint, axes: self.map.link_rotation(entry), share: entry.share });
        }
        Ok(followers)
    }

    /// The last joint of an entry's chain; each must lie below the one before it.
    fn chain_end(&self, entry: &LinkMap) -> Result<usize, ImportError> {
        let mut end = None;
        for name in &entry.joints {
            let joint = self.joint(name)?;
            if let Some(above) = end {
                let mut parent = self.bvh.joints()[joint].parent;
                while parent.is_some_and(|p| p > above) {
                    parent = parent.and_then(|p| self.bvh.joints()[p].parent);
                }
                if parent != Some(above) {
                    let (map, link) = (self.map.name.clone(), entry.link.clone());
                    return Err(ImportError::Chain { map, link, joint: name.clone() });
                }
            }
            end = Some(joint);
        }
        // A valid map has at least one joint in every entry.
        Ok(end.unwrap_or(0))
    }

    fn anchor(&self) -> Result<Anchor, ImportError> {
        match &self.map.anchor {
            RootAnchor::Joint => {
                let joint = self.chain_end(&self.map.root)?;
                Ok(Anchor { joints: (joint, joint), in_root: DVec3::ZERO })
            }
            RootAnchor::Between { joints, links } => {
                let rest = self.model.rest_positions();
                let (a, b) = (self.link(&links.0)?, self.link(&links.1)?);
                let joints = (self.joint(&joints.0)?, self.joint(&joints.1)?);
                Ok(Anchor { joints, in_root: (rest[a] + rest[b]) * 0.5 })
            }
        }
    }

    /// The factor from the source's size to the character's.
    fn fit(&self) -> Result<f64, ImportError> {
        match &self.map.fit {
            Fit::None => Ok(1.0),
            Fit::Factor(factor) => Ok(*factor),
            Fit::Legs { joints, links } => {
                let joints = [self.joint(&joints.0)?, self.joint(&joints.1)?, self.joint(&joints.2)?];
                let links = [self.link(&links.0)?, self.link(&links.1)?, self.link(&links.2)?];
                let world = self.bvh.world_transforms(0);
                let rest = self.model.rest_positions();
                let leg = |p: [DVec3; 3]| p[0].distance(p[1]) + p[1].distance(p[2]);
                let source = leg(joints.map(|j| world[j].position)) * self.map.unit;
                let own = leg(links.map(|l| rest[l]));
                for (of, found) in [("source", source), ("character", own)] {
                    if !(1e-6..=1e6).contains(&found) {
                        return Err(ImportError::LegLength { map: self.map.name.clone(), of, found });
                    }
                }
                Ok(own / source)
            }
        }
    }
}
