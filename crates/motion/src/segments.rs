//! Cutting motions into segments.

use std::ops::Range;

use inhand_model::{
    Configuration, EndConditions, Finger, Motion, ObjectEnds, SEGMENT_COORDINATES, SegmentOrigin,
    Segments,
};
use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::error::MotionError;
use crate::object_rows;
use crate::settings::SegmentSettings;
use crate::stretches::runs;

/// Cuts segments of N samples out of every stretch in which all five fingertips are present
/// (measured or filled).
///
/// With a margin of `m = round(margin_s * rate)` samples, segments of a stretch of `L` samples start
/// at `m, m + stride, ...` while `start + N + m <= L`. The margins are there for the end velocities,
/// which are taken outside the segment, over `m` samples before its first and after its last, so
/// that they give away nothing of what lies between:
/// `(x(start) - x(start - m)) * rate / m` and `(x(end + m) - x(end)) * rate / m`.
///
/// Where the layout has the object, its rows follow those of the fingertips (see
/// [`SegmentLayout`](inhand_model::SegmentLayout)): position, and the rotation vector since the
/// segment's first sample, continuous along the segment. Segments in which the object is missing at
/// any sample are left out, and the others are those that a layout without object would give; in
/// the margins the object is not needed. With either layout the end conditions have the object where
/// it is present at the first and at the last sample.
///
/// Origins count takes in the order of `motions`. `left_out` counts what the takes would have given
/// without gaps, less what they give. Cost: one copy of 15 N numbers a segment, and with the object
/// an arc tangent a sample.
///
/// # Errors
///
/// [`MotionError::Rates`] for motions of different rates, [`MotionError::LayoutRate`] for a layout of
/// another rate than theirs, [`MotionError::Setting`] for a segment of fewer than two samples, a
/// stride of 0 or a margin that rounds to no sample.
pub fn cut_segments(
    motions: &[&Motion],
    settings: &SegmentSettings,
) -> Result<Segments, MotionError> {
    check_rates(motions, settings)?;
    let cut = Cut::new(settings)?;

    let mut origins = Vec::new();
    let mut left_out: usize = 0;
    for (take, motion) in motions.iter().enumerate() {
        let before = origins.len();
        for stretch in runs(motion.len(), |k| motion.fingertip_status(k).is_present()) {
            let starts = cut
                .starts(&stretch)
                .filter(|&start| cut.has_object(motion, start));
            origins.extend(starts.map(|start| SegmentOrigin { take, start }));
        }
        // A stretch starts its own grid, so with a stride beyond a segment's length a gap can even
        // make room for more.
        let whole = cut.starts(&(0..motion.len())).count();
        left_out += whole.saturating_sub(origins.len() - before);
    }

    let tables: Vec<Vec<Configuration>> = motions.par_iter().map(|&motion| table(motion)).collect();
    let layout = settings.layout;
    let rows = layout.rows();
    let mut columns_m = vec![0.0; rows * origins.len()];
    columns_m
        .par_chunks_mut(rows)
        .zip(&origins)
        .for_each(|(column, origin)| {
            let samples = origin.start..origin.start + layout.samples;
            let (fingers, object_m) = column.split_at_mut(layout.finger_rows());
            fingers.copy_from_slice(tables[origin.take][samples.clone()].as_flattened());
            if layout.object {
                let track = motions[origin.take].object.as_ref();
                let poses = track.and_then(|track| track.values().get(samples));
                object_rows::fill(object_m, poses.unwrap_or_default());
            }
        });
    let ends = (origins.iter())
        .map(|origin| EndConditions {
            object: cut.object_ends(motions[origin.take], origin.start),
            ..cut.ends(&tables[origin.take], origin.start)
        })
        .collect();
    let columns_m = DMatrix::from_vec(rows, origins.len(), columns_m);
    Ok(Segments::new(layout, columns_m, origins, ends, left_out)
        .expect("a column, an origin and end conditions were made for each segment"))
}

