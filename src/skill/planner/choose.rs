//! Which skill clears an obstacle, and how it is approached.

use super::approach::{Approach, ApproachTask, StepLaw, approach};
use super::obstacle::{Obstacle, ObstacleKind};
use serde::{Deserialize, Serialize};

/// What a skill can clear, and how it has to be entered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clearance {
    /// Name of the skill; in its own file it goes without saying.
    #[serde(skip)]
    pub skill: String,
    /// What it clears.
    pub kind: ObstacleKind,
    /// Heights that it clears, m; of ways down and gaps, how far down, as a positive number.
    pub heights: (f64, f64),
    /// Lengths along the way that it clears, m; they do not count where the obstacle goes on.
    #[serde(default)]
    pub depths: (f64, f64),
    /// How far the ground behind may differ from that before, m; it does not count where the obstacle goes on.
    #[serde(default = "level")]
    pub behind: f64,
    /// From its beginning to the obstacle, m.
    pub take_off: f64,
    /// How far the obstacle may be from where the skill expects it, either way, m: a parameter `distance` of the skill gives it room.
    #[serde(skip)]
    pub slack: f64,
    /// Speed at its beginning for the lowest and the highest obstacle, m/s.
    pub speeds_in: (f64, f64),
    /// Part of the trials at lowest and highest that succeeded, 0 to 1.
    #[serde(default = "sure")]
    pub success: (f64, f64),
}

fn level() -> f64 {
    0.1
}
fn sure() -> (f64, f64) {
    (1.0, 1.0)
}

impl Clearance {
    /// The field that cannot be used, what it holds, and what would be valid.
    pub(crate) fn fault(&self) -> Option<(&'static str, String, &'static str)> {
        let pairs = [
            ("clears.heights", self.heights, 20.0),
            ("clears.depths", self.depths, 1e3),
            ("clears.speeds_in", self.speeds_in, 30.0),
            ("clears.success", self.success, 1.0),
        ];
        for (field, (low, high), most) in pairs {
            let ordered = low <= high || matches!(field, "clears.speeds_in" | "clears.success");
            if !((0.0..=most).contains(&low) && (0.0..=most).contains(&high) && ordered) {
                return Some((field, format!("({low}, {high})"), "two numbers in order, 0 to 20 m, 1000 m, 30 m/s, 1"));
            }
        }
        let single = [("clears.behind", self.behind), ("clears.take_off", self.take_off)];
        let wrong = single.into_iter().find(|(_, value)| !(0.0..=100.0).contains(value));
        wrong.map(|(field, value)| (field, value.to_string(), "0 to 100 m"))
    }

