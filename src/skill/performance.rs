//! What an episode was like: samples of a simulated athlete, for judging it and for telling a game what happened.

use crate::control::TrackingError;
use crate::control::tracking::Support;
use crate::math::{Real, Vec3};
use crate::model::{CharacterModel, FootKind, Side};
use crate::sim::Simulator;
use glam::{DQuat, DVec3};

/// A foot at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FootSample {
    /// Toe end of the blade or the sole's lower side, world frame, m.
    pub toe: DVec3,
    /// Heel end, world frame, m.
    pub heel: DVec3,
    /// The ground has pushed against it since the recorder last forgot.
    pub pressed: bool,
    /// Lean of a blade, rad, positive towards the inside edge; `None` unless both ends are on the ice, and for a sole.
    pub lean: Option<f64>,
    /// Height of the ground that carries the body, m.
    pub ground: f64,
}

impl FootSample {
    /// Height of the lower end above the ground that carries the body, m.
    pub fn gap(&self) -> f64 {
        self.toe.y.min(self.heel.y) - self.ground
    }
    /// The middle between both ends, m.
    pub fn middle(&self) -> DVec3 {
        (self.toe + self.heel) * 0.5
    }
    /// Horizontal direction from heel to toe, unit; zero for a foot that stands upright.
    pub fn ahead(&self) -> DVec3 {
        ((self.toe - self.heel) * DVec3::new(1.0, 0.0, 1.0)).normalize_or_zero()
    }
}

/// An athlete at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PerformanceSample {
    /// Since the episode began, s.
    pub time: f64,
    /// The root, world frame, m.
    pub root_position: DVec3,
    /// The root's rotation, root to world.
    pub root_rotation: DQuat,
    /// Velocity of the centre of mass, m/s.
    pub com_velocity: DVec3,
    /// Left foot, right foot; a foot that the body lacks never touches anything.
    pub feet: [FootSample; 2],
    /// How far the body is from its reference; known at decisions.
    pub error: Option<TrackingError>,
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
    /// Speed along the ground, m/s.
    pub fn speed(&self) -> f64 {
        self.velocity().length()
    }
    /// The foot of a side.
    pub fn foot(&self, side: Side) -> &FootSample {
        &self.feet[side_index(side)]
    }
    /// The one foot that the ground pushes against; `None` for none or both.
    pub fn standing(&self) -> Option<Side> {
        match [self.feet[0].pressed, self.feet[1].pressed] {
            [true, false] => Some(Side::Left),
            [false, true] => Some(Side::Right),
            _ => None,
        }
    }
    /// Neither foot is pushed against.
    pub fn airborne(&self) -> bool {
        !self.feet[0].pressed && !self.feet[1].pressed
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

/// What a recorder looks at of a foot.
#[derive(Clone, Debug)]
struct FootProbe {
    toe: usize,
    heel: usize,
    blade: Option<usize>,
    /// Contact points that press.
    points: Vec<usize>,
}

impl FootProbe {
    /// The foot of a side; a body with one foot in the middle has it on the left.
    fn of(model: &CharacterModel, side: Side) -> Option<Self> {
        let alone = || model.feet().first().filter(|f| f.side.is_none() && side == Side::Left);
        let foot = model.foot(side).or_else(alone)?;
        let (blade, points) = match foot.kind {
            FootKind::Blade(blade) => (Some(blade), vec![foot.toe, foot.heel]),
            FootKind::Sole => (None, model.foot_points(foot).collect()),
        };
        Some(Self { toe: foot.toe, heel: foot.heel, blade, points })
    }
}

/// Takes samples of a simulation, lane by lane: [`PerformanceRecorder::look`] after every step, then
/// [`PerformanceRecorder::sample`] and [`PerformanceRecorder::forget`].
#[derive(Clone, Debug)]
pub struct PerformanceRecorder<R: Real> {
    feet: [Option<FootProbe>; 2],
    pressed: [R::Mask; 2],
}

impl<R: Real> PerformanceRecorder<R> {
    /// A recorder of an athlete.
    pub fn new(model: &CharacterModel) -> Self {
        let feet = [Side::Left, Side::Right].map(|side| FootProbe::of(model, side));
        Self { feet, pressed: [R::zero().lt(R::zero()); 2] }
    }

    /// Notes what the last step brought.
    #[inline]
    pub fn look(&mut self, sim: &Simulator<R>) {
        for (pressed, foot) in self.pressed.iter_mut().zip(&self.feet) {
            for &point in foot.iter().flat_map(|f| &f.points) {
                *pressed = *pressed | R::zero().lt(sim.state.contact_impulses[point].length_squared());
            }
        }
    }

    /// Whether the ground has pushed against the left and the right foot of a lane since it last forgot.
    pub fn pressed(&self, lane: usize) -> [bool; 2] {
        self.pressed.map(|mask| R::mask_lane(mask, lane))
    }

    /// Forgets what was noted.
    pub fn forget(&mut self) {
        self.pressed = [R::zero().lt(R::zero()); 2];
    }

    /// A sample of every lane. `time` is that of the samples, s; `support` what carries the lanes.
    pub fn sample(&self, sim: &mut Simulator<R>, time: f64, support: &Support<R>) -> Vec<PerformanceSample> {
        let momentum = sim.total_momentum().linear * R::splat(1.0 / sim.model().mass());
        let model = sim.model().clone();
        let root = sim.state.root_position;
        let links = sim.kinematics();
        let place = |point: usize| {
            let p = &model.contact_points[point];
            let link = &links[p.link];
            let down = Vec3::new(R::zero(), R::splat(p.radius), R::zero());
            root + (link.origin + link.rotation.mul_vec(Vec3::splat(p.position))) - down
        };
        let ends = self.feet.each_ref().map(|foot| foot.as_ref().map(|f| (place(f.toe), place(f.heel))));
        let foot = |k: usize, lane: usize| match (&self.feet[k], &ends[k]) {
            (Some(probe), Some((toe, heel))) => FootSample {
                toe: toe.lane(lane),
                heel: heel.lane(lane),
                pressed: R::mask_lane(self.pressed[k], lane),
                lean: probe.blade.and_then(|b| sim.blade_lean(b, lane)).map(|(lean, _)| lean),
                ground: support.height.lane(lane),
            },
            _ => FootSample::default(),
        };
        (0..R::LANES)
            .map(|lane| PerformanceSample {
                time,
                root_position: root.lane(lane),
                root_rotation: sim.state.root_rotation.lane(lane),
                com_velocity: momentum.lane(lane),
                feet: core::array::from_fn(|k| foot(k, lane)),
                error: None,
            })
            .collect()
    }
}
