//! What becomes of skills that were learnt on level ground at rest on what a game puts under them: a block, a slope, a platform of Avian that
//! moves. So far a measurement, printed row by row.

use crate::grounds::{Footing, Outcome, Performer, perform_on};
use bevy::math::DVec3;

fn told(what: &str, outcome: &Outcome) {
    println!(
        "{what}: fell {:?}, root {:.2} to {:.2} m above it, way {:.2} m, {:.2} m/s at the end, touching {:.0} %",
        outcome.fell,
        outcome.height.0,
        outcome.height.1,
        outcome.end(),
        outcome.speed,
        100.0 * outcome.touching
    );
}

#[test]
#[ignore = "a measurement"]
fn table() {
    for (skill, speed) in
        [("skating/two_foot_glide", 2.0), ("skating/stroking", 2.5), ("skating/forward_crossover", 3.0)]
    {
        let performer = Performer::new("skater", skill).at(speed);
        for height in [0.0, 0.5] {
            told(&format!("{skill} block {height}"), &perform_on(&performer, Footing::Block { height }, 6.0));
        }
        for degrees in [-5.0, -2.0, 2.0, 5.0] {
            told(&format!("{skill} slope {degrees}"), &perform_on(&performer, Footing::Slope { degrees }, 6.0));
        }
        #[cfg(feature = "avian")]
        for velocity in [DVec3::ZERO, DVec3::X, DVec3::Z, DVec3::NEG_Z, DVec3::new(0.6, 0.0, -0.8)] {
            for carried in [false, true] {
                let footing = Footing::Platform { height: 0.5, velocity, carried };
                told(&format!("{skill} {footing:?}"), &perform_on(&performer, footing, 6.0));
            }
        }
    }
}
