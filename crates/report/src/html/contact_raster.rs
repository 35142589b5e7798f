//! Contacts of each finger over time, recorded and planned, over whole test takes.

use inhand_model::{EvaluationRows, Finger, PerFinger, in_contact};
use maud::html;

use super::{Method, default};
use crate::figure::scale::Scale;
use crate::figure::strips::{self, Run, State};
use crate::figure::{
    Figure, FigureData, Frame, Key, PLAIN_CLASS, Panel, Px, axes, finger_class, finger_keys,
};
use crate::words::{plain, shortened, to_mm};

/// Takes that have a panel; more would make a page of strips.
const TAKES: usize = 3;
const WIDTH: f64 = 940.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = WIDTH - 84.0;
const TOP: f64 = 4.0;
/// Both strips of a finger and the room below them.
const FINGER_HEIGHT: f64 = 29.0;
const RECORDED_HEIGHT: f64 = 12.0;
const PLANNED_TOP: f64 = 14.0;
const PLANNED_HEIGHT: f64 = 8.0;
const LETTERS: usize = 12;

/// Contact of a finger, or of three or more fingers at once, in one motion over a take.
struct Contact<'a> {
    finger: Option<Finger>,
    motion: &'a str,
    runs: Vec<Run>,
}

/// `None` without an object or without plans of the default method.
pub(super) fn figure(rows: &EvaluationRows, methods: &[Method<'_>], tau_m: f64) -> Option<Figure> {
    let recorded = rows.recorded_distance_m.as_deref()?;
    let name = default(methods)?.name;
    let own = rows.methods.iter().find(|own| own.name == name)?;
    let motions = [("recorded", recorded), (name, own.distance_m.as_deref()?)];
    let takes: Vec<(&str, Vec<Contact<'_>>)> = (rows.takes.iter().enumerate())
        .filter(|(take, _)| rows.segments.iter().any(|origin| origin.take == *take))
        .map(|(take, name)| (name.as_str(), contacts(rows, take, motions, tau_m)))
        .collect();
    let shown = &takes[..takes.len().min(TAKES)];
    let rate_hz = rows.layout.rate_hz;
    if shown.is_empty() || !is_rate(rate_hz) {
        return None;
    }
    let mut caption = format!(
        "Coloured where a fingertip is within {} mm of the object's surface: the upper strip of each finger as recorded, the \
         lower one as planned by {name}, segment after segment. Pale: no contact; grey line: not known; blank: in no segment. Below: three or more fingers at once.",
        plain(to_mm(tau_m))
    );
    if takes.len() > TAKES {
        caption.push_str(&format!(
            " The first {TAKES} of {} test takes.",
            takes.len()
        ));
    }
    let all = shown.iter().flat_map(|(_, contacts)| contacts);
    if all.map(|contact| contact.runs.len()).max() > Some(strips::MANY) {
        caption.push_str(" Changes too short to be seen at this width are not drawn; the numbers behind the figure contain them all.");
    }
    let panels = shown
        .iter()
        .map(|(take, contacts)| panel(take, contacts, rate_hz));
    Some(Figure {
        id: "contact-raster",
        title: "Contacts over the test takes.".to_owned(),
        caption,
        data: data(shown, rate_hz),
        legend: finger_keys(Key::area),
        panels: panels.collect(),
    })
}

/// Whether a rate gives samples a time.
pub(super) fn is_rate(rate_hz: f64) -> bool {
    rate_hz.is_finite() && rate_hz > 0.0
}

/// Contacts in one take, its segments in the order of time: of each finger and of three or more, in each motion.
fn contacts<'a>(
    rows: &EvaluationRows,
    take: usize,
    motions: [(&'a str, &[PerFinger<f64>]); 2],
    tau_m: f64,
) -> Vec<Contact<'a>> {
    let samples = rows.layout.samples;
    let mut segments: Vec<(usize, usize)> = (rows.segments.iter().enumerate())
        .filter(|(_, origin)| origin.take == take)
        .map(|(segment, origin)| (origin.start, segment))
        .collect();
    segments.sort_unstable();
    let runs = |distances_m: &[PerFinger<f64>], finger: Option<Finger>| {
        let instants = segments.iter().flat_map(|&(start, segment)| {
            (0..samples).map(move |t| (start + t, segment * samples + t))
        });
        strips::runs(instants.map(|(sample, row)| {
            let known = distances_m.get(row);
            let state = known.map_or(State::Unknown, |distances_m| match finger {
                Some(finger) => state(distances_m[finger], tau_m),
                None => three(distances_m, tau_m),
            });
            (sample, state)
        }))
    };
    let fingers = Finger::ALL.map(Some).into_iter().chain([None]);
    let contact = |finger| {
        motions.map(|(motion, distances_m)| Contact {
            finger,
            motion,
            runs: runs(distances_m, finger),
        })
    };
    fingers.flat_map(contact).collect()
}

/// Whether a finger touches.
pub(super) fn state(distance_m: f64, tau_m: f64) -> State {
    if distance_m.is_nan() {
        State::Unknown
    } else if in_contact(distance_m, tau_m) {
        State::On
    } else {
        State::Off
    }
}

fn three(distances_m: &PerFinger<f64>, tau_m: f64) -> State {
    let states = distances_m.as_array().map(|d| state(d, tau_m));
    if states.contains(&State::Unknown) {
        State::Unknown
    } else if states.iter().filter(|&&s| s == State::On).count() >= 3 {
        State::On
    } else {
        State::Off
    }
}

/// Two strips a finger, recorded above planned.
fn panel(take: &str, contacts: &[Contact<'_>], rate_hz: f64) -> Panel {
    let frame = Frame::new(
        [LEFT, RIGHT],
        [TOP - 2.0, TOP + 0.5 * FINGER_HEIGHT * contacts.len() as f64],
    );
    let recorded = contacts
        .iter()
        .filter(|contact| contact.motion == "recorded");
    let runs = || recorded.clone().flat_map(|contact| &contact.runs);
    let last = runs().map(|run| run.end).max().unwrap_or(0);
    let first = runs().map(|run| run.begin).min().unwrap_or(last);
    let (from_s, to_s) = (first as f64 / rate_hz, last as f64 / rate_hz);
    let x = Scale::linear(from_s, to_s).over(frame.left, frame.right);
    let strip = |place: usize, contact: &Contact<'_>| {
        let y = TOP + FINGER_HEIGHT * (place / 2) as f64;
        let planned = place % 2 == 1;
        let (top, height) = match planned {
            true => (y + PLANNED_TOP, PLANNED_HEIGHT),
            false => (y, RECORDED_HEIGHT),
        };
        let name = contact.finger.map_or("three +", Finger::name);
        let label = format!("{name}, {}", contact.motion);
        let class = contact.finger.map_or(PLAIN_CLASS, finger_class);
        let at = |sample: usize| x.at(sample as f64 / rate_hz);
        let strip = strips::draw(&label, class, &contact.runs, at, [top, height]);
        html! {
            @if !planned {
                text.label x=(Px(LEFT - 8.0)) y=(Px(y + 14.0)) text-anchor="end" { (name) }
            }
            (strip)
            text.tick x=(Px(RIGHT + 6.0)) y=(Px(top + 9.0)) { (shortened(contact.motion, LETTERS)) }
        }
    };
    let motion = contacts.last().map_or("", |contact| contact.motion);
    Panel {
        title: take.into(),
        width: WIDTH,
        height: frame.bottom + axes::BOTTOM_ROOM,
        summary: format!("Contacts of five fingers over {take}, recorded and planned by {motion}"),
        shapes: html! {
            (axes::bottom(&frame, &x, 12, "time in the take (s)"))
            @for (place, contact) in contacts.iter().enumerate() { (strip(place, contact)) }
        },
    }
}

fn data(takes: &[(&str, Vec<Contact<'_>>)], rate_hz: f64) -> FigureData {
    let contacts = takes
        .iter()
        .flat_map(|(take, all)| all.iter().map(move |one| (*take, one)));
    let rows: Vec<(&str, &Contact<'_>, &Run)> = contacts
        .flat_map(|(take, contact)| contact.runs.iter().map(move |run| (take, contact, run)))
        .filter(|(.., run)| run.state != State::Off)
        .collect();
    FigureData::about(&rows)
        .words("take", |row| row.0)
        .words("finger", |row| {
            row.1.finger.map_or("three_or_more", Finger::name)
        })
        .words("motion", |row| row.1.motion)
        .words("state", |row| match row.2.state {
            State::On => "contact",
            _ => "unknown",
        })
        .numbers("begin_s", |row| row.2.begin as f64 / rate_hz)
        .numbers("end_s", |row| row.2.end as f64 / rate_hz)
        .done()
}
