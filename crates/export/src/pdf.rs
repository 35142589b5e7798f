//! Drawings as PDF files: shapes as shapes and texts as texts, with the sizes and colours of the SVG they are made of.
//!
//! Only what figures of reports hold is drawn: groups, nested `svg`, rectangles, lines, circles, paths and texts, styled by classes of a
//! `style` element and measured in millimetres. Texts are set in Helvetica, one of the fonts that every reader of PDF has: nothing is
//! embedded, and the bytes depend on the drawing alone. Letters that it lacks become question marks.

mod helvetica;

use std::collections::{BTreeMap, HashMap};
use std::fmt::{self, Write as _};

use roxmltree::{Document, Node};

/// The drawing as a file of one page of the same size; `svg` is well-formed XML, else the page is empty.
pub fn pdf_of_svg(svg: &str) -> String {
    let document = Document::parse(svg);
    let root = document.as_ref().map(Document::root_element);
    let mut page = Page::default();
    let mut title = "";
    if let Ok(root) = root {
        let text = |tag| {
            root.children()
                .find(|node| node.has_tag_name(tag))
                .and_then(|node| node.text())
        };
        let tag = |tag| text(("http://www.w3.org/2000/svg", tag)).unwrap_or("");
        title = tag("title");
        page.rules = rules(tag("style"));
        let view_box = root.attribute("viewBox").and_then(numbers::<4>);
        let [.., wide, high] = view_box.unwrap_or_default();
        page.size = [wide, high].map(|mm| mm * POINTS_PER_MM);
        let view = View {
            scale: POINTS_PER_MM,
            origin: [0.0; 2],
        };
        page.children(&root, view, 0);
    }
    file(&page, title)
}

const POINTS_PER_MM: f64 = 72.0 / 25.4;

/// A number of a file, rounded to hundredths.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Adding zero turns the negative zero into the positive one.
        write!(f, "{}", (self.0 * 100.0).round() / 100.0 + 0.0)
    }
}

/// A coordinate system of the drawing: points a unit, and its origin in points from the upper left corner.
#[derive(Clone, Copy)]
struct View {
    scale: f64,
    origin: [f64; 2],
}

impl View {
    fn moved(self, by: [f64; 2]) -> Self {
        let origin = [0, 1].map(|axis| self.origin[axis] + self.scale * by[axis]);
        Self { origin, ..self }
    }
}

/// Selectors of a rule, outermost first, and the properties that it sets.
type Rule<'a> = (Vec<&'a str>, Vec<(&'a str, &'a str)>);

/// An element's style: tags and classes from the outermost element to it, and its properties.
#[derive(Clone, Default)]
struct Style<'a> {
    chain: Vec<Vec<&'a str>>,
    properties: BTreeMap<&'a str, &'a str>,
}

impl Style<'_> {
    fn number(&self, name: &str, usual: f64) -> f64 {
        let value = self
            .properties
            .get(name)
            .and_then(|text| text.trim_end_matches("px").parse().ok());
        value.unwrap_or(usual)
    }

    /// A colour as operands; `None` where nothing is drawn.
    fn colour(&self, name: &str, usual: &str) -> Option<String> {
        let value = match self.properties.get(name).copied().unwrap_or(usual) {
            "none" => return None,
            "currentColor" => self.properties.get("color").copied().unwrap_or(""),
            value => value,
        };
        let part = |at: usize| {
            value
                .get(at..at + 2)
                .and_then(|hex| u8::from_str_radix(hex, 16).ok())
        };
        let [red, green, blue] =
            [1, 3, 5].map(|at| Short(f64::from(part(at).unwrap_or(0)) / 255.0));
        Some(format!("{red} {green} {blue}"))
    }

    fn bold(&self) -> bool {
        self.number("font-weight", 400.0) >= 600.0
    }
}

/// Rules of a style sheet, the more specific ones later. A class is written with its dot.
fn rules(sheet: &str) -> Vec<Rule<'_>> {
    let blocks = sheet.split('}').filter_map(|block| block.split_once('{'));
    let mut rules: Vec<Rule<'_>> = blocks
        .flat_map(|(selectors, body)| {
            let set = body.split(';').filter_map(|own| own.split_once(':'));
            let set: Vec<_> = set
                .map(|(name, value)| (name.trim(), value.trim()))
                .collect();
            let selectors = selectors
                .split(',')
                .map(|own| own.split_whitespace().collect());
            selectors.map(move |own| (own, set.clone()))
        })
        .collect();
    let classes = |parts: &[&str]| parts.iter().filter(|part| part.starts_with('.')).count();
    rules.sort_by_key(|(parts, _)| (classes(parts), parts.len()));
    rules
}

