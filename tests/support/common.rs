//! Scenes and states shared by the tests.
#![allow(dead_code)]

use bevy_athlete::dynamics::{LinkConstants, LinkKinematics, State, update_positions, update_velocities};
use bevy_athlete::math::{RandomStream, Real, Vec3};
use bevy_athlete::model::{Blade, CharacterModel, ContactKind, ContactPoint, Gains, JointKind, LeanLaw, Link};
use bevy_athlete::sim::{SimulationSettings, Simulator};
use glam::{DMat3, DQuat, DVec3};
use std::sync::Arc;

/// A vector with components evenly distributed in [-size, size).
pub fn random_vector(random: &mut RandomStream, size: f64) -> DVec3 {
    DVec3::new(random.range(-size, size), random.range(-size, size), random.range(-size, size))
}

/// A rotation by up to `angle` radians about a random axis.
pub fn random_rotation(random: &mut RandomStream, angle: f64) -> DQuat {
    let axis = DVec3::new(random.normal(), random.normal(), random.normal()).normalize();
    DQuat::from_axis_angle(axis, random.range(-angle, angle))
}

/// A random state: any root pose, joints up to `angle` rad from zero, speeds up to `speed` m/s and rad/s.
pub fn random_state<R: Real>(model: &CharacterModel, random: &mut RandomStream, angle: f64, speed: f64) -> State<R> {
    let mut state = State::at_rest(model);
    for lane in 0..R::LANES {
        let joints: Vec<DQuat> = model
            .links
            .iter()
            .map(|l| match l.joint {
                JointKind::Hinge { axis } => DQuat::from_axis_angle(axis, random.range(-angle, angle)),
                _ => random_rotation(random, angle),
            })
            .collect();
        let velocities: Vec<DVec3> = model
            .links
            .iter()
            .map(|l| match l.joint {
                JointKind::Hinge { axis } => axis * random.range(-speed, speed),
                _ => random_vector(random, speed),
            })
            .collect();
        let position = random_vector(random, 2.0);
        let rotation = random_rotation(random, 3.1);
        state.set_pose(lane, position, rotation, &joints);
        let (linear, angular) = (random_vector(random, speed), random_vector(random, speed));
        state.set_velocity(lane, linear, angular, &velocities);
    }
    state
}

/// Constants and kinematics of a state.
pub fn kinematics_of<R: Real>(
    model: &CharacterModel,
    state: &State<R>,
) -> (Vec<LinkConstants<R>>, Vec<LinkKinematics<R>>) {
    let constants = LinkConstants::of(model);
    let mut links = vec![LinkKinematics::default(); model.links.len()];
    update_positions(&constants, state, &mut links);
    update_velocities(&constants, state, &mut links);
    (constants, links)
}

/// A random tree of links with ball joints and some hinges.
pub fn random_tree(seed: u64, links: usize) -> CharacterModel {
    let mut random = RandomStream::new(seed, 1);
    let mut list: Vec<Link> = Vec::new();
    let mut path: Vec<usize> = Vec::new();
    for i in 0..links {
        // Depth-first: the parent is somewhere on the path to the last link.
        if i > 0 {
            let keep = 1 + random.below(path.len());
            path.truncate(keep);
        }
        let parent = path.last().copied();
        path.push(i);
        let r = DMat3::from_quat(random_rotation(&mut random, 3.0));
        let (a, b) = (random.range(0.01, 0.1), random.range(0.01, 0.1));
        let c = random.range((a - b).abs() + 1e-3, a + b);
        list.push(Link {
            name: format!("link{i}"),
            parent,
            joint: match parent {
                None => JointKind::Free,
                Some(_) if random.uniform() < 0.25 => {
                    JointKind::Hinge { axis: random_vector(&mut random, 1.0).normalize() }
                }
                Some(_) => JointKind::Ball,
            },
            offset: if i == 0 { DVec3::ZERO } else { random_vector(&mut random, 0.4) },
            mass: random.range(0.3, 8.0),
            com: random_vector(&mut random, 0.2),
            inertia: r * DMat3::from_diagonal(DVec3::new(a, b, c)) * r.transpose(),
            gains: Gains { kp: 600.0, kd: 49.0 },
            max_torque: f64::INFINITY,
            limits: None,
            armature: 0.0,
            spring: None,
            shapes: Vec::new(),
        });
    }
    CharacterModel {
        name: "random tree".into(),
        step_rate: 1200.0,
        links: list,
        contact_points: Vec::new(),
        blades: Vec::new(),
        grips: Vec::new(),
        collision_pairs: Vec::new(),
        feet: Vec::new(),
        trunk: 0,
    }
}

/// Random joint vectors in child axes, along the axis for hinges; entry 0 zero.
pub fn random_joint_vectors(model: &CharacterModel, random: &mut RandomStream, size: f64) -> Vec<Vec3<f64>> {
    model
        .links
        .iter()
        .map(|l| match l.joint {
            JointKind::Free => Vec3::zero(),
            JointKind::Hinge { axis } => Vec3::splat(axis * random.range(-size, size)),
            JointKind::Ball => Vec3::splat(random_vector(random, size)),
        })
        .collect()
}

/// Sets the rotation of named links from rotation vectors in degrees; other joints stay at zero.
pub fn pose(model: &CharacterModel, bends: &[(&str, [f64; 3])]) -> Vec<DQuat> {
    let mut joints = vec![DQuat::IDENTITY; model.links.len()];
    for (name, degrees) in bends {
        let link = model.link_index(name).unwrap_or_else(|| panic!("{} has no link {name}", model.name));
        joints[link] = DQuat::from_scaled_axis(DVec3::from_array(degrees.map(f64::to_radians)));
    }
    joints
}

