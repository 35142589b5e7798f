//! Messages of package `foxglove` in JSON, as the types that protobuf has.

use ::foxglove::messages::{
    FrameTransform, FrameTransforms, PackedElementField, PointCloud, Pose, PoseInFrame,
    PosesInFrame, Quaternion, Timestamp, Vector3,
};
use data_encoding::BASE64_NOPAD;
use serde_json::Value;

use crate::reading::Fault;

/// Decodes a message; serde_json itself limits how deep values nest.
pub(super) fn decode<T>(
    message: &[u8],
    read: impl FnOnce(&Value) -> Result<T, Fault>,
) -> Result<T, Fault> {
    let value = serde_json::from_slice(message);
    read(&value.map_err(|error| Fault::new("JSON", error.to_string()))?)
}

pub(super) fn pose_in_frame(value: &Value) -> Result<PoseInFrame, Fault> {
    Ok(PoseInFrame {
        timestamp: timestamp(value),
        frame_id: text(value, "frame_id")?,
        pose: optional(value, "pose", pose)?,
    })
}

pub(super) fn poses_in_frame(value: &Value) -> Result<PosesInFrame, Fault> {
    Ok(PosesInFrame {
        timestamp: timestamp(value),
        frame_id: text(value, "frame_id")?,
        poses: list(value, "poses", pose)?,
    })
}

pub(super) fn frame_transforms(value: &Value) -> Result<FrameTransforms, Fault> {
    Ok(FrameTransforms {
        transforms: list(value, "transforms", frame_transform)?,
    })
}

pub(super) fn frame_transform(value: &Value) -> Result<FrameTransform, Fault> {
    Ok(FrameTransform {
        timestamp: timestamp(value),
        parent_frame_id: text(value, "parent_frame_id")?,
        child_frame_id: text(value, "child_frame_id")?,
        translation: optional(value, "translation", vector)?,
        rotation: optional(value, "rotation", quaternion)?,
    })
}

pub(super) fn point_cloud(value: &Value) -> Result<PointCloud, Fault> {
    let whole = |value: &Value, key: &'static str| {
        let number = value.get(key).and_then(Value::as_u64);
        (number.and_then(|number| u32::try_from(number).ok()))
            .ok_or_else(|| unexpected(value, key, "a whole number"))
    };
    Ok(PointCloud {
        timestamp: timestamp(value),
        frame_id: text(value, "frame_id")?,
        pose: optional(value, "pose", pose)?,
        point_stride: whole(value, "point_stride")?,
        fields: list(value, "fields", |field| {
            Ok(PackedElementField {
                name: text(field, "name")?,
                offset: whole(field, "offset")?,
                r#type: i32::try_from(whole(field, "type")?).unwrap_or(0),
            })
        })?,
        data: base64(&text(value, "data")?)?.into(),
    })
}

fn pose(value: &Value) -> Result<Pose, Fault> {
    Ok(Pose {
        position: optional(value, "position", vector)?,
        orientation: optional(value, "orientation", quaternion)?,
    })
}

fn vector(value: &Value) -> Result<Vector3, Fault> {
    Ok(Vector3 {
        x: number(value, "x")?,
        y: number(value, "y")?,
        z: number(value, "z")?,
    })
}

fn quaternion(value: &Value) -> Result<Quaternion, Fault> {
    Ok(Quaternion {
        x: number(value, "x")?,
        y: number(value, "y")?,
        z: number(value, "z")?,
        w: number(value, "w")?,
    })
}

/// Seconds and nanoseconds; `None`, as where there is none, for anything else.
fn timestamp(value: &Value) -> Option<Timestamp> {
    let time = value.get("timestamp")?;
    let seconds = u32::try_from(time.get("sec")?.as_u64()?).ok()?;
    let nanos = u32::try_from(time.get("nsec")?.as_u64()?).ok()?;
    (nanos < 1_000_000_000).then(|| Timestamp::new(seconds, nanos))
}

/// A number; null, as JSON writes what is none, is not one.
fn number(value: &Value, key: &'static str) -> Result<f64, Fault> {
    match value.get(key) {
        Some(Value::Null) => Some(f64::NAN),
        Some(found) => found.as_f64(),
        None => None,
    }
    .ok_or_else(|| unexpected(value, key, "a number"))
}

fn text(value: &Value, key: &'static str) -> Result<String, Fault> {
    (value.get(key).and_then(Value::as_str).map(str::to_owned))
        .ok_or_else(|| unexpected(value, key, "a text"))
}

fn optional<T>(
    value: &Value,
    key: &str,
    read: impl Fn(&Value) -> Result<T, Fault>,
) -> Result<Option<T>, Fault> {
    let present = value.get(key).filter(|part| !part.is_null());
    present.map(read).transpose()
}

fn list<T>(
    value: &Value,
    key: &'static str,
    read: impl Fn(&Value) -> Result<T, Fault>,
) -> Result<Vec<T>, Fault> {
    let parts = (value.get(key).and_then(Value::as_array))
        .ok_or_else(|| unexpected(value, key, "a list"))?;
    parts.iter().map(read).collect()
}

fn unexpected(value: &Value, key: &str, expected: &str) -> Fault {
    let found = value.get(key).map_or_else(
        || "nothing".to_owned(),
        |found| found.to_string().chars().take(40).collect(),
    );
    Fault::new(format!("{expected} as \"{key}\""), found)
}

/// Bytes of base64, with or without the signs that fill it up.
fn base64(text: &str) -> Result<Vec<u8>, Fault> {
    BASE64_NOPAD
        .decode(text.trim_end_matches('=').as_bytes())
        .map_err(|error| Fault::new("\"data\" in base64", error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_as_in_rfc_4648() {
        for (text, bytes) in [
            ("", &b""[..]),
            ("Zg==", b"f"),
            ("Zm8=", b"fo"),
            ("Zm9v", b"foo"),
            ("Zm9vYg==", b"foob"),
            ("Zm9vYmE", b"fooba"),
            ("+/+/", &[0xfb, 0xff, 0xbf]),
        ] {
            assert_eq!(base64(text).ok().as_deref(), Some(bytes), "{text}");
        }
        assert!(base64("Zm9vY").is_err());
        assert!(base64("Zm 9").is_err());
    }
}
