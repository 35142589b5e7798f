//! Choosing the rank: errors on takes left out of learning.

use inhand_dictionary::{
    LearnError, NmfSettings, RankCurve, RankGroups, RankMethod, activations, folds, learn_nmf,
    learn_pca, rank_curve,
};
use inhand_model::{DictionaryKind, SegmentOrigin, Segments};
use nalgebra::DMatrix;
use proptest::prelude::*;

use crate::segments::{demonstrated, motion, segments};

/// True rank of [`low_rank`].
const RANK: usize = 5;
const SAMPLES: usize = 10;

/// Numbers without pattern, uniform in ±sqrt(3), so that their variance is one.
fn noise(i: usize) -> f64 {
    let mut z = (i as u64).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    let unit = ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64;
    (2.0 * unit - 1.0) * 3.0_f64.sqrt()
}

/// Segments in takes of ten: a mean, five directions with activations of a few centimetres, and
/// noise of the given size, metres.
fn low_rank(count: usize, noise_m: f64) -> Segments {
    let rows = SAMPLES * 15;
    let direction = |row: usize, j: usize| (0.2 * (j + 1) as f64 * row as f64 + j as f64).sin();
    let columns_m = DMatrix::from_fn(rows, count, |row, i| {
        let motion: f64 = (0..RANK)
            .map(|j| 0.02 * noise(i * RANK + j) * direction(row, j))
            .sum();
        0.1 + motion + noise_m * noise(1_000_000 + i * rows + row)
    });
    segments(columns_m)
}

fn curve(segments: &Segments, method: RankMethod<'_>, ranks: &[usize]) -> RankCurve {
    rank_curve(segments, method, ranks, &mut |_| ()).unwrap()
}

fn nmf() -> NmfSettings {
    NmfSettings {
        max_iterations: 20,
        ..NmfSettings::default()
    }
}

#[test]
fn data_of_exact_rank_have_that_rank() {
    let segments = low_rank(60, 0.0);
    let ranks: Vec<usize> = (1..=8).collect();
    let curve = curve(&segments, RankMethod::Pca, &ranks);
    assert_eq!(
        (curve.largest, &curve.too_large[..]),
        (RANK, &[6, 7, 8][..])
    );
    let suggestion = curve.suggestion().unwrap();
    assert_eq!((suggestion.rank, suggestion.best_rank), (RANK, RANK));
    let last = curve.points[RANK - 1];
    for error_m in [
        last.training_rms_m,
        last.reconstructed.rms_m,
        last.predicted.rms_m,
    ] {
        assert!(error_m < 1e-9, "{error_m}");
    }
    assert!((last.explained_variance - 1.0).abs() < 1e-12);
    assert!(curve.points[RANK - 2].predicted.rms_m > 1e-3);
}

#[test]
fn noise_does_not_raise_the_rank_and_is_the_error_that_is_left() {
    let noise_m = 0.001;
    let segments = low_rank(200, noise_m);
    let ranks: Vec<usize> = (1..=20).collect();
    let curve = curve(&segments, RankMethod::Pca, &ranks);
    let suggestion = curve.suggestion().unwrap();
    assert_eq!(suggestion.rank, RANK);
    assert!(!suggestion.still_falling);
    let at = curve.points[RANK - 1];
    // Five numbers of a segment's 150 are fitted: what is left has 145 parts of the noise.
    let expected_m = noise_m * (145.0_f64 / 150.0).sqrt();
    assert!((at.training_rms_m / expected_m - 1.0).abs() < 0.02);
    assert!((at.reconstructed.rms_m / expected_m - 1.0).abs() < 0.04);
    // Nothing of the hidden numbers' noise is known, and five activations come from 105 noisy ones.
    assert!(
        (1.0..1.1).contains(&(at.predicted.rms_m / noise_m)),
        "{at:?}"
    );
    for pair in curve.points.windows(2) {
        assert!(pair[1].training_rms_m < pair[0].training_rms_m);
        assert!(pair[1].reconstructed.rms_m < pair[0].reconstructed.rms_m);
    }
}

#[test]
fn explained_variance_is_what_the_mean_segment_leaves() {
    let segments = low_rank(60, 0.001);
    let columns = segments.columns_m();
    let mean = columns.column_mean();
    let total: f64 = (columns.column_iter())
        .map(|column| (column - &mean).norm_squared())
        .sum();
    for method in [RankMethod::Pca, RankMethod::Nmf(&nmf())] {
        for point in curve(&segments, method, &[3, 7]).points {
            let left = point.training_rms_m.powi(2) * columns.len() as f64;
            assert!((point.explained_variance - (1.0 - left / total)).abs() < 1e-12);
        }
    }
}

