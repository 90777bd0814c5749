//! Contract: a character says what its feet, hands and trunk are, and a character that does not say it gets what its shape
//! tells, whatever its links are called.
//!
//! Proves: the parts of every preset, point by point (the points on which an athlete has fallen are those that skills were
//! trained with); that leaving the fields out changes nothing on a preset but the hands; that renaming every link changes
//! nothing either, so that no name is looked at; the rules for one leg, and for blades of other names.

use bevy_athlete::asset::{Character, PointRole, Side};
use bevy_athlete::model::{self, CharacterModel, FootKind, PRESET_NAMES};
use bevy_athlete::skill::forbidden_points;

fn character(name: &str) -> Character {
    let (file, text) = model::preset_source(name).expect("a preset");
    Character::parse(file, text.as_bytes()).expect("valid")
}

fn names(model: &CharacterModel, points: impl IntoIterator<Item = usize>) -> Vec<String> {
    points.into_iter().map(|p| model.contact_points[p].name.clone()).collect()
}

/// Without feet, roles and trunk.
fn bare(mut character: Character) -> Character {
    character.feet.clear();
    character.trunk = None;
    character.contact_points.iter_mut().for_each(|p| p.role = None);
    character
}

/// What falls on the ground of the presets with shoulders, elbows, hands and knees, left before right.
const LIMBS: [&str; 8] = [
    "shoulder_left",
    "shoulder_right",
    "elbow_left",
    "elbow_right",
    "hand_left",
    "hand_right",
    "knee_left",
    "knee_right",
];

#[test]
fn the_points_of_a_fall_are_those_that_skills_were_trained_with() {
    let human =
        ["head", "chest_back", "chest_front", "pelvis_back", "pelvis_front", "hip_left", "hip_right"].as_slice();
    let skater = [
        "head_top",
        "head_front",
        "head_back",
        "spine_front",
        "spine_back",
        "pelvis_front",
        "pelvis_back",
        "hip_left",
        "hip_right",
    ]
    .as_slice();
    let runner = [
        "head",
        "nape",
        "upper_back_left",
        "upper_back_right",
        "middle_back",
        "lower_back",
        "chest_front",
        "abdomen_front",
        "buttock_left",
        "buttock_right",
        "pelvis_front",
        "hip_left",
        "hip_right",
    ]
    .as_slice();
    for (name, trunk) in [
        ("skater", skater),
        ("foot_human", human),
        ("two_segment_human", human),
        ("toes_human", human),
        ("runner", runner),
    ] {
        let model = model::preset(name).expect("a preset");
        let expected: Vec<&str> = trunk.iter().chain(&LIMBS).copied().collect();
        assert_eq!(names(&model, forbidden_points(&model)), expected, "{name}");
        assert_eq!(names(&model, model.points(PointRole::Hand)), ["hand_left", "hand_right"], "{name}");
        let all: usize =
            [PointRole::Foot, PointRole::Hand, PointRole::Body].map(|r| model.points(r).count()).iter().sum();
        assert_eq!(all, model.contact_points.len());
    }
}

#[test]
fn the_feet_and_the_trunk_of_the_presets() {
    let links = |model: &CharacterModel, list: &[usize]| -> Vec<String> {
        list.iter().map(|&l| model.links[l].name.clone()).collect()
    };
    for (name, feet, trunk, wide) in [
        ("skater", ["foot"].as_slice(), "spine", ["pelvis", "abdomen", "spine", "head"].as_slice()),
        (
            "foot_human",
            &["medial_metatarsal", "medial_phalanges", "lateral_metatarsal", "lateral_phalanges", "heel"],
            "chest",
            &["pelvis", "chest", "head"],
        ),
        ("two_segment_human", &["foot", "toes"], "chest", &["pelvis", "chest", "head"]),
        (
            "toes_human",
            &["medial_metatarsal", "toe1", "toe2", "toe3", "lateral_metatarsal", "toe4", "toe5", "heel"],
            "chest",
            &["pelvis", "chest", "head"],
        ),
        ("runner", &["foot"], "chest", &["pelvis", "abdomen", "chest", "head"]),
    ] {
        let model = model::preset(name).expect("a preset");
        assert_eq!(model.feet().len(), 2, "{name}");
        for side in [Side::Left, Side::Right] {
            let foot = model.foot(side).expect("a foot");
            let expected: Vec<String> = feet.iter().map(|f| format!("{f}_{}", side.name())).collect();
            assert_eq!(links(&model, &foot.links), expected, "{name}");
            let place = |p: usize| {
                let point = &model.contact_points[p];
                model.rest_positions()[point.link] + point.position
            };
            let (toe, heel) = (place(foot.toe), place(foot.heel));
            assert!(toe.z < heel.z - 0.15 && (toe.x < 0.0) == (side == Side::Left), "{name}: {toe} {heel}");
            assert_eq!(matches!(foot.kind, FootKind::Blade(_)), name == "skater");
            assert_eq!(model.blade_index(side).is_some(), name == "skater");
            assert!(model.foot_points(foot).all(|p| model.contact_points[p].role == PointRole::Foot));
        }
        assert_eq!(model.links[model.trunk()].name, trunk);
        let trunk: Vec<usize> = (0..model.links.len()).filter(|&l| model.trunk_links()[l]).collect();
        assert_eq!(links(&model, &trunk), wide, "{name}");
    }
}

