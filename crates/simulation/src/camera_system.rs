//! Simulates a camera system: noisy markers, rigid bodies fitted to them, gaps.

use std::ops::Range;

use inhand_model::{
    BodyKind, Frame, Marker, MarkerKind, PointTrack, Pose, PoseTrack, Position, Status,
    TrackedBody, World,
};
use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};

use crate::error::SimulationError;
use crate::random::Random;
use crate::settings::GapSettings;

/// How often the quaternion of a body changes its sign, Hz. Real recordings do it now and then: a
/// quaternion and its negative are the same rotation.
const SIGN_CHANGES_HZ: f64 = 0.25;
/// Largest step of a converged fit, radians: far below a micrometre at any marker.
const FIT_TOLERANCE_RAD: f64 = 1e-11;
/// Steps of a fit. Each one shrinks the error by the noise relative to the size of the body, so
/// that five are enough at a tenth; more only guards against noise beyond all settings.
const MAX_FIT_STEPS: usize = 20;

/// Captures a rigid body with markers at `template` (in its frame `F`): every marker is seen with
/// noise, and the pose is the least-squares fit to them, as capture software reports it. The markers are in the order of the recording.
pub(crate) fn capture_body<F: Frame>(
    name: &str,
    template: &[Position<F>; 3],
    truth: &[Pose<World, F>],
    noise_m: f64,
    rate_hz: f64,
    random: &mut Random,
) -> (TrackedBody, [Marker; 3]) {
    let fit = Fit::new(template);
    let mut track = PoseTrack::with_capacity(truth.len());
    let mut error_m = Vec::with_capacity(truth.len());
    let mut marker_tracks: [PointTrack<World>; 3] =
        std::array::from_fn(|_| PointTrack::with_capacity(truth.len()));
    let mut sign = random.sign();
    for &pose in truth {
        let seen = template.map(|m| (pose * m).coords_m() + random.normal3(noise_m));
        let fitted = fit.pose(&seen, pose.isometry());
        let placed = template.map(|m| fitted * m.point());
        let distance_m = |k: usize| (placed[k].coords - seen[k]).norm();
        error_m.push((distance_m(0) + distance_m(1) + distance_m(2)) / 3.0);
        for (track, placed) in marker_tracks.iter_mut().zip(placed) {
            track.push(Some(Position::from_point(placed)), Status::Measured);
        }
        if random.chance(SIGN_CHANGES_HZ / rate_hz) {
            sign = -sign;
        }
        let rotation = UnitQuaternion::new_unchecked(fitted.rotation.into_inner() * sign);
        let signed = Isometry3::from_parts(fitted.translation, rotation);
        track.push(Some(Pose::new(signed)), Status::Measured);
    }
    let mut number = 0;
    let markers = marker_tracks.map(|track| {
        number += 1;
        let name = format!("{name}:Marker{number}");
        marker(name, MarkerKind::RigidBodyMarker, track)
    });
    let body = TrackedBody {
        name: name.to_owned(),
        id: entity_id(name),
        kind: BodyKind::RigidBody,
        track,
        marker_error_m: Some(error_m),
    };
    (body, markers)
}

/// Captures a marker of its own: noise on every sample, nothing in the `gaps`.
pub(crate) fn capture_marker(
    name: &str,
    truth: &[Position<World>],
    noise_m: f64,
    gaps: &[Range<usize>],
    random: &mut Random,
) -> Marker {
    let seen = |p: &Position<World>| {
        Some(Position::from_coords(
            p.coords_m() + random.normal3(noise_m),
        ))
    };
    let mut track = PointTrack::from_measured(truth.iter().map(seen));
    for k in gaps.iter().flat_map(Clone::clone) {
        track.set(k, None, Status::Missing);
    }
    marker(name.to_owned(), MarkerKind::Labelled, track)
}

