//! One step, as a table of contents.

use crate::contact::Terrain;
use crate::math::Real;
use crate::sim::Simulator;

/// Advances every lane by one step of `1 / rate` seconds.
///
/// Never allocates after the first call, never panics, never fails: a lane that goes bad stays bad and leaves the
/// others alone (see [`Simulator::is_sane`]).
pub fn step<R: Real>(sim: &mut Simulator<R>, terrain: &impl Terrain<R>) {
    sim.refresh_kinematics();
    sim.measure_momentum();
    sim.run_servos();
    sim.collect_external_wrenches();
    sim.articulate();
    if sim.detect_contacts(terrain) {
        sim.solve_contacts();
    }
    sim.accelerate();
    sim.integrate();
    sim.restore_momentum();
    sim.advance_clock();
}
