//! Learned deviations from the cubic Hermite baseline.

use inhand_model::DeviationFacts;
use maud::{Markup, html};

use super::table::{Line, numbers, table, words};
use crate::learned::deviation_sentence;
use crate::number::{NARROW_SPACE, NONE, count, plain};
use crate::words::tied;

/// The part of the section about the deviation. `takes` is how many training takes there are.
pub(super) fn part(facts: &DeviationFacts, takes: usize) -> Markup {
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
            "mean of the demonstrations in which all fingers had similar ends",
            weights.hand,
            Some(widths.hand),
        ),
        (
            "each finger",
            "mean of the demonstrations in which that finger moved between similar ends, wherever in the hand",
            weights.finger,
            Some(widths.finger),
        ),
    ];
    let lines = parts
        .into_iter()
        .map(|(name, what, weight, width)| Line {
            head: html! { (name) },
            cells: vec![
                rounded(weight),
                width
                    .filter(|_| weight != 0.0)
                    .map_or_else(|| NONE.to_owned(), rounded),
                what.to_owned(),
            ],
            best: Vec::new(),
            stressed: false,
        })
        .collect();
    html! {
        h3 { "Deviation from the smooth curve" }
        p {
            "Beside the primitives above, the deviation of the recorded motion from the cubic through the end conditions was learned: "
            (count(facts.primitives, NARROW_SPACE)) " primitives, and what to expect of them from "
            (count(facts.demonstrations, NARROW_SPACE)) " demonstrations. " (tied(&deviation_sentence(facts, takes)))
        }
        (table(
            "What is expected of the deviation: the sum of three parts",
            &[words("part"), numbers("weight", ""), numbers("kernel width", "std. dev."), words("what it predicts")],
            lines,
        ))
        p.note {
            "Kernel width: how far the end conditions of a demonstration may be from those of a plan to count, in standard deviations of the \
             training data. Weights and widths are those that predict left-out takes best; all weights are then lowered the nearer the gain is \
             to its own standard error, down to none."
        }
    }
}

/// Three digits are more than cross-validation can tell.
fn rounded(value: f64) -> String {
    plain((value * 1e3).round() / 1e3)
}
