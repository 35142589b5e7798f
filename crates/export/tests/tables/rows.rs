//! Rows of an evaluation go into Parquet and come back.

use inhand_export::{RowsFile, evaluation_rows, rows_facts, write_parquet};
use inhand_model::{EvaluationRows, Finger, MethodRows, PerFinger, SegmentLayout, SegmentOrigin};

const SAMPLES: usize = 3;

/// Numbers as files store them: two methods on two segments of two takes; the second segment's plan failed for the second method.
fn rows(object: bool) -> EvaluationRows {
    let number = |k: usize, finger: Finger| (k * 5 + finger.index()) as f64 / 1024.0;
    let by_instant = |offset: f64| -> Vec<PerFinger<f64>> {
        (0..2 * SAMPLES)
            .map(|k| PerFinger::from_fn(|finger| offset + number(k, finger)))
            .collect()
    };
    let mut failed = by_instant(0.5);
    failed[SAMPLES..].fill(PerFinger::new([f64::NAN; 5]));
    let method = |name: &str, error_m: Vec<PerFinger<f64>>| MethodRows {
        name: name.to_owned(),
        distance_m: object.then(|| by_instant(-1.0 / 512.0)),
        hull_distance_m: by_instant(-0.125),
        nearest_pair_m: error_m.iter().map(|e| e[Finger::Thumb] + 0.25).collect(),
        // The baseline plans neither object nor prediction region.
        object_position_error_m: (object && name == "prior").then(|| vec![0.125; 2 * SAMPLES]),
        object_angle_error_rad: (object && name == "prior").then(|| vec![0.5; 2 * SAMPLES]),
        mahalanobis: (name == "prior").then(|| by_instant(2.0)),
        error_m,
    };
    EvaluationRows {
        layout: SegmentLayout {
            samples: SAMPLES,
            rate_hz: 100.0,
            object,
        },
        takes: vec!["a,\"b\"".to_owned(), "c".to_owned()],
        segments: vec![
            SegmentOrigin { take: 0, start: 4 },
            SegmentOrigin { take: 1, start: 0 },
        ],
        filled: (0..2 * SAMPLES)
            .map(|k| PerFinger::from_fn(|finger| (k + finger.index()) % 4 == 0))
            .collect(),
        object_filled: (0..2 * SAMPLES).map(|k| object && k == 1).collect(),
        recorded_distance_m: object.then(|| by_instant(0.25)),
        recorded_hull_distance_m: by_instant(-0.5),
        recorded_nearest_pair_m: vec![0.75; 2 * SAMPLES],
        methods: vec![method("prior", by_instant(0.0)), method("line", failed)],
    }
}

/// NaN is not equal to itself, its text is.
fn same(a: &EvaluationRows, b: &EvaluationRows) {
    assert_eq!(format!("{a:?}"), format!("{b:?}"));
}

fn written(rows: &EvaluationRows) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rows.parquet");
    let mut file = std::fs::File::create(&path).expect("a file");
    let about = [rows_facts("session", rows)];
    write_parquet(
        &evaluation_rows("session", rows, None),
        rows.instants(),
        &about,
        &mut file,
    )
    .expect("written");
    (folder, path)
}

#[test]
fn what_was_written_is_read_back() {
    for object in [true, false] {
        let rows = rows(object);
        let (_folder, path) = written(&rows);
        let file = RowsFile::open(&path).expect("a table of rows");
        assert_eq!(
            (file.session(), file.methods()),
            ("session", &["prior".to_owned(), "line".to_owned()][..])
        );
        same(&file.read().expect("sound"), &rows);
        let errors = file.error_m("line", Finger::Ring).expect("it is there");
        assert_eq!(
            errors[..SAMPLES],
            [3.0, 8.0, 13.0].map(|k| 0.5 + k / 1024.0)
        );
        assert!(errors[SAMPLES..].iter().all(|e| e.is_nan()));
        let refused = file
            .error_m("hold", Finger::Ring)
            .expect_err("not evaluated");
        assert!(refused.to_string().contains("prior, line"), "{refused}");
    }
}

#[test]
fn numbers_are_stored_to_the_nanometre() {
    let mut exact = rows(true);
    let errors_m = [1.0 / 3.0, 0.1, f64::NAN, 1e-12, 123.456, 0.0];
    for (k, error_m) in errors_m.into_iter().enumerate() {
        exact.methods[0].error_m[k] = PerFinger::new([error_m; 5]);
    }
    let (_folder, path) = written(&exact);
    let read = RowsFile::open(&path).and_then(|file| file.error_m("prior", Finger::Index));
    for (stored, exact) in read.expect("sound").into_iter().zip(errors_m) {
        assert!(exact.is_nan() && stored.is_nan() || (stored - exact).abs() <= 0.5e-9);
    }
}

#[test]
fn rows_without_methods_are_empty() {
    let mut none = rows(true);
    none.methods.clear();
    let (_folder, path) = written(&none);
    let read = RowsFile::open(&path)
        .and_then(|file| file.read())
        .expect("sound");
    assert_eq!(read.instants(), 0);
}

#[test]
fn cut_and_other_files_are_refused() {
    let (folder, path) = written(&rows(true));
    let whole = std::fs::read(&path).expect("it is there");
    for kept in [0, 3, 100, whole.len() / 2, whole.len() - 1] {
        let cut = folder.path().join("cut.parquet");
        std::fs::write(&cut, &whole[..kept]).expect("written");
        let refused = RowsFile::open(&cut).expect_err("cut");
        assert!(refused.to_string().contains("cut.parquet"), "{refused}");
    }
    let other = folder.path().join("other.parquet");
    let mut file = std::fs::File::create(&other).expect("a file");
    write_parquet(
        &evaluation_rows("session", &rows(true), None),
        6,
        &[],
        &mut file,
    )
    .expect("written");
    let refused = RowsFile::open(&other).expect_err("no rows of ours");
    assert!(refused.to_string().contains("other content"), "{refused}");
}
