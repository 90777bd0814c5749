//! Prints the fingerprints of the play lanes in the scenes of the determinism test, a line each, after a line that says
//! what this was built for. `scripts/wasm_bits.sh` builds it for several targets and compares.

#[path = "../tests/support/golden.rs"]
mod golden;

use bevy_athlete::control::ReconstructedControl;
use bevy_athlete::math::{F32x8, F64x4, Real};
use bevy_athlete::sim::BuildInfo;

/// The control of the demo's skater: clip sampling and targets count too.
const STROKING: &str = include_str!("../assets/skills/skating/stroking/stroking.control.ron");

fn print<R: Real>(control: &ReconstructedControl) {
    for (name, seconds) in golden::SCENES {
        let hash = golden::thrown::<R>(name, seconds);
        println!("{:<8} {:<34} {hash:016x}", R::NAME, format!("{name}, thrown, {seconds} s"));
    }
    let name = format!("{}, played, {} s", control.clip.name, control.seconds);
    println!("{:<8} {name:<34} {:016x}", R::NAME, golden::played::<R>(control));
}

fn main() -> Result<(), bevy_athlete::control::ControlError> {
    println!("{}", BuildInfo::current());
    let control = ReconstructedControl::from_ron(STROKING, "stroking.control.ron")?;
    print::<f64>(&control);
    print::<F64x4>(&control);
    print::<F32x8>(&control);
    Ok(())
}
