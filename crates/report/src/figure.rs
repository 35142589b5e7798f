//! Figures as inline SVG, drawn for a page column of about 360 to 480 pixels so that their text
//! keeps its size on a phone; wider pages show several side by side. Colours are classes of the
//! page's style sheet, so a figure follows the light or dark scheme. No ids, no scripts, and
//! coordinates are rounded to hundredths: the bytes depend on the data alone.

pub(crate) mod axes;
pub(crate) mod box_plot;
pub(crate) mod dot_plot;
pub(crate) mod line_chart;
pub(crate) mod palette;
pub(crate) mod scale;

use std::fmt;

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
    pub(crate) fn width(&self) -> f64 {
        self.right - self.left
    }

    pub(crate) fn height(&self) -> f64 {
        self.bottom - self.top
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
