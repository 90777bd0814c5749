//! The ground of a course, with another slope, other gaps and bumps in every lane.

use crate::asset::CourseInstance;
use crate::contact::geometry::strip_distance;
use crate::contact::{SupportHit, SurfaceHit};
use crate::math::{Real, Vec3};
use glam::DVec3;

/// Level ground at y = 0 with gaps, or a slope through the origin; either may be rough, but not where there are gaps.
#[derive(Clone, Debug)]
pub(super) struct LaneGround<R: Real> {
    /// False where the course stands on the shared world.
    present: bool,
    friction: R,
    /// One where it is so, else zero.
    carves: R,
    grippable: R,
    /// By how much it rises along -z, m per m.
    slope: R,
    /// Whether any lane's does.
    sloping: bool,
    /// z of the near and the far brink, nearest first.
    gaps: Vec<(R, R)>,
    bumps: Option<LaneBumps<R>>,
}

/// Heights at the nodes of a square grid: the same grid at another place in every lane.
#[derive(Clone, Debug)]
struct LaneBumps<R: Real> {
    columns: usize,
    rows: usize,
    spacing: f64,
    /// x and z of the first node, by lane.
    origin: Vec<(f64, f64)>,
    heights: Vec<R>,
    amplitude: R,
}

impl<R: Real> LaneGround<R> {
    /// Of the kind that `instance` has, with no numbers yet.
    pub fn new(instance: &CourseInstance) -> Self {
        let zero = R::zero();
        Self {
            present: instance.ground.is_some(),
            friction: zero,
            carves: zero,
            grippable: zero,
            slope: zero,
            sloping: false,
            gaps: vec![(zero, zero); instance.gaps.len()],
            bumps: instance.bumps.as_ref().map(|b| LaneBumps {
                columns: b.columns,
                rows: b.rows,
                spacing: b.spacing,
                origin: vec![(0.0, 0.0); R::LANES],
                heights: vec![zero; b.heights.len()],
                amplitude: zero,
            }),
        }
    }

    /// What an instance has that does not fit: what, as it is there and as it is here.
    pub fn difference(&self, instance: &CourseInstance) -> Option<(&'static str, String, String)> {
        let grid = |b: Option<(usize, usize)>| b.map_or("none".into(), |(c, r)| format!("{c} x {r} nodes"));
        let own = self.bumps.as_ref().map(|b| (b.columns, b.rows));
        let other = instance.bumps.as_ref().map(|b| (b.columns, b.rows));
        if self.present != instance.ground.is_some() {
            let word = |present: bool| if present { "there" } else { "missing" }.to_owned();
            return Some(("ground", word(!self.present), word(self.present)));
        }
        if self.gaps.len() != instance.gaps.len() {
            return Some(("number of gaps", instance.gaps.len().to_string(), self.gaps.len().to_string()));
        }
        (own != other).then(|| ("field of bumps", grid(other), grid(own)))
    }

    /// Writes the numbers of a lane.
    pub fn set_lane(&mut self, lane: usize, instance: &CourseInstance) {
        let Some((material, friction)) = instance.ground else { return };
        let number = |is: bool| f64::from(u8::from(is));
        self.friction.set_lane(lane, friction);
        self.carves.set_lane(lane, number(material.carves));
        self.grippable.set_lane(lane, number(material.grippable));
        self.slope.set_lane(lane, instance.slope);
        self.sloping = (0..R::LANES).any(|lane| self.slope.lane(lane) != 0.0);
        for (own, gap) in self.gaps.iter_mut().zip(&instance.gaps) {
            own.0.set_lane(lane, gap.0);
            own.1.set_lane(lane, gap.1);
        }
        if let (Some(own), Some(bumps)) = (&mut self.bumps, &instance.bumps) {
            own.origin[lane] = (bumps.origin.x, bumps.origin.z);
            own.amplitude.set_lane(lane, bumps.amplitude);
            for (own, height) in own.heights.iter_mut().zip(&bumps.heights) {
                own.set_lane(lane, *height);
            }
        }
    }

    #[inline]
    pub fn query(&self, point: Vec3<R>) -> Option<SurfaceHit<R>> {
        if !self.present {
            return None;
        }
        let half = R::splat(0.5);
        let mut hit = SurfaceHit {
            distance: point.y,
            friction: self.friction,
            carves: half.lt(self.carves),
            grippable: half.lt(self.grippable),
            ..SurfaceHit::nothing()
        };
        if self.bumps.is_some() || self.sloping {
            let (height, normal) = self.surface(point);
            (hit.distance, hit.normal) = ((point.y - height) * normal.y, normal);
        } else if !self.gaps.is_empty() {
            hit.distance = R::splat(1e9);
            for (near, far) in self.strips() {
                let own = strip_distance(point, R::zero(), near, far);
                let nearer = own.distance.lt(hit.distance);
                hit.distance = R::select(nearer, own.distance, hit.distance);
                hit.normal = Vec3::select(nearer, own.normal, hit.normal);
            }
        }
        Some(hit)
    }

