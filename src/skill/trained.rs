//! A skill that was learnt, and the player that performs it.

use crate::asset::clip::{ClipError, MotionClip};
use crate::asset::{Course, CourseError, StateError, StateReader, StateWriter};
use crate::contact::Terrain;
use crate::control::tracking::{
    AllLanes, Heading, ObservationLayout, PolicyMirror, SeenBody, Support, TARGET_SUBSTEPS, TrackedMotion, Tracker,
    mirror_links,
};
use crate::control::{Policy, PolicyError};
use crate::math::Vec3;
use crate::model::{CharacterModel, ModelPose, SharedModel};
use crate::sim::Simulator;
use crate::skill::{BadParameter, ENTRY, SkillDefinition, SkillError, SkillParameters};
use glam::DVec3;
use std::sync::Arc;

/// Why a trained skill cannot be performed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrainedSkillError {
    /// The description.
    #[error(transparent)]
    Skill(#[from] SkillError),
    /// The motion.
    #[error(transparent)]
    Clip(#[from] ClipError),
    /// The policy.
    #[error(transparent)]
    Policy(#[from] PolicyError),
    /// The course that it was learnt on.
    #[error(transparent)]
    Course(Box<CourseError>),
}

impl From<CourseError> for TrainedSkillError {
    fn from(error: CourseError) -> Self {
        Self::Course(Box::new(error))
    }
}

/// What the name of a mirrored skill ends with.
const MIRRORED: &str = "_mirrored";

/// A description, its motion and its policy, checked against each other and the character.
#[derive(Clone, Debug)]
pub struct TrainedSkill {
    /// The description.
    pub definition: SkillDefinition,
    /// The motion, tick by tick.
    pub motion: Arc<TrackedMotion>,
    /// What the policy sees.
    pub layout: Arc<ObservationLayout>,
    /// The policy.
    pub policy: Policy,
    /// Set where the skill is performed to the other side than it was learnt.
    pub mirror: Option<Arc<PolicyMirror>>,
}

impl TrainedSkill {
    /// Puts the parts together. Fails where they do not fit.
    pub fn new(
        definition: SkillDefinition,
        clip: &MotionClip,
        policy: Policy,
        model: &CharacterModel,
    ) -> Result<Self, TrainedSkillError> {
        definition.validate()?;
        definition.check_links(model)?;
        definition.check_policy(&policy, model)?;
        let layout = definition.layout(model);
        let motion = Arc::new(definition.prepare_motion(clip, model)?);
        Ok(Self { definition, motion, layout: Arc::new(layout), policy, mirror: None })
    }

    /// The same skill with a motion that knows where it stands on the obstacles it was made for, as in its training. Without it, all
    /// footholds of the motion count as level ground.
    pub fn on_course(mut self, course: &Course, model: &CharacterModel) -> Result<Self, TrainedSkillError> {
        let mut motion = TrackedMotion::clone(&self.motion);
        self.definition.stand_on_course(&mut motion, course, &self.definition.named_world(), model)?;
        self.motion = Arc::new(motion);
        Ok(self)
    }

    /// The same skill to the other side, called `NAME_mirrored`: the motion's image, and a policy that sees the image of
    /// the body and whose action is mirrored back. Mirrored twice it is the skill again.
    pub fn mirrored(&self, model: &CharacterModel) -> Self {
        let mut definition = self.definition.clone();
        definition.name = match definition.name.strip_suffix(MIRRORED) {
            Some(name) => name.into(),
            None => definition.name + MIRRORED,
        };
        let mirror = self.mirror.is_none().then(|| Arc::new(PolicyMirror::new(model, &self.layout)));
        let motion = Arc::new(self.motion.mirrored(&mirror_links(model)));
        Self { definition, motion, layout: self.layout.clone(), policy: self.policy.clone(), mirror }
    }

    /// Last tick at which it may be entered, see [`ENTRY`].
    pub fn entry_ticks(&self) -> usize {
        (ENTRY * self.definition.control_rate).round() as usize
    }

    /// First tick at which it may be left, where that is not its end.
    pub fn exit_tick(&self) -> Option<usize> {
        self.definition.exit_tick()
    }

    /// The name.
    pub fn name(&self) -> &str {
        &self.definition.name
    }
}

/// Performs a trained skill with one body: the same sequence as in training, [`SkillPlayer::drive`] before each step,
/// [`SkillPlayer::after_step`] after it.
#[derive(Clone, Debug)]
pub struct SkillPlayer {
    skill: Arc<TrainedSkill>,
    tracker: Tracker<f64>,
    /// Steps since the tick began, and steps in a part of a tick.
    step: usize,
    steps_per_part: usize,
    steering: f64,
    seen: Vec<f64>,
    row: Vec<f32>,
    action: Vec<f32>,
    spare: Vec<f32>,
    /// The last action held a number that is none.
    bad_action: bool,
    /// Nothing is known of what carries the body.
    arrives: bool,
}

/// Who agrees in policy and step decides together; who is at nearly the same tick touches the ice with the same blade.
#[cfg(feature = "engine")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Rhythm {
    pub policy: usize,
    pub step: usize,
    pub tick: usize,
}

impl SkillPlayer {
    /// A player at the start of the skill. `rate` is that of the simulation, steps per second; `None` if it is no multiple
    /// of [`TARGET_SUBSTEPS`] times the decisions per second.
    pub fn new(skill: Arc<TrainedSkill>, rate: f64) -> Option<Self> {
        let steps_per_part = steps_per_part(&skill, rate)?;
        let tracker = Tracker::new(skill.motion.clone(), skill.definition.tracker_options(), skill.layout.clone());
        let inputs = skill.policy.contract().observation_size();
        let mut player = Self {
            tracker,
            step: 0,
            steps_per_part,
            steering: 0.0,
            seen: Vec::with_capacity(inputs),
            row: Vec::with_capacity(inputs),
            action: Vec::new(),
            spare: Vec::new(),
            bad_action: false,
            arrives: true,
            skill,
        };
        player.put_parameters(&player.skill.definition.default_parameters());
        Some(player)
    }

    /// The skill.
    pub fn skill(&self) -> &Arc<TrainedSkill> {
        &self.skill
    }
    /// Tick of the motion.
    pub fn tick(&self) -> usize {
        self.tracker.tick(0)
    }
    /// Whether a motion that ends has ended.
    pub fn is_finished(&self) -> bool {
        self.tracker.is_finished(0)
    }
    /// Whether the next [`SkillPlayer::drive`] makes a decision.
    pub fn at_decision(&self) -> bool {
        self.step == 0
    }
    /// Which policy decides, steps since its last decision, and the tick of the motion.
    #[cfg(feature = "engine")]
    pub(crate) fn rhythm(&self) -> Rhythm {
        Rhythm { policy: self.skill.policy.address(), step: self.step, tick: self.tick() }
    }
    /// Whether a part of a tick begins with the next [`SkillPlayer::drive`].
    fn commands_now(&self) -> bool {
        self.step.is_multiple_of(self.steps_per_part)
    }
    /// Whether the action of the last decision held a number that is not finite.
    pub fn bad_action(&self) -> bool {
        self.bad_action
    }
    /// Goes on at another rate of the simulation, steps per second. False, and nothing changes, if the rate does not fit
    /// the decisions or the present time lies between two of its steps.
    pub fn set_rate(&mut self, rate: f64) -> bool {
        let Some(parts) = steps_per_part(&self.skill, rate) else { return false };
        let scaled = self.step * parts;
        let fits = scaled.is_multiple_of(self.steps_per_part);
        if fits {
            self.step = scaled / self.steps_per_part;
            self.steps_per_part = parts;
        }
        fits
    }

    /// What it remembers; the skill itself is not part of it.
    pub fn write_state(&self, out: &mut StateWriter) {
        self.tracker.write_state(0, out);
        out.count(self.steps_per_part);
        out.count(self.step);
        out.number(self.steering);
        out.switch(self.bad_action);
        out.switch(self.arrives);
    }
    /// Goes to where a player of the same skill was.
    pub fn read_state(&mut self, from: &mut StateReader) -> Result<(), StateError> {
        self.tracker.read_state(0, from)?;
        self.steps_per_part = from.below("steps in a part of a decision", 100_000)?.max(1);
        self.step = from.below("step since the decision", TARGET_SUBSTEPS * self.steps_per_part)?;
        self.steering = from.number("steering")?;
        self.bad_action = from.switch("whether the action was bad")?;
        self.arrives = from.switch("whether the ground is unknown")?;
        Ok(())
    }

    /// What the policy saw at its last decision, in the order of its contract; empty before the first.
    pub fn observation(&self) -> &[f32] {
        &self.row
    }
    /// What the policy said at its last decision, three numbers for each link but the root; empty before the first.
    pub fn action(&self) -> &[f32] {
        &self.action
    }
    /// Where the reference is, world frame; between two decisions on its way from one to the next.
    pub fn reference_pose(&self) -> ModelPose {
        let steps = (TARGET_SUBSTEPS * self.steps_per_part) as f64;
        self.tracker.reference_pose_at(0, self.step as f64 / steps)
    }
    /// Commands a mean speed, m/s.
    pub fn set_speed(&mut self, speed: f64) {
        self.tracker.set_speed(0, speed);
    }
    /// By how much its way is turned, rad/s, positive to the left.
    pub fn steering(&self) -> f64 {
        self.steering
    }
    /// Turns the way by so much, rad/s, positive to the left.
    pub fn set_steering(&mut self, rate: f64) {
        self.steering = rate;
    }

    /// What carries the body.
    pub fn support(&self) -> Support<f64> {
        *self.tracker.support()
    }
    /// Tells it what carries the body, before it joins: the height of the ground (world, m) and its velocity (m/s).
    pub fn set_support(&mut self, support: &Support<f64>) {
        self.tracker.set_support(0, support.height, support.velocity.lane(0));
        self.arrives = false;
    }
    /// Looks at what is ahead, before a decision; before the first one also at what the body was put on.
    pub(crate) fn look_ahead(&mut self, sim: &mut Simulator<f64>, terrain: &impl Terrain<f64>) {
        if std::mem::take(&mut self.arrives) {
            self.tracker.sense_start(sim, terrain);
        }
        self.tracker.look_ahead(sim, terrain);
    }
    /// Heights of the ground at `distances` (m) ahead of the root on the reference's way, m against what carries the body.
    pub(crate) fn profile(
        &self,
        sim: &Simulator<f64>,
        terrain: &impl Terrain<f64>,
        distances: &[f64],
        heights: &mut [f64],
    ) {
        self.tracker.profile(sim, terrain, distances, heights);
    }
    /// The way that the reference goes over the ground, world axes.
    pub(crate) fn way(&self) -> DVec3 {
        self.tracker.way().lane(0)
    }
    /// The skill's parameters, in the order of its file.
    pub fn parameters(&self) -> &[f64] {
        self.tracker.parameters(0)
    }
    /// Sets the skill's parameters, in the order of its file; each is kept within its range. What is warped by them is so from now on:
    /// in the middle of a motion the reference jumps.
    pub fn set_parameters(&mut self, values: &[f64]) {
        let ranges = &self.skill.definition.parameters;
        let values: Vec<f64> = values.iter().zip(ranges).map(|(v, p)| v.min(p.range.1).max(p.range.0)).collect();
        if values.len() == ranges.len() && values != self.parameters() {
            self.put_parameters(&values);
        }
    }
    fn put_parameters(&mut self, values: &[f64]) {
        self.tracker.set_parameters(0, values, &self.skill.definition.normalise(values));
    }
    /// Sets the skill's parameters by name; those that are not wished for go back to the values that the motion was made for. What is
    /// wrong with a wish is told with its name.
    pub fn choose_parameters(&mut self, wished: &SkillParameters, tell: impl FnMut(&str, BadParameter)) {
        if !self.skill.definition.parameters.is_empty() {
            let values = self.skill.definition.choose_parameters(wished, tell);
            self.set_parameters(&values);
        }
    }

    fn set_gains(&self, sim: &mut Simulator<f64>) {
        let model: SharedModel = sim.model().clone();
        for (command, link) in sim.commands.iter_mut().zip(&model.links).skip(1) {
            (command.kp, command.kd) = (link.gains.kp, link.gains.kd);
        }
        self.tracker.set_gains(sim);
    }

    /// Puts the body into the motion's first pose, its root above `place` and facing `heading`, at the commanded speed.
    pub fn begin(&mut self, sim: &mut Simulator<f64>, heading: Heading<f64>, place: DVec3, speed: Option<f64>) {
        let faces = Heading::of(crate::math::Quat::<f64>::splat(self.skill.motion.tick(0).pose.root_rotation));
        let speed = speed.unwrap_or(self.skill.motion.mean_speed());
        self.tracker.begin_at(sim, 0, 0, speed, heading.relative_to(faces), place);
        self.arrives = true;
        self.tracker.set_speed(0, speed);
        self.step = 0;
        self.set_gains(sim);
    }

    /// Takes over a moving body at a tick of the motion. Commands the speed that the body has, within those that the policy
    /// was trained for.
    pub fn join(&mut self, sim: &mut Simulator<f64>, tick: usize) {
        self.tracker.join(sim, 0, tick);
        let velocity = sim.total_momentum().linear.lane(0) / sim.model().mass();
        let mean = self.skill.motion.mean_speed();
        let (least, most) = self.skill.definition.episode.speed.unwrap_or((mean, mean));
        self.tracker.set_speed(0, (velocity * DVec3::new(1.0, 0.0, 1.0)).length().clamp(least, most));
        self.step = 0;
        self.set_gains(sim);
    }

    /// Sets the servo targets of the coming step, after a look at what is ahead where there is a decision to make. Call it before each
    /// step. An action that is no number counts as none.
    pub fn drive(&mut self, sim: &mut Simulator<f64>, terrain: &impl Terrain<f64>) -> Result<(), PolicyError> {
        if self.at_decision() {
            self.look_ahead(sim, terrain);
            self.observe(&AllLanes::of(sim));
            self.decide_alone()?;
        }
        self.move_targets(sim);
        Ok(())
    }

    /// Moves the servo targets to where they are in the coming step, which is counted; false if they stay.
    pub(crate) fn move_targets(&mut self, sim: &mut Simulator<f64>) -> bool {
        let part = (self.step / self.steps_per_part) as f64 / TARGET_SUBSTEPS as f64;
        // Once the ramp is over, they are there.
        let moves = self.commands_now() && part < self.tracker.options().ramp;
        if moves {
            self.tracker.command(sim, part + 1.0 / TARGET_SUBSTEPS as f64);
        }
        self.step += 1;
        if self.step == TARGET_SUBSTEPS * self.steps_per_part {
            self.step = 0;
        }
        moves
    }

    /// After the last step of a tick looks at what carries the body, and moves the reference on; call it after each step, on what the
    /// step was made.
    pub fn after_step(&mut self, sim: &mut Simulator<f64>, terrain: &impl Terrain<f64>) {
        if self.step == 0 {
            self.tracker.sense_support(sim, terrain);
            self.tracker.advance(sim);
            self.tracker.steer(self.steering / self.skill.definition.control_rate);
        }
    }

    /// Looks at the body: the first half of a decision.
    pub(crate) fn observe(&mut self, body: &impl SeenBody<f64>) {
        self.seen.clear();
        self.tracker.observe_body(body, &mut self.seen);
        self.row.clear();
        match &self.skill.mirror {
            Some(mirror) => mirror.observation(&self.seen, &mut self.row),
            None => self.row.extend(self.seen.iter().map(|v| *v as f32)),
        }
    }

    /// Asks the policy about what was observed, for this body alone: the second half of a decision.
    pub(crate) fn decide_alone(&mut self) -> Result<(), PolicyError> {
        self.skill.policy.act(&self.row, 1, &mut self.action)?;
        self.take_action();
        Ok(())
    }

    /// Decides what the policy said about what was observed: `action` is its row.
    #[cfg(feature = "engine")]
    pub(crate) fn decide(&mut self, action: &[f32]) {
        self.action.clear();
        self.action.extend_from_slice(action);
        self.take_action();
    }

    /// Makes the action the targets of the coming tick.
    fn take_action(&mut self) {
        if let Some(mirror) = &self.skill.mirror {
            mirror.action(&mut self.action, &mut self.spare);
        }
        let action = &self.action;
        self.bad_action = !action.iter().all(|v| v.is_finite());
        self.tracker.act(|link| {
            let part = |k: usize| {
                let value = f64::from(action[3 * (link - 1) + k]);
                if value.is_finite() { value.clamp(-4.0, 4.0) } else { 0.0 }
            };
            Vec3::new(part(0), part(1), part(2))
        });
        let first = 3 * (self.tracker.links() - 1);
        self.tracker.act_gains(|k| {
            let value = f64::from(action[first + k]);
            if value.is_finite() { value } else { 0.0 }
        });
    }
}

/// Steps in a part of a tick at `rate` steps per second; `None` if they are no whole number.
fn steps_per_part(skill: &TrainedSkill, rate: f64) -> Option<usize> {
    let parts = rate / (skill.definition.control_rate * TARGET_SUBSTEPS as f64);
    (parts >= 1.0 && (parts - parts.round()).abs() <= 1e-9).then(|| parts.round() as usize)
}
