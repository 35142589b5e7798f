//! Rounds over blocks, penalties, missing numbers and single precision.

use inhand_dictionary::{
    Activations, Columns, LearnError, NmfProblem, NmfSettings, Penalty, Precision, Start, Tree,
    Update, activations, learn_nmf,
};
use inhand_model::{Dictionary, Segments, StopReason};
use nalgebra::DMatrix;
use proptest::prelude::*;

use crate::segments::{demonstrated, motion, segments};

/// Five thousand short segments: three blocks.
fn many() -> DMatrix<f64> {
    motion(4, 5000)
}

fn settings(rank: usize) -> NmfSettings {
    NmfSettings {
        rank,
        max_iterations: 3,
        relative_change: 0.0,
        ..NmfSettings::default()
    }
}

/// Removes samples of the ring finger from some segments.
fn with_gaps(mut columns: DMatrix<f64>) -> DMatrix<f64> {
    for (segment, mut column) in columns.column_iter_mut().enumerate() {
        if segment % 7 == 3 {
            let t = 1 + segment % 2;
            column.rows_mut(15 * t + 9, 3).fill(f64::NAN);
        }
    }
    columns
}

/// What many processes would do: each takes a run of blocks, one adds up and updates.
fn in_shards(segments: &Segments, settings: &NmfSettings, shards: usize) -> Dictionary {
    let problem = NmfProblem::new(segments, settings).unwrap();
    let mut state = problem.start(segments, settings.seed).unwrap();
    let blocks = problem.blocks();
    let mut activations: Vec<Option<Activations>> = vec![None; blocks];
    while state.stop.is_none() {
        let mut all = Tree::default();
        for shard in 0..shards {
            let mut part = Tree::default();
            let mine = shard * blocks / shards..(shard + 1) * blocks / shards;
            for (block, activations) in mine.clone().zip(&mut activations[mine]) {
                let columns_m = problem.read_block(segments, block).unwrap();
                let previous = activations.take();
                let (sums, next) = problem.sums(&state, block, columns_m, previous).unwrap();
                *activations = Some(next);
                part.push_block(block, sums).unwrap();
            }
            for node in part.into_nodes() {
                all.push(node).unwrap();
            }
        }
        let sums = all.root(blocks).unwrap();
        state = problem.update(state, &sums, segments).unwrap();
    }
    let finished = problem.finish(&[state], demonstrated(), &mut |block| {
        Ok(activations[block].clone().unwrap())
    });
    finished.unwrap()
}

#[test]
fn shards_and_memory_give_the_same_bits() {
    let penalty = Penalty { l1: 1e-6, l2: 1e-6 };
    let cases = [
        settings(6),
        NmfSettings {
            precision: Precision::F32,
            ..settings(6)
        },
        NmfSettings {
            update: Update::Multiplicative,
            activation_penalty: penalty,
            primitive_penalty: penalty,
            ..settings(5)
        },
        NmfSettings {
            left_out_change: 0.3,
            max_iterations: 6,
            ..settings(6)
        },
    ];
    for (columns, may_miss) in [(many(), false), (with_gaps(many()), true)] {
        let segments = segments(columns);
        for settings in &cases {
            let settings = NmfSettings {
                may_miss,
                ..settings.clone()
            };
            let memory = learn_nmf(&segments, demonstrated(), &settings).unwrap();
            for shards in [1, 2, 3, 8] {
                let other = in_shards(&segments, &settings, shards);
                assert!(memory == other, "{shards} {settings:?}");
            }
        }
    }
}

#[test]
fn left_out_takes_end_learning_and_are_learned_from_at_the_end() {
    let settings = NmfSettings {
        left_out_change: 0.3,
        max_iterations: 40,
        ..settings(6)
    };
    let columns = motion(4, 200);
    let all = segments(columns.clone());
    let problem = NmfProblem::new(&all, &settings).unwrap();
    // Takes of ten segments, of which every eighth is left out.
    let left_out = problem.left_out.clone().unwrap();
    assert_eq!(left_out.set_aside, [0..10, 80..90, 160..170]);
    let measured: Vec<usize> = left_out.set_aside.iter().cloned().flatten().collect();
    assert_eq!(left_out.measured, measured);

    // Primitives do not depend on what they are judged by.
    let step = |columns: DMatrix<f64>| {
        let segments = segments(columns);
        let state = problem.start(&segments, 0).unwrap();
        let columns_m = problem.read_block(&segments, 0).unwrap();
        let (sums, _) = problem.sums(&state, 0, columns_m, None).unwrap();
        problem.update(state, &sums, &segments).unwrap()
    };
    let mut others = columns.clone();
    for &segment in &measured {
        others.set_column(segment, &columns.column(11));
    }
    let (state, other) = (step(columns), step(others));
    assert_eq!(state.primitives, other.primitives);
    assert_ne!(state.left_out_history_m2, other.left_out_history_m2);

    let learning = learn_nmf(&all, demonstrated(), &settings).unwrap().learning;
    let reason = StopReason::NoLongerBetterOnLeftOutTakes;
    assert_eq!(learning.stop_reason, reason);
    assert!((3..40).contains(&learning.iterations));
}

