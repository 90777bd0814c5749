//! Speeds of the steps up to an obstacle: equation 15 of Liu, Yin, van de Panne, Guo 2012.

/// How long a step is at a speed: `l = slope v + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepLaw {
    /// s.
    pub slope: f64,
    /// m.
    pub offset: f64,
}

impl StepLaw {
    /// That of the runner of Liu, Yin, van de Panne, Guo 2012, Section 6.
    pub const PUBLISHED: Self = Self { slope: 0.2, offset: 0.17 };

    /// Length of a step at a speed (m/s), m.
    pub fn length(&self, speed: f64) -> f64 {
        self.slope * speed + self.offset
    }

    /// The line through points (speed, m/s; length of a step, m) by least squares. `None` with fewer than two speeds, or where steps get shorter with speed.
    pub fn fitted(points: &[(f64, f64)]) -> Option<Self> {
        let n = points.len() as f64;
        let (v, l) = points.iter().fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
        let (vv, vl) =
            points.iter().fold((0.0, 0.0), |s, p| (s.0 + (p.0 - v) * (p.0 - v), s.1 + (p.0 - v) * (p.1 - l)));
        let slope = vl / vv;
        (vv > 1e-9 && slope > 0.0).then_some(Self { slope, offset: l - slope * v })
    }
}

/// What is asked of an approach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ApproachTask {
    /// From the runner to the obstacle, m.
    pub distance: f64,
    /// Present speed, m/s.
    pub speed: f64,
    /// Distance to the obstacle at which the skill begins, m: `u_h` of the paper.
    pub take_off: f64,
    /// Speed at which it begins, m/s: `v_in`.
    pub speed_in: f64,
    /// Slowest and fastest run, m/s.
    pub speeds: (f64, f64),
    /// Largest change of speed from one step to the next, m/s.
    pub change: f64,
    /// What a metre beside the take-off counts against a metre a second of change: `w_u / w_i`.
    pub weight: f64,
}

/// The steps up to an obstacle.
#[derive(Clone, Debug, PartialEq)]
pub struct Approach {
    /// Speed of each step, m/s; the last is that of the skill's entry. Empty where the skill begins at once.
    pub speeds: Vec<f64>,
    /// Distance to the obstacle after the last step, m.
    pub take_off: f64,
    /// The sum that was minimised.
    pub cost: f64,
    /// All speeds and changes are within their bounds.
    pub possible: bool,
}

/// Most steps that are planned, or told.
const MOST: usize = 64;
/// Number of steps from which on a runner goes on as it is.
const FAR: usize = 24;

/// The speeds of the steps up to an obstacle:
///
/// ```text
/// min  w (d - sum_i l(v_i) - u_h)^2 + sum_i (v_i - v_(i-1))^2     i = 1 .. n,  v_0 the present speed,  v_n = v_in
/// ```
///
/// For a number of steps `n` this is a linear system with a tridiagonal matrix and one dense direction, solved by elimination and the formula of Sherman and Morrison 1950. `n`
/// is the number, among those around the one that the mean of both speeds gives, whose plan is possible at least cost; where none is possible, the one of least cost.
/// With no way left (`distance <= take_off`) the plan is empty.
pub fn approach(task: &ApproachTask, law: &StepLaw) -> Approach {
    let way = task.distance - task.take_off;
    let mean = law.length(0.5 * (task.speed + task.speed_in)).max(1e-3);
    let shortest = law.length(task.speeds.0).max(1e-3);
    let longest = law.length(task.speeds.1).max(1e-3);
    if way <= 0.5 * law.length(task.speed_in) {
        let possible = (task.speed - task.speed_in).abs() <= task.change;
        let off = task.distance - task.take_off;
        let cost = task.weight * off * off + (task.speed - task.speed_in) * (task.speed - task.speed_in);
        return Approach { speeds: Vec::new(), take_off: task.distance, cost, possible };
    }
    // Far away it goes on as it is: only the last steps are planned.
    let own = law.length(task.speed).max(1e-3);
    let ahead = way - FAR as f64 * mean;
    if ahead > own {
        let steady = (ahead / own).min(1e6) as usize;
        let near = ApproachTask { distance: task.distance - steady as f64 * own, ..*task };
        let mut found = approach(&near, law);
        let steady = steady.min(MOST);
        found.speeds.splice(0..0, core::iter::repeat_n(task.speed, steady));
        return found;
    }
    let about = |length: f64| (way / length).min(MOST as f64) as usize;
    let (few, many) = (about(longest).max(1), (about(shortest) + 2).min(MOST));
    let guess = about(mean).clamp(few, many);
    let mut best: Option<Approach> = None;
    // From the likeliest number outwards, so that of two equally good plans the likelier is taken.
    for k in 0..=(many - few) {
        for n in [guess + k, guess.wrapping_sub(k)] {
            if !(few..=many).contains(&n) || (k == 0 && n != guess) {
                continue;
            }
            let found = steps(task, law, n);
            let better = best.as_ref().is_none_or(|b| (found.possible, -found.cost) > (b.possible, -b.cost));
            if better {
                best = Some(found);
            }
        }
    }
    best.unwrap_or(Approach { speeds: Vec::new(), take_off: task.distance, cost: f64::INFINITY, possible: false })
}