/// The skater with arms and a leg out.
pub fn open_pose(model: &CharacterModel) -> Vec<DQuat> {
    pose(
        model,
        &[
            ("bicep_left", [0.0, 0.0, -85.0]),
            ("bicep_right", [0.0, 0.0, 85.0]),
            ("thigh_left", [5.0, 0.0, -25.0]),
            ("thigh_right", [5.0, 0.0, 25.0]),
            ("shin_left", [-10.0, 0.0, 0.0]),
            ("shin_right", [-10.0, 0.0, 0.0]),
        ],
    )
}

/// The skater with arms down at its sides and legs together.
pub fn closed_pose(model: &CharacterModel) -> Vec<DQuat> {
    pose(
        model,
        &[
            ("bicep_left", [0.0, 0.0, 6.0]),
            ("bicep_right", [0.0, 0.0, -6.0]),
            ("forearm_left", [15.0, 0.0, 6.0]),
            ("forearm_right", [15.0, 0.0, -6.0]),
            ("thigh_left", [0.0, 0.0, 6.0]),
            ("thigh_right", [0.0, 0.0, -6.0]),
        ],
    )
}

/// The skater with legs that want to pass through each other and arms that want into the trunk.
pub fn tangled_pose(model: &CharacterModel) -> Vec<DQuat> {
    pose(
        model,
        &[
            ("bicep_left", [0.0, 0.0, 40.0]),
            ("bicep_right", [0.0, 0.0, -40.0]),
            ("thigh_left", [0.0, 0.0, 30.0]),
            ("thigh_right", [0.0, 0.0, -30.0]),
        ],
    )
}

/// One rigid body: its inertia about the centre of mass is `inertia` (diagonal, kg m^2), its centre of mass at `com`.
pub fn rigid(mass: f64, inertia: DVec3, com: DVec3) -> CharacterModel {
    CharacterModel {
        name: "rigid body".into(),
        step_rate: 1200.0,
        links: vec![Link {
            name: "body".into(),
            parent: None,
            joint: JointKind::Free,
            offset: DVec3::ZERO,
            mass,
            com,
            inertia: DMat3::from_diagonal(inertia),
            gains: Gains { kp: 0.0, kd: 0.0 },
            max_torque: 0.0,
            limits: None,
            armature: 0.0,
            spring: None,
            shapes: Vec::new(),
        }],
        contact_points: Vec::new(),
        blades: Vec::new(),
        grips: Vec::new(),
        collision_pairs: Vec::new(),
        feet: Vec::new(),
        trunk: 0,
    }
}

/// Adds an ordinary contact point to link 0.
pub fn add_point(model: &mut CharacterModel, position: DVec3, radius: f64) {
    let name = format!("point{}", model.contact_points.len());
    let kind = ContactKind::Point;
    model.contact_points.push(ContactPoint {
        name,
        link: 0,
        position,
        radius,
        friction: 1.0,
        kind,
        role: bevy_athlete::model::PointRole::Body,
    });
}

/// Adds a blade along -z to link 0, `length` m long, its middle at `middle`, its inside edge towards +x.
pub fn add_blade(model: &mut CharacterModel, middle: DVec3, length: f64, lean_law: LeanLaw) {
    let (index, toe) = (model.blades.len(), model.contact_points.len());
    for (end, z, kind) in
        [("toe", -0.5 * length, ContactKind::BladeToe(index)), ("heel", 0.5 * length, ContactKind::BladeHeel(index))]
    {
        let position = middle + DVec3::new(0.0, 0.0, z);
        let name = format!("blade{index}_{end}");
        model.contact_points.push(ContactPoint {
            name,
            link: 0,
            position,
            radius: 0.0,
            friction: 1.0,
            kind,
            role: bevy_athlete::model::PointRole::Body,
        });
    }
    let name = format!("blade{index}");
    model.blades.push(Blade { name, link: 0, toe, heel: toe + 1, inside: DVec3::X, lean_law, bite: None });
}

/// A box of 10 kg with the half extents `half` and a contact point at each bottom corner; its origin is its centre.
pub fn crate_box(half: DVec3) -> CharacterModel {
    let mass = 10.0;
    let s = half * half * (mass / 3.0);
    let mut model = rigid(mass, DVec3::new(s.y + s.z, s.x + s.z, s.x + s.y), DVec3::ZERO);
    for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        add_point(&mut model, DVec3::new(x * half.x, -half.y, z * half.z), 0.0);
    }
    model
}

/// A simulator in scalar f64 with the settings of the model.
pub fn simulator(model: CharacterModel) -> Simulator<f64> {
    let settings = SimulationSettings::of(&model);
    Simulator::new(Arc::new(model), settings)
}

/// Puts the root of a simulator somewhere, with a velocity; joints stay.
pub fn place(sim: &mut Simulator<f64>, position: DVec3, rotation: DQuat, linear: DVec3, angular: DVec3) {
    let still = vec![DVec3::ZERO; sim.model().links.len()];
    let joints: Vec<DQuat> = sim.state.joints.iter().map(|j| j.rotation.lane(0)).collect();
    sim.state.set_pose(0, position, rotation, &joints);
    sim.state.set_velocity(0, linear, angular, &still);
    sim.state_changed();
}

/// World position of a contact point.
pub fn point_position(sim: &mut Simulator<f64>, point: usize) -> DVec3 {
    let p = sim.model().contact_points[point].clone();
    let root = sim.state.root_position.lane(0);
    let k = &sim.kinematics()[p.link];
    root + k.origin.lane(0) + k.rotation.lane(0) * p.position
}
