//! Which contact points are near a surface, and the work space of the contact stages.

use crate::contact::solver::ContactCluster;
use crate::contact::{BladeContact, ContactMobility, SurfaceHit, Terrain};
use crate::dynamics::LinkKinematics;
use crate::math::{Force, Motion, Real, Sym3, Vec3};
use crate::model::{CharacterModel, ContactKind};

/// A contact point (or an open end of a grip) that takes part in this step.
#[derive(Clone, Copy, Debug)]
pub struct ContactCandidate<R: Real> {
    /// Index of the contact point in the model; for a grip, of the grip.
    pub source: usize,
    /// True for a grip.
    pub is_grip: bool,
    /// True where the knife edge holds.
    pub blade: R::Mask,
    /// True where the point is within the margin.
    pub active: R::Mask,
    /// The place of contact relative to the link's origin, world axes, m.
    pub arm: Vec3<R>,
    /// The place of contact relative to the root's origin at the start of the step, world axes, m.
    pub place: Vec3<R>,
    /// Row directions: normal and two tangents (along and across, for a blade), world axes.
    pub directions: [Vec3<R>; 3],
    /// Moment arms of the rows: `arm x direction`.
    pub moments: [Vec3<R>; 3],
    /// Velocity along each row that the solver aims at, m/s.
    pub aims: [R; 3],
    /// Motion of the link from a unit impulse along each row.
    pub responses: [Motion<R>; 3],
    /// Inverse effective masses `J_r . response_s`: 00, 11, 22, 01, 02, 12.
    pub coupling: [R; 6],
    /// `1 / coupling[r][r]`, zero in inactive lanes.
    pub effective_mass: [R; 3],
    /// Impulses along the rows, N s.
    pub impulses: [R; 3],
    /// Coulomb coefficient.
    pub friction: R,
    /// Index of the other end of the same blade among the candidates.
    pub partner: usize,
    /// Bite: largest lateral impulse over the blade's normal impulse.
    pub bite: R,
}

impl<R: Real> ContactCandidate<R> {
    /// No contact.
    fn blank() -> Self {
        let none = R::zero().lt(R::zero());
        Self {
            source: 0,
            is_grip: false,
            blade: none,
            active: none,
            arm: Vec3::zero(),
            place: Vec3::zero(),
            directions: [Vec3::zero(); 3],
            moments: [Vec3::zero(); 3],
            aims: [R::zero(); 3],
            responses: [Motion::zero(); 3],
            coupling: [R::zero(); 6],
            effective_mass: [R::zero(); 3],
            impulses: [R::zero(); 3],
            friction: R::zero(),
            partner: 0,
            bite: R::zero(),
        }
    }
    /// The surface takes the opposite of impulses along the rows and gives way: what is aimed at goes with it.
    #[inline(always)]
    pub(crate) fn push_surface(&mut self, give: &[R; 6], d: &[R; 3]) {
        let [nn, tt, ss, nt, ns, ts] = *give;
        self.aims[0] -= nn * d[0] + nt * d[1] + ns * d[2];
        self.aims[1] -= nt * d[0] + tt * d[1] + ts * d[2];
        self.aims[2] -= ns * d[0] + ts * d[1] + ss * d[2];
    }
    /// The impulse on the link, world axes, N s.
    #[inline(always)]
    pub fn impulse(&self) -> Vec3<R> {
        let [n, t, s] = self.directions;
        s.mul_add(self.impulses[2], t.mul_add(self.impulses[1], n * self.impulses[0]))
    }
}

/// The candidates of one link.
#[derive(Clone, Copy, Debug)]
pub struct ContactGroup<R> {
    /// Link index.
    pub link: usize,
    /// First candidate.
    pub start: usize,
    /// One past the last candidate.
    pub end: usize,
    /// Velocity of the link origin as the solver goes on.
    pub velocity: Motion<R>,
    /// Impulse wrench on the link about its origin, in all.
    pub wrench: Force<R>,
}

impl<R: Real> ContactGroup<R> {
    /// A group without candidates yet.
    pub fn on_link(link: usize) -> Self {
        Self { link, start: 0, end: 0, velocity: Motion::zero(), wrench: Force::zero() }
    }
}

/// Surface, arm and world-axes place of a contact point before it is known to be near anything.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Probe<R: Real> {
    pub hit: SurfaceHit<R>,
    pub gap: R,
    pub arm: Vec3<R>,
}

/// What is known of a candidate when it joins.
struct NewContact<R: Real> {
    source: usize,
    is_grip: bool,
    active: R::Mask,
    blade: R::Mask,
    arm: Vec3<R>,
}

/// Work space of the contact stages; allocated once.
#[derive(Clone, Debug)]
pub struct ContactScratch<R: Real> {
    /// Contact points in the order of their links.
    pub(crate) order: Vec<usize>,
    /// Answers of the terrain, by contact point.
    pub(crate) probes: Vec<Probe<R>>,
    /// Links with a point, and the radius about the link origin that holds them all, m.
    pub(crate) reach: Vec<(usize, f64, core::ops::Range<usize>)>,
    /// Blades, by index; `None` while no lane has it on the ice.
    pub blades: Vec<Option<BladeContact<R>>>,
    /// Room for every point and grip; the first `count` entries take part. They are large, so they are written over.
    pub(crate) storage: Vec<ContactCandidate<R>>,
    count: usize,
    /// Lanes that got an answer from the terrain which is no number, since this was last cleared.
    pub(crate) unanswered: R::Mask,
    /// True where a surface may give way in this step; the two lists below are of use only then.
    pub(crate) yields: bool,
    /// By candidate: velocity of the surface per impulse on it, world axes, 1/kg.
    pub(crate) gives: Vec<Sym3<R>>,
    /// The same along the rows of the candidate: 00, 11, 22, 01, 02, 12.
    pub(crate) give_rows: Vec<[R; 6]>,
    /// Links that take part.
    pub groups: Vec<ContactGroup<R>>,
    /// Clusters of those links.
    pub(crate) clusters: Vec<ContactCluster<R>>,
    /// Inverse inertias between them.
    pub mobility: ContactMobility<R>,
}

