//! The last seconds of an athlete, to go back to.

use crate::engine::{AthleteBody, AthleteSnapshot, BodyStatus, LinkPoses};
use bevy::prelude::*;
use std::collections::VecDeque;

/// Keeps a snapshot of an athlete for every fixed tick of the last seconds; [`AthleteRewind`] goes back in it. Ticks in
/// which the athlete stood still (paused, frozen, quarantined) are not counted: these are seconds of its own time.
///
/// Ten seconds of a skater at 64 ticks per second take about 3 MB.
///
/// ```no_run
/// # use bevy::prelude::*;
/// # use bevy_athlete::engine::*;
/// # fn spawn(mut commands: Commands, assets: Res<AssetServer>) {
/// commands.spawn((Athlete(assets.load("characters/skater.character.ron")), AthleteHistory::default()));
/// # }
/// // Somebody fell: three seconds back.
/// fn again(fall: On<AthleteFell>, mut commands: Commands) {
///     commands.trigger(AthleteRewind { entity: fall.entity, seconds: 3.0 });
/// }
/// ```
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(opaque)]
#[reflect(Component, Default)]
pub struct AthleteHistory {
    seconds: f64,
    /// Oldest first.
    moments: VecDeque<Moment>,
    span: f64,
}

#[derive(Clone, Debug)]
struct Moment {
    snapshot: AthleteSnapshot,
    /// Time since the moment before, s.
    since: f64,
}

impl Default for AthleteHistory {
    fn default() -> Self {
        Self::new(10.0)
    }
}

impl AthleteHistory {
    /// Room for so many seconds (at least 0; 10 if it is no number).
    pub fn new(seconds: f32) -> Self {
        let seconds = if seconds.is_finite() { f64::from(seconds).max(0.0) } else { 10.0 };
        Self { seconds, moments: VecDeque::new(), span: 0.0 }
    }
    /// How far back it goes at present, s.
    pub fn span(&self) -> f64 {
        self.span
    }
    /// Number of snapshots.
    pub fn len(&self) -> usize {
        self.moments.len()
    }
    /// Whether there is none yet.
    pub fn is_empty(&self) -> bool {
        self.moments.is_empty()
    }
    /// Size of all snapshots, bytes.
    pub fn size(&self) -> usize {
        self.moments.iter().map(|m| m.snapshot.size()).sum()
    }
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.moments.clear();
        self.span = 0.0;
    }

    /// The snapshot nearest to so many seconds before the newest one; the oldest if that is too far back.
    pub fn at(&self, seconds: f32) -> Option<&AthleteSnapshot> {
        self.index(seconds).map(|k| &self.moments[k].snapshot)
    }

    /// Like [`AthleteHistory::at`], and forgets all that came after.
    pub fn rewind(&mut self, seconds: f32) -> Option<AthleteSnapshot> {
        let k = self.index(seconds)?;
        self.moments.truncate(k + 1);
        self.span = self.moments.iter().skip(1).map(|m| m.since).sum();
        self.moments.back().map(|m| m.snapshot.clone())
    }

    /// Adds the present, `since` seconds after the moment before.
    pub fn record(&mut self, snapshot: AthleteSnapshot, since: f64) {
        if !self.moments.is_empty() {
            self.span += since;
        }
        self.moments.push_back(Moment { snapshot, since });
        // Rounding must not keep one too many.
        while self.moments.len() > 1 && self.span - self.moments[1].since >= self.seconds - 1e-6 {
            self.span -= self.moments[1].since;
            self.moments.pop_front();
        }
    }

    fn index(&self, seconds: f32) -> Option<usize> {
        let wanted = if seconds.is_finite() { f64::from(seconds) } else { 0.0 };
        let (mut k, mut back) = (self.moments.len().checked_sub(1)?, 0.0);
        while k > 0 && back + 0.5 * self.moments[k].since <= wanted {
            back += self.moments[k].since;
            k -= 1;
        }
        Some(k)
    }
}

/// Asks for an athlete with an [`AthleteHistory`] to be put back by some seconds of its own time; what came after is
/// forgotten. Lifts a quarantine. Triggered, it acts at once; as a message, before the next fixed ticks: also while time
/// stands still.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct AthleteRewind {
    /// The athlete.
    pub entity: Entity,
    /// How far, s; to the nearest fixed tick, at most to the oldest one that is kept.
    pub seconds: f32,
}

type Rewound<'a> = (&'a mut AthleteBody, &'a mut AthleteHistory, &'a mut LinkPoses);

pub(super) fn rewind_now(rewind: On<AthleteRewind>, mut athletes: Query<Rewound>) {
    go_back(&rewind, &mut athletes);
}

pub(super) fn rewind_bodies(mut asked: MessageReader<AthleteRewind>, mut athletes: Query<Rewound>) {
    asked.read().for_each(|rewind| go_back(rewind, &mut athletes));
}

fn go_back(rewind: &AthleteRewind, athletes: &mut Query<Rewound>) {
    let Ok((mut body, mut history, mut poses)) = athletes.get_mut(rewind.entity) else { return };
    let Some(snapshot) = history.rewind(rewind.seconds) else { return };
    if let Err(error) = body.restore(&snapshot) {
        // Of another character: the entity got a new one.
        warn!("athlete {} cannot go back: {error}", rewind.entity);
        history.clear();
        return;
    }
    body.write_links(&mut poses.current);
    (poses.current_time, poses.lag) = (body.time(), body.lag());
    poses.cut();
    body.take_jump();
}

/// Adds the tick that has ended.
pub(super) fn record(mut athletes: Query<(&AthleteBody, &mut AthleteHistory)>) {
    athletes.par_iter_mut().for_each(|(body, mut history)| {
        if body.last_tick > 0.0 && body.status() == BodyStatus::Running {
            history.record(body.snapshot(), body.last_tick);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Placement;
    use crate::model::skater;

    #[test]
    fn it_keeps_its_seconds_and_finds_the_nearest_moment() {
        let mut body = AthleteBody::new(skater(), Placement::default());
        let mut history = AthleteHistory::new(1.0);
        assert!(history.at(0.0).is_none());
        for k in 0..100 {
            body.simulator_mut().state.time = f64::from(k);
            history.record(body.snapshot(), 0.1);
        }
        assert!((history.span() - 1.0).abs() < 1e-9 && history.len() == 11, "{} s, {}", history.span(), history.len());
        let time = |snapshot: &AthleteSnapshot, body: &mut AthleteBody| {
            body.restore(snapshot).unwrap();
            body.time()
        };
        for (seconds, wanted) in [(0.0, 99.0), (0.04, 99.0), (0.06, 98.0), (0.5, 94.0), (7.0, 89.0), (f32::NAN, 99.0)] {
            assert_eq!(time(history.at(seconds).unwrap(), &mut body), wanted, "{seconds} s back");
        }
        let snapshot = history.rewind(0.3).unwrap();
        assert_eq!(time(&snapshot, &mut body), 96.0);
        assert!((history.span() - 0.7).abs() < 1e-9);
    }
}
