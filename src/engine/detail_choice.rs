//! Which level of detail each athlete has: by its distance and by the budget of time.

use crate::engine::diagnostics::StepTally;
use crate::engine::{AthleteBody, AthleteBudget, AthleteDetail, AthleteLod, AthleteLodReport, AthleteTime, BodyStatus};
use bevy::ecs::query::QueryFilter;
use bevy::math::DVec3;
use bevy::prelude::*;

/// Steps per second of a body at a level.
fn rate_at(level: AthleteDetail, body: &AthleteBody) -> f64 {
    match level {
        AthleteDetail::Frozen => 0.0,
        _ if body.control_seconds().is_some() => body.simulator().settings().rate,
        AthleteDetail::Reduced => body.full_rate() * AthleteDetail::REDUCED_RATE,
        AthleteDetail::Full => body.full_rate(),
    }
}

/// One athlete in the count.
struct Candidate {
    entity: Entity,
    distance: f64,
    now: AthleteDetail,
    /// What its distance allows: at least and at most.
    near: (AthleteDetail, AthleteDetail),
    /// Steps per second at reduced and at full rate.
    rates: [f64; 2],
}

impl Candidate {
    fn rate(&self, level: AthleteDetail) -> f64 {
        match level {
            AthleteDetail::Frozen => 0.0,
            AthleteDetail::Reduced => self.rates[0],
            AthleteDetail::Full => self.rates[1],
        }
    }
}

/// What has been learnt of the time that steps take.
#[derive(Default)]
pub(super) struct StepCost {
    /// Milliseconds per step, all threads together; zero before the first.
    milliseconds: f64,
    /// Fixed ticks since the budget was last looked at.
    waited: u32,
}

impl StepCost {
    /// Part of a tick's measurement in the mean.
    const LEARN: f64 = 0.1;
    /// The budget is looked at every so many fixed ticks: levels that come and go are worse than a late one.
    const WAIT: u32 = 16;
    /// Part of the budget that has to suffice for a higher level.
    const ROOM: f64 = 0.85;

    fn learn(&mut self, tally: &StepTally) {
        if tally.steps > 0 {
            let cost = tally.milliseconds / tally.steps as f64;
            let part = if self.milliseconds == 0.0 { 1.0 } else { Self::LEARN };
            self.milliseconds += (cost - self.milliseconds) * part;
        }
    }
}

