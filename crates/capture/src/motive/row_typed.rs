//! The row-typed Motive CSV before 1.2, as Tracking Tools and the first versions of Motive wrote it.
//!
//! Every line starts with what it is:
//!
//! ```text
//! comment,"..."
//! righthanded
//! info,framecount,548
//! rigidbody,"Hand",1,3,  x,y,z of each marker
//! frame,0,0.000000,  1,  id,x,y,z,qx,qy,qz,qw,yaw,pitch,roll,  2,  x,y,z,id,name, x,y,z,id,name
//! rigidbody,0,0.000000,"Hand",1,0,3,  x,y,z,id ...,  x,y,z ...,  1,1,1,  q,q,q,  error
//! ```
//!
//! In version 1 a rigid body is called `trackable`, and markers have no names. Rows are as long as
//! what was seen at their frame: which markers there are is known at the last line.
//!
//! * A **body** is placed in `frame` rows, where it is listed while it is tracked.
//! * The places of its markers by the **fit** and as **seen** are in its own row of the frame; both
//!   are called `Hand-Marker 1`, as version 1.1 does, and are of different kinds. A body that is not
//!   tracked repeats its last fit there, which is missing.
//! * **Other markers** of a `frame` row are identified by ID and name. Those without either are
//!   numbered in their row's order, and a finding says so.
//! * **Lengths** are metres, **y** is up, **rates** are not stated: they come from the time stamps.

mod line;
mod seen;

use inhand_model::{
    BodyKind, Finding, LengthUnit, MarkerKind, Recording, RotationOrder, Setting, Source, UpAxis,
};

use self::seen::{Samples, Seen};
use crate::assembly::{Assembly, RotationColumns, Series, Take};
use crate::error::CaptureError;
use crate::header::Facts;
use crate::settings::{ReadSettings, settle};
use crate::table::Rows;
use crate::{start_time, text};

/// Beginnings of lines, and with that of files.
const ROW_TYPES: [&[u8]; 7] = [
    b"comment,",
    b"info,",
    b"frame,",
    b"rigidbody,",
    b"trackable,",
    b"righthanded",
    b"lefthanded",
];

/// Most rows that are handed on at a time, and most values where a row has fewer.
const PIECE_ROWS: usize = 1024;
const PIECE_VALUES: usize = 1 << 17;

/// Tracks get at most this many times the samples that the file has...
const SAMPLES_PER_SEEN: u64 = 10;
/// ...or this many: a marker seen once must not cost a sample for each frame of a long take.
const SAMPLES_AT_LEAST: u64 = 1_000_000;

/// A rate is taken to be a round number where that moves the last frame by less than this, frames.
const ROUND_RATE_FRAMES: f64 = 0.25;

/// Largest distance of a time stamp from the even clock without a finding, frames.
const LATE_FRAMES: f64 = 0.5;

pub(crate) fn looks_like(bytes: &[u8]) -> bool {
    ROW_TYPES.iter().any(|kind| bytes.starts_with(kind))
}

