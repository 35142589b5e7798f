//! The first screen: what was recorded, the verdict, errors, and what is worrying.

use inhand_model::{Estimate, Evaluation, Measure, Protocol, TakeFacts};
use maud::html;

use super::checks::{Check, checks};
use super::session::finding_list;
use super::{Body, Method, intervals, method_table, methods};
use crate::Report;
use crate::figure::row_plot::{self, Mark, MarkShape, PlotRow, RowPlot, WANTED_TICKS};
use crate::figure::scale::{Extent, Scale};
use crate::figure::{Figure, FigureData};
use crate::table::statistic;
use crate::text::protocol_columns;
use crate::verdict::{
    Outcome, comparisons, default_method, headline, protocols, verdict, warnings,
};
use crate::words::{count_range, counted, decimals, plain, tied, to_mm};

/// Findings that are listed; all are in section Data quality.
const FINDINGS: usize = 5;

/// The content, which is above all sections.
pub(super) fn body(report: &Report<'_>) -> Body {
    let evaluation = report.evaluation;
    let published = methods(evaluation, Protocol::Published);
    let caption = "Error of all fingers";
    let table = method_table(caption, &published, |method| method);
    let table = protocol_columns(table, evaluation, "mm", |method| method.name);
    let (worries, fine): (Vec<Check>, Vec<Check>) =
        checks(report).into_iter().partition(|check| check.worrying);
    let findings: Vec<_> = warnings(evaluation).collect();
    let more = findings.len().saturating_sub(FINDINGS);
    let none = worries.is_empty() && findings.is_empty();
    Body::from(html! {
        p { (recorded(evaluation)) }
        p class=(outcome(evaluation)) { (tied(&verdict(evaluation))) }
    })
    .figure(figure(evaluation))
    .prose(html! {
        div.table { (table) }
        div.worries {
            h2 { @if none { "Nothing worrying was found" } @else { "Worrying" } }
            @if headline(evaluation) == Protocol::HeldOut {
                p.note { "Held out, where a line does not say otherwise." }
            }
            (finding_list(findings.into_iter().take(FINDINGS)))
            @if more > 0 { p.note { (more) " more findings are in " a href="#quality" { "Data quality" } "." } }
            @if !worries.is_empty() {
                ul { @for check in &worries { li { b { (check.label) } ": " (tied(&check.words)) } } }
            }
            p.note {
                "Looked at without a worry: "
                @for (place, check) in fine.iter().enumerate() {
                    @if place > 0 { "; " }
                    b { (check.label) } ": " (tied(&check.words))
                }
                "."
            }
        }
    })
}

/// What was recorded, in a line.
fn recorded(evaluation: &Evaluation) -> String {
    let session = &evaluation.session;
    let takes = |role: &str, takes: &[TakeFacts]| {
        let seconds: f64 = takes.iter().map(|take| take.duration_s).sum();
        let segments = takes.iter().map(|take| take.segments).sum();
        format!(
            "{} ({} min, {})",
            counted(takes.len(), &format!("{role} take")),
            decimals(seconds / 60.0, 1),
            counted(segments, "segment")
        )
    };
    let seconds = session.segment_samples as f64 / session.rate_hz;
    format!(
        "{} and {}, {}; {} Hz, segments of {} s; {} primitives ({}).",
        takes("training", &session.train),
        takes("test", &session.test),
        (session.object.as_deref().and_then(shape_words))
            .unwrap_or_else(|| "object shape not given".to_owned()),
        plain(session.rate_hz),
        plain(seconds),
        evaluation.dictionary.rank,
        evaluation.dictionary.kind.name().to_uppercase(),
    )
}

/// A shape such as `cube:0.05` with its lengths in millimetres.
fn shape_words(shape: &str) -> Option<String> {
    let (name, lengths_m) = shape.split_once(':')?;
    let lengths = lengths_m
        .split('x')
        .map(|length_m| Some(plain(to_mm(length_m.parse().ok()?))));
    let lengths: Vec<String> = lengths.collect::<Option<_>>()?;
    Some(format!("{name}, {} mm", lengths.join(" × ")))
}

/// Class of the verdict, by whether the default method is behind.
fn outcome(evaluation: &Evaluation) -> &'static str {
    let protocol = headline(evaluation);
    let method = default_method(evaluation, protocol);
    let compared = method.map(|method| comparisons(method, evaluation, protocol));
    let compared = compared.unwrap_or_default();
    let plan = method.and_then(|method| method.plan.as_ref());
    let unsolved = plan.is_some_and(|plan| plan.infeasible + plan.failed > 0);
    match compared.iter().any(|own| own.outcome == Outcome::Higher) {
        behind if behind || unsolved => "verdict behind",
        _ if compared.is_empty() => "verdict",
        _ => "verdict kept-up",
    }
}

/// A method under a protocol.
struct ErrorRow<'a> {
    protocol: Protocol,
    method: Method<'a>,
    intervals: Option<&'a [Estimate; Measure::ALL.len()]>,
}