/// The best plan of `n` steps.
fn steps(task: &ApproachTask, law: &StepLaw, n: usize) -> Approach {
    // Unknown are v_1 to v_(n-1): (T + w a^2 1 1^T) v = b + w a c 1, with T = tridiag(-1, 2, -1).
    let (free, a, w) = (n - 1, law.slope, task.weight);
    let fixed = law.length(task.speed_in) + free as f64 * law.offset;
    let left = task.distance - task.take_off - fixed;
    let mut plain = vec![0.0; free];
    if free > 0 {
        plain[0] += task.speed;
        plain[free - 1] += task.speed_in;
    }
    let mut along = vec![1.0; free];
    eliminate(&mut plain);
    eliminate(&mut along);
    let (sum_plain, sum_along) = (plain.iter().sum::<f64>(), along.iter().sum::<f64>());
    // v = plain + along * s, with s = w a (left - a sum(v)).
    let s = w * a * (left - a * sum_plain) / (1.0 + w * a * a * sum_along);
    let mut speeds: Vec<f64> = plain.iter().zip(&along).map(|(p, q)| p + q * s).collect();
    speeds.push(task.speed_in);
    let gone: f64 = speeds.iter().map(|v| law.length(*v)).sum();
    let take_off = task.distance - gone;
    let off = take_off - task.take_off;
    let (mut cost, mut before, mut possible) = (w * off * off, task.speed, true);
    for v in &speeds {
        let change = v - before;
        cost += change * change;
        possible &= change.abs() <= task.change + 1e-9 && (task.speeds.0 - 1e-9..=task.speeds.1 + 1e-9).contains(v);
        before = *v;
    }
    Approach { speeds, take_off, cost, possible }
}

