//! Contract: a course file becomes obstacles whose numbers follow from its parameters, the same in a lane of its own as alone.
//!
//! Proves: formulas by their values; each refusal by a small edit of a file and by the words of its message; every shipped file
//! reads back equal; a lane of a course terrain answers like the solids put into a world by themselves (which the tests of
//! geometry check), whatever its neighbours hold, so that looking at bounds first leaves nothing out; what moves does so as its
//! velocity says; drawing a lane anew allocates nothing. Checking single answers would not do: a solid that bounds leave out
//! is missed only in the lane and at the place that hide it.

use bevy_athlete::asset::course::{Formula, MotionInstance, Quantity};
use bevy_athlete::asset::{Course, CourseInstance};
use bevy_athlete::contact::{CourseLaneError, CourseTerrain, SupportHit, SurfaceHit, Terrain, World};
use bevy_athlete::math::{F32x8Fused, F64x4, RandomStream, Real, Vec3};
use glam::DVec3;
use std::sync::Arc;

const SHIPPED: [&str; 3] = ["vault_box", "bumps", "stairs"];

fn shipped(name: &str) -> Course {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/courses");
    Course::read(folder.join(format!("{name}.course.ron"))).expect("a course")
}

/// Everything a course can hold but bumps.
const FULL: &str = r#"(
    name: "full",
    parameters: [
        (name: "height", range: (0.4, 0.6), default: 0.5),
        (name: "far", range: (2.0, 6.0)),
    ],
    materials: [(name: "pole", grippable: true), (name: "wet_ice", carves: true)],
    ground: (material: "wet_ice", friction: 0.05),
    side_walls: "2 * height + 1",
    solids: [
        Box(ahead: "far", right: -0.5, yaw: 30, depth: 0.4, width: 2, height: "height", edge: true),
        Box(ahead: "far + 1.5", up: "0.5 * height", depth: 0.4, width: 2, height: 0.3,
            motion: Sway(along: (1, 0, 0), amplitude: 0.4, frequency: 0.5)),
        Rail(ahead: "far - 1", up: "height * 2", length: 1.6, radius: 0.03, material: "pole", friction: 1.1,
            motion: Cross(by: (0, 0.2, 1), speed: 0.5)),
        Box(ahead: "far + 3", depth: 1, width: 1, height: 0.2, motion: Jerk(by: (0, 0.3, 0), start: 0.5, seconds: 2)),
        Stairs(ahead: "far + 6", count: 3, tread: 0.3, rise: 0.15, width: 2),
        Ramp(ahead: "far + 9", yaw: -20, length: 2, width: 1.5, height: "height"),
        Gap(ahead: "far + 4.5", length: 0.7),
        Gap(ahead: "far + 12", length: "height"),
    ],
)"#;

/// Rough ground that is steeper or less steep, up or down.
const SLOPE: &str = r#"(
    name: "slope",
    parameters: [(name: "slope", range: (-8, 8), default: 5), (name: "roughness", range: (0, 0.02))],
    ground: (friction: 0.8, slope: "slope"),
    solids: [Bumps(ahead: 1, length: 6, width: 4, spacing: 0.3, amplitude: "roughness")],
)"#;

fn slope() -> Course {
    Course::parse("slope.course.ron", SLOPE.as_bytes()).expect("a course")
}

fn full() -> Course {
    Course::parse("full.course.ron", FULL.as_bytes()).expect("a course")
}

#[test]
fn formulas_are_sums_of_products() {
    let parameter = |name: &str| [("a", 2.0), ("b_1", -3.0)].into_iter().find(|p| p.0 == name).map(|p| p.1);
    for (text, value) in [
        ("0.5", 0.5),
        ("a", 2.0),
        ("-a", -2.0),
        (" a + 0.2 ", 2.2),
        ("a - b_1 - 1", 4.0),
        ("2 * a * b_1 + a*a", -8.0),
        ("-2*a+ .5", -3.5),
    ] {
        let formula = Formula::parse(text).expect(text);
        assert!((Quantity::Formula(formula).value(&parameter) - value).abs() < 1e-12, "{text}");
    }
    assert!(Quantity::Formula(Formula::parse("a + c").expect("one")).value(&parameter).is_nan());
    for (text, at) in
        [("", 1), ("a +", 4), ("a b", 3), ("a / 2", 3), ("(a)", 1), ("1.2.3", 1), ("a * * b", 5), ("2a", 2), ("é", 1)]
    {
        let error = Formula::parse(text).expect_err(text);
        assert_eq!(error.at, at, "{error}");
        assert!(error.to_string().contains("valid: "), "{error}");
    }
    assert!(Formula::parse(&"a+".repeat(150)).is_err());
}

