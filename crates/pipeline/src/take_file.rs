//! What goes into the file of a take.

use std::path::Path;

use inhand_channels::{
    ContactSample, EvaluatedMethod, EvaluatedSample, GeneratedMethod, GeneratedSegment, TakeFile,
    UnsolvedPlan, WriteSettings,
};
use inhand_evaluation::Rows;
use inhand_model::{Finger, Motion, PerFinger, Provenance, Segments, Shape};

use crate::error::PipelineError;
use crate::output;
use crate::steps::Generated;
use crate::take::Take;

/// Everything that was made of a take.
#[derive(Clone, Copy, Debug)]
pub struct TakeContents<'a> {
    /// The take.
    pub take: &'a Take,
    /// Its motion.
    pub motion: &'a Motion,
    /// What was generated for it.
    pub generated: Option<GeneratedMotion<'a>>,
    /// The step that made it all.
    pub made: &'a Provenance,
    /// Shape of the object.
    pub shape: Option<Shape>,
}

/// What was generated for one take.
#[derive(Clone, Copy, Debug)]
pub struct GeneratedMotion<'a> {
    /// Test segments.
    pub segments: &'a Segments,
    /// Index of the take among those that the segments were cut from.
    pub take: usize,
    /// Methods with their trajectories.
    pub generated: &'a [Generated],
    /// Errors and distances of each method; empty before an evaluation.
    pub rows: &'a [Rows],
}

/// Writes the file of a take: what was recorded, processed, generated and evaluated.
///
/// # Errors
///
/// [`PipelineError`]; then no file appears.
pub fn write(path: &Path, contents: &TakeContents<'_>, view: bool) -> Result<(), PipelineError> {
    let motion = contents.generated.as_ref();
    let of_take = motion.map_or_else(Vec::new, GeneratedMotion::segments_of_take);
    let methods = motion.map_or(&[][..], |motion| motion.generated);
    let rows = motion.map_or(&[][..], |motion| motion.rows);
    let segments: Vec<_> = (motion.iter())
        .flat_map(|motion| {
            methods
                .iter()
                .map(|g| motion.generated_segments(g, &of_take))
        })
        .collect();
    let unsolved: Vec<_> = (motion.iter())
        .flat_map(|motion| methods.iter().map(|g| motion.unsolved_plans(g, &of_take)))
        .collect();
    let generated: Vec<_> = (methods.iter().zip(&segments).zip(&unsolved))
        .map(|((g, segments), unsolved)| GeneratedMethod {
            name: g.method.name(),
            segments,
            unsolved,
        })
        .collect();
    let evaluated: Vec<_> = (motion.iter())
        .flat_map(|motion| {
            methods.iter().zip(rows).map(|(g, rows)| EvaluatedMethod {
                name: g.method.name(),
                samples: motion.evaluated_samples(rows, &of_take),
            })
        })
        .collect();
    let mut provenance = contents.take.provenance.clone();
    provenance.push(contents.made.clone());
    let file = TakeFile {
        recording: contents.take.measured(),
        cleaned: contents.take.cleaned(),
        roles: Some(contents.take.roles()?),
        motion: Some(contents.motion),
        generated: &generated,
        evaluated: &evaluated,
        object_shape: contents.shape,
        annotations: Some(&contents.take.annotations),
        provenance: &provenance,
    };
    write_parts(path, &file, view)
}

/// Writes a take's file from its parts.
///
/// # Errors
///
/// [`PipelineError::Channels`], [`PipelineError::Io`].
pub fn write_parts(path: &Path, file: &TakeFile<'_>, view: bool) -> Result<(), PipelineError> {
    output::write_atomic(path, |out| {
        inhand_channels::write_take(out, file, &WriteSettings { view }).map_err(|source| {
            PipelineError::Channels {
                path: path.to_owned(),
                source: source.into(),
            }
        })
    })
}

impl<'a> GeneratedMotion<'a> {
    fn segments_of_take(&self) -> Vec<usize> {
        let origins = self.segments.origins().iter().enumerate();
        origins
            .filter(|(_, origin)| origin.take == self.take)
            .map(|(index, _)| index)
            .collect()
    }

    fn generated_segments(
        &self,
        generated: &'a Generated,
        of_take: &[usize],
    ) -> Vec<GeneratedSegment<'a>> {
        (of_take.iter())
            .filter_map(|&segment| {
                Some(GeneratedSegment {
                    start_sample: self.segments.origins()[segment].start,
                    trajectory: generated.trajectories[segment].as_ref()?,
                    plan: generated.plans.as_ref().map(|plans| &plans[segment]),
                })
            })
            .collect()
    }

    fn unsolved_plans(&self, generated: &'a Generated, of_take: &[usize]) -> Vec<UnsolvedPlan<'a>> {
        let plans = generated.plans.as_deref().unwrap_or_default();
        (of_take.iter())
            .filter_map(|&segment| Some((segment, plans.get(segment)?)))
            .filter(|(_, plan)| plan.trajectory.is_none())
            .map(|(segment, plan)| UnsolvedPlan {
                start_sample: self.segments.origins()[segment].start,
                samples: self.segments.layout().samples,
                plan,
            })
            .collect()
    }

    fn evaluated_samples(&self, rows: &Rows, of_take: &[usize]) -> Vec<EvaluatedSample> {
        let samples = self.segments.layout().samples;
        let instants = of_take.iter().flat_map(|&segment| {
            let start = self.segments.origins()[segment].start;
            (0..samples).map(move |t| (start + t, segment * samples + t))
        });
        let finite = |values: &PerFinger<f64>| values.as_array().iter().all(|v| v.is_finite());
        (instants.filter(|&(_, row)| finite(&rows.error_m[row])))
            .map(|(sample, row)| EvaluatedSample {
                sample,
                error_m: rows.error_m[row],
                contact: contact_sample(rows, row),
            })
            .collect()
    }
}

fn contact_sample(rows: &Rows, row: usize) -> Option<ContactSample> {
    let distance_m = rows.distance_m.as_ref()?[row];
    let in_contact = rows.in_contact.as_ref()?[row];
    if distance_m
        .as_array()
        .iter()
        .any(|distance| distance.is_nan())
    {
        return None; // The object is missing at this instant.
    }
    let count = Finger::ALL
        .into_iter()
        .filter(|&finger| in_contact[finger])
        .count();
    Some(ContactSample {
        distance_m,
        in_contact,
        count,
    })
}
