//! Contract: skinned meshes that follow the simulated links.
//!
//! The shipped humanoid's own skeleton is laid under an athlete that skates. What is proven: after a second of motion every mapped bone is
//! where its link is, times the offset; the offsets that the rest poses gave put the bones at the skater's joints; what is
//! not mapped keeps the transform that somebody else writes; a map that does not fit is refused with the place and what
//! would be valid. The file itself is looked at too: weights, bones, inverse bind matrices.

use bevy::math::{DMat4, DVec3};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_athlete::asset::bone_map::{BoneMap, BoneMapError};
use bevy_athlete::engine::*;
use bevy_athlete::model::{LinkTransform, RestBone, bind_bones, skater};
use serde_json::Value;
use std::time::Duration;

const TICK: Duration = Duration::from_micros(15_625);
const MAP: &[u8] = include_bytes!("../../assets/maps/humanoid.bones.ron");
const MODEL: &[u8] = include_bytes!("../../assets/models/humanoid.glb");

/// The two parts of a glTF binary.
fn parts() -> (Value, &'static [u8]) {
    let word = |at: usize| u32::from_le_bytes(MODEL[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&MODEL[..4], word(4), word(8)), (&b"glTF"[..], 2, MODEL.len()));
    let text = word(12);
    (serde_json::from_slice(&MODEL[20..20 + text]).unwrap(), &MODEL[28 + text..])
}

/// Name, parent and rest transform of every node.
fn nodes() -> Vec<(String, Option<usize>, Transform)> {
    let (file, _) = parts();
    let nodes = file["nodes"].as_array().unwrap();
    let numbers = |value: &Value| -> Vec<f32> {
        value.as_array().into_iter().flatten().map(|x| x.as_f64().unwrap() as f32).collect()
    };
    let child = |node: &Value, k: usize| node["children"].as_array().is_some_and(|c| c.contains(&k.into()));
    nodes
        .iter()
        .enumerate()
        .map(|(k, node)| {
            let mut transform = Transform::IDENTITY;
            if let [x, y, z] = numbers(&node["translation"])[..] {
                transform.translation = Vec3::new(x, y, z);
            }
            if let [x, y, z, w] = numbers(&node["rotation"])[..] {
                transform.rotation = Quat::from_xyzw(x, y, z, w);
            }
            (node["name"].as_str().unwrap().to_owned(), nodes.iter().position(|n| child(n, k)), transform)
        })
        .collect()
}

/// The skeleton at rest in the skater's frame: the model is turned to face -Z.
fn skeleton() -> Vec<RestBone> {
    let nodes = nodes();
    let place = |k: usize| {
        let mut to_root = DMat4::IDENTITY;
        let mut at = Some(k);
        while let Some(k) = at {
            to_root = nodes[k].2.to_matrix().as_dmat4() * to_root;
            at = nodes[k].1;
        }
        DMat4::from_rotation_y(core::f64::consts::PI) * to_root
    };
    (0..nodes.len()).map(|k| RestBone { name: nodes[k].0.clone(), to_character: place(k) }).collect()
}

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), AthletePlugins));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK));
    app.insert_resource(AthleteWorld::ice());
    app.finish();
    app.cleanup();
    app.update();
    app
}

/// A skater that performs the shipped stroking, with a skin by this map; the scene is there at once.
fn dressed(app: &mut App, map: &str, extra: &[&str]) -> (Entity, Vec<Entity>) {
    let file = "../assets/skills/skating/stroking/stroking.control.ron";
    let control = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/").to_owned() + file).unwrap();
    let control = ControlAsset::parse(file, &control).unwrap();
    let control = app.world_mut().resource_mut::<Assets<ControlAsset>>().add(control);
    let character = CharacterAsset::preset("skater").unwrap();
    let character = app.world_mut().resource_mut::<Assets<CharacterAsset>>().add(character);
    let map = BoneMap::parse("test.bones.ron", map.as_bytes()).unwrap();
    let map = app.world_mut().resource_mut::<Assets<BoneMapAsset>>().add(BoneMapAsset::from(map));
    let place = Transform::from_xyz(3.0, 0.0, -2.0).with_rotation(Quat::from_rotation_y(0.7));
    let athlete = app
        .world_mut()
        .spawn((Athlete(character), AthleteController::Play(control), AthleteSkin::new(map), place))
        .id();
    let half_turn = Transform::from_rotation(Quat::from_rotation_y(core::f32::consts::PI));
    let scene = app.world_mut().spawn((half_turn, ChildOf(athlete))).id();
    let nodes = nodes();
    let entities: Vec<Entity> =
        nodes.iter().map(|(name, _, rest)| app.world_mut().spawn((Name::new(name.clone()), *rest)).id()).collect();
    for (k, (_, parent, _)) in nodes.iter().enumerate() {
        let parent = parent.map_or(scene, |p| entities[p]);
        app.world_mut().entity_mut(entities[k]).insert(ChildOf(parent));
    }
    for name in extra {
        app.world_mut().spawn((Name::new((*name).to_owned()), Transform::default(), ChildOf(scene)));
    }
    (athlete, entities)
}

