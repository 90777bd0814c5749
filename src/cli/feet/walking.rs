//! Rows of the comparison that a trained walk is measured by.

use super::error::FeetError;
use super::search::{SearchOptions, largest, mostly};
use crate::asset::Course;
use crate::cli::{CourseEnd, CourseTask, SkillInputError, find_skill, load_trained_skill, run_course};
use crate::math::{RandomStream, Vec3};
use crate::model::SharedModel;
use crate::sim::ExternalForce;
use crate::skill::{Director, DirectorInput, Disturbance, SkillDefinition};
use glam::DVec3;
use std::sync::Arc;

/// The skill that walks.
const WALK: &str = "walk";
/// How fast, m/s.
const SPEED: f64 = 1.2;
/// A push begins within a second after this, s, and lasts so long, s; then it walks on for so far, m.
const PUSH: (f64, f64, f64) = (4.0, 0.4, 12.0);
/// Number of the random stream of a push.
const STREAM: u64 = 0x0f00_7b02;

/// The walk of a body; `None` where none was trained for it.
fn walker(model: &SharedModel) -> Result<Option<Director>, FeetError> {
    let definition = SkillDefinition::load(find_skill(WALK)?).map_err(SkillInputError::from)?;
    if definition.character != model.name {
        return Ok(None);
    }
    let skill = load_trained_skill(WALK, model)?;
    let rate = skill.definition.simulation_rate(model);
    let input = DirectorInput { direction: DVec3::NEG_Z, speed: Some(SPEED), ..DirectorInput::default() };
    Ok(Some(Director::single(Arc::new(skill), rate)?.with_input(input)))
}

fn task(solids: &str, finish: f64) -> Result<CourseTask, FeetError> {
    let text = format!(
        "(name: \"walk\", parameters: [(name: \"height\", range: (0.0, 0.2), default: 0.0)], ground: (friction: 1.0), solids: [{solids}])"
    );
    Ok(CourseTask {
        course: Course::parse("walk", text.as_bytes())?,
        values: Vec::new(),
        finish,
        seconds: 2.0 * finish / SPEED + 5.0,
        disturbance: Disturbance { joint: 0.02, joint_velocity: 0.1, velocity: 0.05 },
        friction: (1.0, 1.0),
    })
}

/// The largest random heights (m, either way, nodes 0.25 m apart) over which a body walks `metres`.
pub(super) fn roughest(model: &SharedModel, options: &SearchOptions, metres: f64) -> Result<Option<f64>, FeetError> {
    let Some(director) = walker(model)? else { return Ok(None) };
    let solids =
        format!("Bumps(ahead: 1.0, length: {}, width: 8.0, spacing: 0.25, amplitude: \"height\")", metres + 1.0);
    let task = task(&solids, metres)?;
    largest((0.005, 0.1, 0.005), |height| {
        let task = CourseTask { values: vec![("height".into(), height)], ..task.clone() };
        mostly(options, |number| {
            let run = run_course(&mut director.clone(), model, &task, (options.seed, number), |_, _| {})??;
            Ok(run.end == CourseEnd::Finished)
        })
    })
}

/// The largest push (N, for 0.4 s on the trunk) from the right after which it walks on.
pub(super) fn hardest_push(model: &SharedModel, options: &SearchOptions) -> Result<Option<f64>, FeetError> {
    let Some(director) = walker(model)? else { return Ok(None) };
    let task = task("", PUSH.2)?;
    let trunk = model.trunk();
    let position = Vec3::<f64>::splat(model.links[trunk].com);
    largest((10.0, 250.0, 2.5), |force| {
        let push = ExternalForce { link: trunk, position, force: Vec3::<f64>::splat(DVec3::NEG_X * force) };
        mostly(options, |number| {
            // At any phase of the step.
            let begin = PUSH.0 + RandomStream::new(options.seed + number, STREAM).uniform();
            let run = run_course(&mut director.clone(), model, &task, (options.seed, number), |sim, _| {
                sim.external.clear();
                if (begin..begin + PUSH.1).contains(&sim.state.time) {
                    sim.external.push(push);
                }
            })??;
            Ok(run.end == CourseEnd::Finished)
        })
    })
}
