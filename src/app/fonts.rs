//! The two faces of egui's own set of fonts that hold letters; the other half of the set is emoji, which nothing here shows.

use bevy::prelude::*;
use bevy_egui::EguiContext;
use bevy_egui::egui::{FontData, FontDefinitions, FontFamily};
use epaint_default_fonts::{HACK_REGULAR, UBUNTU_LIGHT};

/// Gives every new egui context its fonts, before its first pass.
pub(super) fn give_fonts(mut contexts: Query<&mut EguiContext, Added<EguiContext>>) {
    for mut context in &mut contexts {
        let mut fonts = FontDefinitions::empty();
        for (name, bytes) in [("Hack", HACK_REGULAR), ("Ubuntu-Light", UBUNTU_LIGHT)] {
            fonts.font_data.insert(name.into(), FontData::from_static(bytes).into());
        }
        fonts.families.insert(FontFamily::Monospace, vec!["Hack".into(), "Ubuntu-Light".into()]);
        fonts.families.insert(FontFamily::Proportional, vec!["Ubuntu-Light".into(), "Hack".into()]);
        context.get_mut().set_fonts(fonts);
    }
}
