//! Confidence intervals of errors, and differences on the same segments.

use inhand_model::{
    Bootstrap, Cluster, Estimate, Finger, Intervals, Measure, MethodIntervals, PairedDifference,
};
use maud::html;

use super::{Body, Method, method_table, named};
use crate::figure::row_plot::{self, Mark, MarkShape, PlotRow, RowPlot, WANTED_TICKS};
use crate::figure::scale::{Scale, whole_steps};
use crate::figure::{Figure, FigureData};
use crate::table::{Table, known};
use crate::words::{count, count_range, decimals, millimetres, percent, plain, signed, to_mm};

/// Measures of which differences are drawn, with the titles of their panels.
const DRAWN: [(Measure, &str); 3] = [
    (Measure::P50, "Median error"),
    (Measure::P75, "Third quartile"),
    (Measure::P95, "95 % quantile"),
];

/// Name of the figure of differences.
pub(super) const DIFFERENCES: &str = "differences-from-baseline";

/// A measure in headings.
pub(crate) const fn measure_words(measure: Measure) -> &'static str {
    match measure {
        Measure::Mean => "mean",
        Measure::Rmse => "RMSE",
        Measure::P50 => "median",
        Measure::P75 => "75 %",
        Measure::P95 => "95 %",
    }
}

/// The estimate of a measure.
pub(crate) fn estimate(all: &[Estimate; Measure::ALL.len()], measure: Measure) -> &Estimate {
    let place = Measure::ALL.iter().position(|own| *own == measure);
    &all[place.unwrap_or(0)]
}

/// Intervals and differences of the methods; `id` names the figure of differences.
pub(super) fn body<T>(intervals: &Intervals, methods: &[Method<'_, T>], id: &'static str) -> Body {
    // Compiled once for evaluations and summaries.
    let methods: &Vec<Method<'_, ()>> = &methods.iter().map(Method::alone).collect();
    let body = Body::from(html! { p { (made_words(&intervals.bootstrap)) } })
        .append(estimates(intervals, methods));
    let Some(baseline) = &intervals.best_baseline else {
        return body;
    };
    body.prose(html! {
        h3 { "Differences from the best baseline" }
        p {
            "Each method less " b { (baseline) } ", the baseline with the smallest mean error, on the same "
            (plural(intervals)) ": below zero the method is better. Those in which a plan of one failed are left out for both. An interval that \
             does not contain zero indicates a difference; with as many as are shown here, some do so by chance."
        }
    })
    .figure(differences_figure(intervals, baseline, methods).map(|figure| Figure { id, ..figure }))
    .folded("Differences as numbers", differences(intervals, baseline, methods))
}

/// A method compared with the best baseline, as a sentence with a space before it.
pub(super) fn against_words(intervals: &Intervals, method: &str, baseline: &str) -> Option<String> {
    let mut found = against(intervals, baseline, Measure::P75).filter(|d| d.method == method);
    let relative = found.next()?.relative?;
    Some(format!(
        " Its third quartile differs from that of {baseline}, the best baseline, by {}.",
        relative_words(&relative)
    ))
}

const fn plural(intervals: &Intervals) -> &'static str {
    match intervals.bootstrap.cluster {
        Cluster::Segment => "segments",
        Cluster::Session => "sessions",
    }
}

