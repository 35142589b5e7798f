//! Error against time in a usual and in the worst test segment, with contacts beneath.

use inhand_model::{EvaluationRows, Finger, MethodRows};
use maud::{Markup, html};

use super::contact_raster::{is_rate, state};
use super::{Method, default};
use crate::figure::line_chart::{self, Series};
use crate::figure::scale::{Scale, nice_end};
use crate::figure::strips::{self, State};
use crate::figure::{Figure, FigureData, Frame, Key, Panel, Px, axes, finger_class, finger_keys};
use crate::words::{decimals, plain, to_mm};

const WIDTH: f64 = 460.0;
const FRAME: Frame = Frame::new([50.0, WIDTH - 54.0], [26.0, 192.0]);
/// From the error's axis down to the first strip.
const STRIPS_TOP: f64 = FRAME.bottom + 12.0;
const FINGER_HEIGHT: f64 = 17.0;
const STRIP_HEIGHT: f64 = 6.0;
const WANTED_TICKS: usize = 5;

/// A segment that is shown.
struct Shown<'a> {
    why: &'static str,
    rows: &'a EvaluationRows,
    method: &'a MethodRows,
    segment: usize,
    mean_m: f64,
    tau_m: Option<f64>,
}

/// `None` without rows of the default method.
pub(super) fn figure(rows: &EvaluationRows, methods: &[Method<'_>]) -> Option<Figure> {
    let default = default(methods)?;
    if !is_rate(rows.layout.rate_hz) {
        return None;
    }
    let name = default.name;
    let method = (rows.methods.iter()).find(|own| own.name == name)?;
    let ranked = ranked(rows, method);
    let ((median, median_mean), (worst, worst_mean)) =
        (*ranked.get((ranked.len().max(1) - 1) / 2)?, *ranked.last()?);
    let mut contacts = methods
        .iter()
        .filter_map(|method| method.evaluation.contact.as_ref());
    let tau_m = contacts.next().map(|contact| contact.tau_m);
    let show = |why, segment, mean_m| Shown {
        why,
        rows,
        method,
        segment,
        mean_m,
        tau_m: tau_m.filter(|_| rows.recorded_distance_m.is_some() && method.distance_m.is_some()),
    };
    let mut shown = vec![show("median", median, median_mean)];
    if worst != median {
        shown.push(show("worst", worst, worst_mean));
    }
    let contacts = shown[0].tau_m.map_or_else(String::new, |tau_m| {
        format!(
            " Beneath: where each finger is within {} mm of the object's surface, planned above recorded; pale: not; grey line: not known.",
            plain(to_mm(tau_m))
        )
    });
    Some(Figure {
        id: "error-over-time",
        title: format!("Error of each finger against time, {name}, published protocol."),
        caption: format!(
            "Distance between planned and recorded fingertips at each sample of the test segments with the median and the largest mean \
             error, n = {} segments. The error axes differ.{contacts}",
            ranked.len()
        ),
        data: data(&shown),
        legend: finger_keys(Key::line),
        panels: shown.iter().map(Shown::panel).collect(),
    })
}

/// Segments with their mean error, from the smallest to the largest; those of which nothing is known are left out.
fn ranked(rows: &EvaluationRows, method: &MethodRows) -> Vec<(usize, f64)> {
    let samples = rows.layout.samples.max(1);
    let mean = |instants: &[inhand_model::PerFinger<f64>]| {
        let known: Vec<f64> = (instants.iter())
            .flat_map(|fingers| *fingers.as_array())
            .filter(|error| error.is_finite())
            .collect();
        known.iter().sum::<f64>() / known.len() as f64
    };
    let mut ranked: Vec<(usize, f64)> = (method.error_m.chunks(samples).enumerate())
        .map(|(segment, instants)| (segment, mean(instants)))
        .filter(|(segment, mean)| mean.is_finite() && *segment < rows.segments.len())
        .collect();
    ranked.sort_unstable_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    ranked
}

impl Shown<'_> {
    fn take(&self) -> &str {
        let take = self.rows.segments[self.segment].take;
        self.rows.takes.get(take).map_or("", String::as_str)
    }

    fn start_s(&self) -> f64 {
        self.rows.segments[self.segment].start as f64 / self.rows.layout.rate_hz
    }

    /// Places of the segment's instants in the rows.
    fn instants(&self) -> std::ops::Range<usize> {
        let samples = self.rows.layout.samples;
        self.segment * samples..(self.segment + 1) * samples
    }

    fn error_mm(&self, row: usize, finger: Finger) -> f64 {
        (self.method.error_m.get(row)).map_or(f64::NAN, |fingers| to_mm(fingers[finger]))
    }

    fn state(&self, row: usize, finger: Finger, planned: bool) -> State {
        let distances = if planned {
            &self.method.distance_m
        } else {
            &self.rows.recorded_distance_m
        };
        let distance_m = distances.as_ref().and_then(|all| all.get(row));
        match (distance_m, self.tau_m) {
            (Some(distance_m), Some(tau_m)) => state(distance_m[finger], tau_m),
            _ => State::Unknown,
        }
    }

    fn panel(&self) -> Panel {
        let rate_hz = self.rows.layout.rate_hz;
        // A sample stands for the time up to the next one, as in the strips.
        let seconds = self.rows.layout.samples as f64 / rate_hz;
        let lines = Finger::ALL.map(|finger| {
            let errors: Vec<f64> = self
                .instants()
                .map(|row| self.error_mm(row, finger))
                .collect();
            let known = errors.iter().copied().filter(|error| error.is_finite());
            let largest = decimals(known.fold(f64::NAN, f64::max), 2);
            let points = errors
                .into_iter()
                .enumerate()
                .map(|(t, error)| (t as f64 / rate_hz, error));
            Series::new(
                format!("{finger}: up to {largest} mm"),
                finger_class(finger),
                points,
            )
        });
        let largest = line_chart::heights(&lines).fold(0.0, f64::max);
        let y = Scale::linear(0.0, nice_end(largest, WANTED_TICKS)).over(FRAME.bottom, FRAME.top);
        let x = Scale::linear(0.0, seconds).over(FRAME.left, FRAME.right);
        let strips = match self.tau_m {
            Some(_) => FINGER_HEIGHT * Finger::COUNT as f64 + STRIPS_TOP - FRAME.bottom,
            None => 0.0,
        };
        let whole = Frame {
            bottom: FRAME.bottom + strips,
            ..FRAME
        };
        let shapes = html! {
            (axes::left(&FRAME, &y, WANTED_TICKS, "error (mm)"))
            (axes::bottom(&whole, &x, WANTED_TICKS, "time in the segment (s)"))
            g data-x=(x.describe()) data-y=(y.describe()) data-x-name="time (s)" data-y-name="error (mm)" {
                (line_chart::lines(&lines, &x, &y, false))
            }
            @if self.tau_m.is_some() { (self.strips(&x, rate_hz)) }
        };
        let (take, start) = (self.take(), decimals(self.start_s(), 2));
        Panel {
            title: format!("{} segment: {take} from {start} s", self.why).into(),
            width: WIDTH,
            height: whole.bottom + axes::BOTTOM_ROOM,
            summary: format!(
                "Error of five fingers over the {} test segment, {take} from {start} s, mean {} mm",
                self.why,
                decimals(to_mm(self.mean_m), 2)
            ),
            shapes,
        }
    }

    fn strips(&self, x: &Scale, rate_hz: f64) -> Markup {
        html! {
            line.axis x1=(Px(FRAME.left)) y1=(Px(FRAME.bottom)) x2=(Px(FRAME.right)) y2=(Px(FRAME.bottom)) {}
            @for finger in Finger::ALL {
                @let top = STRIPS_TOP + FINGER_HEIGHT * finger.index() as f64;
                text.tick x=(Px(FRAME.left - 6.0)) y=(Px(top + 10.0)) text-anchor="end" { (finger.name()) }
                @for (motion, planned, down) in [("planned", true, 0.0), ("recorded", false, STRIP_HEIGHT + 1.0)] {
                    @let runs = strips::runs(self.instants().enumerate().map(|(t, row)| (t, self.state(row, finger, planned))));
                    @let at = |t: usize| x.at(t as f64 / rate_hz);
                    (strips::draw(&format!("{finger}, {motion}"), finger_class(finger), &runs, at, [top + down, STRIP_HEIGHT]))
                }
            }
            text.tick x=(Px(FRAME.right + 5.0)) y=(Px(STRIPS_TOP + 3.0)) { "planned" }
            text.tick x=(Px(FRAME.right + 5.0)) y=(Px(STRIPS_TOP + 17.0)) { "recorded" }
        }
    }
}

