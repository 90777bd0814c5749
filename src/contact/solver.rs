//! Projected Gauss-Seidel over the contact rows.
//!
//! Rows of one link share that link's velocity; between links the impulses are handed over block by block, once all
//! rows of a link are done. Nothing reads another link's velocity in between, so this is Gauss-Seidel exactly.

use crate::contact::{ContactCandidate, ContactScratch};
use crate::math::{Force, Motion, Real};

/// The velocity of the link along the three rows, less the aim, in order.
#[inline(always)]
fn residuals<R: Real>(c: &ContactCandidate<R>, v: &Motion<R>) -> [R; 3] {
    let along = |r: usize| v.angular.dot(c.moments[r]) + v.linear.dot(c.directions[r]) - c.aims[r];
    [along(0), along(1), along(2)]
}

/// Adds impulses along the rows to the link's velocity and wrench.
#[inline(always)]
fn apply<R: Real>(c: &ContactCandidate<R>, change: [R; 3], v: &mut Motion<R>, w: &mut Force<R>) {
    let rows = c.responses.iter().zip(&c.moments).zip(&c.directions).zip(change);
    for (((response, moment), direction), d) in rows {
        *v = response.mul_add(d, v);
        w.moment = moment.mul_add(d, w.moment);
        w.force = direction.mul_add(d, w.force);
    }
}

/// Solves for the impulses of all candidates. The groups' velocities must be those without contact; afterwards they
/// include it, and their wrenches hold the impulse wrench on each link.
#[inline]
pub fn solve_contacts<R: Real>(sweeps: usize, scratch: &mut ContactScratch<R>) {
    let zero = R::zero();
    let ContactScratch { candidates, groups, mobility, .. } = scratch;

    // Warm start.
    for group in groups.iter_mut() {
        let (mut v, mut w) = (group.velocity, Force::zero());
        for c in &candidates[group.start..group.end] {
            apply(c, c.impulses, &mut v, &mut w);
        }
        group.wrench = w;
    }
    for a in 0..groups.len() {
        for b in 0..groups.len() {
            let wrench = groups[b].wrench;
            let motion = mobility.response(groups[a].link, groups[b].link, &wrench);
            groups[a].velocity += motion;
        }
    }

    for _ in 0..sweeps {
        for a in 0..groups.len() {
            let (start, end, link) = (groups[a].start, groups[a].end, groups[a].link);
            let (mut v, mut w) = (groups[a].velocity, Force::zero());
            for at in start..end {
                let partner = candidates[at].partner;
                let partner_normal = if partner == at { zero } else { candidates[partner].impulses[0] };
                let c = &mut candidates[at];
                let [n0, t0, s0] = c.impulses;
                let [un, mut ut, mut us] = residuals(c, &v);
                let [_, _, _, nt, ns, ts] = c.coupling;

                // Normal: pushes only. A grip pulls as well.
                let mut n = un.neg_mul_add(c.effective_mass[0], n0);
                if !c.is_grip {
                    n = n.max(zero);
                }
                let dn = n - n0;
                ut = nt.mul_add(dn, ut);
                us = ns.mul_add(dn, us);

                let us_alone = us;
                let mut t = ut.neg_mul_add(c.effective_mass[1], t0);
                let mut s;
                if c.is_grip {
                    us = ts.mul_add(t - t0, us);
                    s = us.neg_mul_add(c.effective_mass[2], s0);
                } else {
                    let limit = c.friction * n;
                    // Blade: friction along, the edge across. Others: first free in both, then onto the disc.
                    let t_line = t.clamp(-limit, limit);
                    let t_first = R::select(c.blade, t_line, t);
                    us = ts.mul_add(t_first - t0, us);
                    s = us.neg_mul_add(c.effective_mass[2], s0);
                    let bite = c.bite * (n + partner_normal.masked(c.blade));
                    let s_edge = s.clamp(-bite, bite);
                    let (mut t_disc, mut s_disc) = (t, s);
                    let beyond = (limit * limit).lt(t * t + s * s) & !c.blade;
                    if R::any(beyond) {
                        // It slides. One and the same step for both tangents, from where they were: at the fixed point
                        // the friction is opposite to the sliding. (The values above know of a row's full free impulse,
                        // which the disc will not grant.)
                        let mass = c.effective_mass[1].min(c.effective_mass[2]);
                        let (t_slide, s_slide) = (ut.neg_mul_add(mass, t0), us_alone.neg_mul_add(mass, s0));
                        let squared = (t_slide * t_slide + s_slide * s_slide).max(R::splat(1e-30));
                        let scale = (limit / squared.sqrt()).min(R::one());
                        t_disc = R::select(beyond, t_slide * scale, t);
                        s_disc = R::select(beyond, s_slide * scale, s);
                    }
                    t = R::select(c.blade, t_line, t_disc);
                    s = R::select(c.blade, s_edge, s_disc);
                }
                // Inactive lanes keep zero: their effective masses are zero.
                c.impulses = [n, t, s];
                apply(c, [dn, t - t0, s - s0], &mut v, &mut w);
            }
            groups[a].velocity = v;
            groups[a].wrench += w;
            for (b, group) in groups.iter_mut().enumerate() {
                if b != a {
                    group.velocity += mobility.response(group.link, link, &w);
                }
            }
        }
    }
}