    /// Where in its range of heights an obstacle is, 0 to 1.
    fn part(&self, height: f64) -> f64 {
        let (low, high) = self.heights;
        if high > low { ((height - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 }
    }
    /// Speed at its beginning for an obstacle, m/s.
    pub fn speed_in(&self, obstacle: &Obstacle) -> f64 {
        let part = self.part(obstacle.height.abs());
        self.speeds_in.0 + (self.speeds_in.1 - self.speeds_in.0) * part
    }
    /// Chance of success for an obstacle, 0 to 1.
    pub fn chance(&self, obstacle: &Obstacle) -> f64 {
        let part = self.part(obstacle.height.abs());
        self.success.0 + (self.success.1 - self.success.0) * part
    }
    /// What about an obstacle is out of its range.
    fn misfit(&self, obstacle: &Obstacle) -> Option<Refusal> {
        const EDGE: f64 = 0.02;
        let within = |x: f64, (low, high): (f64, f64)| (low - EDGE..=high + EDGE).contains(&x);
        let goes_on = matches!(obstacle.kind, ObstacleKind::Up | ObstacleKind::Down);
        if !within(obstacle.height.abs(), self.heights) && obstacle.kind != ObstacleKind::Gap {
            return Some(Refusal::Height { found: obstacle.height, valid: self.heights });
        }
        if !goes_on && !within(obstacle.depth, self.depths) {
            return Some(Refusal::Depth { found: obstacle.depth, valid: self.depths });
        }
        if !goes_on && obstacle.behind.abs() > self.behind + EDGE {
            return Some(Refusal::Behind { found: obstacle.behind, most: self.behind });
        }
        None
    }
}

/// Why an obstacle is not approached.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "engine", derive(bevy::reflect::Reflect))]
#[non_exhaustive]
pub enum Refusal {
    /// No skill clears this kind of obstacle.
    #[error("no skill clears an obstacle of this kind ({0:?})")]
    Kind(ObstacleKind),
    /// Too high or too low for every skill of the kind; the range is that of the nearest.
    #[error("it is {found:.2} m high; valid: {:.2} to {:.2} m", valid.0, valid.1)]
    Height {
        /// m.
        found: f64,
        /// m.
        valid: (f64, f64),
    },
    /// Too long or too short along the way.
    #[error("it is {found:.2} m long; valid: {:.2} to {:.2} m", valid.0, valid.1)]
    Depth {
        /// m.
        found: f64,
        /// m.
        valid: (f64, f64),
    },
    /// The ground behind it is at another height.
    #[error("the ground behind it is {found:.2} m higher; valid: at most {most:.2} m to either side")]
    Behind {
        /// m.
        found: f64,
        /// m.
        most: f64,
    },
    /// The speed cannot be reached on the way that is left.
    #[error("{distance:.2} m are too short to go from {speed:.2} to {wanted:.2} m/s")]
    TooNear {
        /// m.
        distance: f64,
        /// m/s.
        speed: f64,
        /// m/s.
        wanted: f64,
    },
    /// It succeeds too seldom.
    #[error("it would succeed in {:.0} of 100 trials", 100.0 * chance)]
    Risk {
        /// 0 to 1.
        chance: f64,
    },
}

/// What to do about the next obstacle.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Index of the skill in the list that was given.
    pub skill: usize,
    /// Speed at which the skill begins, m/s.
    pub speed_in: f64,
    /// The steps up to it.
    pub approach: Approach,
    /// Chance of success, 0 to 1.
    pub chance: f64,
}

/// Plans for an obstacle: of the skills whose range it is in and that can be reached, the one with the best chance of success, then with the least cost. `reach` says how a
/// run can change: its step law, slowest and fastest speed (m/s), and largest change in a step (m/s). Skills that succeed in fewer than `least_chance` (0 to 1) are refused.
pub fn plan(
    obstacle: &Obstacle,
    speed: f64,
    skills: &[Clearance],
    law: &StepLaw,
    speeds: (f64, f64),
    change: f64,
    least_chance: f64,
) -> Result<Plan, Refusal> {
    /// What counts as much as [`BESIDE`] m beside the take-off, m/s of change in one step.
    const CHANGE: f64 = 0.2;
    /// Beside the take-off, where a skill has no room, m; else a third of its room.
    const BESIDE: f64 = 0.01;
    let mut refusal = Refusal::Kind(obstacle.kind);
    // The reason that is told is that of the skill which comes nearest to doing it.
    let mut told = 0;
    let mut best: Option<Plan> = None;
    for (k, skill) in skills.iter().enumerate().filter(|(_, s)| s.kind == obstacle.kind) {
        let mut refuse = |rank: usize, reason: Refusal| {
            if rank > told {
                (told, refusal) = (rank, reason);
            }
        };
        if let Some(reason) = skill.misfit(obstacle) {
            refuse(1, reason);
            continue;
        }
        let chance = skill.chance(obstacle);
        if chance < least_chance {
            refuse(2, Refusal::Risk { chance });
            continue;
        }
        let wanted = skill.speed_in(obstacle);
        let task = ApproachTask {
            distance: obstacle.distance,
            speed,
            take_off: skill.take_off,
            speed_in: wanted,
            speeds,
            change,
            weight: (CHANGE / (skill.slack / 3.0).max(BESIDE)).powi(2),
        };
        let found = approach(&task, law);
        if !found.possible || (found.take_off - skill.take_off).abs() > skill.slack.max(0.1) {
            refuse(3, Refusal::TooNear { distance: obstacle.distance - skill.take_off, speed, wanted });
            continue;
        }
        let better = best.as_ref().is_none_or(|b| (chance, -found.cost) > (b.chance, -b.approach.cost));
        if better {
            best = Some(Plan { skill: k, speed_in: wanted, approach: found, chance });
        }
    }
    best.ok_or(refusal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn skill(name: &str, kind: ObstacleKind, heights: (f64, f64), success: f64) -> Clearance {
        Clearance {
            skill: name.into(),
            kind,
            heights,
            depths: (0.1, 0.6),
            behind: 0.1,
            take_off: 1.2,
            slack: 0.0,
            speeds_in: (3.0, 4.0),
            success: (success, success),
        }
    }

    fn wall(height: f64) -> Obstacle {
        Obstacle { kind: ObstacleKind::Over, distance: 12.0, height, depth: 0.4, behind: 0.0 }
    }

    fn planned(obstacle: &Obstacle, skills: &[Clearance]) -> Result<Plan, Refusal> {
        plan(obstacle, 3.0, skills, &StepLaw::PUBLISHED, (2.0, 5.0), 0.5, 0.5)
    }

    #[test]
    fn the_skill_that_is_surest_is_chosen_among_those_that_fit() {
        let skills = [
            skill("hurdle", ObstacleKind::Over, (0.2, 0.7), 0.9),
            skill("vault", ObstacleKind::Over, (0.5, 1.0), 0.99),
            skill("jump", ObstacleKind::Up, (0.1, 0.7), 1.0),
        ];
        assert_eq!(planned(&wall(0.3), &skills).unwrap().skill, 0);
        assert_eq!(planned(&wall(0.6), &skills).unwrap().skill, 1);
        let found = planned(&wall(1.0), &skills).unwrap();
        assert_eq!(
            (found.skill, found.approach.speeds.last().copied()),
            (1, Some(4.0)),
            "the highest is entered fastest"
        );
    }

    #[test]
    fn every_refusal_says_what_is_in_the_way() {
        let skills = [skill("vault", ObstacleKind::Over, (0.5, 1.0), 0.99)];
        let reason = |obstacle: Obstacle| planned(&obstacle, &skills).unwrap_err();
        assert!(matches!(reason(wall(1.3)), Refusal::Height { .. }));
        assert!(matches!(reason(Obstacle { depth: 1.1, ..wall(0.7) }), Refusal::Depth { .. }));
        assert!(matches!(reason(Obstacle { behind: -0.9, ..wall(0.7) }), Refusal::Behind { .. }));
        assert!(matches!(reason(Obstacle { kind: ObstacleKind::Gap, ..wall(-1.0) }), Refusal::Kind(ObstacleKind::Gap)));
        assert!(matches!(reason(Obstacle { distance: 1.9, ..wall(1.0) }), Refusal::TooNear { .. }));
        let risky = [skill("vault", ObstacleKind::Over, (0.5, 1.0), 0.4)];
        assert_eq!(planned(&wall(0.7), &risky), Err(Refusal::Risk { chance: 0.4 }));
        assert!(reason(wall(1.3)).to_string().contains("1.30 m high; valid: 0.50 to 1.00 m"));
    }
}
