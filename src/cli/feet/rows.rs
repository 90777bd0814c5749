//! The rows of the comparison.

use super::bodies::FeetBody;
use super::episode::{Disturbance, Episode, run_episode};
use super::error::FeetError;
use super::search::{SearchOptions, largest_held};
use super::walking::{hardest_push, roughest};
use crate::control::balance::{BalanceSettings, Hull};
use crate::model::CharacterModel;
use glam::{DVec2, DVec3};
use serde::Serialize;

/// Acceleration of free fall, m/s^2.
const GRAVITY: f64 = 9.81;
/// How long an episode with a push or a jerk lasts, s: 4 s from its beginning.
const SHORT: f64 = 6.0;
/// Steps that the rows with steps may take.
const STEPS: u32 = 3;
/// How long a push lasts, s.
const PUSH: f64 = 0.4;

/// A row before it is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// Its name: `--row`.
    pub name: &'static str,
    /// Unit of its figures.
    pub unit: &'static str,
    /// Published figures: five segments and two.
    pub published: (Option<f64>, Option<f64>),
    /// What is measured.
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Largest force held without a step, towards this direction.
    Push(DVec3),
    /// The same with at most so many steps.
    Steps(DVec3),
    /// Largest way of the platform held.
    Jerk(DVec3),
    /// Smallest ball stood on.
    Ball,
    /// Largest tilt of swaying ground held, about this axis.
    Sway(DVec3),
    /// Root mean square of the trunk's angular velocity on ground swaying by 10 degrees about this axis.
    Wobble(DVec3),
    /// Largest random heights of the ground walked over.
    WalkRough,
    /// Largest push from the right while walking.
    WalkPush,
}

/// A measured row.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FeetRow {
    /// Name of the experiment.
    pub experiment: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Five segments; `None` where not even the mildest disturbance is held, or no walk was trained for the body.
    pub multi: Option<f64>,
    /// Two segments.
    pub two: Option<f64>,
    /// Two segments with more contact points.
    pub two_more_points: Option<f64>,
    /// Eight segments: single toes.
    pub toes: Option<f64>,
    /// Published for five segments.
    pub published_multi: Option<f64>,
    /// Published for two.
    pub published_two: Option<f64>,
    /// What the centre of pressure alone could hold on the feet of five segments.
    pub bound: Option<f64>,
    /// Episodes a point.
    pub trials: usize,
}

/// All rows.
pub fn experiments() -> Vec<Experiment> {
    let row = |name, unit, published, kind| Experiment { name, unit, published, kind };
    let none = (None, None);
    vec![
        row("push_front", "N", (Some(65.0), Some(45.0)), Kind::Push(DVec3::Z)),
        row("push_back", "N", (Some(50.0), Some(40.0)), Kind::Push(DVec3::NEG_Z)),
        row("push_side", "N", (Some(75.0), Some(50.0)), Kind::Push(DVec3::X)),
        row("platform_back", "m", none, Kind::Jerk(DVec3::Z)),
        row("ball", "m", none, Kind::Ball),
        row("sway_fore_aft", "degrees", none, Kind::Sway(DVec3::X)),
        row("sway_sideways", "degrees", none, Kind::Sway(DVec3::Z)),
        row("trunk_rate_fore_aft", "rad/s", none, Kind::Wobble(DVec3::X)),
        row("trunk_rate_sideways", "rad/s", none, Kind::Wobble(DVec3::Z)),
        row("steps_front", "N", none, Kind::Steps(DVec3::Z)),
        row("steps_back", "N", none, Kind::Steps(DVec3::NEG_Z)),
        row("steps_side", "N", none, Kind::Steps(DVec3::X)),
        row("walk_rough", "m", (Some(0.03), None), Kind::WalkRough),
        row("walk_push_right", "N", (Some(80.0), None), Kind::WalkPush),
    ]
}

