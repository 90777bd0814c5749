//! Learning: what is learnt does not depend on the number of threads, a training goes on from its checkpoint, what is exported
//! acts as what was trained, and files that do not fit are refused with what did not fit.
//!
//! The trainings here are a few iterations long: enough for every part to run, not to learn a skill.

use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::asset::dense_layers::DenseLayers;
use bevy_athlete::asset::policy_contract::GainAction;
use bevy_athlete::cli::load_task;
use bevy_athlete::control::Policy;
use bevy_athlete::control::terms::ObservationTerm;
use bevy_athlete::control::tracking::{Heading, ObservationLayout, TrackedMotion, Tracker, TrackerOptions};
use bevy_athlete::math::{F32x8, F32x8Fused, Real, Vec3};
use bevy_athlete::model::{KeyPoses, preset};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use bevy_athlete::skill::{
    EpisodeOptions, PushOptions, SkillDefinition, SkillPlayer, TerminationLimits, TrainedSkill, TrialRow,
};
use bevy_athlete::train::ppo::{
    Actor, Environment, EpisodeStatus, SkillTask, StartSampler, TrainOptions, Trained, Trainer, evaluate,
    follow_policy, trained_policy,
};
use bevy_athlete::train::{layers_from_bytes, load_layers, policy_bytes};
use glam::DVec3;
use std::sync::Arc;

const POSES: &str = include_str!("../../assets/skills/skating/stroking/stroking.keyposes.ron");

fn task() -> SkillTask {
    let model = preset("skater").unwrap();
    let clip = KeyPoses::from_ron(POSES, "stroking").unwrap().to_clip(&model).unwrap();
    let mut skill = SkillDefinition::imitate("stroking", "skater", "stroking.clip.ron");
    skill.training_rate = Some(240.0);
    skill.episode.seconds = 1.0;
    SkillTask::new(&skill, model, &clip).unwrap()
}

fn options(threads: usize) -> TrainOptions {
    TrainOptions {
        threads,
        env_batches: 2,
        ticks: 8,
        minibatch: 512,
        hidden: vec![24, 16],
        evaluation_trials: 16,
        evaluate_every: 2,
        ..TrainOptions::default()
    }
}

/// Pushes of this force at short intervals.
fn push(link: &str, force: f64) -> PushOptions {
    PushOptions { link: link.into(), force: (force, force), seconds: 0.1, every: 0.1, count: None, airborne: false }
}

fn trained(threads: usize, iterations: usize) -> Trainer {
    let mut trainer = Trainer::new(task(), options(threads)).unwrap();
    for _ in 0..iterations {
        trainer.iterate();
    }
    trainer
}

#[test]
fn one_and_two_threads_learn_the_same() {
    let (one, two) = (trained(1, 3), trained(2, 3));
    assert_eq!(one.present().actor.parameters(), two.present().actor.parameters());
    assert_eq!(one.present().normalizer, two.present().normalizer);
    let (a, b) = (one.best().unwrap(), two.best().unwrap());
    assert_eq!(a.evaluation, b.evaluation);
    let moved =
        one.present().actor.parameters().iter().zip(trained(1, 0).present().actor.parameters()).any(|(a, b)| a != b);
    assert!(moved, "something was learnt");
}

#[test]
fn a_checkpoint_holds_all_that_was_learnt() {
    let trainer = trained(2, 2);
    let text = trainer.checkpoint();
    let again = Trainer::resume(task(), &text, |_| ()).unwrap();
    assert_eq!(again.present().actor, trainer.present().actor);
    assert_eq!(again.curve().len(), 2);
    assert!(again.checkpoint() == text, "a checkpoint of a checkpoint is the same");

    let mut other = task();
    other.skill.name = "crossover".into();
    let refusal = Trainer::resume(other, &text, |_| ()).err().unwrap().to_string();
    assert!(refusal.contains("stroking") && refusal.contains("crossover"), "{refusal}");
    assert!(Trainer::resume(task(), &text[..text.len() / 2], |_| ()).err().unwrap().to_string().contains("checkpoint"));
}

