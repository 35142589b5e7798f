//! Conditions on a comparison, such as `p75 > 5%`.

use inhand_model::{ErrorChange, Estimate, EvaluationComparison, Finger, Measure};

use crate::exit::UsageError;

const EXPECTED: &str =
    "expected [METHOD:]STATISTIC[.FINGER][.low|.high] OP NUMBER[%|mm], such as \"p75 > 5%\"";
const SHARE: &str = "three_or_more";

/// What is looked at.
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

#[derive(Clone, Copy, Debug, PartialEq)]
enum Operator {
    Above,
    AtLeast,
    Below,
    AtMost,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Unit {
    Percent,
    Millimetres,
}

/// A condition on the change from before to after.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Condition {
    text: String,
    method: Option<String>,
    quantity: Quantity,
    end: End,
    operator: Operator,
    limit: f64,
    unit: Unit,
}

impl Condition {
    /// Reads a condition as a person types it.
    pub(super) fn parse(text: &str) -> Result<Self, UsageError> {
        let wrong = |what: String| UsageError(format!("--fail-if \"{text}\": {what}; {EXPECTED}"));
        let operators = [
            (">=", Operator::AtLeast),
            ("<=", Operator::AtMost),
            (">", Operator::Above),
            ("<", Operator::Below),
        ];
        let found = operators
            .iter()
            .find_map(|(sign, operator)| Some((text.split_once(sign)?, *operator)));
        let Some(((left, right), operator)) = found else {
            return Err(wrong("no operator >, >=, < or <=".to_owned()));
        };
        // Names of methods hold no colon, statistics neither.
        let (method, what) = match left.trim().rsplit_once(':') {
            Some((method, what)) => (Some(method.trim().to_owned()), what.trim()),
            None => (None, left.trim()),
        };
        let (quantity, end) = quantity(what).map_err(&wrong)?;
        let (number, unit) = match right.trim() {
            number if number.ends_with('%') => (number.trim_end_matches('%'), Unit::Percent),
            number if number.ends_with("mm") => (number.trim_end_matches("mm"), Unit::Millimetres),
            number => return Err(wrong(format!("\"{number}\" has no unit"))),
        };
        let limit: f64 = (number.trim().parse().ok())
            .filter(|limit: &f64| limit.is_finite())
            .ok_or_else(|| wrong(format!("\"{}\" is no number", number.trim())))?;
        if (quantity, unit) == (Quantity::ThreeOrMore, Unit::Millimetres) {
            return Err(wrong("a share changes by % (points)".to_owned()));
        }
        Ok(Self {
            text: text.to_owned(),
            method,
            quantity,
            end,
            operator,
            limit,
            unit,
        })
    }

    /// What holds, in words, with the number found; `None` where the condition does not.
    ///
    /// # Errors
    ///
    /// [`UsageError`] where the comparison has no such number, so that a check never passes unseen.
    pub(super) fn holds(
        &self,
        comparison: &EvaluationComparison,
    ) -> Result<Option<String>, UsageError> {
        let wrong = |what: &str| UsageError(format!("--fail-if \"{}\": {what}", self.text));
        let found = self
            .change(comparison)
            .ok_or_else(|| wrong("the comparison has no such method or statistic"))?;
        let value = found.filter(|value| value.is_finite()).ok_or_else(|| {
            wrong("it has no such number: no interval (rows.parquet beside both evaluations gives one), or a change relative to 0")
        })?;
        let holds = match self.operator {
            Operator::Above => value > self.limit,
            Operator::AtLeast => value >= self.limit,
            Operator::Below => value < self.limit,
            Operator::AtMost => value <= self.limit,
        };
        let unit = match self.unit {
            Unit::Percent => "%",
            Unit::Millimetres => "mm",
        };
        Ok(holds.then(|| format!("{}: it is {value:.3} {unit}", self.text)))
    }

    /// The change in the unit of the condition: `None` without such a line, `Some(None)` without the number.
    fn change(&self, comparison: &EvaluationComparison) -> Option<Option<f64>> {
        let of_method = |name: &str| self.method.as_deref().is_none_or(|method| method == name);
        match self.quantity {
            Quantity::Error(measure, finger) => {
                let mut of_kind = comparison.errors.iter().filter(|change| {
                    change.measure == measure
                        && change.finger == finger
                        && of_method(&change.after_method)
                });
                of_kind.next().map(|change| self.error_change(change))
            }
            Quantity::ThreeOrMore => {
                let mut of_kind = comparison
                    .contacts
                    .iter()
                    .filter(|change| of_method(&change.after_method));
                of_kind.next().map(|change| {
                    let own = change.after - change.before;
                    self.pick(Some(own), change.absolute.as_ref())
                        .map(|share| 100.0 * share)
                })
            }
        }
    }

    fn error_change(&self, change: &ErrorChange) -> Option<f64> {
        match self.unit {
            Unit::Percent => {
                let own = self.pick(Some(change.relative_change), change.relative.as_ref());
                own.map(|share| 100.0 * share)
            }
            Unit::Millimetres => {
                let own = change.after_m - change.before_m;
                let picked = self.pick(Some(own), change.absolute.as_ref());
                picked.map(|metres| 1e3 * metres)
            }
        }
    }

    fn pick(&self, value: Option<f64>, estimate: Option<&Estimate>) -> Option<f64> {
        let ends = estimate.and_then(|estimate| estimate.interval);
        match self.end {
            End::Value => value,
            End::Low => ends.map(|[low, _]| low),
            End::High => ends.map(|[_, high]| high),
        }
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
    let measure = Measure::ALL
        .into_iter()
        .find(|measure| measure.name() == name);
    let measure = measure.ok_or_else(|| format!("no statistic \"{name}\""))?;
    Ok((Quantity::Error(measure, finger), end))
}

#[cfg(test)]
mod tests {
    use super::*;
    use inhand_model::{Bootstrap, Cluster, ComparedSide, ContactChange, Drawn};

    fn comparison() -> EvaluationComparison {
        let side = || ComparedSide {
            file: String::new(),
            session: String::new(),
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
            settings: Vec::new(),
        }
    }

    fn holds(text: &str) -> Result<bool, String> {
        let condition = Condition::parse(text).map_err(|error| error.to_string())?;
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
