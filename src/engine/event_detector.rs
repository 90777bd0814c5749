//! Looks at a body step by step and detects what is worth an event.

use crate::asset::{StateError, StateReader, StateWriter};
use crate::contact::{BladeEdge, Terrain};
use crate::control::tracking::Heading;
use crate::engine::foot_watch::{FootChange, FootEvent, FootStep, FootWatch};
use crate::engine::{QuarantineReason, StumbleCause};
use crate::math::{Real, Vec3};
use crate::model::CharacterModel;
use crate::sim::Simulator;
use crate::skill::planner::{Obstacle, Refusal};
use crate::skill::{BadParameter, NoEntry};
use bevy::math::DVec3;

/// How long a new edge has to last, s: blades chatter for a few milliseconds when they touch down.
const EDGE_SETTLE: f64 = 0.010;
/// How long nothing may touch before it counts as a take-off, s.
const FLIGHT_SETTLE: f64 = 0.020;
/// A body that balances is steady again after so long with its capture point inside of what stands, s.
const STEADY: f64 = 0.5;
/// A fall: centre of mass below this part of its standing height ...
const FALLEN_BELOW: f64 = 0.5;
/// ... and up again above this one.
const RISEN_ABOVE: f64 = 0.7;

/// Something that happened to a body.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum BodyEvent {
    Edge { time: f64, blade: usize, from: BladeEdge, to: BladeEdge },
    Foot(FootChange),
    Step(FootStep),
    Stumbled { time: f64, cause: StumbleCause },
    TakeOff { time: f64, velocity: DVec3 },
    Landing { time: f64, airtime: f64, velocity: DVec3, height: f64, turns: f64 },
    SkillStarted { time: f64, skill: String },
    SkillEnded { time: f64, skill: String },
    SkillRefused { time: f64, skill: String, reason: NoEntry },
    Parameter { time: f64, skill: String, parameter: String, reason: BadParameter },
    Plan { time: f64, obstacle: Obstacle, plan: Result<String, Refusal> },
    Fell { time: f64, link: usize },
    GripSlipped { time: f64, grip: usize },
    Finished { time: f64 },
    Quarantined { time: f64, reason: QuarantineReason },
}

/// An edge that was told of, and one that may replace it.
#[derive(Clone, Copy, Debug, Default)]
struct EdgeWatch {
    told: BladeEdge,
    seen: BladeEdge,
    since: f64,
}

/// What the detector remembers.
#[derive(Clone, Debug)]
pub(super) struct EventDetector {
    edges: Vec<EdgeWatch>,
    feet: Vec<FootWatch>,
    /// For each contact point, whether it is on the trunk or the head.
    trunk: Vec<bool>,
    /// Standing height of the centre of mass, m.
    height: f64,
    last_contact: Option<f64>,
    airborne: bool,
    fallen: bool,
    /// When a body that balances last had its capture point outside of what stands, s; `None` while it is steady.
    unsteady: Option<f64>,
    flight: FlightWatch,
}

/// A flight from the last contact on.
#[derive(Clone, Copy, Debug, Default)]
struct FlightWatch {
    /// Height of the root at the last contact and at the highest point since, m.
    low: f64,
    high: f64,
    /// Heading at the last step (cosine, sine), and the turn since the last contact, rad.
    heading: (f64, f64),
    turned: f64,
}

impl FlightWatch {
    fn observe(&mut self, heading: (f64, f64), height: f64, touching: bool) {
        if touching {
            *self = Self { low: height, high: height, heading, turned: 0.0 };
        } else {
            // Within a step the sine of the turn is the turn.
            let of = |(c, s): (f64, f64)| Heading { c, s };
            self.turned += of(heading).relative_to(of(self.heading)).s;
            self.heading = heading;
            self.high = self.high.max(height);
        }
    }
}

/// What touches the world after a step, in every lane of a simulator.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touches<R: Real> {
    any: R::Mask,
    trunk: R::Mask,
    /// Where the roots face.
    heading: Heading<R>,
}

