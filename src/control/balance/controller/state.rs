//! What the balance controller remembers, as numbers in a row.

use super::super::forces::SupportPoint;
use super::super::stance::{AnkleStance, Stance};
use super::Balance;
use super::capture::Capture;
use crate::asset::{StateError, StateReader, StateWriter};
use crate::control::foot::SegmentSet;
use glam::DQuat;

impl Balance {
    /// Everything that it takes to go on from here with the same bits, but what it was made with.
    pub fn write_state(&self, out: &mut StateWriter) {
        write_stance(&self.stance, out);
        out.option(self.next.as_ref(), |out, next| write_stance(next, out));
        out.number(self.shifting);
        out.number(self.fresh);
        out.rotation(self.heading);
        self.capture.write_state(out);
        out.number(self.height);
        out.vector(self.guide.0);
        out.vector(self.guide.1);
        out.count(self.steps_left as usize);
        out.count(self.held_steps as usize);
        out.vector(self.decided_at);
        self.accelerations.iter().chain(&self.planned).for_each(|x| out.number(*x));
        self.targets.iter().for_each(|q| out.rotation(*q));
        for footing in &self.footings {
            out.vector(footing.ground.point);
            out.vector(footing.ground.normal);
            out.vector(footing.toward);
            out.vector(footing.drift);
            out.vector(footing.spin);
            out.number(footing.rise);
            out.number(footing.roll);
            out.byte(footing.coming.bits());
            for anchor in &footing.anchors {
                out.vector(anchor.place);
                out.rotation(anchor.rotation);
            }
        }
        out.count(self.forces.points().len());
        for point in self.forces.points() {
            out.count(point.link);
            out.count(point.index);
            out.vector(point.place);
            out.vector(point.normal);
            out.number(point.share);
        }
        out.vector(self.forces.middle());
        self.forces.multipliers().iter().for_each(|x| out.number(*x));
    }

    /// Goes to where a controller of the same character with the same settings was. After an error it is neither here nor there.
    pub fn read_state(&mut self, from: &mut StateReader) -> Result<(), StateError> {
        let (feet, joints) = (self.footings.len(), self.model.links.len());
        self.stance = read_stance(feet, joints, from)?;
        self.next = from.option("next stance", |from| read_stance(feet, joints, from))?;
        self.shifting = from.number("shift of the weight")?;
        self.fresh = from.number("time for the landing")?;
        self.heading = from.rotation("heading")?;
        self.capture = Capture::read_state(from, feet)?;
        self.height = from.number("height of the centre of mass")?;
        self.guide = (from.vector("wished place")?, from.vector("wished velocity")?);
        let most = u32::MAX as usize;
        self.steps_left = from.below("steps to the next decision", most)? as u32;
        self.held_steps = from.below("steps of a decision", most)? as u32;
        self.decided_at = from.vector("place of the last decision")?;
        for x in self.accelerations.iter_mut().chain(&mut self.planned) {
            *x = from.number("acceleration or velocity")?;
        }
        for q in &mut self.targets {
            *q = from.rotation("target of a joint")?;
        }
        for footing in &mut self.footings {
            footing.ground.point = from.vector("ground")?;
            footing.ground.normal = from.vector("normal of the ground")?;
            footing.toward = from.vector("direction of a foot")?;
            footing.drift = from.vector("velocity of the ground")?;
            footing.spin = from.vector("angular velocity of the ground")?;
            footing.rise = from.number("rise")?;
            footing.roll = from.number("roll")?;
            footing.coming = SegmentSet::from_bits(from.byte("segments that come down")?);
            for anchor in &mut footing.anchors {
                anchor.place = from.vector("place of a segment")?;
                anchor.rotation = from.rotation("rotation of a segment")?;
            }
        }
        self.forces.clear();
        let points = self.model.contact_points.len();
        for _ in 0..from.below("points that carry", points + 1)? {
            let link = from.below("link of a point", joints)?;
            let index = from.below("number of a point", points)?;
            let (place, normal) = (from.vector("place of a point")?, from.vector("normal of a point")?);
            let share = from.number("share of a point")?;
            self.forces.push(SupportPoint { link, index, place, normal, share });
        }
        let middle = from.vector("middle of the support")?;
        let mut multipliers = [0.0; 6];
        for x in &mut multipliers {
            *x = from.number("multiplier")?;
        }
        self.forces.build(self.settings.friction, self.settings.margin, middle);
        self.forces.restore(multipliers);
        Ok(())
    }
}

fn write_stance(stance: &Stance, out: &mut StateWriter) {
    out.count(stance.feet.len());
    for foot in &stance.feet {
        out.byte(foot.touch.bits());
        out.number(foot.rise);
        out.number(foot.roll);
    }
    out.count(stance.posture.len());
    stance.posture.iter().for_each(|q| out.rotation(*q));
}

fn read_stance(feet: usize, joints: usize, from: &mut StateReader) -> Result<Stance, StateError> {
    let mut stance = Stance { feet: vec![AnkleStance::default(); feet], posture: vec![DQuat::IDENTITY; joints] };
    from.exactly("feet of a stance", feet)?;
    for foot in &mut stance.feet {
        foot.touch = SegmentSet::from_bits(from.byte("segments")?);
        foot.rise = from.number("rise of an ankle")?;
        foot.roll = from.number("roll of an ankle")?;
    }
    from.exactly("joints of a stance", joints)?;
    for q in &mut stance.posture {
        *q = from.rotation("joint of a posture")?;
    }
    Ok(stance)
}
