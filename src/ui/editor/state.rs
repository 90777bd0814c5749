//! The editor without its panel: a document, what is selected, the jobs and what they found.

use crate::asset::clip::MotionClip;
use crate::model::{KeyPoses, LinkTransform, ModelClip, ModelPose, PRESET_NAMES, SharedModel, preset};
use crate::skill::TrainedSkill;
use crate::train::ppo::Iteration;
use crate::train::{Progress, ReconstructOptions};
use crate::ui::editor::document::{DocumentError, PoseDocument};
use crate::ui::editor::job::JobError;
use crate::ui::editor::jobs::{
    Cycle, Learnt, SimulateJob, Simulated, TrainJob, TrainNews, TrainPlan, job_threads, start_simulation,
    start_training,
};
use std::path::Path;
use std::sync::Arc;

/// Points lower than this touch the ground in a pose, m.
const TOUCHES: f64 = 0.01;

/// What the editor says under its buttons.
#[derive(Clone, Debug, PartialEq)]
pub struct EditorMessage {
    /// The text.
    pub text: String,
    /// Whether it tells of a fault.
    pub fault: bool,
}

/// What is shown beside the ghost. Each replacement has a number of its own.
#[derive(Clone, Debug)]
pub enum Performance {
    /// A control that was searched for.
    Control(Arc<Simulated>),
    /// A policy, as far as it has learnt.
    Skill(Arc<TrainedSkill>),
}

/// A contact point of the selected pose near the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactMark {
    /// Name of the point.
    pub name: String,
    /// Lowest place of its sphere, character frame, m.
    pub place: glam::DVec3,
}

/// The key-pose editor. Plain data: nothing here needs a window.
#[derive(Debug)]
pub struct PoseEditor {
    /// The file, as typed.
    pub path: String,
    /// Pose that is edited.
    pub selected: usize,
    /// Whether the ghost plays the whole motion instead of standing in the selected pose.
    pub playing: bool,
    /// How to learn.
    pub plan: TrainPlan,
    /// Folder that a learnt skill goes to; empty is `runs/NAME`.
    pub folder: String,
    /// Last thing to say.
    pub message: Option<EditorMessage>,
    /// Asks for the stage to be put beside the selected athlete.
    pub bring_here: bool,
    document: Option<PoseDocument>,
    /// Changes that are not saved may be let go.
    let_go: bool,
    model: Option<SharedModel>,
    models: Vec<SharedModel>,
    /// The pose and the motion of this revision and selection.
    shown: Option<(u64, usize, Shown)>,
    simulate: Option<SimulateJob>,
    progress: Option<Progress>,
    train: Option<TrainJob>,
    judging: bool,
    curve: Vec<Iteration>,
    /// What the last search found, and the revision of the document it belongs to.
    simulated: Option<(u64, Arc<Simulated>)>,
    simulating_revision: u64,
    learnt: Option<Arc<Learnt>>,
    performance: Option<Performance>,
    performances: u64,
    saved_to: Option<String>,
}

#[derive(Clone, Debug)]
struct Shown {
    pose: ModelPose,
    clip: Result<(MotionClip, ModelClip), String>,
    marks: Vec<ContactMark>,
}

impl Default for PoseEditor {
    fn default() -> Self {
        Self::new(Vec::new())
    }
}

impl PoseEditor {
    /// An empty editor that knows these characters besides those of the crate.
    pub fn new(models: Vec<SharedModel>) -> Self {
        Self {
            path: String::new(),
            selected: 0,
            playing: false,
            plan: TrainPlan::default(),
            folder: String::new(),
            message: None,
            bring_here: true,
            document: None,
            let_go: false,
            model: None,
            models,
            shown: None,
            simulate: None,
            progress: None,
            train: None,
            judging: false,
            curve: Vec::new(),
            simulated: None,
            simulating_revision: 0,
            learnt: None,
            performance: None,
            performances: 0,
            saved_to: None,
        }
    }

