//! From rows of numbers to tracks on an even clock.

mod frames;
mod rotation;
mod series;

use inhand_model::{BodyKind, Clock, Finding, MarkerKind, Recording, Source};
use rayon::prelude::*;

use self::frames::{Grid, TimeCheck};
use self::series::{Scale, Series, Tracked};
use crate::error::CaptureError;
use crate::table::Table;

/// Where a body's rotation stands among the values of a row.
#[derive(Clone, Copy, Debug)]
pub(crate) enum RotationColumns {
    /// x, y, z, w.
    Quaternion([usize; 4]),
    /// Angles about x, y, z in degrees, and the axes in the order in which the intrinsic rotations
    /// follow each other.
    Euler { angles: [usize; 3], axes: [u8; 3] },
}

/// Where a marker or body stands among the values of a row.
#[derive(Debug)]
pub(crate) enum Entity {
    Marker {
        name: String,
        id: String,
        kind: MarkerKind,
        position: [usize; 3],
        quality: Option<usize>,
    },
    Body {
        name: String,
        id: String,
        kind: BodyKind,
        rotation: RotationColumns,
        position: [usize; 3],
        marker_error: Option<usize>,
    },
}

/// Everything a header says about a take.
#[derive(Debug)]
pub(crate) struct Take {
    pub(crate) name: String,
    pub(crate) clock: Clock,
    pub(crate) source: Source,
    pub(crate) entities: Vec<Entity>,
    /// Whether a marker exactly at the origin is a missing one.
    pub(crate) zero_is_missing: bool,
    /// How many rows the header promises, and under which key.
    pub(crate) declared_rows: Option<(&'static str, u64)>,
    pub(crate) findings: Vec<Finding>,
}

/// Reads the rows of `table` into the entities of `take`.
///
/// # Errors
///
/// [`CaptureError`] where a row is damaged, frame numbers do not rise or leave out too much, or
/// there is no row at all.
pub(crate) fn assemble(table: &Table<'_>, take: Take) -> Result<Recording, CaptureError> {
    let rows_at_most = table.rows_at_most();
    let width = table.values();
    let scale = Scale::of(take.source.length_unit);
    let zero_is_missing = take.zero_is_missing;
    let mut series: Vec<Series> = take
        .entities
        .into_iter()
        .map(|entity| Series::new(entity, rows_at_most, zero_is_missing))
        .collect();
    let mut grid = Grid::new(table.file, rows_at_most, series.len());
    let mut times = TimeCheck::new(take.clock.rate_hz());

    table.for_each_batch(|batch| {
        let mut gaps = Vec::with_capacity(batch.len());
        for rows in batch {
            gaps.push(grid.place(rows)?);
            times.look_at(rows, &grid);
        }
        series.par_iter_mut().for_each(|series| {
            for (rows, gaps) in batch.iter().zip(&gaps) {
                series.push(rows, gaps, width, scale);
            }
        });
        Ok(())
    })?;

    if grid.rows == 0 {
        return Err(CaptureError::NoSamples {
            file: table.file.to_owned(),
        });
    }
    let mut findings = take.findings;
    if let Some((key, declared)) = take.declared_rows
        && declared != grid.rows
    {
        findings.push(Finding::warning(
            key,
            format!(
                "the header promises {declared} rows, found {}: read what is there; the file was \
                 cut or edited after the export",
                grid.rows
            ),
        ));
    }
    findings.extend(grid.finding());
    findings.extend(times.finding());
    let (mut markers, mut bodies) = (Vec::new(), Vec::new());
    for series in series {
        findings.extend(series.findings());
        match series.track {
            Tracked::Marker(marker) => markers.push(marker),
            Tracked::Body(body) => bodies.push(body),
        }
    }
    let mut recording = Recording::new(
        take.name,
        take.clock,
        take.source,
        grid.samples,
        markers,
        bodies,
    )
    .map_err(|source| CaptureError::Recording {
        file: table.file.to_owned(),
        source,
    })?;
    recording.findings = findings;
    Ok(recording)
}
