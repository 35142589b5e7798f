//! Motion of a fingertip over the object while it touches.
//!
//! A pad that holds a point of the object stays where it is in the object's frame, however hand and object
//! move. What it does move there is *apparent slip*: sliding, rolling of the round fingertip and give of its
//! pulp together, which a marker cannot tell apart, and noise. It is measured on the surface: every pad
//! position is moved to its nearest point there first, so that pressing the pulp in counts nothing.
//!
//! Noise makes a path longer with every sample (0.1 mm at 100 Hz: some 2 cm a second) but a displacement
//! only once; the displacement is the number to trust, and the path that of filtered motion.

use inhand_model::{Object, Position, Shape};

use crate::events::Contact;
use crate::surface::surface_point;

/// Apparent slip during one contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slip {
    /// Straight distance (the chord) between the first and the last known pad position on the surface, metres.
    pub displacement_m: f64,
    /// The farthest from the first position, metres.
    pub excursion_m: f64,
    /// Sum of the steps between neighbouring samples that are both known, metres.
    pub path_m: f64,
    /// The fastest of those steps, m/s.
    pub peak_speed_m_s: f64,
    /// Path over the time of those steps, m/s.
    pub mean_speed_m_s: f64,
    /// How many those steps are.
    pub steps: usize,
    /// Samples of the contact at which the pad's position is missing.
    pub missing: usize,
}

/// Apparent slip of a pad during `contact`; `pad` holds its position in the object's frame at every sample
/// of the take (`object_from_hand * hand_tip`), `None` where tip or object is missing.
///
/// `None` unless two neighbouring samples of the contact are known, for a contact outside the take, and
/// for a rate that is not positive. Steps across missing samples are left out: path and speeds are of what
/// was seen.
///
/// ```
/// use inhand_contact::{events::Contact, slip::slip};
/// use inhand_model::{Position, Shape};
///
/// // A pad 1 mm above the top of a cube goes 3 mm along x and 4 mm along y in two steps.
/// let pad = [[0.0, 0.0], [0.003, 0.0], [0.003, 0.004]]
///     .map(|[x, y]| Some(Position::new(x, y, 0.026)));
/// let contact = Contact { samples: 0..3, made: false, broken: false };
/// let cube = Shape::Cuboid { edges_m: [0.05; 3] };
/// let slip = slip(&cube, &pad, &contact, 100.0).unwrap();
/// assert!((slip.displacement_m - 0.005).abs() < 1e-12);
/// assert!((slip.path_m - 0.007).abs() < 1e-12);
/// assert!((slip.peak_speed_m_s - 0.4).abs() < 1e-12);
/// ```
pub fn slip(
    shape: &Shape,
    pad: &[Option<Position<Object>>],
    contact: &Contact,
    rate_hz: f64,
) -> Option<Slip> {
    if !(rate_hz > 0.0 && rate_hz.is_finite()) {
        return None;
    }
    let on_surface: Vec<Option<Position<Object>>> = (pad.get(contact.samples.clone())?.iter())
        .map(|pad| pad.and_then(|pad| surface_point(shape, pad)))
        .collect();
    let mut known = on_surface.iter().flatten();
    let first = *known.next()?;
    let last = *known.next_back()?;
    let steps_m: Vec<f64> = (on_surface.windows(2))
        .filter_map(|pair| Some(pair[1]?.distance_m(pair[0]?)))
        .collect();
    if steps_m.is_empty() {
        return None;
    }
    let largest = |lengths: &mut dyn Iterator<Item = f64>| lengths.fold(0.0, f64::max);
    let path_m: f64 = steps_m.iter().sum();
    Some(Slip {
        displacement_m: last.distance_m(first),
        excursion_m: largest(&mut on_surface.iter().flatten().map(|p| p.distance_m(first))),
        path_m,
        peak_speed_m_s: largest(&mut steps_m.iter().copied()) * rate_hz,
        mean_speed_m_s: path_m * rate_hz / steps_m.len() as f64,
        steps: steps_m.len(),
        missing: on_surface.iter().filter(|p| p.is_none()).count(),
    })
}
