//! What outlives a step, for snapshots.

use super::Tracker;
use crate::asset::{StateError, StateReader, StateWriter};
use crate::math::Real;

impl<R: Real> Tracker<R> {
    /// Tick, place and targets of a lane; the motion itself is not part of it.
    pub fn write_state(&self, lane: usize, out: &mut StateWriter) {
        out.count(self.ticks[lane]);
        out.number(self.fractions[lane]);
        out.number(self.paces[lane]);
        out.number(self.lean.lane(lane));
        out.number(self.turning.lane(lane));
        out.number(self.anchor_heading.c.lane(lane));
        out.number(self.anchor_heading.s.lane(lane));
        out.vector(self.anchor_place.lane(lane));
        out.number(self.speed.lane(lane));
        out.number(self.support.height.lane(lane));
        out.vector(self.support.velocity.lane(lane));
        out.count(self.values[lane].len());
        self.values[lane].iter().for_each(|v| out.number(*v));
        self.parameters.iter().for_each(|v| out.number(v.lane(lane)));
        out.count(self.scan.len());
        self.scan.iter().for_each(|v| out.number(v.lane(lane)));
        self.alphas.iter().for_each(|v| out.number(v.lane(lane)));
        out.count(self.to.len());
        for q in self.from.iter().chain(&self.to) {
            out.rotation(q.lane(lane));
        }
    }

    /// Brings a lane to where one of a tracker of the same motion was.
    pub fn read_state(&mut self, lane: usize, from: &mut StateReader) -> Result<(), StateError> {
        let tick = from.below("tick of the motion", self.motion.last() + 1)?;
        let fraction = from.number("part of the tick")?;
        if !(0.0..1.0).contains(&fraction) {
            return Err(StateError::value("part of the tick", fraction, "0 to 1"));
        }
        self.paces[lane] = from.number("pace of the reference")?;
        self.lean.set_lane(lane, from.number("lean of the reference")?);
        self.turning.set_lane(lane, from.number("turn of the reference")?);
        self.anchor_heading.c.set_lane(lane, from.number("heading of the reference")?);
        self.anchor_heading.s.set_lane(lane, from.number("heading of the reference")?);
        self.anchor_place.set_lane(lane, from.vector("place of the reference")?);
        self.speed.set_lane(lane, from.number("commanded speed")?);
        self.support.height.set_lane(lane, from.number("height of the support")?);
        self.support.velocity.set_lane(lane, from.vector("velocity of the support")?);
        from.exactly("number of parameters", self.values[lane].len())?;
        for value in &mut self.values[lane] {
            *value = from.number("parameter")?;
        }
        for value in &mut self.parameters {
            value.set_lane(lane, from.number("parameter")?);
        }
        from.exactly("number of heights ahead", self.scan.len())?;
        for value in &mut self.scan {
            value.set_lane(lane, from.number("height ahead")?);
        }
        self.enter_at(lane, tick, fraction);
        for value in &mut self.alphas {
            value.set_lane(lane, from.number("gain")?);
        }
        from.exactly("number of targets", self.to.len())?;
        for q in self.from.iter_mut().chain(&mut self.to) {
            q.set_lane(lane, from.rotation("target")?);
        }
        Ok(())
    }
}
