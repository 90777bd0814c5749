//! What the name of a joint says: a side and a part of the body, in the spellings of the field.

use crate::model::Side;

/// A part of the body, as far as a name tells. `Hip`, `Shoulder`, `Leg` and `Arm` mean different joints to different tools;
/// the chain in which they lie decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Pelvis,
    Trunk,
    Neck,
    Head,
    Hip,
    UpperLeg,
    Leg,
    LowerLeg,
    Foot,
    Toe,
    Clavicle,
    Shoulder,
    UpperArm,
    Arm,
    LowerArm,
    Hand,
    Finger,
    /// Twist bones, ends, effectors, props, faces: nothing that a link follows.
    Helper,
}

impl Part {
    pub(crate) fn of_leg(self) -> bool {
        matches!(self, Part::Hip | Part::UpperLeg | Part::Leg | Part::LowerLeg | Part::Foot | Part::Toe)
    }
    pub(crate) fn of_arm(self) -> bool {
        matches!(
            self,
            Part::Clavicle | Part::Shoulder | Part::UpperArm | Part::Arm | Part::LowerArm | Part::Hand | Part::Finger
        )
    }
}

/// What a name says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct JointName {
    pub(crate) side: Option<Side>,
    pub(crate) part: Option<Part>,
}

/// Pieces of names that say which part it is, the more particular first. Matched anywhere in the letters of the name, since
/// many tools write all in one case: `leftupleg`, `lfemur`.
const PARTS: [(&str, Part); 62] = [
    ("twist", Part::Helper),
    ("roll", Part::Helper),
    ("effector", Part::Helper),
    ("helper", Part::Helper),
    ("weapon", Part::Helper),
    ("camera", Part::Helper),
    ("breast", Part::Helper),
    ("tongue", Part::Helper),
    ("eyebrow", Part::Helper),
    ("phalang", Part::Toe),
    ("metatars", Part::Foot),
    ("toe", Part::Toe),
    ("thumb", Part::Finger),
    ("index", Part::Finger),
    ("middlefinger", Part::Finger),
    ("pinky", Part::Finger),
    ("little", Part::Finger),
    ("finger", Part::Finger),
    ("carpal", Part::Finger),
    ("upperleg", Part::UpperLeg),
    ("upleg", Part::UpperLeg),
    ("legupper", Part::UpperLeg),
    ("thigh", Part::UpperLeg),
    ("femur", Part::UpperLeg),
    ("lowerleg", Part::LowerLeg),
    ("lowleg", Part::LowerLeg),
    ("leglower", Part::LowerLeg),
    ("shin", Part::LowerLeg),
    ("calf", Part::LowerLeg),
    ("knee", Part::LowerLeg),
    ("tibia", Part::LowerLeg),
    ("foot", Part::Foot),
    ("ankle", Part::Foot),
    ("heel", Part::Foot),
    ("upperarm", Part::UpperArm),
    ("uparm", Part::UpperArm),
    ("armupper", Part::UpperArm),
    ("humerus", Part::UpperArm),
    ("bicep", Part::UpperArm),
    ("forearm", Part::LowerArm),
    ("lowerarm", Part::LowerArm),
    ("lowarm", Part::LowerArm),
    ("armlower", Part::LowerArm),
    ("elbow", Part::LowerArm),
    ("radius", Part::LowerArm),
    ("clavicle", Part::Clavicle),
    ("collar", Part::Clavicle),
    ("scapula", Part::Clavicle),
    ("shoulder", Part::Shoulder),
    ("shldr", Part::Shoulder),
    ("hand", Part::Hand),
    ("wrist", Part::Hand),
    ("pelvis", Part::Pelvis),
    ("spine", Part::Trunk),
    ("chest", Part::Trunk),
    ("torso", Part::Trunk),
    ("abdomen", Part::Trunk),
    ("thorax", Part::Trunk),
    ("waist", Part::Trunk),
    ("lowerback", Part::Trunk),
    ("neck", Part::Neck),
    ("head", Part::Head),
];

/// Words that mark the end of a bone, a target or the like.
const HELPER_WORDS: [&str; 15] =
    ["end", "tip", "nub", "site", "ik", "top", "pole", "eff", "null", "dummy", "prop", "jaw", "eye", "hair", "target"];

/// The words of a name in lower case: parted at all but letters, and where the case changes. Digits are left out.
fn words(name: &str) -> Vec<String> {
    // What stands before a colon or a bar is the name of a rig.
    let name = name.rsplit([':', '|']).next().unwrap_or(name);
    let letters: Vec<char> = name.chars().collect();
    let mut words: Vec<String> = Vec::new();
    let mut open = false;
    for (i, &c) in letters.iter().enumerate() {
        if !c.is_alphabetic() {
            open = false;
            continue;
        }
        let before = i.checked_sub(1).map(|k| letters[k]);
        let after = letters.get(i + 1);
        // LeftArm, and LHipJoint before its H.
        let humps = c.is_uppercase()
            && (before.is_some_and(char::is_lowercase)
                || before.is_some_and(char::is_uppercase) && after.is_some_and(|a| a.is_lowercase()));
        match words.last_mut() {
            Some(word) if open && !humps => word.extend(c.to_lowercase()),
            _ => words.push(c.to_lowercase().collect()),
        }
        open = true;
    }
    words
}