#[test]
fn a_checkpoint_of_version_1_is_read_and_one_of_a_later_version_refused() {
    let text = trained(2, 2).checkpoint();
    // Version 1 had the same fields by other names; those of the sampler of starts come before those of the options here.
    let starts = text.find("\"starts\":").unwrap();
    let (head, tail) = text.split_at(starts);
    let tail = tail.replacen("\"uniform_share\":", "\"even\":", 1).replacen("\"replay_share\":", "\"again\":", 1);
    let mut old = head.to_owned() + &tail;
    for (name, before) in [
        ("env_batches", "pods"),
        ("learning_rate", "rate"),
        ("kl", "divergence"),
        ("action_std", "sigma"),
        ("action_std_samples", "sigma_samples"),
        ("anneal", "settled"),
        ("anneal_samples", "settle_samples"),
        ("uniform_share", "even_starts"),
        ("replay_share", "hard_starts"),
    ] {
        let name = format!("\"{name}\":");
        assert!(old.contains(&name), "{name}");
        old = old.replace(&name, &format!("\"{before}\":"));
    }
    let of_version = |text: &str, n: u32| text.replacen("\"version\":2", &format!("\"version\":{n}"), 1);
    let resumed = Trainer::resume(task(), &of_version(&old, 1), |_| ()).unwrap();
    assert!(resumed.checkpoint() == text, "the same training under the names of today");

    let later = Trainer::resume(task(), &of_version(&text, 3), |_| ()).err().unwrap().to_string();
    assert_eq!(later, "checkpoint: its version is 3; valid: 1 to 2");
}

#[test]
fn a_training_may_go_on_with_other_options() {
    let text = trained(2, 2).checkpoint();
    let mut other = Trainer::resume(task(), &text, |options| options.env_batches = 3).unwrap();
    assert!(other.best().is_some(), "what was best is still measured for the same aim");
    let before = other.curve().last().unwrap().samples;
    let after = other.iterate().samples;
    assert_eq!(after - before, 3 * 64 * 8, "three batches play");
    let smoother = Trainer::resume(task(), &text, |options| options.smoothness = 0.5).unwrap();
    assert!(smoother.best().is_none(), "a policy learnt without smoothness is no measure");
    let refusal = Trainer::resume(task(), &text, |options| options.smoothness = f32::NAN).err().unwrap().to_string();
    assert!(refusal.contains("smoothness"), "{refusal}");
}

#[test]
fn a_training_may_begin_with_a_policy() {
    let (layers, contract) = trained_policy(&task(), &trained(2, 4).present(), "stroking.clip.ron");
    let (layers, contract) = layers_from_bytes(&policy_bytes(&layers, &contract).unwrap(), "before").unwrap();
    let mut trainer = Trainer::from_policy(task(), options(2), &layers, &contract).unwrap();
    let same = |trainer: &Trainer| DenseLayers::from(&trainer.present().actor) == layers;
    assert!(same(&trainer));
    let (first, learnt) = (trainer.iterate(), (0..9).map(|_| trainer.iterate()).last().unwrap());
    assert!(same(&trainer), "the critic learns alone at first");
    assert!(learnt.critic_loss < first.critic_loss, "{} {}", first.critic_loss, learnt.critic_loss);
    assert!(trainer.best().unwrap().evaluation.1 > 0.0, "the policy itself has been measured");
    trainer.iterate();
    assert!(!same(&trainer), "then the actor learns too");

    let mut other = contract.clone();
    other.action.scale *= 2.0;
    let error = Trainer::from_policy(task(), options(2), &layers, &other).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("action.scale"), "{error}");
    other = contract;
    other.observation[0].size -= 1;
    let error = Trainer::from_policy(task(), options(2), &layers, &other).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("observation"), "{error}");
}

