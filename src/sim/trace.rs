//! The trace: what lets anyone check that nothing cheats.
//!
//! JSON lines: a header, then one line for each step. Format `athlete-trace-1`: masses and inertias of the bodies; after
//! every step positions and velocities, and the contact and external forces that acted during it, at the points where
//! they acted. 17 significant digits.

use crate::math::Real;
use crate::model::{CharacterModel, ContactKind};
use crate::sim::Simulator;
use glam::{DMat3, DQuat, DVec3};
use std::fmt::Write as _;
use std::io::{self, Write};

/// Writes a trace, line by line.
pub struct TraceWriter<W: Write> {
    out: W,
    line: String,
    lane: usize,
}

fn vector(line: &mut String, v: DVec3) {
    let _ = write!(line, "[{:.16e},{:.16e},{:.16e}]", v.x, v.y, v.z);
}

/// A name as a JSON string.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// World transform of every link of lane `lane`: origin (m) and rotation.
pub fn link_transforms<R: Real>(sim: &mut Simulator<R>, lane: usize) -> Vec<(DVec3, DQuat)> {
    let root = sim.state.root_position.lane(lane);
    sim.kinematics()
        .iter()
        .map(|k| (root + k.origin.lane(lane), DQuat::from_mat3(&k.rotation.lane(lane)).normalize()))
        .collect()
}

impl<W: Write> TraceWriter<W> {
    /// Writes the header for the simulator's lane `lane`.
    pub fn new<R: Real>(mut out: W, sim: &Simulator<R>, lane: usize) -> io::Result<Self> {
        let model: &CharacterModel = sim.model();
        let mut line = String::new();
        let _ = write!(
            line,
            "{{\"format\":\"athlete-trace-1\",\"character\":{},\"dt\":{:.16e},\"gravity\":",
            quoted(&model.name),
            sim.step_seconds()
        );
        vector(&mut line, sim.settings().gravity);
        line.push_str(",\"bodies\":[");
        for (i, link) in model.links.iter().enumerate() {
            if i > 0 {
                line.push(',');
            }
            let parent = link.parent.map_or(-1, |p| p as i64);
            let _ = write!(
                line,
                "{{\"name\":{},\"parent\":{parent},\"mass\":{:.16e},\"inertia\":[",
                quoted(&link.name),
                link.mass
            );
            let m = link.inertia.transpose();
            for (k, row) in [m.x_axis, m.y_axis, m.z_axis].into_iter().enumerate() {
                if k > 0 {
                    line.push(',');
                }
                vector(&mut line, row);
            }
            line.push_str("]}");
        }
        line.push_str("]}\n");
        out.write_all(line.as_bytes())?;
        Ok(Self { out, line, lane })
    }

    /// Writes the step that the simulator has just done.
    pub fn record<R: Real>(&mut self, sim: &mut Simulator<R>) -> io::Result<()> {
        let lane = self.lane;
        let line = &mut self.line;
        line.clear();
        let time = sim.state.time;
        let _ = write!(line, "{{\"t\":{time:.16e},\"bodies\":[");
        let root = sim.state.root_position.lane(lane);
        let rate = sim.settings().rate;
        for (i, k) in sim.kinematics().iter().enumerate() {
            if i > 0 {
                line.push(',');
            }
            let m: DMat3 = k.rotation.lane(lane);
            let q = DQuat::from_mat3(&m).normalize();
            line.push_str("{\"com\":");
            vector(line, root + k.origin.lane(lane) + k.com.lane(lane));
            let _ = write!(line, ",\"quat\":[{:.16e},{:.16e},{:.16e},{:.16e}],\"vel\":", q.w, q.x, q.y, q.z);
            vector(line, k.velocity.at(k.com).lane(lane));
            line.push_str(",\"omega\":");
            vector(line, k.velocity.angular.lane(lane));
            line.push('}');
        }
        line.push_str("],\"contacts\":[");
        let model = sim.model().clone();
        let start = sim.contact_root_position.lane(lane);
        let mut first = true;
        for c in sim.contact.candidates() {
            let force = c.impulse().lane(lane) * rate;
            if force == DVec3::ZERO || !R::mask_lane(c.active, lane) {
                continue;
            }
            let (body, kind) = if c.is_grip {
                (model.grips[c.source].link, "grip")
            } else {
                let point = &model.contact_points[c.source];
                let blade = !matches!(point.kind, ContactKind::Point) && R::mask_lane(c.blade, lane);
                (point.link, if blade { "blade" } else { "point" })
            };
            if !first {
                line.push(',');
            }
            first = false;
            let _ = write!(line, "{{\"body\":{body},\"point\":");
            vector(line, start + c.place.lane(lane));
            line.push_str(",\"normal\":");
            vector(line, c.directions[0].lane(lane));
            line.push_str(",\"force\":");
            vector(line, force);
            let _ = write!(line, ",\"kind\":\"{kind}\"}}");
        }
        line.push_str("],\"external\":[");
        for (n, push) in sim.external_points(lane).into_iter().enumerate() {
            if n > 0 {
                line.push(',');
            }
            let (link, point, force) = push;
            let _ = write!(line, "{{\"body\":{link},\"point\":");
            vector(line, point);
            line.push_str(",\"force\":");
            vector(line, force);
            line.push('}');
        }
        line.push_str("]}\n");
        self.out.write_all(self.line.as_bytes())
    }

    /// Flushes and returns the sink.
    pub fn finish(mut self) -> io::Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }
}
