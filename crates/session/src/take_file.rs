//! Writes the file of a take.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;

use inhand_channels::{
    ContactSample, EvaluatedMethod, EvaluatedSample, GeneratedMethod, Outline, RECORDED, TakeFile,
    TakeSegments, TakeWriter, Views,
};
use inhand_model::{
    Hull, MethodRows, Motion, PerFinger, PerProtocol, Protocol, Provenance, Segments,
};
use inhand_motion::FoundSegments;

use crate::error::{Located, SessionError};
use crate::found_events;
use crate::output;
use crate::settings::Settings;
use crate::steps::{self, Generated, Generator};
use crate::take::Take;

/// Seconds that are written at a time: what methods make of them is in memory.
const BLOCK_S: f64 = 64.0;

/// Everything that was made of a take.
#[derive(Clone, Copy, Debug)]
pub struct TakeContents<'a> {
    /// The take.
    pub take: &'a Take,
    /// Its motion.
    pub motion: &'a Motion,
    /// What methods generate for it.
    pub generated: Option<MotionSource<'a>>,
    /// Where each fingertip has been in training, drawn beside what is generated.
    pub hulls: Option<&'a PerFinger<Hull>>,
    /// The step that made it all.
    pub made: &'a Provenance,
    /// What was set: the shape of the object, and what counts as contact.
    pub settings: &'a Settings,
}

/// Source of the motion that methods generate.
#[derive(Clone, Copy, Debug)]
pub enum MotionSource<'a> {
    /// Generated before.
    Memory(GeneratedMotion<'a>),
    /// Generated while it is written, so that memory does not grow with the take.
    Generators(&'a TakeGenerators<'a>),
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
}

/// Methods that generate motion for one take.
#[derive(Debug)]
pub struct TakeGenerators<'a> {
    /// Test segments under each protocol.
    pub segments: PerProtocol<FoundSegments>,
    /// The methods.
    pub generators: PerProtocol<Vec<Generator<'a>>>,
}

