//! One colour per finger, the same in viewers and reports.

use inhand_model::{Finger, PerFinger};

/// An sRGB colour, red, green, blue.
pub type Rgb = [u8; 3];

/// Colour of each finger: five of the eight colours that Okabe and Ito chose so that people with
/// any common form of colour blindness can tell them apart ("Color Universal Design", 2008).
pub const FINGER_COLOURS: PerFinger<Rgb> = PerFinger::new([
    [0xE6, 0x9F, 0x00],
    [0x56, 0xB4, 0xE9],
    [0x00, 0x9E, 0x73],
    [0xD5, 0x5E, 0x00],
    [0xCC, 0x79, 0xA7],
]);

/// A finger's colour as `#RRGGBB`.
///
/// ```
/// use inhand_channels::finger_hex;
/// use inhand_model::Finger;
///
/// assert_eq!(finger_hex(Finger::Thumb), "#E69F00");
/// assert_eq!(finger_hex(Finger::Little), "#CC79A7");
/// ```
pub fn finger_hex(finger: Finger) -> String {
    let [red, green, blue] = FINGER_COLOURS[finger];
    format!("#{red:02X}{green:02X}{blue:02X}")
}
