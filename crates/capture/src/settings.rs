//! Settings that supply what a file does not state.

use std::fmt::Display;

use inhand_model::{LengthUnit, RotationOrder, Setting, UpAxis};

use crate::error::CaptureError;

/// Facts about a file that the user states. They only fill in what the file leaves open: a value that
/// contradicts the file's own statement is an error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadSettings {
    /// Unit of the file's lengths.
    pub length_unit: Option<LengthUnit>,
    /// Notation of the file's rotations.
    pub rotation_order: Option<RotationOrder>,
    /// Axis of the file's world that points up.
    pub up_axis: Option<UpAxis>,
}

/// A unit of length by its name, abbreviation, singular or plural: `mm`, `Millimeters`, `metres`.
pub fn parse_length_unit(name: &str) -> Option<LengthUnit> {
    let name = name.trim().to_ascii_lowercase();
    Some(match name.strip_suffix('s').unwrap_or(&name) {
        "m" | "meter" | "metre" => LengthUnit::Metres,
        "cm" | "centimeter" | "centimetre" => LengthUnit::Centimetres,
        "mm" | "millimeter" | "millimetre" => LengthUnit::Millimetres,
        "in" | "inch" | "inche" => LengthUnit::Inches,
        "ft" | "foot" | "feet" => LengthUnit::Feet,
        _ => return None,
    })
}

/// `quaternion`, or the axes of three Euler angles in the order in which they apply: `XYZ`, `zyx`,
/// `Euler ZXY`. Each axis appears once, as in Motive, which offers no other orders.
pub fn parse_rotation_order(name: &str) -> Option<RotationOrder> {
    let name = name.trim().to_ascii_lowercase();
    if name.starts_with("quaternion") {
        return Some(RotationOrder::Quaternion);
    }
    let order = name.strip_prefix("euler").unwrap_or(&name).trim();
    let axes: [u8; 3] = order.as_bytes().try_into().ok()?;
    let axes = axes.map(|letter| letter.wrapping_sub(b'x'));
    let mut sorted = axes;
    sorted.sort_unstable();
    (sorted == [0, 1, 2]).then_some(RotationOrder::Euler(axes))
}

/// An up axis by its letter: `y`, `Z`.
pub fn parse_up_axis(name: &str) -> Option<UpAxis> {
    match name.trim() {
        "y" | "Y" => Some(UpAxis::Y),
        "z" | "Z" => Some(UpAxis::Z),
        _ => None,
    }
}

/// The file's statement, else the user's, else nothing.
///
/// # Errors
///
/// Both are there and differ.
pub(crate) fn settle<T: Copy + PartialEq, N: Display>(
    file: &str,
    setting: Setting,
    stated: Option<T>,
    given: Option<T>,
    name: impl Fn(T) -> N,
) -> Result<Option<T>, CaptureError> {
    match (stated, given) {
        (Some(stated), Some(given)) if stated != given => {
            let (given, stated) = (name(given), name(stated));
            Err(CaptureError::contradiction(file, setting, given, stated))
        }
        (stated, given) => Ok(stated.or(given)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_units_orders_and_axes() {
        for (name, unit) in [
            ("Meters", Some(LengthUnit::Metres)),
            ("metre", Some(LengthUnit::Metres)),
            ("m", Some(LengthUnit::Metres)),
            ("Millimeters", Some(LengthUnit::Millimetres)),
            ("MM", Some(LengthUnit::Millimetres)),
            ("centimetres", Some(LengthUnit::Centimetres)),
            ("inches", Some(LengthUnit::Inches)),
            ("Feet", Some(LengthUnit::Feet)),
            ("furlongs", None),
            ("", None),
        ] {
            assert_eq!(parse_length_unit(name), unit, "{name}");
        }
        for (name, order) in [
            ("Quaternion", Some(RotationOrder::Quaternion)),
            ("XYZ", Some(RotationOrder::Euler([0, 1, 2]))),
            ("Euler zyx", Some(RotationOrder::Euler([2, 1, 0]))),
            ("XYX", None),
            ("XY", None),
            ("ABC", None),
            ("", None),
        ] {
            assert_eq!(parse_rotation_order(name), order, "{name}");
        }
        assert_eq!(parse_up_axis("Z"), Some(UpAxis::Z));
        assert_eq!(parse_up_axis("x"), None);
    }

    #[test]
    fn a_setting_may_agree_but_not_contradict() {
        let resolve = |stated, given| settle("a.csv", Setting::Up, stated, given, UpAxis::name);
        assert_eq!(resolve(None, None).unwrap(), None);
        assert_eq!(resolve(None, Some(UpAxis::Z)).unwrap(), Some(UpAxis::Z));
        assert_eq!(
            resolve(Some(UpAxis::Z), Some(UpAxis::Z)).unwrap(),
            Some(UpAxis::Z)
        );
        let error = resolve(Some(UpAxis::Z), Some(UpAxis::Y)).unwrap_err();
        assert_eq!(
            error.to_string(),
            "a.csv: `source.up` says y, but the file itself states z: leave `source.up` out"
        );
    }
}