#[test]
fn too_few_segments_are_all_learned_from() {
    let settings = NmfSettings {
        left_out_change: 0.3,
        max_iterations: 6,
        ..settings(6)
    };
    // Two takes, of which the second has five segments.
    let problem = NmfProblem::new(&segments(motion(4, 15)), &settings).unwrap();
    assert_eq!(problem.left_out, None);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let segments = segments(with_gaps(many()));
    let settings = NmfSettings {
        may_miss: true,
        ..settings(6)
    };
    let of_threads = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap()
            .install(|| learn_nmf(&segments, demonstrated(), &settings).unwrap())
    };
    let one = of_threads(1);
    assert!(one == of_threads(2) && one == of_threads(5));
}

#[test]
fn activations_of_another_round_are_refused() {
    let segments = segments(motion(4, 50));
    let problem = NmfProblem::new(&segments, &settings(3)).unwrap();
    let state = problem.start(&segments, 0).unwrap();
    let columns_m = || problem.read_block(&segments, 0).unwrap();
    let (sums, first) = problem.sums(&state, 0, columns_m(), None).unwrap();
    let refused = |result: Result<_, LearnError>| {
        let error = result.err().map(|error| error.to_string());
        error.is_some_and(|error| error.starts_with("activations of block 0"))
    };
    assert!(refused(problem.sums(
        &state,
        0,
        columns_m(),
        Some(first.clone())
    )));
    let next = problem.update(state, &sums, &segments).unwrap();
    assert!(refused(problem.sums(&next, 0, columns_m(), None)));
    let short = Activations::F64(vec![1.0; 3]);
    assert!(refused(problem.sums(&next, 0, columns_m(), Some(short))));
    let single = Activations::F32(first.to_f64().iter().map(|v| *v as f32).collect());
    assert!(refused(problem.sums(&next, 0, columns_m(), Some(single))));
    assert!(problem.sums(&next, 0, columns_m(), Some(first)).is_ok());
}

/// Non-negative data of a rank, shifted as learning would (no margin, minima of zero).
fn low_rank(rows: usize, count: usize, rank: usize) -> DMatrix<f64> {
    let w = DMatrix::from_fn(rows, rank, |r, k| {
        (0.5 + 0.5 * (0.3 * r as f64 + 2.0 * k as f64).sin()).powi(3)
    });
    let h = DMatrix::from_fn(rank, count, |k, i| {
        // Every primitive is zero somewhere, so that the offset is.
        (0.4 * i as f64 * (k as f64 + 1.0)).sin().max(0.0)
    });
    w * h * 0.05
}

#[test]
fn what_is_missing_is_learned_from_the_rest() {
    let whole = low_rank(60, 120, 3);
    let mut gaps = whole.clone();
    let mut missing = Vec::new();
    for segment in (0..120).step_by(6) {
        for row in 24..27 {
            missing.push((row, segment));
            gaps[(row, segment)] = f64::NAN;
        }
    }
    let settings = NmfSettings {
        offset_margin_m: 0.0,
        max_iterations: 3000,
        relative_change: 0.0,
        may_miss: true,
        ..settings(3)
    };
    let learned = learn_nmf(&segments(gaps.clone()), demonstrated(), &settings).unwrap();
    // Objectives count what is there alone.
    let last = *learned.learning.objective_history_m2.last().unwrap();
    let numbers = (60 * 120 - missing.len()) as f64;
    assert!((learned.learning.rms_m - (2.0 * last / numbers).sqrt()).abs() < 1e-12);
    for pair in learned.learning.objective_history_m2.windows(2) {
        assert!(pair[1] <= pair[0] * (1.0 + 1e-9) + 1e-18, "{pair:?}");
    }
    // Activations of the whole segments express what learning never saw.
    let mut worst: f64 = 0.0;
    for &(row, segment) in &missing {
        let column: Vec<f64> = whole.column(segment).iter().copied().collect();
        let h = activations(&learned, &column).unwrap();
        let back = learned.offset_m[row] + learned.primitives.row(row).dot(&h.transpose());
        worst = worst.max((back - whole[(row, segment)]).abs());
    }
    assert!(worst < 1e-4, "{worst}");

    let strict = NmfSettings {
        may_miss: false,
        ..settings
    };
    let refused = learn_nmf(&segments(gaps), demonstrated(), &strict).unwrap_err();
    assert!(refused.to_string().starts_with("training segment 0 "));
}

#[test]
fn allowing_gaps_changes_nothing_where_there_are_none() {
    let segments = segments(motion(10, 80));
    let strict = learn_nmf(&segments, demonstrated(), &settings(9)).unwrap();
    let lenient = NmfSettings {
        may_miss: true,
        ..settings(9)
    };
    assert!(strict == learn_nmf(&segments, demonstrated(), &lenient).unwrap());
}

