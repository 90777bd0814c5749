//! The panels without a window: egui runs headless.
//!
//! What is proven: every panel draws real data and an empty selection, and shows the numbers it was given; a click on a button
//! acts; a push gives the body the momentum that was asked for, to rounding, and leaves nothing behind; the sampler's rings
//! do not grow without bound; bad files give a line in the panel.

use bevy::ecs::schedule::{LogLevel, ScheduleBuildSettings};
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_athlete::contact::World as Surroundings;
use bevy_athlete::engine::*;
use bevy_athlete::ui::editor::{PoseDocument, PoseEditor, PoseField, pose_editor};
use bevy_athlete::ui::*;
use bevy_egui::egui::{self, Event, Modifiers, PointerButton, Pos2, RawInput, Rect, Shape, vec2};
use std::time::Duration;

/// Length of a fixed tick at Bevy's 64 Hz.
const TICK: Duration = Duration::from_micros(15_625);

/// A screen for panels, and what was drawn on it last.
struct Screen {
    ctx: egui::Context,
    texts: Vec<(String, Rect)>,
    time: f64,
}

impl Screen {
    fn new() -> Self {
        Self { ctx: egui::Context::default(), texts: Vec::new(), time: 0.0 }
    }

    fn frame(&mut self, events: Vec<Event>, panel: &mut dyn FnMut(&mut egui::Ui)) {
        self.time += 0.05;
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(900.0, 4000.0))),
            time: Some(self.time),
            events,
            ..RawInput::default()
        };
        let mut output = self.ctx.run_ui(input, |ui| panel(ui));
        // No renderer takes them.
        output.textures_delta.clear();
        self.texts.clear();
        for clipped in &output.shapes {
            collect(&clipped.shape, &mut self.texts);
        }
    }

    /// Draws twice: the first frame measures.
    fn draw(&mut self, panel: &mut dyn FnMut(&mut egui::Ui)) {
        self.frame(vec![], panel);
        self.frame(vec![], panel);
    }

    fn place(&self, text: &str) -> Rect {
        let found = self.texts.iter().find(|(t, _)| t.trim() == text);
        found.unwrap_or_else(|| panic!("no `{text}` on the screen: {:?}", self.texts)).1
    }

    fn shows(&self, text: &str) -> bool {
        self.texts.iter().any(|(t, _)| t.contains(text))
    }

    /// Moves to the text, presses, lets go.
    fn click(&mut self, text: &str, panel: &mut dyn FnMut(&mut egui::Ui)) {
        let at = self.place(text).center();
        self.drag(at, at, panel);
    }

    fn drag(&mut self, from: Pos2, to: Pos2, panel: &mut dyn FnMut(&mut egui::Ui)) {
        let button = |pos: Pos2, pressed: bool| Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        self.frame(vec![Event::PointerMoved(from)], panel);
        self.frame(vec![button(from, true)], panel);
        for k in 1..=4 {
            self.frame(vec![Event::PointerMoved(from + (to - from) * (k as f32 / 4.0))], panel);
        }
        self.frame(vec![button(to, false)], panel);
        self.frame(vec![], panel);
    }
}

fn collect(shape: &Shape, texts: &mut Vec<(String, Rect)>) {
    match shape {
        Shape::Text(text) => {
            texts.push((text.galley.text().to_owned(), text.galley.rect.translate(text.pos.to_vec2())));
        }
        Shape::Vec(shapes) => shapes.iter().for_each(|s| collect(s, texts)),
        _ => {}
    }
}

