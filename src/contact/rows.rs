//! The rows of the contact problem: directions, responses, bias velocities.

use crate::contact::{ContactScratch, OperationalInverseInertia, SurfaceHit};
use crate::math::{Mat3, Motion, Real, Vec3};
use crate::model::CharacterModel;
use glam::DVec3;

/// Tuning of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactSettings {
    /// Distance at which a point starts to take part and a blade end counts as on the ice, m. The blade rule of the
    /// plan: 5 mm.
    pub margin: f64,
    /// Most iterations of the Gauss-Seidel solver.
    pub iterations: usize,
    /// An iteration that changes no impulse by more than this part of the sum of the normal impulses is the last.
    pub tolerance: f64,
    /// Part of the penetration (beyond `slop`) removed in one step.
    pub correction: f64,
    /// Penetration that is left alone, m.
    pub slop: f64,
    /// Largest speed of penetration correction, m/s: a body that starts deep inside is pushed out, not shot out.
    pub correction_speed: f64,
    /// Part of the distance to its anchor that a grip closes in one step, at no more than `correction_speed`.
    pub grip_correction: f64,
    /// How far a grip slides along under its largest force before it opens, m.
    pub grip_slip: f64,
    /// Factor on every friction coefficient.
    pub friction_scale: f64,
}

impl Default for ContactSettings {
    fn default() -> Self {
        Self {
            margin: 0.005,
            iterations: 5,
            tolerance: 1e-3,
            correction: 0.1,
            slop: 0.0002,
            correction_speed: 0.5,
            grip_correction: 0.1,
            grip_slip: 0.02,
            friction_scale: 1.0,
        }
    }
}

/// Response of the link's motion to a force at `arm`: two 3 x 3 blocks (angular, linear).
#[inline(always)]
fn force_response<R: Real>(own: &OperationalInverseInertia<R>, arm: Vec3<R>) -> (Mat3<R>, Mat3<R>) {
    let (aa, ll) = (own.aa.to_mat3(), own.ll.to_mat3());
    (own.al.add_mul_skew(&aa, arm), ll.add_mul_skew(&own.al.transpose(), arm))
}

/// A tangent pair of a unit normal, without a branch. Duff et al. 2017, "Building an Orthonormal Basis, Revisited", with
/// the axes turned so that the jump lies at level normals, where no ground has its own.
#[inline(always)]
fn tangents<R: Real>(n: Vec3<R>) -> (Vec3<R>, Vec3<R>) {
    let one = R::one();
    let sign = R::select(n.y.lt(R::zero()), -one, one);
    let a = -(sign + n.y).recip();
    let b = n.z * n.x * a;
    (Vec3::new(sign * b, -(sign * n.z), one + sign * n.z * n.z * a), Vec3::new(sign + n.x * n.x * a, -n.x, b))
}

/// What the rows of a point aim at, `gap` (m) from a surface: to move along with it and not to pass through.
#[inline(always)]
fn surface_bias_velocities<R: Real>(
    hit: &SurfaceHit<R>,
    gap: R,
    [n, t, s]: [Vec3<R>; 3],
    settings: &ContactSettings,
    inverse_h: R,
) -> [R; 3] {
    let zero = R::zero();
    // Apart: it may close the gap within the step. Inside: it is pushed out gently.
    let outward = (-gap - R::splat(settings.slop)).max(zero) * (inverse_h * R::splat(settings.correction));
    let outward = outward.min(R::splat(settings.correction_speed));
    let apart = zero.lt(gap);
    let carried = hit.velocity;
    [carried.dot(n) + R::select(apart, -(gap * inverse_h), outward), carried.dot(t), carried.dot(s)]
}

/// What the rows are made from.
#[derive(Clone, Copy, Debug)]
pub struct RowInputs<'a, R> {
    /// The character.
    pub model: &'a CharacterModel,
    /// Tuning.
    pub settings: &'a ContactSettings,
    /// Factor on every friction coefficient, by lane.
    pub friction_scale: R,
    /// Impulse of the last step at each contact point, world axes, N s.
    pub warm_points: &'a [Vec3<R>],
    /// Impulse of the last step at each grip, world axes, N s.
    pub warm_grips: &'a [Vec3<R>],
    /// Length of the step, s.
    pub h: f64,
}

