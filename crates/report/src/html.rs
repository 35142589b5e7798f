//! The page: a verdict first, then what it rests on, a file a section.

mod body;
mod choice;
mod constraints;
mod contacts;
mod corridors;
mod deviation;
mod dictionary;
mod errors;
mod object;
mod over_time;
mod plans;
mod provenance;
mod quality;
mod session;
mod statistics;
mod table;

use inhand_model::MethodEvaluation;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::figure::palette::method_classes;
use crate::figure::{Figure, style};
use crate::report::Report;
pub(crate) use body::Body;

/// Styles, written into the page. Ours alone, so it needs no escaping.
const STYLE: &str = include_str!("html/style.css");

/// Nothing may be loaded, whatever a name in a file says; styles and the empty icon are in the
/// page itself.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";

/// A method with the class of its colour.
#[derive(Clone)]
pub(crate) struct Method<'a> {
    pub(crate) evaluation: &'a MethodEvaluation,
    pub(crate) class: String,
    /// Whether it is the one to look at first.
    pub(crate) default: bool,
}

/// A part of the page with its place in the table of contents.
struct Section {
    id: &'static str,
    title: &'static str,
    body: Body,
}

/// What the page says, a section a topic.
fn sections(report: &Report<'_>) -> Vec<Section> {
    let evaluation = report.evaluation;
    let methods: &[Method<'_>] = &methods(report);
    let section = |id, title, body| Section { id, title, body };
    // What nobody planned or judged has no section.
    let sections = [
        Some(section(
            "methods",
            "Methods",
            session::methods(evaluation, methods).into(),
        )),
        Some(section(
            "quality",
            "Data quality",
            quality::section(evaluation).into(),
        )),
        Some(section(
            "errors",
            "Fingertip error",
            errors::section(evaluation, methods),
        )),
        object::section(methods).map(|body| section("object", "Object pose", body)),
        Some(section("contacts", "Contacts", contacts::section(methods))),
        Some(section(
            "constraints",
            "Constraints",
            constraints::section(methods).into(),
        )),
        corridors::section(methods).map(|body| section("corridors", "Corridors", body)),
        Some(section(
            "dictionary",
            "Dictionary",
            dictionary::section(evaluation),
        )),
        Some(section(
            "provenance",
            "Settings and provenance",
            provenance::section(report.provenance).into(),
        )),
    ];
    sections.into_iter().flatten().collect()
}

fn methods<'a>(report: &Report<'a>) -> Vec<Method<'a>> {
    let methods = &report.evaluation.methods;
    methods
        .iter()
        .zip(method_classes(methods))
        .map(|(method, class)| Method {
            evaluation: method,
            class,
            default: method.name == report.evaluation.default_method,
        })
        .collect()
}

/// Every figure of the page, in its order.
pub(crate) fn figures(report: &Report<'_>) -> Vec<Figure> {
    let sections = sections(report).into_iter();
    sections
        .flat_map(|section| section.body.into_figures())
        .collect()
}

/// Draws the page.
pub(crate) fn page(report: &Report<'_>) -> Markup {
    let evaluation = report.evaluation;
    let sections = sections(report);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (evaluation.session.name) " – inhand report" }
                link rel="icon" href="data:,";
                style { (PreEscaped(style::variables())) (PreEscaped(style::SHAPES)) (PreEscaped(STYLE)) }
            }
            body {
                (session::header(evaluation))
                nav aria-label="Contents" {
                    @for section in &sections {
                        a href={ "#" (section.id) } { (section.title) }
                    }
                }
                main {
                    @for section in &sections {
                        section id=(section.id) {
                            h2 { (section.title) }
                            (section.body.draw())
                        }
                    }
                }
            }
        }
    }
}
