//! Cutting motions into segments.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::Range;

use inhand_model::{
    EndConditions, Finger, Hand, Motion, OBJECT_COORDINATES, Object, Pose, Protocol,
    ROTATION_LEVER_M, SegmentLayout, SegmentOrigin, Segments, runs,
};
use nalgebra::{DMatrix, Unit, UnitQuaternion, Vector3};
use rayon::prelude::*;

use crate::boundary::Boundary;
use crate::error::MotionError;
use crate::settings::SegmentSettings;
use crate::table::SegmentTable;

/// A turn below which its axis is rounding, radians: unit quaternions carry some 1e-16.
const SMALLEST_TURN_RAD: f64 = 1e-9;

/// Cuts segments of N samples out of every interval in which all five fingertips are present
/// (measured or filled).
///
/// With a margin of `m` samples ([`EndsRule::samples`](crate::EndsRule::samples)), segments of an interval of `L` samples start
/// at `m, m + stride, ...` while `start + N + m <= L`. The margins are there for the boundary conditions.
/// By [`EndsRule::Differences`](crate::EndsRule::Differences) velocities are taken over `m` samples before the segment's first and after its
/// last: `(x(start) - x(start - m)) * rate / m` and `(x(end + m) - x(end)) * rate / m`. Of motion that a centred
/// filter has smoothed, these samples hold some of what lies between. By [`EndsRule::Lines`](crate::EndsRule::Lines) of motion before
/// the filter nothing does: lines rest on measured samples of `start - m + 1 ..= start` and `end ..= end + m - 1`;
/// a filled one may rest on samples inside the segment and does not count. Segments with fewer than
/// half of these samples measured are left out.
///
/// Where the layout has the object, its rows follow those of the fingertips (see
/// [`SegmentLayout`](inhand_model::SegmentLayout)): position, and the rotation vector since the
/// segment's first sample, continuous along the segment. Segments in which the object is missing at
/// any sample are left out, and the others are those that a layout without object would give; in
/// the margins the object is not needed. With either layout the end conditions have the object where
/// it is present at the first and at the last sample.
///
/// With [`missing_s`](SegmentSettings::missing_s) above zero, gaps of up to that long do not end a
/// interval, and a segment may miss as many samples in all, but not its first or last one, nor those
/// its end velocities are taken from. What is missing is NaN in its column.
///
/// Where a motion says which samples are [`selected`](Motion::selected), segments lie inside those,
/// all of a segment inside one interval of them; margins may lie outside.
///
/// Origins count takes in the order of `motions`. `left_out` counts what the takes would have given
/// without gaps, less what they give. Cost: one copy of 15 N numbers a segment, and with the object
/// an arc tangent a sample.
///
/// # Errors
///
/// [`MotionError::Rate`] for motions of different rates and for a layout of another rate than theirs, [`MotionError::Setting`] for a segment of fewer than two samples, a
/// stride of 0 or boundary conditions over less than a sample.
pub fn cut_segments(
    motions: &[&Motion],
    settings: &SegmentSettings,
) -> Result<Segments, MotionError> {
    cut_some(motions, settings, |count| (0..count).collect())
}

/// Some of the segments of [`cut_segments`]: those whose numbers `which` gives for the number of all of them.
///
/// # Errors
///
/// As for [`cut_segments`].
///
/// # Panics
///
/// If there is no such segment.
pub fn cut_some(
    motions: &[&Motion],
    settings: &SegmentSettings,
    which: impl FnOnce(usize) -> Vec<usize>,
) -> Result<Segments, MotionError> {
    let found = FoundSegments::new(motions, settings)?;
    let which = which(found.origins().len());
    Ok(found.segments(which))
}

/// Places of the segments of [`cut_segments`], whose samples stay in the motions until they are wanted: segments of a long
/// take can be worked on some at a time.
#[derive(Clone, Debug)]
pub struct FoundSegments {
    tables: Vec<SegmentTable>,
    cut: Cut,
    origins: Vec<SegmentOrigin>,
    /// Segments that takes without gaps would have given in addition.
    pub left_out: usize,
}

