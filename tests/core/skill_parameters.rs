//! Contract: a skill's parameters are set by name, and what is set is what is followed and seen.
//!
//! Proves: two values of a parameter give two references that differ by the difference of the values times the warp's profile; the
//! policy sees each value as its place in the range; without a wish it is the value that the motion was made for; a wish out of
//! range, one that is no number and one of a name that nobody has are told, with what would be valid, and do no harm; a wish made in
//! the middle counts from the next decision on, also where the state was written in between. And the first decision of a skill
//! already sees what is ahead: it once saw nothing, because the ground was looked at after steps only.

use crate::plain_skill::{AHEAD, jump_over, seen, silent};
use bevy_athlete::asset::{Course, StateReader, StateWriter};
use bevy_athlete::contact::{Terrain, World};
use bevy_athlete::control::tracking::Heading;
use bevy_athlete::model::{PRESET_NAMES, SharedModel, preset};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use bevy_athlete::skill::{
    BadParameter, Director, DirectorEvent, DirectorInput, SkillParameters, SkillPlayer, TrainedSkill,
};
use glam::DVec3;
use std::sync::Arc;

fn runner() -> SharedModel {
    preset("runner").unwrap()
}

fn skill(model: &SharedModel) -> Arc<TrainedSkill> {
    Arc::new(silent(jump_over(model), model))
}

fn wish(parameters: SkillParameters) -> DirectorInput {
    DirectorInput { parameters, ..DirectorInput::default() }
}

/// A body and its director at the start.
struct Run {
    sim: Simulator<f64>,
    director: Director,
    world: World,
}

impl Run {
    fn new(model: &SharedModel, parameters: SkillParameters) -> Self {
        let skill = skill(model);
        let rate = skill.definition.simulation_rate(model);
        let mut sim = Simulator::new(model.clone(), SimulationSettings { rate, ..SimulationSettings::of(model) });
        let mut director = Director::single(skill, rate).unwrap().with_input(wish(parameters));
        director.begin(&mut sim, Heading::ahead(), DVec3::ZERO);
        Self { sim, director, world: World::ground() }
    }

    fn step(&mut self) {
        self.director.drive(&mut self.sim, &self.world).unwrap();
        step(&mut self.sim, &self.world);
        self.director.after_step(&mut self.sim, &self.world);
    }

    fn told(&mut self) -> Vec<(String, BadParameter)> {
        let events = std::iter::from_fn(|| self.director.take_event());
        let parameter = |event| match event {
            DirectorEvent::Parameter { name, reason } => Some((name, reason)),
            _ => None,
        };
        events.filter_map(parameter).collect()
    }

    fn reference(&self) -> DVec3 {
        self.director.player().reference_pose().root_position
    }
}

#[test]
fn names_are_in_order_and_found() {
    let mut wished = SkillParameters::default().with("b", 1.0).with("a", 2.0).with("b", 3.0);
    assert_eq!(wished.iter().collect::<Vec<_>>(), [("a", 2.0), ("b", 3.0)]);
    assert_eq!(wished, SkillParameters::default().with("a", 2.0).with("b", 3.0));
    assert_eq!((wished.get("a"), wished.get("c")), (Some(2.0), None));
    // What is no number is equal to itself: it is told once, not in every tick.
    wished.set("a", f64::NAN);
    assert_eq!(wished, wished.clone());
    assert!(wished.remove("a").unwrap().is_nan() && !wished.is_empty());
    wished.clear();
    assert_eq!(wished, SkillParameters::default());
}

#[test]
fn without_a_wish_it_is_the_motion_as_it_is() {
    for name in PRESET_NAMES {
        let model = preset(name).unwrap();
        let definition = jump_over(&model);
        assert_eq!(definition.default_parameters(), [0.5, 2.0, 0.5], "neutral, neutral, middle");
        let player = SkillPlayer::new(skill(&model), definition.simulation_rate(&model)).unwrap();
        assert_eq!(player.parameters(), [0.5, 2.0, 0.5]);
        let mut run = Run::new(&model, SkillParameters::default());
        let (first, height) = (run.reference(), run.director.player().skill().motion.tick(0).pose.root_position.y);
        assert_eq!(first.y, height, "{name}");
        let motion = run.director.player().skill().motion.clone();
        for _ in 0..400 {
            run.step();
            let tick = run.director.player().tick();
            if run.director.player().at_decision() {
                // Level ground at rest adds nothing; neither does a warp to the value that it was made for.
                assert_eq!(run.reference().y, motion.tick(tick).pose.root_position.y, "{name}, tick {tick}");
            }
        }
        let (parameters, heights) = seen(run.director.player().observation());
        assert_eq!((parameters, heights), ([0.0, -0.5, 0.0], [0.0; 3]), "{name}");
        assert!(run.told().is_empty());
    }
}

