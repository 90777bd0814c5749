//! Contract: the double Salchow that is shipped, written by hand and simulated, is one.
//!
//! - It glides backwards on the left inside edge, on a curve to the left, and leaves the ice from the left foot.
//! - Both blades are off the ice for at least 0.35 s; between take-off and landing the pelvis turns by at least 1.75 turns,
//!   counter-clockwise seen from above.
//! - Nothing holds or turns it in the air: the centre of mass falls freely, the angular momentum stays what it was.
//! - It lands on the right foot and glides backwards on it for at least 1 s, the left foot behind and off the ice.

use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::model::{CharacterModel, KeyPoses, LinkTransform, ModelPose, skater};
use glam::{DMat3, DQuat, DVec3};
use std::path::PathBuf;

/// A blade with an end below this is on the ice, m: the distance at which the simulation begins to ask about contact.
const ON_ICE: f64 = 0.005;

/// What is looked at, at one time.
struct Moment {
    facing: DVec3,
    /// Heel and toe of the left and the right blade.
    blades: [[DVec3; 2]; 2],
    /// Lean of both blades to their inside edges, degrees.
    leans: [f64; 2],
    places: Vec<LinkTransform>,
    com: DVec3,
}

impl Moment {
    fn of(model: &CharacterModel, pose: &ModelPose) -> Self {
        let mut places: Vec<LinkTransform> = Vec::new();
        pose.link_transforms(model, &mut places);
        let side = |name: &str| model.blades.iter().find(|b| b.name == name).unwrap();
        let blades = ["left", "right"].map(|name| {
            [side(name).heel, side(name).toe].map(|end| {
                let point = &model.contact_points[end];
                places[point.link].position + places[point.link].rotation * point.position
            })
        });
        let leans = ["left", "right"]
            .map(|name| (-(places[side(name).link].rotation * side(name).inside).y).asin().to_degrees());
        let weighed = model.links.iter().zip(&places).map(|(l, at)| (at.position + at.rotation * l.com) * l.mass);
        let com = weighed.sum::<DVec3>() / model.mass();
        let facing = level(pose.root_rotation * DVec3::NEG_Z).normalize();
        Self { facing, blades, leans, places, com }
    }

    fn lowest(&self, side: usize) -> f64 {
        self.blades[side][0].y.min(self.blades[side][1].y)
    }
}

fn level(v: DVec3) -> DVec3 {
    DVec3::new(v.x, 0.0, v.z)
}

/// Signed angle from `a` to `b` about the vertical, counter-clockwise seen from above, rad.
fn turn(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).y.atan2(a.dot(b))
}

/// Angular momentum about the centre of mass between two moments, kg m^2/s.
fn angular_momentum(model: &CharacterModel, a: &Moment, b: &Moment, seconds: f64) -> DVec3 {
    let part = |(i, link): (usize, &bevy_athlete::model::Link)| {
        let place = |m: &Moment| m.places[i].position + m.places[i].rotation * link.com - m.com;
        let (from, to) = (place(a), place(b));
        let turned: DQuat = b.places[i].rotation * a.places[i].rotation.conjugate();
        let omega = turned.to_scaled_axis() / seconds;
        let half = DMat3::from_quat(DQuat::from_scaled_axis(0.5 * seconds * omega) * a.places[i].rotation);
        let inertia = half * link.inertia * half.transpose();
        (0.5 * (from + to)).cross((to - from) / seconds) * link.mass + inertia * omega
    };
    model.links.iter().enumerate().map(part).sum()
}

struct Jump {
    rate: f64,
    moments: Vec<Moment>,
    /// First and last moment in the air.
    flight: (usize, usize),
}

fn jump(clip: &MotionClip) -> Jump {
    let model = skater();
    let poses = clip.to_model(&model).unwrap();
    let moments: Vec<Moment> = poses.poses().iter().map(|p| Moment::of(&model, p)).collect();
    let (mut flight, mut begin) = ((0, 0), None);
    for (k, moment) in moments.iter().enumerate() {
        if moment.lowest(0).min(moment.lowest(1)) < ON_ICE {
            begin = None;
        } else {
            let from = *begin.get_or_insert(k);
            if k - from > flight.1 - flight.0 {
                flight = (from, k);
            }
        }
    }
    Jump { rate: clip.frame_rate, moments, flight }
}

fn path(ending: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join(format!("assets/skills/skating/double_salchow/double_salchow.{ending}"))
}

fn simulated() -> Jump {
    jump(&MotionClip::load(path("clip.ron")).unwrap())
}

/// Air time (s) and turns between take-off and landing.
fn flown(jump: &Jump) -> (f64, f64) {
    let (from, to) = jump.flight;
    let turned: f64 = jump.moments[from..=to].windows(2).map(|m| turn(m[0].facing, m[1].facing)).sum();
    ((to - from) as f64 / jump.rate, turned / core::f64::consts::TAU)
}

#[test]
fn both_blades_are_in_the_air_and_the_body_turns_nearly_twice() {
    let poses = jump(&KeyPoses::load(path("keyposes.ron")).unwrap().to_clip(&skater()).unwrap());
    for (name, jump) in [("key poses", poses), ("simulated", simulated())] {
        // Only whole frames count: the true figures are up to two frames longer.
        let (seconds, turns) = flown(&jump);
        let (from, to) = jump.flight;
        let top = jump.moments[from..=to].iter().map(|m| m.com.y).fold(0.0, f64::max);
        println!("{name}: {seconds:.3} s in the air, {turns:.2} turns, {:.2} m up", top - jump.moments[from].com.y);
        assert!((0.35..0.6).contains(&seconds), "{name}: {seconds} s");
        assert!((1.75..2.25).contains(&turns), "{name}: {turns} turns");
    }
}

