//! Properties of any session.

use inhand_model::{PerFinger, Pose, Position, in_contact};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

use crate::session::{Session, anywhere, motion};

const SAMPLES: usize = 6;

/// A session of some segments around a cube, and how far off a method is.
fn session() -> impl Strategy<Value = (Session, Vec<Vec<f64>>)> {
    (1..5_usize).prop_flat_map(|segments| {
        let instants = segments * SAMPLES;
        let tips = prop::collection::vec(prop::array::uniform15(-0.05..0.05), instants);
        let poses = prop::collection::vec(
            prop::option::weighted(
                0.9,
                (
                    prop::array::uniform3(-0.02..0.02),
                    prop::array::uniform3(-2.0..2.0),
                ),
            ),
            instants,
        );
        let off = prop::collection::vec(prop::collection::vec(-0.01..0.01, 15 * SAMPLES), segments);
        (tips, poses, off).prop_map(move |(tips, poses, off)| {
            let tips: Vec<PerFinger<Position<_>>> = (tips.iter())
                .map(|c: &[f64; 15]| {
                    PerFinger::from_fn(|f| {
                        let row = 3 * f.index();
                        Position::new(c[row], c[row + 1], c[row + 2])
                    })
                })
                .collect();
            let poses: Vec<_> = (poses.into_iter())
                .map(|pose| {
                    pose.map(|(at, turn)| {
                        Pose::new(Isometry3::new(Vector3::from(at), Vector3::from(turn)))
                    })
                })
                .collect();
            let origins: Vec<_> = (0..segments).map(|s| (0, s * SAMPLES)).collect();
            let take = motion(50.0, &tips, Some(&poses));
            (
                Session::new(vec![take], SAMPLES, &origins, 0, anywhere()),
                off,
            )
        })
    })
}

fn planned(session: &Session, off: &[Vec<f64>]) -> Vec<Option<inhand_model::Trajectory>> {
    off.iter()
        .enumerate()
        .map(|(segment, off)| {
            let values = session.segments.fingertips_m(segment).iter().zip(off);
            Some(session.trajectory(values.map(|(v, off)| v + off).collect()))
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn the_contact_share_never_falls_with_tau((session, off) in session(), taus in prop::collection::vec(0.0..0.05, 1..20)) {
        let mut session = session;
        session.settings.tau_sweep_m = taus;
        session.settings.tau_sweep_m.sort_by(f64::total_cmp);
        let contact = session.evaluate(&planned(&session, &off)).0.contact.unwrap();
        prop_assume!(contact.n > 0);
        prop_assert_eq!(contact.by_tau.len(), session.settings.tau_sweep_m.len());
        for pair in contact.by_tau.windows(2) {
            prop_assert!(pair[0].three_or_more <= pair[1].three_or_more);
            prop_assert!(pair[0].recorded_three_or_more <= pair[1].recorded_three_or_more);
        }
        // The sweep says the same as the share at that threshold, and as the fingers one by one.
        for share in &contact.by_tau {
            session.settings.tau_m = share.tau_m;
            let (evaluation, rows) = session.evaluate(&planned(&session, &off));
            prop_assert_eq!(evaluation.contact.unwrap().three_or_more, share.three_or_more);
            let distance_m = rows.distance_m.unwrap();
            let touching = |d: &PerFinger<f64>| d.as_array().iter().filter(|&&d| in_contact(d, share.tau_m)).count();
            let three = distance_m.iter().filter(|d| touching(d) >= 3);
            prop_assert_eq!(three.count() as f64 / contact.n as f64, share.three_or_more);
        }
    }

    #[test]
    fn errors_bound_the_change_of_every_distance((session, off) in session()) {
        let recorded = session.recorded();
        let (_, rows) = session.evaluate(&planned(&session, &off));
        let distances = rows.distance_m.unwrap();
        let of_recording = recorded.rows.recorded_distance_m.unwrap();
        for k in 0..rows.error_m.len() {
            for (finger, error) in rows.error_m[k].iter() {
                let hull = rows.hull_distance_m[k][finger] - recorded.rows.recorded_hull_distance_m[k][finger];
                prop_assert!(hull.abs() <= error + 1e-12);
                let object = distances[k][finger] - of_recording[k][finger];
                prop_assert!(object.is_nan() || object.abs() <= error + 1e-12);
            }
        }
    }

    #[test]
    fn threads_change_nothing((session, off) in session()) {
        let on_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| format!("{:?}", (session.recorded(), session.evaluate(&planned(&session, &off)))))
        };
        prop_assert_eq!(on_threads(1), on_threads(3));
    }
}
