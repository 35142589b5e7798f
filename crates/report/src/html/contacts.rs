//! Fingertips on the object: distances and contacts, planned beside recorded.

use inhand_model::{ContactShare, Finger, PerFinger, Statistics};
use maud::{Markup, html};

use super::errors::{BOX_WORDS, cut_words, finger_sizes, row};
use super::session::name;
use super::statistics::finger_table;
use super::table::{Line, numbers, table, words};
use super::{Method, legend};
use crate::figure::box_plot::{self, BoxPlot, cut_off, shared_end_mm};
use crate::figure::line_chart::{self, AxisSpec, LineChart, Series};
use crate::figure::palette::{RECORDED_CLASS, finger_class};
use crate::number::{NARROW_SPACE, NONE, count, percent, plain, to_mm};

/// The section's content.
pub(super) fn section(methods: &[Method<'_>]) -> Markup {
    let contacts: Vec<(&Method<'_>, &ContactShare)> = methods
        .iter()
        .filter_map(|method| Some((method, method.evaluation.contact.as_ref()?)))
        .collect();
    let differences: Vec<(&Method<'_>, &[Statistics; Finger::COUNT])> = methods
        .iter()
        .filter_map(|method| {
            Some((
                method,
                method.evaluation.distance_difference.as_ref()?.as_array(),
            ))
        })
        .collect();
    html! {
        @if contacts.is_empty() && differences.is_empty() {
            p {
                "Contacts were not judged: they need the object's pose in the test takes and its shape \
                 (for example " code { "--object cube:0.05" } ")."
            }
        }
        @if let Some((_, first)) = contacts.first() {
            p {
                "A fingertip is in contact when its distance to the object's surface is at most "
                (plain(to_mm(first.tau_m))) " mm, from outside or inside; one deeper inside the object than that is not in contact. \
                 The threshold is a choice: the figure shows what another one would have given. \
                 A grasp counts as stable with three fingertips in contact."
            }
            (share_table(&contacts))
            (by_threshold(&contacts))
        }
        @if !differences.is_empty() { (difference_figure(&differences)) }
    }
}

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

fn by_threshold(contacts: &[(&Method<'_>, &ContactShare)]) -> Markup {
    let judged: Vec<_> = contacts
        .iter()
        .filter(|(_, c)| c.n > 0 && !c.by_tau.is_empty())
        .collect();
    let Some((_, first)) = judged.first() else {
        return html! {};
    };
    let curve = |label: &str, class: &str, contact: &ContactShare, recorded: bool| Series {
        label: label.to_owned(),
        class: class.to_owned(),
        points: contact
            .by_tau
            .iter()
            .map(|at| {
                let share = if recorded {
                    at.recorded_three_or_more
                } else {
                    at.three_or_more
                };
                (to_mm(at.tau_m), 100.0 * share)
            })
            .collect(),
    };
    let series = || -> Vec<Series> {
        judged
            .iter()
            .map(|(method, contact)| curve(&method.evaluation.name, &method.class, contact, false))
            .chain([curve("recorded", RECORDED_CLASS, first, true)])
            .collect()
    };
    let entries: Vec<(&str, &str)> = std::iter::once((RECORDED_CLASS, "recorded"))
        .chain(
            judged
                .iter()
                .map(|(m, _)| (m.class.as_str(), m.evaluation.name.as_str())),
        )
        .collect();
    let widest = first
        .by_tau
        .iter()
        .map(|at| to_mm(at.tau_m))
        .fold(0.0, f64::max);
    let chart = |title: &str, low: f64| {
        line_chart::draw(&LineChart {
            title,
            x: AxisSpec {
                name: "contact threshold tau (mm)",
                low: 0.0,
                high: widest,
                log: false,
            },
            y: AxisSpec {
                name: "share of instants (%)",
                low,
                high: 100.0,
                log: false,
            },
            series: series(),
            dots: true,
            marked_x: Some((
                to_mm(first.tau_m),
                format!("used: {} mm", plain(to_mm(first.tau_m))),
            )),
        })
    };
    let enlarged = enlarged_from(
        judged
            .iter()
            .find(|(m, _)| m.default)
            .map(|(_, contact)| *contact),
    );
    html! {
        figure.panels.wide {
            (chart("Three or more fingertips in contact", 0.0))
            @if let Some(low) = enlarged { (chart("The same, upper part enlarged", low)) }
            figcaption.full[enlarged.is_some()] {
                (legend(&entries))
                b { "Share of instants with three or more fingertips in contact against the threshold." }
                " n = " (count(first.n, NARROW_SPACE)) " instants. Where the lines are steep at the threshold used, the share says more about \
                 the threshold than about the motion."
                @if let Some(low) = enlarged {
                    " The second axis starts at " (plain(low)) " %, not at zero; lines that leave it at the bottom are cut."
                }
            }
        }
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

fn difference_figure(differences: &[(&Method<'_>, &[Statistics; Finger::COUNT])]) -> Markup {
    let all = || differences.iter().flat_map(|(_, fingers)| fingers.iter());
    let owners: Vec<Method<'_>> = differences
        .iter()
        .map(|(method, _)| (*method).clone())
        .collect();
    let distributions: Vec<_> = differences.iter().map(|(_, fingers)| *fingers).collect();
    let end_mm = shared_end_mm(all());
    html! {
        h3 { "Distance to the object, planned against recorded" }
        figure.panels {
            @for finger in Finger::ALL {
                (box_plot::draw(&BoxPlot {
                    title: finger.name(),
                    swatch: Some(finger_class(finger)),
                    axis_name: "difference of distances (mm)",
                    end_mm,
                    rows: differences
                        .iter()
                        .map(|(method, fingers)| row(method, &fingers[finger.index()]))
                        .collect(),
                }))
            }
            figcaption {
                b { "Absolute difference between the planned and the recorded distance of a fingertip to the object's surface." }
                " Neither counts on which side of the surface the fingertip is. " (BOX_WORDS) " "
                (finger_sizes(differences.iter().map(|(_, fingers)| *fingers)))
                " " (cut_words(cut_off(all(), end_mm), end_mm))
            }
        }
        details {
            summary { "Statistics of the distance difference" }
            (finger_table("Difference of distances to the object, absolute", &owners, &distributions, true))
        }
    }
}
