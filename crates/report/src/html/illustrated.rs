//! Sections of what figures show beside the numbers, where a report has illustrations.

use super::{Body, Method, clouds, filtering, gaps, paths, shown, worst};
use crate::report::Report;

/// Gaps, the filter, spectra.
pub(super) fn processing(report: &Report<'_>) -> Option<Body> {
    let all = report.illustrations?;
    let mut body = gaps::part(&all.gaps);
    body.append(filtering::part(
        all.filtering.as_ref(),
        all.spectrum.as_ref(),
    ));
    Some(body)
}

/// Paths in space and the worst errors.
pub(super) fn examples(report: &Report<'_>, methods: &[Method<'_>]) -> Option<Body> {
    let all = report.illustrations?;
    let mut body = paths::part(&all.paths, methods);
    body.append(worst::part(&all.worst, report.evaluation.session.rate_hz));
    Some(body)
}

/// Clouds of points on the object; `None` where there is no object.
pub(super) fn clouds(report: &Report<'_>) -> Option<Body> {
    let clouds = &report.illustrations?.point_clouds;
    (!clouds.is_empty()).then(|| clouds::part(clouds))
}

/// Hulls, primitives, explained variance.
pub(super) fn training(report: &Report<'_>) -> Option<Body> {
    let all = report.illustrations?;
    let mut body = Body::default();
    body.figure(all.hulls.as_ref().and_then(shown::hulls));
    body.append(shown::dictionary(
        report.evaluation.dictionary.kind,
        &all.primitives,
        all.explained.as_ref(),
        report.evaluation.session.rate_hz,
    ));
    Some(body)
}