#[test]
fn a_file_that_says_nothing_gets_the_same_parts_by_its_shape() {
    for name in PRESET_NAMES {
        let said = model::preset(name).expect("a preset");
        let found = CharacterModel::build(&bare(character(name))).expect("valid");
        assert_eq!(found.trunk, said.trunk, "{name}");
        for (a, b) in found.feet().iter().zip(said.feet()) {
            assert_eq!((a.side, a.kind, &a.links), (b.side, b.kind, &b.links), "{name}");
        }
        assert_eq!(found.feet().len(), said.feet().len());
        assert_eq!(forbidden_points(&found), forbidden_points(&said), "{name}");
        assert_eq!(found.trunk_links(), said.trunk_links(), "{name}");
    }
}

#[test]
fn names_of_links_do_not_matter() {
    for name in PRESET_NAMES {
        let plain = CharacterModel::build(&bare(character(name))).expect("valid");
        let mut renamed = bare(character(name));
        let place = |links: &[String], name: &str| format!("l{}", links.iter().position(|l| l == name).expect("known"));
        let old: Vec<String> = renamed.links.iter().map(|l| l.name.clone()).collect();
        for link in &mut renamed.links {
            link.name = place(&old, &link.name);
            link.parent = link.parent.as_ref().map(|p| place(&old, p));
        }
        renamed.contact_points.iter_mut().for_each(|p| p.link = place(&old, &p.link));
        renamed.blades.iter_mut().for_each(|b| b.link = place(&old, &b.link));
        renamed.grips.iter_mut().for_each(|g| g.link = place(&old, &g.link));
        for (a, b) in &mut renamed.no_collision {
            (*a, *b) = (place(&old, a), place(&old, b));
        }
        // Blades that are not called by a side are feet by their place.
        for (blade, other) in renamed.blades.iter_mut().zip(["a", "b"]) {
            blade.name = other.into();
        }
        let renamed = CharacterModel::build(&renamed).expect("valid");
        assert_eq!(renamed.trunk, plain.trunk, "{name}");
        assert_eq!(renamed.feet, plain.feet, "{name}");
        assert_eq!(forbidden_points(&renamed), forbidden_points(&plain), "{name}");
    }
}

/// One leg in the middle with a foot welded on, and a tail of two links.
const HOPPER: &str = r#"(
    name: "hopper", step_rate: 1200.0, gains: (kp: 600.0, kd: 49.0),
    links: [
        (name: "a", joint: Free, position: (0.0, 0.8, 0.0), mass: 10.0, shapes: [Sphere(center: (0.0, 0.0, 0.0), radius: 0.1)]),
        (name: "b", parent: "a", joint: Ball, position: (0.0, 0.75, 0.0), mass: 6.0, shapes: [Sphere(center: (0.0, -0.3, 0.0), radius: 0.05)]),
        (name: "c", parent: "b", joint: Weld, position: (0.0, 0.05, 0.0), mass: 1.0, shapes: [Sphere(center: (0.0, 0.0, 0.0), radius: 0.05)]),
        (name: "d", parent: "a", joint: Ball, position: (0.0, 0.9, 0.1), mass: 1.0, shapes: [Sphere(center: (0.0, 0.0, 0.1), radius: 0.05)]),
        (name: "e", parent: "d", joint: Ball, position: (0.0, 0.9, 0.3), mass: 1.0, shapes: [Sphere(center: (0.0, 0.0, 0.1), radius: 0.05)]),
    ],
    contact_points: [
        (name: "front", link: "c", position: (0.0, -0.03, -0.16), radius: 0.02),
        (name: "rear", link: "c", position: (0.0, -0.03, 0.06), radius: 0.02),
        (name: "side", link: "a", position: (0.1, 0.0, 0.0), radius: 0.02),
    ],
)"#;

#[test]
fn one_leg_is_a_foot_on_no_side() {
    let hopper = Character::parse("hopper", HOPPER.as_bytes()).expect("valid");
    let model = CharacterModel::build(&hopper).expect("valid");
    let [foot] = model.feet() else { panic!("{:?}", model.feet()) };
    assert_eq!((foot.side, foot.kind, foot.links.as_slice()), (None, FootKind::Sole, [1].as_slice()));
    assert_eq!(names(&model, [foot.toe, foot.heel]), ["front", "rear"]);
    assert_eq!((model.foot(Side::Left), model.foot(Side::Right)), (None, None));
    assert_eq!(names(&model, forbidden_points(&model)), ["side"]);
    assert_eq!(model.trunk(), 3, "the way up is the tail's two links");

    // A role that is said decides, and a foot that is named by a welded link is the link that carries it.
    let said = HOPPER
        .replace("(0.1, 0.0, 0.0), radius: 0.02", "(0.1, 0.0, 0.0), radius: 0.02, role: Hand")
        .replace("\n)", r#" trunk: "a", feet: [(kind: Sole, links: ["c"])])"#);
    let model = CharacterModel::build(&Character::parse("hopper", said.as_bytes()).expect("valid")).expect("valid");
    assert_eq!(model.feet()[0].links, [1]);
    assert_eq!((names(&model, model.points(PointRole::Hand)), model.trunk()), (vec!["side".to_owned()], 0));
}

#[test]
fn a_model_made_in_code_finds_its_parts() {
    for name in PRESET_NAMES {
        let said = model::preset(name).expect("a preset");
        let mut made = (*said).clone();
        made.feet.clear();
        made.trunk = 0;
        made.contact_points.iter_mut().for_each(|p| p.role = PointRole::Body);
        made.find_parts();
        assert_eq!(forbidden_points(&made), forbidden_points(&said));
        assert_eq!(made.trunk, said.trunk);
    }
}
