//! A motion clip laid out for one character: rotations by link index, sampled without allocation.

use super::{CharacterModel, JointKind};
use crate::asset::clip::{ClipError, MotionClip, difference_interval, frame_at, joint_velocity};
use crate::asset::turn::{rotation_vector, slerp, twist};
use glam::{DQuat, DVec3};

/// A pose of a character.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelPose {
    /// Root joint position, world frame, m.
    pub root_position: DVec3,
    /// Root rotation, root axes to world axes.
    pub root_rotation: DQuat,
    /// Rotation of each link's joint by link index, child axes to parent axes; entry 0 (the root) stays identity.
    pub joints: Vec<DQuat>,
}

/// How fast a character's pose changes.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelVelocity {
    /// Velocity of the root joint, world frame, m/s.
    pub root_linear: DVec3,
    /// Angular velocity of the root, world frame, rad/s.
    pub root_angular: DVec3,
    /// Angular velocity of each link against its parent by link index, child frame, rad/s; entry 0 stays zero.
    pub joints: Vec<DVec3>,
}

/// Place of a link in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "engine", derive(bevy::reflect::Reflect))]
pub struct LinkTransform {
    /// Position of the link's joint, world frame, m.
    pub position: DVec3,
    /// Link axes to world axes.
    pub rotation: DQuat,
}

impl LinkTransform {
    /// Between this place (`s` = 0) and another (1): straight, and along the shorter arc.
    pub fn mix(&self, other: &Self, s: f64) -> Self {
        Self {
            position: self.position.lerp(other.position, s),
            rotation: mix_rotation(self.rotation, other.rotation, s),
        }
    }
}

/// Along the shorter arc by normalised interpolation: for rotations that are not far apart.
fn mix_rotation(a: DQuat, b: DQuat, s: f64) -> DQuat {
    let to = if a.dot(b) < 0.0 { -b } else { b };
    (a * (1.0 - s) + to * s).normalize()
}

impl ModelPose {
    /// The zero pose of a character with its root at the origin.
    pub fn zero(model: &CharacterModel) -> Self {
        Self {
            root_position: DVec3::ZERO,
            root_rotation: DQuat::IDENTITY,
            joints: vec![DQuat::IDENTITY; model.links.len()],
        }
    }

    /// Between this pose (`s` = 0) and another (1): places straight, rotations along the shorter arc.
    pub fn mix(&self, other: &Self, s: f64) -> Self {
        Self {
            root_position: self.root_position.lerp(other.root_position, s),
            root_rotation: mix_rotation(self.root_rotation, other.root_rotation, s),
            joints: self.joints.iter().zip(&other.joints).map(|(a, b)| mix_rotation(*a, *b, s)).collect(),
        }
    }

    /// Forward kinematics: the place of every link, by link index. `out` is cleared first and keeps its memory.
    pub fn link_transforms(&self, model: &CharacterModel, out: &mut Vec<LinkTransform>) {
        out.clear();
        for (link, &joint) in model.links.iter().zip(&self.joints) {
            out.push(match link.parent.and_then(|p| out.get(p).copied()) {
                None => LinkTransform { position: self.root_position, rotation: self.root_rotation },
                Some(parent) => LinkTransform {
                    position: parent.position + parent.rotation * link.offset,
                    rotation: parent.rotation * joint,
                },
            });
        }
    }
}

impl ModelVelocity {
    /// At rest.
    pub fn zero(model: &CharacterModel) -> Self {
        Self { root_linear: DVec3::ZERO, root_angular: DVec3::ZERO, joints: vec![DVec3::ZERO; model.links.len()] }
    }
}

/// A motion clip whose poses hold a rotation for every link of one character.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelClip {
    name: String,
    frame_rate: f64,
    poses: Vec<ModelPose>,
    driven: Vec<bool>,
}

impl MotionClip {
    /// The clip laid out for a character: joints by link index; links that the clip does not name hold the identity.
    /// At a hinge only the rotation about its axis is kept. Fails where the clip is invalid or names no link.
    pub fn to_model(&self, model: &CharacterModel) -> Result<ModelClip, ClipError> {
        self.validate()?;
        let mut targets = Vec::with_capacity(self.joints.len());
        let mut driven = vec![false; model.links.len()];
        for joint in &self.joints {
            match model.link_index(joint) {
                Some(link) if link > 0 => {
                    driven[link] = true;
                    targets.push(link);
                }
                _ => {
                    let links: Vec<&str> = model.links.iter().skip(1).map(|l| l.name.as_str()).collect();
                    return Err(ClipError::UnknownJoint {
                        clip: self.name.clone(),
                        joint: joint.clone(),
                        character: model.name.clone(),
                        links: links.join(", "),
                    });
                }
            }
        }
        let poses = self.poses.iter().map(|pose| {
            let mut out = ModelPose {
                root_position: pose.root_position,
                root_rotation: pose.root_rotation,
                joints: vec![DQuat::IDENTITY; model.links.len()],
            };
            for (&link, &rotation) in targets.iter().zip(&pose.joints) {
                out.joints[link] = match model.links[link].joint {
                    JointKind::Hinge { axis } => twist(rotation, axis),
                    _ => rotation,
                };
            }
            out
        });
        Ok(ModelClip { name: self.name.clone(), frame_rate: self.frame_rate, poses: poses.collect(), driven })
    }
}