    /// Opens a file. The one that was open is let go, its jobs are cancelled; changes that were not saved keep it open at
    /// the first try.
    pub fn open(&mut self, path: impl AsRef<Path>) {
        let path = path.as_ref();
        if self.document.as_ref().is_some_and(PoseDocument::is_dirty) && !std::mem::replace(&mut self.let_go, true) {
            return self.complain("there are changes that are not saved; open it again to let them go");
        }
        match PoseDocument::open(path) {
            Ok(document) => self.edit(document),
            Err(error) => self.complain(error),
        }
    }

    /// Edits a document.
    pub fn edit(&mut self, document: PoseDocument) {
        let name = &document.poses().character;
        let known = self.models.iter().find(|m| m.name == *name).cloned().or_else(|| preset(name));
        let Some(model) = known else {
            let mut names: Vec<&str> = PRESET_NAMES.to_vec();
            names.extend(self.models.iter().map(|m| m.name.as_str()));
            return self.complain(format!("no character `{name}`; valid: {}", names.join(", ")));
        };
        let (models, plan, folder) =
            (std::mem::take(&mut self.models), self.plan.clone(), std::mem::take(&mut self.folder));
        let performances = self.performances + 1;
        *self = Self {
            path: document.path().display().to_string(),
            document: Some(document),
            model: Some(model),
            plan,
            folder,
            performances,
            ..Self::new(models)
        };
        self.refresh();
    }

    /// The document.
    pub fn document(&self) -> Option<&PoseDocument> {
        self.document.as_ref()
    }
    /// The character.
    pub fn model(&self) -> Option<&SharedModel> {
        self.model.as_ref()
    }

    /// Changes the document; a fault becomes the message.
    pub fn change(&mut self, by: impl FnOnce(&mut PoseDocument) -> Result<(), DocumentError>) {
        let Some(document) = &mut self.document else { return };
        match by(document) {
            Ok(()) => (self.message, self.let_go) = (None, false),
            Err(error) => self.complain(error),
        }
        self.refresh();
    }

    fn revision(&self) -> u64 {
        self.document.as_ref().map_or(0, PoseDocument::revision)
    }

    /// Says what went wrong.
    pub fn complain(&mut self, error: impl std::fmt::Display) {
        self.message = Some(EditorMessage { text: error.to_string(), fault: true });
    }

    fn say(&mut self, text: impl Into<String>) {
        self.message = Some(EditorMessage { text: text.into(), fault: false });
    }

    /// Saves the document.
    pub fn save(&mut self, anyway: bool) {
        let Some(document) = &mut self.document else { return };
        let other = Path::new(self.path.trim()).to_path_buf();
        let saved = if other == document.path() { document.save(anyway) } else { document.save_as(&other) };
        match saved {
            Ok(()) => self.say(format!("saved {}", other.display())),
            Err(error) => self.complain(error),
        }
    }

    /// Takes the last change back, or makes it again.
    pub fn step_history(&mut self, redo: bool) {
        if let Some(document) = &mut self.document {
            if redo {
                document.redo()
            } else {
                document.undo()
            };
            self.message = None;
            self.refresh();
        }
    }

    /// Works out pose and motion where the document or the selection changed.
    pub fn refresh(&mut self) {
        let (Some(document), Some(model)) = (&self.document, &self.model) else { return };
        let poses = document.poses();
        self.selected = self.selected.min(poses.poses.len().saturating_sub(1));
        if self.shown.as_ref().is_some_and(|(r, s, _)| (*r, *s) == (document.revision(), self.selected)) {
            return;
        }
        let clip = moving(poses).to_clip(model).map_err(|e| e.to_string());
        let clip = clip.and_then(|clip| Ok((clip.clone(), clip.to_model(model).map_err(|e| e.to_string())?)));
        let pose = standing(poses, self.selected)
            .and_then(|one| one.to_clip(model).ok())
            .and_then(|clip| clip.to_model(model).ok())
            .map_or_else(|| ModelPose::zero(model), |clip| clip.poses()[0].clone());
        let mut links = Vec::new();
        pose.link_transforms(model, &mut links);
        let marks = model.contact_points.iter().filter_map(|point| {
            let link: &LinkTransform = links.get(point.link)?;
            let place = link.position + link.rotation * point.position - glam::DVec3::Y * point.radius;
            (place.y < TOUCHES).then(|| ContactMark { name: point.name.clone(), place })
        });
        let shown = Shown { marks: marks.collect(), pose, clip };
        self.shown = Some((document.revision(), self.selected, shown));
    }

