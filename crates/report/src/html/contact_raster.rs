//! Which finger touches when, recorded and planned, over whole test takes.

use inhand_model::{EvaluationRows, Finger, PerFinger, in_contact};
use maud::html;

use super::{Method, default};
use crate::figure::palette::{PLAIN_CLASS, RECORDED_CLASS, finger_class};
use crate::figure::scale::Scale;
use crate::figure::strips::{self, Run, State, Strip};
use crate::figure::{Figure, FigureData, Frame, Key, Panel, Px, axes, finger_keys};
use crate::number::{plain, to_mm};
use crate::words::shortened;

/// Takes that have a panel; more would make a page of strips.
const TAKES: usize = 3;
const WIDTH: f64 = 940.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = WIDTH - 84.0;
const TOP: f64 = 24.0;
/// Both strips of a finger and the room below them.
const FINGER_HEIGHT: f64 = 29.0;
const RECORDED_HEIGHT: f64 = 12.0;
const PLANNED_TOP: f64 = 14.0;
const PLANNED_HEIGHT: f64 = 8.0;
const LETTERS: usize = 12;

/// Runs of contact of one finger, or of three fingers at once.
struct Lane {
    finger: Option<Finger>,
    recorded: Vec<Run>,
    planned: Vec<Run>,
}

