//! The run beside the numbers that were published for the same protocol.
//!
//! The numbers are those that the text of arXiv:2308.15153 states for its own recordings (one subject, about
//! two minutes a take, five takes for training and one for testing).

use inhand_model::{
    DictionaryKind, Evaluation, Finger, MethodEvaluation, PerFinger, Provenance, Shape, Statistics,
};
use maud::html;

use super::Body;
use super::table::{Line, table, words};
use crate::json::settings_value;
use crate::number::{NARROW_SPACE, NONE, count, millimetres, percent, plain, to_mm};
use crate::report::Report;
use crate::verdict::default_method;
use crate::words::join_words;

/// The publication, as it is cited.
const SOURCE: &str = "arXiv:2308.15153";
/// The method that solves the published problem as it is printed.
const METHOD: &str = "paper";
/// Edge, diameter and height of the published objects, metres.
const SIZE_M: f64 = 0.05;

/// What was published for one object.
struct Published {
    object: &'static str,
    collisions: &'static str,
    three_contacts: &'static str,
}

const CUBE: Published = Published {
    object: "cube",
    collisions: "4 of 10 000 instants",
    three_contacts: "97 %",
};
const CYLINDER: Published = Published {
    object: "cylinder",
    collisions: "1 of 10 000 instants",
    three_contacts: "93 %",
};

/// The section's content; `None` where the published method was not planned, so that nobody compares.
pub(super) fn section(report: &Report<'_>) -> Option<Body> {
    let evaluation = report.evaluation;
    let method = evaluation
        .methods
        .iter()
        .find(|method| method.name == METHOD)?;
    let published = object(evaluation);
    let mut differing = differing(report);
    if published.is_none() {
        differing.insert(
            0,
            "the object is neither a cube with an edge of 50 mm nor a cylinder of 50 mm by 50 mm"
                .to_owned(),
        );
    }
    let Some(published) = published.filter(|_| differing.is_empty()) else {
        return Some(html! {
            p {
                "The published numbers of " (SOURCE) " do not stand beside this run, because it does not follow their protocol: "
                (join_words(&differing)) "."
            }
        }.into());
    };
    let default = default_method(evaluation).filter(|default| default.name != METHOD);
    Some(comparison(&published, method, default))
}

fn object(evaluation: &Evaluation) -> Option<Published> {
    let near = |size_m: f64| (size_m - SIZE_M).abs() < 1e-6;
    match evaluation.session.object.as_deref()?.parse().ok()? {
        Shape::Cuboid { edges_m } if edges_m.iter().all(|&edge| near(edge)) => Some(CUBE),
        Shape::Cylinder {
            diameter_m,
            height_m,
        } if near(diameter_m) && near(height_m) => Some(CYLINDER),
        _ => None,
    }
}

