//! A simulated hand that turns a cube, box or cylinder in its fingers, with ground truth.
//!
//! A take is made in three steps, each a module:
//!
//! 1. a *choreography*: the object strokes about and along the axes of the hand frame and comes
//!    back, in minimum-jerk steps with pauses; between strokes fingers lift, move and are set down
//!    again, one or two at a time, so that three or more always touch;
//! 2. a *slow motion of the hand* in the world;
//! 3. a *capture*: marker noise, least-squares fits of the rigid bodies to their noisy markers,
//!    quaternions that flip their sign, gaps; shaped like a Motive recording.
//!
//! [`simulate_faulty`] plants what goes wrong in real captures on top (swapped labels, flipped bodies,
//! spikes, lost labels) and says where.
//!
//! Fingertips touch exactly: without noise a fingertip in contact lies on the surface, and while
//! it touches it does not move in the object's frame (no rolling, no slipping). The same settings
//! and seed give the same take bit by bit, whatever the number of threads.
//!
//! ```
//! use inhand_model::Finger;
//! use inhand_simulation::{TakeSettings, simulate};
//!
//! let settings = TakeSettings { duration_s: 5.0, ..TakeSettings::cube("short") };
//! let take = simulate(&settings, 7)?;
//! assert_eq!(take.recording.len(), 500);
//! let measured = take.recording.marker("Thumb").and_then(|m| m.track.get(250));
//! let truth = take.truth.fingertips[Finger::Thumb][250];
//! assert!(measured.is_some_and(|measured| measured.distance_m(truth) < 1e-3));
//! # Ok::<(), inhand_simulation::SimulationError>(())
//! ```
//!
//! Axes of the hand frame: x towards the little finger, y along the fingers, z out of the palm;
//! the origin is the centroid of the markers on the back of the hand. The object's axes are
//! parallel to them when it is at home. The world is y up.

mod settings;

mod session;
mod take;

mod choreography;

mod grasp;
mod motion;
mod surface;

mod camera_system;

mod faults;

mod curves;
mod error;
mod random;

pub use error::SimulationError;
pub use faults::{FaultSettings, FaultyTake, simulate_faulty};
pub use session::{SessionSettings, SimulatedSession, session};
pub use settings::{GapSettings, TakeSettings};
pub use take::{Fault, FaultKind, SimulatedTake, Truth, simulate};
