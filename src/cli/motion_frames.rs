//! Instants of a motion as it is written, for a storyboard.

use crate::asset::clip::{ClipError, MotionClip};
use crate::model::{CharacterModel, KeyPoseError, KeyPoses, ModelPose};
use crate::storyboard::StoryboardFrame;

/// Most instants of a clip: enough for a smooth path of the centre of mass.
const MOST: usize = 240;
/// Poses per second from which key poses are read back: between two, a pose changes by less than can be seen.
const FINE: f64 = 240.0;
/// Most poses that key poses are read back from.
const MOST_FINE: f64 = 20_000.0;

fn frame(model: &CharacterModel, time: f64, pose: &ModelPose) -> StoryboardFrame {
    let mut links = Vec::with_capacity(model.links.len());
    pose.link_transforms(model, &mut links);
    StoryboardFrame::new(time, links)
}

/// Instants of a clip at even times: all its poses, or 240 where it has more.
pub fn clip_frames(clip: &MotionClip, model: &CharacterModel) -> Result<Vec<StoryboardFrame>, ClipError> {
    let fitted = clip.to_model(model)?;
    let count = fitted.poses().len().min(MOST);
    let step = fitted.duration() / (count - 1).max(1) as f64;
    Ok((0..count).map(|i| i as f64 * step).map(|t| frame(model, t, &fitted.sample(t))).collect())
}

/// One instant for each key pose of a file, at its time, with its index as the caption (`pose 0`), as it is in the first
/// repetition, contacts included.
pub fn key_pose_frames(poses: &KeyPoses, model: &CharacterModel) -> Result<Vec<StoryboardFrame>, KeyPoseError> {
    let seconds: f64 = poses.seconds.iter().sum();
    let once = KeyPoses {
        // Twice, where it repeats: contacts reach over its end.
        repeat: poses.repeat.min(2),
        frame_rate: (MOST_FINE / seconds.max(1e-3)).clamp(1.0, FINE),
        ..poses.clone()
    };
    let clip = once.to_clip(model)?.to_model(model)?;
    let mut time = 0.0;
    let mut frames = Vec::with_capacity(poses.poses.len());
    for (i, seconds) in poses.seconds.iter().enumerate() {
        frames.push(StoryboardFrame { caption: format!("pose {i}"), ..frame(model, time, &clip.sample(time)) });
        time += seconds;
    }
    Ok(frames)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::skater;
    use glam::{DQuat, DVec3};

    #[test]
    fn key_poses_are_shown_as_they_are_written() {
        let model = skater();
        let text = include_str!("../../assets/skills/skating/stroking/stroking.keyposes.ron");
        let poses = KeyPoses::from_ron(text, "stroking.keyposes.ron").unwrap();
        let frames = key_pose_frames(&poses, &model).unwrap();
        assert_eq!(frames.len(), poses.poses.len());
        let mut time = 0.0;
        for (i, (frame, pose)) in frames.iter().zip(&poses.poses).enumerate() {
            assert!((frame.time - time).abs() < 1e-12 && frame.caption == format!("pose {i}"));
            time += poses.seconds[i];
            for (link, place) in model.links.iter().zip(&frame.links).skip(1) {
                let (x, y, z) = pose.joints.get(&link.name).copied().unwrap_or_default();
                let written = DQuat::from_scaled_axis(DVec3::new(x, y, z) * std::f64::consts::PI / 180.0);
                let shown = frame.links[link.parent.unwrap()].rotation.conjugate() * place.rotation;
                assert!(shown.angle_between(written) < 0.01, "pose {i}, {}", link.name);
            }
        }
    }

    #[test]
    fn a_clip_is_shown_from_its_first_pose_to_its_last() {
        let model = skater();
        let text = include_str!("../../assets/skills/skating/stroking/stroking.keyposes.ron");
        let clip = KeyPoses::from_ron(text, "stroking.keyposes.ron").unwrap().to_clip(&model).unwrap();
        let frames = clip_frames(&clip, &model).unwrap();
        assert_eq!(frames.len(), clip.poses.len().min(MOST));
        assert!((frames[frames.len() - 1].time - clip.duration()).abs() < 1e-9);
        for (frame, pose) in
            [(&frames[0], &clip.poses[0]), (&frames[frames.len() - 1], &clip.poses[clip.poses.len() - 1])]
        {
            assert!((frame.links[0].position - pose.root_position).length() < 1e-9);
        }
        let one = MotionClip { poses: clip.poses[..1].to_vec(), ..clip };
        assert_eq!(clip_frames(&one, &model).unwrap().len(), 1);
    }
}
