//! Figures: drawn, well-formed, the same on the page and in files, with their numbers.

use std::collections::BTreeSet;

use inhand_model::{Evaluation, EvaluationRows, Finger, PerFinger};
use inhand_report::{Figure, FigureValues, Report, figures, html};
use roxmltree::{Document, Node};

use crate::{sample, sample_rows};

/// An evaluation from which every figure is drawn.
fn whole() -> (Evaluation, EvaluationRows) {
    let mut evaluation = sample::evaluation(true);
    evaluation.intervals = Some(sample_rows::intervals(&evaluation));
    let rows = sample_rows::rows(&evaluation, true);
    (evaluation, rows)
}

fn all() -> Vec<Figure> {
    let (evaluation, rows) = whole();
    figures(&Report {
        rows: Some(&rows),
        ..Report::new(&evaluation, &[])
    })
    .expect("the sample has figures")
}

fn figure(id: &str) -> Figure {
    all().into_iter().find(|figure| figure.id == id).expect(id)
}

fn numbers<'a>(figure: &'a Figure, column: &str) -> &'a [f64] {
    match figure.data.column(column).map(|column| &column.values) {
        Some(FigureValues::Numbers(values)) => values,
        other => panic!("{column}: {other:?}"),
    }
}

fn words<'a>(figure: &'a Figure, column: &str) -> &'a [String] {
    match figure.data.column(column).map(|column| &column.values) {
        Some(FigureValues::Words(values)) => values,
        other => panic!("{column}: {other:?}"),
    }
}

/// Shapes that stand for data.
fn is_mark(node: &Node<'_, '_>) -> bool {
    let class = node.attribute("class").unwrap_or("");
    let filled = match node.tag_name().name() {
        "path" => node
            .attribute("d")
            .is_some_and(|d| d.matches(['L', 'H', 'l']).count() > 0),
        "rect" | "line" | "circle" => true,
        _ => false,
    };
    filled && ["area", "line", "box", "point", "bar", "past"].contains(&class)
}

/// Drawings of a print file without the legend above them.
fn panels<'d, 'i>(document: &'d Document<'i>) -> Vec<Node<'d, 'i>> {
    let charts = document.root_element().children();
    let charts = charts.filter(|node| node.attribute("class") == Some("chart"));
    // Every panel has an axis or, in a graph, circles.
    let axis = |n: Node<'_, '_>| matches!(n.attribute("class"), Some("axis" | "node"));
    charts
        .filter(|chart| chart.descendants().any(axis))
        .collect()
}

