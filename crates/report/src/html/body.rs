//! Content of a section: prose, tables and figures in their order.
//!
//! A page is made of sections and a folder of figures is collected from the same sections, so that no
//! figure is on the page alone.

use maud::{Markup, html};

use crate::figure::Figure;

/// Parts of a section from top to bottom.
#[derive(Default)]
pub(crate) struct Body(Vec<Part>);

enum Part {
    /// Headings, paragraphs, tables.
    Prose(Markup),
    Figure(Box<Figure>),
    /// Parts that a reader unfolds.
    Folded(String, Body),
}

impl Body {
    /// Adds headings, paragraphs, tables.
    pub(crate) fn prose(&mut self, markup: Markup) -> &mut Self {
        self.0.push(Part::Prose(markup));
        self
    }

    /// Adds a figure; nothing where there is none to draw.
    pub(crate) fn figure(&mut self, figure: impl Into<Option<Figure>>) -> &mut Self {
        self.0
            .extend(figure.into().map(|figure| Part::Figure(Box::new(figure))));
        self
    }

    /// Adds parts that a reader unfolds; nothing where there are none.
    pub(crate) fn folded(&mut self, summary: &str, body: Body) -> &mut Self {
        if !body.0.is_empty() {
            self.0.push(Part::Folded(summary.to_owned(), body));
        }
        self
    }

    /// Adds all parts of another body.
    pub(crate) fn append(&mut self, mut other: Body) -> &mut Self {
        self.0.append(&mut other.0);
        self
    }

    /// The section on the page.
    pub(crate) fn draw(&self) -> Markup {
        html! {
            @for part in &self.0 {
                @match part {
                    Part::Prose(markup) => (markup),
                    Part::Figure(figure) => (figure.embed()),
                    Part::Folded(summary, body) => details {
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
            Part::Prose(_) => Vec::new(),
            Part::Figure(figure) => vec![*figure],
            Part::Folded(_, body) => body.into_figures(),
        });
        figures.flatten().collect()
    }
}

impl From<Markup> for Body {
    fn from(markup: Markup) -> Self {
        Self(vec![Part::Prose(markup)])
    }
}
