//! Key poses as text that a person goes on with: one joint group to a line, degrees with two decimals, zeros left out.

use super::key_poses::KeyPose;

/// A number with at most two decimals.
fn short(x: f64) -> String {
    let rounded = (x * 100.0).round() / 100.0;
    // Adding zero turns -0 into 0.
    format!("{}", rounded + 0.0)
}

fn vector(v: (f64, f64, f64)) -> String {
    format!("({}, {}, {})", short(v.0), short(v.1), short(v.2))
}

/// What a new file of key poses holds.
pub(crate) struct NewKeyPoses<'a> {
    pub name: &'a str,
    pub character: &'a str,
    /// Lines of comment above all.
    pub remarks: &'a [String],
    /// m/s along -Z.
    pub speed: f64,
    /// From each pose to the next, s.
    pub seconds: &'a [f64],
    /// The poses, each with a line of comment.
    pub poses: &'a [(String, KeyPose)],
}

impl NewKeyPoses<'_> {
    /// The text of a `*.keyposes.ron` file.
    pub fn text(&self) -> String {
        let mut out = String::new();
        for remark in self.remarks {
            out += &format!("// {remark}\n");
        }
        let seconds: Vec<String> = self.seconds.iter().map(|s| format!("{}", (s * 1e4).round() / 1e4)).collect();
        out += &format!("(\n    name: {:?},\n    character: {:?},\n", self.name, self.character);
        out += &format!("    speed: {:?},\n    seconds: [{}],\n    poses: [\n", self.speed, seconds.join(", "));
        for (remark, pose) in self.poses {
            out += &format!("        // {remark}\n        (\n");
            if pose.lateral != 0.0 {
                out += &format!("            lateral: {:.3},\n", pose.lateral);
            }
            if let Some(height) = pose.height {
                out += &format!("            height: {height:.3},\n");
            }
            if short(pose.turn) != "0" {
                out += &format!("            turn: {},\n", short(pose.turn));
            }
            out += &format!("            root: {},\n            joints: {{\n", vector(pose.root));
            for (name, angles) in &pose.joints {
                if vector(*angles) != "(0, 0, 0)" {
                    out += &format!("                {name:?}: {},\n", vector(*angles));
                }
            }
            out += "            },\n        ),\n";
        }
        out += "    ],\n)\n";
        out
    }
}
