//! Contract: from a trace alone anyone can confirm that nothing cheats.
//!
//! The reader below knows the format and mechanics, and nothing of the crate: it reads JSON lines and adds up. For every
//! step the change of the linear momentum, of the angular momentum about the centre of mass and of that about the
//! world's origin must equal gravity plus the listed forces; ordinary friction must lie within its cone; no contact may
//! pull. It must also be able to say no: a trace from a run with a hidden helper force of 5 N is refused.
//!
//! Angular velocity and inertia come from the bodies' quaternions in the file, so a wrong rotation, a wrong inertia
//! order in the header or a contact listed at the wrong place breaks the balance.

use crate::common::*;
use bevy_athlete::contact::World;
use bevy_athlete::math::Vec3;
use bevy_athlete::model::{SharedModel, foot_human, runner, skater};
use bevy_athlete::sim::{ExternalForce, SimulationSettings, Simulator, TraceWriter, step};
use glam::{DMat3, DQuat, DVec3};
use serde_json::Value;

fn vector(v: &Value) -> DVec3 {
    let a = v.as_array().expect("an array of three");
    assert_eq!(a.len(), 3);
    DVec3::new(a[0].as_f64().unwrap(), a[1].as_f64().unwrap(), a[2].as_f64().unwrap())
}

/// Linear momentum, angular momentum about the centre of mass and about the origin, centre of mass, total mass.
struct Sums {
    linear: DVec3,
    about_com: DVec3,
    about_origin: DVec3,
    com: DVec3,
    mass: f64,
}

fn sums(header: &Value, line: &Value) -> Sums {
    let (bodies, places) = (header["bodies"].as_array().unwrap(), line["bodies"].as_array().unwrap());
    assert_eq!(bodies.len(), places.len());
    let (mut mass, mut com, mut linear, mut about_origin) = (0.0, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for (body, at) in bodies.iter().zip(places) {
        let m = body["mass"].as_f64().unwrap();
        let rows: Vec<DVec3> = body["inertia"].as_array().unwrap().iter().map(vector).collect();
        let inertia = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
        let q = at["quat"].as_array().unwrap();
        let [w, x, y, z] = [0, 1, 2, 3].map(|k| q[k].as_f64().unwrap());
        let turn = DMat3::from_quat(DQuat::from_xyzw(x, y, z, w));
        let (p, v, omega) = (vector(&at["com"]), vector(&at["vel"]), vector(&at["omega"]));
        mass += m;
        com += p * m;
        linear += v * m;
        about_origin += p.cross(v * m) + turn * inertia * turn.transpose() * omega;
    }
    com /= mass;
    Sums { linear, about_com: about_origin - com.cross(linear), about_origin, com, mass }
}

/// What the reader finds in a trace. Momentum errors are in units of weight times step (times one metre for angular).
#[derive(Debug, Default)]
struct Findings {
    steps: usize,
    linear: f64,
    about_com: f64,
    about_origin: f64,
    /// Largest friction over normal force at ordinary points.
    friction: f64,
    /// Largest pull of a point or blade, N.
    pull: f64,
    /// Kinds seen.
    points: usize,
    blades: usize,
    externals: usize,
    /// Positions less what the velocities give, m: bodies do not jump.
    jump: f64,
}

fn read(trace: &str) -> Findings {
    let mut lines = trace.lines();
    let header: Value = serde_json::from_str(lines.next().expect("a header")).expect("the header is JSON");
    assert_eq!(header["format"], "athlete-trace-1");
    let (dt, gravity) = (header["dt"].as_f64().unwrap(), vector(&header["gravity"]));
    let mut found = Findings::default();
    let mut before: Option<Sums> = None;
    for line in lines {
        let line: Value = serde_json::from_str(line).expect("a step is JSON");
        let now = sums(&header, &line);
        let Some(last) = before.replace(sums(&header, &line)) else { continue };
        let weight_step = now.mass * gravity.length() * dt;
        let (mut linear, mut about_com, mut about_origin) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        let mut add = |point: DVec3, force: DVec3| {
            linear += force * dt;
            about_com += (point - last.com).cross(force) * dt;
            about_origin += point.cross(force) * dt;
        };
        add(last.com, gravity * now.mass);
        for contact in line["contacts"].as_array().unwrap() {
            let (point, force) = (vector(&contact["point"]), vector(&contact["force"]));
            let normal = vector(&contact["normal"]);
            assert!(contact["body"].as_u64().unwrap() < header["bodies"].as_array().unwrap().len() as u64);
            add(point, force);
            let pressed = force.dot(normal);
            match contact["kind"].as_str().unwrap() {
                "point" => {
                    found.points += 1;
                    found.pull = found.pull.max(-pressed);
                    let aside = (force - normal * pressed).length();
                    // A point that carries next to nothing has no meaningful ratio.
                    if aside > 1e-6 {
                        found.friction = found.friction.max(aside / pressed);
                    }
                }
                "blade" => {
                    found.blades += 1;
                    found.pull = found.pull.max(-pressed);
                }
                "grip" => {}
                other => panic!("unknown kind {other}"),
            }
        }
        for push in line["external"].as_array().unwrap() {
            found.externals += 1;
            add(vector(&push["point"]), vector(&push["force"]));
        }
        found.steps += 1;
        found.linear = found.linear.max((now.linear - last.linear - linear).length() / weight_step);
        found.about_com = found.about_com.max((now.about_com - last.about_com - about_com).length() / weight_step);
        found.about_origin =
            found.about_origin.max((now.about_origin - last.about_origin - about_origin).length() / weight_step);
        found.jump = found.jump.max((now.com - last.com - now.linear / now.mass * dt).length());
    }
    found
}

const ALLOWED: f64 = 1e-6;

impl Findings {
    fn balanced(&self) -> bool {
        self.linear < ALLOWED && self.about_com < ALLOWED && self.about_origin < ALLOWED && self.jump < 1e-9
    }
}

/// Runs and writes a trace; `before_step` may change the simulator, `after_step` sees it.
fn trace(
    model: &SharedModel,
    world: &World,
    velocity: DVec3,
    seconds: f64,
    mut before_step: impl FnMut(&mut Simulator<f64>, usize),
    mut after_step: impl FnMut(&mut Simulator<f64>),
) -> String {
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(model));
    let at = sim.state.root_position.lane(0);
    place(&mut sim, at, DQuat::IDENTITY, velocity, DVec3::ZERO);
    let mut writer = TraceWriter::new(Vec::new(), &sim, 0).unwrap();
    for k in 0..(seconds * model.step_rate) as usize {
        before_step(&mut sim, k);
        step(&mut sim, world);
        writer.record(&mut sim).unwrap();
        after_step(&mut sim);
    }
    String::from_utf8(writer.finish().unwrap()).unwrap()
}

