//! Fingertips on the object: distances and contacts, planned beside recorded.

use inhand_model::{
    ContactShare, EvaluationRows, Finger, PerFinger, PointCloud, Statistics, TauShare, in_contact,
};
use maud::html;

use super::errors::{finger_figure, finger_table};
use super::{Body, Method, contact_raster, default, dynamics, known_of, recorded};
use crate::Report;
use crate::figure::box_plot::{BOX_WORDS, MICROMETRES, axis_words};
use crate::figure::line_chart::{self, LineChart, Series};
use crate::figure::row_plot::PlotRow;
use crate::figure::scale::Scale;
use crate::figure::{
    Figure, FigureData, Frame, Key, PLAIN_CLASS, Panel, PanelTitle, Px, RECORDED_CLASS, axes,
};
use crate::table::{Head, Table, evaluated};
use crate::verdict::contact_sentence;
use crate::words::{count, join_words, percent, plain, tied, to_mm};

/// A method with its contacts.
type Contacts<'m, 'a> = (&'m Method<'a>, &'a ContactShare);

/// The section's content: a sentence, and figure and table where shares are not all of the time.
pub(super) fn section(report: &Report<'_>, methods: &[Method<'_>]) -> Body {
    let contacts = known_of(methods, |own| own.contact.as_ref());
    let differences = known_of(methods, |own| own.distance_difference.as_ref());
    let mut body = Body::default();
    if contacts.is_empty() && differences.is_empty() {
        body = body.prose(html! {
            p {
                "Contacts were not evaluated: they need the object's pose in the test takes and its shape \
                 (for example " code { "--object cube:0.05" } ")."
            }
        });
    }
    let method = default(methods);
    if let Some(sentence) = method.and_then(|own| contact_sentence(own.evaluation)) {
        body = body.prose(html! { p { (tied(&sentence)) } });
    }
    if let Some((_, first)) = contacts.first() {
        let of_rows = |figure: fn(&EvaluationRows, &[Method<'_>], f64) -> Option<Figure>| {
            report
                .rows
                .and_then(|rows| figure(rows, methods, first.tau_m))
        };
        // Always in contact, planned and recorded: no figure says more than the sentence.
        let always = default(methods).and_then(|own| own.evaluation.contact.as_ref());
        let always =
            always.is_some_and(|c| [c.three_or_more, c.recorded_three_or_more] == [1.0; 2]);
        let raster = of_rows(contact_raster::figure);
        let by_threshold = by_threshold(&contacts);
        let (best, other) = match raster.is_some() {
            true => (raster, by_threshold),
            false => (by_threshold, None),
        };
        let best = Body::default().figure(best).prose(share_table(&contacts));
        let note = html! {
            p.note { "n: instants evaluated, those with a tracked object. Filled: those among them at which a fingertip or the object rests on an interpolated sample. Left out: object not tracked, a gap, or a plan that failed. A finger more often in contact than recorded is off the recorded motion just as one less often is." }
        };
        let more = |body: Body| {
            body.figure(other)
                .figure(of_rows(contact_count))
                .prose(note)
        };
        body = match always {
            true => body.folded("Shares by finger, method and threshold", more(best)),
            false => body.append(best).folded(
                "Shares by threshold, fingers at once",
                more(Body::default()),
            ),
        };
    }
    let clouds = report
        .illustrations
        .and_then(|all| clouds(&all.point_clouds));
    let dynamics = dynamics::section(report, methods);
    body.folded("Makes and breaks, slip, phases and gaits", dynamics)
        .folded(
            "Distance to the object, planned against recorded",
            distances(&differences),
        )
        .folded("Clouds of points, as in the paper", clouds)
}

/// Differences of distances to the object.
fn distances(differences: &[(&Method<'_>, &PerFinger<Statistics>)]) -> Body {
    if differences.is_empty() {
        return Body::default();
    }
    let caption = "Difference of distances to the object, absolute";
    let table = finger_table(caption, differences).smallest_marked();
    let figure = Figure {
        id: "distance-difference",
        title: "Absolute difference between the planned and the recorded distance of a fingertip to the object's surface."
            .to_owned(),
        ..finger_figure(
            differences,
            "Neither counts on which side of the surface the fingertip is. ",
            "difference of distances (mm)",
        )
    };
    Body::default().figure(figure).prose(table)
}

/// A motion in the table of shares.
struct Share<'a> {
    head: Head,
    stressed: bool,
    contact: &'a ContactShare,
    three_or_more: f64,
    by_finger: &'a PerFinger<f64>,
}

fn share_table<'a>(contacts: &[Contacts<'_, 'a>]) -> Table<Share<'a>> {
    let mut rows = Vec::new();
    // The recorded motion is the same for every method unless some plans are missing.
    for (place, (method, contact)) in contacts.iter().enumerate() {
        let same = |(_, other): &Contacts<'_, '_>| same_recorded(other, contact);
        if !contacts[..place].iter().any(same) {
            rows.push(Share {
                head: match contacts.iter().all(same) {
                    true => recorded(),
                    false => Head::coloured(
                        RECORDED_CLASS,
                        format!("recorded (instants of {})", method.name),
                    ),
                },
                stressed: false,
                contact,
                three_or_more: contact.recorded_three_or_more,
                by_finger: &contact.recorded_by_finger,
            });
        }
        rows.push(Share {
            head: method.head(),
            stressed: method.default,
            contact,
            three_or_more: contact.three_or_more,
            by_finger: &contact.by_finger,
        });
    }
    let share = |row: &Share<'_>, value: f64| evaluated(row.contact.n, percent(value));
    let caption = "Share of instants in contact, planned and recorded";
    Table::new(caption, rows, "motion", |row| row.head.clone())
        .stressed(|row| row.stressed)
        .numbers("three or more", "%", |row| share(row, row.three_or_more))
        .fingers("%", |row, finger| share(row, row.by_finger[finger]))
        .sizes(|row| [row.contact.n, row.contact.n_filled, row.contact.n_left_out])
}

fn same_recorded(a: &ContactShare, b: &ContactShare) -> bool {
    a.n == b.n
        && a.recorded_three_or_more == b.recorded_three_or_more
        && a.recorded_by_finger == b.recorded_by_finger
}

/// `None` where nothing was evaluated at any threshold.
fn by_threshold(contacts: &[Contacts<'_, '_>]) -> Option<Figure> {
    let known = || {
        contacts
            .iter()
            .filter(|(_, c)| c.n > 0 && !c.by_tau.is_empty())
    };
    let (_, first) = known().next()?;
    let curve = |contact: &ContactShare, of: fn(&TauShare) -> f64| -> Vec<(f64, f64)> {
        let points = contact.by_tau.iter();
        points.map(|at| (to_mm(at.tau_m), 100.0 * of(at))).collect()
    };
    let mut series: Vec<Series> = known()
        .map(|(method, contact)| method.line(curve(contact, |at| at.three_or_more)))
        .collect();
    let recorded = curve(first, |at| at.recorded_three_or_more);
    let widest = recorded.iter().map(|at| at.0).fold(0.0, f64::max);
    series.push(Series::new("recorded", RECORDED_CLASS, recorded));
    let tau_mm = to_mm(first.tau_m);
    let chart = |title: &str, low: f64| {
        line_chart::draw(&LineChart {
            title,
            x: ("contact threshold tau (mm)", Scale::linear(0.0, widest)),
            y: ("share of instants (%)", Scale::linear(low, 100.0)),
            series: &series,
            dots: true,
            marked_x: Some((tau_mm, format!("used: {} mm", plain(tau_mm)))),
        })
    };
    let mut panels = vec![chart("Three or more fingertips in contact", 0.0)];
    let mut caption = format!(
        "n = {} instants. Where the lines are steep at the threshold used, the share says more about the threshold \
        than about the motion.",
        count(first.n)
    );
    let default = known().find(|(method, _)| method.default);
    if let Some(low) = default.and_then(|(_, contact)| enlarged_from(contact)) {
        panels.push(chart("The same, upper part enlarged", low));
        caption.push_str(&format!(
            " The second axis starts at {} %, not at zero; lines that leave it at the bottom are cut.",
            plain(low)
        ));
    }
    let mut legend = line_chart::keys(&series);
    legend.rotate_right(1);
    Some(Figure {
        id: "three-contacts-by-tau",
        title: "Share of instants with three or more fingertips in contact against the threshold."
            .to_owned(),
        caption,
        data: line_chart::data("tau_mm", "share_percent", &series),
        legend,
        panels,
    })
}

/// Shares from here up are drawn a second time where they crowd under 100 %.
const CROWDED_FROM: f64 = 0.8;

/// Start of an axis that has room for the default method at the threshold used, in percent.
fn enlarged_from(contact: &ContactShare) -> Option<f64> {
    let lowest = contact.three_or_more.min(contact.recorded_three_or_more);
    (CROWDED_FROM..1.0).contains(&lowest).then(|| {
        // Twice as far down as the share is below all, on a whole percent.
        (100.0 - 2.0 * 100.0 * (1.0 - lowest)).floor()
    })
}

/// The figure and the effect of clouds on contacts; `None` without clouds.
fn clouds(clouds: &[PointCloud]) -> Option<Body> {
    let first = clouds.first()?;
    if first.excess_m.n == 0 {
        return Some(Body::default());
    }
    let shares = clouds.iter().map(|cloud| {
        format!(
            "{} % by {}",
            percent(cloud.three_or_more),
            count(cloud.points)
        )
    });
    let shares = tied(&join_words(&shares.collect::<Vec<_>>()));
    let body = Body::from(html! {
        p {
            "Distances here are to the object's exact surface. By clouds of points on it, as in the paper, three or more recorded \
             fingertips are in contact at " (shares) " points, against " (percent(first.exact_three_or_more))
            "\u{a0}% by the surface, of the same instants."
        }
    });
    let excesses: Vec<&Statistics> = clouds.iter().map(|cloud| &cloud.excess_m).collect();
    let axis = ("excess (µm)", MICROMETRES.axis(&excesses));
    let names: Vec<String> = clouds
        .iter()
        .map(|c| format!("{} points", count(c.points)))
        .collect();
    let rows = names.iter().map(|label| PlotRow::new(label, PLAIN_CLASS));
    let rows = rows.zip(excesses.iter().copied());
    Some(body.figure(Figure {
        id: "point-clouds",
        title: "Distance to a cloud of points less distance to the surface.".to_owned(),
        caption: format!(
            "Over {} distances of recorded fingertips at instants spread over the test segments ({} of them filled), points spread evenly \
             over the surface. A cloud is never nearer than the surface. {BOX_WORDS}{}",
            count(first.excess_m.n),
            count(first.excess_m.n_filled),
            axis_words(&[axis.1]),
        ),
        data: FigureData::about(clouds)
            .counts("points", |cloud| cloud.points)
            .lengths(
                &["mean", "whisker_low", "p25", "p50", "p75", "p95", "whisker_high", "max"],
                |cloud| &cloud.excess_m,
            )
            .numbers("three_or_more_percent", |cloud| 100.0 * cloud.three_or_more)
            .numbers("exact_three_or_more_percent", |cloud| 100.0 * cloud.exact_three_or_more)
            .done(),
        legend: Vec::new(),
        panels: vec![MICROMETRES.boxes("", None, axis, rows)],
    }))
}

/// Instants at which 0, 1, .. 5 fingers are in contact.
type Counts = [usize; Finger::COUNT + 1];

/// Number of fingers in contact at once; `None` without an object.
fn contact_count(rows: &EvaluationRows, methods: &[Method<'_>], tau_m: f64) -> Option<Figure> {
    let recorded = rows.recorded_distance_m.as_deref()?;
    let mut counted: Vec<(&str, &str, Counts)> = Vec::new();
    for method in methods {
        let own = rows.methods.iter().find(|own| own.name == method.name);
        let Some(planned) = own.and_then(|own| own.distance_m.as_deref()) else {
            continue;
        };
        if method.default {
            let counts = counts(recorded, planned, tau_m);
            counted.insert(0, ("recorded", RECORDED_CLASS, counts));
        }
        counted.push((method.name, &method.class, counts(planned, recorded, tau_m)));
    }
    counted.retain(|(.., counts)| counts.iter().sum::<usize>() > 0);
    let n: usize = counted.first()?.2.iter().sum();
    let cells: Vec<(&str, usize, usize, f64)> = (counted.iter())
        .flat_map(|(label, _, counts)| {
            let shares = shares(counts).into_iter().enumerate();
            shares.map(|(fingers, share)| (*label, fingers, counts[fingers], 100.0 * share))
        })
        .collect();
    let legend = counted
        .iter()
        .map(|(label, class, _)| Key::area(*label, *class));
    Some(Figure {
        id: "contact-count",
        title: "Fingers in contact at once.".to_owned(),
        caption: format!(
            "Share of instants at which so many fingertips are within {} mm of the object's surface, n = {} instants at which \
             planned and recorded distances of all five fingers are known. Every share above zero has a bar that can be seen.",
            plain(to_mm(tau_m)),
            count(n)
        ),
        data: FigureData::about(&cells)
            .words("motion", |cell| cell.0)
            .counts("fingers", |cell| cell.1)
            .counts("instants", |cell| cell.2)
            .numbers("share_percent", |cell| cell.3)
            .done(),
        legend: legend.collect(),
        panels: vec![bars(&counted)],
    })
}

const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 268.0;
const FRAME: Frame = Frame::new([42.0, WIDTH - 8.0], [26.0, HEIGHT - axes::BOTTOM_ROOM]);
/// Of a group's width, what is left free.
const GAP_SHARE: f64 = 0.22;
/// Least height of a bar above zero: rare is not never.
const LEAST: f64 = 1.0;

/// Bars side by side: a group for each number of fingers, a bar for each motion.
fn bars(counted: &[(&str, &str, Counts)]) -> Panel {
    let y = Scale::linear(0.0, 100.0).over(FRAME.bottom, FRAME.top);
    let group_width = FRAME.width() / (Finger::COUNT + 1) as f64;
    let bar_width = group_width * (1.0 - GAP_SHARE) / counted.len() as f64;
    let series = counted.iter().map(|(label, _, counts)| {
        let shares: Vec<String> = shares(counts).into_iter().map(percent).collect();
        format!("{label} {} %", shares.join(", "))
    });
    let series: Vec<String> = series.collect();
    Panel {
        title: PanelTitle::default(),
        width: WIDTH,
        height: HEIGHT,
        summary: format!(
            "Fingers in contact at once, share of 0, 1, 2, 3, 4, 5: {}",
            series.join("; ")
        ),
        shapes: html! {
            (axes::left(&FRAME, &y, 5, "share of instants (%)"))
            line.axis x1=(Px(FRAME.left)) y1=(Px(FRAME.bottom)) x2=(Px(FRAME.right)) y2=(Px(FRAME.bottom)) {}
            text.name x=(Px(0.5 * (FRAME.left + FRAME.right))) y=(Px(HEIGHT - 5.0)) text-anchor="middle" { "fingers in contact" }
            @for fingers in 0..=Finger::COUNT {
                @let left = FRAME.left + group_width * (fingers as f64 + 0.5 * GAP_SHARE);
                text.tick x=(Px(FRAME.left + group_width * (fingers as f64 + 0.5))) y=(Px(FRAME.bottom + 18.0)) text-anchor="middle" { (fingers) }
                @for (place, (label, class, counts)) in counted.iter().enumerate() {
                    @let share = shares(counts)[fingers];
                    @if share > 0.0 {
                        @let top = y.at(100.0 * share).min(FRAME.bottom - LEAST);
                        g.(class) {
                            rect.area x=(Px(left + bar_width * place as f64)) y=(Px(top)) width=(Px(0.86 * bar_width)) height=(Px(FRAME.bottom - top)) {
                                title { (label) ", " (fingers) ": " (percent(share)) " %" }
                            }
                        }
                    }
                }
            }
        },
    }
}

/// Counts of one motion, over instants at which another is known too.
fn counts(own: &[PerFinger<f64>], other: &[PerFinger<f64>], tau_m: f64) -> Counts {
    let known = |fingers: &PerFinger<f64>| fingers.as_array().iter().all(|d| !d.is_nan());
    let mut counts = Counts::default();
    for (own, _) in own
        .iter()
        .zip(other)
        .filter(|(own, other)| known(own) && known(other))
    {
        let distances = own.as_array().iter();
        counts[distances.filter(|&&d| in_contact(d, tau_m)).count()] += 1;
    }
    counts
}

fn shares(counts: &Counts) -> [f64; Finger::COUNT + 1] {
    let n = counts.iter().sum::<usize>() as f64;
    counts.map(|own| own as f64 / n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fingers_are_counted_where_both_motions_are_known() {
        let at = |distances: [f64; 5]| PerFinger::new(distances);
        let planned = [
            at([0.0, 0.001, -0.002, 0.006, 0.1]),
            at([0.0; 5]),
            at([f64::NAN, 0.0, 0.0, 0.0, 0.0]),
            at([1.0; 5]),
        ];
        let recorded = [
            at([0.0; 5]),
            at([0.005, 0.0051, -0.0051, -0.005, 0.0]),
            at([0.0; 5]),
            at([0.0, f64::NAN, 0.0, 0.0, 0.0]),
        ];
        assert_eq!(counts(&planned, &recorded, 0.005), [0, 0, 0, 1, 0, 1]);
        assert_eq!(counts(&recorded, &planned, 0.005), [0, 0, 0, 1, 0, 1]);
        assert_eq!(
            shares(&[1, 0, 0, 0, 0, 3]),
            [0.25, 0.0, 0.0, 0.0, 0.0, 0.75]
        );
    }
}
