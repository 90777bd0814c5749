//! Contract: the three-turns that are shipped, as key poses and simulated, are three-turns.
//!
//! - All of it is skated on the left foot: one end of its blade at least is on the ice at all times, both ends before and
//!   after the turn, and the right foot never touches.
//! - The way hardly bends, the speed stays; the skater and the blade turn by half a turn against it.
//! - The turn is on one end of the blade and short; at least half a second of glide comes before it, one second after.
//! - A blade on both ends travels along its line; knees bend forwards only; the blade changes from one edge to the other.
//!
//! A motion with a hop, a second foot put down, or a foot dragged round sideways is no three-turn, though it ends backwards.

use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::model::{CharacterModel, KeyPoses, LinkTransform, skater};
use glam::DVec3;
use std::f64::consts::PI;
use std::path::PathBuf;

/// A blade with both ends below this is on the ice, m: the contact model's own distance.
const ON_ICE: f64 = 0.005;

/// What is looked at, at one time.
struct Moment {
    mass: DVec3,
    /// Level direction in which the skater faces.
    facing: DVec3,
    /// Heel and toe of the left and the right blade.
    blades: [[DVec3; 2]; 2],
    /// Sine of the left blade's lean, positive towards the inside edge.
    lean: f64,
    knees: [f64; 2],
}

impl Moment {
    /// Whether the left blade glides on both its ends.
    fn flat(&self) -> bool {
        self.blades[0].iter().all(|end| end.y < ON_ICE)
    }
    fn line(&self) -> DVec3 {
        let [heel, toe] = self.blades[0];
        level(toe - heel).normalize()
    }
}

struct Turn {
    name: String,
    forwards: bool,
    simulated: bool,
    rate: f64,
    moments: Vec<Moment>,
}

impl Turn {
    /// Velocity of the centre of mass at moment `i`, m/s.
    fn velocity(&self, i: usize) -> DVec3 {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(self.moments.len() - 1));
        level(self.moments[b].mass - self.moments[a].mass) * self.rate / (b - a) as f64
    }
    /// The moment at which the blade is square to the way.
    fn middle(&self) -> usize {
        let along = |i: usize| self.moments[i].line().dot(self.velocity(i).normalize());
        (1..self.moments.len()).find(|&i| along(i) * along(0) < 0.0).unwrap()
    }
}

fn level(v: DVec3) -> DVec3 {
    DVec3::new(v.x, 0.0, v.z)
}

/// Signed angle from `a` to `b` about the vertical, counter-clockwise seen from above, rad.
fn turn(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).y.atan2(a.dot(b))
}

fn moments(model: &CharacterModel, clip: &MotionClip) -> Vec<Moment> {
    let clip = clip.to_model(model).unwrap();
    let mut places: Vec<LinkTransform> = Vec::new();
    let look = |pose: &bevy_athlete::model::ModelPose| {
        pose.link_transforms(model, &mut places);
        let blade = |name| model.blades.iter().find(|b| b.name == name).unwrap();
        let blades = ["left", "right"].map(|name| {
            [blade(name).heel, blade(name).toe].map(|end| {
                let point = &model.contact_points[end];
                places[point.link].position + places[point.link].rotation * point.position
            })
        });
        let left = blade("left");
        let weighed = model.links.iter().zip(&places).map(|(l, at)| (at.position + at.rotation * l.com) * l.mass);
        Moment {
            mass: weighed.sum::<DVec3>() / model.mass(),
            facing: level(pose.root_rotation * DVec3::NEG_Z).normalize(),
            blades,
            lean: -(places[left.link].rotation * left.inside).y,
            knees: ["shin_left", "shin_right"]
                .map(|name| pose.joints[model.link_index(name).unwrap()].to_scaled_axis().x.to_degrees()),
        }
    };
    clip.poses().iter().map(look).collect()
}

fn shipped() -> Vec<Turn> {
    let model = skater();
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets/skills/skating");
    let mut turns = Vec::new();
    for (skill, forwards) in [("forward_three_turn", true), ("backward_three_turn", false)] {
        let path = |ending: &str| folder.join(skill).join(format!("{skill}.{ending}"));
        let poses = KeyPoses::load(path("keyposes.ron")).unwrap().to_clip(&model).unwrap();
        let clip = MotionClip::load(path("clip.ron")).unwrap();
        for (what, simulated, clip) in [("key poses", false, poses), ("simulated", true, clip)] {
            let name = format!("{skill}, {what}");
            let moments = moments(&model, &clip);
            turns.push(Turn { name, forwards, simulated, rate: clip.frame_rate, moments });
        }
    }
    turns
}

#[test]
fn it_is_skated_on_the_left_foot_alone() {
    for Turn { name, simulated, moments, .. } in shipped() {
        let (mut deepest, mut highest, mut free) = (0.0_f64, 0.0_f64, f64::INFINITY);
        for moment in &moments {
            let [left, right] = moment.blades.map(|ends| ends.map(|end| end.y));
            deepest = deepest.min(left[0].min(left[1]));
            highest = highest.max(left[0].min(left[1]));
            free = free.min(right[0].min(right[1]));
        }
        println!("{name}: lower end at {deepest:.4} to {highest:.4} m, free foot at least at {free:.3} m");
        assert!(deepest > -0.002 && highest < 0.002, "{name}: lower end at {deepest} to {highest} m");
        assert!(free > if simulated { 0.04 } else { 0.07 }, "{name}: free foot at {free} m");
    }
}

