//! Two evaluations side by side: how statistics differ, with intervals.

use inhand_model::{
    Bootstrap, ContactChange, ErrorChange, EvaluationRows, Finger, Measure, MethodEvaluation,
    Statistics,
};
use inhand_statistics::BootstrapError;
use inhand_statistics::bootstrap::{ClusteredRows, Drawn, Draws, SortedRows};

use crate::intervals::{FINGERS, judged_by_both, ones_and_zeros, segment_contacts, segment_errors};

/// A method in the rows of an evaluation.
#[derive(Clone, Copy, Debug)]
pub struct MethodOf<'a> {
    /// The rows.
    pub rows: &'a EvaluationRows,
    /// Place of the method in them.
    pub method: usize,
    /// Largest distance that counts as contact in this evaluation, metres.
    pub tau_m: f64,
}

impl MethodOf<'_> {
    fn name(&self) -> &str {
        &self.rows.methods[self.method].name
    }
}

/// Whether two evaluations judged segments of the same places in takes of the same names. Whether the takes are the
/// same only their files tell.
pub fn same_segments(before: &EvaluationRows, after: &EvaluationRows) -> bool {
    (before.layout.samples, before.layout.rate_hz) == (after.layout.samples, after.layout.rate_hz)
        && before.takes == after.takes
        && before.segments == after.segments
}

/// Changes of the errors of a method: for all fingers together and each finger, in every
/// measure. Segments are drawn together where both judged the very same ones (`paired`: what is hard about a
/// segment is hard in both), else apart. A statistic of no rows on one side is left out.
///
/// # Errors
///
/// [`BootstrapError`] for settings that make no sense.
pub fn compare_errors(
    before: MethodOf<'_>,
    after: MethodOf<'_>,
    paired: bool,
    bootstrap: Bootstrap,
) -> Result<Vec<ErrorChange>, BootstrapError> {
    let sorted = |of: MethodOf<'_>| -> Result<Vec<SortedRows>, BootstrapError> {
        let fingers = inhand_parallel::try_map(&Finger::ALL, |&finger| {
            SortedRows::new(&segment_errors(of.rows, of.method, finger))
        })?;
        let all = SortedRows::merged(&fingers)?;
        Ok([all].into_iter().chain(fingers).collect())
    };
    let samples = sorted(after)?.into_iter().zip(sorted(before)?);
    let mut changes = Vec::new();
    for (finger, (first, second)) in FINGERS.into_iter().zip(samples) {
        let samples = (&first.into(), &second.into());
        let [first, second] = drawn(samples, paired, &Measure::ALL, &bootstrap)?;
        let values = first.values().iter().zip(second.values());
        let found = first.less(&second);
        for ((measure, (&after_m, &before_m)), found) in
            Measure::ALL.into_iter().zip(values).zip(found)
        {
            let Some(found) = found else { continue };
            changes.push(ErrorChange {
                before_method: before.name().to_owned(),
                after_method: after.name().to_owned(),
                finger,
                measure,
                before_m,
                after_m,
                relative_change: ErrorChange::relative_change(before_m, after_m),
                absolute: Some(found.absolute),
                relative: found.relative,
            });
        }
    }
    Ok(changes)
}

/// Change of the share of instants with three or more contacts; `None` where one of both has no
/// object.
///
/// # Errors
///
/// As [`compare_errors`].
pub fn compare_contacts(
    before: MethodOf<'_>,
    after: MethodOf<'_>,
    paired: bool,
    bootstrap: Bootstrap,
) -> Result<Option<ContactChange>, BootstrapError> {
    let counts = |of: MethodOf<'_>| segment_contacts(of.rows, of.method, of.tau_m);
    let (Some(first), Some(second)) = (counts(after), counts(before)) else {
        return Ok(None);
    };
    let first = ones_and_zeros(&first, |counts| counts.three_or_more)?;
    let second = ones_and_zeros(&second, |counts| counts.three_or_more)?;
    let [first, second] = drawn((&first, &second), paired, &[Measure::Mean], &bootstrap)?;
    Ok(first.less(&second)[0].map(|found| ContactChange {
        before_method: before.name().to_owned(),
        after_method: after.name().to_owned(),
        before: second.values()[0],
        after: first.values()[0],
        absolute: Some(found.absolute),
    }))
}

/// Changes of the errors that both evaluations state, without intervals.
pub fn stated_errors(old: &MethodEvaluation, new: &MethodEvaluation) -> Vec<ErrorChange> {
    let of = |method: &MethodEvaluation, finger: Option<Finger>| -> Statistics {
        finger.map_or(method.error.all, |finger| method.error.by_finger[finger])
    };
    let value = |error: &Statistics, measure| match measure {
        Measure::Mean => error.mean,
        Measure::Rmse => error.rmse,
        Measure::P50 => error.p50,
        Measure::P75 => error.p75,
        Measure::P95 => error.p95,
    };
    let fingers = [None].into_iter().chain(Finger::ALL.map(Some));
    fingers
        .map(|finger| (finger, of(old, finger), of(new, finger)))
        .filter(|(_, old, new)| old.n > 0 && new.n > 0)
        .flat_map(|(finger, before, after)| {
            Measure::ALL.map(|measure| ErrorChange {
                before_method: old.name.clone(),
                after_method: new.name.clone(),
                finger,
                measure,
                before_m: value(&before, measure),
                after_m: value(&after, measure),
                relative_change: ErrorChange::relative_change(
                    value(&before, measure),
                    value(&after, measure),
                ),
                absolute: None,
                relative: None,
            })
        })
        .collect()
}

/// Change of the share of instants with three or more contacts that both evaluations state, without an interval.
pub fn stated_contacts(old: &MethodEvaluation, new: &MethodEvaluation) -> Option<ContactChange> {
    let (before, after) = (old.contact.as_ref()?, new.contact.as_ref()?);
    Some(ContactChange {
        before_method: old.name.clone(),
        after_method: new.name.clone(),
        before: before.three_or_more,
        after: after.three_or_more,
        absolute: None,
    })
}

/// Statistics of both samples: of pairs in the same draws of the clusters in which both judged the same instants, else
/// each in its own.
fn drawn(
    (first, second): (&ClusteredRows, &ClusteredRows),
    paired: bool,
    measures: &[Measure],
    bootstrap: &Bootstrap,
) -> Result<[Drawn; 2], BootstrapError> {
    let of_first = Draws::new(bootstrap, first.sizes().len())?;
    let [of_first, of_second] = match paired {
        true => {
            let both = of_first.only(&judged_by_both(first.sizes(), second.sizes()))?;
            [both.clone(), both]
        }
        false => [of_first, Draws::apart(bootstrap, second.sizes().len())?],
    };
    Ok([
        first.drawn(&of_first, measures)?,
        second.drawn(&of_second, measures)?,
    ])
}
