//! The page of many sessions together.

use inhand_model::{GroupSummary, MethodSummary, SessionSummary, Statistics, Summary};
use maud::{Markup, html};

use super::errors::{AXIS_NAME, overview_panels, spread_columns};
use super::{Body, Method, Section, intervals, method_table, section, shell};
use crate::figure::box_plot::{self, BOX_WORDS, MILLIMETRES, axis_words};
use crate::figure::row_plot::PlotRow;
use crate::figure::{Figure, FigureData};
use crate::summary::{by_finger, protocol_words, three_contacts, worst_first};
use crate::table::{Head, Table, UPPER, statistic};
use crate::words::{NONE, count, counted, decimals, join_words, millimetres, percent};

/// Draws the page.
pub(crate) fn page(summary: &Summary) -> Markup {
    let title = counted(summary.sessions.len(), "session");
    let top = html! {
        dl.facts {
            @for (name, value) in facts(summary) { div { dt { (name) } dd { (value) } } }
        }
        p.verdict { (verdict(summary)) }
    };
    shell(&title, &top, &sections(summary))
}

fn sections(summary: &Summary) -> Vec<Section> {
    let contenders = &Method::all(&summary.methods, &summary.default_method, |method| {
        (&method.name, method.baseline)
    });
    let (title, intervals) = match &summary.held_out {
        Some(own) => ("Between sessions, held out", &own.intervals),
        None => ("Between sessions", &summary.intervals),
    };
    let sections = [
        section("methods", "Methods", methods(summary, contenders)),
        section(
            "intervals",
            title,
            intervals::body(intervals, contenders, intervals::DIFFERENCES),
        ),
        section("sessions", "Sessions", sessions(summary, contenders)),
        section("outliers", "Outliers", outliers(summary)),
        section("groups", "Participants, objects, tasks", groups(summary)),
        section("settings", "Settings that differ", settings(summary)),
    ];
    sections.into_iter().flatten().collect()
}

fn facts(summary: &Summary) -> Vec<(&'static str, String)> {
    let sessions = &summary.sessions;
    let add =
        |of: fn(&SessionSummary) -> usize| sessions.iter().map(of).fold(0, usize::saturating_add);
    let (segments, left_out) = (add(|s| s.segments), add(|s| s.left_out));
    let hours = sessions.iter().map(|s| s.duration_s).sum::<f64>() / 3600.0;
    let stated = |of: fn(&SessionSummary) -> Option<&str>| distinct(sessions.iter().map(of));
    let segments = format!("{}, {} lost to gaps", count(segments), count(left_out));
    vec![
        ("Participants", stated(|s| s.participant.as_deref())),
        ("Objects", stated(|s| s.object.as_deref())),
        ("Tasks", stated(|s| s.task.as_deref())),
        ("Test takes", format!("{} h", decimals(hours, 2))),
        ("Segments", segments),
    ]
}

/// The values there are: named where they are few, counted where they are many.
fn distinct<'a>(values: impl Iterator<Item = Option<&'a str>>) -> String {
    const NAMED: usize = 3;
    let values: std::collections::BTreeSet<Option<&str>> = values.collect();
    let stated = values.iter().flatten().map(|&value| value.to_owned());
    let stated: Vec<String> = stated.collect();
    let missing = match values.contains(&None) {
        true => ", some not stated",
        false => "",
    };
    match stated.len() {
        0 => "not stated".to_owned(),
        few if few <= NAMED => format!("{}{missing}", join_words(&stated)),
        many => format!("{}{missing}", count(many)),
    }
}