/// Reads a whole file without byte-order mark.
pub(crate) fn read(
    bytes: &[u8],
    file: &str,
    settings: &ReadSettings,
) -> Result<Recording, CaptureError> {
    let mut seen = Seen::read(bytes, file)?;
    let frames = std::mem::take(&mut seen.frames);
    if frames.is_empty() {
        return Err(CaptureError::no_samples(file));
    }
    let (unit, rotation) = (LengthUnit::Metres, RotationOrder::Quaternion);
    settle(
        file,
        Setting::Units,
        Some(unit),
        settings.length_unit,
        LengthUnit::name,
    )?;
    let given = settings.rotation_order;
    settle(
        file,
        Setting::RotationOrder,
        Some(rotation),
        given,
        |order| order,
    )?;
    let stamped = frames
        .iter()
        .copied()
        .filter(|(.., time_s)| time_s.is_finite());
    let times = Times {
        all: stamped.collect(),
    };
    let start = start_time::parse("start time", None);
    let rate_hz = times.rate_hz(file)?;
    let clock = start.clock(rate_hz, file)?;
    let mut findings: Vec<Finding> = start.finding.into_iter().collect();
    let message = format!("the file states none: {rate_hz} Hz by its time stamps");
    findings.push(Finding::info("rate", message));
    findings.append(&mut seen.findings);
    let facts = Facts {
        file,
        line: 1,
        by_key: std::mem::take(&mut seen.facts),
    };
    let rotation = (!seen.bodies.is_empty()).then_some(rotation);
    let mut columns = Columns::default();
    if !columns.add_all(seen, frames.len(), &mut findings) {
        let problem = "expected frames that place the bodies defined above them, found too few: is \
                       the file damaged?";
        return Err(CaptureError::in_line(file, 1, problem));
    }
    let declared_rows = facts.count("framecount", &mut findings);
    let take = Take {
        name: text::stem(file).to_owned(),
        clock,
        counts_from: 0,
        events: Vec::new(),
        source: Source {
            format: format!("Motive CSV {}", facts.get("version").unwrap_or("1")),
            length_unit: unit,
            up_axis: settings.up_axis.unwrap_or(UpAxis::Y),
            rotation,
            header: facts.by_key,
        },
        series: std::mem::take(&mut columns.series),
        zero_is_missing: false,
        time_tolerance_s: LATE_FRAMES / rate_hz,
        declared_rows,
        findings,
    };
    let mut assembly = Assembly::new(file, take, columns.width, frames.len() as u64);
    let piece_rows = (PIECE_VALUES / columns.width.max(1)).clamp(1, PIECE_ROWS);
    for (piece, frames) in frames.chunks(piece_rows).enumerate() {
        assembly.add(columns.rows(piece * piece_rows, frames))?;
        assembly.fill(usize::MAX);
    }
    assembly.finish()
}

/// The things of a file as columns of rows that are all alike.
#[derive(Default)]
struct Columns {
    series: Vec<Series>,
    /// Values of a row.
    width: usize,
    /// Place of each thing among the values of a row, its number of values, its samples, and how many
    /// of them were passed on.
    things: Vec<(usize, usize, Samples, usize)>,
}

impl Columns {
    /// Makes room for all bodies, and for the other markers that are seen most often as far as memory
    /// stays in proportion to the file; false where it cannot even hold the bodies.
    fn add_all(&mut self, seen: Seen, frames: usize, findings: &mut Vec<Finding>) -> bool {
        let samples = (SAMPLES_PER_SEEN * seen.count).max(SAMPLES_AT_LEAST);
        let tracks = usize::try_from(samples / frames as u64).unwrap_or(usize::MAX);
        let of_bodies = seen.bodies.iter().map(|body| 1 + 2 * body.parts.len());
        let Some(left) = tracks.checked_sub(of_bodies.sum()) else {
            return false;
        };
        for body in seen.bodies {
            let at = self.add(7, body.pose);
            let rotation = RotationColumns::Quaternion([at + 3, at + 4, at + 5, at + 6]);
            let (kind, position) = (BodyKind::RigidBody, [at, at + 1, at + 2]);
            let pose = Series::body(&body.name, &body.id, kind, rotation, position, None);
            self.series.push(pose);
            for (n, [fitted, seen]) in body.parts.into_iter().enumerate() {
                let name = format!("{}-Marker {}", body.name, n + 1);
                self.add_marker(&name, "", MarkerKind::RigidBodyMarker, 4, fitted);
                self.add_marker(&name, "", MarkerKind::Labelled, 3, seen);
            }
        }
        let mut by_count: Vec<usize> = (0..seen.others.len()).collect();
        by_count.sort_by_key(|&n| std::cmp::Reverse(seen.others[n].samples.rows.len()));
        let mut kept = vec![false; seen.others.len()];
        by_count.iter().take(left).for_each(|&n| kept[n] = true);
        let left = left.saturating_sub(by_count.len());
        let mut lost = Vec::new();
        for (other, kept) in seen.others.into_iter().zip(kept) {
            if !kept {
                lost.push(other.samples.rows.len());
                continue;
            }
            // A marker that the software cannot identify is called `Marker-1718`.
            let kind = match other.name.is_empty() || other.name.starts_with("Marker-") {
                true => MarkerKind::Unlabelled,
                false => MarkerKind::Labelled,
            };
            let name = match other.name.as_str() {
                "" => format!("Marker-{}", other.id),
                name => name.to_owned(),
            };
            self.add_marker(&name, &other.id, kind, 3, other.samples);
        }
        for (n, samples) in seen.nameless.into_iter().enumerate() {
            if n < left {
                let name = format!("Unlabeled {}", n + 1);
                self.add_marker(&name, "", MarkerKind::Unlabelled, 3, samples);
            } else {
                lost.push(samples.rows.len());
            }
        }
        if !lost.is_empty() {
            let message = format!(
                "{} markers are seen too seldom to give each a track in {frames} frames: {} of \
                 their samples are not read",
                lost.len(),
                lost.iter().sum::<usize>()
            );
            findings.push(Finding::warning("markers", message));
        }
        true
    }

