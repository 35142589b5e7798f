//! Movement of recorded and planned motion.

use inhand_model::{Finger, FingerMovement, Movement, MovementAnalysis, Statistics};
use maud::{Markup, html};

use super::session::name;
use super::table::{Column, Group, Line, grouped, numbers, table, words};
use super::{Body, Method};
use crate::figure::finger_rows::{self, FingerRow, FingerRows};
use crate::figure::palette::{RECORDED_CLASS, finger_class};
use crate::figure::{Figure, FigureColumn, FigureData, Key};
use crate::number::{NARROW_SPACE, NONE, count, decimals, millimetres, percent, plain, to_mm};
use crate::report::Report;

/// A measure of a fingertip's motion.
struct Measure {
    /// Name in the data of the figure.
    key: &'static str,
    title: &'static str,
    axis: &'static str,
    of: fn(&FingerMovement) -> Statistics,
    /// From the unit of the statistics to that of the axis.
    scale: f64,
}

const MEASURES: [Measure; 5] = [
    Measure {
        key: "length_mm",
        title: "Path length",
        axis: "length in a segment (mm)",
        of: |finger| finger.length_m,
        scale: 1e3,
    },
    Measure {
        key: "peak_speed_mm_s",
        title: "Peak speed",
        axis: "largest speed (mm/s)",
        of: |finger| finger.peak_speed_m_s,
        scale: 1e3,
    },
    Measure {
        key: "static_percent",
        title: "Standing still",
        axis: "share of the steps (%)",
        of: |finger| finger.static_share,
        scale: 100.0,
    },
    Measure {
        key: "sparc",
        title: "SPARC",
        axis: "spectral arc length, right is smoother",
        of: |finger| finger.sparc,
        scale: 1.0,
    },
    Measure {
        key: "ldlj",
        title: "LDLJ",
        axis: "log dimensionless jerk, right is smoother",
        of: |finger| finger.ldlj,
        scale: 1.0,
    },
];

/// A motion with its head in tables.
struct Moving<'a> {
    name: &'a str,
    head: Markup,
    stressed: bool,
    movement: &'a Movement,
}

/// The section's content; `None` where movement was not measured.
pub(super) fn section(report: &Report<'_>, methods: &[Method<'_>]) -> Option<Body> {
    let analysis = report.evaluation.movement.as_ref()?;
    let motions = motions(analysis, methods);
    let mut body = Body::from(html! {
        p {
            "How each fingertip moves over the test segments, as recorded and as planned: a value for each segment, medians here, whole \
             distributions in " code { "evaluation.json" } " and every segment in " code { "segments.parquet" } "."
        }
    });
    body.figure(figure(&motions)).prose(html! {
        (finger_table(&motions))
        p.note {
            "Speeds are those between neighbouring samples; standing still is slower than " (plain(to_mm(analysis.static_speed_m_s))) " mm/s. "
            b { "SPARC" } ": minus the arc length of the normalised spectrum of the speed up to 10 Hz; " b { "LDLJ" } ": minus the logarithm of the \
             dimensionless jerk of the speed. Larger, nearer to 0 where negative, is smoother. Both by S. Balasubramanian, A. Melendez-Calderon, \
             A. Roby-Brami and E. Burdet, On the analysis of movement smoothness, J. NeuroEng. Rehabil. 12:112, 2015, "
             "doi:10.1186/s12984-015-0090-9, with its settings. They are made for whole movements: a segment is cut out of a longer one, so \
             that values compare motions over the same segments and not with those of other studies. Left out: gaps, plans that failed, and \
             motion that has no such measure (a fingertip that stays has no smoothness, one of constant speed no jerk)."
        }
    });
    body.prose(nearest_part(analysis, &motions));
    Some(body)
}

fn motions<'a>(analysis: &'a MovementAnalysis, methods: &'a [Method<'_>]) -> Vec<Moving<'a>> {
    let recorded = Moving {
        name: "recorded",
        head: html! { span.swatch.(RECORDED_CLASS) {} "recorded" },
        stressed: false,
        movement: &analysis.recorded,
    };
    let planned = methods.iter().filter_map(|method| {
        let own = &method.evaluation.name;
        let (name_, movement) = analysis.methods.iter().find(|(name, _)| name == own)?;
        Some(Moving {
            name: name_,
            head: name(method),
            stressed: method.default,
            movement,
        })
    });
    std::iter::once(recorded).chain(planned).collect()
}

