//! `athlete balance`: a body keeps standing in a pose of its feet.

use crate::feet::balance_settings;
use crate::interrupt;
use crate::output::{Outcome, bar, complain, say, say_json};
use bevy_athlete::cli::feet::{Disturbance, Episode, StancePose, run_episode, with_foot_armature};
use bevy_athlete::cli::{ArgumentError, check_output, load_character, within};
use bevy_athlete::control::balance::BalanceSettings;
use bevy_athlete::control::foot::BasicPose;
use bevy_athlete::model::SharedModel;
use bevy_athlete::storyboard::{Ground, Storyboard, StoryboardOptions};
use clap::Args;
use glam::DVec3;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// Starts at rest with noise in every joint, takes the pose after 2 s, holds it, and returns to rest for the last 3 s.
#[derive(Debug, Args)]
pub struct Balance {
    /// rest, tiptoe, inside_tilt, outside_tilt, left_leg, right_leg, left_circling or right_circling
    pose: String,
    /// Name of a preset (foot_human, two_segment_human, toes_human) or path of a .character.ron file
    #[arg(long, default_value = "foot_human")]
    character: String,
    /// How long, s, 1 to 3600
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// Episodes, 1 to 10000
    #[arg(long, default_value_t = 10)]
    trials: usize,
    /// Number of the first episode
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// A push on the trunk after 2 s, for 0.4 s, N
    #[arg(long, default_value_t = 0.0)]
    push: f64,
    /// Where the push goes, degrees: 0 backwards (from the front), 90 to the right, 180 forwards
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    direction: f64,
    /// The ground is a fixed ball of this radius below the middle between the feet, m, 0.2 to 1000
    #[arg(long, conflicts_with = "push")]
    ball: Option<f64>,
    /// Joint noise at the start, rad, 0 to 0.3
    #[arg(long, default_value_t = 0.03)]
    noise: f64,
    /// Least and largest friction coefficient of the ground
    #[arg(long, num_args = 2, default_values_t = [0.6, 1.0])]
    friction: Vec<f64>,
    /// How forces of the ground are chosen: cones, or pressure as published
    #[arg(long, default_value = "cones")]
    method: String,
    /// Decisions per second, 10 to 2000
    #[arg(long)]
    rate: Option<f64>,
    /// Steps of simulation per second, 30 to 20000; by default the character's own
    #[arg(long)]
    step_rate: Option<f64>,
    /// Armature of the feet's joints beyond the ankle, kg m^2, 0 to 10, in place of the character's own
    #[arg(long)]
    foot_armature: Option<f64>,
    /// Steps that may be taken to catch a fall
    #[arg(long, default_value_t = 0)]
    steps: u32,
    /// Where to write a storyboard of the first episode (PNG)
    #[arg(long)]
    storyboard: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Balance {
    /// The character, with another rate or armature where they are asked for.
    fn body(&self) -> Result<SharedModel, Box<dyn std::error::Error>> {
        let mut model = load_character(&self.character)?;
        if let Some(armature) = self.foot_armature {
            model = Arc::new(with_foot_armature(&model, within("--foot-armature", armature, 0.0..=10.0, "kg m^2")?));
        }
        if let Some(rate) = self.step_rate {
            Arc::make_mut(&mut model).step_rate = within("--step-rate", rate, 30.0..=20_000.0, "per second")?;
        }
        Ok(model)
    }

    pub fn run(&self) -> Outcome {
        within("--seconds", self.seconds, 1.0..=3600.0, "s")?;
        within("--trials", self.trials, 1..=10_000, "")?;
        within("--push", self.push, 0.0..=10_000.0, "N")?;
        within("--direction", self.direction, -360.0..=360.0, "degrees")?;
        self.ball.map(|radius| within("--ball", radius, 0.2..=1000.0, "m")).transpose()?;
        within("--noise", self.noise, 0.0..=0.3, "rad")?;
        for friction in &self.friction {
            within("--friction", *friction, 0.01..=3.0, "")?;
        }
        if let Some(path) = &self.storyboard {
            check_output("--storyboard", path)?;
        }
        let stance = match self.pose.as_str() {
            "left_leg" => StancePose::OneLeg(0),
            "right_leg" => StancePose::OneLeg(1),
            "left_circling" => StancePose::Circling(0),
            "right_circling" => StancePose::Circling(1),
            name => StancePose::Basic(BasicPose::named(name).ok_or_else(|| {
                ArgumentError::new(
                    "POSE",
                    name,
                    "rest, tiptoe, inside_tilt, outside_tilt, left_leg, right_leg, left_circling or right_circling",
                )
            })?),
        };
        within("--steps", self.steps, 0..=1000, "")?;
        let settings = BalanceSettings { steps: self.steps, ..balance_settings(&self.method, self.rate)? };
        let (sin, cos) = self.direction.to_radians().sin_cos();
        let push = Disturbance::Push { force: self.push, toward: DVec3::new(sin, 0.0, cos) };
        let model = self.body()?;
        let episode = Episode {
            settings,
            stance,
            disturbance: match self.ball {
                Some(radius) => Disturbance::Ball { radius },
                None if self.push > 0.0 => push,
                None => Disturbance::None,
            },
            seconds: self.seconds,
            returns: self.seconds >= 8.0 && stance != StancePose::Basic(BasicPose::Rest),
            friction: (self.friction[0], self.friction[1]),
            noise: self.noise,
        };
        interrupt::watch()?;
        let bar = bar(self.trials as u64, "balance");
        let (mut held, mut falls, mut cost, mut done, mut carrying) = (0, Vec::new(), (0.0, 0.0), 0, 0.0);
        for number in 0..self.trials {
            if number > 0 && interrupt::asked() {
                break;
            }
            done = number + 1;
            let frames = if number == 0 && self.storyboard.is_some() { 10.0 } else { 0.0 };
            let result = run_episode(&model, &episode, self.seed + number as u64, frames)?;
            match result.fell_at {
                None => {
                    held += 1;
                    carrying += result.carrying;
                }
                Some(time) => falls.push((self.seed + number as u64, time)),
            }
            cost = (cost.0 + result.cost.0, cost.1 + result.cost.1);
            if let (0, Some(path)) = (number, &self.storyboard) {
                let options = StoryboardOptions {
                    ground: Ground::Floor,
                    title: format!("{}, {}", model.name, self.pose),
                    ..Default::default()
                };
                Storyboard::new(options).write(&model, &result.frames, path)?;
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        let stopped = done < self.trials;
        if stopped {
            complain(&format!("stopped after {done} of {} episodes", self.trials));
        }
        let cost = (cost.0 / done as f64, cost.1 / done as f64);
        let carrying = (held > 0).then(|| carrying / f64::from(held));
        if self.json {
            let falls: Vec<_> = falls.iter().map(|(n, t)| json!({ "episode": n, "time": t })).collect();
            say_json(&json!({
                "character": model.name, "pose": self.pose, "seconds": self.seconds, "trials": done, "held": held,
                "falls": falls, "carrying_points": carrying, "method": settings.method.name(), "rate": settings.rate,
                "controller_s_per_s": cost.0, "all_s_per_s": cost.1, "stopped": stopped,
            }))?;
        } else {
            say(&format!("held             {held} of {done} for {} s", self.seconds))?;
            for (number, time) in falls.iter().take(10) {
                say(&format!("fell             episode {number} at {time:.2} s"))?;
            }
            if let Some(points) = carrying {
                say(&format!("carrying         {points:.1} contact points on average from 2 s on"))?;
            }
            say(&format!("cost             {:.4} s of controller, {:.4} s in all, for a second", cost.0, cost.1))?;
        }
        Ok(if stopped { interrupt::stopped() } else { ExitCode::SUCCESS })
    }
}
