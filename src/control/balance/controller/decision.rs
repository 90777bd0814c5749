//! A decision: what is wished, what the ground can give, what joints do.

use super::super::forces::{ForceWeights, SupportPoint};
use super::super::hull::Hull;
use super::super::momentum::{Whole, wished, with_pressure_inside, within_reach};
use super::super::settings::BalanceMethod;
use super::{Balance, BalanceProbe};
use crate::asset::turn::rotation_vector;
use crate::contact::Terrain;
use crate::control::foot::SegmentSet;
use crate::dynamics::generalized_velocity;
use crate::math::Vec3;
use crate::sim::Simulator;
use glam::{DQuat, DVec2, DVec3};

/// Gain of the way of the wished centre of mass towards the middle of the support, 1/s^2, critically damped.
const GUIDE: f64 = 16.0;
/// Speeds at which ankles rise (m/s) and roll (rad/s) into a stance.
const RISE_SPEED: f64 = 0.05;
const ROLL_SPEED: f64 = 0.25;
/// A stance is stood on once the centre of mass is so near the middle of its support (m) and so slow (m/s), or after so long (s).
const NEAR: f64 = 0.015;
const SLOW: f64 = 0.06;
const LONGEST_SHIFT: f64 = 1.2;

/// Height of a segment's sole over the ground below which it counts as support that is about to be, in the landing of the start, m.
const SOON: f64 = 0.03;

impl Balance {
    /// One decision: what is wished, what the ground can give, what joints do.
    pub(super) fn decide(&mut self, sim: &mut Simulator<f64>, terrain: &impl Terrain<f64>, seconds: f64) {
        let root = sim.state.root_position.lane(0);
        self.decided_at = root;
        for footing in &mut self.footings {
            footing.look(&self.kinematics, root, terrain, seconds, self.settings.flying);
        }
        self.fresh = (self.fresh - seconds).max(0.0);
        let whole = self.whole(sim);
        self.go_over(&whole, seconds);
        self.step_where_due(&whole, seconds);
        for (footing, stance) in self.footings.iter_mut().zip(&self.stance.feet) {
            footing.rise += (stance.rise - footing.rise).clamp(-RISE_SPEED * seconds, RISE_SPEED * seconds);
            footing.roll += (stance.roll - footing.roll).clamp(-ROLL_SPEED * seconds, ROLL_SPEED * seconds);
            footing.shape(stance);
        }

        // Where the centre of mass shall be.
        let hull = self.hull(|k| self.stance.feet[k].touch);
        let goal_hull = if self.next.is_some() { self.hull(|k| self.kept(k)) } else { hull };
        let ground = self.ground_height();
        let middle = goal_hull.middle().unwrap_or(DVec2::new(whole.com.x, -whole.com.z));
        let standing = self.footings.iter().zip(&self.stance.feet).filter(|(_, s)| !s.touch.is_empty());
        let rise = standing.map(|(f, _)| f.rise).fold(0.0, f64::max);
        let goal = DVec3::new(middle.x, ground + self.height + rise, -middle.y);
        let (place, pace) = self.guide;
        let push = (goal - place) * GUIDE - pace * (2.0 * GUIDE.sqrt());
        let pace = pace + push * seconds;
        self.guide = (place + pace * seconds, pace);
        let (place, pace) = self.guide;

        // What the ground shall give.
        let mut wish = wished(&whole, &self.settings, place, pace, push);
        self.probe = BalanceProbe {
            com: whole.com,
            target: place,
            wished_force: wish.force,
            wished_moment: wish.moment,
            ..BalanceProbe::default()
        };
        // A step is instead of the hip, not with it.
        let hip = if self.capture.swing.is_some() { 0.0 } else { self.settings.hip };
        wish = within_reach(wish, &whole, &hull, ground, hip);
        self.gather_points(root, terrain);
        let below = hull.middle().unwrap_or(middle);
        self.forces.build(self.settings.friction, self.settings.margin, DVec3::new(below.x, ground, -below.y) - root);
        let weights = match self.settings.method {
            BalanceMethod::Cones => {
                ForceWeights { force: 1.0, upward: self.settings.upward_weight, moment: self.settings.moment_weight }
            }
            BalanceMethod::Pressure => {
                wish = with_pressure_inside(wish, &whole, &self.settings, &hull, ground);
                ForceWeights { force: 1.0, upward: 1.0, moment: 100.0 }
            }
        };
        let com = whole.com - root;
        let lever = com - self.forces.middle();
        let about = wish.moment + lever.cross(wish.force);
        let (mut force, mut moment) = self.forces.solve(wish.force, about, weights);
        if force.y > wish.force.y {
            // Less than the wished lift is cheap, more is not.
            let strict = ForceWeights { upward: weights.force, ..weights };
            (force, moment) = self.forces.solve(wish.force, about, strict);
        }
        if self.settings.method == BalanceMethod::Cones || self.forces.points().is_empty() {
            wish.force = force;
            wish.moment = moment - lever.cross(force);
        }
        (self.probe.force, self.probe.moment) = (force, moment - lever.cross(force));
        self.probe.points = self.forces.points().len();

        // What joints do.
        self.map.update(&self.constants, &self.kinematics, Vec3::<f64>::splat(com));
        self.track(sim);
        self.fill_system(root, &whole, wish.force + whole.mass * whole.gravity, wish.moment);
        self.system.solve();
        self.accelerations.copy_from_slice(&self.system.solution);
        generalized_velocity(&self.constants, &self.kinematics, &sim.state, &mut self.planned);
    }

