//! The simulator: model, state, commands and work space of one character or one batch of lanes.

use crate::contact::{
    BladeEdge, ContactScratch, ContactSettings, GripInputs, RowInputs, SelfCollision, SelfCollisionSettings, Terrain,
    build_rows, detect_contacts, solve_contacts,
};
use crate::dynamics::{
    ArticulatedLink, GripAnchor, JointCommand, LimitSpring, LinkConstants, LinkKinematics, Momentum, ServoOutput,
    State, Totals, articulated_inertias, correct_root, forward_accelerations, integrate, momentum, servo, totals,
    update_positions, update_twists, update_velocities,
};
use crate::math::{Force, Mobility, Motion, Quat, Real, Vec3};
use crate::model::{Blade, SharedModel};
use glam::DVec3;

/// What a simulation does beyond the model: rates and switches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulationSettings {
    /// Steps per second.
    pub rate: f64,
    /// Acceleration of free fall, world axes, m/s^2.
    pub gravity: DVec3,
    /// Contact tuning.
    pub contact: ContactSettings,
    /// Joint limits; `None` switches them off.
    pub limits: Option<LimitSpring>,
    /// Self-collision; `None` switches it off.
    pub self_collision: Option<SelfCollisionSettings>,
}

impl SimulationSettings {
    /// The settings a character file asks for: its rate, earth's gravity, joint limits on, self-collision on.
    pub fn of(model: &crate::model::CharacterModel) -> Self {
        Self {
            rate: model.step_rate,
            gravity: DVec3::new(0.0, -9.81, 0.0),
            contact: ContactSettings::default(),
            limits: Some(LimitSpring::default()),
            self_collision: Some(SelfCollisionSettings::default()),
        }
    }
}

/// A force on a link from outside: a push, wind, a rope.
#[derive(Clone, Copy, Debug)]
pub struct ExternalForce<R> {
    /// Link index.
    pub link: usize,
    /// Where it acts, link frame, m.
    pub position: Vec3<R>,
    /// Force, world axes, N.
    pub force: Vec3<R>,
}

/// Model, state, commands and work space of one character (`f64`) or a batch of them (one per lane).
#[derive(Clone, Debug)]
pub struct Simulator<R: Real> {
    model: SharedModel,
    settings: SimulationSettings,
    /// The state: all that has to be kept to go on from here.
    pub state: State<R>,
    /// What each joint is told to do; entry 0 is unused.
    pub commands: Vec<JointCommand<R>>,
    /// Forces from outside; they act in every step until removed.
    pub external: Vec<ExternalForce<R>>,
    /// Factor on every friction coefficient, by lane.
    pub friction_scale: R,
    constants: Vec<LinkConstants<R>>,
    self_collision: SelfCollision<R>,
    mass: R,
    h: R,
    /// Kinematics belong to the present state.
    fresh: bool,
    pub(crate) kinematics: Vec<LinkKinematics<R>>,
    body: Totals<R>,
    momentum: Momentum<R>,
    pub(super) servos: Vec<ServoOutput<R>>,
    wrenches: Vec<Force<R>>,
    has_wrenches: bool,
    /// Where the external forces act, relative to the root's origin at the start of the step, m.
    external_places: Vec<Vec3<R>>,
    articulated: Vec<ArticulatedLink<R>>,
    root_mobility: Mobility<R>,
    pub(crate) contact: ContactScratch<R>,
    pub(crate) contact_root_position: Vec3<R>,
    accelerations: Vec<Motion<R>>,
    root_acceleration: Motion<R>,
    predicted: Vec<Motion<R>>,
    pub(super) joint_accelerations: Vec<Vec3<R>>,
}

