//! Smooth curves through boundary conditions, and measures of motion.
//!
//! * [`curves`]: the four baselines, which learn nothing.
//! * [`velocity`]: velocities between neighbouring samples, of a trajectory or over takes.
//! * [`smoothness`]: path length, speed, spectral arc length, dimensionless jerk.
//! * [`warping`]: time-warped distance of two motions, the nearest of many.
//!
//! ```
//! use inhand_model::{EndConditions, SegmentLayout};
//! use inhand_curves::{curves, velocity};
//!
//! // Every coordinate goes from 0 to 99 mm in 0.99 s, at rest before and after.
//! let ends = EndConditions {
//!     first_m: [0.0; 15],
//!     last_m: [0.099; 15],
//!     first_velocity_m_s: [0.0; 15],
//!     last_velocity_m_s: [0.0; 15],
//!     object: None,
//! };
//! let layout = SegmentLayout::one_second(100.0);
//! let line = curves::line(&ends, layout);
//! assert!((line.configuration_m(33)[0] - 0.033).abs() < 1e-15);
//!
//! // The straight line moves at 0.1 m/s throughout.
//! let speeds: Vec<f64> = velocity::steps(&line).iter().map(|v| v[0]).collect();
//! assert_eq!(speeds.len(), 99);
//! assert!(speeds.iter().all(|speed| (speed - 0.1).abs() < 1e-12));
//! ```

pub mod curves;
pub mod smoothness;
pub mod velocity;
pub mod warping;
