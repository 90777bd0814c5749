//! Result objects of pose estimators: which of their fields are positions in space.

use super::{PositionError, refuse};
use serde_json::{Map, Value};

/// Fields that hold positions in space, as the common estimators and their bindings call them; the first that is there counts.
const IN_SPACE: [&str; 14] = [
    "joints",
    "worldLandmarks",
    "world_landmarks",
    "poseWorldLandmarks",
    "pose_world_landmarks",
    "keypoints3D",
    "keypoints_3d",
    "keypoints3d",
    "joints3D",
    "joints_3d",
    "joints3d",
    "pred_joints",
    "smpl_joints3d",
    "smpl_joints",
];
/// Fields that hold places in the picture, with the field beside them that would be right.
const IN_PICTURE: [(&str, &str); 8] = [
    ("landmarks", "worldLandmarks"),
    ("poseLandmarks", "poseWorldLandmarks"),
    ("pose_landmarks", "pose_world_landmarks"),
    ("keypoints", "keypoints3D"),
    ("keypoints2d", "keypoints3d"),
    ("keypoints_2d", "keypoints_3d"),
    ("joints2d", "joints3d"),
    ("pred_keypoints_2d", "joints3d"),
];

/// Whether an object is a frame with something around its landmarks, rather than an object from names to landmarks.
pub(super) fn is_result(object: &Map<String, Value>) -> bool {
    IN_SPACE.iter().any(|field| object.contains_key(*field))
        || IN_PICTURE.iter().any(|(field, _)| object.get(*field).is_some_and(Value::is_array))
}

/// The landmarks of a frame that may be a result object with a time or a picture's places beside them; `Null` where nobody
/// was found. Of several persons, the first.
pub(super) fn landmarks_of<'a>(frame: &'a Value, place: &str) -> Result<&'a Value, PositionError> {
    let Value::Object(object) = frame else { return Ok(frame) };
    let Some(field) = IN_SPACE.iter().find(|field| object.contains_key(**field)) else {
        if let Some((field, right)) = IN_PICTURE.iter().find(|(f, _)| object.get(*f).is_some_and(Value::is_array)) {
            let found = format!("only `{field}`, which are places in the picture");
            return refuse(place, found, format!("positions in space, such as the result's `{right}`"));
        }
        return Ok(frame);
    };
    Ok(first_person(&object[*field]))
}

/// The first of several persons: a list of lists of landmarks in place of a list of landmarks.
fn first_person(value: &Value) -> &Value {
    match value {
        Value::Array(persons) if persons.is_empty() => &Value::Null,
        // A person is a list of landmarks, which are lists or objects themselves; or an object with a list in it.
        Value::Array(persons) => match &persons[0] {
            Value::Array(first) if first.first().is_some_and(|l| l.is_array() || l.is_object() || l.is_null()) => {
                &persons[0]
            }
            Value::Object(person) => match person.get("landmark").or_else(|| person.get("landmarks")) {
                Some(list) => list,
                None => value,
            },
            _ => value,
        },
        // Protocol buffers as JSON: {"landmark": [...]}.
        Value::Object(object) => object.get("landmark").unwrap_or(value),
        _ => value,
    }
}