#[test]
fn two_values_give_two_references_and_the_policy_sees_them() {
    let model = runner();
    let wishes = [("height", 0.45, 0.6), ("distance", 1.5, 4.0)];
    for (name, a, b) in wishes {
        let mut runs = [a, b].map(|value| Run::new(&model, SkillParameters::default().with(name, value)));
        let motion = runs[0].director.player().skill().motion.clone();
        let which = usize::from(name == "distance");
        let mut apart: f64 = 0.0;
        for _ in 0..900 {
            runs.iter_mut().for_each(Run::step);
            if !runs[0].director.player().at_decision() {
                continue;
            }
            let tick = runs[0].director.player().tick();
            let values = |value: f64| {
                let mut all = jump_over(&model).default_parameters();
                all[which] = value;
                motion.warps().iter().map(|w| w.offset(tick, &all).0).sum::<DVec3>()
            };
            // Where each body's footholds are is its own affair: both stand on the same ground.
            let wanted = values(b) - values(a);
            let found = runs[1].reference() - runs[0].reference();
            apart = apart.max(found.length());
            assert!((found - wanted).length() < 1e-9, "{name}, tick {tick}: {found} of {wanted}");
        }
        println!("{name}: {apart:.3} m apart");
        let largest = if which == 0 { 0.15 } else { 2.5 };
        assert!((apart - largest).abs() < 1e-9, "{apart}");
        let ranges = jump_over(&model).parameters;
        let place = |v: f64| 2.0 * (v - ranges[which].range.0) / (ranges[which].range.1 - ranges[which].range.0) - 1.0;
        for (run, value) in runs.iter().zip([a, b]) {
            let (parameters, _) = seen(run.director.player().observation());
            assert!((f64::from(parameters[which]) - place(value)).abs() < 1e-6, "{name}: {parameters:?}");
            assert_eq!(parameters[2], 0.0, "the other parameters stay");
        }
    }
}

#[test]
fn wishes_that_cannot_be_met_are_told() {
    let model = runner();
    let wished = SkillParameters::default().with("height", 0.9).with("mood", f64::NAN).with("width", 1.0);
    let mut run = Run::new(&model, wished.clone());
    let told = run.told();
    told.iter().for_each(|(name, reason)| println!("{name}: {reason}"));
    let out = BadParameter::OutOfRange { value: 0.9, low: 0.4, high: 0.6 };
    let unknown = BadParameter::Unknown { known: ["distance", "height", "mood"].map(String::from).to_vec() };
    let expected = [("height", out), ("mood", BadParameter::NotANumber { taken: 0.5 }), ("width", unknown)];
    assert_eq!(told, expected.map(|(name, reason)| (name.to_owned(), reason)));
    assert_eq!(run.director.player().parameters(), [0.6, 2.0, 0.5], "the nearest that can be");
    // The same wish again is not told again; a new one is, at the next decision.
    run.director.set_input(wish(wished.clone()));
    (0..100).for_each(|_| run.step());
    assert!(run.told().is_empty());
    run.director.set_input(wish(wished.with("height", 0.3).with("mood", 0.25)));
    (0..100).for_each(|_| run.step());
    assert_eq!(run.told().iter().map(|t| t.0.as_str()).collect::<Vec<_>>(), ["height", "width"]);
    assert_eq!(run.director.player().parameters(), [0.4, 2.0, 0.25]);
    // A new start tells again.
    run.director.begin(&mut run.sim, Heading::ahead(), DVec3::ZERO);
    assert_eq!(run.told().len(), 2);
    // Without wishes, back to where it was.
    run.director.set_input(DirectorInput::default());
    (0..100).for_each(|_| run.step());
    assert_eq!(run.director.player().parameters(), [0.5, 2.0, 0.5]);
}

#[test]
fn a_wish_in_the_middle_counts_from_the_next_decision_and_is_in_the_state() {
    let model = runner();
    let mut run = Run::new(&model, SkillParameters::default());
    let bytes = |run: &Run| {
        let mut out = StateWriter::default();
        run.director.write_state(&mut out);
        out.finish()
    };
    while !run.director.player().at_decision() || run.director.player().tick() < 6 {
        run.step();
    }
    run.step();
    let before = run.reference();
    run.director.set_input(wish(SkillParameters::default().with("height", 0.6)));
    let state = bytes(&run);
    let mut twin = Run::new(&model, SkillParameters::default());
    twin.director.read_state(&mut StateReader::new(&state)).unwrap();
    assert!(bytes(&twin) == state);
    twin.sim.state = run.sim.state.clone();
    twin.sim.commands.clone_from(&run.sim.commands);
    twin.sim.state_changed();
    run.step();
    assert!((run.reference() - before).length() < 1e-3, "not before the next decision");
    twin.step();
    for _ in 0..200 {
        run.step();
        twin.step();
        assert_eq!(run.sim.state.fingerprint(0), twin.sim.state.fingerprint(0));
    }
    assert!(bytes(&twin) == bytes(&run));
    assert!((run.reference().y - before.y - 0.1).abs() < 1e-3, "{} m higher", run.reference().y - before.y);
    assert_eq!(run.director.player().parameters(), [0.6, 2.0, 0.5]);
}

