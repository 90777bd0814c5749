//! Contract: level of detail does what it says and does not show.
//!
//! Athletes go to half rate and stand still by their distance to the nearest viewer; what they do at half rate is still the
//! skill (nobody falls), simulated time stays that of the fixed ticks, and no change of level moves a drawn pose by more
//! than a frame of its movement. A budget degrades the farthest first, says so, and gives everything back.

use crate::engine_support::*;
use bevy::prelude::*;
use bevy_athlete::engine::*;

/// Skaters along +X at these distances from the origin, all stroking, and a viewer at the origin.
fn along(app: &mut App, distances: &[f32]) -> (Vec<Entity>, Entity) {
    let (file, skill) = (skater_file(app), add(app, shipped_skill("stroking")));
    let athletes = distances
        .iter()
        .map(|x| {
            let place = Transform::from_xyz(*x, 0.0, 0.0);
            let lod = AthleteLod { full: 50.0, reduced: 150.0 };
            app.world_mut().spawn((Athlete(file.clone()), place, AthleteController::skill(skill.clone()), lod)).id()
        })
        .collect();
    (athletes, app.world_mut().spawn(AthleteViewer).id())
}

fn detail(app: &App, athlete: Entity) -> AthleteDetail {
    *app.world().get(athlete).unwrap()
}

#[test]
fn distance_decides_and_time_goes_on() {
    let mut app = app();
    let (athletes, viewer) = along(&mut app, &[10.0, 100.0, 300.0]);
    run_ticks(&mut app, 64);
    let levels: Vec<_> = athletes.iter().map(|a| detail(&app, *a)).collect();
    assert_eq!(levels, [AthleteDetail::Full, AthleteDetail::Reduced, AthleteDetail::Frozen]);
    let rate = |app: &App, k: usize| body(app, athletes[k]).simulator().settings().rate;
    assert_eq!((rate(&app, 0), rate(&app, 1)), (1200.0, 600.0));
    assert!((body(&app, athletes[0]).time() - 1.0).abs() < 1e-3);
    assert!((body(&app, athletes[1]).time() - 1.0).abs() < 2e-3);
    assert_eq!(body(&app, athletes[2]).time(), 0.0);
    let report = *app.world().resource::<AthleteLodReport>();
    assert_eq!((report.full, report.reduced, report.frozen, report.degraded), (1, 1, 1, 0));
    // 37 or 38 steps in two ticks become 28 or 29 in all of one full and one reduced skater.
    let steps: f64 = {
        let store = app.world().resource::<bevy::diagnostic::DiagnosticsStore>();
        store.get_measurement(&AthleteDiagnosticsPlugin::STEPS).unwrap().value
    };
    assert!((27.0..=29.0).contains(&steps), "{steps} steps");

    // The viewer walks to the far one: it goes on, the others step back.
    app.world_mut().get_mut::<Transform>(viewer).unwrap().translation.x = 300.0;
    run_ticks(&mut app, 64);
    let levels: Vec<_> = athletes.iter().map(|a| detail(&app, *a)).collect();
    assert_eq!(levels, [AthleteDetail::Frozen, AthleteDetail::Frozen, AthleteDetail::Full]);
    assert!((body(&app, athletes[2]).time() - 1.0).abs() < 2.0 / 64.0);

    // Without a viewer, or without the component, everybody is at full rate.
    app.world_mut().entity_mut(athletes[0]).remove::<AthleteLod>();
    run_ticks(&mut app, 3);
    let time = body(&app, athletes[0]).time();
    run_ticks(&mut app, 3);
    assert!(body(&app, athletes[0]).time() > time);
    app.world_mut().entity_mut(viewer).despawn();
    // Also where no distance is near enough.
    app.world_mut().get_mut::<AthleteLod>(athletes[1]).unwrap().full = -1.0;
    run_ticks(&mut app, 3);
    assert!(athletes[1..].iter().all(|a| detail(&app, *a) == AthleteDetail::Full));
}

