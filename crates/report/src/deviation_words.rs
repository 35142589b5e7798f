//! Validation of the learned deviation, in words.

use inhand_model::{DeviationFacts, SmoothCurve};

use crate::verdict::fine_mm;
use crate::words::{count, decimals, to_mm};

/// The baseline that a curve is.
pub(crate) fn curve_words(curve: SmoothCurve) -> &'static str {
    match curve {
        SmoothCurve::Hermite => "cubic baseline",
        SmoothCurve::MinimumJerk => "minimum-jerk baseline",
        SmoothCurve::Line => "straight-line baseline",
    }
}

/// Result of the cross-validation of the deviation, in a sentence or two. `takes` is how many training
/// takes there are.
pub(crate) fn deviation_sentence(facts: &DeviationFacts, takes: usize) -> String {
    let found = &facts.validation;
    let weights = &facts.weights;
    let zero = [weights.profile, weights.hand, weights.finger] == [0.0; 3];
    let curve = curve_words(facts.curve);
    if found.segments < 2 {
        let end = match zero {
            true => format!(
                ", so all weights are zero and plans are the {curve} within the velocity bounds"
            ),
            false => String::new(),
        };
        return format!(
            "There was too little training data to leave any out and validate the deviation{end}."
        );
    }
    let of = match takes {
        1 => "intervals of the one training take",
        _ => "groups of takes",
    };
    let (segments, folds) = (count(found.segments), found.folds);
    let smooth = fine_mm(found.smooth_error_m);
    if zero {
        return format!(
            "All weights are zero, so plans are the {curve} within the velocity bounds: on {segments} left-out segments of {folds} {of} its error is \
             {smooth}, and no learned deviation was better by more than the standard error of the difference."
        );
    }
    format!(
        "On {segments} left-out segments of {folds} {of} the {curve} has an error of {smooth}, with the deviation {} (difference \
         {} ± {}, the standard error over segments).",
        fine_mm(found.error_m),
        decimals(to_mm(found.error_m - found.smooth_error_m), 3).replace('-', "−"),
        fine_mm(found.standard_error_m),
    )
}
