//! `inhand compare BEFORE AFTER`.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::Result;
use inhand_model::{Estimate, EvaluationComparison, Finger, Measure, Protocol};
use inhand_session::sessions::{CompareOptions, Part, compare};
use inhand_session::{EvaluateSection, write_text};

use crate::console::{Console, data};
use crate::exit::{Exit, UsageError, usage};
use crate::options::Format;
use crate::output::{check_outputs, reads_part, write_output};

/// Compare two evaluations or two methods, with intervals; fail on a condition
///
/// Compares an evaluation with an earlier one, or two methods of one evaluation, with bootstrap intervals over
/// segments. For use in tests: with --fail-if the exit code is 3 where the condition holds.
///
/// Prints first what differs in the reference motion and in settings, then the largest changes beyond noise and a
/// verdict. JSON always has every number.
///
/// Segments that both evaluations share are drawn together, which gives the narrowest intervals.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// evaluation.json before the change, or the folder with it.
    before: PathBuf,
    /// evaluation.json after the change; none to compare two methods of one.
    after: Option<PathBuf>,
    /// Method after the change [default: every method that both have].
    #[arg(long, value_name = "METHOD")]
    method: Option<String>,
    /// Method before the change, where it is another one.
    #[arg(long, value_name = "METHOD")]
    against: Option<String>,
    /// Exit with 3 if this holds: `[held_out/][METHOD:]STATISTIC[.FINGER][.low|.high] OP NUMBER[%|mm]`.
    ///
    /// STATISTIC is mean, rmse, p50, p75, p95 or three_or_more, OP one of > >= < <=. The number is the change from
    /// before to after: "p75 > 5%" holds if the third quartile of the error of the first method grew by more than
    /// 5 %, "prior:p95.thumb > 0.2mm" if the 95 % quantile of the thumb with prior grew by more than 0.2 mm. For
    /// three_or_more, % are percentage points. With .low the lower end of the interval is compared: "p75.low > 0%"
    /// holds only if the whole interval is above zero. With held_out/ it is the change under the held-out protocol, such as
    /// "held_out/residual:p75 > 5%", without it that under the published one.
    #[arg(long, value_name = "CONDITION")]
    fail_if: Vec<Condition>,
    /// Print every number, not only the largest changes beyond noise.
    #[arg(long)]
    all: bool,
    /// Draws of the bootstrap; 0 for no intervals.
    #[arg(long, value_name = "N", default_value_t = EvaluateSection::default().draws, value_parser = draws)]
    draws: usize,
    /// Confidence of intervals, 0 to 1.
    #[arg(long, value_name = "SHARE", default_value_t = EvaluateSection::default().confidence)]
    confidence: f64,
    /// Markdown for a pull request.
    #[arg(short, long, value_name = "FILE.md")]
    output: Option<PathBuf>,
    /// Print as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    if args.after.is_none() && args.method.is_none() && args.against.is_none() {
        return usage(
            "nothing to compare: name another evaluation, or two methods of this one with --method and --against",
        );
    }
    let before = Part::read(&args.before)?;
    let after = Part::read(args.after.as_ref().unwrap_or(&args.before))?;
    [&before, &after].into_iter().for_each(reads_part);
    check_outputs::<&Path>(&args.output, &[])?;
    let options = CompareOptions {
        method: args.method.clone(),
        against: args.against.clone(),
        draws: args.draws,
        confidence: args.confidence,
    };
    let comparison = compare(&before, &after, &options)?;
    // What can fail comes before anything is printed: an error is a document of its own.
    let conditions = args.fail_if.iter();
    let held = conditions.map(|condition| condition.holds(&comparison));
    let held: Vec<String> = held
        .filter_map(Result::transpose)
        .collect::<Result<_, _>>()?;
    if let Some(output) = &args.output {
        let text = inhand_report::comparison_markdown(&comparison);
        write_output(output, args.force, |path| write_text(path, &text))?;
    }
    match args.format {
        Format::Json => data(&inhand_report::comparison_json(&comparison)?)?,
        Format::Text => data(&inhand_report::comparison_text(&comparison, args.all))?,
    }
    args.output.iter().for_each(|output| console.wrote(output));
    for holds in &held {
        // Not even a quiet console hides why a check fails.
        console.error(&anyhow::anyhow!("check failed: {holds}"));
    }
    Ok(match held.is_empty() {
        true => Exit::Done,
        false => Exit::Lossy,
    })
}

/// None, or as many as intervals need and memory holds.
fn draws(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(draws @ (0 | 100..=1_000_000)) => Ok(draws),
        _ => Err("expected 0, or 100 to 1000000".to_owned()),
    }
}

/// Form of a condition, for errors.
const EXPECTED: &str = "expected [held_out/][METHOD:]STATISTIC[.FINGER][.low|.high] OP NUMBER[%|mm], such as \"p75 > 5%\"";
const SHARE: &str = "three_or_more";

/// The compared number.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Quantity {
    Error(Measure, Option<Finger>),
    ThreeOrMore,
}

/// Which end of the change.
#[derive(Clone, Copy, Debug, PartialEq)]
enum End {
    Value,
    Low,
    High,
}

