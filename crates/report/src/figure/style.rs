//! Colours, once for screens in light and dark and once for paper.

/// Rules for the shapes of figures; colours in them are `var(--name)` of [`COLOURS`].
pub(crate) const SHAPES: &str = include_str!("figure.css");

/// Colours by their names: on screens in light and in dark, and on paper. Fingers have the colours of Okabe and Ito,
/// which people with any colour vision distinguish, the same in every scheme: a reader who knows the thumb's colour knows
/// it everywhere.
const COLOURS: [(&str, [&str; 3]); 24] = [
    ("bg", ["#ffffff", "#13171b", "#ffffff"]),
    ("panel", ["#f5f7f9", "#1b2127", "#ffffff"]),
    ("ink", ["#1a1f25", "#e5e9ed", "#000000"]),
    ("faint", ["#59636e", "#9ba6b1", "#444c55"]),
    ("rule", ["#d5dbe1", "#39424b", "#c3cad1"]),
    ("grid", ["#e6eaee", "#262d34", "#e3e7eb"]),
    ("link", ["#0b5cad", "#7ab8f5", "#000000"]),
    ("warn", ["#9a5b00", "#f0b95a", "#7a4800"]),
    ("warn-bg", ["#fdf3e1", "#2b2415", "#ffffff"]),
    ("good", ["#1d6f42", "#67c08d", "#1d6f42"]),
    ("thumb", ["#e69f00", "#e69f00", "#e69f00"]),
    ("index", ["#56b4e9", "#56b4e9", "#56b4e9"]),
    ("middle", ["#009e73", "#009e73", "#009e73"]),
    ("ring", ["#d55e00", "#d55e00", "#d55e00"]),
    ("little", ["#cc79a7", "#cc79a7", "#cc79a7"]),
    ("l0", ["#0b5fb0", "#5fabf2", "#0b5fb0"]),
    ("l1", ["#8a2a6b", "#df86c0", "#8a2a6b"]),
    ("l2", ["#00707a", "#4fc3cd", "#00707a"]),
    ("l3", ["#5b3fa8", "#a995ee", "#5b3fa8"]),
    ("b0", ["#2c7a3f", "#74c487", "#2c7a3f"]),
    ("b1", ["#a3741a", "#dfb15c", "#a3741a"]),
    ("b2", ["#c2566a", "#f08fa0", "#c2566a"]),
    ("b3", ["#737b85", "#a7afb8", "#737b85"]),
    ("b4", ["#6b5a45", "#c2ae95", "#6b5a45"]),
];

/// Fonts of screens.
const SCREEN_FONT: &str =
    "system-ui, -apple-system, \"Segoe UI\", Roboto, \"Helvetica Neue\", Arial, sans-serif";
/// Fonts that journals and drawing programs have.
const PAPER_FONT: &str =
    "\"Helvetica Neue\", Helvetica, Arial, \"Liberation Sans\", \"DejaVu Sans\", sans-serif";

/// Variables of the page: light, dark where the reader's system is, and for paper.
pub(crate) fn variables() -> String {
    let list = |scheme: usize| -> String {
        (COLOURS.iter())
            .filter(|(_, values)| scheme == 0 || values[1] != values[0])
            .map(|(name, values)| format!("--{name}:{};", values[scheme]))
            .collect()
    };
    let [light, dark, paper] = [0, 1, 2].map(list);
    format!(
        ":root{{--font:{SCREEN_FONT};{light}}}\n@media (prefers-color-scheme: dark){{:root{{{dark}}}}}\n@media print{{:root{{{paper}}}}}\n",
    )
}

/// The rules with their values in place, for files: few programs that draw SVG know variables.
pub(crate) fn for_print() -> String {
    let rules = SHAPES.replace("var(--font)", PAPER_FONT);
    (COLOURS.iter()).fold(rules, |rules, (name, [.., paper])| {
        rules.replace(&format!("var(--{name})"), paper)
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
