//! Inverse inertias at and between the links in contact.
//!
//! The extended force propagator (Featherstone 2010, "Exploiting Sparsity in Operational-Space Dynamics"; Wensing,
//! Featherstone, Orin 2012), down the chains from the root's 6 x 6. With X_i the map of [`ArticulatedLink::pass_up`] and
//! G_i the mobility of joint i:
//!
//! ```text
//! Omega_ij = X_i^T Omega_p(i)j          for j outside the subtree of i
//! Omega_ii = X_i^T Omega_p(i)p(i) X_i + G_i
//! ```
//!
//! Links that lie close together and all carry contact points, such as the segments of a foot, form a **cluster** under
//! their topmost link, the hub. Blocks are kept between the links of one cluster and between hubs. From a link of one
//! cluster to a link of another the way leads over both hubs, `Omega_ab = Y_a^T Omega_hk Y_b`, where `Y_a^T`, the product
//! of the `X^T` between hub and link, is the motion that the hub's motion brings to the link.
//!
//! Blocks and clusters depend on the tree alone, never on which other links are in contact, so a lane's bits do not depend
//! on what its neighbours touch.

use crate::contact::ContactGroup;
use crate::dynamics::{ArticulatedLink, LinkConstants, LinkKinematics};
use crate::math::{Force, Mat3, Mobility, Motion, Real, Sym3, Vec3};
use crate::model::CharacterModel;

const NONE: u32 = u32::MAX;

/// Links of the largest cluster.
const CLUSTER_LINKS: usize = 8;

/// The mobility of one link: the symmetric 6 x 6 block on the diagonal, `[aa al; al^T ll]`.
#[derive(Clone, Copy, Debug, Default)]
pub struct OperationalInverseInertia<R> {
    /// Angular acceleration from moment, 1/(kg m^2).
    pub aa: Sym3<R>,
    /// Angular acceleration from force, 1/(kg m); transposed, linear from moment.
    pub al: Mat3<R>,
    /// Linear acceleration from force, 1/kg.
    pub ll: Sym3<R>,
}

impl<R: Real> OperationalInverseInertia<R> {
    /// The motion that the wrench `f` brings.
    #[inline(always)]
    pub fn mul_force(&self, f: &Force<R>) -> Motion<R> {
        Motion {
            angular: self.al.mul_vec_add(f.force, self.aa.mul_vec(f.moment)),
            linear: self.ll.mul_vec_add(f.force, self.al.tr_mul_vec(f.moment)),
        }
    }
    /// As a general block.
    #[inline(always)]
    fn to_block(self) -> Mobility<R> {
        Mobility { aa: self.aa.to_mat3(), al: self.al, la: self.al.transpose(), ll: self.ll.to_mat3() }
    }
    /// The same at the point `d` away from the present one.
    #[inline(always)]
    fn shifted(&self, d: Vec3<R>) -> Self {
        // With v' = v - d x omega:  al' = al + aa [d],  ll' = ll + al^T [d] - [d] al'.
        let al = self.al.add_mul_skew(&self.aa.to_mat3(), d);
        let ll = self.ll.add_skew_products(-d, &self.al.transpose(), &al.transpose());
        Self { aa: self.aa, al, ll }
    }
    /// `X^T self X + G`: the mobility of a child from that of its parent. Half of it is known by symmetry.
    #[inline(always)]
    fn of_child(&self, link: &ArticulatedLink<R>, d: Vec3<R>) -> Self {
        // At the joint X is [E^T 0; -K^T 1], so, with the parent's blocks there:
        // ll' = ll,  al' = E al - K ll,  aa' = (E aa - K al^T) E^T - al' K^T + Phi.
        let at = self.shifted(d);
        let (e, k) = (link.transmission_matrix(), &link.k);
        let al = e.mul_mat(&at.al).sub_product(k, &at.ll.to_mat3());
        let c = e.mul_mat(&at.aa.to_mat3()).sub_product(k, &at.al.transpose());
        let aa = link.joint_mobility.add_product(&c, &e.transpose()).sub_product(&al, &k.transpose());
        Self { aa, al, ll: at.ll }
    }
}

/// Blocks of the inverse inertia, and the links on the way to them.
#[derive(Clone, Debug)]
pub struct ContactMobility<R> {
    /// The hub of every link; links without contact points are their own.
    hub: Vec<usize>,
    /// Links in contact and all their ancestors, ascending (so parents come first).
    support: Vec<usize>,
    /// Place of a link in `support`, or [`NONE`].
    slot: Vec<u32>,
    /// The links in contact that the support and the plan below were made for.
    planned: Vec<usize>,
    /// What follows has one entry for each slot. Links whose blocks with others are asked for: links in contact, by their
    /// cluster; hubs of those, by other hubs.
    touching: Vec<bool>,
    reached: Vec<bool>,
    /// The last child in the support, a slot, or 0.
    last_child: Vec<usize>,
    own: Vec<OperationalInverseInertia<R>>,
    /// Y^T: the motion of the link that a motion of its hub brings.
    carry: Vec<Mobility<R>>,
    /// Block of (slot, smaller slot), or [`NONE`].
    index: Vec<u32>,
    /// How the blocks are made, in an order that has every source before its use.
    plan: Vec<(usize, BlockSource)>,
    blocks: Vec<Mobility<R>>,
}