/// Text of an element as a page holds it.
fn escaped(node: &Node<'_, '_>) -> String {
    let text = node.text().unwrap_or("").replace('&', "&amp;");
    text.replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[test]
fn every_figure_of_the_list_is_there() {
    let ids: Vec<&str> = all().iter().map(|figure| figure.id).collect();
    for id in [
        "error-by-method",
        "error-by-finger",
        "error-ecdf",
        "error-within-segment",
        "error-over-time",
        "differences-from-baseline",
        "three-contacts-by-tau",
        "contact-count",
        "contact-raster",
        "distance-difference",
        "corridor-coverage",
        "dictionary-objective",
    ] {
        assert!(ids.contains(&id), "{id} is missing among {ids:?}");
    }
    assert_eq!(
        ids.iter().collect::<BTreeSet<_>>().len(),
        ids.len(),
        "ids are unique"
    );
    for id in ids {
        assert!(
            id.bytes().all(|b| b.is_ascii_lowercase() || b == b'-'),
            "{id}"
        );
    }
}

#[test]
fn files_are_well_formed_and_no_figure_is_empty() {
    for figure in all() {
        let (id, svg) = (figure.id, figure.print_svg());
        let document = Document::parse(&svg).unwrap_or_else(|error| panic!("{id}: {error}"));
        let root = document.root_element();
        assert_eq!(
            root.tag_name().namespace(),
            Some("http://www.w3.org/2000/svg")
        );
        assert!(
            ["85mm", "170mm"].contains(&root.attribute("width").unwrap()),
            "{id}"
        );
        assert!(root.attribute("height").unwrap().ends_with("mm"));
        let drawn = panels(&document);
        assert!(!drawn.is_empty(), "{id}: no panel");
        for panel in drawn {
            assert!(
                panel.descendants().any(|node| is_mark(&node)),
                "{id}: an empty panel"
            );
        }
        for node in document.descendants() {
            for attribute in node.attributes() {
                let value = attribute.value();
                let number = !["aria-label", "class", "data-x-name", "data-y-name"]
                    .contains(&attribute.name());
                assert!(
                    !number || !(value.contains("NaN") || value.contains("inf")),
                    "{id}: {value}"
                );
            }
            assert!(!["script", "foreignObject", "image", "use"].contains(&node.tag_name().name()));
        }
        assert_eq!(
            svg.matches("http").count(),
            1,
            "{id} names no host but the namespace"
        );
        assert!(!svg.contains("url(") && !svg.contains("var("), "{id}");
        assert!(figure.data.rows() > 0, "{id}: no numbers");
        assert_eq!(
            figure.data.csv().lines().count(),
            figure.data.rows() + 1,
            "{id}"
        );
        assert!(
            figure.title.ends_with('.'),
            "{id}: the caption follows the title"
        );
    }
}

#[test]
fn the_page_shows_what_the_files_show() {
    let (evaluation, rows) = whole();
    let report = Report {
        rows: Some(&rows),
        ..Report::new(&evaluation, &[])
    };
    let (page, figures) = (html(&report).unwrap(), figures(&report).unwrap());
    assert_eq!(page.matches("<figure ").count(), figures.len());
    for figure in &figures {
        let from = page
            .find(&format!("id=\"figure-{}\"", figure.id))
            .expect(figure.id);
        let part = &page[from..];
        let part = &part[..part.find("</figure>").unwrap()];
        let svg = figure.print_svg();
        // Every shape of the file, letter by letter.
        let document = Document::parse(&svg).unwrap();
        let panels = panels(&document).into_iter();
        let shapes = panels.flat_map(|panel| panel.descendants().filter(Node::is_element).skip(1));
        for shape in shapes {
            let text = &svg[shape.range()];
            // Titles of panels are text of the page.
            match shape.attribute("class") {
                Some("title") => {
                    assert!(
                        part.contains(&format!(">{}</p>", escaped(&shape))),
                        "{text}"
                    );
                    continue;
                }
                Some(class) if class.starts_with("key ") => continue,
                _ => {}
            }
            let tag = &text[..=text.find('>').unwrap()];
            assert!(part.contains(tag), "{}: {tag}", figure.id);
        }
        assert_eq!(svg, figure.print_svg());
    }
    assert_eq!(page, html(&report).unwrap());
    assert!(page.len() < 1_000_000, "{}", page.len());
}

#[test]
fn names_from_files_make_no_elements() {
    let nasty = "<script>alert(1)</script>\"'&\u{0}\u{8}]]>--\u{fffe}";
    let (mut evaluation, mut rows) = whole();
    evaluation.default_method.push_str(nasty);
    evaluation.session.name = nasty.to_owned();
    evaluation.session.participant = Some(nasty.to_owned());
    evaluation.session.task = Some(nasty.to_owned());
    for method in &mut evaluation.methods {
        method.name.push_str(nasty);
    }
    for method in &mut rows.methods {
        method.name.push_str(nasty);
    }
    rows.takes[0] = nasty.to_owned();
    evaluation.intervals = Some(sample_rows::intervals(&evaluation));
    let report = Report {
        rows: Some(&rows),
        ..Report::new(&evaluation, &[])
    };
    let figures = figures(&report).unwrap();
    assert_eq!(figures.len(), all().len());
    for figure in figures {
        let svg = figure.print_svg();
        let document =
            Document::parse(&svg).unwrap_or_else(|error| panic!("{}: {error}", figure.id));
        assert!(
            document
                .descendants()
                .all(|node| node.tag_name().name() != "script")
        );
        assert!(!svg.contains("<script"));
    }
    let page = html(&report).unwrap();
    assert_eq!(page.matches("<script").count(), 1, "only the page's own");
}

#[test]
fn distributions_rise_to_all_and_name_real_errors() {
    let (_, rows) = whole();
    let figure = figure("error-ecdf");
    let (lines, errors, shares) = (
        words(&figure, "line"),
        numbers(&figure, "error_mm"),
        numbers(&figure, "share_percent"),
    );
    for method in &rows.methods {
        let mut own: Vec<f64> = (method.error_m.iter())
            .flat_map(|fingers| *fingers.as_array())
            .filter(|error| error.is_finite())
            .map(|error| 1e3 * error)
            .collect();
        own.sort_by(f64::total_cmp);
        let places: Vec<usize> = (0..lines.len())
            .filter(|&k| lines[k] == method.name)
            .collect();
        assert!(places.len() >= 100);
        for &k in &places {
            let up_to = own.iter().filter(|&&error| error <= errors[k]).count();
            assert!((shares[k] - 100.0 * up_to as f64 / own.len() as f64).abs() < 1e-9);
            assert!(
                own.binary_search_by(|error| error.total_cmp(&errors[k]))
                    .is_ok(),
                "an error that there is"
            );
        }
        assert_eq!(shares[places[places.len() - 1]], 100.0);
    }
}

#[test]
fn counts_of_contacts_are_those_of_the_rows() {
    let (_, rows) = whole();
    let figure = figure("contact-count");
    let (motions, shares) = (words(&figure, "motion"), numbers(&figure, "share_percent"));
    let recorded = rows.recorded_distance_m.as_ref().unwrap();
    let known: Vec<_> = recorded
        .iter()
        .filter(|d| d.as_array().iter().all(|d| !d.is_nan()))
        .collect();
    // The gap of one finger leaves out 20 instants.
    assert_eq!(known.len(), recorded.len() - 20);
    for fingers in 0..=5 {
        let so_many = (known.iter())
            .filter(|d| d.as_array().iter().filter(|d| d.abs() <= 0.005).count() == fingers)
            .count();
        let place = (0..motions.len())
            .filter(|&k| motions[k] == "recorded")
            .nth(fingers)
            .unwrap();
        assert!((shares[place] - 100.0 * so_many as f64 / known.len() as f64).abs() < 1e-9);
    }
    for method in &rows.methods {
        let own = (0..motions.len()).filter(|&k| motions[k] == method.name);
        assert!((own.map(|k| shares[k]).sum::<f64>() - 100.0).abs() < 1e-9);
    }
}

#[test]
fn stretches_of_contact_add_up_to_the_time_in_contact() {
    let (evaluation, rows) = whole();
    let figure = figure("contact-raster");
    let begins = numbers(&figure, "begin_s");
    let ends = numbers(&figure, "end_s");
    let (fingers, motions, states) = (
        words(&figure, "finger"),
        words(&figure, "motion"),
        words(&figure, "state"),
    );
    let seconds = |finger: &str, motion: &str, state: &str| -> f64 {
        (0..begins.len())
            .filter(|&k| fingers[k] == finger && motions[k] == motion && states[k] == state)
            .map(|k| ends[k] - begins[k])
            .sum()
    };
    let recorded = rows.recorded_distance_m.as_ref().unwrap();
    for finger in Finger::ALL {
        let samples = recorded.iter().filter(|d| d[finger].abs() <= 0.005).count();
        assert!(
            (seconds(finger.name(), "recorded", "contact") - 0.01 * samples as f64).abs() < 1e-9
        );
    }
    for motion in ["recorded", evaluation.default_method.as_str()] {
        assert!((seconds("ring", motion, "unknown") - 0.2).abs() < 1e-9);
        assert!((seconds("three_or_more", motion, "unknown") - 0.2).abs() < 1e-9);
    }
}

#[test]
fn without_rows_or_object_there_are_fewer_figures_and_no_empty_ones() {
    let ids = |evaluation: &Evaluation, rows: Option<&EvaluationRows>| -> Vec<&'static str> {
        let report = Report {
            rows,
            ..Report::new(evaluation, &[])
        };
        figures(&report)
            .unwrap()
            .iter()
            .map(|figure| figure.id)
            .collect()
    };
    let (evaluation, rows) = (
        sample::evaluation(true),
        sample_rows::rows(&sample::evaluation(true), true),
    );
    for id in [
        "error-ecdf",
        "error-over-time",
        "contact-count",
        "contact-raster",
    ] {
        assert!(
            !ids(&evaluation, None).contains(&id) && ids(&evaluation, Some(&rows)).contains(&id)
        );
    }
    let evaluation = sample::evaluation(false);
    let rows = sample_rows::rows(&evaluation, false);
    let without = ids(&evaluation, Some(&rows));
    assert!(without.contains(&"error-over-time") && !without.contains(&"contact-raster"));
    // Rows of other methods than those evaluated, or of no segment, draw nothing.
    let mut foreign = rows.clone();
    for method in &mut foreign.methods {
        method.name.push('x');
    }
    assert!(!ids(&evaluation, Some(&foreign)).contains(&"error-ecdf"));
    let mut empty = rows;
    empty.segments.clear();
    for method in &mut empty.methods {
        method.error_m.clear();
    }
    let left = ids(&evaluation, Some(&empty));
    assert!(!left.contains(&"error-ecdf") && !left.contains(&"error-over-time"));
}

