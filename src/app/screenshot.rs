//! Renders some frames, saves a picture, ends the app.

use crate::engine::{AthleteBody, PlaybackSpeed};
use bevy::asset::RenderAssetUsages;
use bevy::camera::RenderTarget;
use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use std::path::PathBuf;

/// A picture to be taken.
#[derive(Resource, Clone, Debug)]
pub(super) struct Shot {
    /// Where it goes.
    pub file: PathBuf,
    /// Frames before it is taken.
    pub frames: u32,
    /// Frames so far.
    pub seen: u32,
}

/// Where pictures come from: an image that is drawn into where there is no window.
#[derive(Resource, Clone, Debug, Default)]
pub(super) struct PictureSource(pub Option<Handle<Image>>);

impl PictureSource {
    /// A picture of this frame.
    pub fn screenshot(&self) -> Screenshot {
        self.0.clone().map_or_else(Screenshot::primary_window, Screenshot::image)
    }
}

/// An image that a camera can draw into, and the component that makes it.
pub(super) fn image_target(images: &mut Assets<Image>, width: u32, height: u32) -> (Handle<Image>, RenderTarget) {
    let mut image = Image::new_target_texture(width, height, TextureFormat::Rgba8UnormSrgb, None);
    image.asset_usage = RenderAssetUsages::default();
    let handle = images.add(image);
    (handle.clone(), RenderTarget::Image(handle.into()))
}

/// Counts frames from when the skater is there; then takes the picture and ends.
pub(super) fn take(
    mut commands: Commands,
    mut shot: ResMut<Shot>,
    source: Res<PictureSource>,
    mut playback: ResMut<PlaybackSpeed>,
    bodies: Query<(), With<AthleteBody>>,
) {
    if bodies.is_empty() {
        return;
    }
    shot.seen += 1;
    // The pause acts in the frame after the next.
    if shot.seen + 1 >= shot.frames {
        playback.paused = true;
    }
    // Two more frames: the pipeline of frames in flight catches up with the last one.
    if shot.seen == shot.frames + 2 {
        commands.spawn(source.screenshot()).observe(save_to_disk(shot.file.clone())).observe(
            |_: On<ScreenshotCaptured>, mut exit: MessageWriter<AppExit>| {
                exit.write(AppExit::Success);
            },
        );
    }
}