/// A headless app with the panels' systems, and an athlete in it.
fn app(spawn: impl FnOnce(&mut App) -> Entity) -> (App, Entity) {
    let mut app = App::new();
    let assets = AssetPlugin { file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/assets").into(), ..default() };
    app.add_plugins((MinimalPlugins, assets, AthletePlugins, AthletePanelsPlugin));
    app.insert_resource(AthleteWorld::ice());
    app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK));
    // The panels' systems have a fixed order among those of the athletes.
    app.edit_schedule(FixedPostUpdate, |schedule| {
        schedule
            .set_build_settings(ScheduleBuildSettings { ambiguity_detection: LogLevel::Error, ..Default::default() });
    });
    app.finish();
    app.cleanup();
    app.update();
    let athlete = spawn(&mut app);
    for _ in 0..2000 {
        app.update();
        if app.world().get::<AthleteBody>(athlete).is_some_and(|b| b.time() > 0.2) {
            return (app, athlete);
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    panic!("the athlete's files do not arrive");
}

fn standing(character: &'static str) -> (App, Entity) {
    app(|app| {
        let file = format!("embedded://bevy_athlete/{character}.character.ron");
        let handle = app.world().resource::<AssetServer>().load(file);
        app.world_mut().spawn(Athlete(handle)).id()
    })
}

/// A skater that strokes by its policy.
fn stroking() -> (App, Entity) {
    app(|app| {
        let server = app.world().resource::<AssetServer>();
        let character = server.load("embedded://bevy_athlete/skater.character.ron");
        let skill = server.load("skills/skating/stroking/stroking.skill.ron");
        app.world_mut().spawn((Athlete(character), AthleteController::skill(skill))).id()
    })
}

fn parts(app: &App, athlete: Entity) -> (AthleteBody, LinkPoses) {
    let world = app.world();
    (world.get::<AthleteBody>(athlete).unwrap().clone(), world.get::<LinkPoses>(athlete).unwrap().clone())
}

#[test]
fn the_inspector_shows_links_joints_contacts_blades_and_the_policy() {
    let (app, athlete) = stroking();
    let (body, poses) = parts(&app, athlete);
    let view = InspectorView::of(&body, &poses);
    assert_eq!(view.links.len(), body.model().links.len());
    assert_eq!(view.joints.len(), view.links.len() - 1);
    assert_eq!(view.blades.len(), 2);
    let phase = view.phase.unwrap();
    assert!((0.0..=1.0).contains(&phase));
    let policy = view.policy.as_ref().unwrap();
    assert_eq!(policy.skill, "stroking");
    let contract = body.skill_player().unwrap().skill().policy.contract();
    let seen: usize = policy.inputs.iter().map(|b| b.values.len()).sum();
    assert_eq!(seen, contract.observation_size());
    assert_eq!(3 * policy.outputs.len(), contract.action_size());
    assert!(policy.outputs.iter().any(|(_, a)| a.iter().any(|v| *v != 0.0)));
    // Newton: what stands on the ice bears about its weight, and the view has the forces of the simulator.
    let up: f64 = view.contacts.iter().map(|c| c.force.y).sum();
    let blades: f64 = view.blades.iter().flat_map(|b| b.force).sum();
    assert!(up > 50.0 && (blades - view.contacts.iter().map(|c| c.force.length()).sum::<f64>()).abs() < 1e-9, "{up}");

    let mut screen = Screen::new();
    screen.draw(&mut |ui| inspector(ui, Some(&view)));
    for text in ["skater", "Blades (2)", "shin_left", "Policy of stroking", "thigh_right"] {
        assert!(screen.shows(text), "{text}");
    }
    screen.click("Policy of stroking", &mut |ui| inspector(ui, Some(&view)));
    screen.frame(vec![], &mut |ui| inspector(ui, Some(&view)));
    screen.draw(&mut |ui| inspector(ui, Some(&view)));
    assert!(screen.shows("Outputs") && screen.shows("Inputs"));
    screen.draw(&mut |ui| inspector(ui, None));
    assert!(screen.shows("no athlete"));
}

#[test]
fn the_plugin_samples_the_selected_athlete_and_the_plots_draw_it() {
    let (mut app, athlete) = standing("skater");
    for _ in 0..64 {
        app.update();
    }
    assert_eq!(app.world().resource::<AthletePanels>().selected, Some(athlete));
    let history = app.world().resource::<SelectedHistory>().history.clone();
    let samples: Vec<Sample> = history.samples().copied().collect();
    assert!(samples.len() >= 64, "{}", samples.len());
    let last = samples[samples.len() - 1];
    let model = app.world().get::<AthleteBody>(athlete).unwrap().model().clone();
    // At rest on both feet: its weight, half on each side.
    let weight = model.mass() * 9.81;
    assert!((last.force[0] + last.force[1] - weight).abs() < 0.05 * weight, "{:?} {weight}", last.force);
    assert!((0.7..1.2).contains(&last.mass_height) && last.speed < 0.05);
    assert!(last.lean[0].abs() < 0.02 && last.step_micros > 0.0, "{last:?}");
    let mut screen = Screen::new();
    screen.draw(&mut |ui| plots(ui, &history));
    for text in ["speed, m/s", "lean, degrees", "cost of a step, microseconds"] {
        assert!(screen.shows(text), "{text}");
    }
    screen.draw(&mut |ui| plots(ui, &History::default()));
    assert!(screen.shows("nothing has been sampled"));
    // A minute more: the ring holds its seconds, not more.
    for _ in 0..64 * 60 {
        app.update();
    }
    let history = &app.world().resource::<SelectedHistory>().history;
    let (first, last) = (history.samples().next().unwrap().time, history.samples().last().unwrap().time);
    assert!(last - first <= history.seconds() && history.samples().len() <= History::CAPACITY);
    // One that is gone leaves nothing selected.
    app.world_mut().despawn(athlete);
    app.update();
    app.update();
    assert_eq!(app.world().resource::<AthletePanels>().selected, None);
    assert_eq!(app.world().resource::<SelectedHistory>().history.samples().len(), 0);
}

#[test]
fn a_push_gives_the_momentum_that_was_asked_for_and_leaves_nothing_behind() {
    let (mut app, athlete) = standing("skater");
    app.insert_resource(AthleteWorld(Surroundings::empty()));
    let pull = Pull { gravity: 0.0, ..Pull::default() };
    app.world_mut().resource_mut::<WorldPull>().set(&pull);
    app.update();
    let momentum = |app: &mut App| {
        let mut body = app.world_mut().get_mut::<AthleteBody>(athlete).unwrap();
        body.simulator_mut().total_momentum().linear.lane(0)
    };
    let before = momentum(&mut app);
    let plan = PushPlan { link: "spine".into(), azimuth: 90.0, elevation: 30.0, force: 160.0, seconds: 0.125 };
    let body = app.world().get::<AthleteBody>(athlete).unwrap().clone();
    let force = plan.force_on(body.simulator().state.root_rotation.lane(0));
    let push = plan.on(&body).unwrap();
    app.world_mut().get_mut::<AthleteForces>(athlete).unwrap().push(push);
    for _ in 0..20 {
        app.update();
        assert!(app.world().get::<AthleteBody>(athlete).unwrap().simulator().external.is_empty());
    }
    let gained = momentum(&mut app) - before;
    // 0.125 s is eight ticks of 150 steps in all: exactly so many whole steps, one more or less at an end.
    assert!((gained - force * 0.125).length() < force.length() * 1.01 / 1200.0, "{gained} {}", force * 0.125);
    assert_eq!(app.world().get::<AthleteForces>(athlete).unwrap().len(), 0);
    let settings = app.world().get::<AthleteBody>(athlete).unwrap().simulator().settings().gravity;
    assert_eq!(settings, DVec3::ZERO);
}

#[test]
fn the_push_button_pushes_and_sliders_change_the_world() {
    let links = vec!["pelvis".to_owned(), "spine".to_owned()];
    let (mut state, mut friction, mut wishes) = (Disturbance::default(), 1.0_f32, Vec::new());
    let mut screen = Screen::new();
    let mut panel = |ui: &mut egui::Ui| {
        let wish = disturbance(ui, &mut state, &links, Some(&mut friction));
        if wish != DisturbanceWish::default() {
            wishes.push(wish);
        }
    };
    screen.draw(&mut panel);
    screen.click("back", &mut panel);
    // The headline has the same word and is no button.
    screen.click("Push", &mut panel);
    let button = screen.texts.iter().rfind(|(t, _)| t == "Push").unwrap().1.center();
    screen.drag(button, button, &mut panel);
    let at = Pos2::new(screen.place("link").right() + 150.0, screen.place("slope").center().y);
    screen.drag(at, at, &mut panel);
    assert_eq!(state.push.azimuth, 180.0);
    assert_eq!(wishes[0], DisturbanceWish { push: true, pull: false });
    assert!(wishes[1..].iter().any(|w| w.pull) && state.pull.slope > 0.0, "{wishes:?} {state:?}");
    screen.draw(&mut |ui| {
        disturbance(ui, &mut Disturbance::default(), &[], None);
    });
    assert!(screen.shows("no athlete") && screen.shows("gravity"));
}

#[test]
fn the_contact_plate_bears_what_the_feet_bear() {
    for character in ["skater", "foot_human"] {
        let (mut app, athlete) = standing(character);
        for _ in 0..32 {
            app.update();
        }
        let (body, _) = parts(&app, athlete);
        let view = PlateView::of(&body);
        let borne: f64 = view.feet.iter().map(PlateFoot::force).sum();
        assert!((borne - view.weight).abs() < 0.3 * view.weight, "{character}: {borne} of {}", view.weight);
        for (foot, side) in view.feet.iter().zip([-1.0, 1.0]) {
            assert!(foot.points.iter().all(|p| p.place.x * side > 0.0), "{character}");
            assert!(foot.center_of_pressure().unwrap().x * side > 0.0);
        }
        assert_eq!(view.feet[0].blade.is_some(), character == "skater");
        assert!(character == "skater" || view.feet[0].points.len() >= 5);
        let mut screen = Screen::new();
        screen.draw(&mut |ui| assert_eq!(contact_plate(ui, Some(&view), None), None));
        assert!(screen.shows("left") && screen.shows("right"));
        screen.draw(&mut |ui| assert_eq!(contact_plate(ui, None, None), None));
        assert!(screen.shows("no athlete"));
    }
}

/// Every segment that can stand can be clicked, on its own foot, and the ankles dragged; an athlete that does not balance is only looked at.
#[test]
fn the_contact_plate_asks_what_is_clicked_and_dragged() {
    let (mut app, athlete) = standing("foot_human");
    let at_rest = PlateView::of(&parts(&app, athlete).0);
    *app.world_mut().get_mut::<AthleteController>(athlete).unwrap() = AthleteController::Balance(BalancePose::Rest);
    app.world_mut().insert_resource(AthletePanels { open: vec![Panel::ContactPlate], ..default() });
    for _ in 0..64 {
        app.update();
    }
    let body = parts(&app, athlete).0;
    let view = PlateView::of(&body);
    let path = app.world().resource::<SelectedHistory>().path.clone();
    let now = |foot: usize| path.runs(foot).pop().unwrap().pop().unwrap().place;
    for (foot, own) in view.feet.iter().enumerate() {
        assert!(now(foot).distance(own.center_of_pressure().unwrap()) < 1e-12, "the path ends at the cross");
        let grid = PressureGrid::of(own, 0.004).unwrap();
        assert!((grid.force() - own.force()).abs() < 1e-6 * own.force());
    }

    // Clicks all over the plate.
    let mut screen = Screen::new();
    screen.draw(&mut |ui| assert_eq!(contact_plate(ui, Some(&view), Some(&path)), None));
    let below = screen.texts.iter().find(|(text, _)| text.starts_with("seen from above")).unwrap().1.top();
    // Both soles lie in the middles of their columns.
    let row = move |j: i32| (-4..=4).flat_map(move |i| [225, 675].map(|middle| (middle + 16 * i, j)));
    let places = || (1..16).flat_map(row).map(|(x, j)| Pos2::new(x as f32, below - 16.0 * j as f32));
    let clicks = |view: &PlateView, screen: &mut Screen| {
        let mut done = Vec::new();
        for at in places() {
            screen.drag(at, at, &mut |ui| done.extend(contact_plate(ui, Some(view), None)));
        }
        done
    };
    assert!(clicks(&at_rest, &mut screen).is_empty(), "nobody balances");
    let mut asked = std::collections::BTreeSet::new();
    let mut rise = 0.0;
    for action in clicks(&view, &mut screen) {
        match action {
            PlateAction::Segment { foot, segment } => {
                asked.insert((foot, segment));
            }
            other => panic!("{other:?}: a click is no drag"),
        }
    }
    let all: std::collections::BTreeSet<_> = (0..2)
        .flat_map(|foot| {
            let touch = body.feet_asked().unwrap()[foot].touch;
            touch.iter().map(move |segment| (foot, segment)).collect::<Vec<_>>()
        })
        .collect();
    assert_eq!(asked, all);

    // Drags of both ankles by 40 points upwards.
    for at in places() {
        screen.drag(at, at - vec2(0.0, 40.0), &mut |ui| {
            if let Some(PlateAction::Ankle { rise: by, .. }) = contact_plate(ui, Some(&view), None) {
                rise += by;
            }
        });
    }
    println!("drags raised ankles by {rise} m in all");
    assert!(rise > 0.05, "{rise} m");

    // What was clicked can be stood on.
    let heel = PlateAction::Segment { foot: 0, segment: 4 }.on(body.feet_asked().unwrap()).unwrap();
    assert!(BalancePose::Feet(heel).stance(body.model()).is_ok());
    assert!(!heel[0].touch.contains(4));
}

#[test]
fn the_menu_opens_panels() {
    let mut panels = AthletePanels::default();
    let athletes = [(Entity::from_raw_u32(1).unwrap(), "one".to_owned())];
    let mut screen = Screen::new();
    let mut menu = |ui: &mut egui::Ui| panel_menu(ui, &mut panels, &athletes);
    screen.draw(&mut menu);
    screen.click("Panels", &mut menu);
    screen.frame(vec![], &mut menu);
    screen.click("Plots", &mut menu);
    assert!(panels.is_open(Panel::Plots));
    assert_eq!(Panel::of_name("plate"), Some(Panel::ContactPlate));
}

const POSES: &str = include_str!("../../assets/skills/skating/stroking/stroking.keyposes.ron");

#[test]
fn the_editor_copies_undoes_and_slides() {
    let mut editor = PoseEditor::default();
    let mut screen = Screen::new();
    screen.draw(&mut |ui| pose_editor(ui, &mut editor));
    assert!(screen.shows("open a .keyposes.ron file"));
    editor.edit(PoseDocument::from_text(POSES.into(), "stroking.keyposes.ron").unwrap());
    screen.draw(&mut |ui| pose_editor(ui, &mut editor));
    for text in ["Simulate", "Train", "thigh_left", "touches: "] {
        assert!(screen.shows(text), "{text}");
    }
    screen.click("copy", &mut |ui| pose_editor(ui, &mut editor));
    assert_eq!(editor.document().unwrap().poses().poses.len(), 5);
    screen.click("Undo", &mut |ui| pose_editor(ui, &mut editor));
    assert_eq!(editor.document().unwrap().text(), POSES);
    screen.click("Redo", &mut |ui| pose_editor(ui, &mut editor));
    assert_eq!(editor.document().unwrap().poses().poses.len(), 5);
    screen.click("Undo", &mut |ui| pose_editor(ui, &mut editor));
    // A drag of a slider of the root: one step of the history.
    let label = screen.place("x: bend back");
    let rail = Pos2::new(label.right() + 30.0, label.center().y);
    screen.drag(rail, rail + vec2(30.0, 0.0), &mut |ui| pose_editor(ui, &mut editor));
    let bent = editor.document().unwrap().value(0, &PoseField::Root(0)).unwrap();
    assert!((bent + 12.0).abs() > 1.0, "{bent}");
    screen.click("Undo", &mut |ui| pose_editor(ui, &mut editor));
    assert_eq!(editor.document().unwrap().text(), POSES);
    assert!(!editor.document().unwrap().can_undo());
    screen.click("Simulate", &mut |ui| pose_editor(ui, &mut editor));
    assert!(editor.simulating().is_some());
    screen.draw(&mut |ui| pose_editor(ui, &mut editor));
    screen.click("Cancel", &mut |ui| pose_editor(ui, &mut editor));
    assert!(editor.simulating().unwrap().0.is_cancelled());
}

#[test]
fn the_monitor_draws_a_curve_and_tells_of_bad_files() {
    let file = std::env::temp_dir().join(format!("bevy_athlete_panel_{}.csv", std::process::id()));
    std::fs::write(&file, "iteration,seconds,reward,survival\n1,1,0.25,\n2,2,0.5,0.75\n").unwrap();
    let mut monitor = TrainingMonitor::of(file.display().to_string());
    let mut screen = Screen::new();
    screen.draw(&mut |ui| training_monitor(ui, &mut monitor));
    assert!(screen.shows("2 iterations") && screen.shows("0.750"));
    std::fs::write(&file, "iteration,seconds,reward,survival\n1,1\n").unwrap();
    for _ in 0..40 {
        screen.frame(vec![], &mut |ui| training_monitor(ui, &mut monitor));
    }
    assert!(screen.shows("line 2: 2 cells"));
    std::fs::remove_file(file).unwrap();
    let mut monitor = TrainingMonitor::default();
    screen.draw(&mut |ui| training_monitor(ui, &mut monitor));
    assert!(screen.shows("no curve yet"));
}