/// What the block of a link and another is made from: it is passed down to the link (a slot) from its parent.
#[derive(Clone, Copy, Debug)]
enum BlockSource {
    /// The mobility of the parent, a slot.
    Own(usize),
    /// The block of the parent and the other.
    Block(u32),
    /// The block of the other and the parent.
    Transposed(u32),
}

/// `X^T B`: the motion of the child from the motion of the parent, column by column.
#[inline(always)]
fn pass_down<R: Real>(link: &ArticulatedLink<R>, d: Vec3<R>, b: &Mobility<R>) -> Mobility<R> {
    let column = |angular: Vec3<R>, linear: Vec3<R>| link.pass_down(d, &Motion { angular, linear });
    let [m0, m1, m2] = [column(b.aa.x, b.la.x), column(b.aa.y, b.la.y), column(b.aa.z, b.la.z)];
    let [f0, f1, f2] = [column(b.al.x, b.ll.x), column(b.al.y, b.ll.y), column(b.al.z, b.ll.z)];
    Mobility {
        aa: Mat3::from_columns(m0.angular, m1.angular, m2.angular),
        la: Mat3::from_columns(m0.linear, m1.linear, m2.linear),
        al: Mat3::from_columns(f0.angular, f1.angular, f2.angular),
        ll: Mat3::from_columns(f0.linear, f1.linear, f2.linear),
    }
}

/// The hub of every link: the root of the largest subtree around it of at most [`CLUSTER_LINKS`] links that all carry
/// contact points or grips; the link itself if there is none.
fn hubs(model: &CharacterModel) -> Vec<usize> {
    let n = model.links.len();
    let mut carries = vec![false; n];
    let places = model.contact_points.iter().map(|p| p.link).chain(model.grips.iter().map(|g| g.link));
    places.for_each(|link| carries[link] = true);
    // Links below each one, itself included, and whether all of them carry something.
    let (mut size, mut full) = (vec![1; n], carries);
    for i in (1..n).rev() {
        if let Some(p) = model.links[i].parent {
            size[p] += size[i];
            full[p] &= full[i];
        }
    }
    let mut hub: Vec<usize> = (0..n).collect();
    for i in 1..n {
        if let Some(p) = model.links[i].parent
            && full[hub[p]]
            && size[hub[p]] <= CLUSTER_LINKS
        {
            hub[i] = hub[p];
        }
    }
    hub
}

impl<R: Real> ContactMobility<R> {
    /// Work space for a model.
    pub fn new(model: &CharacterModel) -> Self {
        let n = model.links.len();
        Self {
            hub: hubs(model),
            support: Vec::with_capacity(n),
            planned: Vec::with_capacity(n),
            slot: vec![NONE; n],
            touching: vec![false; n],
            reached: vec![false; n],
            last_child: vec![0; n],
            own: vec![OperationalInverseInertia::default(); n],
            carry: vec![Mobility::default(); n],
            index: vec![NONE; n * n],
            plan: Vec::with_capacity(n * (n + 1) / 2),
            blocks: Vec::with_capacity(n * (n + 1) / 2),
        }
    }

    /// Links in contact and their ancestors, parents first.
    pub fn support(&self) -> &[usize] {
        &self.support
    }

    /// Computes every block that the solver needs for the links of `groups`.
    #[inline]
    pub fn update(
        &mut self,
        constants: &[LinkConstants<R>],
        kinematics: &[LinkKinematics<R>],
        articulated: &[ArticulatedLink<R>],
        root: &Mobility<R>,
        groups: &[ContactGroup<R>],
    ) {
        // The same links are in contact for many steps in a row.
        if !self.planned.iter().copied().eq(groups.iter().map(|g| g.link)) {
            self.planned.clear();
            self.planned.extend(groups.iter().map(|g| g.link));
            self.find_support(constants, groups);
            self.plan_blocks(constants);
        }
        self.own[0] =
            OperationalInverseInertia { aa: Sym3::from_upper(&root.aa), al: root.al, ll: Sym3::from_upper(&root.ll) };
        for a in 1..self.support.len() {
            let i = self.support[a];
            let parent = constants[i].parent;
            let p = self.slot[parent] as usize;
            let (link, d) = (&articulated[i], kinematics[i].from_parent);
            self.own[a] = self.own[p].of_child(link, d);
            let hub = self.hub[i];
            if hub != i {
                self.carry[a] =
                    if parent == hub { link.pass_down_matrix(d) } else { pass_down(link, d, &self.carry[p]) };
            }
        }
        self.blocks.clear();
        for &(i, source) in &self.plan {
            let (link, d) = (&articulated[i], kinematics[i].from_parent);
            let block = match source {
                BlockSource::Own(p) => pass_down(link, d, &self.own[p].to_block()),
                BlockSource::Block(at) => pass_down(link, d, &self.blocks[at as usize]),
                BlockSource::Transposed(at) => pass_down(link, d, &self.blocks[at as usize].transpose()),
            };
            self.blocks.push(block);
        }
    }

