//! Confidence intervals of errors, and differences on the same segments.

use inhand_model::{
    Bootstrap, Cluster, Estimate, Evaluation, Finger, Intervals, Measure, MethodIntervals,
    PairedDifference,
};
use maud::{Markup, html};

use super::table::{Column, Group, Line, grouped, numbers, table, words};
use super::{Body, Method, Named, named};
use crate::figure::forest::{self, Forest, ForestRow, axis_ends, signed};
use crate::figure::{Figure, FigureColumn, FigureData};
use crate::number::{NARROW_SPACE, NONE, count, decimals, percent, plain, to_mm};

/// Measures of which differences are drawn.
const DRAWN: [Measure; 3] = [Measure::P50, Measure::P75, Measure::P95];

/// What a measure is called in headings.
pub(crate) const fn measure_words(measure: Measure) -> &'static str {
    match measure {
        Measure::Mean => "mean",
        Measure::Rmse => "RMSE",
        Measure::P50 => "median",
        Measure::P75 => "75 %",
        Measure::P95 => "95 %",
    }
}

/// The part of the section on errors; `None` where no intervals were worked out.
pub(super) fn part(evaluation: &Evaluation, methods: &[Method<'_>]) -> Option<Body> {
    let methods: Vec<Named<'_>> = methods.iter().map(Method::named).collect();
    let mut part = Body::from(html! { h3 { "How sure these numbers are" } });
    part.append(body(evaluation.intervals.as_ref()?, &methods));
    Some(part)
}

/// Intervals and differences of the methods.
pub(super) fn body(intervals: &Intervals, methods: &[Named<'_>]) -> Body {
    let mut body = Body::from(html! {
        p { (made_words(&intervals.bootstrap)) }
        (estimates(intervals, methods))
    });
    if let Some(baseline) = &intervals.best_baseline {
        body.prose(html! {
            h3 { "Differences from the best baseline" }
            p {
                "Each method less " b { (baseline) } ", the baseline with the smallest mean error, on the same "
                (plural(intervals.bootstrap.cluster)) ": below zero the method is better. Those in which a plan of one failed are left out for both. An interval that \
                 leaves zero out speaks for a difference; with as many as are looked at here, some do so by chance."
            }
        });
        body.figure(differences_figure(intervals, baseline, methods));
        body.prose(differences(intervals, baseline, methods));
    }
    body
}

/// How a method stands against the best baseline, as a sentence with a space before it.
pub(super) fn against_words(intervals: &Intervals, method: &str, baseline: &str) -> Option<String> {
    let mut found = against(intervals, baseline, Measure::P75).filter(|d| d.method == method);
    let relative = found.next()?.relative?;
    Some(format!(
        " Its third quartile differs from that of {baseline}, the best baseline, by {}.",
        relative_words(&relative)
    ))
}

const fn plural(cluster: Cluster) -> &'static str {
    match cluster {
        Cluster::Segment => "segments",
        Cluster::Session => "sessions",
    }
}

/// How intervals were made, in words.
pub(crate) fn made_words(bootstrap: &Bootstrap) -> String {
    let about = match bootstrap.cluster {
        Cluster::Segment => {
            "segments are drawn, not instants, because neighbouring instants are not independent; the \
             intervals are about other segments of the same hand, object and task"
        }
        Cluster::Session => {
            "sessions are drawn, not segments or instants; the intervals are about other sessions of the same kind"
        }
    };
    let caution = match bootstrap.cluster {
        Cluster::Segment => {
            "Segments that follow one another in a take are alike too, which makes intervals somewhat too narrow."
        }
        Cluster::Session => {
            "Of few sessions intervals are too narrow: of six they hold the true value some 83 times in a hundred, not 95."
        }
    };
    format!(
        "Intervals hold the middle {} % of {} bootstrap draws (seed {}). A draw takes as many {} as there are, with replacement \
         and with all of their instants: {about}. Methods are compared within the same draws. \
         {caution}",
        plain(100.0 * bootstrap.confidence),
        count(bootstrap.draws, NARROW_SPACE),
        bootstrap.seed,
        plural(bootstrap.cluster),
    )
}

/// A value with its interval, in one line.
fn in_a_line(estimate: &Estimate, text: impl Fn(f64) -> String) -> String {
    let own = text(estimate.value);
    match estimate.interval {
        Some([low, high]) => format!("{own} ({} to {})", text(low), text(high)),
        None => own,
    }
}

/// The same in two lines, for the cells of a table.
fn in_a_cell(estimate: &Estimate, text: impl Fn(f64) -> String) -> String {
    in_a_line(estimate, text).replacen(" (", "\n(", 1)
}

/// An error in millimetres with its interval.
pub(crate) fn error_words(estimate: &Estimate) -> String {
    in_a_line(estimate, millimetres_3)
}

/// One decimal more than elsewhere: intervals are narrow.
fn millimetres_3(metres: f64) -> String {
    decimals(to_mm(metres), 3)
}

/// A relative difference with its interval.
pub(crate) fn relative_words(estimate: &Estimate) -> String {
    in_a_line(estimate, |share| signed(100.0 * share))
}

fn estimates(intervals: &Intervals, methods: &[Named<'_>]) -> Markup {
    let clusters = format!("({})", plural(intervals.bootstrap.cluster));
    let confidence = plain(100.0 * intervals.bootstrap.confidence);
    let mut columns = vec![words("method"), numbers("n", &clusters)];
    columns.extend(Measure::ALL.map(|measure| numbers(measure_words(measure), "mm")));
    let lines = |of: &dyn Fn(&MethodIntervals) -> Option<[Estimate; Measure::ALL.len()]>| {
        each(intervals, methods, &|own| {
            Some(error_cells(of(own).as_ref()))
        })
    };
    let groups = Finger::ALL.map(|finger| Group {
        head: Some(
            html! { span.swatch.(crate::figure::palette::finger_class(finger)) {} (finger.name()) },
        ),
        lines: lines(&|own| own.error.by_finger[finger]),
    });
    let contact_columns = [
        words("method"),
        numbers("n", &clusters),
        numbers("three or more", "%"),
        numbers("less recorded", "points"),
    ];
    let contacts = each(intervals, methods, &contact_cells);
    html! {
        (table(&format!("Error with {confidence} % intervals, all fingers"), &columns, lines(&|own| own.error.all)))
        details {
            summary { "The same for each finger" }
            (grouped("Error with intervals, by finger", &columns, &groups))
        }
        @if !contacts.is_empty() {
            (table(
                &format!("Share of instants with three or more contacts, with {confidence} % intervals"),
                &contact_columns,
                contacts,
            ))
        }
    }
}

/// A line for each method of which there are cells.
fn each(
    intervals: &Intervals,
    methods: &[Named<'_>],
    cells: &dyn Fn(&MethodIntervals) -> Option<Vec<String>>,
) -> Vec<Line> {
    let line = |method: &Named<'_>| {
        let own = (intervals.methods.iter()).find(|own| own.method == method.name)?;
        Some(Line {
            head: named(method),
            cells: cells(own)?,
            best: Vec::new(),
            stressed: method.default,
        })
    };
    methods.iter().filter_map(line).collect()
}

fn error_cells(error: Option<&[Estimate; Measure::ALL.len()]>) -> Vec<String> {
    match error {
        Some(error) => std::iter::once(made_of(&error[0]))
            .chain(error.each_ref().map(|own| in_a_cell(own, millimetres_3)))
            .collect(),
        None => vec![NONE.to_owned(); 1 + Measure::ALL.len()],
    }
}

/// `None` without an object.
fn contact_cells(own: &MethodIntervals) -> Option<Vec<String>> {
    let share = own.three_or_more.as_ref()?;
    let points = |value: f64| decimals(100.0 * value, 2);
    let less = own.three_or_more_less_recorded.as_ref();
    Some(vec![
        made_of(share),
        in_a_cell(share, percent),
        less.map_or_else(|| NONE.to_owned(), |own| in_a_cell(own, points)),
    ])
}

/// How many rows and clusters stand behind an estimate.
fn made_of(estimate: &Estimate) -> String {
    let [n, clusters] = [estimate.n, estimate.clusters].map(|n| count(n, NARROW_SPACE));
    format!("{n}\n({clusters})")
}

/// Differences of all fingers together against the best baseline.
pub(crate) fn against<'a>(
    intervals: &'a Intervals,
    baseline: &'a str,
    measure: Measure,
) -> impl Iterator<Item = &'a PairedDifference> {
    intervals.differences.iter().filter(move |difference| {
        difference.other == baseline && difference.finger.is_none() && difference.measure == measure
    })
}

