//! Log channel for viewers: changes made by cleaning, and plans without a solution.

use foxglove::messages::{Log, log};
use inhand_model::{Clock, PlanStatus};

use crate::error::ChannelError;
use crate::streams::Streams;
use crate::take::TakeFile;
use crate::topic;
use crate::wire::viewer_time;

/// Adds the log, if there are entries.
pub(crate) fn add(
    file: &TakeFile<'_>,
    measured: Clock,
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    let clock = file.recording.clock;
    let mut entries: Vec<(usize, log::Level, &str, String)> = Vec::new();
    if let Some(cleaned) = &file.cleaned {
        let last = cleaned.recording.len().saturating_sub(1);
        for change in cleaned.changes {
            // The first sample of the cleaned recording that it concerns.
            let sample = clock.nearest_sample(measured.time_s(change.samples.start));
            let message = change.to_string();
            entries.push((sample.min(last), log::Level::Info, "clean", message));
        }
    }
    for method in file.generated {
        for unsolved in method.unsolved {
            let how = match unsolved.plan.status {
                PlanStatus::Infeasible => "no motion keeps to all constraints",
                _ => "the solver found no motion",
            };
            let message = format!("no trajectory: {how}");
            let sample = unsolved.start_sample;
            entries.push((sample, log::Level::Warning, method.name, message));
        }
    }
    if entries.is_empty() {
        return Ok(());
    }
    // The order of those at one sample stays.
    entries.sort_by_key(|(sample, ..)| *sample);
    let messages: Vec<_> = (entries.into_iter())
        .map(|(sample, level, name, message)| {
            let unix_nanos = clock.unix_nanos(sample);
            let log = Log {
                timestamp: Some(viewer_time(unix_nanos)),
                level: level.into(),
                name: name.to_owned(),
                message,
                ..Log::default()
            };
            (sample, unix_nanos, log)
        })
        .collect();
    let channel = streams.output.channel::<Log>(topic::VIEW_LOG, None)?;
    streams.listed(channel, messages);
    Ok(())
}
