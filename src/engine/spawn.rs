//! From an [`Athlete`] component to a body: waits for files, refuses what cannot be simulated.

use crate::engine::performer::Performer;
use crate::engine::{
    Athlete, AthleteBody, AthleteController, AthleteRefusal, AthleteRefused, AthleteSettings, CharacterAsset,
    ControlAsset, LinkPoses, Placement, ProgramAsset, Refused, SkatingProgram, SkillAsset, SkillController, Steering,
};
use crate::skill::{ProgramPlayer, SkillPlayer, SteeringPlayer, Wish};
use bevy::asset::LoadState;
use bevy::ecs::system::SystemParam;
use bevy::math::DVec3;
use bevy::prelude::*;
use std::collections::BTreeMap;

/// Athletes that wait for their body.
type Waiting = (Without<AthleteBody>, Without<Refused>);
/// What may drive an athlete; the first of the skills that is there counts before the controller.
type Drivers<'a> =
    (&'a AthleteController, Option<&'a Steering>, Option<&'a SkatingProgram>, Option<&'a SkillController>);
type Spawned<'a> = (Entity, &'a Athlete, &'a Transform, Drivers<'a>, &'a AthleteSettings, &'a mut LinkPoses);

/// The files that drivers are made of.
#[derive(SystemParam)]
pub(super) struct DriverAssets<'w> {
    controls: Res<'w, Assets<ControlAsset>>,
    skills: Res<'w, Assets<SkillAsset>>,
    programs: Res<'w, Assets<ProgramAsset>>,
    server: Option<Res<'w, AssetServer>>,
}

/// What drives a body, by its files.
#[derive(Component, Clone, PartialEq)]
pub(super) enum Driven {
    Hold,
    External,
    Play(Handle<ControlAsset>),
    Skill(Handle<SkillAsset>),
    Program(Handle<ProgramAsset>),
    Steered(Vec<Handle<SkillAsset>>),
}

impl Driven {
    fn by((controller, steering, program, skill): &Drivers) -> Self {
        match (controller, steering, program, skill) {
            (_, Some(steering), _, _) => Self::Steered(steering.skills.clone()),
            (_, _, Some(program), _) => Self::Program(program.0.clone()),
            (_, _, _, Some(skill)) => Self::Skill(skill.skill.clone()),
            (AthleteController::Hold, ..) => Self::Hold,
            (AthleteController::External, ..) => Self::External,
            (AthleteController::Play(control), ..) => Self::Play(control.clone()),
        }
    }

    /// Makes it drive the body; false while files are on their way.
    fn start(&self, body: &mut AthleteBody, assets: &DriverAssets) -> Result<bool, AthleteRefusal> {
        let server = assets.server.as_deref();
        let rate = body.model().step_rate;
        let misfit = |message: String| AthleteRefusal::Control { message };
        let skill = |handle: &Handle<SkillAsset>, body: &AthleteBody| -> Result<Option<_>, AthleteRefusal> {
            let Some(asset) = arrived(&assets.skills, handle, server)? else { return Ok(None) };
            let (found, wanted) = (&asset.character, &body.model().name);
            if found != wanted {
                let name = asset.skill.name();
                return Err(misfit(format!("the skill {name} is one of {found}; valid: one of {wanted}")));
            }
            Ok(Some(asset.skill.clone()))
        };
        let odd_rate = || misfit(format!("{rate} steps per second do not fit the decisions of the skill"));
        match self {
            Self::Hold | Self::External => body.hold(),
            Self::Play(handle) => {
                let Some(control) = arrived(&assets.controls, handle, server)? else { return Ok(false) };
                body.play(control.control.clone()).map_err(|e| misfit(e.to_string()))?;
            }
            Self::Skill(handle) => {
                let Some(skill) = skill(handle, body)? else { return Ok(false) };
                let player = Box::new(SkillPlayer::new(skill, rate).ok_or_else(odd_rate)?);
                body.perform(Performer::Skill { player, speed: None, steering: 0.0, begun: false });
            }
            Self::Program(handle) => {
                let Some(asset) = arrived(&assets.programs, handle, server)? else { return Ok(false) };
                let mut skills = BTreeMap::new();
                for handle in &asset.skills {
                    let Some(skill) = skill(handle, body)? else { return Ok(false) };
                    skills.insert(skill.name().to_owned(), skill);
                }
                let player = ProgramPlayer::new(&asset.program, &skills, rate).map_err(|e| misfit(e.to_string()))?;
                body.perform(Performer::Program(Box::new(player)));
            }
            Self::Steered(handles) => {
                let mut skills = Vec::new();
                for handle in handles {
                    let Some(skill) = skill(handle, body)? else { return Ok(false) };
                    skills.push(skill);
                }
                if skills.is_empty() {
                    return Err(misfit("Steering has no skills; valid: at least one".into()));
                }
                let player = Box::new(SteeringPlayer::new(skills, body.model(), rate).ok_or_else(odd_rate)?);
                let wish = Wish { direction: DVec3::ZERO, speed: 2.5, perform: None };
                body.perform(Performer::Steered { player, wish });
            }
        }
        Ok(true)
    }