/// A comparison of two numbers, with its sign.
type Operator = (&'static str, fn(&f64, &f64) -> bool);

/// The longer signs first, since they begin with the shorter ones.
const OPERATORS: [Operator; 4] = [
    (">=", f64::ge),
    ("<=", f64::le),
    (">", f64::gt),
    ("<", f64::lt),
];

const PERCENT: &str = "%";
const MILLIMETRES: &str = "mm";

/// A condition on the change from before to after.
#[derive(Clone, Debug)]
struct Condition {
    text: String,
    protocol: Protocol,
    method: Option<String>,
    quantity: Quantity,
    end: End,
    operator: Operator,
    limit: f64,
    unit: &'static str,
}

impl FromStr for Condition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = |what: String| format!("{what}; {EXPECTED}");
        let mut found = (OPERATORS.into_iter())
            .filter_map(|operator| Some((operator, text.split_once(operator.0)?)));
        let Some((operator, (left, right))) = found.next() else {
            return Err(wrong("no operator >, >=, < or <=".to_owned()));
        };
        // Names of methods hold no colon, statistics neither.
        let left = left.trim();
        let (protocol, left) = match left.split_once('/') {
            None => (Protocol::Published, left),
            Some((name, left)) => {
                let mut known = Protocol::ALL.into_iter();
                let protocol = known.find(|own| own.name() == name.trim());
                let unknown = || wrong(format!("no protocol \"{name}\""));
                (protocol.ok_or_else(unknown)?, left.trim())
            }
        };
        let (method, what) = match left.rsplit_once(':') {
            Some((method, what)) => (Some(method.trim().to_owned()), what.trim()),
            None => (None, left.trim()),
        };
        let (quantity, end) = quantity(what).map_err(&wrong)?;
        let right = right.trim();
        let (number, unit) = ([PERCENT, MILLIMETRES].into_iter())
            .find_map(|unit| Some((right.strip_suffix(unit)?.trim(), unit)))
            .ok_or_else(|| wrong(format!("\"{right}\" has no unit")))?;
        let limit: f64 = (number.parse().ok())
            .filter(|limit: &f64| limit.is_finite())
            .ok_or_else(|| wrong(format!("\"{number}\" is no number")))?;
        if quantity == Quantity::ThreeOrMore && unit == MILLIMETRES {
            return Err(wrong("a share changes by % (points)".to_owned()));
        }
        Ok(Self {
            text: text.to_owned(),
            protocol,
            method,
            quantity,
            end,
            operator,
            limit,
            unit,
        })
    }
}

impl Condition {
    /// The condition with the number, where it holds; `None` where it does not.
    ///
    /// # Errors
    ///
    /// [`UsageError`] where the comparison has no such number, so that a check never passes unseen.
    fn holds(&self, comparison: &EvaluationComparison) -> Result<Option<String>, UsageError> {
        let wrong = |what: &str| UsageError(format!("--fail-if \"{}\": {what}", self.text));
        if self.protocol == Protocol::HeldOut && comparison.held_out.is_none() {
            return Err(wrong(
                "one of the two was made before the held-out protocol",
            ));
        }
        let found = self
            .change(comparison)
            .ok_or_else(|| wrong("the comparison has no such method or statistic"))?;
        let value = found.filter(|value| value.is_finite()).ok_or_else(|| {
            wrong("it has no such number: no interval (rows.parquet beside both evaluations gives one), or a change relative to 0")
        })?;
        let (_, compare) = self.operator;
        let holds = compare(&value, &self.limit);
        Ok(holds.then(|| format!("{}: it is {value:.3} {}", self.text, self.unit)))
    }

    /// The change in the unit of the condition: `None` without such a line, `Some(None)` without the number.
    fn change(&self, comparison: &EvaluationComparison) -> Option<Option<f64>> {
        let (errors, contacts) = match self.protocol {
            Protocol::Published => (&comparison.errors, &comparison.contacts),
            Protocol::HeldOut => {
                let held_out = comparison.held_out.as_ref()?;
                (&held_out.errors, &held_out.contacts)
            }
        };
        let of_method = |name: &str| self.method.as_deref().is_none_or(|method| method == name);
        match self.quantity {
            Quantity::Error(measure, finger) => {
                let mut changes = errors.iter();
                let change = changes.find(|change| {
                    (change.measure, change.finger) == (measure, finger)
                        && of_method(&change.after_method)
                })?;
                Some(if self.unit == PERCENT {
                    self.pick(100.0, change.relative_change, &change.relative)
                } else {
                    self.pick(1e3, change.after_m - change.before_m, &change.absolute)
                })
            }
            Quantity::ThreeOrMore => {
                let mut changes = contacts.iter();
                let change = changes.find(|change| of_method(&change.after_method))?;
                Some(self.pick(100.0, change.after - change.before, &change.absolute))
            }
        }
    }

    /// The value or an end of its interval, times a factor.
    fn pick(&self, factor: f64, value: f64, estimate: &Option<Estimate>) -> Option<f64> {
        let interval = estimate.as_ref().and_then(|estimate| estimate.interval);
        let picked = match self.end {
            End::Value => Some(value),
            End::Low => interval.map(|[low, _]| low),
            End::High => interval.map(|[_, high]| high),
        };
        picked.map(|picked| factor * picked)
    }
}

