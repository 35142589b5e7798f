//! One colour per finger, the same in viewers and reports.

use inhand_model::{Finger, PerFinger};

/// An sRGB colour, red, green, blue.
pub type Rgb = [u8; 3];

/// Colour of each finger: five of the eight colours that Okabe and Ito chose so that people with
/// any common form of colour blindness can distinguish them ("Color Universal Design", 2008).
pub const FINGER_COLOURS: PerFinger<Rgb> = PerFinger::new([
    [0xE6, 0x9F, 0x00],
    [0x56, 0xB4, 0xE9],
    [0x00, 0x9E, 0x73],
    [0xD5, 0x5E, 0x00],
    [0xCC, 0x79, 0xA7],
]);

/// Colours of generated motion, by the place of the method among those of a file. None is a finger's, so
/// that planned and recorded fingertips are never mistaken for each other; they differ in lightness as
/// well as in hue, and all of them contrast with a dark as with a light background.
pub const METHOD_COLOURS: [Rgb; 7] = [
    [0xF0, 0xE4, 0x42],
    [0xA6, 0x6C, 0xFF],
    [0x9E, 0x9E, 0x9E],
    [0x2F, 0x6B, 0xD8],
    [0xA0, 0x6A, 0x3C],
    [0xA8, 0xC8, 0x2E],
    [0xE8, 0x3E, 0x5C],
];

/// Colour of the method at this place; after the last one they repeat.
///
/// ```
/// use inhand_channels::{METHOD_COLOURS, method_colour};
///
/// assert_eq!(method_colour(0), METHOD_COLOURS[0]);
/// assert_eq!(method_colour(METHOD_COLOURS.len()), METHOD_COLOURS[0]);
/// ```
pub const fn method_colour(place: usize) -> Rgb {
    METHOD_COLOURS[place % METHOD_COLOURS.len()]
}

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
