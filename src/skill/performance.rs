//! What a trial was like: samples of a simulated skater, for judging it and for telling a game what happened.

use crate::math::Real;
use crate::model::{CharacterModel, Side};
use crate::sim::Simulator;
use glam::{DQuat, DVec3};

/// A blade at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BladeSample {
    /// Toe end of the blade, world frame, m.
    pub toe: DVec3,
    /// Heel end, world frame, m.
    pub heel: DVec3,
    /// The ice has pushed against it since it last forgot.
    pub pressed: bool,
    /// Lean, rad, positive towards the inside edge; `None` unless both ends are on the ice.
    pub lean: Option<f64>,
}

impl BladeSample {
    /// Height of the lower end above the ice at y = 0, m.
    pub fn gap(&self) -> f64 {
        self.toe.y.min(self.heel.y)
    }
    /// Middle of the blade, world frame, m.
    pub fn middle(&self) -> DVec3 {
        (self.toe + self.heel) * 0.5
    }
    /// Horizontal direction from heel to toe, unit; zero for a blade that stands upright.
    pub fn ahead(&self) -> DVec3 {
        ((self.toe - self.heel) * DVec3::new(1.0, 0.0, 1.0)).normalize_or_zero()
    }
}

/// A skater at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PerformanceSample {
    /// Since the trial began, s.
    pub time: f64,
    /// The root, world frame, m.
    pub root_position: DVec3,
    /// The root's rotation, root to world.
    pub root_rotation: DQuat,
    /// Velocity of the centre of mass, m/s.
    pub com_velocity: DVec3,
    /// Left blade, right blade.
    pub blades: [BladeSample; 2],
}

impl PerformanceSample {
    /// Horizontal direction the root faces, unit.
    pub fn facing(&self) -> DVec3 {
        (self.root_rotation * DVec3::NEG_Z * DVec3::new(1.0, 0.0, 1.0)).normalize_or(DVec3::NEG_Z)
    }
    /// Horizontal velocity of the centre of mass, m/s.
    pub fn velocity(&self) -> DVec3 {
        self.com_velocity * DVec3::new(1.0, 0.0, 1.0)
    }
    /// Speed along the ice, m/s.
    pub fn speed(&self) -> f64 {
        self.velocity().length()
    }
    /// The blade of a side.
    pub fn blade(&self, side: Side) -> &BladeSample {
        &self.blades[side_index(side)]
    }
    /// The one blade that the ice pushes against; `None` for none or both.
    pub fn standing(&self) -> Option<Side> {
        match [self.blades[0].pressed, self.blades[1].pressed] {
            [true, false] => Some(Side::Left),
            [false, true] => Some(Side::Right),
            _ => None,
        }
    }
    /// Neither blade is pushed against.
    pub fn airborne(&self) -> bool {
        !self.blades[0].pressed && !self.blades[1].pressed
    }
}

pub(crate) fn side_index(side: Side) -> usize {
    match side {
        Side::Left => 0,
        Side::Right => 1,
    }
}

/// Places in the character's list of the blades that its left and its right foot stand with; `None` if it lacks one.
pub fn blade_pair(model: &CharacterModel) -> Option<[usize; 2]> {
    Some([model.blade_index(Side::Left)?, model.blade_index(Side::Right)?])
}

/// Takes samples of a simulation, lane by lane: [`Watcher::look`] after every step, then [`Watcher::sample`] and
/// [`Watcher::forget`].
#[derive(Clone, Debug)]
pub struct Watcher<R: Real> {
    blades: [usize; 2],
    pressed: [R::Mask; 2],
}

impl<R: Real> Watcher<R> {
    /// A watcher of a skater; `None` for a character without a left and a right blade.
    pub fn new(model: &CharacterModel) -> Option<Self> {
        Some(Self { blades: blade_pair(model)?, pressed: [R::zero().lt(R::zero()); 2] })
    }

    /// Notes what the last step brought.
    #[inline]
    pub fn look(&mut self, sim: &Simulator<R>) {
        let model = sim.model();
        for (pressed, &blade) in self.pressed.iter_mut().zip(&self.blades) {
            let ends = [model.blades[blade].toe, model.blades[blade].heel];
            for point in ends {
                *pressed = *pressed | R::zero().lt(sim.state.contact_impulses[point].length_squared());
            }
        }
    }

    /// Whether the ice has pushed against the left and the right blade of a lane since it last forgot.
    pub fn pressed(&self, lane: usize) -> [bool; 2] {
        self.pressed.map(|mask| R::mask_lane(mask, lane))
    }

    /// Forgets what was noted.
    pub fn forget(&mut self) {
        self.pressed = [R::zero().lt(R::zero()); 2];
    }

    /// A sample of every lane. `time` is that of the samples, s.
    pub fn sample(&self, sim: &mut Simulator<R>, time: f64) -> Vec<PerformanceSample> {
        let momentum = sim.total_momentum().linear * R::splat(1.0 / sim.model().mass());
        let model = sim.model().clone();
        let root = sim.state.root_position;
        let ends = self.blades.map(|b| {
            let (toe, heel) = sim.blade_ends(&model.blades[b]);
            (root + toe, root + heel)
        });
        (0..R::LANES)
            .map(|lane| PerformanceSample {
                time,
                root_position: root.lane(lane),
                root_rotation: sim.state.root_rotation.lane(lane),
                com_velocity: momentum.lane(lane),
                blades: core::array::from_fn(|k| BladeSample {
                    toe: ends[k].0.lane(lane),
                    heel: ends[k].1.lane(lane),
                    pressed: R::mask_lane(self.pressed[k], lane),
                    lean: sim.blade_lean(self.blades[k], lane).map(|(lean, _)| lean),
                }),
            })
            .collect()
    }
}