    /// Which blocks the solver needs for the links in contact, and how they come about.
    fn plan_blocks(&mut self, constants: &[LinkConstants<R>]) {
        self.plan.clear();
        let n = self.support.len();
        for a in 1..n {
            let i = self.support[a];
            let p = self.slot[constants[i].parent] as usize;
            let hub = self.hub[i];
            let inside = hub != i;
            for b in 0..a {
                // Inside a cluster the links in contact ask for each other, outside the hubs do. And a link on the way
                // to b, left of another branch that leads to some a, keeps its block with the fork.
                let j = self.support[b];
                let asked =
                    if inside { self.hub[j] == hub && self.touching[b] } else { self.hub[j] == j && self.reached[b] };
                let left_of_branch = a < self.last_child[b] && (!inside || self.hub[j] == hub);
                self.index[a * n + b] = NONE;
                if !(asked || left_of_branch) {
                    continue;
                }
                let source = if p == b {
                    BlockSource::Own(b)
                } else {
                    let (larger, smaller) = if p > b { (p, b) } else { (b, p) };
                    match self.index[larger * n + smaller] {
                        // A fork that is not above this link.
                        NONE => continue,
                        at if p > b => BlockSource::Block(at),
                        at => BlockSource::Transposed(at),
                    }
                };
                self.index[a * n + b] = self.plan.len() as u32;
                self.plan.push((i, source));
            }
        }
    }

    fn find_support(&mut self, constants: &[LinkConstants<R>], groups: &[ContactGroup<R>]) {
        for &i in &self.support {
            self.slot[i] = NONE;
        }
        self.support.clear();
        // Mark: 0 stands for "in the support" until the slots are known.
        for group in groups {
            let mut at = group.link;
            while self.slot[at] == NONE {
                self.slot[at] = 0;
                if at == 0 {
                    break;
                }
                at = constants[at].parent;
            }
        }
        for (i, slot) in self.slot.iter_mut().enumerate() {
            if *slot == 0 {
                let a = self.support.len();
                *slot = a as u32;
                self.support.push(i);
                self.touching[a] = false;
                self.reached[a] = false;
                self.last_child[a] = 0;
            }
        }
        for (a, &i) in self.support.iter().enumerate().skip(1) {
            self.last_child[self.slot[constants[i].parent] as usize] = a;
        }
        for group in groups {
            self.touching[self.slot[group.link] as usize] = true;
            self.reached[self.slot[self.hub[group.link]] as usize] = true;
        }
    }

    /// The topmost link of the cluster of `link`.
    #[inline(always)]
    pub fn hub(&self, link: usize) -> usize {
        self.hub[link]
    }

    /// The mobility of a link in contact.
    #[inline(always)]
    pub fn own(&self, link: usize) -> &OperationalInverseInertia<R> {
        &self.own[self.slot[link] as usize]
    }

    /// The motion of `link` from the impulse wrench `w` on `other`: different links in contact of one cluster, or
    /// different hubs.
    #[inline(always)]
    pub fn near_response(&self, link: usize, other: usize, w: &Force<R>) -> Motion<R> {
        let n = self.support.len();
        let (a, b) = (self.slot[link] as usize, self.slot[other] as usize);
        if a > b {
            self.blocks[self.index[a * n + b] as usize].mul_force(w)
        } else {
            self.blocks[self.index[b * n + a] as usize].tr_mul_force(w)
        }
    }

    /// What reaches the hub from the wrench `w` on `link`.
    #[inline(always)]
    pub fn to_hub(&self, link: usize, w: &Force<R>) -> Force<R> {
        if self.hub[link] == link {
            return *w;
        }
        let y = &self.carry[self.slot[link] as usize];
        Force {
            moment: y.la.tr_mul_vec_add(w.force, y.aa.tr_mul_vec(w.moment)),
            force: y.ll.tr_mul_vec_add(w.force, y.al.tr_mul_vec(w.moment)),
        }
    }

    /// The motion of `link` that the motion `m` of its hub brings.
    #[inline(always)]
    pub fn from_hub(&self, link: usize, m: &Motion<R>) -> Motion<R> {
        if self.hub[link] == link {
            return *m;
        }
        let y = &self.carry[self.slot[link] as usize];
        Motion {
            angular: y.al.mul_vec_add(m.linear, y.aa.mul_vec(m.angular)),
            linear: y.ll.mul_vec_add(m.linear, y.la.mul_vec(m.angular)),
        }
    }

    /// The motion of `link` from the impulse wrench `w` on `other`, both in contact.
    pub fn response(&self, link: usize, other: usize, w: &Force<R>) -> Motion<R> {
        let (to, from) = (self.hub[link], self.hub[other]);
        if link == other {
            self.own(link).mul_force(w)
        } else if to == from {
            self.near_response(link, other, w)
        } else {
            self.from_hub(link, &self.near_response(to, from, &self.to_hub(other, w)))
        }
    }
}