fn data(shown: &[Shown<'_>]) -> FigureData {
    let instants: Vec<(&Shown<'_>, usize, usize)> = (shown.iter())
        .flat_map(|one| {
            one.instants()
                .enumerate()
                .map(move |(t, row)| (one, t, row))
        })
        .collect();
    let time = |one: &Shown<'_>, t: usize| one.start_s() + t as f64 / one.rows.layout.rate_hz;
    let columns = FigureData::about(&instants)
        .words("which", |(one, ..)| one.why)
        .words("take", |(one, ..)| one.take())
        .counts("segment", |(one, ..)| one.segment)
        .numbers("time_s", |(one, t, _)| time(one, *t));
    let mut columns = Finger::ALL.into_iter().fold(columns, |columns, finger| {
        let name = format!("{finger}_error_mm");
        columns.numbers(&name, |(one, _, row)| one.error_mm(*row, finger))
    });
    if shown.iter().any(|one| one.tau_m.is_some()) {
        for (motion, planned) in [("planned", true), ("recorded", false)] {
            for finger in Finger::ALL {
                let name = format!("{finger}_contact_{motion}");
                columns = columns.numbers(&name, |(one, _, row)| {
                    match one.state(*row, finger, planned) {
                        State::On => 1.0,
                        State::Off => 0.0,
                        State::Unknown => f64::NAN,
                    }
                });
            }
        }
    }
    columns.done()
}

#[cfg(test)]
mod tests {
    use inhand_model::{PerFinger, SegmentLayout, SegmentOrigin};

    use super::*;

    #[test]
    fn segments_rank_by_their_mean_error() {
        let nothing = PerFinger::new([f64::NAN; 5]);
        let all = |error: f64| PerFinger::new([error; 5]);
        // Two samples a segment: means 3, none, 1 and, of what is known, 2.
        let error_m = vec![
            all(2.0),
            all(4.0),
            nothing,
            nothing,
            all(1.0),
            all(1.0),
            nothing,
            all(2.0),
        ];
        let method = MethodRows {
            name: String::new(),
            error_m,
            distance_m: None,
            hull_distance_m: Vec::new(),
            nearest_pair_m: Vec::new(),
            object_position_error_m: None,
            object_angle_error_rad: None,
            mahalanobis: None,
        };
        let rows = EvaluationRows {
            layout: SegmentLayout {
                samples: 2,
                rate_hz: 10.0,
                object: false,
            },
            takes: vec![String::new()],
            segments: (0..4)
                .map(|k| SegmentOrigin {
                    take: 0,
                    start: 2 * k,
                })
                .collect(),
            filled: Vec::new(),
            object_filled: Vec::new(),
            recorded_distance_m: None,
            recorded_hull_distance_m: Vec::new(),
            recorded_nearest_pair_m: Vec::new(),
            methods: Vec::new(),
        };
        assert_eq!(ranked(&rows, &method), [(2, 1.0), (3, 2.0), (0, 3.0)]);
    }
}
