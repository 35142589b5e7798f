//! Checks that the parts of a take belong together.

use std::collections::BTreeSet;
use std::fmt::Display;

use crate::error::ChannelError;
use crate::take::{GeneratedSegment, TakeFile};
use crate::topic::MethodTopics;

pub(super) fn parts(file: &TakeFile, samples: usize) -> Result<(), ChannelError> {
    let recording = file.used();
    if let Some(motion) = file.motion {
        let lengths = [motion.hand.len()]
            .into_iter()
            .chain(motion.object.iter().map(inhand_model::Track::len))
            .chain(motion.fingertips.iter().map(|(_, track)| track.len()));
        for found in lengths {
            equal("samples of a track of the motion", samples, found)?;
        }
        if motion.clock != recording.clock {
            return Err(ChannelError::mismatch(
                "clock of the motion",
                format!("that of the recording, {:?}", recording.clock),
                format!("{:?}", motion.clock),
            ));
        }
    }
    let mut names = BTreeSet::new();
    for method in file.generated {
        MethodTopics::new(method.name)?;
        unique(&mut names, method.name)?;
        for segment in method.segments {
            segment_fits(segment, method.name, samples, recording.clock.rate_hz())?;
        }
        let starts = method.unsolved.iter().map(|unsolved| unsolved.start_sample);
        if let Some(start) = starts.max().filter(|start| *start >= samples) {
            return Err(ChannelError::mismatch(
                format!("start of an unsolved plan of {}", method.name),
                format!("below the {samples} samples of the take"),
                start,
            ));
        }
    }
    let mut names = BTreeSet::new();
    for method in file.evaluated {
        MethodTopics::new(&method.name)?;
        unique(&mut names, &method.name)?;
        if let Some(last) = method.samples.iter().map(|judged| judged.sample).max()
            && last >= samples
        {
            return Err(ChannelError::mismatch(
                format!("judged sample of method \"{}\"", method.name),
                format!("below {samples}, the samples of the take"),
                last,
            ));
        }
    }
    Ok(())
}

fn segment_fits(
    segment: &GeneratedSegment,
    method: &str,
    samples: usize,
    rate_hz: f64,
) -> Result<(), ChannelError> {
    let layout = segment.trajectory.layout();
    let end = segment.start_sample.saturating_add(layout.samples);
    if end > samples {
        return Err(ChannelError::mismatch(
            format!("end of a trajectory of method \"{method}\""),
            format!("at most {samples}, the samples of the take"),
            end,
        ));
    }
    equal(
        &format!("rate of a trajectory of method \"{method}\" in Hz"),
        rate_hz,
        layout.rate_hz,
    )
}

fn equal<T: PartialEq + Display>(what: &str, expected: T, found: T) -> Result<(), ChannelError> {
    if expected == found {
        Ok(())
    } else {
        Err(ChannelError::mismatch(what, expected, found))
    }
}

fn unique<'a>(names: &mut BTreeSet<&'a str>, name: &'a str) -> Result<(), ChannelError> {
    if names.insert(name) {
        Ok(())
    } else {
        Err(ChannelError::mismatch(
            "names of the methods",
            "each one once",
            format!("\"{name}\" twice"),
        ))
    }
}
