//! A course with all its numbers: solids in the world frame.

use super::{Course, CourseError, MotionEntry, Quantity, SolidEntry};
use crate::asset::Material;
use crate::math::RandomStream;
use glam::{DQuat, DVec3};

/// Stream of the random numbers that bumps are drawn with.
const BUMPS_STREAM: u64 = 0x6275_6d70;

/// Steepest ground of a course, degrees.
const MAX_SLOPE: f64 = 45.0;

/// A course with all its numbers, world frame, m, rad, s.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CourseInstance {
    /// Material and friction of the course's own ground; `None` without one.
    pub ground: Option<(Material, f64)>,
    /// By how much the ground rises along the way (-Z), m per m.
    pub slope: f64,
    /// Where the ground is missing: z of the near and the far brink of each gap, nearest first.
    pub gaps: Vec<(f64, f64)>,
    /// Rough ground.
    pub bumps: Option<BumpsInstance>,
    /// Solids on the ground; the same number and kinds in the same order for every instance of a course.
    pub solids: Vec<SolidInstance>,
    /// Width between the side walls, m.
    pub side_walls: Option<f64>,
}

/// Heights at the nodes of a square grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BumpsInstance {
    /// The node of the smallest x and z, at height 0.
    pub origin: DVec3,
    /// Distance of the nodes, m.
    pub spacing: f64,
    /// Nodes along x.
    pub columns: usize,
    /// Nodes along z.
    pub rows: usize,
    /// Heights, m; node (column i, row j) is number `j * columns + i`. Zero at the border.
    pub heights: Vec<f64>,
    /// No height is further from zero, m.
    pub amplitude: f64,
}

/// A solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidInstance {
    /// Its shape.
    pub shape: SolidShape,
    /// Its centre at its own place, before it moves.
    pub center: DVec3,
    /// What it is made of.
    pub material: Material,
    /// Coulomb coefficient.
    pub friction: f64,
    /// The edges of its top can be held on to.
    pub edge: bool,
    /// How it moves.
    pub motion: Option<MotionInstance>,
}

/// Shape of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SolidShape {
    /// A box.
    Block {
        /// Half of its edge lengths.
        half: DVec3,
        /// Box axes to world axes.
        rotation: DQuat,
    },
    /// A level rod with round ends.
    Rail {
        /// From the middle of its axis to the centre of a round end.
        half: DVec3,
        /// Radius.
        radius: f64,
    },
}

/// How a solid moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionInstance {
    /// `amplitude * sin(2 pi frequency t)`.
    Sway {
        /// Way at a quarter of a period, m.
        amplitude: DVec3,
        /// Hz.
        frequency: f64,
    },
    /// By a way at minimum jerk (Flash, Hogan 1985).
    Jerk {
        /// The way, m.
        by: DVec3,
        /// When it begins, s.
        start: f64,
        /// How long it takes, s.
        seconds: f64,
    },
    /// To and fro at constant speed.
    Cross {
        /// The way, m.
        by: DVec3,
        /// Time one way takes, s.
        seconds: f64,
    },
}

impl MotionInstance {
    /// Displacement (m) and velocity (m/s) at a time (s): a function of the time alone, by polynomials, so that it has the
    /// same bits everywhere.
    pub fn at(&self, time: f64) -> (DVec3, DVec3) {
        match *self {
            Self::Sway { amplitude, frequency } => {
                let turns = time * frequency;
                let (sine, cosine) = sine_cosine(turns - turns.floor());
                (amplitude * sine, amplitude * (core::f64::consts::TAU * frequency * cosine))
            }
            Self::Jerk { by, start, seconds } => {
                // s = 10 u^3 - 15 u^4 + 6 u^5 for u from 0 to 1.
                let u = ((time - start) / seconds).clamp(0.0, 1.0);
                let place = u * u * u * (10.0 + u * (6.0 * u - 15.0));
                let rate = 30.0 * u * u * (1.0 - u) * (1.0 - u) / seconds;
                (by * place, by * rate)
            }
            Self::Cross { by, seconds } => {
                let ways = time / seconds;
                let whole = ways.floor();
                let part = ways - whole;
                let back = whole - 2.0 * (whole * 0.5).floor() > 0.5;
                let (place, rate) = if back { (1.0 - part, -1.0) } else { (part, 1.0) };
                (by * place, by * (rate / seconds))
            }
        }
    }
}

