//! Contract: a director adds nothing of its own to a motion but the choice of skills.
//!
//! A program and a steered run are performed once by the director, and once more by hand: the same skills, one player each, joined at
//! the decisions and ticks that the director named, with its speeds and turns. Both have the same bits, step by step. A golden number
//! would not do: the last bits of a policy's output are those of the processor. What was chosen is checked by what the files say:
//! elements in order, each for at least its seconds and left at the tick of its transition.
//!
//! A skill that is asked for begins when it was said to, or is refused with a reason that names what would be valid.

use bevy_athlete::cli::{find_program, load_trained_skill};
use bevy_athlete::contact::World;
use bevy_athlete::control::tracking::Heading;
use bevy_athlete::model::{SharedModel, preset};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use bevy_athlete::skill::{
    Director, DirectorEvent, DirectorInput, Entry, GraphError, NoEntry, ProgramDefinition, ProgramError,
    SKATING_SKILLS, SkillGraph, SkillPlayer, TrainedSkill,
};
use glam::DVec3;
use std::collections::BTreeMap;
use std::sync::Arc;

fn skater() -> SharedModel {
    preset("skater").unwrap()
}

fn shipped() -> BTreeMap<String, Arc<TrainedSkill>> {
    let model = skater();
    SKATING_SKILLS.iter().map(|n| ((*n).to_owned(), Arc::new(load_trained_skill(n, &model).unwrap()))).collect()
}

fn list(names: &[&str]) -> Vec<Arc<TrainedSkill>> {
    let model = skater();
    names.iter().map(|n| Arc::new(load_trained_skill(n, &model).unwrap())).collect()
}

/// A skill that began before a step, and the tick at which it was entered.
#[derive(Clone, Copy)]
struct Began {
    step: usize,
    skill: usize,
    tick: usize,
}

/// A body, its director, and the fingerprint after each so many steps.
struct Run {
    sim: Simulator<f64>,
    director: Director,
    steps: usize,
    began: Vec<Began>,
    prints: Vec<u64>,
}

const PLACE: DVec3 = DVec3::new(1.0, 0.0, 2.0);
const EVERY: usize = 100;

impl Run {
    fn new(mut director: Director) -> Self {
        let model = skater();
        let mut sim: Simulator<f64> = Simulator::new(model.clone(), SimulationSettings::of(&model));
        director.begin(&mut sim, Heading::ahead(), PLACE);
        assert_eq!(director.take_event(), Some(DirectorEvent::Began(director.skill())));
        Self { sim, director, steps: 0, began: Vec::new(), prints: Vec::new() }
    }

    fn step(&mut self, world: &World) -> Option<DirectorEvent> {
        let before = self.director.skill();
        self.director.drive(&mut self.sim, world).unwrap();
        let event = self.director.take_event();
        if let Some(DirectorEvent::Began(skill)) = event {
            let graph = self.director.graph();
            let (time, print) = (self.sim.state.time, self.sim.state.fingerprint(0));
            println!("{time:8.4} s: {} {print:016x}", graph.skills()[skill].name());
            let tick = graph.transition(before, skill).unwrap().enter;
            self.began.push(Began { step: self.steps, skill, tick });
        }
        step(&mut self.sim, world);
        self.director.after_step(&mut self.sim, world);
        self.steps += 1;
        if self.steps.is_multiple_of(EVERY) {
            self.prints.push(self.sim.state.fingerprint(0));
        }
        event
    }
}