/// The default method and each baseline that is the best at some place, under each protocol.
fn error_rows(evaluation: &Evaluation) -> Vec<ErrorRow<'_>> {
    let best: Vec<&str> = protocols(evaluation)
        .filter_map(|protocol| Some((default_method(evaluation, protocol)?, protocol)))
        .flat_map(|(method, protocol)| comparisons(method, evaluation, protocol))
        .map(|comparison| comparison.baseline)
        .collect();
    let rows = protocols(evaluation).flat_map(|protocol| {
        let known = evaluation.intervals(protocol);
        let known = known.map_or(&[][..], |known| &known.methods);
        methods(evaluation, protocol)
            .into_iter()
            .map(move |method| {
                let own = known.iter().find(|own| own.method == method.name);
                ErrorRow {
                    protocol,
                    intervals: own.and_then(|own| own.error.all.as_ref()),
                    method,
                }
            })
    });
    rows.filter(|row| row.method.default || best.contains(&row.method.name))
        .collect()
}

impl ErrorRow<'_> {
    /// Value of a measure and the ends of its interval, NaN where they are not known, millimetres.
    fn measure(&self, measure: Measure) -> [f64; 3] {
        let error = &self.method.evaluation.error.all;
        let value_m = match measure {
            Measure::P95 => statistic(error, |s| s.p95),
            _ => statistic(error, |s| s.p50),
        };
        let estimates = self.intervals;
        let found = estimates.and_then(|all| intervals::estimate(all, measure).interval);
        let [low_m, high_m] = found.unwrap_or([f64::NAN; 2]);
        [value_m, low_m, high_m].map(to_mm)
    }

    fn plot(&self) -> PlotRow<'_> {
        let shapes = [
            (Measure::P50, MarkShape::Dot),
            (Measure::P95, MarkShape::Ring),
        ];
        let marks = shapes.into_iter().flat_map(|(measure, shape)| {
            let [value, low, high] = self.measure(measure);
            let bar = low
                .is_finite()
                .then(|| Mark::over(MarkShape::Bar, [low, high]));
            let mark = value.is_finite().then(|| Mark::at(shape, value));
            bar.into_iter().chain(mark)
        });
        let words = shapes.map(|(measure, _)| match self.intervals {
            Some(all) => intervals::error_words(intervals::estimate(all, measure)),
            None => decimals(self.measure(measure)[0], 2),
        });
        PlotRow {
            tooltip: format!(
                "{}: median {}, 95 % {} mm",
                self.method.name, words[0], words[1]
            ),
            marks: marks.collect(),
            numbers: shapes
                .map(|(measure, _)| decimals(self.measure(measure)[0], 2))
                .into(),
            ..self.method.row()
        }
    }
}

/// `None` where nothing was evaluated.
fn figure(evaluation: &Evaluation) -> Option<Figure> {
    let rows = error_rows(evaluation);
    if !rows.iter().any(|row| row.measure(Measure::P95)[0] > 0.0) {
        return None;
    }
    let extents = rows.iter().map(|row| {
        let [median, ..] = row.measure(Measure::P50);
        Extent {
            low: median,
            typical: median,
            high: row.measure(Measure::P95).into_iter().fold(0.0, f64::max),
        }
    });
    let axis = ("error (mm)", Scale::comparing(extents, WANTED_TICKS));
    let panels = rows.chunk_by(|a, b| a.protocol == b.protocol).map(|own| {
        let plot = RowPlot {
            title: match own[0].protocol {
                Protocol::HeldOut => "Held out: against the unfiltered recording",
                Protocol::Published => "Published: against the filtered recording",
            },
            axis,
            numbers: &["median", "95 %"],
            rows: own.iter().map(ErrorRow::plot).collect(),
            ..RowPlot::default()
        };
        row_plot::draw(&plot)
    });
    let n = rows.iter().map(|row| row.method.evaluation.error.all.n);
    let mut data = FigureData::about(&rows)
        .words("protocol", |row| row.protocol.title())
        .words("method", |row| row.method.name)
        .counts("n", |row| row.method.evaluation.error.all.n);
    for (measure, name) in [(Measure::P50, "p50"), (Measure::P95, "p95")] {
        for (place, part) in ["", "_low", "_high"].into_iter().enumerate() {
            data = data.numbers(&format!("{name}{part}_mm"), |row| {
                row.measure(measure)[place]
            });
        }
    }
    let medians =
        (rows.iter()).filter_map(|row| Some(intervals::estimate(row.intervals?, Measure::P50)));
    let medians = medians.filter(|own| own.interval.is_some());
    let segments: Vec<usize> = medians.map(|own| own.clusters).collect();
    let mut bars = String::new();
    if let (Some(own), false) = (
        evaluation.intervals(headline(evaluation)),
        segments.is_empty(),
    ) {
        let (confidence, segments) = (
            plain(100.0 * own.bootstrap.confidence),
            count_range(&segments),
        );
        bars = format!("; bars: {confidence} % intervals (bootstrap over {segments} segments)");
    }
    Some(Figure {
        id: "error-overview",
        title: "Error of the default method and the best baselines.".to_owned(),
        caption: format!(
            "Dot: median; ring: 95 % quantile{bars}. All fingers and instants, n = {}.",
            count_range(&n.collect::<Vec<_>>())
        ),
        data: data.done(),
        legend: Vec::new(),
        panels: panels.collect(),
    })
}