#[test]
fn a_policy_without_gains_may_begin_one_that_sets_them() {
    let (layers, contract) = trained_policy(&task(), &trained(2, 4).present(), "stroking.clip.ron");
    let model = preset("skater").unwrap();
    let clip = KeyPoses::from_ron(POSES, "stroking").unwrap().to_clip(&model).unwrap();
    let mut skill = task().skill.clone();
    let links = model.links[1..3].iter().map(|link| link.name.clone()).collect();
    skill.gain_action = Some(GainAction { links, factor: 3.0 });
    let wider = SkillTask::new(&skill, model, &clip).unwrap();
    let trainer = Trainer::from_policy(wider, options(2), &layers, &contract).unwrap();
    let actor = DenseLayers::from(&trainer.present().actor);
    let (inputs, outputs) = (actor.sizes[actor.sizes.len() - 2], layers.outputs());
    assert_eq!(actor.outputs(), outputs + 2);
    let (last, before) = (actor.layers.last().unwrap(), layers.layers.last().unwrap());
    assert_eq!(last.weights[..outputs * inputs], before.weights[..], "what it did before it still does");
    assert!(last.weights[outputs * inputs..].iter().chain(&last.bias[outputs..]).all(|w| *w == 0.0));
}

#[test]
fn trials_begin_as_the_policy_before_leaves_its_motion() {
    let skill = SkillDefinition::load("assets/skills/skating/forward_three_turn/forward_three_turn.skill.ron").unwrap();
    let mut task = load_task(&skill, None).unwrap();
    let file = skill.after.first().unwrap();
    let mut other = SkillDefinition::load(file).unwrap();
    other.after.clear();
    let other = load_task(&other, None).unwrap();
    let (layers, contract) = load_layers(file.with_file_name("policy.onnx")).unwrap();
    let found = follow_policy(&mut task, 0, &other, &layers, &contract).unwrap();
    let before = &task.before[0];
    assert!(found == before.bodies.len() && found >= 100, "{found} bodies");
    let left = before.motion.tick(before.transition.leave);
    let height = left.pose.root_position.y - left.support;
    for body in before.bodies.iter() {
        assert!((body.height - height).abs() < 0.12, "{} against {height} in the motion", body.height);
        assert!(body.linear.z < 0.0, "it goes ahead: {}", body.linear);
    }
    let spread =
        before.bodies.iter().map(|b| b.linear.z).fold((0.0, f64::MIN), |s: (f64, f64), z| (s.0.min(z), s.1.max(z)));
    assert!(spread.1 - spread.0 > 0.1, "at different speeds: {spread:?}");

    // A row of the table in which every trial begins so.
    let row = TrialRow { after: true, ..TrialRow::named("after") };
    let judged = Arc::new(task.trial(&row).unwrap());
    let starts = StartSampler::uniform(judged.motion.last(), judged.motion.cycle().is_some());
    let trials = Environment::<F32x8>::new(judged, 5, 0, &starts);
    let entries: Vec<usize> = task.before.iter().map(|before| before.transition.enter).collect();
    assert!(!entries.contains(&0) && (0..8).all(|lane| entries.contains(&trials.tracker.tick(lane))), "{entries:?}");
    let mut alone = task.clone();
    alone.before.clear();
    let error = alone.trial(&row).unwrap_err().to_string();
    assert!(error.contains("`after`") && error.contains(&task.skill.name), "{error}");

    let mut narrow = other;
    narrow.skill.observe.push(ObservationTerm::FootForces);
    narrow.layout = Arc::new(narrow.skill.layout(&narrow.model));
    let error = follow_policy(&mut task, 0, &narrow, &layers, &contract).unwrap_err().to_string();
    assert!(error.contains("observation"), "{error}");
}

#[test]
fn measurements_leave_the_time_to_learning() {
    let measured = |evaluation_share: f64| {
        let mut trainer = Trainer::new(task(), TrainOptions { evaluation_share, ..options(1) }).unwrap();
        (0..8).filter(|_| trainer.iterate().evaluation.is_some()).count()
    };
    // Every second iteration; the first is always measured, the others where earlier ones took less than their share.
    assert_eq!(measured(1.0), 4);
    assert_eq!(measured(0.0), 1);
    let refusal = Trainer::new(task(), TrainOptions { evaluation_share: 1.5, ..options(1) }).err().unwrap().to_string();
    assert!(refusal.contains("evaluation_share is 1.5; 0 to 1"), "{refusal}");
}

