//! The scene without a window: simulated as fast as it goes, summed up in a table, drawn as a storyboard.

use crate::app::ControlScene;
use crate::contact::BladeEdge;
use crate::control::{ControlError, ControlPlayer, tracking_error};
use crate::model::LinkTransform;
use crate::sim::{SimulationSettings, Simulator, link_transforms, step};
use crate::storyboard::{Ground, Storyboard, StoryboardError, StoryboardFrame, StoryboardOptions, TouchPoint};
use std::fmt;
use std::path::Path;
use std::time::Instant;

/// What a headless run found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// The character.
    pub character: String,
    /// The clip.
    pub clip: String,
    /// Simulated time, s.
    pub seconds: f64,
    /// Mean horizontal speed of the root, m/s.
    pub mean_speed: f64,
    /// Largest distance of the root from the reference, m.
    pub worst_root: f64,
    /// Joint error averaged over joints and time, rad.
    pub mean_joint: f64,
    /// For each blade its name and the time on its flat, inside and outside edge and off the ice, s.
    pub edges: Vec<(String, [f64; 4])>,
    /// Number of steps.
    pub steps: u64,
    /// Wall time of a step, the targets included, microseconds.
    pub step_micros: f64,
    /// Simulated seconds per second of stepping.
    pub real_time_factor: f64,
    /// Hash over every bit of the last state.
    pub fingerprint: u64,
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "character              {}", self.character)?;
        writeln!(f, "clip                   {}", self.clip)?;
        writeln!(f, "simulated time         {:.3} s", self.seconds)?;
        writeln!(f, "mean speed             {:.2} m/s", self.mean_speed)?;
        writeln!(f, "worst root deviation   {:.1} cm", self.worst_root * 100.0)?;
        writeln!(f, "mean joint error       {:.1} degrees", self.mean_joint.to_degrees())?;
        for (name, [flat, inside, outside, off]) in &self.edges {
            let name = format!("blade {name}");
            writeln!(f, "{name:<22} flat {flat:.2} s, inside {inside:.2} s, outside {outside:.2} s, off {off:.2} s")?;
        }
        writeln!(f, "steps                  {}", self.steps)?;
        writeln!(f, "time per step          {:.2} us", self.step_micros)?;
        writeln!(f, "real-time factor       {:.0}", self.real_time_factor)?;
        writeln!(f, "last state             {:016x}", self.fingerprint)
    }
}

/// Why a headless run ended early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum HeadlessError {
    /// The control does not fit.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// The storyboard could not be drawn.
    #[error(transparent)]
    Storyboard(#[from] StoryboardError),
}

/// Simulates the scene to the end of its control: the summary, and a frame of a storyboard every 20 ms.
pub fn simulate(scene: &ControlScene) -> Result<(Summary, Vec<StoryboardFrame>), HeadlessError> {
    let (model, control) = (&scene.model, &scene.control);
    let settings = SimulationSettings { rate: control.rate, ..SimulationSettings::of(model) };
    let mut sim: Simulator<f64> = Simulator::new(model.clone(), settings);
    let mut player = ControlPlayer::new(control, model)?;
    player.restart(&mut sim);
    let mut summary = Summary {
        character: format!("{} ({} degrees of freedom)", model.name, model.dof()),
        clip: control.clip.name.clone(),
        edges: model.blades.iter().map(|b| (b.name.clone(), [0.0; 4])).collect(),
        ..Default::default()
    };
    let h = sim.step_seconds();
    let every = ((0.02 / h).round() as u64).max(1);
    let mut frames = vec![frame(&mut sim, &player)];
    let (mut way, mut error, mut stepping) = (0.0, 0.0, 0.0);
    while !player.is_finished() {
        let begin = Instant::now();
        player.drive(&mut sim);
        step(&mut sim, &scene.world);
        stepping += begin.elapsed().as_secs_f64();
        summary.steps += 1;
        let velocity = sim.state.root_velocity.linear.lane(0);
        way += velocity.with_y(0.0).length() * h;
        let deviation = tracking_error(&sim, 0, &player.reference().at(sim.state.time).pose);
        summary.worst_root = summary.worst_root.max(deviation.root);
        error += deviation.joints;
        for (blade, (_, times)) in summary.edges.iter_mut().enumerate() {
            let slot = match sim.blade_edge(blade, 0) {
                BladeEdge::Flat => 0,
                BladeEdge::Inside => 1,
                BladeEdge::Outside => 2,
                BladeEdge::Off => 3,
            };
            times[slot] += h;
        }
        if summary.steps.is_multiple_of(every) {
            frames.push(frame(&mut sim, &player));
        }
    }
    let steps = summary.steps.max(1) as f64;
    summary.seconds = sim.state.time;
    summary.mean_speed = way / summary.seconds.max(h);
    summary.mean_joint = error / steps;
    summary.step_micros = stepping / steps * 1e6;
    summary.real_time_factor = summary.seconds / stepping.max(1e-9);
    summary.fingerprint = sim.state.fingerprint(0);
    Ok((summary, frames))
}

/// Simulates the scene and writes its storyboard.
pub fn run_headless(scene: &ControlScene, storyboard: &Path) -> Result<Summary, HeadlessError> {
    let (summary, frames) = simulate(scene)?;
    let ground = if scene.control.world == "ground" { Ground::Floor } else { Ground::Ice };
    let title = format!("{}, simulated, with its reference", summary.clip);
    let options = StoryboardOptions { frames: 10, title, ground, ..Default::default() };
    Storyboard::new(options).write(&scene.model, &frames, storyboard)?;
    Ok(summary)
}

/// The present instant.
fn frame(sim: &mut Simulator<f64>, player: &ControlPlayer) -> StoryboardFrame {
    let model = sim.model().clone();
    let links = link_transforms(sim, 0).into_iter().map(|(position, rotation)| LinkTransform { position, rotation });
    let links: Vec<LinkTransform> = links.collect();
    let mut ghost = Vec::with_capacity(links.len());
    player.reference().at(sim.state.time).pose.link_transforms(&model, &mut ghost);
    let contacts = model.contact_points.iter().enumerate().filter_map(|(point, place)| {
        let force = sim.contact_force(point, 0);
        let link = links[place.link];
        (force.length() > 1e-6).then(|| TouchPoint { position: link.position + link.rotation * place.position, force })
    });
    let contacts = contacts.collect();
    StoryboardFrame { ghost: Some(ghost), contacts, ..StoryboardFrame::new(sim.state.time, links) }
}
