//! Colours, once for screens in light and dark and once for paper.

/// Rules for the shapes of figures; colours in them are `var(--name)` of [`COLOURS`].
pub(crate) const SHAPES: &str = include_str!("figure.css");

/// A colour by scheme.
struct Colour {
    name: &'static str,
    light: &'static str,
    dark: &'static str,
    paper: &'static str,
}

const fn colour(
    name: &'static str,
    light: &'static str,
    dark: &'static str,
    paper: &'static str,
) -> Colour {
    Colour {
        name,
        light,
        dark,
        paper,
    }
}

/// The same in every scheme: a reader who knows the thumb's colour knows it everywhere.
const fn fixed(name: &'static str, value: &'static str) -> Colour {
    colour(name, value, value, value)
}

/// Fingers have the colours of Okabe and Ito, which people with any colour vision tell apart.
const COLOURS: [Colour; 25] = [
    colour("bg", "#ffffff", "#13171b", "#ffffff"),
    colour("panel", "#f5f7f9", "#1b2127", "#ffffff"),
    colour("ink", "#1a1f25", "#e5e9ed", "#000000"),
    colour("faint", "#59636e", "#9ba6b1", "#444c55"),
    colour("rule", "#d5dbe1", "#39424b", "#c3cad1"),
    colour("grid", "#e6eaee", "#262d34", "#e3e7eb"),
    colour("link", "#0b5cad", "#7ab8f5", "#000000"),
    colour("warn", "#9a5b00", "#f0b95a", "#7a4800"),
    colour("warn-bg", "#fdf3e1", "#2b2415", "#ffffff"),
    colour("good", "#1d6f42", "#67c08d", "#1d6f42"),
    colour("bad", "#9b2226", "#f08080", "#9b2226"),
    fixed("thumb", "#e69f00"),
    fixed("index", "#56b4e9"),
    fixed("middle", "#009e73"),
    fixed("ring", "#d55e00"),
    fixed("little", "#cc79a7"),
    colour("l0", "#0b5fb0", "#5fabf2", "#0b5fb0"),
    colour("l1", "#8a2a6b", "#df86c0", "#8a2a6b"),
    colour("l2", "#00707a", "#4fc3cd", "#00707a"),
    colour("l3", "#5b3fa8", "#a995ee", "#5b3fa8"),
    colour("b0", "#2c7a3f", "#74c487", "#2c7a3f"),
    colour("b1", "#a3741a", "#dfb15c", "#a3741a"),
    colour("b2", "#c2566a", "#f08fa0", "#c2566a"),
    colour("b3", "#737b85", "#a7afb8", "#737b85"),
    colour("b4", "#6b5a45", "#c2ae95", "#6b5a45"),
];

/// Fonts of screens.
const SCREEN_FONT: &str =
    "system-ui, -apple-system, \"Segoe UI\", Roboto, \"Helvetica Neue\", Arial, sans-serif";
/// Fonts that journals and drawing programs have.
const PAPER_FONT: &str =
    "\"Helvetica Neue\", Helvetica, Arial, \"Liberation Sans\", \"DejaVu Sans\", sans-serif";

/// Variables of the page: light, dark where the reader's system is, and for paper.
pub(crate) fn variables() -> String {
    let list = |of: fn(&Colour) -> &'static str, all: bool| -> String {
        (COLOURS.iter())
            .filter(|colour| all || colour.dark != colour.light)
            .map(|colour| format!("--{}:{};", colour.name, of(colour)))
            .collect()
    };
    format!(
        ":root{{--font:{SCREEN_FONT};{}}}\n@media (prefers-color-scheme: dark){{:root{{{}}}}}\n@media print{{:root{{{}}}}}\n",
        list(|colour| colour.light, true),
        list(|colour| colour.dark, false),
        list(|colour| colour.paper, false),
    )
}

/// The rules with their values in place, for files: few programs that draw SVG know variables.
pub(crate) fn for_print() -> String {
    let rules = SHAPES.replace("var(--font)", PAPER_FONT);
    (COLOURS.iter()).fold(rules, |rules, colour| {
        rules.replace(&format!("var(--{})", colour.name), colour.paper)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_variable_has_a_value() {
        let style = for_print();
        assert!(!style.contains("var("), "{style}");
        assert!(style.contains(".f-thumb { color: #e69f00; }"));
        // Nothing that would end a style element, whose text XML reads as text.
        assert!(!style.contains(['<', '&']));
    }
}