/// Whether the last selector is the element at the end of the chain and the others are around it, in this order.
fn holds(selectors: &[&str], chain: &[Vec<&str>]) -> bool {
    // A tag comes before the classes.
    let is = |part: &str, names: &[&str]| match part.strip_prefix('.') {
        Some(class) => names[1..].contains(&class),
        None => names[0] == part,
    };
    let (Some((own, around)), Some((last, outer))) = (selectors.split_last(), chain.split_last())
    else {
        return false;
    };
    let mut outer = outer.iter();
    is(own, last) && around.iter().all(|part| outer.any(|names| is(part, names)))
}

/// The page while it is drawn.
#[derive(Default)]
struct Page<'a> {
    size: [f64; 2],
    rules: Vec<Rule<'a>>,
    /// Styles in use and the places of those known, by the place of the parent's and the element's own attributes.
    styles: Vec<Style<'a>>,
    known: HashMap<(usize, [&'a str; 3]), usize>,
    /// Shares of opacity in use.
    alphas: Vec<f64>,
    /// Colours and lines as they are set.
    pens: String,
    content: String,
}

fn number(node: &Node<'_, '_>, name: &str) -> f64 {
    node.attribute(name)
        .and_then(|text| text.parse().ok())
        .unwrap_or(0.0)
}

fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let values: Option<Vec<f64>> = text.split(' ').map(|part| part.parse().ok()).collect();
    values?.try_into().ok()
}

impl<'a> Page<'a> {
    /// The style of an element in one whose style has this place, worked out once for all elements that are alike.
    fn style(&mut self, parent: usize, node: &Node<'a, '_>) -> usize {
        let [class, width] =
            ["class", "stroke-width"].map(|name| node.attribute(name).unwrap_or(""));
        let own = (parent, [node.tag_name().name(), class, width]);
        if let Some(&place) = self.known.get(&own) {
            return place;
        }
        let mut style = self.styles.get(parent).cloned().unwrap_or_default();
        style.chain.push(
            [own.1[0]]
                .into_iter()
                .chain(class.split_whitespace())
                .collect(),
        );
        // The only property that is not inherited.
        style.properties.remove("overflow");
        if !width.is_empty() {
            style.properties.insert("stroke-width", width);
        }
        let set = self
            .rules
            .iter()
            .filter(|rule| holds(&rule.0, &style.chain))
            .flat_map(|rule| &rule.1);
        style.properties.extend(set.copied());
        self.styles.push(style);
        self.known.insert(own, self.styles.len() - 1);
        self.styles.len() - 1
    }

    fn children(&mut self, node: &Node<'a, '_>, view: View, style: usize) {
        node.children()
            .for_each(|child| self.draw(&child, view, style));
    }

    fn draw(&mut self, node: &Node<'a, '_>, view: View, parent: usize) {
        let tag = node.tag_name().name();
        if !node.is_element() || ["title", "desc", "style"].contains(&tag) {
            return;
        }
        let place = self.style(parent, node);
        match tag {
            "g" => {
                let shift = node
                    .attribute("transform")
                    .and_then(|text| numbers(text.strip_prefix("translate(")?.strip_suffix(')')?));
                self.children(node, view.moved(shift.unwrap_or_default()), place);
            }
            "svg" => self.nested(node, view, place),
            "text" => self.text(node, view, place),
            _ => {
                let outline = self.outline(node, view);
                self.paint(&outline, place, view.scale, tag != "line");
            }
        }
    }

    /// A shape as operators of PDF, neither filled nor stroked.
    fn outline(&self, node: &Node<'a, '_>, view: View) -> String {
        let mut pen = Pen {
            page: self.size,
            view,
            out: String::new(),
            at: [0.0; 2],
        };
        pen.shape(node);
        pen.out
    }

