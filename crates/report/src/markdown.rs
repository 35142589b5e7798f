//! A summary in Markdown, for pull requests and issues.

use std::fmt::Write;

use inhand_model::{Estimate, Evaluation, Intervals, Measure, MethodEvaluation};

use crate::html::intervals::{against, error_words, made_words, measure_words, relative_words};
use crate::learned::corridor_words;
use crate::number::{NARROW_SPACE, NONE, count, decimals, millimetres, percent};
use crate::verdict::{
    constraint_sentence, contact_sentence, default_method, error_sentence, standing_sentence,
};

/// Measures with a column.
const SHOWN: [Measure; 3] = [Measure::P50, Measure::P75, Measure::P95];
/// Methods and takes listed; what is more is counted. Keeps the text within a screen or two.
const METHODS: usize = 24;
const TAKES: usize = 16;

/// The text.
pub(crate) fn write(evaluation: &Evaluation) -> String {
    let mut text = format!(
        "## In-hand manipulation: {}\n\n",
        escaped(&evaluation.session.name)
    );
    let standing = default_method(evaluation).map(|own| standing_sentence(own, evaluation));
    let sentences = [
        Some(error_sentence(evaluation)),
        standing,
        contact_sentence(evaluation),
        corridor_words(evaluation).map(|words| format!("{words}.")),
        constraint_sentence(evaluation),
    ];
    let sentences: Vec<String> = sentences
        .into_iter()
        .flatten()
        .map(|s| escaped(&s))
        .collect();
    text.push_str(&sentences.join(" "));
    text.push_str("\n\n");
    methods(&mut text, evaluation);
    if let Some(intervals) = &evaluation.intervals {
        differences(&mut text, evaluation, intervals);
    }
    quality(&mut text, evaluation);
    text
}

fn methods(text: &mut String, evaluation: &Evaluation) {
    let three = evaluation
        .methods
        .iter()
        .any(|method| method.contact.is_some());
    let mut head: Vec<String> = vec!["method".to_owned()];
    head.extend(SHOWN.map(|measure| format!("{} (mm)", measure_words(measure))));
    head.push("max (mm)".to_owned());
    if three {
        head.push("three contacts, recorded → planned (%)".to_owned());
    }
    head.push("n (left out)".to_owned());
    row(text, &head);
    let rule: Vec<String> = (0..head.len())
        .map(|place| if place == 0 { "---" } else { "---:" }.to_owned())
        .collect();
    row(text, &rule);
    for method in evaluation.methods.iter().take(METHODS) {
        let mut cells = vec![method_name(method, evaluation)];
        let interval = estimates(evaluation, &method.name);
        cells.extend(SHOWN.map(|measure| error_cell(method, interval, measure)));
        cells.push(judged(method, method.error.all.max));
        if three {
            cells.push(contact_cell(method));
        }
        let (n, left_out) = (method.error.all.n, method.error.all.n_left_out);
        cells.push(format!(
            "{} ({})",
            count(n, NARROW_SPACE),
            count(left_out, NARROW_SPACE)
        ));
        row(text, &cells);
    }
    more(text, evaluation.methods.len(), METHODS, "methods");
    text.push('\n');
}

fn method_name(method: &MethodEvaluation, evaluation: &Evaluation) -> String {
    let name = escaped(&method.name);
    let name = if method.name == evaluation.default_method {
        format!("**{name}**")
    } else {
        name
    };
    if method.baseline {
        format!("{name} (baseline)")
    } else {
        name
    }
}

fn estimates<'a>(evaluation: &'a Evaluation, method: &str) -> Option<&'a [Estimate; 5]> {
    let intervals = evaluation.intervals.as_ref()?;
    let own = intervals.methods.iter().find(|own| own.method == method)?;
    own.error.all.as_ref()
}

fn error_cell(
    method: &MethodEvaluation,
    estimates: Option<&[Estimate; 5]>,
    measure: Measure,
) -> String {
    let place = Measure::ALL.iter().position(|own| *own == measure);
    if let (Some(estimates), Some(place)) = (estimates, place) {
        return error_words(&estimates[place]);
    }
    let error = &method.error.all;
    judged(
        method,
        match measure {
            Measure::Mean => error.mean,
            Measure::Rmse => error.rmse,
            Measure::P50 => error.p50,
            Measure::P75 => error.p75,
            Measure::P95 => error.p95,
        },
    )
}

fn judged(method: &MethodEvaluation, metres: f64) -> String {
    match method.error.all.n {
        0 => NONE.to_owned(),
        _ => millimetres(metres),
    }
}