/// A box of half a metre, from 1 to 1.5 m ahead.
fn box_ahead() -> World {
    let text = r#"(name: "box", ground: (friction: 0.8), solids: [Box(ahead: 1, depth: 0.5, width: 2, height: 0.5)])"#;
    let course = Course::parse("box.course.ron", text.as_bytes()).unwrap();
    World::with_course(&World::empty(), &course.instance(&[], 0).unwrap()).unwrap()
}

#[test]
fn the_first_decision_sees_what_is_ahead() {
    let (world, wanted) = (box_ahead(), [0.0, 0.5, 0.0]);
    assert_eq!(AHEAD, [0.5, 1.2, 2.0]);
    for name in PRESET_NAMES {
        let model = preset(name).unwrap();
        let skill = skill(&model);
        let rate = skill.definition.simulation_rate(&model);
        let settings = SimulationSettings { rate, ..SimulationSettings::of(&model) };
        let mut sim = Simulator::new(model.clone(), settings);
        let mut player = SkillPlayer::new(skill.clone(), rate).unwrap();
        player.begin(&mut sim, Heading::ahead(), DVec3::ZERO, None);
        player.drive(&mut sim, &world).unwrap();
        assert_eq!(seen(player.observation()).1, wanted, "{name}: a player");
        // One that takes a body over sees it as well.
        let mut player = SkillPlayer::new(skill.clone(), rate).unwrap();
        player.join(&mut sim, 3);
        player.drive(&mut sim, &world).unwrap();
        assert_eq!(seen(player.observation()).1, wanted, "{name}: a player that joins");
        let mut director = Director::single(skill, rate).unwrap();
        director.begin(&mut sim, Heading::ahead(), DVec3::ZERO);
        director.drive(&mut sim, &world).unwrap();
        assert_eq!(seen(director.player().observation()).1, wanted, "{name}: a director");
        assert_eq!(director.sees_ground_within(), 2.0);
    }
}

/// A body that begins on a platform, with the platform's velocity, sees at its first decision what it sees on the same at rest.
#[test]
fn the_first_decision_knows_how_the_ground_moves() {
    for name in PRESET_NAMES {
        let model = preset(name).unwrap();
        let skill = skill(&model);
        let rate = skill.definition.simulation_rate(&model);
        let first = |velocity: DVec3| {
            let mut world = box_ahead();
            world.solids.iter_mut().for_each(|solid| solid.linear_velocity = velocity);
            let settings = SimulationSettings { rate, ..SimulationSettings::of(&model) };
            let mut sim = Simulator::new(model.clone(), settings);
            let mut player = SkillPlayer::new(skill.clone(), rate).unwrap();
            player.begin(&mut sim, Heading::ahead(), DVec3::ZERO, None);
            let linear = sim.state.root_velocity.linear.lane(0) + velocity;
            sim.state.root_velocity.linear.set_lane(0, linear);
            sim.state_changed();
            player.drive(&mut sim, &world).unwrap();
            player.observation().to_vec()
        };
        let (rest, moving) = (first(DVec3::ZERO), first(DVec3::new(0.75, 0.0, -1.0)));
        let apart = rest.iter().zip(&moving).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(apart < 1e-6, "{name}: {apart}");
    }
}

/// Nothing but heights are seen of a terrain that is told before the first step: what carries the body is known from its first foothold on.
#[test]
fn a_look_ahead_moves_nothing() {
    let model = runner();
    let prints = |world: &World| {
        let mut run = Run { world: world.clone(), ..Run::new(&model, SkillParameters::default()) };
        (0..20)
            .map(|_| {
                run.step();
                run.sim.state.fingerprint(0)
            })
            .collect::<Vec<_>>()
    };
    let box_far_away = box_ahead();
    let near: bevy_athlete::contact::SupportHit<f64> = box_far_away.height(bevy_athlete::math::Vec3::splat(DVec3::Y));
    assert_eq!(near.height, 0.0);
    let mut level = box_far_away.clone();
    level.solids.truncate(1);
    assert_eq!(prints(&level), prints(&box_far_away), "a box that nobody touches, and a policy that says nothing");
}
