//! The instants behind an evaluation as a table, a row for each method, segment and sample; and read back from
//! Parquet: all of them, or of one method and finger at a time, since those of many sessions do not fit into
//! memory at once.

use std::ops::Range;
use std::path::Path;

use inhand_model::{
    EvaluationRows, Finger, MethodRows, PerFinger, SegmentLayout, SegmentOrigin, Segments,
    Trajectory, stored,
};
use serde::{Deserialize, Serialize};

use crate::error::ExportError;
use crate::parquet_file::ParquetTable;
use crate::table::{Table, TableBuilder};

/// Numbers of each finger at every instant.
type Fingers = Vec<PerFinger<f64>>;

/// An instant of a method.
#[derive(Clone, Copy)]
struct Instant<'a> {
    method: &'a MethodRows,
    /// Place of the method.
    place: usize,
    origin: SegmentOrigin,
    segment: usize,
    sample: usize,
    /// Counted over all segments.
    at: usize,
}

impl Instant<'_> {
    /// A number that some methods do not have.
    fn of(self, values: &Option<Fingers>, finger: Finger) -> f64 {
        values
            .as_ref()
            .map_or(f64::NAN, |values| values[self.at][finger])
    }
}

/// Positions behind the rows: those of `segments` and the trajectories of each method, in the frame `hand`.
#[derive(Clone, Copy, Debug)]
pub struct RowPositions<'a> {
    /// The recorded motion.
    pub segments: &'a Segments,
    /// By method, a trajectory for each segment; `None` where the plan failed.
    pub planned: &'a [&'a [Option<Trajectory>]],
}

impl<'a> RowPositions<'a> {
    fn planned_m(self, i: Instant<'a>, finger: Finger, axis: usize) -> f64 {
        let trajectory = self.planned[i.place][i.segment].as_ref();
        trajectory.map_or(f64::NAN, |trajectory| {
            trajectory.configuration_m(i.sample)[3 * finger.index() + axis]
        })
    }

    fn recorded_m(self, i: Instant<'a>, finger: Finger, axis: usize) -> f64 {
        self.segments.column_m(i.segment)[SegmentLayout::row(i.sample, finger, axis)]
    }
}