/// The same by hand: a player for each skill, joined where the director said. `speed` and `turn` for a skill and a step.
fn by_hand(
    run: &Run,
    speed_at_start: Option<f64>,
    mut wishes: impl FnMut(&mut Simulator<f64>, &mut SkillPlayer, usize, usize),
) -> Vec<u64> {
    let model = skater();
    let graph = run.director.graph();
    let mut sim: Simulator<f64> = Simulator::new(model.clone(), SimulationSettings::of(&model));
    let (world, mut skill, mut prints) = (World::ice(), 0, Vec::new());
    let new = |k: usize| SkillPlayer::new(graph.skills()[k].skill.clone(), model.step_rate).unwrap();
    let mut player = new(skill);
    player.begin(&mut sim, Heading::ahead(), PLACE, speed_at_start);
    let mut began = run.began.iter().peekable();
    for k in 0..run.steps {
        if player.at_decision() {
            if let Some(next) = began.next_if(|began| began.step == k) {
                (skill, player) = (next.skill, new(next.skill));
                player.join(&mut sim, next.tick);
            }
            wishes(&mut sim, &mut player, skill, k);
        }
        player.drive(&mut sim, &world).unwrap();
        step(&mut sim, &world);
        player.after_step(&mut sim, &world);
        if (k + 1).is_multiple_of(EVERY) {
            prints.push(sim.state.fingerprint(0));
        }
    }
    prints
}

#[test]
fn a_program_is_its_skills_one_after_the_other() {
    let program = ProgramDefinition::load(find_program("short_program").unwrap()).unwrap();
    let mut run = Run::new(Director::program(&program, &shipped(), skater().step_rate).unwrap());
    let world = World::ice();
    let most = 60 * 1200;
    while !run.director.is_finished() && run.steps < most {
        run.step(&world);
    }
    println!("end {:.4} s: {:016x}", run.sim.state.time, run.sim.state.fingerprint(0));
    assert!(run.director.is_finished(), "not at its end after a minute");

    // In the order of the file, each for as long as it says, and left where its transition is.
    let graph = run.director.graph();
    let performed: Vec<&str> =
        std::iter::once(0).chain(run.began.iter().map(|b| b.skill)).map(|k| graph.skills()[k].name()).collect();
    let written: Vec<&str> = program.elements.iter().map(|e| e.skill.as_str()).collect();
    assert_eq!(performed, written);
    let mut from = 0;
    for (next, element) in run.began.iter().zip(&program.elements) {
        let seconds = (next.step - from) as f64 / 1200.0;
        assert!(seconds >= element.seconds, "{}: {seconds} s of {}", element.skill, element.seconds);
        from = next.step;
    }

    let mut element = 0;
    let mut skill = graph.index(&program.elements[0].skill).unwrap();
    let elements = &program.elements;
    let hand = by_hand(&run, elements[0].speed, |_, player, now, _| {
        if now != skill {
            (skill, element) = (now, element + 1);
        }
        if let Some(speed) = elements[element].speed {
            player.set_speed(speed);
        }
        player.set_steering(elements[element].steering.to_radians());
    });
    let differing = hand.iter().zip(&run.prints).filter(|(a, b)| a != b).count();
    println!("{} fingerprints, {differing} differ", hand.len());
    assert!(hand.len() == run.prints.len() && differing == 0);
}

/// Wishes over time, as a player of a game might have them.
fn wish(step: usize) -> DirectorInput {
    let (direction, speed) = match step {
        0..2400 => (DVec3::ZERO, 2.5),
        2400..12000 => (DVec3::NEG_X, 2.5),
        12000..40800 => (DVec3::X, 2.5),
        _ => (DVec3::NEG_Z, 3.0),
    };
    DirectorInput { direction, speed: Some(speed), ..DirectorInput::default() }
}

