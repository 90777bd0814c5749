//! A storyboard is a PNG of the asked size in which figures, ghosts and contacts can be seen.
//!
//! Counting pixels of a hue, cell by cell, would notice an empty cell, a camera that looks elsewhere and swapped sides; a
//! bare "the file is not empty" would not. Set `STORYBOARD_DIR` to keep the pictures and look at them.

use crate::puppet::{place, puppet};
use bevy_athlete::model::{ContactPoint, LinkTransform};
use bevy_athlete::storyboard::*;
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;
use tiny_skia::Pixmap;

/// Where a contact point is, world frame, m.
fn at(links: &[LinkTransform], point: &ContactPoint) -> DVec3 {
    links[point.link].position + links[point.link].rotation * point.position
}

/// A stroke on a curve: the standing leg bent, the free leg behind, the arms out.
fn stroke(count: usize) -> Vec<StoryboardFrame> {
    let model = puppet();
    let x = |a: f64| DQuat::from_rotation_x(a);
    let z = |a: f64| DQuat::from_rotation_z(a);
    let pose = |t: f64, delay: f64| {
        let s = (TAU * (t - delay) / 1.6).sin();
        let (left, right) = (0.5 + 0.5 * s, 0.5 - 0.5 * s);
        let yaw = DQuat::from_rotation_y(0.5 * t);
        let root = DVec3::new(-0.5 * t * t, 0.83 + 0.05 * (TAU * t / 0.8).cos() - 0.12, -2.2 * t - delay);
        place(&model, root, yaw * z(0.12 * s) * x(-0.25), |name| match name {
            "torso" => x(-0.3),
            "upper_arm_left" => z(-0.9) * x(0.5 * s),
            "upper_arm_right" => z(0.9) * x(-0.5 * s),
            "forearm_left" | "forearm_right" => x(0.35),
            "thigh_left" => x(0.9 - 1.3 * left) * z(-0.15 * left),
            "thigh_right" => x(0.9 - 1.3 * right) * z(0.15 * right),
            "shin_left" => x(-0.8 + 0.4 * left),
            "shin_right" => x(-0.8 + 0.4 * right),
            "foot_left" => x(0.25),
            "foot_right" => x(0.25),
            _ => DQuat::IDENTITY,
        })
    };
    (0..count)
        .map(|i| {
            let t = 2.4 * i as f64 / (count - 1) as f64;
            let mut links = pose(t, 0.0);
            let mut ghost = pose(t, 0.12);
            // Stand on the lowest blade end.
            let lowest = |links: &[LinkTransform]| {
                model.contact_points.iter().map(|c| at(links, c).y - c.radius).fold(9.0, f64::min)
            };
            for links in [&mut links, &mut ghost] {
                let low = lowest(links);
                links.iter_mut().for_each(|l| l.position.y -= low);
            }
            let contacts = model
                .contact_points
                .iter()
                .map(|c| at(&links, c) - DVec3::Y * c.radius)
                .filter(|p| p.y < 0.02)
                .map(|position| TouchPoint { position, force: DVec3::new(20.0, 230.0, 10.0) })
                .collect();
            StoryboardFrame {
                ghost: Some(ghost),
                contacts,
                caption: "left outside edge".into(),
                ..StoryboardFrame::new(t, links)
            }
        })
        .collect()
}

fn draw(name: &str, options: StoryboardOptions, frames: &[StoryboardFrame]) -> Pixmap {
    let bytes = Storyboard::new(options).png(&puppet(), frames).unwrap();
    if let Ok(dir) = std::env::var("STORYBOARD_DIR") {
        std::fs::write(std::path::Path::new(&dir).join(name).with_extension("png"), &bytes).unwrap();
    }
    Pixmap::decode_png(&bytes).unwrap()
}

