use data_encoding::BASE64;
use inhand_model::{Finding, Finger};
use inhand_report::{Report, html};
use sha2::{Digest, Sha256};

use crate::sample;

fn page() -> String {
    html(&Report::new(
        &sample::evaluation(true),
        &sample::provenance(),
    ))
    .expect("the sample makes a page")
}

/// A number in millimetres as tables print it.
fn mm(metres: f64) -> String {
    format!("{:.2}", 1e3 * metres)
}

#[test]
fn statistics_shown_are_those_given() {
    let (evaluation, page) = (sample::evaluation(true), page());
    for method in &evaluation.methods {
        let rows = std::iter::once(&method.error.all)
            .chain(method.error.by_finger.as_array())
            .chain(method.distance_difference.as_ref().unwrap().as_array());
        for s in rows {
            let cells: Vec<String> = [s.p50, s.p75, s.p95, s.max, s.mean, s.rmse, s.p5, s.p25]
                .map(|v| {
                    if v < 5e-6 {
                        "&lt; 0.01".to_owned()
                    } else {
                        mm(v)
                    }
                })
                .into();
            let plain = page.replace(" class=\"best\"", "");
            let row = format!("<td>{}</td>", cells.join("</td><td>"));
            assert!(plain.contains(&row), "{}: {row}", method.name);
        }
    }
}

#[test]
fn the_smallest_of_a_column_is_marked() {
    let page = page();
    let table = &page[page.find("Error statistics, published").unwrap()..];
    let group = &table[table.find("all fingers").unwrap()..];
    let row = |name: &str| {
        let from = &group[group.find(&format!("</span>{name}</th>")).unwrap()..];
        from[..from.find("</tr>").unwrap()].to_owned()
    };
    assert!(row("hermite").contains("<td class=\"best\">0.40</td>"));
    assert!(!row("paper").contains("best"));
}

#[test]
fn boxes_lie_where_their_numbers_say() {
    let evaluation = sample::evaluation(true);
    let page = page();
    let figure = &page[page.find("All fingers, by method").unwrap()..];
    let row = &figure[figure.find("<g class=\"row\">").unwrap()..];
    let row = &row[..row.find("text class=\"value\"").unwrap()];
    let attribute = |element: &str, name: &str| -> f64 {
        let from = &row[row.find(&format!("class=\"{element}\"")).unwrap()..];
        let from = &from[from.find(&format!(" {name}=\"")).unwrap() + name.len() + 3..];
        from[..from.find('"').unwrap()].parse().unwrap()
    };
    let s = &evaluation.methods[0].error.all;
    let (box_x, width) = (attribute("box", "x"), attribute("box", "width"));
    let median = attribute("median", "x1");
    let share = (median - box_x) / width;
    // The axis is logarithmic: the sample has a method ten times worse.
    let expected = (s.p50 / s.p25).ln() / (s.p75 / s.p25).ln();
    // Coordinates are rounded to hundredths of about ten units.
    assert!((share - expected).abs() < 2e-3, "{share} {expected}");
}

#[test]
fn names_from_files_stay_text() {
    let nasty = "<script>alert(1)</script>\"'&";
    let mut evaluation = sample::evaluation(true);
    evaluation.session.name = nasty.to_owned();
    evaluation.session.object = Some(nasty.to_owned());
    evaluation.session.train[0].name = nasty.to_owned();
    evaluation.quality[1].take = nasty.to_owned();
    evaluation.quality[1]
        .findings
        .push(Finding::warning(nasty, nasty));
    for method in &mut evaluation.methods {
        method.name = format!("{}{nasty}", method.name);
        method.description = nasty.to_owned();
    }
    evaluation.default_method.push_str(nasty);
    let mut provenance = sample::provenance();
    provenance[0].step = nasty.to_owned();
    provenance[0].tool = nasty.to_owned();
    provenance[0].inputs[0].name = nasty.to_owned();
    provenance[0].settings_json = nasty.to_owned();
    provenance[1].settings_json = serde_json::json!({ nasty: nasty }).to_string();
    let page = html(&Report::new(&evaluation, &provenance)).unwrap();
    assert_eq!(
        page.matches("<script").count(),
        1,
        "a name became an element"
    );
    assert!(!page.contains("alert(1)</script>"));
    assert!(page.matches("&lt;script&gt;").count() > 20);
    // No attribute is left early either.
    assert!(!page.contains("=\"\"'"));
}

#[test]
fn nothing_is_loaded_and_one_script_runs() {
    let page = page();
    for word in [
        "http:",
        "https:",
        "//",
        "src=",
        "@import",
        "url(",
        "<script ",
        "<link rel=\"stylesheet",
        "<iframe",
        "onclick",
        "onload",
    ] {
        assert!(!page.contains(word), "{word}");
    }
    assert!(page.contains("default-src 'none'"));
    // The policy lets the page's own script run and no other: it names its hash.
    let script = &page[page.find("<script>").unwrap() + 8..page.find("</script>").unwrap()];
    let hash = BASE64.encode(&Sha256::digest(script));
    assert!(
        page.contains(&format!("script-src &#39;sha256-{hash}&#39;"))
            || page.contains(&format!("script-src 'sha256-{hash}'")),
        "the policy has to name sha256-{hash}"
    );
    // Links go to places on the page that exist.
    for link in page.split("href=\"").skip(1) {
        let target = link.split('"').next().unwrap();
        assert!(
            target == "data:," || page.contains(&format!("id=\"{}\"", &target[1..])),
            "{target}"
        );
    }
}