/// Draws runs of missing samples, each as long as the settings allow and apart from the next by a
/// sample at least. Their sum misses the share by less than one run.
pub(crate) fn draw_gaps(
    settings: &GapSettings,
    samples: usize,
    random: &mut Random,
) -> Result<Vec<Range<usize>>, SimulationError> {
    let wanted = (settings.share * samples as f64).round() as usize;
    let mut lengths = Vec::new();
    let mut missing = 0;
    while missing < wanted {
        let left = wanted - missing;
        let span = settings.max_samples - settings.min_samples + 1;
        let length = settings.min_samples + random.below(span);
        // The last run ends at the wanted sum, where it may be that short.
        let length = length.min(left.max(settings.min_samples));
        lengths.push(length);
        missing += length;
    }
    // Runs are dealt among the samples that stay, at most one before each and one at the end: a
    // sorted choice of distinct places.
    let places = samples.saturating_sub(missing) + 1;
    if lengths.len() > places || missing > samples {
        return Err(SimulationError::Crowded(format!(
            "gaps of {missing} samples in {} runs do not fit into {samples} samples: \
             lower the share or make the gaps longer",
            lengths.len()
        )));
    }
    let mut before = sorted_choice(places, lengths.len(), random).into_iter();
    let mut shift = 0;
    let gaps = lengths.into_iter().map(|length| {
        let start = before.next().unwrap_or(0) + shift;
        shift += length;
        start..start + length
    });
    Ok(gaps.collect())
}

/// `count` distinct numbers of `0..n` in order, every set equally likely: each number is taken
/// with the chance that the rest still needs it (Fan, Muller and Rezucha 1962).
fn sorted_choice(n: usize, count: usize, random: &mut Random) -> Vec<usize> {
    let mut chosen = Vec::with_capacity(count);
    for number in 0..n {
        let needed = count - chosen.len();
        if random.below(n - number) < needed {
            chosen.push(number);
        }
    }
    chosen
}

pub(crate) fn marker(name: String, kind: MarkerKind, track: PointTrack<World>) -> Marker {
    Marker {
        id: entity_id(&name),
        name,
        kind,
        track,
        quality: None,
    }
}

/// 32 hexadecimal digits, as capture software names its assets; the same name has the same one in
/// every take (FNV-1a of 128 bits).
fn entity_id(name: &str) -> String {
    const OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    let hash = (name.bytes()).fold(OFFSET, |hash, byte| {
        (hash ^ u128::from(byte)).wrapping_mul(PRIME)
    });
    format!("{hash:032X}")
}

/// Least-squares fit of three markers to their places on a rigid body.
///
/// Minimises `Σ |m_i - (R t_i + p)|²`. The best `p` maps centroid to centroid; `R` is found by
/// Gauss-Newton from a near start: with arms `a_i` from the centroid and measured arms `b_i`, a
/// rotation by `J⁻¹ Σ a_i x Rᵀ b_i` in the body's frame, `J = Σ (|a_i|² I - a_i a_iᵀ)`, until it
/// vanishes, which is where the gradient does. `J` does not change, so a step is one product.
pub(crate) struct Fit {
    centroid: Vector3<f64>,
    arms: [Vector3<f64>; 3],
    inertia_inverse: Matrix3<f64>,
}

impl Fit {
    /// # Panics
    ///
    /// If the template's markers lie on a line.
    pub(crate) fn new<F: Frame>(template: &[Position<F>; 3]) -> Self {
        let centroid = template.iter().map(|m| m.coords_m()).sum::<Vector3<f64>>() / 3.0;
        let arms = template.map(|m| m.coords_m() - centroid);
        let inertia: Matrix3<f64> = (arms.iter())
            .map(|a| Matrix3::identity() * a.norm_squared() - a * a.transpose())
            .sum();
        Self {
            centroid,
            arms,
            inertia_inverse: inertia
                .try_inverse()
                .expect("the markers of a template do not lie on a line"),
        }
    }

