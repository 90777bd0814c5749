//! What becomes of an athlete that performs a skill on some ground: any character, any skill, any ground, one function. A new body or
//! a new ground is a row more in `footings.rs` of the engine's tests.
#![allow(dead_code, reason = "each test file uses its part")]

use crate::engine_support::{add, body, skill_in};
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use bevy_athlete::contact::{Geometry, Solid, Surface, World as Surroundings};
use bevy_athlete::engine::*;

/// Who performs what.
#[derive(Clone, Debug)]
pub struct Performer {
    /// Name of a character that comes with the crate.
    pub character: &'static str,
    /// Folder of the skill below `assets/skills/`.
    pub skill: &'static str,
    pub input: AthleteInput,
}

impl Performer {
    pub fn new(character: &'static str, skill: &'static str) -> Self {
        Self { character, skill, input: AthleteInput::default() }
    }
    pub fn at(self, speed: f32) -> Self {
        Self { input: self.input.at(speed), ..self }
    }
}

/// What is stood on. The surface is the one that the skill was learnt on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Footing {
    /// A level block whose top is at this height, m.
    Block { height: f64 },
    /// A plane through the origin that rises ahead by so much, degrees.
    Slope { degrees: f64 },
    /// A kinematic body of Avian, its top at this height (m), that moves at a velocity, m/s. Where `carried`, the athlete begins with
    /// the platform's velocity besides its own, as who has long stood on it.
    #[cfg(feature = "avian")]
    Platform { height: f64, velocity: DVec3, carried: bool },
}

impl Footing {
    /// Height of its top under a place, m.
    fn height(&self, place: DVec3) -> f64 {
        match self {
            Self::Block { height } => *height,
            Self::Slope { degrees } => -place.z * degrees.to_radians().tan(),
            #[cfg(feature = "avian")]
            Self::Platform { height, .. } => *height,
        }
    }
    /// How it moves, m/s.
    fn velocity(&self) -> DVec3 {
        match self {
            #[cfg(feature = "avian")]
            Self::Platform { velocity, .. } => *velocity,
            _ => DVec3::ZERO,
        }
    }
}

/// What became of it. Everything counts from what is stood on.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// When the trunk or the head touched something, s.
    pub fell: Option<f64>,
    /// Lowest and highest place of the root above the footing, m.
    pub height: (f64, f64),
    /// Where the root was on the footing in every fixed tick, from where it began, m; x aside, z ahead (negative).
    pub way: Vec<DVec3>,
    /// Mean speed along the footing over the last second, m/s.
    pub speed: f64,
    /// Part of the fixed ticks in which something pressed on the footing.
    pub touching: f64,
    /// Errors that stopped it.
    pub stopped: Option<QuarantineReason>,
}

impl Outcome {
    /// It stayed up: nothing but feet touched, and it was not stopped.
    pub fn stands(&self) -> bool {
        self.fell.is_none() && self.stopped.is_none()
    }
    /// Where it is at the end, m.
    pub fn end(&self) -> DVec3 {
        *self.way.last().expect("a tick")
    }
    /// Largest distance between two ways, m.
    pub fn apart(&self, other: &Self) -> f64 {
        self.way.iter().zip(&other.way).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
    }
}

/// When athletes fell.
#[derive(Resource, Default)]
struct Falls(Vec<(Entity, f64)>);

/// A headless app with Avian in which every frame is one tick.
#[cfg(feature = "avian")]
pub fn avian_app() -> App {
    use bevy_athlete::engine::avian::AthleteAvianPlugin;
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default()));
    app.add_plugins((avian3d::prelude::PhysicsPlugins::default(), AthletePlugins, AthleteAvianPlugin));
    app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(crate::engine_support::TICK));
    app.finish();
    app.cleanup();
    app.update();
    app
}