#[test]
fn training_errors_are_those_of_learning() {
    let segments = segments(motion(SAMPLES, 60));
    let settings = nmf();
    for rank in [4, 9] {
        let by_pca = learn_pca(&segments, demonstrated(), rank).unwrap();
        let found = curve(&segments, RankMethod::Pca, &[rank, 11]).points[0];
        let ratio = found.training_rms_m / by_pca.learning.rms_m;
        assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
        let with_rank = NmfSettings {
            rank,
            ..settings.clone()
        };
        let by_nmf = learn_nmf(&segments, demonstrated(), &with_rank).unwrap();
        let found = curve(&segments, RankMethod::Nmf(&settings), &[rank]).points[0];
        assert_eq!(found.training_rms_m, by_nmf.learning.rms_m);
    }
}

#[test]
fn left_out_segments_are_reconstructed_as_by_projection() {
    let segments = segments(motion(SAMPLES, 40));
    let settings = NmfSettings { rank: 8, ..nmf() };
    for pca in [false, true] {
        let (mut squares, mut numbers) = (0.0, 0);
        for fold in folds(segments.origins(), SAMPLES) {
            let known = segments.select(&fold.known);
            let dictionary = if pca {
                learn_pca(&known, demonstrated(), 8)
            } else {
                learn_nmf(&known, demonstrated(), &settings)
            }
            .unwrap();
            for &segment in &fold.left_out {
                let column = segments.columns_m().column(segment);
                let h = activations(&dictionary, segments.column_m(segment)).unwrap();
                let error = column - &dictionary.offset_m - &dictionary.primitives * h;
                squares += error.norm_squared();
                numbers += error.len();
            }
        }
        let method = if pca {
            RankMethod::Pca
        } else {
            RankMethod::Nmf(&settings)
        };
        let found = curve(&segments, method, &[8]).points[0].reconstructed;
        let expected = (squares / numbers as f64).sqrt();
        assert!(
            (found.rms_m / expected - 1.0).abs() < 1e-3,
            "{found:?} {expected}"
        );
    }
}

#[test]
fn the_order_of_takes_does_not_matter() {
    let segments = low_rank(60, 0.001);
    let backwards: Vec<usize> = (0..60).map(|i| (5 - i / 10) * 10 + i % 10).collect();
    let turned = segments.select(&backwards);
    let ranks = [2, 4, 5, 6, 9];
    let by_pca = |segments| curve(segments, RankMethod::Pca, &ranks);
    let (one, other) = (by_pca(&segments), by_pca(&turned));
    assert_eq!(
        one.suggestion().unwrap().rank,
        other.suggestion().unwrap().rank
    );
    for (a, b) in one.points.iter().zip(&other.points) {
        assert!((a.predicted.rms_m / b.predicted.rms_m - 1.0).abs() < 1e-6);
        assert!((a.reconstructed.rms_m / b.reconstructed.rms_m - 1.0).abs() < 1e-6);
        let errors = [a, b].map(|point| point.predicted.standard_error_m.unwrap());
        assert!((errors[0] / errors[1] - 1.0).abs() < 1e-6);
    }
    // Ranks in any order, some of them twice.
    let shuffled = curve(&segments, RankMethod::Pca, &[9, 2, 5, 4, 5, 6]);
    assert_eq!(shuffled, one);
}

#[test]
fn facts_of_the_curve() {
    let segments = segments(motion(SAMPLES, 30));
    let mut seen = Vec::new();
    let settings = nmf();
    let ranks = [12, 6, 21, 40];
    let curve = rank_curve(
        &segments,
        RankMethod::Nmf(&settings),
        &ranks,
        &mut |point| {
            seen.push(point.rank);
        },
    )
    .unwrap();
    assert_eq!(seen, [6, 12]);
    assert_eq!(curve.kind, DictionaryKind::Nmf);
    // Two of three takes of ten segments remain.
    assert_eq!((curve.largest, &curve.too_large[..]), (20, &[21, 40][..]));
    assert_eq!((curve.segments, curve.left_out, curve.groups), (30, 30, 3));
    assert_eq!((curve.by, curve.hidden.clone()), (RankGroups::Takes, 3..6));
    assert!(
        curve
            .points
            .iter()
            .all(|point| point.predicted.standard_error_m.is_some())
    );
}

