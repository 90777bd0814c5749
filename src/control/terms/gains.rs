//! Servo gains in an action: the policy says how stiff joints are.
//!
//! Park, Yu, Lee 2018, "Multi-Segment Foot for Human Modelling and Simulation", Section 5.2: a normalised gain `alpha` for each joint of the feet, turned into a
//! stiffness by an exponential. Here it is a factor on the joint's own gains,
//!
//! ```text
//! kp = kp0 exp(alpha ln f),   kd = kd0 exp(alpha ln f / 2),   alpha in [-1, 1]
//! ```
//!
//! so that a policy that says nothing leaves the character as it is, and the damping ratio stays.

use crate::asset::policy_contract::GainAction;
use crate::math::Real;
use crate::model::CharacterModel;

/// Joints whose gains a policy sets, for one character.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GainTerm {
    /// The links, in the order of the action's last numbers.
    pub links: Vec<usize>,
    /// Stiffness (N m/rad) and damping (N m s/rad) of each for an action of zero.
    base: Vec<(f64, f64)>,
    /// Logarithm of the largest factor on the stiffness.
    log: f64,
}

impl GainTerm {
    /// For a character, with servo gains for all joints in place of its own or without. Links that it lacks are left out.
    pub fn new(action: &GainAction, model: &CharacterModel, gains: Option<(f64, f64)>) -> Self {
        let links: Vec<usize> = action.links.iter().filter_map(|name| model.link_index(name)).collect();
        let own = |link: &usize| gains.unwrap_or((model.links[*link].gains.kp, model.links[*link].gains.kd));
        Self { base: links.iter().map(own).collect(), links, log: logarithm(action.factor) }
    }

    /// Stiffness (N m/rad) and damping (N m s/rad) of number `k` for an action of `alpha`.
    #[inline]
    pub fn gains<R: Real>(&self, k: usize, alpha: R) -> (R, R) {
        let root = exponential(alpha.clamp(-R::one(), R::one()) * R::splat(0.5 * self.log));
        let (kp, kd) = self.base[k];
        (root * root * R::splat(kp), root * R::splat(kd))
    }
}

/// `e^x` for `|x|` up to 3: Taylor's series of `x / 16` to the eighth power, squared four times. Sums and products only, so the same bits everywhere.
#[inline]
fn exponential<R: Real>(x: R) -> R {
    let y = x * R::splat(1.0 / 16.0);
    let mut sum = R::one();
    for k in (1..=8).rev() {
        sum = (sum * y).mul_add(R::splat(1.0 / f64::from(k)), R::one());
    }
    for _ in 0..4 {
        sum = sum * sum;
    }
    sum
}

/// `ln x` for `x` from 1 to 100, by Newton's steps on [`exponential`].
fn logarithm(x: f64) -> f64 {
    let x = x.clamp(1.0, 100.0);
    let mut y = 0.5 * (x - 1.0).min(3.0);
    for _ in 0..40 {
        // Halved twice: within the range of the series.
        let quarter = exponential(0.25 * y);
        let value = quarter * quarter * quarter * quarter;
        y += 2.0 * (x - value) / (x + value);
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::preset;

    #[test]
    fn gains_go_from_a_part_to_a_multiple_and_keep_the_damping_ratio() {
        for k in 0..=60 {
            let x = -3.0 + 0.1 * f64::from(k);
            assert!((exponential(x) / x.exp() - 1.0).abs() < 1e-10, "{x}");
        }
        for x in [1.0, 2.0, 10.0, 99.0] {
            assert!((logarithm(x) - x.ln()).abs() < 1e-9, "{x}: {}", logarithm(x));
        }
        let model = preset("foot_human").unwrap();
        let action =
            GainAction { links: vec!["medial_phalanges_left".into(), "medial_phalanges_right".into()], factor: 4.0 };
        let term = GainTerm::new(&action, &model, Some((100.0, 10.0)));
        assert_eq!(term.links.len(), 2);
        for (alpha, kp) in [(-1.0, 25.0), (0.0, 100.0), (1.0, 400.0), (7.0, 400.0)] {
            let (p, d) = term.gains(1, alpha);
            assert!((p / kp - 1.0).abs() < 1e-9 && (d * d / p - 1.0).abs() < 1e-9, "{alpha}: {p}, {d}");
        }
    }
}
