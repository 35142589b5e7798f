//! Roles of bodies and markers: the hand, the object, the fingertips.
//!
//! Names decide, by fixed rules and never by a guess: where a take leaves a choice, the answer is
//! an error that lists what the take contains and how to say which is meant.
//!
//! * **Fingers**: a labelled marker whose name, after a prefix that ends with a colon, is made of
//!   the finger's name and words that do not matter (`Thumb`, `thumb_tip`, `Hand:Index`,
//!   `RightMiddleFinger`, `Pinky`). A name with a joint or a second finger word is no fingertip
//!   (`index_knuckle`, `thumb_middle`, `middle_middle`).
//! * **Hand**: the one rigid body called hand (`Hand`, `RightHand`, `hand_back`), else the one bone,
//!   else the one cluster of at least three markers whose names share such a prefix (`hand_top`,
//!   `hand_left`, `hand_right`).
//! * **Object**: the one rigid body called `Object`, `cube5`, `cylinder`, ..., else the one cluster
//!   of such a prefix, else none. Any other body or cluster is the object only where the user says
//!   so.
//!
//! ```
//! # use inhand_model::*;
//! # use inhand_capture::roles::{self, RoleSettings};
//! # let names = ["hand_top", "hand_left", "hand_right", "thumb_tip", "thumb_middle", "index_tip",
//! #     "middle_tip", "middle_middle", "ring_tip", "little_tip", "pillow_top", "pillow_left",
//! #     "pillow_right"];
//! # let header = format!("NO_OF_FRAMES\t1\nFREQUENCY\t100\nMARKER_NAMES\t{}\n", names.join("\t"));
//! # let tsv = header + &["1.0"; 39].join("\t") + "\n";
//! # let recording = inhand_capture::read(tsv.as_bytes(), "take.tsv", &Default::default()).unwrap();
//! // A take with hand_top, hand_left, hand_right, *_tip, thumb_middle, middle_middle, pillow_*.
//! let mut settings = RoleSettings::default();
//! let found = roles::resolve(&recording, &settings)?;
//! assert_eq!(found.fingers[Finger::Middle], "middle_tip");
//! assert_eq!(found.object, None); // no setting says that the pillow is the object
//!
//! settings.object = Some("pillow".parse()?);
//! let set = roles::resolve(&recording, &settings)?;
//! let pillow = ["pillow_top", "pillow_left", "pillow_right"].map(String::from);
//! assert_eq!(set.object, Some(BodySource::Markers(pillow.to_vec())));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bodies;
mod error;
mod fingers;
mod words;

pub use error::RoleError;
pub use fingers::fingertips;

use std::str::FromStr;

use inhand_model::{BodySource, PerFinger, Recording, Roles};

/// Roles that the user sets; the others are found by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RoleSettings {
    /// Source of the hand's pose.
    pub hand: Option<BodyChoice>,
    /// Source of the object's pose.
    pub object: Option<BodyChoice>,
    /// Marker on each fingertip, by name.
    pub fingers: PerFinger<Option<String>>,
    /// The take has no object, whatever its names suggest.
    pub no_object: bool,
}

impl RoleSettings {
    /// These settings, and roles that were found earlier where they say nothing. A marker that moves to another finger
    /// leaves its earlier one.
    #[must_use]
    pub fn or_stored(&self, stored: &Roles) -> Self {
        let body = |source: &BodySource| match source {
            BodySource::RigidBody(name) => BodyChoice::Named(name.clone()),
            BodySource::Markers(names) => BodyChoice::Markers(names.clone()),
        };
        let moved = |marker: &&String| {
            (self.fingers.iter()).any(|(_, other)| other.as_ref() == Some(*marker))
        };
        let object = stored.object.as_ref().filter(|_| !self.no_object);
        let object = self.object.clone().or_else(|| object.map(body));
        Self {
            hand: self.hand.clone().or_else(|| Some(body(&stored.hand))),
            no_object: object.is_none(),
            object,
            fingers: PerFinger::from_fn(|finger| {
                let stored = Some(&stored.fingers[finger]).filter(|marker| !moved(marker));
                self.fingers[finger].as_ref().or(stored).cloned()
            }),
        }
    }
}

/// Source of a body's pose, as the user sets it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BodyChoice {
    /// A rigid body or bone by name; where there is none of that name, the cluster of markers whose
    /// names start with it.
    Named(String),
    /// Three or more markers by name. The first two give the x axis, the first three the plane.
    Markers(Vec<String>),
}

/// Too few names for a cluster.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{text}\" names {found} markers: expected one body name, or three or more different marker \
     names separated by commas"
)]
pub struct BodyChoiceError {
    /// The text.
    pub text: String,
    /// Different names in it.
    pub found: usize,
}

impl FromStr for BodyChoice {
    type Err = BodyChoiceError;

    /// `Hand` names a body; `hand_top,hand_left,hand_right` names a cluster.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut names: Vec<String> = Vec::new();
        for name in text.split(',').map(str::trim).filter(|n| !n.is_empty()) {
            if !names.iter().any(|known| known == name) {
                names.push(name.to_owned());
            }
        }
        match (names.len(), text.contains(',')) {
            (1, false) => Ok(BodyChoice::Named(names.swap_remove(0))),
            (3.., _) => Ok(BodyChoice::Markers(names)),
            (found, _) => Err(BodyChoiceError {
                text: text.to_owned(),
                found,
            }),
        }
    }
}

/// Whether a name alone says that its marker is on a fingertip.
///
/// ```
/// use inhand_capture::roles::is_fingertip_name;
///
/// assert!(is_fingertip_name("thumb_tip") && !is_fingertip_name("index_knuckle"));
/// ```
pub fn is_fingertip_name(name: &str) -> bool {
    words::fingertip(name).is_some()
}

/// The roles of a take's bodies and markers: what the user says, completed by name.
///
/// # Errors
///
/// [`RoleError`] where a role stays open or could go to more than one, and where the user names
/// something that the take does not have. It lists what the take contains.
pub fn resolve(recording: &Recording, settings: &RoleSettings) -> Result<Roles, RoleError> {
    // An error is about what the user named before it is about what is still open.
    for (choice, role) in [(&settings.hand, "hand"), (&settings.object, "object")] {
        if let Some(choice) = choice {
            bodies::chosen(recording, choice, role, &PerFinger::default())?;
        }
    }
    let fingers = fingertips(recording, settings)?;
    let hand = bodies::hand(recording, settings, &fingers)?;
    let object = bodies::object(recording, settings, &fingers, &hand)?;
    Ok(Roles {
        hand,
        object,
        fingers,
    })
}