    pub(crate) fn pose(&self, seen: &[Vector3<f64>; 3], near: Isometry3<f64>) -> Isometry3<f64> {
        let seen_centroid = (seen[0] + seen[1] + seen[2]) / 3.0;
        let mut rotation = near.rotation;
        for _ in 0..MAX_FIT_STEPS {
            let back = rotation.inverse();
            let torque: Vector3<f64> = (self.arms.iter().zip(seen))
                .map(|(arm, seen)| arm.cross(&(back * (seen - seen_centroid))))
                .sum();
            let step = self.inertia_inverse * torque;
            rotation *= UnitQuaternion::from_scaled_axis(step);
            if step.norm() < FIT_TOLERANCE_RAD {
                break;
            }
        }
        rotation.renormalize_fast();
        let translation = seen_centroid - rotation * self.centroid;
        Isometry3::from_parts(Translation3::from(translation), rotation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Purpose;
    use inhand_model::Hand;

    const TEMPLATE: [Position<Hand>; 3] = [
        Position::new(0.03, 0.0, 0.0),
        Position::new(-0.02, 0.02, 0.0),
        Position::new(-0.01, -0.02, 0.01),
    ];

    #[test]
    fn a_fit_of_exact_markers_is_exact() {
        let pose = Isometry3::new(Vector3::new(0.1, 1.0, -0.3), Vector3::new(0.4, -0.2, 2.0));
        let seen = TEMPLATE.map(|m| (pose * m.point()).coords);
        // From a start a quarter radian away.
        let near = pose * Isometry3::rotation(Vector3::new(0.2, 0.1, -0.1));
        let fitted = Fit::new(&TEMPLATE).pose(&seen, near);
        assert!((fitted.translation.vector - pose.translation.vector).norm() < 1e-14);
        assert!(fitted.rotation.angle_to(&pose.rotation) < 1e-10);
    }

    #[test]
    fn a_fit_is_a_least_sum_of_squares() {
        let mut random = Random::new(5, Purpose::HandMarkers);
        for _ in 0..50 {
            let pose = Isometry3::new(random.normal3(1.0), random.normal3(1.0));
            let seen = TEMPLATE.map(|m| (pose * m.point()).coords + random.normal3(2e-3));
            let cost = |pose: Isometry3<f64>| -> f64 {
                (TEMPLATE.iter().zip(&seen))
                    .map(|(m, seen)| ((pose * m.point()).coords - seen).norm_squared())
                    .sum()
            };
            let fitted = Fit::new(&TEMPLATE).pose(&seen, pose);
            for _ in 0..20 {
                let nudge = Isometry3::new(random.normal3(1e-5), random.normal3(1e-3));
                assert!(cost(fitted * nudge) >= cost(fitted));
            }
        }
    }

    #[test]
    fn gaps_have_the_share_and_lengths_asked_for() {
        let check = |settings: GapSettings, samples: usize| {
            let mut random = Random::new(9, Purpose::HandMarkers);
            let gaps = draw_gaps(&settings, samples, &mut random).unwrap();
            let missing: usize = gaps.iter().map(Range::len).sum();
            let wanted = (settings.share * samples as f64).round() as usize;
            assert!(missing >= wanted && missing < wanted + settings.min_samples.max(1));
            assert!(gaps.iter().all(|g| g.end <= samples
                && (settings.min_samples..=settings.max_samples).contains(&g.len())));
            assert!(gaps.windows(2).all(|pair| pair[0].end < pair[1].start));
        };
        check(GapSettings::with_share(0.0), 100);
        check(GapSettings::with_share(0.02), 12_000);
        check(GapSettings::with_share(0.5), 12_000);
        let settings = |share, min_samples, max_samples| GapSettings {
            share,
            min_samples,
            max_samples,
        };
        check(settings(0.5, 1, 1), 1001);
        check(settings(0.3, 10, 10), 100);
    }

    #[test]
    fn gaps_that_do_not_fit_are_refused() {
        let settings = GapSettings {
            share: 0.5,
            min_samples: 60,
            max_samples: 99,
        };
        let mut random = Random::new(9, Purpose::HandMarkers);
        assert!(draw_gaps(&settings, 100, &mut random).is_ok());
        let many = GapSettings {
            share: 0.9,
            min_samples: 1,
            max_samples: 1,
        };
        let refused = draw_gaps(&many, 100, &mut random);
        assert!(matches!(refused, Err(SimulationError::Crowded(_))));
    }

    #[test]
    fn ids_differ_by_name() {
        assert_eq!(entity_id("Hand").len(), 32);
        assert_ne!(entity_id("Hand"), entity_id("Object"));
        assert_eq!(entity_id(""), "6C62272E07BB014262B821756295C58D");
    }
}