/// Sine and cosine of a part of a turn (0 to 1), to 1e-14: Taylor's series on the nearest eighth.
fn sine_cosine(turn: f64) -> (f64, f64) {
    let quarter = (turn * 4.0).round();
    let x = (turn - quarter * 0.25) * core::f64::consts::TAU;
    let y = x * x;
    let sine = x
        * (1.0
            - y / 6.0
                * (1.0
                    - y / 20.0
                        * (1.0
                            - y / 42.0
                                * (1.0 - y / 72.0 * (1.0 - y / 110.0 * (1.0 - y / 156.0 * (1.0 - y / 210.0)))))));
    let cosine = 1.0
        - y / 2.0
            * (1.0
                - y / 12.0
                    * (1.0 - y / 30.0 * (1.0 - y / 56.0 * (1.0 - y / 90.0 * (1.0 - y / 132.0 * (1.0 - y / 182.0))))));
    match quarter as i64 & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// Looks up numbers of one part of a course.
struct Numbers<'a> {
    course: &'a Course,
    values: &'a [f64],
    /// Index and kind of a solid; `None` for the course as a whole.
    solid: Option<(usize, &'static str)>,
}

impl Numbers<'_> {
    fn place(&self) -> Box<str> {
        match self.solid {
            Some((index, kind)) => format!("solid {} ({kind})", index + 1).into(),
            None => "course".into(),
        }
    }

    /// The value of a quantity, from `low` to `high`.
    fn get(&self, field: &'static str, of: &Quantity, low: f64, high: f64, unit: &str) -> Result<f64, CourseError> {
        let parameter = |name: &str| self.course.parameter(name).and_then(|k| self.values.get(k)).copied();
        let value = of.value(&parameter);
        if value >= low && value <= high {
            return Ok(value);
        }
        let with = match of.formula() {
            Some(_) => format!("{value} (from {})", serde_text(of)),
            None => value.to_string(),
        };
        Err(CourseError::Value {
            file: self.course.shown().into(),
            place: self.place(),
            field,
            value: with.into(),
            valid: format!("a number from {low} to {high}{unit}").into(),
        })
    }

    fn length(&self, field: &'static str, of: &Quantity) -> Result<f64, CourseError> {
        self.get(field, of, 0.001, 1000.0, " m")
    }

    /// Where it stands, world frame, m.
    fn stand(&self, ahead: &Quantity, right: &Quantity, up: &Quantity) -> Result<DVec3, CourseError> {
        let place = |field, of| self.get(field, of, -1000.0, 1000.0, " m");
        Ok(DVec3::new(place("right", right)?, place("up", up)?, -place("ahead", ahead)?))
    }

    fn yaw(&self, of: &Quantity) -> Result<DQuat, CourseError> {
        let degrees = self.get("yaw", of, -360.0, 360.0, " degrees")?;
        Ok(if degrees == 0.0 { DQuat::IDENTITY } else { DQuat::from_rotation_y(degrees.to_radians()) })
    }

    /// A direction or way (right, up, ahead) in world axes, m.
    fn way(&self, field: &'static str, of: &(Quantity, Quantity, Quantity)) -> Result<DVec3, CourseError> {
        let part = |of| self.get(field, of, -100.0, 100.0, "");
        let way = DVec3::new(part(&of.0)?, part(&of.1)?, -part(&of.2)?);
        if way.length() >= 1e-3 {
            return Ok(way);
        }
        Err(CourseError::Value {
            file: self.course.shown().into(),
            place: self.place(),
            field,
            value: "nothing".into(),
            valid: "(right, up, ahead), not all of them zero".into(),
        })
    }

    fn motion(&self, of: &Option<MotionEntry>) -> Result<Option<MotionInstance>, CourseError> {
        Ok(match of {
            None => None,
            Some(MotionEntry::Sway { along, amplitude, frequency }) => {
                let along = self.way("along", along)?.normalize();
                let amplitude = along * self.get("amplitude", amplitude, 0.0, 100.0, " m")?;
                Some(MotionInstance::Sway { amplitude, frequency: self.get("frequency", frequency, 0.0, 20.0, " Hz")? })
            }
            Some(MotionEntry::Jerk { by, start, seconds }) => Some(MotionInstance::Jerk {
                by: self.way("by", by)?,
                start: self.get("start", start, 0.0, 1e5, " s")?,
                seconds: self.get("seconds", seconds, 0.01, 1e4, " s")?,
            }),
            Some(MotionEntry::Cross { by, speed }) => {
                let by = self.way("by", by)?;
                let seconds = by.length() / self.get("speed", speed, 0.001, 30.0, " m/s")?;
                Some(MotionInstance::Cross { by, seconds })
            }
        })
    }

    fn material(&self, name: &str) -> Material {
        // The check knows every name.
        self.course.material(name).unwrap_or(Material::WALL)
    }
}

