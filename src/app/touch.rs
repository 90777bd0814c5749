//! Fingers as a mouse: one finger is the left button, two fingers that part are the wheel. Cameras and tools need to know
//! the mouse alone. The panels see the fingers themselves.

use bevy::input::InputSystems;
use bevy::input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll};
use bevy::input::touch::{Touch, TouchInput};
use bevy::prelude::*;

/// Notches of the wheel for fingers that part to e times their distance.
const NOTCHES: f32 = 8.0;

/// Adds what the fingers do to the state of the mouse.
pub(super) struct TouchPlugin;

impl Plugin for TouchPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PreUpdate, fingers_as_mouse.after(InputSystems));
    }
}

fn fingers_as_mouse(
    touches: Res<Touches>,
    mut inputs: MessageReader<TouchInput>,
    mut buttons: ResMut<ButtonInput<MouseButton>>,
    mut motion: ResMut<AccumulatedMouseMotion>,
    mut scroll: ResMut<AccumulatedMouseScroll>,
    mut holding: Local<bool>,
) {
    // Places stay in `Touches` from frame to frame: without news nothing has moved.
    let news = inputs.read().count() > 0;
    let fingers: Vec<&Touch> = touches.iter().collect();
    let hold = fingers.len() == 1;
    if hold != *holding {
        *holding = hold;
        if hold {
            buttons.press(MouseButton::Left);
        } else {
            buttons.release(MouseButton::Left);
        }
    }
    match fingers[..] {
        [finger] if news => motion.delta += finger.delta(),
        [a, b] if news => {
            let before = a.previous_position().distance(b.previous_position()).max(1.0);
            let now = a.position().distance(b.position()).max(1.0);
            scroll.delta.y += NOTCHES * (now / before).ln();
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::input::InputPlugin;
    use bevy::input::touch::TouchPhase;

    fn app() -> App {
        let mut app = App::new();
        app.add_plugins((InputPlugin, TouchPlugin));
        app
    }

    fn touch(app: &mut App, id: u64, phase: TouchPhase, x: f32, y: f32) {
        let window = Entity::PLACEHOLDER;
        app.world_mut().write_message(TouchInput { phase, position: Vec2::new(x, y), window, force: None, id });
    }

    fn pressed(app: &App) -> bool {
        app.world().resource::<ButtonInput<MouseButton>>().pressed(MouseButton::Left)
    }

    #[test]
    fn one_finger_drags_and_lets_go() {
        let mut app = app();
        touch(&mut app, 1, TouchPhase::Started, 10.0, 10.0);
        app.update();
        assert!(pressed(&app));
        touch(&mut app, 1, TouchPhase::Moved, 25.0, 4.0);
        app.update();
        assert_eq!(app.world().resource::<AccumulatedMouseMotion>().delta, Vec2::new(15.0, -6.0));
        // A finger that rests does not go on dragging.
        app.update();
        assert_eq!(app.world().resource::<AccumulatedMouseMotion>().delta, Vec2::ZERO);
        assert!(pressed(&app));
        touch(&mut app, 1, TouchPhase::Ended, 25.0, 4.0);
        app.update();
        assert!(!pressed(&app));
    }

    #[test]
    fn two_fingers_zoom_by_the_ratio_of_their_distances_and_do_not_drag() {
        let mut app = app();
        touch(&mut app, 1, TouchPhase::Started, 0.0, 0.0);
        touch(&mut app, 2, TouchPhase::Started, 100.0, 0.0);
        app.update();
        assert!(!pressed(&app));
        touch(&mut app, 2, TouchPhase::Moved, 200.0, 0.0);
        app.update();
        let apart = app.world().resource::<AccumulatedMouseScroll>().delta.y;
        touch(&mut app, 2, TouchPhase::Moved, 100.0, 0.0);
        app.update();
        let together = app.world().resource::<AccumulatedMouseScroll>().delta.y;
        assert!(apart > 0.0 && (apart + together).abs() < 1e-4, "there and back again: {apart} and {together}");
        assert_eq!(app.world().resource::<AccumulatedMouseMotion>().delta, Vec2::ZERO);
    }
}