#[test]
fn exploration_anneals_once_the_motion_can_be_done() {
    let last_std = |seconds: f64, rows: usize| {
        let mut easy = task();
        // Trials that end before anybody can fall can be done. A push that throws the skater is none of them.
        easy.skill.trial.seconds = seconds;
        let row = |k: usize| TrialRow {
            push: (k > 0 && k + 1 == rows).then(|| push("spine", 9e4)),
            ..TrialRow::named(k.to_string())
        };
        easy.skill.trial.rows = (0..rows).map(row).collect();
        let options = TrainOptions { anneal_samples: 1.0, action_std: (0.1, 0.1), anneal: (0.5, 0.5), ..options(1) };
        let mut trainer = Trainer::new(easy, options).unwrap();
        (0..4).map(|_| trainer.iterate().action_std).last().unwrap()
    };
    assert_eq!(last_std(0.1, 1), 0.05);
    assert_eq!(last_std(10.0, 1), 0.1);
    // Not while one row of many fails.
    assert_eq!(last_std(0.1, 16), 0.1);
}

#[test]
fn options_that_cannot_be_used_are_refused_by_name() {
    let refused = |options: TrainOptions| Trainer::new(task(), options).err().unwrap().to_string();
    let refusal = refused(TrainOptions { kl: 0.0, ..options(1) });
    assert!(refusal.contains("kl is 0; more than 0"), "{refusal}");
    let refusal = refused(TrainOptions { learning_rate: f32::NAN, ..options(1) });
    assert!(refusal.contains("learning_rate is NaN; more than 0"), "{refusal}");
    let refusal = refused(TrainOptions { hidden: vec![], ..options(1) });
    assert!(refusal.contains("hidden is []; 1 to 8 layers"), "{refusal}");
}

#[test]
fn the_policy_that_is_kept_is_a_mean_of_the_actors() {
    let run = |average: usize| {
        let mut trainer = Trainer::new(task(), TrainOptions { average, ..options(1) }).unwrap();
        for _ in 0..9 {
            trainer.iterate();
        }
        trainer.present().actor
    };
    let (last, mean, first) = (run(1), run(1000), trained(1, 0).present().actor);
    let way = |to: &bevy_athlete::train::nn::Network| -> f32 {
        to.parameters().iter().zip(first.parameters()).map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt()
    };
    assert!(way(&mean) > 0.0 && way(&mean) < way(&last), "{} of {}", way(&mean), way(&last));
}

struct Network<'a>(&'a Trained);

impl Actor for Network<'_> {
    type Scratch = bevy_athlete::train::nn::Activations;
    fn act<'a>(&'a self, scratch: &'a mut Self::Scratch, seen: &'a mut [f32], rows: usize) -> &'a [f32] {
        self.0.normalizer.apply(seen);
        self.0.actor.forward(scratch, seen, rows)
    }
}

#[test]
fn the_exported_policy_acts_as_the_trained_one() {
    let trainer = trained(2, 2);
    let task = trainer.task().clone();
    let policy = trainer.present();
    let bytes = {
        let (layers, contract) = trained_policy(&task, &policy, "stroking.clip.ron");
        policy_bytes(&layers, &contract).unwrap()
    };
    let loaded = Policy::from_bytes(&bytes, "stroking").unwrap();
    loaded.check_for(&task.model).unwrap();
    let skill: SkillDefinition = loaded.contract().parse_skill_settings().unwrap();
    assert_eq!(skill, task.skill);

    let size = task.layout.size();
    let rows = 5;
    let seen: Vec<f32> = (0..rows * size).map(|k| ((k * 37 % 101) as f32 - 50.0) / 40.0).collect();
    let mut out = Vec::new();
    loaded.act(&seen, rows, &mut out).unwrap();
    let acts = |policy: &Trained| Network(policy).act(&mut Default::default(), &mut seen.clone(), rows).to_vec();
    let largest_of = |values: &mut dyn Iterator<Item = f32>| values.map(f32::abs).fold(0.0, f32::max);
    let apart = |other: &[f32]| largest_of(&mut out.iter().zip(other).map(|(a, b)| a - b));
    // The file holds the parameters in half precision: with these, the trainer's network acts as the file does ...
    let mut rounded = policy.clone();
    for parameter in rounded.actor.parameters_mut() {
        *parameter = half::f16::from_f32(*parameter).to_f32();
    }
    let expected = acts(&rounded);
    let (worst, largest) = (apart(&expected), largest_of(&mut expected.iter().copied()));
    println!("tract against the trainer: {worst:.2e} of {largest:.2e} (allowed 1e-5 of that)");
    assert!(largest > 0.0 && worst < 1e-5 * largest, "{worst} of {largest}");
    // ... and rounding changes no more than half a unit in the last of 11 bits for each of the four layers.
    let moved = apart(&acts(&policy));
    println!("rounding: {moved:.2e} of {largest:.2e} (allowed 4 x 2^-11 of that)");
    assert!(moved < 4.0 * 2f32.powi(-11) * largest, "{moved} of {largest}");

    // Trials come out alike, whatever the number of threads.
    let count = |threads| evaluate::<F32x8, _>(&task, &loaded, 16, 5, threads);
    assert_eq!(count(1), count(2));
}

