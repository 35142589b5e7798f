//! The hot paths, on a session as large as the paper's: six takes of 120 s at 100 Hz.

use inhand_model::*;
use inhand_motion::*;
use nalgebra::{Isometry3, Vector3};
use rayon::prelude::*;

const TAKES: usize = 6;
const SAMPLES: u32 = 12_000;

fn main() {
    divan::main();
}

/// A smooth motion with jitter: what a marker does in a take. `seed` tells coordinates apart.
fn coordinate(seed: usize, k: u32) -> f64 {
    let (t, phase) = (f64::from(k) * 0.01, seed as f64 * 0.7);
    let jitter = ((t * 9_871.0 + phase) * 137.0).sin().fract() * 2e-4;
    0.03 * (t * 1.3 + phase).sin() + 0.01 * (t * 4.1 + phase).cos() + jitter
}

fn vector(seed: usize, k: u32) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| coordinate(3 * seed + axis, k))
}

fn body(name: &str, seed: usize) -> TrackedBody {
    let pose = |k| Isometry3::new(vector(seed, k), 20.0 * vector(seed + 1, k));
    TrackedBody {
        name: name.into(),
        id: String::new(),
        kind: BodyKind::RigidBody,
        track: Track::from_measured((0..SAMPLES).map(|k| Some(Pose::new(pose(k))))),
        marker_error_m: None,
    }
}

fn take() -> Recording {
    let markers = Finger::ALL.map(|finger| Marker {
        name: finger.to_string(),
        id: String::new(),
        kind: MarkerKind::Labelled,
        track: Track::from_measured(
            (0..SAMPLES).map(|k| Some(Position::from_coords(vector(finger.index(), k)))),
        ),
        quality: None,
    });
    let corners = [[0.0, 0.0], [0.06, 0.0], [0.0, 0.04], [0.05, 0.05]];
    let cluster = corners.iter().enumerate().map(|(i, &[x, z])| Marker {
        name: format!("back{i}"),
        id: String::new(),
        kind: MarkerKind::Labelled,
        track: Track::from_measured((0..SAMPLES).map(|k| {
            let pose = Isometry3::new(vector(9, k), 20.0 * vector(10, k));
            let placed = pose.rotation * Vector3::new(x, 0.0, z) + pose.translation.vector;
            Some(Position::from_coords(placed + 1e-3 * vector(20 + i, k)))
        })),
        quality: None,
    });
    let source = Source {
        format: "bench".into(),
        length_unit: LengthUnit::Metres,
        up_axis: UpAxis::Y,
        rotation: None,
        header: Default::default(),
    };
    Recording::new(
        "take".into(),
        Clock::new(0, StartTime::Unknown, 100.0).expect("100 Hz is a rate"),
        source,
        SAMPLES as usize,
        markers.into_iter().chain(cluster).collect(),
        vec![body("Hand", 9), body("Object", 12)],
    )
    .expect("every track has as many samples")
}

fn roles(cluster: bool) -> Roles {
    Roles {
        hand: if cluster {
            BodySource::Markers((0..4).map(|i| format!("back{i}")).collect())
        } else {
            BodySource::RigidBody("Hand".into())
        },
        object: Some(BodySource::RigidBody("Object".into())),
        fingers: PerFinger::from_fn(|finger| finger.to_string()),
    }
}

fn settings(filter: Filter) -> ProcessSettings {
    ProcessSettings {
        max_gap_s: 0.1,
        fill: GapFill::Cubic,
        filter,
        object_offset_m: [0.0; 3],
    }
}

/// Hand frame and filter of all takes, with objects: 6 x 12 000 x 22 channels.
#[divan::bench(args = [
    Filter::None,
    Filter::Median { window: 50 },
    Filter::SavitzkyGolay { window: 21, order: 3 },
    Filter::Butterworth { cutoff_hz: 8.0, order: 2 },
])]
fn process_session(bencher: divan::Bencher<'_, '_>, filter: Filter) {
    let (take, roles, settings) = (take(), roles(false), settings(filter));
    bencher.bench(|| -> Vec<_> {
        (0..TAKES)
            .into_par_iter()
            .map(|_| process(&take, &roles, &Templates::default(), &settings))
            .collect()
    });
}

#[divan::bench]
fn templates_of_a_session(bencher: divan::Bencher<'_, '_>) {
    let (take, roles) = (take(), roles(true));
    bencher.bench(|| fit_templates([(&take, &roles); TAKES]));
}

#[divan::bench]
fn fit_cluster_of_a_take(bencher: divan::Bencher<'_, '_>) {
    let (take, roles) = (take(), roles(true));
    let templates = fit_templates([(&take, &roles)]).expect("the cluster is not degenerate");
    bencher.bench(|| role_body(&take, BodyRole::Hand, &roles.hand, &templates));
}

#[divan::bench(args = [100, 10, 1])]
fn cut_training_segments(bencher: divan::Bencher<'_, '_>, stride: usize) {
    let motion = process(
        &take(),
        &roles(false),
        &Templates::default(),
        &settings(Filter::None),
    )
    .expect("the take has every role");
    let settings = SegmentSettings {
        layout: SegmentLayout::one_second(100.0),
        stride,
        ends: EndsRule::Differences { margin_s: 0.04 },
        missing_s: 0.0,
    };
    bencher.bench(|| cut_segments(&[&motion; TAKES - 1], &settings));
}
