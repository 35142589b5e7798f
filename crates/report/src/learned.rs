//! Method choice on the training takes, in words: which method was chosen and why,
//! what was learned of deviations, how honest corridors are.

use inhand_model::{
    CorridorCoverage, DeviationFacts, Evaluation, MethodCandidate, MethodChoice, Validation,
};

use crate::number::{NARROW_SPACE, count, decimals, percent, plain, to_mm};
use crate::verdict::default_method;

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
        count(choice.segments, NARROW_SPACE)
    );
    let Some(chosen) = choice.candidates.iter().find(|c| c.name == choice.method) else {
        return format!("it does best {left_out}");
    };
    let own_m = chosen.mean_error_m;
    let start = format!("{left_out} its mean error is {}", fine_mm(own_m));
    let Some(rival) = rival(evaluation, choice) else {
        let least = (choice.candidates.iter()).all(|c| own_m.total_cmp(&c.mean_error_m).is_le());
        return match choice.candidates.len() {
            0 | 1 => format!("{start}, and nothing else was compared"),
            n if least => format!("{start}, the least of {n} methods"),
            _ => start,
        };
    };
    let name = &rival.candidate.name;
    let kind = if rival.learned {
        "the best learned method"
    } else {
        "the best that learns nothing"
    };
    if !rival.candidate.mean_error_m.is_finite() {
        return format!("{start}; {name}, {kind}, leaves segments without a motion");
    }
    let against = format!(
        "{start}, against {} of {name}, {kind}",
        fine_mm(rival.candidate.mean_error_m)
    );
    match choice.gain_m.filter(|gain_m| gain_m.is_finite()) {
        None => against,
        Some(gain_m) if !rival.learned => format!(
            "{against}; the gain of {} is above its standard error",
            gain_words(gain_m, choice.gain_standard_error_m)
        ),
        Some(gain_m) if gain_m > 0.0 => format!(
            "{against}, whose gain of {} is not above its standard error",
            gain_words(gain_m, choice.gain_standard_error_m)
        ),
        Some(_) => against,
    }
}

/// The best candidate of the kind that was not chosen.
struct Rival<'a> {
    candidate: &'a MethodCandidate,
    learned: bool,
}

/// `None` where the chosen method was not evaluated, so that its kind is not known, or where all
/// candidates are of one kind.
fn rival<'a>(evaluation: &Evaluation, choice: &'a MethodChoice) -> Option<Rival<'a>> {
    let baseline = |name: &str| {
        let mut methods = evaluation.methods.iter();
        Some(methods.find(|method| method.name == name)?.baseline)
    };
    let chosen = baseline(&choice.method)?;
    let candidate = choice
        .candidates
        .iter()
        .filter(|c| baseline(&c.name) == Some(!chosen))
        .min_by(|a, b| a.mean_error_m.total_cmp(&b.mean_error_m))?;
    Some(Rival {
        candidate,
        learned: chosen,
    })
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

/// What cross-validation found of the deviation, in a sentence or two. `takes` is how many training
/// takes there are.
pub(crate) fn deviation_sentence(facts: &DeviationFacts, takes: usize) -> String {
    let Validation {
        folds,
        segments,
        smooth_error_m,
        error_m,
        standard_error_m,
    } = facts.validation;
    let zero = [
        facts.weights.profile,
        facts.weights.hand,
        facts.weights.finger,
    ]
    .iter()
    .all(|weight| *weight == 0.0);
    if segments < 2 {
        let what = "There was too little training data to leave any out and see whether a deviation predicts it";
        return if zero {
            format!("{what}, so all weights are zero and plans fall back to the smooth curve.")
        } else {
            format!("{what}.")
        };
    }
    let of = if takes == 1 {
        "stretches of the one training take"
    } else {
        "groups of takes"
    };
    let left_out = format!(
        "{} left-out segments of {folds} {of}",
        count(segments, NARROW_SPACE)
    );
    let smooth = fine_mm(smooth_error_m);
    if zero {
        return format!(
            "All weights are zero, so plans fall back to the smooth curve: on {left_out} it errs by {smooth}, and no learned deviation \
             was better by more than the standard error of the difference."
        );
    }
    format!(
        "On {left_out} the smooth curve errs by {smooth}, with the deviation {} (difference {} ± {}, the standard error over segments).",
        fine_mm(error_m),
        decimals(to_mm(error_m - smooth_error_m), 3).replace('-', "−"),
        fine_mm(standard_error_m),
    )
}

/// How often the widest corridors of the default method hold the recorded motion, without a full
/// stop; `None` where it has none or nothing was judged.
pub(crate) fn corridor_words(evaluation: &Evaluation) -> Option<String> {
    let method = default_method(evaluation)?;
    let widest =
        |a: &&CorridorCoverage, b: &&CorridorCoverage| a.share_stated.total_cmp(&b.share_stated);
    let coverage = method
        .corridors
        .iter()
        .filter(|c| c.n > 0 && c.share_stated.is_finite())
        .max_by(widest)?;
    Some(format!(
        "{} % corridors of {} hold {} % of {} recorded fingertip positions",
        stated_percent(coverage.share_stated),
        method.name,
        percent(coverage.share_inside.all),
        count(coverage.n, NARROW_SPACE),
    ))
}

/// A stated share in percent, with as few digits as it was stated.
pub(crate) fn stated_percent(share: f64) -> String {
    // The product of a share such as 0.95 with 100 may end in a rounding error.
    plain((share * 1e8).round() / 1e6)
}
