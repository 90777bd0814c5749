//! Momentum as somebody sees it who has two pictures of a body and its masses, but no velocity that the simulation holds.
//!
//! The step makes its own momentum exact (`dynamics::momentum::correct_root`), so a comparison of that number with itself
//! proves nothing. Here places and turns of the links are compared.

use bevy_athlete::model::CharacterModel;
use bevy_athlete::sim::{Simulator, link_transforms};
use glam::{DMat3, DQuat, DVec3};

/// Where the links are: centre of mass (world, m) and rotation (link axes to world axes) of each.
pub struct Picture {
    links: Vec<(DVec3, DQuat)>,
    /// Centre of mass of the body, world, m.
    pub center: DVec3,
}

/// Linear momentum, kg m/s, and angular momentum about the centre of mass, kg m^2/s; world axes.
#[derive(Clone, Copy, Debug)]
pub struct SeenMomentum {
    pub linear: DVec3,
    pub angular: DVec3,
}

impl Picture {
    pub fn of(sim: &mut Simulator<f64>) -> Self {
        let model = sim.model().clone();
        let place = |(link, (origin, q)): (usize, (DVec3, DQuat))| (origin + q * model.links[link].com, q);
        let links: Vec<_> = link_transforms(sim, 0).into_iter().enumerate().map(place).collect();
        let center = center(&model, links.iter().map(|(at, _)| *at));
        Self { links, center }
    }

    /// Momentum between this picture and one that was taken `seconds` later, by central differences.
    pub fn momentum(&self, later: &Self, model: &CharacterModel, seconds: f64) -> SeenMomentum {
        let middle = 0.5 * (self.center + later.center);
        let drift = (later.center - self.center) / seconds;
        let mut angular = DVec3::ZERO;
        for ((link, (a, p)), (b, q)) in model.links.iter().zip(&self.links).zip(&later.links) {
            let velocity = (*b - *a) / seconds - drift;
            let turn = DMat3::from_quat(p.slerp(*q, 0.5));
            let way = *q * p.inverse();
            // The short way round.
            let spin = if way.w < 0.0 { -way } else { way }.to_scaled_axis() / seconds;
            angular += (0.5 * (*a + *b) - middle).cross(link.mass * velocity);
            angular += turn * (link.inertia * (turn.transpose() * spin));
        }
        SeenMomentum { linear: model.mass() * drift, angular }
    }
}

fn center(model: &CharacterModel, places: impl Iterator<Item = DVec3>) -> DVec3 {
    model.links.iter().zip(places).map(|(link, at)| link.mass * at).sum::<DVec3>() / model.mass()
}
