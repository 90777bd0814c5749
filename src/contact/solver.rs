//! Projected Gauss-Seidel over the contact rows.
//!
//! Rows of one link share that link's velocity. The motions that other links bring arrive together when the link's turn
//! comes: those from its own cluster at once, those from other clusters through the hub. Nothing reads a link's velocity
//! in between, so this is Gauss-Seidel exactly.

use super::candidate::ContactCluster;
use crate::contact::{ContactCandidate, ContactGroup, ContactMobility, ContactScratch};
use crate::math::{Force, Motion, Real};

/// `J v - aim`: the velocity of the link along the three rows, less what is aimed at.
#[inline(always)]
fn residuals<R: Real>(c: &ContactCandidate<R>, v: &Motion<R>) -> [R; 3] {
    // Two short sums side by side: the points of a link wait for each other here.
    let along = |r: usize| v.angular.dot(c.moments[r]) + v.linear.dot_add(c.directions[r], -c.bias_velocities[r]);
    [along(0), along(1), along(2)]
}

/// Adds the motion `Omega J^T d` of impulses along the rows.
#[inline(always)]
fn add_response<R: Real>(c: &ContactCandidate<R>, d: &[R; 3], v: &mut Motion<R>) {
    for (d, response) in d.iter().zip(&c.responses) {
        *v = response.mul_add(*d, v);
    }
}

/// Adds the wrench `J^T d` of impulses along the rows.
#[inline(always)]
fn add_wrench<R: Real>(c: &ContactCandidate<R>, d: &[R; 3], w: &mut Force<R>) {
    for ((d, moment), direction) in d.iter().zip(&c.moments).zip(&c.directions) {
        w.moment = moment.mul_add(*d, w.moment);
        w.force = direction.mul_add(*d, w.force);
    }
}

/// The new impulses at a contact point or a grip.
#[inline(always)]
fn project<R: Real>(c: &ContactCandidate<R>, residuals: [R; 3], partner_normal: R) -> [R; 3] {
    if !c.is_grip {
        return project_point(c, residuals, partner_normal);
    }
    let pulled = project_grip(c, residuals);
    if !R::any(c.active & !c.pulls) {
        return pulled;
    }
    let pushed = project_point(c, residuals, partner_normal);
    [0, 1, 2].map(|r| R::select(c.pulls, pulled[r], pushed[r]))
}

/// A grip that pulls: each row in turn is brought to its aim, then all of them back to what the grip can hold by.
#[inline]
fn project_grip<R: Real>(c: &ContactCandidate<R>, residuals: [R; 3]) -> [R; 3] {
    let [x0, y0, z0] = c.impulses;
    let [ux, uy, uz] = residuals;
    let [_, _, _, xy, xz, yz] = c.coupling;
    let x = ux.neg_mul_add(c.effective_mass[0], x0);
    let dx = x - x0;
    let y = xy.mul_add(dx, uy).neg_mul_add(c.effective_mass[1], y0);
    let uz = yz.mul_add(y - y0, xz.mul_add(dx, uz));
    let z = uz.neg_mul_add(c.effective_mass[2], z0);
    c.within_grip([x, y, z])
}

