//! What a body remembers, as numbers in a row.

use crate::asset::{StateError, StateReader, StateWriter};
use crate::contact::{ContactSettings, SelfCollisionSettings};
use crate::dynamics::{GripAnchor, LimitSpring};
use crate::engine::controller::Controller;
use crate::engine::step_clock::StepClock;
use crate::engine::{AthleteBody, AthleteDetail, QuarantineReason};
use crate::math::{Quat, Vec3};
use crate::sim::{ExternalForce, SimulationSettings, Simulator};
use bevy::math::DVec3;
use bevy::prelude::Transform;

const REASONS: [QuarantineReason; 8] = [
    QuarantineReason::Position,
    QuarantineReason::Velocity,
    QuarantineReason::Target,
    QuarantineReason::Policy,
    QuarantineReason::Terrain,
    QuarantineReason::Transform,
    QuarantineReason::Force,
    QuarantineReason::Unstable,
];
const DETAILS: [AthleteDetail; 3] = [AthleteDetail::Frozen, AthleteDetail::Reduced, AthleteDetail::Full];

impl AthleteBody {
    /// Everything that it takes to go on from here with the same bits, but the files.
    pub(super) fn write_state(&self, out: &mut StateWriter) {
        out.vector(self.placement.position);
        out.rotation(self.placement.heading);
        write_simulator(&self.simulator, out);
        out.long(self.clock.remainder);
        self.detector.write_state(out);
        out.option(self.quarantine, |out, reason| out.byte(number_of(&REASONS, &reason)));
        out.byte(number_of(&DETAILS, &self.detail));
        out.option(self.performs.as_deref(), StateWriter::text);
        out.option(self.reset_request, |out, place| out.option(place, write_transform));
        out.count(self.requests.len());
        self.requests.iter().for_each(|skill| out.text(skill));
        out.byte(kind(&self.controller));
        self.controller.write_state(out);
    }

    /// Goes to where a body of the same character with the same controller was. After an error the body is neither here
    /// nor there.
    pub(super) fn read_state(&mut self, from: &mut StateReader) -> Result<(), StateError> {
        self.placement.position = from.vector("placement")?;
        self.placement.heading = from.rotation("heading")?;
        if self.quarantine.is_some() {
            // Nothing of what went bad is carried over.
            self.simulator = Simulator::new(self.model().clone(), *self.simulator.settings());
        }
        read_simulator(&mut self.simulator, from)?;
        let remainder = from.long("clock")?;
        if remainder > StepClock::MOST {
            return Err(StateError::value("clock", remainder, format!("up to {}", StepClock::MOST)));
        }
        self.clock.remainder = remainder;
        self.detector.read_state(from)?;
        self.quarantine = from.option("quarantine", |from| one_of(&REASONS, "reason of the quarantine", from))?;
        self.detail = one_of(&DETAILS, "level of detail", from)?;
        self.performs = from.option("skill", |from| from.text("skill"))?;
        self.reset_request = from.option("reset", |from| from.option("place of the reset", read_transform))?;
        self.requests.clear();
        for _ in 0..from.below("number of requests", 1 << 16)? {
            self.requests.push(from.text("skill that was asked for")?);
        }
        let (found, own) = (from.byte("kind of controller")?, kind(&self.controller));
        if found != own {
            return Err(StateError::value("kind of controller", found, own));
        }
        self.controller.place(&self.placement, &self.simulator);
        self.controller.read_state(from)?;
        from.end()?;
        self.jumped = true;
        self.last_tick = 0.0;
        self.events.clear();
        Ok(())
    }
}

fn kind(controller: &Controller) -> u8 {
    match controller {
        Controller::Hold => 0,
        Controller::Play { .. } => 1,
        Controller::Direct { .. } => 2,
        Controller::Balance { .. } => 3,
    }
}

fn number_of<T: PartialEq>(all: &[T], value: &T) -> u8 {
    all.iter().position(|v| v == value).unwrap_or(0) as u8
}

fn one_of<T: Copy>(all: &[T], what: &'static str, from: &mut StateReader) -> Result<T, StateError> {
    let number = from.byte(what)?;
    let value = all.get(usize::from(number)).copied();
    value.ok_or_else(|| StateError::value(what, number, format!("below {}", all.len())))
}

fn write_transform(out: &mut StateWriter, transform: Transform) {
    out.vector(transform.translation.as_dvec3());
    out.rotation(transform.rotation.as_dquat());
    out.vector(transform.scale.as_dvec3());
}

fn read_transform(from: &mut StateReader) -> Result<Transform, StateError> {
    let translation = from.vector("place")?.as_vec3();
    let rotation = from.rotation("place")?.as_quat();
    Ok(Transform { translation, rotation, scale: from.vector("scale")?.as_vec3() })
}

fn write_anchor(out: &mut StateWriter, anchor: GripAnchor, nearest: f64) {
    let (solid, place) = match anchor {
        GripAnchor::Fixed(place) => (None, place),
        GripAnchor::Solid { solid, place } => (Some(solid), place),
    };
    out.option(solid, StateWriter::count);
    out.vector(place);
    out.number(nearest);
}

fn read_anchor(from: &mut StateReader) -> Result<(GripAnchor, f64), StateError> {
    let solid = from.option("solid of a grip", |from| from.below("solid of a grip", GripAnchor::MOST_SOLIDS))?;
    let place = from.vector("place of a grip")?;
    let anchor = solid.map_or(GripAnchor::Fixed(place), |solid| GripAnchor::Solid { solid, place });
    Ok((anchor, from.number("slip of a grip")?))
}

