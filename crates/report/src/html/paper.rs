//! The run beside the numbers that were published for the same protocol.
//!
//! The numbers are those that the text of arXiv:2308.15153 states for its own recordings (one subject, about
//! two minutes a take, five takes for training and one for testing).

use inhand_model::{
    DictionaryKind, Evaluation, MethodEvaluation, PerFinger, Protocol, Provenance, Shape,
    Statistics,
};
use maud::html;

use super::Body;
use crate::Report;
use crate::json::settings_value;
use crate::table::{Table, known};
use crate::verdict::default_method;
use crate::words::{join_words, millimetres, part_of, percent, plain, to_mm};

/// The publication, as it is cited.
const SOURCE: &str = "arXiv:2308.15153";
/// The method that solves the published problem as it is printed.
const METHOD: &str = "paper";
/// Edge, diameter and height of the published objects, metres.
const SIZE_M: f64 = 0.05;

/// Published third quartile of the error of the worst finger, millimetres.
const P75_MM: f64 = 1.2;

/// Published numbers of one object.
struct Published {
    object: &'static str,
    collisions: &'static str,
    /// Share of instants with three or more contacts, as stated and 0 to 1.
    three_contacts: (&'static str, f64),
}

/// The content; `None` where the published method was not planned.
pub(super) fn body(report: &Report<'_>) -> Option<Body> {
    let evaluation = report.evaluation;
    let mut methods = evaluation.methods.iter();
    let method = methods.find(|method| method.name == METHOD)?;
    let Some(published) = followed(report) else {
        let body = html! {
            p {
                "The published numbers of " (SOURCE) " are not shown beside this run, because it does not follow their protocol: "
                (join_words(&differing(report))) "."
            }
        };
        return Some(body.into());
    };
    let default =
        default_method(evaluation, Protocol::Published).filter(|default| default.name != METHOD);
    Some(comparison(&published, method, default))
}

/// The published numbers of this run's object; `None` where it does not follow their protocol.
fn followed(report: &Report<'_>) -> Option<Published> {
    object(report.evaluation).filter(|_| differing(report).is_empty())
}

/// Third quartile of the worst finger and contacts beside the published ones in words, and whether the error is larger or
/// the share of contacts smaller by more than `share`; `None` where the run does not follow the published protocol.
pub(super) fn check(report: &Report<'_>, share: f64) -> Option<(bool, String)> {
    let mut methods = report.evaluation.methods.iter();
    let method = methods.find(|method| method.name == METHOD)?;
    let (stated, least) = followed(report)?.three_contacts;
    let worst_m = values(&method.error.by_finger, |s| s.p75).fold(f64::NAN, f64::max);
    let contacts = (method.contact.as_ref()).map_or(f64::NAN, |own| own.three_or_more);
    let words = format!(
        "75 % of the errors of {METHOD} are below {} mm in the worst finger (published: {P75_MM} mm), three contacts at {} % \
         (published: {stated}), both against the filtered recording; that was another recording, and its problem, without a start, has many solutions: {METHOD} takes \
         the smallest activations",
        millimetres(worst_m),
        percent(contacts),
    );
    let fine = to_mm(worst_m) <= P75_MM && contacts >= least - share;
    Some((!fine, words))
}

fn object(evaluation: &Evaluation) -> Option<Published> {
    let near = |size_m: f64| (size_m - SIZE_M).abs() < 1e-6;
    match evaluation.session.object.as_deref()?.parse().ok()? {
        Shape::Cuboid { edges_m } if edges_m.iter().all(|&edge| near(edge)) => Some(Published {
            object: "cube",
            collisions: "4 of 10 000 instants",
            three_contacts: ("97 %", 0.97),
        }),
        Shape::Cylinder {
            diameter_m,
            height_m,
        } if near(diameter_m) && near(height_m) => Some(Published {
            object: "cylinder",
            collisions: "1 of 10 000 instants",
            three_contacts: ("93 %", 0.93),
        }),
        _ => None,
    }
}

/// Differences of the run from the published protocol, in words.
fn differing(report: &Report<'_>) -> Vec<String> {
    let (session, dictionary) = (&report.evaluation.session, &report.evaluation.dictionary);
    let (rate_hz, samples) = (session.rate_hz, session.segment_samples);
    let (kind, rank) = (dictionary.kind, dictionary.rank);
    let mut contacts = report
        .evaluation
        .methods
        .iter()
        .filter_map(|m| m.contact.as_ref());
    let tau_m = contacts.next().map(|contact| contact.tau_m);
    let checks = [
        (
            object(report.evaluation).is_some(),
            "the object is neither a cube with an edge of 50 mm nor a cylinder of 50 mm by 50 mm"
                .to_owned(),
        ),
        (
            filtered_by_median(report.provenance),
            "motion was not filtered by a median of 50 samples, or that is not known".to_owned(),
        ),
        (
            rate_hz == 100.0,
            format!("it was sampled at {} Hz, not 100 Hz", plain(rate_hz)),
        ),
        (
            samples == 100,
            format!("segments have {samples} samples, not 100"),
        ),
        (
            kind == DictionaryKind::Nmf && rank == 200,
            format!(
                "the dictionary has {rank} {} primitives, not 200 of a non-negative factorisation",
                kind.name().to_uppercase()
            ),
        ),
        (
            tau_m.is_some_and(|tau_m| (tau_m - 0.005).abs() < 1e-9),
            tau_m.map_or_else(
                || "contacts were not evaluated".to_owned(),
                |tau_m| format!("contacts count up to {} mm, not 5 mm", plain(to_mm(tau_m))),
            ),
        ),
    ];
    let differing = checks.into_iter().filter(|(same, _)| !same);
    differing.map(|(_, words)| words).collect()
}

/// Whether the last step that says how it filtered did so by a median of 50 samples.
fn filtered_by_median(provenance: &[Provenance]) -> bool {
    let filters = provenance.iter().rev().filter_map(|step| {
        let settings = settings_value(&step.settings_json);
        let of = |name: &str| settings.pointer(&format!("/process/{name}")).cloned();
        Some((of("filter")?, of("window")))
    });
    let last = filters.take(1).next();
    last.is_some_and(|(filter, window)| filter == "median" && window == Some(50.into()))
}

/// A published measure, and how the same is found for a method; `None` where it was not evaluated.
type PublishedMeasure = (
    &'static str,
    &'static str,
    fn(&MethodEvaluation) -> Option<String>,
);

fn measures(published: &Published) -> [PublishedMeasure; 7] {
    [
        (
            "Error that 75 % of instants stay below, worst finger",
            "1.2 mm",
            |m| largest(&m.error.by_finger, |s| s.p75),
        ),
        ("Largest error", "3.5 mm", |m| {
            largest(&m.error.by_finger, |s| s.max)
        }),
        ("Points inside the training hull", "all", |m| {
            Some(format!("{} %", percent(m.reachability.inside.mean())))
        }),
        ("Instants with a collision", published.collisions, |m| {
            Some(part_of(m.collision.instants, m.collision.n) + " instants")
        }),
        (
            "Median difference of distances to the object, by finger",
            "0 to 5 mm",
            |m| {
                let fingers = m.distance_difference.as_ref()?;
                let medians = || values(fingers, |s| s.p50);
                let low = millimetres(medians().fold(f64::NAN, f64::min));
                Some(format!("{low} to {}", largest(fingers, |s| s.p50)?))
            },
        ),
        ("Largest difference of distances", "below 15 mm", |m| {
            largest(m.distance_difference.as_ref()?, |s| s.max)
        }),
        (
            "Instants with three or more contacts",
            published.three_contacts.0,
            |m| Some(format!("{} %", percent(m.contact.as_ref()?.three_or_more))),
        ),
    ]
}

fn comparison(
    published: &Published,
    method: &MethodEvaluation,
    default: Option<&MethodEvaluation>,
) -> Body {
    let caption = format!(
        "Published numbers for the {} beside this run",
        published.object
    );
    let rows = measures(published);
    let table = Table::new(caption, rows, "measure", |(measure, ..)| *measure)
        .words("published", |(_, stated, _)| (*stated).to_owned());
    let methods = std::iter::once(method).chain(default);
    let table = methods.fold(table, |table, method| {
        table.words(&format!("this run, {}", method.name), |(.., of)| {
            known(of(method))
        })
    });
    Body::from(html! {
        p {
            "This run follows the published protocol (" (published.object) " of 50 mm, median filter of 50 samples, segments of one second at \
             100 Hz, 200 primitives of a non-negative factorisation, contacts up to 5 mm), so the numbers of " (SOURCE) " are shown beside it."
        }
        (table)
        p.note {
            "Published: as the text of " (SOURCE) " states them, for its own recordings of one subject and 100 trajectories. Other data gives other \
             numbers by any method, so the baselines above, on the same data, say more than this column. The published problem has no start and has \
             many solutions; " b { (METHOD) } " takes the one with the smallest activations."
        }
    })
}

fn largest(fingers: &PerFinger<Statistics>, of: fn(&Statistics) -> f64) -> Option<String> {
    let value = values(fingers, of).fold(f64::NAN, f64::max);
    value
        .is_finite()
        .then(|| format!("{} mm", millimetres(value)))
}

/// Values of fingers of which anything was evaluated.
fn values(
    fingers: &PerFinger<Statistics>,
    of: fn(&Statistics) -> f64,
) -> impl Iterator<Item = f64> {
    fingers.as_array().iter().filter(|s| s.n > 0).map(of)
}