fn report(name: &str, f: &Findings, cone: f64) {
    println!(
        "{name}: {} steps, {} point, {} blade contacts, {} pushes; momentum {:.1e}, about the centre {:.1e}, about the \
         origin {:.1e} (allowed {ALLOWED:.0e} of weight x dt), friction {:.4} of {cone} x normal, pull {:.1e} N (allowed 0), jump {:.1e} m",
        f.steps,
        f.points,
        f.blades,
        f.externals,
        f.linear,
        f.about_com,
        f.about_origin,
        f.friction / cone,
        f.pull,
        f.jump
    );
    assert!(f.balanced());
    assert!(f.friction <= cone * (1.0 + 1e-9));
    assert!(f.pull <= 1e-9);
}

#[test]
fn header_is_as_designed() {
    let text = trace(&skater(), &World::ice(), DVec3::ZERO, 0.01, |_, _| {}, |_| {});
    let first = text.lines().next().unwrap();
    let header: Value = serde_json::from_str(first).unwrap();
    let keys: Vec<&str> = header.as_object().unwrap().keys().map(String::as_str).collect();
    let mut expected = vec!["format", "character", "dt", "gravity", "bodies"];
    expected.sort_unstable();
    let mut sorted = keys.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, expected);
    assert!(first.starts_with("{\"format\":\"athlete-trace-1\",\"character\":\"skater\",\"dt\":"), "order as designed");
    let bodies = header["bodies"].as_array().unwrap();
    assert_eq!(bodies.len(), 18);
    assert_eq!((&bodies[0]["name"], &bodies[0]["parent"]), (&Value::from("pelvis"), &Value::from(-1)));
    for body in bodies {
        let mut keys: Vec<&str> = body.as_object().unwrap().keys().map(String::as_str).collect();
        keys.sort_unstable();
        assert_eq!(keys, ["inertia", "mass", "name", "parent"]);
    }
    let mass: f64 = bodies.iter().map(|b| b["mass"].as_f64().unwrap()).sum();
    assert!((mass - skater().mass()).abs() < 1e-12);
    let line: Value = serde_json::from_str(text.lines().nth(1).unwrap()).unwrap();
    let mut keys: Vec<&str> = line.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    assert_eq!(keys, ["bodies", "contacts", "external", "t"]);
    // 17 significant digits: what is read back is what was there.
    let number = text.lines().nth(1).unwrap().split("\"com\":[").nth(1).unwrap().split(',').next().unwrap();
    let digits = number.split('e').next().unwrap().chars().filter(char::is_ascii_digit).count();
    println!("header and line as designed; {} digits (17)", digits);
    assert_eq!(digits, 17);
}