/// A point that pushes: each row in turn is brought to its aim, then back into the cone.
#[inline(always)]
fn project_point<R: Real>(c: &ContactCandidate<R>, residuals: [R; 3], partner_normal: R) -> [R; 3] {
    let [n0, t0, s0] = c.impulses;
    let [un, ut, us] = residuals;
    let [_, _, _, nt, ns, ts] = c.coupling;

    let n = un.neg_mul_add(c.effective_mass[0], n0).max(R::zero());
    let dn = n - n0;
    let ut = nt.mul_add(dn, ut);
    let us = ns.mul_add(dn, us);
    let t = ut.neg_mul_add(c.effective_mass[1], t0);
    let limit = c.friction * n;
    // Blade: friction along, the edge across. Others: first free in both, then onto the disc.
    let t_line = t.clamp(-limit, limit);
    let t_first = R::select(c.blade, t_line, t);
    let us_after = ts.mul_add(t_first - t0, us);
    let s = us_after.neg_mul_add(c.effective_mass[2], s0);
    let bite = c.bite * (n + partner_normal.masked(c.blade));
    let s_edge = s.clamp(-bite, bite);
    let (mut t_disc, mut s_disc) = (t, s);
    let beyond = (limit * limit).lt(s.mul_add(s, t * t)) & !c.blade;
    if R::any(beyond) {
        // It slides. One and the same step for both tangents, from where they were: at the fixed point the friction is
        // opposite to the sliding. (The values above know of a row's full free impulse, which the disc will not grant.)
        let mass = c.effective_mass[1].min(c.effective_mass[2]);
        let (t_slide, s_slide) = (ut.neg_mul_add(mass, t0), us.neg_mul_add(mass, s0));
        let squared = s_slide.mul_add(s_slide, t_slide * t_slide).max(R::splat(1e-30));
        let scale = (limit / squared.sqrt()).min(R::one());
        t_disc = R::select(beyond, t_slide * scale, t);
        s_disc = R::select(beyond, s_slide * scale, s);
    }
    [n, R::select(c.blade, t_line, t_disc), R::select(c.blade, s_edge, s_disc)]
}

/// What a iteration changed, by lane: it tells when to stop.
#[derive(Clone, Copy, Debug)]
struct SweepChange<R> {
    /// Largest change of an impulse, N s.
    largest: R,
    /// Sum of the normal impulses, N s.
    load: R,
}

impl<R: Real> SweepChange<R> {
    fn none() -> Self {
        Self { largest: R::zero(), load: R::zero() }
    }

    #[inline(always)]
    fn add(&mut self, d: &[R; 3], normal: R) {
        self.largest = self.largest.max(d[0].abs().max(d[1].abs().max(d[2].abs())));
        self.load += normal;
    }

    /// Lanes whose impulses still move by more than `tolerance` of the load.
    #[inline(always)]
    fn unsettled(&self, tolerance: R) -> R::Mask {
        (tolerance * self.load).lt(self.largest)
    }
}

/// False where the point's turn would change nothing: it carries nothing, and the link moves away from the surface.
///
/// An end of a blade may carry a side load without a normal one, and a grip pulls; they always have their turn.
#[inline(always)]
fn has_work<R: Real>(c: &ContactCandidate<R>, v: &Motion<R>, running: R::Mask) -> bool {
    if c.is_grip {
        return true;
    }
    let un = v.angular.dot(c.moments[0]) + v.linear.dot_add(c.directions[0], -c.bias_velocities[0]);
    let pressed = R::zero().lt(c.impulses[0].max(un.neg_mul_add(c.effective_mass[0], c.impulses[0])));
    R::any((pressed | c.blade) & c.active & running)
}

/// One pass over the points of a link in the lanes of `running`; returns the impulse wrench that it adds.
#[inline(always)]
fn sweep_link<R: Real, const COMPLIANT: bool>(
    group: &mut ContactGroup<R>,
    candidates: &mut [ContactCandidate<R>],
    inverse_masses: &[[R; 6]],
    running: R::Mask,
    change: &mut SweepChange<R>,
) -> Force<R> {
    let (mut v, mut w) = (group.velocity, Force::zero());
    for at in group.start..group.end {
        if !has_work(&candidates[at], &v, running) {
            // What carries nothing adds nothing to the load either.
            continue;
        }
        let partner = candidates[at].partner;
        let partner_normal = if partner == at { R::zero() } else { candidates[partner].impulses[0] };
        let c = &mut candidates[at];
        let new = project(c, residuals(c, &v), partner_normal);
        // Inactive lanes keep zero: their effective masses are zero.
        let kept = if R::LANES == 1 { new } else { [0, 1, 2].map(|r| R::select(running, new[r], c.impulses[r])) };
        let d = [kept[0] - c.impulses[0], kept[1] - c.impulses[1], kept[2] - c.impulses[2]];
        c.impulses = kept;
        change.add(&d, kept[0]);
        if COMPLIANT {
            c.push_surface(&inverse_masses[at], &d);
        }
        add_response(c, &d, &mut v);
        add_wrench(c, &d, &mut w);
    }
    group.velocity = v;
    w
}