#[test]
fn a_game_plays_what_was_trained() {
    // The player of a game does step for step what a trial of the training does (but for the rounding of its own place and heading).
    let mut skill = task().skill.clone();
    skill.training_rate = None;
    skill.episode = EpisodeOptions {
        start: Some((0.0, 0.0)),
        friction: None,
        joint_noise: 0.0,
        velocity_noise: 0.0,
        joint_velocity_noise: 0.0,
        ..EpisodeOptions::default()
    };
    let model = task().model.clone();
    let task = Arc::new(SkillTask::new(&skill, model.clone(), &task().clip).unwrap());
    let (layers, contract) = trained_policy(&task, &trained(2, 2).present(), "stroking.clip.ron");
    let policy = Policy::from_bytes(&policy_bytes(&layers, &contract).unwrap(), "stroking").unwrap();

    let mut trial = Environment::<f64>::new(task.clone(), 1, 1, &StartSampler::uniform(1, true));
    let trained = TrainedSkill::new(skill, &task.clip, policy.clone(), &model).unwrap();
    let mut player = SkillPlayer::new(Arc::new(trained), model.step_rate).unwrap();
    let mut sim = Simulator::<f64>::new(model.clone(), task.settings);
    let forwards = Heading::of(bevy_athlete::math::Quat::splat(task.motion.tick(0).pose.root_rotation));
    player.begin(&mut sim, forwards, DVec3::ZERO, None);

    let (mut row, mut action) = (vec![0.0; task.layout.size()], Vec::new());
    for tick in 0..40 {
        trial.observe(&mut row);
        policy.act(&row, 1, &mut action).unwrap();
        trial.tick(&action);
        for _ in 0..(model.step_rate / 30.0) as usize {
            player.drive(&mut sim, &task.world).unwrap();
            step(&mut sim, &task.world);
            player.after_step(&mut sim, &task.world);
        }
        let away = (trial.sim.state.root_position - sim.state.root_position).lane(0).length();
        assert!(away < 1e-7, "tick {tick}: {away}");
        assert_eq!(trial.tracker.tick(0), player.tick());
    }

    // A body that is taken over in the middle is where its reference is, and stays so however it is turned.
    let turned = Heading { c: 0.6, s: 0.8 };
    player.begin(&mut sim, turned, DVec3::new(3.0, 0.0, -2.0), None);
    let root = sim.state.root_position.lane(0);
    assert!((root.x - 3.0).abs() < 1e-9 && (root.z + 2.0).abs() < 1e-9, "{root}");
    let faces = Heading::of(sim.state.root_rotation);
    assert!((faces.c - 0.6).abs() < 1e-9 && (faces.s - 0.8).abs() < 1e-9, "{faces:?}");
    player.join(&mut sim, 0);
    let reference = player.reference_pose();
    assert!((reference.root_position - root).length() < 1e-6, "{}", reference.root_position - root);
    let angle = reference.root_rotation.angle_between(sim.state.root_rotation.lane(0));
    assert!(angle < 0.05, "{angle}");
}