fn shipped() -> &'static str {
    core::str::from_utf8(MAP).unwrap()
}

/// Swings the ponytail and shrugs the neck, as an animation would.
fn animate(time: Res<Time>, mut bones: Query<(&Name, &mut Transform), Without<Athlete>>) {
    let phase = time.elapsed_secs();
    for (name, mut transform) in &mut bones {
        match name.as_str() {
            "Ponytail" => transform.rotation = Quat::from_rotation_x(2.0 + phase.sin()),
            "Neck" => transform.rotation = Quat::from_rotation_y(0.3 * phase.sin()),
            _ => {}
        }
    }
}

/// Largest distance (m) and angle (rad) between the mapped bones and their links times the offsets.
fn off_the_links(app: &App, athlete: Entity) -> (f32, f32) {
    let world = app.world();
    let (dress, poses) = (world.get::<DressedIn>(athlete).unwrap(), world.get::<LinkPoses>(athlete).unwrap());
    let (mut distance, mut angle): (f32, f32) = (0.0, 0.0);
    for (entity, bone) in dress.bones() {
        let LinkTransform { position, rotation } = poses.interpolated[bone.link];
        let place = (position + rotation * bone.offset.position).as_vec3();
        let turn = (rotation * bone.offset.rotation).normalize().as_quat();
        let found = world.get::<GlobalTransform>(entity).unwrap().compute_transform();
        distance = distance.max((found.translation - place).length());
        // The angle of a small rotation is twice its vector part; an arc cosine would drown in rounding.
        let between = turn.inverse() * found.rotation;
        angle = angle.max(2.0 * between.xyz().length());
    }
    (distance, angle)
}

#[test]
fn after_a_second_every_mapped_bone_is_on_its_link_and_the_others_are_left_alone() {
    let mut app = app();
    app.add_systems(Update, animate);
    let (athlete, entities) = dressed(&mut app, shipped(), &[]);
    for _ in 0..80 {
        app.update();
    }
    let moved = app.world().get::<AthleteBody>(athlete).unwrap().root_velocity().length();
    assert!(app.world().get::<SkinRefused>(athlete).is_none());
    let bones = app.world().get::<DressedIn>(athlete).expect("dressed").bones().count();
    let (distance, angle) = off_the_links(&app, athlete);
    println!(
        "{bones} bones, skating at {moved:.2} m/s: off by {distance:.1e} m (allowed 1e-5), {angle:.1e} rad (allowed 1e-5)"
    );
    assert!(bones == 18 && moved > 0.5 && distance < 1e-5 && angle < 1e-5);

    let nodes = nodes();
    let of = |name: &str| entities[nodes.iter().position(|n| n.0 == name).unwrap()];
    let phase = app.world().resource::<Time>().elapsed_secs();
    let tail = *app.world().get::<Transform>(of("Ponytail")).unwrap();
    assert_eq!(tail.rotation, Quat::from_rotation_x(2.0 + phase.sin()), "the animation has the last word");
    for name in ["LeftToeBase", "RightToeBase", "Body"] {
        let k = nodes.iter().position(|n| n.0 == name).unwrap();
        assert_eq!(*app.world().get::<Transform>(entities[k]).unwrap(), nodes[k].2, "{name} is untouched");
    }
    // What is not mapped rides on the bone that it hangs on.
    let head = app.world().get::<GlobalTransform>(of("Head")).unwrap();
    let expected = (*head * tail).translation();
    let found = app.world().get::<GlobalTransform>(of("Ponytail")).unwrap().translation();
    assert!((found - expected).length() < 1e-5);
}

#[test]
fn rest_poses_put_the_bones_at_the_joints() {
    // The mesh rests with raised arms, the skater's zero pose has them hanging: the hands meet all the same.
    let model = skater();
    let map = BoneMap::parse("humanoid.bones.ron", MAP).unwrap();
    let skeleton = skeleton();
    let bound = bind_bones(&map, &model, &skeleton).unwrap();
    let zero = model.rest_positions();
    let mut worst: f64 = 0.0;
    for bone in &bound {
        let name = &skeleton[bone.bone].name;
        // Links turn with the identity in the zero pose.
        let place = zero[bone.link] + bone.offset.position;
        let raise = if name.ends_with("Shoulder") { DVec3::Y * 0.06 } else { DVec3::ZERO };
        worst = worst.max((place - zero[bone.link] - raise).length());
    }
    println!("bones are off the skater's joints by at most {worst:.1e} m (allowed 1e-6)");
    assert!(worst < 1e-6);
}