/// Tells the other links of the cluster, from group number `first` on, about the wrench `w` on group number `a`; returns
/// what reaches the hub.
#[inline(always)]
fn tell_cluster<R: Real>(
    mobility: &ContactMobility<R>,
    groups: &mut [ContactGroup<R>],
    cluster: &ContactCluster<R>,
    a: usize,
    first: usize,
    w: &Force<R>,
) -> Force<R> {
    let link = groups[a].link;
    groups[a].wrench += *w;
    for (b, group) in groups[..cluster.end].iter_mut().enumerate().skip(first) {
        if b != a {
            group.velocity += mobility.near_response(group.link, link, w);
        }
    }
    mobility.to_hub(link, w)
}

/// Tells the other clusters, from number `first` on, about the wrench `w` on the hub of cluster number `a`.
#[inline(always)]
fn tell_others<R: Real>(
    mobility: &ContactMobility<R>,
    clusters: &mut [ContactCluster<R>],
    a: usize,
    first: usize,
    w: &Force<R>,
) {
    let hub = clusters[a].hub;
    for (b, cluster) in clusters.iter_mut().enumerate().skip(first) {
        if b != a {
            cluster.pending += mobility.near_response(cluster.hub, hub, w);
        }
    }
}

/// Solves for the impulses of all candidates. The groups' velocities must be those without contact; afterwards their
/// wrenches hold the impulse wrench on each link.
///
/// A lane rests once a iteration has changed none of its impulses by more than `tolerance` of its load: the next step starts
/// from there.
#[inline]
pub fn solve_contacts<R: Real>(iterations: usize, tolerance: f64, scratch: &mut ContactScratch<R>) {
    if scratch.compliant {
        solve::<R, true>(iterations, tolerance, scratch)
    } else {
        solve::<R, false>(iterations, tolerance, scratch)
    }
}

/// `solve_contacts`; `COMPLIANT` where a surface may give way.
#[inline]
fn solve<R: Real, const COMPLIANT: bool>(iterations: usize, tolerance: f64, scratch: &mut ContactScratch<R>) {
    let ContactScratch { storage: candidates, give_rows, groups, clusters, mobility, .. } = scratch;
    clusters.clear();
    for (a, group) in groups.iter().enumerate() {
        let hub = mobility.hub(group.link);
        match clusters.last_mut() {
            Some(cluster) if cluster.hub == hub => cluster.end = a + 1,
            _ => clusters.push(ContactCluster { hub, start: a, end: a + 1, pending: Motion::zero() }),
        }
    }

    // Warm start.
    for at in 0..clusters.len() {
        let cluster = clusters[at];
        let mut to_hub = Force::zero();
        for a in cluster.start..cluster.end {
            let group = &mut groups[a];
            let mut w = Force::zero();
            for c in &candidates[group.start..group.end] {
                add_wrench(c, &c.impulses, &mut w);
            }
            group.velocity += mobility.own(group.link).mul_force(&w);
            to_hub += tell_cluster(mobility, groups, &cluster, a, cluster.start, &w);
        }
        tell_others(mobility, clusters, at, 0, &to_hub);
    }

    let tolerance = R::splat(tolerance);
    let mut running = R::zero().lt(R::one());
    for iteration in 0..iterations {
        let mut change = SweepChange::none();
        // In the last iteration only those that still have their turn need to hear.
        let last = iteration + 1 == iterations;
        for at in 0..clusters.len() {
            let cluster = clusters[at];
            clusters[at].pending = Motion::zero();
            for group in &mut groups[cluster.start..cluster.end] {
                group.velocity += mobility.from_hub(group.link, &cluster.pending);
            }
            let mut to_hub = Force::zero();
            for a in cluster.start..cluster.end {
                let w = sweep_link::<R, COMPLIANT>(&mut groups[a], candidates, give_rows, running, &mut change);
                let first = if last { a + 1 } else { cluster.start };
                to_hub += tell_cluster(mobility, groups, &cluster, a, first, &w);
            }
            tell_others(mobility, clusters, at, if last { at + 1 } else { 0 }, &to_hub);
        }
        running = running & change.unsettled(tolerance);
        if !R::any(running) {
            break;
        }
    }
}
