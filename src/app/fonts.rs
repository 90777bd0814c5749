//! The one face of egui's own set of fonts that the panels cannot do without: the page of the demo has to be fetched. Its
//! digits are of one width, so it serves for tables too. What else is in the set are letters for code, and emoji.

use bevy::prelude::*;
use bevy_egui::EguiContext;
use bevy_egui::egui::{FontData, FontDefinitions, FontFamily};
use epaint_default_fonts::UBUNTU_LIGHT;

/// Gives every new egui context its font, before its first pass.
pub(super) fn give_fonts(mut contexts: Query<&mut EguiContext, Added<EguiContext>>) {
    for mut context in &mut contexts {
        let mut fonts = FontDefinitions::empty();
        fonts.font_data.insert("Ubuntu-Light".into(), FontData::from_static(UBUNTU_LIGHT).into());
        for family in [FontFamily::Monospace, FontFamily::Proportional] {
            fonts.families.insert(family, vec!["Ubuntu-Light".into()]);
        }
        context.get_mut().set_fonts(fonts);
    }
}