#[test]
fn a_given_offset_takes_the_place_of_the_rest_poses() {
    let text = shipped().replace(
        "\"Head\": (link: \"head\")",
        "\"Head\": (link: \"head\", offset: (translation: (0.1, 0.2, 0.3), degrees: (0.0, 90.0, 0.0)))",
    );
    let map = BoneMap::parse("given.bones.ron", text.as_bytes()).unwrap();
    let bound = bind_bones(&map, &skater(), &skeleton()).unwrap();
    let head = bound.iter().find(|b| skeleton()[b.bone].name == "Head").unwrap();
    assert_eq!(head.offset.position, DVec3::new(0.1, 0.2, 0.3));
    assert!((head.offset.rotation * DVec3::Z - DVec3::X).length() < 1e-12);
}

#[test]
fn maps_that_do_not_fit_are_refused() {
    let parse = |text: &str| BoneMap::parse("bad.bones.ron", text.as_bytes());
    let bind = |text: &str| bind_bones(&parse(text).unwrap(), &skater(), &skeleton()).unwrap_err();
    let hips = "\"Hips\": (link: \"pelvis\"),";
    let with = |line: &str| shipped().replace(hips, &format!("{hips}\n        {line}"));

    let error = parse(&with("\"Hips\": (link: \"spine\"),")).unwrap_err();
    println!("{error}");
    assert!(matches!(&error, BoneMapError::Duplicate { name, first: 1, second: 2, .. } if name == "Hips"));
    let error = bind(&with("\"Body\": (link: \"tail\"),"));
    println!("{error}");
    assert!(
        matches!(&error, BoneMapError::UnknownLink { link, valid, .. } if link == "tail" && valid.contains("pelvis"))
    );
    let error = bind(&with("\"Hipz\": (link: \"pelvis\"),"));
    println!("{error}");
    assert!(
        matches!(&error, BoneMapError::UnknownBone { bone, valid, .. } if bone == "Hipz" && valid.contains("Hips"))
    );
    let error = bind(&shipped().replace("\"bicep_left\": (0.0", "\"biceps\": (0.0"));
    assert!(matches!(&error, BoneMapError::UnknownLink { part: "pose", link, .. } if link == "biceps"));
    let error = bind(&shipped().replace("character: \"skater\"", "character: \"runner\""));
    assert!(matches!(&error, BoneMapError::Character { .. }));
    assert!(matches!(parse("(character: \"skater\", bones: {})"), Err(BoneMapError::Empty { .. })));
    let offset =
        "(character: \"skater\", bones: {\"Hips\": (link: \"pelvis\", offset: (translation: (0.0, inf, 0.0)))})";
    assert!(matches!(parse(offset), Err(BoneMapError::Value { field: "translation", .. })));
    for broken in ["", "(", "(character: 3)", "(character: \"skater\", bones: {}, colour: 1)", "\u{1}"] {
        assert!(matches!(parse(broken), Err(BoneMapError::Syntax { .. })), "{broken:?}");
    }
    let huge = vec![b' '; (1 << 20) + 1];
    assert!(matches!(BoneMap::parse("huge", &huge), Err(BoneMapError::TooLarge { .. })));
    let mut flat = skeleton();
    flat[0].to_character = DMat4::ZERO;
    let error = bind_bones(&parse(shipped()).unwrap(), &skater(), &flat).unwrap_err();
    assert!(matches!(error, BoneMapError::RestPose { .. }));
}

#[test]
fn a_refused_skin_leaves_the_athlete_alone() {
    for (extra, map, ambiguous) in
        [(&["Head"][..], shipped().to_owned(), true), (&[][..], shipped().replace("\"Head\"", "\"Kopf\""), false)]
    {
        let mut app = app();
        let (athlete, _) = dressed(&mut app, &map, extra);
        for _ in 0..10 {
            app.update();
        }
        let refused = app.world().get::<SkinRefused>(athlete).expect("a reason");
        println!("{}", refused.0);
        assert_eq!(matches!(refused.0, BoneMapError::AmbiguousBone { count: 2, .. }), ambiguous);
        assert!(app.world().get::<DressedIn>(athlete).is_none());
        assert!(app.world().get::<AthleteBody>(athlete).unwrap().time() > 0.1, "it is simulated");
    }
}