    /// Where the links of the ghost are, character frame: in the selected pose, or at the time `t` (s) of the motion, which
    /// repeats. False without a document.
    pub fn ghost(&self, t: f64, out: &mut Vec<LinkTransform>) -> bool {
        out.clear();
        let (Some((_, _, shown)), Some(model)) = (&self.shown, &self.model) else { return false };
        match &shown.clip {
            Ok((_, clip)) if self.playing || self.performance.is_some() => {
                clip.sample(t.rem_euclid(clip.duration().max(1e-9))).link_transforms(model, out);
            }
            _ => shown.pose.link_transforms(model, out),
        }
        true
    }

    /// The motion of the present poses, or why there is none.
    pub fn clip(&self) -> Option<Result<&MotionClip, &str>> {
        let (_, _, shown) = self.shown.as_ref()?;
        Some(shown.clip.as_ref().map(|(clip, _)| clip).map_err(String::as_str))
    }

    /// The points of the selected pose that touch the ground.
    pub fn marks(&self) -> &[ContactMark] {
        self.shown.as_ref().map_or(&[], |(_, _, shown)| &shown.marks)
    }

    /// Begins to search for a control that makes the body follow the poses.
    pub fn simulate(&mut self, options: ReconstructOptions) {
        let (Some(Ok(clip)), Some(model)) = (self.clip(), self.model.clone()) else {
            return self.complain("nothing to simulate: the poses give no motion");
        };
        match start_simulation(model, clip.clone(), options) {
            Ok(job) => {
                self.simulating_revision = self.revision();
                (self.simulate, self.progress, self.message) = (Some(job), None, None);
            }
            Err(error) => self.complain(error),
        }
    }

    /// [`PoseEditor::simulate`] as the button does it: with all cores but one.
    pub fn simulate_by_default(&mut self) {
        self.simulate(ReconstructOptions { threads: job_threads(), ..ReconstructOptions::default() });
    }

    /// Begins to learn: the simulated motion where there is one, else the poses.
    pub fn train(&mut self) {
        let Some(model) = self.model.clone() else { return self.complain("nothing to learn: no poses are open") };
        let simulated = self.simulated().filter(|s| s.report.fell_at.is_none());
        let plan = TrainPlan {
            cycle: self.document.as_ref().and_then(|d| Cycle::of(d.poses())),
            gains: simulated.and_then(|s| s.control.gains).or(self.plan.gains),
            ..self.plan.clone()
        };
        let simulated = simulated.map(|s| s.motion.clone());
        let Some(clip) = simulated.or_else(|| self.clip().and_then(Result::ok).cloned()) else {
            return self.complain("nothing to learn: the poses give no motion");
        };
        match start_training(model, clip, plan) {
            Ok(job) => {
                self.curve.clear();
                (self.train, self.judging, self.learnt, self.message) = (Some(job), false, None, None);
            }
            Err(error) => self.complain(error),
        }
    }

    /// The search under way and how far it is.
    pub fn simulating(&self) -> Option<(&SimulateJob, Option<Progress>)> {
        self.simulate.as_ref().map(|job| (job, self.progress))
    }
    /// The training under way, and whether it is being judged already.
    pub fn training(&self) -> Option<(&TrainJob, bool)> {
        self.train.as_ref().map(|job| (job, self.judging))
    }
    /// The curve of the last training.
    pub fn curve(&self) -> &[Iteration] {
        &self.curve
    }
    /// What the last search found, as long as the poses are those that were simulated.
    pub fn simulated(&self) -> Option<&Arc<Simulated>> {
        self.simulated.as_ref().filter(|(revision, _)| *revision == self.revision()).map(|(_, found)| found)
    }
    /// What the last training found.
    pub fn learnt(&self) -> Option<&Arc<Learnt>> {
        self.learnt.as_ref()
    }
    /// What is to be shown beside the ghost, and the number of it: it changes with every replacement.
    pub fn performance(&self) -> (u64, Option<&Performance>) {
        (self.performances, self.performance.as_ref())
    }