    fn nested(&mut self, node: &Node<'a, '_>, view: View, place: usize) {
        let [x, y, width, height] = ["x", "y", "width", "height"].map(|name| number(node, name));
        let mut inner = view.moved([x, y]);
        if let Some([left, top, wide, high]) = node.attribute("viewBox").and_then(numbers) {
            inner.scale *= (width / wide).min(height / high);
            inner = inner.moved([-left, -top]);
        }
        let cut = self.styles[place].properties.get("overflow") == Some(&"hidden");
        if cut {
            let outline = self.outline(node, view);
            let _ = writeln!(self.content, "q {outline}W n");
        }
        let before = self.pens.clone();
        self.children(node, inner, place);
        if cut {
            self.content.push_str("Q\n");
            self.pens = before;
        }
    }

    /// Sets colours and lines where they are others than before.
    fn set(&mut self, pens: String) {
        if self.pens != pens {
            self.content.push_str(&pens);
            self.pens = pens;
        }
    }

    fn paint(&mut self, outline: &str, place: usize, scale: f64, closed: bool) {
        let style = &self.styles[place];
        let share = style.number("fill-opacity", 1.0);
        let fill = style
            .colour("fill", "#000000")
            .filter(|_| closed && share > 0.0);
        let stroke = style.colour("stroke", "none");
        let mut pens = String::new();
        if let Some(colour) = &fill {
            let _ = writeln!(pens, "{colour} rg {}", opacity(&mut self.alphas, share));
        }
        if let Some(colour) = &stroke {
            let dashes = style
                .properties
                .get("stroke-dasharray")
                .copied()
                .unwrap_or("");
            let dashes = dashes
                .split(' ')
                .filter_map(|dash| dash.parse::<f64>().ok());
            let dashes: Vec<String> = dashes.map(|dash| Short(scale * dash).to_string()).collect();
            let width = Short(scale * style.number("stroke-width", 1.0));
            let _ = writeln!(pens, "{colour} RG {width} w [{}] 0 d", dashes.join(" "));
        }
        let operator = match (fill, stroke) {
            (Some(_), Some(_)) => "B",
            (Some(_), None) => "f",
            (None, Some(_)) => "S",
            (None, None) => return,
        };
        self.set(pens);
        let _ = writeln!(self.content, "{outline}{operator}");
    }

    fn text(&mut self, node: &Node<'a, '_>, view: View, place: usize) {
        let style = &self.styles[place];
        let Some(colour) = style.colour("fill", "#000000") else {
            return;
        };
        let runs = helvetica::runs(node.text().unwrap_or(""));
        let (size, font) = (
            style.number("font-size", 16.0),
            1 + usize::from(style.bold()),
        );
        let width: f64 = runs.iter().map(|run| size * run.width(style.bold())).sum();
        let before = match node.attribute("text-anchor") {
            Some("middle") => 0.5 * width,
            Some("end") => width,
            _ => 0.0,
        };
        let pens = format!("{colour} rg {}\n", opacity(&mut self.alphas, 1.0));
        self.set(pens);
        let start = [number(node, "x") - before, number(node, "y")];
        let [x, y] = on_page(self.size, view, start);
        let _ = write!(self.content, "BT {x} {y} Td");
        for run in &runs {
            let [size, rise] = [run.size, run.rise].map(|share| Short(view.scale * size * share));
            let _ = write!(
                self.content,
                " /F{font} {size} Tf {rise} Ts ({}) Tj",
                run.escaped()
            );
        }
        self.content.push_str(" ET\n");
    }
}

/// The operator for a share of opacity.
fn opacity(alphas: &mut Vec<f64>, share: f64) -> String {
    let known = alphas.iter().position(|known| *known == share);
    if known.is_none() {
        alphas.push(share);
    }
    format!("/A{} gs", known.unwrap_or(alphas.len() - 1))
}

/// A point from the lower left corner of the page.
fn on_page(page: [f64; 2], view: View, [x, y]: [f64; 2]) -> [Short; 2] {
    let [left, top] = view.moved([x, y]).origin;
    [Short(left), Short(page[1] - top)]
}

/// An outline while it is drawn.
struct Pen {
    page: [f64; 2],
    view: View,
    out: String,
    /// Place of the pen in the drawing.
    at: [f64; 2],
}

impl Pen {
    fn points(&mut self, points: &[[f64; 2]], operator: &str) {
        for &point in points {
            let [x, y] = on_page(self.page, self.view, point);
            let _ = write!(self.out, "{x} {y} ");
            self.at = point;
        }
        self.out.push_str(operator);
        self.out.push(' ');
    }