/// The text of the section beside the paper.
fn beside_the_paper(evaluation: &Evaluation, settings: &str) -> Option<String> {
    let step = inhand_model::Provenance {
        tool: "inhand 0.1.0".to_owned(),
        step: "run".to_owned(),
        settings_json: settings.to_owned(),
        inputs: Vec::new(),
    };
    let page = html(&Report::new(evaluation, &[step])).expect("the sample makes a page");
    let part = &page[page.find("<summary>Published values of the paper")?..];
    Some(part[..part.find("</details>")?].to_owned())
}

#[test]
fn published_numbers_stand_beside_runs_of_their_protocol_alone() {
    let protocol = r#"{"process":{"filter":"median","window":50}}"#;
    let evaluation = sample::evaluation(true);
    let cube = beside_the_paper(&evaluation, protocol).unwrap();
    for text in ["1.2 mm", "4 of 10 000 instants", "97 %", "arXiv:2308.15153"] {
        assert!(cube.contains(text), "{text}");
    }
    let paper = evaluation
        .methods
        .iter()
        .find(|method| method.name == "paper")
        .unwrap();
    let worst = paper
        .error
        .by_finger
        .as_array()
        .iter()
        .map(|s| s.p75)
        .fold(0.0, f64::max);
    assert!(cube.contains(&format!("<td class=\"words\">{:.2} mm</td>", 1e3 * worst)));

    let mut cylinder = sample::evaluation(true);
    cylinder.session.object = Some("cylinder:0.05x0.05".to_owned());
    assert!(
        beside_the_paper(&cylinder, protocol)
            .unwrap()
            .contains("93 %")
    );

    // What differs is named, and the column is not there.
    let mut other = sample::evaluation(true);
    other.session.object = Some("cube:0.06".to_owned());
    other.session.rate_hz = 120.0;
    other.dictionary.rank = 100;
    let part = beside_the_paper(&other, r#"{"process":{"filter":"median","window":25}}"#).unwrap();
    for text in [
        "neither a cube",
        "120 Hz, not 100 Hz",
        "100 NMF primitives",
        "median of 50 samples",
    ] {
        assert!(part.contains(text), "{text}: {part}");
    }
    assert!(!part.contains("1.2 mm") && !part.contains("<table"));
    assert!(
        beside_the_paper(&evaluation, "no JSON")
            .unwrap()
            .contains("that is not known")
    );

    // Nobody compares without the published method.
    let mut without = sample::evaluation(true);
    without.methods.retain(|method| method.name != "paper");
    assert_eq!(beside_the_paper(&without, protocol), None);
}

#[test]
fn estimates_show_their_intervals() {
    let (evaluation, _) = whole();
    let page = html(&Report::new(&evaluation, &[])).unwrap();
    let own = evaluation.intervals.as_ref().unwrap().methods[0]
        .error
        .all
        .unwrap()[2];
    let [low, high] = own.interval.unwrap().map(|end| 1e3 * end);
    assert!(page.contains(&format!(
        "<td>{:.3}\n({low:.3} to {high:.3})</td>",
        1e3 * own.value
    )));
    assert!(page.contains("2000 bootstrap draws (seed 0)"));
    let figure = figure("differences-from-baseline");
    let relative = numbers(&figure, "relative_percent");
    let prior = (words(&figure, "motion")
        .iter()
        .zip(words(&figure, "measure")))
    .position(|(motion, measure)| motion == "prior" && measure == "p95");
    let errors = |name: &str| {
        evaluation
            .methods
            .iter()
            .find(|m| m.name == name)
            .unwrap()
            .error
            .all
            .p95
    };
    let expected = 100.0 * (errors("prior") / errors("hermite") - 1.0);
    assert!((relative[prior.unwrap()] - expected).abs() < 1e-9);
}

/// Numbers at the ticks of the axes of all panels, the least and the greatest.
fn ends_of_axes(evaluation: &Evaluation, id: &str) -> [f64; 2] {
    let drawn = figures(&Report::new(evaluation, &[])).expect("the sample has figures");
    let svg = (drawn.iter().find(|figure| figure.id == id).expect(id)).print_svg();
    let document = Document::parse(&svg).expect("well-formed");
    let ticks = document.descendants();
    let ticks = ticks.filter(|node| node.attribute("class") == Some("tick"));
    let ticks = ticks.filter_map(|node| node.text()?.replace('−', "-").parse::<f64>().ok());
    ticks.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], tick| {
        [low.min(tick), high.max(tick)]
    })
}