/// `p75`, `p75.thumb`, `p75.thumb.low`, `three_or_more.high`.
fn quantity(what: &str) -> Result<(Quantity, End), String> {
    let mut words = what.split('.');
    let name = words.next().unwrap_or_default();
    let (mut finger, mut end) = (None, End::Value);
    for word in words {
        match (word, word.parse::<Finger>()) {
            ("low", _) if end == End::Value => end = End::Low,
            ("high", _) if end == End::Value => end = End::High,
            (_, Ok(found)) if finger.is_none() && end == End::Value => finger = Some(found),
            _ => return Err(format!("\"{word}\" is no finger, low or high")),
        }
    }
    if name == SHARE {
        return match finger {
            None => Ok((Quantity::ThreeOrMore, end)),
            Some(finger) => Err(format!("{SHARE} is of all fingers, not of the {finger}")),
        };
    }
    let mut measures = Measure::ALL.into_iter();
    let measure = measures.find(|measure| measure.name() == name);
    let measure = measure.ok_or_else(|| format!("no statistic \"{name}\""))?;
    Ok((Quantity::Error(measure, finger), end))
}

#[cfg(test)]
mod tests {
    use super::*;
    use inhand_model::{
        Bootstrap, Cluster, ComparedSide, ContactChange, Drawn, ErrorChange, HeldOutComparison,
    };

    fn comparison() -> EvaluationComparison {
        let side = || ComparedSide {
            file: String::new(),
            session: String::new(),
            held_out: true,
        };
        let estimate = |value: f64| Estimate {
            value,
            n: 10,
            clusters: 2,
            standard_error: None,
            interval: Some([value - 0.01, value + 0.01]),
        };
        let change = |method: &str, finger, before_m: f64, after_m: f64| ErrorChange {
            before_method: method.to_owned(),
            after_method: method.to_owned(),
            finger,
            measure: Measure::P75,
            before_m,
            after_m,
            relative_change: ErrorChange::relative_change(before_m, after_m),
            absolute: None,
            relative: Some(estimate((after_m - before_m) / before_m)),
        };
        EvaluationComparison {
            before: side(),
            after: side(),
            drawn: Drawn::Together,
            bootstrap: Bootstrap {
                cluster: Cluster::Segment,
                draws: 1,
                seed: 1,
                confidence: 0.95,
            },
            errors: vec![
                change("prior", None, 1e-3, 1.08e-3),
                change("prior", Some(Finger::Thumb), 1e-3, 0.9e-3),
                change("line", None, 2e-3, 2e-3),
            ],
            contacts: vec![ContactChange {
                before_method: "prior".to_owned(),
                after_method: "prior".to_owned(),
                before: 0.99,
                after: 0.96,
                absolute: None,
            }],
            held_out: Some(HeldOutComparison {
                drawn: Drawn::NotAtAll,
                errors: vec![change("prior", None, 2e-3, 2.1e-3)],
                contacts: Vec::new(),
            }),
            reference: Vec::new(),
            settings: Vec::new(),
        }
    }

    fn holds(text: &str) -> Result<bool, String> {
        let condition: Condition = text.parse()?;
        let found = condition
            .holds(&comparison())
            .map_err(|error| error.to_string())?;
        Ok(found.is_some())
    }

    #[test]
    fn conditions_hold_where_the_change_is_so_large() {
        for (text, expected) in [
            ("p75 > 5%", true),
            ("p75 > 9 %", false),
            ("p75.low > 6%", true),
            ("p75.high >= 9.1%", false),
            ("p75 > 0.05mm", true),
            ("line:p75 > 0%", false),
            ("line:p75 >= 0%", true),
            ("p75.thumb < -5%", true),
            ("prior:p75.thumb.high <= -8.9%", true),
            ("three_or_more < -2%", true),
            ("three_or_more<-4%", false),
            ("published/p75 > 7%", true),
            ("held_out/p75 > 7%", false),
            ("held_out/prior:p75 > 4%", true),
        ] {
            assert_eq!(holds(text), Ok(expected), "{text}");
        }
    }

    #[test]
    fn what_cannot_be_checked_is_refused() {
        for (text, reason) in [
            ("p75 5%", "no operator"),
            ("p75 > 5", "no unit"),
            ("p75 > five%", "no number"),
            ("p76 > 5%", "no statistic"),
            ("heldout/p75 > 5%", "no protocol"),
            ("held_out/line:p75 > 5%", "no such method or statistic"),
            ("p75.sixth > 5%", "no finger"),
            ("three_or_more > 1mm", "points"),
            ("three_or_more.thumb > 1%", "all fingers"),
            ("p95 > 5%", "no such method or statistic"),
            ("residual:p75 > 5%", "no such method or statistic"),
            ("three_or_more.low > 1%", "no interval"),
            ("p75.low > 1mm", "no interval"),
        ] {
            let refused = holds(text).expect_err(text);
            assert!(refused.contains(reason), "{text}: {refused}");
        }
    }
}