    fn lines(&mut self, points: &[[f64; 2]]) {
        for (place, &point) in points.iter().enumerate() {
            self.points(&[point], if place == 0 { "m" } else { "l" });
        }
    }

    fn shape(&mut self, node: &Node<'_, '_>) {
        let value = |name: &str| number(node, name);
        match node.tag_name().name() {
            "rect" | "svg" => {
                let ([x, y], [wide, high]) =
                    (["x", "y"].map(value), ["width", "height"].map(value));
                self.lines(&[[x, y], [x + wide, y], [x + wide, y + high], [x, y + high]]);
                self.out.push_str("h ");
            }
            "line" => self.lines(&[["x1", "y1"].map(value), ["x2", "y2"].map(value)]),
            "circle" => self.circle(["cx", "cy"].map(value), value("r")),
            _ => self.path(node.attribute("d").unwrap_or("")),
        }
    }

    /// Four curves, with the handles that come nearest to a circle.
    fn circle(&mut self, [x, y]: [f64; 2], r: f64) {
        let handle = 4.0 / 3.0 * (std::f64::consts::SQRT_2 - 1.0);
        let on = |a: f64, b: f64| [x + r * a, y + r * b];
        self.points(&[on(1.0, 0.0)], "m");
        for [a, b] in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]] {
            // From this point to the one a quarter of a turn on.
            let near = on(a - handle * b, b + handle * a);
            let far = on(-b + handle * a, a + handle * b);
            self.points(&[near, far, on(-b, a)], "c");
        }
        self.out.push_str("h ");
    }

    /// A path of the commands M, L, l, H, h, V, v, Q and z.
    fn path(&mut self, mut rest: &str) {
        while let Some(command) = rest.chars().next() {
            rest = &rest[command.len_utf8()..];
            let end = rest
                .find(|c: char| c.is_ascii_alphabetic())
                .unwrap_or(rest.len());
            let (own, after) = rest.split_at(end);
            rest = after;
            let own = own.replace('-', " -");
            let values: Vec<f64> = own
                .split_whitespace()
                .filter_map(|value| value.parse().ok())
                .collect();
            let [x, y] = self.at;
            match (command, values.as_slice()) {
                ('M', &[a, b]) => self.points(&[[a, b]], "m"),
                ('L', &[a, b]) => self.points(&[[a, b]], "l"),
                ('l', &[a, b]) => self.points(&[[x + a, y + b]], "l"),
                ('H', &[a]) => self.points(&[[a, y]], "l"),
                ('h', &[a]) => self.points(&[[x + a, y]], "l"),
                ('V', &[b]) => self.points(&[[x, b]], "l"),
                ('v', &[b]) => self.points(&[[x, y + b]], "l"),
                ('Q', &[a, b, c, d]) => {
                    let near = |from: f64, bent: f64| from + (bent - from) * 2.0 / 3.0;
                    let handles = [[near(x, a), near(y, b)], [near(c, a), near(d, b)]];
                    self.points(&[handles[0], handles[1], [c, d]], "c");
                }
                ('z', _) => self.out.push_str("h "),
                _ => {}
            }
        }
    }
}