/// Solves `tridiag(-1, 2, -1) x = b` in place (Thomas 1949): the pivots are `(k + 2) / (k + 1)`.
fn eliminate(b: &mut [f64]) {
    let n = b.len();
    for k in 1..n {
        b[k] += b[k - 1] * (k as f64 / (k + 1) as f64);
    }
    for k in (0..n).rev() {
        let next = if k + 1 < n { b[k + 1] } else { 0.0 };
        b[k] = (b[k] + next) * ((k + 1) as f64 / (k + 2) as f64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::RandomStream;

    fn drawn(random: &mut RandomStream) -> ApproachTask {
        ApproachTask {
            distance: random.range(3.0, 9.0),
            speed: random.range(1.0, 5.0),
            take_off: random.range(0.5, 2.0),
            speed_in: random.range(2.0, 5.0),
            speeds: (1.0, 6.0),
            change: 0.8,
            weight: 20.0,
        }
    }

    fn cost(task: &ApproachTask, law: &StepLaw, speeds: &[f64]) -> f64 {
        let off = task.distance - speeds.iter().map(|v| law.length(*v)).sum::<f64>() - task.take_off;
        let mut before = task.speed;
        let changes = speeds.iter().map(|v| (v - core::mem::replace(&mut before, *v)).powi(2)).sum::<f64>();
        task.weight * off * off + changes
    }

    #[test]
    fn no_change_of_a_speed_makes_a_plan_better() {
        let law = StepLaw::PUBLISHED;
        let mut random = RandomStream::new(1, 7);
        for _ in 0..500 {
            let task = drawn(&mut random);
            let found = approach(&task, &law);
            let n = found.speeds.len();
            assert!(n > 0 && (found.speeds[n - 1] - task.speed_in).abs() < 1e-12, "it ends at the skill's speed");
            assert!((found.cost - cost(&task, &law, &found.speeds)).abs() < 1e-9 * (1.0 + found.cost));
            for k in 0..n - 1 {
                for by in [1e-3, -1e-3] {
                    let mut other = found.speeds.clone();
                    other[k] += by;
                    assert!(cost(&task, &law, &other) > found.cost, "step {k} of {n}: {task:?}");
                }
            }
        }
    }

    #[test]
    fn a_plan_that_is_followed_stays_the_plan() {
        // The rest of the best plan is the best plan of the rest (Bellman 1957), as long as the number of steps is the same.
        let law = StepLaw::PUBLISHED;
        let mut random = RandomStream::new(2, 7);
        let mut compared = 0;
        for _ in 0..300 {
            let task = drawn(&mut random);
            let whole = approach(&task, &law);
            if whole.speeds.len() < 3 {
                continue;
            }
            let first = whole.speeds[0];
            let rest = ApproachTask { distance: task.distance - law.length(first), speed: first, ..task };
            let again = steps(&rest, &law, whole.speeds.len() - 1);
            for (a, b) in again.speeds.iter().zip(&whole.speeds[1..]) {
                assert!((a - b).abs() < 1e-9);
                compared += 1;
            }
        }
        assert!(compared > 1000);
    }

    #[test]
    fn the_take_off_is_met_from_any_distance_where_there_is_room() {
        let law = StepLaw::PUBLISHED;
        let (mut worst, mut impossible): (f64, usize) = (0.0, 0);
        for k in 0..=700 {
            let distance = 30.0 + 0.1 * f64::from(k);
            let task = ApproachTask {
                distance: distance - 20.0,
                speed: 3.0,
                take_off: 1.2,
                speed_in: 3.6,
                speeds: (2.0, 5.0),
                change: 0.5,
                weight: 400.0,
            };
            let found = approach(&task, &law);
            worst = worst.max((found.take_off - task.take_off).abs());
            impossible += usize::from(!found.possible);
        }
        assert!(worst < 0.02 && impossible == 0, "{worst} m beside the take-off, {impossible} impossible");
    }

    #[test]
    fn what_is_too_near_is_not_called_possible() {
        let law = StepLaw::PUBLISHED;
        let task = ApproachTask {
            distance: 2.0,
            speed: 1.0,
            take_off: 1.0,
            speed_in: 5.0,
            speeds: (1.0, 6.0),
            change: 0.5,
            weight: 20.0,
        };
        assert!(!approach(&task, &law).possible);
        assert!(!approach(&ApproachTask { distance: 0.5, ..task }, &law).possible);
        assert!(approach(&ApproachTask { distance: 1.0, speed: 5.0, ..task }, &law).possible);
    }

    #[test]
    fn a_line_through_steps_on_a_line_is_that_line() {
        let law = StepLaw::fitted(&[2.0, 3.0, 4.5].map(|v| (v, 0.31 * v + 0.05))).unwrap();
        assert!((law.slope - 0.31).abs() < 1e-12 && (law.offset - 0.05).abs() < 1e-12);
        assert_eq!(StepLaw::fitted(&[(2.0, 0.5)]), None);
        assert_eq!(StepLaw::fitted(&[(2.0, 0.5), (3.0, 0.4)]), None);
    }
}
