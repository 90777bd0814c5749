//! The character files that ship are the bodies they claim to be.
//!
//! Proves: total mass, degrees of freedom and height of every preset; left and right mirror each other exactly in masses,
//! inertias, joints, limits and contact points; the foot human's feet are built by the rules of Park, Yu, Lee 2018; a
//! model loses nothing of its file (welds merged by the theorem of parallel axes, a written file reads back equal).
//! Totals alone would not do: a foot with its bones in the wrong segment, or an arm mirrored the wrong way, has the same
//! mass and height. The refusals are in `character_refusals.rs`.

use bevy_athlete::asset::Character;
use bevy_athlete::model::{self, CharacterModel, ContactKind, JointKind, Link, PRESET_NAMES, Shape};
use glam::{DMat3, DVec3};

/// Name, degrees of freedom, mass in kg and height in m.
const TOTALS: [(&str, usize, f64, f64); 5] = [
    ("skater", 57, 50.069, 1.4971),
    ("foot_human", 66, 48.5, 1.5),
    ("two_segment_human", 44, 48.5, 1.5),
    ("toes_human", 84, 48.5, 1.5),
    ("runner", 45, 68.0, 1.7),
];

fn preset(name: &str) -> std::sync::Arc<CharacterModel> {
    model::preset(name).expect("a preset")
}

/// Lowest and highest point of the solids, character frame, m.
fn extent(model: &CharacterModel, keep: impl Fn(&Link, &Shape) -> bool) -> (f64, f64) {
    let rest = model.rest_positions();
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (link, at) in model.links.iter().zip(&rest) {
        for shape in link.shapes.iter().filter(|s| keep(link, s)) {
            let (bottom, top) = match *shape {
                Shape::Box { center, half_extents, rotation } => {
                    let reach = (rotation.conjugate() * DVec3::Y).abs().dot(half_extents);
                    (center.y - reach, center.y + reach)
                }
                Shape::Capsule { a, b, radius } => (a.y.min(b.y) - radius, a.y.max(b.y) + radius),
                Shape::Sphere { center, radius } => (center.y - radius, center.y + radius),
            };
            (low, high) = (low.min(at.y + bottom), high.max(at.y + top));
        }
    }
    (low, high)
}

#[test]
fn totals_are_those_of_the_papers() {
    for (name, dof, mass, height) in TOTALS {
        let model = preset(name);
        // The skater's height is that of the person: the blades (boxes 5 mm wide) come on top.
        let blade = |s: &Shape| matches!(s, Shape::Box { half_extents, .. } if half_extents.x < 0.003);
        let (low, high) = extent(&model, |_, s| !blade(s));
        println!(
            "{name}: {} links, {} DoF, mass off by {:.1e} kg (allowed 1e-3), height off by {:.1e} m (allowed 1e-3), \
             {} contact points, {} collision pairs",
            model.links.len(),
            model.dof(),
            model.mass() - mass,
            high - low - height,
            model.contact_points.len(),
            model.collision_pairs.len()
        );
        assert_eq!(model.dof(), dof, "{name}");
        assert!((model.mass() - mass).abs() < 1e-3, "{name} weighs {}", model.mass());
        assert!((high - low - height).abs() < 1e-3, "{name} is {} m high", high - low);
    }
    assert_eq!(TOTALS.map(|t| t.0), PRESET_NAMES);
    assert_eq!(TOTALS.map(|t| preset(t.0).step_rate), [1200.0, 1800.0, 1800.0, 1800.0, 2000.0]);
}