#[test]
fn overlapping_segments_are_not_judged_twice() {
    // 10 samples a segment, a new one every 2 samples: a fifth of them is apart.
    let whole = segments(motion(SAMPLES, 60));
    let origins = (0..60)
        .map(|i| SegmentOrigin {
            take: i / 30,
            start: 2 * (i % 30),
        })
        .collect();
    let dense = Segments::new(
        whole.layout(),
        whole.columns_m().clone(),
        origins,
        whole.ends().to_vec(),
        0,
    )
    .unwrap();
    let curve = curve(&dense, RankMethod::Pca, &[3]);
    assert_eq!((curve.segments, curve.left_out, curve.groups), (60, 12, 2));
}

#[test]
fn segments_with_missing_numbers_teach_and_do_not_judge() {
    let mut columns_m = motion(SAMPLES, 30);
    columns_m[(20, 4)] = f64::NAN;
    let segments = segments(columns_m);
    let settings = NmfSettings {
        may_miss: true,
        ..nmf()
    };
    let found = curve(&segments, RankMethod::Nmf(&settings), &[6]);
    assert_eq!((found.segments, found.left_out, found.groups), (30, 29, 3));
    let point = found.points[0];
    assert!((0.9..1.0).contains(&point.explained_variance), "{point:?}");
    assert!(point.predicted.rms_m.is_finite());
}

#[test]
fn a_single_take_is_left_out_in_stretches() {
    let whole = segments(motion(SAMPLES, 30));
    let origins = (0..30)
        .map(|i| SegmentOrigin {
            take: 7,
            start: SAMPLES * i,
        })
        .collect();
    let single = Segments::new(
        whole.layout(),
        whole.columns_m().clone(),
        origins,
        whole.ends().to_vec(),
        0,
    )
    .unwrap();
    let curve = curve(&single, RankMethod::Pca, &[2, 5]);
    assert_eq!((curve.by, curve.groups), (RankGroups::Intervals, 5));
    assert!(curve.suggestion().is_some());
}

#[test]
fn what_cannot_be_chosen_is_refused() {
    let whole = segments(motion(SAMPLES, 30));
    let fails = |segments: &Segments, ranks: &[usize]| {
        rank_curve(segments, RankMethod::Nmf(&nmf()), ranks, &mut |_| ()).unwrap_err()
    };
    let error = fails(&whole, &[0, 3]).to_string();
    assert!(error.starts_with("rank is 0"), "{error}");
    let error = fails(&whole, &[]);
    assert!(matches!(error, LearnError::Setting { .. }), "{error}");
    let error = fails(&whole, &[60, 50]).to_string();
    assert!(
        error.starts_with("rank 50 and above")
            && error.contains("30 training segments support ranks up to 20"),
        "{error}"
    );
    let one = whole.select(&[4]);
    let error = fails(&one, &[1]);
    let error = error.to_string();
    assert!(
        error.starts_with("1 training segments") && error.contains("give more takes"),
        "{error}"
    );
    let short = segments(motion(2, 30));
    let error = fails(&short, &[1]);
    assert!(error.to_string().contains("at least 3"), "{error}");
    let mut broken = motion(SAMPLES, 30);
    broken[(17, 12)] = f64::INFINITY;
    let error = fails(&segments(broken), &[3]);
    assert!(
        error.to_string().starts_with("training segment 12 "),
        "{error}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

    #[test]
    fn nothing_left_out_overlaps_what_is_learned_from(
        takes in 1_usize..12,
        per_take in 1_usize..40,
        stride in 1_usize..25,
        samples in 3_usize..20,
    ) {
        let origins: Vec<SegmentOrigin> = (0..takes * per_take)
            .map(|i| SegmentOrigin { take: i % takes, start: stride * (i / takes) })
            .collect();
        let overlap = |a: usize, b: usize| {
            let (a, b) = (origins[a], origins[b]);
            a.take == b.take && a.start.abs_diff(b.start) < samples
        };
        for fold in folds(&origins, samples) {
            for (i, &segment) in fold.left_out.iter().enumerate() {
                prop_assert!(fold.known.iter().all(|&known| !overlap(segment, known)));
                prop_assert!(fold.left_out[..i].iter().all(|&other| !overlap(segment, other)));
            }
        }
    }
}
