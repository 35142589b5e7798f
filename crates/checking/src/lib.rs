//! A content doctor for recordings.
//!
//! [`check`] looks at everything that a take tells of itself (rate and repeated frames, gaps, fit and
//! shape of bodies, usable segments) and compares what its header states with what the data says: the
//! unit of length with the size of the hand, the rotation order and the axes with markers that have to
//! stay in place on their bodies, the up axis with things that rest. Where there is no evidence the
//! answer says so; nothing is guessed and nothing is changed.
//!
//! [`ranked`] puts many takes in the order in which a person should look at them; [`to_text`],
//! [`to_markdown`] and [`to_json`] show them.
//!
//! ```
//! use inhand_checking::{CheckSettings, Level, check};
//! use inhand_model::{BodySource, PerFinger, Roles};
//! use inhand_simulation::{TakeSettings, simulate};
//!
//! let take = simulate(&TakeSettings { duration_s: 5.0, ..TakeSettings::cube("take") }, 7)?;
//! let roles = Roles {
//!     hand: BodySource::RigidBody("Hand".into()),
//!     object: None,
//!     fingers: PerFinger::from_fn(|f| ["Thumb", "Index", "Middle", "Ring", "Little"][f.index()].into()),
//! };
//! let checkup = check(&take.recording, Ok(&roles), &[], &CheckSettings::default());
//! assert!(checkup.level() <= Level::Info, "{:?}", checkup.results);
//! let units = checkup.result("units").ok_or("hand and fingers are there")?;
//! assert!(units.found.starts_with("metres agree with a hand of"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod check;
mod checkup;
mod rank;
mod settings;
mod suspicion;

mod json;
mod markdown;
mod text;

mod bodies;
mod convention;
mod gaps;
mod hand;
mod origin;
mod timing;
mod up;

mod numbers;
mod parts;
mod words;

pub use check::check;
pub use checkup::{CheckResult, Checkup, Level, MAX_PLACES, Number, Place, SegmentShare};
pub use json::to_json;
pub use markdown::to_markdown;
pub use rank::{Checked, ranked};
pub use settings::CheckSettings;
pub use suspicion::{Suspicion, SuspicionKind};
pub use text::to_text;
