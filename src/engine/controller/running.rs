//! What tells the joints of a body where to go, as the body keeps it.

use crate::asset::{StateError, StateReader, StateWriter};
use crate::contact::Terrain;
use crate::control::balance::{Balance, Stance};
use crate::control::{ControlPlayer, ReconstructedControl};
use crate::engine::Placement;
use crate::sim::Simulator;
use crate::skill::Director;
use std::sync::Arc;

/// What runs. Clones share all that does not change.
#[derive(Clone, Debug)]
pub(in crate::engine) enum Controller {
    /// Nobody: the commands stay.
    Hold,
    /// A control, in the character's frame and as moved to a placement.
    Play { control: Arc<ReconstructedControl>, player: ControlPlayer, placed: Placement, finished: Option<f64> },
    /// Trained skills.
    Direct { director: Box<Director>, finished: Option<f64> },
    /// Balance by control of momentum; it begins from where the body stands.
    Balance { balance: Box<Balance>, stance: Stance, begun: bool },
}

impl Controller {
    /// Whether the trunk touches the ground as part of what is performed, as in a roll.
    pub fn rolls(&self) -> bool {
        matches!(self, Self::Direct { director, .. } if director.player().skill().definition.touch.as_motion)
    }

    /// Whether the next step begins a decision, which looks at the body.
    pub fn at_decision(&self) -> bool {
        match self {
            Self::Direct { director, .. } => director.player().at_decision(),
            Self::Hold | Self::Play { .. } | Self::Balance { .. } => false,
        }
    }

    /// Looks at body and ground before every step, where it does; the body has to be up to date.
    pub fn before_step(&mut self, sim: &mut Simulator<f64>, terrain: &impl Terrain<f64>) {
        if let Self::Balance { balance, stance, begun } = self {
            if !std::mem::replace(begun, true) {
                balance.begin(sim, terrain);
                // It fitted the character when it was given.
                let fits = balance.assume(stance.clone());
                debug_assert!(fits.is_ok(), "{fits:?}");
            }
            balance.tick(sim, terrain);
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
            Self::Direct { director, .. } => director.player_mut().move_targets(sim),
            Self::Hold | Self::Play { .. } | Self::Balance { .. } => false,
        }
    }

    /// Goes on at another rate, steps per second; false if it cannot, or cannot just now. A control is played at its own.
    pub fn set_rate(&mut self, rate: f64) -> bool {
        match self {
            Self::Hold => true,
            Self::Play { .. } | Self::Balance { .. } => false,
            Self::Direct { director, .. } => director.set_rate(rate),
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
            Self::Direct { director, .. } => director.identity(&mut out),
            Self::Balance { .. } => "balance".to_owned(),
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
            Self::Direct { director, finished } => {
                out.option(*finished, StateWriter::number);
                director.write_state(out);
            }
            Self::Balance { balance, begun, .. } => {
                out.switch(*begun);
                balance.write_state(out);
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
            Self::Direct { director, finished } => {
                *finished = end(from)?;
                director.read_state(from)
            }
            Self::Balance { balance, begun, .. } => {
                *begun = from.switch("whether the balance has begun")?;
                balance.read_state(from)
            }
        }
    }
}

/// FNV-1a, 64 bit (Fowler, Noll, Vo 1991): tells contents apart; no seal against a forger.
pub(in crate::engine) fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
}
