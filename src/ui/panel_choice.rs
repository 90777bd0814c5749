//! The panels there are, which are open, and which athlete they show.

use bevy::prelude::*;

/// A panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Panel {
    /// Links, joints, contacts, blades, policy.
    Inspector,
    /// Curves over the last seconds.
    Plots,
    /// Pushes, friction, slope, gravity.
    Disturbance,
    /// The points of each foot that touch.
    ContactPlate,
    /// Key poses.
    Editor,
    /// The curve of a training.
    Monitor,
}

impl Panel {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Inspector, Self::Plots, Self::Disturbance, Self::ContactPlate, Self::Editor, Self::Monitor];

    /// Its title.
    pub fn title(self) -> &'static str {
        match self {
            Self::Inspector => "Inspector",
            Self::Plots => "Plots",
            Self::Disturbance => "Push and disturb",
            Self::ContactPlate => "Contact plate",
            Self::Editor => "Key poses",
            Self::Monitor => "Training monitor",
        }
    }

    /// Its name on a command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Inspector => "inspector",
            Self::Plots => "plots",
            Self::Disturbance => "push",
            Self::ContactPlate => "plate",
            Self::Editor => "editor",
            Self::Monitor => "monitor",
        }
    }

    /// The panel of this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|p| p.name() == name)
    }
}

/// Which panels are open, and which athlete they show.
#[derive(Resource, Clone, Debug)]
pub struct AthletePanels {
    /// The athlete; where it is `None` or gone, the first one that there is gets selected.
    pub selected: Option<Entity>,
    /// Panels that are open.
    pub open: Vec<Panel>,
    /// Whether the menu bar is shown.
    pub menu: bool,
}

impl Default for AthletePanels {
    fn default() -> Self {
        Self { selected: None, open: Vec::new(), menu: true }
    }
}

impl AthletePanels {
    /// Whether a panel is open.
    pub fn is_open(&self, panel: Panel) -> bool {
        self.open.contains(&panel)
    }

    /// Opens or closes a panel.
    pub fn set_open(&mut self, panel: Panel, open: bool) {
        match (self.is_open(panel), open) {
            (false, true) => self.open.push(panel),
            (true, false) => self.open.retain(|p| *p != panel),
            _ => {}
        }
    }
}