/// In what the run differs from the published protocol, in words.
fn differing(report: &Report<'_>) -> Vec<String> {
    let evaluation = report.evaluation;
    let mut words = Vec::new();
    let mut check = |same: bool, otherwise: String| {
        if !same {
            words.push(otherwise);
        }
    };
    check(
        filtered_by_median(report.provenance),
        "motion was not filtered by a median of 50 samples, or that is not known".to_owned(),
    );
    let rate_hz = evaluation.session.rate_hz;
    check(
        rate_hz == 100.0,
        format!("it was sampled at {} Hz, not 100 Hz", plain(rate_hz)),
    );
    let samples = evaluation.session.segment_samples;
    check(
        samples == 100,
        format!("segments have {samples} samples, not 100"),
    );
    let dictionary = &evaluation.dictionary;
    check(
        dictionary.kind == DictionaryKind::Nmf && dictionary.rank == 200,
        format!(
            "the dictionary has {} {} primitives, not 200 of a non-negative factorisation",
            dictionary.rank,
            dictionary.kind.name().to_uppercase()
        ),
    );
    let tau_m = evaluation
        .methods
        .iter()
        .find_map(|method| Some(method.contact.as_ref()?.tau_m));
    check(
        tau_m.is_some_and(|tau_m| (tau_m - 0.005).abs() < 1e-9),
        tau_m.map_or_else(
            || "contacts were not judged".to_owned(),
            |tau_m| format!("contacts count up to {} mm, not 5 mm", plain(to_mm(tau_m))),
        ),
    );
    words
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

fn comparison(
    published: &Published,
    method: &MethodEvaluation,
    default: Option<&MethodEvaluation>,
) -> Body {
    let mut columns = vec![
        words("measure"),
        words("published"),
        words("this run, paper"),
    ];
    let heading = default.map(|default| format!("this run, {}", default.name));
    columns.extend(heading.as_deref().map(words));
    let line = |measure: &str, stated: &str, of: &dyn Fn(&MethodEvaluation) -> String| Line {
        head: html! { (measure) },
        cells: std::iter::once(stated.to_owned())
            .chain(std::iter::once(method).chain(default).map(of))
            .collect(),
        best: Vec::new(),
        stressed: false,
    };
    let lines = vec![
        line(
            "Error that 75 % of instants stay below, worst finger",
            "1.2 mm",
            &|m| largest(&m.error.by_finger, |s| s.p75),
        ),
        line("Largest error", "3.5 mm", &|m| {
            largest(&m.error.by_finger, |s| s.max)
        }),
        line("Points inside the training hull", "all", &|m| {
            let share = m.reachability.inside.mean();
            format!("{} %", percent(share))
        }),
        line("Instants with a collision", published.collisions, &|m| {
            let collision = &m.collision;
            format!(
                "{} of {} instants",
                count(collision.instants, NARROW_SPACE),
                count(collision.n, NARROW_SPACE)
            )
        }),
        line(
            "Median difference of distances to the object, by finger",
            "0 to 5 mm",
            &|m| {
                (m.distance_difference.as_ref()).map_or_else(
                    || NONE.to_owned(),
                    |fingers| {
                        format!(
                            "{} to {}",
                            smallest(fingers, |s| s.p50),
                            largest(fingers, |s| s.p50)
                        )
                    },
                )
            },
        ),
        line("Largest difference of distances", "below 15 mm", &|m| {
            (m.distance_difference.as_ref())
                .map_or_else(|| NONE.to_owned(), |fingers| largest(fingers, |s| s.max))
        }),
        line(
            "Instants with three or more contacts",
            published.three_contacts,
            &|m| {
                (m.contact.as_ref()).map_or_else(
                    || NONE.to_owned(),
                    |contact| format!("{} %", percent(contact.three_or_more)),
                )
            },
        ),
    ];
    Body::from(html! {
        p {
            "This run follows the published protocol (" (published.object) " of 50 mm, median filter of 50 samples, segments of one second at \
             100 Hz, 200 primitives of a non-negative factorisation, contacts up to 5 mm), so the numbers of " (SOURCE) " stand beside it."
        }
        (table(&format!("Published numbers for the {} beside this run", published.object), &columns, lines))
        p.note {
            "Published: as the text of " (SOURCE) " states them, for its own recordings of one subject and 100 trajectories. Other data gives other \
             numbers by any method, so the baselines above, on the same data, say more than this column. The published problem knows no start and has \
             many solutions; " b { (METHOD) } " takes the one with the smallest activations."
        }
    })
}

fn smallest(fingers: &PerFinger<Statistics>, of: fn(&Statistics) -> f64) -> String {
    millimetres(values(fingers, of).into_iter().fold(f64::NAN, f64::min))
}

fn largest(fingers: &PerFinger<Statistics>, of: fn(&Statistics) -> f64) -> String {
    let value = values(fingers, of).into_iter().fold(f64::NAN, f64::max);
    if value.is_finite() {
        format!("{} mm", millimetres(value))
    } else {
        NONE.to_owned()
    }
}

/// Values of fingers of which anything was judged.
fn values(fingers: &PerFinger<Statistics>, of: fn(&Statistics) -> f64) -> Vec<f64> {
    (Finger::ALL.iter().map(|&finger| &fingers[finger]))
        .filter(|s| s.n > 0)
        .map(of)
        .collect()
}
