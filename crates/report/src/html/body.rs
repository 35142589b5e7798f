//! Content of a section: prose, tables and figures in their order.
//!
//! A page is made of sections and a folder of figures is collected from the same sections, so that no
//! figure is on the page alone.

use maud::{Markup, Render, html};

use crate::figure::Figure;

/// Parts of a section from top to bottom.
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

    /// Adds parts that a reader unfolds; nothing where there are none.
    pub(crate) fn folded(self, summary: &'static str, body: Body) -> Self {
        let part = (!body.0.is_empty()).then_some(BodyPart::Folded(summary, body));
        self.with(part)
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
                    BodyPart::Folded(summary, body) => details {
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