/// Fills the rows of every candidate.
#[inline]
pub fn build_rows<R: Real>(inputs: &RowInputs<R>, scratch: &mut ContactScratch<R>) {
    let RowInputs { model, settings, friction_scale, .. } = *inputs;
    let RowInputs { warm_points, warm_grips, h, .. } = *inputs;
    let (zero, one) = (R::zero(), R::one());
    let inverse_h = R::splat(1.0 / h);
    // A turn by more than this in half a step is no carve.
    let (half_step, most_turn) = (R::splat(0.5 * h), R::splat(0.1));
    let ContactScratch {
        probes,
        grip_probes,
        blades,
        storage: candidates,
        compliant,
        inverse_masses,
        give_rows,
        groups,
        mobility,
        ..
    } = scratch;
    for group in groups.iter() {
        let own = mobility.own(group.link);
        for (c, at) in candidates[group.start..group.end].iter_mut().zip(group.start..) {
            let warm;
            let mut partner_normal = zero;
            if c.is_grip {
                let probe = &grip_probes[c.source];
                c.directions = [Vec3::splat(DVec3::X), Vec3::splat(DVec3::Y), Vec3::splat(DVec3::Z)];
                c.grip_limit = R::splat(model.grips[c.source].max_force * h);
                // It follows its anchor, and comes nearer to it gently.
                let closer = probe.to_anchor * (inverse_h * R::splat(settings.grip_correction));
                let speed = closer.length().max(R::splat(1e-12));
                let follow = closer * (R::splat(settings.correction_speed) / speed).min(one) + probe.velocity;
                c.bias_velocities = [follow.x, follow.y, follow.z];
                c.friction = zero;
                let pushes = c.active & !c.pulls;
                if R::any(pushes) {
                    // There it is a contact point like any other.
                    let n = probe.hit.normal;
                    let (t, s) = tangents(n);
                    let gap = probe.hit.distance;
                    let bias_velocities = surface_bias_velocities(&probe.hit, gap, [n, t, s], settings, inverse_h);
                    for r in 0..3 {
                        c.directions[r] = Vec3::select(pushes, [n, t, s][r], c.directions[r]);
                        c.bias_velocities[r] = R::select(pushes, bias_velocities[r], c.bias_velocities[r]);
                    }
                    let friction = probe.hit.friction * R::splat(settings.friction_scale) * friction_scale;
                    c.friction = friction.masked(pushes);
                }
                warm = warm_grips[c.source];
            } else {
                let probe = &probes[c.source];
                let n = probe.hit.normal;
                let point = &model.contact_points[c.source];
                let (mut t, mut s) = tangents(n);
                c.bite = R::splat(1e9);
                let mut glide = zero;
                if let crate::model::ContactKind::BladeToe(b) | crate::model::ContactKind::BladeHeel(b) = point.kind
                    && let Some(blade) = &blades[b]
                {
                    let spec = &model.blades[b];
                    let half = model.contact_points[spec.toe].position - model.contact_points[spec.heel].position;
                    let x = half.length() * if c.source == spec.toe { 0.5 } else { -0.5 };
                    let (along, across) = blade.edge_frame(R::splat(x));
                    // The velocity turns by twice this angle in the step. A force across the blade as it will be would
                    // be square to the velocity after the step only, and brake; square to the mean of the two it does
                    // no work. The aim still brings the velocity onto the line.
                    let speed = (group.velocity.at(c.arm) - probe.hit.velocity).dot(along);
                    let turn = (speed * blade.curvature * half_step).clamp(-most_turn, most_turn);
                    let scale = turn.mul_add(turn, one).sqrt().recip();
                    t = Vec3::select(c.blade, (along - across * turn) * scale, t);
                    s = Vec3::select(c.blade, (across + along * turn) * scale, s);
                    glide = (speed * turn * scale).masked(c.blade);
                    c.bite = R::splat(spec.bite.unwrap_or(1e9));
                    // The edge holds by the load on both ends: what the other one starts from counts too.
                    let other = if c.source == spec.toe { spec.heel } else { spec.toe };
                    partner_normal = warm_points[other].dot(probes[other].hit.normal).max(zero).masked(c.blade);
                }
                c.directions = [n, t, s];
                c.friction = probe.hit.friction * R::splat(point.friction * settings.friction_scale) * friction_scale;
                c.bias_velocities = surface_bias_velocities(&probe.hit, probe.gap, c.directions, settings, inverse_h);
                c.bias_velocities[2] += glide;
                warm = warm_points[c.source];
            }
            let (angular, linear) = force_response(own, c.arm);
            for r in 0..3 {
                let d = c.directions[r];
                c.moments[r] = c.arm.cross(d);
                c.responses[r] = Motion { angular: angular.mul_vec(d), linear: linear.mul_vec(d) };
            }
            let entry = |r: usize, s: usize| {
                c.moments[r].dot(c.responses[s].angular) + c.directions[r].dot(c.responses[s].linear)
            };
            c.coupling = [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)];
            let gives_way = *compliant && !c.is_grip;
            if gives_way {
                let moved = c.directions.map(|d| inverse_masses[at].mul_vec(d));
                let entry = |r: usize, s: usize| c.directions[r].dot(moved[s]);
                give_rows[at] = [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)];
                c.coupling.iter_mut().zip(&give_rows[at]).for_each(|(own, surface)| *own += *surface);
            } else if *compliant {
                give_rows[at] = [zero; 6];
            }
            for r in 0..3 {
                // Never negative in exact arithmetic; the floor keeps rounding out of the reciprocal.
                let safe = c.coupling[r].max(R::splat(1e-9));
                c.effective_mass[r] = (one / safe).masked(c.active);
            }
            // Warm start: the last impulse, on today's directions.
            let warm = warm.masked(c.active);
            c.impulses = [warm.dot(c.directions[0]), warm.dot(c.directions[1]), warm.dot(c.directions[2])];
            let pulled = if c.is_grip { c.within_grip(c.impulses) } else { c.impulses };
            c.impulses[0] = c.impulses[0].max(zero);
            let limit = c.friction * c.impulses[0];
            c.impulses[1] = c.impulses[1].clamp(-limit, limit);
            let side = R::select(c.blade, c.bite * (c.impulses[0] + partner_normal), limit);
            c.impulses[2] = c.impulses[2].clamp(-side, side);
            if c.is_grip {
                c.impulses = [0, 1, 2].map(|r| R::select(c.pulls, pulled[r], c.impulses[r]));
            }
            if gives_way {
                let warm = c.impulses;
                c.push_surface(&give_rows[at], &warm);
            }
        }
    }
}
