//! Figures of what a run shows beside its numbers.

use inhand_model::{
    ExplainedVariance, Filtering, Finger, Hull, Illustrations, Path, PathExample, PerFinger,
    PointCloud, PrimitivePath, Spectrum, TakeGaps, TrackGaps, WorstCase,
};
use inhand_report::{Figure, FigureColumn, FigureValues, Report, figures, html};

use crate::sample;

fn path(offset: f64) -> Path {
    PerFinger::from_fn(|finger| {
        let y = 0.02 * finger.index() as f64;
        (0..20)
            .map(|t| [0.08 + 0.001 * f64::from(t), y + offset, 0.01])
            .collect()
    })
}

fn tetrahedron(at: f64) -> Hull {
    Hull {
        vertices_m: [
            [0.0, 0.0, 0.0],
            [0.01, 0.0, 0.0],
            [0.0, 0.01, 0.0],
            [0.0, 0.0, 0.01],
        ]
        .map(|[x, y, z]| [x + at, y, z])
        .into(),
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        normals: vec![[0.0, 0.0, -1.0]; 4],
        offsets_m: vec![0.0; 4],
    }
}

fn gaps(take: &str, missing_s: Vec<[f64; 2]>, filled_s: Vec<[f64; 2]>) -> TakeGaps {
    let track = |track: &str, missing_s, filled_s| TrackGaps {
        track: track.into(),
        missing_s,
        filled_s,
    };
    TakeGaps {
        take: take.into(),
        role: "test".into(),
        duration_s: 60.0,
        tracks: vec![
            track("thumb", missing_s, filled_s),
            track("hand", vec![], vec![]),
        ],
    }
}

fn illustrations() -> Illustrations {
    let statistics = sample::statistics((0..100).map(|k| 1e-5 * f64::from(k)).collect());
    let hertz = || (0..=50).map(f64::from);
    Illustrations {
        gaps: vec![
            gaps("whole", vec![], vec![]),
            gaps(
                "take <b>",
                vec![[1.0, 2.5]],
                vec![[10.0, 10.05], [10.06, 10.1]],
            ),
        ],
        filtering: Some(Filtering {
            take: "take <b>".into(),
            finger: Finger::Ring,
            axis: "z",
            time_s: (0..100).map(|k| 3.0 + 0.01 * f64::from(k)).collect(),
            before_m: (0..100).map(|k| 1e-4 * f64::from(k % 7)).collect(),
            after_m: (0..100).map(|k| 1e-6 * f64::from(k)).collect(),
            moved: PerFinger::from_fn(|_| statistics),
        }),
        spectrum: Some(Spectrum {
            frequency_hz: hertz().collect(),
            before_m2_hz: hertz().map(|f| 1e-7 / (1.0 + f)).collect(),
            after_m2_hz: hertz().map(|f| 1e-7 / (1.0 + f * f)).collect(),
            window: 100,
            windows: 12,
        }),
        paths: vec![PathExample {
            why: "median",
            take: "take <b>".into(),
            segment: 4,
            start_s: 4.04,
            rate_hz: 20.0,
            recorded_m: path(0.0),
            methods: vec![
                ("residual".into(), path(0.001)),
                ("hermite".into(), path(0.002)),
            ],
        }],
        worst: vec![WorstCase {
            method: "residual".into(),
            take: "take <b>".into(),
            file: "take <b>.mcap".into(),
            topic: "/generated/residual/fingertips".into(),
            finger: Finger::Little,
            segment: 7,
            time_s: 7.5,
            error_m: 0.0125,
            errors_m: vec![0.0, 0.0125, f64::NAN, 0.001],
        }],
        hulls: Some(PerFinger::from_fn(|finger| {
            tetrahedron(0.02 * finger.index() as f64)
        })),
        primitives: vec![PrimitivePath {
            index: 12,
            share: 0.25,
            path_m: path(0.0),
        }],
        explained: Some(ExplainedVariance {
            principal: vec![(1, 0.61), (2, 0.8), (10, 0.995)],
            learned: (10, 0.97),
            segments: 59,
        }),
        point_clouds: vec![PointCloud {
            points: 50_000,
            excess_m: statistics,
            three_or_more: 0.5,
            exact_three_or_more: 0.75,
        }],
    }
}

const IDS: [&str; 9] = [
    "gaps",
    "filtering",
    "spectrum",
    "path-median",
    "worst-errors",
    "hulls",
    "primitives",
    "explained-variance",
    "point-clouds",
];

fn with(illustrations: &Illustrations) -> (String, Vec<Figure>) {
    let (evaluation, provenance) = (sample::evaluation(true), sample::provenance());
    let report = Report {
        illustrations: Some(illustrations),
        ..Report::new(&evaluation, &provenance)
    };
    let page = html(&report).expect("the sample makes a page");
    (page, figures(&report).expect("and figures"))
}

