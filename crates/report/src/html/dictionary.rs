//! Learning of the primitives.

use inhand_model::{DictionaryFacts, DictionaryKind, Evaluation, Finger, StopReason};
use maud::{Markup, html};

use super::table::{Line, numbers, table, words};
use super::{Body, deviation};
use crate::figure::Figure;
use crate::figure::line_chart::{self, AxisSpec, LineChart, Series};
use crate::figure::palette::{PLAIN_CLASS, finger_class};
use crate::number::{NARROW_SPACE, count, decimals, percent, to_mm};

const MM2_PER_M2: f64 = 1e6;

/// The section's content.
pub(super) fn section(evaluation: &Evaluation) -> Body {
    let facts = &evaluation.dictionary;
    let mut body = Body::from(html! { p { (sentence(facts)) } });
    body.figure(objective_figure(facts));
    body.prose(html! {
        @if let Some(learned) = &facts.deviation {
            (deviation::part(learned, evaluation.session.train.len()))
        }
        details {
            summary { "Velocity bounds that plans had to keep" }
            (bounds_table(facts))
        }
    });
    body
}

fn sentence(facts: &DictionaryFacts) -> String {
    let kind = match facts.kind {
        DictionaryKind::Nmf => "non-negative matrix factorisation",
        DictionaryKind::Pca => "principal components",
    };
    let iterations = count(facts.iterations, NARROW_SPACE);
    let stop = match facts.stop_reason {
        StopReason::Converged => {
            format!(
                "Learning converged after {iterations} iterations: the objective no longer changed."
            )
        }
        StopReason::TargetReached => {
            format!(
                "Learning stopped after {iterations} iterations, when the wanted error was reached."
            )
        }
        StopReason::IterationLimit => {
            format!(
                "Learning stopped at its limit of {iterations} iterations, before it converged."
            )
        }
        StopReason::ClosedForm => "The factorisation is exact and does not iterate.".to_owned(),
    };
    format!(
        "{} primitives by {kind} from {} training segments. {stop} The primitives reproduce the training \
         segments to {} mm root mean square a coordinate (relative error {} %).",
        count(facts.rank, NARROW_SPACE),
        count(facts.segments, NARROW_SPACE),
        decimals(to_mm(facts.rms_m), 3),
        percent(facts.relative_error),
    )
}

/// `None` where learning does not iterate.
fn objective_figure(facts: &DictionaryFacts) -> Option<Figure> {
    let points: Vec<(f64, f64)> = facts
        .objective_history_m2
        .iter()
        .enumerate()
        .map(|(sweep, objective)| (sweep as f64, objective * MM2_PER_M2))
        .collect();
    let last = points.len().checked_sub(1).filter(|last| *last > 0)?;
    let positive = || {
        points
            .iter()
            .map(|point| point.1)
            .filter(|v| v.is_finite() && *v > 0.0)
    };
    let (low, high) = (
        positive().fold(f64::INFINITY, f64::min),
        positive().fold(0.0, f64::max),
    );
    let series = vec![Series {
        label: "objective".to_owned(),
        class: PLAIN_CLASS.to_owned(),
        points,
    }];
    Some(Figure {
        id: "dictionary-objective",
        title: "Objective after each sweep.".to_owned(),
        caption: "Half the squared Frobenius norm of the reconstruction error over all training segments; \
            sweep 0 is the start."
            .to_owned(),
        data: line_chart::data("sweep", "objective_mm2", &series),
        legend: Vec::new(),
        panels: vec![line_chart::draw(&LineChart {
            title: "Objective while learning",
            x: AxisSpec::linear("sweep", 0.0, last as f64),
            y: AxisSpec::log("objective (mm², logarithmic)", low, high),
            series,
            dots: false,
            marked_x: None,
        })],
    })
}

fn bounds_table(facts: &DictionaryFacts) -> Markup {
    let columns = [
        words("finger"),
        numbers("x min", "mm/s"),
        numbers("x max", "mm/s"),
        numbers("y min", "mm/s"),
        numbers("y max", "mm/s"),
        numbers("z min", "mm/s"),
        numbers("z max", "mm/s"),
    ];
    let bounds = &facts.velocity_bounds;
    let lines = Finger::ALL
        .map(|finger| Line {
            head: html! { span.swatch.(finger_class(finger)) {} (finger.name()) },
            cells: (0..3)
                .map(|axis| 3 * finger.index() + axis)
                .flat_map(|row| [bounds.min_m_s[row], bounds.max_m_s[row]])
                .map(|velocity| decimals(to_mm(velocity), 1))
                .collect(),
            best: Vec::new(),
            stressed: false,
        })
        .into();
    table("Velocity bounds in the hand's frame", &columns, lines)
}