fn write_simulator(sim: &Simulator<f64>, out: &mut StateWriter) {
    write_settings(sim.settings(), out);
    out.number(sim.friction_scale);
    let state = &sim.state;
    out.number(state.time);
    out.vector(state.root_position.lane(0));
    out.rotation(state.root_rotation.lane(0));
    out.vector(state.root_velocity.angular.lane(0));
    out.vector(state.root_velocity.linear.lane(0));
    out.count(state.joints.len());
    for joint in state.joints.iter().skip(1) {
        out.rotation(joint.rotation.lane(0));
        out.vector(joint.velocity.lane(0));
    }
    out.count(state.contact_impulses.len());
    state.contact_impulses.iter().for_each(|v| out.vector(v.lane(0)));
    out.count(state.grip_impulses.len());
    state.grip_impulses.iter().for_each(|v| out.vector(v.lane(0)));
    state
        .grips
        .iter()
        .for_each(|grip| out.option(grip.anchor(0), |out, anchor| write_anchor(out, anchor, grip.nearest(0))));
    for command in sim.commands.iter().skip(1) {
        out.rotation(command.rotation.lane(0));
        out.vector(command.velocity.lane(0));
        out.vector(command.torque.lane(0));
        out.number(command.kp);
        out.number(command.kd);
    }
    out.count(sim.external.len());
    for force in &sim.external {
        out.count(force.link);
        out.vector(force.position.lane(0));
        out.vector(force.force.lane(0));
    }
}

fn read_simulator(sim: &mut Simulator<f64>, from: &mut StateReader) -> Result<(), StateError> {
    sim.set_settings(read_settings(from)?);
    sim.friction_scale = from.number("friction")?;
    let vector = |from: &mut StateReader, what| from.vector(what).map(Vec3::<f64>::splat);
    let rotation = |from: &mut StateReader, what| from.rotation(what).map(Quat::<f64>::splat);
    let state = &mut sim.state;
    state.time = from.number("time")?;
    state.root_position = vector(from, "root position")?;
    state.root_rotation = rotation(from, "root rotation")?;
    state.root_velocity.angular = vector(from, "root velocity")?;
    state.root_velocity.linear = vector(from, "root velocity")?;
    from.exactly("number of links", state.joints.len())?;
    for joint in state.joints.iter_mut().skip(1) {
        joint.rotation = rotation(from, "joint rotation")?;
        joint.velocity = vector(from, "joint velocity")?;
    }
    from.exactly("number of contact points", state.contact_impulses.len())?;
    for impulse in &mut state.contact_impulses {
        *impulse = vector(from, "contact impulse")?;
    }
    from.exactly("number of grips", state.grip_impulses.len())?;
    for impulse in &mut state.grip_impulses {
        *impulse = vector(from, "grip impulse")?;
    }
    for grip in &mut state.grips {
        grip.release(0);
        if let Some((anchor, nearest)) = from.option("grip", read_anchor)? {
            grip.hold(0, anchor);
            grip.set_nearest(0, nearest);
        }
    }
    for command in sim.commands.iter_mut().skip(1) {
        command.rotation = rotation(from, "target")?;
        command.velocity = vector(from, "target velocity")?;
        command.torque = vector(from, "extra torque")?;
        command.kp = from.number("stiffness")?;
        command.kd = from.number("damping")?;
    }
    sim.external.clear();
    for _ in 0..from.below("number of forces", usize::MAX)? {
        let link = from.below("link of a force", usize::MAX)?;
        let position = vector(from, "place of a force")?;
        sim.external.push(ExternalForce { link, position, force: vector(from, "force")? });
    }
    sim.state_changed();
    Ok(())
}

fn write_settings(settings: &SimulationSettings, out: &mut StateWriter) {
    let SimulationSettings { rate, gravity, contact, limits, self_collision } = *settings;
    out.number(rate);
    out.vector(gravity);
    let ContactSettings {
        margin,
        iterations,
        tolerance,
        correction,
        slop,
        correction_speed,
        grip_correction,
        grip_slip,
        friction_scale,
    } = contact;
    out.count(iterations);
    for number in [margin, tolerance, correction, slop, correction_speed, grip_correction, grip_slip, friction_scale] {
        out.number(number);
    }
    out.option(limits, |out, LimitSpring { stiffness, damping }| {
        out.number(stiffness);
        out.number(damping);
    });
    out.option(self_collision, |out, SelfCollisionSettings { stiffness, damping, depth_limit }| {
        out.number(stiffness);
        out.number(damping);
        out.number(depth_limit);
    });
}

fn read_settings(from: &mut StateReader) -> Result<SimulationSettings, StateError> {
    let rate = from.number("rate")?;
    if !(1.0..=1e6).contains(&rate) {
        return Err(StateError::value("rate", rate, "1 to 1000000 steps per second"));
    }
    let gravity: DVec3 = from.vector("gravity")?;
    let iterations = from.below("iterations of the solver", 10_000)?;
    let number = |from: &mut StateReader| from.number("contact settings");
    let contact = ContactSettings {
        iterations,
        margin: number(from)?,
        tolerance: number(from)?,
        correction: number(from)?,
        slop: number(from)?,
        correction_speed: number(from)?,
        grip_correction: number(from)?,
        grip_slip: number(from)?,
        friction_scale: number(from)?,
    };
    let limits = from.option("joint limits", |from| {
        Ok(LimitSpring { stiffness: from.number("joint limits")?, damping: from.number("joint limits")? })
    })?;
    let self_collision = from.option("self-collision", |from| {
        let mut number = || from.number("self-collision");
        Ok(SelfCollisionSettings { stiffness: number()?, damping: number()?, depth_limit: number()? })
    })?;
    Ok(SimulationSettings { rate, gravity, contact, limits, self_collision })
}
