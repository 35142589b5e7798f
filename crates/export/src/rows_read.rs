//! The instants behind an evaluation, read back from Parquet: all of them, or of one method and finger at a
//! time, since those of many sessions do not fit into memory at once.

use std::path::Path;

use inhand_model::{EvaluationRows, Finger, MethodRows, PerFinger, SegmentLayout, SegmentOrigin};
use serde::{Deserialize, Serialize};

use crate::error::TableError;
use crate::parquet_read::ParquetTable;

/// Key of the file's metadata with [`RowsFacts`].
const FACTS: &str = "inhand.rows";

/// What the columns do not say.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct RowsFacts {
    session: String,
    methods: Vec<String>,
    takes: Vec<String>,
    segments: usize,
    segment_samples: usize,
    rate_hz: f64,
}

/// What a table of rows says of itself, for [`write_parquet`](crate::write_parquet).
pub fn rows_facts(session: &str, rows: &EvaluationRows) -> (&'static str, String) {
    let facts = RowsFacts {
        session: session.to_owned(),
        methods: rows
            .methods
            .iter()
            .map(|method| method.name.clone())
            .collect(),
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
    file: String,
    table: ParquetTable,
    facts: RowsFacts,
}

impl RowsFile {
    /// Opens a file that [`evaluation_rows`](crate::evaluation_rows) made.
    ///
    /// # Errors
    ///
    /// [`TableError::File`] for a file that is cut, or holds another table.
    pub fn open(path: &Path) -> Result<Self, TableError> {
        let file = path.display().to_string();
        let table = ParquetTable::open(path)?;
        let wrong = |expected: &str, found: String| TableError::File {
            file: file.clone(),
            expected: expected.to_owned(),
            found,
            hint: "`inhand run` and `inhand evaluate --rows` write it".to_owned(),
        };
        let expected = "a table of the instants behind an evaluation";
        let facts = table
            .fact(FACTS)
            .ok_or_else(|| wrong(expected, "a Parquet file of other content".to_owned()))?;
        let facts: RowsFacts =
            serde_json::from_str(facts).map_err(|error| wrong(expected, error.to_string()))?;
        let rows = (facts.segments.checked_mul(facts.segment_samples))
            .and_then(|instants| instants.checked_mul(facts.methods.len()));
        if rows != Some(table.rows()) {
            let expected = format!(
                "{} methods x {} segments x {} samples",
                facts.methods.len(),
                facts.segments,
                facts.segment_samples
            );
            return Err(wrong(&expected, format!("{} rows", table.rows())));
        }
        Ok(Self { file, table, facts })
    }

    /// Name of the session.
    pub fn session(&self) -> &str {
        &self.facts.session
    }

    /// Names of the methods, in their order.
    pub fn methods(&self) -> &[String] {
        &self.facts.methods
    }

    /// Errors of a finger, metres, at every instant of a method; NaN where its plan failed.
    ///
    /// # Errors
    ///
    /// [`TableError::File`] for a method that is not there and damaged bytes.
    pub fn error_m(&self, method: &str, finger: Finger) -> Result<Vec<f64>, TableError> {
        let place = self.facts.methods.iter().position(|name| name == method);
        let place = place.ok_or_else(|| TableError::File {
            file: self.file.clone(),
            expected: format!("the method \"{method}\""),
            found: self.facts.methods.join(", "),
            hint: "run the session with that method".to_owned(),
        })?;
        self.numbers(place, finger, "error_m")
    }

    /// All rows.
    ///
    /// # Errors
    ///
    /// [`TableError::File`] for damaged bytes.
    pub fn read(&self) -> Result<EvaluationRows, TableError> {
        let has_object = self.table.has("object_filled");
        let instants = 0..self.instants();
        let methods = (self.facts.methods.iter().enumerate())
            .map(|(place, name)| {
                let distance_m = has_object.then(|| self.fingers(place, "distance_m"));
                Ok(MethodRows {
                    name: name.clone(),
                    error_m: self.fingers(place, "error_m")?,
                    distance_m: distance_m.transpose()?,
                    hull_distance_m: self.fingers(place, "hull_distance_m")?,
                    nearest_pair_m: (self.table).numbers("nearest_pair_m", self.rows_of(place))?,
                    object_position_error_m: self.if_known(place, "object_position_error_m")?,
                    object_angle_error_rad: self.if_known(place, "object_angle_error_rad")?,
                    mahalanobis: self.mahalanobis(place)?,
                })
            })
            .collect::<Result<_, TableError>>()?;
        if self.facts.methods.is_empty() {
            return Ok(self.without_methods());
        }
        let filled = PerFinger::try_from_fn(|finger| {
            let column = format!("{}.filled", finger.name());
            self.table.counts(&column, instants.clone())
        })?;
        let object_filled = match has_object {
            true => self.table.counts("object_filled", instants.clone())?,
            false => vec![0; instants.len()],
        };
        let recorded_m = has_object.then(|| self.fingers(0, "recorded_distance_m"));
        Ok(EvaluationRows {
            segments: self.segments()?,
            filled: instants
                .map(|k| filled.each_ref().map(|filled| filled[k] != 0))
                .collect(),
            object_filled: object_filled
                .into_iter()
                .map(|filled| filled != 0)
                .collect(),
            recorded_distance_m: recorded_m.transpose()?,
            recorded_hull_distance_m: self.fingers(0, "recorded_hull_distance_m")?,
            recorded_nearest_pair_m: (self.table)
                .numbers("recorded_nearest_pair_m", self.rows_of(0))?,
            methods,
            ..self.without_methods()
        })
    }

    fn without_methods(&self) -> EvaluationRows {
        EvaluationRows {
            layout: SegmentLayout {
                samples: self.facts.segment_samples,
                rate_hz: self.facts.rate_hz,
                object: self.table.has("object_filled"),
            },
            takes: self.facts.takes.clone(),
            segments: Vec::new(),
            filled: Vec::new(),
            object_filled: Vec::new(),
            recorded_distance_m: None,
            recorded_hull_distance_m: Vec::new(),
            recorded_nearest_pair_m: Vec::new(),
            methods: Vec::new(),
        }
    }

    /// Where the segments come from, as the rows of the first method say.
    fn segments(&self) -> Result<Vec<SegmentOrigin>, TableError> {
        let instants = 0..self.instants();
        let takes = self.table.words("take", instants.clone())?;
        let starts = self.table.counts("start_sample", instants)?;
        let firsts = takes
            .iter()
            .zip(starts)
            .step_by(self.facts.segment_samples.max(1));
        firsts
            .map(|(name, start)| {
                let take = self.facts.takes.iter().position(|take| take == name);
                let start = usize::try_from(start).ok();
                (take.zip(start)).map(|(take, start)| SegmentOrigin { take, start })
            })
            .collect::<Option<_>>()
            .ok_or_else(|| TableError::File {
                file: self.file.clone(),
                expected: format!("segments of {}", self.facts.takes.join(", ")),
                found: "one of another take, or before its begin".to_owned(),
                hint: "make the table again".to_owned(),
            })
    }

    /// Numbers that some methods do not have: blank in every row of theirs.
    fn if_known(&self, method: usize, column: &str) -> Result<Option<Vec<f64>>, TableError> {
        if !self.table.has(column) {
            return Ok(None);
        }
        let found = self.table.numbers(column, self.rows_of(method))?;
        Ok(Some(found).filter(|found| found.iter().any(|value| !value.is_nan())))
    }

    fn mahalanobis(&self, method: usize) -> Result<Option<Vec<PerFinger<f64>>>, TableError> {
        if !self.table.has("thumb.mahalanobis") {
            return Ok(None);
        }
        let found = self.fingers(method, "mahalanobis")?;
        let is_known = |fingers: &PerFinger<f64>| fingers.as_array().iter().any(|d| !d.is_nan());
        Ok(Some(found).filter(|found| found.iter().any(is_known)))
    }

    fn instants(&self) -> usize {
        self.facts.segments * self.facts.segment_samples
    }

    fn rows_of(&self, method: usize) -> std::ops::Range<usize> {
        method * self.instants()..(method + 1) * self.instants()
    }

    fn numbers(&self, method: usize, finger: Finger, suffix: &str) -> Result<Vec<f64>, TableError> {
        let column = format!("{}.{suffix}", finger.name());
        self.table.numbers(&column, self.rows_of(method))
    }

    fn fingers(&self, method: usize, suffix: &str) -> Result<Vec<PerFinger<f64>>, TableError> {
        let columns = PerFinger::try_from_fn(|finger| self.numbers(method, finger, suffix))?;
        Ok((0..self.instants())
            .map(|k| columns.each_ref().map(|column| column[k]))
            .collect())
    }
}
