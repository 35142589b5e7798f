//! Legend of lines and swatches.

use inhand_model::Finger;
use maud::{Markup, html};

use super::{Px, finger_class};
use crate::words::shortened;

/// An entry of a legend.
#[derive(Clone, Debug)]
pub(crate) struct Key {
    /// Name.
    pub(crate) label: String,
    /// Class of its colour.
    pub(crate) class: String,
    /// Whether it is a filled shape in the figure, not a line.
    pub(crate) area: bool,
}

impl Key {
    /// An entry for a line, dashed as in the figure.
    pub(crate) fn line(label: impl Into<String>, class: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            class: class.into(),
            area: false,
        }
    }

    /// An entry for a filled shape.
    pub(crate) fn area(label: impl Into<String>, class: impl Into<String>) -> Self {
        Self {
            area: true,
            ..Self::line(label, class)
        }
    }

    fn mark_width(&self) -> f64 {
        if self.area { 10.0 } else { 30.0 }
    }

    /// The mark alone, 8 units high.
    fn shape(&self) -> Markup {
        html! {
            g.(self.class) {
                @if self.area {
                    rect.key x="0.5" y="-0.5" width="9" height="9" rx="1.5" {}
                } @else {
                    path.line d="M1 4L29 4" {}
                }
            }
        }
    }
}

/// An entry for each finger.
pub(crate) fn finger_keys(key: fn(&'static str, &'static str) -> Key) -> Vec<Key> {
    let keys = Finger::ALL.map(|finger| key(finger.name(), finger_class(finger)));
    keys.into()
}

/// A list for the page.
pub(super) fn list(keys: &[Key]) -> Markup {
    html! {
        @if !keys.is_empty() {
            ul.legend {
                @for key in keys {
                    @let width = key.mark_width();
                    li {
                        svg viewBox={ "0 0 " (Px(width)) " 8" } width=(Px(width)) height="8" aria-hidden="true" { (key.shape()) }
                        (key.label)
                    }
                }
            }
        }
    }
}

/// Width of a letter at the figure's text size, generous enough for most fonts.
const LETTER_WIDTH: f64 = 6.6;
const ROW_HEIGHT: f64 = 18.0;
const MARK_GAP: f64 = 6.0;
const ENTRY_GAP: f64 = 18.0;
const LETTERS: usize = 40;

/// Rows of entries `width` units wide, with their height, for a file.
pub(super) fn rows(keys: &[Key], width: f64) -> (Markup, f64) {
    let mut placed = Vec::with_capacity(keys.len());
    let (mut x, mut row) = (0.0, 0);
    for key in keys {
        let label = shortened(&key.label, LETTERS);
        let own = key.mark_width() + MARK_GAP + LETTER_WIDTH * label.chars().count() as f64;
        if x > 0.0 && x + own > width {
            (x, row) = (0.0, row + 1);
        }
        placed.push((key, label, x, ROW_HEIGHT * f64::from(row)));
        x += own + ENTRY_GAP;
    }
    let height = if keys.is_empty() {
        0.0
    } else {
        ROW_HEIGHT * f64::from(row + 1)
    };
    let shapes = html! {
        @for (key, label, x, y) in placed {
            g transform={ "translate(" (Px(x)) " " (Px(y + 5.0)) ")" } { (key.shape()) }
            text x=(Px(x + key.mark_width() + MARK_GAP)) y=(Px(y + 13.0)) { (label) }
        }
    };
    (shapes, height)
}
