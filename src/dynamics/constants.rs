//! The model's numbers, spread over lanes once.

use crate::asset::turn::rotation_by;
use crate::math::{Mat3, Quat, Real, Sym3, Vec3};
use crate::model::{CharacterModel, JointKind};

/// What the dynamics reads of a link.
#[derive(Clone, Debug)]
pub struct LinkConstants<R> {
    /// Index of the parent (0 for the root itself).
    pub parent: usize,
    /// The link at this place of the breadth-first order. The recursions walk in that order: neighbours in it seldom wait
    /// for each other, so the processor works on several limbs at once.
    pub breadth_first: usize,
    /// No other link hangs on this one.
    pub is_leaf: bool,
    /// Of the children of one parent this comes last: the first to arrive when the tree is walked from its leaves.
    pub arrives_first: bool,
    /// The hinge axis, link axes; `None` for a ball joint and the root.
    pub hinge: Option<Vec3<R>>,
    /// Joint position in the parent frame, m.
    pub offset: Vec3<R>,
    /// Mass, kg.
    pub mass: R,
    /// Centre of mass, link frame, m.
    pub com: Vec3<R>,
    /// Inertia about the centre of mass, link axes, kg m^2.
    pub inertia: RotationalInertia<R>,
    /// Largest servo torque, N m.
    pub max_torque: R,
    /// Inertia on the joint's own velocity, kg m^2.
    pub armature: R,
    /// Passive spring of the joint.
    pub spring: Option<PassiveSpring<R>>,
    /// Bounds of the rotation vector, rad.
    pub limits: Option<(Vec3<R>, Vec3<R>)>,
}

/// A passive spring and damper at a joint.
#[derive(Clone, Debug)]
pub struct PassiveSpring<R> {
    /// N m/rad.
    pub stiffness: R,
    /// N m s/rad.
    pub damping: R,
    /// Rotation at which it is slack, child axes to parent axes.
    pub rest: Quat<R>,
}

/// A rotational inertia in link axes; most links are symmetric enough for the cheaper form.
#[derive(Clone, Debug)]
pub enum RotationalInertia<R> {
    /// Principal axes along the link axes.
    Diagonal(Vec3<R>),
    /// Any other.
    Full(Sym3<R>),
}

impl<R: Real> RotationalInertia<R> {
    /// The inertia in world axes, for a link with this link-to-world rotation.
    #[inline(always)]
    pub fn in_world(&self, rotation: &Mat3<R>) -> Sym3<R> {
        match self {
            Self::Diagonal(d) => Sym3::rotated_diagonal(*d, rotation),
            Self::Full(m) => m.rotated_by(rotation),
        }
    }
}

impl<R: Real> LinkConstants<R> {
    /// The constants of every link of a model.
    pub fn of(model: &CharacterModel) -> Vec<Self> {
        let mut depth: Vec<usize> = Vec::with_capacity(model.links.len());
        for link in &model.links {
            depth.push(link.parent.map_or(0, |p| depth[p] + 1));
        }
        let mut order: Vec<usize> = (0..depth.len()).collect();
        order.sort_by_key(|&i| depth[i]);
        model
            .links
            .iter()
            .enumerate()
            .map(|(index, link)| {
                let last_child = |parent: usize| model.links.iter().rposition(|l| l.parent == Some(parent));
                let i = link.inertia;
                let off_diagonal = i.y_axis.x.abs() + i.z_axis.x.abs() + i.z_axis.y.abs();
                let trace = i.x_axis.x + i.y_axis.y + i.z_axis.z;
                Self {
                    parent: link.parent.unwrap_or(0),
                    breadth_first: order[index],
                    is_leaf: last_child(index).is_none(),
                    arrives_first: link.parent.is_some_and(|p| last_child(p) == Some(index)),
                    hinge: match link.joint {
                        JointKind::Hinge { axis } => Some(Vec3::splat(axis)),
                        JointKind::Ball | JointKind::Free => None,
                    },
                    offset: Vec3::splat(link.offset),
                    mass: R::splat(link.mass),
                    com: Vec3::splat(link.com),
                    inertia: if off_diagonal <= 1e-15 * trace {
                        RotationalInertia::Diagonal(Vec3::splat(glam::DVec3::new(i.x_axis.x, i.y_axis.y, i.z_axis.z)))
                    } else {
                        RotationalInertia::Full(Sym3::splat(i))
                    },
                    // Infinity would turn into NaN in a product with zero.
                    max_torque: R::splat(link.max_torque.min(1e9)),
                    armature: R::splat(link.armature),
                    spring: link.spring.map(|s| PassiveSpring {
                        stiffness: R::splat(s.stiffness),
                        damping: R::splat(s.damping),
                        rest: Quat::splat(rotation_by(s.rest)),
                    }),
                    limits: link.limits.map(|l| (Vec3::splat(l.low), Vec3::splat(l.high))),
                }
            })
            .collect()
    }
}