/// An app with the footing, and what the athlete's surface is.
fn app_on(footing: Footing, on_ice: bool) -> App {
    let surface = if on_ice { Surface::ICE } else { Surface::GROUND };
    let solid = |geometry: Geometry| Surroundings { solids: vec![Solid::fixed(geometry, surface)] };
    let world = match footing {
        Footing::Block { height } => {
            let half_extents = DVec3::new(200.0, 0.5, 200.0);
            solid(Geometry::Box { center: DVec3::Y * (height - 0.5), half_extents, rotation: DQuat::IDENTITY })
        }
        Footing::Slope { degrees } => {
            let normal = DVec3::new(0.0, 1.0, degrees.to_radians().tan()).normalize();
            solid(Geometry::Plane { point: DVec3::ZERO, normal })
        }
        #[cfg(feature = "avian")]
        Footing::Platform { height, velocity, .. } => {
            use avian3d::prelude::*;
            use bevy_athlete::engine::avian::AthleteSurface;
            let mut app = avian_app();
            let surface = if on_ice { AthleteSurface::ICE } else { AthleteSurface::GROUND };
            app.world_mut().spawn((
                RigidBody::Kinematic,
                Collider::cuboid(300.0, 1.0, 300.0),
                surface,
                LinearVelocity(velocity.as_vec3()),
                Transform::from_xyz(0.0, height as f32 - 0.5, 0.0),
            ));
            return app;
        }
    };
    let mut app = crate::engine_support::app();
    app.insert_resource(AthleteWorld(world));
    app
}

/// Performs for some seconds on a footing.
pub fn perform_on(performer: &Performer, footing: Footing, seconds: f64) -> Outcome {
    let skill = skill_in(performer.skill);
    let file = CharacterAsset::preset(performer.character).expect("a character");
    let on_ice = skill.bind(&file.model).expect("a skill of this character").definition.world == "ice";
    let mut app = app_on(footing, on_ice);
    app.init_resource::<Falls>();
    app.add_observer(|event: On<AthleteFell>, mut falls: ResMut<Falls>| falls.0.push((event.entity, event.time)));
    let (character, skill) = (add(&mut app, file), add(&mut app, skill));
    let start = Transform::from_xyz(0.0, footing.height(DVec3::ZERO) as f32, 0.0);
    let controller = AthleteController::skill(skill);
    #[cfg(feature = "avian")]
    if let Footing::Platform { velocity, carried: true, .. } = footing {
        // Before its first step: blades that slide across their edges brake hard.
        let carry = move |mut bodies: Query<&mut AthleteBody, Added<AthleteBody>>| {
            for mut body in &mut bodies {
                let sim = body.simulator_mut();
                sim.state.root_velocity.linear += bevy_athlete::math::Vec3::splat(velocity);
                sim.state_changed();
            }
        };
        app.add_systems(FixedPostUpdate, carry.in_set(AthleteSystems::Control));
    }
    // A tick for the colliders to be known.
    app.update();
    let athlete = app.world_mut().spawn((Athlete(character), controller, performer.input.clone(), start)).id();
    app.update();
    let place = |app: &App| {
        let body = body(app, athlete);
        let root = body.simulator().state.root_position.lane(0);
        (root, root - footing.velocity() * body.time())
    };
    let first = place(&app).1;
    let (mut way, mut touching) = (Vec::new(), 0);
    let mut height = (f64::INFINITY, f64::NEG_INFINITY);
    let ticks = (seconds * 64.0).round() as usize;
    for _ in 0..ticks {
        app.update();
        let (root, on_it) = place(&app);
        way.push((on_it - first) * DVec3::new(1.0, 0.0, 1.0));
        let above = root.y - footing.height(root);
        height = (height.0.min(above), height.1.max(above));
        touching += usize::from(body(&app, athlete).simulator().loaded_points(0) > 0);
    }
    let last = &way[way.len().saturating_sub(65)..];
    let speed = last.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>() / ((last.len() - 1) as f64 / 64.0);
    let fell = app.world().resource::<Falls>().0.first().map(|fall| fall.1);
    let stopped = body(&app, athlete).quarantine_reason();
    Outcome { fell, height, way, speed, touching: touching as f64 / ticks as f64, stopped }
}
