//! Columns of segments from the tables of takes.

use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use inhand_dictionary::{Columns, LearnError};
use inhand_model::{Configuration, Pose, Protocol, SegmentLayout, SegmentOrigin, Segments};
use inhand_motion::{Cut, SegmentTable};
use inhand_session::{Located as _, Role, SessionError, steps};
use nalgebra::{DMatrix, Isometry3, Quaternion, Translation3, UnitQuaternion};

use crate::file::{self, Label};
use crate::folder::LearningFolder;

/// Tables are kept in memory up to this size, bytes; the last one always is.
const CACHE_BYTES: usize = 64 << 20;

/// Samples of a part of a table: parts are written and read one at a time.
const PART: usize = 1 << 15;

/// Label of the parts of tables: they are written before the run has an id, which covers their takes' hashes.
fn label(take: usize, part: usize) -> Label {
    Label {
        kind: "table".to_owned(),
        id: "0".repeat(64),
        start: part,
        round: take,
    }
}

/// Samples of all of the table, whether it has the object, and what is selected; then configurations, poses and
/// measured parts of its own samples.
type Part = (
    (usize, bool, Option<Vec<Range<usize>>>),
    Vec<(Configuration, Option<[f64; 7]>, u8)>,
);

pub(crate) fn write_table(
    path: &Path,
    take: usize,
    table: &SegmentTable,
) -> Result<(), SessionError> {
    let selected = table.selected().map(<[_]>::to_vec);
    let all = (table.len(), table.object().is_some(), selected);
    let pose = |k: usize| {
        let isometry = table.object()?.value(k).isometry();
        let [x, y, z] = isometry.translation.vector.into();
        let [a, b, c, w] = isometry.rotation.coords.into();
        Some([x, y, z, a, b, c, w])
    };
    let sample = |k| (table.configuration_m(k), pose(k), table.measured_parts(k));
    let parts = (0..table.len().div_ceil(PART).max(1)).map(|part| -> (Label, Part) {
        let samples = part * PART..table.len().min((part + 1) * PART);
        (
            label(take, part),
            (all.clone(), samples.map(sample).collect()),
        )
    });
    // Written again by the next `init`: it need not outlast a crash.
    file::write_parts(path, parts)
}

pub(crate) fn read_table(path: &Path, take: usize) -> Result<SegmentTable, SessionError> {
    let mut read: Option<(usize, SegmentTable)> = None;
    let add = |((samples, has_object, selected), rows): Part| {
        let (_, table) =
            read.get_or_insert_with(|| (samples, SegmentTable::new(has_object, selected)));
        for (fingertips_m, object, measured) in &rows {
            // Written as it was, unit length and all: normalising again would change digits.
            let pose = object.map(|[x, y, z, a, b, c, w]| {
                let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, a, b, c));
                Pose::new(Isometry3::from_parts(Translation3::new(x, y, z), rotation))
            });
            table.push(fingertips_m, pose, *measured);
        }
    };
    file::read_parts(path, |part| label(take, part), add)?;
    match read {
        Some((samples, table)) if table.len() == samples => Ok(table),
        _ => Err(SessionError::data(
            path,
            "the table ends too early: begin the run again",
        )),
    }
}

/// A take as segments are cut from it.
struct CutTake {
    table: SegmentTable,
    starts: Vec<usize>,
}

/// The training columns of a learning folder under a protocol, read as they are asked for.
pub(crate) struct TableColumns<'a> {
    folder: &'a LearningFolder,
    protocol: Protocol,
    cut: Cut,
    /// Number of the first segment of each take, and at the end that of all.
    firsts: Vec<usize>,
    cache: Mutex<Vec<(usize, Arc<CutTake>)>>,
}

impl<'a> TableColumns<'a> {
    pub(crate) fn new(folder: &'a LearningFolder) -> Result<Self, SessionError> {
        Self::under(Protocol::Published, folder)
    }

    pub(crate) fn under(
        protocol: Protocol,
        folder: &'a LearningFolder,
    ) -> Result<Self, SessionError> {
        let plan = folder.plan();
        let settings = steps::cut_settings(plan.layout, (Role::Train, protocol), &plan.settings);
        let cut = Cut::new(&settings).during("processing training takes")?;
        let mut firsts = vec![0];
        for take in &plan.takes {
            firsts.push(firsts[firsts.len() - 1] + take.segments(protocol));
        }
        Ok(Self {
            folder,
            protocol,
            cut,
            firsts,
            cache: Mutex::new(Vec::new()),
        })
    }

