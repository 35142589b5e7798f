//! Settings that a message can ask the user for.

use std::fmt;

/// A setting that decides what a file or take leaves open. Messages of libraries name it by its key in
/// `inhand.toml`; a program may show its own word for it instead, as the command line shows flags.
///
/// ```
/// use inhand_model::Setting;
///
/// assert_eq!(Setting::Units.to_string(), "`source.units`");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// Unit of length of a source file.
    Units,
    /// Order of the Euler angles of a source file.
    RotationOrder,
    /// Axis of a source file that points up.
    Up,
    /// Body or markers of the hand.
    Hand,
    /// Body or markers of the object.
    Object,
    /// Markers on the fingertips.
    Fingers,
}

impl Setting {
    /// Every setting.
    pub const ALL: [Self; 6] = [
        Self::Units,
        Self::RotationOrder,
        Self::Up,
        Self::Hand,
        Self::Object,
        Self::Fingers,
    ];

    /// Key in `inhand.toml`.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Units => "source.units",
            Self::RotationOrder => "source.rotation_order",
            Self::Up => "source.up",
            Self::Hand => "roles.hand",
            Self::Object => "roles.object",
            Self::Fingers => "fingers",
        }
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}`", self.key())
    }
}
