//! The page: a verdict first, then what it rests on, a file a section.

pub(crate) mod checks;
mod constraints;
mod contact_raster;
mod contacts;
mod corridors;
mod dictionary;
mod dynamics;
mod errors;
mod examples;
pub(crate) mod intervals;
mod movement;
mod paper;
mod processing;
mod quality;
mod segment_errors;
mod session;
mod shown;
pub(crate) mod summary;
mod top;

use inhand_model::{Evaluation, Finger, MethodEvaluation, Protocol};
use maud::{DOCTYPE, Markup, PreEscaped, Render, html};

use crate::Report;
use crate::figure::line_chart::Series;
use crate::figure::row_plot::PlotRow;
use crate::figure::{Figure, RECORDED_CLASS, classes, style};
use crate::table::{Head, Table};

/// Styles, written into the page. Ours alone, so it needs no escaping.
const STYLE: &str = include_str!("html/style.css");

/// Sorts tables, shows values under the pointer and opens everything at once; the page says the same without it.
const SCRIPT: &str = include_str!("html/page.js");

/// Nothing may be loaded, whatever a name in a file says; styles and the empty icon are in the
/// page itself, and of scripts only the one with this hash runs: not one that a name smuggles in.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src 'sha256-qDLffSZxX44V6+d6vyVGUmF1Iv9pRBMX6fALz11I5TY='; base-uri 'none'; form-action 'none'";

/// A method with what is known of it and the class of its colour.
pub(crate) struct Method<'a, T = MethodEvaluation> {
    pub(crate) name: &'a str,
    pub(crate) evaluation: &'a T,
    pub(crate) class: String,
    /// Whether it is the one to look at first.
    pub(crate) default: bool,
}

impl<'a, T> Method<'a, T> {
    /// Methods with their colours. `of` is the name of one, and whether it is a baseline.
    fn all(methods: &'a [T], default: &str, of: fn(&T) -> (&str, bool)) -> Vec<Self> {
        (methods.iter().zip(classes(methods.iter().map(|m| of(m).1))))
            .map(|(evaluation, class)| Method {
                name: of(evaluation).0,
                evaluation,
                class,
                default: of(evaluation).0 == default,
            })
            .collect()
    }

    /// The same without what is known of it.
    fn alone(&self) -> Method<'a, ()> {
        Method {
            name: self.name,
            evaluation: &(),
            class: self.class.clone(),
            default: self.default,
        }
    }

    /// The name with the colour it has in the figures.
    fn head(&self) -> Head {
        Head::coloured(&self.class, self.name)
    }

    /// The row of the method in a plot.
    fn row(&self) -> PlotRow<'_> {
        PlotRow {
            stressed: self.default,
            ..PlotRow::new(self.name, &self.class)
        }
    }

    /// A line of the method.
    fn line(&self, points: impl IntoIterator<Item = (f64, f64)>) -> Series {
        Series {
            on_top: self.default,
            ..Series::new(self.name, &self.class, points)
        }
    }
}

/// The method to look at first.
fn default<'m, 'a, T>(methods: &'m [Method<'a, T>]) -> Option<&'m Method<'a, T>> {
    methods.iter().find(|method| method.default)
}

/// The method of that name.
fn named<'m, 'a, T>(methods: &'m [Method<'a, T>], name: &str) -> Option<&'m Method<'a, T>> {
    methods.iter().find(|method| method.name == name)
}

/// The methods of which something is known, with it.
fn known_of<'m, 'a, R>(
    methods: &'m [Method<'a>],
    of: impl Fn(&'a MethodEvaluation) -> Option<R>,
) -> Vec<(&'m Method<'a>, R)> {
    let known = methods.iter().filter_map(|m| Some((m, of(m.evaluation)?)));
    known.collect()
}

/// A table with methods as rows.
fn method_table<'m, R, T: 'm>(
    caption: impl Into<String>,
    rows: impl IntoIterator<Item = R>,
    method: fn(&R) -> &Method<'m, T>,
) -> Table<R> {
    Table::new(caption, rows, "method", |row| method(row).head())
        .stressed(|row| method(row).default)
}

/// Recorded or planned motion, with what is known of it.
struct Motion<'a, T> {
    name: &'a str,
    head: Head,
    stressed: bool,
    facts: &'a T,
}

/// The recorded motion, then the methods of which something is known.
fn motions<'a, T>(
    recorded_facts: &'a T,
    planned: &'a [(String, T)],
    methods: &'a [Method<'_>],
) -> Vec<Motion<'a, T>> {
    let mut motions = vec![Motion {
        name: "recorded",
        head: recorded(),
        stressed: false,
        facts: recorded_facts,
    }];
    motions.extend(methods.iter().filter_map(|method| {
        let (_, facts) = planned.iter().find(|(name, _)| name == method.name)?;
        Some(Motion {
            name: method.name,
            head: method.head(),
            stressed: method.default,
            facts,
        })
    }));
    motions
}

/// A row of a motion.
type MotionRow<'a, T, R> = (&'a Motion<'a, T>, R);

/// A table with a group of motions for each finger.
fn motions_by_finger<'a, T, R>(
    caption: &str,
    motions: &'a [Motion<'a, T>],
    of: fn(&'a T, Finger) -> R,
) -> Table<MotionRow<'a, T, R>> {
    let groups = Finger::ALL.map(|finger| {
        let rows = motions.iter().map(|own| (own, of(own.facts, finger)));
        (finger, rows.collect())
    });
    Table::grouped(caption, groups, "motion", |(motion, _)| motion.head.clone())
        .stressed(|(motion, _)| motion.stressed)
}

