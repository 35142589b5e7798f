//! Figures: one value is what the page shows, what a print-fit SVG file shows, and the data behind both.
//!
//! A [`Figure`] is made of panels, each drawn in SVG user units for a column of about 360 to 480 pixels so
//! that its text keeps its size on a phone; wider pages show several side by side. Drawings hold no
//! colours, no ids and no scripts: classes say what a shape is (`line`, `box`, `grid`) and whose it is
//! (`f-thumb`, `l0`), and one style sheet (`figure/figure.css`) colours them, by the reader's light or dark scheme on
//! the page and for white paper in a file. Coordinates are rounded to hundredths: the bytes
//! depend on the data alone.

pub(crate) mod axes;
pub(crate) mod box_plot;
mod data;
pub(crate) mod legend;
pub(crate) mod line_chart;
mod palette;
mod print;
pub(crate) mod projection;
pub(crate) mod row_plot;
pub(crate) mod scale;
pub(crate) mod state_graph;
pub(crate) mod strips;
pub(crate) mod style;

use std::fmt;

use maud::{Markup, html};

pub use data::{FigureColumn, FigureData, FigureValues};
pub(crate) use legend::{Key, finger_keys};
pub(crate) use palette::{PLAIN_CLASS, RECORDED_CLASS, classes, finger_class};

/// A figure of a report: its drawing, its caption, and the numbers that are drawn.
///
/// The page and [`Figure::print_svg`] show the very same drawing.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Name for files and links, lower-case letters, digits and hyphens, such as `error-by-finger`.
    pub id: &'static str,
    /// Title, in a line.
    pub title: String,
    /// Definitions, counts, what is cut off. Plain text.
    pub caption: String,
    /// Every number that is drawn.
    pub data: FigureData,
    /// Lines and swatches explained above the panels.
    pub(crate) legend: Vec<Key>,
    /// Drawings from left to right, row after row.
    pub(crate) panels: Vec<Panel>,
}

/// A drawing: the content of an `svg` element, with its size.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    /// Title above the drawing, with the class of a swatch before it; empty where the figure's own says it all.
    pub(crate) title: PanelTitle,
    /// Size in SVG user units, which are pixels of the page where there is room.
    pub(crate) width: f64,
    /// As the width.
    pub(crate) height: f64,
    /// Description for readers who do not see it.
    pub(crate) summary: String,
    /// Shapes and texts.
    pub(crate) shapes: Markup,
}

/// Title of a panel, and the class of a swatch before it.
#[derive(Clone, Debug, Default)]
pub(crate) struct PanelTitle {
    text: String,
    swatch: Option<&'static str>,
}

impl<T: Into<String>> From<T> for PanelTitle {
    fn from(text: T) -> Self {
        let text = text.into();
        Self { text, swatch: None }
    }
}

impl PanelTitle {
    /// The title with a swatch before it.
    pub(crate) fn swatch(self, class: Option<&'static str>) -> Self {
        Self {
            swatch: class,
            ..self
        }
    }
}

/// Panels wider than this are shown two in a row on a page, narrower ones three.
const NARROW: f64 = 400.0;
/// Panels wider than this take the whole width of a page or of two columns in print.
const COLUMN: f64 = 520.0;

impl Figure {
    /// The figure as an SVG file of its own for print: light colours on white, width and height in
    /// millimetres (85 for one column, 170 for two), its style inside, nothing loaded, well-formed XML
    /// whatever names from files hold. Same figure, same bytes.
    pub fn print_svg(&self) -> String {
        print::svg(self)
    }

    /// The figure on the page.
    pub(crate) fn embed(&self) -> Markup {
        let width = self.widest();
        let class = if width > COLUMN {
            "panels page"
        } else if width > NARROW {
            "panels wide"
        } else {
            "panels"
        };
        html! {
            figure id={ "figure-" (self.id) } class=(class) {
                @for panel in &self.panels {
                    div.panel {
                        (panel.title.embed())
                        @if width > COLUMN {
                            div.scroll tabindex="0" role="region" aria-label=(self.title) { (panel.embed()) }
                        } @else {
                            (panel.embed())
                        }
                    }
                }
                figcaption.full[self.panels.len() > 1 || width > COLUMN] {
                    (legend::list(&self.legend))
                    b { (self.title) } " " (self.caption) " "
                    a.file href={ "#figure-" (self.id) } { (self.id) }
                }
            }
        }
    }

    fn widest(&self) -> f64 {
        (self.panels.iter())
            .map(|panel| panel.width)
            .fold(0.0, f64::max)
    }
}

impl PanelTitle {
    fn embed(&self) -> Markup {
        html! {
            @if !self.text.is_empty() {
                p.heading {
                    @if let Some(class) = self.swatch { span.swatch.(class) {} }
                    (self.text)
                }
            }
        }
    }
}

impl Panel {
    fn embed(&self) -> Markup {
        html! {
            svg.chart viewBox={ "0 0 " (Px(self.width)) " " (Px(self.height)) } role="img" aria-label=(self.summary) { (self.shapes) }
        }
    }
}

/// A coordinate in SVG user units, printed with at most two decimals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Px(pub(crate) f64);

impl fmt::Display for Px {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hundredths = (self.0 * 100.0).round() / 100.0;
        // Adding zero turns the negative zero into the positive one.
        write!(f, "{}", hundredths + 0.0)
    }
}

/// The part of a figure inside the axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) right: f64,
    pub(crate) bottom: f64,
}

impl Frame {
    /// The frame from left to right and from top to bottom.
    pub(crate) const fn new([left, right]: [f64; 2], [top, bottom]: [f64; 2]) -> Self {
        Self {
            left,
            top,
            right,
            bottom,
        }
    }

    pub(crate) fn width(&self) -> f64 {
        self.right - self.left
    }

    pub(crate) fn height(&self) -> f64 {
        self.bottom - self.top
    }

    /// A line from top to bottom that marks the value at `x`.
    pub(crate) fn mark(&self, x: f64) -> Markup {
        html! { line.mark x1=(Px(x)) y1=(Px(self.top)) x2=(Px(x)) y2=(Px(self.bottom)) {} }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_short_and_never_negative_zero() {
        for (value, text) in [(1.0, "1"), (0.126, "0.13"), (-0.001, "0"), (12.5, "12.5")] {
            assert_eq!(Px(value).to_string(), text);
        }
    }
}
