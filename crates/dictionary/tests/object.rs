//! Segments that carry the object.

use inhand_dictionary::{NmfSettings, Update, activations, learn_nmf, learn_pca};
use inhand_model::{Dictionary, OBJECT_COORDINATES, SEGMENT_COORDINATES, Segments};
use nalgebra::DMatrix;

use crate::segments::{demonstrated, motion, of_layout, segments};

/// Segments with these columns (21 N rows) at 100 Hz, the object in them.
fn segments_with_object(columns_m: DMatrix<f64>) -> Segments {
    let samples = columns_m.nrows() / (SEGMENT_COORDINATES + OBJECT_COORDINATES);
    of_layout(columns_m, samples, true)
}

/// The motion of [`motion`] and an object that goes with it: it moves along x and y by some
/// millimetres, rests along z, and turns about two axes.
fn motion_with_object(samples: usize, count: usize) -> DMatrix<f64> {
    let fingers = motion(samples, count);
    let finger_rows = fingers.nrows();
    DMatrix::from_fn(
        finger_rows + OBJECT_COORDINATES * samples,
        count,
        |row, segment| {
            let Some(row) = row.checked_sub(finger_rows) else {
                return fingers[(row, segment)];
            };
            let (t, coordinate) = (row / OBJECT_COORDINATES, row % OBJECT_COORDINATES);
            let (time, s) = (t as f64 / samples as f64, segment as f64);
            match coordinate {
                0 => 0.11 + 0.004 * (2.0 * time + 0.7 * s).sin(),
                1 => -0.02 + 0.003 * time * (0.3 * s).cos(),
                2 => 0.05,
                3 => 0.025 * time * (1.1 * s).sin(),
                4 => 0.040 * time * time * (0.4 * s).cos(),
                _ => 0.0,
            }
        },
    )
}

fn settings(rank: usize) -> NmfSettings {
    NmfSettings {
        rank,
        relative_change: 0.0,
        max_iterations: 40,
        ..NmfSettings::default()
    }
}

fn learn(columns: DMatrix<f64>, settings: &NmfSettings) -> Dictionary {
    learn_nmf(&segments_with_object(columns), demonstrated(), settings).unwrap()
}

#[test]
fn fingertips_and_object_are_learned_together() {
    let (samples, count) = (20, 60);
    let columns = motion_with_object(samples, count);
    for update in [Update::Hals, Update::Multiplicative] {
        let dictionary = learn(
            columns.clone(),
            &NmfSettings {
                update,
                ..settings(30)
            },
        );
        dictionary.validate().unwrap();
        assert_eq!(dictionary.primitives.nrows(), 21 * samples);
        let history = &dictionary.learning.objective_history_m2;
        assert_eq!(history.len(), 41);
        assert!(
            history.windows(2).all(|pair| pair[1] <= pair[0]),
            "{update:?}"
        );
        if update == Update::Multiplicative {
            continue;
        }
        assert!(
            dictionary.learning.rms_m < 5e-4,
            "{}",
            dictionary.learning.rms_m
        );
        // Each part for itself, through the activations of a given segment.
        let (mut fingers_m2, mut object_m2) = (0.0, 0.0);
        for column in columns.column_iter() {
            let h = activations(&dictionary, column.clone_owned().as_slice()).unwrap();
            let error = &dictionary.offset_m + &dictionary.primitives * h - column;
            fingers_m2 += error.rows(0, 15 * samples).norm_squared();
            object_m2 += error.rows(15 * samples, 6 * samples).norm_squared();
        }
        let rms_m = |sum_m2: f64, coordinates: usize| {
            (sum_m2 / (coordinates * samples * count) as f64).sqrt()
        };
        assert!(rms_m(fingers_m2, 15) < 5e-4 && rms_m(object_m2, 6) < 5e-4);
    }
}

#[test]
fn the_offset_keeps_each_of_21_coordinates_by_the_margin_from_zero() {
    let samples = 10;
    let columns = motion_with_object(samples, 12);
    let dictionary = learn(columns.clone(), &settings(4));
    let minimum = |rows: &mut dyn Iterator<Item = usize>| {
        rows.map(|row| columns.row(row).min())
            .fold(f64::INFINITY, f64::min)
    };
    for t in 0..samples {
        for coordinate in 0..SEGMENT_COORDINATES {
            let min = minimum(&mut (0..samples).map(|t| 15 * t + coordinate));
            assert!((dictionary.offset_m[15 * t + coordinate] - (min - 0.005)).abs() < 1e-15);
        }
        for coordinate in 0..6 {
            let row = |t: usize| dictionary.layout.object_row(t, coordinate);
            let min = minimum(&mut (0..samples).map(row));
            assert!((dictionary.offset_m[row(t)] - (min - 0.005)).abs() < 1e-15);
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let columns = motion_with_object(12, 210);
    let of_threads = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap()
            .install(|| {
                let nmf = NmfSettings {
                    max_iterations: 4,
                    ..settings(40)
                };
                let pca = learn_pca(&segments_with_object(columns.clone()), demonstrated(), 10);
                (learn(columns.clone(), &nmf), pca.unwrap())
            })
    };
    let one = of_threads(1);
    for threads in [2, 3, 5] {
        assert!(one == of_threads(threads), "{threads} threads");
    }
}

#[test]
fn components_give_segments_back_at_full_rank() {
    let columns = motion_with_object(3, 10);
    let learned = learn_pca(&segments_with_object(columns.clone()), demonstrated(), 9).unwrap();
    learned.validate().unwrap();
    for column in columns.column_iter() {
        let h = activations(&learned, column.clone_owned().as_slice()).unwrap();
        assert!((&learned.offset_m + &learned.primitives * h - column).amax() < 1e-12);
    }
}

#[test]
fn components_do_not_depend_on_what_the_rows_are_called() {
    // 5 samples with object have as many rows as 7 without.
    let columns = motion_with_object(5, 12);
    let with = learn_pca(&segments_with_object(columns.clone()), demonstrated(), 6).unwrap();
    let without = learn_pca(&segments(columns), demonstrated(), 6).unwrap();
    assert_eq!(with.primitives, without.primitives);
    assert_eq!(
        with.activation_covariance_m2,
        without.activation_covariance_m2
    );
}

#[test]
fn a_number_that_is_none_is_named_with_its_place() {
    for (row, name) in [
        (49, "index axis 1"),
        (170, "object position axis 2"),
        (172, "object rotation axis 1"),
    ] {
        // Segment 11 is the second of take 1: it starts at sample 14. Sample 3 of it.
        let mut columns = motion_with_object(10, 14);
        columns[(row, 11)] = f64::NAN;
        let learned = learn_nmf(&segments_with_object(columns), demonstrated(), &settings(3));
        let error = learned.unwrap_err();
        let expected = format!("training segment 11 (take 1, sample 17): {name} is NaN");
        assert!(error.to_string().starts_with(&expected), "{error}");
    }
}

#[test]
fn a_segment_without_the_object_does_not_fit() {
    let dictionary = learn(motion_with_object(8, 20), &settings(5));
    let error = activations(&dictionary, &[0.1; 15 * 8]).unwrap_err();
    let expected = "a segment of 120 numbers does not fit a dictionary of 168 rows";
    assert!(error.to_string().starts_with(expected), "{error}");
}