impl<R: Real> Touches<R> {
    /// By the impulses of the last step; `detector` is that of a body of the same model.
    pub fn of(sim: &Simulator<R>, detector: &EventDetector) -> Self {
        let none = R::zero().lt(R::zero());
        let (mut any, mut trunk) = (none, none);
        for (impulse, on_trunk) in sim.state.contact_impulses.iter().zip(&detector.trunk) {
            let touches = touches(impulse);
            any = any | touches;
            if *on_trunk {
                trunk = trunk | touches;
            }
        }
        for impulse in &sim.state.grip_impulses {
            any = any | touches(impulse);
        }
        Self { any, trunk, heading: Heading::of(sim.state.root_rotation) }
    }
}

/// Where an impulse is not zero.
fn touches<R: Real>(impulse: &Vec3<R>) -> R::Mask {
    R::zero().lt(impulse.x.abs().max(impulse.y.abs()).max(impulse.z.abs()))
}

impl EventDetector {
    pub fn new(model: &CharacterModel) -> Self {
        let is_trunk = model.trunk_links();
        Self {
            edges: vec![EdgeWatch::default(); model.blades.len()],
            feet: FootWatch::of(model),
            trunk: model.contact_points.iter().map(|p| is_trunk[p.link]).collect(),
            height: standing_height(model),
            last_contact: None,
            airborne: false,
            fallen: false,
            unsteady: None,
            flight: FlightWatch::default(),
        }
    }

    /// Forgets everything that happened.
    pub fn restart(&mut self) {
        self.edges.fill(EdgeWatch::default());
        self.feet.iter_mut().for_each(FootWatch::restart);
        self.last_contact = None;
        self.airborne = false;
        self.fallen = false;
        self.unsteady = None;
    }

    /// How far outside of what stands the capture point of a body that balances lies, m.
    pub fn observe_balance(&mut self, outside: f64, time: f64, out: &mut Vec<BodyEvent>) {
        if outside > StumbleCause::OUTSIDE {
            if self.unsteady.replace(time).is_none() {
                out.push(BodyEvent::Stumbled { time, cause: StumbleCause::BalanceLost { outside } });
            }
        } else if self.unsteady.is_some_and(|last| time - last > STEADY) {
            self.unsteady = None;
        }
    }

    /// Looks at lane `lane` after a step; `time` is the body's, s. With `rolls` the trunk may touch the ground: it is part of what is performed.
    pub fn observe<R: Real>(
        &mut self,
        sim: &mut Simulator<R>,
        lane: usize,
        time: f64,
        rolls: bool,
        touches_now: &Touches<R>,
        surroundings: &impl Terrain<f64>,
        out: &mut Vec<BodyEvent>,
    ) {
        for (blade, watch) in self.edges.iter_mut().enumerate() {
            let edge = sim.blade_edge(blade, lane);
            if edge != watch.seen {
                watch.seen = edge;
                watch.since = time;
            }
            if watch.seen != watch.told && time - watch.since >= EDGE_SETTLE {
                out.push(BodyEvent::Edge { time: watch.since, blade, from: watch.told, to: watch.seen });
                watch.told = watch.seen;
            }
        }

        let standing = self.feet.iter().filter(|foot| foot.stands()).count();
        for foot in &mut self.feet {
            let carried = standing > usize::from(foot.stands());
            foot.observe(sim, lane, time, carried, surroundings, |event| {
                out.push(match event {
                    FootEvent::Change(change) => BodyEvent::Foot(change),
                    FootEvent::Step(step) => BodyEvent::Step(step),
                    FootEvent::Caught { time, foot, speed } => {
                        BodyEvent::Stumbled { time, cause: StumbleCause::FootCaught { foot, speed } }
                    }
                });
            });
        }

        for grip in (0..sim.model().grips.len()).filter(|&grip| sim.grip_slipped(grip, lane)) {
            out.push(BodyEvent::GripSlipped { time, grip });
        }

        let touching = R::mask_lane(touches_now.any, lane);
        let on_trunk = R::mask_lane(touches_now.trunk, lane);
        let velocity = |sim: &mut Simulator<R>| sim.total_momentum().linear.lane(lane) / sim.model().mass();
        if touching {
            if self.airborne {
                let airtime = time - self.last_contact.unwrap_or(time);
                let (height, turns) = (self.flight.high - self.flight.low, self.flight.turned / core::f64::consts::TAU);
                out.push(BodyEvent::Landing { time, airtime, velocity: velocity(sim), height, turns });
                self.airborne = false;
            }
            self.last_contact = Some(time);
        } else if let Some(last) = self.last_contact
            && !self.airborne
            && time - last >= FLIGHT_SETTLE
        {
            out.push(BodyEvent::TakeOff { time: last, velocity: velocity(sim) });
            self.airborne = true;
        }

        let Heading { c, s } = touches_now.heading;
        self.flight.observe((c.lane(lane), s.lane(lane)), sim.state.root_position.y.lane(lane), touching);

        // The height is only asked for where it matters: while the trunk touches, and after a fall.
        if self.fallen || on_trunk {
            let com = Vec3::<f64>::splat(sim.center_of_mass().lane(lane));
            let height = surroundings.query(com).distance;
            if on_trunk && !self.fallen && !rolls {
                let hit = |(impulse, trunk): (&Vec3<R>, &bool)| *trunk && R::mask_lane(touches(impulse), lane);
                let point = sim.state.contact_impulses.iter().zip(&self.trunk).position(hit);
                if let (Some(point), true) = (point, height < FALLEN_BELOW * self.height) {
                    self.fallen = true;
                    out.push(BodyEvent::Fell { time, link: sim.model().contact_points[point].link });
                }
            } else if height > RISEN_ABOVE * self.height {
                self.fallen = false;
            }
        }
    }

