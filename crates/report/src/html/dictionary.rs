//! Learning of the primitives, and of deviations from the cubic Hermite baseline.

use inhand_model::{
    DeviationFacts, DictionaryFacts, DictionaryKind, Finger, StopReason, VelocityBounds,
};
use maud::{Markup, html};

use super::{Body, shown};
use crate::Report;
use crate::deviation_words::{curve_words, deviation_sentence};
use crate::figure::line_chart::{self, LineChart, Series};
use crate::figure::scale::Scale;
use crate::figure::{Figure, PLAIN_CLASS};
use crate::table::Table;
use crate::words::{NONE, count, decimals, percent, short, tied, to_mm};

const MM2_PER_M2: f64 = 1e6;

/// The section's content: explained variance, or the objective where that is not known, is its figure.
pub(super) fn section(report: &Report<'_>) -> Body {
    let evaluation = report.evaluation;
    let facts = &evaluation.dictionary;
    let takes = evaluation.session.train.len();
    let own = evaluation.held_out.as_ref();
    let held_out = own.and_then(|own| own.deviation.as_ref());
    let deviation = facts.deviation.as_ref();
    let deviation = deviation.map(|learned| Body::from(deviation_part(learned, held_out, takes)));
    let objective = Body::default().figure(objective_figure(facts));
    let bounds = Body::default().prose(bounds_table(&facts.velocity_bounds));
    let body = Body::from(html! { p { (sentence(facts)) } });
    let body = match report.illustrations {
        Some(all) => body
            .append(shown::variance_part(all))
            .folded("Objective while learning", objective)
            .folded(
                "Hulls and primitives",
                shown::hulls_and_primitives(all, facts.kind, evaluation.session.rate_hz),
            ),
        None => body.append(objective),
    };
    body.folded("Deviation from the cubic baseline", deviation)
        .folded("Velocity bounds of plans", bounds)
}

fn sentence(facts: &DictionaryFacts) -> String {
    let kind = match facts.kind {
        DictionaryKind::Nmf => "non-negative matrix factorisation",
        DictionaryKind::Pca => "principal components",
    };
    format!(
        "{} primitives by {kind} from {} training segments. Learning {}. The primitives reproduce the training \
         segments to {} mm root mean square a coordinate (relative error {} %).",
        count(facts.rank),
        count(facts.segments),
        end(facts),
        decimals(to_mm(facts.rms_m), 3),
        percent(facts.relative_error),
    )
}

/// How learning ended, as the end of a sentence about it.
pub(super) fn end(facts: &DictionaryFacts) -> String {
    let iterations = count(facts.iterations);
    match facts.stop_reason {
        StopReason::Converged => format!("converged after {iterations} iterations"),
        StopReason::TargetReached => {
            format!("stopped after {iterations} iterations, at the target error")
        }
        StopReason::IterationLimit => {
            format!("stopped at its limit of {iterations} iterations, before it converged")
        }
        StopReason::NoLongerBetterOnLeftOutTakes => {
            format!("stopped after {iterations} iterations, no longer better on left-out takes")
        }
        StopReason::ClosedForm => "is exact and does not iterate".to_owned(),
    }
}

/// `None` where learning does not iterate.
fn objective_figure(facts: &DictionaryFacts) -> Option<Figure> {
    let history = facts.objective_history_m2.iter().enumerate();
    let points = history.map(|(iteration, objective)| (iteration as f64, objective * MM2_PER_M2));
    let series = [Series::new("objective", PLAIN_CLASS, points)];
    let last = series[0].points.len().checked_sub(2)? + 1;
    let positive = || line_chart::heights(&series).filter(|v| *v > 0.0);
    let low = positive().fold(f64::INFINITY, f64::min);
    let high = positive().fold(0.0, f64::max);
    Some(Figure {
        id: "dictionary-objective",
        title: "Objective after each iteration.".to_owned(),
        caption: format!(
            "Half the squared Frobenius norm of the reconstruction error of {} training segments; iteration 0 is the start.",
            count(facts.segments)
        ),
        data: line_chart::data("iteration", "objective_mm2", &series),
        legend: Vec::new(),
        panels: vec![line_chart::draw(&LineChart {
            x: ("iteration", Scale::linear(0.0, last as f64)),
            y: ("objective (mm²)", Scale::log(low, high)),
            series: &series,
            ..LineChart::default()
        })],
    })
}

fn bounds_table(bounds: &VelocityBounds) -> Table<Finger> {
    let caption = "Velocity bounds in the hand's frame";
    let table = Table::new(caption, Finger::ALL, "finger", |finger| *finger);
    let columns = [(0, "x"), (1, "y"), (2, "z")]
        .into_iter()
        .flat_map(|(axis, name)| {
            let ends = [("min", &bounds.min_m_s), ("max", &bounds.max_m_s)];
            ends.map(|(end, values)| (format!("{name} {end}"), axis, values))
        });
    columns.fold(table, |table, (name, axis, values)| {
        table.numbers(&name, "mm/s", |finger| {
            decimals(to_mm(values[3 * finger.index() + axis]), 1)
        })
    })
}

/// The learned deviation, and that of the held-out protocol. `takes` is how many training takes there are.
fn deviation_part(
    facts: &DeviationFacts,
    held_out: Option<&DeviationFacts>,
    takes: usize,
) -> Markup {
    let (weights, widths) = (facts.weights, facts.bandwidths);
    let parts = [
        (
            "course over time",
            "one for all fingers and axes, in proportion to displacement and end velocities",
            weights.profile,
            None,
        ),
        (
            "whole hand",
            "mean of the demonstrations in which all fingers had similar boundary conditions",
            weights.hand,
            Some(widths.hand),
        ),
        (
            "each finger",
            "mean of the demonstrations in which that finger moved between similar boundary conditions, wherever in the hand",
            weights.finger,
            Some(widths.finger),
        ),
    ];
    // Three digits are more than cross-validation can determine.
    let caption = "Deviation predictor: the sum of three parts";
    let table = Table::new(caption, parts, "part", |(name, ..)| *name)
        .numbers("weight", "", |(_, _, weight, _)| short(*weight))
        .numbers("kernel width", "std. dev.", |(_, _, weight, width)| {
            let width = width.filter(|_| *weight != 0.0);
            width.map_or_else(|| NONE.to_owned(), short)
        })
        .words("what it predicts", |(_, what, ..)| (*what).to_owned());
    html! {
        p {
            "In addition to the primitives above, the deviation of the recorded motion from the cubic Hermite baseline through the boundary conditions was learned: "
            (count(facts.primitives)) " primitives, and a predictor (kernel regression) of their activations from "
            (count(facts.demonstrations)) " demonstrations. " (tied(&deviation_sentence(facts, takes)))
        }
        @if let Some(own) = held_out {
            p {
                "Under the held-out protocol the curve is the " (curve_words(own.curve)) ", with a deviation of its own. "
                (tied(&deviation_sentence(own, takes)))
            }
        }
        (table)
        p.note {
            "Kernel width: how far the boundary conditions of a demonstration may be from those of a plan to count, in standard deviations of the \
             training data. Weights and widths are those that predict left-out takes best; all weights are then lowered the nearer the gain is \
             to its own standard error, down to none."
        }
    }
}
