//! Contract: the clock of the athletes slows them down alone.
//!
//! Slow motion shows the same motion: the steps are the same steps, so after as much time of their own the bits are those of full speed, also where the
//! pace was changed on the way, and snapshots go from one pace to another. What is drawn between ticks goes at the slow pace, too.
//! Everything else in the game goes on.

use crate::engine_support::*;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_athlete::engine::*;

fn skating(app: &mut App) -> Entity {
    let (file, skill) = (skater_file(app), add(app, shipped_skill("stroking")));
    app.world_mut().spawn((Athlete(file), AthleteController::skill(skill))).id()
}

fn set_speed(app: &mut App, speed: f32) {
    app.world_mut().resource_mut::<AthleteTime>().set_relative_speed(speed);
}

#[test]
fn slow_motion_is_the_same_motion() {
    let mut fast = app();
    let athlete = skating(&mut fast);
    run_ticks(&mut fast, 65);
    let at_64 = {
        let mut app = app();
        let athlete = skating(&mut app);
        run_ticks(&mut app, 64);
        body(&app, athlete).snapshot()
    };

    // Half as fast, a quarter as fast, stopped, and at last twice as fast: in all 64 ticks' worth.
    let mut app = app();
    let slow = skating(&mut app);
    for (speed, ticks, time) in [(0.5, 64, 32.0), (0.25, 64, 48.0), (2.0, 8, 64.0)] {
        set_speed(&mut app, speed);
        run_ticks(&mut app, ticks);
        assert!((body(&app, slow).time() - time / 64.0).abs() < 1.0 / 1200.0, "{} s", body(&app, slow).time());
        app.world_mut().resource_mut::<AthleteTime>().pause();
        let (print, elapsed) = (body(&app, slow).snapshot(), app.world().resource::<Time<Fixed>>().elapsed());
        run_ticks(&mut app, 5);
        assert!(body(&app, slow).snapshot() == print, "it moved while time stood still");
        assert!(app.world().resource::<Time<Fixed>>().elapsed() > elapsed, "the game goes on");
        app.world_mut().resource_mut::<AthleteTime>().unpause();
    }
    assert!(body(&app, slow).snapshot() == at_64, "another motion in slow motion");
    assert_eq!(app.world().resource::<AthleteTime>().elapsed(), TICK * 64);

    // A snapshot knows nothing of the pace.
    set_speed(&mut app, 1.0);
    body_mut(&mut app, slow).restore(&at_64).unwrap();
    run_ticks(&mut app, 1);
    assert!(body(&app, slow).snapshot() == body(&fast, athlete).snapshot());
}

#[test]
fn what_is_drawn_goes_at_the_slow_pace() {
    // Frames of a quarter of a tick, at a tenth of the pace: the root is drawn on its way, evenly.
    let mut app = app();
    let athlete = skating(&mut app);
    run_ticks(&mut app, 64);
    set_speed(&mut app, 0.1);
    run_ticks(&mut app, 4);
    let frame = TICK / 4;
    app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(frame));
    let shown = |app: &App| app.world().get::<LinkPoses>(athlete).unwrap().interpolated_time;
    let mut times = Vec::new();
    for _ in 0..160 {
        app.update();
        times.push(shown(&app));
    }
    let wanted = frame.as_secs_f64() * 0.1;
    let steps: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
    let worst = steps.iter().map(|s| (s - wanted).abs()).fold(0.0, f64::max);
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    println!("{:.4} ms a frame, wanted {:.4}, at worst {:.4} off", mean * 1e3, wanted * 1e3, worst * 1e3);
    assert!((mean / wanted - 1.0).abs() < 0.02 && steps.iter().all(|s| *s >= -1e-12));
    // No frame is further off than a step of the simulation.
    assert!(worst < 1.0 / 1200.0, "{worst} s");
}

#[test]
fn a_push_lasts_as_long_for_them() {
    let pushed = |speed: f32, ticks: usize| {
        let mut app = app();
        let athlete = skating(&mut app);
        run_ticks(&mut app, 1);
        set_speed(&mut app, speed);
        let force = AthleteForce {
            link: LinkId::ROOT,
            position: DVec3::ZERO,
            force: DVec3::X * 60.0,
            seconds: Some(16.0 / 64.0),
        };
        app.world_mut().get_mut::<AthleteForces>(athlete).unwrap().push(force);
        run_ticks(&mut app, ticks);
        assert!(app.world().get::<AthleteForces>(athlete).unwrap().is_empty(), "{speed}: it acts on");
        (body(&app, athlete).time(), body(&app, athlete).simulator().state.fingerprint(0))
    };
    assert_eq!(pushed(1.0, 32), pushed(0.5, 64));
}

#[test]
fn it_is_a_change_only_where_somebody_changes_it() {
    #[derive(Resource, Default)]
    struct Changes(usize);
    let mut app = app();
    app.init_resource::<Changes>();
    app.add_systems(Update, |time: Res<AthleteTime>, mut changes: ResMut<Changes>| {
        changes.0 += usize::from(time.is_changed() && !time.is_added());
    });
    run_ticks(&mut app, 10);
    let before = app.world().resource::<Changes>().0;
    run_ticks(&mut app, 10);
    assert_eq!(app.world().resource::<Changes>().0, before);
    set_speed(&mut app, 0.5);
    run_ticks(&mut app, 10);
    assert_eq!(app.world().resource::<Changes>().0, before + 1);
}