impl<R: Real> Simulator<R> {
    /// A character at rest in its zero pose, holding that pose.
    pub fn new(model: SharedModel, settings: SimulationSettings) -> Self {
        let n = model.links.len();
        let commands = model
            .links
            .iter()
            .map(|l| JointCommand {
                rotation: Quat::identity(),
                velocity: Vec3::zero(),
                kp: R::splat(l.gains.kp),
                kd: R::splat(l.gains.kd),
                torque: Vec3::zero(),
            })
            .collect();
        Self {
            state: State::at_rest(&model),
            commands,
            external: Vec::new(),
            friction_scale: R::one(),
            constants: LinkConstants::of(&model),
            self_collision: SelfCollision::of(&model),
            mass: R::splat(model.mass()),
            h: R::splat(1.0 / settings.rate),
            fresh: false,
            kinematics: vec![LinkKinematics::default(); n],
            body: Totals::default(),
            momentum: Momentum::default(),
            servos: vec![ServoOutput::default(); n],
            wrenches: vec![Force::zero(); n],
            has_wrenches: false,
            external_places: Vec::with_capacity(8),
            articulated: vec![ArticulatedLink::default(); n],
            root_mobility: Mobility::default(),
            contact: ContactScratch::new(&model),
            contact_root_position: Vec3::zero(),
            accelerations: vec![Motion::zero(); n],
            root_acceleration: Motion::zero(),
            predicted: vec![Motion::zero(); n],
            joint_accelerations: vec![Vec3::zero(); n],
            model,
            settings,
        }
    }

    /// The model.
    pub fn model(&self) -> &SharedModel {
        &self.model
    }
    /// The settings.
    pub fn settings(&self) -> &SimulationSettings {
        &self.settings
    }
    /// Replaces the settings.
    pub fn set_settings(&mut self, settings: SimulationSettings) {
        self.h = R::splat(1.0 / settings.rate);
        self.settings = settings;
    }
    /// Length of a step, s.
    pub fn step_seconds(&self) -> f64 {
        1.0 / self.settings.rate
    }

    /// To be called after the state was changed from outside.
    pub fn state_changed(&mut self) {
        self.fresh = false;
    }

    /// Kinematics of the present state.
    pub fn kinematics(&mut self) -> &[LinkKinematics<R>] {
        self.refresh_kinematics();
        &self.kinematics
    }

    /// Centre of mass, world frame, m.
    pub fn center_of_mass(&mut self) -> Vec3<R> {
        self.refresh_kinematics();
        self.state.root_position + self.body.com
    }

    /// Centre of mass relative to the root, world axes, m; of a simulator whose kinematics are up to date.
    pub(crate) fn com_from_root(&self) -> Vec3<R> {
        self.body.com
    }

    /// Momentum of the present state.
    pub fn total_momentum(&mut self) -> Momentum<R> {
        self.refresh_kinematics();
        momentum(&self.constants, &self.kinematics, self.body.com)
    }

    /// Composite inertia about the centre of mass, world axes, kg m^2.
    pub fn total_inertia(&mut self) -> crate::math::Sym3<R> {
        self.refresh_kinematics();
        self.body.inertia
    }

    /// Kinetic and potential energy, J.
    pub fn energy(&mut self) -> (R, R) {
        self.refresh_kinematics();
        let gravity = Vec3::splat(self.settings.gravity);
        crate::dynamics::energy(&self.constants, &self.kinematics, self.state.root_position, gravity)
    }

    /// The model's numbers over lanes.
    pub fn constants(&self) -> &[LinkConstants<R>] {
        &self.constants
    }

    /// Torque of the last step on link `link` from its joint, child axes, N m: servo, extra torque, limit spring and passive spring, the implicit
    /// parts included; what an armature takes of it does not reach the link. What is known before the step is within the joint's `max_torque`; in a jolt the implicit damping may go beyond
    /// it for a step.
    pub fn joint_torque(&self, link: usize) -> Vec3<R> {
        self.servos[link].torque_at(self.joint_accelerations[link])
    }

    /// The toe and the heel end of a blade, world axes, relative to the root, m.
    pub fn blade_ends(&mut self, blade: &Blade) -> (Vec3<R>, Vec3<R>) {
        let model = self.model.clone();
        let link = self.kinematics()[blade.link];
        let end = |point: usize| link.origin + link.rotation.mul_vec(Vec3::splat(model.contact_points[point].position));
        (end(blade.toe), end(blade.heel))
    }

