//! Courses of random obstacles, of the kinds and sizes that a runner's skills clear.

use crate::asset::{Course, CourseError};
use crate::math::RandomStream;
use crate::skill::planner::{Clearance, ObstacleKind};
use std::fmt::Write;

/// From the end of an obstacle to the next one, m.
const SPACING: (f64, f64) = (8.0, 20.0);
/// From the start to the first one, m.
const FIRST: (f64, f64) = (8.0, 14.0);
/// Way behind the last one, m.
const BEHIND: f64 = 8.0;
/// Width of the way, and of what stands on it, m.
const WIDTH: (f64, f64) = (4.0, 6.0);
/// Lengths keep away from the ends of what a skill clears by this, m: they are read from heights that lie apart.
const LENGTH_EDGE: f64 = 0.1;

/// A course, and what is on it.
#[derive(Clone, Debug)]
pub struct RandomCourse {
    /// The course; it has no parameters.
    pub course: Course,
    /// Its obstacles in order.
    pub obstacles: Vec<ObstacleKind>,
    /// Way ahead at which it is over, m.
    pub finish: f64,
}

/// What has been built so far.
struct Builder<'a> {
    clears: &'a [Clearance],
    random: &'a mut RandomStream,
    solids: String,
    /// Beginning and height of the platform that the way is on, m.
    platform: Option<(f64, f64)>,
    at: f64,
    obstacles: Vec<ObstacleKind>,
}

impl Builder<'_> {
    fn draw(&mut self, (low, high): (f64, f64)) -> f64 {
        self.random.range(low.min(high), high.max(low))
    }

    fn solid(&mut self, text: std::fmt::Arguments) {
        // Writing to a text cannot fail.
        let _ = writeln!(self.solids, "        {text},");
    }

    /// A box on the ground, or what its top is seen of above a platform.
    fn block(&mut self, ahead: f64, depth: f64, height: f64) {
        let width = WIDTH.1;
        self.solid(format_args!(
            "Box(ahead: {ahead:.4}, depth: {depth:.4}, width: {width}, height: {height:.4}, material: \"ground\")"
        ));
    }

    /// The platform that the way is on ends here.
    fn close(&mut self) {
        if let Some((from, height)) = self.platform.take() {
            self.block(from, self.at - from, height);
        }
    }

    /// An obstacle of a skill's kind, `self.at` ahead.
    fn build(&mut self, clears: &Clearance) {
        let (low, high) = clears.depths;
        let length = (low + LENGTH_EDGE.min(0.5 * (high - low)), high - LENGTH_EDGE.min(0.5 * (high - low)));
        let level = self.platform.map_or(0.0, |p| p.1);
        match clears.kind {
            ObstacleKind::Up => {
                let height = self.draw(clears.heights);
                self.platform = Some((self.at, height));
            }
            ObstacleKind::Down => self.close(),
            ObstacleKind::Over => {
                let (height, depth) = (self.draw(clears.heights), self.draw(length));
                self.block(self.at, depth, level + height);
                self.at += depth;
            }
            ObstacleKind::Gap => {
                let length = self.draw(length);
                let at = self.at;
                self.solid(format_args!("Gap(ahead: {at:.4}, length: {length:.4})"));
                self.at += length;
            }
        }
        self.obstacles.push(clears.kind);
    }

    fn finished(mut self) -> Result<RandomCourse, CourseError> {
        let finish = self.at + BEHIND;
        self.at = finish + 20.0;
        self.close();
        let text = format!(
            "(\n    name: \"random\",\n    ground: (friction: 0.8),\n    side_walls: {:.1},\n    solids: [\n{}    ],\n)\n",
            WIDTH.0, self.solids
        );
        Ok(RandomCourse { course: Course::parse("random", text.as_bytes())?, obstacles: self.obstacles, finish })
    }
}

/// A course of so many obstacles, 8 to 20 m apart: from level ground steps up, boxes and gaps, from a platform ways down to the ground and boxes, each kind
/// that can be there equally often, heights even over what the skills clear.
pub fn random_course(
    clears: &[Clearance],
    obstacles: usize,
    random: &mut RandomStream,
) -> Result<RandomCourse, CourseError> {
    let mut builder = Builder { clears, random, solids: String::new(), platform: None, at: 0.0, obstacles: Vec::new() };
    builder.at = builder.draw(FIRST);
    for k in 0..obstacles {
        if k > 0 {
            builder.at += builder.draw(SPACING);
        }
        let raised = builder.platform.is_some();
        // Without a way down nothing goes up.
        let down = builder.clears.iter().any(|c| c.kind == ObstacleKind::Down);
        let can = |c: &&Clearance| match c.kind {
            ObstacleKind::Up => !raised && down,
            ObstacleKind::Gap => !raised,
            ObstacleKind::Down => builder.platform.is_some_and(|p| (c.heights.0..=c.heights.1).contains(&p.1)),
            ObstacleKind::Over => true,
        };
        let possible: Vec<&Clearance> = builder.clears.iter().filter(can).collect();
        if possible.is_empty() {
            break;
        }
        let chosen = possible[builder.random.below(possible.len())].clone();
        builder.build(&chosen);
    }
    builder.finished()
}