#[test]
fn an_axis_of_differences_ends_at_a_hundred_percent() {
    for (value, interval, expected) in [
        (5.0, Some([4.0, 6.0]), [0.0, 100.0]),
        (-5.0, Some([-6.0, -4.0]), [-100.0, 0.0]),
        (3.0, None, [0.0, 100.0]),
        (0.5, Some([-7.0, 8.0]), [-100.0, 100.0]),
    ] {
        let (mut evaluation, _) = whole();
        for difference in &mut evaluation.intervals.as_mut().unwrap().differences {
            let relative = difference.relative.as_mut().unwrap();
            (relative.value, relative.interval) = (value, interval);
        }
        let ends = ends_of_axes(&evaluation, "differences-from-baseline");
        assert_eq!(ends, expected, "{value} {interval:?}");
    }
}

/// The logarithmic part of the names of axes, by figure.
fn logarithmic(evaluation: &Evaluation, id: &str) -> bool {
    let drawn = figures(&Report::new(evaluation, &[])).expect("the sample has figures");
    let svg = (drawn.iter().find(|figure| figure.id == id).expect(id)).print_svg();
    svg.contains("(mm, logarithmic)")
}

#[test]
fn errors_of_one_wild_method_make_their_axes_logarithmic() {
    let (evaluation, _) = whole();
    let scaled = |factor: f64| {
        let mut evaluation = evaluation.clone();
        // Methods that are alike, but for the last one.
        let like = ["residual", "hermite"];
        evaluation
            .methods
            .retain(|method| like.contains(&method.name.as_str()));
        let wild = evaluation
            .methods
            .last_mut()
            .expect("the sample has the methods");
        let all = &mut wild.error.all;
        let mut fingers = *wild.error.by_finger.as_array();
        for s in fingers.iter_mut().chain([all]) {
            for value in [
                &mut s.p5,
                &mut s.p25,
                &mut s.p50,
                &mut s.p75,
                &mut s.p95,
                &mut s.whisker_high,
            ] {
                *value *= factor;
            }
        }
        wild.error.by_finger = PerFinger::new(fingers);
        wild.median_error_by_sample_m
            .iter_mut()
            .for_each(|m| *m *= factor);
        evaluation
    };
    for id in ["error-by-method", "error-by-finger", "error-within-segment"] {
        assert!(!logarithmic(&scaled(1.0), id), "{id}");
        assert!(logarithmic(&scaled(100.0), id), "{id}");
    }
}

#[test]
fn an_axis_of_shares_ends_at_none_and_all() {
    // Of 0.97 and all an axis of ten points would go beyond all.
    for (stated, inside) in [(0.97, 1.0), (0.03, 0.0)] {
        let (mut evaluation, _) = whole();
        for region in evaluation.methods.iter_mut().flat_map(|m| &mut m.corridors) {
            region.share_stated = stated;
            region.share_inside.all = inside;
            region.share_inside.by_finger = PerFinger::new([inside; 5]);
        }
        let [low, high] = ends_of_axes(&evaluation, "corridor-coverage");
        let end = if inside == 1.0 { high } else { low };
        assert_eq!(end, 100.0 * inside);
    }
}