/// The errors of the default method, and how they compare, in words.
fn verdict(summary: &Summary) -> String {
    let (intervals, name) = (&summary.intervals, &summary.default_method);
    let Some(method) = summary.methods.iter().find(|method| method.name == *name) else {
        return String::new();
    };
    let held_out = summary.held_out.as_ref();
    let first = held_out.and_then(|own| own.methods.iter().find(|method| method.name == *name));
    let intervals = held_out.map_or(intervals, |own| &own.intervals);
    let error = &first.unwrap_or(method).error.all;
    let mut text = match error.n {
        0 => format!("{name}: no instant was evaluated."),
        _ => format!(
            "{name}{}: the median error is {} mm, a quarter of the errors is above {} mm.",
            protocol_words(summary),
            millimetres(error.p50),
            millimetres(error.p75)
        ),
    };
    if first.is_some() {
        let median = millimetres(statistic(&method.error.all, |s| s.p50));
        text.push_str(&format!(
            " Under the published protocol the median is {median} mm."
        ));
    }
    let [planned, recorded] = three_contacts(method.contacts);
    if planned.is_finite() {
        text.push_str(&format!(
            " Three or more fingers are in contact {} % of the time, recorded {} %.",
            percent(planned),
            percent(recorded)
        ));
    }
    let baseline = intervals.best_baseline.as_ref();
    let compared =
        baseline.and_then(|baseline| intervals::against_words(intervals, name, baseline));
    text + &compared.unwrap_or_default()
}

/// A name from a file, or that there is none.
fn stated(value: Option<&str>) -> String {
    value
        .filter(|value| !value.is_empty())
        .unwrap_or(NONE)
        .to_owned()
}

/// The name, and the file under the pointer: names of sessions may repeat.
fn session_head(session: &SessionSummary) -> Head {
    Head::hovering(&session.name, &session.file)
}

/// Errors of the methods over all sessions.
fn methods(summary: &Summary, contenders: &[Method<'_, MethodSummary>]) -> Body {
    let both = summary.held_out.as_ref().map(|held_out| {
        let error = |method: &&Method<'_, MethodSummary>| {
            let mut methods = held_out.methods.iter();
            let own = methods.find(|own| own.name == method.name);
            own.map_or_else(Statistics::default, |own| own.error.all)
        };
        let table = method_table("Error over all sessions, both protocols", contenders, |m| m)
            .lengths("held out: median", |m| statistic(&error(m), |s| s.p50))
            .lengths("held out: 95 %", |m| statistic(&error(m), |s| s.p95))
            .lengths("published: median", |m| {
                statistic(&m.evaluation.error.all, |s| s.p50)
            })
            .lengths("published: 95 %", |m| {
                statistic(&m.evaluation.error.all, |s| s.p95)
            });
        Body::default().prose(table)
    });
    let caption = "Error over all sessions, published";
    let table = method_table(caption, contenders, |method| method);
    let table = spread_columns(table, |method| method.evaluation.error.all)
        .percents("three contacts", "%", |m| {
            three_contacts(m.evaluation.contacts)[0]
        })
        .percents("recorded", "%", |m| {
            three_contacts(m.evaluation.contacts)[1]
        });
    let boxes: Vec<(&str, &str, &Statistics)> = (contenders.iter())
        .flat_map(|method| {
            let distributions = by_finger(&method.evaluation.error);
            distributions.map(|(finger, error)| (finger, method.name, error))
        })
        .collect();
    let figure = boxes.iter().any(|(.., error)| error.n > 0).then(|| {
        let (panels, caption) = overview_panels(contenders, |method| &method.error, "");
        Figure {
            id: "error-over-sessions",
            title: "Error over all sessions, published protocol.".to_owned(),
            caption,
            data: box_plot::data(&boxes),
            legend: Vec::new(),
            panels,
        }
    });
    Body::from(html! {
        p {
            "Distance between planned and recorded fingertips at every instant of every test segment of all sessions together: quantiles are \
             those of the instants, not means over sessions, so that long sessions weigh more than short ones."
        }
    })
    .append(both)
    .figure(figure)
    .prose(table)
}

/// Sessions that are drawn; the table has all of them.
const DRAWN: usize = 40;

