//! Distances to clouds of points on the object, as the paper measures them, beside exact ones.

use inhand_contact::{SurfaceCloud, surface_distance_m};
use inhand_model::{Finger, Object, PerFinger, PointCloud, Position, Shape, Status};
use inhand_statistics::quantiles::statistics;

use super::Illustrated;
use crate::error::SessionError;

/// Points of the paper's clouds (arXiv 2308.15153): of its cube and of its cylinder.
const POINTS: [usize; 2] = [50_000, 70_000];

/// Recorded instants that are measured at most, spread over the test segments: distances to clouds take
/// long, and a thousand instants tell their difference.
const INSTANTS: usize = 1500;

/// Fingers that hold an object stably.
const HOLDING: usize = 3;

/// Recorded fingertips at one instant.
struct Instant {
    tips: PerFinger<Position<Object>>,
    filled: PerFinger<bool>,
}

/// Clouds of the paper's sizes against the surface; none where no take has an object of known shape.
pub(super) fn point_clouds(run: &Illustrated<'_>) -> Result<Vec<PointCloud>, SessionError> {
    let Some(shape) = run.settings.shape()? else {
        return Ok(Vec::new());
    };
    let offsets_m = run.settings.pad_offsets_m()?;
    let tau_m = run.settings.evaluate.tau_mm / 1000.0;
    let (instants, missing) = instants(run);
    if instants.is_empty() {
        return Ok(Vec::new());
    }
    let clouds = POINTS.map(|points| {
        let cloud = SurfaceCloud::new(&shape, points);
        compare(&shape, &cloud, &instants, missing, &offsets_m, tau_m)
    });
    Ok(clouds.into())
}

/// Every so manieth instant of the test segments, and at how many of those the object was missing.
fn instants(run: &Illustrated<'_>) -> (Vec<Instant>, usize) {
    let samples = run.test.layout().samples;
    let all = samples * run.test.len();
    let mut missing = 0;
    let instants = (0..all)
        .step_by(all.div_ceil(INSTANTS).max(1))
        .filter_map(|instant| {
            let (segment, t) = (instant / samples, instant % samples);
            let origin = run.test.origins()[segment];
            let motion = run.test_motions.get(origin.take)?;
            let object = motion.object.as_ref()?;
            let Some(hand_from_object) = object.get(origin.start + t) else {
                missing += 1;
                return None;
            };
            let object_from_hand = hand_from_object.inverse();
            let is_filled = |status: Status| status == Status::Filled;
            let object_filled = is_filled(object.status(origin.start + t));
            Some(Instant {
                tips: PerFinger::from_fn(|finger| {
                    object_from_hand * run.test.position(segment, t, finger)
                }),
                filled: PerFinger::from_fn(|finger| {
                    object_filled || is_filled(motion.fingertips[finger].status(origin.start + t))
                }),
            })
        });
    let instants = instants.collect();
    (instants, missing)
}

fn compare(
    shape: &Shape,
    cloud: &SurfaceCloud,
    instants: &[Instant],
    missing: usize,
    offsets_m: &PerFinger<f64>,
    tau_m: f64,
) -> PointCloud {
    // In the order of the instants, whatever thread measured them.
    let measured: Vec<PerFinger<[f64; 2]>> = inhand_parallel::map(instants, |instant| {
        PerFinger::from_fn(|finger| {
            let tip = instant.tips[finger];
            [surface_distance_m(shape, tip), cloud.distance_m(tip)]
        })
    });
    let excess_m = (measured.iter().flat_map(PerFinger::as_array))
        .map(|[exact, by_cloud]| (by_cloud - exact.abs()).max(0.0))
        .collect();
    let filled = instants
        .iter()
        .flat_map(|instant| instant.filled.as_array());
    let filled = filled.filter(|&&filled| filled).count();
    // A cloud knows no inside: its distance takes the sign of the exact one, so that pads are offset alike.
    let share = |distance: fn([f64; 2]) -> f64| {
        let touches = |fingers: &PerFinger<[f64; 2]>, finger: Finger| {
            (distance(fingers[finger]) - offsets_m[finger]).abs() <= tau_m
        };
        let held = measured.iter().filter(|fingers| {
            let touching = Finger::ALL
                .iter()
                .filter(|&&finger| touches(fingers, finger));
            touching.count() >= HOLDING
        });
        held.count() as f64 / measured.len() as f64
    };
    PointCloud {
        points: cloud.size(),
        excess_m: statistics(excess_m, filled, Finger::COUNT * missing),
        three_or_more: share(|[exact, by_cloud]| by_cloud.copysign(exact)),
        exact_three_or_more: share(|[exact, _]| exact),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three fingers 1, 2 and 4.99 mm from a face of a cube, two far away: by a coarse cloud the third is
    /// no longer in contact.
    #[test]
    fn a_coarse_cloud_loses_contacts() {
        let shape: Shape = "cube:0.05".parse().expect("a shape");
        let away_m = [0.001, 0.002, 0.00499, 0.05, 0.06];
        let instant = Instant {
            tips: PerFinger::new(away_m).map(|m| Position::new(0.0011, 0.0017, 0.025 + m)),
            filled: PerFinger::from_fn(|finger| finger == Finger::Index),
        };
        let of = |points, offset_m| {
            let cloud = SurfaceCloud::new(&shape, points);
            let offsets_m = PerFinger::new([offset_m; 5]);
            compare(
                &shape,
                &cloud,
                std::slice::from_ref(&instant),
                2,
                &offsets_m,
                0.005,
            )
        };
        let coarse = of(600, 0.0);
        assert_eq!((coarse.points, coarse.excess_m.n), (600, 5));
        assert_eq!(
            (coarse.excess_m.n_filled, coarse.excess_m.n_left_out),
            (1, 10)
        );
        assert_eq!(
            (coarse.exact_three_or_more, coarse.three_or_more),
            (1.0, 0.0)
        );
        assert!(coarse.excess_m.min >= 0.0 && coarse.excess_m.max < 0.002);
        // Points a seventh of a millimetre apart are as good as the surface.
        let fine = of(700_000, 0.0);
        assert_eq!((fine.exact_three_or_more, fine.three_or_more), (1.0, 1.0));
        assert!(fine.excess_m.p50 < 1e-5);
        // With pads 1 mm nearer the third has room to spare, 6 mm nearer the first is too deep inside.
        assert_eq!(of(600, 0.001).three_or_more, 1.0);
        assert_eq!(of(600, 0.0065).exact_three_or_more, 0.0);
    }
}