#[test]
fn a_scene_that_is_replaced_is_dressed_anew() {
    let mut app = app();
    let (athlete, entities) = dressed(&mut app, shipped(), &[]);
    for _ in 0..4 {
        app.update();
    }
    assert!(app.world().get::<DressedIn>(athlete).is_some());
    let scene = app.world().get::<ChildOf>(*entities.last().unwrap()).unwrap().parent();
    app.world_mut().despawn(scene);
    for _ in 0..3 {
        app.update();
    }
    assert!(app.world().get::<DressedIn>(athlete).is_none(), "nothing to dress in");
}

#[test]
fn the_shipped_file_is_a_sound_skin() {
    let (file, binary) = parts();
    let accessor = |index: &Value| {
        let accessor = &file["accessors"][index.as_u64().unwrap() as usize];
        let view = &file["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let (start, length) =
            (view["byteOffset"].as_u64().unwrap() as usize, view["byteLength"].as_u64().unwrap() as usize);
        (accessor["count"].as_u64().unwrap() as usize, &binary[start..start + length])
    };
    let primitive = &file["meshes"][0]["primitives"][0];
    let joints = file["skins"][0]["joints"].as_array().unwrap().len();
    let (count, weights) = accessor(&primitive["attributes"]["WEIGHTS_0"]);
    let (_, bones) = accessor(&primitive["attributes"]["JOINTS_0"]);
    assert!(weights.chunks(4).all(|w| w.iter().map(|x| u32::from(*x)).sum::<u32>() == 255));
    assert!(bones.iter().all(|b| usize::from(*b) < joints));
    let (_, indices) = accessor(&primitive["indices"]);
    let indices: Vec<usize> = indices.chunks(2).map(|i| usize::from(u16::from_le_bytes([i[0], i[1]]))).collect();
    assert!(indices.iter().all(|i| *i < count));
    let floats =
        |bytes: &[u8]| -> Vec<f32> { bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect() };
    // At rest every bone's matrix undoes its inverse bind matrix.
    let (_, inverse) = accessor(&file["skins"][0]["inverseBindMatrices"]);
    let turn = DMat4::from_rotation_y(core::f64::consts::PI).inverse();
    let mut worst: f64 = 0.0;
    for (bone, inverse) in skeleton().iter().zip(floats(inverse).chunks(16)) {
        let product = turn * bone.to_character * Mat4::from_cols_slice(inverse).as_dmat4();
        worst = worst.max((product - DMat4::IDENTITY).to_cols_array().iter().fold(0.0, |m, x| m.max(x.abs())));
    }
    let normals = floats(accessor(&primitive["attributes"]["NORMAL"]).1);
    let long = normals.chunks(3).map(|n| (Vec3::from_slice(n).length() - 1.0).abs()).fold(0.0, f32::max);
    println!(
        "{count} vertices, {} triangles, {joints} bones; bind matrices off by {worst:.1e}, normals by {long:.1e}",
        indices.len() / 3
    );
    assert!(worst < 1e-5 && long < 1e-5);
}

/// The same through Bevy's own loader.
#[cfg(feature = "gltf")]
#[test]
fn a_scene_from_the_loader_is_dressed() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default()));
    app.add_plugins((bevy::image::ImagePlugin::default(), bevy::mesh::MeshPlugin));
    app.add_plugins((bevy::world_serialization::WorldSerializationPlugin, bevy::gltf::GltfPlugin::default()));
    app.add_plugins(AthletePlugins);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK));
    app.insert_resource(AthleteWorld::ice());
    app.finish();
    app.cleanup();
    let assets = app.world().resource::<AssetServer>().clone();
    let half_turn = Transform::from_rotation(Quat::from_rotation_y(core::f32::consts::PI));
    let scene = assets.load(bevy::gltf::GltfAssetLabel::Scene(0).from_asset("models/humanoid.glb"));
    let athlete = app
        .world_mut()
        .spawn((
            Athlete(assets.load("characters/skater.character.ron")),
            AthleteController::Play(assets.load("skills/skating/stroking/stroking.control.ron")),
            AthleteSkin::new(assets.load("maps/humanoid.bones.ron")),
            children![(WorldAssetRoot(scene), half_turn)],
        ))
        .id();
    for _ in 0..2000 {
        app.update();
        if app.world().get::<DressedIn>(athlete).is_some() {
            break;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(app.world().get::<SkinRefused>(athlete).is_none());
    let bones = app.world().get::<DressedIn>(athlete).expect("dressed").bones().count();
    for _ in 0..64 {
        app.update();
    }
    let (distance, angle) = off_the_links(&app, athlete);
    let skinned = app.world_mut().query::<&bevy::mesh::skinning::SkinnedMesh>().iter(app.world()).count();
    println!("{bones} bones, {skinned} skinned meshes: off by {distance:.1e} m, {angle:.1e} rad (allowed 1e-5)");
    assert!(bones == 18 && skinned == 1 && distance < 1e-5 && angle < 1e-5);
}