    /// Edge of a blade during the last step.
    pub fn blade_edge(&self, blade: usize, lane: usize) -> BladeEdge {
        match self.contact.blades.get(blade).copied().flatten() {
            Some(b) if R::mask_lane(b.on_ice, lane) => BladeEdge::of_lean(b.lean.lane(lane)),
            _ => BladeEdge::Off,
        }
    }

    /// Lean (rad) and curvature (1/m) of a blade during the last step; `None` when off the ice.
    pub fn blade_lean(&self, blade: usize, lane: usize) -> Option<(f64, f64)> {
        let b = self.contact.blades.get(blade).copied().flatten()?;
        R::mask_lane(b.on_ice, lane).then(|| (b.lean.lane(lane), b.curvature.lane(lane)))
    }

    /// Force of the last step on the link of contact point `point`, world axes, N; zero when apart.
    pub fn contact_force(&self, point: usize, lane: usize) -> DVec3 {
        self.state.contact_impulses[point].lane(lane) * self.settings.rate
    }

    /// Where grip number `grip` is in lane `lane`, world frame, m; `None` for a number that the character does not have.
    pub fn grip_position(&mut self, grip: usize, lane: usize) -> Option<DVec3> {
        let (link, position) = self.model.grips.get(grip).map(|g| (g.link, g.position))?;
        self.refresh_kinematics();
        let k = &self.kinematics[link];
        Some(self.state.root_position.lane(lane) + k.origin.lane(lane) + k.rotation.lane(lane) * position)
    }

    /// Closes grip number `grip` of lane `lane` about `anchor`. It holds from the next step on by up to the `max_force` of the grip;
    /// where the anchor lies on a surface that a hand cannot close about, it only pushes and rubs (see
    /// [`SurfaceHit::grippable`](crate::contact::SurfaceHit::grippable)). A hand that is away from its anchor is drawn to it gently. A number that the character does not have
    /// is ignored.
    pub fn hold(&mut self, grip: usize, lane: usize, anchor: GripAnchor) {
        self.state.hold(grip, lane, anchor);
    }

    /// Opens grip number `grip` of lane `lane`.
    pub fn release(&mut self, grip: usize, lane: usize) {
        self.state.release(grip, lane);
    }

    /// Force of the last step on the link of grip number `grip`, world axes, N; zero where it is open.
    pub fn grip_force(&self, grip: usize, lane: usize) -> DVec3 {
        self.state.grip_impulses.get(grip).map_or(DVec3::ZERO, |impulse| impulse.lane(lane) * self.settings.rate)
    }

    /// Whether grip number `grip` of lane `lane` slipped open in the last step: what it held pulled harder than it can hold for
    /// longer than `grip_slip`, or the solid that it held is gone.
    pub fn grip_slipped(&self, grip: usize, lane: usize) -> bool {
        self.contact.grip_probes.get(grip).is_some_and(|probe| R::mask_lane(probe.slipped, lane))
    }

    /// Number of contact points that carried load in the last step in lane `lane`.
    pub fn loaded_points(&self, lane: usize) -> usize {
        (0..self.model.contact_points.len()).filter(|&p| self.contact_force(p, lane).length() > 1e-9).count()
    }

    /// Forces from outside during the last step: link, point (world frame at the step's start, m), force (N).
    pub fn external_points(&self, lane: usize) -> Vec<(usize, DVec3, DVec3)> {
        let at = |(push, place): (&ExternalForce<R>, &Vec3<R>)| {
            (push.link, (self.contact_root_position + *place).lane(lane), push.force.lane(lane))
        };
        self.external.iter().zip(&self.external_places).map(at).collect()
    }

    /// True if lane `lane` is finite and within the range the step is made for (speeds below 100 m/s and 200 rad/s).
    pub fn is_sane(&self, lane: usize) -> bool {
        let v = &self.state.root_velocity;
        self.state.is_finite(lane)
            && v.linear.lane(lane).length() < 100.0
            && v.angular.lane(lane).length() < 200.0
            && self.state.joints.iter().all(|j| j.velocity.lane(lane).length() < 1000.0)
    }