    /// Adds a marker, with its quality behind the position where it has four values.
    fn add_marker(
        &mut self,
        name: &str,
        id: &str,
        kind: MarkerKind,
        values: usize,
        samples: Samples,
    ) {
        let at = self.add(values, samples);
        let quality = (values == 4).then_some(at + 3);
        let marker = Series::marker(name, id, kind, [at, at + 1, at + 2], quality);
        self.series.push(marker);
    }

    /// Adds a thing of so many values; returns its place.
    fn add(&mut self, values: usize, samples: Samples) -> usize {
        let at = self.width;
        self.things.push((at, values, samples, 0));
        self.width += values;
        at
    }

    /// The rows of the frames from `start` on, NaN where they have no value.
    fn rows(&mut self, start: usize, frames: &[(usize, i64, f64)]) -> Rows {
        let mut values = vec![f64::NAN; self.width * frames.len()];
        for (at, count, samples, next) in &mut self.things {
            while let Some(&row) = samples.rows.get(*next)
                && row < start + frames.len()
            {
                let place = (row - start) * self.width + *at;
                let found = &samples.values[*next * *count..][..*count];
                values[place..place + *count].copy_from_slice(found);
                *next += 1;
            }
        }
        Rows {
            frames: frames.iter().map(|&(_, number, _)| number).collect(),
            times_s: frames.iter().map(|&(.., time_s)| time_s).collect(),
            values,
            cut: None,
            lines: frames.iter().map(|&(line, ..)| line).collect(),
        }
    }
}

/// Time stamps against frame numbers.
struct Times {
    /// Line, frame and time of each row that has one.
    all: Vec<(usize, i64, f64)>,
}

impl Times {
    /// The rate of the time stamps, made round where that fits.
    fn rate_hz(&self, file: &str) -> Result<f64, CaptureError> {
        let measured_hz = self.measured_hz().filter(|hz| hz.is_finite() && *hz > 0.0);
        let measured_hz = measured_hz.ok_or_else(|| {
            let problem = format!(
                "expected two frames whose numbers and time stamps rise, since this format states \
                 no rate, found {} with a time stamp: export the take again",
                self.all.len()
            );
            let line = self.all.last().map_or(1, |&(line, ..)| line);
            CaptureError::in_line(file, line, problem)
        })?;
        let frames = match self.all[..] {
            [(_, first, _), .., (_, last, _)] => (last - first) as f64,
            _ => 0.0,
        };
        let fits = |hz: f64| ((hz / measured_hz - 1.0) * frames).abs() < ROUND_RATE_FRAMES;
        let round = [(measured_hz / 10.0).round() * 10.0, measured_hz.round()];
        let round_hz = round.into_iter().find(|&hz| hz > 0.0 && fits(hz));
        Ok(round_hz.unwrap_or(measured_hz))
    }

    /// Frames a second: the median over all pairs of rows that are half of the take apart, which
    /// neither the jitter of time stamps nor a clock that hangs for a while moves far.
    fn measured_hz(&self) -> Option<f64> {
        let apart = self.all.len() / 2;
        let pairs = self.all.iter().zip(self.all.iter().skip(apart.max(1)));
        let rates = pairs.map(|(&(_, f0, t0), &(_, f1, t1))| (f1 - f0) as f64 / (t1 - t0));
        let mut rates: Vec<f64> = rates.collect();
        if rates.is_empty() {
            return None;
        }
        let middle = rates.len() / 2;
        Some(*rates.select_nth_unstable_by(middle, f64::total_cmp).1)
    }
}