#[test]
fn links_are_depth_first_and_bodies_possible() {
    for name in PRESET_NAMES {
        let model = preset(name);
        assert_eq!(model.links[0].joint, JointKind::Free);
        for (i, link) in model.links.iter().enumerate().skip(1) {
            // Depth-first: the parent is the previous link or one of its ancestors.
            let mut at = Some(i - 1);
            while at.is_some() && at != link.parent {
                at = model.links[at.expect("some")].parent;
            }
            assert!(at.is_some(), "{name}: {} comes before its parent", link.name);
            assert!(link.max_torque.is_finite() && link.limits.is_some() && link.gains.kp > 0.0, "{}", link.name);
        }
        // No link's mass lies farther from its centre, on average, than a limb is long.
        for link in &model.links {
            let trace = link.inertia.x_axis.x + link.inertia.y_axis.y + link.inertia.z_axis.z;
            let gyration = (trace / 2.0 / link.mass).sqrt();
            assert!((0.005..0.2).contains(&gyration), "{name}: {} has {gyration} m", link.name);
        }
        for &(a, b) in &model.collision_pairs {
            assert!(a < b && model.links[b].parent != Some(a), "{name}: {a} {b}");
        }
        // Standing, the lowest contact sphere or blade end is the lowest point of the whole body.
        let (low, _) = extent(&model, |_, _| true);
        let gap = model.rest_root_height() + low;
        println!("{name}: solids reach {gap:.1e} m below the lowest contact point (allowed 1e-6)");
        assert!(gap.abs() < 1e-6);
    }
}

#[test]
fn at_rest_the_centre_of_mass_is_above_the_feet() {
    for name in PRESET_NAMES {
        let model = preset(name);
        let rest = model.rest_positions();
        let com: DVec3 = model.links.iter().zip(&rest).map(|(l, at)| (*at + l.com) * l.mass).sum();
        let com = com / model.mass();
        let floor = -model.rest_root_height();
        let places = model.contact_points.iter().map(|p| (rest[p.link] + p.position, p.radius));
        let support: Vec<f64> = places.filter(|(p, r)| p.y - r < floor + 1e-4).map(|(p, _)| p.z).collect();
        let (front, back) = support.iter().fold((0.0f64, 0.0f64), |(f, b), z| (f.min(*z), b.max(*z)));
        println!(
            "{name}: centre of mass {:.3} m high, at z {:.4} between {front:.3} and {back:.3} m",
            com.y - floor,
            com.z
        );
        assert!(com.x.abs() < 1e-12 && front + 0.03 < com.z && com.z < back - 0.03, "{name}");
        assert!((0.5..0.62).contains(&((com.y - floor) / TOTALS.iter().find(|t| t.0 == name).expect("listed").3)));
    }
}

/// The name of the other side.
fn mirrored(name: &str) -> String {
    let swap = |a: &str, b: &str| name.contains(a).then(|| name.replace(a, b));
    swap("left", "right").or_else(|| swap("right", "left")).unwrap_or_else(|| name.to_owned())
}

#[test]
fn left_mirrors_right() {
    let flip = |v: DVec3| DVec3::new(-v.x, v.y, v.z);
    let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    let mut worst = 0.0f64;
    for name in PRESET_NAMES {
        let model = preset(name);
        let rest = model.rest_positions();
        for (i, link) in model.links.iter().enumerate() {
            let j = model.link_index(&mirrored(&link.name)).expect("the other side");
            let other = &model.links[j];
            let inertia = mirror * link.inertia * mirror - other.inertia;
            let scale = link.inertia.x_axis.length();
            let off = [
                (rest[i] - flip(rest[j])).length(),
                (link.com - flip(other.com)).length(),
                (link.mass - other.mass).abs(),
                inertia.x_axis.length().max(inertia.y_axis.length()).max(inertia.z_axis.length()) / scale,
            ];
            worst = off.iter().fold(worst, |a, b| a.max(*b));
            assert_eq!((link.gains, link.max_torque), (other.gains, other.max_torque), "{}", link.name);
            let (Some(a), Some(b)) = (link.limits, other.limits) else { continue };
            if i == j {
                // A joint on the midline turns and leans equally far to both sides.
                assert_eq!((a.low.y, a.low.z), (-a.high.y, -a.high.z), "{}", link.name);
            } else {
                assert_eq!((a.low.x, a.high.x), (b.low.x, b.high.x), "{}", link.name);
                assert_eq!((a.low.y, a.high.y, a.low.z, a.high.z), (-b.high.y, -b.low.y, -b.high.z, -b.low.z));
            }
        }
        for point in &model.contact_points {
            let other = model.contact_points.iter().find(|p| p.name == mirrored(&point.name)).expect("the other side");
            assert_eq!(model.links[other.link].name, mirrored(&model.links[point.link].name));
            worst = worst.max((point.position - flip(other.position)).length()).max(point.radius - other.radius);
        }
        assert_eq!(model.grips.len(), 2, "{name} has a grip on each hand");
    }
    println!("worst difference of the sides: {worst:.1e} (allowed 1e-9)");
    assert!(worst < 1e-9);
}