/// Hands every body its level.
pub(super) fn choose_detail<Viewer: QueryFilter + 'static>(
    viewers: Query<Entity, Viewer>,
    places: TransformHelper,
    (time, athletes_time): (Res<Time>, Res<AthleteTime>),
    frame: Res<Time<Virtual>>,
    tally: Res<StepTally>,
    budget: Res<AthleteBudget>,
    mut cost: Local<StepCost>,
    mut report: ResMut<AthleteLodReport>,
    mut athletes: Query<(Entity, &mut AthleteBody, Option<(&AthleteLod, &mut AthleteDetail)>)>,
) {
    cost.learn(&tally);
    let looks_from: Vec<DVec3> = viewers
        .iter()
        .filter_map(|viewer| places.compute_global_transform(viewer).ok())
        .map(|place| place.translation().as_dvec3())
        .collect();
    let mut candidates = Vec::new();
    // Steps per second of those that have no level of detail.
    let mut others = 0.0;
    for (entity, mut body, lod) in &mut athletes {
        let Some((lod, _)) = lod else {
            if body.detail != AthleteDetail::Full {
                body.detail = AthleteDetail::Full;
            }
            others += body.simulator().settings().rate;
            continue;
        };
        if body.status() == BodyStatus::Quarantined {
            continue;
        }
        let place = body.simulator().state.root_position.lane(0);
        let distance = looks_from.iter().map(|from| from.distance(place)).min_by(f64::total_cmp);
        let level = |leave: f64| match distance {
            Some(d) if d > f64::from(lod.reduced) * leave => AthleteDetail::Frozen,
            Some(d) if d > f64::from(lod.full) * leave => AthleteDetail::Reduced,
            _ => AthleteDetail::Full,
        };
        candidates.push(Candidate {
            entity,
            distance: distance.unwrap_or(0.0),
            now: body.detail,
            near: (level(1.0), level(1.1)),
            rates: [AthleteDetail::Reduced, AthleteDetail::Full].map(|l| rate_at(l, &body)),
        });
    }
    // The nearest first; ties by entity, so that the order is always the same.
    candidates.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.entity.cmp(&b.entity)));

    let wanted: Vec<AthleteDetail> = candidates.iter().map(|c| c.now.clamp(c.near.0, c.near.1)).collect();
    // A frame runs the ticks of its time, and where frames are shorter than a tick, now and then a whole one.
    let seconds = frame.delta().max(time.delta()).as_secs_f64() * f64::from(athletes_time.relative_speed());
    let per_rate = cost.milliseconds * seconds;
    let mut levels = wanted.clone();
    if let Some(allowed) = budget.milliseconds {
        let allowed = f64::from(allowed).max(0.0);
        cost.waited += 1;
        if cost.waited >= StepCost::WAIT {
            cost.waited = 0;
            let low = within(&candidates, &wanted, others, allowed * StepCost::ROOM / per_rate.max(1e-12));
            let high = within(&candidates, &wanted, others, allowed / per_rate.max(1e-12));
            for (k, level) in levels.iter_mut().enumerate() {
                *level = candidates[k].now.clamp(low[k], high[k]);
            }
        } else {
            // Until then no one goes up.
            for (level, candidate) in levels.iter_mut().zip(&candidates) {
                *level = (*level).min(candidate.now);
            }
        }
    }
    *report = AthleteLodReport::default();
    for ((candidate, level), wanted) in candidates.iter().zip(&levels).zip(&wanted) {
        match level {
            AthleteDetail::Full => report.full += 1,
            AthleteDetail::Reduced => report.reduced += 1,
            AthleteDetail::Frozen => report.frozen += 1,
        }
        report.degraded += usize::from(level < wanted);
        if let Ok((_, mut body, Some((_, mut detail)))) = athletes.get_mut(candidate.entity) {
            if body.detail != *level {
                body.detail = *level;
            }
            detail.set_if_neq(*level);
        }
    }
    let rates = candidates.iter().zip(&levels).map(|(c, level)| c.rate(*level));
    report.milliseconds = ((others + rates.sum::<f64>()) * per_rate) as f32;
}

/// The levels at which all together make at most `allowed` steps per second, as near to the wanted ones as can be; nearest
/// candidate first.
fn within(candidates: &[Candidate], wanted: &[AthleteDetail], others: f64, allowed: f64) -> Vec<AthleteDetail> {
    let mut levels = wanted.to_vec();
    let mut total = others + candidates.iter().zip(&levels).map(|(c, l)| c.rate(*l)).sum::<f64>();
    for lower in [AthleteDetail::Reduced, AthleteDetail::Frozen] {
        for (level, candidate) in levels.iter_mut().zip(candidates).rev() {
            if total <= allowed {
                return levels;
            }
            if *level > lower {
                total -= candidate.rate(*level) - candidate.rate(lower);
                *level = lower;
            }
        }
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_farthest_are_degraded_first_and_no_more_than_needed() {
        let far = AthleteDetail::Full;
        let candidates: Vec<Candidate> = (0..10)
            .map(|k| Candidate {
                entity: Entity::from_raw_u32(k).unwrap(),
                distance: f64::from(k),
                now: far,
                near: (far, far),
                rates: [600.0, 1200.0],
            })
            .collect();
        let wanted = [AthleteDetail::Full; 10];
        for allowed in (0..=14).map(|k| f64::from(k) * 1000.0) {
            let levels = within(&candidates, &wanted, 0.0, allowed);
            let total: f64 = candidates.iter().zip(&levels).map(|(c, l)| c.rate(*l)).sum();
            assert!(total <= allowed, "{total} of {allowed}");
            assert!(levels.windows(2).all(|pair| pair[0] >= pair[1]), "a nearer one has less: {levels:?}");
            assert!(allowed - total < 1200.0 || levels == wanted, "{levels:?} leave {allowed} unused");
            // Nobody is frozen while others are at full rate.
            assert!(!(levels.contains(&AthleteDetail::Frozen) && levels.contains(&AthleteDetail::Full)), "{levels:?}");
        }
    }
}
