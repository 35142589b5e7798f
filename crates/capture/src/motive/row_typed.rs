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
//! what was seen at their frame, so that the file is looked through once for what there is in it,
//! and then read.
//!
//! * A **body** is placed in `frame` rows, where it is listed while it is tracked.
//! * The places of its markers by the **fit** and as **seen** are in its own row of the frame; both
//!   are called `Hand-Marker 1`, as version 1.1 does, and are of different kinds. A body that is not
//!   tracked repeats its last fit there, which is missing.
//! * **Other markers** of a `frame` row go by ID and name. Those without either are numbered in
//!   their row's order, and a finding says so.
//! * **Lengths** are metres, **y** is up, **rates** are not stated: they come from the time stamps.

mod entities;
mod instants;
mod layout;
mod line;

use inhand_model::{Finding, LengthUnit, Recording, RotationOrder, Source, UpAxis};

use self::entities::Entities;
use self::instants::Instants;
use self::layout::Layout;
use crate::assembly::{self, Assembly, Parsed, Pieces, Take};
use crate::error::CaptureError;
use crate::settings::ReadSettings;
use crate::table::Rows;
use crate::{start_time, text};

/// How lines start, and with that files.
const ROW_TYPES: [&[u8]; 7] = [
    b"comment,",
    b"info,",
    b"frame,",
    b"rigidbody,",
    b"trackable,",
    b"righthanded",
    b"lefthanded",
];

/// Rows that are handed on at a time, and values at which that is enough.
const PIECE_ROWS: usize = 1024;
const PIECE_VALUES: usize = 1 << 17;

/// A rate is taken to be a round number where that moves the last frame by less than this, frames.
const ROUND_RATE_FRAMES: f64 = 0.25;

/// How far a time stamp may be from the even clock, frames, before somebody should look at it.
const LATE_FRAMES: f64 = 0.5;

pub(super) fn looks_like(bytes: &[u8]) -> bool {
    ROW_TYPES.iter().any(|kind| bytes.starts_with(kind))
}

/// Reads a whole file without byte-order mark.
pub(super) fn read(
    bytes: &[u8],
    file: &str,
    settings: &ReadSettings,
) -> Result<Recording, CaptureError> {
    let (prelude, mut instants) = Instants::open(bytes, file)?;
    let (mut entities, mut times) = (Entities::new(&prelude), Times::default());
    while let Some(instant) = instants.next()? {
        times.add(instant.line, instant.frame.number, instant.frame.time_s);
        entities.see(&instant);
    }
    if entities.frames == 0 {
        return Err(CaptureError::NoSamples {
            file: file.to_owned(),
        });
    }

    let (unit, rotation) = (LengthUnit::Metres, RotationOrder::Quaternion);
    settings.settle_length_unit(file, Some(unit))?;
    settings.settle_rotation_order(file, Some(rotation))?;
    let start = start_time::parse("start time", None);
    let clock = start.clock(times.rate_hz(file)?, file)?;
    let (layout, lost) = Layout::new(&entities).ok_or_else(|| CaptureError::Header {
        file: file.to_owned(),
        line: 1,
        expected: "definitions of the bodies that the frames have".to_owned(),
        found: format!(
            "{} bodies for {} frames",
            entities.bodies.len(),
            entities.frames
        ),
        hint: "is the file damaged?",
    })?;

    let mut findings: Vec<Finding> = start.finding.into_iter().collect();
    findings.extend(times.findings(clock.rate_hz()));
    findings.extend(entities.findings());
    findings.extend(lost);
    let version = prelude.facts.get("version").map_or("1", String::as_str);
    let declared_rows = prelude.facts.get("framecount").map(String::as_str);
    let declared_rows = assembly::declared_rows("framecount", declared_rows, &mut findings);
    let take = Take {
        name: text::stem(file).to_owned(),
        clock,
        source: Source {
            format: format!("Motive CSV {version}"),
            length_unit: unit,
            up_axis: settings.up_axis.unwrap_or(UpAxis::Y),
            rotation: (!entities.bodies.is_empty()).then_some(rotation),
            header: prelude.facts.clone(),
        },
        entities: layout.entities(&entities),
        zero_is_missing: false,
        declared_rows,
        findings,
    };
    let (width, frames) = (layout.width, entities.frames);
    let pieces = Frames {
        instants: Instants::open(bytes, file)?.1,
        entities: &entities,
        layout,
    };
    Assembly::new(pieces, file, take, width, frames, frames).read_whole()
}

/// Time stamps against frame numbers.
#[derive(Default)]
struct Times {
    /// Line, frame and time of each row that has one.
    all: Vec<(usize, i64, f64)>,
}

impl Times {
    fn add(&mut self, line: usize, frame: i64, time_s: f64) {
        if time_s.is_finite() {
            self.all.push((line, frame, time_s));
        }
    }

    /// The rate of the time stamps, made round where that fits.
    fn rate_hz(&self, file: &str) -> Result<f64, CaptureError> {
        let measured_hz = self.measured_hz().filter(|hz| hz.is_finite() && *hz > 0.0);
        let measured_hz = measured_hz.ok_or_else(|| CaptureError::Header {
            file: file.to_owned(),
            line: self.all.last().map_or(1, |&(line, ..)| line),
            expected: "two frames whose numbers and time stamps rise, since this format states no \
                       rate"
                .to_owned(),
            found: format!("{} with a time stamp", self.all.len()),
            hint: "export the take again",
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

    fn findings(&self, rate_hz: f64) -> Vec<Finding> {
        let mut findings = vec![Finding::info(
            "rate",
            format!("the file states none: {rate_hz} Hz by its time stamps"),
        )];
        let Some(&(_, first, start_s)) = self.all.first() else {
            return findings;
        };
        let off = |&(line, frame, time_s): &(usize, i64, f64)| {
            let even_s = start_s + (frame - first) as f64 / rate_hz;
            (line, (time_s - even_s).abs())
        };
        let worst = self.all.iter().map(off).max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((line, off_s)) = worst
            && off_s * rate_hz > LATE_FRAMES
        {
            findings.push(Finding::warning(
                format!("line {line}"),
                format!(
                    "its time stamp is {:.3} ms from the even clock of {rate_hz} Hz; this is the \
                     worst row: times are taken from the frames",
                    off_s * 1e3
                ),
            ));
        }
        findings
    }
}

/// The frames as rows of one kind.
struct Frames<'a> {
    instants: Instants<'a>,
    entities: &'a Entities,
    layout: Layout,
}

impl Pieces for Frames<'_> {
    fn next(&mut self) -> Result<Option<Parsed>, CaptureError> {
        let (mut frames, mut lines, mut values) = (Vec::new(), Vec::new(), Vec::new());
        while values.len() < PIECE_VALUES
            && let Some(instant) = self.instants.next()?
        {
            self.layout.fill(self.entities, &instant, &mut values);
            frames.push(instant.frame.number);
            lines.push(instant.line);
            if frames.len() == PIECE_ROWS {
                break;
            }
        }
        let rows = Rows::new(frames, lines, values);
        Ok((rows.len() > 0).then(|| (vec![rows], Ok(()))))
    }
}