fn side_of(word: &str) -> Option<Side> {
    match word {
        "left" | "l" | "lft" | "lf" | "lt" => Some(Side::Left),
        "right" | "r" | "rgt" | "rt" | "rght" => Some(Side::Right),
        _ => None,
    }
}

/// The part that letters without a side speak of.
fn part_of(letters: &str, words: &[String], sided: bool) -> Option<Part> {
    if words.iter().any(|w| HELPER_WORDS.contains(&w.as_str())) {
        return Some(Part::Helper);
    }
    let word = |w: &str| words.iter().any(|x| x == w);
    if sided && (word("middle") || word("ring") || word("mid")) {
        return Some(Part::Finger);
    }
    if let Some((_, part)) = PARTS.iter().find(|(piece, _)| letters.contains(piece)) {
        return Some(*part);
    }
    match () {
        () if sided && word("ball") => Some(Part::Toe),
        () if letters.contains("hip") => Some(if sided { Part::Hip } else { Part::Pelvis }),
        () if sided && letters.contains("leg") => Some(Part::Leg),
        () if sided && letters.contains("arm") => Some(Part::Arm),
        () if !sided && (letters.contains("back") || letters.contains("lumbar") || word("ribs")) => Some(Part::Trunk),
        () => None,
    }
}

/// Reads a name.
pub(crate) fn read_name(name: &str) -> JointName {
    let words = words(name);
    let sides: Vec<Side> = words.iter().filter_map(|w| side_of(w)).collect();
    let letters: String = words.iter().filter(|w| side_of(w).is_none()).map(String::as_str).collect();
    if let Some(&side) = sides.first() {
        return JointName { side: Some(side), part: part_of(&letters, &words, true) };
    }
    // One case throughout: `leftupleg`, `lfemur`.
    for (start, side) in [("left", Side::Left), ("right", Side::Right), ("l", Side::Left), ("r", Side::Right)] {
        if let Some(rest) = letters.strip_prefix(start)
            && let Some(part) = part_of(rest, &[rest.to_owned()], true)
            && (start.len() > 1 || known_start(rest))
        {
            return JointName { side: Some(side), part: Some(part) };
        }
    }
    JointName { side: None, part: part_of(&letters, &words, false) }
}

/// Whether letters begin with the name of a part: `lfemur` is one, `lumbar` is none.
fn known_start(letters: &str) -> bool {
    PARTS.iter().any(|(piece, _)| letters.starts_with(piece))
        || letters.starts_with("hip")
        || letters.starts_with("hum")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same joint in the spellings of the field. A reader that knew one spelling only would pass with one tool's files.
    #[test]
    fn sides_and_parts_in_any_spelling() {
        let left = Some(Side::Left);
        let right = Some(Side::Right);
        for (name, side, part) in [
            ("mixamorig:LeftUpLeg", left, Part::UpperLeg),
            ("LHipJoint", left, Part::Hip),
            ("LThumb", left, Part::Finger),
            ("LeftHandIndex1", left, Part::Finger),
            ("LeftHandRing2", left, Part::Finger),
            ("mixamorig:HeadTop_End", None, Part::Helper),
            ("UpperLeg_L", left, Part::UpperLeg),
            ("Shoulder_R", right, Part::Shoulder),
            ("Bip01 L UpperArm", left, Part::UpperArm),
            ("Bip01 R Toe0", right, Part::Toe),
            ("thigh.L", left, Part::UpperLeg),
            ("lShldr", left, Part::Shoulder),
            ("rfemur", right, Part::UpperLeg),
            ("lhumerus", left, Part::UpperArm),
            ("leftforearm", left, Part::LowerArm),
            ("LeftForeArm", left, Part::LowerArm),
            ("LeftArm", left, Part::Arm),
            ("Left_Leg", left, Part::Leg),
            ("RightHip", right, Part::Hip),
            ("Hips", None, Part::Pelvis),
            ("LowerBack", None, Part::Trunk),
            ("lowerback", None, Part::Trunk),
            ("Spine2", None, Part::Trunk),
            ("upperneck", None, Part::Neck),
            ("LeftArmRoll", left, Part::Helper),
            ("RightAnkle", right, Part::Foot),
            ("lft_wrist", left, Part::Hand),
            ("left hand", left, Part::Hand),
            ("foot_right", right, Part::Foot),
            ("medial_metatarsal_left", left, Part::Foot),
            ("medial_phalanges_left", left, Part::Toe),
        ] {
            assert_eq!(read_name(name), JointName { side, part: Some(part) }, "{name}");
        }
        assert_eq!(read_name("joint_Root"), JointName::default());
        assert_eq!(read_name("Reference"), JointName::default());
        assert_eq!(read_name("lumbar").side, None);
    }
}
