//! The frozen description of a character, built once from a validated file.

mod body_landmarks;
mod body_parts;
mod bone_binding;
mod build;
mod character_model;
mod find_map;
mod fingerprint;
mod import_check;
mod import_motion;
mod inverse_kinematics;
mod key_contacts;
mod key_pose_text;
mod key_poses;
mod mass;
mod mass_path;
mod mjcf;
mod model_clip;
mod overlap;
mod position_import;
mod presets;
mod retarget;
mod side_check;
mod sole_height;
mod soles;
mod windows;

pub use crate::asset::{PointRole, Side};
pub use body_landmarks::{BodyLandmark, BodyLandmarkError, BodyLandmarks};
pub use bone_binding::{BoundBone, RestBone, bind_bones, rest_links};
pub use character_model::{
    Blade, CharacterModel, ContactKind, ContactPoint, Foot, FootKind, Gains, Grip, JointKind, JointLimits, JointSpring,
    LeanLaw, Link, Shape, SharedModel,
};
pub use find_map::{FindMapError, FoundMap, MapRow, MapWarning, RestPose, find_map, some_names};
pub use import_check::{MotionRefusal, MotionWarning, check_motion, check_size};
pub use import_motion::{ImportMotionError, ImportWarning, ImportedMotion, import_motion};
pub use inverse_kinematics::{BodySize, LandmarkTarget, PoseFit, PoseSolver};
pub use key_contacts::KeyContact;
pub use key_poses::{KeyPose, KeyPoseError, KeyPoses};
pub use mass_path::GRAVITY;
pub use mjcf::export_mjcf;
pub use model_clip::{LinkTransform, ModelClip, ModelPose, ModelVelocity};
pub use position_import::{
    ImportedPoses, PositionImportError, PositionImportOptions, PositionWarning, import_positions,
};
pub use presets::{PRESET_NAMES, foot_human, preset, preset_source, runner, skater, toes_human, two_segment_human};
pub use retarget::{ImportError, import_bvh, import_scale};
pub use side_check::SidedPart;
pub use sole_height::SoleHeights;
pub use windows::{BodyPart, Objective, OptimizeRecord, Window};