fn check_rates(motions: &[&Motion], settings: &SegmentSettings) -> Result<(), MotionError> {
    let Some(first) = motions.first() else {
        return Ok(());
    };
    let first_rate_hz = first.clock.rate_hz();
    if let Some(other) = (motions.iter()).find(|motion| motion.clock.rate_hz() != first_rate_hz) {
        return Err(MotionError::Rates {
            first_take: first.name.clone(),
            first_rate_hz,
            take: other.name.clone(),
            rate_hz: other.clock.rate_hz(),
        });
    }
    if settings.layout.rate_hz != first_rate_hz {
        return Err(MotionError::LayoutRate {
            layout_rate_hz: settings.layout.rate_hz,
            take: first.name.clone(),
            rate_hz: first_rate_hz,
        });
    }
    Ok(())
}

/// The rule of cutting, in samples.
struct Cut {
    samples: usize,
    stride: usize,
    margin: usize,
    rate_hz: f64,
    needs_object: bool,
}

impl Cut {
    fn new(settings: &SegmentSettings) -> Result<Self, MotionError> {
        let layout = settings.layout;
        if layout.samples < 2 {
            return Err(MotionError::setting(
                "layout.samples",
                layout.samples,
                "2 or more: a segment has a first and a last sample",
            ));
        }
        if settings.stride == 0 {
            return Err(MotionError::setting("stride", 0, "1 sample or more"));
        }
        let margin = (settings.margin_s * layout.rate_hz).round();
        if !(margin >= 1.0 && margin.is_finite()) {
            return Err(MotionError::setting(
                "margin_s",
                settings.margin_s,
                format!(
                    "{} s or more, a sample at {} Hz: end velocities are taken over it",
                    1.0 / layout.rate_hz,
                    layout.rate_hz
                ),
            ));
        }
        Ok(Self {
            samples: layout.samples,
            stride: settings.stride,
            margin: margin as usize,
            rate_hz: layout.rate_hz,
            needs_object: layout.object,
        })
    }

    /// Starts of the segments within a stretch, as samples of the take.
    fn starts(&self, stretch: &Range<usize>) -> impl Iterator<Item = usize> + use<> {
        let first = stretch.start.saturating_add(self.margin);
        let needed = self.samples.saturating_add(self.margin);
        // One past the last possible start; where nothing fits, no more than the first.
        let end = (stretch.end + 1).saturating_sub(needed).max(first);
        (first..end).step_by(self.stride)
    }

    /// Whether the segment that starts at a sample of the take has what it needs of the object.
    fn has_object(&self, motion: &Motion, start: usize) -> bool {
        !self.needs_object
            || (motion.object.as_ref()).is_some_and(|object| {
                (start..start + self.samples).all(|k| object.status(k).is_present())
            })
    }

    /// Where the object is at the ends of the segment that starts at a sample of the take.
    fn object_ends(&self, motion: &Motion, start: usize) -> Option<ObjectEnds> {
        let object = motion.object.as_ref()?;
        Some(ObjectEnds {
            first: object.get(start)?,
            last: object.get(start + self.samples - 1)?,
        })
    }

    /// What the fingertips do at the ends of the segment that starts at a sample of the take; the
    /// object is not in the table.
    fn ends(&self, table: &[Configuration], start: usize) -> EndConditions {
        let last = start + self.samples - 1;
        let velocity = |from: usize, to: usize| -> Configuration {
            let per_second = self.rate_hz / self.margin as f64;
            std::array::from_fn(|i| (table[to][i] - table[from][i]) * per_second)
        };
        EndConditions {
            first_m: table[start],
            last_m: table[last],
            first_velocity_m_s: velocity(start - self.margin, start),
            last_velocity_m_s: velocity(last, last + self.margin),
            object: None,
        }
    }
}

/// The configuration at every sample of a take, NaN where missing: time-major, so that a segment is
/// one piece of it.
fn table(motion: &Motion) -> Vec<Configuration> {
    (0..motion.len())
        .map(|k| {
            let mut configuration = [f64::NAN; SEGMENT_COORDINATES];
            for finger in Finger::ALL {
                if let Some(position) = motion.fingertips[finger].get(k) {
                    configuration[finger.index() * 3..][..3].copy_from_slice(&position.to_array());
                }
            }
            configuration
        })
        .collect()
}
