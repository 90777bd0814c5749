//! Steps and strides, and the mean of each quantity over the cycle.

use super::samples::{FootGait, GaitError, GaitRecording};
use crate::model::GRAVITY;
use serde::Serialize;

/// Points of a curve: every 2 % of the cycle, 0 to 100.
pub const POINTS: usize = 51;
/// Strides of each foot that are asked for.
const STRIDES: usize = 20;
/// A foot stands from this load on, body weights.
const LOADED: f64 = 0.02;
/// A foot that has been up for so long steps down anew, s.
const SWING: f64 = 0.1;
/// The part that comes down first is told by the loads in this time, s.
const FIRST: f64 = 0.02;
/// Cut-off of the low pass for forces and moments, Hz.
const CUT_OFF: f64 = 20.0;

/// A quantity over the cycle, from heel strike to heel strike, or over the stance.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Curve {
    /// Mean over strides.
    pub mean: Vec<f64>,
    /// Standard deviation over strides.
    pub sd: Vec<f64>,
}

/// What a walk is like.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct GaitReport {
    /// Mean speed, m/s.
    pub speed: f64,
    /// Strides of both feet that were counted.
    pub strides: usize,
    /// Mean length of a stride in time, s.
    pub stride_seconds: f64,
    /// Mean length of a stride over the ground, m.
    pub stride_length: f64,
    /// Stance as a part of the stride.
    pub stance: f64,
    /// Steps of all feet that came down with what is behind the ankle, as a part of all.
    pub heel_first: f64,
    /// Sum of the sizes of the joints' powers over weight and speed.
    pub cost_of_transport: f64,
    /// Vertical force, body weights.
    pub vertical_force: Curve,
    /// Moment of the ankle, N m/kg, positive where it presses the toes down.
    pub ankle_moment: Curve,
    /// Angle of the ankle, degrees, positive where the toes are up.
    pub ankle: Curve,
    /// Angle of the medial toes, degrees, positive where they are up.
    pub toes: Curve,
    /// Where the force acts along the sole over the stance, 0 to 1.
    pub pressure_path: Curve,
    /// Stiffness of each joint of the foot over the cycle, as a multiple of the character's.
    pub gains: Vec<(String, Curve)>,
    /// Largest angle of the toes between 40 and 80 % of the cycle, degrees.
    pub toe_peak_degrees: f64,
    /// Where it is, % of the cycle.
    pub toe_peak_percent: f64,
}

/// Zero-phase low pass: a Butterworth filter of second order, forwards and backwards.
fn low_pass(x: &mut [f64], rate: f64) {
    let w = (std::f64::consts::PI * CUT_OFF / rate).tan();
    let k = 1.0 / (1.0 + std::f64::consts::SQRT_2 * w + w * w);
    let (b, a1, a2) = (w * w * k, 2.0 * (w * w - 1.0) * k, (1.0 - std::f64::consts::SQRT_2 * w + w * w) * k);
    let one_way = |x: &mut dyn Iterator<Item = &mut f64>| {
        let mut state: Option<[f64; 4]> = None;
        for x in x {
            let [x1, x2, y1, y2] = state.unwrap_or([*x; 4]);
            let y = b * (*x + 2.0 * x1 + x2) - a1 * y1 - a2 * y2;
            state = Some([*x, x1, y, y1]);
            *x = y;
        }
    };
    one_way(&mut x.iter_mut());
    one_way(&mut x.iter_mut().rev());
}

/// The value at a time, samples, between those around it.
fn at(x: &[f64], time: f64) -> f64 {
    let k = (time as usize).min(x.len() - 1);
    let next = x[(k + 1).min(x.len() - 1)];
    x[k] + (next - x[k]) * (time - k as f64)
}

/// Mean and deviation of curves.
fn mean_of(curves: &[Vec<f64>]) -> Curve {
    let n = curves.len().max(1) as f64;
    let points = curves.first().map_or(0, Vec::len);
    let mean: Vec<f64> = (0..points).map(|k| curves.iter().map(|c| c[k]).sum::<f64>() / n).collect();
    let deviation = |k: usize| (curves.iter().map(|c| (c[k] - mean[k]).powi(2)).sum::<f64>() / n).sqrt();
    Curve { sd: (0..points).map(deviation).collect(), mean }
}