impl FoundSegments {
    /// Finds the segments of motions.
    ///
    /// # Errors
    ///
    /// As for [`cut_segments`].
    pub fn new(motions: &[&Motion], settings: &SegmentSettings) -> Result<Self, MotionError> {
        check_rates(motions, settings)?;
        let cut = Cut::new(settings)?;
        let tables: Vec<_> = (motions.iter())
            .map(|motion| SegmentTable::from_motion(motion))
            .collect();
        let starts: Vec<Starts> = tables.par_iter().map(|table| cut.starts(table)).collect();
        let origins = starts.iter().enumerate().flat_map(|(take, starts)| {
            let starts = starts.starts.iter();
            starts.map(move |&start| SegmentOrigin { take, start })
        });
        Ok(Self {
            tables,
            cut,
            origins: origins.collect(),
            left_out: starts.iter().map(|starts| starts.left_out).sum(),
        })
    }

    /// Where each segment is.
    pub fn origins(&self) -> &[SegmentOrigin] {
        &self.origins
    }

    /// Shape of each segment.
    pub fn layout(&self) -> SegmentLayout {
        self.cut.layout
    }

    /// Cuts the segments of these numbers, in this order.
    ///
    /// # Panics
    ///
    /// If there is no such segment.
    pub fn segments(&self, which: impl IntoIterator<Item = usize>) -> Segments {
        let cut = &self.cut;
        let origins: Vec<_> = (which.into_iter())
            .map(|segment| self.origins[segment])
            .collect();
        let rows = cut.layout.rows();
        let mut columns_m = vec![0.0; rows * origins.len()];
        columns_m
            .par_chunks_mut(rows)
            .zip(&origins)
            .for_each(|(column, origin)| cut.fill(&self.tables[origin.take], origin.start, column));
        let ends = (origins.iter())
            .map(|origin| cut.ends(&self.tables[origin.take], origin.start))
            .collect();
        let columns_m = DMatrix::from_vec(rows, origins.len(), columns_m);
        let segments = Segments::new(cut.layout, columns_m, origins, ends, self.left_out)
            .expect("a column, an origin and end conditions were made for each segment");
        segments.under(cut.protocol)
    }
}

fn check_rates(motions: &[&Motion], settings: &SegmentSettings) -> Result<(), MotionError> {
    let Some(first) = motions.first() else {
        return Ok(());
    };
    let (first_take, first_hz) = (&first.name, first.clock.rate_hz());
    let layout_hz = settings.layout.rate_hz;
    let error = |motion: &Motion, expected: String| MotionError::Rate {
        take: motion.name.clone(),
        rate_hz: motion.clock.rate_hz(),
        expected,
    };
    if let Some(other) = (motions.iter()).find(|motion| !motion.clock.has_rate_of(first.clock)) {
        return Err(error(
            other,
            format!("take \"{first_take}\" at {first_hz} Hz: takes of one session need one rate"),
        ));
    }
    if layout_hz != first_hz {
        return Err(error(
            first,
            format!("but segments are laid out for {layout_hz} Hz"),
        ));
    }
    Ok(())
}

/// The rule of cutting, in samples: what [`cut_segments`] does, for takes that come one at a time.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    layout: SegmentLayout,
    stride: usize,
    /// Samples kept free on each side of a segment.
    margin: usize,
    missing: usize,
    protocol: Protocol,
}

/// Where segments of a take start.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Starts {
    /// First samples, in order.
    pub starts: Vec<usize>,
    /// Segments that the take without gaps would have given in addition.
    pub left_out: usize,
}

impl Cut {
    /// The rule that settings give.
    ///
    /// # Errors
    ///
    /// [`MotionError::Setting`] as [`cut_segments`].
    pub fn new(settings: &SegmentSettings) -> Result<Self, MotionError> {
        let layout = settings.layout;
        let (samples, stride) = (layout.samples, settings.stride);
        let expected = "2 or more: a segment has a first and a last sample";
        MotionError::unless(samples >= 2, "layout.samples", samples, expected)?;
        MotionError::unless(stride > 0, "stride", stride, "1 sample or more")?;
        let margin = settings.ends.samples(layout.rate_hz)?;
        let missing = settings.missing_s * layout.rate_hz;
        let in_range = missing >= 0.0 && missing < samples as f64;
        let expected = "a time in seconds, 0 or more and shorter than a segment";
        MotionError::unless(in_range, "missing_s", settings.missing_s, expected)?;
        Ok(Self {
            layout,
            stride,
            margin,
            protocol: settings.ends.protocol(),
            // A whole number of samples must not be lost to rounding.
            missing: (missing + 1e-6) as usize,
        })
    }

