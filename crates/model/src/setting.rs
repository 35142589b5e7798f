//! Settings that a message can ask the user for.

use std::fmt;

use crate::names::named;

named! {
    /// A setting that decides what a file or take leaves open. Messages of libraries name it by its key in
    /// `inhand.toml`; a program may show its own word for it instead, as the command line shows flags.
    ///
    /// ```
    /// use inhand_model::Setting;
    ///
    /// assert_eq!(Setting::Units.to_string(), "`source.units`");
    /// ```
    pub enum Setting {
        /// Unit of length of a source file.
        Units = "source.units",
        /// Order of the Euler angles of a source file.
        RotationOrder = "source.rotation_order",
        /// Axis of a source file that points up.
        Up = "source.up",
        /// Body or markers of the hand.
        Hand = "roles.hand",
        /// Body or markers of the object.
        Object = "roles.object",
        /// Markers on the fingertips.
        Fingers = "fingers",
        /// Longest gap that processing fills.
        MaxGap = "process.max_gap_s",
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}`", self.name())
    }
}
