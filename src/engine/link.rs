//! Links of athletes by name.

use crate::model::CharacterModel;
use bevy::prelude::*;

/// A link of a character. Ask for it by name: [`AthleteBody::link`](super::AthleteBody::link).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Reflect)]
#[reflect(Default)]
pub struct LinkId(usize);

impl LinkId {
    /// The root: the pelvis of a human.
    pub const ROOT: Self = Self(0);

    /// The link with this index in the character. One that is not there is no error: nothing acts on it and it is nowhere.
    pub const fn at(index: usize) -> Self {
        Self(index)
    }
    /// The link of this name.
    pub fn of(model: &CharacterModel, name: &str) -> Option<Self> {
        model.link_index(name).map(Self)
    }
    /// Its index in the character.
    pub const fn index(self) -> usize {
        self.0
    }
    /// Its name; `None` if the character has no such link.
    pub fn name(self, model: &CharacterModel) -> Option<&str> {
        model.links.get(self.0).map(|link| link.name.as_str())
    }
}