    /// What it remembers; what follows from the model is not part of it.
    pub fn write_state(&self, out: &mut StateWriter) {
        out.count(self.edges.len());
        for edge in &self.edges {
            out.byte(edge_number(edge.told));
            out.byte(edge_number(edge.seen));
            out.number(edge.since);
        }
        out.count(self.feet.len());
        self.feet.iter().for_each(|foot| foot.write_state(out));
        out.option(self.last_contact, StateWriter::number);
        out.switch(self.airborne);
        out.switch(self.fallen);
        out.option(self.unsteady, StateWriter::number);
        let FlightWatch { low, high, heading, turned } = self.flight;
        [low, high, heading.0, heading.1, turned].into_iter().for_each(|x| out.number(x));
    }

    /// Goes to where a detector of the same model was.
    pub fn read_state(&mut self, from: &mut StateReader) -> Result<(), StateError> {
        from.exactly("number of blades", self.edges.len())?;
        for edge in &mut self.edges {
            edge.told = numbered_edge(from)?;
            edge.seen = numbered_edge(from)?;
            edge.since = from.number("time of the edge")?;
        }
        from.exactly("number of soles", self.feet.len())?;
        self.feet.iter_mut().try_for_each(|foot| foot.read_state(from))?;
        self.last_contact = from.option("last contact", |from| from.number("last contact"))?;
        self.airborne = from.switch("whether it is in the air")?;
        self.fallen = from.switch("whether it has fallen")?;
        self.unsteady = from.option("last loss of balance", |from| from.number("last loss of balance"))?;
        let mut number = || from.number("flight");
        let (low, high, heading) = (number()?, number()?, (number()?, number()?));
        self.flight = FlightWatch { low, high, heading, turned: number()? };
        Ok(())
    }
}

/// Standing height of the centre of mass above the lowest contact point in the zero pose, m.
fn standing_height(model: &CharacterModel) -> f64 {
    let places = model.rest_positions();
    let moment: f64 = model.links.iter().zip(&places).map(|(l, p)| l.mass * (p.y + l.com.y)).sum();
    model.rest_root_height() + moment / model.mass()
}

const EDGES: [BladeEdge; 4] = [BladeEdge::Off, BladeEdge::Flat, BladeEdge::Inside, BladeEdge::Outside];

fn edge_number(edge: BladeEdge) -> u8 {
    EDGES.iter().position(|e| *e == edge).unwrap_or(0) as u8
}

fn numbered_edge(from: &mut StateReader) -> Result<BladeEdge, StateError> {
    let number = from.byte("edge of a blade")?;
    EDGES.get(usize::from(number)).copied().ok_or_else(|| StateError::value("edge of a blade", number, "0 to 3"))
}
