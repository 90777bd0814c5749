//! The demo in a page, with options from its address.

use crate::app::{ControlScene, DemoOptions, run_window};
use std::process::ExitCode;
use web_sys::js_sys::Reflect;
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