/// Pixels of a cell that pass.
fn count(picture: &Pixmap, cell: u32, cells: u32, test: impl Fn(i32, i32, i32) -> bool) -> usize {
    let width = picture.width() / cells;
    let rows = 0..picture.height();
    rows.flat_map(|y| (cell * width..(cell + 1) * width).map(move |x| (x, y)))
        .filter_map(|(x, y)| picture.pixel(x, y))
        .filter(|p| test(p.red().into(), p.green().into(), p.blue().into()))
        .count()
}

#[test]
fn every_cell_shows_both_sides_of_the_figure() {
    let options = StoryboardOptions { title: "Stroking, 16 links (puppet)".into(), ..Default::default() };
    let picture = draw("strip", options, &stroke(49));
    assert_eq!((picture.width(), picture.height()), (1920, 560));
    for cell in 0..8 {
        let blue = count(&picture, cell, 8, |r, _, b| b > r + 70 && b > 120);
        let orange = count(&picture, cell, 8, |r, _, b| r > b + 70 && r > 120);
        assert!(blue > 500 && orange > 500, "cell {cell}: {blue} pixels of the left limbs, {orange} of the right");
    }
}

#[test]
fn contacts_are_marked_only_where_something_touches() {
    let options = || StoryboardOptions { width: 600, height: 300, frames: 3, path_band: false, ..Default::default() };
    let red = |r: i32, g: i32, b: i32| r > 180 && g < 80 && b < 130;
    let mut frames = stroke(3);
    assert!(count(&draw("touch", options(), &frames), 0, 3, red) > 10);
    frames.iter_mut().for_each(|f| f.contacts.clear());
    assert_eq!(count(&draw("flight", options(), &frames), 0, 3, red), 0);
}

#[test]
fn all_views_can_be_drawn() {
    let frames = stroke(30);
    let scenery = vec![bevy_athlete::model::Shape::Box {
        center: DVec3::new(0.6, 0.1, -2.0),
        half_extents: DVec3::new(0.2, 0.1, 0.4),
        rotation: DQuat::IDENTITY,
    }];
    for (name, options) in [
        ("front", StoryboardOptions { azimuth: 1.2, ground: Ground::Floor, ..Default::default() }),
        ("fixed", StoryboardOptions { follow: Follow::Fixed, frames: 4, scenery, ..Default::default() }),
        ("world", StoryboardOptions { heading: Heading::World, elevation: 0.6, frames: 5, ..Default::default() }),
        ("small", StoryboardOptions { width: 64, height: 64, frames: 64, ..Default::default() }),
        ("flat", StoryboardOptions { elevation: 0.0, azimuth: 0.0, path_band: false, ..Default::default() }),
    ] {
        let picture = draw(name, options, &frames);
        assert!(count(&picture, 0, 1, |r, _, b| (r - b).abs() > 70) > 10, "{name}");
    }
}

#[test]
fn the_same_frames_give_the_same_bytes() {
    let storyboard = Storyboard::new(StoryboardOptions { width: 400, height: 200, frames: 3, ..Default::default() });
    let frames = stroke(7);
    assert_eq!(storyboard.png(&puppet(), &frames).unwrap(), storyboard.png(&puppet(), &frames).unwrap());
}

#[test]
fn bad_input_is_refused_by_name() {
    let storyboard = Storyboard::default();
    let model = puppet();
    let message = |frames: &[StoryboardFrame]| storyboard.png(&model, frames).unwrap_err().to_string();
    assert!(message(&[]).contains("at least one frame"));
    let mut frames = stroke(2);
    frames[1].links[3].position.y = f64::NAN;
    assert!(message(&frames).contains("frame 1") && message(&frames).contains("links"));
    frames[1].links.pop();
    assert!(message(&frames).contains("14 links"), "{}", message(&frames));
    let error = Storyboard::new(StoryboardOptions { frames: 0, ..Default::default() }).png(&model, &stroke(2));
    assert!(error.unwrap_err().to_string().contains("1 to 64"));
}
