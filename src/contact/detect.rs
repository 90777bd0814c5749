//! Which contact points are near a surface.

use super::grips::{GripProbe, probe_grips};
use super::scratch::Probe;
use crate::contact::{BladeContact, ContactGroup, ContactScratch, ContactSettings, GripInputs, Terrain};
use crate::dynamics::LinkKinematics;
use crate::math::{Real, Vec3};
use crate::model::{CharacterModel, ContactKind};

/// What is known of a candidate when it joins.
struct NewContact<R: Real> {
    source: usize,
    is_grip: bool,
    active: R::Mask,
    blade: R::Mask,
    pulls: R::Mask,
    arm: Vec3<R>,
}

/// Asks the terrain about every link that is near it, and lists the points within `settings.margin` of a surface. Grips that
/// hold on to something are listed too; one that has slipped opens. `h` is the length of a step, s. Returns true if anything takes
/// part.
#[inline]
pub fn detect_contacts<R: Real>(
    model: &CharacterModel,
    kinematics: &[LinkKinematics<R>],
    root_position: Vec3<R>,
    terrain: &impl Terrain<R>,
    settings: &ContactSettings,
    h: f64,
    grips: GripInputs<R>,
    scratch: &mut ContactScratch<R>,
) -> bool {
    scratch.clear();
    let ContactSettings { margin, grip_slip, .. } = *settings;
    let closed = &mut scratch.grip_probes;
    let any_grip = probe_grips(model, kinematics, root_position, terrain, (margin, grip_slip, h), grips, closed);
    let margin = R::splat(margin);
    let ContactScratch {
        order,
        probes,
        grip_probes,
        reach,
        blades,
        storage: candidates,
        count,
        unanswered,
        compliant,
        inverse_masses,
        groups,
        ..
    } = scratch;
    let far = R::splat(1e9);
    // Anything beyond this, and NaN, is no answer; of a body that is nowhere none is expected.
    let absurd = R::splat(1e12);
    let somewhere = root_position.length_squared().lt(absurd * absurd);
    for (link, radius, range) in reach.iter() {
        let k = &kinematics[*link];
        let origin = root_position + k.origin;
        // The link's ball first: most links are in the air most of the time.
        let clearance = terrain.clearance(origin);
        *unanswered = *unanswered | (somewhere & !clearance.abs().lt(absurd));
        let near = (clearance - R::splat(*radius)).lt(margin);
        if !R::any(near) {
            for &p in &order[range.clone()] {
                probes[p].gap = far;
            }
            continue;
        }
        for &p in &order[range.clone()] {
            let point = &model.contact_points[p];
            let arm = k.rotation.mul_vec(Vec3::splat(point.position));
            let hit = terrain.query_contact(p, origin + arm);
            let size =
                hit.distance.abs() + hit.friction.abs() + hit.velocity.length_squared() + hit.normal.length_squared();
            *unanswered = *unanswered | (somewhere & near & !size.lt(absurd));
            let radius = R::splat(point.radius);
            // A lane whose ball is far off stays out, as it would alone, whatever an inexact distance says.
            let gap = R::select(near, hit.distance - radius, far);
            probes[p] = Probe { hit, gap, arm: arm - hit.normal * radius };
        }
    }

    for (index, blade) in model.blades.iter().enumerate() {
        let (toe, heel) = (&probes[blade.toe], &probes[blade.heel]);
        let on_ice = toe.gap.lt(margin) & heel.gap.lt(margin);
        if !R::any(on_ice) {
            continue;
        }
        let on_ice = on_ice & toe.hit.carves & heel.hit.carves;
        if R::any(on_ice) {
            let inside = kinematics[blade.link].rotation.mul_vec(Vec3::splat(blade.inside));
            blades[index] =
                Some(BladeContact::new(on_ice, toe.arm - heel.arm, inside, toe.hit.normal, &blade.lean_law));
        }
    }

    let none = R::zero().lt(R::zero());
    let mut join = |link: usize, new: NewContact<R>| {
        let NewContact { source, is_grip, active, blade, pulls, arm } = new;
        let at = *count;
        match groups.last_mut() {
            Some(group) if group.link == link => group.end = at + 1,
            _ => groups.push(ContactGroup { start: at, end: at + 1, ..ContactGroup::on_link(link) }),
        }
        // The rows follow later.
        let c = &mut candidates[at];
        (c.source, c.is_grip, c.blade, c.pulls, c.active) = (source, is_grip, blade, pulls, active);
        (c.arm, c.place, c.partner) = (arm, kinematics[link].origin + arm, at);
        *count += 1;
    };
    // Links in ascending order, each with its points first and then its grips.
    let mut next_grip = 0;
    let mut held = |upto: usize, join: &mut dyn FnMut(usize, NewContact<R>)| {
        // Grips are few and their order in the file is free: look at all that belong to links before `upto`.
        while next_grip < upto {
            for (g, grip) in model.grips.iter().enumerate() {
                let GripProbe { active, pulls, arm, .. } = grip_probes[g];
                if grip.link == next_grip && R::any(active) {
                    join(grip.link, NewContact { source: g, is_grip: true, active, blade: none, pulls, arm });
                }
            }
            next_grip += 1;
        }
    };
    for &p in order.iter() {
        let point = &model.contact_points[p];
        if any_grip {
            held(point.link, &mut join);
        }
        let active = probes[p].gap.lt(margin);
        if !R::any(active) {
            continue;
        }
        let blade = match point.kind {
            ContactKind::Point => none,
            ContactKind::BladeToe(b) | ContactKind::BladeHeel(b) => blades[b].map_or(none, |b| b.on_ice),
        };
        let arm = probes[p].arm;
        join(point.link, NewContact { source: p, is_grip: false, active, blade, pulls: none, arm });
    }
    if any_grip {
        held(model.links.len(), &mut join);
    }
    let candidates = &mut candidates[..*count];
    // The two ends of a blade know each other.
    for a in 0..candidates.len() {
        if candidates[a].is_grip {
            continue;
        }
        if let ContactKind::BladeToe(blade) = model.contact_points[candidates[a].source].kind {
            let heel = model.blades[blade].heel;
            if let Some(b) = candidates.iter().position(|c| !c.is_grip && c.source == heel) {
                candidates[a].partner = b;
                candidates[b].partner = a;
            }
        }
    }
    if terrain.is_compliant() && !candidates.is_empty() {
        *compliant = true;
        for c in candidates.iter_mut().filter(|c| !c.is_grip) {
            c.directions[0] = probes[c.source].hit.normal;
        }
        terrain.surface_inverse_mass(root_position, candidates, &mut inverse_masses[..candidates.len()]);
    }
    !candidates.is_empty()
}