impl ModelClip {
    /// Name for reports.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// Poses per second.
    pub fn frame_rate(&self) -> f64 {
        self.frame_rate
    }
    /// The poses, at least one.
    pub fn poses(&self) -> &[ModelPose] {
        &self.poses
    }
    /// Whether the clip moves the joint of this link.
    pub fn drives(&self, link: usize) -> bool {
        self.driven.get(link).copied().unwrap_or(false)
    }
    /// Time from the first pose to the last, s.
    pub fn duration(&self) -> f64 {
        (self.poses.len() - 1) as f64 / self.frame_rate
    }

    /// The pose at time `t` (s from the start, clamped to the clip).
    pub fn sample(&self, t: f64) -> ModelPose {
        let mut pose = self.poses[0].clone();
        self.sample_into(t, &mut pose);
        pose
    }

    /// The pose at time `t` (s, clamped) written into `out`: positions linear, rotations along the shorter arc. Does
    /// not allocate once `out` has an entry per link.
    pub fn sample_into(&self, t: f64, out: &mut ModelPose) {
        let (a, b, s) = self.around(t);
        out.joints.resize(a.joints.len(), DQuat::IDENTITY);
        out.root_position = a.root_position.lerp(b.root_position, s);
        out.root_rotation = mix(a.root_rotation, b.root_rotation, s);
        for ((out, a), b) in out.joints.iter_mut().zip(&a.joints).zip(&b.joints) {
            *out = mix(*a, *b, s);
        }
    }

    /// How fast the pose changes at time `t` (s, clamped): see [`ModelClip::sample_velocity_into`].
    pub fn sample_velocity(&self, t: f64) -> ModelVelocity {
        let mut out = ModelVelocity {
            root_linear: DVec3::ZERO,
            root_angular: DVec3::ZERO,
            joints: vec![DVec3::ZERO; self.driven.len()],
        };
        self.sample_velocity_into(t, &mut out);
        out
    }

    /// How fast the pose changes at time `t` (s, clamped), written into `out`: central differences over one frame
    /// interval, one-sided at the ends. Does not allocate once `out` has an entry per link.
    pub fn sample_velocity_into(&self, t: f64, out: &mut ModelVelocity) {
        let (t0, t1) = difference_interval(t, self.frame_rate, self.duration());
        let per_second = if t1 > t0 { 1.0 / (t1 - t0) } else { 0.0 };
        let ((a0, b0, s0), (a1, b1, s1)) = (self.around(t0), self.around(t1));
        out.joints.resize(self.driven.len(), DVec3::ZERO);
        let before = a0.root_position.lerp(b0.root_position, s0);
        let after = a1.root_position.lerp(b1.root_position, s1);
        out.root_linear = (after - before) * per_second;
        let before = mix(a0.root_rotation, b0.root_rotation, s0);
        let after = mix(a1.root_rotation, b1.root_rotation, s1);
        out.root_angular = rotation_vector(after * before.conjugate()) * per_second;
        for (link, out) in out.joints.iter_mut().enumerate() {
            *out = DVec3::ZERO;
            if self.driven[link] {
                let before = mix(a0.joints[link], b0.joints[link], s0);
                let after = mix(a1.joints[link], b1.joints[link], s1);
                *out = joint_velocity(before, after, per_second);
            }
        }
    }

    /// The poses before and after `t` and the fraction of the way between them.
    fn around(&self, t: f64) -> (&ModelPose, &ModelPose, f64) {
        let (frame, s) = frame_at(t, self.frame_rate, self.poses.len());
        let next = (frame + 1).min(self.poses.len() - 1);
        (&self.poses[frame], &self.poses[next], s)
    }
}

fn mix(a: DQuat, b: DQuat, s: f64) -> DQuat {
    if s > 0.0 { slerp(a, b, s) } else { a }
}
