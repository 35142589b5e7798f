//! The page of many sessions together.

mod groups;
mod methods;
mod notes;
mod sessions;

use inhand_model::{MethodSummary, SessionSummary, Statistics, Summary};
use maud::{Markup, html};

use super::{Body, Named, Section, intervals, shell};
use crate::figure::Figure;
use crate::figure::palette::classes;
use crate::number::{NARROW_SPACE, NONE, count, decimals, millimetres};
use crate::words::join_words;

/// A method of a summary with the class of its colour.
pub(super) struct Contender<'a> {
    pub(super) summary: &'a MethodSummary,
    pub(super) named: Named<'a>,
}

/// Draws the page.
pub(crate) fn page(summary: &Summary) -> Markup {
    let title = title(summary);
    shell(&title, &header(summary), &sections(summary))
}

/// Every figure of the page, in its order.
pub(crate) fn figures(summary: &Summary) -> Vec<Figure> {
    let sections = sections(summary).into_iter();
    sections
        .flat_map(|section| section.body.into_figures())
        .collect()
}

fn sections(summary: &Summary) -> Vec<Section> {
    let contenders = &contenders(summary);
    let named: Vec<Named<'_>> = contenders.iter().map(|c| c.named.clone()).collect();
    let section = |id, title, body| Section { id, title, body };
    let mut sure = Body::default();
    sure.append(intervals::body(&summary.intervals, &named));
    let sections = [
        Some(section("methods", "Methods", methods::section(contenders))),
        Some(section("intervals", "Between sessions", sure)),
        Some(section(
            "sessions",
            "Sessions",
            sessions::section(summary, contenders),
        )),
        notes::outliers(summary).map(|body| section("outliers", "Outliers", body)),
        Some(section(
            "groups",
            "Participants, objects, tasks",
            groups::section(summary),
        )),
        notes::settings(summary).map(|body| section("settings", "Settings that differ", body)),
    ];
    sections.into_iter().flatten().collect()
}

fn contenders(summary: &Summary) -> Vec<Contender<'_>> {
    let baselines = summary.methods.iter().map(|method| method.baseline);
    (summary.methods.iter().zip(classes(baselines)))
        .map(|(method, class)| Contender {
            summary: method,
            named: Named {
                name: &method.name,
                class,
                default: method.name == summary.default_method,
            },
        })
        .collect()
}

fn title(summary: &Summary) -> String {
    match summary.sessions.len() {
        1 => "1 session".to_owned(),
        n => format!("{} sessions", count(n, NARROW_SPACE)),
    }
}

fn header(summary: &Summary) -> Markup {
    let sessions = &summary.sessions;
    let add =
        |of: fn(&SessionSummary) -> usize| sessions.iter().map(of).fold(0, usize::saturating_add);
    let (segments, left_out) = (add(|s| s.segments), add(|s| s.left_out));
    let hours = sessions.iter().map(|s| s.duration_s).sum::<f64>() / 3600.0;
    html! {
        header {
            p.kind { "In-hand manipulation report" }
            h1 { (title(summary)) }
            dl.facts {
                (fact("Participants", &distinct(sessions.iter().map(|s| s.participant.as_deref()))))
                (fact("Objects", &distinct(sessions.iter().map(|s| s.object.as_deref()))))
                (fact("Tasks", &distinct(sessions.iter().map(|s| s.task.as_deref()))))
                (fact("Test takes", &format!("{} h", decimals(hours, 2))))
                (fact("Segments", &format!(
                    "{}, {} lost to gaps", count(segments, NARROW_SPACE), count(left_out, NARROW_SPACE)
                )))
            }
            p.verdict { (verdict(summary)) }
        }
    }
}

fn fact(name: &str, value: &str) -> Markup {
    html! { div { dt { (name) } dd { (value) } } }
}

/// The values there are: named where they are few, counted where they are many.
fn distinct<'a>(values: impl Iterator<Item = Option<&'a str>>) -> String {
    const NAMED: usize = 3;
    let values: std::collections::BTreeSet<Option<&str>> = values.collect();
    let stated: Vec<String> = values
        .iter()
        .flatten()
        .map(|&value| value.to_owned())
        .collect();
    let missing = if values.contains(&None) {
        ", some not stated"
    } else {
        ""
    };
    match stated.len() {
        0 => "not stated".to_owned(),
        few if few <= NAMED => format!("{}{missing}", join_words(&stated)),
        many => format!("{}{missing}", count(many, NARROW_SPACE)),
    }
}

/// How the method to look at first stands, in words.
fn verdict(summary: &Summary) -> String {
    let intervals = &summary.intervals;
    let name = &summary.default_method;
    let Some(method) = summary.methods.iter().find(|method| method.name == *name) else {
        return String::new();
    };
    let mut text = format!("{name}: {}.", middle(&method.error.all));
    if let Some(contacts) = method.contacts.filter(|contacts| contacts.n > 0) {
        let share = |part: usize| crate::number::percent(part as f64 / contacts.n as f64);
        text.push_str(&format!(
            " Three or more fingers hold {} % of the time, recorded {} %.",
            share(contacts.three_or_more),
            share(contacts.recorded_three_or_more)
        ));
    }
    if let Some(baseline) = &intervals.best_baseline
        && let Some(words) = intervals::against_words(intervals, name, baseline)
    {
        text.push_str(&words);
    }
    text
}

fn middle(error: &Statistics) -> String {
    if error.n == 0 {
        return "no instant was judged".to_owned();
    }
    format!(
        "the median error is {} mm, a quarter of the errors is above {} mm",
        millimetres(error.p50),
        millimetres(error.p75)
    )
}

/// A name from a file, or that there is none.
pub(super) fn stated(value: Option<&str>) -> String {
    value
        .filter(|value| !value.is_empty())
        .unwrap_or(NONE)
        .to_owned()
}