/// When a foot comes down and goes up, as sample numbers: (down, up).
fn stances(load: &[f64], rate: f64) -> Vec<(usize, usize)> {
    let swing = (SWING * rate) as usize;
    let mut found: Vec<(usize, usize)> = Vec::new();
    let (mut up_for, mut down) = (0, None);
    for (k, load) in load.iter().enumerate() {
        if *load > LOADED {
            if down.is_none() && up_for >= swing {
                down = Some(k);
            }
            up_for = 0;
        } else {
            up_for += 1;
            if let Some(from) = down.filter(|_| up_for == swing) {
                found.push((from, k + 1 - swing));
                down = None;
            }
        }
    }
    found
}

/// The walk as a laboratory tells it: curves are means over the strides of both feet.
pub fn gait_report(recording: &GaitRecording) -> Result<GaitReport, GaitError> {
    let rate = recording.rate;
    let mut report = GaitReport::default();
    let mut curves: [Vec<Vec<f64>>; 4] = Default::default();
    let mut gains: Vec<Vec<Vec<f64>>> = vec![Vec::new(); recording.joints.len()];
    let (mut paths, mut steps, mut heels) = (Vec::new(), 0usize, 0usize);
    let (mut seconds, mut stance_part) = (0.0, 0.0);
    for side in 0..2 {
        let of = |quantity: &dyn Fn(&FootGait) -> f64| -> Vec<f64> {
            recording.samples.iter().map(|s| quantity(&s.feet[side])).collect()
        };
        let load = of(&|f| f.force.y);
        let stances = stances(&load, rate);
        let mut quantities = [load, of(&|f| f.ankle_moment), of(&|f| f.ankle), of(&|f| f.toes)];
        quantities[..2].iter_mut().for_each(|x| low_pass(x, rate));
        for (down, _) in &stances {
            let first =
                &recording.samples[*down..(*down + ((FIRST * rate) as usize).max(1)).min(recording.samples.len())];
            let (heel, whole) =
                first.iter().fold((0.0, 0.0), |s, x| (s.0 + x.feet[side].heel, s.1 + x.feet[side].force.y));
            steps += 1;
            heels += usize::from(heel > 0.5 * whole);
        }
        for pair in stances.windows(2).take(STRIDES) {
            let ((down, up), next) = (pair[0], pair[1].0);
            let length = (next - down) as f64;
            let time = |k: usize| down as f64 + length * k as f64 / (POINTS - 1) as f64;
            for (curve, quantity) in curves.iter_mut().zip(&quantities) {
                curve.push((0..POINTS).map(|k| at(quantity, time(k))).collect());
            }
            for (joint, curve) in gains.iter_mut().enumerate() {
                let gain = of(&|f| f.gains.get(joint).copied().unwrap_or(1.0));
                curve.push((0..POINTS).map(|k| at(&gain, time(k))).collect());
            }
            // Where there is no load for a moment, it is where it was.
            let mut last = 0.0;
            let places = recording.samples.iter().map(|s| {
                last = s.feet[side].pressure.unwrap_or(last);
                last
            });
            let path: Vec<f64> = places.collect();
            let stance = (up - down).saturating_sub(1) as f64;
            paths.push((0..POINTS).map(|k| at(&path, down as f64 + stance * k as f64 / (POINTS - 1) as f64)).collect());
            seconds += length / rate;
            stance_part += (up - down) as f64 / length;
        }
    }
    let strides = paths.len();
    let found = strides / 2;
    if found < STRIDES {
        let seconds = recording.samples.len() as f64 / rate;
        return Err(GaitError::Strides { found, seconds, wanted: STRIDES });
    }
    let n = strides as f64;
    let count = recording.samples.len().max(1) as f64;
    let level = |v: glam::DVec3| v.x.hypot(v.z);
    report.speed = recording.samples.iter().map(|s| level(s.velocity)).sum::<f64>() / count;
    report.strides = strides;
    report.stride_seconds = seconds / n;
    report.stride_length = report.speed * report.stride_seconds;
    report.stance = stance_part / n;
    report.heel_first = heels as f64 / steps.max(1) as f64;
    let power = recording.samples.iter().map(|s| s.power).sum::<f64>() / count;
    report.cost_of_transport = power / (recording.mass * GRAVITY * report.speed.max(1e-6));
    let [force, moment, ankle, toes] = curves.map(|c| mean_of(&c));
    (report.vertical_force, report.ankle_moment, report.ankle, report.toes) = (force, moment, ankle, toes);
    report.pressure_path = mean_of(&paths);
    let named = recording.joints.iter().zip(gains);
    report.gains = named.map(|(name, curves)| (name.clone(), mean_of(&curves))).collect();
    let window = (POINTS - 1) * 2 / 5..=(POINTS - 1) * 4 / 5;
    let peak = window.max_by(|a, b| report.toes.mean[*a].total_cmp(&report.toes.mean[*b])).unwrap_or(0);
    report.toe_peak_degrees = report.toes.mean[peak];
    report.toe_peak_percent = 100.0 * peak as f64 / (POINTS - 1) as f64;
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::super::samples::GaitSample;
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn the_low_pass_keeps_what_is_slow_and_takes_what_is_fast_without_a_delay() {
        let rate = 200.0;
        let wave = |hz: f64| -> Vec<f64> { (0..400).map(|k| (TAU * hz * f64::from(k) / rate).sin()).collect() };
        let (slow, fast) = (wave(2.0), wave(60.0));
        let mut both: Vec<f64> = slow.iter().zip(&fast).map(|(a, b)| a + b).collect();
        low_pass(&mut both, rate);
        for k in 50..350 {
            assert!((both[k] - slow[k]).abs() < 0.02, "{k}: {} {}", both[k], slow[k]);
        }
    }

    /// A walk of one stride a second whose foot stands for 0.6 s, the other half a stride later.
    fn recording() -> GaitRecording {
        let foot = |time: f64| {
            let phase = time.rem_euclid(1.0) / 0.6;
            let stands = phase < 1.0;
            FootGait {
                force: glam::DVec3::Y * if stands { (TAU * 0.5 * phase).sin().max(0.05) } else { 0.0 },
                heel: if stands && phase < 0.3 { 1.0 } else { 0.0 },
                pressure: stands.then_some(phase),
                toes: if (0.5..0.7).contains(&(phase * 0.6)) { 30.0 } else { 0.0 },
                gains: vec![2.0],
                ..FootGait::default()
            }
        };
        let sample = |k: u32| {
            let time = f64::from(k) / 200.0 + 0.0025;
            let velocity = glam::DVec3::NEG_Z * 1.2;
            GaitSample { time, feet: [foot(time), foot(time + 0.5)], velocity, power: 50.0 * GRAVITY * 1.2 }
        };
        GaitRecording { samples: (0..5000).map(sample).collect(), rate: 200.0, mass: 50.0, joints: vec!["heel".into()] }
    }

    #[test]
    fn strides_are_found_and_averaged() {
        let report = gait_report(&recording()).unwrap();
        assert_eq!((report.strides, report.heel_first), (40, 1.0));
        assert!((report.stride_seconds - 1.0).abs() < 1e-9 && (report.stride_length - 1.2).abs() < 1e-9);
        assert!((report.stance - 0.6).abs() < 0.01 && (report.cost_of_transport - 1.0).abs() < 1e-9);
        for (k, place) in report.pressure_path.mean.iter().enumerate() {
            assert!((place - k as f64 / 50.0).abs() < 0.02, "the force goes evenly from heel to toe: {k} {place}");
        }
        assert!(report.vertical_force.sd.iter().all(|sd| *sd < 1e-6), "one stride is as the other");
        assert!((report.toe_peak_degrees, (50.0..70.0).contains(&report.toe_peak_percent)) == (30.0, true));
        assert!(report.gains[0].1.mean.iter().all(|g| *g == 2.0));
    }

    #[test]
    fn too_few_strides_are_an_error_that_says_so() {
        let mut short = recording();
        short.samples.truncate(1000);
        let error = gait_report(&short).unwrap_err().to_string();
        assert_eq!(error, "3 strides in 5 s; valid: 20 or more, in a longer time or with a gait that steps");
    }
}
