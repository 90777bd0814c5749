//! A race: eight runners side by side over the same pieces.

use super::site::LOST;
use crate::app::news::{News, StaysDown};
use crate::engine::{AthleteBody, AthleteFell, AthleteInput, AthleteLook, AthleteReset, LinkPoses};
use bevy::prelude::*;

/// Runners.
pub(super) const LANES: usize = 8;
/// From one to the next, m.
const APART: f32 = 1.6;
/// Width of the pieces, m.
pub(super) const WIDTH: f32 = LANES as f32 * APART + 1.0;
/// Where the race ends, m along -Z.
const FINISH: f32 = 38.0;
/// How fast they are told to run, m/s.
const SPEED: f32 = 3.4;
/// The next race begins so long after the last has come in or fallen, s; and this long after the start at the latest.
const PAUSE: f32 = 4.0;
const LONGEST: f32 = 45.0;

/// Whether there is a race, and how far it is.
#[derive(Resource, Default, Debug)]
pub(crate) struct Race {
    /// Asked for.
    pub on: bool,
    /// Since its start, s.
    clock: f32,
    /// Since it was decided, s.
    over: f32,
    /// Who has come in.
    came_in: usize,
}

impl Race {
    /// No race.
    pub(super) fn stop(&mut self) {
        *self = Self::default();
    }

    /// From its start.
    pub(super) fn begin(&mut self) {
        *self = Self { on: self.on, ..Self::default() };
    }
}

/// Who races.
#[derive(Component)]
pub(super) struct Racer {
    lane: usize,
    /// It has come in, or has fallen.
    done: bool,
}

/// What makes a runner a racer.
pub(super) fn racer(lane: usize) -> impl Bundle {
    let aside = (lane as f32 - 0.5 * (LANES - 1) as f32) * APART;
    let hue = lane as f32 * 360.0 / LANES as f32;
    let look = AthleteLook {
        left: Color::hsl(hue, 0.62, 0.42),
        right: Color::hsl(hue, 0.62, 0.56),
        middle: Color::hsl(hue, 0.30, 0.80),
        ..default()
    };
    (Racer { lane, done: false }, StaysDown, look, Transform::from_xyz(aside, 0.0, 0.0))
}

/// Straight on in their lanes, and what they have done.
pub(super) fn run(
    mut commands: Commands,
    time: Res<Time>,
    mut race: ResMut<Race>,
    mut news: ResMut<News>,
    mut racers: Query<(Entity, &LinkPoses, &mut Racer, &mut AthleteInput), With<AthleteBody>>,
) {
    // While files are read nobody runs.
    if racers.iter().count() < LANES {
        return;
    }
    race.clock += time.delta_secs();
    let mut running = false;
    for (_, poses, mut racer, mut input) in &mut racers {
        // Where it is in this tick; its transform is that of the last frame.
        let Some(root) = poses.current.first() else { return };
        let place = root.position.as_vec3();
        let aside = (racer.lane as f32 - 0.5 * (LANES - 1) as f32) * APART;
        if !racer.done && place.y < LOST {
            racer.done = true;
            news.tell(format!("lane {} is out", racer.lane + 1));
        }
        if !racer.done && -place.z > FINISH {
            racer.done = true;
            race.came_in += 1;
            news.tell(format!("{}. lane {}, {:.1} s", race.came_in, racer.lane + 1, race.clock));
        }
        running |= !racer.done;
        // To a point ahead in its own lane: who was pushed aside comes back.
        let way = Vec3::new(aside - place.x, 0.0, -6.0);
        let wanted = AthleteInput::towards(way).at(if racer.done { 0.0 } else { SPEED });
        if *input != wanted {
            *input = wanted;
        }
    }
    if running && race.clock < LONGEST {
        return;
    }
    race.over += time.delta_secs();
    if race.over > PAUSE {
        for (entity, ..) in &racers {
            commands.trigger(AthleteReset::new(entity));
        }
    }
}

/// Who falls is out.
pub(super) fn fell(fall: On<AthleteFell>, mut racers: Query<&mut Racer>, mut news: ResMut<News>) {
    if let Ok(mut racer) = racers.get_mut(fall.entity)
        && !racer.done
    {
        racer.done = true;
        news.tell(format!("lane {} is out", racer.lane + 1));
    }
}

/// Who is put back to the start runs again, and the race begins anew.
pub(super) fn again(reset: On<AthleteReset>, mut racers: Query<&mut Racer>, mut race: ResMut<Race>) {
    if let Ok(mut racer) = racers.get_mut(reset.entity) {
        racer.done = false;
        race.begin();
    }
}
