//! What a rollout saw, did and earned, and how much better than expected that was.

use crate::train::ppo::environment::EpisodeStatus;

/// The experience of one rollout, tick by tick, `width` rows each: row `tick * width + lane`.
#[derive(Default)]
pub(crate) struct Experience {
    width: usize,
    /// Normalised observations (rows x inputs).
    pub observations: Vec<f32>,
    /// Actions as they were tried (rows x outputs).
    pub actions: Vec<f32>,
    /// The actions without exploration (rows x outputs).
    pub means: Vec<f32>,
    /// Log-probability of each action, but for a constant that all share.
    pub log_probabilities: Vec<f32>,
    /// Rewards, scaled so that values stay near one.
    pub rewards: Vec<f32>,
    /// What the critic expected.
    pub values: Vec<f32>,
    /// How the tick left each lane's episode.
    pub status: Vec<EpisodeStatus>,
    /// The critic's value of the state in which an episode was truncated; without meaning elsewhere.
    pub final_values: Vec<f32>,
    pub advantages: Vec<f32>,
    /// What the critic is to expect.
    pub returns: Vec<f32>,
}

impl Experience {
    /// Room for `ticks` ticks of `width` lanes; allocates only when it has never been this large.
    pub fn reshape(&mut self, ticks: usize, width: usize, inputs: usize, outputs: usize) {
        self.width = width;
        let rows = ticks * width;
        self.observations.resize(rows * inputs, 0.0);
        for buffer in [&mut self.actions, &mut self.means] {
            buffer.resize(rows * outputs, 0.0);
        }
        for buffer in [
            &mut self.log_probabilities,
            &mut self.rewards,
            &mut self.values,
            &mut self.final_values,
            &mut self.advantages,
            &mut self.returns,
        ] {
            buffer.resize(rows, 0.0);
        }
        self.status.resize(rows, EpisodeStatus::Running);
    }

    pub fn rows(&self) -> usize {
        self.values.len()
    }

    /// The rows before and after a row that belong to the same episode.
    pub fn neighbours(&self, row: usize) -> [Option<usize>; 2] {
        let runs = |from: usize| self.status[from] == EpisodeStatus::Running;
        let before = row.checked_sub(self.width).filter(|b| runs(*b));
        let after = Some(row + self.width).filter(|a| *a < self.rows() && runs(row));
        [before, after]
    }

    /// Generalised advantage estimation (Schulman, Moritz, Levine, Jordan, Abbeel 2016, "High-Dimensional Continuous Control
    /// Using Generalized Advantage Estimation", equation 16), backwards in time. With the reward r, the value V of a row and
    /// V' of the state that its tick led to:
    ///
    /// ```text
    /// delta = r + gamma V' - V        advantage = delta + gamma lambda (advantage of the lane's next row)
    /// ```
    ///
    /// V' is the next row's value where the episode runs, that of its last state where it was truncated, and 0 where it was
    /// terminated; nothing is carried over the end of an episode. `next_values` holds, for each lane, the value of the state after
    /// the last tick; it is used up.
    pub fn estimate_advantages(&mut self, gamma: f32, lambda: f32, next_values: &mut [f32]) {
        let mut carried = vec![0.0_f32; self.width];
        for first in (0..self.rows()).step_by(self.width.max(1)).rev() {
            for (lane, (next, carried)) in next_values.iter_mut().zip(&mut carried).enumerate() {
                let row = first + lane;
                let (after, kept) = match self.status[row] {
                    EpisodeStatus::Running => (*next, *carried),
                    EpisodeStatus::Truncated => (self.final_values[row], 0.0),
                    EpisodeStatus::Terminated => (0.0, 0.0),
                };
                let delta = self.rewards[row] + gamma * after - self.values[row];
                *carried = delta + gamma * lambda * kept;
                self.advantages[row] = *carried;
                self.returns[row] = *carried + self.values[row];
                *next = self.values[row];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two lanes over three ticks, with this status and these values; each lane's rewards make its values come true.
    #[test]
    fn true_values_leave_no_advantage() {
        let (gamma, values) = (0.9_f32, [0.7, 0.1, 0.4, 0.5, 0.2, 0.3]);
        let status = [
            [EpisodeStatus::Running, EpisodeStatus::Truncated],
            [EpisodeStatus::Terminated, EpisodeStatus::Running],
            [EpisodeStatus::Running, EpisodeStatus::Truncated],
        ];
        let mut experience = Experience::default();
        experience.reshape(3, 2, 1, 1);
        experience.values = values.to_vec();
        experience.status = status.concat();
        experience.final_values = vec![f32::NAN, 0.9, f32::NAN, f32::NAN, f32::NAN, 0.8];
        let mut next = [0.6, f32::NAN];
        let follows = [values[2], 0.9, 0.0, values[5], 0.6, 0.8];
        experience.rewards = values.iter().zip(follows).map(|(v, after)| v - gamma * after).collect();
        experience.estimate_advantages(gamma, 0.95, &mut next);
        assert!(experience.advantages.iter().all(|a| a.abs() < 1e-6), "{:?}", experience.advantages);
        assert!(experience.returns.iter().zip(values).all(|(r, v)| (r - v).abs() < 1e-6));
        // One reward more at a lane's last tick is carried back to where its episode began, and not beyond.
        experience.rewards[4] += 1.0;
        experience.rewards[5] += 1.0;
        experience.estimate_advantages(gamma, 0.95, &mut [0.6, f32::NAN]);
        let expected = [0.0, 0.0, 0.0, gamma * 0.95, 1.0, 1.0];
        let apart = experience.advantages.iter().zip(expected).map(|(a, e)| (a - e).abs()).fold(0.0, f32::max);
        assert!(apart < 1e-5, "{:?}", experience.advantages);
    }

    #[test]
    fn neighbours_are_of_the_same_episode() {
        let mut experience = Experience::default();
        experience.reshape(3, 2, 1, 1);
        experience.status[3] = EpisodeStatus::Truncated;
        assert_eq!(experience.neighbours(2), [Some(0), Some(4)]);
        assert_eq!(experience.neighbours(3), [Some(1), None]);
        assert_eq!(experience.neighbours(5), [None, None]);
    }
}
