//! Refused input and its errors.

use inhand_dictionary::{LearnError, NmfSettings, learn_nmf, learn_pca};
use nalgebra::DMatrix;

use crate::segments::{demonstrated, motion, segments};

fn refuse(columns: DMatrix<f64>, settings: &NmfSettings) -> LearnError {
    learn_nmf(&segments(columns), demonstrated(), settings).unwrap_err()
}

fn of_rank(rank: usize) -> NmfSettings {
    NmfSettings {
        rank,
        ..NmfSettings::default()
    }
}

#[test]
fn a_rank_above_the_segments_names_the_largest() {
    let error = refuse(motion(10, 12), &of_rank(13));
    assert_eq!(
        error,
        LearnError::RankTooLarge {
            rank: 13,
            largest: 12,
            segments: 12,
            rows: 150,
            kind: "nmf"
        }
    );
    assert!(
        error
            .to_string()
            .contains("the largest possible nmf rank is 12"),
        "{error}"
    );
    // More segments than numbers in one.
    let error = refuse(motion(1, 40), &of_rank(16));
    assert!(
        matches!(error, LearnError::RankTooLarge { largest: 15, .. }),
        "{error}"
    );
}

#[test]
fn a_pca_rank_above_the_components_names_the_largest() {
    let learn = |columns, rank| learn_pca(&segments(columns), demonstrated(), rank).unwrap_err();
    let error = learn(motion(10, 12), 12);
    assert!(
        matches!(
            error,
            LearnError::RankTooLarge {
                largest: 11,
                kind: "pca",
                ..
            }
        ),
        "{error}"
    );
    // Each segment twice: half the components.
    let twice = DMatrix::from_fn(150, 12, |r, c| motion(10, 6)[(r, c / 2)]);
    let error = learn(twice, 8);
    assert!(
        matches!(error, LearnError::RankTooLarge { largest: 5, .. }),
        "{error}"
    );
    assert!(
        learn(motion(10, 12), 0)
            .to_string()
            .starts_with("rank is 0: expected 1")
    );
    assert!(matches!(
        learn(motion(10, 1), 1),
        LearnError::RankTooLarge { largest: 0, .. }
    ));
}

#[test]
fn nothing_to_learn_from() {
    for columns in [DMatrix::zeros(150, 0), DMatrix::zeros(0, 3)] {
        let error = refuse(columns.clone(), &of_rank(1)).to_string();
        assert!(
            error.starts_with("no training segments (0 left out"),
            "{error}"
        );
        let same = learn_pca(&segments(columns), demonstrated(), 1).unwrap_err();
        assert_eq!(same.to_string(), error);
    }
    let error = refuse(motion(2, 5), &of_rank(0)).to_string();
    assert!(error.starts_with("rank is 0"), "{error}");
}

#[test]
fn a_number_that_is_none_is_named_with_its_place() {
    for found in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut columns = motion(10, 14);
        // Segment 11 is the second of take 1: it starts at sample 14. Sample 3 of it, ring z.
        columns[(3 * 15 + 11, 11)] = found;
        let message = refuse(columns, &of_rank(3)).to_string();
        let place = "training segment 11 (take 1, sample 17): ring axis 2 is";
        assert!(message.starts_with(place), "{message}");
    }
}

#[test]
fn a_coordinate_that_never_changes_is_named() {
    let mut columns = motion(10, 14);
    for t in 0..10 {
        columns.row_mut(t * 15 + 4).fill(0.25);
    }
    let error = refuse(columns, &of_rank(3)).to_string();
    let expected = "index axis 1 is 0.25 m in every sample of 14 training segments";
    assert!(error.starts_with(expected), "{error}");
}

#[test]
fn settings_out_of_range_are_named() {
    let base = of_rank(3);
    for (settings, name) in [
        (
            NmfSettings {
                relative_change: -1.0,
                ..base.clone()
            },
            "relative_change",
        ),
        (
            NmfSettings {
                relative_change: f64::NAN,
                ..base.clone()
            },
            "relative_change",
        ),
        (
            NmfSettings {
                offset_margin_m: -0.001,
                ..base.clone()
            },
            "offset_margin_m",
        ),
        (
            NmfSettings {
                offset_margin_m: f64::INFINITY,
                ..base.clone()
            },
            "offset_margin_m",
        ),
        (
            NmfSettings {
                stop_rms_m: Some(0.0),
                ..base.clone()
            },
            "stop_rms_m",
        ),
        (
            NmfSettings {
                stop_rms_m: Some(f64::NAN),
                ..base.clone()
            },
            "stop_rms_m",
        ),
    ] {
        let error = refuse(motion(4, 6), &settings);
        assert!(
            matches!(error, LearnError::Setting { name: found, .. } if found == name),
            "{error}"
        );
        assert!(error.to_string().starts_with(name), "{error}");
    }
}