#[test]
fn skater_stands_glides_and_falls() {
    let (ice, mu) = (World::ice(), 0.02);
    let still = trace(&skater(), &ice, DVec3::ZERO, 0.5, |_, _| {}, |_| {});
    report("skater standing", &read(&still), mu);

    // Gliding on both blades: how deep their ends sink, by the feet's places in the trace and the blades' in the file.
    let gliding = trace(&skater(), &ice, DVec3::NEG_Z * 3.0, 1.0, |_, _| {}, |_| {});
    let f = read(&gliding);
    report("skater gliding", &f, mu);
    let model = skater();
    let (mut deepest, mut highest) = (f64::MIN, f64::MIN);
    for line in gliding.lines().skip(1) {
        let line: Value = serde_json::from_str(line).unwrap();
        for end in model.blades.iter().flat_map(|b| [b.toe, b.heel]) {
            let point = &model.contact_points[end];
            let foot = &line["bodies"][point.link];
            let q = foot["quat"].as_array().unwrap();
            let [w, x, y, z] = [0, 1, 2, 3].map(|k| q[k].as_f64().unwrap());
            let arm = point.position - model.links[point.link].com;
            let height = (vector(&foot["com"]) + DQuat::from_xyzw(x, y, z, w) * arm).y;
            (deepest, highest) = (deepest.max(-height), highest.max(height));
        }
    }
    println!(
        "  blade ends between {:.4} mm in and {:.4} mm above the ice (allowed 5 mm)",
        deepest * 1e3,
        highest * 1e3
    );
    assert!(deepest < 5e-3 && highest < 5e-3 && f.blades > 1000);

    // Loose from the start: it collapses and slides about on all its points.
    let loose = |sim: &mut Simulator<f64>, k: usize| {
        if k == 0 {
            for c in &mut sim.commands {
                (c.kp, c.kd) = (20.0, 2.0);
            }
        }
    };
    let falling = trace(&skater(), &ice, DVec3::new(1.0, 0.0, -2.0), 1.5, loose, |_| {});
    let f = read(&falling);
    report("skater falling", &f, mu);
    assert!(f.points > 500, "it lies on the ice");
}

#[test]
fn foot_human_and_runner_on_ground() {
    let (ground, mu) = (World::ground(), 0.8);
    let standing = trace(&foot_human(), &ground, DVec3::ZERO, 0.5, |_, _| {}, |_| {});
    let f = read(&standing);
    report("foot human standing", &f, mu);
    assert!(f.points > 5000);
    let hop = trace(&runner(), &ground, DVec3::new(2.0, 1.0, -3.0), 0.8, |_, _| {}, |_| {});
    report("runner landing askew", &read(&hop), mu);
}

fn push(force: DVec3) -> ExternalForce<f64> {
    ExternalForce { link: 0, position: Vec3::splat(DVec3::new(0.02, 0.1, -0.03)), force: Vec3::splat(force) }
}

#[test]
fn a_push_is_listed_and_a_hidden_helper_is_found() {
    let ice = World::ice();
    let with = |force: DVec3| {
        let shove = move |sim: &mut Simulator<f64>, k: usize| {
            sim.external.clear();
            if k >= 60 {
                sim.external.push(push(force));
            }
        };
        trace(&skater(), &ice, DVec3::NEG_Z * 2.0, 0.2, shove, |_| {})
    };
    let open = with(DVec3::new(80.0, 20.0, 5.0));
    let f = read(&open);
    report("skater pushed", &f, 0.02);
    assert!(f.externals > 100);

    // The same as a helper: 5 N up, and no word of it in the trace.
    let helped = with(DVec3::Y * 5.0);
    assert!(read(&helped).balanced(), "listed, it is honest");
    let hidden: Vec<String> = helped
        .lines()
        .enumerate()
        .map(|(k, line)| {
            let at = if k == 0 { None } else { line.find("\"external\":") };
            at.map_or_else(|| line.to_string(), |at| format!("{}\"external\":[]}}", &line[..at]))
        })
        .collect();
    let f = read(&hidden.join("\n"));
    println!(
        "hidden 5 N: momentum off by {:.2e} of weight x dt (5 N are {:.2e}; allowed {ALLOWED:.0e}): refused",
        f.linear,
        5.0 / (skater().mass() * 9.81)
    );
    assert!(!f.balanced() && (f.linear * skater().mass() * 9.81 / 5.0 - 1.0).abs() < 1e-3);

    // A contact that is left out is found too.
    let still = trace(&skater(), &ice, DVec3::ZERO, 0.1, |_, _| {}, |_| {});
    let robbed: Vec<String> = still
        .lines()
        .map(|line| match (line.find("\"contacts\":["), line.find("],\"external\"")) {
            (Some(a), Some(b)) => format!("{}{}", &line[..a + 12], &line[b..]),
            _ => line.to_string(),
        })
        .collect();
    assert!(!read(&robbed.join("\n")).balanced());
}
