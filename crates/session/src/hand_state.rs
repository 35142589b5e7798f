//! State of the hand: from a JSON file, or from a take at a time.
//!
//! ```json
//! {
//!   "fingertips_m": { "thumb": [0.03, -0.02, 0.08], "index": [0.05, 0.03, 0.09] },
//!   "velocity_m_s": { "thumb": [0.0, 0.0, 0.0] },
//!   "object": { "position_m": [0.04, 0.0, 0.1], "quaternion_xyzw": [0.0, 0.0, 0.0, 1.0] }
//! }
//! ```
//!
//! All in the frame of the hand; any part and any finger may be left out.

use std::fmt;
use std::path::{Path, PathBuf};

use inhand_model::{Finger, Hand, InputHash, Motion, Object, PerFinger, Pose, Position};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::error::SessionError;
use crate::files::{hex_sha256, name_of};
use crate::settings::Settings;
use crate::steps;
use crate::take;

/// How far from unit length a quaternion may be: what six written decimals leave.
const QUATERNION_TOLERANCE: f64 = 1e-3;

const EXPECTED: &str =
    "a state as JSON, such as {\"fingertips_m\": {\"thumb\": [0.03, -0.02, 0.08]}}";

/// Where fingertips and object are, and how fast the fingertips move; hand frame.
#[derive(Clone, Debug, PartialEq)]
pub struct HandState {
    /// Fingertip positions, metres, as far as they are known.
    pub fingertips_m: PerFinger<Option<[f64; 3]>>,
    /// Fingertip velocities, m/s, as far as they are known.
    pub velocity_m_s: PerFinger<Option<[f64; 3]>>,
    /// The object, where it is known.
    pub object: Option<Pose<Hand, Object>>,
    /// Where it comes from.
    pub source: InputHash,
    /// The file.
    pub path: PathBuf,
    /// The take's sample, where it comes from a take.
    pub sample: Option<usize>,
}

/// Which end of a motion a state is for: velocities are taken outside the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StateRole {
    /// The motion starts here: the velocity is that of arriving.
    Start,
    /// The motion ends here: the velocity is that of leaving.
    Goal,
}

/// The file of a state, and its time where it is a take's.
fn split(text: &str) -> (&Path, Option<&str>) {
    let at = text.rsplit_once('@').filter(|_| !Path::new(text).is_file());
    at.map_or((Path::new(text), None), |(path, time)| {
        (Path::new(path), Some(time))
    })
}

/// The file of a state, as [`read_state`] reads it.
pub fn state_file(text: &str) -> &Path {
    split(text).0
}

/// Reads a state: `FILE.json`, or `TAKE@SECONDS` for a take at a time since its first sample.
///
/// # Errors
///
/// [`SessionError::Data`] for a state that cannot be used, and what reading a take can give.
pub fn read_state(
    text: &str,
    role: StateRole,
    settings: &Settings,
) -> Result<HandState, SessionError> {
    let (path, Some(seconds)) = split(text) else {
        return from_json(Path::new(text));
    };
    let time_s = seconds.trim().trim_end_matches('s').parse::<f64>();
    let time_s = time_s.ok().filter(|t| t.is_finite()).ok_or_else(|| {
        let found = format!("\"{seconds}\"");
        fault(text, "a file, or a number of seconds after \"@\"", &found)
    })?;
    from_take(path, time_s, role, settings)
}