    /// The forward dynamics of the present state and commands without contact, and nothing else: kinematics, servos,
    /// articulated inertias, accelerations. The state stays. For timing; [`Simulator::joint_torque`] is that of this state
    /// afterwards.
    pub fn forward_only(&mut self) {
        self.fresh = false;
        self.refresh_kinematics();
        self.run_servos();
        self.has_wrenches = false;
        self.articulate();
        self.accelerate();
    }

    pub(super) fn refresh_kinematics(&mut self) {
        if !self.fresh {
            update_positions(&self.constants, &self.state, &mut self.kinematics);
            update_velocities(&self.constants, &self.state, &mut self.kinematics);
            self.body = totals(&self.constants, &self.kinematics, self.mass);
            self.fresh = true;
        }
    }

    pub(super) fn measure_momentum(&mut self) {
        self.momentum = momentum(&self.constants, &self.kinematics, self.body.com);
    }

    pub(super) fn run_servos(&mut self) {
        for i in 1..self.constants.len() {
            self.servos[i] = servo(&self.constants[i], &self.state, i, &self.commands[i], self.settings.limits, self.h);
        }
    }

    pub(super) fn collect_external_wrenches(&mut self) {
        self.has_wrenches = false;
        self.external_places.clear();
        if self.external.is_empty() && self.settings.self_collision.is_none() {
            return;
        }
        self.wrenches.fill(Force::zero());
        if let Some(settings) = &self.settings.self_collision {
            self.has_wrenches = self.self_collision.add_forces(&self.kinematics, settings, &mut self.wrenches);
        }
        for push in &self.external {
            let arm = self.kinematics[push.link].rotation.mul_vec(push.position);
            self.wrenches[push.link] += Force::at(arm, push.force);
            self.has_wrenches = true;
            // The part of the momentum that comes from outside.
            let place = self.kinematics[push.link].origin + arm;
            self.external_places.push(place);
            let point = place - self.body.com;
            self.momentum.linear = push.force.mul_add(self.h, self.momentum.linear);
            self.momentum.angular = point.cross(push.force).mul_add(self.h, self.momentum.angular);
        }
    }

    pub(super) fn articulate(&mut self) {
        let external: &[Force<R>] = if self.has_wrenches { &self.wrenches } else { &[] };
        self.root_mobility =
            articulated_inertias(&self.constants, &self.kinematics, &self.servos, external, &mut self.articulated);
    }

    pub(super) fn detect_contacts(&mut self, terrain: &impl Terrain<R>) -> bool {
        self.contact_root_position = self.state.root_position;
        let any = detect_contacts(
            &self.model,
            &self.kinematics,
            self.state.root_position,
            terrain,
            &self.settings.contact,
            1.0 / self.settings.rate,
            GripInputs { states: &mut self.state.grips, impulses: &mut self.state.grip_impulses },
            &mut self.contact,
        );
        if !any {
            self.state.contact_impulses.fill(Vec3::zero());
            self.state.grip_impulses.fill(Vec3::zero());
        }
        any
    }

    pub(super) fn solve_contacts(&mut self) {
        self.contact.mobility.update(
            &self.constants,
            &self.kinematics,
            &self.articulated,
            &self.root_mobility,
            &self.contact.groups,
        );
        self.predict_velocities();
        let inputs = RowInputs {
            model: &self.model,
            settings: &self.settings.contact,
            friction_scale: self.friction_scale,
            warm_points: &self.state.contact_impulses,
            warm_grips: &self.state.grip_impulses,
            h: 1.0 / self.settings.rate,
        };
        build_rows(&inputs, &mut self.contact);
        solve_contacts(self.settings.contact.iterations, self.settings.contact.tolerance, &mut self.contact);
        self.apply_contact_impulses();
    }

