//! The page: a verdict first, then what it rests on, a file a section.

mod body;
mod choice;
mod clouds;
mod constraints;
mod contact_count;
mod contact_raster;
mod contacts;
mod corridors;
mod deviation;
mod dictionary;
mod dynamics;
mod dynamics_figures;
mod ecdf;
mod errors;
mod filtering;
mod gaps;
mod illustrated;
pub(crate) mod intervals;
mod movement;
mod object;
mod over_time;
mod paper;
mod paths;
mod plan_status;
mod plan_times;
mod plans;
mod provenance;
mod quality;
mod segment_errors;
mod session;
mod shown;
mod statistics;
pub(crate) mod summary;
mod table;
mod worst;

use inhand_model::MethodEvaluation;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::figure::palette::method_classes;
use crate::figure::{Figure, style};
use crate::report::Report;
pub(crate) use body::Body;

/// Styles, written into the page. Ours alone, so it needs no escaping.
const STYLE: &str = include_str!("html/style.css");

/// Sorts tables and shows values under the pointer; the page says everything without it.
const SCRIPT: &str = include_str!("html/page.js");

/// Nothing may be loaded, whatever a name in a file says; styles and the empty icon are in the
/// page itself, and of scripts only the one with this hash runs: not one that a name smuggles in.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src 'sha256-KNRghC7MrMJwftOgSWXfqvgZMMxrhzx4bQMZD8E4B4s='; base-uri 'none'; form-action 'none'";

/// A method with the class of its colour.
#[derive(Clone)]
pub(crate) struct Method<'a> {
    pub(crate) evaluation: &'a MethodEvaluation,
    pub(crate) class: String,
    /// Whether it is the one to look at first.
    pub(crate) default: bool,
}

/// A method by its name alone, with the class of its colour.
#[derive(Clone)]
pub(crate) struct Named<'a> {
    pub(crate) name: &'a str,
    pub(crate) class: String,
    /// Whether it is the one to look at first.
    pub(crate) default: bool,
}

impl<'a> Method<'a> {
    pub(crate) fn named(&self) -> Named<'a> {
        Named {
            name: &self.evaluation.name,
            class: self.class.clone(),
            default: self.default,
        }
    }
}

/// A method's name with the colour it has in the figures.
fn named(method: &Named<'_>) -> Markup {
    html! { span.swatch.(method.class) {} (method.name) }
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
        illustrated::processing(report).map(|body| section("processing", "Gaps and filter", body)),
        Some(section(
            "errors",
            "Fingertip error",
            errors::section(report, methods),
        )),
        illustrated::examples(report, methods)
            .map(|body| section("examples", "Paths and worst errors", body)),
        paper::section(report).map(|body| section("paper", "Beside the paper", body)),
        object::section(methods).map(|body| section("object", "Object pose", body)),
        Some(section(
            "contacts",
            "Contacts",
            contacts::section(report, methods),
        )),
        illustrated::clouds(report).map(|body| section("clouds", "Clouds of points", body)),
        dynamics::section(report, methods)
            .map(|body| section("dynamics", "Contacts over time", body)),
        movement::section(report, methods).map(|body| section("movement", "Movement", body)),
        Some(section(
            "constraints",
            "Constraints",
            constraints::section(methods),
        )),
        plan_times::section(report.plan_times, methods)
            .map(|body| section("plan-times", "Plan times", body)),
        corridors::section(methods).map(|body| section("corridors", "Corridors", body)),
        Some(section(
            "dictionary",
            "Dictionary",
            dictionary::section(evaluation),
        )),
        illustrated::training(report).map(|body| section("training", "What training showed", body)),
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

/// Draws the page of one evaluation.
pub(crate) fn page(report: &Report<'_>) -> Markup {
    let evaluation = report.evaluation;
    shell(
        &evaluation.session.name,
        &session::header(evaluation),
        &sections(report),
    )
}

/// A page: what every report has around its sections.
fn shell(title: &str, header: &Markup, sections: &[Section]) -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) " – inhand report" }
                link rel="icon" href="data:,";
                style { (PreEscaped(style::variables())) (PreEscaped(style::SHAPES)) (PreEscaped(STYLE)) }
            }
            body {
                (header)
                details.contents.small {
                    summary { "Contents" }
                    (contents(sections))
                }
                div.columns {
                    div.contents.side { (contents(sections)) }
                    main {
                        @for section in sections {
                            section id=(section.id) {
                                h2 { (section.title) }
                                (section.body.draw())
                            }
                        }
                    }
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
}

fn contents(sections: &[Section]) -> Markup {
    html! {
        nav aria-label="Contents" {
            @for section in sections {
                a href={ "#" (section.id) } { (section.title) }
            }
        }
    }
}
