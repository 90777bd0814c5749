//! Records an animated picture of what the camera sees, writes it, ends the app.

use crate::app::gif_file::{Pixels, write_gif};
use crate::app::screenshot::PictureSource;
use crate::engine::AthleteBody;
use bevy::prelude::*;
use bevy::render::view::screenshot::ScreenshotCaptured;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;

/// Pictures per second.
pub(super) const RATE: u16 = 20;
/// Frames before the first picture: shaders are compiled, images are there.
const WARM_UP: u32 = 4;

/// A recording on its way.
#[derive(Resource, Debug)]
pub(super) struct Recording {
    /// Where it goes.
    pub file: PathBuf,
    /// Frames that pass unseen.
    pub skip: u32,
    /// Pictures in all.
    pub count: u32,
    seen: u32,
    size: (u32, u32),
    /// By number: they come when the graphics card has them.
    pictures: BTreeMap<u32, Pixels>,
}

impl Recording {
    /// Of `seconds`, from the simulated time `at`, s.
    pub fn new(file: PathBuf, at: f64, seconds: f64) -> Self {
        let frames = |time: f64| (time * f64::from(RATE)).round() as u32;
        let (skip, count) = (frames(at).max(WARM_UP), frames(seconds).max(1));
        Self { file, skip, count, seen: 0, size: (0, 0), pictures: BTreeMap::new() }
    }
}

/// Asks for a picture of this frame.
pub(super) fn film(
    mut commands: Commands,
    mut recording: ResMut<Recording>,
    source: Res<PictureSource>,
    bodies: Query<(), With<AthleteBody>>,
) {
    if bodies.is_empty() {
        return;
    }
    recording.seen += 1;
    let Some(number) = recording.seen.checked_sub(recording.skip + 1).filter(|n| *n < recording.count) else { return };
    let keep = move |picture: On<ScreenshotCaptured>, recording: ResMut<Recording>, exit: MessageWriter<AppExit>| {
        keep(number, &picture.image, recording.into_inner(), exit);
    };
    commands.spawn(source.screenshot()).observe(keep);
}

/// Keeps a picture; the last one ends the recording.
fn keep(number: u32, image: &Image, recording: &mut Recording, mut exit: MessageWriter<AppExit>) {
    let pixels = match image.clone().try_into_dynamic() {
        Ok(picture) => picture.to_rgb8(),
        Err(error) => {
            error!("picture {number}: {error}");
            exit.write(AppExit::error());
            return;
        }
    };
    recording.size = pixels.dimensions();
    recording.pictures.insert(number, pixels.pixels().map(|p| p.0).collect());
    if recording.pictures.len() < recording.count as usize {
        return;
    }
    let pictures: Vec<Pixels> = std::mem::take(&mut recording.pictures).into_values().collect();
    let written = File::create(&recording.file).map_err(|e| e.to_string()).and_then(|file| {
        let (width, height) = recording.size;
        let side = |length: u32| u16::try_from(length).map_err(|e| e.to_string());
        write_gif(BufWriter::new(file), (side(width)?, side(height)?), &pictures, 100 / RATE).map_err(|e| e.to_string())
    });
    match written {
        Ok(()) => exit.write(AppExit::Success),
        Err(reason) => {
            error!("{}: {reason}", recording.file.display());
            // Half a file is none.
            let _ = std::fs::remove_file(&recording.file);
            exit.write(AppExit::error())
        }
    };
}
