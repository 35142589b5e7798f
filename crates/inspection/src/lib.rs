//! Inspection of recordings: suspect samples, content checks, cleaning.
//!
//! * [`detect`] finds flipped bodies, swapped fingertips, spikes and lost labels, each with a range of
//!   samples, a score and a suggested repair. Nothing is changed.
//! * [`check()`] compares what a take's header states with what its data says (rate and repeated
//!   frames, gaps, fit and shape of bodies, unit of length, rotation order, axes, usable segments).
//!   Where there is no evidence the result says so. [`ranked`] puts many takes in the order in which a
//!   person should look at them; [`to_text`], [`to_markdown`] and [`to_json`] show them.
//! * [`TakeLook`] runs both on a take of a session, [`inspect()`] compares takes and looks at settings,
//!   [`inspect_results`] adds what only results show.
//! * [`clean()`] repairs, fills and resamples a recording. [`repair()`], [`fill`], [`to_pads`] and
//!   [`resample`] are its steps. Every step lists what it changed as [`Change`](inhand_model::Change)s.
//!
//! Nothing reads or writes files.
//!
//! ```
//! use inhand_inspection::{CheckSettings, Level, check};
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

pub mod detect;

mod check;
mod clean;
mod coverage;
mod session;
mod smoothing;
mod suspect;
mod take_gaps;

mod continuity;
mod geometry;
mod lookup;
mod statistics;

pub use check::*;
pub use clean::*;
pub use coverage::{Coverage, Presence};
pub use session::*;
pub use smoothing::{Smoothing, smoothing};
pub use suspect::*;
pub use take_gaps::take_gaps;