/// One obstacle of a skill's kind, so far from the start, its height drawn from what the skill clears, or as given.
pub fn single_obstacle(
    clears: &Clearance,
    distance: f64,
    height: Option<f64>,
    random: &mut RandomStream,
) -> Result<RandomCourse, CourseError> {
    let mut chosen = clears.clone();
    if let Some(height) = height {
        chosen.heights = (height, height);
    }
    let mut builder =
        Builder { clears: &[], random, solids: String::new(), platform: None, at: distance, obstacles: Vec::new() };
    if chosen.kind == ObstacleKind::Down {
        let height = builder.draw(chosen.heights);
        builder.platform = Some((-10.0, height));
    }
    builder.build(&chosen);
    builder.finished()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clears(kind: ObstacleKind) -> Clearance {
        Clearance {
            skill: format!("{kind:?}"),
            kind,
            heights: (0.2, 0.6),
            depths: (0.4, 1.0),
            behind: 0.1,
            take_off: 2.0,
            slack: 0.4,
            speeds_in: (3.0, 3.0),
            success: (1.0, 1.0),
        }
    }

    #[test]
    fn every_course_can_be_built_and_ends_where_it_began() {
        let kinds = [ObstacleKind::Up, ObstacleKind::Down, ObstacleKind::Over, ObstacleKind::Gap].map(clears);
        let mut counts = [0usize; 4];
        for number in 0..50 {
            let mut random = RandomStream::new(number, 1);
            let found = random_course(&kinds, 20, &mut random).unwrap();
            assert_eq!(found.obstacles.len(), 20);
            assert!((19.0 * 8.0..20.0 * 22.0).contains(&found.finish), "{} m", found.finish);
            let mut raised = false;
            for kind in &found.obstacles {
                match kind {
                    ObstacleKind::Up => assert!(!std::mem::replace(&mut raised, true)),
                    ObstacleKind::Down => assert!(std::mem::replace(&mut raised, false)),
                    ObstacleKind::Gap => assert!(!raised),
                    ObstacleKind::Over => {}
                }
                counts[*kind as usize] += 1;
            }
            let instance = found.course.instance(&[], 0).unwrap();
            assert!(instance.side_walls == Some(4.0) && !instance.solids.is_empty());
            let again = random_course(&kinds, 20, &mut RandomStream::new(number, 1)).unwrap();
            assert_eq!(again.course, found.course, "the same numbers, the same course");
        }
        assert!(counts.iter().all(|n| *n > 100), "{counts:?}");
    }

    #[test]
    fn without_a_way_down_nothing_goes_up() {
        let kinds = [ObstacleKind::Up, ObstacleKind::Gap].map(clears);
        let found = random_course(&kinds, 10, &mut RandomStream::new(3, 1)).unwrap();
        assert!(found.obstacles.iter().all(|k| *k == ObstacleKind::Gap));
        assert!(random_course(&[], 10, &mut RandomStream::new(3, 1)).unwrap().obstacles.is_empty());
    }

    #[test]
    fn nothing_drops_from_lower_than_it_can() {
        let deep = Clearance { heights: (0.9, 2.0), skill: "roll".into(), ..clears(ObstacleKind::Down) };
        let kinds = [clears(ObstacleKind::Up), clears(ObstacleKind::Gap), deep];
        let found = random_course(&kinds, 20, &mut RandomStream::new(5, 1)).unwrap();
        assert!(found.obstacles.iter().all(|kind| *kind != ObstacleKind::Down), "{:?}", found.obstacles);
    }

    #[test]
    fn a_single_obstacle_is_where_it_is_asked_for() {
        for kind in [ObstacleKind::Up, ObstacleKind::Down, ObstacleKind::Over, ObstacleKind::Gap] {
            let found = single_obstacle(&clears(kind), 31.7, Some(0.45), &mut RandomStream::new(3, 1)).unwrap();
            assert_eq!(found.obstacles, [kind]);
            assert!(found.finish > 31.7 + 7.9 && found.finish < 31.7 + 10.0);
        }
    }
}
