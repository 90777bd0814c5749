//! The demo in a page: options from its address, and what it tells the page.
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

use crate::app::pull::PointerPull;
use crate::app::{Act, ControlScene, DemoOptions, run_window};
use crate::engine::{Athlete, AthleteBody, PlaybackSpeed};
use bevy::diagnostic::FrameCount;
use bevy::platform::time::Instant;
use bevy::prelude::*;
use std::process::ExitCode;
use web_sys::js_sys::{Object, Reflect};
use web_sys::wasm_bindgen::{JsValue, throw_str};
use web_sys::{UrlSearchParams, Window};

/// Runs the demo in the page's canvas, with the options of the page's query. What is wrong with them is thrown to the
/// page, which shows it.
pub fn run_in_page() -> ExitCode {
    let begun = web_sys::window().ok_or_else(|| "no window".to_owned()).and_then(|page| {
        let options = DemoOptions::from_query(query(&page)).map_err(|e| e.to_string())?;
        let scene = ControlScene::load(None).map_err(|e| e.to_string())?;
        Ok(run_window(scene, &options))
    });
    begun.unwrap_or_else(|message| throw_str(&message))
}

/// Names and values of the query of the page's address.
fn query(page: &Window) -> Vec<(String, String)> {
    let search = page.location().search().unwrap_or_default();
    let pairs = UrlSearchParams::new_with_str(&search).map(|query| query.entries());
    let text = |pair: &JsValue, index: u32| Reflect::get_u32(pair, index).ok()?.as_string();
    let pairs = pairs.into_iter().flatten().flatten();
    pairs.filter_map(|pair| Some((text(&pair, 0)?, text(&pair, 1)?))).collect()
}

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
