//! Whether left and right of a source are exchanged: whether the body fits better with the landmarks the other way round.
//!
//! Knees, elbows and ankles bend one way only, toes point ahead, and hips and shoulders face the same way: a body whose left
//! legs are called right fits badly.

use super::CharacterModel;
use super::body_landmarks::BodyLandmarks;
use super::inverse_kinematics::{BodySize, LandmarkTarget, PoseFit, PoseSolver};
use crate::asset::landmark_layout::LandmarkLayout;

/// A part of the body whose left and right can be exchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SidedPart {
    /// All of it.
    Body,
    /// Hips and what hangs on them.
    Legs,
    /// Shoulders, arms and face.
    Arms,
}

impl SidedPart {
    /// All of them.
    pub const ALL: [SidedPart; 3] = [SidedPart::Body, SidedPart::Legs, SidedPart::Arms];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            SidedPart::Body => "body",
            SidedPart::Legs => "legs",
            SidedPart::Arms => "arms",
        }
    }
}

/// Sums below which a pose fits too well for its sides to be doubted.
const GOOD_ENOUGH: f64 = 40.0;
/// Part of the sum that the other way round must reach.
const BETTER: f64 = 0.6;

/// For each landmark, which one takes its place when the sides of a part are exchanged.
pub(crate) fn exchange(
    layout: &LandmarkLayout,
    body: &BodyLandmarks,
    model: &CharacterModel,
    part: SidedPart,
) -> Vec<usize> {
    let hips: Vec<usize> = layout.trunk()[..2].iter().filter_map(|&i| Some(body.points[i]?.link)).collect();
    let in_legs = |mut link: usize| loop {
        if hips.contains(&link) {
            return true;
        }
        match model.links[link].parent {
            Some(parent) => link = parent,
            None => return false,
        }
    };
    let moves = |i: usize| match part {
        SidedPart::Body => true,
        SidedPart::Legs => body.points[i].is_some_and(|p| in_legs(p.link)),
        SidedPart::Arms => body.points[i].is_none_or(|p| !in_legs(p.link)),
    };
    (0..layout.landmarks.len()).map(|i| if moves(i) { layout.partner(i) } else { i }).collect()
}

/// The part whose exchange makes the body fit much better, with the fit it then has.
pub(crate) fn exchanged_part(
    solver: &PoseSolver,
    exchanges: &[(SidedPart, Vec<usize>)],
    trunk: [usize; 4],
    targets: &[Option<LandmarkTarget>],
    size: &BodySize,
    fit: &PoseFit,
) -> Option<(SidedPart, PoseFit)> {
    if fit.cost < GOOD_ENOUGH {
        return None;
    }
    let others = exchanges.iter().map(|(part, order)| {
        let turned: Vec<Option<LandmarkTarget>> = order.iter().map(|&i| targets[i]).collect();
        (*part, solver.solve(trunk, &turned, size, None))
    });
    let (part, best) = others.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost))?;
    (best.cost < BETTER * fit.cost).then_some((part, best))
}
