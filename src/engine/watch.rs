//! Watches a body step by step and notes what is worth an event.

use crate::contact::{BladeEdge, Terrain};
use crate::control::tracking::Heading;
use crate::engine::body::standing_height;
use crate::model::CharacterModel;
use crate::sim::Simulator;
use bevy::math::DVec3;

/// How long a new edge has to last, s: blades chatter for a few milliseconds when they touch down.
const EDGE_SETTLE: f64 = 0.010;
/// How long nothing may touch before it counts as a take-off, s.
const FLIGHT_SETTLE: f64 = 0.020;
/// A fall: centre of mass below this part of its standing height ...
const FALLEN_BELOW: f64 = 0.5;
/// ... and up again above this one.
const RISEN_ABOVE: f64 = 0.7;

/// Something to tell.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Happening {
    Edge { time: f64, blade: usize, from: BladeEdge, to: BladeEdge },
    TakeOff { time: f64, velocity: DVec3 },
    Landing { time: f64, airtime: f64, velocity: DVec3, height: f64, turns: f64 },
    SkillStarted { time: f64, skill: String },
    SkillEnded { time: f64, skill: String },
    Fell { time: f64, link: usize },
    Finished { time: f64 },
    Quarantined { time: f64 },
}

/// An edge that was told, and one that may replace it.
#[derive(Clone, Copy, Debug, Default)]
struct EdgeWatch {
    told: BladeEdge,
    seen: BladeEdge,
    since: f64,
}

/// What the watch remembers.
#[derive(Clone, Debug)]
pub(super) struct Watch {
    edges: Vec<EdgeWatch>,
    /// For each contact point, whether it is on the trunk or the head.
    trunk: Vec<bool>,
    /// Standing height of the centre of mass, m.
    height: f64,
    last_contact: Option<f64>,
    airborne: bool,
    fallen: bool,
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
    fn observe(&mut self, sim: &Simulator<f64>, touching: bool) {
        let heading = Heading::of(sim.state.root_rotation);
        let height = sim.state.root_position.y;
        if touching {
            *self = Self { low: height, high: height, heading: (heading.c, heading.s), turned: 0.0 };
        } else {
            // Within a step the sine of the turn is the turn.
            self.turned += heading.relative_to(Heading { c: self.heading.0, s: self.heading.1 }).s;
            self.heading = (heading.c, heading.s);
            self.high = self.high.max(height);
        }
    }
}

impl Watch {
    pub fn new(model: &CharacterModel) -> Self {
        // The trunk: from the root to the joint that is highest in the zero pose (the head's).
        let places = model.rest_positions();
        let highest = (0..places.len()).max_by(|&a, &b| places[a].y.total_cmp(&places[b].y)).unwrap_or(0);
        let mut is_trunk = vec![false; model.links.len()];
        let mut link = Some(highest);
        while let Some(i) = link {
            is_trunk[i] = true;
            link = model.links[i].parent;
        }
        Self {
            edges: vec![EdgeWatch::default(); model.blades.len()],
            trunk: model.contact_points.iter().map(|p| is_trunk[p.link]).collect(),
            height: standing_height(model),
            last_contact: None,
            airborne: false,
            fallen: false,
            flight: FlightWatch::default(),
        }
    }

    /// Forgets everything that happened.
    pub fn restart(&mut self) {
        self.edges.fill(EdgeWatch::default());
        self.last_contact = None;
        self.airborne = false;
        self.fallen = false;
    }

    /// Looks at the state after a step.
    pub fn observe(&mut self, sim: &mut Simulator<f64>, surroundings: &impl Terrain<f64>, out: &mut Vec<Happening>) {
        let time = sim.state.time;
        for (blade, watch) in self.edges.iter_mut().enumerate() {
            let edge = sim.blade_edge(blade, 0);
            if edge != watch.seen {
                watch.seen = edge;
                watch.since = time;
            }
            if watch.seen != watch.told && time - watch.since >= EDGE_SETTLE {
                out.push(Happening::Edge { time: watch.since, blade, from: watch.told, to: watch.seen });
                watch.told = watch.seen;
            }
        }

        let touches = |impulse: &crate::math::Vec3<f64>| impulse.lane(0) != DVec3::ZERO;
        let state = &sim.state;
        let touching = state.contact_impulses.iter().chain(&state.grip_impulses).any(touches);
        let on_trunk = |(impulse, trunk): (&crate::math::Vec3<f64>, &bool)| *trunk && touches(impulse);
        let trunk = state.contact_impulses.iter().zip(&self.trunk).position(on_trunk);
        let velocity = |sim: &mut Simulator<f64>| sim.total_momentum().linear.lane(0) / sim.model().mass();
        if touching {
            if self.airborne {
                let airtime = time - self.last_contact.unwrap_or(time);
                let (height, turns) = (self.flight.high - self.flight.low, self.flight.turned / core::f64::consts::TAU);
                out.push(Happening::Landing { time, airtime, velocity: velocity(sim), height, turns });
                self.airborne = false;
            }
            self.last_contact = Some(time);
        } else if let Some(last) = self.last_contact
            && !self.airborne
            && time - last >= FLIGHT_SETTLE
        {
            out.push(Happening::TakeOff { time: last, velocity: velocity(sim) });
            self.airborne = true;
        }

        self.flight.observe(sim, touching);

        // The height is only asked for where it matters: while the trunk touches, and after a fall.
        if self.fallen || trunk.is_some() {
            let com = sim.center_of_mass();
            let height = surroundings.query(com).distance;
            if let (Some(point), false) = (trunk, self.fallen) {
                if height < FALLEN_BELOW * self.height {
                    self.fallen = true;
                    out.push(Happening::Fell { time, link: sim.model().contact_points[point].link });
                }
            } else if height > RISEN_ABOVE * self.height {
                self.fallen = false;
            }
        }
    }
}