    /// Shows nothing beside the ghost any more.
    pub fn end_performance(&mut self) {
        self.perform(None);
    }

    fn perform(&mut self, performance: Option<Performance>) {
        self.performance = performance;
        self.performances += 1;
    }

    /// Folder that a learnt skill goes to.
    pub fn skill_folder(&self) -> String {
        let name = self.document.as_ref().map_or("skill", |d| d.poses().name.as_str());
        if self.folder.trim().is_empty() { format!("runs/{name}") } else { self.folder.trim().to_owned() }
    }

    /// Writes what was learnt into its folder.
    pub fn save_skill(&mut self) {
        let Some(learnt) = self.learnt.clone() else { return };
        let folder = self.skill_folder();
        match learnt.save(Path::new(&folder)) {
            Ok(()) => {
                self.say(format!("saved the skill and its card to {folder}"));
                self.saved_to = Some(folder);
            }
            Err(error) => self.complain(error),
        }
    }

    /// Folder that the present skill was saved to.
    pub fn saved_to(&self) -> Option<&str> {
        self.saved_to.as_deref()
    }

    /// Takes in what the jobs have told. Call it once a frame; it never waits.
    pub fn poll(&mut self) {
        if let Some(job) = &mut self.simulate {
            self.progress = job.news().pop_back().or(self.progress);
            if let Some(result) = job.result() {
                self.simulate = None;
                match result {
                    Ok(found) => self.simulation_done(found),
                    Err(JobError::Cancelled) => self.say("the simulation was cancelled"),
                    Err(error) => self.complain(error),
                }
            }
        }
        let Some(job) = &mut self.train else { return };
        // The result is asked for first, so that no news is left behind it.
        let result = job.result();
        let (news, cancelled) = (job.news(), job.is_cancelled());
        let mut latest = None;
        for news in news {
            match news {
                TrainNews::Iteration(iteration) => self.curve.push(iteration),
                TrainNews::Policy(skill) => latest = Some(skill),
                TrainNews::Judging => self.judging = true,
            }
        }
        if let Some(skill) = latest.filter(|_| !cancelled) {
            self.perform(Some(Performance::Skill(skill)));
        }
        if let Some(result) = result {
            self.train = None;
            match result {
                Ok(learnt) => self.training_done(learnt),
                Err(JobError::Cancelled) => self.say("the training was cancelled"),
                Err(error) => self.complain(error),
            }
        }
    }

    fn simulation_done(&mut self, found: Simulated) {
        let report = &found.report;
        let degrees = report.mean_joint.to_degrees();
        self.say(match report.fell_at {
            Some(at) => format!("it falls at {at:.2} s: change the poses"),
            None => format!("it follows: root within {:.2} m, joints within {degrees:.1} degrees", report.worst_root),
        });
        let found = Arc::new(found);
        self.simulated = Some((self.simulating_revision, found.clone()));
        self.perform(Some(Performance::Control(found)));
    }

    fn training_done(&mut self, learnt: Learnt) {
        self.perform(Some(Performance::Skill(learnt.skill.clone())));
        self.learnt = Some(Arc::new(learnt));
        self.save_skill();
    }
}

/// The poses as a motion; the windows are for optimisation alone and need not fit while durations are edited.
fn moving(poses: &KeyPoses) -> KeyPoses {
    KeyPoses { windows: Vec::new(), ..poses.clone() }
}

/// One pose alone, standing in it.
fn standing(poses: &KeyPoses, index: usize) -> Option<KeyPoses> {
    let mut pose = poses.poses.get(index)?.clone();
    pose.airborne = false;
    Some(KeyPoses {
        seconds: vec![0.1],
        poses: vec![pose],
        mirrored: false,
        repeat: 1,
        contacts: Vec::new(),
        ..moving(poses)
    })
}