#[test]
fn a_steered_run_is_its_skills_one_after_the_other() {
    let model = skater();
    let mut run = Run::new(Director::steering(list(&SKATING_SKILLS), &model, model.step_rate).unwrap());
    let world = World::ice();
    let mut turns = Vec::new();
    for k in 0..50 * 1200 {
        run.director.set_input(wish(k));
        match k {
            21600 => _ = run.director.request(&mut run.sim, "forward_three_turn"),
            31200 => _ = run.director.request(&mut run.sim, "double_salchow"),
            45600 => _ = run.director.request(&mut run.sim, "backward_three_turn"),
            _ => {}
        }
        run.step(&world);
        turns.push(run.director.player().steering());
    }
    println!(
        "end {:.4} s: {:016x} at {:?}",
        run.sim.state.time,
        run.sim.state.fingerprint(0),
        run.sim.state.root_position.lane(0)
    );
    let graph = run.director.graph();
    let performed: Vec<&str> = run.began.iter().map(|b| graph.skills()[b.skill].name()).collect();
    // On curves it crosses over, on straights it strokes; what was asked for comes once each, in that order.
    let asked = ["forward_three_turn", "double_salchow", "backward_three_turn"];
    let once: Vec<&str> = performed.iter().copied().filter(|skill| asked.contains(skill)).collect();
    assert_eq!(once, asked, "{performed:?}");
    assert_eq!((performed.first(), performed.last()), (Some(&"forward_crossover"), Some(&"stroking")), "{performed:?}");
    assert!(performed.contains(&"backward_crossover"), "{performed:?}");
    let hand = by_hand(&run, None, |_, player, now, step| {
        if graph.skills()[now].repeats() {
            player.set_speed(wish(step).speed.unwrap());
        }
        player.set_steering(turns[step]);
    });
    let differing = hand.iter().zip(&run.prints).filter(|(a, b)| a != b).count();
    println!("{} fingerprints, {differing} differ", hand.len());
    assert!(hand.len() == run.prints.len() && differing == 0);
}

/// Steps until a skill begins, at most so many; what else happened is refused.
fn steps_until(run: &mut Run, skill: &str, most: usize) -> Option<usize> {
    let world = World::ice();
    (0..most).find(|_| match run.step(&world) {
        Some(DirectorEvent::Began(k)) => run.director.graph().skills()[k].name() == skill,
        Some(DirectorEvent::Refused { skill, reason }) => panic!("{skill}: {reason}"),
        _ => false,
    })
}

#[test]
fn a_skill_begins_when_it_was_said_to() {
    let model = skater();
    let mut run = Run::new(Director::steering(list(&SKATING_SKILLS), &model, model.step_rate).unwrap());
    let world = World::ice();
    (0..1234).for_each(|_| _ = run.step(&world));
    let said = run.director.request(&mut run.sim, "forward_three_turn");
    let Entry::After { seconds } = said else { panic!("{said:?}") };
    assert_eq!(run.director.entry(&mut run.sim, "forward_three_turn"), said, "a question is no request");
    let steps = steps_until(&mut run, "forward_three_turn", 8 * 1200).expect("it never began");
    let began = (steps + 1) as f64 / 1200.0;
    println!("said after {seconds:.3} s, began after {began:.3} s");
    // Decisions come thirty times a second; what was said counts from the last one.
    assert!((began - seconds).abs() <= 1.0 / 30.0 + 1e-9);

    // While it plays, once more: after its end, by way of what follows it.
    let again = run.director.request(&mut run.sim, "backward_three_turn");
    assert!(matches!(again, Entry::After { .. }), "{again:?}");
}

/// A skater on a curve to the side that was learnt as an image has to change hands before it can turn: by straight strokes and
/// their image. (It once never came to that, since the wished direction was asked again on the way.)
#[test]
fn a_skill_of_the_other_hand_begins_too() {
    let model = skater();
    let skills = list(&["stroking", "forward_crossover", "forward_three_turn"]);
    let mut run = Run::new(Director::steering(skills, &model, model.step_rate).unwrap());
    let world = World::ice();
    let wish = |direction: DVec3| DirectorInput { direction, speed: Some(2.5), ..DirectorInput::default() };
    run.director.set_input(wish(DVec3::NEG_Z));
    (0..2400).for_each(|_| _ = run.step(&world));
    run.director.set_input(wish(DVec3::X));
    steps_until(&mut run, "forward_crossover_mirrored", 12 * 1200).expect("no crossover to the right");
    (0..600).for_each(|_| _ = run.step(&world));
    let said = run.director.request(&mut run.sim, "forward_three_turn");
    let Entry::After { seconds } = said else { panic!("{said:?}") };
    let steps = steps_until(&mut run, "forward_three_turn", 40 * 1200).expect("it never began");
    let began = (steps + 1) as f64 / 1200.0;
    println!("said after {seconds:.3} s, began after {began:.3} s");
    assert!((began - seconds).abs() <= 1.0 / 30.0 + 1e-9);
}