    /// A lower bound of the distance, m.
    #[inline]
    pub fn clearance(&self, point: Vec3<R>) -> Option<R> {
        /// So far above the highest bump, the bumps need not be looked at, m.
        const HIGH: f64 = 0.25;
        if !self.present {
            return None;
        }
        let Some(bumps) = &self.bumps else { return self.query(point).map(|hit| hit.distance) };
        let mut over = point.y - bumps.amplitude;
        if self.sloping {
            // From the plane over all bumps: the way up times the cosine of its slope; below it, no less than the way up.
            over += self.slope * point.z;
            let cosine = R::one() / (R::one() + self.slope * self.slope).sqrt();
            over = over.min(over * cosine);
        }
        let close = over.lt(R::splat(HIGH));
        if !R::any(close) {
            return Some(over);
        }
        // No slope between neighbours is more than twice the amplitude over the spacing, along x and along z, and the ground's own along z.
        let slope = bumps.amplitude * R::splat(2.0 / bumps.spacing);
        let along = slope + self.slope.abs();
        let cosine = (R::one() + slope * slope + along * along).sqrt().recip();
        let (height, _) = self.surface(point);
        Some(R::select(close, ((point.y - height) * cosine).max(over), over))
    }

    #[inline]
    pub fn height(&self, point: Vec3<R>) -> Option<SupportHit<R>> {
        if !self.present {
            return None;
        }
        let zero = R::zero();
        let mut hit = SupportHit { height: zero, found: zero.lt(R::one()), ..SupportHit::nothing() };
        if self.bumps.is_some() || self.sloping {
            (hit.height, hit.normal) = self.surface(point);
        }
        for (near, far) in &self.gaps {
            hit.found = hit.found & !(point.z.lt(*near) & far.lt(point.z));
        }
        hit.height = R::select(hit.found, hit.height, R::splat(SupportHit::<R>::BOTTOMLESS));
        Some(hit)
    }

    /// Height and outward unit normal under a point where there are no gaps.
    #[inline]
    fn surface(&self, point: Vec3<R>) -> (R, Vec3<R>) {
        match &self.bumps {
            Some(bumps) => bumps.surface(point, self.slope),
            None => {
                let cosine = R::one() / (R::one() + self.slope * self.slope).sqrt();
                (-self.slope * point.z, Vec3 { x: R::zero(), y: cosine, z: self.slope * cosine })
            }
        }
    }

    /// z of the near and the far brink of every piece of ground.
    #[inline]
    fn strips(&self) -> impl Iterator<Item = (R, R)> + '_ {
        let end = R::splat(1e9);
        let near = std::iter::once(end).chain(self.gaps.iter().map(|g| g.1));
        near.zip(self.gaps.iter().map(|g| g.0).chain(std::iter::once(-end)))
    }
}

impl<R: Real> LaneBumps<R> {
    /// Height and outward unit normal under a point, lane by lane, on ground that rises by `slope` along -z: bilinear between nodes, even beyond
    /// them.
    #[inline]
    fn surface(&self, point: Vec3<R>, slope: R) -> (R, Vec3<R>) {
        let cosine = R::one() / (R::one() + slope * slope).sqrt();
        let (mut height, mut normal) = (-slope * point.z, Vec3 { x: R::zero(), y: cosine, z: slope * cosine });
        let end = [(self.columns - 1) as f64, (self.rows - 1) as f64];
        for lane in 0..R::LANES {
            let (x, z) = self.origin[lane];
            let u = [(point.x.lane(lane) - x) / self.spacing, (point.z.lane(lane) - z) / self.spacing];
            // What is no number is on neither side.
            if !(u[0] > 0.0 && u[0] < end[0] && u[1] > 0.0 && u[1] < end[1]) {
                continue;
            }
            let (i, j) = (u[0] as usize, u[1] as usize);
            let (s, t) = (u[0] - i as f64, u[1] - j as f64);
            let h = |i: usize, j: usize| self.heights[j * self.columns + i].lane(lane);
            let (a, b, c, d) = (h(i, j), h(i + 1, j), h(i, j + 1), h(i + 1, j + 1));
            let (rise, z) = (slope.lane(lane), point.z.lane(lane));
            height.set_lane(lane, (a * (1.0 - s) + b * s) * (1.0 - t) + (c * (1.0 - s) + d * s) * t - rise * z);
            let slope_x = ((b - a) * (1.0 - t) + (d - c) * t) / self.spacing;
            let slope_z = ((c - a) * (1.0 - s) + (d - b) * s) / self.spacing;
            normal.set_lane(lane, DVec3::new(-slope_x, 1.0, rise - slope_z).normalize());
        }
        (height, normal)
    }
}
