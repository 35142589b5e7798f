//! Movement of recorded and planned motion.

use inhand_model::{Finger, FingerMovement, Movement, MovementAnalysis, Statistics};
use maud::{Markup, html};

use super::{Body, Method, Motion, MotionRow, motions, motions_by_finger};
use crate::Report;
use crate::figure::row_plot::{self, Mark, MarkShape, PlotRow, RowPlot, WANTED_TICKS};
use crate::figure::scale::{Scale, whole_steps};
use crate::figure::{Figure, FigureData, Key, Panel, finger_keys};
use crate::table::{Table, UPPER, statistic};
use crate::words::{count, count_range, millimetres, plain, short, to_mm};

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

/// The section's content; `None` where movement was not measured.
pub(super) fn section(report: &Report<'_>, methods: &[Method<'_>]) -> Option<Body> {
    let analysis = report.evaluation.movement.as_ref()?;
    let motions = motions(&analysis.recorded, &analysis.methods, methods);
    let (speeds, smoothness) = MEASURES.split_at(3);
    let table = Body::default().prose(finger_table(&motions)).prose(html! {
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
    let smoothness = Body::default().figure(Figure {
        id: "movement-smoothness",
        title: "How smoothly each fingertip moves.".to_owned(),
        ..figure(smoothness, &motions)
    });
    let body = Body::default().figure(figure(speeds, &motions));
    Some(
        body.folded("Smoothness", smoothness)
            .folded("Medians of each fingertip, and definitions", table)
            .folded(
                "Distance to the nearest demonstration",
                Body::from(nearest_part(analysis, &motions)),
            ),
    )
}

/// A motion.
type Moving<'a> = Motion<'a, Movement>;

fn finger_table<'a>(
    motions: &'a [Moving<'a>],
) -> Table<MotionRow<'a, Movement, &'a FingerMovement>> {
    let caption = "Motion of each fingertip: medians over segments";
    let median = |s: &Statistics| statistic(s, |s| s.p50);
    motions_by_finger(caption, motions, |own, finger| &own.by_finger[finger])
        .lengths("length", |(_, own)| median(&own.length_m))
        .decimals("peak speed", "mm/s", 1, |(_, own)| {
            to_mm(median(&own.peak_speed_m_s))
        })
        .percents("still", "%", |(_, own)| median(&own.static_share))
        .decimals("SPARC", "", 2, |(_, own)| median(&own.sparc))
        .decimals("LDLJ", "", 2, |(_, own)| median(&own.ldlj))
        .counts("n", "", |(_, own)| own.length_m.n)
        .counts("left out", "", |(_, own)| own.length_m.n_left_out)
}

