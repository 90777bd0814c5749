//! What the contact plate shows: the points of each foot that may touch the ground, what they bear, and what the foot is asked to stand on.
//!
//! After Park, Yu, Lee 2018, "Multi-Segment Foot for Human Modelling and Simulation", Figure 13.

use crate::contact::BladeEdge;
use crate::control::balance::AnkleStance;
use crate::control::foot::FootAnatomy;
use crate::engine::AthleteBody;
use crate::model::{CharacterModel, ContactKind};
use crate::ui::history::side_of;
use glam::{DVec2, DVec3};

/// Points higher than this above the lowest one in the zero pose are no part of a sole, m.
const SOLE: f64 = 0.05;

/// A contact point of a sole.
#[derive(Clone, Debug, PartialEq)]
pub struct PlatePoint {
    /// Name.
    pub name: String,
    /// Where it is on the plate, m: to the right, and ahead; as in the zero pose.
    pub place: DVec2,
    /// Radius, m.
    pub radius: f64,
    /// Force upwards, N; zero when apart.
    pub force: f64,
    /// The segment it is on, as [`FootAnatomy::segments`] counts them; `None` where the foot has none that can be asked to touch.
    pub segment: Option<usize>,
}

/// What can be asked of a foot of segments.
#[derive(Clone, Debug, PartialEq)]
pub struct PlateAnkle {
    /// The foot, by its number in the character.
    pub foot: usize,
    /// Names of its segments.
    pub segments: Vec<String>,
    /// Where the ankle is on the plate, m, in the zero pose.
    pub place: DVec2,
    /// What it is asked while the athlete balances; `None` while it does something else.
    pub asked: Option<AnkleStance>,
}

/// A blade of a sole.
#[derive(Clone, Debug, PartialEq)]
pub struct PlateBlade {
    /// Toe and heel end on the plate, m.
    pub ends: [DVec2; 2],
    /// Force upwards on toe and heel, N.
    pub force: [f64; 2],
    /// Edge.
    pub edge: BladeEdge,
    /// Lean, rad, positive towards the inside edge; `None` off the ice.
    pub lean: Option<f64>,
    /// Direction on the plate towards the inside edge, unit: to the right, and ahead.
    pub inside: DVec2,
}

/// One foot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlateFoot {
    /// Points of the sole.
    pub points: Vec<PlatePoint>,
    /// Its blade.
    pub blade: Option<PlateBlade>,
    /// Its ankle and segments, where it has some.
    pub ankle: Option<PlateAnkle>,
}

impl PlateFoot {
    /// Force upwards, N.
    pub fn force(&self) -> f64 {
        self.loads().map(|(_, force)| force).sum()
    }

    /// Centre of pressure on the plate, m; `None` without load.
    pub fn center_of_pressure(&self) -> Option<DVec2> {
        let force = self.force();
        (force > 1e-6).then(|| self.loads().map(|(place, force)| place * force).sum::<DVec2>() / force)
    }

    fn loads(&self) -> impl Iterator<Item = (DVec2, f64)> + '_ {
        let blade = self.blade.iter().flat_map(|b| [(b.ends[0], b.force[0]), (b.ends[1], b.force[1])]);
        self.points.iter().map(|p| (p.place, p.force)).chain(blade)
    }
}

/// Both feet of an athlete.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlateView {
    /// Left, right.
    pub feet: [PlateFoot; 2],
    /// Weight of the athlete, N.
    pub weight: f64,
}

impl PlateView {
    /// Reads a body at its last step.
    pub fn of(body: &AthleteBody) -> Self {
        let (sim, model) = (body.simulator(), body.model());
        let mut view = Self { weight: model.mass() * sim.settings().gravity.length(), ..Self::default() };
        let places = rest_places(model);
        let lowest =
            model.contact_points.iter().zip(&places).map(|(c, p)| p.1 - c.radius).fold(f64::INFINITY, f64::min);
        let force = |k: usize| sim.contact_force(k, 0).y.max(0.0);
        for (k, point) in model.contact_points.iter().enumerate() {
            let Some(side) = side_of(model, k) else { continue };
            if point.kind == ContactKind::Point && places[k].1 - point.radius < lowest + SOLE {
                let (place, radius) = (places[k].0, point.radius);
                let name = point.name.clone();
                view.feet[side].points.push(PlatePoint { name, place, radius, force: force(k), segment: None });
            }
        }
        view.add_segments(body);
        for (k, blade) in model.blades.iter().enumerate() {
            let Some(side) = side_of(model, blade.toe) else { continue };
            view.feet[side].blade = Some(PlateBlade {
                ends: [places[blade.toe].0, places[blade.heel].0],
                force: [force(blade.toe), force(blade.heel)],
                edge: body.blade_edge(k),
                lean: sim.blade_lean(k, 0).map(|(lean, _)| lean),
                inside: DVec2::new(blade.inside.x, -blade.inside.z).normalize_or_zero(),
            });
        }
        view
    }

