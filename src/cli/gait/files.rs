//! The samples of a walk for other programs.

use super::samples::GaitRecording;
use crate::model::GRAVITY;
use glam::DVec3;
use std::fmt::Write;

const SIDES: [&str; 2] = ["left", "right"];

/// A table with a line of names.
fn table(names: &[String], rows: impl Iterator<Item = Vec<f64>>, separator: char) -> String {
    let mut text = names.join(&separator.to_string());
    text.push('\n');
    for row in rows {
        for (k, x) in row.iter().enumerate() {
            if k > 0 {
                text.push(separator);
            }
            let _ = write!(text, "{x:.6}");
        }
        text.push('\n');
    }
    text
}

/// The head of an OpenSim storage file, and its table.
fn storage(title: &str, degrees: bool, names: &[String], rows: Vec<Vec<f64>>) -> String {
    let degrees = if degrees { "yes" } else { "no" };
    let (count, columns) = (rows.len(), names.len());
    let head = format!("{title}\nversion=1\nnRows={count}\nnColumns={columns}\ninDegrees={degrees}\nendheader\n");
    head + &table(names, rows.into_iter(), '\t')
}

/// All of it, comma separated: s, body weights (right, up, ahead of the way), 0 to 1 along the sole (empty load: -1), N m/kg, degrees, multiples of
/// the character's stiffness, m/s, W.
pub fn csv_text(recording: &GaitRecording) -> String {
    let mut names = vec!["time_s".to_owned(), "speed_m_per_s".into(), "power_W".into()];
    for side in SIDES {
        let quantities = [
            "force_right_BW",
            "force_up_BW",
            "force_ahead_BW",
            "heel_BW",
            "pressure_0_to_1",
            "ankle_moment_Nm_per_kg",
            "ankle_deg",
            "toes_deg",
        ];
        names.extend(quantities.map(|q| format!("{side}_{q}")));
        names.extend(recording.joints.iter().map(|j| format!("{side}_gain_{}", j.trim_end_matches("_left"))));
    }
    let rows = recording.samples.iter().map(|s| {
        let mut row = vec![s.time, s.velocity.x.hypot(s.velocity.z), s.power];
        for f in &s.feet {
            row.extend(f.force.to_array());
            row.extend([f.heel, f.pressure.unwrap_or(-1.0), f.ankle_moment, f.ankle, f.toes]);
            row.extend(&f.gains);
        }
        row
    });
    table(&names, rows, ',')
}

/// Forces of the ground and where they act, as OpenSim's `.sto`: x ahead at the start (the way that is walked), y up, z right; N and m.
pub fn sto_text(recording: &GaitRecording) -> String {
    let mut names = vec!["time".to_owned()];
    for side in SIDES {
        names.extend(["x", "y", "z"].map(|axis| format!("{side}_ground_force_v{axis}")));
        names.extend(["x", "y", "z"].map(|axis| format!("{side}_ground_force_p{axis}")));
    }
    let weight = recording.mass * GRAVITY;
    let axes = |v: DVec3| [-v.z, v.y, v.x];
    let row = |s: &super::GaitSample| {
        let mut row = vec![s.time];
        for f in &s.feet {
            row.extend([f.force.z * weight, f.force.y * weight, f.force.x * weight]);
            row.extend(axes(f.center));
        }
        row
    };
    storage("ground_forces", false, &names, recording.samples.iter().map(row).collect())
}

/// Angles of ankles and toes, as OpenSim's `.mot`, degrees: positive where the toes are up.
pub fn mot_text(recording: &GaitRecording) -> String {
    let names = ["time", "ankle_angle_l", "mtp_angle_l", "ankle_angle_r", "mtp_angle_r"].map(String::from);
    let row = |s: &super::GaitSample| {
        let [l, r] = &s.feet;
        vec![s.time, l.ankle, l.toes, r.ankle, r.toes]
    };
    storage("foot_angles", true, &names, recording.samples.iter().map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::super::{FootGait, GaitSample};
    use super::*;

    #[test]
    fn tables_have_as_many_columns_as_names() {
        let foot = || FootGait { gains: vec![1.0, 2.0], pressure: Some(0.5), ..FootGait::default() };
        let sample = |time: f64| GaitSample { time, feet: [foot(), foot()], ..GaitSample::default() };
        let joints = vec!["heel_left".into(), "toes_left".into()];
        let recording = GaitRecording { samples: vec![sample(0.0), sample(0.005)], rate: 200.0, mass: 50.0, joints };
        let csv = csv_text(&recording);
        let columns: Vec<usize> = csv.lines().map(|l| l.split(',').count()).collect();
        assert_eq!(columns, [3 + 2 * 10; 3]);
        assert!(csv.contains("right_gain_heel"));
        for (text, columns) in [(sto_text(&recording), 13), (mot_text(&recording), 5)] {
            assert!(text.contains(&format!("nRows=2\nnColumns={columns}\n")), "{text}");
            let body = text.split("endheader\n").nth(1).unwrap();
            assert!(body.lines().all(|l| l.split('\t').count() == columns), "{body}");
        }
    }
}
