//! Additional cost of each family of constraints.

use std::sync::Arc;

use divan::Bencher;
use inhand_contact::hull;
use inhand_model::{
    EndConditions, Finger, Hand, Hull, Object, PerFinger, Pose, Position, SegmentLayout,
};
use inhand_planner::{AccelerationBounds, Constraints, Holding, Planner, PlannerSettings, Target};
use nalgebra::{Isometry3, Vector3};

use crate::{SAMPLES, plan_in_turn, support};

/// A ball of points about where each finger is, some 400 faces.
fn hulls() -> PerFinger<Hull> {
    let points: Vec<_> = (0..200)
        .map(|k| {
            let (z, turn) = (1.0 - (2.0 * f64::from(k) + 1.0) / 200.0, 2.4 * f64::from(k));
            let r = (1.0 - z * z).sqrt();
            Position::<Hand>::new(0.022 * r * turn.cos(), 0.022 * r * turn.sin(), 0.022 * z)
        })
        .collect();
    let ball = hull(&points).expect("a ball has a hull");
    PerFinger::from_fn(|_| ball.clone())
}

#[divan::bench(args = ["none", "hull_distance", "acceleration", "reachability", "separation", "holding"])]
fn plan(bencher: Bencher, family: &str) {
    let residual = support::residual(SAMPLES, 140, false);
    let mut settings = PlannerSettings {
        constraints: Constraints::default(),
        ..support::settings(support::bounds(1.0))
    };
    let constraints = &mut settings.constraints;
    match family {
        "hull_distance" => settings.hulls = Some(Arc::new(hulls())),
        "acceleration" => {
            constraints.acceleration = Some(AccelerationBounds {
                min_m_s2: [-0.5; 15],
                max_m_s2: [0.5; 15],
            });
        }
        "reachability" => {
            constraints.reachability_margin_m = Some(0.0);
            settings.hulls = Some(Arc::new(hulls()));
        }
        "separation" => constraints.separation_m = Some(0.006),
        _ => {}
    }
    let planner = Planner::residual(&residual, &settings).expect("sound parts");
    let targets: Vec<Target> = (0..8)
        .map(|case| {
            let wave = |phase: f64, size: f64| {
                std::array::from_fn(|c| size * (1.3 * c as f64 + phase + f64::from(case)).sin())
            };
            let ends = EndConditions {
                first_m: wave(0.0, 0.01),
                last_m: wave(0.4, 0.01),
                first_velocity_m_s: wave(2.0, 0.01),
                last_velocity_m_s: wave(3.0, 0.01),
                object: None,
            };
            let target = Target::from(ends);
            match family {
                "holding" => target.holding(held(&ends)),
                _ => target,
            }
        })
        .collect();
    plan_in_turn(bencher, &planner, &targets);
}

/// Thumb, index and middle follow an object that moves evenly from start to goal.
fn held(ends: &EndConditions) -> Holding {
    let at = SegmentLayout::row(0, Finger::Thumb, 0);
    let tip = |values: &[f64; 15]| Vector3::from_fn(|axis, _| values[at + axis]);
    let (first, last) = (tip(&ends.first_m), tip(&ends.last_m));
    let mut contacts = PerFinger::from_fn(|_| None);
    for finger in [Finger::Thumb, Finger::Index, Finger::Middle] {
        let at = SegmentLayout::row(0, finger, 0);
        let [x, y, z] = [0, 1, 2].map(|axis| {
            let middle = (ends.first_m[at + axis] + ends.last_m[at + axis]) / 2.0;
            middle - (first + last)[axis] / 2.0
        });
        contacts[finger] = Some(Position::<Object>::new(x, y, z));
    }
    let samples = SAMPLES as f64 - 1.0;
    let poses = (0..SAMPLES).map(|t| first + (last - first) * (t as f64 / samples));
    Holding {
        hand_from_object: poses
            .map(|way| Pose::new(Isometry3::new(way, Vector3::zeros())))
            .collect(),
        contacts,
        tau_m: 0.005,
    }
}