#[test]
fn single_precision_follows_double() {
    let segments = segments(motion(20, 200));
    let double = learn_nmf(&segments, demonstrated(), &settings(12)).unwrap();
    let single = NmfSettings {
        precision: Precision::F32,
        ..settings(12)
    };
    let single = learn_nmf(&segments, demonstrated(), &single).unwrap();
    let histories = [&double, &single].map(|d| &d.learning.objective_history_m2);
    for (a, b) in histories[0].iter().zip(histories[1]) {
        assert!((a - b).abs() < 1e-3 * a, "{a} {b}");
    }
    assert!((double.primitives - single.primitives).amax() < 1e-3);
}

#[test]
fn a_penalty_of_one_factor_is_refused() {
    let segments = segments(motion(4, 50));
    let one = NmfSettings {
        activation_penalty: Penalty { l1: 0.1, l2: 0.0 },
        ..settings(3)
    };
    let refused = learn_nmf(&segments, demonstrated(), &one).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "activations are penalised and primitives are not: their scale would move to the primitives \
         until the penalty is nothing; penalise both"
    );
}

#[test]
fn sparse_activations_are_what_l1_gives() {
    let segments = segments(motion(10, 120));
    let zeros = |l1: f64| {
        let settings = NmfSettings {
            activation_penalty: Penalty { l1, l2: 0.0 },
            primitive_penalty: Penalty { l1: 0.0, l2: l1 },
            max_iterations: 20,
            ..settings(10)
        };
        let dictionary = learn_nmf(&segments, demonstrated(), &settings).unwrap();
        let projection = &dictionary.activation_mean_m;
        (dictionary.learning.rms_m, projection.sum())
    };
    let (plain_rms, _) = zeros(0.0);
    let (light_rms, light) = zeros(1e-6);
    let (heavy_rms, heavy) = zeros(3e-5);
    assert!(plain_rms <= light_rms && light_rms < heavy_rms);
    assert!(heavy < light, "{heavy} {light}");
}

#[test]
fn one_pass_of_many_segments_learns() {
    let segments = segments(many());
    let rms_m = |start, max_iterations| {
        let settings = NmfSettings {
            start,
            max_iterations,
            ..settings(13)
        };
        let learned = learn_nmf(&segments, demonstrated(), &settings).unwrap();
        assert_eq!(learned.learning.iterations, max_iterations);
        learned.learning.rms_m
    };
    let (nothing, one, three) = (
        rms_m(Start::Random, 0),
        rms_m(Start::Random, 1),
        rms_m(Start::Random, 3),
    );
    // Twenty batches: ahead of a full pass or two, and full passes go on from there.
    let online = rms_m(Start::Online, 0);
    assert!(online < 0.5 * nothing, "{online} {nothing}");
    assert!(online < one && online < three, "{online} {one} {three}");
    assert!(rms_m(Start::Online, 3) < online);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn objectives_never_rise(
        seed in any::<u64>(),
        samples in 2_usize..6,
        count in 12_usize..40,
        rank in 1_usize..12,
        weights in prop::array::uniform4(0.0_f64..1e-3),
        penalised in any::<bool>(),
        multiplicative in any::<bool>(),
        gaps in any::<bool>(),
        single in any::<bool>(),
    ) {
        let mut columns = motion(samples, count);
        // Noise of a millimetre, so that no fit is exact.
        for (i, v) in columns.iter_mut().enumerate() {
            *v += 1e-3 * ((i as f64 + seed as f64 % 1000.0) * 12.9898).sin();
        }
        if gaps {
            columns[(20, 3)] = f64::NAN;
            columns[(25, 7)] = f64::NAN;
        }
        let penalty = |l1, l2| if penalised { Penalty { l1, l2 } } else { Penalty::default() };
        let settings = NmfSettings {
            rank,
            seed,
            max_iterations: 30,
            relative_change: 0.0,
            update: if multiplicative { Update::Multiplicative } else { Update::Hals },
            activation_penalty: penalty(weights[0], weights[1]),
            primitive_penalty: penalty(weights[2], weights[3]),
            may_miss: gaps,
            precision: if single { Precision::F32 } else { Precision::F64 },
            ..NmfSettings::default()
        };
        let segments = segments(columns);
        let dictionary = match learn_nmf(&segments, demonstrated(), &settings) {
            Ok(dictionary) => dictionary,
            // The heaviest weights leave nothing, and that is said.
            Err(LearnError::PenaltyOfEverything) if penalised => return Ok(()),
            Err(error) => panic!("{error}"),
        };
        // Objectives are formed by subtraction: their rounding is that of the data.
        let data = {
            let problem = NmfProblem::new(&segments, &settings).unwrap();
            let columns_m = problem.read_block(&segments, 0).unwrap();
            let rows = segments.layout().rows();
            columns_m.iter().enumerate().map(|(i, v)| {
                let v = v - problem.offset_m[i % rows];
                if v.is_nan() { 0.0 } else { v * v }
            }).sum::<f64>()
        };
        let rounding = data * if single { 1e-6 } else { 1e-13 };
        for pair in dictionary.learning.objective_history_m2.windows(2) {
            prop_assert!(pair[1] <= pair[0] + rounding, "{} {}", pair[0], pair[1]);
        }
        prop_assert_eq!(Columns::count(&segments), dictionary.learning.segments);
    }
}