fn finger_table(motions: &[Moving<'_>]) -> Markup {
    const COLUMNS: [Column<'static>; 8] = [
        words("motion"),
        numbers("n", ""),
        numbers("left out", ""),
        numbers("length", "mm"),
        numbers("peak speed", "mm/s"),
        numbers("still", "%"),
        numbers("SPARC", ""),
        numbers("LDLJ", ""),
    ];
    let groups = Finger::ALL.map(|finger| Group {
        head: Some(html! { span.swatch.(finger_class(finger)) {} (finger.name()) }),
        lines: (motions.iter())
            .map(|motion| line(motion, &motion.movement.by_finger[finger]))
            .collect(),
    });
    grouped(
        "Motion of each fingertip: medians over segments",
        &COLUMNS,
        &groups,
    )
}

fn line(motion: &Moving<'_>, finger: &FingerMovement) -> Line {
    let median = |s: Statistics, print: fn(f64) -> String| match s.n {
        0 => NONE.to_owned(),
        _ => print(s.p50),
    };
    Line {
        head: motion.head.clone(),
        cells: vec![
            count(finger.length_m.n, NARROW_SPACE),
            count(finger.length_m.n_left_out, NARROW_SPACE),
            median(finger.length_m, millimetres),
            median(finger.peak_speed_m_s, |speed| decimals(to_mm(speed), 1)),
            median(finger.static_share, percent),
            median(finger.sparc, |sparc| decimals(sparc, 2)),
            median(finger.ldlj, |ldlj| decimals(ldlj, 2)),
        ],
        best: Vec::new(),
        stressed: motion.stressed,
    }
}

fn nearest_part(analysis: &MovementAnalysis, motions: &[Moving<'_>]) -> Markup {
    const COLUMNS: [Column<'static>; 7] = [
        words("motion"),
        numbers("n", ""),
        numbers("left out", ""),
        numbers("median", "mm"),
        numbers("75 %", "mm"),
        numbers("95 %", "mm"),
        numbers("max", "mm"),
    ];
    let lines: Vec<Line> = (motions.iter())
        .filter_map(|motion| Some((motion, motion.movement.nearest_demonstration_m?)))
        .map(|(motion, s)| Line {
            head: motion.head.clone(),
            cells: [s.n, s.n_left_out]
                .map(|n| count(n, NARROW_SPACE))
                .into_iter()
                .chain([s.p50, s.p75, s.p95, s.max].map(|length| match s.n {
                    0 => NONE.to_owned(),
                    _ => millimetres(length),
                }))
                .collect(),
            best: Vec::new(),
            stressed: motion.stressed,
        })
        .collect();
    if lines.is_empty() {
        return html! {
            p { "How near motion is to what was demonstrated is not known here: the training segments were not at hand." }
        };
    }
    let looked_at = count(analysis.demonstrations, NARROW_SPACE);
    let available = count(analysis.demonstrations_available, NARROW_SPACE);
    html! {
        (table("Time-warped distance of the whole hand to the nearest demonstration (mm)", &COLUMNS, lines))
        p.note {
            "The nearest of " (looked_at) " training segments"
            @if looked_at != available { ", an even spread of the " (available) " there are" }
            ". Dynamic time warping in the symmetric form of H. Sakoe and S. Chiba (1978)"
            @if let Some(band) = analysis.warping_band { ", shifts of at most " (band) " samples" }
            ": the sum over the path through the alignment, of weight 2 for diagonal steps, over the number of samples of both motions. It is the mean \
             distance of matched configurations, each the root of the sum of squares over the five fingertips, \
             and does not grow with the length of a segment. The recorded line shows how near unseen motion of the same hand comes."
        }
    }
}

fn figure(motions: &[Moving<'_>]) -> Figure {
    let panels = MEASURES.iter().map(|measure| {
        finger_rows::draw(&FingerRows {
            title: measure.title,
            axis_name: measure.axis,
            scale: measure.scale,
            rows: (motions.iter())
                .map(|motion| FingerRow {
                    label: motion.name,
                    stressed: motion.stressed,
                    by_finger: (motion.movement.by_finger.each_ref()).map(measure.of),
                })
                .collect(),
        })
    });
    Figure {
        id: "movement",
        title: "How each fingertip moves.".to_owned(),
        caption: "Point: median over segments. Line: from the first to the third quartile. A dash: no segment has such a measure.".to_owned(),
        data: data(motions),
        legend: Finger::ALL.map(|finger| Key::area(finger.name(), finger_class(finger))).into(),
        panels: panels.collect(),
    }
}

fn data(motions: &[Moving<'_>]) -> FigureData {
    let cells = || {
        MEASURES.iter().flat_map(move |measure| {
            motions.iter().flat_map(move |motion| {
                Finger::ALL.into_iter().map(move |finger| {
                    let s = (measure.of)(&motion.movement.by_finger[finger]);
                    (measure, motion.name, finger, s)
                })
            })
        })
    };
    let number = |of: fn(&Statistics) -> f64| {
        cells().map(move |(measure, .., s)| match s.n {
            0 => f64::NAN,
            _ => measure.scale * of(&s),
        })
    };
    FigureData::new([
        FigureColumn::words("measure", cells().map(|cell| cell.0.key)),
        FigureColumn::words("motion", cells().map(|cell| cell.1)),
        FigureColumn::words("finger", cells().map(|cell| cell.2.name())),
        FigureColumn::counts("n", cells().map(|cell| cell.3.n)),
        FigureColumn::counts("n_left_out", cells().map(|cell| cell.3.n_left_out)),
        FigureColumn::numbers("p25", number(|s| s.p25)),
        FigureColumn::numbers("p50", number(|s| s.p50)),
        FigureColumn::numbers("p75", number(|s| s.p75)),
    ])
}