#[test]
fn it_takes_off_from_the_left_inside_edge_backwards() {
    let Jump { rate, moments, flight: (from, _) } = simulated();
    let entry = &moments[..from - (0.1 * rate) as usize];
    let way = |k: usize| level(entry[k].com - entry[k - 1].com);
    let curve = turn(way(1), way(entry.len() - 1));
    assert!(curve > 0.15, "the path turns by {curve} rad");
    for (k, moment) in entry.iter().enumerate().skip(1) {
        let along = moment.facing.dot(way(k).normalize());
        assert!(along < -0.6, "at {k}: {along}");
        let speed = way(k).length() * rate;
        assert!((1.5..2.7).contains(&speed), "at {k}: {speed} m/s");
    }
    let inside = entry.iter().filter(|m| m.leans[0] > 5.0).count();
    assert!(inside * 10 > entry.len() * 9, "on the inside edge for {inside} of {} poses", entry.len());
    for (k, moment) in moments[..from].iter().enumerate() {
        assert!(moment.lowest(0) < 0.02, "at {k}: left foot at {} m", moment.lowest(0));
    }
    for moment in &moments[from - (0.1 * rate) as usize..from] {
        assert!(moment.lowest(0) < ON_ICE && moment.lowest(1) > ON_ICE);
    }
}

#[test]
fn nothing_but_gravity_acts_in_the_air() {
    let model = skater();
    let Jump { rate, moments, flight: (from, to) } = simulated();
    let air = &moments[from..=to];
    for m in air.windows(3) {
        let acceleration = (m[2].com - 2.0 * m[1].com + m[0].com) * rate * rate;
        assert!((acceleration + DVec3::Y * 9.81).length() < 0.5, "{acceleration}");
    }
    let spins: Vec<DVec3> = air.windows(2).map(|m| angular_momentum(&model, &m[0], &m[1], 1.0 / rate)).collect();
    let mean = spins.iter().sum::<DVec3>() / spins.len() as f64;
    println!("angular momentum {mean:.2} kg m^2/s");
    assert!(mean.y > 8.0, "{mean}");
    for spin in &spins {
        assert!((*spin - mean).length() < 0.08 * mean.length(), "{spin} against {mean}");
    }
}

#[test]
fn it_lands_on_the_right_foot_and_glides_backwards() {
    let Jump { rate, moments, flight: (_, to) } = simulated();
    let after = &moments[to + 1..];
    let early = &after[..(0.1 * rate) as usize];
    assert!(after[0].lowest(1) < ON_ICE, "right foot at {} m", after[0].lowest(1));
    assert!(early.iter().all(|m| m.lowest(0) > ON_ICE), "the left foot comes down");
    assert!(after.len() as f64 / rate > 1.4, "{} poses", after.len());
    let glide = &after[(0.35 * rate) as usize..];
    assert!(glide.len() as f64 / rate >= 1.0);
    let span = (0.1 * rate) as usize;
    for (k, m) in glide.windows(span + 1).enumerate() {
        let (a, b) = (&m[0], &m[span]);
        let way = level(b.com - a.com);
        let speed = way.length() * rate / span as f64;
        assert!((1.2..2.6).contains(&speed), "at {k}: {speed} m/s");
        let line = level(m[span / 2].blades[1][1] - m[span / 2].blades[1][0]).normalize();
        assert!(line.dot(way.normalize()) < -0.9, "at {k}: the blade points {line}, the way is {way}");
        let behind = (m[0].blades[0][0] - m[0].com).dot(m[0].facing);
        assert!(
            behind < 0.1 && (k < glide.len() / 3 || behind < -0.35),
            "at {k}: the left foot is {behind} m in front"
        );
        assert!(m[0].lowest(0) > 0.02, "at {k}: the left foot is at {} m", m[0].lowest(0));
        assert!(m[0].com.y > 0.6, "at {k}: the centre of mass is at {} m", m[0].com.y);
    }
    let on_ice = glide.iter().filter(|m| m.lowest(1) < ON_ICE).count();
    assert!(on_ice * 20 > glide.len() * 19, "on the ice in {on_ice} of {} poses", glide.len());
}

/// The windows of the key poses are such as an optimisation takes, and its servos are the stiff ones of a jump.
#[test]
fn its_windows_can_be_optimised_with_stiff_servos() {
    use bevy_athlete::contact::World;
    use bevy_athlete::model::preset;
    use bevy_athlete::train::optimize::{OptimizeOptions, Plan, optimize};
    let mut poses = KeyPoses::load(path("keyposes.ron")).unwrap();
    let model = preset("skater").unwrap();
    let plan = Plan::new(&poses, &model).unwrap();
    let options = OptimizeOptions { iterations: Some(0), threads: 1, samcon: None, ..OptimizeOptions::default() };
    let found = optimize(&plan, &World::ice(), "ice", &options, None, |_| true).unwrap();
    assert_eq!(found.control.gains, Some((2000.0, 60.0)));
    poses.optimize.gains = Some((2000.0, -1.0));
    let error = Plan::new(&poses, &model).unwrap_err().to_string();
    assert!(error.contains("gains"), "{error}");
}