#[test]
fn knees_bend_backwards_only_and_elbows_forwards() {
    for name in PRESET_NAMES {
        let model = preset(name);
        let range = |link: &str| {
            let limits = model.links[model.link_index(link).expect("a link")].limits.expect("limits");
            (limits.low.x.to_degrees(), limits.high.x.to_degrees())
        };
        for side in ["left", "right"] {
            // Turning by -90 degrees about +X carries the foot from under the knee to behind it (+Z).
            let foot = glam::DQuat::from_rotation_x(-core::f64::consts::FRAC_PI_2) * DVec3::NEG_Y;
            assert!(foot.z > 0.99);
            let (low, high) = range(&format!("shin_{side}"));
            assert!(low < -130.0 && high <= 8.0 + 1e-9, "{name} knee {low} to {high}");
            let (low, high) = range(&format!("forearm_{side}"));
            assert!(low >= -15.0 - 1e-9 && high > 120.0, "{name} elbow {low} to {high}");
        }
    }
}

#[test]
fn the_skater_stands_on_two_blades() {
    let model = preset("skater");
    assert_eq!(model.blades.len(), 2);
    for (index, blade) in model.blades.iter().enumerate() {
        let (toe, heel) = (&model.contact_points[blade.toe], &model.contact_points[blade.heel]);
        assert_eq!((toe.kind, heel.kind), (ContactKind::BladeToe(index), ContactKind::BladeHeel(index)));
        assert_eq!((toe.radius, heel.radius), (0.0, 0.0));
        let along = toe.position - heel.position;
        assert!((along - DVec3::new(0.0, 0.0, -0.208)).length() < 1e-12, "toes point forward: {along}");
        // Inside is towards the midline.
        assert_eq!(blade.inside.x, -model.rest_positions()[blade.link].x.signum());
        assert_eq!(model.links[blade.link].name, format!("foot_{}", blade.name));
        let below = -model.rest_positions()[blade.link].y - toe.position.y;
        assert!((below - 0.90614).abs() < 1e-9, "blade ends {below} m below the pelvis");
    }
}

#[test]
fn a_weld_adds_mass_by_parallel_axes() {
    // Boot and blade box of the skater, 54 mm apart, one kilogram each: computed here on its own, term by term.
    let model = preset("skater");
    let foot = &model.links[model.link_index("foot_left").expect("a foot")];
    let m = 1.0831;
    let cuboid = |x: f64, y: f64, z: f64| DVec3::new(y * y + z * z, x * x + z * z, x * x + y * y) * (m / 12.0);
    let parallel = DVec3::new(1.0, 0.0, 1.0) * (2.0 * m * 0.027 * 0.027);
    let expected = cuboid(0.108, 0.054, 0.208) + cuboid(0.005, 0.054, 0.208) + parallel;
    let off =
        (foot.inertia - DMat3::from_diagonal(expected)).to_cols_array().iter().fold(0.0f64, |a, b| a.max(b.abs()));
    let com = (foot.com - DVec3::new(0.0, -0.0486, -0.0216)).length();
    println!("welded foot: inertia off by {off:.1e} kg m^2 (allowed 1e-15), centre by {com:.1e} m (allowed 1e-12)");
    assert!(off < 1e-15 && com < 1e-12 && (foot.mass - 2.0 * m).abs() < 1e-12);
}

