//! Snapshots: one opaque value that holds all that an athlete remembers.
//!
//! A body that is restored goes on with the same bits: places, velocities, the impulses that the next step starts from,
//! grips, targets, the clock, what is performed and how far it has come, what was told already. Not in it: files
//! (character, control, skills), the world, and the components of the entity.

use crate::asset::{StateError, StateReader, StateWriter};
use crate::engine::AthleteBody;
use crate::engine::controller::{Controller, hash};
use crate::model::{CharacterModel, SharedModel};
use std::sync::Arc;

/// The first bytes of a snapshot.
const MAGIC: &[u8; 8] = b"athlsnap";

/// Why a snapshot could not be read or restored.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// The bytes are something else.
    #[error("not a snapshot of an athlete: it does not begin with `athlsnap`")]
    NotASnapshot,
    /// The format is of another time.
    #[error("snapshot of format {found}; valid: {supported}")]
    Version {
        /// The version found.
        found: u64,
        /// The version that is read.
        supported: u64,
    },
    /// Bytes were changed or lost.
    #[error("the snapshot is damaged: checksum {found:016x}, by its bytes {computed:016x}")]
    Damaged {
        /// The checksum in the bytes.
        found: u64,
        /// That of the bytes.
        computed: u64,
    },
    /// It is of another character.
    #[error("snapshot of another character: {found}; valid: {wanted}, with the same links and masses")]
    Character {
        /// The character of the snapshot.
        found: String,
        /// That of the body.
        wanted: String,
    },
    /// The body is driven by something else.
    #[error("the snapshot is of a body driven by {found}; this one is driven by {wanted}, or files of other contents")]
    Controller {
        /// What drove the body of the snapshot.
        found: String,
        /// What drives this one.
        wanted: String,
    },
    /// Its contents cannot be.
    #[error("snapshot: {0}")]
    State(#[from] StateError),
}

/// All that an athlete's body remembers, at one moment. Clones share it.
///
/// Two snapshots of bodies in the same state are equal, bit for bit.
#[derive(Clone, Debug)]
pub struct AthleteSnapshot {
    state: Arc<[u8]>,
    origin: Origin,
}

/// What the state belongs to.
#[derive(Clone, Debug)]
enum Origin {
    /// Taken in this program.
    Live { model: SharedModel, given: Arc<Controller> },
    /// Read from bytes.
    Bytes(Arc<Identity>),
}

/// What the state belongs to, by name and contents.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Identity {
    character: String,
    model: u64,
    controller: String,
    files: u64,
}

impl Identity {
    fn of(model: &CharacterModel, given: &Controller) -> Self {
        let (controller, files) = given.identity();
        Self { character: model.name.clone(), model: model.fingerprint(), controller, files }
    }
}

impl PartialEq for AthleteSnapshot {
    fn eq(&self, other: &Self) -> bool {
        self.state == other.state
    }
}

impl AthleteSnapshot {
    /// Version of the byte format; others are refused.
    pub const VERSION: u64 = 8;

    /// Size of what it holds, bytes.
    pub fn size(&self) -> usize {
        self.state.len()
    }

    /// As bytes, for files and networks: the same on every machine.
    pub fn to_bytes(&self) -> Vec<u8> {
        let identity = match &self.origin {
            Origin::Live { model, given } => Identity::of(model, given),
            Origin::Bytes(identity) => Identity::clone(identity),
        };
        let mut out = StateWriter::with_capacity(self.state.len() + 256);
        MAGIC.iter().for_each(|b| out.byte(*b));
        out.whole(Self::VERSION);
        out.text(&identity.character);
        out.whole(identity.model);
        out.text(&identity.controller);
        out.whole(identity.files);
        out.count(self.state.len());
        let mut bytes = out.finish();
        bytes.extend_from_slice(&self.state);
        bytes.extend_from_slice(&hash(&bytes).to_le_bytes());
        bytes
    }

    /// From [`AthleteSnapshot::to_bytes`]. Whether it fits a body shows in [`AthleteBody::restore`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SnapshotError> {
        let mut from = StateReader::new(bytes);
        if from.take("magic", MAGIC.len()).ok() != Some(MAGIC.as_slice()) {
            return Err(SnapshotError::NotASnapshot);
        }
        let found = from.whole("version")?;
        if found != Self::VERSION {
            return Err(SnapshotError::Version { found, supported: Self::VERSION });
        }
        let (body, checksum) = bytes.split_at(bytes.len() - 8);
        let (found, computed) = (StateReader::new(checksum).whole("checksum")?, hash(body));
        if found != computed {
            return Err(SnapshotError::Damaged { found, computed });
        }
        let identity = Identity {
            character: from.text("character")?,
            model: from.whole("character")?,
            controller: from.text("controller")?,
            files: from.whole("controller")?,
        };
        let length = from.below("length", bytes.len())?;
        let state = from.take("state", length)?.into();
        from.whole("checksum")?;
        from.end()?;
        Ok(Self { state, origin: Origin::Bytes(Arc::new(identity)) })
    }
}

impl AthleteBody {
    /// All that the body remembers. Take it between fixed ticks, or in `FixedPostUpdate` after
    /// [`AthleteSystems::WriteBack`](super::AthleteSystems::WriteBack).
    pub fn snapshot(&self) -> AthleteSnapshot {
        let mut out = StateWriter::with_capacity(8192);
        self.write_state(&mut out);
        let origin = Origin::Live { model: self.model().clone(), given: self.given.clone() };
        AthleteSnapshot { state: out.finish().into(), origin }
    }

    /// Puts the body back to the moment of the snapshot; what it does from there on has the same bits as it had.
    ///
    /// A snapshot that was taken in this program brings back what drove the body then, too, until the components that
    /// name it change. One that was read from bytes fits a body that is driven by the same files. After an error the
    /// body is as it was.
    pub fn restore(&mut self, snapshot: &AthleteSnapshot) -> Result<(), SnapshotError> {
        let other_character = |found: &str, body: &Self| {
            let wanted = body.model().name.clone();
            Err(SnapshotError::Character { found: found.to_owned(), wanted })
        };
        let before = self.snapshot();
        match &snapshot.origin {
            Origin::Live { model, given } => {
                if !Arc::ptr_eq(model, self.model()) && model.fingerprint() != self.model().fingerprint() {
                    return other_character(&model.name, self);
                }
                self.adopt(given);
            }
            Origin::Bytes(identity) => {
                let own = Identity::of(self.model(), &self.given);
                if own.model != identity.model {
                    return other_character(&identity.character, self);
                }
                if own.files != identity.files {
                    return Err(SnapshotError::Controller {
                        found: identity.controller.clone(),
                        wanted: own.controller,
                    });
                }
            }
        }
        let read = self.read_state(&mut StateReader::new(&snapshot.state));
        if let (Err(_), Origin::Live { given, .. }) = (&read, &before.origin) {
            // What was written a moment ago can be read.
            self.adopt(given);
            let _ = self.read_state(&mut StateReader::new(&before.state));
        }
        Ok(read?)
    }

    /// Is driven as it was at another time.
    fn adopt(&mut self, given: &Arc<Controller>) {
        if !Arc::ptr_eq(&self.given, given) {
            self.controller = Controller::clone(given);
            self.given = given.clone();
        }
    }
}