/// Writes the file of a take: what was recorded, processed, generated and evaluated. Returns for each published method
/// how many segments are without a trajectory.
///
/// # Errors
///
/// [`SessionError`]; then no file appears.
pub fn write(
    path: &Path,
    contents: &TakeContents<'_>,
    views: Views,
) -> Result<Vec<usize>, SessionError> {
    let TakeContents { take, settings, .. } = *contents;
    take.roles()?;
    let source = contents.generated.as_ref();
    let annotations = found_events::with_found(&take.annotations, contents.motion, settings)?;
    let provenance = take.made_by(contents.made);
    let mut kinds = evaluated(contents, &(0..0))?;
    for samples in blocks(contents.motion) {
        let more = evaluated(contents, &samples)?;
        (kinds.iter_mut().zip(&more)).for_each(|(method, more)| method.add_kinds(more));
    }
    // Before the first sample only the names of methods are needed.
    MotionSource::block(source, &(0..0), |[generated, held_out], mut lost| {
        let file = TakeFile {
            motion: Some(contents.motion),
            generated,
            held_out,
            evaluated: &kinds,
            object_shape: settings.shape()?,
            hulls: contents.hulls,
            annotations: Some(&annotations),
            ..take.file(&provenance)
        };
        let outline = Outline::new(file.used()).with_findings(file.recording.findings.clone());
        output::write_atomic(path, |out| {
            let mut writer = TakeWriter::begin(out, &file, &outline, views).in_file(path)?;
            for samples in blocks(contents.motion) {
                let recording = take.recording.slice(samples.clone());
                let evaluated = evaluated(contents, &samples)?;
                MotionSource::block(source, &samples, |[generated, held_out], more| {
                    lost.iter_mut()
                        .zip(more)
                        .for_each(|(lost, more)| *lost += more);
                    let block = TakeFile {
                        generated,
                        held_out,
                        evaluated: &evaluated,
                        ..TakeFile::new(&recording)
                    };
                    writer.append(&block).in_file(path)
                })?;
            }
            writer.finish().in_file(path)
        })?;
        Ok(lost)
    })
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

/// The samples that are written at a time.
fn blocks(motion: &Motion) -> impl Iterator<Item = Range<usize>> {
    let (len, block) = (motion.len(), BLOCK_S * motion.clock.rate_hz());
    let block = (block.round() as usize).max(1);
    (0..len)
        .step_by(block)
        .map(move |start| start..len.min(start + block))
}

impl MotionSource<'_> {
    /// Calls `write` with what each method has of these samples under each protocol, and the number of segments that start
    /// there without a trajectory, of each published method.
    fn block<T>(
        source: Option<&Self>,
        samples: &Range<usize>,
        write: impl FnOnce([&[GeneratedMethod<'_>]; 2], Vec<usize>) -> Result<T, SessionError>,
    ) -> Result<T, SessionError> {
        let made;
        let motion: GeneratedMotion<'_> = match source {
            None => return write([&[], &[]], Vec::new()),
            Some(Self::Memory(motion)) => *motion,
            Some(Self::Generators(generators)) => {
                made = generators.block(samples)?;
                GeneratedMotion {
                    segments: made.as_ref().map(|(segments, _)| segments),
                    take: 0,
                    generated: made.as_ref().map(|(_, generated)| generated.as_slice()),
                    rows: &[],
                    written: None,
                }
            }
        };
        let segments = Protocol::ALL.map(|protocol| {
            let inside = motion.inside(protocol, samples);
            let methods = motion.methods(protocol);
            let made = methods.map(|g| (g, inside.generated(&g.trajectories, g.plans.as_deref())));
            made.collect::<Vec<_>>()
        });
        let methods = segments.each_ref().map(|methods| {
            let methods = methods.iter().map(|(generated, segments)| GeneratedMethod {
                name: generated.method.name(),
                plans: generated.plans.is_some(),
                segments,
            });
            methods.collect::<Vec<_>>()
        });
        let inside = motion.inside(Protocol::Published, samples);
        let lost = motion.methods(Protocol::Published);
        let lost = lost.map(|generated| inside.without_trajectory(&generated.trajectories));
        write(methods.each_ref().map(Vec::as_slice), lost.collect())
    }
}

impl TakeGenerators<'_> {
    /// What each method makes of the segments that have any of these samples.
    fn block(
        &self,
        samples: &Range<usize>,
    ) -> Result<PerProtocol<(Segments, Vec<Generated>)>, SessionError> {
        PerProtocol::try_from_fn(|protocol| {
            let found = &self.segments[protocol];
            let inside = TakeSegments {
                origins: found.origins(),
                length: found.layout().samples,
                take: 0,
                samples: samples.clone(),
            };
            let segments = found.segments(inside.places());
            let by_each = self.generators[protocol].iter();
            let generated = by_each.map(|generator| generator.generate(&segments));
            let generated = generated.collect::<Result<Vec<_>, SessionError>>()?;
            Ok((segments, generated))
        })
    }
}

impl<'a> GeneratedMotion<'a> {
    /// Segments of the take that have any of these samples.
    fn inside(&self, protocol: Protocol, samples: &Range<usize>) -> TakeSegments<'a> {
        let segments = self.segments[protocol];
        TakeSegments {
            origins: segments.origins(),
            length: segments.layout().samples,
            take: self.take,
            samples: samples.clone(),
        }
    }

    /// Methods that are written.
    fn methods(&self, protocol: Protocol) -> impl Iterator<Item = &'a Generated> {
        let (written, methods) = (self.written, self.generated[protocol].iter());
        methods.filter(move |g| written.is_none_or(|written| written.contains(g.method.name())))
    }
}

/// Errors and contacts of the recording and of each method at these samples.
fn evaluated(
    contents: &TakeContents<'_>,
    samples: &Range<usize>,
) -> Result<Vec<EvaluatedMethod>, SessionError> {
    let mut evaluated = vec![recorded_contacts(
        contents.motion,
        samples.clone(),
        contents.settings,
    )?];
    if let Some(MotionSource::Memory(motion)) = &contents.generated {
        let tau_m = contents.settings.evaluate.tau_mm / 1000.0;
        let inside = motion.inside(Protocol::Published, samples);
        let rows = motion.rows.iter();
        let written = rows.filter(|rows| motion.written.is_none_or(|w| w.contains(&*rows.name)));
        evaluated.extend(written.map(|rows| EvaluatedMethod {
            name: rows.name.clone(),
            samples: inside.evaluated(rows, tau_m),
        }));
    }
    Ok(evaluated)
}

/// Which recorded fingertips touch the object at these samples, where its shape and pose are known.
pub(crate) fn recorded_contacts(
    motion: &Motion,
    samples: Range<usize>,
    settings: &Settings,
) -> Result<EvaluatedMethod, SessionError> {
    let tau_m = settings.evaluate.tau_mm / 1e3;
    let contacts = steps::contacts(motion, samples.clone(), settings)?;
    let known = samples.zip(contacts).filter_map(|(sample, distance_m)| {
        Some(EvaluatedSample {
            sample,
            error_m: None,
            contact: Some(ContactSample::new(distance_m?, tau_m)),
        })
    });
    Ok(EvaluatedMethod {
        name: RECORDED.to_owned(),
        samples: known.collect(),
    })
}