#[test]
fn what_cannot_begin_is_refused_with_the_reason() {
    let model = skater();
    let three = list(&["stroking", "forward_crossover", "forward_three_turn"]);
    let mut run = Run::new(Director::steering(three, &model, model.step_rate).unwrap());
    let refused = |run: &mut Run, skill: &str| {
        let Entry::Never(reason) = run.director.request(&mut run.sim, skill) else { panic!("{skill} is granted") };
        let told = DirectorEvent::Refused { skill: skill.to_owned(), reason: reason.clone() };
        assert_eq!(run.director.take_event(), Some(told), "the answer comes as an event, too");
        println!("{skill}: {reason}");
        reason
    };
    let NoEntry::Unknown { known } = refused(&mut run, "quadruple_axel") else { panic!() };
    assert!(known.contains(&"forward_three_turn".to_owned()));
    assert_eq!(refused(&mut run, "stroking"), NoEntry::Playing);
    // A second wish takes the place of the first, which is told.
    run.director.request(&mut run.sim, "forward_three_turn");
    run.director.request(&mut run.sim, "forward_crossover");
    let replaced = NoEntry::Replaced { by: "forward_crossover".into() };
    let told = DirectorEvent::Refused { skill: "forward_three_turn".into(), reason: replaced };
    assert_eq!(run.director.take_event(), Some(told));
    // A new start forgets it, and says so.
    run.director.begin(&mut run.sim, Heading::ahead(), PLACE);
    let told = DirectorEvent::Refused { skill: "forward_crossover".into(), reason: NoEntry::Restarted };
    assert_eq!(run.director.take_event(), Some(told));
    // What plays one skill takes no requests.
    let alone = Director::single(list(&["stroking"]).remove(0), model.step_rate).unwrap();
    assert_eq!(refused(&mut Run::new(alone), "stroking"), NoEntry::NotSteered);
}

#[test]
fn skills_that_make_no_graph_are_refused() {
    let model = skater();
    let two = list(&["stroking", "forward_crossover"]);
    let fault = |skills: &[Arc<TrainedSkill>], links: &[(&str, &str)]| {
        let error = SkillGraph::new(skills.to_vec(), links).unwrap_err();
        println!("{error}");
        error
    };
    assert_eq!(fault(&[], &[]), GraphError::Empty);
    assert!(matches!(fault(&[two[0].clone(), two[0].clone()], &[]), GraphError::Twice { .. }));
    assert!(matches!(fault(&two, &[("stroking", "axel")]), GraphError::Unknown { .. }));
    // Only the links that were named can be gone along.
    let graph = SkillGraph::new(two.clone(), &[("stroking", "forward_crossover")]).unwrap();
    assert!(graph.transition(0, 1).is_some() && graph.transition(1, 0).is_none());
    assert!(matches!(graph.entry(1, 0, 0), Entry::Never(NoEntry::NoTransition { .. })));
    // Steps that are not those of the decisions.
    let error = Director::steering(two, &model, 1000.0).unwrap_err();
    println!("{error}");
    assert!(matches!(error, GraphError::Rate { .. }));
    let program = ProgramDefinition::load(find_program("short_program").unwrap()).unwrap();
    let error = Director::program(&program, &shipped(), 1000.0).unwrap_err();
    println!("{error}");
    assert!(matches!(error, ProgramError::Graph { .. }));
}