/// Objects with their places in the file, which is ASCII alone, after its version.
fn file(page: &Page<'_>, title: &str) -> String {
    let [width, height] = page.size.map(Short);
    let alphas = page.alphas.iter().enumerate();
    let alphas: String = alphas
        .map(|(place, share)| format!("/A{place} << /ca {share} >> "))
        .collect();
    let title: String = title
        .encode_utf16()
        .map(|unit| format!("{unit:04X}"))
        .collect();
    let font =
        |name: &str| format!("<< /Type /Font /Subtype /Type1 /BaseFont /{name} /Encoding 7 0 R >>");
    let content = format!("1 j\n{}", page.content);
    let objects = [
        "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /DisplayDocTitle true >> >>"
            .to_owned(),
        "<< /Type /Pages /Kids [3 0 R] /Count 1 >>".to_owned(),
        format!(
            "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {width} {height}] /Contents 4 0 R \
             /Resources << /Font << /F1 5 0 R /F2 6 0 R >> /ExtGState << {alphas}>> >> >>"
        ),
        format!(
            "<< /Length {} >>\nstream\n{content}endstream",
            content.len()
        ),
        font("Helvetica"),
        font("Helvetica-Bold"),
        helvetica::ENCODING.to_owned(),
        format!("<< /Title <FEFF{title}> /Producer (inhand) >>"),
    ];
    let mut file = "%PDF-1.4\n".to_owned();
    let mut places = String::new();
    for (place, object) in objects.iter().enumerate() {
        let _ = writeln!(places, "{:010} 00000 n ", file.len());
        let _ = write!(file, "{} 0 obj\n{object}\nendobj\n", place + 1);
    }
    let (count, start) = (objects.len() + 1, file.len());
    let _ = write!(
        file,
        "xref\n0 {count}\n0000000000 65535 f \n{places}trailer\n<< /Size {count} /Root 1 0 R /Info 8 0 R >>\nstartxref\n{start}\n%%EOF\n"
    );
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRAWING: &str = r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 85 50">
        <title>Grün (a)</title>
        <style>svg text { font-size: 12px; fill: #000000 } svg .line { fill: none; stroke: currentColor; stroke-width: 2 }
            .b0 .line { stroke-dasharray: 7 3 } .b0 { color: #ff0000 } svg .axis { stroke: #000000 } .plot { overflow: hidden } svg .pale { fill-opacity: 0 }</style>
        <svg x="5" y="5" width="40" height="20" viewBox="0 -10 400 200">
            <svg class="plot" x="0" y="0" width="100" height="100">
                <g class="b0"><path class="line" d="M0 0L10 20l-5-5H1h2V3v4z"><title>tip</title></path></g>
            </svg>
            <rect class="pale" x="0" y="0" width="9" height="9"/><line class="axis" x1="0" y1="0" x2="9" y2="0"/>
            <text x="100" y="0" text-anchor="end">(≤ 10⁻⁷ µm)</text>
        </svg>
    </svg>"##;

    #[test]
    fn offsets_lead_to_the_objects() {
        for svg in [DRAWING, "no drawing"] {
            let file = pdf_of_svg(svg);
            assert!(file.is_ascii());
            assert!(file.starts_with("%PDF-1.4\n") && file.ends_with("%%EOF\n"));
            let start: usize = file
                .lines()
                .rev()
                .nth(1)
                .and_then(|own| own.parse().ok())
                .expect("a place");
            let mut table = file[start..].lines().skip(2);
            assert!(table.next().is_some_and(|free| free.ends_with(" 65535 f ")));
            for object in 1..=8 {
                let entry = table.next().expect("an entry");
                let place: usize = entry[..10].parse().expect("a place");
                assert!(
                    file[place..].starts_with(&format!("{object} 0 obj\n")),
                    "{entry}"
                );
                assert_eq!(entry.len(), 19);
            }
            let (_, stream) = file.split_once("/Length ").expect("a stream");
            let (length, content) = stream.split_once(" >>\nstream\n").expect("a stream");
            assert_eq!(content.find("endstream"), length.parse().ok());
        }
    }

    #[test]
    fn shapes_have_the_places_and_styles_of_the_drawing() {
        let file = pdf_of_svg(DRAWING);
        // 85 and 50 mm.
        assert!(file.contains("/MediaBox [0 0 240.94 141.73]"));
        // A unit of the inner drawing is a tenth of a millimetre; its zero is 6 mm from the top.
        assert!(
            file.contains("q 14.17 124.72 m 42.52 124.72 l 42.52 96.38 l 14.17 96.38 l h W n"),
            "{file}"
        );
        assert!(file.contains("1 0 0 RG 0.57 w [1.98 0.85] 0 d\n14.17 124.72 m 17.01 119.06 l"));
        assert!(
            !file.contains(" re") && !file.contains("tip"),
            "what cannot be seen is not drawn"
        );
        // The rule for the class `line` is not one for lines.
        assert!(file.contains("0 0 0 RG 0.28 w [] 0 d\n"));
        // Text that ends at 100 units: letters of Helvetica are known, exponents small and raised.
        assert!(file.contains("/F1 3.4 Tf 0 Ts (\\(\\002 10) Tj /F1 2.21 Tf 1.19 Ts (\\0017) Tj"));
        assert!(file.contains("( \\265m\\)) Tj ET"));
        assert!(file.contains("/Title <FEFF0047007200FC"));
    }
}
