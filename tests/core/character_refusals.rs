//! A wrong character file is refused with a message that names the file, the link and the value, and says what would be
//! valid; no bytes whatever make the parser or the builder panic.
//!
//! Proves: each refusal by a small edit of a shipping file and by the words of its message; 3000 seeded mutations of bytes
//! and values of all shipping files. Checking only that an error comes back would not do: a typo in the schema would fail
//! every edited file for the same wrong reason.

use bevy_athlete::asset::{AssetError, Character};
use bevy_athlete::math::RandomStream;
use bevy_athlete::model::{self, CharacterModel, PRESET_NAMES};

fn source(name: &str) -> &'static str {
    model::preset_source(name).expect("a preset").1
}

/// The message for a shipping file with the first `from` replaced by `to`.
fn message(name: &str, from: &str, to: &str) -> String {
    let text = source(name);
    assert!(text.contains(from), "{name} has no `{from}` to edit");
    let edited = text.replacen(from, to, 1);
    let error = Character::parse("mine.ron", edited.as_bytes()).expect_err(&format!("`{from}` -> `{to}` is accepted"));
    error.to_string()
}

#[test]
fn each_refusal_names_file_place_and_value() {
    let thigh = "mass: 6.5709,\n            shapes: [Box(center: (0.0, -0.18605, 0.0)";
    let cases: &[(&str, &str, &[&str])] = &[
        // The tree.
        (r#"parent: "pelvis""#, r#"parent: "shin_left""#, &["`thigh_left`", "cycle", "shin_left -> thigh_left"]),
        (r#"parent: "pelvis""#, r#"parent: "thigh_left""#, &["`thigh_left`", "cycle"]),
        (r#"name: "thigh_right""#, r#"name: "thigh_left""#, &["`thigh_left`", "entries 2 and 6"]),
        (r#"parent: "pelvis""#, r#"parent: "hips""#, &["`thigh_left`", "`hips`", "one of pelvis, thigh_left"]),
        (r#"parent: "pelvis","#, "", &["2 links without a parent", "pelvis, thigh_left", "exactly one"]),
        ("joint: Free", r#"parent: "head", joint: Ball"#, &["cycle"]),
        ("joint: Free", "joint: Ball", &["`pelvis`", "joint is Ball", "Free for the root"]),
        ("joint: Ball", "joint: Free", &["`thigh_left`", "joint is Free", "Ball, Hinge or Weld"]),
        ("joint: Free", "joint: Weld", &["`pelvis`", "joint is Weld"]),
        (r#"name: "thigh_left""#, r#"name: """#, &["link ``", "name is \"\"", "1 to 64 letters"]),
        // Numbers.
        ("mass: 6.5709", "mass: 0.0", &["`thigh_left`", "mass is 0.0", "from 0.0001 to 1000 kg"]),
        ("mass: 6.5709", "mass: -6.5709", &["`thigh_left`", "mass is -6.5709"]),
        ("mass: 6.5709", "mass: 6570.9", &["`thigh_left`", "mass is 6570.9", "to 1000 kg"]),
        ("mass: 6.5709", "mass: NaN", &["`thigh_left`", "mass is NaN"]),
        ("mass: 6.5709", "mass: inf", &["`thigh_left`", "mass is inf"]),
        ("position: (-0.090728,", "position: (NaN,", &["`thigh_left`", "position is [NaN,", "three numbers"]),
        ("position: (-0.090728,", "position: (1e300,", &["`thigh_left`", "position is [1e300,"]),
        ("mass: 6.5709,", "mass: 6.5709, com: (0.0, -inf, 0.0),", &["`thigh_left`", "com is [0.0, -inf"]),
        ("size: (0.093025", "size: (0.0", &["`thigh_left`", "box size is [0.0,", "100 m"]),
        ("size: (0.093025", "size: (NaN", &["`thigh_left`", "box size is [NaN,"]),
        ("rotation: (0.0, 0.0, ", "rotation: (0.0, inf, ", &["`scapula_left`", "box rotation", "degrees"]),
        ("step_rate: 1200.0", "step_rate: 29.0", &["`skater`", "step_rate is 29.0", "from 30 to 20000/s"]),
        ("step_rate: 1200.0", "step_rate: NaN", &["`skater`", "step_rate is NaN"]),
        ("step_rate: 1200.0", "step_rate: 1e9", &["`skater`", "step_rate is 1000000000.0"]),
        ("kp: 600.0", "kp: -1.0", &["`skater`", "gains.kp is -1.0"]),
        ("kd: 49.0", "kd: NaN", &["`skater`", "gains.kd is NaN"]),
        ("max_torque: 220.0", "max_torque: 0.0", &["`thigh_left`", "max_torque is 0.0", "N m"]),
        ("joint: Weld,", "joint: Weld, max_torque: 5.0,", &["`blade_left`", "max_torque is 5.0", "nothing on a"]),
        ("max_torque: 220.0", "max_torque: 220.0, armature: -0.1", &["`thigh_left`", "armature is -0.1", "kg m^2"]),
        ("joint: Weld,", "joint: Weld, armature: 0.1,", &["`blade_left`", "armature is 0.1", "nothing on a"]),
        (
            "max_torque: 220.0",
            "max_torque: 220.0, spring: (stiffness: -1.0)",
            &["`thigh_left`", "spring stiffness is -1.0", "N m/rad"],
        ),
        (
            "max_torque: 220.0",
            "max_torque: 220.0, spring: (stiffness: 1.0, rest: (0.0, 200.0, 0.0))",
            &["`thigh_left`", "spring rest is [0.0, 200.0", "180 degrees"],
        ),
        (
            "joint: Weld,",
            "joint: Weld, spring: (stiffness: 1.0),",
            &["`blade_left`", "spring is (1.0, 0.0)", "nothing on a"],
        ),
        (
            "limits: (x: (-75.0, 135.0)",
            "limits: (x: (75.0, 35.0)",
            &["`thigh_left`", "limits.x is (75.0, 35.0)", "low <= high"],
        ),
        ("limits: (x: (-75.0, 135.0)", "limits: (x: (NaN, 35.0)", &["`thigh_left`", "limits.x is (NaN, 35.0)"]),
        ("limits: (x: (-75.0, 135.0)", "limits: (x: (-75.0, 500.0)", &["limits.x is (-75.0, 500.0)", "180 degrees"]),
        (
            "joint: Ball",
            "joint: Hinge(axis: (0.0, 0.0, 0.0))",
            &["`thigh_left`", "joint axis is [0.0, 0.0, 0.0]", "length 1"],
        ),
        ("joint: Ball", "joint: Hinge(axis: (NaN, 0.0, 1.0))", &["`thigh_left`", "joint axis is [NaN"]),
        // Inertias.
        (
            "mass: 6.5709,",
            "mass: 6.5709, inertia: (0.1, -0.1, 0.1, 0.0, 0.0, 0.0),",
            &["`thigh_left`", "-1.0000e-1", "all three positive"],
        ),
        (
            "mass: 6.5709,",
            "mass: 6.5709, inertia: (0.1, 0.1, 0.1, 0.2, 0.0, 0.0),",
            &["`thigh_left`", "principal moments (-1.0000e-1"],
        ),
        (
            "mass: 6.5709,",
            "mass: 6.5709, inertia: (0.1, 0.1, 0.3, 0.0, 0.0, 0.0),",
            &["`thigh_left`", "3.0000e-1", "sum of the other two"],
        ),
        (
            "mass: 6.5709,",
            "mass: 6.5709, inertia: (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),",
            &["`thigh_left`", "all three positive"],
        ),
        ("mass: 6.5709,", "mass: 6.5709, inertia: (0.1, 0.1, NaN, 0.0, 0.0, 0.0),", &["`thigh_left`", "NaN"]),
        (thigh, "mass: 6.5709,\n            shapes: [], no_shapes: [Box(center: (0.0, -0.18605, 0.0)", &["no_shapes"]),
        // What hangs on links.
        (r#"link: "foot_left""#, r#"link: "boot""#, &["blade `left`", "`boot`", "one of pelvis"]),
        (
            "inside: (1.0, 0.0, 0.0)",
            "inside: (0.0, 0.0, 1.0)",
            &["blade `left`", "inside is [0.0, 0.0, 1.0]", "across"],
        ),
        ("dead_zone: 15.0", "dead_zone: -1.0", &["blade `left`", "dead_zone is -1.0"]),
        ("bite: 4.0", "bite: NaN", &["blade `left`", "bite is NaN"]),
        (
            r#"name: "head_top", link: "head""#,
            r#"name: "head_top", link: "hat""#,
            &["contact point `head_top`", "`hat`"],
        ),
        (r#"name: "head_top""#, r#"name: "blade_left_toe""#, &["contact point `blade_left_toe`", "used once"]),
        (
            r#"name: "left_hand", link: "hand_left""#,
            r#"name: "left_hand", link: "paw""#,
            &["grip `left_hand`", "`paw`"],
        ),
        ("grips: [", r#"no_collision: [("head", "tail")], grips: ["#, &["no_collision pair `tail`"]),
        ("radius: 0.05", "radius: -0.05", &["contact point", "radius is -0.05"]),
        // Feet, roles and trunk.
        (r#"links: ["foot_left"]"#, r#"links: []"#, &["foot `1`", "links is []", "one or more links"]),
        (r#"links: ["foot_left"]"#, r#"links: ["boot"]"#, &["foot `1`", "link is `boot`", "one of pelvis"]),
        (r#"links: ["foot_right"]"#, r#"links: ["foot_left"]"#, &["foot `2`", "\"foot_left\"", "foot 1 has it"]),
        (r#"links: ["foot_right"]"#, r#"links: ["blade_left"]"#, &["foot `2`", "\"blade_left\"", "foot 1 has it"]),
        (
            r#"links: ["foot_left"]"#,
            r#"links: ["shin_left"]"#,
            &["foot `1`", "shin_left", "the blade's link, foot_left"],
        ),
        (r#"kind: Blade("left")"#, r#"kind: Blade("third")"#, &["foot `1`", "third", "one of left, right"]),
        (r#"kind: Blade("left")"#, "kind: Skate", &["mine.ron:", "Skate", "Sole"]),
        (r#"toe: "blade_left_toe""#, r#"toe: "hand_left""#, &["foot `1`", "toe is \"hand_left\"", "blade_left_toe"]),
        (r#"heel: "blade_left_heel""#, r#"heel: "tip""#, &["foot `1`", "heel is \"tip\"", "one of blade_left_toe"]),
        (r#"side: Left"#, r#"side: Middle"#, &["mine.ron:", "Middle", "Left"]),
        (r#"trunk: "spine""#, r#"trunk: "stem""#, &["trunk `stem`", "one of pelvis"]),
        ("radius: 0.05)", "radius: 0.05, role: Foot)", &["contact point `head_top`", "role is Foot", "Hand or Body"]),
        ("role: Hand", "role: Paw", &["mine.ron:", "Paw", "Hand"]),
        // The text.
        ("step_rate", "step_rat", &["mine.ron:", "step_rat", "step_rate"]),
        ("mass: 6.5709,", "", &["mine.ron:", "mass"]),
        ("joint: Ball", "joint: Slide", &["mine.ron:", "Slide", "Hinge"]),
    ];
    for (from, to, words) in cases {
        let message = message("skater", from, to);
        for word in ["mine.ron"].iter().chain(*words) {
            assert!(message.contains(word), "`{from}` -> `{to}` says `{message}`, without `{word}`");
        }
        // Only syntax errors may leave the valid value to the parser's own words.
        assert!(message.contains("valid: ") || message.starts_with("mine.ron:") && !message.starts_with("mine.ron: "));
    }
    println!("{} refusals, each with its words", cases.len());
}

#[test]
fn files_beyond_the_limits_are_refused() {
    let big = vec![b' '; Character::MAX_BYTES + 1];
    let error = Character::parse("big.ron", &big).expect_err("too large");
    assert!(matches!(error, AssetError::TooLarge { .. }) && error.to_string().contains("at most 1048576 bytes"));

    let error = Character::parse("text.ron", b"(name: \"\xff\")").expect_err("not text");
    assert_eq!(error.to_string(), "text.ron: byte 8 is not UTF-8 text");

    let error = Character::read("no/such/file.ron").expect_err("no file");
    assert!(error.to_string().starts_with("no/such/file.ron: cannot be read"));

    let deep = "(".repeat(100_000);
    assert!(Character::parse("deep.ron", deep.as_bytes()).is_err());

    let mut character = Character::parse("skater", source("skater").as_bytes()).expect("valid");
    let point = character.contact_points[0].clone();
    character.contact_points = vec![point; 257 - 2 * character.blades.len()];
    let error = CharacterModel::build(&character).expect_err("too many points");
    assert_eq!(error.to_string(), "skater: 257 contact points (blade ends included); valid: 0 to 256");

    character.contact_points.clear();
    let template = character.links[1].clone();
    for i in character.links.len()..129 {
        let mut link = template.clone();
        link.name = format!("extra_{i}");
        character.links.push(link);
    }
    let error = CharacterModel::build(&character).expect_err("too many links");
    assert_eq!(error.to_string(), "skater: 129 links; valid: 1 to 128");

    character.links.clear();
    let error = CharacterModel::build(&character).expect_err("no links");
    assert_eq!(error.to_string(), "skater: 0 links; valid: 1 to 128");
}

/// One random edit: of a byte, of a stretch of bytes, or of a number or a word.
fn mutate(text: &mut Vec<u8>, random: &mut RandomStream) {
    let at = random.below(text.len());
    match random.below(6) {
        0 => text[at] = random.bits() as u8,
        1 => drop(text.drain(at..(at + random.below(40)).min(text.len()))),
        2 => {
            let piece = text[at..(at + random.below(200)).min(text.len())].to_vec();
            let to = random.below(text.len());
            text.splice(to..to, piece);
        }
        // A number becomes another one.
        3 | 4 => {
            let digit = |b: &u8| b.is_ascii_digit() || matches!(b, b'-' | b'.');
            let Some(start) = text[at..].iter().position(digit).map(|i| at + i) else { return };
            let end = text[start..].iter().position(|b| !digit(b)).map_or(text.len(), |i| start + i);
            let values = ["0.0", "-1.0", "1e-300", "1e300", "-1e300", "NaN", "inf", "-inf", "1e-5", "180.0", "99.0"];
            text.splice(start..end, values[random.below(values.len())].bytes());
        }
        // A quoted name becomes another name of the file.
        _ => {
            let quotes: Vec<usize> = (0..text.len()).filter(|&i| text[i] == b'"').collect();
            if quotes.len() < 4 {
                return;
            }
            let pick = |random: &mut RandomStream| 2 * random.below(quotes.len() / 2);
            let (from, to) = (pick(random), pick(random));
            let name = text[quotes[from]..=quotes[from + 1]].to_vec();
            text.splice(quotes[to]..=quotes[to + 1], name);
        }
    }
}

#[test]
fn three_thousand_mutations_never_panic() {
    let (mut accepted, mut refused) = (0, 0);
    for seed in 0..3000 {
        let mut random = RandomStream::new(seed, 77);
        let mut text = source(PRESET_NAMES[random.below(PRESET_NAMES.len())]).as_bytes().to_vec();
        for _ in 0..1 + random.below(3) {
            mutate(&mut text, &mut random);
        }
        let built = Character::parse("mutated.ron", &text).map(|c| CharacterModel::build(&c).expect("validated"));
        match built {
            Ok(model) => {
                // What is accepted is usable: finite, and every index in range.
                accepted += 1;
                assert!(model.mass().is_finite() && model.rest_root_height().is_finite());
                for link in &model.links {
                    let det = link.inertia.determinant();
                    assert!(link.com.is_finite() && det.is_finite() && det > 0.0, "seed {seed}: {link:?}");
                }
                assert!(model.contact_points.iter().all(|p| p.link < model.links.len()));
            }
            Err(error) => {
                refused += 1;
                assert!(error.to_string().len() < 4000, "seed {seed}: {error}");
            }
        }
    }
    println!("3000 mutations: {accepted} accepted, {refused} refused, no panic");
    assert!(accepted > 100 && refused > 1000, "the mutations reach both sides");
}