fn nearest_part(analysis: &MovementAnalysis, motions: &[Moving<'_>]) -> Markup {
    let rows = motions
        .iter()
        .filter_map(|motion| Some((motion, motion.facts.nearest_demonstration_m?)));
    let caption = "Time-warped distance of the whole hand to the nearest demonstration (mm)";
    let table = Table::new(caption, rows, "motion", |(motion, _)| motion.head.clone())
        .stressed(|(motion, _)| motion.stressed)
        .statistics(&UPPER, "mm", millimetres, |(_, s)| *s)
        .counts("n", "", |(_, s)| s.n)
        .counts("left out", "", |(_, s)| s.n_left_out);
    let available = analysis.demonstrations_available;
    html! {
        @if table.is_empty() {
            p { "The distance to the nearest demonstration is not known: the training segments were not available." }
        } @else {
            (table)
            p.note {
                "The nearest of " (count(analysis.demonstrations)) " training segments"
                @if analysis.demonstrations != available { ", an even spread of the " (count(available)) " there are" }
                ". Dynamic time warping in the symmetric form of H. Sakoe and S. Chiba (1978)"
                @if let Some(band) = analysis.warping_band { ", shifts of at most " (band) " samples" }
                ": the sum over the path through the alignment, of weight 2 for diagonal steps, over the number of samples of both motions. It is the mean \
                 distance of matched configurations, each the root of the sum of squares over the five fingertips, \
                 and does not grow with the length of a segment. The recorded line shows how near unseen motion of the same hand comes."
            }
        }
    }
}

fn figure(measures: &[Measure], motions: &[Moving<'_>]) -> Figure {
    let cells: Vec<(&Measure, &str, Finger, Statistics)> = (measures.iter())
        .flat_map(|measure| motions.iter().map(move |motion| (measure, motion)))
        .flat_map(|(measure, motion)| {
            let fingers = motion.facts.by_finger.iter();
            fingers.map(move |(finger, own)| (measure, motion.name, finger, (measure.of)(own)))
        })
        .collect();
    let sizes: Vec<usize> = cells
        .iter()
        .map(|cell| cell.3.n)
        .filter(|n| *n > 0)
        .collect();
    let scaled = |cell: &(&Measure, &str, Finger, Statistics), of: fn(&Statistics) -> f64| {
        cell.0.scale * statistic(&cell.3, of)
    };
    Figure {
        id: "movement",
        title: "How each fingertip moves.".to_owned(),
        caption: format!(
            "Point: median over the test segments. Line: from the first to the third quartile; n = {} segments. Whole distributions \
             are in evaluation.json, single segments in segments.parquet.",
            count_range(&sizes)
        ),
        data: FigureData::about(&cells)
            .words("measure", |cell| cell.0.key)
            .words("motion", |cell| cell.1)
            .words("finger", |cell| cell.2.name())
            .counts("n", |cell| cell.3.n)
            .counts("n_left_out", |cell| cell.3.n_left_out)
            .numbers("p25", |cell| scaled(cell, |s| s.p25))
            .numbers("p50", |cell| scaled(cell, |s| s.p50))
            .numbers("p75", |cell| scaled(cell, |s| s.p75))
            .done(),
        legend: finger_keys(Key::area),
        panels: measures
            .iter()
            .map(|measure| panel(measure, motions))
            .collect(),
    }
}

/// A row a motion: for each finger a line from quartile to quartile with the median on it.
fn panel(measure: &Measure, motions: &[Moving<'_>]) -> Panel {
    let quartiles = |own: &FingerMovement| {
        let s = (measure.of)(own);
        let scaled = [s.p25, s.p50, s.p75].map(|value| measure.scale * value);
        (s.n > 0).then_some((s.n, scaled))
    };
    let row = |motion: &Moving<'_>| {
        let fingers = motion.facts.by_finger.iter();
        let marks = fingers.filter_map(|(finger, own)| {
            let (n, [p25, p50, p75]) = quartiles(own)?;
            let [a, b, c] = [p25, p50, p75].map(short);
            let words = format!("{finger}: median {b}, quartiles {a} and {c} (n = {n})");
            Some([
                Mark::over(MarkShape::Bar, [p25, p75]).of_finger(finger, words.clone()),
                Mark::at(MarkShape::Dot, p50).of_finger(finger, words),
            ])
        });
        marks.flatten().collect()
    };
    let fingers = motions
        .iter()
        .flat_map(|motion| motion.facts.by_finger.as_array());
    let ends = fingers
        .filter_map(quartiles)
        .flat_map(|(_, [p25, _, p75])| [p25, p75]);
    let mut shown: Vec<f64> = ends.filter(|value| value.is_finite()).collect();
    // What cannot be negative starts at 0.
    if shown.iter().all(|value| *value >= 0.0) {
        shown.push(0.0);
    }
    let [low, high] = whole_steps(shown, 0.0, WANTED_TICKS);
    let rows = motions.iter().map(|motion| PlotRow {
        label: motion.name,
        stressed: motion.stressed,
        marks: row(motion),
        ..PlotRow::default()
    });
    row_plot::draw(&RowPlot {
        title: measure.title,
        axis: (measure.axis, Scale::linear(low, high)),
        rows: rows.collect(),
        ..RowPlot::default()
    })
}
