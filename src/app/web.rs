//! What the demo tells the page it is in.
//!
//! Once per frame `window.athlete` becomes an object with
//!
//! | field | meaning |
//! | --- | --- |
//! | `frame` | frames drawn so far |
//! | `bodies` | athletes that are simulated |
//! | `time` | simulated time since the first of them began, s |
//! | `simulated` | time that the fixed ticks covered, s |
//! | `spent` | wall time that they took, s |
//! | `paused` | time stands still |
//! | `steered` | the skater goes where the player points |
//! | `pull` | force of the pull at a limb, N |
//!
//! `bodies * simulated / spent` is the number of such athletes that one thread holds in real time.

use crate::app::Act;
use crate::app::pull::PointerPull;
use crate::engine::{Athlete, AthleteBody, PlaybackSpeed};
use bevy::diagnostic::FrameCount;
use bevy::platform::time::Instant;
use bevy::prelude::*;
use web_sys::js_sys::{Object, Reflect};
use web_sys::wasm_bindgen::JsValue;

/// Tells the page what happens.
pub(super) struct PagePlugin;

impl Plugin for PagePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Ticks>()
            .add_systems(FixedFirst, begin_tick)
            .add_systems(FixedLast, end_tick)
            .add_systems(Last, tell_page);
    }
}

/// What the fixed ticks covered and took.
#[derive(Resource, Default)]
struct Ticks {
    begun: Option<Instant>,
    simulated: f64,
    spent: f64,
}

fn begin_tick(mut ticks: ResMut<Ticks>) {
    ticks.begun = Some(Instant::now());
}

fn end_tick(mut ticks: ResMut<Ticks>, time: Res<Time>) {
    let Some(begun) = ticks.begun.take() else { return };
    ticks.spent += begun.elapsed().as_secs_f64();
    ticks.simulated += time.delta_secs_f64();
}

fn tell_page(
    frames: Res<FrameCount>,
    ticks: Res<Ticks>,
    playback: Res<PlaybackSpeed>,
    act: Res<Act>,
    pull: Res<PointerPull>,
    athletes: Query<&AthleteBody, With<Athlete>>,
) {
    let Some(page) = web_sys::window() else { return };
    let told = Object::new();
    for (name, value) in [
        ("frame", JsValue::from(frames.0)),
        ("bodies", JsValue::from(athletes.iter().count() as u32)),
        ("time", JsValue::from(athletes.iter().next().map_or(0.0, AthleteBody::time))),
        ("simulated", JsValue::from(ticks.simulated)),
        ("spent", JsValue::from(ticks.spent)),
        ("paused", JsValue::from(playback.paused)),
        ("steered", JsValue::from(*act == Act::Steer)),
        ("pull", JsValue::from(pull.force)),
    ] {
        // A new object of our own takes every field.
        let _ = Reflect::set(&told, &name.into(), &value);
    }
    let _ = Reflect::set(&page, &"athlete".into(), &told);
}