fn figure<'a>(figures: &'a [Figure], id: &str) -> &'a Figure {
    let mut found = figures.iter().filter(|figure| figure.id == id);
    let first = found.next().unwrap_or_else(|| panic!("no figure {id}"));
    assert!(found.next().is_none(), "{id} is there twice");
    first
}

fn numbers<'a>(figure: &'a Figure, column: &str) -> &'a [f64] {
    match figure.data.column(column) {
        Some(FigureColumn {
            values: FigureValues::Numbers(values),
            ..
        }) => values,
        other => panic!("{column}: {other:?}"),
    }
}

#[test]
fn each_illustration_is_a_figure_with_its_numbers() {
    let (page, figures) = with(&illustrations());
    for id in IDS {
        let figure = figure(&figures, id);
        assert!(page.contains(&format!("id=\"figure-{id}\"")), "{id}");
        assert!(figure.data.rows() > 0, "{id}");
        let svg = figure.print_svg();
        assert!(!svg.contains("NaN"), "{id}");
        for text in [&svg, &page] {
            assert!(!text.contains("take <b>"), "{id}");
        }
    }
    let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found}");
    close(numbers(figure(&figures, "gaps"), "end_s")[0], 2.5);
    assert_eq!(figure(&figures, "gaps").data.rows(), 3);
    close(
        numbers(figure(&figures, "filtering"), "position_mm")[1],
        0.1,
    );
    // A square metre is 10^6 square millimetres.
    close(
        numbers(figure(&figures, "spectrum"), "after_mm2_hz")[2],
        0.1 / 5.0,
    );
    let path = figure(&figures, "path-median");
    assert_eq!(path.data.rows(), 3 * 5 * 20);
    close(numbers(path, "time_s")[19], 4.04 + 0.95);
    close(numbers(path, "y_mm")[100], 1.0);
    close(
        numbers(figure(&figures, "worst-errors"), "error_mm")[1],
        12.5,
    );
    close(numbers(figure(&figures, "hulls"), "x_mm")[1], 10.0);
    close(
        numbers(figure(&figures, "primitives"), "share_percent")[0],
        25.0,
    );
    close(
        numbers(figure(&figures, "explained-variance"), "explained_percent")[3],
        97.0,
    );
    let clouds = figure(&figures, "point-clouds");
    close(numbers(clouds, "max_mm")[0], 0.99);
    close(numbers(clouds, "three_or_more_percent")[0], 50.0);
}

#[test]
fn the_worst_case_says_how_to_look_at_it() {
    let (page, _) = with(&illustrations());
    assert!(
        page.contains("inhand cut './take &lt;b&gt;.mcap' --from 5.5 --to 9.5 -o worst-1.mcap")
    );
    assert!(page.contains("/generated/residual/fingertips"));
    // The sentence about contacts by clouds.
    assert!(
        page.contains("50.0\u{a0}% by 50\u{202f}000 points"),
        "contacts by clouds"
    );
}

#[test]
fn what_is_not_there_has_a_sentence_and_no_figure() {
    let empty = Illustrations {
        gaps: vec![gaps("whole", vec![], vec![])],
        ..Illustrations::default()
    };
    let (page, figures) = with(&empty);
    for id in IDS {
        assert!(figures.iter().all(|figure| figure.id != id), "{id}");
    }
    for sentence in [
        "No test take has a few seconds without a gap",
        "No interval of the test takes is long enough for a spectrum.",
        "No segment was planned, so no path is shown.",
        "No segment was planned, so there is no worst error.",
        "No training segment uses any primitive.",
        "explained variance is not available",
    ] {
        assert!(page.contains(sentence), "{sentence}");
    }
    assert!(!page.contains("Clouds of points"));
    // Without illustrations there is nothing to say of them.
    let (evaluation, provenance) = (sample::evaluation(true), sample::provenance());
    let page = html(&Report::new(&evaluation, &provenance)).expect("a page");
    assert!(!page.contains("The worst errors") && !page.contains("The filter:"));
}

/// Takes with gaps beyond those that are drawn are counted, and stay in the data.
#[test]
fn many_takes_are_not_all_drawn() {
    let many = Illustrations {
        gaps: (0..40)
            .map(|k| {
                gaps(
                    &format!("take {k}"),
                    vec![[1.0, 1.1 + f64::from(k)]],
                    vec![],
                )
            })
            .collect(),
        ..Illustrations::default()
    };
    let (_, figures) = with(&many);
    let gaps = figure(&figures, "gaps");
    assert_eq!(gaps.data.rows(), 40);
    assert!(
        gaps.caption.contains("28 are not drawn, with 27.10 s"),
        "{}",
        gaps.caption
    );
    let svg = gaps.print_svg();
    assert!(svg.contains("take 39, test") && !svg.contains("take 27, test"));
}
