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
//! Each block depends on the tree alone, never on which other links are in contact, so a lane's bits do not depend on
//! what its neighbours touch.

use crate::contact::ContactGroup;
use crate::dynamics::{ArticulatedLink, LinkConstants, LinkKinematics};
use crate::math::{Mat3, Mobility, Motion, Real, Vec3};
use crate::model::CharacterModel;

const NONE: u32 = u32::MAX;

/// Blocks of the inverse inertia, and the links on the way to them.
#[derive(Clone, Debug)]
pub struct ContactMobility<R> {
    /// Links in contact and all their ancestors, ascending (so parents come first).
    support: Vec<usize>,
    /// Place of a link in `support`, or [`NONE`].
    slot: Vec<u32>,
    touching: Vec<bool>,
    /// Links with two or more children in the support.
    branching: Vec<bool>,
    /// Block of (slot, slot) with the larger slot first, or [`NONE`].
    index: Vec<u32>,
    blocks: Vec<Mobility<R>>,
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

impl<R: Real> ContactMobility<R> {
    /// Work space for a model.
    pub fn new(model: &CharacterModel) -> Self {
        let n = model.links.len();
        Self {
            support: Vec::with_capacity(n),
            slot: vec![NONE; n],
            touching: vec![false; n],
            branching: vec![false; n],
            index: vec![NONE; n * n],
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
        self.find_support(constants, groups);
        self.blocks.clear();
        let n = self.support.len();
        self.index[..n * n].fill(NONE);
        for a in 0..n {
            let i = self.support[a];
            if i == 0 {
                self.blocks.push(*root);
                self.index[0] = 0;
                continue;
            }
            let p = self.slot[constants[i].parent] as usize;
            let (link, d) = (&articulated[i], kinematics[i].from_parent);
            for b in 0..a {
                let needed = self.touching[b] || b == p || self.branching[b];
                if !needed {
                    continue;
                }
                // The parent's row may not hold this pair: then no descendant needs it either.
                let source = if p >= b { self.index[p * n + b] } else { self.index[b * n + p] };
                if source == NONE {
                    continue;
                }
                let source = &self.blocks[source as usize];
                let block = if p >= b { pass_down(link, d, source) } else { pass_down(link, d, &source.transpose()) };
                self.index[a * n + b] = self.blocks.len() as u32;
                self.blocks.push(block);
            }
            let with_parent = self.blocks[self.index[a * n + p] as usize].transpose();
            let mut own = pass_down(link, d, &with_parent);
            own.aa = own.aa + link.joint_mobility.to_mat3();
            self.index[a * n + a] = self.blocks.len() as u32;
            self.blocks.push(own);
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
        for i in 0..constants.len() {
            if self.slot[i] == 0 {
                self.slot[i] = self.support.len() as u32;
                self.support.push(i);
            }
        }
        let n = self.support.len();
        self.touching[..n].fill(false);
        self.branching[..n].fill(false);
        for group in groups {
            self.touching[self.slot[group.link] as usize] = true;
        }
        let mut children = [0u8; 256];
        for &i in &self.support[1..] {
            children[self.slot[constants[i].parent] as usize & 255] += 1;
        }
        for (a, branching) in self.branching[..n].iter_mut().enumerate() {
            *branching = children[a & 255] > 1;
        }
    }

    /// The block of a link with itself.
    #[inline(always)]
    pub fn own(&self, link: usize) -> &Mobility<R> {
        let a = self.slot[link] as usize;
        &self.blocks[self.index[a * self.support.len() + a] as usize]
    }

    /// The motion of `link` from the impulse wrench `w` on `other`.
    #[inline(always)]
    pub fn response(&self, link: usize, other: usize, w: &crate::math::Force<R>) -> Motion<R> {
        let n = self.support.len();
        let (a, b) = (self.slot[link] as usize, self.slot[other] as usize);
        if a >= b {
            self.blocks[self.index[a * n + b] as usize].mul_force(w)
        } else {
            self.blocks[self.index[b * n + a] as usize].tr_mul_force(w)
        }
    }
}
