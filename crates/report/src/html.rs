//! The page: a verdict first, then what it rests on, a file a section.

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

use inhand_model::{Evaluation, MethodEvaluation, Provenance};
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::figure::palette::method_classes;

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
    body: Markup,
}

/// Draws the page.
pub(crate) fn page(evaluation: &Evaluation, provenance: &[Provenance]) -> Markup {
    let methods: Vec<Method<'_>> = evaluation
        .methods
        .iter()
        .zip(method_classes(&evaluation.methods))
        .map(|(method, class)| Method {
            evaluation: method,
            class,
            default: method.name == evaluation.default_method,
        })
        .collect();
    let section = |id, title, body| Some(Section { id, title, body });
    let sections = [
        section("methods", "Methods", session::methods(evaluation, &methods)),
        section("quality", "Data quality", quality::section(evaluation)),
        section(
            "errors",
            "Fingertip error",
            errors::section(evaluation, &methods),
        ),
        object::section(&methods).and_then(|body| section("object", "Object pose", body)),
        section("contacts", "Contacts", contacts::section(&methods)),
        section("constraints", "Constraints", constraints::section(&methods)),
        corridors::section(&methods).and_then(|body| section("corridors", "Corridors", body)),
        section("dictionary", "Dictionary", dictionary::section(evaluation)),
        section(
            "provenance",
            "Settings and provenance",
            provenance::section(provenance),
        ),
    ];
    // What nobody planned or judged has no section.
    let sections: Vec<Section> = sections.into_iter().flatten().collect();
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
                style { (PreEscaped(STYLE)) }
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
                            (section.body)
                        }
                    }
                }
            }
        }
    }
}

/// Names of methods with the look of their lines, for line charts.
fn legend(entries: &[(&str, &str)]) -> Markup {
    html! {
        ul.legend {
            @for (class, name) in entries {
                li {
                    svg viewBox="0 0 30 8" width="30" height="8" aria-hidden="true" {
                        g.(class) { path.line d="M1 4L29 4" {} }
                    }
                    (name)
                }
            }
        }
    }
}
