//! Whether key poses can be used for a character, field by field.

use super::{KeyPoseError, KeyPoses};
use crate::model::CharacterModel;
use glam::DVec3;

/// Longest motion, repetitions included, s.
const MAX_SECONDS: f64 = 3600.0;

impl KeyPoses {
    /// Refuses the first value that cannot be used.
    pub(super) fn check(&self, model: &CharacterModel) -> Result<(), KeyPoseError> {
        let bad = |place: String, found: String, valid: &str| {
            Err(KeyPoseError::Value { name: self.name.clone(), place, found, valid: valid.to_owned() })
        };
        if self.poses.is_empty() || self.poses.len() > 1000 {
            return bad("poses".into(), format!("{} poses", self.poses.len()), "1 to 1000");
        }
        if self.seconds.len() != self.poses.len() {
            return bad("seconds".into(), format!("{} times", self.seconds.len()), "one for each pose");
        }
        if let Some((i, s)) = self.seconds.iter().enumerate().find(|(_, s)| !(0.01..=10.0).contains(*s)) {
            return bad(format!("seconds of pose {i}"), s.to_string(), "0.01 to 10 s");
        }
        if !(1..=1000).contains(&self.repeat) {
            return bad("repeat".into(), self.repeat.to_string(), "1 to 1000");
        }
        if !(1.0..=240.0).contains(&self.frame_rate) {
            return bad("frame_rate".into(), self.frame_rate.to_string(), "1 to 240 poses per second");
        }
        let sides = if self.mirrored { 2.0 } else { 1.0 };
        let total = self.seconds.iter().sum::<f64>() * self.repeat as f64 * sides;
        if total > MAX_SECONDS {
            return bad("repeat".into(), format!("{total} s in all"), "at most 3600 s in all");
        }
        if !(-30.0..=30.0).contains(&self.speed) {
            return bad("speed".into(), self.speed.to_string(), "-30 to 30 m/s");
        }
        if !(-30.0..=30.0).contains(&self.acceleration) {
            return bad("acceleration".into(), self.acceleration.to_string(), "-30 to 30 m/s^2");
        }
        if !(-5.0..=5.0).contains(&self.curvature) {
            return bad("curvature".into(), self.curvature.to_string(), "-5 to 5 1/m");
        }
        if self.mirrored && self.curvature != 0.0 {
            return bad(
                "curvature".into(),
                self.curvature.to_string(),
                "0 where `mirrored`: a mirror image turns back",
            );
        }
        for (i, pose) in self.poses.iter().enumerate() {
            let place = |what: &str| format!("pose {i}, {what}");
            if !(-10.0..=10.0).contains(&pose.lateral) {
                return bad(place("lateral"), pose.lateral.to_string(), "-10 to 10 m");
            }
            match pose.height {
                Some(height) if !(0.0..=10.0).contains(&height) => {
                    return bad(place("height"), height.to_string(), "0 to 10 m");
                }
                None if self.poses.iter().any(|p| p.height.is_some()) => {
                    return bad(place("height"), "none".into(), "a height in every pose, or in none");
                }
                _ => {}
            }
            if !(-100.0..=100.0).contains(&pose.support) {
                return bad(place("support"), pose.support.to_string(), "-100 to 100 m");
            }
            if !(-10_000.0..=10_000.0).contains(&pose.turn) {
                return bad(place("turn"), pose.turn.to_string(), "at most 10000 degrees");
            }
            let inner = i > 0 && i + 1 < self.poses.len();
            if pose.airborne && !(self.mass_on_path && pose.height.is_none() && inner) {
                let valid = "only with `mass_on_path`, without `height`, and not in the first or last pose";
                return bad(place("airborne"), "true".into(), valid);
            }
            let root = std::iter::once(("root", &pose.root));
            for (name, angle) in root.chain(pose.joints.iter().map(|(n, a)| (n.as_str(), a))) {
                let v = DVec3::new(angle.0, angle.1, angle.2);
                if !(v.is_finite() && v.length() <= 360.0) {
                    return bad(place(name), v.to_string(), "a rotation vector of at most 360 degrees");
                }
                if name != "root" && model.link_index(name).is_none_or(|l| l == 0) {
                    let links: Vec<&str> = model.links.iter().skip(1).map(|l| l.name.as_str()).collect();
                    return bad(place(name), "no such joint".into(), &format!("one of {}", links.join(", ")));
                }
            }
        }
        for (i, contact) in self.contacts.iter().enumerate() {
            let once = !self.mirrored && self.repeat == 1;
            if let Some((field, found, valid)) = contact.fault(model, self.poses.len(), once) {
                return bad(format!("contact {i}, {field}"), found, &valid);
            }
        }
        self.check_windows()
    }

    fn check_windows(&self) -> Result<(), KeyPoseError> {
        let bad = |place: String, found: String, valid: &str| {
            Err(KeyPoseError::Value { name: self.name.clone(), place, found, valid: valid.to_owned() })
        };
        if let Some((field, found, valid)) = self.optimize.fault() {
            return bad(format!("optimize, {field}"), found, valid);
        }
        for (i, window) in self.windows.iter().enumerate() {
            if !(0.05..=5.0).contains(&window.seconds) {
                return bad(format!("window {i}, seconds"), window.seconds.to_string(), "0.05 to 5 s");
            }
            for objective in &window.objectives {
                if let Some((found, valid)) = objective.fault() {
                    return bad(format!("window {i}, {}", objective.label()), found, valid);
                }
            }
        }
        let (poses, windows) = (self.seconds.iter().sum::<f64>(), self.windows.iter().map(|w| w.seconds).sum::<f64>());
        if !self.windows.is_empty() && (poses - windows).abs() > 1e-3 {
            return bad("windows".into(), format!("{windows:.3} s in all"), &format!("{poses:.3} s, as the poses"));
        }
        Ok(())
    }
}