/// A table of every evaluated instant, for own statistics and figures.
///
/// Columns: `session`, `method`, `take`; `segment` (counted over all takes, from 0), `start_sample` of the
/// segment in its take, `sample` inside the segment, `time_s` since the segment's first sample; for each
/// finger `FINGER.error_m`, `FINGER.filled` (1 where the recorded fingertip was filled), and, where an
/// object is known, `FINGER.distance_m` and `FINGER.recorded_distance_m` (signed, to its surface) and once
/// `object_filled`; `FINGER.hull_distance_m` (signed, to the training hull) and
/// `FINGER.recorded_hull_distance_m`; `nearest_pair_m` and `recorded_nearest_pair_m`; where a method plans them,
/// `FINGER.mahalanobis` (of the recorded fingertip from the prediction region, no unit), `object_position_error_m`
/// and `object_angle_error_rad`; with `positions` also `FINGER.planned_x_m` and `FINGER.recorded_x_m`, and so on for y
/// and z. A blank cell is a number that does not exist: the plan failed, or the object is missing.
pub fn evaluation_rows<'a>(
    session: &'a str,
    rows: &'a EvaluationRows,
    positions: Option<RowPositions<'a>>,
) -> Table<'a> {
    let (instants, samples) = (rows.instants(), rows.layout.samples);
    // Without instants there are no rows, so that nothing is divided by zero.
    let mut table = TableBuilder::new(rows.methods.len() * instants, move |row| {
        let at = row % instants;
        Instant {
            method: &rows.methods[row / instants],
            place: row / instants,
            origin: rows.segments[at / samples],
            segment: at / samples,
            sample: at % samples,
            at,
        }
    });
    let any = |has: fn(&MethodRows) -> bool| rows.methods.iter().any(has);
    let or_missing =
        |values: &Option<Vec<f64>>, k| values.as_ref().map_or(f64::NAN, |v| stored(v[k]));
    table.words("session", move |_| session);
    table.words("method", |i| &i.method.name);
    table.words("take", |i| &rows.takes[i.origin.take]);
    table.counts("segment", |i| i.segment);
    table.counts("start_sample", |i| i.origin.start);
    table.counts("sample", |i| i.sample);
    (table.numbers("time_s", "s", |i| i.sample as f64 / rows.layout.rate_hz)).shared = true;
    for finger in Finger::ALL {
        let name = |suffix: &str| format!("{}.{suffix}", finger.name());
        let error_m = move |i: Instant<'_>| stored(i.method.error_m[i.at][finger]);
        table.numbers(name("error_m"), "m", error_m);
        table.counts(name("filled"), move |i| rows.filled[i.at][finger].into());
        if let Some(recorded_m) = &rows.recorded_distance_m {
            let distance_m = move |i: Instant<'_>| stored(i.of(&i.method.distance_m, finger));
            table.numbers(name("distance_m"), "m", distance_m);
            let recorded_m = move |i: Instant<'_>| stored(recorded_m[i.at][finger]);
            (table.numbers(name("recorded_distance_m"), "m", recorded_m)).shared = true;
        }
        let hull_m = move |i: Instant<'_>| stored(i.method.hull_distance_m[i.at][finger]);
        table.numbers(name("hull_distance_m"), "m", hull_m);
        let recorded_m = move |i: Instant<'_>| stored(rows.recorded_hull_distance_m[i.at][finger]);
        (table.numbers(name("recorded_hull_distance_m"), "m", recorded_m)).shared = true;
        if any(|method| method.mahalanobis.is_some()) {
            let mahalanobis = move |i: Instant<'_>| stored(i.of(&i.method.mahalanobis, finger));
            table.numbers(name("mahalanobis"), "1", mahalanobis);
        }
        if let Some(positions) = positions {
            type PositionOf<'a> = fn(RowPositions<'a>, Instant<'a>, Finger, usize) -> f64;
            let of: [(&str, PositionOf<'a>); 2] = [
                ("planned", RowPositions::planned_m),
                ("recorded", RowPositions::recorded_m),
            ];
            for (motion, position_m) in of {
                for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
                    let name = name(&format!("{motion}_{letter}_m"));
                    let number = move |i| position_m(positions, i, finger, axis);
                    let column = table.numbers(name, "m", number);
                    (column.frame, column.shared) = ("hand", motion == "recorded");
                }
            }
        }
    }
    if rows.recorded_distance_m.is_some() {
        table.counts("object_filled", |i| rows.object_filled[i.at].into());
    }
    let planned_m = |i: Instant<'_>| stored(i.method.nearest_pair_m[i.at]);
    table.numbers("nearest_pair_m", "m", planned_m);
    let recorded_m = |i: Instant<'_>| stored(rows.recorded_nearest_pair_m[i.at]);
    (table.numbers("recorded_nearest_pair_m", "m", recorded_m)).shared = true;
    if any(|method| method.object_position_error_m.is_some()) {
        let distance_m = move |i: Instant<'_>| or_missing(&i.method.object_position_error_m, i.at);
        table.numbers("object_position_error_m", "m", distance_m);
        let angle_rad = move |i: Instant<'_>| or_missing(&i.method.object_angle_error_rad, i.at);
        table.numbers("object_angle_error_rad", "rad", angle_rad);
    }
    table.finish()
}

/// Key of the file's metadata with [`RowsFacts`].
const FACTS: &str = "inhand.rows";

/// Key of a file's metadata with the key of the results that it belongs to.
pub const RESULTS_KEY: &str = "inhand.key";

/// Facts that the columns do not hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct RowsFacts {
    session: String,
    methods: Vec<String>,
    takes: Vec<String>,
    segments: usize,
    segment_samples: usize,
    rate_hz: f64,
}

