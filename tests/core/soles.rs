//! Contract: a sole is what a file says it is: higher by its thickness, larger by its margins, heavier by its mass, of its friction; and
//! a body with shoes stands.
//!
//! Judged by the model's own numbers in the zero pose, by the distance in which a sliding shoe stops, and in the simulator under the
//! balance controller, on feet of five segments, of two and with single toes. Each refusal names foot, field and value.

use bevy_athlete::asset::Character;
use bevy_athlete::cli::feet::{Disturbance, Episode, StancePose, run_episode};
use bevy_athlete::contact::{Surface, World};
use bevy_athlete::control::foot::BasicPose;
use bevy_athlete::model::{CharacterModel, SharedModel, preset, preset_source};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use glam::DVec3;
use std::sync::Arc;

const SHOE: &str = "thickness: 0.025, front: 0.012, rear: 0.01, side: 0.006, friction: 0.9, mass: 0.3";
const STANDING_FEET: [&str; 3] = ["foot_human", "two_segment_human", "toes_human"];

/// A preset whose feet have this sole.
fn with_sole(name: &str, sole: &str) -> Result<CharacterModel, String> {
    let (file, text) = preset_source(name).unwrap();
    assert!(text.contains("kind: Sole,"), "{name} has no feet to edit");
    let edited = text.replace("kind: Sole,", &format!("kind: Sole, sole: ({sole}),"));
    let character = Character::parse(file, edited.as_bytes()).map_err(|e| e.to_string())?;
    CharacterModel::build(&character).map_err(|e| e.to_string())
}

/// The lowest points of a foot in the zero pose (m above the lowest of them all), by name, with the rectangle of their discs.
fn soles(model: &CharacterModel, foot: usize) -> (Vec<(String, DVec3)>, DVec3, DVec3) {
    let rest = model.rest_positions();
    let places = |p: usize| {
        let point = &model.contact_points[p];
        (point.name.clone(), rest[point.link] + point.position, point.radius)
    };
    let all: Vec<_> = model.foot_points(&model.feet()[foot]).map(places).collect();
    let floor = all.iter().map(|(_, at, r)| at.y - r).fold(f64::INFINITY, f64::min);
    let low: Vec<_> = all.into_iter().filter(|(_, at, r)| at.y - r < floor + 1e-3).collect();
    let from = low.iter().map(|(_, at, r)| *at - *r).fold(DVec3::INFINITY, DVec3::min);
    let to = low.iter().map(|(_, at, r)| *at + *r).fold(DVec3::NEG_INFINITY, DVec3::max);
    (low.into_iter().map(|(name, at, _)| (name, at)).collect(), from, to)
}

#[test]
fn a_sole_raises_enlarges_and_weighs() {
    for name in STANDING_FEET {
        let (bare, shod) = (preset(name).unwrap(), with_sole(name, SHOE).unwrap());
        assert!((shod.mass() - bare.mass() - 0.6).abs() < 1e-9, "{name} weighs {} kg", shod.mass());
        let raised = shod.rest_root_height() - bare.rest_root_height();
        assert!((raised - 0.025).abs() < 1e-9, "{name} stands {raised} m higher");
        for foot in 0..2 {
            let ((a, low, high), (b, shod_low, shod_high)) = (soles(&bare, foot), soles(&shod, foot));
            assert_eq!(
                a.iter().map(|p| &p.0).collect::<Vec<_>>(),
                b.iter().map(|p| &p.0).collect::<Vec<_>>(),
                "{name}"
            );
            let grown = [low.x - shod_low.x, shod_high.x - high.x, low.z - shod_low.z, shod_high.z - high.z];
            for (side, wanted) in grown.into_iter().zip([0.006, 0.006, 0.012, 0.01]) {
                assert!((side - wanted).abs() < 1e-9, "{name}: {grown:?}");
            }
        }
        // Above the soles nothing moves, and what is no longer bare has the sole's friction.
        let mut covered = 0;
        for (a, b) in bare.contact_points.iter().zip(&shod.contact_points) {
            if a.position == b.position {
                assert_eq!(a.friction, b.friction);
            } else {
                covered += 1;
                assert_eq!(b.friction, 0.9, "{}", b.name);
            }
        }
        assert!(covered >= 16, "{name}: {covered} points covered");
        // The slabs lie between the foot and the ground.
        let rest = shod.rest_positions();
        for (l, (a, b)) in bare.links.iter().zip(&shod.links).enumerate() {
            assert_eq!(b.shapes.len() - a.shapes.len(), usize::from(b.mass > a.mass), "{}", b.name);
            for shape in &b.shapes[a.shapes.len()..] {
                let bevy_athlete::model::Shape::Box { center, half_extents, .. } = *shape else {
                    panic!("a slab is a box")
                };
                let bottom = rest[l].y + center.y - half_extents.y + shod.rest_root_height();
                assert!(bottom.abs() < 1e-9 && (half_extents.y - 0.0125).abs() < 1e-9, "{}: {bottom}", b.name);
            }
        }
    }
}