impl<R: Real> ContactScratch<R> {
    /// Work space for a model.
    pub fn new(model: &CharacterModel) -> Self {
        let mut order: Vec<usize> = (0..model.contact_points.len()).collect();
        order.sort_by_key(|&p| model.contact_points[p].link);
        let mut reach: Vec<(usize, f64, core::ops::Range<usize>)> = Vec::new();
        for (at, &p) in order.iter().enumerate() {
            let point = &model.contact_points[p];
            let radius = point.position.length() + point.radius;
            match reach.last_mut() {
                Some((link, largest, range)) if *link == point.link => {
                    *largest = largest.max(radius);
                    range.end = at + 1;
                }
                _ => reach.push((point.link, radius, at..at + 1)),
            }
        }
        let zero = R::zero();
        let far = Probe {
            hit: SurfaceHit {
                distance: zero,
                normal: Vec3::zero(),
                velocity: Vec3::zero(),
                friction: zero,
                ice: zero.lt(zero),
            },
            gap: R::splat(1e9),
            arm: Vec3::zero(),
        };
        let capacity = model.contact_points.len() + model.grips.len();
        Self {
            order,
            probes: vec![far; model.contact_points.len()],
            reach,
            blades: vec![None; model.blades.len()],
            storage: vec![ContactCandidate::blank(); capacity],
            count: 0,
            unanswered: zero.lt(zero),
            yields: false,
            gives: vec![Sym3::zero(); capacity],
            give_rows: vec![[R::zero(); 6]; capacity],
            groups: Vec::with_capacity(capacity),
            clusters: Vec::with_capacity(capacity),
            mobility: ContactMobility::new(model),
        }
    }

    /// Points that take part, by link.
    pub fn candidates(&self) -> &[ContactCandidate<R>] {
        &self.storage[..self.count]
    }

    /// Removes all candidates.
    pub fn clear(&mut self) {
        self.count = 0;
        self.yields = false;
        self.groups.clear();
        self.blades.iter_mut().for_each(|b| *b = None);
    }
}

/// Asks the terrain about every link that is near it, and lists the points within `margin` (m) of a surface. Grips that
/// hold on to something are listed too. Returns true if anything takes part.
#[inline]
pub fn detect_contacts<R: Real>(
    model: &CharacterModel,
    kinematics: &[LinkKinematics<R>],
    root_position: Vec3<R>,
    terrain: &impl Terrain<R>,
    margin: f64,
    grips: &[Option<glam::DVec3>],
    scratch: &mut ContactScratch<R>,
) -> bool {
    scratch.clear();
    let margin = R::splat(margin);
    let ContactScratch {
        order,
        probes,
        reach,
        blades,
        storage: candidates,
        count,
        unanswered,
        yields,
        gives,
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
        let on_ice = on_ice & toe.hit.ice & heel.hit.ice;
        if R::any(on_ice) {
            let inside = kinematics[blade.link].rotation.mul_vec(Vec3::splat(blade.inside));
            blades[index] =
                Some(BladeContact::new(on_ice, toe.arm - heel.arm, inside, toe.hit.normal, &blade.lean_law));
        }
    }

    let none = R::zero().lt(R::zero());
    let mut join = |link: usize, new: NewContact<R>| {
        let NewContact { source, is_grip, active, blade, arm } = new;
        let at = *count;
        match groups.last_mut() {
            Some(group) if group.link == link => group.end = at + 1,
            _ => groups.push(ContactGroup { start: at, end: at + 1, ..ContactGroup::on_link(link) }),
        }
        // The rows follow later.
        let c = &mut candidates[at];
        (c.source, c.is_grip, c.blade, c.active) = (source, is_grip, blade, active);
        (c.arm, c.place, c.partner) = (arm, kinematics[link].origin + arm, at);
        *count += 1;
    };
    // Links in ascending order, each with its points first and then its grips.
    let mut next_grip = 0;
    let mut held = |upto: usize, join: &mut dyn FnMut(usize, NewContact<R>)| {
        // Grips are few and their order in the file is free: look at all that belong to links before `upto`.
        while next_grip < upto {
            for (g, grip) in model.grips.iter().enumerate() {
                if grip.link == next_grip && grips.get(g).is_some_and(Option::is_some) {
                    let arm = kinematics[grip.link].rotation.mul_vec(Vec3::splat(grip.position));
                    join(grip.link, NewContact { source: g, is_grip: true, active: !none, blade: none, arm });
                }
            }
            next_grip += 1;
        }
    };
    let any_grip = grips.iter().any(Option::is_some);
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
        join(point.link, NewContact { source: p, is_grip: false, active, blade, arm: probes[p].arm });
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
    if terrain.yields() && !candidates.is_empty() {
        *yields = true;
        for c in candidates.iter_mut().filter(|c| !c.is_grip) {
            c.directions[0] = probes[c.source].hit.normal;
        }
        terrain.give(root_position, candidates, &mut gives[..candidates.len()]);
    }
    !candidates.is_empty()
}
