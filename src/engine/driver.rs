//! What tells the joints of a body where to go.

use crate::asset::{StateError, StateReader, StateWriter};
use crate::control::{ControlPlayer, ReconstructedControl};
use crate::engine::Placement;
use crate::engine::performer::Performer;
use crate::sim::Simulator;
use std::sync::Arc;

/// What tells the joints where to go, as the body keeps it. Clones share all that does not change.
#[derive(Clone, Debug)]
pub(super) enum Driver {
    /// Nobody: the commands stay.
    Hold,
    /// A control, in the character's frame and as moved to a placement.
    Play { control: Arc<ReconstructedControl>, player: ControlPlayer, placed: Placement, finished: Option<f64> },
    /// Trained skills.
    Perform { performer: Performer, finished: Option<f64> },
}

impl Driver {
    /// Whether the next step begins a decision, which looks at the body.
    pub fn at_decision(&self) -> bool {
        match self {
            Self::Perform { performer, .. } => performer.player().at_decision(),
            Self::Hold | Self::Play { .. } => false,
        }
    }

    /// Sets the targets of the coming step; true if any changed.
    pub fn drive(&mut self, sim: &mut Simulator<f64>) -> bool {
        match self {
            Self::Play { player, finished: None, .. } => {
                let commands = player.commands_now();
                player.drive(sim);
                commands
            }
            Self::Perform { performer, .. } => performer.move_targets(sim),
            Self::Hold | Self::Play { .. } => false,
        }
    }

    /// Goes on at another rate, steps per second; false if it cannot, or cannot just now. A control is played at its own.
    pub fn set_rate(&mut self, rate: f64) -> bool {
        match self {
            Self::Hold => true,
            Self::Play { .. } => false,
            Self::Perform { performer, .. } => performer.set_rate(rate),
        }
    }

    /// Moves a control to a placement.
    pub fn place(&mut self, placement: &Placement, sim: &Simulator<f64>) {
        if let Self::Play { control, player, placed, .. } = self
            && placed != placement
            // The control fitted this character before it was moved.
            && let Ok(moved) = ControlPlayer::new(&placement.move_control(control), sim.model())
        {
            (*player, *placed) = (moved, *placement);
        }
    }

    /// What it is, for people, and a number that tells it from others.
    pub fn identity(&self) -> (String, u64) {
        let mut out = StateWriter::default();
        let name = match self {
            Self::Hold => "targets that are held".to_owned(),
            Self::Play { control, .. } => {
                for offset in control.offsets.iter().flatten() {
                    out.vector(*offset);
                }
                for pose in &control.clip.poses {
                    out.vector(pose.root_position);
                    out.rotation(pose.root_rotation);
                    pose.joints.iter().for_each(|q| out.rotation(*q));
                }
                out.number(control.rate);
                out.number(control.tick_rate);
                out.count(control.ticks_per_window);
                out.number(control.seconds);
                format!("a control of the clip {}", control.clip.name)
            }
            Self::Perform { performer, .. } => performer.identity(&mut out),
        };
        out.text(&name);
        (name, hash(&out.finish()))
    }

    /// What it remembers.
    pub fn write_state(&self, out: &mut StateWriter) {
        match self {
            Self::Hold => {}
            Self::Play { player, finished, .. } => {
                out.option(*finished, StateWriter::number);
                player.write_state(out);
            }
            Self::Perform { performer, finished } => {
                out.option(*finished, StateWriter::number);
                performer.write_state(out);
            }
        }
    }

    /// Goes to where one like it was.
    pub fn read_state(&mut self, from: &mut StateReader) -> Result<(), StateError> {
        let end = |from: &mut StateReader| from.option("end", |from| from.number("end"));
        match self {
            Self::Hold => Ok(()),
            Self::Play { player, finished, .. } => {
                *finished = end(from)?;
                player.read_state(from)
            }
            Self::Perform { performer, finished } => {
                *finished = end(from)?;
                performer.read_state(from)
            }
        }
    }
}

/// FNV-1a, 64 bit (Fowler, Noll, Vo 1991): tells contents apart; no seal against a forger.
pub(super) fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
}
