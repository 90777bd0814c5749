//! `athlete info`: a character in numbers, or what a policy file says about itself.

use crate::info_policy;
use crate::output::{Outcome, say, say_json};
use bevy_athlete::cli::{CharacterTable, character_table, load_character};
use clap::Args;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Debug, Args)]
pub struct Info {
    #[arg(long, help = character_help!(), required_unless_present = "policy")]
    character: Option<String>,
    /// A policy (.onnx): show its contract, and with --character check that it fits
    #[arg(long, value_name = "FILE")]
    policy: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Info {
    pub fn run(&self) -> Outcome {
        let name = self.character.as_deref();
        if let Some(file) = &self.policy {
            return info_policy::run(file, name, self.json);
        }
        let table = character_table(&*load_character(name.unwrap_or_default())?);
        if self.json {
            say_json(&table)?
        } else {
            say(text(&table)?.trim_end())?
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn text(table: &CharacterTable) -> Result<String, std::fmt::Error> {
    let mut out = String::new();
    writeln!(
        out,
        "{}: {} degrees of freedom, {} links, {:.3} kg, {:.3} m high, root at {:.4} m, {} steps/s",
        table.character,
        table.dof,
        table.links.len(),
        table.mass,
        table.height,
        table.root_height,
        table.step_rate
    )?;
    let names = |names: &[String]| if names.is_empty() { "none".to_owned() } else { names.join(", ") };
    writeln!(
        out,
        "blades: {}; grips: {}; pairs of links that may collide: {}",
        names(&table.blades),
        names(&table.grips),
        table.collision_pairs
    )?;
    for foot in &table.feet {
        let stands = foot.blade.as_ref().map_or("sole".to_owned(), |blade| format!("blade {blade}"));
        let (side, links) = (foot.side.unwrap_or("middle"), foot.links.join(", "));
        writeln!(out, "foot, {side}: {stands}; {links}; toe {}, heel {}", foot.toe, foot.heel)?;
    }
    writeln!(out, "trunk: {}\n", table.trunk)?;
    writeln!(
        out,
        "{:<26} {:<26} {:<5} {:>3} {:>9} {:>23} {:>7} {:>6} {:>7} {:>6}  limits x, y, z (degrees)",
        "link", "parent", "joint", "dof", "kg", "joint at x, y, z (m)", "kp", "kd", "max Nm", "points"
    )?;
    for link in &table.links {
        let [x, y, z] = link.position;
        let limits = link
            .limits_deg
            .map_or("free".to_owned(), |l| l.map(|[low, high]| format!("{low:.0}..{high:.0}")).join(", "));
        writeln!(
            out,
            "{:<26} {:<26} {:<5} {:>3} {:>9.4} {:>23} {:>7} {:>6} {:>7} {:>6}  {limits}",
            link.name,
            link.parent.as_deref().unwrap_or("-"),
            link.joint,
            link.dof,
            link.mass,
            format!("{x:.3} {y:.3} {z:.3}"),
            link.kp,
            link.kd,
            link.max_torque.map_or("-".to_owned(), |t| t.to_string()),
            link.contact_points
        )?;
    }
    for link in table.links.iter().filter(|l| l.armature > 0.0) {
        writeln!(out, "armature of {}: {} kg m^2", link.name, link.armature)?;
    }
    for (link, [stiffness, damping]) in table.links.iter().filter_map(|l| Some((l, l.spring?))) {
        writeln!(out, "spring of {}: {stiffness} N m/rad, {damping} N m s/rad", link.name)?;
    }
    writeln!(
        out,
        "\n{:<26} {:<26} {:<5} {:<4} {:>26} {:>8} {:>8}",
        "contact point", "link", "kind", "role", "at x, y, z (m)", "radius", "friction"
    )?;
    for point in &table.contact_points {
        let [x, y, z] = point.position;
        writeln!(
            out,
            "{:<26} {:<26} {:<5} {:<4} {:>26} {:>8.4} {:>8}",
            point.name,
            point.link,
            point.kind,
            point.role,
            format!("{x:.4} {y:.4} {z:.4}"),
            point.radius,
            point.friction
        )?;
    }
    Ok(out)
}