    /// Says of each point which segment of its foot it is on.
    fn add_segments(&mut self, body: &AthleteBody) {
        let model = body.model();
        let links = model.rest_positions();
        for (foot, described) in model.feet().iter().enumerate() {
            let Ok(anatomy) = FootAnatomy::of(model, foot) else { continue };
            let Some(side) = side_of(model, described.toe) else { continue };
            let segments = anatomy.segments();
            for point in &mut self.feet[side].points {
                let on = |p: &(DVec3, f64, usize)| model.contact_points[p.2].name == point.name;
                point.segment = segments.iter().position(|s| s.stands && s.points.iter().any(on));
            }
            let at = links[anatomy.ankle()];
            self.feet[side].ankle = Some(PlateAnkle {
                foot,
                segments: segments.iter().map(|s| s.name.clone()).collect(),
                place: DVec2::new(at.x, -at.z),
                asked: body.feet_asked().and_then(|feet| feet.get(foot)).copied(),
            });
        }
    }
}

/// Place on the plate and height of each contact point in the zero pose, m.
fn rest_places(model: &CharacterModel) -> Vec<(DVec2, f64)> {
    let links = model.rest_positions();
    let place = |c: &crate::model::ContactPoint| {
        let at = links[c.link] + c.position;
        (DVec2::new(at.x, -at.z), at.y)
    };
    model.contact_points.iter().map(place).collect()
}

/// Pressure along a blade of length `length` (m) that bears `toe` and `heel` (N) at its ends: where it begins and ends
/// (m from the heel) and how much it is there (N/m). Linear between the two, with the same force and the same centre as
/// the two forces; where that would pull, only a part of the blade presses, in a triangle, at least a fifth of it long.
pub fn blade_pressure(toe: f64, heel: f64, length: f64) -> Option<[(f64, f64); 2]> {
    let force = toe + heel;
    if !(force > 1e-6 && length > 1e-6) {
        return None;
    }
    let center = length * toe / force;
    if (length / 3.0..=length * 2.0 / 3.0).contains(&center) {
        let mean = force / length;
        let tilt = 6.0 * mean * (center / length - 0.5);
        return Some([(0.0, mean - tilt), (length, mean + tilt)]);
    }
    let near = center.min(length - center).max(0.2 * length / 3.0);
    let (reach, peak) = (3.0 * near, 2.0 * force / (3.0 * near));
    Some(if center < 0.5 * length { [(0.0, peak), (reach, 0.0)] } else { [(length - reach, 0.0), (length, peak)] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pressure_along_a_blade_bears_the_forces_of_its_ends() {
        for (toe, heel) in [(300.0, 300.0), (400.0, 250.0), (600.0, 60.0), (80.0, 500.0)] {
            let [(a, p), (b, q)] = blade_pressure(toe, heel, 0.28).unwrap();
            assert!(p >= -1e-9 && q >= -1e-9, "it presses, it does not pull: {p} {q}");
            let force = 0.5 * (p + q) * (b - a);
            assert!((force - toe - heel).abs() < 1e-6, "{force}");
            // Moment about the heel of a linear load: integral of s p(s).
            let moment = (b - a) * (p * (2.0 * a + b) + q * (a + 2.0 * b)) / 6.0;
            assert!((moment - toe * 0.28).abs() < 1e-6, "{moment} {}", toe * 0.28);
        }
        assert!(blade_pressure(0.0, 0.0, 0.28).is_none());
    }

    #[test]
    fn the_pressure_is_the_average_of_the_loaded_points() {
        let point = |x: f64, y: f64, force: f64| PlatePoint {
            name: String::new(),
            place: DVec2::new(x, y),
            radius: 0.01,
            force,
            segment: None,
        };
        let points = vec![point(0.0, 0.0, 100.0), point(0.1, 0.2, 300.0)];
        let foot = PlateFoot { points, ..PlateFoot::default() };
        assert_eq!(foot.force(), 400.0);
        assert!((foot.center_of_pressure().unwrap() - DVec2::new(0.075, 0.15)).length() < 1e-12);
        assert_eq!(PlateFoot::default().center_of_pressure(), None);
    }
}
