//! The training curve as a CSV table.

use crate::train::ppo::trainer::Iteration;
use std::fmt::Write as _;

/// The curve with one line for each iteration; survival and reward are empty where they were not measured.
pub fn curve_csv(curve: &[Iteration]) -> String {
    let mut csv = String::from(
        "iteration,samples,seconds,reward,length_s,failed,kl,learning_rate,action_std,critic_loss,survival,evaluated_reward,simulation_s,inference_s,learning_s\n",
    );
    for i in curve {
        let (survival, reward) =
            i.evaluation.map_or((String::new(), String::new()), |(s, r)| (s.to_string(), r.to_string()));
        let [a, b, c] = i.parts;
        let _ = writeln!(
            csv,
            "{},{},{:.3},{:.5},{:.4},{:.4},{:.5},{:.3e},{:.4},{:.6},{survival},{reward},{a:.4},{b:.4},{c:.4}",
            i.number,
            i.samples,
            i.seconds,
            i.reward,
            i.length,
            i.failed,
            i.kl,
            i.learning_rate,
            i.action_std,
            i.critic_loss
        );
    }
    csv
}