fn fault(place: &str, expected: &str, found: &str) -> SessionError {
    SessionError::data(place, format!("expected {expected}, found {found}"))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StateJson {
    #[serde(default)]
    fingertips_m: Entries,
    #[serde(default)]
    velocity_m_s: Entries,
    object: Option<ObjectJson>,
}

/// The entries of a map in the order they stand, so that one that comes twice is seen.
#[derive(Default)]
struct Entries(Vec<(String, [f64; 3])>);

impl<'de> Deserialize<'de> for Entries {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Collect;
        impl<'de> Visitor<'de> for Collect {
            type Value = Entries;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("fingers with three numbers each")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Entries, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(Entries(entries))
            }
        }
        deserializer.deserialize_map(Collect)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectJson {
    position_m: [f64; 3],
    quaternion_xyzw: [f64; 4],
}

fn from_json(path: &Path) -> Result<HandState, SessionError> {
    let bytes = std::fs::read(path).map_err(SessionError::io("read", path))?;
    let place = path.display().to_string();
    let state: StateJson = serde_json::from_slice(&bytes).map_err(|error| {
        let found = match error.is_data() {
            true => error.to_string(),
            false => format!("no JSON at line {} column {}", error.line(), error.column()),
        };
        fault(&place, EXPECTED, &found)
    })?;
    Ok(HandState {
        fingertips_m: tips(&place, "fingertips_m", &state.fingertips_m)?,
        velocity_m_s: tips(&place, "velocity_m_s", &state.velocity_m_s)?,
        object: (state.object)
            .map(|object| pose(&place, &object))
            .transpose()?,
        source: InputHash {
            name: name_of(path),
            sha256: hex_sha256(&bytes),
        },
        path: path.to_owned(),
        sample: None,
    })
}

fn tips(
    place: &str,
    key: &str,
    values: &Entries,
) -> Result<PerFinger<Option<[f64; 3]>>, SessionError> {
    let mut tips: PerFinger<Option<[f64; 3]>> = PerFinger::default();
    for (name, value) in &values.0 {
        let finger: Finger = name.parse().map_err(|_| {
            let found = format!("\"{name}\" in {key}");
            fault(place, "thumb, index, middle, ring or little", &found)
        })?;
        if tips[finger].replace(*value).is_some() {
            let found = format!("{finger} twice in {key}");
            return Err(fault(place, "each finger once", &found));
        }
    }
    Ok(tips)
}

fn pose(place: &str, object: &ObjectJson) -> Result<Pose<Hand, Object>, SessionError> {
    let [x, y, z, w] = object.quaternion_xyzw;
    let quaternion = Quaternion::new(w, x, y, z);
    let length = quaternion.norm();
    if (length - 1.0).abs() > QUATERNION_TOLERANCE {
        let found = format!("quaternion_xyzw of length {length}");
        return Err(fault(place, "a quaternion of unit length", &found));
    }
    let translation = Translation3::from(object.position_m);
    let rotation = UnitQuaternion::new_normalize(quaternion);
    Ok(Pose::new(Isometry3::from_parts(translation, rotation)))
}

fn from_take(
    path: &Path,
    time_s: f64,
    role: StateRole,
    settings: &Settings,
) -> Result<HandState, SessionError> {
    let mut take = take::read_clean(path, settings)?;
    let motions = steps::motions(std::slice::from_mut(&mut take), settings)?.published;
    let motion = (motions.first()).expect("as many motions as takes were given");
    let rate_hz = motion.clock.rate_hz();
    let last_s = motion.len().saturating_sub(1) as f64 / rate_hz;
    let place = format!("{}@{time_s}", path.display());
    if motion.is_empty() || time_s < 0.0 || time_s > last_s {
        let expected = format!("a time from 0 to {last_s:.3} s");
        return Err(fault(&place, &expected, &format!("{time_s} s")));
    }
    let k = (time_s * rate_hz).round() as usize;
    let at = |k: usize, finger: Finger| {
        let track = &motion.fingertips[finger];
        (k < track.len())
            .then(|| track.get(k).map(Position::to_array))
            .flatten()
    };
    let fingertips_m = PerFinger::from_fn(|finger| at(k, finger));
    if fingertips_m.as_array().iter().all(Option::is_none) {
        return Err(fault(
            &place,
            "a fingertip that was seen",
            "five missing ones",
        ));
    }
    let margin = (settings.segments.margin_s * rate_hz).round().max(1.0) as usize;
    let (from, to) = match role {
        StateRole::Start => (k.checked_sub(margin), Some(k)),
        StateRole::Goal => (Some(k), Some(k + margin)),
    };
    let velocity_m_s = PerFinger::from_fn(|finger| {
        let (a, b) = (at(from?, finger)?, at(to?, finger)?);
        let per_second = rate_hz / margin as f64;
        Some([0, 1, 2].map(|axis| (b[axis] - a[axis]) * per_second))
    });
    Ok(HandState {
        fingertips_m,
        velocity_m_s,
        object: object_at(motion, k),
        source: take.hash.clone(),
        path: path.to_owned(),
        sample: Some(k),
    })
}

fn object_at(motion: &Motion, k: usize) -> Option<Pose<Hand, Object>> {
    let track = motion.object.as_ref()?;
    (k < track.len()).then(|| track.get(k)).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<HandState, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("goal.json");
        std::fs::write(&path, text).unwrap();
        let settings = Settings::default();
        read_state(path.to_str().unwrap(), StateRole::Goal, &settings).map_err(|e| e.to_string())
    }

    #[test]
    fn any_part_may_be_left_out() {
        let state = read(r#"{"fingertips_m": {"Thumb": [1, 2, 3]}}"#).unwrap();
        assert_eq!(state.fingertips_m[Finger::Thumb], Some([1.0, 2.0, 3.0]));
        assert_eq!(state.fingertips_m[Finger::Index], None);
        assert_eq!(state.object, None);
        let state =
            read(r#"{"object": {"position_m": [0, 0, 1], "quaternion_xyzw": [0, 0, 1, 0]}}"#);
        let turned = state.unwrap().object.unwrap();
        assert_eq!(turned.quaternion_xyzw(), [0.0, 0.0, 1.0, 0.0]);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, reason) in [
            (
                r#"{"fingertips_m": {"pinkie": [1, 2, 3]}}"#,
                "\"pinkie\" in fingertips_m",
            ),
            (r#"{"fingertips_m": {"thumb": [1, 2]}}"#, "line 1"),
            (r#"{"fingertips_m": {"thumb": [1, 2, null]}}"#, "line 1"),
            (
                r#"{"fingertips_m": {"thumb": [1, 2, 3], "THUMB": [1, 2, 3]}}"#,
                "twice",
            ),
            (
                r#"{"fingertips_m": {"thumb": [1, 2, 3], "thumb": [1, 2, 4]}}"#,
                "twice",
            ),
            (r#"{"tips": {}}"#, "unknown field"),
            (
                r#"{"object": {"position_m": [0, 0, 1], "quaternion_xyzw": [0, 0, 2, 0]}}"#,
                "length 2",
            ),
            ("", "JSON"),
        ] {
            let error = read(text).unwrap_err();
            assert!(
                error.contains(reason) && error.contains("goal.json"),
                "{error}"
            );
        }
        let settings = Settings::default();
        let error = read_state("take.mcap@soon", StateRole::Start, &settings).unwrap_err();
        assert!(error.to_string().contains("\"soon\""), "{error}");
    }
}