#[test]
fn the_page_is_the_same_each_time_and_small() {
    let first = page();
    assert_eq!(first, page());
    assert!(first.len() < 500_000, "{}", first.len());
    assert!(
        !first.contains("NaN") && !first.contains("inf\""),
        "a number that is none was drawn"
    );
}

#[test]
fn tags_are_closed() {
    let page = page();
    for tag in [
        "svg", "g", "table", "tbody", "tr", "td", "th", "div", "section", "figure", "details",
        "dl", "ul", "text", "path",
    ] {
        let open =
            page.matches(&format!("<{tag} ")).count() + page.matches(&format!("<{tag}>")).count();
        assert_eq!(open, page.matches(&format!("</{tag}>")).count(), "{tag}");
    }
}

#[test]
fn fingers_have_their_colour_in_every_scheme() {
    let page = page();
    for colour in ["#e69f00", "#56b4e9", "#009e73", "#d55e00", "#cc79a7"] {
        assert_eq!(
            page.matches(colour).count(),
            1,
            "{colour} is set once and never changed"
        );
    }
    for finger in Finger::ALL {
        assert!(page.contains(&format!("f-{finger}")));
    }
    assert!(page.contains("prefers-color-scheme: dark") && page.contains("@media print"));
}

/// The text of every cell of every row of every table.
pub(crate) fn rows(page: &str) -> Vec<Vec<String>> {
    let cells = |row: &str| {
        row.split("</th>")
            .flat_map(|part| part.split("</td>"))
            .map(text)
            .collect::<Vec<_>>()
    };
    page.split("<tr")
        .skip(1)
        .map(|part| cells(part.split("</tr>").next().unwrap_or(part)))
        .collect()
}

/// Text outside of tags.
pub(crate) fn text(html: &str) -> String {
    let (mut text, mut inside) = (String::new(), false);
    // The first tag is cut open by the split at its name.
    for letter in html.split_once('>').map_or(html, |(_, rest)| rest).chars() {
        match letter {
            '<' => inside = true,
            '>' => inside = false,
            _ if !inside => text.push(letter),
            _ => {}
        }
    }
    text.replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace('\u{202f}', " ")
}

#[test]
fn every_table_shows_what_was_given() {
    let rows = rows(&page());
    for expected in [
        // Takes, gaps.
        "cube_01|train|120.0|12 000|114|5|ring|99.8|100.0|1",
        "cube_01|train|ring|252|2.1|80|172|0.31",
        "cube_01|train|little|31|0.3|31|0|0.06",
        // Methods.
        "prior|start + end, NMF 200|yes|higher · higher · lower · higher",
        // Contacts: recorded, planned.
        "recorded|> 99.9|100.0|97.5|95.0|92.5|90.0|11 900|23|0",
        "prior|99.1|99.1|96.1|93.2|90.2|87.2|11 900|23|0",
        // Constraints at a glance, reach, collisions, plans.
        "prior|99.2|3.20|2 of 11 900|9.31|0 of 176 715|1.000|0 of 119|3.1e-9",
        "hermite|99.2|3.20|3 of 11 900|9.31|12 of 176 715|1.134|–|–",
        "recorded|99.8|99.5|99.2|98.9|98.6||||||11 900",
        "prior|> 99.9|99.6|99.2|98.8|98.4|0.00|0.80|1.60|2.40|3.20|11 900",
        "recorded|2||9.58||11 900",
        "line|3|1|9.31|ring, little|11 900",
        "paper|119|0|0|4|0|3.1e-9|9 of 119",
        // Families of constraints: with room, at the bound, within rounding.
        "acceleration|0 of 119|satisfied (margin 410.00 mm/s²)",
        "distance between fingertips|2 of 119|satisfied exactly",
        "velocity|4 of 119|2.0e-9 mm/s",
        // Prediction regions by stated share, the object, the choice, the deviation.
        "residual|1.61|52.0|53.0|52.5|52.0|51.5|51.0|59 500|119|0",
        "prior|3.02|90.1|91.1|90.6|90.1|89.6|89.1|59 500|119|0",
        "residual|0.32|0.67|2.25|9.03|0.46|0.95|3.22|12.93|11 900|23|0",
        "hermite|0.727|590",
        "whole hand|0.36|2|mean of the demonstrations in which all fingers had similar boundary conditions",
        // Velocity bounds.
        "index|-240.0|260.0|-250.0|270.0|-260.0|280.0",
    ] {
        assert!(
            rows.iter()
                .any(|row| row.join("|").trim_end_matches('|') == expected.trim_end_matches('|')),
            "{expected}"
        );
    }
}

#[test]
fn facts_of_the_dictionary_and_the_steps_are_shown() {
    let page = page().replace('\u{202f}', " ");
    for words in [
        "200 primitives by non-negative matrix factorisation from 590 training segments",
        "stopped at its limit of 40 iterations, before it converged",
        "0.143 mm root mean square",
        "relative error 0.3 %",
        "Objective after each iteration",
        "inhand 0.1.0, 6 inputs",
        "\"window\": 50",
        "a finger",
        "n = 59 500 for each method",
        "n = 11 900 for each box",
    ] {
        let escaped = words.replace('"', "&quot;");
        assert!(page.contains(&escaped), "{words}");
    }
    for step in sample::provenance() {
        for input in step.inputs {
            assert!(page.contains(&input.sha256));
        }
    }
}