    /// The body as a whole.
    pub(super) fn whole(&self, sim: &mut Simulator<f64>) -> Whole {
        let mass = self.model.mass();
        let momentum = sim.total_momentum();
        let lean = |link: usize| {
            let now = self.kinematics[link].rotation.lane(0);
            let wanted = self.heading;
            rotation_vector(wanted * DQuat::from_mat3(&now).conjugate())
        };
        Whole {
            mass,
            com: sim.center_of_mass().lane(0),
            velocity: momentum.linear.lane(0) / mass,
            spin: momentum.angular.lane(0),
            inertia: sim.total_inertia().to_mat3().lane(0),
            lean: 0.5 * (lean(0) + lean(self.model.trunk())),
            gravity: sim.settings().gravity,
        }
    }

    /// Segments of a foot that stand now and in the next stance.
    fn kept(&self, foot: usize) -> SegmentSet {
        let now = self.stance.feet[foot].touch;
        self.next.as_ref().map_or(now, |next| now.both(next.feet[foot].touch))
    }

    /// Steps onto the next stance: at once where it lets go of nothing, otherwise when the weight is where what is kept can bear it.
    fn go_over(&mut self, whole: &Whole, seconds: f64) {
        let Some(next) = &self.next else { return };
        let feet = self.stance.feet.len();
        if (0..feet).all(|k| self.kept(k).is_empty()) {
            // Nothing is kept: both stances together first.
            for (now, next) in self.stance.feet.iter_mut().zip(&next.feet) {
                now.touch = now.touch.either(next.touch);
            }
        }
        self.shifting += seconds;
        let lets_go = (0..feet).any(|k| self.kept(k) != self.stance.feet[k].touch);
        let off = self
            .hull(|k| self.kept(k))
            .middle()
            .map_or(0.0, |middle| DVec2::new(whole.com.x, -whole.com.z).distance(middle));
        let pace = DVec2::new(whole.velocity.x, whole.velocity.z);
        let ready = (off < NEAR && pace.length() < SLOW) || !lets_go || self.shifting > LONGEST_SHIFT;
        if ready && let Some(next) = self.next.take() {
            for ((footing, now), next) in self.footings.iter_mut().zip(&self.stance.feet).zip(&next.feet) {
                let new = next.touch.iter().filter(|&k| !now.touch.contains(k));
                footing.coming = new.fold(footing.coming, SegmentSet::with);
            }
            self.stance = next;
        }
    }

    /// The hull of those of these segments, by foot, that touch or soon will.
    pub(super) fn hull(&self, touch: impl Fn(usize) -> SegmentSet) -> Hull {
        let feet = self.footings.iter().enumerate();
        let soon = if self.fresh > 0.0 { SOON } else { self.settings.contact };
        Hull::of(feet.flat_map(|(k, f)| f.touching_places(f.near(touch(k), soon))).map(|p| DVec2::new(p.x, -p.z)))
    }

    /// Mean height of the ground where the body stands.
    pub(super) fn ground_height(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for p in self.footings.iter().zip(&self.stance.feet).flat_map(|(f, s)| f.touching_places(s.touch)) {
            sum += p.y;
            count += 1.0;
        }
        if count > 0.0 {
            sum / count
        } else {
            self.footings.iter().map(|f| f.ground.point.y).sum::<f64>() / self.footings.len() as f64
        }
    }

    /// The points that carry.
    pub(super) fn gather_points(&mut self, root: DVec3, terrain: &impl Terrain<f64>) {
        self.forces.clear();
        for (footing, stance) in self.footings.iter().zip(&self.stance.feet) {
            let segments = footing.anatomy.segments();
            for segment in stance.touch.iter().filter_map(|k| segments.get(k)) {
                let k = &self.kinematics[segment.link];
                for &(position, radius, index) in &segment.points {
                    let center = k.origin.lane(0) + k.rotation.lane(0) * position;
                    let hit = terrain.query(Vec3::<f64>::splat(root + center));
                    let gap = (hit.distance - radius) / self.settings.contact;
                    if gap < 0.95 {
                        let normal = hit.normal.lane(0);
                        self.forces.push(SupportPoint {
                            link: segment.link,
                            index,
                            place: center - normal * radius,
                            normal,
                            share: 1.0 - gap.max(0.0),
                        });
                    }
                }
            }
        }
    }
}
