//! Fingertips on the object: distances and contacts, planned beside recorded.

use inhand_model::{ContactShare, Finger, PerFinger, Statistics, TauShare};
use maud::{Markup, html};

use super::errors::{BOX_WORDS, cut_words, finger_boxes, finger_sizes, row};
use super::session::name;
use super::statistics::finger_table;
use super::table::{Line, numbers, table, words};
use super::{Body, Method, contact_count, contact_raster};
use crate::figure::box_plot::{self, BoxPlot, cut_off, shared_end_mm};
use crate::figure::line_chart::{self, AxisSpec, LineChart, Series};
use crate::figure::palette::{RECORDED_CLASS, finger_class};
use crate::figure::{Figure, Key};
use crate::number::{NARROW_SPACE, NONE, count, percent, plain, to_mm};
use crate::report::Report;

/// The section's content.
pub(super) fn section(report: &Report<'_>, methods: &[Method<'_>]) -> Body {
    let contacts: Vec<(&Method<'_>, &ContactShare)> = methods
        .iter()
        .filter_map(|method| Some((method, method.evaluation.contact.as_ref()?)))
        .collect();
    let differences: Vec<Differences<'_, '_>> = methods
        .iter()
        .filter_map(|method| Some((method, method.evaluation.distance_difference.as_ref()?)))
        .collect();
    let mut body = Body::default();
    if contacts.is_empty() && differences.is_empty() {
        body.prose(html! {
            p {
                "Contacts were not judged: they need the object's pose in the test takes and its shape \
                 (for example " code { "--object cube:0.05" } ")."
            }
        });
    }
    if let Some((_, first)) = contacts.first() {
        body.prose(html! {
            p {
                "A fingertip is in contact when its distance to the object's surface is at most "
                (plain(to_mm(first.tau_m))) " mm, from outside or inside; one deeper inside the object than that is not in contact. \
                 The threshold is a choice: the figure shows what another one would have given. \
                 A grasp counts as stable with three fingertips in contact."
            }
            (share_table(&contacts))
        });
        body.figure(by_threshold(&contacts));
        if let Some(rows) = report.rows {
            body.figure(contact_count::figure(rows, methods, first.tau_m))
                .figure(contact_raster::figure(rows, methods, first.tau_m));
        }
    }
    if !differences.is_empty() {
        body.append(difference_part(&differences));
    }
    body
}

/// Largest distance that counts as contact, metres; `None` where contacts were not judged.
pub(super) fn tau_m(methods: &[Method<'_>]) -> Option<f64> {
    let contacts = methods
        .iter()
        .filter_map(|method| method.evaluation.contact.as_ref());
    contacts.map(|contact| contact.tau_m).next()
}

/// A method with its differences of distances.
type Differences<'a, 'b> = (&'a Method<'b>, &'b PerFinger<Statistics>);

fn share_table(contacts: &[(&Method<'_>, &ContactShare)]) -> Markup {
    let mut columns = vec![
        words("motion"),
        numbers("n", ""),
        numbers("filled", ""),
        numbers("left out", ""),
        numbers("three or more", "%"),
    ];
    columns.extend(Finger::ALL.map(|finger| numbers(finger.name(), "%")));
    let share = |contact: &ContactShare, value: f64| {
        if contact.n == 0 {
            NONE.to_owned()
        } else {
            percent(value)
        }
    };
    let cells = |contact: &ContactShare, three: f64, fingers: &PerFinger<f64>| -> Vec<String> {
        [contact.n, contact.n_filled, contact.n_left_out]
            .map(|n| count(n, NARROW_SPACE))
            .into_iter()
            .chain([share(contact, three)])
            .chain(fingers.as_array().map(|value| share(contact, value)))
            .collect()
    };
    let mut lines = Vec::new();
    // The recorded motion is the same for every method unless some plans are missing.
    for (place, (method, contact)) in contacts.iter().enumerate() {
        let seen = contacts[..place]
            .iter()
            .any(|(_, other)| same_recorded(other, contact));
        if !seen {
            let others = contacts
                .iter()
                .all(|(_, other)| same_recorded(other, contact));
            lines.push(Line {
                head: html! {
                    span.swatch.(RECORDED_CLASS) {} "recorded"
                    @if !others { " (instants of " (method.evaluation.name) ")" }
                },
                cells: cells(
                    contact,
                    contact.recorded_three_or_more,
                    &contact.recorded_by_finger,
                ),
                best: Vec::new(),
                stressed: false,
            });
        }
        lines.push(Line {
            head: name(method),
            cells: cells(contact, contact.three_or_more, &contact.by_finger),
            best: Vec::new(),
            stressed: method.default,
        });
    }
    html! {
        (table("Share of instants in contact, planned and recorded", &columns, lines))
        p.note { "n: instants judged, those with a tracked object. Filled: those among them at which a fingertip or the object rests on an interpolated sample. Left out: object not tracked, a gap, or a plan that failed. A finger more often in contact than recorded is off the recorded motion just as one less often is." }
    }
}

fn same_recorded(a: &ContactShare, b: &ContactShare) -> bool {
    a.n == b.n
        && a.recorded_three_or_more == b.recorded_three_or_more
        && a.recorded_by_finger == b.recorded_by_finger
}

/// `None` where nothing was judged at any threshold.
fn by_threshold(contacts: &[(&Method<'_>, &ContactShare)]) -> Option<Figure> {
    let judged: Vec<_> = contacts
        .iter()
        .filter(|(_, c)| c.n > 0 && !c.by_tau.is_empty())
        .collect();
    let (_, first) = judged.first()?;
    let series: Vec<Series> = judged
        .iter()
        .map(|(method, contact)| curve(&method.evaluation.name, &method.class, contact, false))
        .chain([curve("recorded", RECORDED_CLASS, first, true)])
        .collect();
    let widest = first
        .by_tau
        .iter()
        .map(|at| to_mm(at.tau_m))
        .fold(0.0, f64::max);
    let chart = |title: &str, low: f64| {
        line_chart::draw(&LineChart {
            title,
            x: AxisSpec::linear("contact threshold tau (mm)", 0.0, widest),
            y: AxisSpec::linear("share of instants (%)", low, 100.0),
            series: series.clone(),
            dots: true,
            marked_x: Some((
                to_mm(first.tau_m),
                format!("used: {} mm", plain(to_mm(first.tau_m))),
            )),
        })
    };
    let mut panels = vec![chart("Three or more fingertips in contact", 0.0)];
    let mut caption = format!(
        "n = {} instants. Where the lines are steep at the threshold used, the share says more about the threshold \
         than about the motion.",
        count(first.n, NARROW_SPACE)
    );
    let default = judged.iter().find(|(method, _)| method.default);
    if let Some(low) = enlarged_from(default.map(|(_, contact)| *contact)) {
        panels.push(chart("The same, upper part enlarged", low));
        caption.push_str(&format!(
            " The second axis starts at {} %, not at zero; lines that leave it at the bottom are cut.",
            plain(low)
        ));
    }
    let keys = judged
        .iter()
        .map(|(method, _)| Key::line(&method.evaluation.name, &method.class));
    Some(Figure {
        id: "three-contacts-by-tau",
        title: "Share of instants with three or more fingertips in contact against the threshold."
            .to_owned(),
        caption,
        data: line_chart::data("tau_mm", "share_percent", &series),
        legend: std::iter::once(Key::line("recorded", RECORDED_CLASS))
            .chain(keys)
            .collect(),
        panels,
    })
}

fn curve(label: &str, class: &str, contact: &ContactShare, recorded: bool) -> Series {
    let share = |at: &TauShare| match recorded {
        true => at.recorded_three_or_more,
        false => at.three_or_more,
    };
    Series {
        label: label.to_owned(),
        class: class.to_owned(),
        points: contact
            .by_tau
            .iter()
            .map(|at| (to_mm(at.tau_m), 100.0 * share(at)))
            .collect(),
    }
}

/// Shares from here up are drawn a second time where they crowd under 100 %.
const CROWDED_FROM: f64 = 0.8;

/// Where an axis starts that has room for the default method at the threshold used, in percent.
fn enlarged_from(contact: Option<&ContactShare>) -> Option<f64> {
    let contact = contact?;
    let lowest = contact.three_or_more.min(contact.recorded_three_or_more);
    (CROWDED_FROM..1.0).contains(&lowest).then(|| {
        // Twice as far down as the share is below all, on a whole percent.
        (100.0 - 2.0 * 100.0 * (1.0 - lowest)).floor()
    })
}

fn difference_part(differences: &[Differences<'_, '_>]) -> Body {
    let owners: Vec<Method<'_>> = differences
        .iter()
        .map(|(method, _)| (*method).clone())
        .collect();
    let distributions: Vec<_> = differences
        .iter()
        .map(|(_, fingers)| fingers.as_array())
        .collect();
    let mut body = Body::from(html! { h3 { "Distance to the object, planned against recorded" } });
    let caption = "Difference of distances to the object, absolute";
    let table = finger_table(caption, &owners, &distributions, true);
    body.figure(difference_figure(differences))
        .folded("Statistics of the distance difference", table.into());
    body
}

fn difference_figure(differences: &[Differences<'_, '_>]) -> Figure {
    let all = || {
        differences
            .iter()
            .flat_map(|(_, fingers)| fingers.as_array())
    };
    let end_mm = shared_end_mm(all());
    let panel = |finger: Finger| {
        box_plot::draw(&BoxPlot {
            title: finger.name(),
            swatch: Some(finger_class(finger)),
            axis_name: "difference of distances (mm)",
            end_mm,
            rows: differences
                .iter()
                .map(|(method, fingers)| row(method, &fingers[finger]))
                .collect(),
        })
    };
    Figure {
        id: "distance-difference",
        title: "Absolute difference between the planned and the recorded distance of a fingertip to the object's surface."
            .to_owned(),
        caption: format!(
            "Neither counts on which side of the surface the fingertip is. {BOX_WORDS} {} {}",
            finger_sizes(differences.iter().map(|(_, fingers)| fingers.as_array())),
            cut_words(cut_off(all(), end_mm), end_mm)
        ),
        data: box_plot::data(differences.iter().flat_map(|(method, fingers)| finger_boxes(method, fingers))),
        legend: Vec::new(),
        panels: Finger::ALL.map(panel).into(),
    }
}