#[test]
fn feet_follow_the_rules_of_the_multi_segment_foot() {
    let model = preset("foot_human");
    let rest = model.rest_positions();
    let mut standing = 0;
    for side in ["left", "right"] {
        let segments = ["medial_metatarsal", "medial_phalanges", "lateral_metatarsal", "lateral_phalanges", "heel"];
        let links = segments.map(|s| model.link_index(&format!("{s}_{side}")).expect("a segment"));
        let parent = |i: usize| model.links[model.links[links[i]].parent.expect("a parent")].name.clone();
        assert_eq!(parent(0), format!("shin_{side}"));
        assert_eq!([parent(1), parent(2), parent(4)], [0; 3].map(|_| format!("medial_metatarsal_{side}")));
        assert_eq!(parent(3), format!("lateral_metatarsal_{side}"));
        assert!(links.iter().all(|&l| model.links[l].joint == JointKind::Ball));

        // 16 capsules of one radius: 7 (three metatarsals, four tarsals), 3, 2, 2 and 2.
        let mut ends = Vec::new();
        let counts = links.map(|l| model.links[l].shapes.len());
        assert_eq!(counts, [7, 3, 2, 2, 2]);
        for &link in &links {
            for shape in &model.links[link].shapes {
                let Shape::Capsule { a, b, radius } = *shape else { panic!("a bone is a capsule") };
                assert_eq!(radius, 0.01);
                ends.extend([rest[link] + a, rest[link] + b]);
            }
        }

        // Contact only at the ends of bones, and one sphere where bones share an end.
        let points: Vec<_> = model.contact_points.iter().filter(|p| links.contains(&p.link)).collect();
        let place = |p: &model::ContactPoint| rest[p.link] + p.position;
        for point in &points {
            assert_eq!((point.radius, point.kind), (0.01, ContactKind::Point));
            assert!(ends.iter().any(|e| (*e - place(point)).length() < 1e-9), "{} is at no end", point.name);
        }
        for end in &ends {
            let here = points.iter().filter(|p| (*end - place(p)).length() < 1e-3).count();
            assert_eq!(here, 1, "one sphere at the end {end}");
        }

        // At rest the four touching segments have three spheres or more on one height, the arch none.
        let floor = -model.rest_root_height();
        let touching: Vec<_> = points.iter().filter(|p| place(p).y - p.radius < floor + 1e-4).collect();
        let on = links.map(|l| touching.iter().filter(|p| p.link == l).count());
        assert_eq!(on, [0, 6, 3, 3, 4], "touching points per segment of the {side} foot");
        let toes = touching.iter().filter(|p| p.name.contains("_tip_") || p.name.contains("_head_")).count();
        assert_eq!(toes, 10, "points in the toe area");
        standing += touching.len();
        let z = |p: &DVec3| p.z;
        let length = ends.iter().map(z).fold(f64::MIN, f64::max) - ends.iter().map(z).fold(f64::MAX, f64::min) + 0.02;
        println!("{side} foot: length {length:.4} m (0.21 to 0.22), touching points per segment {on:?}");
        assert!((0.21..=0.22).contains(&length));
    }
    assert!(standing >= 28, "{standing} points touch when standing");
}

#[test]
fn the_two_humans_differ_only_in_their_feet() {
    let (many, two) = (preset("foot_human"), preset("two_segment_human"));
    let foot = |name: &str| ["foot", "toes", "medial", "lateral", "heel"].iter().any(|p| name.starts_with(p));
    let body = |m: &CharacterModel| -> Vec<(String, f64, DVec3, DMat3)> {
        let links = m.links.iter().filter(|l| !foot(&l.name));
        links.map(|l| (l.name.clone(), l.mass, l.offset, l.inertia)).collect()
    };
    assert_eq!(body(&many), body(&two));
    let hinges = two.links.iter().filter(|l| matches!(l.joint, JointKind::Hinge { .. })).count();
    assert_eq!(hinges, 2);
}

#[test]
fn a_written_file_reads_back_equal() {
    for name in PRESET_NAMES {
        let (file, text) = model::preset_source(name).expect("a source");
        let character = Character::parse(file, text.as_bytes()).expect("valid");
        let again = Character::parse(file, character.to_ron().expect("text").as_bytes()).expect("valid");
        assert_eq!(character, again);
    }
}

#[test]
fn a_character_file_is_found_beside_the_file_that_names_it() {
    let skill = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/characters/any.skill.ron");
    let found = Character::beside(&skill, "runner.character.ron");
    assert_eq!(Character::read(found).expect("beside it").name, "runner");
    // What does not lie there is a preset's name, or a path from the working folder.
    for name in ["runner", "nobody.character.ron"] {
        assert_eq!(Character::beside(&skill, name), name);
    }
}