#[test]
fn a_written_file_reads_back_equal() {
    for course in SHIPPED.map(shipped).into_iter().chain([full(), slope()]) {
        let text = course.to_ron().expect("text");
        assert_eq!(Course::parse(&course.file, text.as_bytes()).expect(&text), course);
    }
}

#[test]
fn each_refusal_names_file_place_and_value() {
    let cases: &[(&str, &str, &[&str])] = &[
        (r#"name: "full""#, r#"name: "a b""#, &["name is \"a b\"", "letters"]),
        ("range: (0.4, 0.6)", "range: (0.6, 0.4)", &["parameter `height`", "(0.6, 0.4)", "low <= high"]),
        ("range: (0.4, 0.6)", "range: (NaN, 0.6)", &["parameter `height`", "NaN"]),
        ("default: 0.5", "default: 0.7", &["parameter `height`", "default is 0.7", "from 0.4 to 0.6"]),
        (r#"(name: "far""#, r#"(name: "height""#, &["parameter `height` comes twice"]),
        (r#"(name: "pole""#, r#"(name: "wall""#, &["material `wall` comes twice"]),
        (
            r#""far - 1""#,
            r#""fare - 1""#,
            &["solid 3 (Rail)", "parameter `fare` is unknown", "one of height, far", "ahead"],
        ),
        (r#""far - 1""#, r#""far / 1""#, &["full.course.ron:", "far / 1", "no +, - or * at character 5"]),
        (r#""far - 1""#, "true", &["full.course.ron:", "a number or a formula in quotes"]),
        (
            r#"material: "pole""#,
            r#"material: "wood""#,
            &["solid 3 (Rail)", "material `wood` is unknown", "ground, ice, wall, rail, pole"],
        ),
        (r#"material: "wet_ice""#, r#"material: "snow""#, &["ground", "material `snow`"]),
        ("height: 0.3", "height: -0.3", &["solid 2 (Box)", "height is -0.3", "from 0.001 to 1000 m"]),
        (
            r#"height: "height", edge"#,
            r#"height: "height - 0.45", edge"#,
            &["solid 1 (Box)", "from \"height - 0.45\"", "height is -0.0"],
        ),
        ("yaw: 30", "yaw: 3000", &["solid 1 (Box)", "yaw is 3000", "degrees"]),
        ("friction: 1.1", "friction: inf", &["solid 3 (Rail)", "friction is inf"]),
        ("radius: 0.03", "radius: 0", &["solid 3 (Rail)", "radius is 0"]),
        ("frequency: 0.5", "frequency: 50", &["solid 2 (Box)", "frequency is 50", "Hz"]),
        ("along: (1, 0, 0)", "along: (0, 0, 0)", &["solid 2 (Box)", "along is nothing", "not all of them zero"]),
        ("speed: 0.5", "speed: 0", &["solid 3 (Rail)", "speed is 0"]),
        ("seconds: 2", "seconds: -2", &["solid 4 (Box)", "seconds is -2"]),
        ("count: 3", "count: 0", &["solid 5 (Stairs)", "count is 0", "1 to 1024"]),
        ("count: 3", "count: 1020", &["solids (steps of stairs counted)", "at most 1024"]),
        (r#""far + 12""#, r#""far + 5""#, &["solid 8 (Gap)", "before the gap in the list before it ends"]),
        (r#"ground: (material: "wet_ice", friction: 0.05),"#, "", &["solid 7 (Gap)", "no ground of its own"]),
        (
            "Gap(ahead: \"far + 12\", length: \"height\")",
            "Bumps(ahead: 20, length: 2, width: 2, spacing: 0.3, amplitude: 0.02)",
            &["solid 8 (Bumps)", "gaps and bumps"],
        ),
        (
            "Gap(ahead: \"far + 12\", length: \"height\")",
            "Bumps(ahead: 20, length: 2, width: 2, spacing: 0, amplitude: 0.02)",
            &["solid 8 (Bumps)", "spacing is 0"],
        ),
        (
            "Gap(ahead: \"far + 12\", length: \"height\")",
            "Bumps(ahead: 20, length: 900, width: 900, spacing: 0.02, amplitude: 0.02)",
            &["nodes of bumps", "at most 65536"],
        ),
        ("side_walls: \"2 * height + 1\"", "side_walls: \"0 * height\"", &["course", "side_walls is 0"]),
        ("radius: 0.03", "radios: 0.03", &["full.course.ron:", "radios"]),
    ];
    for (from, to, words) in cases {
        assert!(FULL.contains(from), "no `{from}` to edit");
        let edited = FULL.replacen(from, to, 1);
        let error = Course::parse("full.course.ron", edited.as_bytes()).expect_err(to).to_string();
        for word in ["full.course.ron"].iter().chain(*words) {
            assert!(error.contains(word), "`{from}` -> `{to}` says `{error}`, without `{word}`");
        }
    }
    let big = vec![b' '; Course::MAX_BYTES + 1];
    assert!(Course::parse("big", &big).expect_err("too large").to_string().contains("at most 1048576 bytes"));
    assert!(Course::parse("text", b"\xff").expect_err("no text").to_string().contains("not UTF-8"));
    assert!(Course::read("no/such.course.ron").expect_err("no file").to_string().contains("cannot be read"));
    assert!(Course::parse("deep", "(".repeat(100_000).as_bytes()).is_err());

    let (course, mut values) = (full(), full().defaults());
    assert_eq!(values, [0.5, 4.0]);
    course.set(&mut values, "height", 0.45).expect("in range");
    assert_eq!(values, [0.45, 4.0]);
    let error = course.set(&mut values, "height", 0.7).expect_err("too high").to_string();
    assert_eq!(error, "full.course.ron: parameter `height`: value is 0.7; valid: a number from 0.4 to 0.6");
    let error = course.set(&mut values, "width", 0.7).expect_err("unknown").to_string();
    assert!(error.contains("`width` is unknown; valid: one of height, far"), "{error}");
}

#[test]
fn mutations_never_panic() {
    let mut accepted = 0;
    for seed in 0..3000 {
        let mut random = RandomStream::new(seed, 31);
        let mut text = FULL.as_bytes().to_vec();
        for _ in 0..1 + random.below(3) {
            let at = random.below(text.len());
            match random.below(3) {
                0 => text[at] = random.bits() as u8,
                1 => drop(text.drain(at..(at + random.below(20)).min(text.len()))),
                _ => {
                    let digit = |b: &u8| b.is_ascii_digit() || matches!(b, b'-' | b'.');
                    let Some(start) = text[at..].iter().position(digit).map(|i| at + i) else { continue };
                    let end = text[start..].iter().position(|b| !digit(b)).map_or(text.len(), |i| start + i);
                    let values = ["0.0", "-1.0", "1e-300", "1e300", "NaN", "inf", "-inf", "7", "99999999999"];
                    text.splice(start..end, values[random.below(values.len())].bytes());
                }
            }
        }
        match Course::parse("mutated", &text) {
            Ok(course) => {
                accepted += 1;
                if let Ok(instance) = course.instance(&course.defaults(), seed) {
                    let hit: SurfaceHit<f64> =
                        CourseTerrain::new(Arc::new(World::empty()), &instance).query(Vec3::zero());
                    assert!(!hit.distance.is_nan(), "seed {seed}");
                }
            }
            Err(error) => assert!(error.to_string().len() < 4000, "seed {seed}: {error}"),
        }
    }
    println!("{accepted} of 3000 accepted");
    assert!(accepted > 100 && accepted < 2900);
}

#[test]
fn a_box_stands_where_the_file_says() {
    let mut values = shipped("vault_box").defaults();
    let course = shipped("vault_box");
    course.set(&mut values, "height", 0.45).expect("valid");
    course.set(&mut values, "distance", 2.5).expect("valid");
    let instance = course.instance(&values, 0).expect("a course");
    assert_eq!(instance.side_walls, Some(2.0));
    let terrain = CourseTerrain::<f64>::new(Arc::new(World::empty()), &instance);
    let height = |x: f64, z: f64| terrain.height(Vec3::splat(DVec3::new(x, 0.3, z))).height;
    assert_eq!(
        [height(0.0, -2.49), height(0.0, -2.51), height(0.99, -2.89), height(1.01, -2.6), height(0.0, -2.91)],
        [0.0, 0.45, 0.45, 0.0, 0.0]
    );
    let grip = |x: f64, y: f64, z: f64| terrain.query(Vec3::splat(DVec3::new(x, y, z))).grippable;
    assert!(grip(0.0, 0.46, -2.51) && grip(0.9, 0.44, -2.495), "at the edge of the top");
    assert!(!grip(0.0, 0.46, -2.7) && !grip(0.0, 0.3, -2.495), "in the middle of the top, and below the edge");
    // Forces: friction and material of the wall, and of the ground beside it.
    let hit = terrain.query(Vec3::splat(DVec3::new(0.0, 0.01, 0.0)));
    assert!(hit.distance == 0.01 && hit.friction == 0.8 && !hit.carves);
}

/// Points about a course: most near its solids.
fn points(instance: &CourseInstance, random: &mut RandomStream) -> Vec<DVec3> {
    let mut points = Vec::new();
    for solid in &instance.solids {
        points.extend(
            (0..12).map(|_| solid.center + DVec3::from_array(core::array::from_fn(|_| random.range(-1.2, 1.2)))),
        );
    }
    points.extend(
        (0..60).map(|_| DVec3::new(random.range(-3.0, 3.0), random.range(-0.5, 2.5), random.range(-22.0, 3.0))),
    );
    points
}

fn lanes_answer_like_worlds<R: Real>(course: &Course, base: &World, tolerance: f64) {
    let mut random = RandomStream::new(3, 17);
    let draw = |random: &mut RandomStream, lane: usize| {
        let mut values = course.defaults();
        course.draw(random, &mut values);
        course.instance(&values, lane as u64).expect("a course")
    };
    let instances: Vec<CourseInstance> = (0..R::LANES).map(|lane| draw(&mut random, lane)).collect();
    let shared = if instances[0].ground.is_some() { World::empty() } else { base.clone() };
    let mut terrain = CourseTerrain::<R>::new(Arc::new(shared.clone()), &instances[0]);
    let mut worlds = Vec::new();
    for (lane, instance) in instances.iter().enumerate() {
        terrain.set_lane(lane, instance).expect("the same course");
        let time = 0.7 * lane as f64 + 0.3;
        terrain.set_time(lane, time);
        let mut world = shared.clone();
        world.solids.extend(World::course_solids(instance, time).expect("solids"));
        worlds.push(world);
    }
    let mut worst = 0.0f64;
    for point in points(&instances[0], &mut random) {
        let hit: SurfaceHit<R> = terrain.query(Vec3::splat(point));
        let clearance = terrain.clearance(Vec3::splat(point));
        let height: SupportHit<R> = terrain.height(Vec3::splat(point));
        for (lane, world) in worlds.iter().enumerate() {
            let alone: SurfaceHit<f64> = world.query(Vec3::splat(point));
            let off = (hit.distance.lane(lane) - alone.distance).abs();
            worst = worst.max(off);
            assert!(
                off < tolerance,
                "{} lane {lane} at {point}: {} and {}",
                course.name,
                hit.distance.lane(lane),
                alone.distance
            );
            // Over rough ground a distance along the local normal falls short of the true one by the cosine of its slope.
            let rough = if instances[lane].bumps.is_some() { 0.03 * alone.distance.abs() } else { 0.0 };
            let bound = clearance.lane(lane) <= alone.distance + rough + tolerance;
            assert!(bound || alone.distance < 0.0, "{} lane {lane} at {point}", course.name);
            let found = R::mask_lane(height.found, lane);
            let alone_height: SupportHit<f64> = world.height(Vec3::splat(point));
            // A point on a rim may fall on either side of it in single precision.
            let rim = |d: DVec3| world.height(Vec3::<f64>::splat(point + d)).height != alone_height.height;
            if !(rim(DVec3::X * 1e-4) || rim(DVec3::X * -1e-4) || rim(DVec3::Z * 1e-4) || rim(DVec3::Z * -1e-4))
                || tolerance < 1e-9
            {
                assert_eq!(found, alone_height.found, "{} lane {lane} at {point}", course.name);
                assert!(!found || (height.height.lane(lane) - alone_height.height).abs() < 10.0 * tolerance, "{point}");
            }
            // Where one solid is clearly nearest, all it says is the same.
            if off < tolerance && (hit.normal.lane(lane) - alone.normal.lane(0)).length() < 1e-6 {
                let velocity = (hit.velocity.lane(lane) - alone.velocity.lane(0)).length();
                let same_surface = (hit.friction.lane(lane) - alone.friction).abs() < 1e-6;
                assert!(velocity < 1e-5 || !same_surface, "{} at {point}: {velocity}", course.name);
            }
        }
    }
    println!("{} in {}: worst difference {worst:.1e} m (allowed {tolerance:.0e})", course.name, R::NAME);
}

#[test]
fn a_lane_answers_like_a_world_of_its_own() {
    for course in SHIPPED.map(shipped).into_iter().chain([full(), slope()]) {
        lanes_answer_like_worlds::<f64>(&course, &World::ground(), 1e-12);
        lanes_answer_like_worlds::<F64x4>(&course, &World::ground(), 1e-12);
        lanes_answer_like_worlds::<F32x8Fused>(&course, &World::ground(), 2e-5);
    }
    // On a shared world: the same without ground of its own.
    let text = FULL.replace(r#"ground: (material: "wet_ice", friction: 0.05),"#, "");
    let text: String = text.lines().filter(|l| !l.contains("Gap(")).collect::<Vec<_>>().join("\n");
    let course = Course::parse("shared", text.as_bytes()).expect("a course");
    lanes_answer_like_worlds::<F64x4>(&course, &World::ground(), 1e-12);
}

#[test]
fn a_long_course_leaves_nothing_out() {
    // More than one region of blocks; boxes across, beside and above each other, some that move.
    let mut text =
        "(name: \"long\", parameters: [(name: \"a\", range: (0.3, 0.9))], ground: (friction: 0.7), solids: ["
            .to_owned();
    for k in 0..150 {
        let (ahead, right, up) =
            (f64::from(k % 50) * 0.45 - 2.0, f64::from(k % 7) * 0.5 - 1.5, f64::from(k / 50) * 0.8);
        let motion = if k % 11 == 0 { ", motion: Cross(by: (0, 0, \"3 * a\"), speed: 1)" } else { "" };
        text += &format!(
            "Box(ahead: {ahead}, right: {right}, up: {up}, yaw: {k}, depth: 0.3, width: \"a\", height: 0.4{motion}),"
        );
    }
    let course = Course::parse("long", (text + "])").as_bytes()).expect("a course");
    lanes_answer_like_worlds::<F64x4>(&course, &World::empty(), 1e-12);
    lanes_answer_like_worlds::<F32x8Fused>(&course, &World::empty(), 2e-5);
}

#[test]
fn neighbours_change_no_bits() {
    let course = full();
    let mut random = RandomStream::new(4, 17);
    let instances: Vec<CourseInstance> = (0..4)
        .map(|_| {
            let mut values = course.defaults();
            course.draw(&mut random, &mut values);
            course.instance(&values, 0).expect("a course")
        })
        .collect();
    let empty = Arc::new(World::empty());
    let mut together = CourseTerrain::<F64x4>::new(empty.clone(), &instances[0]);
    let mut alone: Vec<CourseTerrain<f64>> = Vec::new();
    for (lane, instance) in instances.iter().enumerate() {
        together.set_lane(lane, instance).expect("the same course");
        alone.push(CourseTerrain::new(empty.clone(), instance));
    }
    for _ in 0..30 {
        together.advance(1.0 / 32.0);
        alone.iter_mut().for_each(|t| t.advance(1.0 / 32.0));
    }
    for point in points(&instances[1], &mut random) {
        let hit = together.query(Vec3::splat(point));
        let (clearance, height) = (together.clearance(Vec3::splat(point)), together.height(Vec3::splat(point)));
        for (lane, terrain) in alone.iter().enumerate() {
            let own = terrain.query(Vec3::<f64>::splat(point));
            assert_eq!(hit.distance.lane(lane).to_bits(), own.distance.to_bits(), "{point}");
            assert_eq!(hit.normal.lane(lane), own.normal.lane(0));
            assert_eq!(hit.velocity.lane(lane), own.velocity.lane(0));
            assert_eq!(F64x4::mask_lane(hit.carves, lane), own.carves);
            assert_eq!(F64x4::mask_lane(hit.grippable, lane), own.grippable);
            assert_eq!(
                clearance.lane(lane).to_bits(),
                terrain.clearance(Vec3::<f64>::splat(point)).to_bits(),
                "{point}"
            );
            assert_eq!(height.height.lane(lane).to_bits(), terrain.height(Vec3::<f64>::splat(point)).height.to_bits());
        }
    }
}

#[test]
fn what_moves_does_so_as_its_velocity_says() {
    let motions = [
        MotionInstance::Sway { amplitude: DVec3::new(0.3, 0.1, 0.0), frequency: 0.7 },
        MotionInstance::Jerk { by: DVec3::new(0.0, 0.4, 1.0), start: 0.5, seconds: 2.0 },
        MotionInstance::Cross { by: DVec3::new(1.0, 0.0, 2.0), seconds: 1.3 },
    ];
    let h = 1e-5;
    for motion in motions {
        let mut worst = 0.0f64;
        for k in 0..400 {
            let time = 0.0173 * f64::from(k) + 0.001;
            let (before, now, after) = (motion.at(time - h), motion.at(time), motion.at(time + h));
            if let MotionInstance::Cross { seconds, .. } = motion
                && ((time - h) / seconds).floor() != ((time + h) / seconds).floor()
            {
                continue;
            }
            worst = worst.max(((after.0 - before.0) / (2.0 * h) - now.1).length());
        }
        println!("{motion:?}: velocity off by {worst:.1e} m/s (allowed 1e-6)");
        assert!(worst < 1e-6);
    }
    // By the library's sine; at rest at both ends; there and back.
    let sway = |t: f64| motions[0].at(t).0.x - 0.3 * (core::f64::consts::TAU * 0.7 * t).sin();
    assert!((0..1000).all(|k| sway(0.0137 * f64::from(k)).abs() < 1e-13));
    assert_eq!(
        (motions[1].at(0.2), motions[1].at(9.0)),
        ((DVec3::ZERO, DVec3::ZERO), (DVec3::new(0.0, 0.4, 1.0), DVec3::ZERO))
    );
    assert!(
        (motions[2].at(1.3).0 - DVec3::new(1.0, 0.0, 2.0)).length() < 1e-12 && motions[2].at(2.6).0.length() < 1e-12
    );
}

#[test]
fn a_lane_of_another_course_is_refused_and_drawing_one_allocates_nothing() {
    let (course, other) = (full(), shipped("vault_box"));
    let mut terrain =
        CourseTerrain::<F64x4>::new(Arc::new(World::empty()), &course.instance(&course.defaults(), 0).expect("one"));
    let wrong = other.instance(&other.defaults(), 0).expect("one");
    let error = terrain.set_lane(1, &wrong).expect_err("another course");
    assert!(
        matches!(error, CourseLaneError::Different { lane: 1, .. })
            && error.to_string().contains("number of solids is 1"),
        "{error}"
    );
    assert_eq!(terrain.set_lane(9, &wrong).expect_err("no lane").to_string(), "lane 9; valid: 0 to 3");
    let flat =
        CourseInstance { ground: None, gaps: Vec::new(), ..course.instance(&course.defaults(), 0).expect("one") };
    assert!(terrain.set_lane(1, &flat).expect_err("no ground").to_string().contains("ground is missing"));

    for course in [course, shipped("bumps")] {
        let mut values = course.defaults();
        let mut instance = course.instance(&values, 0).expect("one");
        let mut terrain = CourseTerrain::<F32x8Fused>::new(Arc::new(World::empty()), &instance);
        let mut random = RandomStream::new(1, 1);
        course.draw(&mut random, &mut values);
        course.evaluate(&values, 7, &mut instance).expect("one");
        let before = crate::counting_allocator::allocations();
        for lane in 0..8 {
            course.draw(&mut random, &mut values);
            course.evaluate(&values, lane as u64, &mut instance).expect("one");
            terrain.set_lane(lane, &instance).expect("fits");
            terrain.advance(0.01);
        }
        let taken = crate::counting_allocator::allocations() - before;
        assert_eq!(taken, 0, "{}", course.name);
    }
}

#[test]
fn bumps_are_level_at_the_border_and_drawn_by_the_seed() {
    let course = shipped("bumps");
    let [a, again, b] = [1, 1, 2].map(|seed| course.instance(&course.defaults(), seed).expect("one"));
    assert_eq!(a, again);
    assert_ne!(a, b);
    let bumps = a.bumps.as_ref().expect("bumps");
    let (low, high) = bumps.heights.iter().fold((0.0f64, 0.0f64), |(l, h), v| (l.min(*v), h.max(*v)));
    assert!(low < -0.018 && high > 0.018 && low >= -0.02 && high <= 0.02, "{low} {high}");
    let terrain = CourseTerrain::<f64>::new(Arc::new(World::empty()), &a);
    let height = |x: f64, z: f64| terrain.height(Vec3::splat(DVec3::new(x, 0.5, z))).height;
    // Level before, behind and beside it, and no step where it begins.
    assert_eq!([height(0.0, 0.0), height(0.0, -0.999), height(3.2, -5.0), height(0.0, -23.0)], [0.0; 4]);
    let mut steepest = 0.0f64;
    for k in 0..4000 {
        let z = -0.9 - 0.006 * f64::from(k);
        steepest = steepest.max((height(0.37, z) - height(0.37, z - 1e-4)).abs() / 1e-4);
    }
    assert!(steepest < 2.0 * 0.02 / 0.3 + 1e-6, "a slope of {steepest}");
}

/// On a slope of 5 degrees the ground at 2 m ahead is 2 tan 5 degrees up, its normal leans back by 5 degrees, and the distance from it is square to it.
#[test]
fn ground_that_has_a_slope_is_a_plane_through_the_start() {
    let course = Course::parse(
        "plane.course.ron",
        br#"(name: "plane", parameters: [(name: "slope", range: (-45, 45))], ground: (friction: 0.8, slope: "slope"))"#,
    )
    .expect("a course");
    for degrees in [5.0, -20.0, 0.0] {
        let angle = f64::to_radians(degrees);
        let instance = course.instance(&[degrees], 0).expect("one");
        let terrain = CourseTerrain::<f64>::new(Arc::new(World::empty()), &instance);
        let above = DVec3::new(0.7, 3.0, -2.0);
        let height = terrain.height(Vec3::splat(above));
        assert!((height.height - 2.0 * angle.tan()).abs() < 1e-12, "{degrees} degrees: {}", height.height);
        let normal = DVec3::new(0.0, angle.cos(), angle.sin());
        let hit: SurfaceHit<f64> = terrain.query(Vec3::splat(above));
        assert!((hit.normal.lane(0) - normal).length() < 1e-12 && (height.normal.lane(0) - normal).length() < 1e-12);
        assert!((hit.distance - above.dot(normal)).abs() < 1e-12, "{degrees} degrees: {}", hit.distance);
    }
    let too_steep = course.instance(&[50.0], 0).expect_err("refused").to_string();
    assert!(too_steep.contains("slope") && too_steep.contains("-45 to 45"), "{too_steep}");
    let gap = br#"(name: "gap", ground: (friction: 0.8, slope: 3), solids: [Gap(ahead: 2, length: 1)])"#;
    let refused = Course::parse("gap.course.ron", gap).expect_err("refused").to_string();
    assert!(refused.contains("solid 1 (Gap)") && refused.contains("slope"), "{refused}");
}
