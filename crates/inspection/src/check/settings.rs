//! Thresholds of the checks. The defaults are what people and cameras usually do.

use inhand_motion::{GapFill, ProcessSettings};

/// Limits of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckSettings {
    /// How the take would be processed: its longest gap filled says which gaps stay open.
    pub process: ProcessSettings,
    /// Time kept free at both ends of an interval when it is cut, seconds.
    pub margin_s: f64,
    /// How much of a segment may be missing, seconds.
    pub missing_s: f64,
    /// Share of samples missing from which a finger, the hand or the object is useless.
    pub useless_share: f64,
    /// Share of usable segments below which a take is worth a look.
    pub usable_share: f64,
    /// Shortest time for which a marker that reports the very same numbers counts as frozen, seconds.
    pub frozen_s: f64,
    /// Mean marker error of a body (median over the take) above which its fit is doubtful, metres.
    pub marker_error_m: f64,
    /// Change of distance between markers of one rigid body (95 % of samples) above which it is not
    /// rigid, metres...
    pub rigid_m: f64,
    /// ...and the same relative to the distance; the larger one counts.
    pub rigid_share: f64,
    /// Change of the median distance between two of its markers over the take, metres, above which
    /// it counts as drift.
    pub drift_m: f64,
    /// Shortest and longest plausible distance from the body on the back of the hand to the
    /// furthest fingertip (median over the take), metres.
    pub hand_reach_m: [f64; 2],
    /// Speed of rotation that no hand and no held object has, rad/s.
    pub turn_rad_s: f64,
}

impl Default for CheckSettings {
    /// Gaps up to 0.1 s are filled and 40 ms are kept free, as in the method. Hands of adults reach
    /// 7 to 18 cm from the back of the hand to the furthest fingertip, from closed to stretched; the
    /// limits leave room for children, for bodies worn at the wrist and for odd postures.
    fn default() -> Self {
        Self {
            process: ProcessSettings {
                max_gap_s: 0.1,
                fill: GapFill::Cubic,
                filter: inhand_motion::Filter::None,
                object_offset_m: [0.0; 3],
            },
            margin_s: 0.04,
            missing_s: 0.0,
            useless_share: 0.5,
            usable_share: 0.9,
            frozen_s: 0.1,
            marker_error_m: 1e-3,
            rigid_m: 2e-3,
            rigid_share: 0.03,
            drift_m: 1e-3,
            hand_reach_m: [0.055, 0.26],
            turn_rad_s: 60.0,
        }
    }
}