    fn take(&self, take: usize) -> Result<Arc<CutTake>, SessionError> {
        // A panic elsewhere leaves the list as it was before or after a change.
        let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, found)) = cache.iter().find(|(cached, _)| *cached == take) {
            return Ok(found.clone());
        }
        let path = self.folder.table(take, self.protocol);
        let table = read_table(&path, take)?;
        let planned = &self.folder.plan().takes[take];
        let segments = planned.segments(self.protocol);
        let starts = self.cut.starts(&table).starts;
        if (table.len(), starts.len()) != (planned.samples, segments) {
            return Err(SessionError::data(
                &path,
                format!(
                    "the table has {} samples and {} segments, `learning.json` says {} and {}: the \
                     file is of another run; begin again",
                    table.len(),
                    starts.len(),
                    planned.samples,
                    segments
                ),
            ));
        }
        let bytes = |take: &CutTake| 8 * (22 * take.table.len() + take.starts.len());
        let loaded = Arc::new(CutTake { table, starts });
        cache.push((take, loaded.clone()));
        while cache.len() > 1
            && cache.iter().map(|(_, take)| bytes(take)).sum::<usize>() > CACHE_BYTES
        {
            cache.remove(0);
        }
        Ok(loaded)
    }

    /// The take of a segment.
    fn take_of(&self, segment: usize) -> usize {
        self.firsts.partition_point(|&first| first <= segment) - 1
    }

    /// The segments that deviations are learned from: those drawn of all, as far as they miss nothing.
    pub(crate) fn demonstrations(&self) -> Result<Segments, SessionError> {
        let settings = &self.folder.plan().settings;
        let drawn = steps::drawn_demonstrations(self.count(), settings);
        Ok(steps::complete(self.segments(&drawn)?))
    }

    /// Some of the segments with their boundary conditions.
    fn segments(&self, which: &[usize]) -> Result<Segments, SessionError> {
        let layout = self.layout();
        let mut columns_m = vec![0.0; which.len() * layout.rows()];
        let mut origins = Vec::with_capacity(which.len());
        let mut ends = Vec::with_capacity(which.len());
        for (&segment, column) in (which.iter()).zip(columns_m.chunks_exact_mut(layout.rows())) {
            let take = self.take_of(segment);
            let cut = self.take(take)?;
            let start = cut.starts[segment - self.firsts[take]];
            self.cut.fill(&cut.table, start, column);
            origins.push(SegmentOrigin { take, start });
            ends.push(self.cut.ends(&cut.table, start));
        }
        let columns_m = DMatrix::from_vec(layout.rows(), which.len(), columns_m);
        let left_out = self.folder.plan().left_out;
        let segments = Segments::new(layout, columns_m, origins, ends, left_out)
            .expect("a column, an origin and boundary conditions were made for each segment");
        Ok(segments.under(self.protocol))
    }
}

impl Columns for TableColumns<'_> {
    fn layout(&self) -> SegmentLayout {
        self.folder.plan().layout
    }

    fn count(&self) -> usize {
        self.firsts[self.firsts.len() - 1]
    }

    fn origin(&self, segment: usize) -> SegmentOrigin {
        let take = self.take_of(segment);
        let start = self
            .take(take)
            .map_or(0, |cut| cut.starts[segment - self.firsts[take]]);
        SegmentOrigin { take, start }
    }

    fn left_out(&self) -> usize {
        self.folder.plan().left_out
    }

    fn read(&self, segments: Range<usize>, into_m: &mut [f64]) -> Result<(), LearnError> {
        let rows = self.layout().rows();
        let mut take = usize::MAX;
        let mut current: Option<Arc<CutTake>> = None;
        for (segment, column) in segments.zip(into_m.chunks_exact_mut(rows)) {
            let wanted = self.take_of(segment);
            if wanted != take {
                current = Some(self.take(wanted).map_err(LearnError::reading)?);
                take = wanted;
            }
            if let Some(cut) = &current {
                let start = cut.starts[segment - self.firsts[take]];
                self.cut.fill(&cut.table, start, column);
            }
        }
        Ok(())
    }
}