/// Method of the intervals, in words.
pub(crate) fn made_words(bootstrap: &Bootstrap) -> String {
    let (clusters, about, caution) = match bootstrap.cluster {
        Cluster::Segment => (
            "segments",
            "segments are drawn, not instants, because neighbouring instants are not independent; the \
             intervals are about other segments of the same hand, object and task",
            "Segments that follow one another in a take are alike too, which makes intervals somewhat too narrow.",
        ),
        Cluster::Session => (
            "sessions",
            "sessions are drawn, not segments or instants; the intervals are about other sessions of the same kind",
            "Of few sessions intervals are too narrow: of six they contain the true value some 83 times in a hundred, not 95.",
        ),
    };
    format!(
        "Intervals contain the middle {} % of {} bootstrap draws (seed {}). A draw takes as many {clusters} as there are, with replacement \
         and with all of their instants: {about}. Methods are compared within the same draws. \
         {caution}",
        plain(100.0 * bootstrap.confidence),
        count(bootstrap.draws),
        bootstrap.seed,
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

/// The same with fewer letters, for a terminal.
pub(crate) fn error_words_short(estimate: &Estimate) -> String {
    in_a_line(estimate, millimetres).replace(" to ", "–")
}

/// Millimetres with one decimal more than elsewhere: intervals are narrow.
pub(crate) fn millimetres_3(metres: f64) -> String {
    decimals(to_mm(metres), 3)
}

/// A relative difference with its interval.
pub(crate) fn relative_words(estimate: &Estimate) -> String {
    in_a_line(estimate, |share| signed(100.0 * share, " %"))
}

/// A method with the intervals of its errors, where they are known.
type Estimated<'a> = (&'a Method<'a, ()>, Option<[Estimate; Measure::ALL.len()]>);

fn estimates(intervals: &Intervals, methods: &[Method<'_, ()>]) -> Body {
    let confidence = plain(100.0 * intervals.bootstrap.confidence);
    let clusters = format!("({})", plural(intervals));
    let all: Vec<(&Method<'_, ()>, &MethodIntervals)> = (methods.iter())
        .filter_map(|method| {
            let mut found = intervals.methods.iter();
            Some((method, found.find(|own| own.method == method.name)?))
        })
        .collect();
    let pooled = all.iter().map(|(method, own)| (*method, own.error.all));
    let by_finger = Finger::ALL.map(|finger| {
        let rows = all
            .iter()
            .map(|(method, own)| (*method, own.error.by_finger[finger]));
        (finger, rows.collect())
    });
    let caption = format!("Error with {confidence} % intervals, all fingers");
    let pooled = method_table(caption, pooled, |row| row.0);
    let caption = "Error with intervals, by finger";
    let by_finger = Table::grouped(caption, by_finger, "method", |row| row.0.head());
    let by_finger = by_finger.stressed(|row| row.0.default);
    let contacts = all.iter().filter_map(|(method, own)| {
        let share = own.three_or_more.as_ref()?;
        Some((*method, share, own.three_or_more_less_recorded.as_ref()))
    });
    let caption =
        format!("Share of instants with three or more contacts, with {confidence} % intervals");
    let contacts = method_table(caption, contacts, |row| row.0)
        .numbers("three or more", "%", |(_, share, _)| {
            in_a_cell(share, percent)
        })
        .numbers("less recorded", "points", |(.., less)| {
            known(less.map(|own| in_a_cell(own, |value| decimals(100.0 * value, 2))))
        })
        .numbers("n", &clusters, |(_, share, _)| made_of(share));
    let body = Body::default()
        .prose(error_columns(pooled, &clusters))
        .folded(
            "The same for each finger",
            Body::default().prose(error_columns(by_finger, &clusters)),
        );
    if contacts.is_empty() {
        return body;
    }
    body.prose(contacts)
}

fn error_columns<'a>(table: Table<Estimated<'a>>, clusters: &str) -> Table<Estimated<'a>> {
    let shown = [
        Measure::P50,
        Measure::P75,
        Measure::P95,
        Measure::Mean,
        Measure::Rmse,
    ];
    let table = shown.into_iter().fold(table, |table, measure| {
        table.numbers(measure_words(measure), "mm", |(_, error)| {
            let own = error.as_ref().map(|error| estimate(error, measure));
            known(own.map(|own| in_a_cell(own, millimetres_3)))
        })
    });
    table.numbers("n", clusters, |(_, error)| {
        known(error.as_ref().map(|error| made_of(&error[0])))
    })
}

/// Number of rows and clusters of an estimate.
fn made_of(estimate: &Estimate) -> String {
    format!("{}\n({})", count(estimate.n), count(estimate.clusters))
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

/// Twice as large is as far as an axis reaches: a larger difference is shown by its number.
const REACH: f64 = 100.0;
/// Shortest axis, percentage points: less would make a drama of rounding.
const SHORTEST: f64 = 10.0;

/// `None` where no difference is relative to anything.
fn differences_figure(
    intervals: &Intervals,
    baseline: &str,
    methods: &[Method<'_, ()>],
) -> Option<Figure> {
    let all: Vec<&PairedDifference> = (DRAWN.iter())
        .flat_map(|(measure, _)| against(intervals, baseline, *measure))
        .collect();
    let relative = all.iter().filter_map(|difference| difference.relative);
    let reached = relative.flat_map(|own| {
        let ends = own.interval.unwrap_or([own.value; 2]);
        [own.value, ends[0], ends[1]].map(|share| (100.0 * share).clamp(-REACH, REACH))
    });
    let [low, high] = whole_steps(reached.chain([0.0]), SHORTEST, WANTED_TICKS);
    let row = |difference: &PairedDifference| {
        let relative = difference.relative?;
        let method = named(methods, &difference.method)?;
        let value = 100.0 * relative.value;
        let interval = relative.interval.map(|ends| ends.map(|end| 100.0 * end));
        let bar = interval.map(|ends| Mark::over(MarkShape::Bar, ends));
        let words = match interval {
            Some(_) => relative_words(&relative),
            None => relative_words(&relative) + ", no interval",
        };
        Some(PlotRow {
            tooltip: format!("{}: {words}", method.name),
            marks: bar
                .into_iter()
                .chain([Mark::at(MarkShape::Dot, value)])
                .collect(),
            numbers: vec![signed(value, " %")],
            ..method.row()
        })
    };
    let panels = DRAWN.iter().filter_map(|(measure, title)| {
        let rows: Vec<_> = against(intervals, baseline, *measure)
            .filter_map(row)
            .collect();
        let plot = RowPlot {
            title,
            axis: ("difference from the baseline (%)", Scale::linear(low, high)),
            marked: Some((0.0, "equal")),
            numbers: &[""],
            rows,
            ..RowPlot::default()
        };
        (!plot.rows.is_empty()).then(|| row_plot::draw(&plot))
    });
    let panels: Vec<_> = panels.collect();
    (!panels.is_empty()).then(|| Figure {
        id: DIFFERENCES,
        title: format!("Error relative to the best baseline, {baseline}."),
        caption: format!(
            "Dot: difference of the methods' errors over the error of {baseline}, also as a number; bar: {} % interval; n = {} {}. Left of the dotted line the \
             method is better. ▸: more than the axis holds.",
            plain(100.0 * intervals.bootstrap.confidence),
            count_range(&all.iter().map(|own| own.absolute.clusters).collect::<Vec<_>>()),
            plural(intervals)
        ),
        data: difference_data(&all),
        legend: Vec::new(),
        panels,
    })
}

fn difference_data(all: &[&PairedDifference]) -> FigureData {
    let ends = |estimate: &Estimate| {
        let [low, high] = estimate.interval.unwrap_or([f64::NAN; 2]);
        [estimate.value, low, high]
    };
    let columns = (FigureData::about(all).words("motion", |d| &*d.method))
        .words("baseline", |d| &*d.other)
        .words("measure", |d| d.measure.name());
    let parts = ["", "_low", "_high"].into_iter().enumerate();
    let columns = parts.clone().fold(columns, |columns, (place, part)| {
        columns.numbers(&format!("relative{part}_percent"), |d| {
            d.relative
                .as_ref()
                .map_or(f64::NAN, |own| 100.0 * ends(own)[place])
        })
    });
    parts
        .fold(columns, |columns, (place, part)| {
            columns.numbers(&format!("absolute{part}_mm"), |d| {
                to_mm(ends(&d.absolute)[place])
            })
        })
        .numbers("better_percent", |d| 100.0 * d.share_better)
        .done()
}

fn differences(intervals: &Intervals, baseline: &str, methods: &[Method<'_, ()>]) -> Body {
    let method = |difference: &PairedDifference| named(methods, &difference.method);
    let groups = Measure::ALL.map(|measure| {
        let rows = against(intervals, baseline, measure).map(|d| (d, method(d)));
        (measure_words(measure), rows.collect())
    });
    let clusters = plural(intervals);
    let caption = format!("Error less that of {baseline}, all fingers, on the same {clusters}");
    let table = Table::grouped(caption, groups, "method", |(difference, method)| {
        method.map_or_else(|| (&*difference.method).into(), Method::head)
    })
    .stressed(|(_, method)| method.is_some_and(|method| method.default))
    .numbers("difference", "mm", |(d, _)| error_words(&d.absolute))
    .numbers("difference", "%", |(d, _)| {
        known(d.relative.as_ref().map(relative_words))
    })
    .percents("better in", "%", |(d, _)| d.share_better)
    .counts("n", "", |(d, _)| d.absolute.n)
    .counts("clusters", "", |(d, _)| d.absolute.clusters);
    Body::default().prose(table).prose(html! {
        p.note {
            "Better in: share of " (clusters) " in which the method has the smaller error, a tie counting half, so that 50 % is chance."
        }
    })
}