/// Metadata of a table of rows, for [`write_parquet`](crate::write_parquet).
pub fn rows_facts(session: &str, rows: &EvaluationRows) -> (&'static str, String) {
    let methods = rows.methods.iter().map(|method| method.name.clone());
    let facts = RowsFacts {
        session: session.to_owned(),
        methods: methods.collect(),
        takes: rows.takes.clone(),
        segments: rows.segments.len(),
        segment_samples: rows.layout.samples,
        rate_hz: rows.layout.rate_hz,
    };
    let text = serde_json::to_value(facts).unwrap_or_default().to_string();
    (FACTS, text)
}

/// Rows of an evaluation in a Parquet file.
#[derive(Debug)]
pub struct RowsFile {
    table: ParquetTable,
    facts: RowsFacts,
}

impl RowsFile {
    /// Opens a file that [`evaluation_rows`] made.
    ///
    /// # Errors
    ///
    /// [`ExportError::Content`] for a file that is cut, or holds another table.
    pub fn open(path: &Path) -> Result<Self, ExportError> {
        let table = ParquetTable::open(path)?;
        let expected = "a table of the instants behind an evaluation";
        let wrong = |expected: &str, found: &str| {
            let hint = "`inhand run` and `inhand evaluate --rows` write it";
            ExportError::file(&table.file, expected, found, hint)
        };
        let facts = (table.fact(FACTS))
            .ok_or_else(|| wrong(expected, "a Parquet file of other content"))?;
        let facts: RowsFacts =
            serde_json::from_str(facts).map_err(|error| wrong(expected, &error.to_string()))?;
        let (methods, segments, samples) =
            (facts.methods.len(), facts.segments, facts.segment_samples);
        let instants = segments.checked_mul(samples);
        if instants.and_then(|instants| instants.checked_mul(methods)) != Some(table.rows()) {
            let expected = format!("{methods} methods x {segments} segments x {samples} samples");
            return Err(wrong(&expected, &format!("{} rows", table.rows())));
        }
        Ok(Self { table, facts })
    }

    /// Name of the session.
    pub fn session(&self) -> &str {
        &self.facts.session
    }

    /// Key of the results that it belongs to; `None` in files of before.
    pub fn key(&self) -> Option<&str> {
        self.table.fact(RESULTS_KEY)
    }

    /// Names of the methods, in their order.
    pub fn methods(&self) -> &[String] {
        &self.facts.methods
    }

    /// Errors of a finger, metres, at every instant of a method; NaN where its plan failed.
    ///
    /// # Errors
    ///
    /// [`ExportError::Content`] for a method that is not there and damaged bytes.
    pub fn error_m(&self, method: &str, finger: Finger) -> Result<Vec<f64>, ExportError> {
        let place = self.facts.methods.iter().position(|name| name == method);
        let place = place.ok_or_else(|| {
            ExportError::file(
                &self.table.file,
                format!("the method \"{method}\""),
                self.facts.methods.join(", "),
                "run the session with that method",
            )
        })?;
        self.finger(place, finger, "error_m")
    }

    /// All rows.
    ///
    /// # Errors
    ///
    /// [`ExportError::Content`] for damaged bytes.
    pub fn read(&self) -> Result<EvaluationRows, ExportError> {
        let (facts, table) = (&self.facts, &self.table);
        let object = table.has("object_filled");
        let mut rows = EvaluationRows {
            layout: SegmentLayout {
                samples: facts.segment_samples,
                rate_hz: facts.rate_hz,
                object,
            },
            takes: facts.takes.clone(),
            segments: Vec::new(),
            filled: Vec::new(),
            object_filled: Vec::new(),
            recorded_distance_m: None,
            recorded_hull_distance_m: Vec::new(),
            recorded_nearest_pair_m: Vec::new(),
            methods: Vec::new(),
        };
        if facts.methods.is_empty() {
            return Ok(rows);
        }
        for (place, name) in facts.methods.iter().enumerate() {
            rows.methods.push(self.method(place, name, object)?);
        }
        let instants = 0..self.instants();
        let filled = PerFinger::try_from_fn(|finger| {
            table.counts(&format!("{}.filled", finger.name()), instants.clone())
        })?;
        rows.segments = self.segments()?;
        rows.filled = (instants.clone())
            .map(|k| filled.each_ref().map(|filled| filled[k] != 0))
            .collect();
        rows.object_filled = vec![false; instants.len()];
        if object {
            let filled = table.counts("object_filled", instants.clone())?;
            rows.object_filled = filled.into_iter().map(|filled| filled != 0).collect();
            rows.recorded_distance_m = Some(self.fingers(0, "recorded_distance_m")?);
        }
        rows.recorded_hull_distance_m = self.fingers(0, "recorded_hull_distance_m")?;
        rows.recorded_nearest_pair_m = table.numbers("recorded_nearest_pair_m", instants)?;
        Ok(rows)
    }