/// A quantity as it is written.
fn serde_text(of: &Quantity) -> String {
    of.formula().map(|f| format!("\"{}\"", f.text())).unwrap_or_default()
}

/// The course with these values of its parameters.
pub(super) fn evaluate(
    course: &Course,
    values: &[f64],
    seed: u64,
    out: &mut CourseInstance,
) -> Result<(), CourseError> {
    let whole = Numbers { course, values, solid: None };
    out.gaps.clear();
    out.solids.clear();
    out.ground = match &course.ground {
        Some(ground) => {
            Some((whole.material(&ground.material), whole.get("friction", &ground.friction, 0.0, 10.0, "")?))
        }
        None => None,
    };
    out.slope = match &course.ground {
        Some(ground) if ground.slope != Quantity::ZERO => {
            whole.get("slope", &ground.slope, -MAX_SLOPE, MAX_SLOPE, " degrees")?.to_radians().tan()
        }
        _ => 0.0,
    };
    out.side_walls = match &course.side_walls {
        Some(width) => Some(whole.get("side_walls", width, 0.01, 1000.0, " m")?),
        None => None,
    };
    let mut rough = false;
    for (index, entry) in course.solids.iter().enumerate() {
        let numbers = Numbers { solid: Some((index, entry.kind())), ..whole };
        match entry {
            SolidEntry::Box { ahead, right, up, yaw, depth, width, height, edge, material, friction, motion } => {
                let [depth, width, height] = [
                    numbers.length("depth", depth)?,
                    numbers.length("width", width)?,
                    numbers.length("height", height)?,
                ];
                let (stand, turn) = (numbers.stand(ahead, right, up)?, numbers.yaw(yaw)?);
                out.solids.push(SolidInstance {
                    shape: SolidShape::Block { half: DVec3::new(width, height, depth) * 0.5, rotation: turn },
                    center: stand + turn * DVec3::new(0.0, height * 0.5, -depth * 0.5),
                    material: numbers.material(material),
                    friction: numbers.get("friction", friction, 0.0, 10.0, "")?,
                    edge: *edge,
                    motion: numbers.motion(motion)?,
                });
            }
            SolidEntry::Rail { ahead, right, up, yaw, length, radius, material, friction, motion } => {
                let half = numbers.yaw(yaw)? * DVec3::X * (0.5 * numbers.length("length", length)?);
                out.solids.push(SolidInstance {
                    shape: SolidShape::Rail { half, radius: numbers.get("radius", radius, 0.001, 10.0, " m")? },
                    center: numbers.stand(ahead, right, up)?,
                    material: numbers.material(material),
                    friction: numbers.get("friction", friction, 0.0, 10.0, "")?,
                    edge: false,
                    motion: numbers.motion(motion)?,
                });
            }
            SolidEntry::Stairs { ahead, right, up, count, tread, rise, width, material, friction } => {
                let stand = numbers.stand(ahead, right, up)?;
                let (tread, rise) = (numbers.length("tread", tread)?, numbers.length("rise", rise)?);
                let width = numbers.length("width", width)?;
                let friction = numbers.get("friction", friction, 0.0, 10.0, "")?;
                for k in 0..*count {
                    let (height, depth) = (rise * (k + 1) as f64, tread * (count - k) as f64);
                    out.solids.push(SolidInstance {
                        shape: SolidShape::Block {
                            half: DVec3::new(width, height, depth) * 0.5,
                            rotation: DQuat::IDENTITY,
                        },
                        center: stand + DVec3::new(0.0, height * 0.5, -tread * k as f64 - depth * 0.5),
                        material: numbers.material(material),
                        friction,
                        edge: false,
                        motion: None,
                    });
                }
            }
            SolidEntry::Ramp {
                ahead,
                right,
                up,
                yaw,
                length,
                width,
                height,
                thickness,
                material,
                friction,
                motion,
            } => {
                let (length, width) = (numbers.length("length", length)?, numbers.length("width", width)?);
                let height = numbers.get("height", height, -1000.0, 1000.0, " m")?;
                let thickness = numbers.length("thickness", thickness)?;
                let rotation = numbers.yaw(yaw)? * DQuat::from_rotation_x(height.atan2(length));
                let half = DVec3::new(width, thickness, length.hypot(height)) * 0.5;
                out.solids.push(SolidInstance {
                    shape: SolidShape::Block { half, rotation },
                    center: numbers.stand(ahead, right, up)? + rotation * DVec3::new(0.0, -half.y, -half.z),
                    material: numbers.material(material),
                    friction: numbers.get("friction", friction, 0.0, 10.0, "")?,
                    edge: false,
                    motion: numbers.motion(motion)?,
                });
            }
            SolidEntry::Gap { ahead, length } => {
                let near = -numbers.get("ahead", ahead, -1000.0, 1000.0, " m")?;
                let far = near - numbers.length("length", length)?;
                if out.gaps.last().is_some_and(|before| near >= before.1) {
                    return Err(CourseError::Together {
                        file: course.shown().into(),
                        place: numbers.place(),
                        reason: "begins before the gap in the list before it ends",
                        valid: "gaps from the nearest to the furthest, with ground between them",
                    });
                }
                out.gaps.push((near, far));
            }
            SolidEntry::Bumps { ahead, length, width, spacing, amplitude } => {
                rough = true;
                let [columns, rows] = nodes(*length, *width, *spacing);
                let bumps = out.bumps.get_or_insert_with(BumpsInstance::default);
                let ahead = numbers.get("ahead", ahead, -1000.0, 1000.0, " m")?;
                bumps.amplitude = numbers.get("amplitude", amplitude, 0.0, 10.0, " m")?;
                bumps.spacing = *spacing;
                (bumps.columns, bumps.rows) = (columns, rows);
                let (x, z) = ((columns - 1) as f64 * spacing * 0.5, (rows - 1) as f64 * spacing);
                bumps.origin = DVec3::new(-x, 0.0, -ahead - z);
                let mut random = RandomStream::new(seed, BUMPS_STREAM);
                bumps.heights.clear();
                for node in 0..columns * rows {
                    let (i, j) = (node % columns, node / columns);
                    let border = i == 0 || j == 0 || i + 1 == columns || j + 1 == rows;
                    let height = random.range(-bumps.amplitude, bumps.amplitude);
                    bumps.heights.push(if border { 0.0 } else { height });
                }
            }
        }
    }
    if !rough {
        out.bumps = None;
    }
    Ok(())
}

/// Nodes along x and z of a field of bumps: whole spacings, at least two each way.
pub(super) fn nodes(length: f64, width: f64, spacing: f64) -> [usize; 2] {
    [width, length].map(|size| (size / spacing).round().clamp(2.0, 1e6) as usize + 1)
}
