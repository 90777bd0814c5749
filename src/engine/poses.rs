//! Where the links of an athlete are, at the fixed ticks and between them.

use crate::engine::LinkId;
use crate::model::LinkTransform;
use bevy::prelude::*;
use std::time::Duration;

/// Places of all links of an athlete by link index, world frame; empty until its body is there.
#[derive(Component, Clone, Debug, Default, Reflect)]
#[reflect(Component, Default)]
pub struct LinkPoses {
    /// At the fixed tick before the last one.
    pub previous: Vec<LinkTransform>,
    /// At the last fixed tick.
    pub current: Vec<LinkTransform>,
    /// Now: what is drawn. Updated before `Update`.
    pub interpolated: Vec<LinkTransform>,
    /// Simulated time of `previous`, s.
    pub previous_time: f64,
    /// Simulated time of `current`, s.
    pub current_time: f64,
    /// Simulated time of `interpolated`, s.
    pub interpolated_time: f64,
    /// Time of the fixed tick that did not fill a whole step, s: by so much `current` is older than its tick.
    pub lag: f64,
}

impl LinkPoses {
    /// Where a link is now, world frame; identity before the body is there.
    pub fn link(&self, link: LinkId) -> Transform {
        self.interpolated.get(link.index()).map_or(Transform::IDENTITY, to_transform)
    }

    /// Shows the state `overstep` (0 to 1) of the way through the fixed tick that is under way; `None` shows the last
    /// fixed tick's. `tick` is how long that was for athletes.
    pub(crate) fn interpolate(&mut self, overstep: Option<f64>, tick: Duration) {
        let span = self.current_time - self.previous_time;
        // Ticks hold 18 or 19 whole steps, so the poses are not evenly spaced: the fraction is taken between their own
        // times. It ends up to one step beyond 1, never before 0.
        let s = match overstep {
            Some(overstep) if span > 0.0 => {
                let back = (1.0 - overstep) * tick.as_secs_f64();
                ((span + self.lag - back) / span).clamp(0.0, 1.5)
            }
            _ => 1.0,
        };
        self.interpolated_time = self.previous_time + s * span;
        self.interpolated.clear();
        self.interpolated.extend(self.previous.iter().zip(&self.current).map(|(a, b)| a.mix(b, s)));
    }

    /// Makes `current` the pose before, in order to overwrite it.
    pub(crate) fn advance(&mut self) {
        std::mem::swap(&mut self.previous, &mut self.current);
        self.previous_time = self.current_time;
    }

    /// Forgets the pose before: nothing is interpolated across a jump.
    pub(crate) fn cut(&mut self) {
        self.previous.clone_from(&self.current);
        self.previous_time = self.current_time;
    }
}

/// In single precision.
pub(crate) fn to_transform(link: &LinkTransform) -> Transform {
    Transform::from_translation(link.position.as_vec3()).with_rotation(link.rotation.as_quat().normalize())
}