/// `None` where no difference is relative to anything.
fn differences_figure(
    intervals: &Intervals,
    baseline: &str,
    methods: &[Named<'_>],
) -> Option<Figure> {
    let of = |difference: &PairedDifference| {
        methods
            .iter()
            .find(|method| method.name == difference.method)
    };
    let rows = |measure: Measure| -> Vec<ForestRow<'_>> {
        against(intervals, baseline, measure)
            .filter_map(|difference| {
                let (relative, method) = (difference.relative?, of(difference)?);
                Some(ForestRow {
                    label: method.name,
                    class: &method.class,
                    stressed: method.default,
                    value: 100.0 * relative.value,
                    interval: relative.interval.map(|ends| ends.map(|end| 100.0 * end)),
                })
            })
            .collect()
    };
    let drawn: Vec<(Measure, Vec<ForestRow<'_>>)> = DRAWN
        .map(|measure| (measure, rows(measure)))
        .into_iter()
        .filter(|(_, rows)| !rows.is_empty())
        .collect();
    if drawn.is_empty() {
        return None;
    }
    let ends = axis_ends(drawn.iter().flat_map(|(_, rows)| rows));
    let panels = drawn.into_iter().map(|(measure, rows)| {
        forest::draw(&Forest {
            title: match measure {
                Measure::P50 => "Median error",
                Measure::P75 => "Third quartile",
                _ => "95 % quantile",
            },
            axis_name: "difference from the baseline (%)",
            ends,
            rows,
        })
    });
    Some(Figure {
        id: "differences-from-baseline",
        title: format!("Error relative to the best baseline, {baseline}."),
        caption: format!(
            "Dot: difference of the methods' errors over the error of {baseline}, also as a number; bar: {} % interval; left of the dotted line the method is \
             better. ▸: more than the axis holds.",
            plain(100.0 * intervals.bootstrap.confidence)
        ),
        data: difference_data(intervals, baseline),
        legend: Vec::new(),
        panels: panels.collect(),
    })
}

fn difference_data(intervals: &Intervals, baseline: &str) -> FigureData {
    let all: Vec<&PairedDifference> = (DRAWN.iter())
        .flat_map(|&measure| against(intervals, baseline, measure))
        .collect();
    let relative = |of: fn(&Estimate) -> f64| {
        (all.iter()).map(move |d| d.relative.as_ref().map_or(f64::NAN, |e| 100.0 * of(e)))
    };
    let absolute = |of: fn(&Estimate) -> f64| all.iter().map(move |d| to_mm(of(&d.absolute)));
    let low = |e: &Estimate| e.interval.map_or(f64::NAN, |ends| ends[0]);
    let high = |e: &Estimate| e.interval.map_or(f64::NAN, |ends| ends[1]);
    FigureData::new([
        FigureColumn::words("motion", all.iter().map(|d| d.method.as_str())),
        FigureColumn::words("baseline", all.iter().map(|d| d.other.as_str())),
        FigureColumn::words("measure", all.iter().map(|d| d.measure.name())),
        FigureColumn::numbers("relative_percent", relative(|e| e.value)),
        FigureColumn::numbers("relative_low_percent", relative(low)),
        FigureColumn::numbers("relative_high_percent", relative(high)),
        FigureColumn::numbers("absolute_mm", absolute(|e| e.value)),
        FigureColumn::numbers("absolute_low_mm", absolute(low)),
        FigureColumn::numbers("absolute_high_mm", absolute(high)),
        FigureColumn::numbers("better_percent", all.iter().map(|d| 100.0 * d.share_better)),
    ])
}

const DIFFERENCES: [Column<'static>; 6] = [
    words("method"),
    numbers("difference", "mm"),
    numbers("difference", "%"),
    numbers("better in", "%"),
    numbers("n", ""),
    numbers("clusters", ""),
];

fn differences(intervals: &Intervals, baseline: &str, methods: &[Named<'_>]) -> Markup {
    let lines = |measure: Measure| -> Vec<Line> {
        against(intervals, baseline, measure)
            .map(|difference| {
                let method = methods.iter().find(|m| m.name == difference.method);
                Line {
                    head: method.map_or_else(|| html! { (difference.method) }, named),
                    cells: vec![
                        error_words(&difference.absolute),
                        difference
                            .relative
                            .as_ref()
                            .map_or_else(|| NONE.to_owned(), relative_words),
                        percent(difference.share_better),
                        count(difference.absolute.n, NARROW_SPACE),
                        count(difference.absolute.clusters, NARROW_SPACE),
                    ],
                    best: Vec::new(),
                    stressed: method.is_some_and(|m| m.default),
                }
            })
            .collect()
    };
    let groups: Vec<Group> = Measure::ALL
        .map(|measure| Group {
            head: Some(html! { (measure_words(measure)) }),
            lines: lines(measure),
        })
        .into_iter()
        .filter(|group| !group.lines.is_empty())
        .collect();
    html! {
        details {
            summary { "Differences as numbers" }
            (grouped(&format!("Error less that of {baseline}, all fingers, on the same {}", plural(intervals.bootstrap.cluster)), &DIFFERENCES, &groups))
            p.note {
                "Better in: share of " (plural(intervals.bootstrap.cluster)) " in which the method has the smaller error, a tie counting half, so that 50 % is chance."
            }
        }
    }
}
