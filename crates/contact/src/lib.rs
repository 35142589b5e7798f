//! Distances, contacts and hulls of fingertips and objects.
//!
//! Three questions about five fingertips, as *In-hand manipulation planning using human motion
//! dictionary* (arXiv 2308.15153) asks them:
//!
//! * **Do they touch the object?** [`surface_distance_m`] is the exact signed distance to a box or
//!   cylinder (by parry, whose types stay in here), [`FingerOffsets`] takes off the way from marker to
//!   pad; [`SurfaceCloud`] measures to points on the surface instead, as the paper does.
//! * **Do they touch one another?** [`nearest_pair_m`].
//! * **Have they been there before?** [`hull`] makes the convex hull of all positions of a fingertip
//!   in the training takes, [`inside`] and [`hull_distance_m`] say whether and how far a planned
//!   position is in it, [`HullProbe`] the same for whole trajectories.
//!
//! And of what touches over time: [`ContactSeries`] finds makes, breaks and states of contact, [`slip_m`] how
//! far pads move over the object meanwhile, [`phases`](fn@phases) in-grasp manipulation, finger gaiting and regrasps.
//!
//! Signs are the same everywhere: negative inside, 0 on the surface, positive outside. Lengths are
//! metres.
//!
//! ```
//! use inhand_contact::{nearest_pair_m, surface_distance_m};
//! use inhand_model::{Finger, Hand, Object, PerFinger, Pose, Position, Shape};
//! use nalgebra::Isometry3;
//!
//! // A cube of 50 mm whose centre is 100 mm in front of the hand, thumb and index on two faces.
//! let cube: Shape = "cube:0.05".parse()?;
//! let hand_from_object = Pose::<Hand, Object>::new(Isometry3::translation(0.1, 0.0, 0.0));
//! let tips = PerFinger::new([-0.027, 0.025, 0.04, 0.06, 0.08])
//!     .map(|y| Position::<Hand>::new(0.1, y, 0.0));
//!
//! let object_from_hand = hand_from_object.inverse();
//! let distance_m = tips.map(|tip| surface_distance_m(&cube, object_from_hand * tip));
//! assert!((distance_m[Finger::Thumb] - 0.002).abs() < 1e-12);
//! assert!(distance_m[Finger::Index].abs() < 1e-12);
//!
//! let (nearest_m, a, b) = nearest_pair_m(&tips);
//! assert!((nearest_m - 0.015).abs() < 1e-12);
//! assert_eq!((a, b), (Finger::Index, Finger::Middle));
//! # Ok::<(), inhand_model::ShapeError>(())
//! ```

mod cloud;
mod error;
mod events;
mod grid;
mod hull;
mod pair;
mod phases;
mod surface;

pub use cloud::SurfaceCloud;
pub use error::ContactError;
pub use events::{Contact, ContactSeries};
pub use hull::{HullProbe, hull, hull_distance_m, inside};
pub use pair::nearest_pair_m;
pub use phases::phases;
pub use surface::{FingerOffsets, slip_m, surface_distance_m};
