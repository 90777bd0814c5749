//! Pushes and a changed world: what the panel edits.

use crate::ui::marks::nobody;
use bevy_egui::egui::{self, ComboBox, Grid, Slider};
use glam::{DQuat, DVec3};

/// Gravity on earth, m/s^2.
const EARTH: f64 = 9.81;

/// A push at the centre of mass of a link.
#[derive(Clone, Debug, PartialEq)]
pub struct PushPlan {
    /// Name of the link; one that the character does not have is the root.
    pub link: String,
    /// Where the force points against the athlete's heading, degrees: 0 is forwards, 90 to its left.
    pub azimuth: f64,
    /// Upwards from level, degrees.
    pub elevation: f64,
    /// Force, N.
    pub force: f64,
    /// How long it acts, s.
    pub seconds: f64,
}

impl Default for PushPlan {
    fn default() -> Self {
        Self { link: "spine".into(), azimuth: 90.0, elevation: 0.0, force: 200.0, seconds: 0.1 }
    }
}

impl PushPlan {
    /// The force on an athlete whose root is turned by `root` (root to world), world axes, N.
    pub fn force_on(&self, root: DQuat) -> DVec3 {
        let ahead = (root * DVec3::NEG_Z).with_y(0.0).normalize_or(DVec3::NEG_Z);
        let (up, level) = self.elevation.to_radians().sin_cos();
        let along = DQuat::from_rotation_y(self.azimuth.to_radians()) * ahead;
        (along * level + DVec3::Y * up) * self.force
    }
}

/// Gravity and slope that all athletes feel.
///
/// A slope is gravity turned against the ground, as on a plane tilted by that angle; the ground stays where it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull {
    /// Gravity, m/s^2.
    pub gravity: f64,
    /// Slope, degrees.
    pub slope: f64,
    /// Where downhill is, degrees about the vertical: 0 is along -Z, 90 along -X.
    pub downhill: f64,
}

impl Default for Pull {
    fn default() -> Self {
        Self { gravity: EARTH, slope: 0.0, downhill: 0.0 }
    }
}

impl Pull {
    /// Acceleration of free fall, world axes, m/s^2.
    pub fn acceleration(&self) -> DVec3 {
        let (sin, cos) = self.slope.to_radians().sin_cos();
        let along = DQuat::from_rotation_y(self.downhill.to_radians()) * DVec3::NEG_Z;
        (along * sin - DVec3::Y * cos) * self.gravity
    }
}

/// What the panel holds between frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// The push to give.
    pub push: PushPlan,
    /// Gravity and slope.
    pub pull: Pull,
}

/// What the user asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DisturbanceWish {
    /// Give the push now.
    pub push: bool,
    /// Gravity or slope were changed.
    pub pull: bool,
}

/// Draws the panel. `links` are the names of the selected athlete's links and `friction_scale` its factor on friction;
/// without either nothing is selected and only the world can be changed.
pub fn disturbance(
    ui: &mut egui::Ui,
    state: &mut Disturbance,
    links: &[String],
    friction_scale: Option<&mut f32>,
) -> DisturbanceWish {
    let mut wish = DisturbanceWish::default();
    ui.strong("Push");
    if links.is_empty() {
        nobody(ui);
    } else {
        wish.push = push(ui, &mut state.push, links);
    }
    ui.separator();
    ui.strong("World");
    Grid::new("disturb_world").num_columns(2).spacing([10.0, 4.0]).show(ui, |ui| {
        if let Some(scale) = friction_scale {
            ui.label("friction of the selected");
            let slider = Slider::new(scale, 0.0..=100.0).logarithmic(true).smallest_positive(0.05).suffix(" x");
            ui.add(slider).on_hover_text("factor on every friction coefficient that it feels");
            ui.end_row();
        }
        let before = state.pull;
        ui.label("gravity");
        ui.add(Slider::new(&mut state.pull.gravity, 0.0..=20.0).fixed_decimals(2).suffix(" m/s\u{b2}"));
        ui.end_row();
        ui.label("slope");
        ui.add(Slider::new(&mut state.pull.slope, 0.0..=30.0).fixed_decimals(1).suffix("\u{b0}"))
            .on_hover_text("gravity turned against the ground, which stays as it is drawn");
        ui.end_row();
        ui.label("downhill");
        ui.add(Slider::new(&mut state.pull.downhill, -180.0..=180.0).fixed_decimals(0).suffix("\u{b0}"));
        ui.end_row();
        wish.pull = state.pull != before;
    });
    if ui.button("As on level ground").clicked() {
        wish.pull |= state.pull != Pull::default();
        state.pull = Pull::default();
    }
    wish
}