/// Recorded motion as the head of a line.
fn recorded() -> Head {
    Head::coloured(RECORDED_CLASS, "recorded")
}

/// Content of a section from top to bottom: prose, tables and figures. A folder of figures is collected from the same
/// sections as the page, so that no figure is on the page alone.
#[derive(Default)]
pub(crate) struct Body(Vec<BodyPart>);

enum BodyPart {
    /// Headings, paragraphs, tables.
    Prose(Markup),
    Figure(Box<Figure>),
    /// Parts that a reader unfolds.
    Folded(&'static str, Body),
}

impl Body {
    fn with(mut self, part: impl IntoIterator<Item = BodyPart>) -> Self {
        self.0.extend(part);
        self
    }

    /// Adds headings, paragraphs or a table.
    pub(crate) fn prose(self, content: impl Render) -> Self {
        self.with([BodyPart::Prose(content.render())])
    }

    /// Adds a figure; nothing where there is none to draw.
    pub(crate) fn figure(self, figure: impl Into<Option<Figure>>) -> Self {
        let figure = figure.into();
        self.with(figure.map(|figure| BodyPart::Figure(Box::new(figure))))
    }

    /// Adds parts that a reader unfolds, under words that name them; nothing where there are none.
    pub(crate) fn folded(self, summary: &'static str, body: impl Into<Option<Body>>) -> Self {
        let body = body.into().filter(|body| !body.0.is_empty());
        self.with(body.map(|body| BodyPart::Folded(summary, body)))
    }

    /// Adds all parts of another body, where there is one.
    pub(crate) fn append(self, other: impl Into<Option<Body>>) -> Self {
        self.with(other.into().unwrap_or_default().0)
    }

    /// The section on the page.
    pub(crate) fn draw(&self) -> Markup {
        html! {
            @for part in &self.0 {
                @match part {
                    BodyPart::Prose(markup) => (markup),
                    BodyPart::Figure(figure) => (figure.embed()),
                    BodyPart::Folded(summary, body) => details.more {
                        summary { (summary) }
                        (body.draw())
                    },
                }
            }
        }
    }

    /// Its figures in their order.
    pub(crate) fn into_figures(self) -> Vec<Figure> {
        let figures = self.0.into_iter().map(|part| match part {
            BodyPart::Prose(_) => Vec::new(),
            BodyPart::Figure(figure) => vec![*figure],
            BodyPart::Folded(_, body) => body.into_figures(),
        });
        figures.flatten().collect()
    }
}

impl From<Markup> for Body {
    fn from(markup: Markup) -> Self {
        Self::default().prose(markup)
    }
}

/// A part of the page with its place in the table of contents.
struct Section {
    id: &'static str,
    title: &'static str,
    body: Body,
}

fn section(
    id: &'static str,
    title: &'static str,
    body: impl Into<Option<Body>>,
) -> Option<Section> {
    let body = body.into()?;
    Some(Section { id, title, body })
}

/// Methods under a protocol with their colours.
fn methods(evaluation: &Evaluation, protocol: Protocol) -> Vec<Method<'_>> {
    let methods = evaluation.methods(protocol);
    Method::all(methods, &evaluation.default_method, |method| {
        (&method.name, method.baseline)
    })
}

/// The sections of the page, one a question of a reader: what answers it is shown, the rest is folded away.
fn sections(report: &Report<'_>) -> Vec<Section> {
    let methods = &methods(report.evaluation, Protocol::Published);
    // What was not planned or evaluated has no section.
    let sections = [
        section("quality", "Data quality", quality::section(report)),
        section(
            "errors",
            "Fingertip error",
            errors::section(report, methods),
        ),
        section(
            "time",
            "Error over time",
            errors::time_section(report, methods),
        ),
        section(
            "contacts",
            "Contacts (published)",
            contacts::section(report, methods),
        ),
        section(
            "movement",
            "Movement (published)",
            movement::section(report, methods),
        ),
        section(
            "constraints",
            "Constraints (published)",
            constraints::section(report, methods),
        ),
        section(
            "corridors",
            "Prediction regions (published)",
            corridors::section(methods),
        ),
        section("dictionary", "Dictionary", dictionary::section(report)),
        section(
            "provenance",
            "Settings and provenance",
            Body::from(session::provenance(report.provenance)),
        ),
    ];
    sections.into_iter().flatten().collect()
}

/// Draws the page of one evaluation; with its figures, in their order.
pub(crate) fn page(report: &Report<'_>) -> (Markup, Vec<Figure>) {
    let (top, sections) = (top::body(report), sections(report));
    let page = shell(&report.evaluation.session.name, &top.draw(), &sections);
    let sections = sections.into_iter().map(|section| section.body);
    let bodies = std::iter::once(top).chain(sections);
    (page, bodies.flat_map(Body::into_figures).collect())
}

/// A page: what every report has around its sections. `top` is below the title.
fn shell(title: &str, top: &Markup, sections: &[Section]) -> Markup {
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
                header {
                    p.kind { "In-hand manipulation report" }
                    h1 { (title) }
                    (top)
                }
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
            // The script shows it: without one it would do nothing.
            label.everything hidden { input type="checkbox" autocomplete="off"; " Open everything, also to print" }
        }
    }
}
