//! Method choice on the training takes, in words: which method was chosen and why,
//! validation of the deviation, coverage of prediction regions.

use inhand_model::{DeviationFacts, Evaluation, MethodCandidate, MethodChoice};

use crate::number::{count, decimals, to_mm};

/// Which method was chosen and why, in a sentence; `None` where no choice was asked for.
pub(crate) fn choice_sentence(evaluation: &Evaluation) -> Option<String> {
    let choice = evaluation.choice.as_ref()?;
    Some(format!(
        "auto chose {}: {}.",
        choice.method,
        reason(evaluation, choice)
    ))
}

fn reason(evaluation: &Evaluation, choice: &MethodChoice) -> String {
    let left_out = format!(
        "on {} training segments left out of learning",
        count(choice.segments)
    );
    let Some(chosen) = choice.candidates.iter().find(|c| c.name == choice.method) else {
        return format!("it has the lowest error {left_out}");
    };
    let own_m = chosen.mean_error_m;
    let start = format!("{left_out} its mean error is {}", fine_mm(own_m));
    let Some((rival, learned)) = rival(evaluation, choice) else {
        let least = (choice.candidates.iter()).all(|c| own_m.total_cmp(&c.mean_error_m).is_le());
        return match choice.candidates.len() {
            0 | 1 => format!("{start}, and nothing else was compared"),
            n if least => format!("{start}, the least of {n} methods"),
            _ => start,
        };
    };
    let kind = match learned {
        true => "the best learned method",
        false => "the best baseline",
    };
    let (name, error_m) = (&rival.name, rival.mean_error_m);
    if !error_m.is_finite() {
        return format!("{start}; {name}, {kind}, fails for some segments");
    }
    let against = format!("{start}, against {} of {name}, {kind}", fine_mm(error_m));
    let gain = choice.gain_m.filter(|gain_m| gain_m.is_finite());
    let words = gain.map(|gain_m| gain_words(gain_m, choice.gain_standard_error_m));
    match words {
        Some(gain) if !learned => {
            format!("{against}; the gain of {gain} is above its standard error")
        }
        Some(words) if gain > Some(0.0) => {
            format!("{against}, whose gain of {words} is not above its standard error")
        }
        _ => against,
    }
}

/// The best candidate of the kind that was not chosen, and whether it is learned; `None` where the chosen method was
/// not evaluated, so that its kind is not known, or where all candidates are of one kind.
fn rival<'a>(
    evaluation: &Evaluation,
    choice: &'a MethodChoice,
) -> Option<(&'a MethodCandidate, bool)> {
    let baseline = |name: &str| {
        let mut methods = evaluation.methods.iter();
        Some(methods.find(|method| method.name == name)?.baseline)
    };
    let chosen = baseline(&choice.method)?;
    let others = (choice.candidates.iter()).filter(|c| baseline(&c.name) == Some(!chosen));
    let best = others.min_by(|a, b| a.mean_error_m.total_cmp(&b.mean_error_m))?;
    Some((best, chosen))
}

fn gain_words(gain_m: f64, standard_error_m: Option<f64>) -> String {
    match standard_error_m {
        Some(error_m) if error_m.is_finite() => {
            format!("{} ± {}", decimals(to_mm(gain_m), 3), fine_mm(error_m))
        }
        _ => fine_mm(gain_m),
    }
}

/// Millimetres with a third decimal: means over many segments differ by less than a hundredth.
fn fine_mm(metres: f64) -> String {
    format!("{} mm", decimals(to_mm(metres), 3))
}

/// Result of the cross-validation of the deviation, in a sentence or two. `takes` is how many training
/// takes there are.
pub(crate) fn deviation_sentence(facts: &DeviationFacts, takes: usize) -> String {
    let found = &facts.validation;
    let weights = &facts.weights;
    let zero = [weights.profile, weights.hand, weights.finger] == [0.0; 3];
    if found.segments < 2 {
        let end = if zero {
            ", so all weights are zero and plans fall back to the cubic baseline"
        } else {
            ""
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
            "All weights are zero, so plans fall back to the cubic baseline: on {segments} left-out segments of {folds} {of} its error is \
             {smooth}, and no learned deviation was better by more than the standard error of the difference."
        );
    }
    format!(
        "On {segments} left-out segments of {folds} {of} the cubic baseline has an error of {smooth}, with the deviation {} (difference \
         {} ± {}, the standard error over segments).",
        fine_mm(found.error_m),
        decimals(to_mm(found.error_m - found.smooth_error_m), 3).replace('-', "−"),
        fine_mm(found.standard_error_m),
    )
}