fn contact_cell(method: &MethodEvaluation) -> String {
    match &method.contact {
        Some(contact) if contact.n > 0 => format!(
            "{} → {}",
            percent(contact.recorded_three_or_more),
            percent(contact.three_or_more)
        ),
        _ => NONE.to_owned(),
    }
}

fn differences(text: &mut String, evaluation: &Evaluation, intervals: &Intervals) {
    let Some(baseline) = intervals.best_baseline.as_deref() else {
        return;
    };
    let cell = |method: &str, measure: Measure| {
        let mut of = against(intervals, baseline, measure).filter(|own| own.method == method);
        let relative = of.next().and_then(|own| own.relative.as_ref());
        relative.map_or_else(|| NONE.to_owned(), relative_words)
    };
    let compared: Vec<&MethodEvaluation> = (evaluation.methods.iter())
        .filter(|method| {
            SHOWN
                .iter()
                .any(|&m| against(intervals, baseline, m).any(|own| own.method == method.name))
        })
        .collect();
    if compared.is_empty() {
        return;
    }
    let _ = writeln!(
        text,
        "Error relative to {}, the best baseline, on the same segments; below zero is better:\n",
        escaped(baseline)
    );
    let mut head = vec!["method".to_owned()];
    head.extend(SHOWN.map(|measure| measure_words(measure).to_owned()));
    row(text, &head);
    row(text, &["---", "---:", "---:", "---:"].map(str::to_owned));
    for method in compared.iter().take(METHODS) {
        let mut cells = vec![method_name(method, evaluation)];
        cells.extend(SHOWN.map(|measure| cell(&method.name, measure)));
        row(text, &cells);
    }
    more(text, compared.len(), METHODS, "methods");
    let _ = writeln!(text, "\n{}\n", made_words(&intervals.bootstrap));
}

/// A line a take, the odd ones alone where there are many.
fn quality(text: &mut String, evaluation: &Evaluation) {
    let takes = &evaluation.quality;
    let odd: Vec<_> = takes.iter().filter(|take| take.warnings() > 0).collect();
    let missing: usize = (takes.iter())
        .flat_map(|take| take.fingers.as_array().map(|track| track.recorded))
        .map(|track| track.missing)
        .sum();
    let samples: usize = (takes.iter())
        .flat_map(|take| take.fingers.as_array().map(|track| track.recorded))
        .map(|track| track.measured + track.filled + track.missing)
        .sum();
    if samples == 0 {
        return;
    }
    let _ = writeln!(
        text,
        "Data: {} of {} fingertip samples missing as recorded ({} %); {} of {} takes with warnings.",
        count(missing, NARROW_SPACE),
        count(samples, NARROW_SPACE),
        percent(missing as f64 / samples as f64),
        odd.len(),
        takes.len(),
    );
    if odd.is_empty() {
        return;
    }
    text.push('\n');
    for take in odd.iter().take(TAKES) {
        let object = take.object_tracked.map_or_else(String::new, |share| {
            format!(", object tracked {} %", percent(share))
        });
        let gaps_s = take.fingers.map(|track| track.longest_gap_s);
        let gap = gaps_s.into_array().into_iter().fold(0.0, f64::max);
        let _ = writeln!(
            text,
            "* {} ({}): {} warnings, longest gap {} s{object}",
            escaped(&take.take),
            escaped(&take.role),
            take.warnings(),
            decimals(gap, 2),
        );
    }
    more(text, odd.len(), TAKES, "takes");
}

fn more(text: &mut String, all: usize, shown: usize, what: &str) {
    if all > shown {
        let _ = writeln!(text, "\nand {} more {what}.", all - shown);
    }
}

pub(crate) fn row(text: &mut String, cells: &[String]) {
    let _ = writeln!(text, "| {} |", cells.join(" | "));
}

/// Text as text: nothing in it is taken for a table, a tag, code, a link, stress or a mention.
pub(crate) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '&' => safe.push_str("&amp;"),
            // A backslash does not keep sites from mentioning people and issues; a character reference does.
            '@' => safe.push_str("&#64;"),
            '#' => safe.push_str("&#35;"),
            '|' | '`' | '*' | '_' | '[' | ']' | '\\' | '~' | '!' => {
                safe.push('\\');
                safe.push(letter);
            }
            '\n' | '\r' => safe.push(' '),
            _ => safe.push(letter),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_text() {
        assert_eq!(
            escaped("a|b`c <script>@me #1 [x](y) *z*\n_w_"),
            "a\\|b\\`c &lt;script&gt;&#64;me &#35;1 \\[x\\](y) \\*z\\* \\_w\\_"
        );
        assert_eq!(escaped("0.44 mm (75 %)"), "0.44 mm (75 %)");
    }
}