fn push(ui: &mut egui::Ui, plan: &mut PushPlan, links: &[String]) -> bool {
    if !links.contains(&plan.link) {
        plan.link.clone_from(&links[0]);
    }
    Grid::new("disturb_push").num_columns(2).spacing([10.0, 4.0]).show(ui, |ui| {
        ui.label("link");
        ComboBox::from_id_salt("push_link").selected_text(&plan.link).show_ui(ui, |ui| {
            for link in links {
                ui.selectable_value(&mut plan.link, link.clone(), link);
            }
        });
        ui.end_row();
        ui.label("direction");
        ui.add(Slider::new(&mut plan.azimuth, -180.0..=180.0).fixed_decimals(0).suffix("\u{b0}"))
            .on_hover_text("0 is forwards, 90 to its left");
        ui.end_row();
        ui.label("upwards");
        ui.add(Slider::new(&mut plan.elevation, -90.0..=90.0).fixed_decimals(0).suffix("\u{b0}"));
        ui.end_row();
        ui.label("size");
        ui.add(Slider::new(&mut plan.force, 0.0..=2000.0).fixed_decimals(0).suffix(" N"));
        ui.end_row();
        ui.label("duration");
        ui.add(Slider::new(&mut plan.seconds, 0.01..=2.0).logarithmic(true).fixed_decimals(2).suffix(" s"));
        ui.end_row();
    });
    ui.horizontal(|ui| {
        for (name, azimuth) in [("forwards", 0.0), ("left", 90.0), ("back", 180.0), ("right", -90.0)] {
            if ui.small_button(name).clicked() {
                plan.azimuth = azimuth;
            }
        }
    });
    let impulse = plan.force * plan.seconds;
    ui.horizontal(|ui| {
        let clicked = ui.button("Push").clicked();
        ui.weak(format!("{impulse:.1} N s"));
        clicked
    })
    .inner
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_push_points_where_the_athlete_says() {
        let plan = PushPlan { azimuth: 0.0, force: 100.0, ..PushPlan::default() };
        assert!((plan.force_on(DQuat::IDENTITY) - DVec3::NEG_Z * 100.0).length() < 1e-9);
        let left = PushPlan { azimuth: 90.0, ..plan.clone() };
        assert!((left.force_on(DQuat::IDENTITY) - DVec3::NEG_X * 100.0).length() < 1e-9);
        // It turns with the heading, not with the lean, and keeps its size.
        let turned = DQuat::from_rotation_y(1.1) * DQuat::from_rotation_x(0.4);
        let force = PushPlan { elevation: 30.0, ..plan }.force_on(turned);
        assert!((force.length() - 100.0).abs() < 1e-9);
        assert!((force.y - 50.0).abs() < 1e-9);
        let along = DQuat::from_rotation_y(1.1) * DVec3::NEG_Z;
        assert!(force.with_y(0.0).normalize().dot(along) > 1.0 - 1e-9);
    }

    #[test]
    fn a_slope_keeps_the_size_of_gravity_and_pulls_downhill() {
        assert_eq!(Pull::default().acceleration(), DVec3::new(-0.0, -EARTH, -0.0));
        let pull = Pull { slope: 10.0, downhill: 90.0, ..Pull::default() }.acceleration();
        assert!((pull.length() - EARTH).abs() < 1e-9);
        assert!((pull.x + EARTH * 10_f64.to_radians().sin()).abs() < 1e-9, "{pull}");
        assert!(pull.z.abs() < 1e-9);
    }
}