    fn method(&self, place: usize, name: &str, object: bool) -> Result<MethodRows, ExportError> {
        let (table, rows) = (&self.table, self.rows_of(place));
        // Columns that some methods do not have are blank in every row of theirs.
        let if_known = |column: &str| -> Result<Option<Vec<f64>>, ExportError> {
            let numbers = (table.has(column)).then(|| table.numbers(column, rows.clone()));
            let numbers = numbers.transpose()?;
            Ok(numbers.filter(|numbers| numbers.iter().any(|value| !value.is_nan())))
        };
        let mahalanobis = (table.has("thumb.mahalanobis"))
            .then(|| self.fingers(place, "mahalanobis"))
            .transpose()?;
        let is_known = |fingers: &PerFinger<f64>| fingers.as_array().iter().any(|d| !d.is_nan());
        Ok(MethodRows {
            name: name.to_owned(),
            error_m: self.fingers(place, "error_m")?,
            distance_m: (object.then(|| self.fingers(place, "distance_m"))).transpose()?,
            hull_distance_m: self.fingers(place, "hull_distance_m")?,
            nearest_pair_m: table.numbers("nearest_pair_m", rows.clone())?,
            object_position_error_m: if_known("object_position_error_m")?,
            object_angle_error_rad: if_known("object_angle_error_rad")?,
            mahalanobis: mahalanobis.filter(|found| found.iter().any(is_known)),
        })
    }

    /// Where the segments come from, as the rows of the first method say.
    fn segments(&self) -> Result<Vec<SegmentOrigin>, ExportError> {
        let instants = 0..self.instants();
        let takes = self.table.words("take", instants.clone())?;
        let starts = self.table.counts("start_sample", instants)?;
        let samples = self.facts.segment_samples.max(1);
        (takes.iter().zip(starts).step_by(samples))
            .map(|(name, start)| {
                let take = self.facts.takes.iter().position(|take| take == name)?;
                let start = usize::try_from(start).ok()?;
                Some(SegmentOrigin { take, start })
            })
            .collect::<Option<_>>()
            .ok_or_else(|| {
                ExportError::file(
                    &self.table.file,
                    format!("segments of {}", self.facts.takes.join(", ")),
                    "one of another take, or before its start",
                    "make the table again",
                )
            })
    }

    fn instants(&self) -> usize {
        self.facts.segments * self.facts.segment_samples
    }

    fn rows_of(&self, method: usize) -> Range<usize> {
        method * self.instants()..(method + 1) * self.instants()
    }

    fn finger(&self, method: usize, finger: Finger, name: &str) -> Result<Vec<f64>, ExportError> {
        let column = format!("{}.{name}", finger.name());
        self.table.numbers(&column, self.rows_of(method))
    }

    fn fingers(&self, method: usize, name: &str) -> Result<Fingers, ExportError> {
        let columns = PerFinger::try_from_fn(|finger| self.finger(method, finger, name))?;
        Ok((0..self.instants())
            .map(|k| columns.each_ref().map(|column| column[k]))
            .collect())
    }
}
