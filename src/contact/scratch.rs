//! The work space of the contact stages.

use super::candidate::ContactCluster;
use super::grips::GripProbe;
use crate::contact::{BladeContact, ContactCandidate, ContactGroup, ContactMobility, SurfaceHit};
use crate::math::{Real, Sym3, Vec3};
use crate::model::CharacterModel;

/// Surface, arm and world-axes place of a contact point before it is known to be near anything.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Probe<R: Real> {
    pub hit: SurfaceHit<R>,
    pub gap: R,
    pub arm: Vec3<R>,
}

/// Work space of the contact stages; allocated once.
#[derive(Clone, Debug)]
pub struct ContactScratch<R: Real> {
    /// Contact points in the order of their links.
    pub(crate) order: Vec<usize>,
    /// Answers of the terrain, by contact point.
    pub(crate) probes: Vec<Probe<R>>,
    /// Grips and their anchors, by grip.
    pub(crate) grip_probes: Vec<GripProbe<R>>,
    /// Links with a point, and the radius about the link origin that holds them all, m.
    pub(crate) reach: Vec<(usize, f64, core::ops::Range<usize>)>,
    /// Blades, by index; `None` while no lane has it on the ice.
    pub blades: Vec<Option<BladeContact<R>>>,
    /// Room for every point and grip; the first `count` entries take part. They are large, so they are written over.
    pub(crate) storage: Vec<ContactCandidate<R>>,
    pub(super) count: usize,
    /// Lanes that got an answer from the terrain which is no number, since this was last cleared.
    pub(crate) unanswered: R::Mask,
    /// True where a surface may give way in this step; the two lists below are of use only then.
    pub(crate) compliant: bool,
    /// By candidate: velocity of the surface per impulse on it, world axes, 1/kg.
    pub(crate) inverse_masses: Vec<Sym3<R>>,
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
            hit: SurfaceHit { distance: zero, normal: Vec3::zero(), ..SurfaceHit::nothing() },
            gap: R::splat(1e9),
            arm: Vec3::zero(),
        };
        let capacity = model.contact_points.len() + model.grips.len();
        Self {
            order,
            probes: vec![far; model.contact_points.len()],
            grip_probes: vec![GripProbe::open(); model.grips.len()],
            reach,
            blades: vec![None; model.blades.len()],
            storage: vec![ContactCandidate::blank(); capacity],
            count: 0,
            unanswered: zero.lt(zero),
            compliant: false,
            inverse_masses: vec![Sym3::zero(); capacity],
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
        self.compliant = false;
        self.groups.clear();
        self.blades.iter_mut().for_each(|b| *b = None);
    }
}