    /// Where segments of a take start.
    pub fn starts(&self, table: &SegmentTable) -> Starts {
        let intervals = self.intervals(table);
        let mut starts = Vec::new();
        for usable in self.usable(table.len(), table.selected()) {
            for interval in &intervals {
                let interval = interval.start.max(usable.start)..interval.end.min(usable.end);
                starts.extend(
                    self.within(&interval)
                        .filter(|&start| self.can_teach(table, start)),
                );
            }
        }
        // An interval starts its own grid, so with a stride beyond a segment's length a gap can even
        // make room for more.
        let whole = self.without_gaps(table.len(), table.selected());
        Starts {
            left_out: whole.saturating_sub(starts.len()),
            starts,
        }
    }

    /// Segments of the take without gaps that are not complete, by what most of their missing samples lack: the hand,
    /// a finger, or the object.
    pub fn left_out_by(&self, table: &SegmentTable) -> BTreeMap<String, usize> {
        let is_complete = |start: usize, mut with_margins: Range<usize>| {
            let bridged = self.missing > 0 || with_margins.all(|k| table.is_present(k));
            bridged && self.can_teach(table, start)
        };
        let usable = self.usable(table.len(), table.selected());
        let mut left_out_by = BTreeMap::new();
        for start in usable.iter().flat_map(|range| self.within(range)) {
            let samples = start - self.margin..start + self.layout.samples + self.margin;
            if is_complete(start, samples.clone()) {
                continue;
            }
            let missing = |is_missing: &dyn Fn(usize) -> bool| {
                samples.clone().filter(|&k| is_missing(k)).count()
            };
            let tips =
                Finger::ALL.map(|finger| (missing(&|k| !table.has(finger, k)), finger.name()));
            let object =
                (self.layout.object).then(|| (missing(&|k| !table.has_object(k)), "object"));
            let hand = missing(&|k| !Finger::ALL.iter().any(|&finger| table.has(finger, k)));
            // Where the hand is lost all fingertips are: of equal ones the first counts.
            let most = std::iter::once((hand, "hand"))
                .chain(tips)
                .chain(object)
                .reduce(|most, other| if other.0 > most.0 { other } else { most });
            if let Some((_, name)) = most {
                *left_out_by.entry(name.to_owned()).or_default() += 1;
            }
        }
        left_out_by
    }

    /// Segments that a take of `len` samples, of which these are selected, would give if nothing were
    /// missing.
    pub fn without_gaps(&self, len: usize, selected: Option<&[Range<usize>]>) -> usize {
        let usable = self.usable(len, selected);
        usable.iter().map(|range| self.within(range).count()).sum()
    }

    /// Fills a column (15 N numbers, with the object 21 N) with the segment that starts at a sample.
    ///
    /// # Panics
    ///
    /// If the take ends before the segment, or the column has another length.
    pub fn fill(&self, table: &SegmentTable, start: usize, column_m: &mut [f64]) {
        let samples = start..start + self.layout.samples;
        let (fingers, object_m) = column_m.split_at_mut(self.layout.finger_rows());
        let configurations = fingers.as_chunks_mut().0.iter_mut();
        for (configuration, k) in configurations.zip(samples.clone()) {
            *configuration = table.configuration_m(k);
        }
        if self.layout.object {
            fill_object(object_m, samples.map_while(|k| table.object_at(k)));
        }
    }

    /// End conditions of the segment that starts at a sample.
    ///
    /// # Panics
    ///
    /// If the take ends before the segment and its margin.
    pub fn ends(&self, table: &SegmentTable, start: usize) -> EndConditions {
        let boundary = self.boundary(start);
        match self.protocol {
            Protocol::Published => boundary.differences(table),
            Protocol::HeldOut => boundary.lines(table),
        }
    }

    fn boundary(&self, start: usize) -> Boundary {
        Boundary {
            first: start,
            last: start + self.layout.samples - 1,
            samples: self.margin,
            rate_hz: self.layout.rate_hz,
        }
    }