/// Measures a row; `long` is how long slow disturbances last, s. With less than a minute the walk over rough ground is 20 m long, not 100.
pub fn measure_row(
    row: &Experiment,
    settings: BalanceSettings,
    options: &SearchOptions,
    long: f64,
) -> Result<FeetRow, FeetError> {
    let standing = |disturbance, seconds| Episode { settings, ..Episode::standing(disturbance, seconds) };
    let mut figures = [None; 4];
    for (figure, body) in figures.iter_mut().zip(FeetBody::ALL) {
        let model = body.model();
        *figure = match row.kind {
            Kind::Push(toward) => largest_held(&model, options, (10.0, 170.0, 2.5), |force| {
                standing(Disturbance::Push { force, toward }, SHORT)
            })?,
            Kind::Steps(toward) => largest_held(&model, options, (10.0, 250.0, 2.5), |force| Episode {
                settings: BalanceSettings { steps: STEPS, ..settings },
                ..Episode::standing(Disturbance::Push { force, toward }, SHORT)
            })?,
            Kind::Jerk(toward) => largest_held(&model, options, (0.01, 0.33, 0.01), |way| {
                standing(Disturbance::Jerk { way, toward }, SHORT)
            })?,
            Kind::Ball => {
                largest_held(&model, options, (4.0, 0.3, 0.1), |radius| standing(Disturbance::Ball { radius }, long))?
            }
            Kind::Sway(axis) => {
                let sway = |degrees: f64| Disturbance::Sway { angle: degrees.to_radians(), frequency: 0.25, axis };
                largest_held(&model, options, (1.0, 25.0, 0.75), |degrees| standing(sway(degrees), long))?
            }
            Kind::Wobble(axis) => {
                let sway = Disturbance::Sway { angle: 10f64.to_radians(), frequency: 0.25, axis };
                let (mut sum, mut held) = (0.0, 0.0);
                for number in 0..options.trials as u64 {
                    let result = run_episode(&model, &standing(sway, long), options.seed + number, 0.0)?;
                    if result.held() {
                        sum += result.trunk_rate;
                        held += 1.0;
                    }
                }
                (held > 0.0).then(|| sum / held)
            }
            Kind::WalkRough => roughest(&model, options, if long < 60.0 { 20.0 } else { 100.0 })?,
            Kind::WalkPush => hardest_push(&model, options)?,
        };
    }
    let [multi, two, two_more_points, toes] = figures;
    let (published_multi, published_two) = row.published;
    let bound = match row.kind {
        Kind::Push(toward) => Some(push_bound(&FeetBody::Multi.model(), toward)),
        _ => None,
    };
    Ok(FeetRow {
        experiment: row.name,
        unit: row.unit,
        multi,
        two,
        two_more_points,
        toes,
        published_multi,
        published_two,
        bound,
        trials: options.trials,
    })
}

/// The largest push that the centre of pressure alone catches, N: a linear pendulum from over the middle of the support, the force F at
/// the trunk's centre of mass for T. With omega^2 = g / z, z the height of the centre of mass and z_F that of the force,
///
/// ```text
/// F = m g d / (z_F (1 - exp(-omega T))),     d from the middle of the support to its edge
/// ```
fn push_bound(model: &CharacterModel, toward: DVec3) -> f64 {
    let places = model.rest_positions();
    let height = model.rest_root_height();
    let com = model.links.iter().zip(&places).map(|(l, p)| (*p + l.com) * l.mass).sum::<DVec3>() / model.mass();
    let z = com.y + height;
    let trunk = model.trunk();
    let z_force = places[trunk].y + model.links[trunk].com.y + height;
    let soles = model.feet().iter().flat_map(|f| model.foot_points(f)).map(|k| &model.contact_points[k]);
    let touching = soles.filter(|p| height + places[p.link].y + p.position.y - p.radius < 0.002);
    let hull = Hull::of(touching.map(|p| places[p.link] + p.position).map(|p| DVec2::new(p.x, -p.z)));
    let way = DVec2::new(toward.x, -toward.z);
    let middle = hull.middle().unwrap_or(DVec2::ZERO);
    let d = hull.corners().iter().map(|c| (*c - middle).dot(way)).fold(0.0, f64::max);
    let omega = (GRAVITY / z).sqrt();
    model.mass() * GRAVITY * d / (z_force * (1.0 - (-omega * PUSH).exp()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::foot_human;

    #[test]
    fn bounds_are_those_of_a_linear_pendulum() {
        let model = foot_human();
        let [front, back, side] = [DVec3::Z, DVec3::NEG_Z, DVec3::X].map(|d| push_bound(&model, d));
        // The sole is 0.195 m long: front and back share about 116 N.
        assert!((front + back - 116.0).abs() < 4.0, "{front} + {back}");
        assert!((55.0..75.0).contains(&side), "{side}");
    }
}