#[test]
fn a_trial_ends_when_the_reference_was_dragged_round() {
    let limited = |skill: &SkillDefinition, turn| {
        let mut skill = skill.clone();
        skill.max_reference_drift = Some(0.3);
        skill.episode = EpisodeOptions {
            start: Some((0.0, 0.0)),
            joint_noise: 0.0,
            velocity_noise: 0.0,
            joint_velocity_noise: 0.0,
            ..EpisodeOptions::default()
        };
        skill.limits = TerminationLimits {
            height: 10.0,
            root: 10.0,
            pose: 10.0,
            place: 1e3,
            touch: false,
            turn,
            ..TerminationLimits::default()
        };
        skill
    };
    let first_end = |skill: SkillDefinition, clip: &MotionClip, hold: &dyn Fn(&mut Environment<f64>, usize)| {
        let task = Arc::new(SkillTask::new(&skill, preset("skater").unwrap(), clip).unwrap());
        let still = vec![0.0; task.action_size()];
        let mut trial = Environment::<f64>::new(task, 1, 1, &StartSampler::uniform(1, true));
        (1..=60).find(|tick| {
            hold(&mut trial, *tick);
            trial.tick(&still)[0].status == EpisodeStatus::Terminated
        })
    };

    // A body that turns by 0.1 rad in a tick drags the reference from half a radian on: 0.8 rad further after 13 ticks.
    let alone = task();
    let spins = |trial: &mut Environment<f64>, tick: usize| {
        let pose = &alone.motion.tick(0).pose;
        let turn = glam::DQuat::from_rotation_y(0.1 * tick as f64);
        trial.sim.state.set_pose(0, pose.root_position, turn * pose.root_rotation, &pose.joints);
        trial.sim.state_changed();
    };
    assert_eq!(first_end(limited(&alone.skill, None), &alone.clip, &spins), None);
    let tick = first_end(limited(&alone.skill, Some(0.8)), &alone.clip, &spins).expect("dragged round, and goes on");
    assert!((11..=20).contains(&tick), "{tick}");

    // A cycle that turns is no dragging: a body held on its reference goes round the circle.
    let path = "assets/skills/skating/forward_crossover/forward_crossover.skill.ron";
    let skill = SkillDefinition::load(path).unwrap();
    let clip = MotionClip::load(&skill.motion).unwrap();
    let follows = |trial: &mut Environment<f64>, _: usize| {
        let pose = trial.tracker.reference_pose(0);
        trial.sim.state.set_pose(0, pose.root_position, pose.root_rotation, &pose.joints);
        trial.sim.state_changed();
    };
    assert_eq!(first_end(limited(&skill, Some(0.05)), &clip, &follows), None);
}

#[test]
fn a_lane_put_onto_its_reference_is_there() {
    let task = task();
    let mut sim = Simulator::<F32x8Fused>::new(task.model.clone(), SimulationSettings::of(&task.model));
    let mut tracker = Tracker::new(task.motion.clone(), TrackerOptions::default(), task.layout.clone());
    for lane in 0..F32x8Fused::LANES {
        tracker.begin(&mut sim, lane, 5 * lane, task.motion.mean_speed());
    }
    let terms = tracker.terms(&mut sim, &task.weights, &task.feet);
    for lane in 0..F32x8Fused::LANES {
        let all = [terms.pose, terms.velocity, terms.ends, terms.root, terms.spin, terms.com_velocity, terms.place];
        let worst = all.iter().map(|t| t.lane(lane)).fold(0.0, f64::max);
        assert!(worst < 1e-4 && terms.height.lane(lane).abs() < 1e-4, "lane {lane}: {worst}");
    }
    let mut seen = Vec::new();
    tracker.observe(&mut sim, &mut seen);
    assert_eq!(seen.len(), task.layout.size());

    // Turned and pushed away, the reference that may drift by half a metre is half a metre off.
    let options = TrackerOptions { max_reference_drift: Some(0.5), ..TrackerOptions::default() };
    let mut tracker = Tracker::new(task.motion.clone(), options, task.layout.clone());
    for lane in 0..F32x8Fused::LANES {
        tracker.begin(&mut sim, lane, 0, 2.0);
    }
    sim.state.root_position += Vec3::splat(glam::DVec3::new(3.0, 0.0, 0.0));
    sim.state_changed();
    tracker.advance(&sim);
    let away = tracker.terms(&mut sim, &task.weights, &task.feet).place.lane(0).sqrt();
    assert!((away - 0.5).abs() < 1e-3, "{away}");
}

