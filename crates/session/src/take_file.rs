//! Writes the file of a take.

use std::collections::BTreeSet;
use std::path::Path;

use inhand_channels::{
    ContactSample, EvaluatedMethod, EvaluatedSample, GeneratedMethod, GeneratedSegment, RECORDED,
    TakeFile, Views,
};
use inhand_model::{
    Hull, MethodRows, Motion, PerFinger, PerProtocol, Protocol, Provenance, Segments,
};

use crate::error::{Located, SessionError};
use crate::found_events;
use crate::output;
use crate::settings::Settings;
use crate::steps::{self, Generated};
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
    /// What was set: the shape of the object, and what counts as contact.
    pub settings: &'a Settings,
}

/// What was generated for one take.
#[derive(Clone, Copy, Debug)]
pub struct GeneratedMotion<'a> {
    /// Test segments under each protocol.
    pub segments: PerProtocol<&'a Segments>,
    /// Index of the take among those that the segments were cut from.
    pub take: usize,
    /// Methods with their trajectories for these segments.
    pub generated: PerProtocol<&'a [Generated]>,
    /// Published errors and distances of each method; empty before an evaluation.
    pub rows: &'a [MethodRows],
    /// Methods that are written, by name; `None` for all.
    pub written: Option<&'a BTreeSet<&'a str>>,
    /// Where each fingertip has been in training.
    pub hulls: &'a PerFinger<Hull>,
}

/// Writes the file of a take: what was recorded, processed, generated and evaluated.
///
/// # Errors
///
/// [`SessionError`]; then no file appears.
pub fn write(path: &Path, contents: &TakeContents<'_>, views: Views) -> Result<(), SessionError> {
    let TakeContents { take, settings, .. } = *contents;
    take.roles()?;
    let motion = contents.generated.as_ref();
    let segments = Protocol::ALL
        .map(|protocol| motion.map_or_else(Vec::new, |motion| motion.generated_segments(protocol)));
    let [generated, held_out] = segments.each_ref().map(|segments| {
        let methods = segments
            .iter()
            .map(|(name, segments)| GeneratedMethod { name, segments });
        methods.collect::<Vec<_>>()
    });
    let annotations = found_events::with_found(&take.annotations, contents.motion, settings)?;
    let tau_m = settings.evaluate.tau_mm / 1000.0;
    let of_methods = (motion.iter()).flat_map(|motion| {
        let judged = motion.generated.published.iter().zip(motion.rows);
        (judged.filter(|(g, _)| motion.writes(g))).map(|(g, rows)| EvaluatedMethod {
            name: g.method.name().to_owned(),
            samples: motion.evaluated_samples(rows, tau_m),
        })
    });
    let recorded = recorded_contacts(contents.motion, settings)?;
    let evaluated: Vec<_> = recorded.into_iter().chain(of_methods).collect();
    let provenance = take.made_by(contents.made);
    let file = TakeFile {
        motion: Some(contents.motion),
        generated: &generated,
        held_out: &held_out,
        evaluated: &evaluated,
        object_shape: settings.shape()?,
        hulls: motion.map(|motion| motion.hulls),
        annotations: Some(&annotations),
        ..take.file(&provenance)
    };
    write_parts(path, &file, views)
}

/// Writes a take's file from its parts.
///
/// # Errors
///
/// [`SessionError::At`], [`SessionError::Io`].
pub fn write_parts(path: &Path, file: &TakeFile<'_>, views: Views) -> Result<(), SessionError> {
    output::write_atomic(path, |out| {
        inhand_channels::write_take(out, file, views).in_file(path)
    })
}

impl<'a> GeneratedMotion<'a> {
    fn of_take(&self, protocol: Protocol) -> impl Iterator<Item = usize> + use<'a> {
        let (take, segments) = (self.take, self.segments[protocol]);
        let origins = segments.origins().iter().enumerate();
        let of_take = origins.filter(move |(_, origin)| origin.take == take);
        of_take.map(|(index, _)| index)
    }

    /// What each method made of the segments of the take.
    fn generated_segments(
        &self,
        protocol: Protocol,
    ) -> Vec<(&'static str, Vec<GeneratedSegment<'a>>)> {
        let segments = self.segments[protocol];
        let of_method = |generated: &'a Generated| {
            let segment = |segment: usize| {
                let trajectory = generated.trajectories[segment].as_ref();
                let plan = generated.plans.as_ref().map(|plans| &plans[segment]);
                (trajectory.is_some() || plan.is_some()).then(|| GeneratedSegment {
                    start_sample: segments.origins()[segment].start,
                    samples: segments.layout().samples,
                    trajectory,
                    plan,
                })
            };
            let made = self.of_take(protocol).filter_map(segment).collect();
            (generated.method.name(), made)
        };
        let generated = self.generated[protocol].iter();
        (generated.filter(|g| self.writes(g)).map(of_method)).collect()
    }

    fn writes(&self, method: &Generated) -> bool {
        (self.written).is_none_or(|written| written.contains(method.method.name()))
    }

    fn evaluated_samples(&self, rows: &MethodRows, tau_m: f64) -> Vec<EvaluatedSample> {
        let segments = self.segments.published;
        let samples = segments.layout().samples;
        let instants = self.of_take(Protocol::Published).flat_map(|segment| {
            let start = segments.origins()[segment].start;
            (0..samples).map(move |t| (start + t, segment * samples + t))
        });
        let finite = |values: &PerFinger<f64>| values.as_array().iter().all(|v| v.is_finite());
        (instants.filter(|&(_, row)| finite(&rows.error_m[row])))
            .map(|(sample, row)| EvaluatedSample {
                sample,
                error_m: Some(rows.error_m[row]),
                contact: contact_sample(rows, row, tau_m),
            })
            .collect()
    }
}

/// Which recorded fingertips touch the object, where its shape and pose are known.
pub(crate) fn recorded_contacts(
    motion: &Motion,
    settings: &Settings,
) -> Result<Option<EvaluatedMethod>, SessionError> {
    let contacts = steps::contacts(motion, settings)?;
    let samples: Vec<_> = (contacts.iter().enumerate())
        .filter_map(|(sample, contact)| {
            let distance_m = (*contact)?;
            Some(EvaluatedSample {
                sample,
                error_m: None,
                contact: Some(ContactSample::new(
                    distance_m,
                    settings.evaluate.tau_mm / 1e3,
                )),
            })
        })
        .collect();
    Ok((!samples.is_empty()).then_some(EvaluatedMethod {
        name: RECORDED.to_owned(),
        samples,
    }))
}

fn contact_sample(rows: &MethodRows, row: usize, tau_m: f64) -> Option<ContactSample> {
    let distance_m = rows.distance_m.as_ref()?[row];
    if distance_m
        .as_array()
        .iter()
        .any(|distance| distance.is_nan())
    {
        return None; // The object is missing at this instant.
    }
    Some(ContactSample::new(distance_m, tau_m))
}