    /// Whether a change of these files concerns it.
    fn uses(&self, changed: &ChangedFiles) -> bool {
        match self {
            Self::Hold | Self::External => false,
            Self::Play(handle) => changed.controls.contains(&handle.id()),
            Self::Skill(handle) => changed.skills.contains(&handle.id()),
            Self::Program(handle) => changed.programs.contains(&handle.id()),
            Self::Steered(handles) => handles.iter().any(|h| changed.skills.contains(&h.id())),
        }
    }
}

/// Gives a body to every athlete whose files have arrived.
pub(super) fn build_bodies(
    mut commands: Commands,
    characters: Res<Assets<CharacterAsset>>,
    assets: DriverAssets,
    mut waiting: Query<Spawned, Waiting>,
    mut refusals: MessageWriter<AthleteRefused>,
) {
    for (entity, athlete, transform, drivers, settings, mut poses) in &mut waiting {
        let driven = Driven::by(&drivers);
        let built: Result<Option<AthleteBody>, AthleteRefusal> = (|| {
            let placement = Placement::from_transform(transform)?;
            let character = arrived(&characters, &athlete.0, assets.server.as_deref())?;
            let Some(character) = character else { return Ok(None) };
            let mut body = AthleteBody::new(character.model.clone(), placement);
            if !driven.start(&mut body, &assets)? {
                return Ok(None);
            }
            body.apply_settings(settings);
            Ok(Some(body))
        })();
        match built {
            Ok(None) => {}
            Ok(Some(mut body)) => {
                body.write_links(&mut poses.current);
                poses.current_time = body.time();
                poses.cut();
                commands.entity(entity).insert((body, driven));
            }
            Err(reason) => {
                commands.entity(entity).insert(Refused(reason.clone()));
                refuse(&mut commands, &mut refusals, entity, reason);
            }
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
pub(super) fn change_controllers(
    mut commands: Commands,
    assets: DriverAssets,
    mut controls: MessageReader<AssetEvent<ControlAsset>>,
    mut skills: MessageReader<AssetEvent<SkillAsset>>,
    mut programs: MessageReader<AssetEvent<ProgramAsset>>,
    mut athletes: Query<(Entity, Drivers, &mut Driven, &mut AthleteBody)>,
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
    for (entity, drivers, mut driven, mut body) in &mut athletes {
        let wanted = Driven::by(&drivers);
        if wanted == *driven && !driven.uses(&changed) {
            continue;
        }
        match wanted.start(&mut body, &assets) {
            Ok(false) => continue,
            Ok(true) => {}
            Err(reason) => {
                body.hold();
                refuse(&mut commands, &mut refusals, entity, reason);
            }
        }
        *driven = wanted;
    }
}

/// The asset; `None` while it is on its way.
fn arrived<'a, A: Asset>(
    assets: &'a Assets<A>,
    handle: &Handle<A>,
    server: Option<&AssetServer>,
) -> Result<Option<&'a A>, AthleteRefusal> {
    if let Some(asset) = assets.get(handle) {
        return Ok(Some(asset));
    }
    match server.map(|s| s.load_state(handle)) {
        Some(LoadState::Failed(error)) => Err(AthleteRefusal::Load { message: error.to_string() }),
        _ => Ok(None),
    }
}

/// Tells everybody: the log, readers and observers.
pub(super) fn refuse(
    commands: &mut Commands,
    refusals: &mut MessageWriter<AthleteRefused>,
    entity: Entity,
    reason: AthleteRefusal,
) {
    error!("athlete {entity} is refused: {reason}");
    let refused = AthleteRefused { entity, reason };
    refusals.write(refused.clone());
    commands.trigger(refused);
}