#[test]
fn nothing_pops_when_levels_change_and_nobody_falls() {
    let mut app = app();
    let (athletes, viewer) = along(&mut app, &[30.0]);
    let athlete = athletes[0];
    run_ticks(&mut app, 32);
    let (mut largest, mut seen) = (0.0_f64, [0; 3]);
    let mut before = app.world().get::<LinkPoses>(athlete).unwrap().interpolated.clone();
    let mut fastest = 0.0_f64;
    for k in 0..900 {
        // Half seconds near, at middle distance, and now and then too far; not in step with anything.
        let away = match (k / 33) % 5 {
            0 | 2 => 0.0,
            1 | 3 => 90.0,
            _ => 400.0,
        };
        let root = body(&app, athlete).simulator().state.root_position.lane(0);
        app.world_mut().get_mut::<Transform>(viewer).unwrap().translation = root.as_vec3() + Vec3::X * away;
        app.update();
        seen[detail(&app, athlete) as usize] += 1;
        let poses = app.world().get::<LinkPoses>(athlete).unwrap();
        for (a, b) in poses.interpolated.iter().zip(&before) {
            largest = largest.max((a.position - b.position).length());
        }
        // The speed of the fastest link, from the simulation itself.
        let mut now = body_mut(&mut app, athlete);
        let links = now.simulator_mut().kinematics();
        fastest = links.iter().map(|l| l.velocity.linear.lane(0).length()).fold(fastest, f64::max);
        before.clone_from(&app.world().get::<LinkPoses>(athlete).unwrap().interpolated);
        assert_eq!(body(&app, athlete).status(), BodyStatus::Running);
    }
    let frame = 1.0 / 64.0;
    println!(
        "frames by level (frozen, reduced, full): {seen:?}; largest move in a frame {:.1} mm; fastest link {fastest:.2} m/s moves {:.1} mm",
        largest * 1e3,
        fastest * frame * 1e3
    );
    assert!(seen.iter().all(|n| *n > 100));
    // A tick holds up to one step more or less than its time.
    assert!(largest < fastest * (frame + 2.0 / 600.0), "a pop of {largest} m");
    let height = body(&app, athlete).simulator().state.root_position.y;
    assert!(height > 0.6, "it fell: the root is at {height} m");
}

#[test]
fn ten_seconds_at_half_rate_are_still_skating() {
    let mut app = app();
    let (athletes, _) = along(&mut app, &[100.0, 110.0]);
    #[derive(Resource, Default)]
    struct Falls(usize);
    app.init_resource::<Falls>();
    app.add_observer(|_: On<AthleteFell>, mut falls: ResMut<Falls>| falls.0 += 1);
    // Strokes go along -Z: the distance to the viewer stays between 100 and 115 m.
    run_ticks(&mut app, 640);
    assert_eq!(app.world().resource::<Falls>().0, 0);
    for athlete in athletes {
        assert_eq!(detail(&app, athlete), AthleteDetail::Reduced);
        let body = body(&app, athlete);
        let (place, speed) = (body.simulator().state.root_position.lane(0), body.root_velocity().length());
        println!("{:.2} s at 600 Hz: at {place:.2}, {speed:.2} m/s", body.time());
        assert!((body.time() - 10.0).abs() < 0.01 && place.z < -15.0 && speed > 1.5);
    }
}

#[test]
fn a_budget_degrades_the_farthest_first_and_gives_back() {
    let mut app = app();
    let distances: Vec<f32> = (1..=12).map(|k| k as f32 * 3.0).collect();
    let (athletes, _) = along(&mut app, &distances);
    run_ticks(&mut app, 32);
    let report = |app: &App| *app.world().resource::<AthleteLodReport>();
    assert_eq!((report(&app).full, report(&app).degraded), (12, 0));
    let whole = report(&app).milliseconds;
    assert!(whole > 0.0);

    // Nothing fits: everybody stands still.
    app.world_mut().resource_mut::<AthleteBudget>().milliseconds = Some(0.0);
    run_ticks(&mut app, 20);
    assert_eq!((report(&app).frozen, report(&app).degraded), (12, 12));
    assert_eq!(report(&app).milliseconds, 0.0);

    // Room for some, by what steps were measured to take: the nearest.
    for part in [0.3_f32, 0.6] {
        let allowed = whole * part;
        app.world_mut().resource_mut::<AthleteBudget>().milliseconds = Some(allowed);
        run_ticks(&mut app, 48);
        let levels: Vec<_> = athletes.iter().map(|a| detail(&app, *a)).collect();
        println!("{allowed:.3} of {whole:.3} ms: {levels:?}, {:?}", report(&app));
        assert!(levels.windows(2).all(|pair| pair[0] >= pair[1]), "a farther one has more: {levels:?}");
    }

    // Everything fits again.
    app.world_mut().resource_mut::<AthleteBudget>().milliseconds = Some(1e4);
    run_ticks(&mut app, 20);
    assert_eq!((report(&app).full, report(&app).degraded), (12, 0));
    app.world_mut().resource_mut::<AthleteBudget>().milliseconds = None;
    run_ticks(&mut app, 2);
    assert_eq!(report(&app).full, 12);
}
