//! `athlete`: simulation, reconstruction, export and timing of bevy_athlete's characters, without a window.

/// What `--character` takes, with what a command adds.
macro_rules! character_help {
    ($($more:literal)?) => {
        concat!(
            "Name of a preset (skater, foot_human, two_segment_human, toes_human, runner) or path of a .character.ron file"
            $(, $more)?
        )
    };
}

mod balance;
mod bench;
mod course;
mod evaluate;
mod export;
mod export_mjcf;
mod feet;
mod follow;
mod foot_pose;
mod gait;
mod import_joints;
mod info;
mod info_policy;
mod interrupt;
mod join;
mod map;
mod motion;
mod optimize;
mod output;
mod program;
mod reconstruct;
mod record;
mod run_folder;
mod show;
mod simulate;
mod train;
mod train_affine;
mod world_args;

use bevy_athlete::cli::exit_code;
use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Simulated athletes on the command line.
///
/// Exit codes: 0 success, 1 failure, 2 wrong arguments, 3 a result was found and written but is worse than asked (reconstruct: it
/// follows its clip worse; optimize: it falls), 130 stopped by Ctrl-C.
///
/// Ctrl-C: train, reconstruct and optimize save what they have found and say how to go on; evaluate, program, balance and feet show what
/// they have tried. A second Ctrl-C ends the program at once, and so does the first one for all other commands.
#[derive(Debug, Parser)]
#[command(name = "athlete", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Simulate a character that performs a motion (plain stable PD) or replays a control
    Simulate(simulate::Simulate),
    /// Search for a control whose simulation follows a motion
    Reconstruct(reconstruct::Reconstruct),
    /// Optimise the windows of a skill's key poses: a motion that was simulated
    Optimize(optimize::Optimize),
    /// Turn 3D joint positions of a pose estimator into key poses
    ImportJoints(import_joints::ImportJoints),
    /// Show what the skeleton of a .bvh file is taken for, and write that as a joint map to edit
    Map(map::Map),
    /// Put motions one after the other into one clip, such as the cycles of a gait
    Join(join::Join),
    /// Draw key poses or a motion
    Show(show::Show),
    /// Write a character or the character of a benchmark scene as a MuJoCo model
    ExportMjcf(export_mjcf::ExportMjcf),
    /// Show links, masses, joints and contact points of a character, or the contract of a policy
    Info(info::Info),
    /// Pose a foot of several segments: its four basic poses
    FootPose(foot_pose::FootPose),
    /// Keep a body standing in a pose of its feet, pushed or not, many times
    Balance(balance::Balance),
    /// Compare feet of five segments with feet of two: what each holds
    Feet(feet::Feet),
    /// Measure a walk as a gait laboratory does, beside people
    Gait(gait::Gait),
    /// Learn a policy for a skill or a motion
    Train(train::Train),
    /// Try a policy on fresh random trials
    Evaluate(evaluate::Evaluate),
    /// Make a skill that a game loads of what a training left
    Export(export::Export),
    /// Perform a program of trained skills many times
    Program(program::Program),
    /// Run a course of obstacles with a step planner many times
    Course(course::CourseCommand),
    /// Time the simulation in the shared scenes
    Bench(bench::Bench),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Simulate(command) => command.run(),
        Command::Reconstruct(command) => command.run(),
        Command::Optimize(command) => command.run(),
        Command::ImportJoints(command) => command.run(),
        Command::Map(command) => command.run(),
        Command::Join(command) => command.run(),
        Command::Show(command) => command.run(),
        Command::ExportMjcf(command) => command.run(),
        Command::Info(command) => command.run(),
        Command::FootPose(command) => command.run(),
        Command::Balance(command) => command.run(),
        Command::Feet(command) => command.run(),
        Command::Gait(command) => command.run(),
        Command::Train(command) => command.run(),
        Command::Evaluate(command) => command.run(),
        Command::Export(command) => command.run(),
        Command::Program(command) => command.run(),
        Command::Course(command) => command.run(),
        Command::Bench(command) => command.run(),
    };
    result.unwrap_or_else(|failure| {
        output::complain(&format!("error: {failure}"));
        ExitCode::from(exit_code(&*failure))
    })
}