/// The sessions, worst first.
fn sessions(summary: &Summary, contenders: &[Method<'_, MethodSummary>]) -> Body {
    let Some(place) = contenders.iter().position(|method| method.default) else {
        return Body::default();
    };
    let ranked = worst_first(summary, place);
    let name = &summary.default_method;
    let table = Table::new(
        format!("Sessions, error of {name}{}", protocol_words(summary)),
        ranked.iter().copied(),
        "session",
        |session| session_head(session),
    )
    .words("participant", |session| {
        stated(session.participant.as_deref())
    })
    .words("object", |session| stated(session.object.as_deref()))
    .words("task", |session| stated(session.task.as_deref()))
    .counts("segments", "", |session| session.segments)
    .counts("lost", "", |session| session.left_out)
    .counts("warnings", "", |session| session.warnings)
    .statistics(&UPPER, "mm", millimetres, |session| {
        session.methods[place].headline().all
    })
    .lengths("published: median", |session| {
        statistic(&session.methods[place].error.all, |s| s.p50)
    })
    .percents("three +", "%", |s| {
        three_contacts(s.methods[place].contacts)[0]
    })
    .percents("recorded", "%", |s| {
        three_contacts(s.methods[place].contacts)[1]
    });
    let body = Body::from(html! {
        p {
            "Sessions by the third quartile of the error of " b { (name) } (protocol_words(summary)) ", worst first. A session's own \
             report, with the worst instants of its takes, is beside its evaluation."
        }
    });
    body.figure(session_figure(
        &ranked,
        &contenders[place],
        (place, protocol_words(summary)),
    ))
    .prose(table)
}

fn session_figure(
    ranked: &[&SessionSummary],
    method: &Method<'_, MethodSummary>,
    (place, words_of_protocol): (usize, &str),
) -> Option<Figure> {
    let drawn: Vec<(&SessionSummary, &Statistics)> = (ranked.iter())
        .map(|session| (*session, &session.methods[place].headline().all))
        .filter(|(_, error)| error.n > 0)
        .take(DRAWN)
        .collect();
    if drawn.is_empty() {
        return None;
    }
    let name = method.name;
    let title = format!("{name}, by session");
    let errors: Vec<&Statistics> = drawn.iter().map(|(_, error)| *error).collect();
    let axis = (AXIS_NAME, MILLIMETRES.axis(&errors));
    let panel = |part: &[(&SessionSummary, &Statistics)]| {
        let rows = (part.iter())
            .map(|(session, error)| (PlotRow::new(&session.name, &method.class), *error));
        MILLIMETRES.boxes(&title, None, axis, rows)
    };
    // Two columns of boxes are read more easily than one tall one.
    let half = drawn.len().div_ceil(2).max(10);
    let words = match ranked.len() > drawn.len() {
        true => format!(
            " The {} worst of {} sessions are drawn.",
            drawn.len(),
            ranked.len()
        ),
        false => String::new(),
    };
    // The finger of a box is all of them; the session comes before it.
    let boxes: Vec<_> = errors.iter().map(|error| ("all", name, *error)).collect();
    let mut data = FigureData::about(&drawn)
        .words("session", |(session, _)| &*session.name)
        .words("file", |(session, _)| &*session.file)
        .done();
    data.columns.extend(box_plot::data(&boxes).columns);
    Some(Figure {
        id: "error-by-session",
        title: format!("Error of {name} by session{words_of_protocol}, worst first."),
        caption: format!("{BOX_WORDS}{}{words}", axis_words(&[axis.1])),
        data,
        legend: Vec::new(),
        panels: drawn.chunks(half).map(panel).collect(),
    })
}

/// Sessions far from the others; `None` where no session is.
fn outliers(summary: &Summary) -> Option<Body> {
    if summary.outliers.is_empty() {
        return None;
    }
    let outliers = summary
        .outliers
        .iter()
        .map(|outlier| (outlier, &summary.sessions[outlier.session.place]));
    let caption = "Sessions unlike the others";
    let table = Table::new(caption, outliers, "session", |(_, session)| {
        session_head(session)
    })
    .words("measure", |(outlier, _)| outlier.what.clone())
    .numbers("there", "", |(outlier, _)| {
        format!("{} {}", decimals(outlier.value, 2), outlier.unit)
    })
    .numbers("median of the sessions", "", |(outlier, _)| {
        format!("{} {}", decimals(outlier.median, 2), outlier.unit)
    })
    .decimals("score", "", 1, |(outlier, _)| outlier.score)
    .words("gaps and warnings of the session", |(_, session)| {
        session_notes(session)
    });
    Some(Body::from(html! {
        p {
            "An outlier has a modified z-score beyond 3.5, " code { "0.6745 (value − median) / MAD" } " with the median absolute deviation \
             from the median over sessions (Iglewicz and Hoaglin 1993); where most sessions agree to the last digit, the mean deviation replaces \
             it. A session unlike the others is not necessarily wrong."
        }
        (table)
    }))
}

fn session_notes(session: &SessionSummary) -> String {
    let mut notes = Vec::new();
    if session.left_out > 0 {
        let all = session.segments + session.left_out;
        notes.push(format!(
            "{} of {all} segments lost to gaps",
            session.left_out
        ));
    }
    if session.warnings > 0 {
        notes.push(counted(session.warnings, "warning") + " about its takes");
    }
    match notes.is_empty() {
        true => "no gaps, no warnings".to_owned(),
        false => notes.join("; "),
    }
}

/// Participant x object x task x finger.
fn groups(summary: &Summary) -> Body {
    let mut methods: Vec<&str> = Vec::new();
    for group in &summary.groups {
        if !methods.contains(&group.method.as_str()) {
            methods.push(&group.method);
        }
    }
    let middle = |s: &Statistics| match s.n {
        0 => NONE.to_owned(),
        _ => format!("{} ({})", millimetres(s.p50), millimetres(s.p75)),
    };
    let tables = methods.iter().map(|method| {
        let groups = summary
            .groups
            .iter()
            .filter(|group| group.method == *method);
        let protocol = summary.held_out.as_ref().map_or("", |_| ", published");
        let caption = format!("Error of {method} by group{protocol}");
        Table::new(caption, groups, "participant", |group: &&GroupSummary| {
            stated(group.participant.as_deref())
        })
        .words("object", |group| stated(group.object.as_deref()))
        .words("task", |group| stated(group.task.as_deref()))
        .counts("sessions", "", |group| group.sessions)
        .counts("n", "", |group| group.error.all.n)
        .numbers("all fingers", "mm", |group| middle(&group.error.all))
        .fingers("mm", |group, finger| middle(&group.error.by_finger[finger]))
    });
    let body = Body::from(html! {
        p {
            "Sessions of the same participant, object and task together. Each cell: median (third quartile) of the error at all of their instants, \
             mm. –: not stated by the session; set participant and task in its inhand.toml, or with --participant and \
             --task."
        }
    });
    tables.fold(body, Body::prose)
}

/// Settings that are not the same in all sessions; `None` where all are.
fn settings(summary: &Summary) -> Option<Body> {
    if summary.differences.is_empty() {
        return None;
    }
    let values = |values: &[String]| {
        let mut counts: Vec<(&str, usize)> = Vec::new();
        for value in values {
            match counts.iter_mut().find(|(known, _)| known == value) {
                Some((_, times)) => *times += 1,
                None => counts.push((value, 1)),
            }
        }
        let values = counts
            .iter()
            .map(|(value, times)| format!("{value} (in {times})"));
        values.collect::<Vec<_>>().join("; ")
    };
    let caption = "Settings that differ among the sessions";
    let table = Table::new(caption, &summary.differences, "setting", |own| {
        own.key.clone()
    })
    .words("values", |own| values(&own.values));
    Some(Body::from(html! {
        p {
            "These sessions were joined on request although their settings differ. Numbers over all of them mix what \
             these settings change."
        }
        (table)
    }))
}