    /// Where segments with their margins may lie. Margins may reach beyond what is selected: they only
    /// tell how fast a segment begins and ends.
    fn usable(&self, len: usize, selected: Option<&[Range<usize>]>) -> Vec<Range<usize>> {
        let Some(selected) = selected else {
            return std::iter::once(0..len).collect();
        };
        (selected.iter())
            .map(|range| {
                let end = range.end.saturating_add(self.margin).min(len);
                range.start.saturating_sub(self.margin)..end
            })
            .collect()
    }

    /// Stretches between gaps that are too long to be bridged.
    fn intervals(&self, table: &SegmentTable) -> Vec<Range<usize>> {
        let runs = runs(0..table.len(), |k| table.is_present(k));
        let mut intervals: Vec<Range<usize>> = Vec::new();
        for run in runs {
            match intervals.last_mut() {
                Some(last) if run.start - last.end <= self.missing => last.end = run.end,
                _ => intervals.push(run),
            }
        }
        intervals
    }

    /// Starts of the segments within an interval, as samples of the take.
    fn within(&self, interval: &Range<usize>) -> impl Iterator<Item = usize> + use<> {
        let first = interval.start.saturating_add(self.margin);
        let needed = self.layout.samples.saturating_add(self.margin);
        // One past the last possible start; where nothing fits, no more than the first.
        let end = (interval.end + 1).saturating_sub(needed).max(first);
        (first..end).step_by(self.stride)
    }

    /// Whether the segment that starts at a sample has what it needs: its ends, most of its samples,
    /// and all of the object where the layout has it.
    fn can_teach(&self, table: &SegmentTable, start: usize) -> bool {
        let samples = start..start + self.layout.samples;
        let last = samples.end - 1;
        let ends = [start - self.margin, start, last, last + self.margin];
        let missing = || {
            let missing = samples.clone().filter(|&k| !table.is_present(k));
            missing.count()
        };
        (self.missing == 0
            || ends.iter().all(|&k| table.is_present(k)) && missing() <= self.missing)
            && (!self.layout.object || samples.clone().all(|k| table.has_object(k)))
            && (self.protocol == Protocol::Published
                || self.boundary(start).has_lines(table, self.layout.object))
    }
}

/// Fills the object's rows of a column (6 N, time-major) from its poses at the N samples, all of them
/// present: position in the hand's frame, metres, and the rotation vector since the first sample
/// (hand frame) times [`ROTATION_LEVER_M`].
///
/// A rotation has many vectors, whole turns apart along its axis. The first sample's is zero, and
/// each further sample takes the one nearest to the sample before, so that a steady turn is a
/// straight line beyond half a turn too. Near a whole turn the axis of what is left is lost in noise
/// and the vector with it, as for any three numbers that stand for a rotation.
fn fill_object(rows_m: &mut [f64], poses: impl Iterator<Item = Pose<Hand, Object>>) {
    let mut back = None;
    let mut turned = Vector3::zeros();
    let rows = rows_m.as_chunks_mut::<OBJECT_COORDINATES>().0;
    for (row, pose) in rows.iter_mut().zip(poses) {
        let [x, y, z] = pose.origin().to_array();
        let rotation = pose.isometry().rotation;
        match back {
            None => back = Some(rotation.inverse()),
            Some(back) => turned = nearest_rotation_vector(rotation * back, turned),
        }
        let [a, b, c]: [f64; 3] = (turned * ROTATION_LEVER_M).into();
        *row = [x, y, z, a, b, c];
    }
}

/// The rotation vector of a rotation that is nearest to `previous`, radians: of
/// `axis * (angle + 2 pi k)` over whole k.
fn nearest_rotation_vector(rotation: UnitQuaternion<f64>, previous: Vector3<f64>) -> Vector3<f64> {
    let shortest = rotation.scaled_axis();
    let angle = shortest.norm();
    // No turn, or whole turns, have any axis: the nearest vector lies along the previous one.
    let axis = Unit::try_new(shortest, SMALLEST_TURN_RAD)
        .or_else(|| Unit::try_new(previous, SMALLEST_TURN_RAD));
    let Some(axis) = axis else {
        return shortest;
    };
    // Half a turn from nowhere is as near either way and stays as it is: ties go to even.
    let turns = ((axis.dot(&previous) - angle) / TAU).round_ties_even();
    axis.into_inner() * (angle + TAU * turns)
}
