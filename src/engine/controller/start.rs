//! From the files that a controller names to what runs.

use crate::engine::arrival::{arrived, refuse};
use crate::engine::{
    AthleteBody, AthleteController, AthleteInput, AthleteRefusal, AthleteRefused, ControlAsset, ProgramAsset,
    SkillAsset,
};
use crate::skill::{Director, TrainedSkill};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The files that controllers are made of.
#[derive(SystemParam)]
pub(in crate::engine) struct ControllerAssets<'w> {
    controls: Res<'w, Assets<ControlAsset>>,
    skills: Res<'w, Assets<SkillAsset>>,
    programs: Res<'w, Assets<ProgramAsset>>,
    server: Option<Res<'w, AssetServer>>,
}

impl ControllerAssets<'_> {
    /// What tells how far the files are.
    pub fn server(&self) -> Option<&AssetServer> {
        self.server.as_deref()
    }

    /// A skill, made for the body; `None` while its file is on its way.
    fn skill(
        &self,
        handle: &Handle<SkillAsset>,
        body: &AthleteBody,
    ) -> Result<Option<Arc<TrainedSkill>>, AthleteRefusal> {
        let Some(asset) = arrived(&self.skills, handle, self.server())? else { return Ok(None) };
        Ok(Some(asset.bind(body.model())?))
    }

    /// All of them; `None` while a file is on its way.
    fn skills(
        &self,
        handles: &[Handle<SkillAsset>],
        body: &AthleteBody,
    ) -> Result<Option<Vec<Arc<TrainedSkill>>>, AthleteRefusal> {
        handles.iter().map(|handle| self.skill(handle, body)).collect()
    }
}

/// The controller that was started last.
#[derive(Component, Clone)]
pub(in crate::engine) struct StartedController(pub AthleteController);

impl AthleteController {
    /// Makes it drive the body; false while files are on their way.
    pub(in crate::engine) fn start(
        &self,
        input: &AthleteInput,
        body: &mut AthleteBody,
        assets: &ControllerAssets,
    ) -> Result<bool, AthleteRefusal> {
        let rate = |skill: &TrainedSkill| skill.definition.simulation_rate(body.model());
        let director = match self {
            Self::Hold | Self::External => {
                body.hold();
                return Ok(true);
            }
            Self::Play(handle) => {
                let Some(control) = arrived(&assets.controls, handle, assets.server())? else { return Ok(false) };
                body.play(control.control.clone())?;
                return Ok(true);
            }
            Self::Skill { skill } => {
                let Some(skill) = assets.skill(skill, body)? else { return Ok(false) };
                let rate = rate(&skill);
                Director::single(skill, rate)?
            }
            Self::Program(handle) => {
                let Some(asset) = arrived(&assets.programs, handle, assets.server())? else { return Ok(false) };
                let Some(skills) = assets.skills(&asset.skills, body)? else { return Ok(false) };
                let rate = skills.first().map_or(body.model().step_rate, |s| rate(s));
                let skills: BTreeMap<_, _> = skills.into_iter().map(|s| (s.name().to_owned(), s)).collect();
                Director::program(&asset.program, &skills, rate)?
            }
            Self::Balance(pose) => {
                let stance = pose.stance(body.model())?;
                body.balance(stance)?;
                return Ok(true);
            }
            Self::Course { run, skills } => {
                let Some(run) = assets.skill(run, body)? else { return Ok(false) };
                let Some(skills) = assets.skills(skills, body)? else { return Ok(false) };
                let rate = rate(&run);
                Director::course(std::iter::once(run).chain(skills).collect(), body.model(), rate)?
            }
            Self::Steer { skills } => {
                let Some(skills) = assets.skills(skills, body)? else { return Ok(false) };
                let rate = skills.first().map_or(body.model().step_rate, |s| rate(s));
                Director::steering(skills, body.model(), rate)?
            }
        };
        body.direct(director.with_input(input.checked()));
        Ok(true)
    }

    /// Whether a change of these files concerns it.
    fn uses(&self, changed: &ChangedFiles) -> bool {
        match self {
            Self::Hold | Self::External | Self::Balance(_) => false,
            Self::Play(handle) => changed.controls.contains(&handle.id()),
            Self::Skill { skill } => changed.skills.contains(&skill.id()),
            Self::Program(handle) => changed.programs.contains(&handle.id()),
            Self::Course { run, skills } => {
                std::iter::once(run).chain(skills).any(|h| changed.skills.contains(&h.id()))
            }
            Self::Steer { skills } => skills.iter().any(|h| changed.skills.contains(&h.id())),
        }
    }
}

/// Files that changed on disk since they were last looked at.
#[derive(Default)]
struct ChangedFiles {
    controls: Vec<AssetId<ControlAsset>>,
    skills: Vec<AssetId<SkillAsset>>,
    programs: Vec<AssetId<ProgramAsset>>,
}

fn modified<A: Asset>(events: &mut MessageReader<AssetEvent<A>>) -> Vec<AssetId<A>> {
    let id = |event: &AssetEvent<A>| match event {
        AssetEvent::Modified { id } => Some(*id),
        _ => None,
    };
    events.read().filter_map(id).collect()
}

/// Hands changed controllers to their bodies, once their files have arrived; files that changed start anew.
pub(in crate::engine) fn change_controllers(
    mut commands: Commands,
    assets: ControllerAssets,
    mut controls: MessageReader<AssetEvent<ControlAsset>>,
    mut skills: MessageReader<AssetEvent<SkillAsset>>,
    mut programs: MessageReader<AssetEvent<ProgramAsset>>,
    mut athletes: Query<(Entity, &AthleteController, &AthleteInput, &mut StartedController, &mut AthleteBody)>,
    mut refusals: MessageWriter<AthleteRefused>,
) {
    let mut changed = ChangedFiles {
        controls: modified(&mut controls),
        skills: modified(&mut skills),
        programs: modified(&mut programs),
    };
    let uses = |program: &ProgramAsset| program.skills.iter().any(|s| changed.skills.contains(&s.id()));
    let with_skills: Vec<_> = assets.programs.iter().filter(|(_, p)| uses(p)).map(|(id, _)| id).collect();
    changed.programs.extend(with_skills);
    for (entity, controller, input, mut started, mut body) in &mut athletes {
        if *controller == started.0 && !controller.uses(&changed) {
            continue;
        }
        match controller.start(input, &mut body, &assets) {
            Ok(false) => continue,
            Ok(true) => {}
            Err(reason) => {
                body.hold();
                refuse(&mut commands, &mut refusals, entity, reason);
            }
        }
        started.0 = controller.clone();
    }
}