/// The body's inertia grows by that of the slab: a block on a sole of its own size, by hand.
#[test]
fn a_slab_weighs_as_a_box_does() {
    let shoe = |sole: &str| {
        let text = format!(
            "(name: \"last\", step_rate: 2000.0, gains: (kp: 0.0, kd: 0.0), links: [(name: \"last\", joint: Free, position: (0.0, 0.1, 0.0), \
             mass: 2.0, shapes: [Box(center: (0.0, 0.0, 0.0), size: (0.1, 0.08, 0.3))])], contact_points: [{}], \
             feet: [(kind: Sole, links: [\"last\"]{sole})])",
            [(-0.04, -0.14), (0.04, -0.14), (-0.04, 0.14), (0.04, 0.14)]
                .iter()
                .enumerate()
                .map(|(k, (x, z))| format!(
                    "(name: \"p{k}\", link: \"last\", position: ({x:?}, -0.03, {z:?}), radius: 0.01)"
                ))
                .collect::<Vec<_>>()
                .join(", ")
        );
        CharacterModel::build(&Character::parse("last", text.as_bytes()).unwrap()).unwrap()
    };
    let (bare, shod) = (shoe(""), shoe(", sole: (thickness: 0.04, friction: 0.3, mass: 0.5)"));
    let (a, b) = (&bare.links[0], &shod.links[0]);
    // Slab: 0.1 x 0.04 x 0.3 m, its centre 0.06 m below that of the block.
    let com = -0.06 * 0.5 / 2.5;
    assert!((b.com - DVec3::Y * com).length() < 1e-12, "{}", b.com);
    let steiner = 2.0 * com * com + 0.5 * (0.06 + com).powi(2);
    let across = a.inertia.x_axis.x + 0.5 / 12.0 * (0.04f64.powi(2) + 0.3f64.powi(2)) + steiner;
    let up = a.inertia.y_axis.y + 0.5 / 12.0 * (0.1f64.powi(2) + 0.3f64.powi(2));
    assert!((b.inertia.x_axis.x - across).abs() < 1e-12 && (b.inertia.y_axis.y - up).abs() < 1e-12);

    // It stops after v^2 / (2 mu g).
    for (model, friction) in [(bare, 1.0), (shod, 0.3)] {
        let surface = Surface { friction: 0.8, ..Surface::GROUND };
        let mut sim = Simulator::<f64>::new(Arc::new(model.clone()), SimulationSettings::of(&model));
        sim.state.root_velocity.linear.z = -1.0;
        sim.state_changed();
        let start = sim.state.root_position.lane(0);
        assert!((start.y - model.rest_root_height()).abs() < 1e-12);
        for _ in 0..2000 {
            step(&mut sim, &World::plane(surface));
        }
        let way = start.z - sim.state.root_position.lane(0).z;
        let expected = 1.0 / (2.0 * 0.8 * friction * 9.81);
        println!("factor {friction}: stops after {way:.4} m, Coulomb says {expected:.4} m (allowed 2 %)");
        assert!((way - expected).abs() < 0.02 * expected);
    }
}

#[test]
fn bodies_with_shoes_stand() {
    for name in STANDING_FEET {
        let model: SharedModel = Arc::new(with_sole(name, SHOE).unwrap());
        let tiptoe = StancePose::Basic(BasicPose::Tiptoe);
        for (stance, seconds) in [(StancePose::Basic(BasicPose::Rest), 5.0), (tiptoe, 9.0)] {
            let returns = stance == tiptoe;
            let episode = Episode { stance, returns, ..Episode::standing(Disturbance::None, seconds) };
            let result = run_episode(&model, &episode, 1, 0.0).unwrap();
            assert!(result.held(), "{name} fell in {stance:?} at {:?}", result.fell_at);
        }
    }
}

#[test]
fn wrong_soles_are_refused_by_field() {
    let cases = [
        ("thickness: 0.0, mass: 0.3", "sole thickness is 0.0", "from 0.001 to 0.2 m"),
        ("thickness: NaN, mass: 0.3", "sole thickness is NaN", "from 0.001 to 0.2 m"),
        ("thickness: 0.02, front: -0.01, mass: 0.3", "sole front is -0.01", "from 0 to 0.1 m"),
        ("thickness: 0.02, rear: 0.5, mass: 0.3", "sole rear is 0.5", "from 0 to 0.1 m"),
        ("thickness: 0.02, side: inf, mass: 0.3", "sole side is inf", "from 0 to 0.1 m"),
        ("thickness: 0.02, friction: -1.0, mass: 0.3", "sole friction is -1.0", "from 0 to 10"),
        ("thickness: 0.02, mass: -0.3", "sole mass is -0.3", "from 0 to 10 kg"),
        ("thickness: 0.02", "mass", ""),
        ("thickness: 0.02, mass: 0.3, heel: 0.1", "heel", "thickness"),
    ];
    for (sole, field, valid) in cases {
        let message = with_sole("foot_human", sole).unwrap_err();
        assert!(message.contains(field) && message.contains(valid), "`{sole}` says `{message}`");
        assert!(
            message.contains("foot `1`") || message.contains("foot_human.character.ron:"),
            "`{sole}` says `{message}`"
        );
    }
    let (file, text) = preset_source("skater").unwrap();
    let edited = text.replace("kind: Blade(\"left\"),", "kind: Blade(\"left\"), sole: (thickness: 0.02, mass: 0.3),");
    assert_ne!(text, edited);
    let message = Character::parse(file, edited.as_bytes()).unwrap_err().to_string();
    assert!(message.contains("foot `1`") && message.contains("sole") && message.contains("blade"), "{message}");
}