#[test]
fn it_goes_from_one_direction_to_the_other_and_glides() {
    for skated in shipped() {
        let Turn { name, forwards, rate, moments, .. } = &skated;
        let (middle, last) = (skated.middle(), moments.len() - 1);
        // The turn is from the last moment of even glide before the middle to the first after it.
        let before = (0..middle).rev().find(|&i| moments[i].flat()).unwrap();
        let after = (middle..=last).find(|&i| moments[i].flat()).unwrap();
        let seconds = |a: usize, b: usize| (b - a) as f64 / rate;
        println!(
            "{name}: {:.2} s, turn {:.2} s, glide {:.2} s",
            seconds(0, before),
            seconds(before, after),
            seconds(after, last)
        );
        assert!(seconds(0, before) >= 0.5, "{name}: {} s before the turn", seconds(0, before));
        assert!((0.15..0.45).contains(&seconds(before, after)), "{name}: turns for {} s", seconds(before, after));
        assert!(seconds(after, last) >= 1.0, "{name}: glides for {} s", seconds(after, last));

        let sign = if *forwards { 1.0 } else { -1.0 };
        for (i, moment) in moments.iter().enumerate() {
            let (v, flat) = (skated.velocity(i), moment.flat());
            assert!((1.4..2.6).contains(&v.length()), "{name}: {} m/s", v.length());
            if i + 2 <= before || i >= after + 2 {
                let way = if i <= before { sign } else { -sign };
                let (blade, body) = (moment.line().dot(v) / v.length(), moment.facing.dot(v) / v.length());
                assert!(blade * way > 0.98, "{name}: blade {blade} along the way at {} s", seconds(0, i));
                assert!(body * way > 0.6, "{name}: faces {body} along the way at {} s", seconds(0, i));
            }
            let gliding = i <= before || i >= after;
            assert!(flat || !gliding || higher_end(moment) < 0.012, "{name}: off the flat at {} s", seconds(0, i));
        }
        let bend = turn(skated.velocity(1), skated.velocity(last - 1)).to_degrees();
        assert!((10.0..45.0).contains(&bend), "{name}: the way bends by {bend} degrees");
    }
}

/// Height of the higher end of the left blade, m.
fn higher_end(moment: &Moment) -> f64 {
    moment.blades[0][0].y.max(moment.blades[0][1].y)
}

#[test]
fn skater_and_blade_turn_by_half_a_turn_counter_clockwise() {
    for Turn { name, moments, .. } in shipped() {
        let mut blade = 0.0;
        let mut body = 0.0;
        for pair in moments.windows(2) {
            blade += turn(pair[0].line(), pair[1].line());
            body += turn(pair[0].facing, pair[1].facing);
        }
        let first = level(moments[1].mass - moments[0].mass);
        let last = level(moments[moments.len() - 1].mass - moments[moments.len() - 2].mass);
        for (what, angle) in [("blade", blade), ("body", body)] {
            let relative = angle - turn(first, last);
            println!("{name}: {what} turns by {:.0} degrees against the way", relative.to_degrees());
            assert!((relative - PI).abs() < 0.35, "{name}: {what} turns by {relative} rad");
        }
    }
}

#[test]
fn the_blade_changes_edge_and_does_not_slip() {
    for skated in shipped() {
        let Turn { name, moments, .. } = &skated;
        let middle = skated.middle();
        let (mut slips, mut leans) = (Vec::new(), [Vec::new(), Vec::new()]);
        for (i, around) in moments.windows(3).enumerate() {
            let moment = &around[1];
            if around.iter().all(Moment::flat) {
                let place = |m: &Moment| level(m.blades[0][0] + m.blades[0][1]) / 2.0;
                let slip = turn(moment.line(), place(&around[2]) - place(&around[0])).to_degrees().abs();
                slips.push(slip.min(180.0 - slip));
                leans[usize::from(i > middle)].push(moment.lean.asin().to_degrees());
            }
            for knee in moment.knees {
                assert!((-110.0..-5.0).contains(&knee), "{name}: knee at {knee}");
            }
        }
        slips.sort_by(f64::total_cmp);
        let mean = slips.iter().sum::<f64>() / slips.len() as f64;
        let most = slips[slips.len() * 9 / 10];
        let [before, after] = leans.map(|l| l.iter().sum::<f64>() / l.len() as f64);
        println!("{name}: slip {mean:.2}, nine tenths below {most:.2} degrees; lean {before:.1}, then {after:.1}");
        assert!(mean < 1.0 && most < 3.0, "{name}: slip {mean}, {most} degrees");
        // Curving to the left on the left foot: outside edge forwards, inside edge backwards.
        let sign = if skated.forwards { 1.0 } else { -1.0 };
        assert!(before * sign < -5.0 && after * sign > 5.0, "{name}: lean {before}, then {after} degrees");
    }
}
