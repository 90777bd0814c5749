//! What has just happened, in words.

use crate::app::act::skill_title;
use crate::engine::{
    Athlete, AthleteBody, AthleteController, AthleteFell, AthleteQuarantined, AthleteRefused, AthleteReset,
    AthleteSettings, Landing, SkillStarted, StepTaken, StumbleCause, Stumbled,
};
use bevy::prelude::*;
use std::collections::VecDeque;

/// How long a line is shown, s.
const SHOWN: f32 = 3.5;
/// A fallen skater lies for so long before it starts again, s.
const LIES: f32 = 2.5;
/// Flights shorter than this are not told of, s.
const HOP: f64 = 0.2;

/// The latest lines and the time they are still shown, s.
#[derive(Resource, Default)]
pub(super) struct News(pub VecDeque<(String, f32)>);

/// Counts down to a new start, s.
#[derive(Component)]
struct Lies(f32);

/// Who falls stays where it is.
#[derive(Component)]
pub(super) struct StaysDown;

pub(super) struct NewsPlugin;

impl Plugin for NewsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<News>()
            .add_observer(skill_started)
            .add_observer(landed)
            .add_observer(fell)
            .add_observer(stepped)
            .add_observer(stumbled)
            // Who starts again for another reason does not lie any more.
            .add_observer(|reset: On<AthleteReset>, mut commands: Commands| {
                commands.entity(reset.entity).try_remove::<Lies>();
            })
            .add_observer(|bad: On<AthleteQuarantined>, mut news: ResMut<News>| {
                news.tell(format!("stopped: {:?}", bad.event()));
            })
            .add_observer(|refused: On<AthleteRefused>, mut news: ResMut<News>| {
                news.tell(format!("{}", refused.reason));
            })
            .add_systems(Update, (forget, get_up));
    }
}

impl News {
    pub(super) fn tell(&mut self, line: String) {
        self.0.push_back((line, SHOWN));
        if self.0.len() > 4 {
            self.0.pop_front();
        }
    }
}

/// News of a crowd is no news.
fn is_alone(athletes: &Query<(), With<Athlete>>) -> bool {
    athletes.iter().count() <= 2
}

fn skill_started(started: On<SkillStarted>, athletes: Query<(), With<Athlete>>, mut news: ResMut<News>) {
    if is_alone(&athletes) {
        news.tell(skill_title(&started.skill));
    }
}

fn landed(landing: On<Landing>, athletes: Query<(), With<Athlete>>, mut news: ResMut<News>) {
    if landing.airtime > HOP && is_alone(&athletes) {
        let (turns, air, height) = (landing.turns.abs(), landing.airtime, landing.height * 100.0);
        news.tell(format!("landed: {turns:.1} turns, {air:.2} s in the air, {height:.0} cm up"));
    }
}

/// A step of who balances is news; one of a walk is not.
fn stepped(step: On<StepTaken>, balancing: Query<&AthleteController>, mut news: ResMut<News>) {
    if matches!(balancing.get(step.entity), Ok(AthleteController::Balance(_))) {
        let way = step.from.distance(step.to) * 100.0;
        let side = step.side.map_or(String::new(), |side| format!(" with the {side:?} foot").to_lowercase());
        news.tell(format!("a step of {way:.0} cm{side}"));
    }
}

fn stumbled(stumble: On<Stumbled>, athletes: Query<(), With<Athlete>>, mut news: ResMut<News>) {
    if is_alone(&athletes) {
        news.tell(match stumble.cause {
            StumbleCause::FootCaught { speed, .. } => format!("a foot catches at {speed:.1} m/s"),
            StumbleCause::BalanceLost { .. } => "loses its balance".into(),
        });
    }
}

fn fell(
    fall: On<AthleteFell>,
    mut commands: Commands,
    athletes: Query<(), With<Athlete>>,
    bodies: Query<(&AthleteBody, &AthleteSettings), (Without<Lies>, Without<StaysDown>)>,
    mut news: ResMut<News>,
) {
    let Ok((body, settings)) = bodies.get(fall.entity) else { return };
    if is_alone(&athletes) {
        let link = fall.link.name(body.model()).unwrap_or_default();
        news.tell(format!("fell on the {}", link.replace('_', " ")));
    }
    // Who starts again at the end of a motion also gets up from a fall.
    if settings.restart_after.is_some() || !is_alone(&athletes) {
        commands.entity(fall.entity).insert(Lies(LIES));
    }
}

fn get_up(mut commands: Commands, time: Res<Time>, mut lying: Query<(Entity, &mut Lies)>) {
    for (entity, mut lies) in &mut lying {
        lies.0 -= time.delta_secs();
        if lies.0 <= 0.0 {
            commands.entity(entity).remove::<Lies>();
            commands.trigger(AthleteReset::new(entity));
        }
    }
}

fn forget(time: Res<Time<Real>>, mut news: ResMut<News>) {
    if news.0.is_empty() {
        return;
    }
    for line in &mut news.0 {
        line.1 -= time.delta_secs();
    }
    news.0.retain(|line| line.1 > 0.0);
}