    /// Velocities of the links in contact and their ancestors after the step if nothing touched: J times the
    /// generalised velocity that the step would end with.
    fn predict_velocities(&mut self) {
        let h = self.h;
        let root = -self.root_mobility.mul_force(&self.articulated[0].bias);
        self.accelerations[0] = root;
        let gravity = Vec3::splat(self.settings.gravity);
        let falling = Motion { angular: root.angular, linear: root.linear + gravity };
        self.predicted[0] = falling.mul_add(h, &self.state.root_velocity);
        for &i in &self.contact.mobility.support()[1..] {
            let parent = self.constants[i].parent;
            let (k, a) = (&self.kinematics[i], &self.articulated[i]);
            let (acceleration, relative) = a.accelerate(k.from_parent, &self.accelerations[parent]);
            self.accelerations[i] = acceleration;
            let joint_velocity = relative.mul_add(h, k.joint_velocity);
            let parent = self.predicted[parent];
            self.predicted[i] = Motion { angular: parent.angular + joint_velocity, linear: parent.at(k.from_parent) };
        }
        for group in &mut self.contact.groups {
            group.velocity = self.predicted[group.link];
        }
    }

    /// Turns the impulses into wrenches on the articulated bodies, and keeps them for the momentum and the next step.
    fn apply_contact_impulses(&mut self) {
        self.state.contact_impulses.fill(Vec3::zero());
        self.state.grip_impulses.fill(Vec3::zero());
        for c in self.contact.candidates() {
            // A point that only touches in another lane gives zeros of either sign; alone it would not be there.
            let impulse = c.impulse() + Vec3::zero();
            let kept = if c.is_grip { &mut self.state.grip_impulses } else { &mut self.state.contact_impulses };
            kept[c.source] = impulse;
            self.momentum.linear += impulse;
            self.momentum.angular += (c.place - self.body.com).cross(impulse);
        }
        let inverse_h = R::splat(self.settings.rate);
        for &i in self.contact.mobility.support() {
            self.wrenches[i] = Force::zero();
        }
        for group in &self.contact.groups {
            self.wrenches[group.link] =
                Force { moment: group.wrench.moment * inverse_h, force: group.wrench.force * inverse_h };
        }
        for &i in self.contact.mobility.support()[1..].iter().rev() {
            let wrench = self.wrenches[i];
            let link = &mut self.articulated[i];
            link.drive = link.joint_mobility.mul_vec_add(wrench.moment, link.drive);
            let passed = link.pass_up(self.kinematics[i].from_parent, &wrench);
            self.wrenches[self.constants[i].parent] += passed;
        }
        self.articulated[0].bias = self.articulated[0].bias - self.wrenches[0];
    }

    pub(super) fn accelerate(&mut self) {
        self.root_acceleration = forward_accelerations(
            &self.constants,
            &self.kinematics,
            &self.articulated,
            &self.root_mobility,
            Vec3::splat(self.settings.gravity),
            &mut self.accelerations,
            &mut self.joint_accelerations,
        );
    }

    pub(super) fn integrate(&mut self) {
        integrate(&self.root_acceleration, &self.joint_accelerations, self.h, &mut self.state);
    }

    /// Makes the momentum of the new state equal to the old one plus what gravity, contacts and pushes gave.
    pub(super) fn restore_momentum(&mut self) {
        let com = self.contact_root_position + self.body.com;
        let gravity = Vec3::splat(self.settings.gravity);
        self.momentum.linear = gravity.mul_add(self.mass * self.h, self.momentum.linear);
        let com_target = self.momentum.linear.mul_add(self.h * self.mass.recip(), com);
        update_positions(&self.constants, &self.state, &mut self.kinematics);
        update_velocities(&self.constants, &self.state, &mut self.kinematics);
        self.body =
            correct_root(&self.constants, &self.kinematics, self.mass, &self.momentum, com_target, &mut self.state);
        update_twists(&self.constants, self.state.root_velocity, &mut self.kinematics);
        self.fresh = true;
    }

    pub(super) fn advance_clock(&mut self) {
        self.state.time += self.step_seconds();
    }
}
