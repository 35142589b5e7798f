//! Rule for contact between fingertip and object.

/// More than rounding can do to a distance between a finger and the object in its hand, metres, so
/// that a distance of exactly tau is a contact; far below what any camera can tell apart.
const CONTACT_ROUNDING_M: f64 = 1e-12;

/// Whether a pad at this signed distance from the object's surface is in contact: within tau of it,
/// outside or inside. Not where the distance is not known.
pub fn in_contact(distance_m: f64, tau_m: f64) -> bool {
    distance_m.abs() <= tau_m + CONTACT_ROUNDING_M
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contact_is_near_from_either_side() {
        for (distance_m, touches) in [
            (0.0, true),
            (0.005, true),
            (-0.005, true),
            (0.1 + 0.2 - 0.295, true),
            (0.005_001, false),
            (-0.005_001, false),
            (f64::NAN, false),
        ] {
            assert_eq!(in_contact(distance_m, 0.005), touches, "{distance_m}");
        }
    }
}