/// `None` without an object or without plans of the default method.
pub(super) fn figure(rows: &EvaluationRows, methods: &[Method<'_>], tau_m: f64) -> Option<Figure> {
    let recorded = rows.recorded_distance_m.as_deref()?;
    let name = default(methods)?.name;
    let own = rows.methods.iter().find(|own| own.name == name)?;
    let planned = own.distance_m.as_deref()?;
    let takes: Vec<(usize, Vec<Lane>)> = (0..rows.takes.len())
        .filter(|&take| rows.segments.iter().any(|origin| origin.take == take))
        .map(|take| (take, lanes(rows, take, recorded, planned, tau_m)))
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
    let longest = shown
        .iter()
        .flat_map(|(_, lanes)| lanes)
        .flat_map(|lane| [lane.recorded.len(), lane.planned.len()]);
    if longest.max() > Some(strips::MANY) {
        caption.push_str(" Changes too short to be seen at this width are not drawn; the numbers behind the figure contain them all.");
    }
    Some(Figure {
        id: "contact-raster",
        title: "Contacts over the test takes.".to_owned(),
        caption,
        data: data(rows, shown, name),
        legend: finger_keys(Key::area),
        panels: (shown.iter())
            .map(|(take, lanes)| panel(&rows.takes[*take], lanes, name, rate_hz))
            .collect(),
    })
}

/// Whether a rate gives samples a time.
pub(super) fn is_rate(rate_hz: f64) -> bool {
    rate_hz.is_finite() && rate_hz > 0.0
}

/// Runs of one take, its segments in the order of time.
fn lanes(
    rows: &EvaluationRows,
    take: usize,
    recorded: &[PerFinger<f64>],
    planned: &[PerFinger<f64>],
    tau_m: f64,
) -> Vec<Lane> {
    let samples = rows.layout.samples;
    let mut segments: Vec<(usize, usize)> = (rows.segments.iter().enumerate())
        .filter(|(_, origin)| origin.take == take)
        .map(|(segment, origin)| (origin.start, segment))
        .collect();
    segments.sort_unstable();
    let runs = |distances: &[PerFinger<f64>], of: &dyn Fn(&PerFinger<f64>) -> State| {
        strips::runs(
            segments
                .iter()
                .flat_map(|&(start, segment)| {
                    (0..samples).map(move |t| (start + t, segment * samples + t))
                })
                .map(|(sample, row)| (sample, distances.get(row).map_or(State::Unknown, of))),
        )
    };
    let lane = |finger: Option<Finger>, of: &dyn Fn(&PerFinger<f64>) -> State| Lane {
        finger,
        recorded: runs(recorded, of),
        planned: runs(planned, of),
    };
    (Finger::ALL.iter())
        .map(|&finger| lane(Some(finger), &|d| state(d[finger], tau_m)))
        .chain([lane(None, &|d| three(d, tau_m))])
        .collect()
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

fn panel(take: &str, lanes: &[Lane], method: &str, rate_hz: f64) -> Panel {
    let bottom = TOP + FINGER_HEIGHT * lanes.len() as f64;
    let frame = Frame {
        left: LEFT,
        top: TOP - 2.0,
        right: RIGHT,
        bottom,
    };
    let ends = lanes
        .iter()
        .flat_map(|lane| lane.recorded.iter().map(|run| (run.begin, run.end)));
    let (first, last) = ends.fold((usize::MAX, 0), |(a, b), (begin, end)| {
        (a.min(begin), b.max(end))
    });
    let (from_s, to_s) = (first.min(last) as f64 / rate_hz, last as f64 / rate_hz);
    let x = Scale::linear(from_s, to_s, frame.left, frame.right);
    let shapes = html! {
        text.title x="0" y="12.5" { (shortened(take, 80)) }
        (axes::bottom(&frame, &x, 12, "time in the take (s)"))
        @for (place, lane) in lanes.iter().enumerate() {
            @let y = TOP + FINGER_HEIGHT * place as f64;
            @let name = lane.finger.map_or("three +", Finger::name);
            text.label x=(Px(LEFT - 8.0)) y=(Px(y + 14.0)) text-anchor="end" { (name) }
            (strips::draw(&strip(lane, "recorded", &lane.recorded, rate_hz, y, RECORDED_HEIGHT), &x))
            (strips::draw(&strip(lane, method, &lane.planned, rate_hz, y + PLANNED_TOP, PLANNED_HEIGHT), &x))
            text.tick x=(Px(RIGHT + 6.0)) y=(Px(y + 9.5)) { "recorded" }
            text.tick x=(Px(RIGHT + 6.0)) y=(Px(y + PLANNED_TOP + 8.0)) { (shortened(method, LETTERS)) }
        }
    };
    Panel {
        width: WIDTH,
        height: bottom + axes::BOTTOM_ROOM,
        summary: format!("Contacts of five fingers over {take}, recorded and planned by {method}"),
        shapes,
    }
}

fn strip<'a>(
    lane: &Lane,
    motion: &str,
    runs: &'a [Run],
    rate_hz: f64,
    top: f64,
    height: f64,
) -> Strip<'a> {
    let name = lane.finger.map_or("three or more", Finger::name);
    let class = match lane.finger {
        Some(finger) => finger_class(finger),
        None if motion == "recorded" => RECORDED_CLASS,
        None => PLAIN_CLASS,
    };
    Strip {
        label: format!("{name}, {motion}"),
        class,
        runs,
        rate_hz,
        top,
        height,
    }
}

fn data(rows: &EvaluationRows, takes: &[(usize, Vec<Lane>)], method: &str) -> FigureData {
    let rate_hz = rows.layout.rate_hz;
    let mut all: Vec<(&str, &str, &str, &Run)> = Vec::new();
    for (take, lanes) in takes {
        for lane in lanes {
            let finger = lane.finger.map_or("three_or_more", Finger::name);
            for (motion, runs) in [("recorded", &lane.recorded), (method, &lane.planned)] {
                let on_or_unknown = runs.iter().filter(|run| run.state != State::Off);
                all.extend(
                    on_or_unknown.map(|run| (rows.takes[*take].as_str(), finger, motion, run)),
                );
            }
        }
    }
    let word = |run: &Run| match run.state {
        State::On => "contact",
        _ => "unknown",
    };
    FigureData::about(&all)
        .words("take", |row| row.0)
        .words("finger", |row| row.1)
        .words("motion", |row| row.2)
        .words("state", |row| word(row.3))
        .numbers("begin_s", |row| row.3.begin as f64 / rate_hz)
        .numbers("end_s", |row| row.3.end as f64 / rate_hz)
        .done()
}
