//! `athlete info --policy`: what a policy file says about itself.

use crate::output::{Outcome, say, say_json};
use bevy_athlete::cli::load_character;
use bevy_athlete::control::Policy;
use bevy_athlete::skill::SkillDefinition;
use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

/// Prints the contract of a policy that loads, and fits the character where one is named.
pub fn run(file: &Path, character: Option<&str>, json: bool) -> Outcome {
    let policy = Policy::load(file)?;
    if let Some(name) = character {
        let model = load_character(name)?;
        SkillDefinition::of_contract(policy.contract(), &model)?.check_policy(&policy, &model)?;
    }
    if json {
        say_json(&serde_json::json!({
            "file": policy.file(),
            "fingerprint": policy.fingerprint(),
            "contract": policy.contract(),
        }))?
    } else {
        say(text(&policy, character)?.trim_end())?
    }
    Ok(ExitCode::SUCCESS)
}

fn text(policy: &Policy, character: Option<&str>) -> Result<String, std::fmt::Error> {
    let contract = policy.contract();
    let mut out = String::new();
    let mut line = |what: &str, text: String| writeln!(out, "{what:<13} {text}");
    line("policy", policy.file().to_owned())?;
    line("fingerprint", policy.fingerprint().to_owned())?;
    let fits = character.map_or_else(String::new, |name| format!(" (fits {name})"));
    line("character", format!("{}{fits}", contract.character))?;
    if let Some(fingerprint) = &contract.character_fingerprint {
        line("body", format!("fingerprint {fingerprint}"))?;
    }
    line("skill", contract.skill.clone())?;
    if !contract.skill_settings.is_empty() {
        line("settings", contract.skill_settings.clone())?;
    }
    line("written by", format!("{}, contract version {}", contract.crate_version, contract.version))?;
    line(
        "rates",
        format!("{} actions/s, trained at {} simulation steps/s", contract.control_rate, contract.simulation_rate),
    )?;
    let again = if contract.reference.cyclic { ", again and again" } else { ", once" };
    line("reference", format!("{}{again}", contract.reference.file))?;
    line(
        "servo gains",
        match contract.gains {
            Some((kp, kd)) => format!("{kp} N m/rad, {kd} N m s/rad at every joint"),
            None => "those of the character".into(),
        },
    )?;
    line("golden pair", "agrees".into())?;
    if policy.is_affine() {
        line("network", format!("affine, {} x {}", contract.action_size(), contract.observation_size()))?;
    }

    let normaliser = &contract.normaliser;
    writeln!(out, "\nobservation: {} numbers, clipped at {} deviations", contract.observation_size(), normaliser.clip)?;
    writeln!(out, "  {:<16} {:>6} {:>22} {:>22}  meaning", "block", "size", "means", "deviations")?;
    let mut at = 0;
    for block in &contract.observation {
        let range = at..at + block.size;
        at = range.end;
        let means = range_of(normaliser.mean[range.clone()].iter().copied());
        let deviations = range_of(normaliser.scale[range].iter().map(|s| 1.0 / s));
        writeln!(out, "  {:<16} {:>6} {means:>22} {deviations:>22}  {}", block.name, block.size, block.meaning)?;
    }
    let action = &contract.action;
    writeln!(
        out,
        "\naction: {} numbers, {}, times {} rad",
        contract.action_size(),
        action.meaning.sentence(),
        action.scale
    )?;
    writeln!(out, "  links: {}", action.links.join(", "))?;
    Ok(out)
}

/// Least and largest of some numbers.
fn range_of(numbers: impl Iterator<Item = f32>) -> String {
    let (low, high) = numbers.fold((f32::MAX, f32::MIN), |(low, high), v| (low.min(v), high.max(v)));
    format!("{low:.3} to {high:.3}")
}
