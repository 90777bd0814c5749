//! What the inspector shows, read from a body.

use crate::contact::BladeEdge;
use crate::engine::{AthleteBody, BodyStatus, LinkPoses};
use crate::model::{JointKind, JointLimits};
use glam::DVec3;

/// A link.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkRow {
    /// Name.
    pub name: String,
    /// Joints between it and the root.
    pub depth: usize,
    /// Mass, kg.
    pub mass: f64,
    /// Place of its joint, world frame, m.
    pub position: DVec3,
}

/// A joint: that of the link of the same name to its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct JointRow {
    /// Name of the link.
    pub name: String,
    /// Rotation vector, rad.
    pub angle: DVec3,
    /// Rotation vector of the servo's target, rad.
    pub target: DVec3,
    /// Range of each component; `None` is free.
    pub limits: Option<JointLimits>,
    /// Components that the joint can move: all three of a ball joint, that of a hinge.
    pub axes: [bool; 3],
    /// Angular velocity, child axes, rad/s.
    pub velocity: DVec3,
    /// Servo torque of the last step, child axes, N m.
    pub torque: DVec3,
    /// Largest torque, N m; infinite where there is none.
    pub max_torque: f64,
}

/// A contact point that carried load in the last step.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactRow {
    /// Name of the point.
    pub name: String,
    /// Name of its link.
    pub link: String,
    /// Where it is, world frame, m.
    pub position: DVec3,
    /// Force on the link, world axes, N.
    pub force: DVec3,
}

/// A blade.
#[derive(Clone, Debug, PartialEq)]
pub struct BladeRow {
    /// Name.
    pub name: String,
    /// Edge in the last step.
    pub edge: BladeEdge,
    /// Lean (rad, positive towards the inside edge) and curvature of its line (1/m); `None` off the ice.
    pub lean: Option<(f64, f64)>,
    /// Forces on its toe and heel ends, N.
    pub force: [f64; 2],
}

/// One block of what a policy sees.
#[derive(Clone, Debug, PartialEq)]
pub struct InputBlock {
    /// Name in the policy's contract.
    pub name: String,
    /// What the numbers mean.
    pub meaning: String,
    /// The numbers at the last decision.
    pub values: Vec<f32>,
}

/// A policy at its last decision.
#[derive(Clone, Debug, PartialEq)]
pub struct PolicyRow {
    /// Name of the skill.
    pub skill: String,
    /// What it saw, block by block; empty before the first decision.
    pub inputs: Vec<InputBlock>,
    /// What it said, by link: offsets of the target in units of the action.
    pub outputs: Vec<(String, [f32; 3])>,
}

/// Everything that the inspector shows of one athlete.
#[derive(Clone, Debug, PartialEq)]
pub struct InspectorView {
    /// Name of the character.
    pub character: String,
    /// Simulated time since the start, s.
    pub time: f64,
    /// Whether it is stepped.
    pub status: BodyStatus,
    /// Place in the motion, 0 to 1; `None` where none is followed.
    pub phase: Option<f64>,
    /// Links, root first.
    pub links: Vec<LinkRow>,
    /// Joints by link, without the root.
    pub joints: Vec<JointRow>,
    /// What touches.
    pub contacts: Vec<ContactRow>,
    /// Blades.
    pub blades: Vec<BladeRow>,
    /// The policy, where one drives.
    pub policy: Option<PolicyRow>,
}

impl InspectorView {
    /// Reads a body at its last fixed tick.
    pub fn of(body: &AthleteBody, poses: &LinkPoses) -> Self {
        let (sim, model) = (body.simulator(), body.model());
        let mut depths: Vec<usize> = Vec::with_capacity(model.links.len());
        for link in &model.links {
            depths.push(link.parent.map_or(0, |p| depths[p] + 1));
        }
        let place = |link: usize| poses.current.get(link).map_or(DVec3::ZERO, |l| l.position);
        let links = model.links.iter().enumerate().map(|(i, link)| LinkRow {
            name: link.name.clone(),
            depth: depths[i],
            mass: link.mass,
            position: place(i),
        });
        let joints = model.links.iter().enumerate().skip(1).map(|(i, link)| JointRow {
            name: link.name.clone(),
            angle: sim.state.joints[i].rotation.to_rotation_vector().lane(0),
            target: sim.commands[i].rotation.to_rotation_vector().lane(0),
            limits: link.limits,
            axes: match link.joint {
                JointKind::Hinge { axis } => axis.to_array().map(|a| a.abs() > 1e-6),
                _ => [true; 3],
            },
            velocity: sim.state.joints[i].velocity.lane(0),
            torque: sim.joint_torque(i).lane(0),
            max_torque: link.max_torque,
        });
        let contacts = model.contact_points.iter().enumerate().filter_map(|(k, point)| {
            let force = sim.contact_force(k, 0);
            let link = poses.current.get(point.link)?;
            (force.length() > 1e-9).then(|| ContactRow {
                name: point.name.clone(),
                link: model.links[point.link].name.clone(),
                position: link.position + link.rotation * point.position,
                force,
            })
        });
        let blades = model.blades.iter().enumerate().map(|(k, blade)| BladeRow {
            name: blade.name.clone(),
            edge: body.blade_edge(k),
            lean: sim.blade_lean(k, 0),
            force: [blade.toe, blade.heel].map(|point| sim.contact_force(point, 0).length()),
        });
        let player = body.skill_player();
        let phase = match (player, body.control_seconds()) {
            (Some(player), _) => Some(player.tick() as f64 / player.skill().motion.last().max(1) as f64),
            (None, Some(seconds)) => Some((body.time() / seconds.max(1e-9)).clamp(0.0, 1.0)),
            (None, None) => None,
        };
        let policy = player.map(|player| {
            let contract = player.skill().policy.contract();
            let mut at = 0;
            let inputs = contract.observation.iter().map_while(|block| {
                let values = player.observation().get(at..at + block.size)?.to_vec();
                at += block.size;
                Some(InputBlock { name: block.name.clone(), meaning: block.meaning.clone(), values })
            });
            let (said, _) = player.action().as_chunks::<3>();
            PolicyRow {
                skill: player.skill().name().to_owned(),
                inputs: inputs.collect(),
                outputs: contract.action.links.iter().cloned().zip(said.iter().copied()).collect(),
            }
        });
        Self {
            character: model.name.clone(),
            time: body.time(),
            status: body.status(),
            phase,
            links: links.collect(),
            joints: joints.collect(),
            contacts: contacts.collect(),
            blades: blades.collect(),
            policy,
        }
    }
}
