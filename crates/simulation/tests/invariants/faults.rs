//! Planted faults are as they are said to be, and nothing else is changed.

use inhand_model::{Finger, MarkerKind, Status};
use inhand_simulation::{
    FaultKind, FaultSettings, FaultyTake, SimulationError, TakeSettings, simulate_faulty,
};

fn faulty(seed: u64) -> FaultyTake {
    let settings = TakeSettings {
        duration_s: 60.0,
        ..TakeSettings::cylinder("cylinder")
    };
    simulate_faulty(&settings, &FaultSettings::bad_session(), seed).expect("the settings are valid")
}

fn of_kind<'a>(
    take: &'a FaultyTake,
    name: &'a str,
) -> impl Iterator<Item = &'a inhand_simulation::Fault> {
    take.faults
        .iter()
        .filter(move |fault| fault.kind.name() == name)
}

#[test]
fn there_are_as_many_as_were_asked_for() {
    let take = faulty(3);
    let count = |name| of_kind(&take, name).count();
    // A swap of which no sample is left is none.
    assert!((8..=10).contains(&count("swap")), "{}", count("swap"));
    assert_eq!(
        (
            count("flip"),
            count("spike"),
            count("unlabelled"),
            count("ghost")
        ),
        (5, 20, 3, 2)
    );
    assert!(
        take.faults
            .windows(2)
            .all(|pair| pair[0].samples.start <= pair[1].samples.start)
    );
}

#[test]
fn the_same_seed_plants_the_same() {
    let (a, b, other) = (faulty(5), faulty(5), faulty(6));
    assert_eq!(a.faults, b.faults);
    assert_ne!(a.faults, other.faults);
    for (a, b) in a.recording.markers.iter().zip(&b.recording.markers) {
        assert!(a.track.iter().eq(b.track.iter()), "{}", a.name);
    }
}

#[test]
fn every_sample_is_as_the_faults_say() {
    let take = faulty(7);
    for finger in Finger::ALL {
        let name = format!("{finger:?}");
        let label = take.recording.marker(&name).expect("it has all fingers");
        for k in 0..take.recording.len() {
            let here = |kind| {
                of_kind(&take, kind)
                    .find(|fault| fault.samples.contains(&k) && fault.entities.contains(&name))
            };
            let source = here("swap").map_or(&name, |swap| {
                let other = swap.entities.iter().find(|entity| **entity != name);
                other.expect("a swap has two")
            });
            let clean = take
                .clean
                .recording
                .marker(source)
                .and_then(|m| m.track.get(k));
            let clean = clean.expect("the take has no gaps before");
            let Some(seen) = label.track.get(k) else {
                assert!(
                    here("gap").is_some() || here("unlabelled").is_some(),
                    "{name} at {k}"
                );
                continue;
            };
            match here("spike") {
                Some(spike) => {
                    let FaultKind::Spike { off_m, was_m } = &spike.kind else {
                        panic!("it is a spike");
                    };
                    let off = seen.distance_m(clean);
                    assert!(off <= off_m + 1e-12 && off > 0.003, "{name} at {k}: {off}");
                    assert_eq!(was_m[k - spike.samples.start], clean.to_array());
                }
                None => assert_eq!(seen, clean, "{name} at {k}"),
            }
        }
    }
}

#[test]
fn flipped_bodies_are_the_true_ones_times_the_turn() {
    let take = faulty(8);
    for (body, clean) in take
        .recording
        .bodies
        .iter()
        .zip(&take.clean.recording.bodies)
    {
        for k in 0..take.recording.len() {
            let flip = of_kind(&take, "flip")
                .find(|fault| fault.entities[0] == body.name && fault.samples.contains(&k));
            let turn = flip.map(|fault| match fault.kind {
                FaultKind::Flip { true_from_recorded } => true_from_recorded,
                _ => panic!("it is a flip"),
            });
            let Some(seen) = body.track.get(k) else {
                continue;
            };
            let truth = clean.track.value(k).isometry();
            let expected = turn.map_or(truth, |turn| truth * turn);
            let seen = seen.isometry();
            assert!((seen.translation.vector - expected.translation.vector).norm() < 1e-12);
            assert!(seen.rotation.angle_to(&expected.rotation) < 1e-7);
            if let Some(turn) = turn {
                assert!(
                    turn.rotation.angle() > 0.6,
                    "{} degrees",
                    turn.rotation.angle().to_degrees()
                );
            }
        }
    }
}

#[test]
fn lost_labels_go_to_unlabelled_markers() {
    let take = faulty(9);
    for fault in of_kind(&take, "unlabelled") {
        let piece = take
            .recording
            .marker(&fault.entities[1])
            .expect("it is there");
        assert_eq!(piece.kind, MarkerKind::Unlabelled);
        let own = take
            .clean
            .recording
            .marker(&fault.entities[0])
            .expect("it is there");
        let mut seen = 0;
        for k in 0..take.recording.len() {
            if piece.track.status(k) == Status::Measured {
                assert!(fault.samples.contains(&k));
                assert_eq!(piece.track.get(k), own.track.get(k));
                seen += 1;
            }
        }
        assert!(
            seen + 6 >= fault.samples.len(),
            "{seen} of {:?}",
            fault.samples
        );
    }
}

#[test]
fn too_many_are_refused() {
    let settings = TakeSettings {
        duration_s: 4.0,
        ..TakeSettings::cube("short")
    };
    let faults = FaultSettings {
        unlabelled_per_minute: 60.0,
        swaps_per_minute: 60.0,
        flips_per_minute: 60.0,
        ..FaultSettings::bad_session()
    };
    let many = TakeSettings {
        duration_s: 60.0,
        rate_hz: 100.0,
        ..settings.clone()
    };
    let refused = simulate_faulty(&many, &faults, 1);
    assert!(
        matches!(refused, Err(SimulationError::Crowded(_))),
        "{:?}",
        refused.err()
    );
    let negative = FaultSettings {
        spikes_per_minute: -1.0,
        ..FaultSettings::bad_session()
    };
    let refused = simulate_faulty(&settings, &negative, 1);
    let text = refused.map(|_| ()).unwrap_err().to_string();
    assert!(
        text.starts_with("setting spikes_per_minute is -1"),
        "{text}"
    );
}