#[test]
fn a_cycle_goes_on_where_it_ended() {
    let model = preset("skater").unwrap();
    let mut poses = KeyPoses::from_ron(POSES, "stroking").unwrap();
    (poses.repeat, poses.acceleration) = (1, 0.0);
    let clip = poses.to_clip(&model).unwrap();
    let motion = TrackedMotion::cyclic(&clip, &model, 30.0, true).unwrap();
    let (first, last) = (motion.tick(0), motion.tick(motion.last()));
    let moved = motion.cycle().unwrap().apply(first.pose.root_position);
    assert!(moved.distance(last.pose.root_position) < 1e-9);
    let worst = first.pose.joints.iter().zip(&last.pose.joints).map(|(a, b)| 1.0 - a.dot(*b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-12, "{worst}");
    assert!((motion.mean_speed() - 2.4).abs() < 0.1, "{}", motion.mean_speed());
    for tick in 0..=motion.last() {
        let sum: f64 = motion.tick(tick).phase.iter().sum();
        assert!((sum - 1.0).abs() < 1e-9, "tick {tick}: {sum}");
    }

    // A tracker that runs over the seam keeps the reference's speed.
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
    let mut tracker =
        Tracker::new(Arc::new(motion), TrackerOptions::default(), Arc::new(ObservationLayout::of(&model)));
    tracker.begin(&mut sim, 0, 0, 2.4);
    let mut before = tracker.reference_root();
    for _ in 0..80 {
        tracker.advance(&sim);
        let now = tracker.reference_root();
        let speed = (now - before).length() * 30.0;
        assert!((1.8..3.0).contains(&speed), "{speed} m/s at tick {}", tracker.tick(0));
        before = now;
    }
}

#[test]
fn headings_turn_without_trigonometry() {
    for degrees in [-179.0_f64, -91.0, -30.0, 0.0, 44.0, 90.0, 135.0, 180.0] {
        let angle = degrees.to_radians();
        let q = glam::DQuat::from_rotation_y(angle) * glam::DQuat::from_rotation_x(0.3);
        let heading = Heading::<f64>::of(bevy_athlete::math::Quat::splat(q));
        assert!((heading.c - angle.cos()).abs() < 1e-12 && (heading.s - angle.sin()).abs() < 1e-12, "{degrees}");
        let turned = heading.to_quat().rotate(Vec3::splat(glam::DVec3::NEG_Z)).lane(0);
        assert!(turned.distance(glam::DQuat::from_rotation_y(angle) * glam::DVec3::NEG_Z) < 1e-8, "{degrees}");
        let v = Vec3::splat(glam::DVec3::new(1.0, 2.0, 3.0));
        assert!((heading.to_local(heading.to_world(v)) - v).length() < 1e-12);
    }
}

#[test]
fn skills_that_cannot_be_used_are_refused_by_field() {
    let with = |text: &str| {
        let whole = format!("(name: \"s\", character: \"skater\", motion: \"m.bvh\", {text})");
        SkillDefinition::from_ron(&whole, "s.skill.ron").err().map(|e| e.to_string())
    };
    assert_eq!(with(""), None);
    for (text, named) in [
        ("control_rate: 0.0", "control_rate"),
        ("training_rate: 100.0", "training_rate"),
        ("action_scale: NaN", "action_scale"),
        ("world: \"moon\"", "world"),
        ("window: (2.0, 1.0)", "window"),
        ("gains: (-1.0, 2.0)", "gains"),
        ("episode: (seconds: 0.0)", "episode.seconds"),
        ("episode: (friction: (0.2, 0.1))", "episode.friction"),
        ("limits: (turn: 4.0)", "limits.turn"),
        ("unknown: 1", "unknown"),
    ] {
        let refusal = with(text).unwrap_or_else(|| panic!("{text} was accepted"));
        assert!(refusal.contains(named), "{text}: {refusal}");
    }
    let mut task = task();
    assert!(task.at_rate(1000.0).is_err());
    task.skill.episode.push = Some(push("wing", 1.0));
    let refusal = SkillTask::new(&task.skill, task.model.clone(), &task.clip).err().unwrap().to_string();
    assert!(refusal.contains("wing") && refusal.contains("pelvis"), "{refusal}");
}
