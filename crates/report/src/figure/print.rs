//! Figures as files fit for print.

use maud::{Markup, PreEscaped, html};

use super::{COLUMN, Figure, Panel, PanelTitle, Px, legend, style};
use crate::words::shortened;

/// Widths that journals take, millimetres: one column, and two with the gap between them.
const ONE_COLUMN_MM: f64 = 85.0;
const TWO_COLUMNS_MM: f64 = 170.0;
const GAP_MM: f64 = 5.0;
/// Around everything.
const EDGE_MM: f64 = 2.0;
/// User units across one column: text of 12 units prints in 2.4 mm, about 7 points.
const COLUMN_UNITS: f64 = 410.0;

/// A panel with its left and upper edge, width and height, millimetres.
type Placed<'a> = (&'a Panel, [f64; 4]);

/// The file.
pub(super) fn svg(figure: &Figure) -> String {
    let wide = figure.widest() > COLUMN;
    let columns = if wide || figure.panels.len() == 1 {
        1
    } else {
        2
    };
    let width_mm = if wide || columns == 2 {
        TWO_COLUMNS_MM
    } else {
        ONE_COLUMN_MM
    };
    let inside_mm = width_mm - 2.0 * EDGE_MM;
    let unit_mm = ONE_COLUMN_MM / COLUMN_UNITS;
    let (keys, keys_height) = legend::rows(&figure.legend, inside_mm / unit_mm);
    let keys_mm = keys_height * unit_mm;
    let top_mm = if keys_mm > 0.0 {
        EDGE_MM + keys_mm + 0.4 * GAP_MM
    } else {
        EDGE_MM
    };
    let (panels, bottom_mm) = placed(figure, columns, inside_mm, top_mm);
    let height_mm = bottom_mm + EDGE_MM;
    let markup = html! {
        svg xmlns="http://www.w3.org/2000/svg" width={ (Px(width_mm)) "mm" } height={ (Px(height_mm)) "mm" }
            viewBox={ "0 0 " (Px(width_mm)) " " (Px(height_mm)) } role="img" aria-labelledby="title desc" {
            title id="title" { (figure.title) }
            desc id="desc" { (figure.caption) }
            style { (PreEscaped(style::for_print())) }
            rect.paper x="0" y="0" width=(Px(width_mm)) height=(Px(height_mm)) {}
            @if keys_mm > 0.0 {
                svg.chart x=(Px(EDGE_MM)) y=(Px(EDGE_MM)) width=(Px(inside_mm)) height=(Px(keys_mm))
                    viewBox={ "0 0 " (Px(inside_mm / unit_mm)) " " (Px(keys_height)) } preserveAspectRatio="xMinYMin" { (keys) }
            }
            @for (panel, [x, y, width, height]) in &panels {
                @let rise = title_height(panel);
                svg.chart x=(Px(*x)) y=(Px(*y)) width=(Px(*width)) height=(Px(*height)) preserveAspectRatio="xMinYMin"
                    viewBox={ "0 " (Px(-rise)) " " (Px(panel.width)) " " (Px(panel.height + rise)) } {
                    (title(&panel.title))
                    (panel.shapes)
                }
            }
        }
    };
    let text: String = markup.into_string().chars().map(allowed_in_xml).collect();
    format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{text}\n")
}

/// Room for the title above a panel, user units.
fn title_height(panel: &Panel) -> f64 {
    if panel.title.text.is_empty() {
        0.0
    } else {
        20.0
    }
}

/// The title above a panel, whose drawing begins at zero.
fn title(title: &PanelTitle) -> Markup {
    let left = if title.swatch.is_some() { 18.0 } else { 0.0 };
    html! {
        @if let Some(class) = title.swatch {
            rect.key.(class) x="0.5" y="-17.5" width="11" height="11" rx="2" {}
        }
        @if !title.text.is_empty() {
            text.title x=(Px(left)) y="-7.5" { (shortened(&title.text, TITLE_LETTERS)) }
        }
    }
}

/// Longest title of a panel in a file.
const TITLE_LETTERS: usize = 60;

/// Panels in rows of `columns`, each as wide as its column, with the end of the last row.
fn placed(figure: &Figure, columns: usize, inside_mm: f64, top_mm: f64) -> (Vec<Placed<'_>>, f64) {
    let column_mm = (inside_mm - GAP_MM * (columns - 1) as f64) / columns as f64;
    let mut all = Vec::with_capacity(figure.panels.len());
    let mut y = top_mm;
    for row in figure.panels.chunks(columns) {
        let height_of =
            |panel: &Panel| (panel.height + title_height(panel)) * column_mm / panel.width;
        all.extend(row.iter().enumerate().map(|(place, panel)| {
            let x = EDGE_MM + (column_mm + GAP_MM) * place as f64;
            (panel, [x, y, column_mm, height_of(panel)])
        }));
        y += row.iter().map(height_of).fold(0.0, f64::max) + GAP_MM;
    }
    (all, y - GAP_MM)
}

/// XML knows no control characters, not even escaped ones; names from files may hold them.
fn allowed_in_xml(letter: char) -> char {
    match letter {
        '\t' | '\n' | '\r' => letter,
        '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => char::REPLACEMENT_CHARACTER,
        _ => letter,
    }
}
